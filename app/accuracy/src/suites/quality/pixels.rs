//! Pixels of pictures, each with what decides its error.

use glam::DVec2;
use relievo_engine::Offset;
use relievo_engine::planet::clipmap::choose::MAX_ANISOTROPY;
use relievo_engine::planet::clipmap::view::View;
use relievo_gpu::{Setting, Still};

use crate::SuiteError;

/// Share of the pixels of ground whose error is less than what is told.
const SHARE: f64 = 0.9;

/// A pixel that shows ground.
#[derive(Clone, Copy, Debug)]
struct Pixel {
    /// How far its ground is from where it should be, pixels.
    ground_px: f64,
    /// How much nearer the nearest ground is, 0 to 1.
    nearness: f64,
    /// Length over width of its footprint on level ground, at least 1.
    anisotropy: f64,
}

/// Pixels of ground, of several pictures.
#[derive(Debug, Default)]
pub(super) struct Pixels(Vec<Pixel>);

impl Pixels {
    /// Adds a picture's, with how far each is from the truth.
    pub(super) fn add(&mut self, still: &Still, offsets: &[Offset]) -> Result<(), SuiteError> {
        let depths = still.renderer.read_distances();
        let depths = depths.map_err(|error| SuiteError::System(error.to_string()))?;
        let frame = &still.frame;
        let view = View::new(&frame.camera, &frame.planet, frame.viewport_px);
        let [width, height] = frame.viewport_px.map(f64::from);
        let nearest = depths.iter().copied().fold(f32::INFINITY, f32::min);
        let columns = frame.viewport_px[0].max(1) as usize;
        for (i, (depth, offset)) in depths.iter().zip(offsets).enumerate() {
            if !(depth.is_finite() && offset.screen_px.is_finite()) {
                continue;
            }
            let x = ((i % columns) as f64 + 0.5) / width * 2.0 - 1.0;
            let y = 1.0 - ((i / columns) as f64 + 0.5) / height * 2.0;
            let (ray, depth) = (view.ray(DVec2::new(x, y)), f64::from(*depth));
            let up = (view.eye + ray * depth).normalize();
            let sin_grazing = -ray.normalize().dot(up);
            self.0.push(Pixel {
                ground_px: offset.screen_px,
                nearness: f64::from(nearest) / depth,
                anisotropy: 1.0 / sin_grazing.clamp(1.0 / MAX_ANISOTROPY, 1.0),
            });
        }
        Ok(())
    }

    /// What 9 in 10 pixels have less of, with a filter; 0 without pixels.
    pub(super) fn error_px(&self, filter: &Setting) -> f64 {
        let taps = f64::from(filter.max_taps);
        let error = |pixel: &Pixel| {
            let texel_px = (filter.colour_texel_px * pixel.nearness).max(pixel.anisotropy / taps);
            pixel.ground_px + 0.5 * (texel_px - 1.0).max(0.0)
        };
        let mut errors: Vec<f64> = self.0.iter().map(error).collect();
        let at = (SHARE * errors.len().saturating_sub(1) as f64).round() as usize;
        if at >= errors.len() {
            return 0.0;
        }
        *errors.select_nth_unstable_by(at, f64::total_cmp).1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filter(max_taps: u32, colour_texel_px: f64) -> Setting {
        Setting {
            azimuth_steps: 64,
            radial_steps: 8,
            height_texel_px: 2.0,
            colour_texel_px,
            max_taps,
        }
    }

    #[test]
    fn a_pixels_error_is_its_grounds_and_what_its_colours_are_too_wide() {
        let pixel = Pixel {
            ground_px: 0.25,
            nearness: 0.5,
            anisotropy: 8.0,
        };
        let pixels = Pixels(vec![pixel; 100]);
        for (taps, texel_px, expected) in [
            (8, 1.0, 0.25),
            (16, 2.0, 0.25),
            (16, 4.0, 0.75),
            (4, 1.0, 0.75),
            (1, 1.0, 3.75),
        ] {
            assert_eq!(pixels.error_px(&filter(taps, texel_px)), expected);
        }
        assert_eq!(Pixels::default().error_px(&filter(1, 1.0)), 0.0);
    }

    #[test]
    fn one_in_ten_may_be_worse() {
        let of = |ground_px| Pixel {
            ground_px,
            nearness: 1.0,
            anisotropy: 1.0,
        };
        let pixels = Pixels((0..101).map(|k| of(f64::from(k))).collect());
        assert_eq!(pixels.error_px(&filter(8, 1.0)), 90.0);
    }
}
