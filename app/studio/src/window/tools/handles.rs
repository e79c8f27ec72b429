//! The selected element's vertices as handles: drag, insert, delete.

use std::sync::Arc;

use eframe::egui::{Key, Modifiers, PointerButton, Pos2, Rect, Response, Ui};
use relievo_engine::project::{Edit, Element, ElementId, ElementKind, Vertex, Vertices};

use super::view::{self, Projector};
use super::{draft, snap};
use crate::window::action::Action;
use crate::window::studio::Studio;

/// Handles that are drawn and grabbed at most; those of longer outlines show when one is nearer.
pub(super) const MOST: usize = 400;

/// A vertex of an element: in which of its lists, and where in that.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Spot {
    pub(crate) list: usize,
    pub(crate) index: usize,
}

/// A vertex that is being dragged.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Held {
    pub(crate) element: ElementId,
    pub(crate) spot: Spot,
}

/// What a press grabs.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Grip {
    Vertex(Spot),
    /// The middle of the edge after a vertex: a press makes a vertex there.
    Middle(Spot),
}

impl Studio {
    /// Handles of the selected element; `true` while the pointer is theirs.
    pub(in crate::window) fn drag_handles(
        &mut self,
        ui: &Ui,
        rect: Rect,
        response: &Response,
        actions: &mut Vec<Action>,
    ) -> bool {
        if response.drag_started_by(PointerButton::Primary) && !ui.input(|i| i.modifiers.command) {
            let origin = ui.input(|i| i.pointer.press_origin());
            self.grab_handle(rect, origin, actions);
            if self.tools.held.is_some() {
                // What was asked for just now is there in the next frame.
                return true;
            }
        }
        if self.tools.held.is_none() {
            self.vertex_keys(ui, actions);
            return false;
        }
        let pointer = ui.input(|i| i.pointer.latest_pos());
        if response.dragged()
            && let Some(at) = pointer
        {
            let free = ui.input(|i| i.modifiers.alt);
            self.move_held(rect, at, free, actions);
        }
        if response.drag_stopped() || !ui.input(|i| i.pointer.any_down()) {
            actions.push(Action::EndDrag);
            self.tools.held = None;
        }
        true
    }

    /// The selected element if its vertices may be dragged.
    fn grabbable(&self) -> Option<Arc<Element>> {
        self.selected_element()
            .filter(|e| !e.locked && e.visible && !matches!(e.kind, ElementKind::Brush(_)))
    }

    fn grab_handle(&mut self, rect: Rect, origin: Option<Pos2>, actions: &mut Vec<Action>) {
        let (Some(element), Some(at)) = (self.grabbable(), origin) else {
            return;
        };
        let projector = Projector::new(self.document.engine(), self.camera(), rect);
        let Some(grip) = grip(&projector, &element, at) else {
            return;
        };
        actions.push(Action::BeginDrag);
        let spot = match grip {
            Grip::Vertex(spot) => spot,
            Grip::Middle(after) => {
                let Some(edit) = inserted(&element, after) else {
                    return;
                };
                actions.push(self.replace(edit));
                Spot {
                    index: after.index + 1,
                    ..after
                }
            }
        };
        self.tools.vertex = Some((element.id.clone(), spot));
        self.tools.held = Some(Held {
            element: element.id.clone(),
            spot,
        });
    }

    fn move_held(&mut self, rect: Rect, at: Pos2, free: bool, actions: &mut Vec<Action>) {
        let (Some(held), Some(target)) = (self.tools.held.clone(), self.vertex_at(rect, at, free))
        else {
            return;
        };
        let Some(element) = self.element(&held.element) else {
            return;
        };
        let moved = changed(&element, held.spot.list, |vertices| {
            let near = vertices.get(held.spot.index)?;
            let to = view::vertex(view::place(&target), Some(near));
            let vertex = Vertex {
                height_m: near.height_m,
                ..to
            };
            if vertex == vertices[held.spot.index] {
                return None;
            }
            vertices[held.spot.index] = vertex;
            Some(())
        });
        if let Some(moved) = moved {
            actions.push(self.replace(moved));
        }
    }

    /// Delete and Backspace take the chosen vertex away, Esc chooses none.
    fn vertex_keys(&mut self, ui: &Ui, actions: &mut Vec<Action>) {
        let Some((id, spot)) = self.tools.vertex.clone() else {
            return;
        };
        let Some(element) = self.grabbable().filter(|e| e.id == id) else {
            self.tools.vertex = None;
            return;
        };
        if ui.ctx().text_edit_focused() || self.dialog.is_some() || self.palette_is_open() {
            return;
        }
        let (remove, escape) = ui.input_mut(|i| {
            let mut pressed = |key| i.consume_key(Modifiers::NONE, key);
            let delete = pressed(Key::Delete);
            (pressed(Key::Backspace) || delete, pressed(Key::Escape))
        });
        if escape {
            self.tools.vertex = None;
        }
        if remove && let Some(smaller) = removed(&element, spot) {
            actions.push(self.replace(smaller));
            self.tools.vertex = None;
        }
    }

    /// The action that puts an element in the place of the one with its id.
    pub(in crate::window) fn replace(&self, element: Element) -> Action {
        Action::Edit(Edit::ReplaceElement {
            scenario: self.document.project().scenario.clone(),
            element: Arc::new(element),
        })
    }
}

/// Whether a list of an element is closed.
pub(super) fn is_ring(element: &Element, list: usize) -> bool {
    matches!(&element.kind, ElementKind::Polygon(polygon) if list <= polygon.holes.len())
}

/// Handles of an element that are on the screen: vertices, and the middles of edges.
pub(super) fn handles(
    projector: &Projector<'_>,
    element: &Element,
) -> Vec<(Spot, Vertex, Option<Vertex>)> {
    let mut all = Vec::new();
    for (list, vertices) in element.vertex_lists().into_iter().enumerate() {
        let vertices = vertices.as_slice();
        let ring = is_ring(element, list);
        for (index, vertex) in vertices.iter().enumerate() {
            if all.len() >= MOST {
                return all;
            }
            if projector.screen(view::place(vertex)).is_none() {
                continue;
            }
            let next = vertices
                .get(index + 1)
                .or(vertices.first().filter(|_| ring));
            let middle = next.map(|next| draft::between(vertex, next, 0.5));
            all.push((Spot { list, index }, *vertex, middle));
        }
    }
    all
}

fn grip(projector: &Projector<'_>, element: &Element, at: Pos2) -> Option<Grip> {
    let near = |vertex: &Vertex| {
        let screen = projector.screen(view::place(vertex))?;
        let distance = screen.distance(at);
        let hit = distance <= snap::REACH && projector.visible(view::place(vertex)).is_some();
        hit.then_some(distance)
    };
    let all = handles(projector, element);
    let vertices = all
        .iter()
        .filter_map(|(spot, vertex, _)| Some((near(vertex)?, Grip::Vertex(*spot))));
    let nearest = vertices.min_by(|a, b| a.0.total_cmp(&b.0));
    let middles = all
        .iter()
        .filter_map(|(spot, _, middle)| Some((near(middle.as_ref()?)?, Grip::Middle(*spot))));
    nearest
        .or_else(|| middles.min_by(|a, b| a.0.total_cmp(&b.0)))
        .map(|(_, grip)| grip)
}

/// The element with one list changed; `None` where `change` says that nothing is.
pub(in crate::window) fn changed(
    element: &Element,
    list: usize,
    change: impl FnOnce(&mut Vec<Vertex>) -> Option<()>,
) -> Option<Element> {
    let mut element = element.clone();
    let mut lists = element.vertex_lists_mut();
    let slot = lists.get_mut(list)?;
    let mut vertices = slot.as_slice().to_vec();
    change(&mut vertices)?;
    **slot = Vertices::from(vertices);
    Some(element)
}

/// The element with a vertex more in the middle of the edge after one.
pub(in crate::window) fn inserted(element: &Element, after: Spot) -> Option<Element> {
    changed(element, after.list, |vertices| {
        let a = *vertices.get(after.index)?;
        let b = vertices.get(after.index + 1).or(vertices.first())?;
        let middle = draft::between(&a, b, 0.5);
        vertices.insert(after.index + 1, middle);
        Some(())
    })
}

/// The element with a vertex less, or without the hole or breakline that has no vertex to spare; `None`
/// where too few would be left.
pub(in crate::window) fn removed(element: &Element, spot: Spot) -> Option<Element> {
    let least = super::least_vertices(is_ring(element, spot.list));
    let lists = element.vertex_lists();
    let vertices = lists.get(spot.list)?.as_slice();
    if spot.index < vertices.len() && vertices.len() <= least {
        return without_part(element, spot.list);
    }
    changed(element, spot.list, |vertices| {
        if vertices.len() <= least || spot.index >= vertices.len() {
            return None;
        }
        vertices.remove(spot.index);
        Some(())
    })
}

/// The element without one of its holes or breaklines.
fn without_part(element: &Element, list: usize) -> Option<Element> {
    let mut element = element.clone();
    let ElementKind::Polygon(polygon) = &mut element.kind else {
        return None;
    };
    let part = list.checked_sub(1)?;
    if part < polygon.holes.len() {
        polygon.holes.remove(part);
    } else {
        let part = part - polygon.holes.len();
        if part >= polygon.breaklines.len() {
            return None;
        }
        polygon.breaklines.remove(part);
    }
    Some(element)
}

#[cfg(test)]
mod tests {
    use relievo_engine::project::{Polygon, SurfaceKind};

    use super::*;

    fn square() -> Element {
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let outline: Vec<Vertex> = corners.map(|(x, y)| Vertex::new(x, y)).to_vec();
        let polygon = Polygon::new(outline, SurfaceKind::Smooth);
        Element::new("a".into(), "A", ElementKind::Polygon(polygon))
    }

    fn outline(element: &Element) -> Vec<(f64, f64)> {
        let vertices = element.vertex_lists()[0].as_slice();
        vertices.iter().map(|v| (v.lon_deg, v.lat_deg)).collect()
    }

    #[test]
    fn a_vertex_is_inserted_in_the_middle_also_of_the_closing_edge() {
        let spot = |index| Spot { list: 0, index };
        let more = inserted(&square(), spot(0)).unwrap();
        assert_eq!(outline(&more)[1], (0.5, 0.0));
        let more = inserted(&square(), spot(3)).unwrap();
        assert_eq!(outline(&more)[4], (0.0, 0.5));
    }

    #[test]
    fn a_ring_keeps_three_vertices() {
        let spot = Spot { list: 0, index: 1 };
        let three = removed(&square(), spot).unwrap();
        assert_eq!(outline(&three), [(0.0, 0.0), (1.0, 1.0), (0.0, 1.0)]);
        assert!(removed(&three, spot).is_none());
        assert!(removed(&square(), Spot { list: 0, index: 9 }).is_none());
        assert!(removed(&square(), Spot { list: 3, index: 0 }).is_none());
    }

    #[test]
    fn a_hole_or_a_breakline_without_a_vertex_to_spare_goes_as_a_whole() {
        let mut element = square();
        let ring = [(0.2, 0.2), (0.4, 0.2), (0.2, 0.4)].map(|(x, y)| Vertex::new(x, y));
        if let ElementKind::Polygon(polygon) = &mut element.kind {
            polygon.holes = vec![ring.to_vec().into()];
            polygon.breaklines = vec![ring[..2].to_vec().into()];
        }
        let without_line = removed(&element, Spot { list: 2, index: 1 }).unwrap();
        assert_eq!(without_line.vertex_lists().len(), 2);
        let without_hole = removed(&without_line, Spot { list: 1, index: 0 }).unwrap();
        assert_eq!(without_hole, square());
    }
}
