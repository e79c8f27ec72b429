//! Areas: rings, what they enclose, and the boundary that is left once crossings are cut.

use glam::DVec2;

use crate::tree::{Bounds, Tree};

/// A directed edge of a ring.
#[derive(Clone, Copy, Debug)]
struct RingEdge {
    from: DVec2,
    to: DVec2,
    hole: bool,
}

/// The area inside an outline and outside of all holes. Inside is what a ring goes around at all
/// (non-zero winding), so that a crossing outline loses nothing.
#[derive(Clone, Debug)]
pub(crate) struct Rings {
    edges: Vec<RingEdge>,
    tree: Tree,
}

/// Edges that can decide whether points of a rectangle lie inside, and how often the others go
/// around all of it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Crossings {
    edges: Vec<u32>,
    outline: i32,
    holes: i32,
}

/// Twice the signed area of a ring.
pub(crate) fn twice_area(ring: &[DVec2]) -> f64 {
    let Some(&origin) = ring.first() else {
        return 0.0;
    };
    (0..ring.len())
        .map(|i| (ring[i] - origin).perp_dot(ring[(i + 1) % ring.len()] - origin))
        .sum()
}

/// Length around a ring.
pub(crate) fn perimeter(ring: &[DVec2]) -> f64 {
    (0..ring.len())
        .map(|i| (ring[(i + 1) % ring.len()] - ring[i]).length())
        .sum()
}

/// How a directed edge changes the winding of a point left of which it passes upward (1) or downward
/// (−1): half-open, so that every point is decided.
#[inline]
fn winding(from: DVec2, to: DVec2, p: DVec2) -> i32 {
    if (from.y <= p.y) == (to.y <= p.y) {
        return 0;
    }
    let side = (to - from).perp_dot(p - from);
    if from.y <= p.y {
        i32::from(side > 0.0)
    } else {
        -i32::from(side < 0.0)
    }
}

impl Rings {
    /// `holes` count by what they enclose, whichever way round they go.
    pub(crate) fn new(outline: &[DVec2], holes: &[Vec<DVec2>]) -> Self {
        let mut edges = Vec::new();
        for (ring, hole) in
            core::iter::once((outline, false)).chain(holes.iter().map(|h| (h.as_slice(), true)))
        {
            let backward = hole && twice_area(ring) < 0.0;
            for i in 0..ring.len() {
                let (a, b) = (ring[i], ring[(i + 1) % ring.len()]);
                let (from, to) = if backward { (b, a) } else { (a, b) };
                edges.push(RingEdge { from, to, hole });
            }
        }
        let bounds: Vec<Bounds> = edges
            .iter()
            .map(|e| Bounds::flat(e.from.min(e.to), e.from.max(e.to)))
            .collect();
        Self {
            tree: Tree::new(&bounds),
            edges,
        }
    }

    /// Whether a point lies inside.
    pub(crate) fn contains(&self, p: DVec2) -> bool {
        let (mut outline, mut holes) = (0, 0);
        self.tree.visit(
            |b| b.max.x >= p.x && b.min.y <= p.y && b.max.y >= p.y,
            |i| {
                let e = &self.edges[i as usize];
                let w = winding(e.from, e.to, p);
                if e.hole { holes += w } else { outline += w }
            },
        );
        outline != 0 && holes == 0
    }

    /// Collects what decides whether points between `min` and `max` lie inside.
    pub(crate) fn gather(&self, min: DVec2, max: DVec2, found: &mut Crossings) {
        found.edges.clear();
        (found.outline, found.holes) = (0, 0);
        self.tree.visit(
            |b| b.max.x >= min.x && b.min.y <= max.y && b.max.y >= min.y,
            |i| {
                let e = &self.edges[i as usize];
                let (low, high) = (e.from.y.min(e.to.y), e.from.y.max(e.to.y));
                // Beyond the rectangle for sure, and past all of its rows: one answer for all points.
                if e.from.x.min(e.to.x) > max.x && low <= min.y && high > max.y {
                    let w = winding(e.from, e.to, min);
                    if e.hole {
                        found.holes += w;
                    } else {
                        found.outline += w;
                    }
                } else {
                    found.edges.push(i);
                }
            },
        );
    }

    /// Whether a point lies inside, from what was gathered around it.
    #[inline]
    pub(crate) fn contains_given(&self, p: DVec2, found: &Crossings) -> bool {
        let (mut outline, mut holes) = (found.outline, found.holes);
        for i in &found.edges {
            let e = &self.edges[*i as usize];
            let w = winding(e.from, e.to, p);
            if e.hole { holes += w } else { outline += w }
        }
        outline != 0 && holes == 0
    }
}

/// A place where segments meet: on segment `on` at `at` (0 to 1).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cut {
    pub(crate) on: u32,
    pub(crate) at: f64,
    pub(crate) point: DVec2,
}

/// Most crossings that are cut; beyond them the rest stays as it is, for a scribble may have as many as
/// the square of its edges.
const MOST_CUTS: usize = 2_000_000;

/// All places where segments cross, or one ends on another, apart from ends that they share by
/// `neighbours` (consecutive segments of a ring). Sorted by segment and place.
pub(crate) fn cuts(segments: &[(DVec2, DVec2)], neighbours: impl Fn(u32, u32) -> bool) -> Vec<Cut> {
    let bounds: Vec<Bounds> = segments
        .iter()
        .map(|(a, b)| Bounds::flat(a.min(*b), a.max(*b)))
        .collect();
    let tree = Tree::new(&bounds);
    let mut all = Vec::new();
    for (i, (a, b)) in segments.iter().enumerate() {
        if all.len() > MOST_CUTS {
            break;
        }
        tree.visit(
            |other| other.overlaps(&bounds[i]),
            |k| {
                if k as usize > i {
                    let (c, d) = segments[k as usize];
                    let shares = neighbours(i as u32, k);
                    meet((i as u32, *a, *b), (k, c, d), shares, &mut all);
                }
            },
        );
    }
    all.sort_by(|x, y| x.on.cmp(&y.on).then(x.at.total_cmp(&y.at)));
    all
}

/// Adds where two segments meet, on both.
fn meet(
    (i, a, b): (u32, DVec2, DVec2),
    (k, c, d): (u32, DVec2, DVec2),
    shares_end: bool,
    all: &mut Vec<Cut>,
) {
    let (ab, cd) = (b - a, d - c);
    let cross = ab.perp_dot(cd);
    let (length, other) = (ab.length(), cd.length());
    if length == 0.0 || other == 0.0 {
        return;
    }
    // Ends closer than this to a segment lie on it.
    let close = 1e-9 * (length + other) + 1e-9;
    let mut ends = |on: u32, from: DVec2, along: DVec2, size: f64, point: DVec2| {
        let t = (point - from).dot(along) / (size * size);
        let off = (point - from).perp_dot(along).abs() / size;
        if off <= close && t * size > close && (1.0 - t) * size > close {
            all.push(Cut { on, at: t, point });
            return true;
        }
        false
    };
    let touching = [
        ends(i, a, ab, length, c),
        ends(i, a, ab, length, d),
        ends(k, c, cd, other, a),
        ends(k, c, cd, other, b),
    ];
    if touching.contains(&true) || cross == 0.0 || shares_end {
        return;
    }
    let t = (c - a).perp_dot(cd) / cross;
    let u = (c - a).perp_dot(ab) / cross;
    if !(0.0..=1.0).contains(&t) || !(0.0..=1.0).contains(&u) {
        return;
    }
    // At common ends nothing needs cutting.
    let inner = |t: f64, size: f64| t * size > close && (1.0 - t) * size > close;
    let point = a + ab * t;
    if inner(t, length) {
        all.push(Cut {
            on: i,
            at: t,
            point,
        });
    }
    if inner(u, other) {
        all.push(Cut {
            on: k,
            at: u,
            point,
        });
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn v(x: f64, y: f64) -> DVec2 {
        DVec2::new(x, y)
    }

    #[test]
    fn both_lobes_of_a_bow_tie_and_the_heart_of_a_star_are_inside() {
        let tie = Rings::new(&[v(0.0, 0.0), v(2.0, 2.0), v(2.0, 0.0), v(0.0, 2.0)], &[]);
        assert!(tie.contains(v(0.2, 1.0)) && tie.contains(v(1.8, 1.0)));
        assert!(!tie.contains(v(1.0, 1.8)) && !tie.contains(v(1.0, 0.2)));
        let star: Vec<DVec2> = (0..5)
            .map(|k| {
                let angle = f64::from(k * 2) * core::f64::consts::TAU / 5.0;
                v(libm::cos(angle), libm::sin(angle))
            })
            .collect();
        assert!(Rings::new(&star, &[]).contains(v(0.01, 0.02)));
    }

    #[test]
    fn a_hole_counts_whichever_way_round_it_goes() {
        let square = [v(0.0, 0.0), v(9.0, 0.0), v(9.0, 9.0), v(0.0, 9.0)];
        let hole = vec![v(3.0, 3.0), v(6.0, 3.0), v(6.0, 6.0), v(3.0, 6.0)];
        let backward: Vec<DVec2> = hole.iter().rev().copied().collect();
        for hole in [hole, backward] {
            let rings = Rings::new(&square, &[hole]);
            assert!(!rings.contains(v(4.0, 4.0)) && rings.contains(v(1.0, 4.0)));
        }
    }

    proptest! {
        #[test]
        fn what_is_gathered_for_a_rectangle_decides_every_point_of_it(
            points in prop::collection::vec((-9..9_i32, -9..9_i32), 3..30),
            x in -12.0..12.0_f64, y in -12..12_i32, w in 0.0..5.0_f64, part in 0.0..1.0_f64,
        ) {
            let ring: Vec<DVec2> = points.iter().map(|(x, y)| v(f64::from(*x), f64::from(*y))).collect();
            let rings = Rings::new(&ring, &[]);
            let min = v(x, f64::from(y));
            let mut found = Crossings::default();
            rings.gather(min, min + w, &mut found);
            for p in [min, min + w, min + w * part, v(min.x + w * part, min.y)] {
                prop_assert_eq!(rings.contains_given(p, &found), rings.contains(p));
            }
        }

        #[test]
        fn between_its_cuts_no_segment_crosses_another(
            points in prop::collection::vec((-9..9_i32, -9..9_i32, -9..9_i32, -9..9_i32), 2..20),
        ) {
            let segments: Vec<(DVec2, DVec2)> = points
                .iter()
                .map(|(a, b, c, d)| (v(f64::from(*a), f64::from(*b)), v(f64::from(*c), f64::from(*d))))
                .collect();
            let all = cuts(&segments, |_, _| false);
            let mut pieces = Vec::new();
            for (i, (a, b)) in segments.iter().enumerate() {
                let mut from = *a;
                for cut in all.iter().filter(|c| c.on == i as u32) {
                    pieces.push((from, cut.point));
                    from = cut.point;
                }
                pieces.push((from, *b));
            }
            // What crosses now does so next to an end.
            for (i, (a, b)) in pieces.iter().enumerate() {
                for (c, d) in &pieces[i + 1..] {
                    let (ab, cd) = (*b - *a, *d - *c);
                    let cross = ab.perp_dot(cd);
                    if cross.abs() < 1e-6 {
                        continue;
                    }
                    let t = (*c - *a).perp_dot(cd) / cross;
                    let u = (*c - *a).perp_dot(ab) / cross;
                    let middle = 1e-4..=1.0 - 1e-4;
                    prop_assert!(!(middle.contains(&t) && middle.contains(&u)), "{a} {b} {c} {d}");
                }
            }
        }
    }
}
