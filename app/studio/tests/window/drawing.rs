//! Planning elements drawn on the terrain, and what belongs to them: bookmarks, scenarios.

use eframe::egui::accesskit::Role;
use eframe::egui::{Key, Modifiers, vec2};
use egui_kittest::kittest::Queryable;
use relievo_engine::project::{Element, ElementKind, SurfaceKind, Vertex};

use crate::shared::{PLAIN, Window};

impl Window {
    /// Draws a triangle around the middle and closes it.
    fn draw_triangle(&mut self) {
        self.press(Modifiers::NONE, Key::P);
        for (x, y) in [(-0.2, 0.1), (0.2, 0.1), (0.0, -0.2)] {
            let at = self.at(x, y);
            self.click_at(at);
        }
        self.press(Modifiers::NONE, Key::Enter);
    }

    fn elements(&self) -> Vec<&Element> {
        let project = self.harness.state().document().project();
        project.elements.iter().map(|e| &**e).collect()
    }

    fn outline(&self) -> Vec<Vertex> {
        self.elements()[0].vertex_lists()[0].as_slice().to_vec()
    }
}

#[test]
fn a_polygon_is_drawn_dragged_undone_saved_and_opened_again() {
    let mut window = Window::open(PLAIN);
    window.draw_triangle();
    let drawn = window.outline();
    assert_eq!(drawn.len(), 3);
    assert!(
        drawn[0].lon_deg < 10.0 && drawn[0].lat_deg < 45.0 && drawn[2].lat_deg > 45.0,
        "{drawn:?}"
    );
    let ElementKind::Polygon(polygon) = &window.elements()[0].kind else {
        panic!("expected a polygon")
    };
    assert!(matches!(polygon.surface.kind, SurfaceKind::Platform { .. }));
    assert_eq!(
        window.harness.state().selected_element().unwrap().id.0,
        "platform-1"
    );
    // One drag is one step.
    let (from, to) = (window.at(0.0, -0.2), window.at(0.1, -0.3));
    window.drag(from, to);
    let moved = window.outline();
    assert!(
        moved[2].lon_deg > drawn[2].lon_deg + 0.01 && moved[2].lat_deg > drawn[2].lat_deg + 0.01
    );
    assert_eq!(moved[..2], drawn[..2]);
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(window.outline(), drawn);
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert_eq!(window.outline(), moved);
    window.press(Modifiers::COMMAND, Key::S);
    let window = window.again();
    assert_eq!(window.outline(), moved);
    assert_eq!(window.elements()[0].name, "Platform 1");
}

#[test]
fn a_click_counts_however_long_the_frame_in_it_takes() {
    let mut window = Window::open(PLAIN);
    window.press(Modifiers::NONE, Key::P);
    for (x, y) in [(-0.2, 0.1), (0.2, 0.1), (0.0, -0.2)] {
        let at = window.at(x, y);
        window.harness.hover_at(at);
        window.harness.run_steps(1);
        window.harness.drag_at(at);
        // A quarter of a second each.
        window.harness.run_steps(8);
        window.harness.drop_at(at);
        window.harness.run_steps(4);
    }
    window.press(Modifiers::NONE, Key::Enter);
    assert_eq!(window.outline().len(), 3);
}

#[test]
fn a_click_counts_where_it_was_and_not_where_the_pointer_went_in_the_same_frame() {
    let mut window = Window::open(PLAIN);
    // Places come from the ground that is there, which gets finer until then.
    window.until("the whole picture", |w| {
        w.harness.query_by_label("complete").is_some()
    });
    window.draw_triangle();
    let drawn = window.outline();
    window.press(Modifiers::COMMAND, Key::Z);
    window.press(Modifiers::NONE, Key::P);
    for (x, y) in [(-0.2, 0.1), (0.2, 0.1), (0.0, -0.2)] {
        let at = window.at(x, y);
        window.harness.hover_at(at);
        window.harness.drag_at(at);
        window.harness.drop_at(at);
        window.harness.hover_at(at + vec2(70.0, 30.0));
        window.harness.run_steps(4);
    }
    window.press(Modifiers::NONE, Key::Enter);
    assert_eq!(window.outline(), drawn);
}

#[test]
fn backspace_takes_the_last_vertex_back_and_escape_everything() {
    let mut window = Window::open(PLAIN);
    window.press(Modifiers::NONE, Key::P);
    for (x, y) in [(-0.2, 0.1), (0.2, 0.1), (0.3, 0.3), (0.0, -0.2)] {
        let at = window.at(x, y);
        window.click_at(at);
        if (x, y) == (0.3, 0.3) {
            window.press(Modifiers::NONE, Key::Backspace);
        }
    }
    window.press(Modifiers::NONE, Key::Enter);
    assert_eq!(window.outline().len(), 3);
    window.press(Modifiers::NONE, Key::P);
    let at = window.at(0.3, 0.3);
    window.click_at(at);
    window.press(Modifiers::NONE, Key::Escape);
    window.press(Modifiers::NONE, Key::Enter);
    assert_eq!(window.elements().len(), 1);
}

#[test]
fn a_click_on_the_first_vertex_closes_and_vertices_snap() {
    let mut window = Window::open(PLAIN);
    window.draw_triangle();
    let corner = window.outline()[1];
    window.press(Modifiers::NONE, Key::P);
    let near = window.at(0.2, 0.1) + vec2(4.0, -3.0);
    for at in [near, window.at(0.4, 0.1), window.at(0.4, 0.3)] {
        window.click_at(at);
    }
    let first = window.at(0.2, 0.1);
    window.click_at(first);
    assert_eq!(window.elements().len(), 2);
    let outline = window.elements()[1].vertex_lists()[0].as_slice().to_vec();
    assert_eq!(outline.len(), 3);
    assert!(
        (outline[0].lon_deg - corner.lon_deg).abs() < 1e-9,
        "{outline:?}"
    );
    assert!((outline[0].lat_deg - corner.lat_deg).abs() < 1e-9);
}

#[test]
fn a_vertex_is_inserted_at_the_middle_of_an_edge_and_deleted() {
    let mut window = Window::open(PLAIN);
    window.draw_triangle();
    let (from, to) = (window.at(0.0, 0.1), window.at(0.0, 0.3));
    window.drag(from, to);
    assert_eq!(window.outline().len(), 4);
    window.press(Modifiers::NONE, Key::Delete);
    assert_eq!(window.outline().len(), 3);
    assert_eq!(window.elements().len(), 1);
    // Without a chosen vertex Delete means the element.
    window.press(Modifiers::NONE, Key::Delete);
    assert!(window.elements().is_empty());
}

#[test]
fn coordinates_and_surfaces_are_typed_in_the_inspector() {
    let mut window = Window::open(PLAIN);
    window.draw_triangle();
    window.harness.get_by_label("Insert after vertex 1").click();
    window.steps();
    assert_eq!(window.outline().len(), 4);
    window.harness.get_by_label("Remove vertex 2").click();
    window.steps();
    assert_eq!(window.outline().len(), 3);
    window
        .harness
        .get_by_role_and_label(Role::Slider, "Height")
        .set_value_accesskit(250.0);
    window.steps();
    let ElementKind::Polygon(polygon) = &window.elements()[0].kind else {
        panic!("expected a polygon")
    };
    assert_eq!(
        polygon.surface.kind,
        SurfaceKind::Platform { height_m: 250.0 }
    );
}

#[test]
fn a_corridor_and_a_stroke_are_drawn_and_reordered_by_keys() {
    let mut window = Window::open(PLAIN);
    window.press(Modifiers::NONE, Key::C);
    for x in [-0.3, 0.0, 0.3] {
        let at = window.at(x, 0.2);
        window.click_at(at);
    }
    window.press(Modifiers::NONE, Key::Enter);
    window.press(Modifiers::NONE, Key::B);
    let (from, to) = (window.at(-0.2, -0.1), window.at(0.2, -0.1));
    window.drag(from, to);
    let names = |w: &Window| {
        w.elements()
            .iter()
            .map(|e| e.id.0.clone())
            .collect::<Vec<_>>()
    };
    assert_eq!(names(&window), ["road-1", "brush-1"]);
    assert_eq!(window.undo_label().as_deref(), Some("Add Brush 1"));
    let ElementKind::Brush(brush) = &window.elements()[1].kind else {
        panic!("expected a brush")
    };
    assert!(brush.strokes[0].points.as_slice().len() > 2);
    window.press(Modifiers::NONE, Key::Escape);
    window.press(Modifiers::ALT, Key::ArrowDown);
    assert_eq!(names(&window), ["brush-1", "road-1"]);
    window.press(Modifiers::COMMAND, Key::H);
    assert!(!window.elements()[0].visible);
}

#[test]
fn a_click_on_the_terrain_selects_what_is_there() {
    let mut window = Window::open(PLAIN);
    window.draw_triangle();
    let beside = window.at(0.4, 0.4);
    window.click_at(beside);
    assert!(window.harness.state().selected_element().is_none());
    let inside = window.at(0.0, 0.0);
    window.click_at(inside);
    assert_eq!(
        window.harness.state().selected_element().unwrap().id.0,
        "platform-1"
    );
}

#[test]
fn bookmarks_are_kept_named_flown_to_and_removed() {
    let mut window = Window::open(PLAIN);
    window.press(Modifiers::COMMAND, Key::D);
    let bookmarks = |w: &Window| w.harness.state().document().project().bookmarks.clone();
    assert_eq!(bookmarks(&window).len(), 1);
    let kept = bookmarks(&window)[0].camera.clone();
    assert!((kept.lon_deg - 10.0).abs() < 1e-9);
    window
        .harness
        .get_by_role_and_label(Role::TextInput, "Name of Bookmark 1")
        .focus();
    window.steps();
    window
        .harness
        .key_press_modifiers(Modifiers::COMMAND, Key::A);
    window
        .harness
        .get_by_role_and_label(Role::TextInput, "Name of Bookmark 1")
        .type_text("Valley");
    window.press(Modifiers::NONE, Key::Enter);
    assert_eq!(bookmarks(&window)[0].name, "Valley");
    let (from, to) = (window.at(0.0, 0.0), window.at(0.3, 0.0));
    window.drag(from, to);
    assert!(window.harness.state().camera().lon_rad.to_degrees() < 9.99);
    window.click("Go to Valley");
    window.until("the flight is over", |w| {
        (w.harness.state().camera().lon_rad.to_degrees() - 10.0).abs() < 1e-6
    });
    window.click("Remove Valley");
    assert!(bookmarks(&window).is_empty());
}

#[test]
fn a_scenario_is_added_changed_switched_and_merged() {
    let mut window = Window::open(PLAIN);
    window.draw_triangle();
    window.harness.get_by_label("Scenarios").click();
    window.steps();
    let buttons = window
        .harness
        .query_all_by_role_and_label(Role::Button, "Add");
    buttons.last().unwrap().click();
    window.steps();
    let project = |w: &Window| w.harness.state().document().project().clone();
    assert_eq!(project(&window).scenario.unwrap().0, "scenario-1");
    // What is drawn now is the scenario's alone.
    window.press(Modifiers::NONE, Key::C);
    for x in [-0.3, 0.3] {
        let at = window.at(x, 0.3);
        window.click_at(at);
    }
    window.press(Modifiers::NONE, Key::Enter);
    assert_eq!(window.elements().len(), 1, "the base is as it was");
    assert_eq!(project(&window).scenarios[0].changes.len(), 1);
    window.click("Show scenario Base");
    assert_eq!(project(&window).scenario, None);
    window.click("Show scenario Scenario 1");
    window.click("Merge");
    assert!(project(&window).scenarios.is_empty());
    assert_eq!(window.elements().len(), 2);
    for _ in 0..8 {
        window.press(Modifiers::COMMAND, Key::Z);
    }
    assert!(window.elements().is_empty() && project(&window).scenarios.is_empty());
}

#[test]
fn two_scenarios_are_compared_with_both_sides_labelled() {
    let mut window = Window::open(PLAIN);
    window.draw_triangle();
    window.harness.get_by_label("Scenarios").click();
    window.steps();
    let buttons = window
        .harness
        .query_all_by_role_and_label(Role::Button, "Add");
    buttons.last().unwrap().click();
    window.steps();
    window.click("Swipe");
    let sides = |w: &Window| {
        let there = |name: &str| w.harness.query_by_label(name).is_some();
        (there("Side of Scenario 1"), there("Side of Base"))
    };
    assert_eq!(sides(&window), (true, true));
    let line = window
        .harness
        .get_by_label("Line between both scenarios")
        .rect();
    assert!((line.center().x - window.view().center().x).abs() < 1.0);
    let (from, to) = (
        line.center() + vec2(0.0, 60.0),
        line.center() + vec2(100.0, 60.0),
    );
    let before = *window.harness.state().camera();
    window.drag(from, to);
    let line = window
        .harness
        .get_by_label("Line between both scenarios")
        .rect();
    assert!((line.center().x - to.x).abs() < 12.0, "{line:?}");
    assert_eq!(
        *window.harness.state().camera(),
        before,
        "the line is dragged, not the ground"
    );
    window.click("Side by side");
    assert_eq!(sides(&window), (true, true));
    window.click("Hold X");
    assert_eq!(sides(&window), (true, false));
    window.harness.key_down(Key::X);
    window.steps();
    assert_eq!(sides(&window), (false, true));
    window.harness.key_up(Key::X);
    window.steps();
    window.click("Difference");
    window.until("the difference", |w| {
        w.harness
            .query_by_label_contains("Height of Scenario 1 less Base: up to 0.0 m")
            .is_some()
    });
    window.click("Stop");
    assert_eq!(sides(&window), (false, false));
}

#[test]
fn lengths_and_areas_are_measured_along_geodesics() {
    let mut window = Window::open(PLAIN);
    window.press(Modifiers::NONE, Key::M);
    for (x, y) in [(-0.2, 0.0), (0.2, 0.0)] {
        let at = window.at(x, y);
        window.click_at(at);
    }
    let measured = window.harness.state().measured().unwrap();
    // 0.4 of the picture's height at 60° from 20 km: 0.4 · 2 · tan 30° · 20 km, on the ellipsoid a bit
    // more than on the ball.
    let way_m: f64 = measured.trim_end_matches(" m").parse().unwrap();
    assert!((way_m / 9237.6 - 1.0).abs() < 0.01, "{measured}");
    let at = window.at(0.0, 0.3);
    window.click_at(at);
    let measured = window.harness.state().measured().unwrap();
    assert!(
        measured.contains(", closed 3") && measured.ends_with("km²"),
        "{measured}"
    );
    window.press(Modifiers::NONE, Key::Escape);
    window.press(Modifiers::NONE, Key::Escape);
    assert!(window.harness.state().measured().is_none());
    assert!(window.elements().is_empty());
}

#[test]
fn a_place_is_found_by_its_name() {
    let mut window = Window::open(PLAIN);
    window.press(Modifiers::COMMAND, Key::G);
    window
        .harness
        .get_by_role_and_label(Role::TextInput, "Place")
        .focus();
    window.steps();
    window
        .harness
        .get_by_role_and_label(Role::TextInput, "Place")
        .type_text("reykjav");
    window.steps();
    let found = window.harness.get_by_label_contains("Reykjav");
    found.click();
    window.steps();
    window.until("the flight is over", |w| {
        w.harness.state().camera().lat_rad.to_degrees() > 64.0
    });
    assert!(!window.harness.state().document().is_changed());
}

#[test]
fn the_profile_follows_what_is_measured() {
    let mut window = Window::open(PLAIN);
    window.press(Modifiers::COMMAND | Modifiers::SHIFT, Key::F);
    window.harness.get_by_label_contains("Measure a way");
    window.press(Modifiers::NONE, Key::M);
    for x in [-0.2, 0.2] {
        let at = window.at(x, 0.0);
        window.click_at(at);
    }
    window.until("the profile", |w| {
        w.harness.query_by_label("Heights along the line").is_some()
    });
    window.harness.get_by_label_contains(" on the ground, ");
    window.click("Copy as CSV");
}

#[test]
fn a_hole_and_a_breakline_are_drawn_into_the_selected_polygon_edited_and_undone() {
    let mut window = Window::open(PLAIN);
    // Without a polygon there is nothing to draw a hole into.
    window.press(Modifiers::NONE, Key::H);
    let at = window.at(0.0, 0.0);
    window.click_at(at);
    window.draw_triangle();
    let whole = window.elements()[0].clone();
    window.press(Modifiers::NONE, Key::H);
    for (x, y) in [(-0.05, 0.05), (0.05, 0.05), (0.06, 0.06), (0.0, -0.03)] {
        let at = window.at(x, y);
        window.click_at(at);
        if (x, y) == (0.06, 0.06) {
            window.press(Modifiers::NONE, Key::Backspace);
        }
    }
    window.press(Modifiers::NONE, Key::Enter);
    let holes = |w: &Window| {
        let ElementKind::Polygon(polygon) = &w.elements()[0].kind else {
            panic!("expected a polygon")
        };
        polygon.holes.clone()
    };
    assert_eq!(holes(&window).len(), 1);
    assert_eq!(holes(&window)[0].as_slice().len(), 3);
    // Its vertices are dragged like any, as one step.
    let drawn = holes(&window);
    let (from, to) = (window.at(0.0, -0.03), window.at(0.02, -0.06));
    window.drag(from, to);
    assert!(holes(&window) != drawn);
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(holes(&window), drawn);
    // Breaklines are for surfaces through vertices.
    window.press(Modifiers::NONE, Key::K);
    let beside = window.at(-0.1, 0.08);
    window.click_at(beside);
    window.press(Modifiers::NONE, Key::Enter);
    assert_eq!(window.elements()[0].vertex_lists().len(), 2);
    let at = window.at(0.0, -0.1);
    window.click_at(at);
    window
        .harness
        .get_by_role_and_label(Role::ComboBox, "Surface")
        .click();
    window.steps();
    window.harness.get_by_label("Through vertices").click();
    window.steps();
    window.press(Modifiers::NONE, Key::K);
    for (x, y) in [(-0.1, 0.08), (0.1, 0.08)] {
        let at = window.at(x, y);
        window.click_at(at);
    }
    window.press(Modifiers::NONE, Key::Enter);
    assert_eq!(window.elements()[0].vertex_lists()[2].as_slice().len(), 2);
    // A vertex that cannot be spared takes its line with it, then its hole.
    window.press(Modifiers::NONE, Key::Delete);
    assert_eq!(window.elements()[0].vertex_lists().len(), 2);
    for _ in 0..4 {
        window.press(Modifiers::COMMAND, Key::Z);
    }
    assert_eq!(*window.elements()[0], whole);
}
