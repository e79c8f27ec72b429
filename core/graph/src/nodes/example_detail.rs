//! Colours finer than imagery has them, after examples.

mod around;
mod choice;
mod coarse;
mod exemplar;
mod field;
mod patches;
mod shown;

use std::sync::Arc;

use glam::I64Vec2;
use relievo_planet::{Grid, Planet, SampleRect};
use relievo_raster::colour::{decode_slice, encode_slice};
use relievo_raster::{Bands, Block};

use crate::node::{Artefact, Made};
use crate::{ContentId, IdHasher, ImageNode, Job, Known, RenderError};
use choice::Choice;
use coarse::{Coarse, CoarseColours, Nesting};
pub use exemplar::{Exemplar, ExemplarError, LEAST_SAMPLES, MOST_SAMPLES};
use field::{Field, covered, covering};
use patches::{MARGIN, Patches};
use shown::Kept;

const KIND: &str = "example detail";

/// Largest strength of detail.
pub const MOST_STRENGTH: f64 = 4.0;

/// Coarse colours are read in squares of this many samples, so that neighbouring fine tiles share
/// what they read.
const SHARED: i64 = 32;

/// How detail is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExampleDetailParams {
    /// Another seed chooses among other patches.
    pub seed: u64,
    /// Metres from sample to sample below which imagery shows nothing. Detail begins where samples are
    /// half as far apart as in the coarsest lattice that keeps all of the imagery. NaN counts as 0,
    /// which means no detail.
    pub coarse_spacing_m: f64,
    /// Contrast of detail relative to the exemplars', clamped to 0 to [`MOST_STRENGTH`]; NaN counts
    /// as 0.
    pub strength: f64,
    /// How far a patch's mean colour may be from the imagery's to be used as it is, as a distance of
    /// encoded colours (black to white is √3); at twice that it has faded. Infinity always uses the
    /// nearest; NaN and less than 0 count as 0.
    pub tolerance: f64,
}

impl Default for ExampleDetailParams {
    fn default() -> Self {
        Self {
            seed: 0,
            coarse_spacing_m: 0.0,
            strength: 1.0,
            tolerance: 0.15,
        }
    }
}

/// Imagery continued below its resolution after exemplars: fine samples of what such ground looks like.
///
/// Inputs: colours and, if masked, a mask. On lattices finer than `coarse_spacing_m` the colours at the
/// coarse lattice (the level of the same chain of halvings, read as an artefact) are refined step by
/// step, each step by two. With Lₖ the colours after k steps, D the mean of two by two samples, U their
/// smooth refinement that keeps means (average interpolation) and Fₖ light of patches of the exemplars
/// at the resolution of step k:
///
/// - Lₖ₊₁ = U Lₖ + c (Fₖ₊₁ − U D Fₖ₊₁), in linear light
///
/// where c ≤ 1 is lowered for two by two samples that would get darker than ground is or brighter than
/// white. Hence D Lₖ₊₁ = Lₖ up to rounding at every step: reduced by the box, the result gives back the
/// coarse imagery (the constraint of \[WM04\]) and every level the coarser one. A patch lies where, of
/// some that chance names, it is the most like the coarse imagery around its centre, and its contrast is
/// in proportion to the light there. All is decided by global integer indices: any tile is made alone.
///
/// Alpha is the input's. Where the input or the coarse colours are transparent, the result is the
/// input; elsewhere input and result are mixed by the mask in linear light, and the constraint holds
/// where the mask is 1. On coarser lattices, with strength 0, without exemplars, and next to poles
/// (where a level has fewer than 8 coarse columns) the result is the input bit for bit.
#[derive(Clone, Debug)]
pub struct ExampleDetail {
    planet: Planet,
    params: ExampleDetailParams,
    exemplars: Vec<Arc<Exemplar>>,
    masked: bool,
    /// Of all of the above.
    name: ContentId,
    kept: Arc<Kept>,
}

/// The rectangles that are refined from one to the next, coarse first: what is needed after each step
/// but the last.
fn steps(rect: SampleRect, doublings: u32) -> Vec<SampleRect> {
    let mut all = Vec::with_capacity(doublings as usize);
    let mut wanted = rect;
    for _ in 0..doublings {
        wanted = covering(&wanted).grow(1);
        all.push(wanted);
    }
    all.reverse();
    all
}

impl ExampleDetail {
    /// `masked` says whether there is a second input. Exemplars that are no finer than the coarse
    /// lattice have nothing to show.
    pub fn new(
        planet: Planet,
        params: &ExampleDetailParams,
        exemplars: Vec<Arc<Exemplar>>,
        masked: bool,
    ) -> Self {
        let positive = |v: f64| if v > 0.0 { v } else { 0.0 };
        let params = ExampleDetailParams {
            seed: params.seed,
            coarse_spacing_m: positive(params.coarse_spacing_m),
            strength: positive(params.strength).min(MOST_STRENGTH),
            tolerance: positive(params.tolerance),
        };
        let mut name = IdHasher::default();
        name.int(params.seed as i64)
            .float(params.coarse_spacing_m)
            .float(params.strength)
            .float(params.tolerance)
            .float(planet.radius_m)
            .float(planet.equatorial_radius_m)
            .float(planet.flattening)
            .int(i64::from(masked));
        for exemplar in &exemplars {
            name.id(exemplar.name());
        }
        Self {
            planet,
            params,
            exemplars,
            masked,
            name: name.finish(),
            kept: Arc::default(),
        }
    }

    /// How a lattice is refined; `None` where it is not.
    fn nesting(&self, grid: &Grid) -> Option<Nesting> {
        if self.params.strength == 0.0 || self.exemplars.is_empty() || grid.rect.is_empty() {
            return None;
        }
        Nesting::new(&grid.lattice, &self.planet, self.params.coarse_spacing_m)
    }

    /// The coarse colours that decide the samples of a grid.
    fn coarse(&self, grid: &Grid) -> Option<CoarseColours> {
        let nesting = self.nesting(grid)?;
        let needed = steps(grid.rect, nesting.doublings)[0].grow(MARGIN);
        let shared = I64Vec2::splat(SHARED);
        let rect = SampleRect::new(
            needed.min.div_euclid(shared) * SHARED,
            (needed.max + (SHARED - 1)).div_euclid(shared) * SHARED,
        );
        Some(CoarseColours {
            grid: Grid::new(nesting.coarse, rect.grow(1)),
        })
    }

    /// Colours of a rectangle or a little more in linear light.
    fn refined(&self, job: &Job, nesting: &Nesting, coarse: &Coarse) -> Result<Field, RenderError> {
        // Those that are finer than the coarse colours.
        let first_m = nesting.spacing_m / 2.0;
        let fine = self.exemplars.iter().filter(|e| e.mip(first_m).is_some());
        let fine: Vec<Arc<Exemplar>> = fine.cloned().collect();
        let choice = Choice {
            planet: &self.planet,
            exemplars: &fine,
            seed: self.params.seed,
            strength: self.params.strength as f32,
            tolerance: self.params.tolerance as f32,
            kept: &self.kept,
        };
        let steps = steps(job.grid.rect, nesting.doublings);
        let patches = Patches::new(&choice, nesting, coarse, &steps, job.cancel)?;
        let mut light = coarse.light.part(steps[0]);
        for (doublings, step) in (1..).zip(&steps) {
            if job.cancel.is_cancelled() {
                return Err(RenderError::Cancelled);
            }
            if light.rect() != *step {
                light = light.part(*step);
            }
            let detail = patches.light(doublings, &covered(step));
            light = light.refined(detail.as_ref());
        }
        Ok(light.part(job.grid.rect))
    }
}

impl ImageNode for ExampleDetail {
    fn kind(&self) -> &'static str {
        KIND
    }

    fn output(&self) -> Bands {
        Bands::Colour
    }

    /// Its samples depend on nothing but those below them and artefacts, but it is no part of a run:
    /// coarser steps are made for many rows at once.
    fn is_pointwise(&self) -> bool {
        false
    }

    fn identify(&self, grid: &Grid, id: &mut IdHasher) {
        id.id(self.name).grid(grid);
    }

    fn known(&self, _grid: &Grid, inputs: &[Known]) -> Known {
        if inputs[0].is_complete(Bands::Colour) {
            Known::Complete
        } else {
            Known::Nothing
        }
    }

    fn identity(&self, grid: &Grid, inputs: &[Known]) -> Option<usize> {
        let hidden = self.masked && inputs[1].is_absent(Bands::Mask);
        let same = hidden || inputs[0].is_absent(Bands::Colour) || self.nesting(grid).is_none();
        same.then_some(0)
    }

    fn artefacts(&self, grid: &Grid) -> Vec<Arc<dyn Artefact>> {
        self.coarse(grid)
            .map(|coarse| Arc::new(coarse) as Arc<dyn Artefact>)
            .into_iter()
            .collect()
    }

    fn render(&self, job: &Job, inputs: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        self.render_from(job, &[], inputs, out)
    }

    fn render_from(
        &self,
        job: &Job,
        artefacts: &[Made],
        inputs: &[&Block],
        out: &mut Block,
    ) -> Result<(), RenderError> {
        out.samples_mut().copy_from_slice(inputs[0].samples());
        let Some(nesting) = self.nesting(job.grid) else {
            return Ok(());
        };
        let coarse = artefacts
            .first()
            .and_then(|made| made.downcast_ref::<Coarse>())
            .ok_or_else(|| RenderError::Node {
                node: KIND,
                reason: "coarse colours were expected, none were made".into(),
            })?;
        let light = self.refined(job, &nesting, coarse)?;
        let mask = self.masked.then(|| inputs[1].plane(0));
        let weights = weights(job.grid.rect, nesting.doublings, coarse, inputs[0], mask);
        let mut refined = vec![0.0; weights.len()];
        let mut below = Vec::new();
        for plane in 0..3 {
            refined.copy_from_slice(light.plane(plane));
            if self.masked {
                below.clear();
                below.extend_from_slice(inputs[0].plane(plane));
                decode_slice(&mut below);
                for ((v, below), weight) in refined.iter_mut().zip(&below).zip(&weights) {
                    if *weight < 1.0 {
                        *v = below + weight * (*v - below);
                    }
                }
            }
            encode_slice(&mut refined);
            let samples = out.plane_mut(plane).iter_mut();
            for ((out, refined), weight) in samples.zip(&refined).zip(&weights) {
                if *weight > 0.0 {
                    *out = *refined;
                }
            }
        }
        Ok(())
    }
}

/// How much of each sample is refined, from 0 to 1.
fn weights(
    rect: SampleRect,
    doublings: u32,
    coarse: &Coarse,
    colours: &Block,
    mask: Option<&[f32]>,
) -> Vec<f32> {
    let mut weights = Vec::with_capacity(rect.area() as usize);
    for y in rect.min.y..rect.max.y {
        for x in rect.min.x..rect.max.x {
            let above = coarse.at(I64Vec2::new(x >> doublings, y >> doublings));
            let there = coarse.there[above] && colours.plane(3)[weights.len()] > 0.0;
            let weight = mask.map_or(1.0, |mask| super::overlay::clamped(mask[weights.len()]));
            weights.push(if there { weight } else { 0.0 });
        }
    }
    weights
}

#[cfg(test)]
mod tests;
