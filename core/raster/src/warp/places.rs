//! Places of the samples of a square in a source: between four nodes or nine, or each by itself.

use glam::{DVec2, I64Vec2};

use crate::kernel::Lane;

/// Places of the samples of a patch whose sides are powers of two (or a single row).
#[derive(Clone, Debug)]
pub(crate) enum Places<P> {
    /// Bilinear: of the first sample, of the one a patch's width of columns east, and the same its height
    /// of rows south; for a single row both are the same.
    Corners([P; 4]),
    /// Biquadratic: at the corners as above, and in the middles between them.
    Nine(Nine<P>),
    /// Of every sample, row by row.
    Each(Vec<P>),
}

/// Nodes of a square: at its corners, the middles of its edges and its centre, row by row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nine<P = DVec2>(pub(crate) [P; 9]);

/// Weights of the nodes at 0, ½ and 1 for a place between them.
fn parabola(u: f64) -> [f64; 3] {
    [
        (2.0 * u - 1.0) * (u - 1.0),
        4.0 * u * (1.0 - u),
        u * (2.0 * u - 1.0),
    ]
}

impl Nine {
    /// Its four quarters, each by its column and row, with its corners.
    pub(crate) fn quarters(&self) -> [(I64Vec2, [DVec2; 4]); 4] {
        core::array::from_fn(|quarter| {
            let (x, y) = (quarter % 2, quarter / 2);
            let i = 3 * y + x;
            let corners = [0, 1, 3, 4].map(|k| self.0[i + k]);
            (I64Vec2::new(x as i64, y as i64), corners)
        })
    }

    /// How far a bilinear surface through the corners misses the other nodes, at most; NaN where one of
    /// them has no place.
    pub(crate) fn miss(&self) -> DVec2 {
        let [nw, n, ne, w, centre, e, sw, s, se] = self.0;
        largest([
            centre - (nw + ne + sw + se) * 0.25,
            n - (nw + ne) * 0.5,
            w - (nw + sw) * 0.5,
            e - (ne + se) * 0.5,
            s - (sw + se) * 0.5,
        ])
    }

    /// How far the parabolas through nine nodes around miss these nodes, which are those of a quarter.
    pub(crate) fn missed_by(&self, around: &Self, quarter: I64Vec2) -> DVec2 {
        largest([1, 3, 4, 5, 7].map(|i| {
            let in_quarter = 0.5 * DVec2::new((i % 3) as f64, (i / 3) as f64);
            self.0[i] - around.at((quarter.as_dvec2() + in_quarter) * 0.5)
        }))
    }

    /// The place at a share of the way along both sides.
    fn at(&self, share: DVec2) -> DVec2 {
        let (across, down) = (parabola(share.x), parabola(share.y));
        (0..9)
            .map(|i| self.0[i] * (across[i % 3] * down[i / 3]))
            .sum()
    }
}

/// The largest of differences along each axis.
fn largest(differences: [DVec2; 5]) -> DVec2 {
    differences.into_iter().fold(DVec2::ZERO, |all, one| {
        // Not `max`, which would hide NaN.
        let larger = |a: f64, b: f64| if a > b || a.is_nan() { a } else { b };
        DVec2::new(larger(all.x, one.x.abs()), larger(all.y, one.y.abs()))
    })
}

impl Places<DVec2> {
    /// Least and greatest coordinates of all places; `None` where none has any. Nodes of a square that
    /// are no numbers leave it with those of the others.
    pub(crate) fn bounds(&self) -> Option<(DVec2, DVec2)> {
        let (nodes, swing): (&[DVec2], DVec2) = match self {
            Self::Corners(corners) => (corners, DVec2::ZERO),
            // A parabola swings past its nodes by a quarter at most of what its middle misses the straight
            // line by; along both sides that stays below the largest miss.
            Self::Nine(nine) => (&nine.0, nine.miss()),
            Self::Each(each) => (each, DVec2::ZERO),
        };
        let known = |p: &DVec2| p.is_finite() && p.abs().max_element() < 1e12;
        let mut known = nodes.iter().copied().filter(known);
        let one = known.next()?;
        let (low, high) = known.fold((one, one), |(low, high), p| (low.min(p), high.max(p)));
        Some((low - swing, high + swing))
    }

    /// The place of the sample `i`, `share` of the way along both sides.
    pub(crate) fn at(&self, i: usize, share: DVec2) -> DVec2 {
        match self {
            Self::Corners([nw, ne, sw, se]) => {
                let (west, east) = (*nw + (*sw - *nw) * share.y, *ne + (*se - *ne) * share.y);
                west + (east - west) * share.x
            }
            Self::Nine(nine) => nine.at(share),
            Self::Each(each) => each[i],
        }
    }

    /// The same in other coordinates.
    pub(crate) fn map<P>(self, to: impl Fn(DVec2) -> P) -> Places<P> {
        match self {
            Self::Corners(corners) => Places::Corners(corners.map(to)),
            Self::Nine(Nine(nodes)) => Places::Nine(Nine(nodes.map(to))),
            Self::Each(each) => Places::Each(each.into_iter().map(to).collect()),
        }
    }
}

impl Places<[f32; 2]> {
    /// Places of the samples of a row of a patch of a width and height from `column` on, as many as the
    /// patch has; what further lanes hold is unspecified.
    #[inline(always)]
    pub(crate) fn row(
        &self,
        (width, height): (usize, usize),
        column: usize,
        row: usize,
        x: &mut Lane,
        y: &mut Lane,
    ) {
        // Exact: sides are powers of two.
        let (pitch, v) = (1.0 / width as f32, row as f32 / height as f32);
        match self {
            Self::Corners([nw, ne, sw, se]) => {
                for (axis, out) in [x, y].into_iter().enumerate() {
                    let west = nw[axis] + (sw[axis] - nw[axis]) * v;
                    let east = ne[axis] + (se[axis] - ne[axis]) * v;
                    let slope = (east - west) * pitch;
                    for (i, place) in out.iter_mut().enumerate() {
                        *place = west + slope * ((column + i) as u32 as f32);
                    }
                }
            }
            Self::Nine(Nine(nodes)) => {
                for (axis, out) in [x, y].into_iter().enumerate() {
                    let node = |i: usize| nodes[i][axis];
                    let at = |i: usize| {
                        let [start, slope, bend] = powers([node(i), node(i + 3), node(i + 6)]);
                        start + v * (slope + v * bend)
                    };
                    let [start, slope, bend] = powers([at(0), at(1), at(2)]);
                    for (i, place) in out.iter_mut().enumerate() {
                        let u = (column + i) as u32 as f32 * pitch;
                        *place = start + u * (slope + u * bend);
                    }
                }
            }
            Self::Each(places) => {
                let places = &places[row * width + column..(row + 1) * width];
                for ((x, y), place) in x.iter_mut().zip(y).zip(places) {
                    [*x, *y] = *place;
                }
            }
        }
    }
}

/// Coefficients of 1, u and u² of the parabola through values at 0, ½ and 1.
#[inline(always)]
fn powers([start, middle, end]: [f32; 3]) -> [f32; 3] {
    let (rise, sag) = (end - start, middle - start);
    [start, 4.0 * sag - rise, 2.0 * (rise - 2.0 * sag)]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn parabolas_are_followed_by_rows_and_by_single_places(
            c in prop::array::uniform9(-3.0..3.0_f64), column in 0..16_usize, row in 0..16_usize,
        ) {
            let surface = |p: DVec2| {
                let z = [1.0, p.x, p.x * p.x];
                let w = [1.0, p.y, p.y * p.y];
                (0..9).map(|i| c[i] * z[i % 3] * w[i / 3]).sum::<f64>()
            };
            let place = |p: DVec2| DVec2::new(surface(p), p.x - surface(p));
            let nodes = core::array::from_fn(|i| place(0.5 * DVec2::new((i % 3) as f64, (i / 3) as f64)));
            let places = Places::Nine(Nine(nodes));
            let share = DVec2::new(column as f64, row as f64) / 16.0;
            let exact = place(share);
            prop_assert!(places.at(0, share).abs_diff_eq(exact, 1e-12));
            let (low, high) = places.bounds().unwrap();
            prop_assert!(exact.cmpge(low - 1e-12).all() && exact.cmple(high + 1e-12).all());
            let (mut x, mut y): (Lane, Lane) = Default::default();
            places.map(|p| p.as_vec2().to_array()).row((16, 16), column, row, &mut x, &mut y);
            prop_assert!((f64::from(x[0]) - exact.x).abs() < 1e-4 && (f64::from(y[0]) - exact.y).abs() < 1e-4);
        }
    }

    #[test]
    fn a_node_without_a_place_is_never_within_reach() {
        let mut nodes = [DVec2::ZERO; 9];
        assert_eq!(Nine(nodes).miss(), DVec2::ZERO);
        for i in 0..9 {
            nodes[i] = DVec2::NAN;
            assert!(Nine(nodes).miss().is_nan());
            nodes[i] = DVec2::ZERO;
        }
    }
}
