//! A sample of fine imagery at every resolution that it has.

use relievo_raster::colour::{linear_from_srgb, srgb_from_linear};
use relievo_raster::{Bands, Block};

/// Least samples along a side of an exemplar.
pub const LEAST_SAMPLES: usize = 8;

/// (1 − √⅓) / 2: by so many samples linear interpolation is shifted.
///
/// Plain linear interpolation takes the contrast of what is as fine as the samples; shifted so, and with
/// samples made to fit, the energy of every frequency stays what it is on average over all places
/// between samples (1.61 / |1 + 0.27 z|² of the samples times (2 + cos ω) / 3 of the interpolation is 1).
///
/// Source: \[BTU04\].
const SHIFT: f32 = 0.211_324_87;

/// Most samples of an exemplar, which takes 43 bytes for each: 45 MB.
pub const MOST_SAMPLES: usize = 1 << 20;

/// Largest spacing of an exemplar in metres; more than a planet has.
pub(super) const MOST_SPACING_M: f64 = 1e9;

/// Fine imagery that shows what the ground looks like: colours with north up, and their spacing.
#[derive(Clone, Debug)]
pub(super) struct Exemplar {
    spacing_m: f64,
    /// Each half as fine as the one before.
    mips: Vec<Mip>,
}

/// An exemplar at one resolution.
#[derive(Clone, Debug)]
struct Mip {
    width: usize,
    height: usize,
    /// Red, green, blue in linear light, and alpha, which is 1 once holes are filled; in the end such
    /// that shifted interpolation gives them.
    light: Vec<[f32; 4]>,
    /// The same as the eye has it, nearly: encoded.
    encoded: Vec<[f32; 4]>,
}

impl Exemplar {
    /// From straight, encoded colours (as [`Bands::Colour`] says), samples `spacing_m` metres apart
    /// along rows and columns. Transparent samples take the mean of what surrounds them; values that
    /// are not finite count as transparent. `None` when they are no colours, fewer than [`LEAST_SAMPLES`]
    /// along a side, more than [`MOST_SAMPLES`], all transparent, or `spacing_m` is no length.
    pub(super) fn new(colours: &Block, spacing_m: f64) -> Option<Self> {
        let (width, height) = (colours.width(), colours.height());
        let fits = width.min(height) >= LEAST_SAMPLES && width * height <= MOST_SAMPLES;
        let is_length = spacing_m > 0.0 && spacing_m <= MOST_SPACING_M;
        if colours.bands() != Bands::Colour || !fits || !is_length {
            return None;
        }
        let mut mips = vec![Mip::finest(colours)];
        while let Some(half) = mips.last().and_then(Mip::halved) {
            mips.push(half);
        }
        if mips[0].light.iter().all(|v| v[3] == 0.0) {
            return None;
        }
        fill_holes(&mut mips);
        for mip in &mut mips {
            mip.encoded = mip.light.iter().map(|v| v.map(srgb_from_linear)).collect();
            fit_to_shift(mip);
        }
        Some(Self { spacing_m, mips })
    }

    /// Metres from sample to sample.
    pub(super) fn spacing_m(&self) -> f64 {
        self.spacing_m
    }

    /// Bytes of one with so many samples: two colours for each, and a third of that for the coarser ones.
    pub(super) fn bytes(samples: usize) -> usize {
        samples * (2 * size_of::<[f32; 4]>()) * 4 / 3
    }

    /// Metres along rows and columns.
    pub(super) fn extent_m(&self) -> [f64; 2] {
        [self.mips[0].width, self.mips[0].height].map(|n| n as f64 * self.spacing_m)
    }

    /// The resolution that samples `spacing_m` apart show, a little finer rather than coarser;
    /// `None` if the exemplar has nothing that fine.
    pub(super) fn mip(&self, spacing_m: f64) -> Option<usize> {
        let ratio = spacing_m / self.spacing_m;
        if ratio < 0.7 {
            return None;
        }
        let mut mip = 0;
        let mut left = ratio;
        while left > 1.42 && mip + 1 < self.mips.len() {
            left *= 0.5;
            mip += 1;
        }
        Some(mip)
    }

    /// How places in metres from the exemplar's north-west corner are read at a resolution.
    pub(super) fn reader(&self, mip: usize) -> Reader<'_> {
        let at = &self.mips[mip];
        let spacing_m = self.spacing_m * f64::from(1_u32 << mip);
        Reader {
            light: &at.light,
            encoded: &at.encoded,
            width: at.width,
            last: [(at.width - 1) as f32, (at.height - 1) as f32],
            per_metre: (1.0 / spacing_m) as f32,
        }
    }
}

/// Reads an exemplar at one resolution.
#[derive(Clone, Copy)]
pub(super) struct Reader<'a> {
    light: &'a [[f32; 4]],
    encoded: &'a [[f32; 4]],
    width: usize,
    /// Indices of the last column and row.
    last: [f32; 2],
    /// Samples in a metre.
    pub(super) per_metre: f32,
}

impl Reader<'_> {
    /// Linear light at a place in samples (the first sample's centre is ½), beyond the last ones theirs.
    #[inline(always)]
    pub(super) fn light(&self, at: [f32; 2]) -> [f32; 4] {
        self.read(self.light, at, 0.5 + SHIFT)
    }

    /// As [`Self::light`], encoded, and linear between samples.
    #[inline(always)]
    pub(super) fn encoded(&self, at: [f32; 2]) -> [f32; 4] {
        self.read(self.encoded, at, 0.5)
    }

    #[inline(always)]
    fn read(&self, samples: &[[f32; 4]], at: [f32; 2], first: f32) -> [f32; 4] {
        let x = (at[0] - first).clamp(0.0, self.last[0]);
        let y = (at[1] - first).clamp(0.0, self.last[1]);
        // Truncation is the floor of what is not negative.
        let (column, row) = (x as usize, y as usize);
        let (tx, ty) = (x - column as f32, y - row as f32);
        let east = usize::from((column as f32) < self.last[0]);
        let south = if (row as f32) < self.last[1] {
            self.width
        } else {
            0
        };
        let first = row * self.width + column;
        let (nw, ne) = (samples[first], samples[first + east]);
        let (sw, se) = (samples[first + south], samples[first + south + east]);
        core::array::from_fn(|c| {
            let north = nw[c] + tx * (ne[c] - nw[c]);
            let south = sw[c] + tx * (se[c] - sw[c]);
            north + ty * (south - north)
        })
    }
}

impl Mip {
    fn finest(colours: &Block) -> Self {
        let planes: [&[f32]; 4] = core::array::from_fn(|plane| colours.plane(plane));
        let light = (0..planes[0].len()).map(|i| {
            let v = planes.map(|plane| plane[i]);
            if v[3] > 0.0 && v.iter().all(|v| v.is_finite()) {
                let [r, g, b] = [v[0], v[1], v[2]].map(|v| linear_from_srgb(v).max(0.0));
                [r, g, b, v[3].min(1.0)]
            } else {
                [0.0; 4]
            }
        });
        Self {
            width: colours.width(),
            height: colours.height(),
            light: light.collect(),
            encoded: Vec::new(),
        }
    }

    /// The next coarser one: means of two by two samples by their alpha, an odd last row or column
    /// left out; `None` once a side would vanish.
    fn halved(&self) -> Option<Self> {
        let (width, height) = (self.width / 2, self.height / 2);
        if width == 0 || height == 0 {
            return None;
        }
        let mut light = Vec::with_capacity(width * height);
        for y in 0..height {
            for x in 0..width {
                let first = 2 * y * self.width + 2 * x;
                let quad = [first, first + 1, first + self.width, first + self.width + 1];
                let alpha: f32 = quad.iter().map(|i| self.light[*i][3]).sum();
                let mut mean = [0.0; 4];
                if alpha > 0.0 {
                    for (c, mean) in mean.iter_mut().enumerate().take(3) {
                        let sum: f32 = quad
                            .iter()
                            .map(|i| self.light[*i][c] * self.light[*i][3])
                            .sum();
                        *mean = sum / alpha;
                    }
                    mean[3] = alpha * 0.25;
                }
                light.push(mean);
            }
        }
        Some(Self {
            width,
            height,
            light,
            encoded: Vec::new(),
        })
    }
}

/// Gives every sample without alpha the colour of the next coarser one, from the coarsest on.
fn fill_holes(mips: &mut [Mip]) {
    for at in (0..mips.len()).rev() {
        let (finer, coarser) = mips.split_at_mut(at + 1);
        let mip = &mut finer[at];
        for y in 0..mip.height {
            for x in 0..mip.width {
                let sample = &mut mip.light[y * mip.width + x];
                if sample[3] == 0.0
                    && let Some(coarse) = coarser.first()
                {
                    let (cx, cy) = (
                        (x / 2).min(coarse.width - 1),
                        (y / 2).min(coarse.height - 1),
                    );
                    *sample = coarse.light[cy * coarse.width + cx];
                }
                sample[3] = 1.0;
            }
        }
    }
}

/// Makes samples such that shifted interpolation gives them: along rows, then along columns.
fn fit_to_shift(mip: &mut Mip) {
    for at in 0..mip.light.len() {
        if at % mip.width > 0 {
            mip.light[at] = fitted(mip.light[at - 1], mip.light[at]);
        }
    }
    for at in mip.width..mip.light.len() {
        mip.light[at] = fitted(mip.light[at - mip.width], mip.light[at]);
    }
}

fn fitted(before: [f32; 4], here: [f32; 4]) -> [f32; 4] {
    core::array::from_fn(|c| (here[c] - SHIFT * before[c]) / (1.0 - SHIFT))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(width: usize, height: usize) -> Block {
        let mut block = Block::filled(Bands::Colour, width, height, &[0.2, 0.5, 0.7, 1.0]);
        for (i, v) in block.plane_mut(0).iter_mut().enumerate() {
            *v = (i % width) as f32 / width as f32;
        }
        block
    }

    #[test]
    fn what_shows_nothing_is_no_exemplar() {
        let is_one = |colours: &Block, spacing_m| Exemplar::new(colours, spacing_m).is_some();
        assert!(is_one(&ramp(8, 8), 1.0));
        for spacing_m in [0.0, -1.0, f64::INFINITY, f64::NAN] {
            assert!(!is_one(&ramp(8, 8), spacing_m));
        }
        assert!(!is_one(&ramp(8, 7), 1.0));
        assert!(!is_one(&Block::new(Bands::Height, 9, 9), 1.0));
        assert!(!is_one(&Block::new(Bands::Colour, 1025, 1024), 1.0));
        let mut nothing = Block::filled(Bands::Colour, 9, 9, &[f32::NAN, 0.5, 0.5, 1.0]);
        assert!(!is_one(&nothing, 1.0));
        nothing.plane_mut(0)[40] = 0.25;
        assert!(is_one(&nothing, 1.0));
    }

    #[test]
    fn holes_take_what_surrounds_them() {
        let mut holed = Block::filled(Bands::Colour, 16, 16, &[0.25, 0.5, 0.75, 1.0]);
        for i in [0, 1, 17, 100, 255] {
            for plane in 0..4 {
                holed.plane_mut(plane)[i] = 0.0;
            }
        }
        let exemplar = Exemplar::new(&holed, 1.0).unwrap();
        for mip in &exemplar.mips {
            for v in &mip.encoded {
                for (v, expected) in v.iter().zip([0.25, 0.5, 0.75, 1.0]) {
                    assert!((v - expected).abs() < 1e-5, "{v} for {expected}");
                }
            }
        }
    }

    #[test]
    fn a_resolution_is_neither_much_finer_nor_coarser_than_asked_for() {
        let exemplar = Exemplar::new(&ramp(256, 64), 0.5).unwrap();
        assert_eq!(exemplar.mips.len(), 7);
        assert_eq!(exemplar.mip(0.34), None);
        for step in 0..200 {
            let spacing_m = 0.36 * libm::exp2(f64::from(step) / 40.0);
            let mip = exemplar.mip(spacing_m).expect("as fine as that");
            let own_m = 0.5 * f64::from(1 << mip);
            assert!(own_m <= spacing_m * 1.45 && (own_m >= spacing_m * 0.7 || mip == 6));
        }
    }

    #[test]
    fn samples_are_met_and_the_border_goes_on() {
        let exemplar = Exemplar::new(&ramp(16, 16), 2.0).unwrap();
        let reader = exemplar.reader(0);
        let at = |x: f32, y: f32| {
            let at = [x * reader.per_metre, y * reader.per_metre];
            let (light, encoded) = (srgb_from_linear(reader.light(at)[0]), reader.encoded(at)[0]);
            assert!((light - encoded).abs() < 1e-5, "{light} {encoded}");
            encoded
        };
        assert!((at(7.0, 9.0) - 3.0 / 16.0).abs() < 1e-5);
        assert!((reader.encoded([3.75, 2.1])[0] - 3.25 / 16.0).abs() < 1e-5);
        assert_eq!(at(-50.0, 9.0), at(1.0, 1.0));
        let last = [1e9; 2];
        assert_eq!(reader.encoded(last), reader.encoded([15.5; 2]));
        assert!(reader.light(last).iter().all(|v| v.is_finite()));
    }

    #[test]
    fn between_samples_contrast_is_kept() {
        // Noise of every frequency, read anywhere: variance and covariance of neighbours are its own.
        let mut noise = ramp(256, 256);
        for (i, v) in noise.samples_mut().iter_mut().enumerate().take(65_536) {
            *v = (super::super::super::noise::scrambled(i as u64) >> 40) as f32 / 16_777_216.0;
        }
        let exemplar = Exemplar::new(&noise, 1.0).unwrap();
        let statistics = |offset: [f32; 2]| {
            let reader = exemplar.reader(0);
            let (mut sum, mut squares, mut products, mut count) = (0.0, 0.0, 0.0, 0.0);
            for i in 0..20_000_u16 {
                let (x, y) = (f32::from(i % 240), f32::from(i / 240));
                let red =
                    |x: f32| f64::from(reader.light([x + 5.0 + offset[0], y + 3.0 + offset[1]])[0]);
                let (a, b) = (red(x), red(x + 1.0));
                sum += a;
                squares += a * a;
                products += a * b;
                count += 1.0;
            }
            let mean = sum / count;
            [
                squares / count - mean * mean,
                products / count - mean * mean,
            ]
        };
        let own = statistics([0.5, 0.5]);
        let mut read = [0.0; 2];
        for i in 0..64_u8 {
            let offset = [i % 8, i / 8].map(|k| (f32::from(k) + 0.5) / 8.0);
            let statistics = statistics(offset);
            read = [
                read[0] + statistics[0] / 64.0,
                read[1] + statistics[1] / 64.0,
            ];
        }
        assert!((read[0] / own[0] - 1.0).abs() < 0.02, "{read:?} {own:?}");
        assert!((read[1] - own[1]).abs() < 0.02 * own[0], "{read:?} {own:?}");
    }
}
