//! A lens on the terrain: the circle in which layers show, dragged from place to place.

use eframe::egui::{Key, Modifiers, Painter, PointerButton, Rect, Response, Stroke, Ui};
use glam::DVec3;
use relievo_engine::planet::MapPoint;
use relievo_engine::project::{Edit, Extra, LayerId, Mask, MaskCircle, Project};

use super::Tool;
use super::view::Projector;
use crate::window::action::Action;
use crate::window::studio::Studio;

/// Corners of the drawn circle.
const CORNERS: u32 = 96;

/// Part of the distance to the ground that a new lens has as radius.
const USUAL_PART: f64 = 0.2;

/// A layer's circle changed: for all unlocked layers that share it, so that a lens keeps its stack.
pub(in crate::window) fn with_circle(project: &Project, id: &LayerId, circle: &MaskCircle) -> Edit {
    let circle_of = |mask: &Option<Mask>| mask.as_ref().and_then(|m| m.circle.clone());
    let before = project.layer(id).and_then(|layer| circle_of(&layer.mask));
    let shares = project.layers.iter().filter(|layer| {
        layer.id == *id || (before.is_some() && !layer.locked && circle_of(&layer.mask) == before)
    });
    let mut edits: Vec<Edit> = shares
        .map(|layer| {
            let mask = Mask {
                circle: Some(circle.clone()),
                ..layer.mask.clone().unwrap_or_default()
            };
            Edit::SetMask {
                id: layer.id.clone(),
                mask: Some(Box::new(mask)),
            }
        })
        .collect();
    match (edits.len(), edits.pop()) {
        (1, Some(only)) => only,
        (_, last) => {
            edits.extend(last);
            Edit::Batch {
                label: "Lens".to_owned(),
                edits,
            }
        }
    }
}

impl Studio {
    /// A circle in the middle of the view, for a layer that has none.
    pub(in crate::window) fn usual_lens(&self) -> MaskCircle {
        let planet = self.document.project().planet.body.figure();
        let camera = self.camera();
        let (place, distance_m) = match self.middle() {
            Some(hit) => {
                let ground = hit.direction * (planet.radius_m + hit.ground_m);
                let distance_m = camera.eye(&planet).distance(ground);
                (MapPoint::from_direction(hit.direction), distance_m)
            }
            None => (
                MapPoint::new(
                    camera.lon_rad,
                    core::f64::consts::FRAC_PI_2 - camera.lat_rad,
                ),
                camera.altitude_m,
            ),
        };
        let (lon_deg, lat_deg) = place.to_degrees();
        let radius_m = (USUAL_PART * distance_m).clamp(1.0, planet.radius_m);
        MaskCircle {
            lon_deg,
            lat_deg,
            radius_m: rounded(radius_m),
            fade_m: rounded(0.05 * radius_m),
            extra: Extra::new(),
        }
    }

    /// The selected layer's circle.
    fn lens(&self) -> Option<&MaskCircle> {
        let layer = self.document.project().layer(self.selected.as_ref()?)?;
        layer.mask.as_ref()?.circle.as_ref()
    }

    /// The main button moves the selected layer's lens; `true` while it does.
    pub(in crate::window) fn drag_lens(
        &mut self,
        ui: &Ui,
        rect: Rect,
        response: &Response,
        actions: &mut Vec<Action>,
    ) -> bool {
        let typing = ui.ctx().text_edit_focused() || self.dialog.is_some();
        if !typing && ui.input_mut(|i| i.consume_key(Modifiers::NONE, Key::Escape)) {
            self.tools.choose(Tool::Select);
            return false;
        }
        let project = self.document.project();
        let selected = self.selected.as_ref().and_then(|id| project.layer(id));
        let Some(layer) = selected.filter(|l| !l.locked && l.kind.may_be_masked()) else {
            return false;
        };
        let main = |response: &Response| response.dragged_by(PointerButton::Primary);
        let turns = ui.input(|i| i.modifiers.command);
        let begins = response.drag_started_by(PointerButton::Primary) && !turns;
        let goes_on = self.tools.moves_lens && main(response);
        let clicked = response.clicked_by(PointerButton::Primary);
        if begins {
            actions.push(Action::BeginDrag);
        }
        if (begins || goes_on || clicked)
            && let Some(at) = ui.input(|i| i.pointer.latest_pos())
            && let Some(place) = self.ground_point(rect, at)
        {
            let (lon_deg, lat_deg) = place.to_degrees();
            let circle = MaskCircle {
                lon_deg,
                lat_deg,
                ..self.lens().cloned().unwrap_or_else(|| self.usual_lens())
            };
            actions.push(Action::Edit(with_circle(project, &layer.id, &circle)));
        }
        if self.tools.moves_lens && response.drag_stopped() {
            actions.push(Action::EndDrag);
        }
        let moves = begins || (goes_on && !response.drag_stopped());
        let taken = moves || self.tools.moves_lens;
        self.tools.moves_lens = moves;
        taken
    }

    /// The rim of the selected layer's lens.
    pub(super) fn paint_lens(&self, painter: &Painter, projector: &Projector<'_>, stroke: Stroke) {
        let Some(circle) = self.lens() else { return };
        let planet = self.document.project().planet.body.figure();
        let centre = MapPoint::from_degrees(circle.lon_deg, circle.lat_deg).to_unit();
        let (sin, cos) = (circle.radius_m / planet.radius_m).sin_cos();
        let east = DVec3::Z.cross(centre).try_normalize().unwrap_or(DVec3::X);
        let north = centre.cross(east);
        let corner = |k: u32| {
            let turn = core::f64::consts::TAU * f64::from(k) / f64::from(CORNERS);
            let away = east * turn.sin() + north * turn.cos();
            projector.screen(MapPoint::from_direction(centre * cos + away * sin))
        };
        let mut before = corner(0);
        for k in 1..=CORNERS {
            let next = corner(k);
            if let (Some(a), Some(b)) = (before, next) {
                painter.line_segment([a, b], stroke);
            }
            before = next;
        }
    }
}

/// To two digits: lengths that people would choose.
fn rounded(length_m: f64) -> f64 {
    let unit = 10.0_f64.powf((length_m.max(1e-6)).log10().floor() - 1.0);
    (length_m / unit).round() * unit
}

#[cfg(test)]
mod tests {
    use relievo_engine::project::{Layer, LayerKind, SlopeLayer};

    use super::*;

    fn circle(lon_deg: f64) -> MaskCircle {
        MaskCircle {
            lon_deg,
            lat_deg: 0.0,
            radius_m: 1000.0,
            fade_m: 0.0,
            extra: Extra::new(),
        }
    }

    fn layer(id: &str, lens: Option<MaskCircle>) -> Layer {
        let slopes = LayerKind::Slope(SlopeLayer::default());
        let mut layer = Layer::new(LayerId::from(id), id, slopes);
        layer.mask = lens.map(|circle| Mask {
            circle: Some(circle),
            ..Mask::default()
        });
        layer
    }

    #[test]
    fn a_lens_moves_with_all_that_it_shows_and_with_nothing_else() {
        let mut project = Project {
            layers: vec![
                layer("a", Some(circle(1.0))),
                layer("b", Some(circle(1.0))),
                layer("c", Some(circle(2.0))),
                layer("d", None),
            ],
            ..Project::default()
        };
        let edit = with_circle(&project, &LayerId::from("b"), &circle(5.0));
        project.apply(edit).unwrap();
        let lon = |i: usize| {
            let mask = project.layers[i].mask.as_ref();
            mask.and_then(|m| m.circle.as_ref()).map(|c| c.lon_deg)
        };
        assert_eq!(
            [0, 1, 2, 3].map(lon),
            [Some(5.0), Some(5.0), Some(2.0), None]
        );
        let edit = with_circle(&project, &LayerId::from("d"), &circle(7.0));
        project.apply(edit).unwrap();
        let lon = |i: usize| {
            let mask = project.layers[i].mask.as_ref();
            mask.and_then(|m| m.circle.as_ref()).map(|c| c.lon_deg)
        };
        assert_eq!(
            [0, 1, 2, 3].map(lon),
            [Some(5.0), Some(5.0), Some(2.0), Some(7.0)]
        );
    }

    #[test]
    fn lengths_are_rounded_to_two_digits() {
        assert_eq!(rounded(1234.0), 1200.0);
        assert!((rounded(0.0456) - 0.046).abs() < 1e-12);
    }
}
