//! What the planner is told and what it answers.

use core::ops::RangeInclusive;

use glam::{DVec2, DVec3, I64Vec2};

use super::focus::FocusRule;
use super::tile_set::TileSet;
use super::window::Window;
use crate::{Camera, LevelKey, MapPoint, Planet, SampleRect, TILE_SAMPLES, TileKey};

/// Lowest and highest terrain of some region, metres above the sphere, without exaggeration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightRange {
    /// Lowest height.
    pub min_m: f64,
    /// Highest height, not below `min_m`.
    pub max_m: f64,
}

/// Knows bounds of the terrain's height. The tighter they are, the more is culled; they must hold
/// for whatever can be drawn, coarse stand-ins included.
pub trait TerrainBounds {
    /// Bounds over the whole planet.
    fn everywhere(&self) -> HeightRange;

    /// Bounds within `radius_rad` (central angle) of a point. The default is [`Self::everywhere`].
    fn near(&self, _centre: MapPoint, _radius_rad: f64) -> HeightRange {
        self.everywhere()
    }
}

impl TerrainBounds for HeightRange {
    fn everywhere(&self) -> HeightRange {
        *self
    }
}

/// How clip levels and the mesh lie around their focus: the same for who plans and who draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Layout {
    /// N of the height windows: a power of two, at least 256.
    pub height_window: u32,
    /// Width of the blend into the next coarser level of heights, of each ring's width, 1 to 100 per
    /// cent; it ends at the ring's outer rim.
    pub blend_percent: u32,
    /// Where the focus lies.
    pub focus: FocusRule,
}

impl Layout {
    /// What pictures are drawn with.
    pub const STANDARD: Self = Self {
        height_window: 256,
        blend_percent: 50,
        focus: FocusRule::Ahead,
    };

    /// Where in a ring, as a part of its outer radius, the blend into the next coarser level begins.
    pub fn rim_begins(&self) -> f64 {
        // A ring reaches from half its outer radius.
        1.0 - 0.5 * f64::from(self.blend_percent.clamp(1, 100)) / 100.0
    }
}

impl Default for Layout {
    fn default() -> Self {
        Self::STANDARD
    }
}

/// How much is spent on a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// How levels lie around the focus.
    pub layout: Layout,
    /// N of the colour and normal windows: a power of two, at least 256.
    pub colour_samples: u32,
    /// Smallest size of a height sample on the screen, pixels.
    pub height_texel_px: f64,
    /// Smallest size of a colour sample on the screen, pixels.
    pub colour_texel_px: f64,
    /// Most taps along the major axis of a colour footprint, at least 1. A footprint longer than
    /// that many times its width selects coarser levels.
    pub max_taps: u32,
    /// Finest level n of heights that the data (with synthesised detail) is worth, at most 24.
    pub finest_height_level: u8,
    /// Finest level n of colours that the data is worth, at most 24.
    pub finest_colour_level: u8,
}

impl Default for Quality {
    /// For a software adapter.
    fn default() -> Self {
        Self {
            layout: Layout::default(),
            colour_samples: 1024,
            height_texel_px: 2.0,
            colour_texel_px: 1.0,
            max_taps: 8,
            finest_height_level: 24,
            finest_colour_level: 24,
        }
    }
}

/// A view to plan for.
#[derive(Clone, Copy)]
pub struct PlanInput<'a> {
    /// The viewer.
    pub camera: Camera,
    /// The planet; only its sphere is used.
    pub planet: Planet,
    /// Width and height of the picture in pixels.
    pub viewport_px: [u32; 2],
    /// Height of the terrain below the eye, metres above the sphere, without exaggeration.
    pub ground_m: f64,
    /// Bounds of the terrain's heights.
    pub terrain: &'a dyn TerrainBounds,
    /// Factor by which heights are drawn, positive.
    pub exaggeration: f64,
    /// How much to spend.
    pub quality: Quality,
}

/// One clip level of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelPlan {
    /// The level.
    pub level: LevelKey,
    /// Where its window lies.
    pub window: Window,
    /// The tiles that the converged picture can read.
    pub selected: TileSet,
    /// The box around them: aligned to tiles, in the window's unwrapped indices. Every tile in it
    /// touches the window, but tiles at the window's sides stick out of it. Empty when the picture
    /// reads nothing of this level.
    pub wanted: SampleRect,
    /// Continuous position of the focus in the window's unwrapped indices.
    pub focus_in_sample: DVec2,
    /// Continuous position of the view's centre on the ground, or as near to it as ground is seen,
    /// in the window's unwrapped indices: tiles near it come first.
    pub centre_in_sample: DVec2,
}

impl LevelPlan {
    /// Whether the converged picture can read a tile of this level.
    pub fn selects(&self, tile: TileKey) -> bool {
        let rect = self.window.tile_rect(tile);
        rect.is_some_and(|rect| self.selected.contains(&rect))
    }

    /// The tiles of `selected`, nearest to the view's centre first.
    pub fn selected_tiles(&self) -> Vec<TileKey> {
        let mut tiles = self.wanted_tiles();
        tiles.retain(|tile| self.selects(*tile));
        tiles
    }

    /// The tiles of `wanted`: those of `selected` before the others, nearest to the view's centre
    /// first.
    pub fn wanted_tiles(&self) -> Vec<TileKey> {
        let mut tiles = self.ordered(&self.wanted, &SampleRect::default());
        tiles.sort_by_key(|tile| !self.selects(*tile));
        tiles
    }

    /// The tiles of the window that are not wanted, nearest to the view's centre first: prefetch.
    pub fn prefetch_tiles(&self) -> Vec<TileKey> {
        self.ordered(&self.window.rect, &self.wanted)
    }

    /// Tiles that touch `rect` but not `except`, by distance from the view's centre.
    fn ordered(&self, rect: &SampleRect, except: &SampleRect) -> Vec<TileKey> {
        let mut tiles: Vec<(f64, TileKey)> = self
            .level
            .tiles_touching(rect)
            .filter(|(_, tile)| !tile.overlaps(except))
            .map(|(key, tile)| {
                let centre = (tile.min + I64Vec2::splat(TILE_SAMPLES / 2)).as_dvec2();
                (centre.distance_squared(self.centre_in_sample), key)
            })
            .collect();
        tiles.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        tiles.dedup_by_key(|t| t.1);
        tiles.into_iter().map(|t| t.1).collect()
    }
}

/// Which clipmap a tile is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ClipKind {
    /// Heights.
    Heights,
    /// Colours, and the normals that share their windows.
    Colours,
}

/// The visible sectors of one ring: bit k stands for the azimuths from k to k + 1 times
/// 2π / [`super::rings::SECTORS`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RingSectors {
    /// Which ring; 0 is the widest.
    pub ring: u8,
    /// Visible sectors of the ring, or of the disc inside it.
    pub visible: u32,
}

/// The answer: what to draw, what to hold, what to make.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Where the clipmaps and the mesh are centred, normalised.
    pub focus: MapPoint,
    /// Position of the eye in world space, metres.
    pub eye_in_world: DVec3,
    /// Height of the eye above the drawn terrain, metres, at least 0.1.
    pub clearance_m: f64,
    /// Angle of a pixel in the middle of the picture, radians.
    pub pixel_rad: f64,
    /// Central angle from the nadir beyond which no terrain shows above the horizon, radians.
    pub horizon_rad: f64,
    /// Rings of the mesh to draw, widest to narrowest; the fill disc lies inside the last.
    pub rings: RangeInclusive<u8>,
    /// Visible sectors of every ring, widest first; rings with none are left out.
    pub sectors: Vec<RingSectors>,
    /// Visible sectors of the fill disc inside the last ring.
    pub disc_sectors: u32,
    /// Whether terrain beyond the widest ring can be seen, so that the cap is to be drawn.
    pub cap: bool,
    /// Height levels, coarse to fine, consecutive in n.
    pub heights: Vec<LevelPlan>,
    /// Colour levels, coarse to fine, consecutive in n.
    pub colours: Vec<LevelPlan>,
    /// Whether all windows have their final shape; when false, plan again after this plan's tiles
    /// have come, even if the view stays.
    pub settled: bool,
}

impl Plan {
    /// Index into `heights` of the level that a ring's vertices read.
    pub fn height_level_of_ring(&self, ring: u8) -> usize {
        // Level n0 has as many rows as the window; ring 1 and the wider ones read it.
        usize::from(ring.saturating_sub(1)).min(self.heights.len().saturating_sub(1))
    }

    /// All tiles that the converged picture can read, in the order in which they are to be made:
    /// coarse before fine, heights before colours, near the view's centre first.
    pub fn selected_tiles(&self) -> Vec<(ClipKind, TileKey)> {
        self.in_order(LevelPlan::selected_tiles)
    }

    /// All wanted tiles in the order in which they are to be made: coarse before fine, heights
    /// before colours, near the view's centre first.
    pub fn wanted_tiles(&self) -> Vec<(ClipKind, TileKey)> {
        self.in_order(LevelPlan::wanted_tiles)
    }

    /// All other tiles of the windows, in the same order.
    pub fn prefetch_tiles(&self) -> Vec<(ClipKind, TileKey)> {
        self.in_order(LevelPlan::prefetch_tiles)
    }

    /// Interleaves both clipmaps by level.
    fn in_order(&self, tiles: impl Fn(&LevelPlan) -> Vec<TileKey>) -> Vec<(ClipKind, TileKey)> {
        let mut levels: Vec<(u8, ClipKind, &LevelPlan)> = Vec::new();
        levels.extend(
            self.heights
                .iter()
                .map(|l| (l.level.n, ClipKind::Heights, l)),
        );
        levels.extend(
            self.colours
                .iter()
                .map(|l| (l.level.n, ClipKind::Colours, l)),
        );
        levels.sort_by_key(|&(n, kind, _)| (n, kind));
        levels
            .into_iter()
            .flat_map(|(_, kind, level)| tiles(level).into_iter().map(move |t| (kind, t)))
            .collect()
    }
}
