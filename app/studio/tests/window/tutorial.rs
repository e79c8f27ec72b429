//! The steps of `docs/guide/tutorial.md`, in its order, in a window that draws.
//!
//! With the environment variable `RELIEVO_PICTURES` set to a folder, the pictures of the guide are
//! written there.

use std::path::PathBuf;

use eframe::egui::accesskit::Role;
use eframe::egui::{Key, Modifiers, Pos2};
use egui_kittest::kittest::Queryable;
use image::DynamicImage;
use image::codecs::jpeg::JpegEncoder;
use relievo_engine::project::{Element, ElementKind, Project, SurfaceKind};

use crate::shared::{Window, sample};

/// A tour through the window that leaves pictures behind where they are asked for.
struct Tour {
    window: Window,
    pictures: Option<PathBuf>,
}

impl Tour {
    fn start() -> Self {
        let (folder, file) = sample();
        Self {
            window: Window::open_drawn(folder, file),
            pictures: std::env::var_os("RELIEVO_PICTURES").map(PathBuf::from),
        }
    }

    /// Waits until the flight is over and every visible tile is drawn.
    fn settle(&mut self) {
        let (mut camera, mut rested) = (None, 0);
        for _ in 0..2_000 {
            self.window.harness.run_steps(1);
            let now = *self.window.harness.state().camera();
            let rests = camera.replace(now) == Some(now);
            // A flight begins a step or two after what asks for it.
            rested = if rests { rested + 1 } else { 0 };
            if rested > 3 && self.window.harness.query_by_label("complete").is_some() {
                return;
            }
        }
        panic!("the picture never was complete");
    }

    /// What the window shows, as a picture of the guide.
    fn picture(&mut self, name: &str) {
        self.settle();
        // Tooltips belong to whoever points.
        self.window.harness.remove_cursor();
        self.window.steps();
        let picture = self.window.harness.render().unwrap();
        let colours: std::collections::HashSet<_> = picture.pixels().map(|p| p.0).collect();
        assert!(
            colours.len() > 1000,
            "{name} shows {} colours",
            colours.len()
        );
        if let Some(folder) = &self.pictures {
            std::fs::create_dir_all(folder).unwrap();
            let mut file = std::fs::File::create(folder.join(name)).unwrap();
            let colours = DynamicImage::ImageRgba8(picture).to_rgb8();
            JpegEncoder::new_with_quality(&mut file, 88)
                .encode_image(&colours)
                .unwrap();
        }
    }

    fn type_into(&mut self, field: &str, text: &str) {
        let role = Role::TextInput;
        self.window
            .harness
            .get_by_role_and_label(role, field)
            .focus();
        self.window.steps();
        self.window
            .harness
            .get_by_role_and_label(role, field)
            .type_text(text);
        self.window.steps();
    }

    /// Types into a field for a number, which becomes one for text while it has the focus.
    fn set(&mut self, field: &str, value: f64) {
        self.window
            .harness
            .get_by_role_and_label(Role::SpinButton, field)
            .set_value_accesskit(value);
        self.window.steps();
    }

    /// Clicks at points of the view, in shares of its width and height from the top left.
    fn click_view(&mut self, places: &[(f32, f32)]) {
        for &(x, y) in places {
            let at = self.in_view(x, y);
            self.window.click_at(at);
        }
    }

    fn in_view(&self, x: f32, y: f32) -> Pos2 {
        self.window.view().lerp_inside([x, y])
    }

    fn project(&self) -> &Project {
        self.window.harness.state().document().project()
    }

    /// What the shown scenario holds.
    fn selected(&self) -> Element {
        let state = self.window.harness.state();
        (*state.selected_element().unwrap()).clone()
    }
}

fn platform_height_m(element: &Element) -> f64 {
    let ElementKind::Polygon(polygon) = &element.kind else {
        panic!("expected a polygon");
    };
    let SurfaceKind::Platform { height_m } = polygon.surface.kind else {
        panic!("expected a platform");
    };
    height_m
}

#[test]
fn the_tutorial_leads_from_the_sample_to_two_scenarios_and_their_difference() {
    let mut tour = Tour::start();
    tour.picture("1-start.jpg");

    // A place by its name, then a view of the slope above it.
    tour.window.press(Modifiers::COMMAND, Key::G);
    tour.type_into("Place", "Salt Lake");
    tour.window.press(Modifiers::NONE, Key::Enter);
    tour.settle();
    let camera = *tour.window.harness.state().camera();
    assert!(
        (camera.lat_rad.to_degrees() - 40.8).abs() < 0.1,
        "{camera:?}"
    );
    tour.window.press(Modifiers::COMMAND, Key::G);
    for (field, value) in [
        ("Longitude", -111.646),
        ("Latitude", 40.253),
        ("Altitude", 2250.0),
        ("Heading", 50.0),
        ("Pitch", -24.0),
    ] {
        tour.set(field, value);
    }
    tour.window.click("Go");
    tour.picture("2-above-provo.jpg");

    // A platform on the slope.
    tour.window.press(Modifiers::NONE, Key::P);
    tour.click_view(&[(0.42, 0.55), (0.60, 0.55), (0.64, 0.68), (0.40, 0.68)]);
    tour.picture("3-drawing.jpg");
    tour.window.press(Modifiers::NONE, Key::Enter);
    tour.settle();
    let first_m = platform_height_m(&tour.selected());
    assert!((1400.0..1700.0).contains(&first_m), "{first_m} m");
    tour.picture("4-platform.jpg");

    // A road that leads up to it.
    tour.window.press(Modifiers::NONE, Key::C);
    tour.click_view(&[(0.15, 0.9), (0.3, 0.78), (0.42, 0.66)]);
    tour.window.press(Modifiers::NONE, Key::Enter);
    assert_eq!(tour.project().elements.len(), 2);
    tour.picture("5-road.jpg");

    // Another scenario, with the platform ten metres lower.
    tour.window.harness.get_by_label("Scenarios").click();
    tour.window.steps();
    let buttons = tour
        .window
        .harness
        .query_all_by_role_and_label(Role::Button, "Add");
    buttons.last().unwrap().click();
    tour.window.steps();
    tour.click_view(&[(0.52, 0.62)]);
    let slider = tour
        .window
        .harness
        .get_by_role_and_label(Role::Slider, "Height");
    slider.set_value_accesskit((first_m - 10.0).round());
    tour.window.steps();
    assert_eq!(
        platform_height_m(&tour.selected()),
        (first_m - 10.0).round()
    );
    let base = platform_height_m(&tour.project().elements[0]);
    assert_eq!(base, first_m, "the base is as it was");

    // Side by side and as a difference.
    tour.window.click("Swipe");
    tour.picture("6-swipe.jpg");
    tour.window.click("Difference");
    tour.window.until("the difference", |w| {
        w.harness
            .query_by_label_contains("Height of Scenario 1 less Base")
            .is_some()
    });
    tour.picture("7-difference.jpg");
    tour.window.click("Stop");

    // Saved, and the same when it is opened again.
    tour.window.press(Modifiers::COMMAND, Key::S);
    assert!(!tour.window.harness.state().document().is_changed());
    let saved = tour.project().clone();
    let again = tour.window.again();
    assert_eq!(again.harness.state().document().project(), &saved);
}
