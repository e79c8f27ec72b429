//! The finished file: directories, then tiles from the coarsest level to the full image.

use std::io::{self, Write};
use std::path::Path;

use super::spool::Spool;
use super::{CogLayout, CogSamples, tiles_of};
use crate::file::{Cancel, OverviewInfo};
use crate::write::ifd::{self, Field, Value};
use crate::write::{WriteError, atomically};

/// One level: its size and the lengths of its tiles.
struct Level {
    size: OverviewInfo,
    lengths: Vec<u64>,
    /// Number of its first tile in the spool.
    first: usize,
}

/// Puts the file in its place.
pub(super) fn assemble(
    path: &Path,
    layout: &CogLayout,
    geo: &[Field],
    sizes: &[OverviewInfo],
    spool: &Spool,
    cancel: &Cancel,
) -> Result<(), WriteError> {
    let mut first = 0;
    let mut levels = Vec::with_capacity(sizes.len());
    for size in sizes {
        let count = tiles_of(*size, layout.tile);
        let lengths = (first..first + count).map(|n| spool.length(n)).collect();
        levels.push(Level {
            size: *size,
            lengths,
            first,
        });
        first += count;
    }
    let total: u64 = levels.iter().flat_map(|l| &l.lengths).sum();
    let directories = |big: bool, starts: &[u64]| {
        let fields: Vec<Vec<Field>> = levels
            .iter()
            .zip(starts)
            .enumerate()
            .map(|(i, (l, s))| fields(layout, l, *s, i, geo))
            .collect();
        ifd::encode(&fields, big)
    };
    let none = vec![0; levels.len()];
    let limit = layout
        .largest_classic_bytes
        .min(CogLayout::LARGEST_CLASSIC_BYTES);
    let big = total + directories(true, &none).len() as u64 > limit;
    let mut at = directories(big, &none).len() as u64;
    let mut starts = none;
    for (start, level) in starts.iter_mut().zip(&levels).rev() {
        *start = at;
        at += level.lengths.iter().sum::<u64>();
    }
    let head = directories(big, &starts);
    let mut stopped = false;
    let written = atomically(path, |out| {
        out.write_all(&head)?;
        for level in levels.iter().rev() {
            for number in level.first..level.first + level.lengths.len() {
                if cancel.is_cancelled() {
                    stopped = true;
                    return Err(io::Error::other("cancelled"));
                }
                out.write_all(&spool.read(number)?)?;
            }
        }
        Ok(())
    });
    if stopped {
        Err(WriteError::Cancelled)
    } else {
        written
    }
}

/// The directory of a level whose tiles begin at `start`.
fn fields(
    layout: &CogLayout,
    level: &Level,
    start: u64,
    index: usize,
    geo: &[Field],
) -> Vec<Field> {
    let samples = layout.samples;
    let channels = samples.channels();
    let float = samples.is_float();
    let short = |tag, v: u16| Field::new(tag, Value::Short(vec![v]));
    let long = |tag, v: u32| Field::new(tag, Value::Long(vec![v]));
    let mut offset = start;
    let offsets = level.lengths.iter().map(|size| {
        let at = offset;
        offset += size;
        at
    });
    let mut fields = vec![
        long(256, level.size.width),
        long(257, level.size.height),
        Field::new(
            258,
            Value::Short(vec![if float { 32 } else { 8 }; channels]),
        ),
        short(259, 8),
        short(262, if channels >= 3 { 2 } else { 1 }),
        short(277, channels as u16),
        short(284, 1),
        short(317, if float { 3 } else { 2 }),
        long(322, layout.tile),
        long(323, layout.tile),
        Field::new(324, Value::Offset(offsets.collect())),
        Field::new(325, Value::Offset(level.lengths.clone())),
        Field::new(339, Value::Short(vec![if float { 3 } else { 1 }; channels])),
    ];
    if index > 0 {
        fields.push(long(254, 1));
    } else {
        fields.extend(geo.iter().cloned());
    }
    if samples == CogSamples::Rgba8 {
        fields.push(short(338, 2));
    }
    if let CogSamples::Height { nodata } = samples {
        let text = if nodata.is_nan() {
            "nan".to_owned()
        } else {
            format!("{nodata}")
        };
        fields.push(Field::new(42_113, Value::Ascii(text)));
    }
    fields
}
