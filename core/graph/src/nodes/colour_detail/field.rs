//! Colours of a rectangle, and their refinement by two that keeps means.

use glam::I64Vec2;
use relievo_planet::SampleRect;

/// Three planes of linear light over a rectangle of samples.
#[derive(Clone, Debug)]
pub(super) struct Field {
    rect: SampleRect,
    planes: [Vec<f32>; 3],
}

/// North-west, north-east, south-west, south-east.
pub(super) type Quad = [f32; 4];

/// The smallest rectangle of coarse samples that covers `fine` ones, two by two each.
pub(super) fn covering(fine: &SampleRect) -> SampleRect {
    let two = I64Vec2::splat(2);
    SampleRect::new(fine.min.div_euclid(two), (fine.max + 1).div_euclid(two))
}

/// The samples, two by two each, that `coarse` ones cover.
pub(super) fn covered(coarse: &SampleRect) -> SampleRect {
    SampleRect::new(coarse.min * 2, coarse.max * 2)
}

/// What a sample is above its parent, from the parent's neighbours: the four add up to nothing.
///
/// Average interpolation of degree 2 in both directions: where the parents are means of a quadratic
/// over their areas so are the children, and refined without end the result is continuous.
///
/// Source: \[Don93\].
#[inline(always)]
fn rise(around: &[[f32; 3]; 3]) -> Quad {
    let [[nw, n, ne], [w, _, e], [sw, s, se]] = *around;
    let east = (e - w) * 0.125;
    let south = (s - n) * 0.125;
    let twist = ((se - sw) - (ne - nw)) * (1.0 / 64.0);
    [
        twist - east - south,
        east - south - twist,
        south - east - twist,
        east + south + twist,
    ]
}

/// What two by two samples are above the smooth refinement of their own means: nothing that coarser samples
/// show, and nothing on average.
#[inline(always)]
pub(super) fn above_smooth(quad: Quad, around_means: &[[f32; 3]; 3]) -> Quad {
    let mean = around_means[1][1];
    let rise = rise(around_means);
    core::array::from_fn(|k| (quad[k] - mean) - rise[k])
}

/// The sample `at` of a plane and the eight around it.
#[inline(always)]
pub(super) fn around(plane: &[f32], stride: usize, at: usize) -> [[f32; 3]; 3] {
    let row = |first: usize| [plane[first], plane[first + 1], plane[first + 2]];
    [row(at - stride - 1), row(at - 1), row(at + stride - 1)]
}

/// The two by two samples of a plane under sample `at` of one that is half as wide.
#[inline(always)]
pub(super) fn quad(plane: &[f32], half_stride: usize, at: usize) -> Quad {
    let (row, column) = (at / half_stride, at % half_stride);
    let first = 4 * row * half_stride + 2 * column;
    let south = first + 2 * half_stride;
    [
        plane[first],
        plane[first + 1],
        plane[south],
        plane[south + 1],
    ]
}

/// Means of two by two samples of a plane with an even number of rows and columns.
pub(super) fn reduced(plane: &[f32], width: usize) -> Vec<f32> {
    let mut out = vec![0.0; plane.len() / 4];
    let rows = plane.chunks_exact((2 * width).max(1));
    for (rows, out) in rows.zip(out.chunks_exact_mut((width / 2).max(1))) {
        let (north, south) = rows.split_at(width);
        let pairs = north.chunks_exact(2).zip(south.chunks_exact(2));
        for (out, (n, s)) in out.iter_mut().zip(pairs) {
            *out = ((n[0] + n[1]) + (s[0] + s[1])) * 0.25;
        }
    }
    out
}

/// The largest share of `change`, at most 1, that leaves `from` + share · `change` in `low..=high`.
#[inline(always)]
fn share(from: f32, change: f32, low: f32, high: f32) -> f32 {
    let room = if change < 0.0 {
        low - from
    } else {
        high - from
    };
    // Also where there is no change at all.
    if change.abs() <= room.abs() {
        1.0
    } else {
        (room / change).max(0.0)
    }
}

impl Field {
    /// All 0.
    pub(super) fn new(rect: SampleRect) -> Self {
        let plane = || vec![0.0; rect.area() as usize];
        Self {
            rect,
            planes: [plane(), plane(), plane()],
        }
    }

    pub(super) fn rect(&self) -> SampleRect {
        self.rect
    }

    pub(super) fn len(&self) -> usize {
        self.planes[0].len()
    }

    pub(super) fn plane(&self, plane: usize) -> &[f32] {
        &self.planes[plane]
    }

    /// Where a sample inside is kept.
    pub(super) fn at(&self, sample: I64Vec2) -> usize {
        debug_assert!(self.rect.contains(sample), "{sample} of {:?}", self.rect);
        let from = sample - self.rect.min;
        (from.y * self.rect.width() + from.x) as usize
    }

    #[inline(always)]
    pub(super) fn get(&self, at: usize) -> [f32; 3] {
        [self.planes[0][at], self.planes[1][at], self.planes[2][at]]
    }

    #[inline(always)]
    pub(super) fn set(&mut self, at: usize, colour: [f32; 3]) {
        for (plane, v) in self.planes.iter_mut().zip(colour) {
            plane[at] = v;
        }
    }

    /// The same colours over a rectangle inside.
    pub(super) fn part(&self, rect: SampleRect) -> Self {
        let mut out = Self::new(rect);
        let width = rect.width() as usize;
        for (row, y) in (rect.min.y..rect.max.y).enumerate() {
            let from = self.at(I64Vec2::new(rect.min.x, y));
            for (plane, out) in self.planes.iter().zip(&mut out.planes) {
                out[row * width..(row + 1) * width].copy_from_slice(&plane[from..from + width]);
            }
        }
        out
    }

    /// Means of two by two samples of a field over what `self`'s rectangle would cover.
    fn reduced(&self) -> Self {
        let rect = covering(&self.rect);
        debug_assert_eq!(covered(&rect), self.rect, "whole quads");
        let width = self.rect.width() as usize;
        let planes = core::array::from_fn(|plane| reduced(&self.planes[plane], width));
        Self { rect, planes }
    }

    /// The colours at twice the resolution, with `detail` added: everywhere two by two samples have
    /// the mean of the one that covers them (but for rounding).
    ///
    /// `detail` is given over all that `self` covers; what of it `self` can show already (its own
    /// average interpolation) is left out. The result covers all samples of `self` but the outermost.
    pub(super) fn refined(&self, detail: Option<&Self>) -> Self {
        let stride = self.rect.width() as usize;
        let Some(detail) = detail else {
            return self.refined_by(None::<&fn(usize) -> [Quad; 3]>);
        };
        debug_assert_eq!(detail.rect, covered(&self.rect), "detail for all samples");
        let means = detail.reduced();
        self.refined_by(Some(&|at: usize| {
            core::array::from_fn(|plane| {
                let fine = quad(&detail.planes[plane], stride, at);
                above_smooth(fine, &around(&means.planes[plane], stride, at))
            })
        }))
    }

    /// The colours at twice the resolution, with `changes` of the children of a sample added, which have
    /// no mean.
    ///
    /// Values stay below 1 where theirs do, and above a share of theirs: what would leave the range keeps
    /// its pattern and loses contrast, two by two samples at a time and in all channels alike, so that the
    /// hue stays.
    pub(super) fn refined_by(&self, changes: Option<&impl Fn(usize) -> [Quad; 3]>) -> Self {
        let inner = self.rect.grow(-1);
        let mut out = Self::new(covered(&inner));
        let width = out.rect.width() as usize;
        for (row, y) in (inner.min.y..inner.max.y).enumerate() {
            let first = self.at(I64Vec2::new(inner.min.x, y));
            for column in 0..inner.width() as usize {
                let (at, to) = (first + column, 2 * row * width + 2 * column);
                let mut children = self.smooth(at);
                if let Some(changes) = changes {
                    self.add(at, &changes(at), &mut children);
                }
                for (plane, quad) in out.planes.iter_mut().zip(children) {
                    plane[to] = quad[0];
                    plane[to + 1] = quad[1];
                    plane[to + width] = quad[2];
                    plane[to + width + 1] = quad[3];
                }
            }
        }
        out
    }

    /// The children of a sample by average interpolation alone.
    #[inline(always)]
    fn smooth(&self, at: usize) -> [Quad; 3] {
        core::array::from_fn(|plane| {
            let parent = self.planes[plane][at];
            let stride = self.rect.width() as usize;
            let rise = rise(&around(&self.planes[plane], stride, at));
            let (low, high) = range(parent, SMOOTH_SHARE);
            let kept = rise.iter().fold(1.0_f32, |kept, rise| {
                kept.min(share(parent, *rise, low, high))
            });
            rise.map(|rise| parent + kept * rise)
        })
    }

    /// Adds changes to the children of a sample.
    #[inline(always)]
    fn add(&self, at: usize, changes: &[Quad; 3], children: &mut [Quad; 3]) {
        let mut kept = 1.0_f32;
        for plane in 0..3 {
            let (low, high) = range(self.planes[plane][at], DETAIL_SHARE);
            for (change, child) in changes[plane].iter().zip(&children[plane]) {
                kept = kept.min(share(*child, *change, low.min(*child), high.max(*child)));
            }
        }
        for (children, changes) in children.iter_mut().zip(changes) {
            for (child, change) in children.iter_mut().zip(changes) {
                *child += kept * change;
            }
        }
    }
}

/// Least share of a value that its children have by average interpolation, which overshoots next to a
/// jump: a dark line would run along every coast.
const SMOOTH_SHARE: f32 = 0.5;

/// Least share of a value that its children have with detail: a channel that reached 0 would leave a
/// colour that no ground has.
const DETAIL_SHARE: f32 = 0.125;

/// Where children of a value may lie: from a share of it to 1, for brighter ones up to twice as far
/// above 1 as they are. What is negative has no darker children.
#[inline(always)]
fn range(parent: f32, share: f32) -> (f32, f32) {
    (parent.min(share * parent), (2.0 * parent - 1.0).max(1.0))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn field(rect: SampleRect, value: impl Fn(I64Vec2, usize) -> f32) -> Field {
        let mut field = Field::new(rect);
        for y in rect.min.y..rect.max.y {
            for x in rect.min.x..rect.max.x {
                let sample = I64Vec2::new(x, y);
                let at = field.at(sample);
                field.set(at, core::array::from_fn(|plane| value(sample, plane)));
            }
        }
        field
    }

    proptest! {
        #[test]
        fn two_by_two_samples_have_the_mean_of_the_one_above_and_stay_in_range(
            parents in prop::collection::vec(prop_oneof![0.0..1.0_f32, Just(0.0_f32), Just(1.0_f32)], 48),
            detail in prop::collection::vec(-3.0..3.0_f32, 64),
            origin in (-50..50_i64, -50..50_i64),
        ) {
            let rect = SampleRect::at(origin.0, origin.1, 4, 4);
            let pick = |values: &[f32], s: I64Vec2, plane: usize| {
                values[(s.x.rem_euclid(8) * 5 + s.y.rem_euclid(8) * 11) as usize * (plane + 1) % values.len()]
            };
            let coarse = field(rect, |s, plane| pick(&parents, s, plane));
            let added = field(covered(&rect), |s, plane| pick(&detail, s, plane));
            for detail in [None, Some(&added)] {
                let fine = coarse.refined(detail);
                prop_assert_eq!(fine.rect, covered(&rect.grow(-1)));
                let means = fine.reduced();
                for y in means.rect.min.y..means.rect.max.y {
                    for x in means.rect.min.x..means.rect.max.x {
                        let sample = I64Vec2::new(x, y);
                        let (above, mean) = (coarse.get(coarse.at(sample)), means.get(means.at(sample)));
                        for (above, mean) in above.iter().zip(mean) {
                            prop_assert!((above - mean).abs() <= 2e-7, "{above} {mean}");
                        }
                    }
                }
                for v in fine.planes.iter().flatten() {
                    prop_assert!((-1e-6..=1.000_001).contains(v), "{v}");
                }
            }
        }

        #[test]
        fn means_of_a_quadratic_are_refined_to_means_of_the_same_quadratic(
            c in prop::array::uniform6(-0.02..0.02_f64),
        ) {
            // Mean over an area of side 1 / scale: x² becomes x² + side² / 12.
            let mean = |s: I64Vec2, scale: f64| {
                let (x, y) = ((s.x as f64 + 0.5) / scale, (s.y as f64 + 0.5) / scale);
                let more = 1.0 / (12.0 * scale * scale);
                let v = 0.5 + c[0] * x + c[1] * y + c[2] * (x * x + more) + c[3] * (y * y + more) + c[4] * x * y;
                v as f32
            };
            let rect = SampleRect::at(-2, -2, 4, 4);
            let fine = field(rect, |s, _| mean(s, 1.0)).refined(None);
            for y in -2..2 {
                for x in -2..2 {
                    let sample = I64Vec2::new(x, y);
                    let (got, expected) = (fine.get(fine.at(sample))[1], mean(sample, 2.0));
                    prop_assert!((got - expected).abs() < 1e-6, "{got} {expected}");
                }
            }
        }
    }

    #[test]
    fn refined_again_and_again_a_jump_becomes_continuous() {
        // Two samples, dark and bright: the largest step between neighbours falls as they get finer.
        let mut coarse = field(SampleRect::at(-6, -6, 12, 12), |s, _| {
            if s.x < 0 { 0.3 } else { 0.6 }
        });
        let mut largest = 0.3;
        for _ in 0..5 {
            coarse = coarse.refined(None);
            let width = coarse.rect.width() as usize;
            let row = &coarse.planes[0][..width];
            let step = row
                .windows(2)
                .map(|w| (w[1] - w[0]).abs())
                .fold(0.0, f32::max);
            assert!(step < 0.76 * largest, "{step} after {largest}");
            largest = step;
        }
    }

    #[test]
    fn detail_that_the_coarse_samples_can_show_is_left_out() {
        let rect = SampleRect::at(0, 0, 6, 6);
        let coarse = field(rect, |_, _| 0.5);
        let slope = field(covered(&rect), |s, _| (s.x - 2 * s.y) as f32 * 0.01);
        let fine = coarse.refined(Some(&slope));
        assert!(fine.planes.iter().flatten().all(|v| (v - 0.5).abs() < 1e-6));
    }

    #[test]
    fn a_share_brings_values_to_the_border_and_no_further() {
        assert_eq!(share(0.5, 0.25, 0.0, 1.0), 1.0);
        assert_eq!(share(0.5, 1.0, 0.0, 1.0), 0.5);
        assert_eq!(share(0.25, -1.0, 0.0, 1.0), 0.25);
        assert_eq!(share(0.0, -1.0, 0.0, 1.0), 0.0);
        assert_eq!(share(1.0, 0.0, 0.0, 1.0), 1.0);
    }
}
