//! What is measured of a source: patch by patch how rough and how steep it is.

use core::f64::consts::PI;
use std::sync::Arc;

use glam::I64Vec2;
use relievo_planet::{Grid, LevelKey, Planet, SampleRect, TILE_SAMPLES};
use relievo_raster::{Block, Cancel};

use super::steepness::{Cells, steepness};
use crate::node::{Artefact, Made};
use crate::roughness::{Energy, Measured, PowerLaw, Surface};
use crate::{ContentId, IdHasher, RenderError};

/// Samples along a side of a cell of roughness.
pub(super) const WIDE: usize = 32;
/// Samples along a side of a cell of steepness.
pub(super) const NARROW: usize = 2;
/// Cells along a side of a patch.
pub(super) const WIDE_CELLS: usize = TILE_SAMPLES as usize / WIDE;
pub(super) const NARROW_CELLS: usize = TILE_SAMPLES as usize / NARROW;

/// Lags in samples: from one or two of the data, where what they lack can still be told, to half a cell.
const LAGS: [usize; 4] = [2, 4, 8, 16];

/// Samples read around a patch: a ring of wide cells, and the longest lag around that.
pub(super) const MARGIN: usize = WIDE + 16;

/// Side of what is read.
const SIDE: usize = TILE_SAMPLES as usize + 2 * MARGIN;

/// Wide cells along a side of a patch with a ring around it.
const RINGED: usize = WIDE_CELLS + 2;

/// Differences below which a lag says nothing of a region.
const FEW: u64 = 64;

/// How many times rougher than its surroundings a place may be for its steepness.
const STEEPEST: f32 = 3.0;

/// How a source is measured; the same for all of its patches.
#[derive(Clone, Debug)]
pub(super) struct Survey {
    planet: Planet,
    /// Rows of patches: 2 to this power from pole to pole.
    n: u8,
    spacing_m: f64,
    /// How much roughness follows steepness, 0 to 1.
    slope: f64,
    /// Where the law is read.
    longest_m: f64,
    /// Logarithm of the energy of octaves of variance 1 that follow a law, by its exponent.
    ln_gain: fn(f64) -> f64,
    name: ContentId,
}

impl Survey {
    /// A survey of data `spacing_m` apart for octaves from `longest_m` down.
    pub(super) fn new(
        planet: Planet,
        spacing_m: f64,
        slope: f64,
        longest_m: f64,
        ln_gain: fn(f64) -> f64,
    ) -> Self {
        let spacing_rad = spacing_m / planet.radius_m;
        // A little coarser counts as fine enough: data are rarely spaced as tiles are.
        let n = (0..FINEST)
            .find(|n| LevelKey::new(0, *n).step_rad().y <= spacing_rad * 1.01)
            .unwrap_or(FINEST);
        let mut id = IdHasher::default();
        for v in [
            planet.radius_m,
            spacing_m,
            slope,
            longest_m,
            ln_gain(0.5),
            ln_gain(1.0),
        ] {
            id.float(v);
        }
        Self {
            planet,
            n,
            spacing_m,
            slope,
            longest_m,
            ln_gain,
            name: id.finish(),
        }
    }

    /// Rows of patches from pole to pole.
    pub(super) fn rows(&self) -> i64 {
        1 << self.n
    }

    /// The planet.
    pub(super) fn planet(&self) -> &Planet {
        &self.planet
    }

    /// Wavelength of the longest octave in metres.
    pub(super) fn longest_m(&self) -> f64 {
        self.longest_m
    }

    /// Patches of a row around the planet.
    pub(super) fn columns(&self, row: i64) -> i64 {
        self.level(row).tiles().x
    }

    /// The level whose tiles are the patches of a row: its samples are about square on the ground.
    pub(super) fn level(&self, row: i64) -> LevelKey {
        let sin_colat = libm::sin((row as f64 + 0.5) / self.rows() as f64 * PI);
        let m = f64::from(self.n) + 1.0 + libm::log2(sin_colat);
        LevelKey::new(libm::round(m).clamp(0.0, 25.0) as u8, self.n)
    }

    /// Side of a sample of the survey along meridians, metres.
    pub(super) fn step_m(&self) -> f64 {
        LevelKey::new(0, self.n).step_rad().y * self.planet.radius_m
    }
}

/// Finest level of a survey: 4.7 mm on Earth.
const FINEST: u8 = 24;

/// A patch that is to be measured: a tile of the survey's level.
pub(super) struct PatchOf {
    pub(super) survey: Arc<Survey>,
    pub(super) column: i64,
    pub(super) row: i64,
}

/// What was measured of a patch.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Patch {
    pub(super) column: i64,
    pub(super) row: i64,
    /// Of each wide cell: the height of the longest octave, in metres per unit of steepness, and the factor
    /// on it from octave to octave.
    pub(super) law: Vec<[f32; 2]>,
    /// The steepness of each narrow cell to the power of its share; 0 about what is level.
    pub(super) steepness: Vec<f32>,
}

impl Artefact for PatchOf {
    fn identify(&self, id: &mut IdHasher) {
        id.bytes(b"roughness")
            .id(self.survey.name)
            .int(i64::from(self.survey.n))
            .int(self.column)
            .int(self.row);
    }

    fn reads(&self) -> Vec<(usize, Grid)> {
        let level = self.survey.level(self.row);
        let first = I64Vec2::new(self.column, self.row) * TILE_SAMPLES - MARGIN as i64;
        let rect = SampleRect::at(first.x, first.y, SIDE as i64, SIDE as i64);
        vec![(0, Grid::new(Arc::new(level.lattice()), rect))]
    }

    fn make(&self, samples: &[Block], cancel: &Cancel) -> Result<Made, RenderError> {
        let heights = samples.first().map_or(&[][..], |block| block.plane(0));
        if cancel.is_cancelled() {
            return Err(RenderError::Cancelled);
        }
        Ok(Arc::new(self.measure(heights)))
    }

    fn bytes(&self) -> usize {
        8 * WIDE_CELLS * WIDE_CELLS + 4 * NARROW_CELLS * NARROW_CELLS
    }
}

impl PatchOf {
    fn measure(&self, heights: &[f32]) -> Patch {
        let survey = &*self.survey;
        let lattice = survey.level(self.row).lattice();
        let radius_m = survey.planet.radius_m;
        let first_row = self.row * TILE_SAMPLES - MARGIN as i64;
        let across_m = |row: usize| {
            let colat_rad = lattice.centre(I64Vec2::new(0, first_row + row as i64)).y;
            lattice.step.x * libm::sin(colat_rad).abs() * radius_m
        };
        let surface = Surface::new(heights, SIDE, survey.step_m(), across_m);
        let cells = steepness(heights, survey.step_m(), across_m, survey.slope);
        let energies: Vec<[Energy; LAGS.len()]> = (0..RINGED * RINGED)
            .map(|cell| {
                let start = |i: usize| MARGIN - WIDE + i * WIDE;
                let (x, y) = (start(cell % RINGED), start(cell / RINGED));
                LAGS.map(|lag| surface.energy(lag, x..x + WIDE, y..y + WIDE))
            })
            .collect();
        let mut patch = Patch {
            column: self.column,
            row: self.row,
            law: Vec::with_capacity(WIDE_CELLS * WIDE_CELLS),
            steepness: vec![0.0; NARROW_CELLS * NARROW_CELLS],
        };
        for y in 0..WIDE_CELLS {
            for x in 0..WIDE_CELLS {
                let around: Vec<&[Energy; LAGS.len()]> = (0..9)
                    .map(|i| &energies[(y + i / 3) * RINGED + x + i % 3])
                    .collect();
                let usual = usual_steepness(&cells, x, y);
                let law = self.law(&surface, &around);
                let of_unit = law.map_or([0.0; 2], |[height_m, falloff]| {
                    [height_m / usual.max(f32::MIN_POSITIVE), falloff]
                });
                let flat = usual <= 0.0 || !of_unit[0].is_finite();
                patch.law.push(if flat { [0.0; 2] } else { of_unit });
                patch.fill(&cells, (x, y), usual);
            }
        }
        patch
    }

    /// The law of the cells around one: by the geometric means of their energies, so that a single cliff
    /// does not decide. The height of the longest octave and the factor from octave to octave.
    fn law(&self, surface: &Surface, around: &[&[Energy; LAGS.len()]]) -> Option<[f32; 2]> {
        let mut measured = Vec::with_capacity(LAGS.len());
        for (k, lag) in LAGS.into_iter().enumerate() {
            let (mut ln_sum, mut count) = (0.0, 0);
            for energies in around {
                let energy = energies[k];
                if let Some(mean_m2) = energy.mean_m2().filter(|mean| *mean > 0.0) {
                    ln_sum += energy.count as f64 * libm::log(mean_m2);
                    count += energy.count;
                }
            }
            if count >= FEW {
                let all = Energy { sum_m2: 0.0, count };
                measured.push(Measured {
                    lag_m: surface.lag_m(lag),
                    energy_m2: libm::exp(ln_sum / count as f64),
                    independent: all.independent(lag),
                });
            }
        }
        let law = PowerLaw::fit(&measured, self.survey.spacing_m)?;
        let energy_m2 = law.energy_m2(self.survey.longest_m);
        let gain = libm::exp((self.survey.ln_gain)(law.exponent));
        Some([
            (energy_m2 / gain).sqrt() as f32,
            libm::exp2(-law.exponent) as f32,
        ])
    }
}

/// The root of the mean square of the steepness around a wide cell, what is level left out.
fn usual_steepness(cells: &Cells, x: usize, y: usize) -> f32 {
    const PER: usize = WIDE / NARROW;
    let (mut sum, mut count) = (0.0_f64, 0_u32);
    for row in y * PER..(y + 3) * PER {
        for column in x * PER..(x + 3) * PER {
            // The ring of narrow cells is as wide as that of wide ones.
            if let Some(steep) = cells.at(column, row) {
                sum += f64::from(steep) * f64::from(steep);
                count += 1;
            }
        }
    }
    (sum / f64::from(count.max(1))).sqrt() as f32
}

impl Patch {
    /// Takes over the steepness of the narrow cells of a wide one.
    fn fill(&mut self, cells: &Cells, (x, y): (usize, usize), usual: f32) {
        const PER: usize = WIDE / NARROW;
        for row in y * PER..(y + 1) * PER {
            for column in x * PER..(x + 1) * PER {
                let (at_x, at_y) = (column + PER, row + PER);
                let steep = if cells.is_about_level(at_x, at_y) {
                    0.0
                } else {
                    // Holes are as steep as what is around them.
                    let found = cells.at(at_x, at_y).unwrap_or(usual);
                    found.min(STEEPEST * usual)
                };
                self.steepness[row * NARROW_CELLS + column] = steep;
            }
        }
    }
}
