//! Colours: curves, levels, matching, seams.

use eframe::egui::accesskit::Role;
use eframe::egui::{Key, Modifiers, vec2};
use egui_kittest::kittest::{NodeT as _, Queryable};
use relievo_engine::project::{Adjust, DetailBy, ImageryLayer, LayerId, LayerKind};

use super::shared::Window;

/// Two tints over noise: the upper one brighter and bluer.
const TINTS: &str = r##"{"version": 1,
    "camera": {"lon_deg": 10.0, "lat_deg": 45.0, "altitude_m": 20000.0},
    "layers": [
    {"id": "hills", "name": "Hills", "kind": "noise", "amplitude_m": 900.0, "wavelength_m": 50000.0, "octaves": 3},
    {"id": "low", "name": "Low tint", "kind": "tint", "stops": [
        {"height_m": -900.0, "colour": "#203050"}, {"height_m": 900.0, "colour": "#a0a060"}]},
    {"id": "high", "name": "High tint", "kind": "tint", "stops": [
        {"height_m": -900.0, "colour": "#405080"}, {"height_m": 900.0, "colour": "#c0c8b0"}]}]}"##;

fn adjust(window: &Window, id: &str) -> Adjust {
    let layer = window.layers().iter().find(|l| l.id.0 == id).unwrap();
    let LayerKind::Tint(tint) = &layer.kind else {
        panic!("expected a tint, found {}", layer.kind.name());
    };
    tint.adjust.clone()
}

#[test]
fn a_layer_is_matched_to_what_lies_below_in_one_step_that_can_be_taken_back() {
    let mut window = Window::open(TINTS);
    window.click("Match colours…");
    window.click("Match colours");
    window.until("the match", |w| {
        w.undo_label().as_deref() == Some("Match colours")
    });
    assert_ne!(adjust(&window, "high"), Adjust::default());
    window.until("its figures", |w| {
        w.harness
            .query_by_label_contains("places compared")
            .is_some()
    });
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(adjust(&window, "high"), Adjust::default());
    assert_eq!(window.undo_label(), None);
}

#[test]
fn layers_are_balanced_and_the_one_that_is_kept_stays() {
    let mut window = Window::open(TINTS);
    window.click("Match colours…");
    window.click("Balance layers");
    window.until("the balance", |w| {
        w.undo_label().as_deref() == Some("Balance layers")
    });
    for id in ["low", "high"] {
        assert_ne!(adjust(&window, id), Adjust::default(), "{id}");
    }
    window.press(Modifiers::COMMAND, Key::Z);
    for id in ["low", "high"] {
        assert_eq!(adjust(&window, id), Adjust::default(), "{id}");
    }
}

#[test]
fn a_curve_is_bent_by_clicks_by_drags_and_by_keys() {
    let mut window = Window::open(TINTS);
    window.harness.get_by_label("Curves").click();
    window.steps();
    let plane = "Tone curve of all channels, 0 points";
    let rect = window
        .harness
        .get_by_role_and_label(Role::Slider, plane)
        .rect();
    window.click_at(rect.center() + vec2(0.0, -0.1 * rect.height()));
    let points = adjust(&window, "high").curves.all;
    assert_eq!(points.len(), 3, "both ends and the new one");
    assert!(points[1].output > points[1].input, "{points:?}");
    // The new point has the keys.
    let before = points[1].output;
    window.press(Modifiers::NONE, Key::ArrowUp);
    let after = adjust(&window, "high").curves.all[1].output;
    assert!((after - before - 0.01).abs() < 1e-9);
    let at = rect.center() + vec2(0.0, -0.1 * rect.height());
    window.drag(at, rect.center() + vec2(0.0, 0.2 * rect.height()));
    let points = adjust(&window, "high").curves.all;
    assert!(points[1].output < points[1].input, "{points:?}");
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(
        adjust(&window, "high").curves.all[1].output,
        after,
        "one step"
    );
    window.press(Modifiers::NONE, Key::Delete);
    assert!(adjust(&window, "high").curves.all.len() < 3);
}

#[test]
fn a_stretch_makes_the_darkest_seen_black_and_the_lightest_white() {
    let mut window = Window::open(TINTS);
    window.click("Levels…");
    window.until("a histogram", |w| {
        let button = w
            .harness
            .query_by_role_and_label(Role::Button, "Stretch each");
        button.is_some_and(|b| !b.accesskit_node().is_disabled())
    });
    window.click("Stretch each");
    let adjusted = adjust(&window, "high");
    for channel in 0..3 {
        assert!(adjusted.gain[channel] > 1.2, "{adjusted:?}");
        assert!(adjusted.offset[channel] < 0.0, "{adjusted:?}");
    }
}

/// Two pictures whose files are gone: what is set does not need them.
const PICTURES: &str = r#"{"version": 1, "layers": [
    {"id": "near", "name": "Aerial", "kind": "imagery", "path": "gone/near.tif"},
    {"id": "wide", "name": "Satellite", "kind": "imagery", "path": "gone/wide.tif"}]}"#;

fn imagery(window: &Window) -> ImageryLayer {
    let layer = window.layers().iter().find(|l| l.id.0 == "wide").unwrap();
    let LayerKind::Imagery(imagery) = &layer.kind else {
        panic!("expected imagery, found {}", layer.kind.name());
    };
    imagery.clone()
}

#[test]
fn imagery_goes_on_after_examples_or_by_noise_and_every_step_is_taken_back() {
    let mut window = Window::open(PICTURES);
    window
        .harness
        .get_by_label("Detail beyond the file")
        .click();
    window.steps();
    window.click("Add examples");
    let [only] = &imagery(&window).detail[..] else {
        panic!("one kind of detail");
    };
    let DetailBy::Examples { layers, .. } = &only.by else {
        panic!("after examples");
    };
    assert_eq!(layers[..], [LayerId::from("near")]);
    window
        .harness
        .get_by_role_and_label(Role::Slider, "Amount")
        .set_value_accesskit(2.0);
    window.steps();
    assert_eq!(imagery(&window).detail[0].strength, 2.0);
    window.click("Add noise");
    let by: Vec<bool> = imagery(&window)
        .detail
        .iter()
        .map(|d| d.by == DetailBy::Noise)
        .collect();
    assert_eq!(by, [false, true]);
    for count in [1, 1, 0] {
        window.press(Modifiers::COMMAND, Key::Z);
        assert_eq!(imagery(&window).detail.len(), count);
    }
    assert_eq!(window.undo_label(), None);
}

#[test]
fn holes_and_seams_are_set_in_the_inspector() {
    let mut window = Window::open(PICTURES);
    window
        .harness
        .get_by_role_and_label(Role::CheckBox, "Fill holes")
        .click();
    window.steps();
    assert!(imagery(&window).missing.is_some());
    window
        .harness
        .get_by_role_and_label(Role::Slider, "Seam blend")
        .set_value_accesskit(500.0);
    window.steps();
    assert_eq!(imagery(&window).seam_blend_m, 500.0);
    for _ in 0..2 {
        window.press(Modifiers::COMMAND, Key::Z);
    }
    assert_eq!(
        (imagery(&window).missing, imagery(&window).seam_blend_m),
        (None, 0.0)
    );
}
