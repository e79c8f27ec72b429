//! Lenses on the terrain: put, drawn, shaped, dragged, shared.

use eframe::egui::accesskit::Role;
use eframe::egui::{CursorIcon, Event, Key, Modifiers, Pos2};
use egui_kittest::kittest::Queryable;
use relievo_engine::project::{Lens, LensShape};

use super::shared::Window;

/// A tint over noise from 20 km straight above, and what stands in the upper tint's layer.
fn tints(of_low: &str, of_high: &str) -> String {
    let stops = r##""stops": [{"height_m": -900.0, "colour": "#203050"}, {"height_m": 900.0, "colour": "#a0a060"}]"##;
    format!(
        r#"{{"version": 1, "camera": {{"lon_deg": 10.0, "lat_deg": 45.0, "altitude_m": 20000.0}}, "layers": [
        {{"id": "hills", "name": "Hills", "kind": "noise", "amplitude_m": 1.0, "wavelength_m": 500000.0, "octaves": 3}},
        {{"id": "low", "name": "Low tint", "kind": "tint", {of_low} {stops}}},
        {{"id": "high", "name": "High tint", "kind": "tint", {of_high} {stops}}}]}}"#
    )
}

/// A mask in a square of 6 km.
const SQUARE: &str = r#""mask": {"polygon": {"lon_deg": 10.0, "lat_deg": 45.0,
    "corners_m": [[-3000, -3000], [3000, -3000], [3000, 3000], [-3000, 3000]]}},"#;

impl Window {
    fn lens_of(&self, id: &str) -> Option<Lens> {
        let layer = self.layers().iter().find(|l| l.id.0 == id).unwrap();
        layer.mask.as_ref().and_then(|m| m.lens.clone())
    }

    fn lens(&self) -> Lens {
        self.lens_of("high").unwrap()
    }

    fn corners(&self) -> Vec<[f64; 2]> {
        let LensShape::Polygon { corners_m } = self.lens().shape else {
            panic!("expected a polygon, found a circle");
        };
        corners_m
    }

    /// On a project whose picture is complete: places come from the ground that is there.
    fn complete(text: &str) -> Self {
        let mut window = Self::open(text);
        window.until("the whole picture", |w| {
            w.harness.query_by_label("complete").is_some()
        });
        window
    }

    /// Where a place so many metres from the middle of the view is, once `metres` is what a share of the
    /// view's height is on the ground.
    fn metres_at(&self, metres: f64, east_m: f64, north_m: f64) -> Pos2 {
        self.at((east_m / metres) as f32, (-north_m / metres) as f32)
    }

    /// Draws a square with the tool and returns how many metres the view is high.
    fn draw_square(&mut self) -> f64 {
        self.harness.get_by_label("Mask").click();
        self.steps();
        // It may lie below what the pane shows.
        self.harness
            .get_by_role_and_label(Role::Button, "Draw…")
            .click_accesskit();
        self.steps();
        for (x, y) in [(-0.2, 0.2), (0.2, 0.2), (0.2, -0.2), (-0.2, -0.2)] {
            let at = self.at(x, y);
            self.click_at(at);
        }
        self.press(Modifiers::NONE, Key::Enter);
        let corners_m = self.corners();
        (corners_m[1][0] - corners_m[0][0]) / 0.4
    }

    fn cursor(&mut self, at: Pos2) -> CursorIcon {
        self.harness.hover_at(at);
        self.steps();
        self.harness.output().platform_output.cursor_icon
    }
}

fn miss_m(corner: [f64; 2], east_m: f64, north_m: f64) -> f64 {
    (corner[0] - east_m).hypot(corner[1] - north_m)
}

#[test]
fn a_lens_is_put_on_a_layer_and_dragged_over_the_terrain_as_one_step() {
    let mut window = Window::open(&tints("", ""));
    let radius_m = |lens: &Lens| match lens.shape {
        LensShape::Circle { radius_m } => radius_m,
        LensShape::Polygon { .. } => panic!("expected a circle, found a polygon"),
    };
    window.press(Modifiers::NONE, Key::X);
    window.drag(window.at(0.0, 0.0), window.at(0.2, 0.1));
    let first = window.lens();
    assert!(
        radius_m(&first) > 100.0 && first.lon_deg > 10.0,
        "{first:?}"
    );
    window.drag(window.at(0.0, 0.0), window.at(-0.2, 0.1));
    let second = window.lens();
    assert!(second.lon_deg < 10.0 && second.lat_deg < 45.0, "{second:?}");
    assert_eq!(radius_m(&second), radius_m(&first));
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(window.lens_of("high"), Some(first));
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(window.lens_of("high"), None);
    window.press(Modifiers::NONE, Key::Escape);
    let before = *window.harness.state().camera();
    window.drag(window.at(0.0, 0.0), window.at(0.2, 0.1));
    let after = *window.harness.state().camera();
    assert_ne!(after, before, "the ground moves again");
    assert_eq!(window.lens_of("high"), None);
}

#[test]
fn a_lens_is_drawn_corner_by_corner_shaped_moved_and_all_of_it_is_undone() {
    let mut window = Window::complete(&tints("", ""));
    let metres = window.draw_square();
    let drawn = window.lens();
    assert!((drawn.lon_deg - 10.0).abs() < 1e-3 && (drawn.lat_deg - 45.0).abs() < 1e-3);
    let side_m = 0.4 * metres;
    let half_m = 0.2 * metres;
    let square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    for (corner, (x, y)) in window.corners().iter().zip(square) {
        let miss_m = miss_m(*corner, x * half_m, y * half_m);
        assert!(miss_m < 0.02 * side_m, "{corner:?}");
    }
    // The tool that moves it is chosen; the handle in the middle of an edge becomes a corner.
    let (from, to) = (window.at(0.0, 0.2), window.at(0.05, 0.3));
    window.drag(from, to);
    let corners_m = window.corners();
    assert_eq!(corners_m.len(), 5);
    let miss = miss_m(corners_m[1], 0.05 * metres, -0.3 * metres);
    assert!(miss < 0.02 * side_m, "{corners_m:?}");
    // A corner.
    let (from, to) = (window.at(-0.2, 0.2), window.at(-0.3, 0.25));
    window.drag(from, to);
    let shaped = window.lens();
    let corners_m = window.corners();
    assert!(miss_m(corners_m[0], -0.3 * metres, -0.25 * metres) < 0.02 * side_m);
    assert_eq!(
        (shaped.lon_deg, shaped.lat_deg),
        (drawn.lon_deg, drawn.lat_deg)
    );
    // Anywhere else it moves by the pointer's way and keeps its shape.
    let (from, to) = (window.at(0.1, -0.1), window.at(0.2, -0.15));
    window.drag(from, to);
    let moved = window.lens();
    assert_eq!(moved.shape, shaped.shape);
    let east_m =
        (moved.lon_deg - shaped.lon_deg).to_radians() * 6.378e6 * 45.0_f64.to_radians().cos();
    let north_m = (moved.lat_deg - shaped.lat_deg).to_radians() * 6.367e6;
    let miss = miss_m([east_m, north_m], 0.1 * metres, 0.05 * metres);
    assert!(miss < 0.02 * side_m, "{east_m} {north_m} of {metres}");
    // Far outside, a click brings its centre.
    let at = window.at(-0.38, 0.44);
    window.click_at(at);
    assert!(
        window.lens().lon_deg < 9.95 && window.lens().lat_deg < 44.95,
        "{:?}",
        window.lens()
    );
    let mut steps = Vec::new();
    for _ in 0..5 {
        window.press(Modifiers::COMMAND, Key::Z);
        steps.push(window.lens_of("high"));
    }
    assert_eq!(steps[0], Some(moved));
    assert_eq!(steps[1], Some(shaped));
    assert_eq!(steps[3], Some(drawn));
    assert_eq!(steps[4], None);
    assert_eq!(window.undo_label(), None);
}

#[test]
fn delete_and_backspace_take_corners_away_down_to_three_and_never_the_layer() {
    let mut window = Window::complete(&tints("", ""));
    window.draw_square();
    // A click on a small handle adds a corner, which is then the chosen one.
    let at = window.at(0.0, -0.2);
    window.click_at(at);
    assert_eq!(window.corners().len(), 5);
    let added = window.corners()[3];
    window.press(Modifiers::NONE, Key::Delete);
    assert_eq!(window.corners().len(), 4);
    assert!(!window.corners().contains(&added));
    window.press(Modifiers::NONE, Key::Backspace);
    assert_eq!(window.corners().len(), 3);
    let left = window.lens();
    for key in [Key::Delete, Key::Backspace, Key::Delete] {
        window.press(Modifiers::NONE, key);
    }
    assert_eq!(window.lens(), left);
    assert_eq!(window.order(), ["hills", "low", "high"]);
    for _ in 0..2 {
        window.press(Modifiers::COMMAND, Key::Z);
    }
    assert_eq!(window.corners().len(), 5);
}

#[test]
fn the_pointer_shows_what_a_press_would_take_and_ctrl_moves_the_ground() {
    let mut window = Window::complete(&tints("", ""));
    let metres = window.draw_square();
    for ((east, north), cursor) in [
        ((0.2, 0.2), CursorIcon::Grab),
        ((0.2, 0.0), CursorIcon::Copy),
        ((0.1, 0.05), CursorIcon::Move),
        ((-0.25, 0.0), CursorIcon::Move),
        ((0.38, -0.44), CursorIcon::Crosshair),
    ] {
        let at = window.metres_at(metres, east * metres, north * metres);
        assert_eq!(window.cursor(at), cursor, "{east} {north}");
    }
    let (lens, camera) = (window.lens(), *window.harness.state().camera());
    let (from, to) = (window.at(0.0, 0.05), window.at(0.2, 0.1));
    window
        .harness
        .event(Event::ModifiersChanged(Modifiers::COMMAND));
    window.drag(from, to);
    assert_eq!(window.lens(), lens);
    assert_ne!(*window.harness.state().camera(), camera);
}

#[test]
fn escape_takes_a_drag_back_and_then_ends_the_tool() {
    let mut window = Window::complete(&tints("", SQUARE));
    let before = window.lens();
    window.press(Modifiers::NONE, Key::X);
    let (from, to) = (window.at(0.0, 0.02), window.at(0.2, 0.1));
    window.harness.hover_at(from);
    window.harness.run_steps(1);
    window.harness.drag_at(from);
    window.harness.run_steps(1);
    for at in [from + (to - from) * 0.5, to] {
        window.harness.hover_at(at);
        window.harness.run_steps(1);
    }
    window.steps();
    assert_ne!(window.lens(), before);
    window.press(Modifiers::NONE, Key::Escape);
    assert_eq!(window.lens(), before);
    window.harness.drop_at(to);
    window.steps();
    assert_eq!((window.lens(), window.undo_label()), (before.clone(), None));
    // The tool is still there; now it ends.
    window.drag(from, to);
    assert_ne!(window.lens(), before);
    window.press(Modifiers::COMMAND, Key::Z);
    window.press(Modifiers::NONE, Key::Escape);
    window.drag(from, to);
    assert_eq!(window.lens(), before);
}

#[test]
fn a_circle_becomes_a_hexagon_of_its_area_in_the_inspector_and_layers_go_on_sharing_it() {
    let circle = r#""mask": {"circle": {"lon_deg": 10.0, "lat_deg": 45.0, "radius_m": 2500.0, "fade_m": 30.0}},"#;
    let mut window = Window::complete(&tints(circle, circle));
    let before = window.lens();
    let choose = |window: &mut Window, from: &str, to: &str| {
        assert!(
            window.harness.query_all_by_value(from).next().is_some(),
            "{from} is shown"
        );
        window
            .harness
            .get_by_role_and_label(Role::ComboBox, "Shape")
            .click_accesskit();
        window.steps();
        // A tool has the same name; the list is in front.
        let buttons = window.harness.get_all_by_role_and_label(Role::Button, to);
        buttons.last().unwrap().click();
        window.steps();
    };
    choose(&mut window, "Circle", "Polygon");
    assert_eq!(window.corners().len(), 6);
    assert!(
        window
            .harness
            .query_by_label_contains("6, 19.63 km² inside")
            .is_some()
    );
    assert_eq!(window.lens_of("low"), window.lens_of("high"));
    window.press(Modifiers::NONE, Key::X);
    let (from, to) = (window.at(0.0, 0.02), window.at(0.1, 0.1));
    window.drag(from, to);
    assert_ne!(window.lens().lon_deg, 10.0);
    assert_eq!(window.lens_of("low"), window.lens_of("high"));
    window.press(Modifiers::COMMAND, Key::Z);
    choose(&mut window, "Polygon", "Circle");
    assert_eq!(window.lens(), before);
    assert_eq!(window.lens_of("low"), window.lens_of("high"));
}

#[test]
fn a_locked_layers_lens_stays_where_it_is_while_others_that_share_it_move() {
    let locked = format!("{SQUARE} \"locked\": true,");
    let mut window = Window::complete(&tints(&locked, SQUARE));
    let before = window.lens();
    window.press(Modifiers::NONE, Key::X);
    let (from, to) = (window.at(0.0, 0.02), window.at(0.1, 0.1));
    window.drag(from, to);
    assert_eq!(window.lens_of("low").as_ref(), Some(&before));
    assert_ne!(window.lens(), before);
    // The tool is not offered for the locked one.
    let mut window = Window::complete(&tints(SQUARE, &locked));
    window.press(Modifiers::NONE, Key::X);
    window.drag(from, to);
    assert_eq!(window.lens(), before);
    assert_eq!(window.undo_label(), None);
}
