//! Quality in pixels of error or milliseconds a frame, as people ask for it.

use crate::shared::{PROJECT, Window};
use eframe::egui::accesskit::Role;
use eframe::egui::{Key, Modifiers};
use egui_kittest::kittest::{NodeT, Queryable};
use relievo_engine::project::{Aim, Quality};

impl Window {
    fn quality(&self) -> Quality {
        self.harness.state().document().project().quality.clone()
    }

    /// Chooses what decides.
    fn decide_by(&mut self, choice: &str) {
        self.harness
            .get_by_role_and_label(Role::ComboBox, "Decided by")
            .click();
        self.steps();
        self.harness
            .get_by_role_and_label(Role::Button, choice)
            .click();
        self.steps();
    }

    fn has_slider(&self, label: &str) -> bool {
        self.harness
            .query_by_role_and_label(Role::Slider, label)
            .is_some()
    }

    /// What the plot says to who cannot see it.
    fn trade(&self) -> String {
        let start = "Error on the screen against time a frame";
        let plot = self.harness.query_all_by_role(Role::Image);
        plot.filter_map(|node| node.accesskit_node().label())
            .find(|label| label.starts_with(start))
            .unwrap()
    }
}

fn scene() -> Window {
    let mut window = Window::open(PROJECT);
    window.harness.get_by_label("Scene").click();
    window.steps();
    window
}

#[test]
fn who_asks_for_pixels_of_error_gets_them_and_each_change_is_one_step_back() {
    let mut window = scene();
    assert!(window.has_slider("Texel size") && window.has_slider("Mesh"));
    assert!(window.trade().contains("About "), "{}", window.trade());
    window.decide_by("Pixels of error");
    assert_eq!(window.quality().aim, Aim::Error);
    assert!(window.has_slider("Error") && !window.has_slider("Mesh"));
    window
        .harness
        .get_by_role_and_label(Role::Slider, "Error")
        .set_value_accesskit(0.05);
    window.steps();
    assert_eq!(window.quality().error_px, 0.05);
    let fine = window.trade();
    window
        .harness
        .get_by_role_and_label(Role::Slider, "Error")
        .set_value_accesskit(20.0);
    window.steps();
    assert_ne!(window.trade(), fine);
    for _ in 0..2 {
        window.press(Modifiers::COMMAND, Key::Z);
    }
    assert_eq!(window.quality().error_px, 0.5);
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(window.quality(), Quality::default());
    assert_eq!(window.undo_label(), None);
    assert!(window.has_slider("Mesh"));
}

#[test]
fn milliseconds_a_frame_are_kept_in_the_file_and_driven_by_keys() {
    let mut window = scene();
    window.decide_by("Milliseconds a frame");
    window
        .harness
        .get_by_role_and_label(Role::Slider, "Frame time")
        .focus();
    window.steps();
    window.press(Modifiers::NONE, Key::ArrowRight);
    let quality = window.quality();
    assert_eq!(quality.aim, Aim::FrameTime);
    assert!(quality.frame_budget_ms > 16.0, "{quality:?}");
    // Without a device there is nothing to go by, and nothing breaks.
    assert!(window.trade().contains("no frame was measured yet"));
    window.press(Modifiers::COMMAND, Key::S);
    window.until("the saved file", |w| {
        let text = std::fs::read_to_string(&w.file).unwrap();
        text.contains("\"aim\": \"frame_time\"") && text.contains("\"frame_budget_ms\"")
    });
    let window = window.again();
    assert_eq!(window.quality(), quality);
}
