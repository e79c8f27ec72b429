//! Measuring commands as scripts see them.

use std::path::Path;

use serde_json::Value;

use crate::shared::{good, refused, relievo};

fn parsed(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// Rolling hills, and a scenario in which they are twice as high.
fn hills(folder: &Path) -> String {
    let path = folder.join("hills.relievo");
    let project = r#"{"version": 1, "layers": [
        {"id": "hills", "name": "Hills", "kind": "noise", "mode": "replace", "amplitude_m": 100.0,
         "wavelength_m": 20000.0, "octaves": 6, "offset_m": 500.0},
        {"id": "higher", "name": "Higher", "kind": "noise", "mode": "replace", "amplitude_m": 200.0,
         "wavelength_m": 20000.0, "octaves": 6, "offset_m": 500.0, "visible": false}],
      "scenarios": [{"id": "s1", "name": "Higher hills", "layers": [{"id": "higher", "visible": true}]}]}"#;
    std::fs::write(&path, project).unwrap();
    path.to_str().unwrap().to_owned()
}

/// A basin of 20 m with upright walls in level ground.
fn basin(folder: &Path) -> String {
    let path = folder.join("basin.relievo");
    let project = r#"{"version": 1, "elements": [{"id": "basin", "kind": "polygon",
        "outline": [[10, 5], [10.01, 5], [10.01, 5.01], [10, 5.01]],
        "surface": {"type": "platform", "height_m": -20}, "side": {"wall": true}}]}"#;
    std::fs::write(&path, project).unwrap();
    path.to_str().unwrap().to_owned()
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("expected a number, found {value}"))
}

#[test]
fn a_profile_is_a_table_and_a_summary() {
    let folder = tempfile::tempdir().unwrap();
    let project = hills(folder.path());
    let table = folder.path().join("line.csv");
    let line = [
        "profile",
        &project,
        "--line",
        "10,5;10.2,5;10.2,5.1",
        "--spacing",
        "500",
    ];
    let written = [&line[..], &["-o", table.to_str().unwrap()]].concat();
    let summary = good(&written).json();
    let text = std::fs::read_to_string(&table).unwrap();
    let mut lines = text.lines();
    assert_eq!(
        lines.next(),
        Some("distance_m,lon_deg,lat_deg,height_m,slope_percent")
    );
    let rows: Vec<Vec<f64>> = lines
        .map(|l| l.split(',').map(|v| v.parse().unwrap()).collect())
        .collect();
    assert_eq!(number(&summary["points"]) as usize, rows.len());
    let last = rows.last().unwrap();
    assert!((last[0] - number(&summary["length_m"])).abs() < 0.01);
    assert!((last[1] - 10.2).abs() < 1e-6 && (last[2] - 5.1).abs() < 1e-6);
    // 0.2° along a circle of latitude and 0.1° along a meridian.
    assert!(
        (last[0] - (22_178.0 + 11_057.0)).abs() < 50.0,
        "{}",
        last[0]
    );
    assert!(
        number(&summary["climb_m"]) > 1.0 && rows.iter().all(|r| (200.0..800.0).contains(&r[3]))
    );
    assert_eq!(good(&line).out, text, "without -o the table is printed");
}

#[test]
fn contours_are_geojson_at_whole_intervals() {
    let folder = tempfile::tempdir().unwrap();
    let project = hills(folder.path());
    let found = good(&[
        "contours",
        &project,
        "--bounds",
        "10,5,10.3,5.3",
        "--interval",
        "20",
    ]);
    let found = found.json();
    let features = found["features"].as_array().unwrap();
    assert!(features.len() > 2);
    for feature in features {
        let height_m = number(&feature["properties"]["height_m"]);
        assert_eq!(height_m % 20.0, 0.0);
        assert_eq!(feature["geometry"]["type"], "LineString");
        let first = &feature["geometry"]["coordinates"][0];
        let at = format!("{},{}", first[0], first[1]);
        let there = good(&["sample", &project, "--at", &at]).json();
        assert!((number(&there["height_m"]) - height_m).abs() < 15.0);
    }
}

#[test]
fn sight_is_summed_up_and_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let project = hills(folder.path());
    let picture = folder.path().join("seen.png");
    let name = picture.to_str().unwrap();
    let seen = good(&[
        "viewshed",
        &project,
        "--at",
        "10,5",
        "--radius",
        "2000",
        "--spacing",
        "100",
        "-o",
        name,
    ])
    .json();
    let (visible, area) = (number(&seen["visible_m2"]), number(&seen["area_m2"]));
    assert!(visible > 0.0 && visible <= area);
    assert!((area / (core::f64::consts::PI * 4e6) - 1.0).abs() < 0.05);
    assert!(std::fs::read(&picture).unwrap().starts_with(b"\x89PNG"));
    let world = std::fs::read_to_string(picture.with_extension("pgw")).unwrap();
    let world: Vec<f64> = world.lines().map(|l| l.parse().unwrap()).collect();
    // 20 samples of 100 m to each side of the observer's.
    assert_eq!(world, [100.0, 0.0, 0.0, -100.0, -2000.0, 2000.0]);
    let system = std::fs::read_to_string(picture.with_extension("prj")).unwrap();
    assert!(
        system.contains("Azimuthal_Equidistant") && system.contains("\"Central_Meridian\",10"),
        "{system}"
    );

    let raster = folder.path().join("seen.tif");
    let name = raster.to_str().unwrap();
    let asked = [
        "viewshed",
        &project,
        "--at",
        "10,5",
        "--radius",
        "2000",
        "--spacing",
        "100",
        "-o",
        name,
    ];
    assert_eq!(good(&asked).json(), seen);
    let file = good(&["info", name, "--json"]).json();
    assert!(
        file["crs"].as_str().unwrap().contains("+proj=aeqd"),
        "{file}"
    );
    assert_eq!(
        (&file["width"], &file["extent"]["west"]),
        (&Value::from(41), &Value::from(-2050.0))
    );
}

#[test]
fn water_is_summed_up_and_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let project = hills(folder.path());
    let basin = basin(folder.path());
    let shore = folder.path().join("shore.geojson");
    let wet = good(&[
        "flood",
        &basin,
        "--at",
        "10.005,5.005",
        "--level=-15",
        "-o",
        shore.to_str().unwrap(),
    ])
    .json();
    // Walls around 0.01 by 0.01 degrees, five metres of water: a degree of latitude is 110 579 m here,
    // one of longitude 110 897 m (WGS 84).
    let area_m2 = 1105.79 * 1108.97;
    assert!(
        (number(&wet["area_m2"]) / area_m2 - 1.0).abs() < 0.01,
        "{wet}"
    );
    assert!(
        (number(&wet["volume_m3"]) / (5.0 * area_m2) - 1.0).abs() < 0.01,
        "{wet}"
    );
    assert!((number(&wet["deepest_m"]) - 5.0).abs() < 1e-3, "{wet}");
    let drawn: Value = serde_json::from_str(&std::fs::read_to_string(&shore).unwrap()).unwrap();
    assert_eq!(
        drawn["features"].as_array().map(Vec::len),
        Some(1),
        "{drawn}"
    );
    assert_eq!(drawn["features"][0]["geometry"]["type"], "Polygon");

    let depths = folder.path().join("depth.tif");
    let name = depths.to_str().unwrap();
    let asked = [
        "flood",
        &basin,
        "--at",
        "10.005,5.005",
        "--level=-15",
        "-o",
        name,
    ];
    good(&asked);
    let file = good(&["info", name, "--json"]).json();
    // What is wet: 5 m deep on 0.01 by 0.01 degrees, to a sample.
    for (edge, exact) in [
        ("west", 10.0),
        ("south", 5.0),
        ("east", 10.01),
        ("north", 5.01),
    ] {
        assert!(
            (number(&file["extent"][edge]) - exact).abs() < 5e-4,
            "{file}"
        );
    }

    let ground = number(&good(&["sample", &project, "--at", "10,5"]).json()["height_m"]);
    let dry = format!("{}", ground - 100.0);
    let told = refused(&["flood", &project, "--at", "10,5", "--level", &dry]);
    assert!(told.contains("below the water level"), "{told}");
}

/// A platform in a scenario, a road and strokes, on level ground.
fn works(folder: &Path) -> String {
    let path = folder.join("works.relievo");
    let project = r#"{"version": 1, "elements": [
        {"id": "road", "name": "Road", "kind": "corridor", "line": [[10, 5, 3], [10.01, 5, 3]],
         "profile": {"type": "heights"}, "section": {"type": "road", "width_m": 8}},
        {"id": "away", "name": "Away", "kind": "polygon", "visible": false,
         "outline": [[11, 5], [11.01, 5], [11.01, 5.01]], "surface": {"type": "tin"}},
        {"id": "hill", "name": "Hill", "kind": "brush", "strokes": [
          {"tool": "raise", "strength_m": 2, "radius_m": 50, "points": [[10.02, 5], [10.03, 5]]}]}],
      "scenarios": [{"id": "s1", "name": "Pad", "changes": [{"change": "add", "element":
        {"id": "pad", "name": "Pad", "kind": "polygon", "outline": [[179.999, 5.1], [180.001, 5.1],
         [180.001, 5.101], [179.999, 5.101]], "surface": {"type": "platform", "height_m": 2},
         "side": {"fill_slope": 0.5}}}]}]}"#;
    std::fs::write(&path, project).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn elements_and_their_daylight_lines_are_exported_with_names_and_heights() {
    let folder = tempfile::tempdir().unwrap();
    let project = works(folder.path());
    let export = |what: &str, file: &str, scenario: &str| {
        let path = folder.path().join(file);
        let name = path.to_str().unwrap();
        let asked = [
            "export",
            &project,
            "-o",
            name,
            "--what",
            what,
            "--scenario",
            scenario,
        ];
        good(&asked);
        path
    };
    let read = |path: &Path| parsed(&std::fs::read_to_string(path).unwrap());
    let found = read(&export("elements", "base.geojson", "base"));
    let features = found["features"].as_array().unwrap();
    let names: Vec<&Value> = features.iter().map(|f| &f["properties"]["name"]).collect();
    assert_eq!(names, ["Road", "Hill"], "what is hidden takes no part");
    assert_eq!(features[0]["properties"]["width_m"], 8.0);
    assert_eq!(
        features[0]["geometry"]["coordinates"],
        serde_json::json!([[10.0, 5.0, 3.0], [10.01, 5.0, 3.0]])
    );
    assert_eq!(features[1]["properties"]["tool"], "raise");
    let raised = number(&features[1]["geometry"]["coordinates"][0][2]);
    assert!((raised - 2.0).abs() < 0.01, "{raised}");

    let found = read(&export("elements", "pad.geojson", "Pad"));
    let pad = &found["features"][2];
    assert_eq!(pad["properties"]["surface"], "platform");
    assert_eq!(
        pad["geometry"]["type"], "MultiPolygon",
        "cut at the antimeridian"
    );
    assert_eq!(pad["geometry"]["coordinates"][0][0][0][2], 2.0);

    let found = read(&export("daylight", "daylight.geojson", "Pad"));
    let lines = found["features"].as_array().unwrap();
    let of_pad = lines
        .iter()
        .find(|f| f["properties"]["id"] == "pad")
        .unwrap();
    assert_eq!(of_pad["properties"]["ending"], "meets the ground");
    // 2 m of fill at 1 in 2 meet level ground 4 m beside: 0.0000362° of latitude.
    let coordinates = of_pad["geometry"]["coordinates"].to_string();
    assert!(
        coordinates.contains("5.0999638") || coordinates.contains("5.099963"),
        "{coordinates}"
    );

    let package = export("elements", "pad.gpkg", "Pad");
    let file = good(&["info", package.to_str().unwrap(), "--json"]).json();
    assert_eq!(file["features"], 3, "{file}");

    let run = relievo(&["export", &project, "-o", "x.geojson", "--what", "contours"]);
    let (code, line) = (run.code, run.err);
    assert!(
        code == 2 && line.contains("--bounds and --interval"),
        "{line}"
    );
}

#[test]
fn a_profile_is_a_line_with_heights_too() {
    let folder = tempfile::tempdir().unwrap();
    let project = hills(folder.path());
    let path = folder.path().join("line.geojson");
    let name = path.to_str().unwrap();
    let line = [
        "profile",
        &project,
        "--line",
        "179.9,5;-179.9,5",
        "--spacing",
        "500",
    ];
    let sums = good(&[&line[..], &["-o", name]].concat()).json();
    let found = parsed(&std::fs::read_to_string(&path).unwrap());
    let parts = found["features"][0]["geometry"]["coordinates"]
        .as_array()
        .unwrap();
    assert_eq!(parts.len(), 2, "cut at the antimeridian");
    let points: usize = parts.iter().map(|p| p.as_array().unwrap().len()).sum();
    // The cut adds an end to each part.
    assert_eq!(points, number(&sums["points"]) as usize + 2);
    let heights = parts.iter().flat_map(|p| p.as_array().unwrap());
    let highest = heights
        .map(|p| number(&p[2]))
        .fold(f64::NEG_INFINITY, f64::max);
    assert!((highest - number(&sums["highest_m"])).abs() < 1e-3);
}

#[test]
fn scenarios_are_compared_as_json_table_and_page() {
    let folder = tempfile::tempdir().unwrap();
    let project = hills(folder.path());
    let compare = |file: &str| {
        let path = folder.path().join(file);
        let bounds = "10,5,10.02,5.02";
        good(&[
            "compare",
            &project,
            "--b",
            "Higher hills",
            "--bounds",
            bounds,
            "--samples",
            "65536",
            "-o",
            path.to_str().unwrap(),
        ]);
        std::fs::read_to_string(path).unwrap()
    };
    let report: Value = serde_json::from_str(&compare("report.json")).unwrap();
    assert_eq!(
        (&report["a"], &report["b"]),
        (&Value::from("base"), &Value::from("Higher hills"))
    );
    let total = &report["total"];
    let [cut, fill, net] = ["cut_m3", "fill_m3", "net_m3"].map(|q| number(&total[q]["value"]));
    assert!(
        (fill - cut - net).abs() < 1e-6 * (cut + fill) && cut + fill > 0.0,
        "{total}"
    );
    assert!(number(&total["cut_m3"]["error"]) >= 0.0);
    let table = compare("report.csv");
    let lines: Vec<&str> = table.lines().collect();
    assert!(lines[0].starts_with("id,name,kind,step,cut_m3,cut_m3_error,"));
    assert!(lines.last().unwrap().starts_with(",total,,,"));
    let page = compare("report.html");
    assert!(page.starts_with("<!doctype html>") && page.trim_end().ends_with("</html>"));
    assert_eq!(page.matches("data:image/png;base64,").count(), 3);
    assert!(
        !page.contains("http://") && !page.contains("https://"),
        "it needs nothing else"
    );

    let told = refused(&["compare", &project, "--b", "nothing"]);
    assert!(
        told.contains("expected base, ground or a scenario (Higher hills), found \"nothing\""),
        "{told}"
    );
    let told = refused(&["compare", &project, "--b", "base", "-o", "x.txt"]);
    assert!(told.contains("ends in .html or .json or .csv"), "{told}");
}
