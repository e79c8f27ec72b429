//! Side slopes: envelopes of cones that stand on boundary segments.
//!
//! `upper(x) = min over b of z(b) + cut · |x − b|` and `lower(x) = max over b of z(b) − fill · |x − b|`,
//! in closed form for each segment with heights linear along it.

use glam::DVec2;

use crate::tree::{Bounds, Tree};

/// A straight piece of a boundary with heights linear along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Segment {
    pub(crate) from: DVec2,
    pub(crate) to: DVec2,
    pub(crate) from_m: f64,
    pub(crate) to_m: f64,
}

impl Segment {
    /// Rise over run along it, 0 or more; infinite for a jump in one place.
    pub(crate) fn grade(&self) -> f64 {
        let rise = (self.to_m - self.from_m).abs();
        if rise == 0.0 {
            0.0
        } else {
            rise / (self.to - self.from).length()
        }
    }

    pub(crate) fn bounds(&self) -> Bounds {
        Bounds {
            min: self.from.min(self.to),
            max: self.from.max(self.to),
            low: self.from_m.min(self.to_m),
            high: self.from_m.max(self.to_m),
        }
    }
}

/// A segment, ready for evaluation.
#[derive(Clone, Copy, Debug)]
struct Edge {
    from: DVec2,
    along: DVec2,
    length: f64,
    low_m: f64,
    /// Rise per metre along.
    rise: f64,
    /// How far before the foot of the perpendicular the lowest cone stands, per metre of distance;
    /// infinite where the segment is as steep as the slope: then it stands at its lower end.
    lead_cut: f64,
    lead_fill: f64,
}

fn lead(rise: f64, slope: f64) -> f64 {
    let share = rise / slope;
    // A difference of squares would lose all digits next to 1.
    let rest = (1.0 - share) * (1.0 + share);
    if rest > 0.0 {
        share / rest.sqrt()
    } else {
        f64::INFINITY.copysign(share)
    }
}

impl Edge {
    fn new(s: &Segment, (cut, fill): (f64, f64)) -> Self {
        let d = s.to - s.from;
        let length = d.length();
        let along = if length > 0.0 { d / length } else { DVec2::X };
        let rise = if length > 0.0 {
            (s.to_m - s.from_m) / length
        } else {
            0.0
        };
        Self {
            from: s.from,
            along,
            length,
            low_m: s.from_m,
            rise,
            lead_cut: lead(rise, cut),
            lead_fill: lead(rise, fill),
        }
    }

    /// Foot of the perpendicular along the segment, not limited to it, and distance from its line.
    #[inline]
    fn foot(&self, p: DVec2) -> (f64, f64) {
        let d = p - self.from;
        (d.dot(self.along), d.perp_dot(self.along).abs())
    }

    /// Where the extreme cone stands: `lead · off` before the foot, within the segment.
    #[inline]
    fn cone(&self, t: f64, off: f64, lead: f64) -> (f64, f64) {
        // On the line itself an infinite lead still leads to the end.
        let shift = if off > 0.0 { lead * off } else { 0.0 };
        let shift = if lead.is_infinite() { lead } else { shift };
        let at = (t - shift).clamp(0.0, self.length);
        let away = t - at;
        (
            self.low_m + self.rise * at,
            (away * away + off * off).sqrt(),
        )
    }

    #[inline]
    fn upper(&self, p: DVec2, cut: f64) -> f64 {
        let (t, off) = self.foot(p);
        let (z, d) = self.cone(t, off, self.lead_cut);
        z + cut * d
    }

    #[inline]
    fn lower(&self, p: DVec2, fill: f64) -> f64 {
        let (t, off) = self.foot(p);
        let (z, d) = self.cone(t, off, -self.lead_fill);
        z - fill * d
    }

    /// Distance, squared, and the height there.
    #[inline]
    fn nearest(&self, p: DVec2) -> (f64, f64) {
        let (t, off) = self.foot(p);
        let at = t.clamp(0.0, self.length);
        let away = t - at;
        (away * away + off * off, self.low_m + self.rise * at)
    }
}

/// What a boundary says at a place outside of its area.
#[expect(clippy::struct_field_names, reason = "a unit is part of every name")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sides {
    /// Distance to the boundary in metres.
    pub(crate) distance_m: f64,
    /// The boundary's height at the nearest place.
    pub(crate) nearest_m: f64,
    /// No slope of a fill is lower.
    pub(crate) lower_m: f64,
    /// No slope of a cut is higher.
    pub(crate) upper_m: f64,
}

impl Sides {
    /// Far from everything.
    pub(crate) const NOTHING: Self = Self {
        distance_m: f64::INFINITY,
        nearest_m: f64::NAN,
        lower_m: f64::NEG_INFINITY,
        upper_m: f64::INFINITY,
    };

    /// Of two parts of a boundary; the first counts where they are equally near.
    #[inline]
    pub(crate) fn and(self, other: Self) -> Self {
        let (distance_m, nearest_m) = if other.distance_m < self.distance_m {
            (other.distance_m, other.nearest_m)
        } else {
            (self.distance_m, self.nearest_m)
        };
        Self {
            distance_m,
            nearest_m,
            lower_m: self.lower_m.max(other.lower_m),
            upper_m: self.upper_m.min(other.upper_m),
        }
    }
}

/// All segments of a boundary in one frame.
#[derive(Clone, Debug)]
pub(crate) struct Envelope {
    edges: Vec<Edge>,
    tree: Tree,
    cut: f64,
    fill: f64,
    /// Whether all heights are one, so that the nearest place decides everything.
    level: bool,
    /// Whether slopes are wanted at all.
    slopes: bool,
}

/// Segments that can decide anything within a disc.
#[derive(Clone, Debug, Default)]
pub(crate) struct Candidates {
    nearest: Vec<u32>,
    cones: Vec<u32>,
}

/// Safety against rounding in decisions that must never lose a segment, metres.
const SLACK_M: f64 = 1e-6;

impl Envelope {
    /// `slopes` are cut and fill; `None` for walls.
    pub(crate) fn new(segments: &[Segment], slopes: Option<(f64, f64)>) -> Self {
        let (cut, fill) = slopes.unwrap_or((1.0, 1.0));
        let bounds: Vec<Bounds> = segments.iter().map(Segment::bounds).collect();
        let first = segments.first().map(|s| s.from_m);
        Self {
            edges: segments.iter().map(|s| Edge::new(s, (cut, fill))).collect(),
            tree: Tree::new(&bounds),
            cut,
            fill,
            level: segments
                .iter()
                .all(|s| Some(s.from_m) == first && Some(s.to_m) == first),
            slopes: slopes.is_some(),
        }
    }

    /// Ends of all segments.
    pub(crate) fn lines(&self) -> impl Iterator<Item = (DVec2, DVec2)> + '_ {
        let end = |e: &Edge| (e.from, e.from + e.along * e.length);
        self.edges.iter().map(end)
    }

    /// Distance from a point to the boundary.
    pub(crate) fn distance(&self, p: DVec2) -> f64 {
        self.tree
            .least(
                |b| {
                    let d = b.distance(p);
                    d * d
                },
                |i| self.edges[i as usize].nearest(p).0,
            )
            .sqrt()
    }

    /// Collects what can decide anything within `radius` of `centre`; answers the boundary's
    /// distance from the centre. Nothing is collected where all of the disc is beyond `reach`.
    pub(crate) fn gather(
        &self,
        centre: DVec2,
        radius: f64,
        reach: f64,
        found: &mut Candidates,
    ) -> f64 {
        found.nearest.clear();
        found.cones.clear();
        let distance = self.distance(centre);
        if distance > reach + radius + SLACK_M {
            return distance;
        }
        let limit = distance + 2.0 * radius + SLACK_M;
        self.tree.visit(
            |b| b.distance(centre) <= limit,
            |i| {
                if self.edges[i as usize].nearest(centre).0.sqrt() <= limit {
                    found.nearest.push(i);
                }
            },
        );
        found.nearest.sort_unstable();
        if self.level || !self.slopes {
            return distance;
        }
        let slack = SLACK_M * (1.0 + self.cut.max(self.fill));
        let upper = self.tree.least(
            |b| b.low + self.cut * b.distance(centre),
            |i| self.edges[i as usize].upper(centre, self.cut),
        );
        let lower = -self.tree.least(
            |b| self.fill * b.distance(centre) - b.high,
            |i| -self.edges[i as usize].lower(centre, self.fill),
        );
        let below = upper + 2.0 * self.cut * radius + slack;
        let above = lower - 2.0 * self.fill * radius - slack;
        self.tree.visit(
            |b| {
                let d = b.distance(centre);
                b.low + self.cut * d <= below || b.high - self.fill * d >= above
            },
            |i| {
                let e = &self.edges[i as usize];
                if e.upper(centre, self.cut) <= below || e.lower(centre, self.fill) >= above {
                    found.cones.push(i);
                }
            },
        );
        distance
    }

    /// What the boundary says at a point, from what was gathered around it. Candidates that are not
    /// needed change no bit.
    #[inline]
    pub(crate) fn sides(&self, p: DVec2, found: &Candidates) -> Sides {
        let mut best = (f64::INFINITY, f64::NAN);
        for i in &found.nearest {
            let (d2, z) = self.edges[*i as usize].nearest(p);
            if d2 < best.0 {
                best = (d2, z);
            }
        }
        let distance_m = best.0.sqrt();
        let mut sides = Sides {
            distance_m,
            nearest_m: best.1,
            ..Sides::NOTHING
        };
        if self.level && self.slopes {
            sides.lower_m = best.1 - self.fill * distance_m;
            sides.upper_m = best.1 + self.cut * distance_m;
        }
        for i in &found.cones {
            let e = &self.edges[*i as usize];
            let (t, off) = e.foot(p);
            let (z, d) = e.cone(t, off, e.lead_cut);
            sides.upper_m = sides.upper_m.min(z + self.cut * d);
            let (z, d) = e.cone(t, off, -e.lead_fill);
            sides.lower_m = sides.lower_m.max(z - self.fill * d);
        }
        sides
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn segments() -> impl Strategy<Value = Vec<Segment>> {
        let one = (
            -50.0..50.0_f64,
            -50.0..50.0_f64,
            -30.0..30.0_f64,
            -30.0..30.0_f64,
            -9.0..9.0_f64,
            -9.0..9.0_f64,
        );
        prop::collection::vec(one, 1..40).prop_map(|all| {
            all.into_iter()
                .map(|(x, y, dx, dy, a, b)| Segment {
                    from: DVec2::new(x, y),
                    to: DVec2::new(x + dx, y + dy),
                    from_m: a,
                    to_m: b,
                })
                .collect()
        })
    }

    proptest! {
        #[test]
        fn the_closed_form_is_the_extreme_over_the_cones(
            segments in segments(), x in -99.0..99.0_f64, y in -99.0..99.0_f64,
            cut in 0.05..5.0_f64, fill in 0.05..5.0_f64,
        ) {
            let p = DVec2::new(x, y);
            let envelope = Envelope::new(&segments, Some((cut, fill)));
            let mut found = Candidates::default();
            envelope.gather(p, 0.0, f64::INFINITY, &mut found);
            let sides = envelope.sides(p, &found);
            let (mut upper, mut lower, mut near) = (f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY);
            let parts = 2000;
            for s in &segments {
                for k in 0..=parts {
                    let t = f64::from(k) / f64::from(parts);
                    let z = s.from_m + t * (s.to_m - s.from_m);
                    let d = (s.from + (s.to - s.from) * t - p).length();
                    upper = upper.min(z + cut * d);
                    lower = lower.max(z - fill * d);
                    near = near.min(d);
                }
            }
            let close = 45.0 / f64::from(parts) * (1.0 + cut.max(fill)) + 0.03;
            prop_assert!(sides.upper_m <= upper + 1e-9 && sides.upper_m > upper - close, "{sides:?} {upper}");
            prop_assert!(sides.lower_m >= lower - 1e-9 && sides.lower_m < lower + close, "{sides:?} {lower}");
            prop_assert!(sides.distance_m <= near + 1e-9 && sides.distance_m > near - close);
        }

        #[test]
        fn what_is_gathered_for_a_disc_decides_every_point_of_it(
            segments in segments(), x in -99.0..99.0_f64, y in -99.0..99.0_f64, radius in 0.0..30.0_f64,
            angle in 0.0..6.3_f64, part in 0.0..1.0_f64,
        ) {
            let centre = DVec2::new(x, y);
            let p = centre + DVec2::new(libm::cos(angle), libm::sin(angle)) * radius * part;
            let envelope = Envelope::new(&segments, Some((0.5, 0.7)));
            let (mut around, mut here) = (Candidates::default(), Candidates::default());
            envelope.gather(centre, radius, f64::INFINITY, &mut around);
            envelope.gather(p, 0.0, f64::INFINITY, &mut here);
            prop_assert_eq!(envelope.sides(p, &around), envelope.sides(p, &here));
        }
    }
}
