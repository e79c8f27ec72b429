//! What clicks, keys and drags do to the project.

use crate::shared::{PROJECT, Window, sample};
use eframe::egui::accesskit::Role;
use eframe::egui::{Event, Key, Modifiers, Pos2, vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use relievo_engine::project::LayerKind;

#[test]
fn the_eye_hides_and_shows_a_layer() {
    let mut window = Window::open(PROJECT);
    window
        .harness
        .get_by_role_and_label(Role::CheckBox, "Show Hills")
        .click();
    window.steps();
    assert!(!window.layers()[0].visible);
    assert!(window.harness.state().document().is_changed());
    window.press(Modifiers::COMMAND, Key::Z);
    assert!(window.layers()[0].visible);
    assert!(
        !window.harness.state().document().is_changed(),
        "undone is as saved"
    );
}

#[test]
fn values_beyond_the_ends_of_their_sliders_are_shown_and_left_alone() {
    let odd = PROJECT
        .replace("900.0", "1e-6")
        .replace("500000.0", "123.456789012")
        .replace("\"height_m\": 0.0", "\"height_m\": 0.123456789");
    let mut window = Window::open(&odd);
    for layer in ["Hills", "High tint", "Low tint"] {
        window
            .harness
            .get_by_role_and_label(Role::ListBoxOption, layer)
            .click();
        window.steps();
    }
    assert!(!window.harness.state().document().is_changed());
    assert_eq!(window.undo_label(), None);
}

#[test]
fn a_whole_drag_of_a_slider_is_one_undo_step() {
    let mut window = Window::open(PROJECT);
    let slider = window
        .harness
        .get_by_role_and_label(Role::Slider, "Brightness")
        .rect();
    let from = Pos2::new(slider.left() + 60.0, slider.center().y);
    window.drag(from, from + vec2(40.0, 0.0));
    assert!(window.brightness("high") != 0.0);
    assert!(window.undo_label().is_some());
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(window.brightness("high"), 0.0);
    assert_eq!(window.undo_label(), None, "one step, not one a frame");
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert!(window.brightness("high") != 0.0);
}

#[test]
fn escape_takes_a_drag_back() {
    let mut window = Window::open(PROJECT);
    let slider = window
        .harness
        .get_by_role_and_label(Role::Slider, "Brightness")
        .rect();
    let from = Pos2::new(slider.left() + 60.0, slider.center().y);
    window.harness.hover_at(from);
    window.harness.drag_at(from);
    window.harness.run_steps(1);
    window.harness.hover_at(from + vec2(30.0, 0.0));
    window.harness.run_steps(2);
    assert!(window.brightness("high") != 0.0);
    window.press(Modifiers::NONE, Key::Escape);
    window.harness.hover_at(from + vec2(50.0, 0.0));
    window.harness.run_steps(2);
    assert_eq!(window.brightness("high"), 0.0);
    window.harness.drop_at(from + vec2(50.0, 0.0));
    window.steps();
    assert_eq!(
        (window.brightness("high"), window.undo_label()),
        (0.0, None)
    );
}

#[test]
fn alt_and_arrows_reorder_layers() {
    let mut window = Window::open(PROJECT);
    assert_eq!(
        window.harness.state().selected().unwrap().0,
        "high",
        "the top layer is selected first"
    );
    window.press(Modifiers::ALT, Key::ArrowDown);
    assert_eq!(window.order(), ["hills", "high", "low"]);
    window.press(Modifiers::ALT, Key::ArrowDown);
    window.press(Modifiers::ALT, Key::ArrowDown);
    assert_eq!(
        window.order(),
        ["high", "hills", "low"],
        "the lowest stays lowest"
    );
    window.press(Modifiers::ALT, Key::ArrowUp);
    assert_eq!(window.order(), ["hills", "high", "low"]);
}

#[test]
fn a_row_that_is_dragged_over_another_takes_its_place() {
    let mut window = Window::open(PROJECT);
    let row = |window: &Window, name: &str| {
        window
            .harness
            .get_by_role_and_label(Role::ListBoxOption, name)
            .rect()
    };
    let from = row(&window, "High tint");
    let to = row(&window, "Hills");
    let grip = Pos2::new(from.left() + 80.0, from.center().y);
    window.drag(grip, Pos2::new(grip.x, to.bottom() - 4.0));
    assert_eq!(window.order(), ["high", "hills", "low"]);
}

#[test]
fn a_click_selects_and_delete_removes() {
    let mut window = Window::open(PROJECT);
    window
        .harness
        .get_by_role_and_label(Role::ListBoxOption, "Low tint")
        .click();
    window.steps();
    assert_eq!(window.harness.state().selected().unwrap().0, "low");
    window.press(Modifiers::NONE, Key::Delete);
    assert_eq!(window.order(), ["hills", "high"]);
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(window.order(), ["hills", "low", "high"]);
}

#[test]
fn a_locked_layer_is_left_alone() {
    let mut window = Window::open(&PROJECT.replacen(
        "\"id\": \"high\"",
        "\"locked\": true, \"id\": \"high\"",
        1,
    ));
    window.press(Modifiers::NONE, Key::Delete);
    window.press(Modifiers::ALT, Key::ArrowDown);
    window
        .harness
        .get_by_role_and_label(Role::CheckBox, "Show High tint")
        .click();
    window.steps();
    assert_eq!(window.order(), ["hills", "low", "high"]);
    assert!(window.layers()[2].visible);
    assert!(!window.harness.state().document().is_changed());
}

#[test]
fn typing_a_name_does_not_fly_or_delete() {
    let mut window = Window::open(PROJECT);
    let before = *window.harness.state().camera();
    window
        .harness
        .get_by_role_and_label(Role::TextInput, "Name")
        .focus();
    window.steps();
    window
        .harness
        .key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.harness.key_down(Key::W);
    window
        .harness
        .get_by_role_and_label(Role::TextInput, "Name")
        .type_text("Snow");
    window.harness.key_press(Key::Delete);
    window.steps();
    window.harness.key_up(Key::W);
    window.press(Modifiers::NONE, Key::Enter);
    assert_eq!(window.layers()[2].name, "Snow");
    assert_eq!(*window.harness.state().camera(), before);
}

#[test]
fn dragging_the_view_moves_the_camera_but_is_no_edit() {
    let mut window = Window::open(PROJECT);
    let before = *window.harness.state().camera();
    let centre = window
        .harness
        .get_by_label("View of the planet")
        .rect()
        .center();
    window.drag(centre, centre + vec2(60.0, 20.0));
    let after = *window.harness.state().camera();
    assert!(
        after.lon_rad < before.lon_rad && after.lat_rad > before.lat_rad,
        "{after:?}"
    );
    assert!(!window.harness.state().document().is_changed());
    assert_eq!(window.undo_label(), None);
    window.press(Modifiers::COMMAND, Key::S);
    let saved = relievo_engine::project::open(&window.file)
        .unwrap()
        .0
        .camera
        .to_camera();
    assert!(
        (saved.lon_rad - after.lon_rad).abs() < 1e-12,
        "the camera is saved with the project"
    );
}

#[test]
fn keys_fly_and_the_wheel_zooms() {
    let mut window = Window::open(PROJECT);
    let start = *window.harness.state().camera();
    window.harness.key_down(Key::W);
    window.harness.run_steps(5);
    window.harness.key_up(Key::W);
    let flown = *window.harness.state().camera();
    assert!(flown.lat_rad > start.lat_rad);
    let centre = window
        .harness
        .get_by_label("View of the planet")
        .rect()
        .center();
    window.harness.hover_at(centre);
    let wheel = Event::MouseWheel {
        unit: eframe::egui::MouseWheelUnit::Line,
        delta: vec2(0.0, 3.0),
        phase: eframe::egui::TouchPhase::Move,
        source: eframe::egui::MouseWheelSource::Wheel,
        modifiers: Modifiers::NONE,
    };
    window.harness.event(wheel);
    window.harness.run_steps(10);
    assert!(window.harness.state().camera().altitude_m < 0.9 * flown.altitude_m);
}

#[test]
fn saving_writes_what_is_shown_and_clears_the_mark() {
    let mut window = Window::open(PROJECT);
    window.press(Modifiers::COMMAND, Key::H);
    assert!(window.harness.state().document().is_changed());
    window.press(Modifiers::COMMAND, Key::S);
    assert!(!window.harness.state().document().is_changed());
    let saved = relievo_engine::project::open(&window.file).unwrap().0;
    assert!(!saved.layers[2].visible);
}

#[test]
fn a_file_that_another_program_changed_is_not_overwritten_without_asking() {
    let mut window = Window::open(PROJECT);
    let theirs = PROJECT.replacen("Hills", "Mountains", 1);
    std::fs::write(&window.file, &theirs).unwrap();
    window.press(Modifiers::COMMAND, Key::H);
    window.press(Modifiers::COMMAND, Key::S);
    assert_eq!(std::fs::read_to_string(&window.file).unwrap(), theirs);
    window
        .harness
        .get_by_role_and_label(Role::Button, "Reload")
        .click();
    window.steps();
    assert_eq!(window.layers()[0].name, "Mountains");
}

#[test]
fn unsaved_changes_are_asked_about_before_another_project_is_started() {
    let mut window = Window::open(PROJECT);
    window.press(Modifiers::COMMAND, Key::H);
    window.press(Modifiers::COMMAND, Key::N);
    window
        .harness
        .get_by_role_and_label(Role::Button, "Cancel")
        .click();
    window.steps();
    assert_eq!(window.layers().len(), 3);
    window.press(Modifiers::COMMAND, Key::N);
    window
        .harness
        .get_by_role_and_label(Role::Button, "Save")
        .click();
    window.steps();
    assert!(window.layers().is_empty());
    assert!(
        !relievo_engine::project::open(&window.file)
            .unwrap()
            .0
            .layers[2]
            .visible
    );
}

#[test]
fn menus_help_and_the_scene_page_open_without_complaints() {
    let mut window = Window::open(PROJECT);
    window.harness.get_by_label("Scene").click();
    window.steps();
    window
        .harness
        .get_by_role_and_label(Role::Slider, "Azimuth")
        .set_value_accesskit(90.0);
    window.steps();
    assert_eq!(
        window.harness.state().document().project().sun.azimuth_deg,
        90.0
    );
    window.press(Modifiers::NONE, Key::F1);
    window.harness.get_by_role_and_label(Role::Button, "Close");
    window.press(Modifiers::NONE, Key::Escape);
    window.press(Modifiers::COMMAND, Key::G);
    window
        .harness
        .get_by_role_and_label(Role::Button, "Go")
        .click();
    window.steps();
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::M);
    window.harness.get_by_label("Messages");
    window.harness.get_by_label("File").click();
    window.steps();
    window.harness.get_by_label_contains("Save as");
}

#[test]
fn detail_is_added_by_the_menu_and_kept_to_a_range_of_heights() {
    let mut window = Window::open(PROJECT);
    let detail = |w: &Window| {
        let LayerKind::Detail(layer) = &w.layers().last().unwrap().kind else {
            panic!("expected a layer of detail");
        };
        layer.detail.clone()
    };
    window.harness.get_by_label("Layer").click();
    window.steps();
    window.harness.get_by_label_contains("Add detail").click();
    window.steps();
    assert_eq!(detail(&window).lowest_m, None);
    window
        .harness
        .get_by_role_and_label(Role::CheckBox, "By height")
        .click();
    window.steps();
    window
        .harness
        .get_by_role_and_label(Role::Slider, "Lowest")
        .set_value_accesskit(9500.0);
    window.steps();
    // The other bound gives way.
    let bounds = detail(&window);
    assert_eq!(
        (bounds.lowest_m, bounds.highest_m),
        (Some(9500.0), Some(9501.0))
    );
    for _ in 0..3 {
        window.press(Modifiers::COMMAND, Key::Z);
    }
    assert_eq!(window.order(), ["hills", "low", "high"]);
}

const MISSING: &str = r#"{"version": 1, "layers": [
    {"id": "east", "name": "East", "kind": "height", "path": "gone/east.tif"},
    {"id": "west", "name": "West", "kind": "height", "path": "gone/west.tif"}]}"#;

/// Paths of all layers' files.
fn paths(window: &Window) -> Vec<&str> {
    let sources = window.layers().iter().map(|l| l.source().unwrap());
    sources.map(|s| s.path.as_str()).collect()
}

#[test]
fn missing_files_are_located_together_as_one_step_and_never_dropped() {
    let mut window = Window::open(MISSING);
    window.until("the missing file is told", |w| {
        w.has_button("Locate the file of West") && w.has_button("Locate the file of East")
    });
    let moved = window.file.parent().unwrap().join("moved");
    std::fs::create_dir(&moved).unwrap();
    for name in ["east.tif", "west.tif"] {
        std::fs::write(moved.join(name), "not really a picture").unwrap();
    }
    let west = window.layers()[1].id.clone();
    window
        .harness
        .state_mut()
        .locate(west.clone(), &moved.join("west.tif"));
    window.until("the question", |w| w.has_button("Link all"));
    window.click("Cancel");
    assert_eq!(paths(&window), ["gone/east.tif", "gone/west.tif"]);
    window
        .harness
        .state_mut()
        .locate(west.clone(), &moved.join("west.tif"));
    window.until("the question", |w| w.has_button("Link all"));
    window.press(Modifiers::NONE, Key::Enter);
    assert_eq!(paths(&window), ["moved/east.tif", "moved/west.tif"]);
    assert_eq!(window.undo_label().as_deref(), Some("Relink 2 files"));
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(paths(&window), ["gone/east.tif", "gone/west.tif"]);
    window
        .harness
        .state_mut()
        .locate(west, &moved.join("west.tif"));
    window.until("the question", |w| w.has_button("Only the one"));
    window.click("Only the one");
    assert_eq!(paths(&window), ["gone/east.tif", "moved/west.tif"]);
    window.press(Modifiers::COMMAND, Key::S);
    let saved = relievo_engine::project::open(&window.file).unwrap().0;
    assert_eq!(
        saved.layers[0].source().unwrap().path,
        "gone/east.tif",
        "a file that is missing is not dropped"
    );
}

#[test]
fn an_empty_window_offers_projects_and_files_and_what_was_open_lately() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("sample.relievo");
    std::fs::write(&file, PROJECT).unwrap();
    let gone = folder.path().join("gone.relievo");
    let list = serde_json::json!({"projects": [&gone, &file]});
    std::fs::create_dir(folder.path().join("state")).unwrap();
    std::fs::write(folder.path().join("state/recent.json"), list.to_string()).unwrap();
    let mut window = Window::start(folder, file, false);
    window.harness.get_by_label_contains("New from files…");
    let there = |w: &Window, name: &str| {
        let button = w.harness.get_by_label_contains(name);
        !button.accesskit_node().is_disabled()
    };
    window.until("what is missing is greyed", |w| !there(w, "gone  –"));
    assert!(there(&window, "sample  –"));
    window.harness.get_by_label_contains("sample  –").click();
    window.steps();
    assert_eq!(window.order(), ["hills", "low", "high"]);
    assert!(
        window
            .harness
            .query_by_label_contains("New from files…")
            .is_none()
    );
    // The one that was opened is on top of the list now, also for the next window.
    let list = std::fs::read_to_string(window.file.with_file_name("state/recent.json")).unwrap();
    let (sample, gone) = (list.find("sample").unwrap(), list.find("gone").unwrap());
    assert!(sample < gone, "{list}");
    window.harness.get_by_label("File").click();
    window.steps();
    window.harness.get_by_label_contains("Open recent").click();
    window.steps();
    window.click("Clear this list");
    let list = std::fs::read_to_string(window.file.with_file_name("state/recent.json")).unwrap();
    assert!(!list.contains("relievo"), "{list}");
}

#[test]
fn edits_that_a_crash_left_unsaved_are_offered_again() {
    let mut window = Window::open(PROJECT);
    window.press(Modifiers::COMMAND, Key::H);
    window.press(Modifiers::ALT, Key::ArrowDown);
    assert_eq!(window.order(), ["hills", "high", "low"]);
    // The window is dropped without a word, as in a crash.
    let mut window = window.again();
    assert_eq!(window.order(), ["hills", "low", "high"]);
    window.click("Recover");
    assert_eq!(window.order(), ["hills", "high", "low"]);
    assert!(!window.layers()[1].visible && window.harness.state().document().is_changed());
    window.press(Modifiers::COMMAND, Key::S);
    let mut window = window.again();
    assert!(!window.has_button("Recover"));
    window.press(Modifiers::COMMAND, Key::H);
    let mut window = window.again();
    window.click("Throw away");
    let window = window.again();
    assert!(!window.has_button("Recover"));
}

#[test]
fn a_file_that_changed_while_the_window_was_behind_is_told_when_it_comes_to_the_front() {
    let mut window = Window::open(PROJECT);
    window.harness.event(Event::WindowFocused(false));
    window.steps();
    let theirs = PROJECT.replacen("Hills", "Mountains", 1);
    std::fs::write(&window.file, &theirs).unwrap();
    window.harness.event(Event::WindowFocused(true));
    window.steps();
    window.until("the question", |w| w.has_button("Reload"));
    window.click("Reload");
    assert_eq!(window.layers()[0].name, "Mountains");
}

#[test]
fn a_viewer_near_the_ground_stays_there_while_the_ground_gets_finer() {
    let (folder, file) = sample();
    let text = std::fs::read_to_string(&file).unwrap();
    let start = text.find("\"camera\"").unwrap();
    let end = start + text[start..].find('}').unwrap() + 1;
    // 195 m above a valley floor, below what five minutes of arc make of the mountains beside it.
    let camera = r#""camera": {"lon_deg": -111.6395, "lat_deg": 40.2575, "altitude_m": 1650.0,
        "heading_deg": 45.0, "pitch_deg": -14.0}"#;
    let text = format!("{}{camera}{}", &text[..start], &text[end..]);
    std::fs::write(&file, text).unwrap();
    let mut window = Window::start(folder, file, true);
    window.until("the ground", |w| {
        w.harness.query_by_label("complete").is_some()
    });
    window.steps();
    let altitude_m = window.harness.state().camera().altitude_m;
    assert!((altitude_m - 1650.0).abs() < 1e-6, "{altitude_m}");
}
