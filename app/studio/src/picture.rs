//! Pictures of the renderer as files, and how fine they are asked for.

pub(crate) mod labels;

use std::path::Path;

use relievo_engine::View;
use relievo_engine::planet::Camera;
use relievo_engine::planet::clipmap::rings::SECTORS;
use relievo_engine::project::{self, Aim};
use relievo_engine::raster::write::{Png, WriteError, write_png};
use relievo_engine::raster::{Bands, Block, colour};
use relievo_gpu::{AdapterClass, Front, Picture, Quality, Setting};

/// Size of a height sample on the screen in times that of a colour sample: shapes are smoother than
/// what is painted on them.
const HEIGHT_TEXEL_FACTOR: f64 = 2.0;

/// Writes a picture as PNG, whole or not at all.
///
/// # Errors
/// [`WriteError`] when the system refuses.
pub(crate) fn write(path: &Path, picture: &Picture) -> Result<(), WriteError> {
    let mut block = Block::new(
        Bands::Colour,
        picture.width as usize,
        picture.height as usize,
    );
    let [red, green, blue, alpha] = block.planes_mut();
    for (i, pixel) in picture.rgba.chunks_exact(4).enumerate() {
        red[i] = colour::from_u8(pixel[0]);
        green[i] = colour::from_u8(pixel[1]);
        blue[i] = colour::from_u8(pixel[2]);
        alpha[i] = 1.0;
    }
    write_png(path, &block, Png::Rgb8)
}

/// How finely a picture is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fineness {
    /// What the front-end spends.
    pub(crate) quality: Quality,
    /// Smallest size of a colour sample on the screen in pixels.
    pub(crate) colour_texel_px: f64,
    /// Smallest size of a height sample on the screen in pixels.
    pub(crate) height_texel_px: f64,
}

/// How finely a project is drawn on an adapter: with a setting of the measured front, or else as its
/// own settings say.
pub(crate) fn fineness(
    settings: &project::Quality,
    class: AdapterClass,
    chosen: Option<&Setting>,
) -> Fineness {
    let standard = Quality::for_adapter(class);
    let standard = Quality {
        colour_window: settings
            .colour_window_samples
            .unwrap_or(standard.colour_window),
        ..standard
    };
    if let Some(setting) = chosen {
        return Fineness {
            quality: setting.on(standard),
            colour_texel_px: setting.colour_texel_px,
            height_texel_px: setting.height_texel_px,
        };
    }
    let density = settings.mesh_density.unwrap_or(1.0).max(0.0).sqrt();
    // The mesh is cut in sectors of whole steps.
    let sectors = SECTORS;
    let azimuth_steps = (f64::from(standard.azimuth_steps) * density / f64::from(sectors))
        .round()
        .max(1.0) as u32;
    Fineness {
        quality: Quality {
            azimuth_steps: azimuth_steps * sectors,
            radial_steps: (f64::from(standard.radial_steps) * density)
                .round()
                .clamp(4.0, 200.0) as u32,
            ..standard
        },
        colour_texel_px: settings.texel_px,
        height_texel_px: settings.texel_px * HEIGHT_TEXEL_FACTOR,
    }
}

/// How finely a still is drawn, which may take longer than a frame: with the finest mesh and filter on
/// any adapter, unless the project says which error will do.
pub(crate) fn still_fineness(settings: &project::Quality, class: AdapterClass) -> Fineness {
    let front = Front::measured();
    let chosen = (settings.aim == Aim::Error)
        .then(|| &front.points()[front.cheapest_within(settings.error_px)].setting);
    let finest = fineness(settings, AdapterClass::Discrete, chosen);
    Fineness {
        quality: Quality {
            colour_window: fineness(settings, class, chosen).quality.colour_window,
            ..finest.quality
        },
        ..finest
    }
}

/// The view of a camera for a picture of a size.
pub(crate) fn view(camera: Camera, viewport_px: [u32; 2], fineness: &Fineness) -> View {
    View {
        camera,
        viewport_px,
        layout: fineness.quality.layout,
        colour_window: fineness.quality.colour_window,
        colour_texel_px: fineness.colour_texel_px,
        height_texel_px: fineness.height_texel_px,
        max_taps: fineness.quality.max_taps,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(aim: Aim, error_px: f64) -> project::Quality {
        project::Quality {
            aim,
            error_px,
            ..project::Quality::default()
        }
    }

    #[test]
    fn a_still_is_as_fine_as_any_adapter_draws_unless_an_error_is_allowed() {
        let finest = still_fineness(&settings(Aim::Adapter, 0.5), AdapterClass::Software);
        let frames = still_fineness(&settings(Aim::FrameTime, 0.5), AdapterClass::Software);
        assert_eq!(finest, frames);
        assert_eq!(finest.quality.max_taps, 8);
        let coarse = still_fineness(&settings(Aim::Error, 100.0), AdapterClass::Software);
        assert!(coarse.quality.azimuth_steps < finest.quality.azimuth_steps);
        assert_eq!(coarse.quality.colour_window, finest.quality.colour_window);
    }

    #[test]
    fn a_setting_of_the_front_takes_the_place_of_texels_and_mesh_but_not_of_windows() {
        let own = project::Quality {
            texel_px: 8.0,
            mesh_density: project::Auto::Value(0.1),
            colour_window_samples: project::Auto::Value(512),
            ..project::Quality::default()
        };
        for point in Front::measured().points() {
            let fineness = fineness(&own, AdapterClass::Software, Some(&point.setting));
            assert_eq!(fineness.quality.azimuth_steps, point.setting.azimuth_steps);
            assert_eq!(fineness.colour_texel_px, point.setting.colour_texel_px);
            assert_eq!(fineness.quality.colour_window, 512);
        }
    }
}
