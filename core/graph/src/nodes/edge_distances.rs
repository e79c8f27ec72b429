//! Distances to where a source ends.

use std::sync::{Arc, OnceLock};

use parking_lot::Mutex;
use relievo_planet::Grid;
use relievo_raster::edge::EdgeDistance;
use relievo_raster::warp::{Coverage, Warp};
use relievo_raster::{Bands, Block, Cancel};

use super::memory::add_grid;
use crate::{ContentId, IdHasher, ImageNode, Job, Known, RenderError};

const KIND: &str = "edge distances";

/// Metres to a source's edge, given as heights: 0 outside, never more than what is asked for. No inputs.
///
/// A [`RangeMask`](super::RangeMask) over it fades a source out towards its edge. Where all samples of a grid
/// are known to be so far inside, they are uniform, and nothing of what lies below is looked at. Distances
/// come from what is prepared once for the node ([`EdgeDistance`]), when the first sample is asked for; see
/// there for the formula and its limits.
#[derive(Debug)]
pub struct EdgeDistances {
    warp: Arc<Warp>,
    most_m: f32,
    /// Whether there may be holes that count.
    has_holes: bool,
    name: ContentId,
    distance: OnceLock<EdgeDistance>,
    /// Held while preparing, so that it happens once.
    preparing: Mutex<()>,
}

impl EdgeDistances {
    /// To the file's outline and to the holes inside of it. Distances beyond `most_m` metres are given as
    /// that; one that is no number, or below 0, counts as 0.
    pub fn new(warp: Arc<Warp>, most_m: f64) -> Self {
        if !warp.file().info().may_have_holes {
            return Self::to_outline(warp, most_m);
        }
        Self::with(warp, most_m, true, OnceLock::new())
    }

    /// To the file's outline alone, as if it had no holes.
    pub fn to_outline(warp: Arc<Warp>, most_m: f64) -> Self {
        let distance = EdgeDistance::to_outline(&warp);
        Self::with(warp, most_m, false, OnceLock::from(distance))
    }

    fn with(
        warp: Arc<Warp>,
        most_m: f64,
        has_holes: bool,
        distance: OnceLock<EdgeDistance>,
    ) -> Self {
        let most_m = if most_m > 0.0 { most_m as f32 } else { 0.0 };
        let mut id = IdHasher::default();
        id.id(place_name(&warp))
            .float(f64::from(most_m))
            .int(i64::from(has_holes));
        Self {
            warp,
            most_m,
            has_holes,
            name: id.finish(),
            distance,
            preparing: Mutex::new(()),
        }
    }

    fn distance(&self, cancel: &Cancel) -> Result<&EdgeDistance, RenderError> {
        if let Some(ready) = self.distance.get() {
            return Ok(ready);
        }
        let _one_at_a_time = self.preparing.lock();
        if let Some(ready) = self.distance.get() {
            return Ok(ready);
        }
        // Not kept when it fails or is cancelled: the next job tries again.
        let made = EdgeDistance::new(&self.warp, cancel)?;
        Ok(self.distance.get_or_init(|| made))
    }
}

/// Name of a file's data, of where they lie, and of how they are laid there.
fn place_name(warp: &Warp) -> ContentId {
    let mut id = IdHasher::default();
    let planet = warp.planet();
    id.bytes(&warp.file().fingerprint())
        .float(planet.radius_m)
        .float(planet.equatorial_radius_m)
        .float(planet.flattening)
        .int(warp.kernel().tag());
    if let Some(place) = &warp.file().info().georeference {
        id.bytes(place.crs.as_bytes());
        for v in place.plane_from_pixel {
            id.float(v);
        }
    }
    id.finish()
}

impl ImageNode for EdgeDistances {
    fn kind(&self) -> &'static str {
        KIND
    }

    fn output(&self) -> Bands {
        Bands::Height
    }

    fn is_pointwise(&self) -> bool {
        true
    }

    fn identify(&self, grid: &Grid, id: &mut IdHasher) {
        id.id(self.name);
        add_grid(grid, id);
    }

    fn known(&self, grid: &Grid, _inputs: &[Known]) -> Known {
        // From the outline alone, never from the artefact: ids must not depend on what happened
        // to be prepared already.
        match self.warp.coverage(grid) {
            Coverage::Outside => Known::Uniform([0.0; 4]),
            Coverage::Inside
                if !self.has_holes
                    && EdgeDistance::least_m(&self.warp, grid) >= f64::from(self.most_m) =>
            {
                Known::Uniform([self.most_m, 0.0, 0.0, 0.0])
            }
            Coverage::Inside | Coverage::Partial => Known::Complete,
        }
    }

    fn render(&self, job: &Job, _inputs: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        let distances = self.distance(job.cancel)?.distances_m(&self.warp, job.grid);
        *out = distances.map_err(|error| RenderError::Node {
            node: KIND,
            reason: error.to_string(),
        })?;
        for v in out.samples_mut() {
            *v = if *v < self.most_m { *v } else { self.most_m };
            *v = if *v > 0.0 { *v } else { 0.0 };
        }
        Ok(())
    }
}
