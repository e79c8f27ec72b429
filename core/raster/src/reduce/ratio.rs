//! From one level to the next: means weighted by area.
//!
//! A level of odd size has no exact half: each coarse pixel then covers a little less than two fine
//! ones, so that both levels cover the same ground and no level is shifted against another.

use crate::colour::{linear_from_srgb, srgb_from_linear};
use crate::file::{OverviewInfo, PixelRect};
use crate::{Bands, Block, normal};

/// The way from a rectangle of a fine level to one of the coarse level.
pub(crate) struct Reduction {
    needs: PixelRect,
    columns: Vec<Taps>,
    rows: Vec<Taps>,
}

/// Fine samples under a coarse one along an axis: the first (counted within what is needed) and the
/// part that each has; parts add up to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Taps {
    first: usize,
    weights: [f64; 3],
}

impl Reduction {
    /// Between two levels of which the coarse one has at least half the size.
    pub(crate) fn new(fine: OverviewInfo, coarse: OverviewInfo, wanted: PixelRect) -> Self {
        let (x, x_end, columns) = taps(fine.width, coarse.width, wanted.x, wanted.width);
        let (y, y_end, rows) = taps(fine.height, coarse.height, wanted.y, wanted.height);
        Self {
            needs: PixelRect {
                x,
                y,
                width: x_end - x,
                height: y_end - y,
            },
            columns,
            rows,
        }
    }

    /// The rectangle of the fine level that it reads.
    pub(crate) fn needs(&self) -> PixelRect {
        self.needs
    }

    /// The coarse rectangle. Heights: the mean of those that are there. Colours: premultiplied and
    /// in linear light. Normals: the direction of the sum of unit vectors.
    pub(crate) fn apply(&self, fine: &Block) -> Block {
        let mut coarse = Block::new(fine.bands(), self.columns.len(), self.rows.len());
        match fine.bands() {
            Bands::Colour => self.colours(fine, &mut coarse),
            Bands::Normal => self.normals(fine, &mut coarse),
            Bands::Height | Bands::Mask => self.heights(fine, &mut coarse),
        }
        coarse
    }

    fn heights(&self, fine: &Block, coarse: &mut Block) {
        let samples = fine.plane(0);
        let out = coarse.plane_mut(0);
        for (y, row) in self.rows.iter().enumerate() {
            for (x, column) in self.columns.iter().enumerate() {
                let (mut sum, mut weight) = (0.0, 0.0);
                for (i, w) in under(row, column, fine) {
                    let height = f64::from(samples[i]);
                    if !height.is_nan() {
                        sum += w * height;
                        weight += w;
                    }
                }
                out[y * self.columns.len() + x] = if weight > 0.0 {
                    (sum / weight) as f32
                } else {
                    f32::NAN
                };
            }
        }
    }

    fn normals(&self, fine: &Block, coarse: &mut Block) {
        let (east, north) = (fine.plane(0), fine.plane(1));
        let [out_east, out_north] = coarse.planes_mut();
        for (y, row) in self.rows.iter().enumerate() {
            for (x, column) in self.columns.iter().enumerate() {
                let mut sum = glam::DVec3::ZERO;
                for (i, w) in under(row, column, fine) {
                    sum += w * normal::unit([east[i], north[i]]);
                }
                let i = y * self.columns.len() + x;
                [out_east[i], out_north[i]] = normal::coordinates(sum);
            }
        }
    }

    fn colours(&self, fine: &Block, coarse: &mut Block) {
        let light: [Vec<f32>; 3] =
            [0, 1, 2].map(|c| fine.plane(c).iter().map(|v| linear_from_srgb(*v)).collect());
        let alpha = fine.plane(3);
        let [r, g, b, a] = coarse.planes_mut();
        for (y, row) in self.rows.iter().enumerate() {
            for (x, column) in self.columns.iter().enumerate() {
                let mut sums = [0.0f64; 4];
                for (i, w) in under(row, column, fine) {
                    let covered = w * f64::from(alpha[i]);
                    for (sum, channel) in sums.iter_mut().zip(&light) {
                        *sum += covered * f64::from(channel[i]);
                    }
                    sums[3] += covered;
                }
                if sums[3] > 0.0 {
                    let i = y * self.columns.len() + x;
                    for (plane, sum) in [&mut *r, &mut *g, &mut *b].into_iter().zip(sums) {
                        plane[i] = srgb_from_linear((sum / sums[3]) as f32);
                    }
                    a[i] = (sums[3] as f32).min(1.0);
                }
            }
        }
    }
}

/// Indices and weights of the fine samples under a coarse one.
#[inline]
fn under(row: &Taps, column: &Taps, fine: &Block) -> impl Iterator<Item = (usize, f64)> {
    let (row, column, width) = (*row, *column, fine.width());
    (0..3)
        .filter(move |j| row.weights[*j] > 0.0)
        .flat_map(move |j| {
            let start = (row.first + j) * width + column.first;
            (0..3)
                .filter(move |i| column.weights[*i] > 0.0)
                .map(move |i| (start + i, row.weights[j] * column.weights[i]))
        })
}

/// Taps of `count` coarse samples from `start` on, with the first fine sample and the one after the last.
fn taps(fine: u32, coarse: u32, start: u32, count: u32) -> (u32, u32, Vec<Taps>) {
    let (fine, coarse) = (u64::from(fine), u64::from(coarse));
    // In units of 1/coarse of a fine sample, so that all borders are integers.
    let span = |i: u64| (i * fine / coarse, (i + 1) * fine);
    let (first, _) = span(u64::from(start));
    let mut last = first;
    let taps = (u64::from(start)..u64::from(start + count))
        .map(|i| {
            let (from, end) = span(i);
            let begin = i * fine;
            let weights = core::array::from_fn(|t| {
                let (low, high) = ((from + t as u64) * coarse, (from + t as u64 + 1) * coarse);
                let overlap = high.min(end).saturating_sub(low.max(begin));
                if overlap > 0 {
                    last = last.max(from + t as u64 + 1);
                }
                overlap as f64 / fine as f64
            });
            Taps {
                first: (from - first) as usize,
                weights,
            }
        })
        .collect();
    (first as u32, last as u32, taps)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use glam::DVec3;

    use super::*;

    proptest! {
        #[test]
        fn every_fine_sample_counts_as_much_as_it_covers(fine in 2u32..2000) {
            let coarse = fine.div_ceil(2);
            let (first, last, taps) = taps(fine, coarse, 0, coarse);
            prop_assert_eq!((first, last), (0, fine));
            let mut covered = vec![0.0; fine as usize];
            for tap in &taps {
                prop_assert!((tap.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
                for (i, w) in tap.weights.iter().enumerate().filter(|(_, w)| **w > 0.0) {
                    covered[tap.first + i] += w;
                }
            }
            let share = f64::from(coarse) / f64::from(fine);
            prop_assert!(covered.iter().all(|c| (c - share).abs() < 1e-9));
        }

        #[test]
        fn a_part_of_a_level_is_the_same_part_of_the_whole(fine in 2u32..300, at in 0.0..1.0f64) {
            let coarse = fine.div_ceil(2);
            let start = (f64::from(coarse) * at) as u32;
            let (_, _, whole) = taps(fine, coarse, 0, coarse);
            let (first, _, part) = taps(fine, coarse, start, coarse - start);
            for (a, b) in part.iter().zip(&whole[start as usize..]) {
                prop_assert_eq!(a.first + first as usize, b.first);
                prop_assert_eq!(a.weights, b.weights);
            }
        }
    }

    #[test]
    fn level_ground_stays_level_and_opposite_slopes_cancel() {
        let whole = PixelRect {
            x: 0,
            y: 0,
            width: 2,
            height: 1,
        };
        let (fine, coarse) = (
            OverviewInfo {
                width: 4,
                height: 2,
            },
            OverviewInfo {
                width: 2,
                height: 1,
            },
        );
        let mut normals = Block::new(Bands::Normal, 4, 2);
        let [east, north] = normals.planes_mut();
        for (i, (e, n)) in east.iter_mut().zip(north).enumerate() {
            let leaning = if i % 2 == 0 { 0.48 } else { -0.48 };
            [*e, *n] = normal::coordinates(DVec3::new(leaning, 0.6, 0.64));
        }
        let level = DVec3::new(0.0, 0.6, 0.64).normalize();
        let half = Reduction::new(fine, coarse, whole).apply(&normals);
        for (e, n) in half.plane(0).iter().zip(half.plane(1)) {
            let mean = normal::unit([*e, *n]);
            assert!(mean.abs_diff_eq(level, 1e-6), "{mean}");
        }
    }

    #[test]
    fn holes_do_not_spread_and_transparent_colours_do_not_bleed() {
        let size = |n| OverviewInfo {
            width: n,
            height: n,
        };
        let reduction = Reduction::new(
            size(2),
            size(1),
            PixelRect {
                x: 0,
                y: 0,
                width: 1,
                height: 1,
            },
        );
        let mut heights = Block::new(Bands::Height, 2, 2);
        heights
            .samples_mut()
            .copy_from_slice(&[10.0, f32::NAN, 20.0, f32::NAN]);
        assert_eq!(reduction.apply(&heights).samples(), [15.0]);
        let mut colours = Block::filled(Bands::Colour, 2, 2, &[1.0, 0.0, 0.0, 1.0]);
        for plane in 0..4 {
            colours.plane_mut(plane)[3] = 0.0;
        }
        let mixed = reduction.apply(&colours);
        assert!((mixed.samples()[0] - 1.0).abs() < 1e-6 && mixed.samples()[3] == 0.75);
    }
}
