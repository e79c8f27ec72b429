//! What a missing tile shows: the next coarser level, linearly between its samples.

use crate::file::{OverviewInfo, PixelRect};
use crate::{Bands, Block, colour};

/// Makes a part of a block a hole.
pub(super) fn empty(part: PixelRect, out: &mut Block) {
    let value = if out.bands() == Bands::Height {
        f32::NAN
    } else {
        0.0
    };
    let width = out.width();
    for plane in 0..out.bands().planes() {
        let samples = out.plane_mut(plane);
        for y in part.y as usize..(part.y + part.height) as usize {
            let first = y * width + part.x as usize;
            samples[first..first + part.width as usize].fill(value);
        }
    }
}

/// Pixels of the level of half the size around a rectangle, one more on each side that has one.
pub(super) fn needs(wanted: PixelRect, coarse: OverviewInfo) -> PixelRect {
    let range = |first: u32, count: u32, side: u32| {
        let from = (first / 2).saturating_sub(u32::from(first.is_multiple_of(2)));
        let to = ((first + count - 1) / 2 + 2).min(side);
        (from, to - from)
    };
    let (x, width) = range(wanted.x, wanted.width, coarse.width);
    let (y, height) = range(wanted.y, wanted.height, coarse.height);
    PixelRect {
        x,
        y,
        width,
        height,
    }
}

/// The two coarse samples around a fine one along an axis, as indices within what is there; the
/// nearer one, which has three quarters of the weight, first.
fn pair(fine: u32, first: u32, count: u32) -> (usize, usize) {
    let near = fine / 2;
    let far = if fine.is_multiple_of(2) {
        near.saturating_sub(1)
    } else {
        near + 1
    };
    let inside = |i: u32| (i.max(first) - first).min(count - 1) as usize;
    (inside(near), inside(far))
}

/// Writes the rectangle `wanted` at `part` of `out`, made from `coarse`, which stands for `needs` of
/// the level of half the size. Holes have no weight.
pub(super) fn doubled(
    mut coarse: Block,
    needs: PixelRect,
    wanted: PixelRect,
    part: PixelRect,
    out: &mut Block,
) {
    let bands = out.bands();
    if bands == Bands::Colour {
        colour::premultiply(&mut coarse);
    }
    let mut made = Block::new(bands, part.width as usize, part.height as usize);
    let width = needs.width as usize;
    for y in 0..part.height {
        let (near_row, far_row) = pair(wanted.y + y, needs.y, needs.height);
        for x in 0..part.width {
            let (near, far) = pair(wanted.x + x, needs.x, needs.width);
            let taps = [
                (near_row * width + near, 9.0 / 16.0),
                (near_row * width + far, 3.0 / 16.0),
                (far_row * width + near, 3.0 / 16.0),
                (far_row * width + far, 1.0 / 16.0),
            ];
            let i = (y * part.width + x) as usize;
            for plane in 0..bands.planes() {
                let samples = coarse.plane(plane);
                let (mut sum, mut weight) = (0.0_f64, 0.0_f64);
                for (at, w) in taps {
                    if !samples[at].is_nan() {
                        sum += w * f64::from(samples[at]);
                        weight += w;
                    }
                }
                // A hole keeps its edge: it neither grows nor shrinks by more than half a pixel.
                made.plane_mut(plane)[i] = if weight >= 0.5 {
                    (sum / weight) as f32
                } else {
                    f32::NAN
                };
            }
        }
    }
    if bands == Bands::Colour {
        colour::unpremultiply(&mut made);
    }
    out.copy_from(
        &made,
        (0, 0),
        (part.x as usize, part.y as usize),
        (part.width as usize, part.height as usize),
    );
}
