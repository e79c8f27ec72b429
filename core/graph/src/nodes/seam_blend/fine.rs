//! Corrections of coarse samples brought to finer ones.

use glam::I64Vec2;
use relievo_planet::SampleRect;

use super::coarse::Coarse;
use super::membrane::Corrections;

/// Coarse samples of a line between which a sample lies: cubic convolution (\[Key81\]), which goes
/// through them and is smooth.
#[derive(Clone, Copy, Debug)]
struct Taps {
    /// The first of four.
    first: i64,
    weights: [f32; 4],
}

impl Taps {
    fn new(sample: i64, doublings: u32) -> Self {
        // From the centre of the coarse sample before, in halves of a fine sample.
        let from_first = 2 * sample + 1 - (1 << doublings);
        let step = 2_i64 << doublings;
        let t = from_first.rem_euclid(step) as f32 / step as f32;
        Self {
            first: from_first.div_euclid(step) - 1,
            weights: [
                ((1.0 - 0.5 * t) * t - 0.5) * t,
                (1.5 * t - 2.5) * t * t + 1.0,
                ((2.0 - 1.5 * t) * t + 0.5) * t,
                (0.5 * t - 0.5) * t * t,
            ],
        }
    }
}

/// The coarse samples that decide the samples of a rectangle.
pub(super) fn needed(rect: &SampleRect, doublings: [u32; 2]) -> SampleRect {
    let axis = |min: i64, max: i64, doublings: u32| {
        if doublings == 0 {
            return (min, max);
        }
        let (first, last) = (Taps::new(min, doublings), Taps::new(max - 1, doublings));
        (first.first, last.first + 4)
    };
    let (west, east) = axis(rect.min.x, rect.max.x, doublings[0]);
    let (north, south) = axis(rect.min.y, rect.max.y, doublings[1]);
    SampleRect::new(I64Vec2::new(west, north), I64Vec2::new(east, south))
}

/// Corrections of a rectangle of coarse samples.
pub(super) struct Field {
    rect: SampleRect,
    doublings: [u32; 2],
    planes: [Vec<f32>; 3],
}

impl Field {
    /// Put together from blocks, all that are needed for the samples of a rectangle; `None` where all
    /// are 0.
    pub(super) fn new(coarse: &Coarse, blocks: &[&Corrections], rect: &SampleRect) -> Option<Self> {
        if blocks.iter().all(|block| block.planes.is_none()) {
            return None;
        }
        let rect = needed(rect, coarse.doublings);
        let mut planes: [Vec<f32>; 3] =
            core::array::from_fn(|_| Vec::with_capacity(rect.area() as usize));
        // Mostly that of the sample before.
        let mut last: Option<&Corrections> = None;
        for inside in coarse.inside(&rect) {
            let holds = |block: &&Corrections| block.block.contains(inside);
            last = last
                .filter(holds)
                .or_else(|| blocks.iter().copied().find(holds));
            let found = last.and_then(|block| block.at(inside));
            for (plane, v) in planes.iter_mut().zip(found.unwrap_or_default()) {
                plane.push(v);
            }
        }
        Some(Self {
            rect,
            doublings: coarse.doublings,
            planes,
        })
    }

    /// The corrections of one channel of a row of samples from west to east; `false` where all are 0.
    pub(super) fn row(&self, channel: usize, row: i64, columns: &Columns, out: &mut Row) -> bool {
        let width = self.rect.width() as usize;
        let plane = &self.planes[channel];
        let line = |y: i64| {
            let first = (y - self.rect.min.y) as usize * width;
            &plane[first..first + width]
        };
        out.coarse.clear();
        if self.doublings[1] == 0 {
            out.coarse.extend_from_slice(line(row));
        } else {
            let Taps { first, weights } = Taps::new(row, self.doublings[1]);
            let [a, b, c, d] = core::array::from_fn(|k| line(first + k as i64));
            out.coarse.extend((0..width).map(|x| {
                weights[0] * a[x] + weights[1] * b[x] + weights[2] * c[x] + weights[3] * d[x]
            }));
        }
        if out.coarse.iter().all(|v| *v == 0.0) {
            return false;
        }
        out.fine.clear();
        if self.doublings[0] == 0 {
            out.fine.extend_from_slice(&out.coarse);
        } else {
            out.fine.extend(columns.0.iter().map(|taps| {
                let first = (taps.first - self.rect.min.x) as usize;
                let from = &out.coarse[first..first + 4];
                let w = taps.weights;
                w[0] * from[0] + w[1] * from[1] + w[2] * from[2] + w[3] * from[3]
            }));
        }
        true
    }

    /// How the columns of a rectangle lie between coarse ones, the same for all of its rows.
    pub(super) fn columns(&self, rect: &SampleRect) -> Columns {
        let columns = rect.min.x..rect.max.x;
        Columns(columns.map(|x| Taps::new(x, self.doublings[0])).collect())
    }
}

/// Taps of columns.
pub(super) struct Columns(Vec<Taps>);

/// Corrections of a row.
#[derive(Default)]
pub(super) struct Row {
    coarse: Vec<f32>,
    pub(super) fine: Vec<f32>,
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn taps_give_back_a_parabola(sample in -5000..5000_i64, doublings in 1..8_u32) {
            let taps = Taps::new(sample, doublings);
            let place = (sample as f64 + 0.5) / f64::from(1 << doublings) - 0.5;
            let mut sum = 0.0;
            let mut value = 0.0;
            for (k, weight) in taps.weights.iter().enumerate() {
                let from = (taps.first + k as i64) as f64 - place;
                sum += f64::from(*weight);
                value += f64::from(*weight) * (1.0 + from + from * from);
            }
            prop_assert!((sum - 1.0).abs() < 1e-6 && (value - 1.0).abs() < 1e-5);
            let before = (taps.first + 1) as f64;
            prop_assert!(before <= place && place < before + 1.0);
        }
    }
}
