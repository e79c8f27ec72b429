//! An element with an inside and sides: polygons and corridors, ready for evaluation.

use glam::DVec2;

use crate::envelope::{Candidates, Envelope, Sides};
use crate::frame::Frame;
use crate::patch::{Patch, Positions};
use crate::rings::{Crossings, Rings};
use crate::strip::Strip;
use crate::tin::Tin;

/// Heights inside an area.
#[derive(Clone, Debug)]
pub(crate) enum AreaHeights {
    /// One height; of an offset, above the ground.
    Level(f64),
    Plane {
        at: DVec2,
        height_m: f64,
        gradient: DVec2,
    },
    Tin(Tin),
}

/// What is inside.
#[derive(Clone, Debug)]
pub(crate) enum Interior {
    Area { rings: Rings, heights: AreaHeights },
    Strip(Strip),
}

/// One frame's share of an element.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub(crate) frame: Frame,
    pub(crate) interior: Interior,
    pub(crate) envelope: Envelope,
}

/// The element.
#[derive(Clone, Debug)]
pub(crate) struct Solid {
    pub(crate) parts: Vec<Part>,
    /// Cut and fill; `None` for walls.
    pub(crate) slopes: Option<(f64, f64)>,
    /// How far from the boundary it acts.
    pub(crate) reach_m: f64,
    pub(crate) raises: bool,
    pub(crate) lowers: bool,
    /// Whether heights inside are above the ground instead of the datum.
    pub(crate) on_ground: bool,
    /// Typical width and length of the inside.
    pub(crate) width_m: f64,
    pub(crate) length_m: f64,
    /// Mean height of the inside above its boundary.
    pub(crate) mean_above_edge_m: f64,
}

/// What an element says at a place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    /// Height inside; `None` outside.
    pub(crate) inside_m: Option<f64>,
    /// Distance to the axis that decided it.
    axis_m: f64,
    /// What the boundary says; inside only if asked for.
    pub(crate) sides: Sides,
}

impl Hit {
    pub(crate) const NOTHING: Self = Self {
        inside_m: None,
        axis_m: f64::INFINITY,
        sides: Sides::NOTHING,
    };
}

/// Buffers that evaluations share.
#[derive(Default)]
pub(crate) struct Scratch {
    pub(crate) positions: Positions,
    candidates: Candidates,
    crossings: Crossings,
    pieces: Vec<u32>,
}

impl Solid {
    /// Evaluates a patch into `hits`; `false` where the element does not reach it. `around_m` also
    /// asks what the boundary says inside and that much beyond the reach.
    pub(crate) fn evaluate(
        &self,
        patch: &Patch,
        around_m: Option<f64>,
        scratch: &mut Scratch,
        hits: &mut Vec<Hit>,
    ) -> bool {
        hits.clear();
        for part in &self.parts {
            let Scratch {
                positions,
                candidates,
                crossings,
                pieces,
            } = scratch;
            patch.positions(&part.frame, positions);
            let (centre, radius) = positions.disc();
            let reach = self.reach_m + around_m.unwrap_or(0.0);
            let distance = part.envelope.gather(centre, radius, reach, candidates);
            let crosses = distance <= radius + SLACK_M;
            let reached = distance <= reach + radius + SLACK_M;
            // One answer for all of the patch where no boundary passes.
            let all_inside = match &part.interior {
                Interior::Area { rings, .. } if !crosses => Some(rings.contains(centre)),
                Interior::Area { .. } | Interior::Strip(_) => None,
            };
            match &part.interior {
                Interior::Area { rings, heights } => {
                    if all_inside == Some(false) && !reached {
                        continue;
                    }
                    if all_inside.is_none() {
                        rings.gather(positions.min, positions.max, crossings);
                    }
                    if let AreaHeights::Tin(tin) = heights {
                        tin.gather(positions.min, positions.max, pieces);
                    }
                }
                Interior::Strip(strip) => {
                    strip.gather(centre, radius, pieces);
                    if pieces.is_empty() && !reached {
                        continue;
                    }
                }
            }
            hits.resize(patch.len(), Hit::NOTHING);
            for (p, hit) in positions.points.iter().zip(hits.iter_mut()) {
                let (inside_m, axis_m) = match &part.interior {
                    Interior::Area { rings, heights } => {
                        let inside =
                            all_inside.unwrap_or_else(|| rings.contains_given(*p, crossings));
                        let height = inside.then(|| heights.at(*p, pieces)).flatten();
                        (height, 0.0)
                    }
                    Interior::Strip(strip) => match strip.at(*p, pieces) {
                        Some((axis_m, height_m)) => (Some(height_m), axis_m),
                        None => (None, f64::INFINITY),
                    },
                };
                if inside_m.is_some() && (hit.inside_m.is_none() || axis_m < hit.axis_m) {
                    (hit.inside_m, hit.axis_m) = (inside_m, axis_m);
                }
                if reached && (inside_m.is_none() || around_m.is_some()) {
                    hit.sides = hit.sides.and(part.envelope.sides(*p, candidates));
                }
            }
        }
        !hits.is_empty()
    }

    /// Lowest and highest height that sides leave at a place outside, and whether the boundary is
    /// too steep there, so that the nearest part of it decides; `None` beyond the reach.
    #[inline]
    pub(crate) fn limits(&self, sides: &Sides) -> Option<(f64, f64, bool)> {
        let (cut, fill) = self.slopes?;
        if sides.distance_m > self.reach_m {
            return None;
        }
        let steep = sides.lower_m > sides.upper_m;
        let (low, high) = if steep {
            (
                sides.nearest_m - fill * sides.distance_m,
                sides.nearest_m + cut * sides.distance_m,
            )
        } else {
            (sides.lower_m, sides.upper_m)
        };
        Some((
            if self.raises { low } else { f64::NEG_INFINITY },
            if self.lowers { high } else { f64::INFINITY },
            steep,
        ))
    }

    /// Share of a sample of side `spacing_m` that the element covers, with its slopes, and the height
    /// that it brings there, from what it says at the sample's centre.
    pub(crate) fn cover(&self, hit: &Hit, before_m: f64, spacing_m: f64) -> (f64, f64) {
        let target = hit.sides.nearest_m + self.mean_above_edge_m;
        let rise = target - before_m;
        if !rise.is_finite() || (rise > 0.0 && !self.raises) || (rise < 0.0 && !self.lowers) {
            return (0.0, target);
        }
        let run = self.slopes.map_or(0.0, |(cut, fill)| {
            let slope = if rise > 0.0 { fill } else { cut };
            (rise.abs() / slope).min(self.reach_m)
        });
        let half = self.width_m / 2.0;
        let signed = if hit.inside_m.is_some() {
            -hit.sides.distance_m
        } else {
            hit.sides.distance_m
        };
        let at = half + signed;
        // Integral from the middle of the section of what it covers.
        let covered = |u: f64| {
            let v = (u.abs() - half).clamp(0.0, run);
            let slope = if run > 0.0 {
                v - v * v / (2.0 * run)
            } else {
                0.0
            };
            (u.abs().min(half) + slope).copysign(u)
        };
        let across = (covered(at + spacing_m / 2.0) - covered(at - spacing_m / 2.0)) / spacing_m;
        let along = ((self.length_m + run) / spacing_m).min(1.0);
        ((across * along).clamp(0.0, 1.0), target)
    }
}

impl AreaHeights {
    #[inline]
    fn at(&self, p: DVec2, pieces: &[u32]) -> Option<f64> {
        match self {
            Self::Level(height_m) => Some(*height_m),
            Self::Plane {
                at,
                height_m,
                gradient,
            } => Some(height_m + gradient.dot(p - *at)),
            Self::Tin(tin) => tin.height_m(p, pieces),
        }
    }
}

/// Safety against rounding, metres.
const SLACK_M: f64 = 1e-6;
