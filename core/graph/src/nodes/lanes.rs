//! Many samples at a time.

use relievo_raster::Block;

/// Samples that are worked on together: their planes stay in the nearest cache, and loops over them
/// have a fixed length, which suits vectors.
pub(crate) const LANES: usize = 64;

/// One plane of them.
pub(crate) type Lanes = [f32; LANES];

/// Red, green, blue, alpha.
pub(crate) type Colours = [Lanes; 4];

/// Reads the colours from `first` on, as many as there are, at most [`LANES`]; further lanes stay
/// as they are.
#[inline(always)]
pub(crate) fn read(planes: [&[f32]; 4], first: usize, lanes: &mut Colours) {
    for (lanes, plane) in lanes.iter_mut().zip(planes) {
        copy(&plane[first..], lanes);
    }
}

/// Copies the first values, as many as there are, at most [`LANES`].
#[inline(always)]
pub(crate) fn copy(from: &[f32], to: &mut Lanes) {
    if let Some(all) = from.first_chunk() {
        *to = *all;
    } else {
        to[..from.len()].copy_from_slice(from);
    }
}

/// Writes lanes to the samples from `first` on, as many as there are.
#[inline(always)]
pub(crate) fn write(lanes: &Lanes, plane: &mut [f32], first: usize) {
    let plane = &mut plane[first..];
    if let Some(all) = plane.first_chunk_mut() {
        *all = *lanes;
    } else {
        let n = plane.len();
        plane.copy_from_slice(&lanes[..n]);
    }
}

/// The planes of a block of colours.
pub(crate) fn planes(block: &Block) -> [&[f32]; 4] {
    core::array::from_fn(|plane| block.plane(plane))
}
