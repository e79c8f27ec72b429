//! Planning elements as the window has them: which are shown, which is selected, what commands do.

use std::sync::Arc;

use eframe::egui::{Pos2, Rect};
use relievo_engine::planet::MapPoint;
use relievo_engine::project::{Edit, Element, ElementId, ScenarioId};

use super::Studio;
use crate::commands::Command;
use crate::window::panes::Pane;
use crate::window::tools::view::place;
use crate::window::tools::{Spot, removed};

/// Elements that the pointer snaps to, at most: more are a carpet of vertices anyway.
const MOST_TARGETS: usize = 300;

impl Studio {
    /// The scenario that is shown; `None`: the base.
    pub(in crate::window) fn scenario(&self) -> Option<ScenarioId> {
        self.document.project().scenario.clone()
    }

    /// Elements of the shown scenario, the bottom one first.
    pub(in crate::window) fn elements(&self) -> Vec<Arc<Element>> {
        let project = self.document.project();
        project.elements_in(project.scenario.as_ref())
    }

    /// One element of the shown scenario.
    pub(in crate::window) fn element(&self, id: &ElementId) -> Option<Arc<Element>> {
        let project = self.document.project();
        project.element_in(project.scenario.as_ref(), id).cloned()
    }

    /// The selected element.
    pub fn selected_element(&self) -> Option<Arc<Element>> {
        self.element(self.selected_element.as_ref()?)
    }

    /// Selects an element, or none; layers are then not what keys mean.
    pub(in crate::window) fn select_element(&mut self, id: Option<ElementId>) {
        if id.is_some() {
            self.layout.open(Pane::Inspector);
        }
        self.tools.vertex = None;
        self.selected_element = id;
    }

    /// The vertex of the selected element that is chosen.
    pub(in crate::window) fn chosen_vertex(&self) -> Option<Spot> {
        let (id, spot) = self.tools.vertex.as_ref()?;
        (self.selected_element.as_ref() == Some(id)).then_some(*spot)
    }

    /// Elements that the pointer snaps to.
    pub(in crate::window) fn snap_targets(&self) -> Vec<Arc<Element>> {
        let mut elements = self.elements();
        elements.retain(|e| e.visible);
        elements.truncate(MOST_TARGETS);
        elements
    }

    /// The place of the drawn ground that a point of the screen shows.
    pub(in crate::window) fn ground_point(&self, rect: Rect, at: Pos2) -> Option<MapPoint> {
        let hit = self.hit(rect, at)?;
        Some(MapPoint::from_direction(hit.direction))
    }

    /// Whether the palette is open.
    pub(in crate::window) fn palette_is_open(&self) -> bool {
        self.palette.is_some()
    }

    /// Flies to where the selected element is seen whole.
    pub(super) fn fly_to_element(&mut self, id: &ElementId) {
        let Some(element) = self.element(id) else {
            return;
        };
        let places: Vec<MapPoint> = element
            .vertex_lists()
            .iter()
            .flat_map(|l| l.as_slice().iter().map(place))
            .collect();
        let Some(first) = places.first() else { return };
        let sum: glam::DVec3 = places.iter().map(|p| p.to_unit()).sum();
        let middle = sum.try_normalize().map_or(*first, MapPoint::from_direction);
        let reach = places
            .iter()
            .map(|p| p.angle_to(middle))
            .fold(0.0, f64::max);
        let radius_m = self.document.project().planet.body.figure().radius_m;
        let half = 0.5 * self.camera().fov_y_rad;
        let away_m = (reach * radius_m / half.tan() * 1.4).max(200.0);
        let mut to = *self.camera();
        (to.lon_rad, to.lat_rad) = (middle.lon_rad, middle.lat_rad());
        to.altitude_m = away_m;
        (to.heading_rad, to.pitch_rad) = (0.0, -core::f64::consts::FRAC_PI_2);
        self.fly_above(to);
    }

    /// Carries a command out that is about the selected element; `false`: none is selected.
    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "most commands are about no element"
    )]
    pub(super) fn run_on_element(&mut self, command: Command) -> bool {
        let Some(element) = self.selected_element() else {
            return false;
        };
        let (scenario, id) = (self.scenario(), element.id.clone());
        let edit = match command {
            Command::ZoomToLayer => {
                self.fly_to_element(&id);
                return true;
            }
            _ if element.locked => return true,
            Command::RemoveLayer if self.chosen_vertex().is_some() => {
                // The keys mean the vertex that is chosen on the terrain.
                let smaller = self.chosen_vertex().and_then(|s| removed(&element, s));
                self.tools.vertex = None;
                smaller.map(|element| Edit::ReplaceElement {
                    scenario,
                    element: Arc::new(element),
                })
            }
            Command::RemoveLayer => Some(Edit::RemoveElement { scenario, id }),
            Command::ToggleVisible => Some(Edit::SetElementVisible {
                scenario,
                id,
                visible: !element.visible,
            }),
            Command::MoveUp | Command::MoveDown => {
                let elements = self.elements();
                let from = elements.iter().position(|e| e.id == id);
                let to = from.and_then(|from| {
                    if command == Command::MoveUp {
                        Some(from + 1).filter(|to| *to < elements.len())
                    } else {
                        from.checked_sub(1)
                    }
                });
                to.map(|index| Edit::MoveElement {
                    scenario,
                    id,
                    index,
                })
            }
            _ => return false,
        };
        if let Some(edit) = edit {
            self.edit(edit);
        }
        true
    }
}
