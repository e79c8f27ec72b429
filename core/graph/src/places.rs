//! Heights at places that lie on no grid: read at a stated spacing, the same at every zoom.

use std::collections::BTreeMap;
use std::sync::Arc;

use relievo_planet::{Grid, LevelKey, MapPoint, Planet, SampleRect};
use relievo_raster::{Block, Cancel};

use crate::{Graph, NodeIndex, RenderError};

/// Side of the pieces of a level that are read, samples.
const PIECE: i64 = 32;

/// Finest level that is read: 4.7 mm on Earth.
const FINEST: u8 = 24;

/// The pieces of one level around places.
#[derive(Clone, Debug)]
pub struct Pieces {
    level: LevelKey,
    /// Each with its number among [`Pieces::grids`].
    pieces: BTreeMap<(i64, i64), usize>,
}

impl Pieces {
    /// Those of the coarsest level whose samples are no farther apart than `spacing_m` along
    /// meridians and about as far along circles of latitude.
    pub fn around(planet: &Planet, places: &[MapPoint], spacing_m: f64) -> Self {
        let spacing_rad = spacing_m / planet.equatorial_radius_m;
        let n = (0..FINEST)
            .find(|n| LevelKey::new(0, *n).step_rad().y <= spacing_rad)
            .unwrap_or(FINEST);
        let colat_rad = places.first().map_or(1.0, |p| p.normalised().colat_rad);
        let narrower = -libm::log2(libm::sin(colat_rad).max(1e-9));
        let m = (f64::from(n) + 1.0 - narrower).round().clamp(0.0, 25.0);
        let level = LevelKey::new(m as u8, n);
        let mut pieces = BTreeMap::new();
        for place in places {
            pieces.insert(piece_of(level, *place).0, 0);
        }
        for (k, number) in pieces.values_mut().enumerate() {
            *number = k;
        }
        Self { level, pieces }
    }

    /// The grids of the pieces.
    pub fn grids(&self) -> impl Iterator<Item = Grid> + '_ {
        let lattice = Arc::new(self.level.lattice());
        self.pieces.keys().map(move |(x, y)| {
            // One more for the interpolation.
            let rect = SampleRect::at(x * PIECE, y * PIECE, PIECE + 1, PIECE + 1);
            Grid::new(Arc::clone(&lattice), rect)
        })
    }

    /// Bilinear height at one of the places from the blocks of all [`Self::grids`]; holes are left
    /// out, NaN where there is nothing but holes.
    ///
    /// # Panics
    /// If the place lies in no piece, or there is not a block for each.
    pub fn height_m(&self, place: MapPoint, samples: &[Block]) -> f64 {
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

/// The piece that a place lies in, and where in it, in samples from the middle of its first.
fn piece_of(level: LevelKey, place: MapPoint) -> ((i64, i64), glam::DVec2) {
    let at = level.sample_from_map(place) - 0.5;
    let piece = (at / PIECE as f64).floor();
    ((piece.x as i64, piece.y as i64), at - piece * PIECE as f64)
}

impl Graph {
    /// Heights of a node at places, bilinear between samples about `spacing_m` metres apart; NaN
    /// where there are none.
    ///
    /// # Errors
    /// [`RenderError`] from a node, or `Cancelled`.
    pub fn heights_at(
        &self,
        node: NodeIndex,
        planet: &Planet,
        places: &[MapPoint],
        spacing_m: f64,
        cancel: &Cancel,
    ) -> Result<Vec<f64>, RenderError> {
        let pieces = Pieces::around(planet, places, spacing_m);
        let samples: Result<Vec<Block>, RenderError> = pieces
            .grids()
            .map(|grid| self.evaluate(node, &grid, cancel))
            .collect();
        let samples = samples?;
        Ok(places
            .iter()
            .map(|p| pieces.height_m(*p, &samples))
            .collect())
    }
}
