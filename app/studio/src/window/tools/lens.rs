//! A lens on the terrain: the circle or polygon in which layers show, dragged from place to place and
//! shaped by its corners.
//!
//! ```text
//! press --grip--> corner | middle of an edge | all of it --each frame--> with_lens --> Edit::SetMask
//! ```

mod grip;
mod paint;
pub(in crate::window) mod shape;
mod share;

use eframe::egui::{Key, Modifiers, PointerButton, Pos2, Rect, Response, Ui};
use relievo_engine::planet::MapPoint;
use relievo_engine::project::{Extra, Layer, LayerId, Lens, LensShape, Vertex};

pub(in crate::window) use share::with_lens;

use super::Tool;
use super::view::{self, Projector};
use crate::window::action::Action;
use crate::window::studio::Studio;
use grip::Grip;

/// Part of the distance to the ground that a new lens has as radius.
const USUAL_PART: f64 = 0.2;

/// Part of its radius over which a new lens fades out.
const USUAL_FADE: f64 = 0.05;

/// What the tool remembers from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct LensTool {
    /// What is dragged.
    held: Option<Grip>,
    /// What a press would take.
    hover: Option<Grip>,
    /// The corner that keys act on, and whose.
    corner: Option<(LayerId, usize)>,
}

impl Studio {
    /// A circle in the middle of the view, for a layer that has none.
    pub(in crate::window) fn usual_lens(&self) -> Lens {
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
        Lens {
            lon_deg,
            lat_deg,
            fade_m: rounded(USUAL_FADE * radius_m),
            shape: LensShape::Circle {
                radius_m: rounded(radius_m),
            },
            extra: Extra::new(),
        }
    }

    /// The selected layer's lens.
    fn lens(&self) -> Option<&Lens> {
        let layer = self.document.project().layer(self.selected.as_ref()?)?;
        layer.mask.as_ref()?.lens.as_ref()
    }

    /// The selected layer, if its lens may be changed.
    fn lens_layer(&self) -> Option<&Layer> {
        let layer = self.document.project().layer(self.selected.as_ref()?)?;
        (!layer.locked && layer.kind.may_be_masked()).then_some(layer)
    }

    /// The corner of the selected layer's polygon that keys act on.
    fn chosen_corner(&self) -> Option<usize> {
        let (id, index) = self.tools.lens.corner.as_ref()?;
        let corners_m = shape::corners(self.lens()?)?;
        (self.selected.as_ref() == Some(id) && *index < corners_m.len()).then_some(*index)
    }

    /// The main button takes the selected layer's lens or one of its corners; `true` while it does.
    pub(in crate::window) fn drag_lens(
        &mut self,
        ui: &Ui,
        rect: Rect,
        response: &Response,
        actions: &mut Vec<Action>,
    ) -> bool {
        if self.tools.lens.held.is_none() && !self.lens_keys(ui, actions) {
            return false;
        }
        let Some(id) = self.lens_layer().map(|layer| layer.id.clone()) else {
            self.tools.lens = LensTool::default();
            return false;
        };
        let turns = ui.input(|i| i.modifiers.command);
        let begins = response.drag_started_by(PointerButton::Primary) && !turns;
        let was_held = self.tools.lens.held.is_some();
        let mut lens = self.lens().cloned();
        if begins {
            let origin = ui.input(|i| i.pointer.press_origin());
            self.tools.lens.held = origin.and_then(|at| self.grip_at(rect, at));
            if self.tools.lens.held.is_some() {
                actions.push(Action::BeginDrag);
                lens = self.taken(&id, lens);
            }
        } else if response.clicked_by(PointerButton::Primary) && !turns {
            let at = super::released_at(ui);
            self.tools.lens.held = at.and_then(|at| self.grip_at(rect, at));
            lens = self.taken(&id, lens);
            if self.tools.lens.held == Some(Grip::Centre) {
                lens = at.and_then(|at| self.dragged(rect, at, lens));
            }
            self.tools.lens.held = None;
            self.change_lens(&id, lens.as_ref(), actions);
            return false;
        }
        let drags = begins || response.dragged_by(PointerButton::Primary);
        if self.tools.lens.held.is_some()
            && drags
            && let Some(at) = ui.input(|i| i.pointer.latest_pos())
        {
            // Over the sky nothing moves; a corner that was just made is there all the same.
            lens = self.dragged(rect, at, lens.clone()).or(lens);
            self.change_lens(&id, lens.as_ref(), actions);
        }
        let taken = self.tools.lens.held.is_some();
        let ends = response.drag_stopped() || !ui.input(|i| i.pointer.any_down());
        if was_held && ends {
            actions.push(Action::EndDrag);
            self.tools.lens.held = None;
        }
        self.mind_hover(ui, rect, response);
        taken
    }

    /// Delete and Backspace take the chosen corner away; Esc ends the tool: `false` then.
    fn lens_keys(&mut self, ui: &Ui, actions: &mut Vec<Action>) -> bool {
        if ui.ctx().text_edit_focused() || self.dialog.is_some() || self.palette_is_open() {
            return true;
        }
        let (back, escape) = ui.input_mut(|i| {
            let mut pressed = |key| i.consume_key(Modifiers::NONE, key);
            (pressed(Key::Backspace), pressed(Key::Escape))
        });
        if escape {
            self.tools.choose(Tool::Select);
            return false;
        }
        if back {
            actions.extend(self.without_corner());
        }
        true
    }

    /// Takes the chosen corner away and chooses the one before it. `None` where no corner is chosen or too
    /// few would be left.
    pub(in crate::window) fn without_corner(&mut self) -> Option<Action> {
        let index = self.chosen_corner()?;
        let id = self.lens_layer()?.id.clone();
        let smaller = shape::removed(self.lens()?, index)?;
        self.tools.lens.corner = Some((id.clone(), index.saturating_sub(1)));
        let edit = with_lens(self.document.project(), &id, &smaller);
        Some(Action::Edit(edit))
    }

    /// Whether keys act on a corner of a lens.
    pub(in crate::window) fn has_chosen_corner(&self) -> bool {
        self.tools.tool == Tool::Lens
            && self.tools.lens.held.is_none()
            && self.chosen_corner().is_some()
    }

    /// What a press at a point of the screen takes.
    fn grip_at(&self, rect: Rect, at: Pos2) -> Option<Grip> {
        let planet = self.document.project().planet.body.figure();
        let projector = Projector::new(self.document.engine(), self.camera(), rect);
        let place = self.ground_point(rect, at);
        grip::grip(&projector, planet, self.lens(), at, place)
    }

    /// The lens once something of it is held: with a corner more where that was the middle of an edge.
    fn taken(&mut self, id: &LayerId, lens: Option<Lens>) -> Option<Lens> {
        let (corner, lens) = match self.tools.lens.held {
            Some(Grip::Corner(index)) => (Some(index), lens),
            Some(Grip::Middle(after)) => {
                let more = lens.as_ref().and_then(|lens| shape::inserted(lens, after));
                self.tools.lens.held = Some(Grip::Corner(after + 1));
                (Some(after + 1), more.or(lens))
            }
            Some(Grip::Whole(_) | Grip::Centre) | None => (None, lens),
        };
        self.tools.lens.corner = corner.map(|index| (id.clone(), index));
        lens
    }

    /// The lens with what is held of it at a point of the screen.
    fn dragged(&self, rect: Rect, at: Pos2, lens: Option<Lens>) -> Option<Lens> {
        let place = self.ground_point(rect, at)?;
        let lens = lens.unwrap_or_else(|| self.usual_lens());
        let planet = self.document.project().planet.body.figure();
        Some(match self.tools.lens.held? {
            Grip::Corner(index) => shape::with_corner(planet, &lens, index, place),
            Grip::Whole(taken_m) => shape::carried(planet, &lens, taken_m, place),
            Grip::Centre => shape::centred(&lens, place),
            Grip::Middle(_) => lens,
        })
    }

    fn change_lens(&self, id: &LayerId, lens: Option<&Lens>, actions: &mut Vec<Action>) {
        if let Some(lens) = lens.filter(|lens| self.lens() != Some(lens)) {
            let edit = with_lens(self.document.project(), id, lens);
            actions.push(Action::Edit(edit));
        }
    }

    /// Shows what a press would take.
    fn mind_hover(&mut self, ui: &Ui, rect: Rect, response: &Response) {
        let turns = ui.input(|i| i.modifiers.command);
        let at = response.hover_pos().filter(|_| !turns);
        let held = self.tools.lens.held;
        self.tools.lens.hover = held.or_else(|| at.and_then(|at| self.grip_at(rect, at)));
        if let Some(grip) = self.tools.lens.hover {
            ui.ctx().set_cursor_icon(grip.cursor(held.is_some()));
        }
    }

    /// Gives the selected layer a lens of the outline that was drawn, and takes the tool that moves it.
    pub(super) fn close_lens(&mut self, outline: &[Vertex], actions: &mut Vec<Action>) {
        let Some(id) = self.lens_layer().map(|layer| layer.id.clone()) else {
            return;
        };
        let planet = self.document.project().planet.body.figure();
        let places: Vec<MapPoint> = outline.iter().map(view::place).collect();
        let (centre, shape) = shape::drawn(planet, &places);
        let (lon_deg, lat_deg) = centre.to_degrees();
        let before = self.lens();
        let radius_m = (shape::area_m2(&shape) / core::f64::consts::PI).sqrt();
        let lens = Lens {
            lon_deg,
            lat_deg,
            fade_m: before.map_or(rounded(USUAL_FADE * radius_m), |lens| lens.fade_m),
            extra: before.map_or_else(Extra::new, |lens| lens.extra.clone()),
            shape,
        };
        self.change_lens(&id, Some(&lens), actions);
        self.tools.choose(Tool::Lens);
    }
}

/// To two digits: lengths that people would choose.
fn rounded(length_m: f64) -> f64 {
    let unit = 10.0_f64.powf((length_m.max(1e-6)).log10().floor() - 1.0);
    (length_m / unit).round() * unit
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_rounded_to_two_digits() {
        assert_eq!(rounded(1234.0), 1200.0);
        assert!((rounded(0.0456) - 0.046).abs() < 1e-12);
    }
}
