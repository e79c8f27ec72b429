//! The coarse colours that detail is added to, and the lattice on which they lie.

use std::sync::Arc;

use glam::I64Vec2;
use relievo_planet::{Grid, GridCrs, Lattice, Planet, SampleRect};
use relievo_raster::colour::{linear_from_srgb, srgb_from_linear};
use relievo_raster::{Block, Cancel};

use super::super::ground::Ground;
use super::field::Field;
use super::survey::{self, Contrast};
use crate::node::{Artefact, Made};
use crate::{IdHasher, RenderError};

/// Most halvings from the coarse lattice to the finest that is refined.
const MOST_DOUBLINGS: u32 = 24;

/// A spacing is met when it is missed by no more than this factor.
pub(super) const TOLERANCE: f64 = 1.01;

/// The sides of a closed coarse lattice are multiples of this many samples, so that patches fit
/// around the planet and over the poles ([`super::patches`]).
const CLOSED: i64 = 8;

/// How a lattice lies in the coarse one: sample (i, j) in coarse sample (i, j) / 2^doublings.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Nesting {
    pub(super) doublings: u32,
    pub(super) coarse: Arc<Lattice>,
    /// Metres from row to row of the coarse lattice.
    pub(super) spacing_m: f64,
}

impl Nesting {
    /// The coarsest lattice that holds `lattice` and has rows at most `coarse_spacing_m` apart; `None`
    /// where `lattice` is no finer than that, or has no such lattice around it.
    pub(super) fn new(lattice: &Lattice, planet: &Planet, coarse_spacing_m: f64) -> Option<Self> {
        let mut spacing_m = row_spacing_m(lattice, planet)?;
        let mut doublings = 0_u32;
        while spacing_m * 2.0 <= coarse_spacing_m * TOLERANCE && doublings < MOST_DOUBLINGS {
            spacing_m *= 2.0;
            doublings += 1;
        }
        if doublings == 0 {
            return None;
        }
        let times = 1_i64 << doublings;
        let columns_around = match lattice.columns_around {
            Some(columns) if columns % (times * CLOSED) == 0 => Some(columns / times),
            // Next to a pole, where a level has few columns.
            Some(_) => return None,
            None => None,
        };
        if columns_around.is_some() && rows_between_poles(lattice) % (times * CLOSED) != 0 {
            return None;
        }
        let coarse = Lattice {
            crs: lattice.crs.clone(),
            origin: lattice.origin,
            // A power of two: exact, so the lattice of a level is that of the coarse level.
            step: lattice.step * times as f64,
            columns_around,
        };
        Some(Self {
            doublings,
            coarse: Arc::new(coarse),
            spacing_m,
        })
    }
}

/// Metres from row to row, one number for all of a lattice so that wholes equal their parts.
fn row_spacing_m(lattice: &Lattice, planet: &Planet) -> Option<f64> {
    if lattice.crs == GridCrs::Map {
        return Some(lattice.step.y.abs() * planet.radius_m);
    }
    let ground = Ground::new(lattice, super::KIND).ok()?;
    let [_, row] = ground.steps_m(planet, I64Vec2::ZERO)?;
    let spacing_m = row.length();
    (spacing_m > 0.0).then_some(spacing_m)
}

/// Rows of a lattice that closes upon itself.
pub(super) fn rows_between_poles(lattice: &Lattice) -> i64 {
    libm::round(core::f64::consts::PI / lattice.step.y.abs()) as i64
}

/// Reads the coarse colours of a rectangle.
pub(super) struct CoarseColours {
    /// What is read: one sample more on every side than is given.
    pub(super) grid: Grid,
    pub(super) purpose: Purpose,
}

/// What coarse colours are compared or measured for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Purpose {
    /// Pieces of examples that are like them.
    Examples,
    /// Noise that goes on as they do from this halving on (see [`Contrast::new`]).
    Noise { finest: usize },
}

impl Purpose {
    /// Coarse samples beyond the wanted ones that decide these.
    pub(super) fn margin(self) -> i64 {
        match self {
            Self::Examples => super::patches::MARGIN,
            // Between whose centres the outermost lie.
            Self::Noise { .. } => survey::MARGIN + 1,
        }
    }
}

/// Coarse colours as they are refined.
pub(super) struct Coarse {
    /// Straight colours in linear light; where there are none, the mean of those next to it.
    pub(super) light: Field,
    /// Which samples are there, row by row.
    pub(super) there: Vec<bool>,
    /// For examples, [`Self::light`] as the eye has it, nearly: encoded.
    pub(super) encoded: Vec<[f32; 3]>,
    /// For noise, of all samples but a margin.
    pub(super) contrast: Option<Contrast>,
}

impl Coarse {
    fn new(read: &SampleRect, colours: &Block, purpose: Purpose) -> Self {
        let planes: [&[f32]; 4] = core::array::from_fn(|plane| colours.plane(plane));
        let samples: Vec<Option<[f32; 3]>> = (0..planes[0].len())
            .map(|i| {
                let v = planes.map(|plane| plane[i]);
                let there = v[3] > 0.0 && v.iter().all(|v| v.is_finite());
                there.then(|| [v[0], v[1], v[2]].map(linear_from_srgb))
            })
            .collect();
        let rect = read.grow(-1);
        let stride = read.width() as usize;
        let mut light = Field::new(rect);
        let mut there = Vec::with_capacity(light.len());
        for row in 0..rect.height() as usize {
            for column in 0..rect.width() as usize {
                let centre = (row + 1) * stride + column + 1;
                let colour = samples[centre].unwrap_or_else(|| {
                    let around = (0..3).flat_map(|y| {
                        let first = (row + y) * stride + column;
                        &samples[first..first + 3]
                    });
                    mean(around)
                });
                light.set(there.len(), colour);
                there.push(samples[centre].is_some());
            }
        }
        let (encoded, contrast) = match purpose {
            Purpose::Examples => {
                let encoded = (0..there.len()).map(|i| light.get(i).map(srgb_from_linear));
                (encoded.collect(), None)
            }
            Purpose::Noise { finest } => {
                let contrast = Contrast::new(&light, &there, finest);
                (Vec::new(), Some(contrast))
            }
        };
        Self {
            light,
            there,
            encoded,
            contrast,
        }
    }

    /// Where a sample inside is kept.
    pub(super) fn at(&self, sample: I64Vec2) -> usize {
        self.light.at(sample)
    }
}

/// Mean of those colours that are there; 0 if none is.
fn mean<'a>(colours: impl Iterator<Item = &'a Option<[f32; 3]>>) -> [f32; 3] {
    let mut sum = [0.0; 3];
    let mut count = 0.0;
    for colour in colours.flatten() {
        for (sum, v) in sum.iter_mut().zip(colour) {
            *sum += v;
        }
        count += 1.0;
    }
    sum.map(|sum| if count > 0.0 { sum / count } else { 0.0 })
}

impl Artefact for CoarseColours {
    fn identify(&self, id: &mut IdHasher) {
        let purpose = match self.purpose {
            Purpose::Examples => 0,
            Purpose::Noise { finest } => finest as i64,
        };
        id.bytes(super::KIND.as_bytes()).int(purpose);
        id.grid(&self.grid);
    }

    fn reads(&self) -> Vec<(usize, Grid)> {
        vec![(0, self.grid.clone())]
    }

    fn make(&self, samples: &[Block], _cancel: &Cancel) -> Result<Made, RenderError> {
        let coarse = Coarse::new(&self.grid.rect, &samples[0], self.purpose);
        Ok(Arc::new(coarse))
    }

    fn bytes(&self) -> usize {
        /// Light and a flag.
        const SAMPLE: usize = size_of::<[f32; 3]>() + 1;
        let samples = self.grid.rect.area() as usize;
        let more = match self.purpose {
            Purpose::Examples => samples * size_of::<[f32; 3]>(),
            Purpose::Noise { .. } => Contrast::bytes(samples),
        };
        samples * SAMPLE + more
    }
}

#[cfg(test)]
mod tests {
    use relievo_planet::LevelKey;
    use relievo_raster::Bands;

    use super::*;

    #[test]
    fn the_lattice_of_a_level_lies_in_that_of_the_coarse_level() {
        let fine = LevelKey::new(14, 12).lattice();
        let spacing_m = fine.step.y * Planet::EARTH.radius_m;
        for (coarse_spacing_m, doublings) in [
            (spacing_m * 2.0, 1),
            (spacing_m * 3.9, 1),
            (spacing_m * 4.0, 2),
            (spacing_m * 32.0, 5),
        ] {
            let nesting = Nesting::new(&fine, &Planet::EARTH, coarse_spacing_m).expect("finer");
            assert_eq!(nesting.doublings, doublings);
            let level = LevelKey::new(14 - doublings as u8, 12 - doublings as u8);
            assert_eq!(*nesting.coarse, level.lattice());
        }
        for coarse_spacing_m in [spacing_m, spacing_m * 1.9, 0.0, f64::NAN] {
            assert_eq!(Nesting::new(&fine, &Planet::EARTH, coarse_spacing_m), None);
        }
    }

    #[test]
    fn a_level_with_few_columns_has_no_coarse_level_far_above_it() {
        let spacing_m = |n: u8| LevelKey::new(0, n).lattice().step.y * Planet::EARTH.radius_m;
        let coarse = |m, n, doublings: u8| {
            let coarse_spacing_m = spacing_m(n - doublings);
            Nesting::new(
                &LevelKey::new(m, n).lattice(),
                &Planet::EARTH,
                coarse_spacing_m,
            )
        };
        assert!(coarse(0, 9, 5).is_some());
        assert_eq!(coarse(0, 9, 6), None);
        assert!(coarse(3, 12, 8).is_some());
    }

    #[test]
    fn what_is_not_there_takes_the_mean_of_what_is_next_to_it() {
        let read = SampleRect::at(-3, 4, 6, 5);
        let mut colours = Block::filled(Bands::Colour, 6, 5, &[0.5, 0.25, 0.75, 1.0]);
        for i in [14, 15, 21] {
            colours.plane_mut(3)[i] = 0.0;
        }
        colours.plane_mut(1)[20] = f32::NAN;
        let coarse = Coarse::new(&read, &colours, Purpose::Examples);
        assert_eq!(coarse.light.rect(), read.grow(-1));
        assert_eq!(coarse.there.iter().filter(|there| !**there).count(), 4);
        for v in &coarse.encoded {
            for (v, expected) in v.iter().zip([0.5, 0.25, 0.75]) {
                assert!((v - expected).abs() < 1e-5);
            }
        }
        let nothing = Coarse::new(&read, &Block::new(Bands::Colour, 6, 5), Purpose::Examples);
        assert!(nothing.encoded.iter().flatten().all(|v| *v == 0.0));
    }
}
