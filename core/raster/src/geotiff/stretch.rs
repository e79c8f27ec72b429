//! The range of stored numbers that is shown as 0 to 1.

use super::GeoTiff;
use super::layout::{Layout, SampleFormat};
use super::samples::Meaning;
use crate::file::{Cancel, PixelRect, ReadError};
use crate::open::Stretch;
use crate::{Bands, Block};

/// Chunks looked at to choose a stretch.
const STRETCH_CHUNKS: u64 = 64;
/// Decoded bytes of chunks looked at to choose a stretch, of one chunk at least.
const STRETCH_BYTES: u64 = 256 << 20;
/// Pixels of a chunk looked at.
const STRETCH_PIXELS: u32 = 1 << 20;
/// Samples kept to choose a stretch.
const STRETCH_SAMPLES: usize = 1 << 18;

/// Kinds of stored numbers, as far as a stretch cares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Numbers {
    /// Integers of at most 8 bits.
    Bytes,
    /// Wider integers.
    Integers,
    /// Floats.
    Floats,
}

impl Numbers {
    fn of(layout: &Layout) -> Self {
        match layout.format {
            SampleFormat::Float => Self::Floats,
            SampleFormat::Unsigned | SampleFormat::Signed if layout.bits <= 8 => Self::Bytes,
            SampleFormat::Unsigned | SampleFormat::Signed => Self::Integers,
        }
    }
}

impl GeoTiff {
    /// Chooses the range that colours show; until then it is the full one of the stored type.
    pub(super) fn stretch(&mut self, stretch: Stretch) -> Result<(), ReadError> {
        let Meaning::Colour(colours) = &self.meaning else {
            return Ok(());
        };
        let numbers = Numbers::of(&self.levels[0].image.layout);
        let needed = match stretch {
            Stretch::Auto => numbers != Numbers::Bytes,
            Stretch::Full => false,
            Stretch::MinMax | Stretch::Percentile { .. } | Stretch::Range { .. } => true,
        };
        if colours.palette.is_some() || !needed {
            return Ok(());
        }
        let (first, second) = colours.range;
        let grey = colours.bands[0] == colours.bands[1];
        let mut values = if matches!(stretch, Stretch::Range { .. }) {
            Vec::new()
        } else {
            self.spread_values(if grey { 1 } else { 3 })?
        };
        for value in &mut values {
            *value = first + *value * (second - first);
            if numbers != Numbers::Floats {
                // Shown values are f32: integers come back to the unit.
                *value = libm::round(*value);
            }
        }
        let full = (first.min(second), first.max(second));
        if let (Some((low, high)), Meaning::Colour(colours)) = (
            range(&mut values, stretch, full, numbers),
            &mut self.meaning,
        ) {
            colours.range = if first > second {
                (high, low)
            } else {
                (low, high)
            };
            colours.clamp = true;
        }
        Ok(())
    }

    /// Shown values of the first planes, without holes, from chunks spread over the coarsest level.
    fn spread_values(&self, planes: usize) -> Result<Vec<f64>, ReadError> {
        let level = self.levels.len() - 1;
        let layout = &self.levels[level].image.layout;
        let chunks = u64::from(layout.columns()) * u64::from(layout.rows());
        let affordable = (STRETCH_BYTES / layout.chunk_bytes().max(1)).max(1);
        let looked_at = chunks.min(STRETCH_CHUNKS).min(affordable);
        let per_chunk = (STRETCH_SAMPLES as u64 / looked_at).max(1);
        let mut values = Vec::new();
        let mut block = Block::new(Bands::Colour, 0, 0);
        for i in 0..looked_at {
            let index = i * chunks / looked_at;
            let columns = u64::from(layout.columns());
            let x = (index % columns) as u32 * layout.chunk_width;
            let y = (index / columns) as u32 * layout.chunk_height;
            let width = layout.chunk_width.min(layout.width - x).min(STRETCH_PIXELS);
            let height = layout.chunk_height.min(layout.height - y);
            let rect = PixelRect {
                x,
                y,
                width,
                height: height.min(STRETCH_PIXELS / width),
            };
            block.reshape(Bands::Colour, rect.width as usize, rect.height as usize);
            self.read_level(level, rect, &mut block, &Cancel::default())?;
            let every =
                (u64::from(rect.width) * u64::from(rect.height) / per_chunk).max(1) as usize;
            let alpha = block.plane(3);
            for plane in 0..planes {
                let there = block.plane(plane).iter().zip(alpha).step_by(every);
                values.extend(there.filter(|(_, a)| **a > 0.0).map(|(v, _)| f64::from(*v)));
            }
        }
        Ok(values)
    }
}

/// Shown range of samples that lie as `values` does (a sample of them, without nodata); `full` is
/// the range of their type. `None` to leave values as they are.
pub(crate) fn range(
    values: &mut [f64],
    stretch: Stretch,
    full: (f64, f64),
    numbers: Numbers,
) -> Option<(f64, f64)> {
    let stretch = match stretch {
        Stretch::Auto if numbers == Numbers::Bytes => return None,
        Stretch::Auto
            if numbers == Numbers::Floats && values.iter().all(|v| (0.0..=1.0).contains(v)) =>
        {
            return None;
        }
        Stretch::Auto => Stretch::Percentile {
            low: 2.0,
            high: 98.0,
        },
        given @ (Stretch::Full
        | Stretch::MinMax
        | Stretch::Percentile { .. }
        | Stretch::Range { .. }) => given,
    };
    let (low, high) = match stretch {
        Stretch::Auto | Stretch::Full => return None,
        Stretch::Range { low, high } => (low, high),
        Stretch::MinMax => percentiles(values, 0.0, 100.0)?,
        Stretch::Percentile { low, high } => percentiles(values, low, high)?,
    };
    if low.is_finite() && high.is_finite() && low != high {
        return Some((low, high));
    }
    // One value everywhere: shown as it lies in the type's range.
    Some(full)
}

fn percentiles(values: &mut [f64], low: f64, high: f64) -> Option<(f64, f64)> {
    let last = values.len().checked_sub(1)?;
    values.sort_unstable_by(f64::total_cmp);
    let at = |percent: f64| {
        values[(libm::round(percent.clamp(0.0, 100.0) / 100.0 * last as f64) as usize).min(last)]
    };
    Some((at(low), at(high)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_leave_out_the_extremes_and_full_leaves_all_as_it_is() {
        let mut values: Vec<f64> = (0..=100).rev().map(f64::from).collect();
        let full = (0.0, 65535.0);
        assert_eq!(
            range(&mut values, Stretch::Auto, full, Numbers::Integers),
            Some((2.0, 98.0))
        );
        assert_eq!(
            range(&mut values, Stretch::MinMax, full, Numbers::Integers),
            Some((0.0, 100.0))
        );
        assert_eq!(
            range(&mut values, Stretch::Full, full, Numbers::Integers),
            None
        );
        assert_eq!(
            range(&mut values, Stretch::Auto, full, Numbers::Bytes),
            None
        );
        assert_eq!(
            range(&mut [3.0, 3.0], Stretch::MinMax, full, Numbers::Integers),
            Some(full)
        );
        assert_eq!(
            range(&mut [], Stretch::MinMax, full, Numbers::Integers),
            None
        );
    }
}
