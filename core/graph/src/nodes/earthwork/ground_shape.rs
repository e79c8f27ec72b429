//! Elements that stand on the ground: shaped once, from heights read at a spacing of their own.

use std::sync::Arc;

use relievo_earthwork::{GroundNeed, Prepared};
use relievo_planet::Grid;
use relievo_raster::{Block, Cancel};

use crate::node::{Artefact, Made};
use crate::places::Pieces;
use crate::{ContentId, IdHasher, RenderError};

/// The artefact of an element that needs the ground.
pub(super) struct GroundShape {
    prepared: Arc<Prepared>,
    need: Arc<GroundNeed>,
    name: ContentId,
    pieces: Pieces,
}

impl GroundShape {
    /// `None` for an element that needs no ground.
    pub(super) fn new(prepared: &Arc<Prepared>, name: ContentId) -> Option<Self> {
        let need = Arc::clone(prepared.need()?);
        Some(Self {
            pieces: Pieces::around(&prepared.planet(), &need.places, need.spacing_m),
            prepared: Arc::clone(prepared),
            need,
            name,
        })
    }
}

impl Artefact for GroundShape {
    fn identify(&self, id: &mut IdHasher) {
        id.bytes(b"element on the ground").id(self.name);
    }

    fn reads(&self) -> Vec<(usize, Grid)> {
        self.pieces.grids().map(|grid| (0, grid)).collect()
    }

    fn make(&self, samples: &[Block], cancel: &Cancel) -> Result<Made, RenderError> {
        if cancel.is_cancelled() {
            return Err(RenderError::Cancelled);
        }
        let places = self.need.places.iter();
        let heights: Vec<f64> = places.map(|p| self.pieces.height_m(*p, samples)).collect();
        Ok(self.prepared.shape(&heights))
    }

    fn bytes(&self) -> usize {
        // Corners, triangles, segments and their trees.
        1_000 + 300 * self.need.places.len()
    }
}
