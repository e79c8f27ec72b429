//! Layers drawn from the shape of the ground, and their tables of colours.

use super::adjust::adjust;
use super::{Twin, unless_default};
use crate::stored::colour::StoredColour;
use crate::stored::fault::{At, Fault};
use crate::stored::value::With;
use crate::stored::{range, relief};
use crate::{
    Adjust, Blend, ContoursLayer, SlopeLayer, SlopeStop, SlopeUnit, Tint, TintInterpolation,
    TintLayer, TintStop,
};

impl Twin for TintLayer {
    type Stored = relief::Tint;

    fn from_stored(stored: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        Ok(Self {
            tint: tint(stored.stops, stored.interpolation, at)?,
            blend: stored.blend.map_or(Blend::Normal, Into::into),
            adjust: adjust(stored.adjust, at)?,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        let (stops, interpolation) = stored_tint(&self.tint);
        relief::Tint {
            stops,
            interpolation,
            blend: unless_default(self.blend, &Blend::Normal).map(Into::into),
            adjust: unless_default(&self.adjust, &&Adjust::default()).map(Twin::to_stored),
        }
    }
}

/// A tint from its fields.
pub(crate) fn tint(
    stops: Vec<With<relief::TintStop>>,
    interpolation: Option<relief::TintInterpolation>,
    at: &At<'_>,
) -> Result<Tint, Fault> {
    let rising = |stop: &With<relief::TintStop>| stop.fields.height_m;
    check_stops(&stops, "height_m", rising, at)?;
    let read = stops.into_iter().map(|With { fields, extra }| TintStop {
        height_m: fields.height_m,
        colour: fields.colour.0,
        extra,
    });
    Ok(Tint {
        stops: read.collect(),
        interpolation: interpolation.map_or_else(Default::default, Into::into),
    })
}

/// A tint's fields.
pub(crate) fn stored_tint(
    tint: &Tint,
) -> (
    Vec<With<relief::TintStop>>,
    Option<relief::TintInterpolation>,
) {
    let stops = tint.stops.iter().map(|stop| With {
        fields: relief::TintStop {
            height_m: stop.height_m,
            colour: StoredColour(stop.colour),
        },
        extra: stop.extra.clone(),
    });
    let interpolation =
        unless_default(tint.interpolation, &TintInterpolation::default()).map(Into::into);
    (stops.collect(), interpolation)
}

/// That a table has stops, whose heights or slopes rise.
fn check_stops<T>(
    stops: &[T],
    what: &str,
    of: impl Fn(&T) -> f64,
    at: &At<'_>,
) -> Result<(), Fault> {
    let stops_at = At::Member(at, "stops");
    if stops.is_empty() || stops.len() > range::MOST_STOPS {
        let expected = format!("1 to {} stops", range::MOST_STOPS);
        return Err(stops_at.fault(expected, stops.len().to_string()));
    }
    for (i, pair) in stops.windows(2).enumerate() {
        let (before, here) = (of(&pair[0]), of(&pair[1]));
        if here <= before {
            let stop_at = At::Element(&stops_at, i + 1);
            let higher = format!("more than the stop before, {before}");
            return Err(At::Member(&stop_at, what).fault(higher, here.to_string()));
        }
    }
    Ok(())
}

impl Twin for SlopeLayer {
    type Stored = relief::Slope;

    fn from_stored(stored: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        let rising = |stop: &With<relief::SlopeStop>| stop.fields.slope_deg;
        check_stops(&stored.stops, "slope_deg", rising, at)?;
        let stops = stored.stops.into_iter();
        let stops = stops.map(|With { fields, extra }| SlopeStop {
            slope_deg: fields.slope_deg,
            colour: fields.colour.0,
            opacity: fields.opacity.unwrap_or(1.0),
            extra,
        });
        Ok(Self {
            stops: stops.collect(),
            interpolation: stored
                .interpolation
                .map_or(TintInterpolation::Stepped, Into::into),
            unit: stored.unit.map_or(SlopeUnit::Degrees, Into::into),
            blend: stored.blend.map_or(Blend::Normal, Into::into),
        })
    }

    fn to_stored(&self) -> Self::Stored {
        let stops = self.stops.iter().map(|stop| With {
            fields: relief::SlopeStop {
                slope_deg: stop.slope_deg,
                colour: StoredColour(stop.colour),
                opacity: unless_default(stop.opacity, &1.0),
            },
            extra: stop.extra.clone(),
        });
        relief::Slope {
            stops: stops.collect(),
            interpolation: unless_default(self.interpolation, &TintInterpolation::Stepped)
                .map(Into::into),
            unit: unless_default(self.unit, &SlopeUnit::Degrees).map(Into::into),
            blend: unless_default(self.blend, &Blend::Normal).map(Into::into),
        }
    }
}

impl Twin for ContoursLayer {
    type Stored = relief::Contours;

    fn from_stored(stored: Self::Stored, _: &At<'_>) -> Result<Self, Fault> {
        let default = Self::default();
        Ok(Self {
            interval_m: stored.interval_m,
            base_m: stored.base_m.unwrap_or(default.base_m),
            index_every: stored.index_every.unwrap_or(default.index_every),
            colour: stored.colour.map_or(default.colour, |c| c.0),
            width_px: stored.width_px.unwrap_or(default.width_px),
            index_width_px: stored.index_width_px.unwrap_or(default.index_width_px),
            blend: stored.blend.map_or(default.blend, Into::into),
        })
    }

    fn to_stored(&self) -> Self::Stored {
        let default = Self::default();
        relief::Contours {
            interval_m: self.interval_m,
            base_m: unless_default(self.base_m, &default.base_m),
            index_every: unless_default(self.index_every, &default.index_every),
            colour: unless_default(self.colour, &default.colour).map(StoredColour),
            width_px: unless_default(self.width_px, &default.width_px),
            index_width_px: unless_default(self.index_width_px, &default.index_width_px),
            blend: unless_default(self.blend, &default.blend).map(Into::into),
        }
    }
}
