//! What people measure in the window: results, their marks on the terrain, files.

use eframe::egui::accesskit::Role;
use eframe::egui::{Key, Modifiers};
use egui_kittest::kittest::{NodeT, Queryable};
use relievo::window::Pane;

use crate::shared::{PLAIN, Window};

impl Window {
    /// What the legend over the picture says; empty without one.
    fn legend(&self) -> String {
        let node = self.harness.query_by_label_contains("Legend. ");
        node.and_then(|n| n.accesskit_node().label())
            .unwrap_or_default()
    }

    fn says(&self, text: &str) -> bool {
        self.harness.query_by_label_contains(text).is_some()
    }

    /// Runs a command by its name.
    fn run(&mut self, command: &str) {
        self.press(Modifiers::COMMAND, Key::P);
        self.harness
            .get_by_role_and_label(Role::TextInput, "Find a command")
            .type_text(command);
        self.steps();
        self.press(Modifiers::NONE, Key::Enter);
    }
}

/// Level ground at 0 m with a platform of 100 m: 1 km square around 10°, 45°.
const PLATFORM: &str = r#"{"version": 1,
    "camera": {"lon_deg": 10.0, "lat_deg": 45.0, "altitude_m": 6000.0},
    "layers": [{"id": "hills", "name": "Hills", "kind": "noise", "amplitude_m": 1e-6, "wavelength_m": 20000.0, "octaves": 1}],
    "elements": [{"id": "p", "name": "Square", "kind": "polygon", "surface": {"kind": "platform", "height_m": 10.0},
        "outline": [[9.99, 44.99], [10.01, 44.99], [10.01, 45.01], [9.99, 45.01]],
        "side": {"cut_slope": 0.5, "fill_slope": 0.5, "max_reach_m": 100.0}}]}"#;

#[test]
fn an_observer_is_placed_and_what_is_seen_lies_on_the_terrain_until_it_is_cleared() {
    let mut window = Window::open(PLAIN);
    window.press(Modifiers::NONE, Key::O);
    assert!(window.harness.state().shows(Pane::Viewshed));
    let middle = window.at(0.0, 0.0);
    window.click_at(middle);
    window.until("the viewshed", |w| w.legend().contains("Seen: "));
    // All of a circle of 2 km on ground as flat as the sea is within the horizon of 4.7 km.
    assert!(
        window.legend().contains("Seen: 12.57 km² (100 %)"),
        "{}",
        window.legend()
    );
    // A quick answer follows the project by itself.
    window
        .harness
        .get_by_role_and_label(Role::SpinButton, "Radius")
        .set_value_accesskit(1000.0);
    window.steps();
    window.until("the smaller circle", |w| w.legend().contains("3.14 km²"));
    window.press(Modifiers::NONE, Key::Escape);
    window.run("clear results");
    assert_eq!(window.legend(), "");
    assert!(!window.harness.state().document().is_changed());
}

#[test]
fn water_rises_to_a_level_that_is_typed_and_says_when_the_place_is_dry() {
    let mut window = Window::open(PLATFORM);
    window.press(Modifiers::NONE, Key::U);
    // The middle is the platform at 10 m.
    window.until("tiles", |w| !w.says(" tiles"));
    let middle = window.at(0.0, 0.0);
    window.click_at(middle);
    let level = |w: &Window, m: f64| {
        w.harness
            .get_by_role_and_label(Role::Slider, "Level")
            .set_value_accesskit(m);
    };
    level(&window, 3.0);
    window.steps();
    window.until("why not", |w| {
        w.says("expected ground below the water level of 3 m")
    });
    assert_eq!(window.legend(), "");
}

#[test]
fn volumes_are_measured_and_written_and_out_of_date_once_the_plan_changes() {
    let mut window = Window::open(PLATFORM);
    window.run("measure volumes");
    assert!(window.harness.state().shows(Pane::Volumes));
    window.until("the volumes", |w| w.says("From ground to base"));
    assert!(window.has_button("Square, added"));
    let folder = tempfile::tempdir().unwrap();
    for (item, name) in [
        ("Page with pictures (HTML)…", "r.html"),
        ("Table (CSV)…", "r.csv"),
        ("Data (JSON)…", "r.json"),
    ] {
        window.click("Save report");
        window.click(item);
        let file = folder.path().join(name);
        window.type_path(&file);
        window.until("the report", |_| file.is_file());
    }
    let data = std::fs::read_to_string(folder.path().join("r.json")).unwrap();
    let data: serde_json::Value = serde_json::from_str(&data).unwrap();
    let amount = |name: &str| {
        (
            data["total"][name]["value"].as_f64().unwrap(),
            data["total"][name]["error"].as_f64().unwrap(),
        )
    };
    // A square of 1577.0 by 2222.6 m on the ellipsoid, 10 m high, and slopes of 20 m around it.
    let (fill, error) = amount("fill_m3");
    let (west_east, south_north) = (1576.9, 2222.6);
    let truth = 10.0 * west_east * south_north
        + 100.0 * 2.0 * (west_east + south_north)
        + 4.0 / 3.0 * 10.0 * 100.0 * core::f64::consts::PI;
    assert!(
        (fill / truth - 1.0).abs() < 1e-3 && error / fill < 2e-3,
        "{fill} {truth}"
    );
    let page = std::fs::read_to_string(folder.path().join("r.html")).unwrap();
    assert!(page.contains("data:image/png;base64,"));
    // Whatever it took, the pane says what it is of.
    window.click("Square, added");
    assert_eq!(window.harness.state().selected_element().unwrap().id.0, "p");
    window.press(Modifiers::NONE, Key::Delete);
    window.until("the next answer", |w| {
        w.says("Out of date") || w.says("Nothing differs.")
    });
    if window.says("Out of date") {
        window.click("Measure again");
    }
    window.until("nothing", |w| w.says("Nothing differs."));
}

#[test]
fn contours_of_the_view_are_written() {
    let mut window = Window::open(&PLATFORM.replace("1e-6", "500.0"));
    window.until("files", |w| !w.says(" tiles"));
    window.run("contours of this view");
    window.until("contours", |w| w.says("Save GeoJSON…"));
    let folder = tempfile::tempdir().unwrap();
    for name in ["c.geojson", "c.gpkg"] {
        window.click(if name.ends_with("gpkg") {
            "Save GeoPackage…"
        } else {
            "Save GeoJSON…"
        });
        let file = folder.path().join(name);
        window.type_path(&file);
        window.until("the file", |_| file.is_file());
    }
    let text = std::fs::read_to_string(folder.path().join("c.geojson")).unwrap();
    let data: serde_json::Value = serde_json::from_str(&text).unwrap();
    let heights = data["features"].as_array().unwrap().iter();
    let heights: Vec<f64> = heights
        .map(|f| f["properties"]["height_m"].as_f64().unwrap())
        .collect();
    assert!(heights.len() > 3 && heights.iter().all(|h| h % 10.0 == 0.0));
    assert!(window.legend().contains("Contours every 10 m"));
}
