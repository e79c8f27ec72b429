//! Panes, the palette, the history and how the window looks, as people use them.

use crate::shared::{PROJECT, Window};
use eframe::egui::accesskit::{Role, Toggled};
use eframe::egui::{Event, Key, Modifiers};
use egui_kittest::kittest::{NodeT, Queryable};
use relievo::commands::{Command, Menu, TABLE};
use relievo::window::Pane;

const CTRL_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

impl Window {
    fn shows(&self, pane: Pane) -> bool {
        self.harness.state().shows(pane)
    }

    /// Opens the palette and types.
    fn find(&mut self, text: &str) {
        self.press(Modifiers::COMMAND, Key::P);
        self.harness
            .get_by_role_and_label(Role::TextInput, "Find a command")
            .type_text(text);
        self.steps();
    }
}

#[test]
fn every_pane_is_shown_and_hidden_by_its_keys_and_draws_without_complaint() {
    let mut window = Window::open(PROJECT);
    for entry in TABLE {
        let Command::Toggle(pane) = entry.command else {
            continue;
        };
        let keys = entry.shortcuts[0];
        let first = window.shows(pane);
        window.press(keys.modifiers, keys.logical_key);
        assert_eq!(window.shows(pane), !first, "{pane:?}");
        window.press(keys.modifiers, keys.logical_key);
        assert_eq!(window.shows(pane), first, "{pane:?}");
        window.press(keys.modifiers, keys.logical_key);
        window.press(keys.modifiers, keys.logical_key);
    }
}

#[test]
fn panes_and_looks_are_kept_for_the_next_run_and_can_be_reset() {
    let mut window = Window::open(PROJECT);
    window.press(CTRL_SHIFT, Key::L);
    window.press(CTRL_SHIFT, Key::T);
    window.press(Modifiers::COMMAND, Key::Plus);
    assert!(!window.shows(Pane::Layers) && window.shows(Pane::Statistics));
    let mut window = window.again();
    assert!(!window.shows(Pane::Layers) && window.shows(Pane::Statistics));
    assert_eq!(window.harness.ctx.zoom_factor(), 1.1);
    window.find("reset panes");
    window.press(Modifiers::NONE, Key::Enter);
    assert!(window.shows(Pane::Layers) && !window.shows(Pane::Statistics));
}

#[test]
fn the_palette_finds_a_command_by_a_few_letters_and_runs_it() {
    let mut window = Window::open(PROJECT);
    window.find("shohid");
    let line = |w: &Window| {
        w.harness
            .get_by_role_and_label(Role::ListBoxOption, "Show or hide")
            .accesskit_node()
            .toggled()
    };
    assert_eq!(line(&window), Some(Toggled::True));
    window.press(Modifiers::NONE, Key::Enter);
    assert!(!window.layers()[2].visible);
    assert!(
        window
            .harness
            .query_by_role_and_label(Role::TextInput, "Find a command")
            .is_none()
    );
    // Without a step to undo the palette says so and does nothing.
    window.press(Modifiers::COMMAND, Key::Z);
    window.press(Modifiers::COMMAND, Key::K);
    let undo = window
        .harness
        .get_by_role_and_label(Role::ListBoxOption, "Undo");
    assert!(undo.accesskit_node().is_disabled());
    window.press(Modifiers::NONE, Key::Escape);
    assert!(!window.harness.state().document().is_changed());
}

#[test]
fn what_is_typed_while_the_palette_opens_is_for_the_palette() {
    let mut window = Window::open(PROJECT);
    // All in one frame, as a slow one hears it: the letters have meanings of their own otherwise.
    window
        .harness
        .key_press_modifiers(Modifiers::COMMAND, Key::P);
    for (key, letter) in [(Key::B, "b"), (Key::R, "r"), (Key::U, "u")] {
        window.harness.key_press(key);
        window.harness.event(Event::Text(letter.to_owned()));
    }
    window.steps();
    let field = window
        .harness
        .get_by_role_and_label(Role::TextInput, "Find a command");
    assert_eq!(field.accesskit_node().value().as_deref(), Some("bru"));
}

#[test]
fn arrows_choose_in_the_palette() {
    let mut window = Window::open(PROJECT);
    window.press(Modifiers::COMMAND, Key::P);
    let chosen = |w: &Window| -> Option<String> {
        let all = w.harness.query_all_by_role(Role::ListBoxOption);
        let node = all.filter(|n| n.accesskit_node().toggled() == Some(Toggled::True));
        // The selected layer lies behind the palette.
        node.filter_map(|n| n.accesskit_node().label()).next_back()
    };
    let first = chosen(&window);
    window.press(Modifiers::NONE, Key::ArrowDown);
    let second = chosen(&window);
    assert!(first.is_some() && first != second);
    window.press(Modifiers::NONE, Key::ArrowUp);
    assert_eq!(chosen(&window), first);
}

#[test]
fn a_click_in_the_history_goes_there_and_back() {
    let mut window = Window::open(PROJECT);
    window.press(Modifiers::COMMAND, Key::H);
    window.press(Modifiers::ALT, Key::ArrowDown);
    window.press(Modifiers::NONE, Key::Delete);
    assert_eq!(window.order(), ["hills", "low"]);
    window.press(CTRL_SHIFT, Key::H);
    window
        .harness
        .get_by_role_and_label(Role::ListBoxOption, "Step: As it was opened")
        .click();
    window.steps();
    assert_eq!(window.order(), ["hills", "low", "high"]);
    assert!(window.layers()[2].visible && !window.harness.state().document().is_changed());
    let last = window
        .harness
        .query_all_by_role(Role::ListBoxOption)
        .rfind(|n| {
            n.accesskit_node()
                .label()
                .is_some_and(|l| l.starts_with("Step: "))
        })
        .unwrap();
    last.click();
    window.steps();
    assert_eq!(window.order(), ["hills", "low"]);
}

#[test]
fn every_command_is_in_a_menu() {
    let mut window = Window::open(PROJECT);
    for menu in Menu::ALL {
        window
            .harness
            .query_all_by_role_and_label(Role::Button, menu.title())
            .next()
            .unwrap()
            .click();
        window.steps();
        for entry in TABLE.iter().filter(|e| e.menu == menu) {
            assert!(
                window
                    .harness
                    .query_all_by_label_contains(entry.title)
                    .next()
                    .is_some(),
                "{}",
                entry.title
            );
        }
        window.press(Modifiers::NONE, Key::Escape);
    }
}

#[test]
fn a_problem_can_be_acted_on_where_it_is_told() {
    const MISSING: &str = r#"{"version": 1, "layers": [
        {"id": "east", "name": "East", "kind": "height", "path": "gone/east.tif"},
        {"id": "top", "name": "Top", "kind": "noise", "amplitude_m": 900.0, "wavelength_m": 500000.0, "octaves": 3}]}"#;
    let mut window = Window::open(MISSING);
    window.press(CTRL_SHIFT, Key::M);
    window.until("the problem is told", |w| {
        w.has_button("Find the file of East")
    });
    assert!(window.has_button("Try East again"));
    assert_eq!(window.harness.state().selected().unwrap().0, "top");
    window.click("Select East");
    assert_eq!(window.harness.state().selected().unwrap().0, "east");
}

#[test]
fn the_histogram_of_noise_counts_before_and_after() {
    let mut window = Window::open(PROJECT);
    window
        .harness
        .get_by_role_and_label(Role::ListBoxOption, "Hills")
        .click();
    window.press(CTRL_SHIFT, Key::G);
    window.until("the histogram", |w| {
        w.harness.query_by_label_contains(" samples, ").is_some()
    });
    window
        .harness
        .get_by_label("Histogram of the selected layer");
}

#[test]
fn the_graph_names_every_node_and_what_it_made() {
    let mut window = Window::open(&PROJECT.replacen(
        "\"id\": \"high\"",
        "\"visible\": false, \"id\": \"high\"",
        1,
    ));
    window.press(CTRL_SHIFT, Key::N);
    window.until("tiles of the noise", |w| {
        let nodes = w.harness.query_all_by_label_contains(", Hills, ");
        let mut texts = nodes.filter_map(|n| n.accesskit_node().value());
        texts.any(|text| text.contains(" tiles, "))
    });
    window.harness.get_by_label("High tint (hidden)");
}
