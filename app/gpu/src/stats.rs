//! What a frame cost.

use crate::terrain::TerrainKey;
use crate::timing::FrameTime;

/// Figures of one drawn frame.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameStats {
    /// Whether nothing had changed, so that the picture before it was kept and nothing drawn.
    pub reused: bool,
    /// Triangles drawn.
    pub triangles: u64,
    /// Triangles of bodies on the ground.
    pub mass_triangles: u64,
    /// Triangles that would have been drawn without leaving out invisible sectors.
    pub triangles_without_culling: u64,
    /// Draw calls for terrain.
    pub draws: u32,
    /// Vertices displaced; 0 when neither view nor heights had changed.
    pub displaced_vertices: u64,
    /// Uploads stored before drawing.
    pub uploads: u32,
    /// Bytes they sent.
    pub uploaded_bytes: u64,
    /// The pipeline that drew the terrain: what of colour, light and air the scene used.
    pub pipeline: TerrainKey,
    /// Memory of textures, mesh and targets on the device, bytes.
    pub gpu_memory: u64,
    /// The latest frame that has been measured on the device; a frame or two old. `None` where the
    /// device has no timestamps.
    pub measured: Option<FrameTime>,
}

impl FrameStats {
    /// Parts of the drawing that the frame did without, and why: no shader, texture or draw call has them.
    pub fn left_out(&self) -> Vec<(&'static str, &'static str)> {
        let key = &self.pipeline;
        [
            (key.colour, "colours", "no layer gives colour"),
            (key.normals, "light by slope", "no layer gives heights"),
            (key.haze, "air", "the body has none, or haze is 0"),
            (self.mass_triangles > 0, "bodies", "none is in view"),
        ]
        .into_iter()
        .filter_map(|(is_used, part, why)| (!is_used).then_some((part, why)))
        .collect()
    }
}
