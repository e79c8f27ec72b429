//! A colour that becomes transparent.

use eframe::egui::Ui;
use relievo_engine::project::{Adjust, ClearColour, Edit, Extra, LayerId};

use super::changed;
use crate::window::action::Action;
use crate::window::controls::{self, Number};
use crate::window::inspector::vector::colour;

const FROM: Number = Number::new(
    "Gone within",
    "Distance from the colour up to which everything goes",
    0.0..=1.0,
    0.0,
);
const TO: Number = Number::new(
    "Kept beyond",
    "Distance from the colour from which everything stays; between the two it is partly transparent",
    0.0..=1.0,
    1.0,
);

/// Distances are at least this far apart.
const APART: f64 = 0.001;

/// Draws whether there is one, which, and how far it reaches.
pub(super) fn show(ui: &mut Ui, id: &LayerId, adjust: &Adjust, actions: &mut Vec<Action>) {
    let value = adjust.clear.as_ref().map(|clear| clear.colour);
    if let Some(new) = colour(ui, "Transparent colour", value) {
        actions.push(changed(id, adjust, |a| {
            a.clear = new.map(|colour| match a.clear.take() {
                Some(clear) => ClearColour { colour, ..clear },
                None => ClearColour {
                    colour,
                    from: 0.0,
                    to: 1.0,
                    extra: Extra::new(),
                },
            });
        }));
    }
    let Some(clear) = &adjust.clear else { return };
    let edit = |from: f64, to: f64| {
        let mut adjust = adjust.clone();
        adjust.clear = Some(ClearColour {
            from,
            to,
            ..clear.clone()
        });
        Edit::SetAdjust {
            id: id.clone(),
            adjust,
        }
    };
    // Each gives way to the other.
    controls::number(ui, &FROM, clear.from, actions, |from| {
        let from = from.min(1.0 - APART);
        edit(from, clear.to.max(from + APART).min(1.0))
    });
    controls::number(ui, &TO, clear.to, actions, |to| {
        let to = to.max(APART);
        edit(clear.from.min(to - APART), to)
    });
}
