//! Drawing something new: vertex by vertex, until it is closed.

use std::sync::Arc;

use eframe::egui::{Key, PointerButton, Pos2, Rect, Response, Ui};
use relievo_engine::project::{
    Corridor, Edit, Element, ElementKind, LensShape, Polygon, ProfileKind, SectionKind,
    SurfaceKind, Vertex,
};

use super::view::{self, Projector};
use super::{Spot, Tool, snap};
use crate::window::action::Action;
use crate::window::studio::Studio;

/// Colours of new elements.
const AREA: [u8; 3] = [214, 164, 92];
const LINE: [u8; 3] = [120, 120, 126];

/// Width of a new road, metres, at least; more where the view is wide.
const ROAD_M: f64 = 8.0;

impl Studio {
    /// The main button and the keys of the tools that draw vertex by vertex.
    pub(in crate::window) fn draw_draft(
        &mut self,
        ui: &Ui,
        rect: Rect,
        response: &Response,
        actions: &mut Vec<Action>,
    ) {
        let free = ui.input(|i| i.modifiers.alt);
        let at = response.hover_pos().filter(|_| response.hovered());
        self.tools.next = at.and_then(|at| self.vertex_at(rect, at, free));
        let clicked = response.clicked_by(PointerButton::Primary);
        let double = response.double_clicked_by(PointerButton::Primary);
        if clicked
            && !double
            && let Some(at) = super::released_at(ui)
            && let Some(vertex) = self.vertex_at(rect, at, free)
        {
            let closes = self.tools.tool.is_ring()
                && self.tools.draft.len() >= super::least_vertices(true)
                && self.tools.draft.first() == Some(&vertex);
            if closes {
                self.close_draft(actions);
                return;
            }
            if self.tools.draft.last() != Some(&vertex) && self.has_room() {
                self.tools.draft.push(vertex);
            }
        }
        if ui.ctx().text_edit_focused() || self.dialog.is_some() {
            return;
        }
        let (enter, back, escape) = ui.input_mut(|i| {
            let mut pressed = |key| i.consume_key(eframe::egui::Modifiers::NONE, key);
            (
                pressed(Key::Enter),
                pressed(Key::Backspace),
                pressed(Key::Escape),
            )
        });
        if enter || double {
            self.close_draft(actions);
        } else if back {
            self.tools.draft.pop();
        } else if escape {
            // The first Esc gives up what was begun, the next one the tool.
            if self.tools.draft.is_empty() {
                self.tools.choose(Tool::Select);
            }
            self.tools.draft.clear();
        }
    }

    /// Whether what is drawn may have a vertex more.
    fn has_room(&self) -> bool {
        self.tools.tool != Tool::LensOutline || self.tools.draft.len() < LensShape::MOST_CORNERS
    }

    /// The vertex that a pointer means: one of an element or an edge if it is near, or the ground.
    pub(in crate::window) fn vertex_at(&self, rect: Rect, at: Pos2, free: bool) -> Option<Vertex> {
        let near = self.tools.draft.last();
        if !free && let Some(vertex) = self.snapped(rect, at) {
            return Some(view::vertex(view::place(&vertex), near));
        }
        let point = self.ground_point(rect, at)?;
        Some(view::vertex(point, near))
    }

    /// A vertex or a place on an edge of the draft or of a visible element near a pointer.
    fn snapped(&self, rect: Rect, at: Pos2) -> Option<Vertex> {
        let projector = Projector::new(self.document.engine(), self.camera(), rect);
        let mut best: Option<(bool, f32, Vertex)> = None;
        let mut look = |vertices: &[Vertex], is_ring: bool| {
            let points: Vec<Option<Pos2>> = vertices
                .iter()
                .map(|v| projector.screen(view::place(v)))
                .collect();
            let Some((near, distance)) = snap::near(&points, is_ring, at) else {
                return;
            };
            let (is_edge, vertex) = match near {
                snap::Near::Vertex(i) => (false, vertices[i]),
                snap::Near::Edge(i, share) => (
                    true,
                    between(&vertices[i], &vertices[(i + 1) % vertices.len()], share),
                ),
            };
            if best.is_none_or(|(edge, d, _)| (is_edge, distance) < (edge, d)) {
                best = Some((is_edge, distance, vertex));
            }
        };
        look(&self.tools.draft, false);
        for element in self.snap_targets() {
            let is_ring = matches!(element.kind, ElementKind::Polygon(_));
            for (index, list) in element.vertex_lists().into_iter().enumerate() {
                let own = self
                    .tools
                    .held
                    .as_ref()
                    .is_some_and(|held| held.element == element.id && held.spot.list == index);
                if !own {
                    look(list.as_slice(), is_ring);
                }
            }
        }
        best.map(|(.., vertex)| vertex)
    }

    /// Makes an element of what was drawn.
    fn close_draft(&mut self, actions: &mut Vec<Action>) {
        let tool = self.tools.tool;
        if tool == Tool::Measure {
            self.tools.draft.clear();
            return;
        }
        let is_ring = tool.is_ring();
        if self.tools.draft.len() < super::least_vertices(is_ring) {
            return;
        }
        let vertices = std::mem::take(&mut self.tools.draft);
        if tool == Tool::LensOutline {
            self.close_lens(&vertices, actions);
            return;
        }
        if matches!(tool, Tool::Hole | Tool::Breakline) {
            if let Some(host) = self.host_of(tool) {
                let (whole, spot) = with_part(&host, tool, vertices);
                actions.push(self.replace(whole));
                self.tools.choose(Tool::Select);
                self.tools.vertex = Some((host.id.clone(), spot));
            }
            return;
        }
        let (stem, kind) = if is_ring {
            let grounds = vertices
                .iter()
                .map(|v| self.document.engine().ground_m(view::place(v)));
            let mean_m = grounds.sum::<f64>() / vertices.len() as f64;
            let surface = SurfaceKind::Platform {
                height_m: (mean_m * 10.0).round() / 10.0,
            };
            (
                "Platform",
                ElementKind::Polygon(Polygon::new(vertices, surface)),
            )
        } else {
            let profile = ProfileKind::Follow {
                offset_m: 0.0,
                smooth_m: 100.0,
            };
            let section = SectionKind::Road {
                width_m: ROAD_M,
                crossfall_percent: 0.0,
            };
            (
                "Road",
                ElementKind::Corridor(Corridor::new(vertices, profile, section)),
            )
        };
        let mut element = self.new_element(stem, kind);
        element.style.fill = Some(if is_ring { AREA } else { LINE });
        self.select_element(Some(element.id.clone()));
        actions.push(Action::Edit(Edit::AddElement {
            scenario: self.document.project().scenario.clone(),
            index: None,
            element: Arc::new(element),
        }));
        self.tools.choose(Tool::Select);
    }

    /// The selected polygon, if a tool can draw something into it: holes into any, breaklines into one
    /// whose surface goes through vertices.
    pub(in crate::window) fn host_of(&self, tool: Tool) -> Option<Arc<Element>> {
        let element = self.selected_element().filter(|e| !e.locked)?;
        let ElementKind::Polygon(polygon) = &element.kind else {
            return None;
        };
        let is_tin = matches!(polygon.surface.kind, SurfaceKind::Tin);
        (tool == Tool::Hole || is_tin).then_some(element)
    }

    /// An element with an id and a name of its own.
    pub(in crate::window) fn new_element(&self, stem: &str, kind: ElementKind) -> Element {
        let project = self.document.project();
        let taken = |id: &str| {
            let in_scenarios = project.scenarios.iter().flat_map(|s| &s.changes);
            project.elements.iter().any(|e| e.id.0 == id)
                || in_scenarios
                    .filter_map(|c| c.element_id())
                    .any(|e| e.0 == id)
        };
        let number = (1..u32::MAX)
            .find(|n| !taken(&format!("{}-{n}", stem.to_lowercase())))
            .unwrap_or(u32::MAX);
        let id = format!("{}-{number}", stem.to_lowercase());
        Element::new(id.as_str().into(), format!("{stem} {number}"), kind)
    }
}

/// A polygon with a hole or a breakline more, and where its first vertex is.
fn with_part(host: &Element, tool: Tool, vertices: Vec<Vertex>) -> (Element, Spot) {
    let mut whole = host.clone();
    let mut list = 0;
    if let ElementKind::Polygon(polygon) = &mut whole.kind {
        let parts = if tool == Tool::Hole {
            list = 1 + polygon.holes.len();
            &mut polygon.holes
        } else {
            list = 1 + polygon.holes.len() + polygon.breaklines.len();
            &mut polygon.breaklines
        };
        parts.push(vertices.into());
    }
    (whole, Spot { list, index: 0 })
}

/// A place on the straight way between two vertices; heights too where both have one.
pub(super) fn between(a: &Vertex, b: &Vertex, share: f32) -> Vertex {
    let share = f64::from(share);
    let mix = |a: f64, b: f64| a + (b - a) * share;
    Vertex {
        lon_deg: mix(a.lon_deg, b.lon_deg),
        lat_deg: mix(a.lat_deg, b.lat_deg),
        height_m: a.height_m.zip(b.height_m).map(|(a, b)| mix(a, b)),
    }
}
