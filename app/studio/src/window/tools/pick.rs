//! Selecting an element by a click on the terrain.

use eframe::egui::{Pos2, Rect, Ui};
use relievo_engine::project::{Element, ElementKind};

use super::view::{self, Projector};
use super::{handles, snap};
use crate::window::action::Action;
use crate::window::studio::Studio;

/// Vertices of an element that are looked at, at most.
const MOST: usize = 20_000;

impl Studio {
    /// Selects the topmost element under the pointer, or none.
    pub(in crate::window) fn pick_element(
        &mut self,
        ui: &Ui,
        rect: Rect,
        actions: &mut Vec<Action>,
    ) {
        let Some(at) = super::released_at(ui) else {
            return;
        };
        let projector = Projector::new(self.document.engine(), self.camera(), rect);
        let elements = self.elements();
        let mut shown = elements.iter().rev().filter(|e| e.visible);
        let found = shown.find(|e| is_under(&projector, e, at));
        if found.is_some() || self.selected_element.is_some() {
            actions.push(Action::SelectElement(found.map(|e| e.id.clone())));
        }
    }
}

/// Whether an element is under a point of the screen: on one of its lines or inside its outline.
fn is_under(projector: &Projector<'_>, element: &Element, at: Pos2) -> bool {
    let lists = element.vertex_lists();
    let on_screen = |list: &relievo_engine::project::Vertices| -> Vec<Option<Pos2>> {
        let vertices = list.as_slice().iter().take(MOST);
        vertices.map(|v| projector.screen(view::place(v))).collect()
    };
    let mut inside = false;
    for (index, list) in lists.iter().enumerate() {
        let points = on_screen(list);
        let is_ring = handles::is_ring(element, index);
        if snap::near(&points, is_ring, at).is_some() {
            return true;
        }
        if is_ring && points.iter().all(Option::is_some) {
            let ring: Vec<Pos2> = points.into_iter().flatten().collect();
            inside ^= snap::is_inside(&ring, at);
        }
    }
    inside && matches!(element.kind, ElementKind::Polygon(_))
}
