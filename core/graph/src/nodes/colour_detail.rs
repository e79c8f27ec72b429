//! Colours finer than imagery has them, after examples or by noise.

mod amount;
mod around;
mod choice;
mod coarse;
mod example;
mod exemplar;
mod field;
mod grain;
mod patches;
mod shown;
mod survey;

use std::sync::Arc;

use glam::I64Vec2;
use relievo_planet::{Grid, Planet, SampleRect};
use relievo_raster::colour::{decode_slice, encode_slice};
use relievo_raster::{Bands, Block};

use crate::node::{Artefact, Made};
use crate::{ContentId, IdHasher, ImageNode, Job, Known, RenderError};
pub use amount::ColourDetailAmount;
use choice::Choice;
use coarse::{Coarse, CoarseColours, Nesting, Purpose};
use example::{Example, Found};
pub use example::{ExampleAt, MOST_SIDE};
use exemplar::Exemplar;
pub use exemplar::{LEAST_SAMPLES, MOST_SAMPLES};
use field::{Field, covered, covering};
use grain::Grain;
use patches::Patches;
use shown::Kept;
use survey::Contrast;

const KIND: &str = "colour detail";

/// Largest strength of detail.
pub const MOST_STRENGTH: f64 = 4.0;

/// Coarse colours are read in squares of this many samples, so that neighbouring fine tiles share
/// what they read.
const SHARED: i64 = 32;

/// Coarse samples from sample to sample of the imagery from which on the finest halving is of the way it
/// was resampled rather than of the ground.
const SPARSE: f64 = core::f64::consts::SQRT_2;

/// Where detail comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColourDetailSource {
    /// Pieces of examples that are most like the imagery around a place.
    #[default]
    Examples,
    /// Noise of which the contrast goes on as it falls in the imagery from halving to halving.
    Noise,
}

/// How detail is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColourDetailParams {
    /// Where it comes from.
    pub by: ColourDetailSource,
    /// Another seed chooses among other patches, or gives unrelated noise.
    pub seed: u64,
    /// Metres from sample to sample below which imagery shows nothing. Detail begins where samples are
    /// half as far apart as in the coarsest lattice that keeps all of the imagery. NaN counts as 0,
    /// which means no detail.
    pub coarse_spacing_m: f64,
    /// Contrast of detail relative to the examples', or to what the imagery's goes on to be; clamped to 0
    /// to [`MOST_STRENGTH`]; NaN counts as 0.
    pub strength: f64,
    /// For examples: how far a patch's mean colour may be from the imagery's to be used as it is, as a
    /// distance of encoded colours (black to white is √3); at twice that it has faded. Infinity always
    /// uses the nearest; NaN and less than 0 count as 0.
    pub tolerance: f64,
}

impl Default for ColourDetailParams {
    fn default() -> Self {
        Self {
            by: ColourDetailSource::Examples,
            seed: 0,
            coarse_spacing_m: 0.0,
            strength: 1.0,
            tolerance: 0.15,
        }
    }
}

/// Imagery continued below its resolution: fine samples of what such ground looks like, after examples
/// or by noise.
///
/// Inputs: colours; if masked, a mask; and the colours of which examples are read ([`ExampleAt`]), one
/// input for each. Examples are artefacts: read when the first tile needs them, once for all tiles. One
/// that turns out to be transparent is as good as none.
///
/// On lattices finer than `coarse_spacing_m` the colours at the coarse lattice (the level of the same
/// chain of halvings, read as an artefact) are refined step by step, each step by two. With Lₖ the colours after k steps, D the mean of two by two samples, U their
/// smooth refinement that keeps means (average interpolation) and Fₖ light of patches of the examples
/// at the resolution of step k, or noise:
///
/// - Lₖ₊₁ = U Lₖ + c (Fₖ₊₁ − U D Fₖ₊₁), in linear light
///
/// where c ≤ 1 is lowered for two by two samples that would get darker than ground is or brighter than
/// white. Hence D Lₖ₊₁ = Lₖ up to rounding at every step: reduced by the box, the result gives back the
/// coarse imagery (the constraint of \[WM04\]) and every level the coarser one. A patch lies where, of
/// some that chance names, it is the most like the coarse imagery around its centre, and its contrast is
/// in proportion to the light there. Noise has at every step the contrast, relative to the light, that
/// follows by a power law from how it falls in the imagery around the place (the module `survey`); what is
/// level stays level. All is decided by global integer indices: any tile is made alone.
///
/// Alpha is the input's. Where the input or the coarse colours are transparent, the result is the
/// input; elsewhere input and result are mixed by the mask in linear light, and the constraint holds
/// where the mask is 1. On coarser lattices, with strength 0, without examples that are finer than the
/// coarse lattice (unless by noise), and next to poles (where a level has fewer than 8 coarse columns)
/// the result is the input bit for bit.
#[derive(Clone, Debug)]
pub struct ColourDetail {
    planet: Planet,
    params: ColourDetailParams,
    /// Those that can be examples.
    examples: Vec<Arc<Example>>,
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

impl ColourDetail {
    /// `masked` says whether the second input is a mask. The inputs after that are those of the examples,
    /// in their order; noise needs none, and reads none.
    pub fn new(
        planet: Planet,
        params: &ColourDetailParams,
        examples: Vec<ExampleAt>,
        masked: bool,
    ) -> Self {
        let positive = |v: f64| if v > 0.0 { v } else { 0.0 };
        let by_examples = params.by == ColourDetailSource::Examples;
        let params = ColourDetailParams {
            by: params.by,
            seed: params.seed,
            coarse_spacing_m: positive(params.coarse_spacing_m),
            strength: positive(params.strength).min(MOST_STRENGTH),
            tolerance: if by_examples {
                positive(params.tolerance)
            } else {
                0.0
            },
        };
        let mut name = IdHasher::default();
        name.int(i64::from(by_examples))
            .int(params.seed as i64)
            .float(params.coarse_spacing_m)
            .float(params.strength)
            .float(params.tolerance)
            .float(planet.radius_m)
            .float(planet.equatorial_radius_m)
            .float(planet.flattening)
            .int(i64::from(masked));
        let first = 1 + usize::from(masked);
        let examples: Vec<_> = examples
            .into_iter()
            .enumerate()
            .filter(|(_, at)| by_examples && at.is_usable())
            .map(|(k, at)| {
                name.int(k as i64);
                at.identify(&mut name);
                let input = first + k;
                Arc::new(Example { input, at })
            })
            .collect();
        Self {
            planet,
            params,
            examples,
            masked,
            name: name.finish(),
            kept: Arc::default(),
        }
    }

    /// The samples, by metres from row to row, from which on they are synthesised in part; finer ones
    /// are, coarser ones are the imagery. `None` if none is.
    pub fn synthesised_below_m(&self) -> Option<f64> {
        let finest_m = self.params.coarse_spacing_m * coarse::TOLERANCE / 2.0;
        (self.adds() && finest_m > 0.0).then_some(finest_m)
    }

    /// Whether there is detail on any lattice.
    fn adds(&self) -> bool {
        let has_source = match self.params.by {
            ColourDetailSource::Examples => !self.examples.is_empty(),
            ColourDetailSource::Noise => true,
        };
        self.params.strength > 0.0 && has_source
    }

    /// How a lattice is refined; `None` where it is not.
    fn nesting(&self, grid: &Grid) -> Option<Nesting> {
        if !self.adds() || grid.rect.is_empty() {
            return None;
        }
        Nesting::new(&grid.lattice, &self.planet, self.params.coarse_spacing_m)
    }

    /// The coarse colours that decide the samples of a grid.
    fn coarse(&self, grid: &Grid) -> Option<CoarseColours> {
        let nesting = self.nesting(grid)?;
        let purpose = match self.params.by {
            ColourDetailSource::Examples => Purpose::Examples,
            ColourDetailSource::Noise => Purpose::Noise {
                // Data that are sparser than the lattice are smooth from sample to sample.
                finest: if self.params.coarse_spacing_m < SPARSE * nesting.spacing_m {
                    1
                } else {
                    2
                },
            },
        };
        let needed = steps(grid.rect, nesting.doublings)[0].grow(purpose.margin());
        let shared = I64Vec2::splat(SHARED);
        let rect = SampleRect::new(
            needed.min.div_euclid(shared) * SHARED,
            (needed.max + (SHARED - 1)).div_euclid(shared) * SHARED,
        );
        Some(CoarseColours {
            grid: Grid::new(nesting.coarse, rect.grow(1)),
            purpose,
        })
    }

    /// Colours of a rectangle in linear light, after those examples in which there is something; `None`
    /// where they show nothing that is finer than the coarse colours.
    fn by_examples(
        &self,
        job: &Job,
        nesting: &Nesting,
        coarse: &Coarse,
        found: impl Iterator<Item = Arc<Exemplar>>,
    ) -> Result<Option<Field>, RenderError> {
        let first_m = nesting.spacing_m / 2.0;
        let exemplars: Vec<_> = found.filter(|e| e.mip(first_m).is_some()).collect();
        if exemplars.is_empty() {
            return Ok(None);
        }
        let choice = Choice {
            planet: &self.planet,
            exemplars: &exemplars,
            seed: self.params.seed,
            strength: self.params.strength as f32,
            tolerance: self.params.tolerance as f32,
            kept: &self.kept,
        };
        let steps = steps(job.grid.rect, nesting.doublings);
        let patches = Patches::new(&choice, nesting, coarse, &steps, job.cancel)?;
        refined(job, &steps, coarse, |light, doublings| {
            let detail = patches.light(doublings + 1, &covered(&light.rect()));
            light.refined(detail.as_ref())
        })
        .map(Some)
    }

    /// Colours of a rectangle in linear light, with noise that goes on as they do.
    fn by_noise(
        &self,
        job: &Job,
        nesting: &Nesting,
        coarse: &Coarse,
        contrast: &Contrast,
    ) -> Result<Field, RenderError> {
        let strength = self.params.strength as f32;
        let grain = Grain::new(contrast, nesting, strength, self.params.seed);
        let steps = steps(job.grid.rect, nesting.doublings);
        refined(job, &steps, coarse, |light, doublings| {
            grain.refined(light, doublings)
        })
    }
}

/// The coarse colours refined from step to step: `step` makes of colours after some doublings those after
/// one more, of all samples but the outermost.
fn refined(
    job: &Job,
    steps: &[SampleRect],
    coarse: &Coarse,
    step: impl Fn(&Field, u32) -> Field,
) -> Result<Field, RenderError> {
    let mut light = coarse.light.part(steps[0]);
    for (doublings, rect) in (0..).zip(steps) {
        if job.cancel.is_cancelled() {
            return Err(RenderError::Cancelled);
        }
        if light.rect() != *rect {
            light = light.part(*rect);
        }
        light = step(&light, doublings);
    }
    Ok(light.part(job.grid.rect))
}

impl ImageNode for ColourDetail {
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

    fn required(&self, input: usize, out: SampleRect) -> SampleRect {
        // Examples are read as artefacts.
        if input <= usize::from(self.masked) {
            out
        } else {
            SampleRect::default()
        }
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
        let Some(coarse) = self.coarse(grid) else {
            return Vec::new();
        };
        let mut all: Vec<Arc<dyn Artefact>> = vec![Arc::new(coarse)];
        for example in &self.examples {
            all.push(Arc::clone(example) as Arc<dyn Artefact>);
        }
        all
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
        let (coarse, found) = taken(artefacts)?;
        let light = match &coarse.contrast {
            Some(contrast) => Some(self.by_noise(job, &nesting, coarse, contrast)?),
            None => self.by_examples(job, &nesting, coarse, found)?,
        };
        let Some(light) = light else {
            return Ok(());
        };
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

/// The coarse colours and those examples in which there is something, from what was made of
/// [`ColourDetail::artefacts`].
fn taken(
    artefacts: &[Made],
) -> Result<(&Coarse, impl Iterator<Item = Arc<Exemplar>>), RenderError> {
    let coarse = artefacts.first().and_then(|made| made.downcast_ref());
    let coarse = coarse.ok_or_else(|| RenderError::Node {
        node: KIND,
        reason: "coarse colours were expected, none were made".into(),
    })?;
    let found = artefacts[1..]
        .iter()
        .filter_map(|made| made.downcast_ref::<Found>()?.clone());
    Ok((coarse, found))
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
