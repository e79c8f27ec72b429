//! A layer that blends into what lies below it, along the edge of its data.

mod coarse;
mod fine;
mod membrane;
mod places;

use std::sync::Arc;

use relievo_planet::{Grid, Planet, SampleRect};
use relievo_raster::{Bands, Block};

use crate::node::{Artefact, Made};
use crate::{ContentId, IdHasher, ImageNode, Job, Known, RenderError};
use coarse::Coarse;
use fine::{Field, Row};
use membrane::{Corrections, Membrane};

const KIND: &str = "seam blend";

/// Corrections end at this part of the reach: what interpolation from the coarse lattice adds (three of
/// its samples, each at most a sixteenth of the reach) and where a seam lies in a sample is the rest.
const SUPPORT: f64 = 0.75;

/// A layer's colours, changed near the edge of its data so that they meet what lies below.
///
/// Inputs: colours below, colours of the layer and, if masked, a mask of where it shows. With a coarse
/// lattice that has 16 to 32 rows in the reach, where all of the following is found:
///
/// - seam: samples where the layer is there (alpha · mask > ½), beside one where it is not, with colours
///   below (alpha > ½) at both;
/// - dᵢ = below − layer at seam sample i, straight encoded values; lᵢ the length of seam it stands for;
/// - M(x) = Σ wᵢ dᵢ / Σ wᵢ, wᵢ = lᵢ (1 − ρ²)² / ρ², ρ = |x − xᵢ| / (¾ reach) < 1;
/// - right outside of a seam M is what it is at the seam, so that it goes on to where the edge really lies;
/// - result = layer + (1 − 3δ² + 2δ³) M, δ the distance to the nearest seam over ¾ reach.
///
/// M is a membrane through the differences at the seam: normalised weights 1 / ρ² are Poisson's kernel of
/// a half-plane and of a disc, so along seams straight or round M solves Laplace's equation, as \[PGB03\]
/// asks of a correction that keeps gradients, up to its finite range; for others it is close to that, as
/// \[FHLCL09\] and \[FFL11\] found for similar weights, and nothing is solved for. Distances are straight
/// lines between places on the ellipsoid, in metres: the same in every direction, over the poles and the
/// antimeridian. Finer lattices interpolate the correction by cubic convolution (\[Key81\]); coarser ones
/// find seams among their own samples.
///
/// Alpha is the layer's bit for bit, and so are its colours where it or the mask is 0, where no seam is
/// within the reach, and on lattices with samples larger than the reach. Results are clamped to 0..=1, and
/// what lies beyond that to between it and 0..=1. Seams more than 128 columns of the coarse lattice away
/// are not seen where it has more than 768 around the planet: near the poles of levels that are not meant
/// for them.
///
/// A block of 128 × 128 coarse samples is an artefact. It reads the layer and what is below on about 180 ×
/// 180 samples (over a pole up to 770 × 156) and takes time in proportion to samples times seam samples within
/// the support of each: those of a line, some 50, or 1800 if the layer has holes everywhere.
#[derive(Clone, Debug)]
pub struct SeamBlend {
    planet: Planet,
    reach_m: f64,
    masked: bool,
    /// Of all of the above.
    name: ContentId,
}

impl SeamBlend {
    /// `reach_m`: metres on the ground from a seam to where the layer is left as it is; 0, less and NaN
    /// leave all of it, and more than half around the planet is no more than that. `masked` says whether
    /// there is a third input.
    pub fn new(planet: Planet, reach_m: f64, masked: bool) -> Self {
        let farthest_m = core::f64::consts::PI * planet.equatorial_radius_m;
        let reach_m = if reach_m > 0.0 {
            reach_m.min(farthest_m)
        } else {
            0.0
        };
        let mut name = IdHasher::default();
        name.float(reach_m)
            .float(planet.radius_m)
            .float(planet.equatorial_radius_m)
            .float(planet.flattening)
            .int(i64::from(masked));
        Self {
            planet,
            reach_m,
            masked,
            name: name.finish(),
        }
    }

    fn coarse(&self, grid: &Grid) -> Option<Coarse> {
        if self.reach_m == 0.0 || grid.rect.is_empty() {
            return None;
        }
        Coarse::new(&grid.lattice, &self.planet, self.reach_m)
    }
}

impl ImageNode for SeamBlend {
    fn kind(&self) -> &'static str {
        KIND
    }

    fn output(&self) -> Bands {
        Bands::Colour
    }

    /// Its samples depend on nothing but those of the layer and artefacts, but only nodes that are no part
    /// of a run may ask for artefacts.
    fn is_pointwise(&self) -> bool {
        false
    }

    /// What is below decides by artefacts alone. Asked for here as well it would be made twice: here and
    /// for the overlay above, and each of those times twice again below the next layer that blends.
    fn required(&self, input: usize, out: SampleRect) -> SampleRect {
        if input == 0 {
            SampleRect::default()
        } else {
            out
        }
    }

    fn identify(&self, grid: &Grid, id: &mut IdHasher) {
        id.id(self.name).grid(grid);
    }

    fn known(&self, _grid: &Grid, inputs: &[Known]) -> Known {
        if inputs[1].is_complete(Bands::Colour) {
            Known::Complete
        } else {
            Known::Nothing
        }
    }

    /// That no seam is near cannot be known: it depends on samples beyond the grid.
    fn identity(&self, grid: &Grid, inputs: &[Known]) -> Option<usize> {
        let hidden = self.masked && inputs[2].is_absent(Bands::Mask);
        let same = hidden || inputs[1].is_absent(Bands::Colour) || self.coarse(grid).is_none();
        same.then_some(1)
    }

    fn artefacts(&self, grid: &Grid) -> Vec<Arc<dyn Artefact>> {
        let Some(coarse) = self.coarse(grid).map(Arc::new) else {
            return Vec::new();
        };
        let support_m = SUPPORT * self.reach_m;
        let blocks = coarse.blocks(&fine::needed(&grid.rect, coarse.doublings));
        let around = blocks
            .into_iter()
            .filter_map(|block| coarse.around(&self.planet, block, support_m));
        let membrane = |around| Membrane {
            planet: self.planet,
            name: self.name,
            coarse: Arc::clone(&coarse),
            around,
            support_m,
            masked: self.masked,
        };
        around
            .map(|around| Arc::new(membrane(around)) as Arc<dyn Artefact>)
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
        out.samples_mut().copy_from_slice(inputs[1].samples());
        let Some(coarse) = self.coarse(job.grid) else {
            return Ok(());
        };
        let blocks: Option<Vec<&Corrections>> =
            artefacts.iter().map(|made| made.downcast_ref()).collect();
        let blocks = blocks.ok_or_else(|| RenderError::Node {
            node: KIND,
            reason: "corrections were expected, something else was made".into(),
        })?;
        let rect = job.grid.rect;
        let Some(field) = Field::new(&coarse, &blocks, &rect) else {
            return Ok(());
        };
        let mask = self.masked.then(|| inputs[2].plane(0));
        let alpha = inputs[1].plane(3);
        let columns = field.columns(&rect);
        let width = rect.width() as usize;
        let mut corrections = Row::default();
        for channel in 0..3 {
            let plane = out.plane_mut(channel);
            for (row, y) in (rect.min.y..rect.max.y).enumerate() {
                if job.cancel.is_cancelled() {
                    return Err(RenderError::Cancelled);
                }
                if !field.row(channel, y, &columns, &mut corrections) {
                    continue;
                }
                let first = row * width;
                let line = plane[first..first + width].iter_mut();
                for (x, (v, correction)) in line.zip(&corrections.fine).enumerate() {
                    let i = first + x;
                    let shows = alpha[i] > 0.0 && mask.is_none_or(|mask| mask[i] > 0.0);
                    if shows && *correction != 0.0 {
                        *v = corrected(*v, *correction);
                    }
                }
            }
        }
        Ok(())
    }
}

/// A value and what is added to it, no farther beyond 0..=1 than the value was.
fn corrected(v: f32, correction: f32) -> f32 {
    if v.is_nan() {
        return v;
    }
    (v + correction).clamp(v.min(0.0), v.max(1.0))
}

#[cfg(test)]
mod tests;
