//! A mask that fades a source out towards its edge.

use std::sync::{Arc, OnceLock};

use parking_lot::Mutex;
use relievo_planet::Grid;
use relievo_raster::edge::EdgeDistance;
use relievo_raster::warp::{Coverage, Warp};
use relievo_raster::{Bands, Block, Cancel};

use super::memory::add_grid;
use crate::{ContentId, IdHasher, ImageNode, Job, Known, RenderError};

const KIND: &str = "edge fade";

/// Weights of a source by the distance to its edge: 0 outside and at the edge, rising smoothly to 1
/// at a width in metres inside. No inputs.
///
/// Distances come from an artefact ([`EdgeDistance`]) that is prepared once, when the first sample is
/// asked for; see there for the formula and its limits.
#[derive(Debug)]
pub struct EdgeFade {
    warp: Arc<Warp>,
    width_m: f64,
    /// Whether holes count as edges.
    has_holes: bool,
    name: ContentId,
    distance: OnceLock<EdgeDistance>,
    /// Held while preparing, so that it happens once.
    preparing: Mutex<()>,
}

impl EdgeFade {
    /// `width_m` of 0, less, or not finite means no fading: 1 inside, 0 outside.
    pub fn new(warp: Arc<Warp>, width_m: f64) -> Self {
        let width_m = if width_m.is_finite() {
            width_m.max(0.0)
        } else {
            0.0
        };
        let mut id = IdHasher::default();
        id.bytes(&warp.file().fingerprint()).float(width_m);
        if let Some(place) = &warp.file().info().georeference {
            id.bytes(place.crs.as_bytes());
            for v in place.plane_from_pixel {
                id.float(v);
            }
        }
        Self {
            warp,
            width_m,
            has_holes: true,
            name: id.finish(),
            distance: OnceLock::new(),
            preparing: Mutex::new(()),
        }
    }

    /// The same by the distance to the file's outline alone, as if it had no holes.
    pub fn outline(warp: Arc<Warp>, width_m: f64) -> Self {
        let mut fade = Self::new(warp, width_m);
        let mut id = IdHasher::default();
        id.bytes(b"outline").id(fade.name);
        fade.name = id.finish();
        fade.distance = OnceLock::from(EdgeDistance::to_outline(&fade.warp));
        fade.has_holes = false;
        fade
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

impl ImageNode for EdgeFade {
    fn kind(&self) -> &'static str {
        KIND
    }

    fn output(&self) -> Bands {
        Bands::Mask
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
            Coverage::Inside if !self.has_holes && self.width_m == 0.0 => {
                Known::Uniform([1.0, 0.0, 0.0, 0.0])
            }
            Coverage::Inside | Coverage::Partial => Known::Nothing,
        }
    }

    fn render(&self, job: &Job, _inputs: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        let weight = self
            .distance(job.cancel)?
            .weight(&self.warp, job.grid, self.width_m);
        *out = weight.map_err(|error| RenderError::Node {
            node: KIND,
            reason: error.to_string(),
        })?;
        Ok(())
    }
}
