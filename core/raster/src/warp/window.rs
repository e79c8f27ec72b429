//! Windows of a source: any rectangle of any of its levels, wrapped around the globe, reflected
//! over the poles, continued beyond its outline, and shrunk further where overviews are missing.

use glam::I64Vec2;
use relievo_planet::SampleRect;

use super::plane::SourcePlane;
use crate::file::{Cancel, PixelRect, RasterFile, ReadError};
use crate::{Bands, Block, colour};

/// Pixels read at once while shrinking.
const STRIP_PIXELS: i64 = 1 << 20;

/// At which size the source is sampled: an overview, each 2^shrink of whose columns and rows are
/// one column and row of the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Scale {
    pub(crate) overview: usize,
    pub(crate) shrink_x: u8,
    pub(crate) shrink_y: u8,
}

/// Reads the rectangle `rect` (unwrapped columns and rows at `scale`) into `out`; colours become
/// premultiplied linear light if `premultiply`.
pub(crate) fn load(
    file: &dyn RasterFile,
    source: &SourcePlane,
    scale: Scale,
    rect: &SampleRect,
    premultiply: bool,
    out: &mut Block,
    cancel: &Cancel,
) -> Result<(), ReadError> {
    let bands = file.info().bands;
    if scale.shrink_x == 0 && scale.shrink_y == 0 {
        assemble(file, source, scale.overview, rect, out, cancel)?;
        if premultiply && bands == Bands::Colour {
            colour::premultiply(out);
        }
        return Ok(());
    }
    let cell = I64Vec2::new(1 << scale.shrink_x, 1 << scale.shrink_y);
    let info = &file.info().overviews[scale.overview];
    let size = I64Vec2::new(i64::from(info.width), i64::from(info.height));
    // Where the image simply ends, cells beyond it are not made: there may be millions of times as
    // many of their pixels as of the image's own.
    let ends = [
        source.columns_around.is_none(),
        source.reflects == [false; 2],
    ];
    let held = clip(rect, (size + cell - 1) / cell, ends);
    let mut shrunk = Block::new(bands, held.width() as usize, held.height() as usize);
    let columns = (STRIP_PIXELS / (cell.x * cell.y)).clamp(1, held.width().max(1));
    let rows = (STRIP_PIXELS / (cell.x * cell.y * columns)).clamp(1, held.height().max(1));
    let mut strip = Block::new(bands, 0, 0);
    let mut y = held.min.y;
    while y < held.max.y {
        let bottom = (y + rows).min(held.max.y);
        let mut x = held.min.x;
        while x < held.max.x {
            let right = (x + columns).min(held.max.x);
            let part = SampleRect::new(I64Vec2::new(x, y), I64Vec2::new(right, bottom));
            let fine = SampleRect::new(part.min * cell, part.max * cell);
            let fine = clip(&fine, size, ends);
            assemble(file, source, scale.overview, &fine, &mut strip, cancel)?;
            if premultiply && bands == Bands::Colour {
                colour::premultiply(&mut strip);
            }
            let means = shrink(&strip, cell.x as usize, cell.y as usize);
            let to = (part.min - held.min).as_usizevec2();
            let whole = (means.width(), means.height());
            shrunk.copy_from(&means, (0, 0), (to.x, to.y), whole);
            x = right;
        }
        y = bottom;
    }
    continue_beyond(&shrunk, &held, rect, out);
    Ok(())
}

/// The part of `rect` inside 0..`size` along the axes that end, at least one sample of it.
fn clip(rect: &SampleRect, size: I64Vec2, ends: [bool; 2]) -> SampleRect {
    let along = |min: i64, max: i64, size: i64, ends: bool| {
        if !ends {
            return (min, max);
        }
        let first = min.clamp(0, size - 1);
        (first, max.clamp(first + 1, size))
    };
    let (left, right) = along(rect.min.x, rect.max.x, size.x, ends[0]);
    let (top, bottom) = along(rect.min.y, rect.max.y, size.y, ends[1]);
    SampleRect::new(I64Vec2::new(left, top), I64Vec2::new(right, bottom))
}

/// Writes the samples of `rect` into `out`, those outside of `held` as the nearest one inside.
fn continue_beyond(block: &Block, held: &SampleRect, rect: &SampleRect, out: &mut Block) {
    out.reshape(block.bands(), rect.width() as usize, rect.height() as usize);
    let (width, last) = (out.width(), held.max - 1);
    for plane in 0..block.bands().planes() {
        let (from, to) = (block.plane(plane), out.plane_mut(plane));
        for (line, y) in to.chunks_exact_mut(width.max(1)).zip(rect.min.y..) {
            let row = (y.clamp(held.min.y, last.y) - held.min.y) as usize * block.width();
            for (v, x) in line.iter_mut().zip(rect.min.x..) {
                *v = from[row + (x.clamp(held.min.x, last.x) - held.min.x) as usize];
            }
        }
    }
}

/// Means of cells of `cell_x` × `cell_y` samples, the last ones of what is left; NaN counts for
/// nothing.
fn shrink(block: &Block, cell_x: usize, cell_y: usize) -> Block {
    let (width, height) = (
        block.width().div_ceil(cell_x),
        block.height().div_ceil(cell_y),
    );
    let mut out = Block::new(block.bands(), width, height);
    let mut sums = vec![(0.0_f64, 0_u32); width];
    for plane in 0..block.bands().planes() {
        let target = out.plane_mut(plane);
        for y in 0..height {
            sums.fill((0.0, 0));
            for row in block.plane(plane)[y * cell_y * block.width()..]
                .chunks_exact(block.width().max(1))
                .take(cell_y)
            {
                for (cell, (sum, valid)) in row.chunks(cell_x).zip(&mut sums) {
                    for v in cell.iter().filter(|v| !v.is_nan()) {
                        *sum += f64::from(*v);
                        *valid += 1;
                    }
                }
            }
            for (v, (sum, valid)) in target[y * width..(y + 1) * width].iter_mut().zip(&sums) {
                *v = (sum / f64::from(*valid)) as f32; // 0 / 0 is NaN: nothing valid
            }
        }
    }
    out
}

/// A run of columns of a window: where it begins there, where in the source, how long it is.
struct Run {
    to: usize,
    from: u32,
    length: u32,
}

/// A rectangle of unwrapped columns and rows of an overview.
fn assemble(
    file: &dyn RasterFile,
    source: &SourcePlane,
    overview: usize,
    rect: &SampleRect,
    out: &mut Block,
    cancel: &Cancel,
) -> Result<(), ReadError> {
    if cancel.is_cancelled() {
        return Err(ReadError::Cancelled);
    }
    let info = &file.info().overviews[overview];
    let size = I64Vec2::new(i64::from(info.width), i64::from(info.height));
    if SampleRect::new(I64Vec2::ZERO, size).contains_rect(rect) {
        return file.read(overview, pixel_rect(rect), out, cancel);
    }
    let period = source.columns_around.map(|around| {
        ((around as f64 * size.x as f64 / source.size.x).round() as i64).clamp(1, size.x)
    });
    out.reshape(
        file.info().bands,
        rect.width() as usize,
        rect.height() as usize,
    );
    let mut part = Block::new(file.info().bands, 0, 0);

    // Rows of one kind: as they are (or continued beyond an edge), or reflected over a pole.
    let rows: Vec<(i64, bool)> = (rect.min.y..rect.max.y)
        .map(|y| source_row(source, y, size.y))
        .collect();
    for reflected in [false, true] {
        let of_kind = || {
            rows.iter()
                .enumerate()
                .filter(|(_, (_, r))| *r == reflected)
                .map(|(to, (from, _))| (to, *from))
        };
        let (Some(first), Some(last)) =
            (of_kind().map(|r| r.1).min(), of_kind().map(|r| r.1).max())
        else {
            continue;
        };
        let height = (last - first + 1) as usize;
        let turn = if reflected {
            period.map_or(0, |p| p / 2)
        } else {
            0
        };
        if let Some(period) = period {
            for run in runs(rect.min.x + turn, rect.max.x + turn, period) {
                let from = PixelRect {
                    x: run.from,
                    y: first as u32,
                    width: run.length,
                    height: height as u32,
                };
                file.read(overview, from, &mut part, cancel)?;
                for (to, row) in of_kind() {
                    out.copy_from(
                        &part,
                        (0, (row - first) as usize),
                        (run.to, to),
                        (run.length as usize, 1),
                    );
                }
            }
        } else {
            let (left, right) = (
                rect.min.x.clamp(0, size.x - 1),
                (rect.max.x - 1).clamp(0, size.x - 1),
            );
            let from = SampleRect::at(left, first, right - left + 1, height as i64);
            file.read(overview, pixel_rect(&from), &mut part, cancel)?;
            let columns: Vec<usize> = (rect.min.x..rect.max.x)
                .map(|x| (x.clamp(left, right) - left) as usize)
                .collect();
            for plane in 0..part.bands().planes() {
                let (source, width) = (part.plane(plane), columns.len());
                let target = out.plane_mut(plane);
                for (to, row) in of_kind() {
                    let line = &source[(row - first) as usize * part.width()..][..part.width()];
                    for (v, column) in target[to * width..(to + 1) * width]
                        .iter_mut()
                        .zip(&columns)
                    {
                        *v = line[*column];
                    }
                }
            }
        }
    }
    Ok(())
}

fn pixel_rect(rect: &SampleRect) -> PixelRect {
    PixelRect {
        x: rect.min.x as u32,
        y: rect.min.y as u32,
        width: rect.width() as u32,
        height: rect.height() as u32,
    }
}

/// The row of the source for a row of a window, and whether it lies beyond a pole.
fn source_row(source: &SourcePlane, y: i64, height: i64) -> (i64, bool) {
    if y < 0 && source.reflects[0] && -1 - y < height {
        (-1 - y, true)
    } else if y >= height && source.reflects[1] && 2 * height - 1 - y >= 0 {
        (2 * height - 1 - y, true)
    } else {
        (y.clamp(0, height - 1), false)
    }
}

/// Unwrapped columns `from..to` as runs within 0..period.
fn runs(from: i64, to: i64, period: i64) -> Vec<Run> {
    let mut runs = Vec::new();
    let mut x = from;
    while x < to {
        let inside = x.rem_euclid(period);
        let length = (period - inside).min(to - x);
        runs.push(Run {
            to: (x - from) as usize,
            from: inside as u32,
            length: length as u32,
        });
        x += length;
    }
    runs
}
