//! What a front-end needs to draw one frame: plain data.

use std::sync::Arc;

use glam::DVec3;
use relievo_planet::clipmap::{Plan, Window, choose};
use relievo_planet::{Camera, Planet};
use relievo_raster::Tile;

use crate::masses::MassMesh;

/// Which stack of clip levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ClipKind {
    /// Heights, f32 metres; NaN never arrives (nodata is 0 m).
    Height,
    /// Straight RGBA, 8 bits, sRGB encoded.
    Colour,
    /// East and north component of the surface normal, half floats.
    Normal,
}

impl ClipKind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Height, Self::Colour, Self::Normal];
}

/// One clip level as the front-end shows it.
///
/// Sample (i, j) of the level is stored at the texel that [`Window::storage_of`] says, of array
/// layer `layer`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelView {
    /// Layer of the clipmap's texture array; stays the same while the level's n does.
    pub layer: u32,
    /// What the level's storage holds.
    pub window: Window,
    /// What shaders are told: position, scale, valid and settled rectangle, fade.
    pub view: choose::LevelView,
}

/// Samples to copy into a clipmap texture before this frame is drawn.
#[derive(Clone, Debug)]
pub struct Upload {
    /// Which clipmap.
    pub clipmap: ClipKind,
    /// Array layer.
    pub layer: u32,
    /// First texel written; the rectangle does not cross the torus seam.
    pub storage: [u32; 2],
    /// The samples; a uniform tile has no buffer.
    pub tile: Arc<Tile>,
    /// First sample of the tile that is copied.
    pub source: [u32; 2],
    /// Columns and rows.
    pub size: [u32; 2],
}

/// Light of the sun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// Unit vector towards the sun, world space.
    pub direction_in_world: DVec3,
    /// Light from elsewhere, 0 to 1.
    pub ambient: f32,
}

/// Everything that a frame shows: one revision of the project.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Counts revisions; a frame never mixes two.
    pub revision: u64,
    /// The planet; its sphere places vertices.
    pub planet: Planet,
    /// Factor on heights.
    pub exaggeration: f64,
    /// The viewer.
    pub camera: Camera,
    /// Width and height of the picture in pixels that the plan was made for.
    pub viewport_px: [u32; 2],
    /// Near plane in metres.
    pub near_m: f64,
    /// Where to draw what: rings and their visible sectors, the disc, the cap, the eye.
    pub plan: Arc<Plan>,
    /// Size N of the height windows in samples.
    pub height_window: u32,
    /// Size N of the colour and normal windows in samples.
    pub colour_window: u32,
    /// Height levels, coarse to fine; the first covers what the others do not.
    pub heights: Vec<LevelView>,
    /// Colour levels, coarse to fine. Empty when the project has no visible colour.
    pub colours: Vec<LevelView>,
    /// Normal levels, coarse to fine. Empty when nothing is lit.
    pub normals: Vec<LevelView>,
    /// The sun.
    pub sun: Sun,
    /// Density of the air at the datum relative to Earth's; 0 has a black sky.
    pub air: f32,
    /// Bodies that stand on the ground.
    pub masses: Vec<Arc<MassMesh>>,
    /// Samples to copy, in order.
    pub uploads: Vec<Upload>,
    /// Visible tiles that are still to come.
    pub pending: usize,
}

impl Frame {
    /// Whether the picture is as good as it will get: nothing to come, nothing fading.
    pub fn is_converged(&self) -> bool {
        let settled = |l: &LevelView| l.view.fade >= 1.0;
        self.pending == 0
            && [&self.heights, &self.colours, &self.normals]
                .into_iter()
                .flatten()
                .all(settled)
    }
}
