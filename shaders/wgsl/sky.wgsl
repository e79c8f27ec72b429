// sky.wgsl: vertex entry `sky_vertex` (one triangle over the picture, no buffers), fragment entry
// `sky_fragment`.
// What is seen beyond the terrain: the air's own light, the sun, black space. Drawn at infinity
// (depth 0) after the terrain, so only uncovered pixels cost anything.

#import lib/frame
#import lib/sky
#import lib/light

override HAS_HAZE: bool = true;

@group(0) @binding(0) var<uniform> frame: Frame;

struct Varyings {
    @builtin(position) position: vec4f,
    @location(0) ray: vec3f,
}

@vertex
fn sky_vertex(@builtin(vertex_index) index: u32) -> Varyings {
    let corner = vec2f(f32((index << 1u) & 2u), f32(index & 2u)) * 2.0 - 1.0;
    let ray = frame.ray_forward + corner.x * frame.ray_right + corner.y * frame.ray_up;
    return Varyings(vec4f(corner, 0.0, 1.0), ray);
}

@fragment
fn sky_fragment(in: Varyings) -> @location(0) vec4f {
    let ray = normalize(in.ray);
    // The angle to the sun from the chord, since a cosine near 1 cannot tell a disc this small.
    let sun_angle = length(ray - frame.sun_in_focus);
    let disc = 1.0 - smoothstep(0.85 * SUN_RADIUS_RAD, SUN_RADIUS_RAD, sun_angle);
    var light = vec3f(0.0);
    var sun = vec3f(12.0, 11.6, 11.0);
    if (HAS_HAZE) {
        let up = dot(ray, frame.eye_up_in_focus);
        // Sunlight is judged where the ray is lowest: at the eye, or where it passes the planet.
        var lowest_up = frame.eye_up_in_focus;
        if (up < 0.0) {
            lowest_up = normalize(frame.eye_up_in_focus - ray * up);
        }
        let air = air_to_space(frame.altitude_m, up);
        light = scattered(air, dot(lowest_up, frame.sun_in_focus), dot(ray, frame.sun_in_focus));
        sun *= transmitted(air);
        // A soft glow around the sun, as bright as the air that carries it.
        let near = exp(-18.0 * sun_angle) * 0.35;
        light += near * sun_in_air(dot(lowest_up, frame.sun_in_focus)) * (1.0 - transmitted(0.6 * air));
    }
    light += disc * sun;
    return to_pixel(light, in.position.xy);
}
