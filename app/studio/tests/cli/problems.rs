//! What is wrong with a project or an argument: exit codes, one line that names it, and how to mend it.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::shared::{NOISE, good, in_folder, refused, relievo, sample_file, text_file};

#[test]
fn check_tells_every_problem_with_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let project = text_file(
        folder.path(),
        "p.relievo",
        r##"{"version": 1, "colour": "blue", "layers": [
            {"id": "a", "name": "A", "kind": "imagery", "path": "missing.tif", "mask": {"vector": "b"},
             "detail": [{"by": "noise", "areas": "zones"}, {"by": "examples", "layers": ["d", "a", "gone"], "sise": 3}]},
            {"id": "b", "name": "B", "kind": "hologram"},
            {"id": "c", "name": "C", "kind": "tint", "opacty": 0.5, "stops": [{"height_m": 0.0, "colour": "#112233"}]},
            {"id": "d", "name": "D", "kind": "imagery", "path": "missing.tif"}
        ]}"##,
    );
    let run = relievo(&["check", &project, "--json"]);
    assert_eq!(run.code, 2);
    // Two files, one mask, one kind of areas, two examples.
    assert!(run.err.contains("found 6"), "{}", run.err);
    let problems = run.json();
    let places: Vec<&str> = problems
        .as_array()
        .unwrap()
        .iter()
        .map(|p| p["place"].as_str().unwrap())
        .collect();
    for place in [
        "/colour",
        "/layers/0/path",
        "/layers/1/kind",
        "/layers/2/opacty",
        "/layers/2",
        "/layers/0/mask/vector",
        "/layers/0/detail/0/areas",
        "/layers/0/detail/1/layers/1",
        "/layers/0/detail/1/layers/2",
        "/layers/0/detail/1/sise",
    ] {
        assert!(places.contains(&place), "{place} in {places:?}");
    }
    assert!(
        problems
            .as_array()
            .unwrap()
            .iter()
            .all(|p| !p["mend"].as_str().unwrap().is_empty())
    );
    assert!(relievo(&["check", &project]).out.contains("to mend it"));
}

#[test]
#[expect(clippy::too_many_lines, reason = "a table of what can be wrong")]
fn bad_input_is_refused_in_one_line_that_names_it() {
    let folder = tempfile::tempdir().unwrap();
    let text = text_file(folder.path(), "text.tif", "this is no raster");
    let damaged = text_file(
        folder.path(),
        "damaged.relievo",
        "{\"version\": 1,\n \"layers\": [}",
    );
    let project = text_file(folder.path(), "p.relievo", NOISE);
    let picture = in_folder(folder.path(), "p.png");
    let raster = in_folder(folder.path(), "p.tif");
    let cases: &[(&[&str], &str)] = &[
        (&["info", "nowhere.tif"], "nowhere.tif"),
        (&["info", &text], "text.tif"),
        (&["info", &damaged], "line 2"),
        (&["check", "nowhere.relievo"], "nowhere.relievo"),
        (&["sample", &project, "--at", "200"], "LON,LAT"),
        (&["sample", &project, "--at", "0,95"], "latitude"),
        (&["sample", &project], "--at"),
        (&["render", &project, "-o", "picture.bmp"], ".png"),
        (
            &["render", &project, "-o", &picture, "--size", "0x5"],
            "WxH",
        ),
        (
            &["render", &project, "-o", &picture, "--camera", "1,2"],
            "fields",
        ),
        (&["render", &project, "-o", &picture, "--fov", "200"], "170"),
        (
            &["render", &project, "-o", &picture, "--front-end", "crystal"],
            "clipmap",
        ),
        (
            &[
                "bake",
                &project,
                "-o",
                &raster,
                "--output",
                "height",
                "--bounds",
                "1,2,3",
                "--resolution",
                "1",
            ],
            "W,S,E,N",
        ),
        (
            &[
                "bake",
                &project,
                "-o",
                &raster,
                "--output",
                "height",
                "--bounds",
                "0,5,1,4",
                "--resolution",
                "1",
            ],
            "N beyond S",
        ),
        (
            &[
                "bake",
                &project,
                "-o",
                &raster,
                "--output",
                "height",
                "--bounds",
                "0,4,1,5",
                "--resolution",
                "-1",
            ],
            "positive",
        ),
        (
            &[
                "bake",
                &project,
                "-o",
                &raster,
                "--output",
                "height",
                "--bounds",
                "0,4,1,5",
                "--resolution",
                "1",
                "--crs",
                "EPSG:1",
            ],
            "EPSG:1",
        ),
        (
            &["apply", &project, &damaged, "-o", &picture],
            "damaged.relievo",
        ),
        (&["new", &picture, "--source", &text], "text.tif"),
        (&["--threads", "0", "schema"], "threads"),
        (&["schema", "--nonsense"], "--nonsense"),
        (&["p.relievo", "schema"], "found both"),
        (&["nowhere.relievo"], "nowhere.relievo"),
    ];
    for (arguments, part) in cases {
        let line = refused(arguments);
        assert!(
            line.contains(part),
            "{arguments:?}: expected {part:?} in {line}"
        );
    }
    assert!(!PathBuf::from(&raster).exists() && !PathBuf::from(&picture).exists());
}

#[test]
fn a_missing_file_of_a_visible_layer_is_bad_input_and_of_a_hidden_one_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let with = |visible: bool| {
        format!(
            r#"{{"version": 1, "layers": [{{"id": "gone", "name": "Gone", "kind": "imagery", "visible": {visible},
                "path": "gone.tif"}}]}}"#
        )
    };
    let shown = text_file(folder.path(), "shown.relievo", &with(true));
    let line = refused(&["sample", &shown, "--at", "1,2"]);
    assert!(line.contains("gone.tif"), "{line}");
    let hidden = text_file(folder.path(), "hidden.relievo", &with(false));
    assert_eq!(
        good(&["sample", &hidden, "--at", "1,2"]).json()["height_m"],
        0.0
    );
}

#[test]
fn a_missing_file_is_found_by_its_name_and_linked_by_the_edit_that_check_gives() {
    let folder = tempfile::tempdir().unwrap();
    let project = text_file(
        folder.path(),
        "moved.relievo",
        r#"{"version": 1, "layers": [{"id": "dem", "kind": "height", "path": "gone/wasatch-dem.tif"}]}"#,
    );
    let run = relievo(&["check", &project, "--json"]);
    assert_eq!(run.code, 2);
    let problem = &run.json()[0];
    let what = problem["what"].as_str().unwrap();
    assert!(what.contains("not even its folder"), "{what}");
    let mend = problem["mend"].as_str().unwrap();
    assert!(mend.contains("--search"), "{mend}");
    assert_eq!(problem["edits"], Value::Null);
    // One of that name that will not do comes first.
    std::fs::create_dir_all(folder.path().join("a/b")).unwrap();
    text_file(folder.path(), "a/wasatch-dem.tif", "no picture");
    let dem = sample_file("data/wasatch-dem.tif");
    std::fs::copy(&dem, folder.path().join("a/b/wasatch-dem.tif")).unwrap();
    let problem = &relievo(&["check", &project, "--json"]).json()[0];
    let edits = &problem["edits"];
    assert_eq!(
        *edits,
        serde_json::json!([{"edit": "set_path", "id": "dem", "path": "a/b/wasatch-dem.tif"}])
    );
    let edits = text_file(folder.path(), "edits.json", &edits.to_string());
    let mended = in_folder(folder.path(), "mended.relievo");
    good(&["apply", &project, &edits, "-o", &mended]);
    good(&["check", &mended]);
    // In a folder that is given, too; one that is none is refused.
    std::fs::remove_dir_all(folder.path().join("a")).unwrap();
    let data = Path::new(&dem).parent().unwrap().to_str().unwrap();
    let problem = &relievo(&["check", &project, "--json", "--search", data]).json()[0];
    let path = problem["edits"][0]["path"].as_str().unwrap();
    assert!(path.ends_with("wasatch-dem.tif"), "{path}");
    let line = refused(&["check", &project, "--search", &dem]);
    assert!(line.contains("expected a folder"), "{line}");
}
