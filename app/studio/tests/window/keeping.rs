//! Work that is not saved: asked about when it would be lost, offered again after a crash.

use eframe::egui::accesskit::Role;
use eframe::egui::{Key, Modifiers, ViewportEvent, ViewportId};
use egui_kittest::kittest::Queryable;

use crate::shared::{PLAIN, Window};

impl Window {
    /// A window on an empty Earth.
    fn untitled() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("named.relievo");
        Self::start(folder, file, false)
    }

    /// The program ends without warning and is started again without a project.
    fn killed(self) -> Self {
        self.restarted(false)
    }

    fn add_noise(&mut self) {
        self.press(Modifiers::COMMAND, Key::P);
        self.harness
            .get_by_role_and_label(Role::TextInput, "Find a command")
            .type_text("add noise heights");
        self.steps();
        self.press(Modifiers::NONE, Key::Enter);
        assert!(self.harness.state().document().is_changed());
    }

    fn asks(&self, question: &str) -> bool {
        self.harness
            .query_all_by_label_contains(question)
            .next()
            .is_some()
    }

    /// The user closes the window.
    fn close(&mut self) {
        let viewports = &mut self.harness.input_mut().viewports;
        let info = viewports.entry(ViewportId::ROOT).or_default();
        info.events.push(ViewportEvent::Close);
        self.harness.run_steps(1);
        let viewports = &mut self.harness.input_mut().viewports;
        viewports
            .entry(ViewportId::ROOT)
            .or_default()
            .events
            .clear();
        self.steps();
    }
}

#[test]
fn closing_an_untitled_project_with_changes_asks_to_save_them() {
    let mut window = Window::untitled();
    window.close();
    assert!(!window.asks("Save changes"), "nothing would be lost");
    window.add_noise();
    window.close();
    assert!(window.asks("Save changes to Untitled?"));
    window.click("Save");
    let path = window.file.clone();
    window.type_path(&path);
    window.until("the file", |w| w.file.is_file());
    assert!(!window.harness.state().document().is_changed());
    // Nothing of it is left to be offered.
    let mut window = window.killed();
    window.harness.run_steps(20);
    assert!(!window.asks("Recover"));
}

#[test]
fn starting_anew_over_an_untitled_project_asks_too() {
    let mut window = Window::untitled();
    window.add_noise();
    window.press(Modifiers::COMMAND, Key::N);
    assert!(window.asks("Save changes to Untitled?"));
    window.click("Don't save");
    assert!(window.layers().is_empty());
    let mut window = window.killed();
    window.harness.run_steps(20);
    assert!(!window.asks("Recover"), "it was not wanted");
}

#[test]
fn an_untitled_project_is_offered_again_after_a_kill_until_somebody_decides() {
    let mut window = Window::untitled();
    window.add_noise();
    window.press(Modifiers::COMMAND, Key::H);
    assert!(!window.layers()[0].visible);
    let mut window = window.killed();
    window.until("the offer", |w| w.asks("Recover unsaved work on Untitled?"));
    assert!(window.asks("2 edits were"));
    window.click("Decide later");
    assert!(window.layers().is_empty());
    let mut window = window.killed();
    window.until("the offer", |w| w.asks("Recover unsaved work"));
    window.click("Recover");
    assert!(!window.layers()[0].visible && window.harness.state().document().is_changed());
    // It is guarded on: killed once more it is offered once more.
    let mut window = window.killed();
    window.until("the offer", |w| w.asks("2 edits were"));
    window.click("Throw away");
    let mut window = window.killed();
    window.harness.run_steps(20);
    assert!(!window.asks("Recover"));
}

#[test]
fn an_offer_that_is_left_for_later_is_there_again_whatever_is_done_meanwhile() {
    let mut window = Window::open(PLAIN);
    window.press(Modifiers::COMMAND, Key::H);
    let mut window = window.restarted(true);
    window.until("the offer", |w| w.asks("Recover unsaved work on sample?"));
    window.click("Decide later");
    // Something else is done and given up with the window.
    window.press(Modifiers::COMMAND, Key::D);
    window.end();
    let window = window.restarted(true);
    assert!(window.asks("Recover unsaved work on sample?") && window.asks("1 edit was"));
}
