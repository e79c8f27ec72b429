//! Where a layer shows.

use super::layer::layer_id;
use super::{Twin, unless_default};
use crate::stored::fault::{At, Fault};
use crate::stored::mask as stored;
use crate::stored::value::With;
use crate::{Lens, LensShape, Mask, MaskRange};

impl Twin for Mask {
    type Stored = With<stored::Mask>;

    fn from_stored(stored: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        let With { fields, extra } = stored;
        let heights = fields.heights.map(|With { fields, extra }| {
            let fade = fields.fade_m.unwrap_or(0.0);
            let at = At::Member(at, "heights");
            range(
                (fields.from_m, fields.to_m, fade),
                extra,
                ("from_m", "to_m"),
                &at,
            )
        });
        let slopes = fields.slopes.map(|With { fields, extra }| {
            let fade = fields.fade_deg.unwrap_or(0.0);
            let at = At::Member(at, "slopes");
            range(
                (fields.from_deg, fields.to_deg, fade),
                extra,
                ("from_deg", "to_deg"),
                &at,
            )
        });
        let vector = fields
            .vector
            .map(|id| layer_id(id, &At::Member(at, "vector")));
        Ok(Self {
            heights: heights.transpose()?,
            slopes: slopes.transpose()?,
            lens: lens(fields.circle, fields.polygon, at)?,
            vector: vector.transpose()?,
            invert: fields.invert.unwrap_or(false),
            extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        let heights = self.heights.as_ref().map(|r| With {
            fields: stored::MaskHeights {
                from_m: r.from,
                to_m: r.to,
                fade_m: unless_default(r.fade, &0.0),
            },
            extra: r.extra.clone(),
        });
        let slopes = self.slopes.as_ref().map(|r| With {
            fields: stored::MaskSlopes {
                from_deg: r.from,
                to_deg: r.to,
                fade_deg: unless_default(r.fade, &0.0),
            },
            extra: r.extra.clone(),
        });
        let (circle, polygon) = self.lens.as_ref().map_or((None, None), stored_lens);
        With {
            fields: stored::Mask {
                heights,
                slopes,
                circle,
                polygon,
                vector: self.vector.as_ref().map(|id| id.0.clone()),
                invert: unless_default(self.invert, &false),
            },
            extra: self.extra.clone(),
        }
    }
}

type StoredCircle = With<stored::MaskCircle>;
type StoredPolygon = With<stored::MaskPolygon>;

/// A mask has one lens at most.
fn lens(
    circle: Option<StoredCircle>,
    polygon: Option<StoredPolygon>,
    at: &At<'_>,
) -> Result<Option<Lens>, Fault> {
    match (circle, polygon) {
        (None, None) => Ok(None),
        (Some(With { fields, extra }), None) => Ok(Some(Lens {
            lon_deg: fields.lon_deg,
            lat_deg: fields.lat_deg,
            fade_m: fields.fade_m.unwrap_or(0.0),
            shape: LensShape::Circle {
                radius_m: fields.radius_m,
            },
            extra,
        })),
        (None, Some(With { fields, extra })) => Ok(Some(Lens {
            lon_deg: fields.lon_deg,
            lat_deg: fields.lat_deg,
            fade_m: fields.fade_m.unwrap_or(0.0),
            shape: LensShape::Polygon {
                corners_m: fields.corners_m.0,
            },
            extra,
        })),
        (Some(_), Some(_)) => Err(At::Member(at, "polygon").fault("a circle or a polygon", "both")),
    }
}

fn stored_lens(lens: &Lens) -> (Option<StoredCircle>, Option<StoredPolygon>) {
    let (lon_deg, lat_deg) = (lens.lon_deg, lens.lat_deg);
    let fade_m = unless_default(lens.fade_m, &0.0);
    let extra = lens.extra.clone();
    match &lens.shape {
        LensShape::Circle { radius_m } => {
            let fields = stored::MaskCircle {
                lon_deg,
                lat_deg,
                radius_m: *radius_m,
                fade_m,
            };
            (Some(With { fields, extra }), None)
        }
        LensShape::Polygon { corners_m } => {
            let fields = stored::MaskPolygon {
                lon_deg,
                lat_deg,
                corners_m: stored::StoredCorners(corners_m.clone()),
                fade_m,
            };
            (None, Some(With { fields, extra }))
        }
    }
}

fn range(
    (from, to, fade): (f64, f64, f64),
    extra: crate::Extra,
    (low, high): (&str, &str),
    at: &At<'_>,
) -> Result<MaskRange, Fault> {
    if to < from {
        let at = At::Member(at, high);
        return Err(at.fault(format!("no less than {low}, {from}"), to.to_string()));
    }
    Ok(MaskRange {
        from,
        to,
        fade,
        extra,
    })
}
