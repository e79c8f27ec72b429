//! Vector layers: classes of features by a property.

use eframe::egui::accesskit::Role;
use eframe::egui::{Key, Modifiers};
use egui_kittest::kittest::{NodeT, Queryable};
use relievo_engine::project::{ClassedBy, LayerKind};

use crate::shared::Window;

const LAYER: &str = r##"{"version": 1,
    "camera": {"lon_deg": 10.0, "lat_deg": 45.0, "altitude_m": 20000.0},
    "layers": [{"id": "v", "name": "Plots", "kind": "vector", "path": "plots.geojson", "style": {"fill": "#808080"}}]}"##;

/// Three points with a use and a height.
const PLOTS: &str = r#"{"type": "FeatureCollection", "features": [
    {"type": "Feature", "properties": {"use": "field", "height": 1}, "geometry": {"type": "Point", "coordinates": [10, 45]}},
    {"type": "Feature", "properties": {"use": "wood", "height": 5}, "geometry": {"type": "Point", "coordinates": [10.01, 45]}},
    {"type": "Feature", "properties": {"use": "field", "height": 9}, "geometry": {"type": "Point", "coordinates": [10.02, 45]}}]}"#;

fn classes(window: &Window) -> Option<ClassedBy> {
    let LayerKind::Vector(vector) = &window.layers()[0].kind else {
        panic!("expected a vector layer")
    };
    vector.style.by.clone()
}

#[test]
fn features_are_coloured_by_a_property_in_classes_that_can_be_undone() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("plots.geojson"), PLOTS).unwrap();
    let file = folder.path().join("sample.relievo");
    std::fs::write(&file, LAYER).unwrap();
    let mut window = Window::start(folder, file, true);
    window.until("the features", |w| {
        w.harness.query_by_label_contains("3 features").is_some()
    });
    let choose = |window: &mut Window, list: &str, item: &str| {
        window
            .harness
            .get_by_role_and_label(Role::ComboBox, list)
            .click();
        window.steps();
        window
            .harness
            .get_by_role_and_label(Role::Button, item)
            .click();
        window.steps();
    };
    choose(&mut window, "Colour by", "use");
    window.until("classes", |w| classes(w).is_some());
    let by = classes(&window).unwrap();
    assert_eq!((by.property.as_str(), by.classes.len()), ("use", 2));
    assert!(by.classes[0].fill.is_some() && by.classes[0].fill != by.classes[1].fill);
    window.steps();
    let wells = window.harness.query_all_by_role(Role::ColorWell);
    let wells: Vec<String> = wells
        .filter_map(|n| n.accesskit_node().label())
        .filter(|l| l.starts_with("Fill of "))
        .collect();
    assert_eq!(wells, ["Fill of field", "Fill of wood"]);
    window.click("Remove class field");
    assert_eq!(classes(&window).unwrap().classes.len(), 1);
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(classes(&window), Some(by));
    choose(&mut window, "Colour by", "height");
    window.until("numbers", |w| classes(w).unwrap().property == "height");
    choose(&mut window, "Classes", "Equal counts");
    window.until("ranges", |w| {
        w.harness.query_by_label_contains("Fill of below").is_some()
    });
    choose(&mut window, "Colour by", "All alike");
    assert_eq!(classes(&window), None);
}
