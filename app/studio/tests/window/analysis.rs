//! What people measure in the window: results, their marks on the terrain, files.

use eframe::egui::accesskit::Role;
use eframe::egui::{Key, Modifiers};
use egui_kittest::kittest::{NodeT, Queryable};
use relievo::window::Pane;
use relievo_engine::planet::Planet;

use crate::shared::Window;

impl Window {
    /// What the legend over the picture says; empty without one.
    fn legend(&self) -> String {
        let node = self.harness.query_by_label_contains("Legend. ");
        node.and_then(|n| n.accesskit_node().value())
            .unwrap_or_default()
    }

    fn says(&self, text: &str) -> bool {
        self.harness
            .query_all_by_label_contains(text)
            .next()
            .is_some()
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

/// The area of the water that the legend tells.
fn area_m2(window: &Window) -> f64 {
    let legend = window.legend();
    let text = legend.split(" m: ").nth(1).unwrap();
    let (number, _) = text.split_once(" m²").unwrap();
    number.parse().unwrap()
}

/// Level ground at 0 m seen from above, with what comes after the layers.
fn level(altitude_m: u32, more: &str) -> String {
    format!(
        r#"{{"version": 1,
        "camera": {{"lon_deg": 10.0, "lat_deg": 45.0, "altitude_m": {altitude_m}}},
        "layers": [{{"id": "flat", "name": "Flat", "kind": "noise", "amplitude_m": 0.01, "wavelength_m": 20000.0, "octaves": 1}}]{more}}}"#
    )
}

/// A square with upright walls and a flat bottom.
fn square(half_deg: f64, height_m: f64) -> String {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let outline = corners.map(|(x, y)| [10.0 + x * half_deg, 45.0 + y * half_deg]);
    format!(
        r#", "elements": [{{"id": "p", "name": "Square", "kind": "polygon", "outline": {outline:?},
        "surface": {{"type": "platform", "height_m": {height_m}}}, "side": {{"wall": true}}}}]"#
    )
}

#[test]
fn an_observer_is_placed_and_what_is_seen_lies_on_the_terrain_until_it_is_cleared() {
    let mut window = Window::open(&level(20_000, ""));
    window.press(Modifiers::NONE, Key::O);
    assert!(window.harness.state().shows(Pane::Viewshed));
    let middle = window.at(0.0, 0.0);
    window.click_at(middle);
    // All of a circle of 2 km on level ground is within the horizon of 4.7 km.
    window.until("the viewshed", |w| w.legend().contains("(100 %)"));
    let seen_km2 = |w: &Window| -> f64 {
        let legend = w.legend();
        let text = legend.split("Seen: ").nth(1).unwrap_or_default();
        text.split(' ').next().unwrap().parse().unwrap()
    };
    let circle_km2 = |radius_km: f64| core::f64::consts::PI * radius_km * radius_km;
    assert!((seen_km2(&window) / circle_km2(2.0) - 1.0).abs() < 0.02);
    window
        .harness
        .get_by_role_and_label(Role::SpinButton, "Radius")
        .set_value_accesskit(1000.0);
    window.steps();
    window.until("the smaller circle", |w| {
        if w.says("Out of date") {
            w.harness
                .get_by_role_and_label(Role::Button, "Measure again")
                .click();
        }
        (seen_km2(w) / circle_km2(1.0) - 1.0).abs() < 0.02
    });
    window.press(Modifiers::NONE, Key::Escape);
    window.run("clear results");
    assert_eq!(window.legend(), "");
    assert_eq!(window.layers().len(), 1, "no result is part of the project");
}

#[test]
fn water_rises_to_a_level_that_is_typed_and_says_when_the_place_is_dry() {
    // A basin of a thousandth of a degree, 20 m deep.
    let (half_deg, planet) = (0.0005_f64, Planet::EARTH);
    let side_m = planet.metres_per_radian(45_f64.to_radians()) * (2.0 * half_deg).to_radians();
    let mut window = Window::open(&level(400, &square(half_deg, -20.0)));
    window.until("the picture", |w| w.says("complete"));
    window.press(Modifiers::NONE, Key::U);
    let middle = window.at(0.0, 0.0);
    window.click_at(middle);
    window.until("the water", |w| w.legend().contains("Water at -15.00 m: "));
    // Counted in samples, half of one missing or too many along the walls.
    let (area_m2, spacing_m) = (area_m2(&window), 1.0);
    let wrong_m2 = (area_m2 - side_m.x * side_m.y).abs();
    assert!(wrong_m2 < (side_m.x + side_m.y) * spacing_m, "{area_m2} m²");
    assert!(
        window.legend().contains("5.00 m deep"),
        "{}",
        window.legend()
    );
    let type_level = |w: &mut Window, m: f64| {
        w.harness
            .get_by_role_and_label(Role::Slider, "Level")
            .set_value_accesskit(m);
        w.steps();
    };
    type_level(&mut window, -25.0);
    window.until("why not", |w| {
        if w.says("Out of date") {
            w.harness
                .get_by_role_and_label(Role::Button, "Measure again")
                .click();
        }
        w.says("expected ground below the water level of -25 m")
    });
    // The view is drawn before the pane that says it.
    window.until("a view without water", |w| w.legend().is_empty());
}

#[test]
fn volumes_are_measured_and_written_and_out_of_date_once_the_plan_changes() {
    let mut window = Window::open(&level(
        6000,
        &square(0.001, 10.0).replace(r#""wall": true"#, r#""cut_slope": 0.5, "fill_slope": 0.5"#),
    ));
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::U);
    window
        .harness
        .get_by_role_and_label(Role::SpinButton, "Samples")
        .set_value_accesskit(20_000.0);
    window.steps();
    window.run("measure volumes");
    assert!(window.harness.state().shows(Pane::Volumes));
    window.until("the volumes", |w| w.says("From ground to base"));
    assert!(window.has_button("Square, added"));
    let folder = tempfile::tempdir().unwrap();
    for (item, name) in [("Table (CSV)…", "r.csv"), ("Data (JSON)…", "r.json")] {
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
    // 0.002° of longitude and of latitude at 45° on WGS 84, 10 m high.
    let (fill, error) = amount("fill_m3");
    // With slopes of 20 m beside it, and quarters of cones at its corners.
    let (width_m, height_m) = (157.6937, 222.2635);
    let cone_m3 = core::f64::consts::PI * 20.0 * 20.0 * 10.0 / 3.0;
    let truth = 10.0 * width_m * height_m + 100.0 * 2.0 * (width_m + height_m) + cone_m3;
    assert!(
        (fill - truth).abs() <= error + 1e-3 * truth && error < 0.1 * truth,
        "{fill} ± {error}, {truth}"
    );
    let table = std::fs::read_to_string(folder.path().join("r.csv")).unwrap();
    assert!(table.contains("p,Square,polygon,added,"));
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
    let mut window = Window::open(&level(6000, "").replace("0.01", "500.0"));
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
