//! Colour adjustments between the file and the running program.

use super::{Twin, optional, unless_default};
use crate::adjust::UNMIXED;
use crate::stored::colour::StoredColour;
use crate::stored::fault::{At, Fault};
use crate::stored::value::With;
use crate::stored::{adjust as stored, range};
use crate::{Adjust, AdjustSpace, ClearColour, CurvePoint, ToneCurves};

impl Twin for Adjust {
    type Stored = With<stored::Adjust>;

    fn from_stored(stored: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        let With { fields, extra } = stored;
        let default = Self::default();
        let clear = fields.clear;
        Ok(Self {
            space: fields.space.map_or(default.space, Into::into),
            temperature_k: fields.temperature_k.unwrap_or(default.temperature_k),
            tint: fields.tint.unwrap_or(default.tint),
            mix: [
                fields.mix_red.unwrap_or(UNMIXED[0]),
                fields.mix_green.unwrap_or(UNMIXED[1]),
                fields.mix_blue.unwrap_or(UNMIXED[2]),
            ],
            gain: fields.gain.unwrap_or(default.gain),
            offset: fields.offset.unwrap_or(default.offset),
            brightness: fields.brightness.unwrap_or(default.brightness),
            contrast: fields.contrast.unwrap_or(default.contrast),
            hue_deg: fields.hue_deg.unwrap_or(default.hue_deg),
            saturation: fields.saturation.unwrap_or(default.saturation),
            gamma: fields.gamma.unwrap_or(default.gamma),
            curves: optional(fields.curves, &At::Member(at, "curves"))?,
            invert: fields.invert.unwrap_or(default.invert),
            clear: clear
                .map(|given| ClearColour::from_stored(given, &At::Member(at, "clear")))
                .transpose()?,
            strength: fields.strength.unwrap_or(default.strength),
            extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        let default = Self::default();
        With {
            fields: stored::Adjust {
                space: unless_default(self.space, &AdjustSpace::default()).map(Into::into),
                temperature_k: unless_default(self.temperature_k, &default.temperature_k),
                tint: unless_default(self.tint, &default.tint),
                mix_red: unless_default(self.mix[0], &UNMIXED[0]),
                mix_green: unless_default(self.mix[1], &UNMIXED[1]),
                mix_blue: unless_default(self.mix[2], &UNMIXED[2]),
                gain: unless_default(self.gain, &default.gain),
                offset: unless_default(self.offset, &default.offset),
                brightness: unless_default(self.brightness, &default.brightness),
                contrast: unless_default(self.contrast, &default.contrast),
                hue_deg: unless_default(self.hue_deg, &default.hue_deg),
                saturation: unless_default(self.saturation, &default.saturation),
                gamma: unless_default(self.gamma, &default.gamma),
                curves: unless_default(&self.curves, &&default.curves).map(Twin::to_stored),
                invert: unless_default(self.invert, &default.invert),
                clear: self.clear.as_ref().map(Twin::to_stored),
                strength: unless_default(self.strength, &default.strength),
            },
            extra: self.extra.clone(),
        }
    }
}

/// The member `adjust` of the object at `at`.
pub(super) fn adjust(stored: Option<With<stored::Adjust>>, at: &At<'_>) -> Result<Adjust, Fault> {
    optional(stored, &At::Member(at, "adjust"))
}

impl Twin for ToneCurves {
    type Stored = With<stored::ToneCurves>;

    fn from_stored(stored: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        let With { fields, extra } = stored;
        Ok(Self {
            all: points(fields.all, &At::Member(at, "all"))?,
            channels: [
                points(fields.red, &At::Member(at, "red"))?,
                points(fields.green, &At::Member(at, "green"))?,
                points(fields.blue, &At::Member(at, "blue"))?,
            ],
            extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        let stored = |points: &Vec<CurvePoint>| {
            (!points.is_empty()).then(|| points.iter().map(stored_point).collect())
        };
        let [red, green, blue] = self.channels.each_ref().map(stored);
        With {
            fields: stored::ToneCurves {
                all: stored(&self.all),
                red,
                green,
                blue,
            },
            extra: self.extra.clone(),
        }
    }
}

fn stored_point(point: &CurvePoint) -> With<stored::CurvePoint> {
    With {
        fields: stored::CurvePoint {
            input: point.input,
            output: point.output,
        },
        extra: point.extra.clone(),
    }
}

/// The points of a curve, whose inputs rise.
fn points(
    stored: Option<Vec<With<stored::CurvePoint>>>,
    at: &At<'_>,
) -> Result<Vec<CurvePoint>, Fault> {
    let stored = stored.unwrap_or_default();
    if stored.len() > range::MOST_CURVE_POINTS {
        let expected = format!("at most {} points", range::MOST_CURVE_POINTS);
        return Err(at.fault(expected, stored.len().to_string()));
    }
    for (i, pair) in stored.windows(2).enumerate() {
        let (before, here) = (pair[0].fields.input, pair[1].fields.input);
        if here <= before {
            let point = At::Element(at, i + 1);
            let expected = format!("more than the point before, {before}");
            return Err(At::Member(&point, "input").fault(expected, here.to_string()));
        }
    }
    let points = stored.into_iter().map(|With { fields, extra }| CurvePoint {
        input: fields.input,
        output: fields.output,
        extra,
    });
    Ok(points.collect())
}

impl Twin for ClearColour {
    type Stored = With<stored::ClearColour>;

    fn from_stored(stored: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        let With { fields, extra } = stored;
        let (from, to) = (fields.from.unwrap_or(0.0), fields.to.unwrap_or(1.0));
        if to <= from {
            let expected = format!("more than \"from\", {from}");
            return Err(At::Member(at, "to").fault(expected, to.to_string()));
        }
        Ok(Self {
            colour: fields.colour.0,
            from,
            to,
            extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        With {
            fields: stored::ClearColour {
                colour: StoredColour(self.colour),
                from: unless_default(self.from, &0.0),
                to: unless_default(self.to, &1.0),
            },
            extra: self.extra.clone(),
        }
    }
}
