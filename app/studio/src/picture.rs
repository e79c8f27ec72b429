//! Pictures of the renderer as files, and how fine they are asked for.

pub(crate) mod labels;

use std::path::Path;

use relievo_engine::View;
use relievo_engine::planet::Camera;
use relievo_engine::planet::clipmap::rings::SECTORS;
use relievo_engine::project;
use relievo_engine::raster::write::{Png, WriteError, write_png};
use relievo_engine::raster::{Bands, Block, colour};
use relievo_gpu::{AdapterClass, Picture, Quality};

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

/// What the front-end spends on a project's pictures on an adapter.
pub(crate) fn quality(settings: &project::Quality, class: AdapterClass) -> Quality {
    let standard = Quality::for_adapter(class);
    let density = settings.mesh_density.unwrap_or(1.0).max(0.0).sqrt();
    // The mesh is cut in sectors of whole steps.
    let sectors = SECTORS;
    let azimuth_steps = (f64::from(standard.azimuth_steps) * density / f64::from(sectors))
        .round()
        .max(1.0) as u32;
    Quality {
        colour_window: settings
            .colour_window_samples
            .unwrap_or(standard.colour_window),
        azimuth_steps: azimuth_steps * sectors,
        radial_steps: (f64::from(standard.radial_steps) * density)
            .round()
            .clamp(4.0, 200.0) as u32,
        ..standard
    }
}

/// What is spent on a still, which may take longer than a frame: the finest mesh and filter on any
/// adapter.
pub(crate) fn still_quality(settings: &project::Quality, class: AdapterClass) -> Quality {
    let finest = quality(settings, AdapterClass::Discrete);
    Quality {
        colour_window: quality(settings, class).colour_window,
        ..finest
    }
}

/// The view of a camera for a picture of a size.
pub(crate) fn view(
    camera: Camera,
    viewport_px: [u32; 2],
    settings: &project::Quality,
    quality: &Quality,
) -> View {
    View {
        camera,
        viewport_px,
        layout: quality.layout,
        colour_window: quality.colour_window,
        colour_texel_px: settings.texel_px,
        height_texel_px: settings.texel_px * HEIGHT_TEXEL_FACTOR,
        max_taps: quality.max_taps,
    }
}
