//! What the bands of a file are: heights or colours, by what the file says and the caller asks.

use super::fault::{Fault, damaged, unsupported};
use super::ifd::{Ifd, TiffBytes, tag};
use super::layout::{Layout, SampleFormat, photometric};
use super::samples::{Alpha, Colours, Heights, Meaning};
use crate::Bands;
use crate::open::OpenOptions;

/// Why the bands have no meaning: the file's fault, or the caller's.
pub(crate) enum MeaningError {
    File(Fault),
    Options(String),
}

impl From<Fault> for MeaningError {
    fn from(fault: Fault) -> Self {
        Self::File(fault)
    }
}

/// What was decided of the bands before anything is known of their values.
pub(crate) struct Choice {
    /// Heights or colours.
    pub(crate) bands: Bands,
    /// Bands of the file: one or three.
    pub(crate) selected: Vec<u16>,
    /// Band of alpha, and whether colours are multiplied with it.
    pub(crate) alpha: Option<(u16, bool)>,
}

impl Choice {
    /// Decides by photometric interpretation, band count, sample type and options.
    pub(crate) fn of(layout: &Layout, options: &OpenOptions) -> Result<Self, MeaningError> {
        let extras = layout.extra_samples.len() as u16;
        let first_extra = layout.samples - extras.min(layout.samples);
        let alpha = layout
            .extra_samples
            .iter()
            .position(|e| matches!(e, 1 | 2))
            .map(|i| (first_extra + i as u16, layout.extra_samples[i] == 1));
        let data = layout.samples - u16::from(alpha.is_some());
        let natural = natural(layout, data, alpha.is_some())?;
        let asked = match (&options.select, options.as_bands) {
            (_, Some(bands @ (Bands::Height | Bands::Colour))) => Some(bands),
            (_, Some(other)) => {
                return Err(MeaningError::Options(format!(
                    "files hold heights or colours, {other:?} was asked for"
                )));
            }
            (Some(select), None) if select.len() >= 3 => Some(Bands::Colour),
            _ => None,
        };
        let bands = asked.unwrap_or(natural);
        let selected = match &options.select {
            Some(select) => {
                let fits =
                    select.len() == 1 || (matches!(select.len(), 3 | 4) && bands == Bands::Colour);
                if !fits || select.iter().any(|b| *b >= layout.samples) {
                    return Err(MeaningError::Options(format!(
                        "expected 1 band for heights, 1, 3 or 4 for colours, each below {}, found {select:?}",
                        layout.samples
                    )));
                }
                select.clone()
            }
            None if bands == Bands::Colour
                && natural == Bands::Colour
                && data >= 3
                && layout.photometric != photometric::PALETTE =>
            {
                vec![0, 1, 2]
            }
            None => vec![0],
        };
        let mut selected = selected;
        let alpha = match (selected.len(), alpha) {
            // The fourth that is asked for is alpha, multiplied in only where the file says so of it.
            (4, own) => selected.pop().map(|band| (band, own == Some((band, true)))),
            // Who names three bands means these: what files call alpha is often a fourth band of
            // a camera (near infrared). Multiplied in, it belongs to the colours.
            (3, Some((_, false))) if options.select.is_some() => None,
            (_, own) => own.filter(|(band, _)| !selected.contains(band)),
        };
        Ok(Self {
            bands,
            selected,
            alpha,
        })
    }
}

/// What a file holds when nobody asks for anything else.
fn natural(layout: &Layout, data: u16, alpha: bool) -> Result<Bands, Fault> {
    match layout.photometric {
        photometric::RGB | photometric::YCBCR if layout.samples < 3 => damaged(format!(
            "expected at least 3 bands in a colour image, found {}",
            layout.samples
        )),
        photometric::YCBCR
            if layout.compression != super::layout::compression::JPEG || layout.planar =>
        {
            unsupported("expected YCbCr colours in interleaved JPEG compression, found another")
        }
        photometric::PALETTE if layout.bits > 16 || layout.format != SampleFormat::Unsigned => {
            unsupported(format!(
                "expected a palette of at most 16 bits, found {} bits",
                layout.bits
            ))
        }
        photometric::RGB | photometric::YCBCR | photometric::PALETTE => Ok(Bands::Colour),
        photometric::WHITE_IS_ZERO | photometric::BLACK_IS_ZERO | photometric::MASK => {
            let picture = layout.bits == 1 || (data == 1 && alpha && layout.bits == 8);
            Ok(if picture || data >= 3 {
                Bands::Colour
            } else {
                Bands::Height
            })
        }
        other => {
            let name = match other {
                5 => "CMYK",
                8..=10 => "Lab",
                32803 => "a camera's raw mosaic",
                _ => "another interpretation",
            };
            unsupported(format!(
                "expected grey, RGB, palette or YCbCr samples, found {name} (number {other})"
            ))
        }
    }
}

/// What to apply to heights.
pub(crate) struct HeightScale {
    pub(crate) scale: f64,
    pub(crate) offset: f64,
}

/// The meaning that follows from the choice; colours get the full range of their type, to be
/// narrowed by a stretch.
pub(crate) fn meaning(
    file: &TiffBytes,
    ifd: &Ifd,
    layout: &Layout,
    choice: &Choice,
    scale: &HeightScale,
    nodata: Option<f64>,
) -> Result<Meaning, Fault> {
    if choice.bands == Bands::Height {
        return Ok(Meaning::Height(Heights {
            band: choice.selected[0],
            scale: scale.scale,
            offset: scale.offset,
            alpha: choice.alpha.map(|(band, _)| band),
            nodata,
        }));
    }
    let (low, high) = full_range(layout);
    let bands = match choice.selected.as_slice() {
        &[r, g, b] => [r, g, b],
        other => [other[0]; 3],
    };
    let palette = (layout.photometric == photometric::PALETTE)
        .then(|| palette(file, ifd, layout.bits))
        .transpose()?;
    let inverted = layout.photometric == photometric::WHITE_IS_ZERO;
    Ok(Meaning::Colour(Colours {
        bands,
        palette,
        range: if inverted { (high, low) } else { (low, high) },
        clamp: layout.format != SampleFormat::Float,
        alpha: choice.alpha.map(|(band, associated)| Alpha {
            band,
            full: high,
            associated,
        }),
        nodata,
    }))
}

/// Lowest and highest value of a sample type; 0 and 1 for floats.
pub(crate) fn full_range(layout: &Layout) -> (f64, f64) {
    let steps = |bits: u16| libm::exp2(f64::from(bits));
    match layout.format {
        SampleFormat::Unsigned => (0.0, steps(layout.bits) - 1.0),
        SampleFormat::Signed => (-steps(layout.bits - 1), steps(layout.bits - 1) - 1.0),
        SampleFormat::Float => (0.0, 1.0),
    }
}

fn palette(file: &TiffBytes, ifd: &Ifd, bits: u16) -> Result<Vec<[f32; 4]>, Fault> {
    let entries = 1usize << bits;
    let values = file.unsigned_vec(ifd, tag::COLOUR_MAP, 3 << 16)?;
    if values.len() < 3 * entries {
        return damaged(format!(
            "expected a colour map of {} values, found {}",
            3 * entries,
            values.len()
        ));
    }
    // Some writers fill in 8-bit colours.
    let full = if values.iter().all(|v| *v < 256) {
        255.0
    } else {
        65535.0
    };
    let shown = |i: usize| (values[i] as f64 / full) as f32;
    Ok((0..entries)
        .map(|i| [shown(i), shown(entries + i), shown(2 * entries + i), 1.0])
        .collect())
}
