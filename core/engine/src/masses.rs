//! Bodies that stand on the ground, as front-ends draw them: prisms with walls and a flat roof.
//!
//! Areas of vector layers that are extruded are kept in cells of the map, each with a mesh of its own
//! around an origin of its own, so that f32 offsets are exact to millimetres anywhere on the planet.
//! Meshes are made by a thread of their own from the heights of the evaluated ground, never from what is
//! on the screen.

mod cells;
pub(crate) mod making;
mod prism;

use glam::DVec3;

/// A vertex of a wall or a roof.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassVertex {
    /// Metres from the mesh's origin along the axes of the world.
    pub offset_m: [f32; 3],
    /// Unit normal in the world.
    pub normal: [f32; 3],
    /// Red, green, blue, sRGB encoded; the fourth is 255.
    pub rgba: [u8; 4],
}

/// Bodies of one part of the map.
#[derive(Clone, Debug, PartialEq)]
pub struct MassMesh {
    /// Names the content: equal ids mean equal meshes.
    pub id: u64,
    /// Where offsets start: metres from the planet's centre.
    pub origin_in_world: DVec3,
    /// No vertex lies farther from the origin than this, metres.
    pub radius_m: f64,
    /// All vertices.
    pub vertices: Vec<MassVertex>,
    /// Triangles, counter-clockwise from outside.
    pub indices: Vec<u32>,
}
