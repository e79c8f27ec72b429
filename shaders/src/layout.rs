//! Rust mirrors of the structs that shaders read, field by field.
//!
//! `tests/layouts.rs` compares every offset with what naga computes for the WGSL.

use bytemuck::{Pod, Zeroable};
use relievo_planet::clipmap::choose;

/// Most levels of one clipmap that a frame can show.
pub const MAX_LEVELS: usize = 32;

/// First slot of the colour levels in `clip_levels`; heights begin at 0.
pub const COLOUR_SLOT: usize = MAX_LEVELS;

/// First slot of the normal levels.
pub const NORMAL_SLOT: usize = 2 * MAX_LEVELS;

/// Slots of `clip_levels`.
pub const LEVEL_SLOTS: usize = 3 * MAX_LEVELS;

/// `Frame` of `lib/frame.wgsl`; meanings are given there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
#[expect(missing_docs, reason = "the WGSL struct documents each field")]
pub struct FrameUniform {
    pub clip_from_eye: [[f32; 4]; 4],
    pub ray_forward: [f32; 3],
    pub exaggeration: f32,
    pub ray_right: [f32; 3],
    pub radius_m: f32,
    pub ray_up: [f32; 3],
    pub pixel_rad: f32,
    pub focus_from_eye_m: [f32; 3],
    pub altitude_m: f32,
    pub eye_up_in_focus: [f32; 3],
    pub ambient: f32,
    pub sun_in_focus: [f32; 3],
    pub haze: f32,
    pub sin_cos_colat: [f32; 2],
    pub scale_height_m: f32,
    pub height_levels: u32,
    pub colour_levels: u32,
    pub normal_levels: u32,
    pub colour_window: f32,
    pub first_height_ring: i32,
    pub reference_height_m: f32,
    pub reference_drawn_m: f32,
    pub padding: [f32; 2],
}

/// `LevelView` of `lib/clipmap.wgsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
#[expect(
    missing_docs,
    reason = "its twin, relievo_planet::clipmap::choose::LevelView, documents each field"
)]
pub struct LevelUniform {
    pub focus_in_storage: [f32; 2],
    pub samples_per_rad: [f32; 2],
    pub valid_min: [f32; 2],
    pub valid_max: [f32; 2],
    pub settled_min: [f32; 2],
    pub settled_max: [f32; 2],
    pub tap_rows: [f32; 2],
    /// Texels after which storage repeats, columns and rows.
    pub period: [f32; 2],
    pub fade: f32,
    pub edge_band: f32,
    pub texel_rad: f32,
    /// Array layer.
    pub layer: u32,
}

impl LevelUniform {
    /// A level as the chooser knows it, with its place in the texture array.
    pub fn new(view: &choose::LevelView, period: [u32; 2], layer: u32) -> Self {
        Self {
            focus_in_storage: view.focus_in_storage.to_array(),
            samples_per_rad: view.samples_per_rad.to_array(),
            valid_min: view.valid_min.to_array(),
            valid_max: view.valid_max.to_array(),
            settled_min: view.settled_min.to_array(),
            settled_max: view.settled_max.to_array(),
            tap_rows: view.tap_rows.to_array(),
            period: period.map(|p| p as f32),
            fade: view.fade,
            edge_band: view.edge_band,
            texel_rad: view.texel_rad,
            layer,
        }
    }
}

/// `DisplaceRange` of `displace.wgsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct DisplaceRange {
    /// First vertex.
    pub first: u32,
    /// Number of vertices.
    pub count: u32,
}

/// `MassPlace` of `masses.wgsl`; meanings are given there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
#[expect(missing_docs, reason = "the WGSL struct documents each field")]
pub struct MassPlace {
    pub focus_from_world_x: [f32; 3],
    pub padding_x: f32,
    pub focus_from_world_y: [f32; 3],
    pub padding_y: f32,
    pub focus_from_world_z: [f32; 3],
    pub padding_z: f32,
    pub origin_from_eye_m: [f32; 3],
    pub padding_origin: f32,
    pub up_in_focus: [f32; 3],
    pub origin_height_m: f32,
}

/// `MeasureInput` of `measure.wgsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct MeasureInput {
    /// (sin, cos) of the focus' colatitude.
    pub sin_cos_colat: [f32; 2],
    /// Number of queries.
    pub count: u32,
    /// Number of levels to choose from.
    pub levels: u32,
}

/// `FormsInput` of `forms.wgsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct FormsInput {
    /// (sin, cos) of the focus' colatitude.
    pub sin_cos_colat: [f32; 2],
    /// The colatitude, radians.
    pub colat_rad: f32,
    /// \[CH06\]'s distortion of longitudes there.
    pub distortion: f32,
    /// Number of queries.
    pub count: u32,
    /// How often each is answered.
    pub repeats: u32,
    /// 0, which the compiler cannot know.
    pub zero: f32,
    /// Nothing.
    pub padding: f32,
}

/// A vertex of the static rings as displacement reads it and the terrain pass interpolates it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct RingVertexData {
    /// (u, v, 1 − w); see `relievo_planet::transform::RingVertex`.
    pub vertex: [f32; 3],
    /// The ring's number minus the vertex's rim weight: 0 inside to 1 at the outer rim.
    pub ring_minus_rim: f32,
}
