//! What is added to a layer: seams of a block and its surroundings, and the membrane through them.

use std::sync::Arc;

use glam::I64Vec2;
use relievo_planet::{Grid, Planet, SampleRect};
use relievo_raster::vector::on_widest;
use relievo_raster::{Block, Cancel};

use super::coarse::{Around, Coarse};
use super::places::Places;
use crate::node::{Artefact, Made};
use crate::{ContentId, IdHasher, RenderError};

/// Samples that are worked on together.
const LANES: usize = 16;

/// Far away from every seam, in units of the support.
const FAR: f32 = 1e15;

/// Squares of distances count as no less than this: there a seam's own difference is all that counts.
const LEAST_SQUARE: f32 = 1e-14;

/// Makes a block of corrections.
pub(super) struct Membrane {
    pub(super) planet: Planet,
    /// Of the node.
    pub(super) name: ContentId,
    pub(super) coarse: Arc<Coarse>,
    pub(super) around: Around,
    /// Metres from a seam at which nothing is left.
    pub(super) support_m: f64,
    pub(super) masked: bool,
}

/// What is added to the colours of a block of coarse samples.
pub(super) struct Corrections {
    pub(super) block: SampleRect,
    /// Red, green and blue, row by row; `None` where no seam is near.
    pub(super) planes: Option<[Vec<f32>; 3]>,
}

impl Corrections {
    /// Those of a sample of the block.
    pub(super) fn at(&self, sample: I64Vec2) -> Option<[f32; 3]> {
        let from = sample - self.block.min;
        let i = (from.y * self.block.width() + from.x) as usize;
        let planes = self.planes.as_ref()?;
        Some(core::array::from_fn(|channel| planes[channel][i]))
    }
}

impl Artefact for Membrane {
    fn identify(&self, id: &mut IdHasher) {
        id.bytes(super::KIND.as_bytes())
            .id(self.name)
            .grid(&Grid::new(
                Arc::clone(&self.coarse.lattice),
                self.around.block,
            ));
    }

    fn reads(&self) -> Vec<(usize, Grid)> {
        let read = Grid::new(Arc::clone(&self.coarse.lattice), self.around.read);
        let inputs = if self.masked { 3 } else { 2 };
        (0..inputs).map(|input| (input, read.clone())).collect()
    }

    fn make(&self, samples: &[Block], cancel: &Cancel) -> Result<Made, RenderError> {
        let mask = samples.get(2).map(|mask| mask.plane(0));
        let first = self.around.read.min;
        let layer = Layer::new(first, &samples[0], &samples[1], mask);
        let places = Places::new(
            &self.planet,
            &self.coarse.lattice,
            self.around.seams,
            self.support_m,
        )?;
        let seams = Seams::new(&layer, &places, self.around.seams);
        let planes = if seams.column.is_empty() {
            None
        } else {
            self.corrections(&layer, &places, &seams, cancel)?
        };
        Ok(Arc::new(Corrections {
            block: self.around.block,
            planes,
        }))
    }

    fn bytes(&self) -> usize {
        /// Three channels.
        const SAMPLE: usize = 3 * 4;
        self.around.block.area() as usize * SAMPLE
    }
}

/// The layer and what lies below it, as they are read.
struct Layer<'a> {
    below: [&'a [f32]; 3],
    top: [&'a [f32]; 3],
    /// What was read.
    first: I64Vec2,
    stride: usize,
    /// Whether the layer is there: more than half.
    shows: Vec<bool>,
    /// Whether anything is below.
    below_is_there: Vec<bool>,
}

impl<'a> Layer<'a> {
    /// `first` is the first sample that was read.
    fn new(first: I64Vec2, below: &'a Block, top: &'a Block, mask: Option<&[f32]>) -> Self {
        Self {
            below: core::array::from_fn(|plane| below.plane(plane)),
            top: core::array::from_fn(|plane| top.plane(plane)),
            first,
            stride: top.width(),
            shows: is_there(top, mask),
            below_is_there: is_there(below, None),
        }
    }

    /// How many sides of a sample lie in a seam: those to the west and east, those to the north and
    /// south. A seam is where the layer is, next to where it is not, with something below on both sides.
    fn seam_sides(&self, i: usize) -> [usize; 2] {
        if !self.shows[i] || !self.below_is_there[i] {
            return [0; 2];
        }
        let beyond = |k: usize| usize::from(!self.shows[k] && self.below_is_there[k]);
        [
            beyond(i - 1) + beyond(i + 1),
            beyond(i - self.stride) + beyond(i + self.stride),
        ]
    }

    /// Where a sample is kept.
    fn at(&self, sample: I64Vec2) -> usize {
        let from = sample - self.first;
        from.y as usize * self.stride + from.x as usize
    }

    /// The difference at a seam right beside a sample where the layer is not, or at its corners. Up to
    /// there, where the finer seam may lie, differences go on as they are.
    fn difference_beside(&self, i: usize) -> Option<[f32; 3]> {
        let (north, south) = (i - self.stride, i + self.stride);
        let sides = [north, i - 1, i + 1, south];
        let corners = [north - 1, north + 1, south - 1, south + 1];
        [sides, corners].into_iter().find_map(|places| {
            let mut sum = [0.0; 3];
            let mut count = 0.0;
            for k in places {
                if self.seam_sides(k) != [0; 2] {
                    let difference = self.difference(k);
                    sum = core::array::from_fn(|c| sum[c] + difference[c]);
                    count += 1.0;
                }
            }
            (count > 0.0).then(|| sum.map(|sum| sum / count))
        })
    }

    fn difference(&self, i: usize) -> [f32; 3] {
        core::array::from_fn(|c| self.below[c][i] - self.top[c][i])
    }
}

/// Where there are colours: more than half, and numbers.
fn is_there(colours: &Block, mask: Option<&[f32]>) -> Vec<bool> {
    let [r, g, b, alpha] = core::array::from_fn(|plane| colours.plane(plane));
    let rgb = r.iter().zip(g).zip(b);
    let are_numbers = rgb.map(|((r, g), b)| r.is_finite() & g.is_finite() & b.is_finite());
    let samples = are_numbers.zip(alpha);
    match mask {
        Some(mask) => samples
            .zip(mask)
            .map(|((are, alpha), weight)| are & (alpha * weight > 0.5))
            .collect(),
        None => samples.map(|(are, alpha)| are & (*alpha > 0.5)).collect(),
    }
}

/// The samples of all seams, row by row and from west to east.
#[derive(Default)]
struct Seams {
    /// Of the first row.
    first_row: i64,
    /// Where each row begins, and where the last one ends.
    rows: Vec<usize>,
    column: Vec<i64>,
    place: Vec<[f32; 3]>,
    /// Below less layer.
    difference: Vec<[f32; 3]>,
    /// Length of seam that the sample stands for.
    length: Vec<f32>,
}

impl Seams {
    fn new(layer: &Layer, places: &Places, rect: SampleRect) -> Self {
        let mut seams = Self {
            first_row: rect.min.y,
            ..Self::default()
        };
        for y in rect.min.y..rect.max.y {
            seams.rows.push(seams.column.len());
            for x in rect.min.x..rect.max.x {
                let i = layer.at(I64Vec2::new(x, y));
                let sides = layer.seam_sides(i);
                if sides == [0; 2] {
                    continue;
                }
                let sample = I64Vec2::new(x, y);
                let Some(place) = places.at(sample) else {
                    continue;
                };
                // A step of stairs stands for the slope through it.
                let [column, row] = places.steps(sample);
                let [north, east] = [sides[0] as f32 * row, sides[1] as f32 * column];
                let length = (north * north + east * east).sqrt();
                seams.column.push(x);
                seams.place.push(place);
                seams.difference.push(layer.difference(i));
                seams.length.push(length.max(f32::MIN_POSITIVE));
            }
        }
        seams.rows.push(seams.column.len());
        seams
    }

    /// The samples of a row between two columns.
    #[inline(always)]
    fn between(&self, row: i64, columns: Option<(i64, i64)>) -> core::ops::Range<usize> {
        let at = (row - self.first_row) as usize;
        let (start, end) = (self.rows[at], self.rows[at + 1]);
        let Some((west, east)) = columns else {
            return start..end;
        };
        let row = &self.column[start..end];
        start + row.partition_point(|x| *x < west)..start + row.partition_point(|x| *x < east)
    }
}

/// Sums over the seams that are seen from some samples.
#[derive(Clone, Copy)]
struct Sums {
    weight: [f32; LANES],
    difference: [[f32; LANES]; 3],
    /// Square of the distance to the nearest.
    nearest: [f32; LANES],
}

impl Membrane {
    /// Row by row; `None` if all of them are 0.
    fn corrections(
        &self,
        layer: &Layer,
        places: &Places,
        seams: &Seams,
        cancel: &Cancel,
    ) -> Result<Option<[Vec<f32>; 3]>, RenderError> {
        let block = self.around.block;
        let width = block.width() as usize;
        let samples = block.area() as usize;
        let mut planes: [Vec<f32>; 3] = core::array::from_fn(|_| vec![0.0; samples]);
        let half = (0.5 * self.coarse.spacing_m / self.support_m) as f32;
        let mut any = false;
        for y in block.min.y..block.max.y {
            if cancel.is_cancelled() {
                return Err(RenderError::Cancelled);
            }
            let row = (y - block.min.y) as usize * width;
            for first in (0..width).step_by(LANES) {
                let x = block.min.x + first as i64;
                let count = LANES.min(width - first);
                let mut at = [[FAR; LANES]; 3];
                for lane in 0..count {
                    if let Some(place) = places.at(I64Vec2::new(x + lane as i64, y)) {
                        for (at, v) in at.iter_mut().zip(place) {
                            at[lane] = v;
                        }
                    }
                }
                let sums = on_widest(
                    #[inline(always)]
                    || self.sums(seams, &at, I64Vec2::new(x, y)),
                );
                for lane in 0..count {
                    // Where the layer is, its samples lie half a sample inside of the seam.
                    let i = layer.at(I64Vec2::new(x + lane as i64, y));
                    let side = if layer.shows[i] { half } else { -half };
                    let distance = (sums.nearest[lane].sqrt() + side).max(0.0);
                    if sums.weight[lane] <= 0.0 || distance >= 1.0 {
                        continue;
                    }
                    any = true;
                    let beside = if layer.shows[i] {
                        None
                    } else {
                        layer.difference_beside(i)
                    };
                    let met = beside.unwrap_or_else(|| {
                        sums.difference.map(|sum| sum[lane] / sums.weight[lane])
                    });
                    for (plane, met) in planes.iter_mut().zip(met) {
                        plane[row + first + lane] = taper(distance) * met;
                    }
                }
            }
        }
        Ok(any.then_some(planes))
    }

    /// Sums for some samples of a row, the first of which is `sample`.
    #[inline(always)]
    fn sums(&self, seams: &Seams, at: &[[f32; LANES]; 3], sample: I64Vec2) -> Sums {
        let Around {
            block,
            seams: read,
            most_columns,
            ..
        } = self.around;
        let mut sums = Sums {
            weight: [0.0; LANES],
            difference: [[0.0; LANES]; 3],
            nearest: [FAR; LANES],
        };
        let per_column = most_columns.map_or(0.0, |most| 1.0 / most as f32);
        let per_row = 1.0 / Around::MOST_ROWS as f32;
        let rows = read.max.y - block.max.y;
        let rows = rows.max(block.min.y - read.min.y);
        let halo = block.min.x - read.min.x;
        let columns = most_columns.map(|_| (sample.x - halo, sample.x + LANES as i64 + halo));
        let (north, south) = (
            (sample.y - rows).max(read.min.y),
            (sample.y + rows + 1).min(read.max.y),
        );
        for y in north..south {
            let from_row = (y - sample.y) as f32 * per_row;
            let least = from_row * from_row;
            for i in seams.between(y, columns) {
                let (place, length) = (seams.place[i], seams.length[i]);
                let difference = seams.difference[i];
                let from_column = (sample.x - seams.column[i]) as f32;
                for lane in 0..LANES {
                    let [dx, dy, dz] = [0, 1, 2].map(|axis| at[axis][lane] - place[axis]);
                    let square = dx * dx + dy * dy + dz * dz;
                    let across = (from_column + lane as f32) * per_column;
                    let square = larger(square, larger(across * across, least));
                    let left = larger(1.0 - square, 0.0);
                    let weight = length * left * left / larger(square, LEAST_SQUARE);
                    sums.weight[lane] += weight;
                    for (sum, v) in sums.difference.iter_mut().zip(difference) {
                        sum[lane] += weight * v;
                    }
                    let nearest = sums.nearest[lane];
                    sums.nearest[lane] = if square < nearest { square } else { nearest };
                }
            }
        }
        sums
    }
}

#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// 1 at a seam, 0 at the end of the support, level at both.
fn taper(distance: f32) -> f32 {
    1.0 - distance * distance * (3.0 - 2.0 * distance)
}
