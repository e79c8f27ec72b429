//! Elements that stand on the ground: shaped once, from heights read at a spacing of their own.

use std::collections::BTreeMap;
use std::sync::Arc;

use relievo_earthwork::{GroundNeed, Prepared};
use relievo_planet::{Grid, LevelKey, MapPoint, SampleRect};
use relievo_raster::{Block, Cancel};

use crate::node::{Artefact, Made};
use crate::{ContentId, IdHasher, RenderError};

/// Side of the pieces of the ground that are read, samples.
const PIECE: i64 = 32;

/// Finest level at which the ground is read: 4.7 mm on Earth.
const FINEST: u8 = 24;

/// The artefact of an element that needs the ground.
pub(super) struct GroundShape {
    prepared: Arc<Prepared>,
    need: Arc<GroundNeed>,
    name: ContentId,
    level: LevelKey,
    /// Pieces of the level by their position, each with its place in what is read.
    pieces: BTreeMap<(i64, i64), usize>,
}

impl GroundShape {
    /// `None` for an element that needs no ground.
    pub(super) fn new(prepared: &Arc<Prepared>, name: ContentId) -> Option<Self> {
        let need = Arc::clone(prepared.need()?);
        let level = level_for(prepared, &need);
        let mut pieces = BTreeMap::new();
        for place in &need.places {
            pieces.insert(piece_of(level, *place).0, 0);
        }
        for (k, at) in pieces.values_mut().enumerate() {
            *at = k;
        }
        Some(Self {
            prepared: Arc::clone(prepared),
            need,
            name,
            level,
            pieces,
        })
    }

    fn rect(piece: (i64, i64)) -> SampleRect {
        // One more for the interpolation.
        SampleRect::at(piece.0 * PIECE, piece.1 * PIECE, PIECE + 1, PIECE + 1)
    }

    /// Bilinear height at a place; holes are left out, NaN where there is nothing but holes.
    fn height_m(&self, place: MapPoint, samples: &[Block]) -> f64 {
        let (piece, at) = piece_of(self.level, place);
        let block = &samples[self.pieces[&piece]];
        let corner = at.floor();
        let share = at - corner;
        let (x, y) = (corner.x as usize, corner.y as usize);
        let (mut sum, mut weights) = (0.0, 0.0);
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let wx = if dx == 1 { share.x } else { 1.0 - share.x };
            let wy = if dy == 1 { share.y } else { 1.0 - share.y };
            let h = f64::from(block.plane(0)[(y + dy) * block.width() + x + dx]);
            if h.is_finite() {
                sum += wx * wy * h;
                weights += wx * wy;
            }
        }
        if weights > 0.0 {
            sum / weights
        } else {
            f64::NAN
        }
    }
}

/// The level at whose spacing the ground is read: rows no farther apart than asked for, columns about
/// as far apart on the ground.
fn level_for(prepared: &Prepared, need: &GroundNeed) -> LevelKey {
    let spacing_rad = need.spacing_m / prepared.planet().equatorial_radius_m;
    let n = (0..FINEST)
        .find(|n| LevelKey::new(0, *n).step_rad().y <= spacing_rad)
        .unwrap_or(FINEST);
    let colat_rad = need
        .places
        .first()
        .map_or(1.0, |p| p.normalised().colat_rad);
    let narrower = -libm::log2(libm::sin(colat_rad).max(1e-9));
    let m = (f64::from(n) + 1.0 - narrower).round().clamp(0.0, 25.0);
    LevelKey::new(m as u8, n)
}

/// The piece that a place lies in, and where in it, in samples from the middle of its first.
fn piece_of(level: LevelKey, place: MapPoint) -> ((i64, i64), glam::DVec2) {
    let at = level.sample_from_map(place) - 0.5;
    let piece = (at / PIECE as f64).floor();
    ((piece.x as i64, piece.y as i64), at - piece * PIECE as f64)
}

impl Artefact for GroundShape {
    fn identify(&self, id: &mut IdHasher) {
        id.bytes(b"element on the ground").id(self.name);
    }

    fn reads(&self) -> Vec<(usize, Grid)> {
        let lattice = Arc::new(self.level.lattice());
        let grid = |piece| Grid::new(Arc::clone(&lattice), Self::rect(piece));
        self.pieces.keys().map(|piece| (0, grid(*piece))).collect()
    }

    fn make(&self, samples: &[Block], cancel: &Cancel) -> Result<Made, RenderError> {
        if cancel.is_cancelled() {
            return Err(RenderError::Cancelled);
        }
        let heights: Vec<f64> = self
            .need
            .places
            .iter()
            .map(|p| self.height_m(*p, samples))
            .collect();
        Ok(self.prepared.shape(&heights))
    }

    fn bytes(&self) -> usize {
        // Corners, triangles, segments and their trees.
        1_000 + 300 * self.need.places.len()
    }
}
