//! A corridor's strip in one frame: what lies within its half width of the axis.

use glam::DVec2;

use crate::element::Section;
use crate::envelope::Segment;
use crate::tree::{Bounds, Tree};

/// A straight piece of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Axis {
    pub(crate) from: DVec2,
    pub(crate) to: DVec2,
    pub(crate) from_m: f64,
    pub(crate) to_m: f64,
    /// Tangent of half the turn to the left at either end; 0 at the ends of the corridor.
    pub(crate) turn_from: f64,
    pub(crate) turn_to: f64,
    /// Whether the corridor begins here, or ends.
    pub(crate) first: bool,
    pub(crate) last: bool,
}

/// Turns are mitred up to this tangent of their half (152°).
const SHARPEST: f64 = 4.0;

/// Tangent of half the turn from one direction to another, left positive.
pub(crate) fn half_turn(before: DVec2, after: DVec2) -> f64 {
    let (a, b) = (before.normalize_or_zero(), after.normalize_or_zero());
    let (cross, dot) = (a.perp_dot(b), a.dot(b));
    if 1.0 + dot > 1e-9 {
        (cross / (1.0 + dot)).clamp(-SHARPEST, SHARPEST)
    } else {
        SHARPEST
    }
}

/// Half of what a section covers, metres.
pub(crate) fn half_width_m(section: &Section) -> f64 {
    match *section {
        Section::Road { width_m, .. } => width_m / 2.0,
        Section::Dam { crest_width_m } => crest_width_m / 2.0,
        Section::Trench { bottom_width_m, .. } => bottom_width_m / 2.0,
        Section::Channel {
            bottom_width_m,
            depth_m,
            bank_slope,
        } => bottom_width_m / 2.0 + depth_m / bank_slope,
    }
}

/// Height above the profile at a distance across.
#[inline]
fn across_m(section: &Section, off: f64) -> f64 {
    match *section {
        Section::Road {
            crossfall_percent, ..
        } => -crossfall_percent / 100.0 * off,
        Section::Dam { .. } => 0.0,
        Section::Trench { depth_m, .. } => -depth_m,
        Section::Channel {
            bottom_width_m,
            depth_m,
            bank_slope,
        } => bank_slope * (off - bottom_width_m / 2.0).max(0.0) - depth_m,
    }
}

/// The strip.
#[derive(Clone, Debug)]
pub(crate) struct Strip {
    axes: Vec<Axis>,
    tree: Tree,
    section: Section,
    half_m: f64,
}

impl Strip {
    pub(crate) fn new(axes: Vec<Axis>, section: Section) -> Self {
        let bounds: Vec<Bounds> = axes
            .iter()
            .map(|a| Bounds::flat(a.from.min(a.to), a.from.max(a.to)))
            .collect();
        Self {
            tree: Tree::new(&bounds),
            axes,
            section,
            half_m: half_width_m(&section),
        }
    }

    /// Pieces that reach a disc, in order.
    pub(crate) fn gather(&self, centre: DVec2, radius: f64, found: &mut Vec<u32>) {
        found.clear();
        let limit = self.half_m + radius + 1e-6;
        self.tree
            .visit(|b| b.distance(centre) <= limit, |i| found.push(i));
        found.sort_unstable();
    }

    /// Distance to the axis and height at a point of the strip; `None` outside.
    pub(crate) fn at(&self, p: DVec2, found: &[u32]) -> Option<(f64, f64)> {
        // Where mitres leave a gap, or pieces are shorter than their mitres, the nearest piece counts.
        let mut best: Option<(bool, f64, f64)> = None;
        for i in found {
            let axis = &self.axes[*i as usize];
            let Some((owned, d2, height)) = self.on(axis, p) else {
                continue;
            };
            let better = best.is_none_or(|(o, d, _)| (owned && !o) || (owned == o && d2 < d));
            if better {
                best = Some((owned, d2, height));
            }
        }
        best.map(|(_, d2, height)| (d2.sqrt(), height))
    }

    /// Whether a piece owns a point of its strip, the squared distance from its axis, and the height.
    #[inline]
    fn on(&self, axis: &Axis, p: DVec2) -> Option<(bool, f64, f64)> {
        let d = axis.to - axis.from;
        let length = d.length();
        let along = d / length;
        let t = (p - axis.from).dot(along);
        let u = along.perp_dot(p - axis.from);
        let away = t - t.clamp(0.0, length);
        let d2 = away * away + u * u;
        if d2 > self.half_m * self.half_m || (axis.first && t < 0.0) || (axis.last && t > length) {
            return None;
        }
        let (low, high) = (u * axis.turn_from, length - u * axis.turn_to);
        let owned = low < high && t >= low && t <= high;
        let share = self.station(axis, length, t, u) / length;
        let profile = axis.from_m + share * (axis.to_m - axis.from_m);
        Some((owned, d2, profile + across_m(&self.section, u.abs())))
    }

    /// Lengths at both ends of a piece within which stations are bent towards the mitres.
    #[inline]
    fn bends(&self, axis: &Axis, length: f64) -> (f64, f64) {
        let of = |turn: f64| (2.0 * self.half_m * turn.abs()).min(length / 2.0);
        (of(axis.turn_from), of(axis.turn_to))
    }

    /// The station along a piece to which a point belongs: `t` itself away from the bends; at a mitre
    /// the corner's, so that heights do not jump from piece to piece.
    #[inline]
    fn station(&self, axis: &Axis, length: f64, t: f64, u: f64) -> f64 {
        let (first, last) = self.bends(axis, length);
        let (low, high) = (u * axis.turn_from, length - u * axis.turn_to);
        let station = if t < first && low < first {
            first * (t - low) / (first - low)
        } else if t > length - last && high > length - last {
            length - last * (high - t) / (high - (length - last))
        } else {
            t
        };
        station.clamp(0.0, length)
    }

    /// Height of a piece's surface at a point, mitres or not.
    fn height_on(&self, axis: &Axis, t: f64, u: f64) -> f64 {
        let length = (axis.to - axis.from).length();
        let share = self.station(axis, length, t, u) / length;
        axis.from_m + share * (axis.to_m - axis.from_m) + across_m(&self.section, u.abs())
    }

    /// The boundary: both sides, round outer corners, ends. `before` is the piece that ends where the
    /// strip's first piece begins, if another strip holds it.
    pub(crate) fn boundary(&self, before: Option<&Axis>) -> Vec<Segment> {
        let mut all = Vec::new();
        for (i, axis) in self.axes.iter().enumerate() {
            let length = (axis.to - axis.from).length();
            let along = (axis.to - axis.from) / length;
            let left = along.perp();
            let point = |t: f64, u: f64| axis.from + along * t + left * u;
            let mut piece = |(ta, ua): (f64, f64), (tb, ub): (f64, f64)| {
                all.push(Segment {
                    from: point(ta, ua),
                    to: point(tb, ub),
                    from_m: self.height_on(axis, ta, ua),
                    to_m: self.height_on(axis, tb, ub),
                });
            };
            for u in [self.half_m, -self.half_m] {
                let low = (u * axis.turn_from).max(0.0);
                let high = (length - u * axis.turn_to).min(length);
                let (first, last) = self.bends(axis, length);
                let mut stops = [low, first.max(low), (length - last).min(high), high];
                stops[2] = stops[2].max(stops[1]);
                for pair in stops.windows(2).filter(|pair| pair[0] < pair[1]) {
                    piece((pair[0], u), (pair[1].min(high), u));
                }
            }
            let mut across = vec![-self.half_m, 0.0, self.half_m];
            if let Section::Channel { bottom_width_m, .. } = self.section {
                across.splice(1..2, [-bottom_width_m / 2.0, bottom_width_m / 2.0]);
            }
            for (ends, t) in [(axis.first, 0.0), (axis.last, length)] {
                for pair in across.windows(2).filter(|_| ends) {
                    piece((t, pair[0]), (t, pair[1]));
                }
            }
            let previous = if i == 0 {
                before
            } else {
                Some(&self.axes[i - 1])
            };
            if let Some(previous) = previous.filter(|_| !axis.first) {
                self.corner(previous, axis, &mut all);
            }
        }
        all
    }

    /// The round outer corner between two pieces.
    fn corner(&self, before: &Axis, after: &Axis, all: &mut Vec<Segment>) {
        let a = (before.to - before.from).normalize_or_zero();
        let b = (after.to - after.from).normalize_or_zero();
        let turn = libm::atan2(a.perp_dot(b), a.dot(b));
        if turn == 0.0 {
            return;
        }
        // The outer side is right of a left turn.
        let u = if turn > 0.0 {
            -self.half_m
        } else {
            self.half_m
        };
        let length = (before.to - before.from).length();
        // 3° a step: the arc is off its chord by 0.03 % of the half width.
        let steps = libm::ceil(turn.abs() / 0.052) as usize;
        let steps = (steps.max(1) * 2).min(128);
        let corner = |k: usize| {
            let angle = turn * k as f64 / steps as f64;
            let (sin, cos) = libm::sincos(angle);
            let out = a.perp().rotate(DVec2::new(cos, sin)) * u;
            let p = after.from + out;
            // The bisector halves the corner between both pieces.
            let height = if k * 2 <= steps {
                let d = p - before.from;
                self.height_on(before, d.dot(a).max(length), a.perp_dot(d))
            } else {
                let d = p - after.from;
                self.height_on(after, d.dot(b), b.perp_dot(d))
            };
            (p, height)
        };
        for k in 0..steps {
            let ((from, from_m), (to, to_m)) = (corner(k), corner(k + 1));
            all.push(Segment {
                from,
                to,
                from_m,
                to_m,
            });
        }
    }
}

/// Mean height of a section above its height at the boundary, metres.
pub(crate) fn mean_above_edge_m(section: &Section) -> f64 {
    let half = half_width_m(section);
    let edge = across_m(section, half);
    let mean = match *section {
        Section::Road { .. } => across_m(section, half / 2.0),
        Section::Dam { .. } | Section::Trench { .. } => edge,
        Section::Channel {
            bottom_width_m,
            depth_m,
            ..
        } => {
            let bank = half - bottom_width_m / 2.0;
            if half > 0.0 {
                -depth_m * (bottom_width_m / 2.0 + bank / 2.0) / half
            } else {
                0.0
            }
        }
    };
    mean - edge
}
