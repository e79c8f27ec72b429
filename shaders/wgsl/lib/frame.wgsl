// lib/frame.wgsl: library, no entry point, no bindings.
// What every pass of a frame knows. The entry declares it as `frame` in group 0, binding 0.
// Spaces: *_in_focus = axes at the focus (x south, y east, z up); eye-relative = the same axes with
//         the eye as origin, metres; clip = reversed depth, far plane at infinity.
// Twin:   shaders/src/layout.rs; tests/layouts.rs compares the offsets.

struct Frame {
    clip_from_eye: mat4x4f,
    // Direction of view through the picture's middle and its steps to the right and top edge.
    ray_forward: vec3f,
    exaggeration: f32,
    ray_right: vec3f,
    radius_m: f32,
    ray_up: vec3f,
    // Angle of a pixel in the middle of the picture, radians.
    pixel_rad: f32,
    // The focus, raised by the exaggerated reference height, minus the eye.
    focus_from_eye_m: vec3f,
    // Height of the eye above the sphere.
    altitude_m: f32,
    // Unit vector from the planet's centre to the eye.
    eye_up_in_focus: vec3f,
    ambient: f32,
    sun_in_focus: vec3f,
    // Density of the air at the datum relative to Earth's; 0 for none.
    haze: f32,
    // (sin, cos) of the focus' colatitude.
    sin_cos_colat: vec2f,
    // Height in metres over which the air thins by the factor e.
    scale_height_m: f32,
    height_levels: u32,
    colour_levels: u32,
    normal_levels: u32,
    // Texels along a side of a colour and normal layer.
    colour_window: f32,
    // Index of the height level that ring 1 reads, minus 1; negative when finer levels come first.
    first_height_ring: i32,
    // Height in metres, without exaggeration, of the ground near the eye: heights are drawn relative
    // to it, so that they have the digits that a planet's mountains would take.
    reference_height_m: f32,
    // The same with exaggeration.
    reference_drawn_m: f32,
}
