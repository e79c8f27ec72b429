//! Power spectra of lines of samples.

use core::f64::consts::TAU;

/// Power in a third of an octave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Band {
    /// Middle wavelength, samples.
    pub(super) wavelength: f64,
    /// Mean power per frequency.
    pub(super) power: f64,
}

/// A power law beside a spectrum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fit {
    /// Exponent of frequency of the straight line through the bands.
    pub(super) slope: f64,
    /// Root mean square deviation of bands from the law, decibels.
    pub(super) error_db: f64,
    /// The largest one.
    pub(super) worst_db: f64,
    stated_slope: f64,
    constant_db: f64,
}

impl Fit {
    /// Deviation of a band from the law, decibels.
    pub(super) fn deviation_db(&self, band: &Band) -> f64 {
        let law_db = self.constant_db - self.stated_slope * decibels(band.wavelength);
        decibels(band.power) - law_db
    }
}

fn decibels(ratio: f64) -> f64 {
    10.0 * libm::log10(ratio)
}

/// Power of lines of the same length, in thirds of octaves from two samples to an eighth of a line.
pub(super) fn bands(lines: &[Vec<f32>]) -> Vec<Band> {
    let length = lines.first().map_or(0, Vec::len);
    let mut power = vec![0.0; length / 2];
    let turns: Vec<(f64, f64)> = (0..length)
        .map(|i| libm::sincos(TAU * i as f64 / length as f64))
        .collect();
    for line in lines {
        let mean = line.iter().map(|h| f64::from(*h)).sum::<f64>() / length as f64;
        // Hann's window.
        let windowed: Vec<f64> = line
            .iter()
            .zip(&turns)
            .map(|(height, (_, cos))| (f64::from(*height) - mean) * (0.5 - 0.5 * cos))
            .collect();
        for (frequency, power) in power.iter_mut().enumerate() {
            let (mut re, mut im) = (0.0, 0.0);
            let mut turn = 0;
            for height in &windowed {
                let (sin, cos) = turns[turn];
                re += height * cos;
                im += height * sin;
                turn += frequency;
                if turn >= length {
                    turn -= length;
                }
            }
            *power += re * re + im * im;
        }
    }
    let third = libm::exp2(1.0 / 3.0);
    let mut bands = Vec::new();
    let mut longest = length as f64 / 8.0;
    while longest / third >= 2.0 {
        let shortest = longest / third;
        // Frequencies in cycles a line.
        let first = libm::ceil(length as f64 / longest) as usize;
        let end = (libm::ceil(length as f64 / shortest) as usize).min(power.len());
        if let Some(inside) = power.get(first..end).filter(|inside| !inside.is_empty()) {
            bands.push(Band {
                wavelength: libm::sqrt(longest * shortest),
                power: inside.iter().sum::<f64>() / inside.len() as f64,
            });
        }
        longest = shortest;
    }
    bands
}

/// How near the bands of wavelengths between two are to a power law with a stated slope.
pub(super) fn fit(bands: &[Band], [shortest, longest]: [f64; 2], stated_slope: f64) -> Fit {
    let judged = || {
        let inside = bands
            .iter()
            .filter(|b| (shortest..=longest).contains(&b.wavelength));
        // Frequency and power, decibels.
        inside.map(|band| (-decibels(band.wavelength), decibels(band.power)))
    };
    let count = judged().count() as f64;
    let (x, y) = judged().fold((0.0, 0.0), |(x, y), p| (x + p.0 / count, y + p.1 / count));
    let (xx, xy) = judged().fold((0.0, 0.0), |(xx, xy), p| {
        (xx + (p.0 - x) * (p.0 - x), xy + (p.0 - x) * (p.1 - y))
    });
    let constant_db = y - stated_slope * x;
    let deviations = || judged().map(|p| p.1 - constant_db - stated_slope * p.0);
    Fit {
        slope: xy / xx,
        error_db: libm::sqrt(deviations().map(|d| d * d).sum::<f64>() / count),
        worst_db: deviations().map(f64::abs).fold(0.0, f64::max),
        stated_slope,
        constant_db,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_wave_has_its_power_in_its_own_band() {
        let line = (0..1024).map(|i| (TAU * f64::from(i) / 16.3).sin() as f32);
        let bands = bands(&[line.collect()]);
        let most = bands
            .iter()
            .max_by(|a, b| a.power.total_cmp(&b.power))
            .unwrap();
        assert!((14.0..19.0).contains(&most.wavelength), "{most:?}");
        let far = bands.iter().filter(|b| b.wavelength < 10.0);
        assert!(far.clone().count() > 4 && far.clone().all(|b| b.power < most.power * 1e-6));
    }

    #[test]
    fn a_power_law_is_found_and_fits_without_error() {
        let bands: Vec<Band> = (1..40)
            .map(|k| 2.0 * libm::exp2(f64::from(k) / 5.0))
            .map(|wavelength| Band {
                wavelength,
                power: 7.0 * wavelength.powi(3),
            })
            .collect();
        let exact = fit(&bands, [4.0, 200.0], -3.0);
        assert!(
            (exact.slope + 3.0).abs() < 1e-9 && exact.error_db < 1e-9,
            "{exact:?}"
        );
        let wrong = fit(&bands, [4.0, 200.0], -2.0);
        assert!(
            (wrong.slope + 3.0).abs() < 1e-9 && wrong.error_db > 1.0,
            "{wrong:?}"
        );
    }
}
