//! From a frame to what its shaders are told.
//!
//! Invariant: everything planet-sized is subtracted in f64 here; what reaches a shader is relative
//! to the eye or the focus. Twin of the consuming side: `shaders/wgsl/lib/frame.wgsl`.

use glam::{DMat3, DMat4, DVec3, Vec2};
use relievo_engine::planet::clipmap::choose::LevelView as ShaderView;
use relievo_engine::planet::clipmap::view::{FocusFrame, View};
use relievo_engine::{Frame, LevelView};
use relievo_shaders::layout::{
    COLOUR_SLOT, FrameUniform, LEVEL_SLOTS, LevelUniform, MAX_LEVELS, NORMAL_SLOT,
};

use crate::quality::Look;

/// Scale height of Earth's air over Earth's radius; other planets' airs are scaled likewise.
const SCALE_HEIGHT_PER_RADIUS: f64 = 8_000.0 / 6_371_008.8;

/// All levels of a frame, in the slots that shaders expect.
pub type LevelUniforms = [LevelUniform; LEVEL_SLOTS];

/// Axes of the focus (south, east, up) in world space: world from focus.
fn world_from_focus(frame: &Frame) -> DMat3 {
    let at = FocusFrame::at(frame.plan.focus);
    DMat3::from_cols(at.south, at.east, at.up)
}

/// The frame uniform for a picture `size_px` pixels large.
pub fn frame_uniform(frame: &Frame, size_px: [u32; 2], look: Look) -> FrameUniform {
    let Frame { camera, planet, .. } = frame;
    let world_from_focus = world_from_focus(frame);
    let focus_from_world = world_from_focus.transpose();
    let aspect = f64::from(size_px[0].max(1)) / f64::from(size_px[1].max(1));
    let view = View::new(camera, planet, size_px);
    let eye = view.eye;
    let (reference_m, reference_drawn_m) = reference(frame);
    let focus = world_from_focus.z_axis * (planet.radius_m + reference_drawn_m);
    let focus_from_eye = focus_from_world * (focus - eye);
    let clip_from_eye =
        camera.view_projection(planet, aspect, frame.near_m) * DMat4::from_mat3(world_from_focus);
    let turned = |v: DVec3| (focus_from_world * v).as_vec3().to_array();
    let (sin_colat, cos_colat) = sin_cos_colat(world_from_focus);
    FrameUniform {
        clip_from_eye: clip_from_eye.as_mat4().to_cols_array_2d(),
        ray_forward: turned(view.forward),
        exaggeration: frame.exaggeration as f32,
        ray_right: turned(view.right * view.tan_half.x),
        radius_m: planet.radius_m as f32,
        ray_up: turned(view.up * view.tan_half.y),
        pixel_rad: (2.0 * view.tan_half.y / f64::from(size_px[1].max(1))) as f32,
        focus_from_eye_m: focus_from_eye.as_vec3().to_array(),
        altitude_m: camera.altitude_m as f32,
        eye_up_in_focus: turned(eye.normalize_or(DVec3::Z)),
        ambient: frame.sun.ambient,
        sun_in_focus: turned(frame.sun.direction_in_world),
        haze: (look.haze * frame.air).clamp(0.0, 8.0),
        sin_cos_colat: [sin_colat as f32, cos_colat as f32],
        scale_height_m: (planet.radius_m * SCALE_HEIGHT_PER_RADIUS) as f32,
        height_levels: count(&frame.heights),
        colour_levels: count(&frame.colours),
        normal_levels: count(&frame.normals),
        colour_window: frame.colour_window as f32,
        // Ring 1 and the wider ones read the coarsest level: `Plan::height_level_of_ring`.
        first_height_ring: -1,
        reference_height_m: reference_m,
        reference_drawn_m: reference_drawn_m as f32,
        padding: [0.0; 2],
    }
}

/// (sin θv, cos θv), never negative the first, from the frame's own axes so that both agree.
fn sin_cos_colat(world_from_focus: DMat3) -> (f64, f64) {
    (
        (-world_from_focus.x_axis.z).max(0.0),
        world_from_focus.z_axis.z,
    )
}

/// Height of the ground below the eye that heights are drawn relative to, and the same with
/// exaggeration.
///
/// Single precision has 8 mm at 100 km: beside an eye a metre above such a mountain, or above one that
/// is exaggerated to it, the ground would tremble by pixels.
fn reference(frame: &Frame) -> (f32, f64) {
    let drawn_m = frame.camera.altitude_m - frame.plan.clearance_m;
    let natural_m = (drawn_m / frame.exaggeration) as f32;
    if natural_m.is_finite() {
        (natural_m, f64::from(natural_m) * frame.exaggeration)
    } else {
        (0.0, 0.0)
    }
}

fn count(levels: &[LevelView]) -> u32 {
    levels.len().min(MAX_LEVELS) as u32
}

/// Whether colours and normals lie in the same windows, so that one choice of levels serves both.
pub fn shares_levels(frame: &Frame) -> bool {
    let (colours, normals) = (&frame.colours, &frame.normals);
    !colours.is_empty()
        && colours.len() == normals.len()
        && colours
            .iter()
            .zip(normals)
            .all(|(c, n)| c.window == n.window && c.layer == n.layer)
}

/// What may be read of both of two levels in one window.
fn readable_in_both(a: &ShaderView, b: &ShaderView) -> ShaderView {
    ShaderView {
        valid_min: a.valid_min.max(b.valid_min),
        valid_max: a.valid_max.min(b.valid_max),
        settled_min: a.settled_min.max(b.settled_min),
        settled_max: a.settled_max.min(b.settled_max),
        fade: a.fade.min(b.fade),
        tap_rows: Vec2::new(
            a.tap_rows.x.max(b.tap_rows.x),
            a.tap_rows.y.min(b.tap_rows.y),
        ),
        ..*a
    }
}

/// The levels of all three clipmaps. Of more than [`MAX_LEVELS`] the finest are left out. Where
/// colours and normals share their levels, the colours' slots say what may be read of both.
pub fn level_uniforms(frame: &Frame) -> LevelUniforms {
    let mut slots = [LevelUniform::default(); LEVEL_SLOTS];
    let stacks = [
        (0, &frame.heights),
        (COLOUR_SLOT, &frame.colours),
        (NORMAL_SLOT, &frame.normals),
    ];
    for (first, levels) in stacks {
        for (slot, level) in slots[first..first + MAX_LEVELS].iter_mut().zip(levels) {
            let period = level.window.period().to_array().map(|p| p as u32);
            *slot = LevelUniform::new(&level.view, period, level.layer);
        }
    }
    if shares_levels(frame) {
        let both = frame.colours.iter().zip(&frame.normals);
        for (slot, (colour, normal)) in slots[COLOUR_SLOT..NORMAL_SLOT].iter_mut().zip(both) {
            let period = colour.window.period().to_array().map(|p| p as u32);
            let view = readable_in_both(&colour.view, &normal.view);
            *slot = LevelUniform::new(&view, period, colour.layer);
        }
    }
    slots
}
