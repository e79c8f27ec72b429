//! How far one picture is from another: for numbers, for an eye that compares colours, and for one that
//! looks at structure.

mod ssim;

pub use relievo_engine::analysis::colour::{Lab, ciede2000};
pub use ssim::mean_ssim;

/// Size and display values (sRGB encoded, 0 to 1) of a picture, row by row.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    /// Columns and rows.
    pub size_px: [usize; 2],
    /// As many pixels.
    pub pixels: &'a [[f32; 3]],
}

/// Differences of two pictures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureError {
    /// Peak signal to noise ratio of display values in decibels; infinite for equal pictures.
    pub psnr_db: f64,
    /// Mean structural similarity of lightness: 1 for equal pictures, see [`mean_ssim`].
    pub ssim: f64,
    /// Mean colour difference, see [`ciede2000()`]; about 1 is just noticeable side by side.
    pub mean_de: f64,
    /// The colour difference that one in a hundred pixels exceeds.
    pub p99_de: f64,
    /// Largest colour difference.
    pub max_de: f64,
}

impl PictureError {
    /// Compares two pictures of the same size; what one has beyond the other does not count.
    pub fn between(truth: &Seen, shown: &Seen) -> Self {
        let pairs = || truth.pixels.iter().zip(shown.pixels);
        let count = pairs().count().max(1) as f64;
        let squares =
            pairs().flat_map(|(a, b)| a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)));
        let mean_square = squares.sum::<f64>() / (3.0 * count);
        let labs = |seen: &Seen| {
            seen.pixels
                .iter()
                .map(|p| Lab::from_srgb(*p))
                .collect::<Vec<_>>()
        };
        let (a, b) = (labs(truth), labs(shown));
        let mut differences: Vec<f64> = a.iter().zip(&b).map(|(a, b)| ciede2000(*a, *b)).collect();
        let mean_de = differences.iter().sum::<f64>() / count;
        differences.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let last = differences.len().saturating_sub(1) as f64;
            differences
                .get((share * last).round() as usize)
                .copied()
                .unwrap_or(0.0)
        };
        let lightness = |labs: &[Lab]| labs.iter().map(|lab| lab.l).collect::<Vec<_>>();
        Self {
            psnr_db: -10.0 * libm::log10(mean_square),
            ssim: mean_ssim(truth.size_px, &lightness(&a), &lightness(&b), 100.0),
            mean_de,
            p99_de: at(0.99),
            max_de: at(1.0),
        }
    }
}

/// Display values of RGBA with 8 bits.
pub fn from_rgba8(rgba: &[u8]) -> Vec<[f32; 3]> {
    let value = |byte: u8| f32::from(byte) / 255.0;
    rgba.chunks_exact(4)
        .map(|p| [value(p[0]), value(p[1]), value(p[2])])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(shift: f32) -> Vec<[f32; 3]> {
        let value = |i: usize| ((i * 37 % 101) as f32 / 101.0 * 0.8 + shift).min(1.0);
        (0..32 * 24)
            .map(|i| [value(i), value(i + 5), value(i + 9)])
            .collect()
    }

    #[test]
    fn equal_pictures_have_no_error_and_a_known_shift_has_the_known_noise_ratio() {
        let (a, b) = (ramp(0.0), ramp(0.1));
        let seen = |pixels| Seen {
            size_px: [32, 24],
            pixels,
        };
        let none = PictureError::between(&seen(&a), &seen(&a));
        assert_eq!(
            (none.psnr_db, none.mean_de, none.max_de),
            (f64::INFINITY, 0.0, 0.0)
        );
        assert!((none.ssim - 1.0).abs() < 1e-12);
        let some = PictureError::between(&seen(&a), &seen(&b));
        assert!(
            (some.psnr_db - 20.0).abs() < 1e-3,
            "a tenth is 20 dB: {some:?}"
        );
        assert!(some.mean_de > 1.0 && some.mean_de <= some.p99_de && some.p99_de <= some.max_de);
        assert!(some.ssim < 1.0);
    }
}
