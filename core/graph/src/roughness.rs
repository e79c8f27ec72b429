//! How rough heights are, scale by scale: squared second differences, and the power law that they follow.
//!
//! A second difference h(x − r) − 2 h(x) + h(x + r) knows nothing of the ground's height and tilt and is
//! decided by waves about 2 r long, so its mean square at lags a factor of 2 apart is an octave spectrum that
//! holes do not disturb. On ground whose heights are a power law it is in proportion to r to the power of
//! 2 H, H from 0 (jagged) to 2 (smooth).

use core::ops::Range;

/// Exponents that a fit can give: real ground lies between.
pub const EXPONENTS: [f64; 2] = [0.4, 1.2];

/// What a fit tends to where heights say little: between the 0.6 of ranges and the 1.1 of slopes.
const USUAL_EXPONENT: f64 = 0.9;

/// How much the usual exponent counts: little beside octaves that were measured well, of which each counts about 0.5.
const USUAL_WEIGHT: f64 = 0.08;

/// The most that is put back for what data lack, as a logarithm: within a sample they say nothing.
const MOST_LACKING: f64 = 3.0;

/// Independent differences from which on a lag counts half.
const HALF_COUNT: f64 = 20.0;

/// Heights on a lattice whose samples are about square on the ground, row by row; NaN is a hole.
pub struct Surface<'a> {
    heights: &'a [f32],
    width: usize,
    rows: usize,
    down_m: f64,
    /// What brings squared differences along a row to the lag of a column; `None` where the row's
    /// samples are too narrow or too wide to be compared.
    along: Vec<Option<f64>>,
}

/// Squared second differences of a region at one lag.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Their sum in square metres.
    pub sum_m2: f64,
    /// How many.
    pub count: u64,
}

impl Energy {
    /// Their mean in square metres; `None` without any.
    pub fn mean_m2(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum_m2 / self.count as f64)
    }

    /// How many of them are about independent of each other, at a lag in samples.
    pub fn independent(&self, lag: usize) -> f64 {
        self.count as f64 / (2 * lag * lag) as f64
    }
}

impl<'a> Surface<'a> {
    /// Rows are `down_m` metres apart, samples of row j `across_m(j)`.
    ///
    /// # Panics
    /// If `heights` are not whole rows of `width` samples.
    pub fn new(
        heights: &'a [f32],
        width: usize,
        down_m: f64,
        across_m: impl Fn(usize) -> f64,
    ) -> Self {
        let rows = heights.len() / width.max(1);
        assert_eq!(rows * width, heights.len(), "whole rows");
        let along = (0..rows).map(|row| {
            let ratio = down_m / across_m(row);
            // Off by a factor of 1.4 at most on tiles; an exponent that differs from the usual one by
            // 0.2 is then off by less than 0.6 dB.
            let usable = (0.49..=2.05).contains(&ratio);
            usable.then(|| libm::pow(ratio, 2.0 * USUAL_EXPONENT))
        });
        Self {
            heights,
            width,
            rows,
            down_m,
            along: along.collect(),
        }
    }

    /// A lag of some samples in metres.
    pub fn lag_m(&self, lag: usize) -> f64 {
        lag as f64 * self.down_m
    }

    /// Second differences along rows and columns around the samples of a region, `lag` samples to either
    /// side, which may lie outside of it.
    pub fn energy(&self, lag: usize, columns: Range<usize>, rows: Range<usize>) -> Energy {
        let mut all = Energy::default();
        let (columns, rows) = (
            columns.start..columns.end.min(self.width),
            rows.start..rows.end.min(self.rows),
        );
        let inner = columns.start.max(lag)..columns.end.min(self.width.saturating_sub(lag));
        for row in rows {
            let line = &self.heights[row * self.width..(row + 1) * self.width];
            if let Some(factor) = self.along[row] {
                let mut along = Energy::default();
                for x in inner.clone() {
                    along.add(line[x - lag], line[x], line[x + lag]);
                }
                all.sum_m2 += along.sum_m2 * factor;
                all.count += along.count;
            }
            if row < lag || row + lag >= self.rows {
                continue;
            }
            let north = &self.heights[(row - lag) * self.width..];
            let south = &self.heights[(row + lag) * self.width..];
            for x in columns.clone() {
                all.add(north[x], line[x], south[x]);
            }
        }
        all
    }
}

impl Energy {
    #[inline]
    fn add(&mut self, before: f32, here: f32, after: f32) {
        let difference = (before - here) + (after - here);
        if difference.is_finite() {
            self.sum_m2 += f64::from(difference) * f64::from(difference);
            self.count += 1;
        }
    }
}

/// What was measured at one lag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// The lag in metres.
    pub lag_m: f64,
    /// Mean squared second difference in square metres, positive.
    pub energy_m2: f64,
    /// About how many independent differences it is the mean of.
    pub independent: f64,
}

/// Mean squared second differences as a power of the lag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerLaw {
    /// Natural logarithm of the energy at a lag of 1 m in square metres.
    ln_energy: f64,
    /// H: the energy is in proportion to the lag to the power of 2 H.
    pub exponent: f64,
}

impl PowerLaw {
    /// The law through energies at some lags; `None` without any. Lags with many independent differences
    /// count most, and the exponent tends to a usual one where they say little; it stays within
    /// [`EXPONENTS`].
    ///
    /// - `spacing_m`: of the data that were measured. Samples are means over about their area, and
    ///   between them heights were interpolated, so that energies lack what is finer: as much as is
    ///   put back here. 0 for heights that lack nothing.
    pub fn fit(measured: &[Measured], spacing_m: f64) -> Option<Self> {
        let mut law: Option<Self> = None;
        // What is lacking depends on the exponent: four rounds settle it to a hundredth.
        for _ in 0..4 {
            let exponent = law.map_or(USUAL_EXPONENT, |law| law.exponent);
            law = Self::through(measured, |lag_m| ln_lacking(lag_m / spacing_m, exponent));
        }
        law
    }

    fn through(measured: &[Measured], ln_lacking: impl Fn(f64) -> f64) -> Option<Self> {
        let lags_m = measured.iter().map(|m| m.lag_m);
        let shortest_m = lags_m.fold(f64::INFINITY, f64::min);
        let points = measured.iter().filter(|m| m.energy_m2 > 0.0).map(|m| {
            let ln_whole = libm::log(m.energy_m2) + ln_lacking(m.lag_m);
            // What is finer still is likest the finest: ground is no power law over all scales.
            let finest = (shortest_m / m.lag_m).sqrt();
            let weight = finest * m.independent / (m.independent + HALF_COUNT);
            (libm::log(m.lag_m), 0.5 * ln_whole, weight)
        });
        let (mut weights, mut mean_x, mut mean_y) = (0.0, 0.0, 0.0);
        for (x, y, weight) in points.clone() {
            weights += weight;
            mean_x += weight * x;
            mean_y += weight * y;
        }
        if weights <= 0.0 {
            return None;
        }
        (mean_x, mean_y) = (mean_x / weights, mean_y / weights);
        let (mut across, mut square) = (USUAL_WEIGHT * USUAL_EXPONENT, USUAL_WEIGHT);
        for (x, y, weight) in points {
            across += weight * (x - mean_x) * (y - mean_y);
            square += weight * (x - mean_x) * (x - mean_x);
        }
        let exponent = (across / square).clamp(EXPONENTS[0], EXPONENTS[1]);
        Some(Self {
            ln_energy: 2.0 * (mean_y - exponent * mean_x),
            exponent,
        })
    }

    /// Mean squared second difference at a lag in square metres.
    pub fn energy_m2(&self, lag_m: f64) -> f64 {
        libm::exp(self.ln_energy + 2.0 * self.exponent * libm::log(lag_m))
    }
}

/// The natural logarithm of the factor that the energy at a lag, in samples of the data, lacks where data are
/// means over their samples, bilinear between them.
///
/// Fitted within 0.2 dB at lags of 1.5 to 8 to surfaces of random phases with exponents of 0.4, 0.7 and 1 and
/// sixteen times finer than the data.
fn ln_lacking(lag: f64, exponent: f64) -> f64 {
    if !lag.is_finite() {
        return 0.0;
    }
    let factor = libm::exp(0.834 - 0.587 * exponent);
    let falloff = 0.35 + exponent * (1.75 - 0.5 * exponent);
    (factor * libm::pow(lag, -falloff)).min(MOST_LACKING)
}

#[cfg(test)]
mod tests;
