//! The command line as scripts see it: exit codes, results, one line about what is wrong.

use std::path::{Path, PathBuf};

use relievo_engine::raster::write::{Png, write_png};
use relievo_engine::raster::{Bands, Block, Cancel};
use serde_json::Value;

use crate::shared::{good, in_folder, refused, relievo, sample_file, text_file};

const NOISE: &str = r##"{"version": 1, "layers": [
    {"id": "hills", "name": "Hills", "kind": "noise", "amplitude_m": 900.0, "wavelength_m": 500000.0, "octaves": 6},
    {"id": "tint", "name": "Tint", "kind": "tint",
     "stops": [{"height_m": -500.0, "colour": "#102030"}, {"height_m": 500.0, "colour": "#f0e0d0"}]}]}"##;

#[test]
fn a_project_made_from_a_file_is_checked_sampled_edited_and_described() {
    let folder = tempfile::tempdir().unwrap();
    let project = in_folder(folder.path(), "new.relievo");
    good(&[
        "new",
        &project,
        "--source",
        &sample_file("data/wasatch-dem.tif"),
        &sample_file("data/provo-aerial.tif"),
    ]);
    assert_eq!(
        good(&["check", &project, "--json"]).json(),
        Value::Array(vec![])
    );
    let info = good(&["info", &project, "--json"]).json();
    assert_eq!(info["layers"][0]["kind"], "height");
    assert_eq!(info["layers"][1]["kind"], "imagery");
    let camera_lon = info["camera"]["lon_deg"].as_f64().unwrap();
    assert!(
        (-113.0..-110.0).contains(&camera_lon),
        "the camera looks at the data: {camera_lon}"
    );

    let lines = good(&[
        "sample",
        &project,
        "--at",
        "-111.65,40.25",
        "--at",
        "-111.6,40.3",
    ])
    .out;
    let places: Vec<Value> = lines
        .lines()
        .map(|l| serde_json::from_str(l).unwrap())
        .collect();
    assert_eq!(places.len(), 2);
    assert!(
        (1200.0..3500.0).contains(&places[0]["height_m"].as_f64().unwrap()),
        "{}",
        places[0]
    );

    let edits = text_file(
        folder.path(),
        "edits.json",
        r#"[{"edit": "set_exaggeration", "vertical_exaggeration": 2.5}]"#,
    );
    let edited = in_folder(folder.path(), "edited.relievo");
    good(&["apply", &project, &edits, "-o", &edited]);
    assert_eq!(
        good(&["info", &edited, "--json"]).json()["planet"]["vertical_exaggeration"],
        2.5
    );
    let moved = good(&["sample", &edited, "--at", "-111.65,40.25"]).json();
    assert_eq!(
        moved["height_m"], places[0]["height_m"],
        "measurements are not exaggerated"
    );
}

#[test]
fn a_small_new_project_in_the_mountains_is_seen_from_above_the_ground() {
    let folder = tempfile::tempdir().unwrap();
    let header = "ncols 4\nnrows 4\nxllcorner 10\nyllcorner 45\ncellsize 0.001\n";
    let rows = "3000 3000 3000 3000\n".repeat(4);
    let heights = text_file(folder.path(), "alp.asc", &format!("{header}{rows}"));
    let project = in_folder(folder.path(), "alp.relievo");
    good(&["new", &project, "--source", &heights]);
    let info = good(&["info", &project, "--json"]).json();
    let altitude_m = info["camera"]["altitude_m"].as_f64().unwrap();
    // 0.004 degrees of latitude fill a picture of 60 degrees from 385 m, and there is room around.
    assert!((3385.0..3600.0).contains(&altitude_m), "{altitude_m}");
}

#[test]
fn a_new_project_replaces_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let project = text_file(folder.path(), "mine.relievo", NOISE);
    let line = refused(&[
        "new",
        &project,
        "--source",
        &sample_file("data/wasatch-dem.tif"),
    ]);
    assert!(
        line.contains("exists") && line.contains("mine.relievo"),
        "{line}"
    );
    assert_eq!(std::fs::read_to_string(project).unwrap(), NOISE);
}

#[test]
fn edits_take_effect_all_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let project = text_file(folder.path(), "p.relievo", NOISE);
    let edits = text_file(
        folder.path(),
        "edits.json",
        r#"[{"edit": "set_visible", "id": "hills", "visible": false}, {"edit": "remove_layer", "id": "nobody"}]"#,
    );
    let output = in_folder(folder.path(), "out.relievo");
    let line = refused(&["apply", &project, &edits, "-o", &output]);
    assert!(
        line.contains("edit 1") && line.contains("nobody") && line.contains("edits.json"),
        "{line}"
    );
    assert!(!Path::new(&output).exists());
}

#[test]
fn the_schema_is_json_and_describes_edits() {
    let schema = good(&["schema"]).json();
    assert!(schema["$defs"]["edits"].is_object());
}

#[test]
fn a_baked_region_has_the_samples_that_sample_gives() {
    let folder = tempfile::tempdir().unwrap();
    let project = text_file(folder.path(), "p.relievo", NOISE);
    let out = in_folder(folder.path(), "heights.tif");
    let arguments = [
        "bake",
        &project,
        "-o",
        &out,
        "--output",
        "height",
        "--bounds",
        "-10,40,-9,41",
        "--resolution",
        "0.05",
    ];
    good(&arguments);
    let info = good(&["info", &out, "--json"]).json();
    assert_eq!(
        (&info["width"], &info["height"]),
        (&Value::from(20), &Value::from(20))
    );
    assert_eq!(info["read_as"], "heights");
    assert!((info["extent"]["west"].as_f64().unwrap() + 10.0).abs() < 1e-9);
    let first = std::fs::read(&out).unwrap();
    good(&[&arguments[..], &["--threads", "3"]].concat());
    assert_eq!(
        std::fs::read(&out).unwrap(),
        first,
        "the same bytes for any number of threads"
    );
}

#[test]
fn a_baked_openexr_file_is_a_source_again() {
    let folder = tempfile::tempdir().unwrap();
    let project = text_file(folder.path(), "p.relievo", NOISE);
    let region = ["--bounds", "-10,40,-9,41", "--resolution", "0.05"];
    let bake = |name: &str, output: &str| {
        let out = in_folder(folder.path(), name);
        let arguments = ["bake", &project, "-o", &out, "--output", output];
        good(&[&arguments[..], &region].concat());
        let first = std::fs::read(&out).unwrap();
        good(&[&arguments[..], &region, &["--threads", "3"]].concat());
        assert_eq!(std::fs::read(&out).unwrap(), first, "{name}");
        out
    };
    let (heights, colours) = (bake("h.exr", "height"), bake("c.exr", "colour"));
    let info = good(&["info", &colours, "--json"]).json();
    assert_eq!(
        (&info["format"], &info["read_as"]),
        (&"OpenEXR".into(), &"colours".into())
    );
    let info = good(&["info", &heights, "--json"]).json();
    assert_eq!(info["crs"], "EPSG:4326");
    assert!((info["extent"]["north"].as_f64().unwrap() - 41.0).abs() < 1e-9);
    // The same samples as a GeoTIFF has.
    let height_m = |source: &str| {
        let project = format!("{source}.relievo");
        good(&["new", &project, "--source", source]);
        let line = good(&["sample", &project, "--at", "-9.525,40.475"]).json();
        line["height_m"].as_f64().unwrap()
    };
    let (exr, tif) = (height_m(&heights), height_m(&bake("h.tif", "height")));
    assert!((exr - tif).abs() < 1e-6 && exr != 0.0, "{exr} {tif}");
}

#[test]
fn a_folder_of_tiles_is_heights_with_an_encoding_and_imagery_without() {
    let folder = tempfile::tempdir().unwrap();
    let tiles = folder.path().join("tiles");
    let tile = tiles.join("0/0");
    std::fs::create_dir_all(&tile).unwrap();
    // 256 · 128 + 7 + 128 / 256 − 32 768 = 7.5.
    let colour = [128.0, 7.0, 128.0, 255.0].map(|v| v / 255.0);
    let block = Block::filled(Bands::Colour, 64, 64, &colour);
    write_png(&tile.join("0.png"), &block, Png::Rgb8).unwrap();
    let tiles = tiles.to_str().unwrap();
    let heights = in_folder(folder.path(), "heights.relievo");
    let encoding = ["--encoding", "terrarium"];
    good(&[&["new", &heights, "--source", tiles][..], &encoding].concat());
    assert_eq!(
        good(&["check", &heights, "--json"]).json(),
        Value::Array(vec![])
    );
    let line = good(&["sample", &heights, "--at", "10,20"]).json();
    assert_eq!(line["height_m"], 7.5);
    let imagery = in_folder(folder.path(), "imagery.relievo");
    good(&["new", &imagery, "--source", tiles]);
    let info = good(&["info", &imagery, "--json"]).json();
    assert_eq!(info["layers"][0]["kind"], "imagery");
    let other = in_folder(folder.path(), "other.relievo");
    let file = sample_file("data/wasatch-dem.tif");
    let line = refused(&[&["new", &other, "--source", &file][..], &encoding].concat());
    assert!(line.contains("set of tiles"), "{line}");
}

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
fn help_tells_every_option_with_its_unit_and_default() {
    let help = good(&["help", "render"]).out;
    for part in [
        "--size <WxH>",
        "pixels",
        "[default: 1280x960]",
        "degrees",
        "metres",
        "milliseconds",
        "--threads",
    ] {
        assert!(help.contains(part), "{part} in {help}");
    }
    let all = good(&["--help"]).out;
    for command in [
        "render", "bake", "sample", "info", "check", "new", "apply", "schema",
    ] {
        assert!(all.contains(command), "{command} in {all}");
        assert!(!good(&["help", command]).out.is_empty());
    }
    assert!(good(&["--version"]).out.starts_with("relievo "));
}

#[test]
fn an_asked_for_end_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let project = text_file(folder.path(), "p.relievo", NOISE);
    let out = in_folder(folder.path(), "heights.tif");
    let cancel = Cancel::default();
    cancel.cancel();
    let (mut output, mut err) = (Vec::new(), Vec::new());
    let arguments = [
        "relievo",
        "bake",
        &project,
        "-o",
        &out,
        "--output",
        "height",
        "--bounds",
        "0,0,9,9",
        "--resolution",
        "0.01",
    ];
    assert_eq!(
        relievo::cli::run(arguments, &mut output, &mut err, &cancel),
        130
    );
    let left: Vec<_> = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|e| e.unwrap().file_name())
        .collect();
    assert_eq!(left, ["p.relievo"]);
}

/// A reader that went away.
struct Gone;

impl std::io::Write for Gone {
    fn write(&mut self, _: &[u8]) -> std::io::Result<usize> {
        Err(std::io::ErrorKind::BrokenPipe.into())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let mut err = Vec::new();
    let code = relievo::cli::run(
        ["relievo", "schema"],
        &mut Gone,
        &mut err,
        &Cancel::default(),
    );
    assert_eq!((code, err.len()), (0, 0));
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

#[test]
fn a_layer_matched_to_another_looks_like_it_and_stays_editable() {
    let folder = tempfile::tempdir().unwrap();
    let aerial = sample_file("data/provo-aerial.tif");
    let layer = |id: &str, adjust: &str| {
        format!(
            r#"{{"id": "{id}", "name": "{id}", "kind": "imagery", "path": "{aerial}", "adjust": {adjust}}}"#
        )
    };
    let hazy = r#"{"gain": [0.7, 0.8, 0.6], "offset": [0.1, 0.12, 0.2]}"#;
    let text = format!(
        r#"{{"version": 1, "layers": [{}, {}]}}"#,
        layer("below", hazy),
        layer("above", "{}")
    );
    let project = text_file(folder.path(), "two.relievo", &text);
    let before = good(&["compare", &project, "--layers", "above,below"]).json();
    assert!(
        before["ciede2000"]["mean"].as_f64().unwrap() > 5.0,
        "{before}"
    );
    for (method, most) in [("mean", 0.1), ("histogram", 1.0), ("regression", 0.1)] {
        let edits = in_folder(folder.path(), "edits.json");
        let told = good(&[
            "match", &project, "--layer", "above", "--method", method, "-o", &edits,
        ])
        .json();
        assert_eq!(
            told["ciede2000_before"]["mean"],
            before["ciede2000"]["mean"]
        );
        let matched = in_folder(folder.path(), "matched.relievo");
        good(&["apply", &project, &edits, "-o", &matched]);
        let after = good(&["compare", &matched, "--layers", "above,below"]).json();
        let mean = after["ciede2000"]["mean"].as_f64().unwrap();
        assert!(mean < most, "{method}: {mean}");
        for figure in ["mean", "p95"] {
            assert_eq!(
                told["ciede2000_after"][figure], after["ciede2000"][figure],
                "{method}: what was foretold is what is shown"
            );
        }
    }
    let unknown = refused(&["match", &project, "--layer", "nothing"]);
    assert!(
        unknown.contains("nothing") && unknown.contains("below, above"),
        "{unknown}"
    );
    let lowest = refused(&["match", &project, "--layer", "below"]);
    assert!(lowest.contains("nothing below"), "{lowest}");
    let elsewhere = refused(&["match", &project, "--layer", "above", "--region", "0,0,1,1"]);
    assert!(
        elsewhere.contains("at least 50 places") && elsewhere.contains("found 0"),
        "{elsewhere}"
    );
}

#[test]
fn several_layers_balanced_at_once_look_like_the_one_that_is_held() {
    let folder = tempfile::tempdir().unwrap();
    let aerial = sample_file("data/provo-aerial.tif");
    // Three copies of one picture, told apart by what is added to them: what a balance of own colours has
    // nothing to do for, and of a held layer as it is shown all the more.
    let layer = |id: &str, adjust: &str| {
        format!(
            r#"{{"id": "{id}", "name": "{id}", "kind": "imagery", "path": "{aerial}", "adjust": {adjust}}}"#
        )
    };
    let hazy = r#"{"gain": [0.7, 0.8, 0.6], "offset": [0.1, 0.12, 0.2]}"#;
    let layers = [layer("held", hazy), layer("a", "{}"), layer("b", "{}")];
    let text = format!(r#"{{"version": 1, "layers": [{}]}}"#, layers.join(", "));
    let project = text_file(folder.path(), "three.relievo", &text);
    let edits = in_folder(folder.path(), "edits.json");
    let told = good(&[
        "balance", &project, "--layers", "held,a,b", "--hold", "held", "-o", &edits,
    ])
    .json();
    let overlaps = told["overlaps"].as_array().unwrap();
    assert_eq!(overlaps.len(), 3, "{told}");
    let mean = |overlap: &Value, when: &str| overlap[when]["mean"].as_f64().unwrap();
    assert!(mean(&overlaps[0], "ciede2000_before") > 5.0, "{told}");
    let balanced = in_folder(folder.path(), "balanced.relievo");
    good(&["apply", &project, &edits, "-o", &balanced]);
    for (overlap, id) in overlaps.iter().zip(["a", "b"]) {
        let shown = good(&["compare", &balanced, "--layers", &format!("{id},held")]).json();
        let shown = shown["ciede2000"]["mean"].as_f64().unwrap();
        assert!(shown < 0.2, "{id}: {shown}");
        // The same colours in the other order.
        let foretold = mean(overlap, "ciede2000_after");
        assert!((shown - foretold).abs() < 1e-6, "{id}: {shown} {foretold}");
    }
    let held = std::fs::read_to_string(&edits).unwrap();
    assert!(!held.contains("held"), "{held}");
    let one = refused(&["balance", &project, "--layers", "a"]);
    assert!(one.contains("at least two layers"), "{one}");
    let twice = refused(&["balance", &project, "--layers", "a,a"]);
    assert!(twice.contains("each layer once"), "{twice}");
    let other = refused(&["balance", &project, "--layers", "a,b", "--hold", "held"]);
    assert!(other.contains("one of the layers"), "{other}");
}
