// masses.wgsl: vertex entry `mass_vertex`, fragment entry `mass_fragment`.
// Bodies that stand on the ground: walls and roofs of one colour, lit as the ground is and behind
// the same air. Drawn after the terrain with the same depth, so each hides what lies behind it.
// Spaces: vertices = metres from the mesh's origin along the axes of the world.

#import lib/frame
#import lib/sky
#import lib/light

override HAS_HAZE: bool = true;

// Twin: shaders/src/layout.rs.
struct MassPlace {
    // Axes of the world in focus space.
    focus_from_world_x: vec3f,
    focus_from_world_y: vec3f,
    focus_from_world_z: vec3f,
    // The mesh's origin from the eye, metres in focus space.
    origin_from_eye_m: vec3f,
    // The vertical at the origin, in focus space.
    up_in_focus: vec3f,
    // Height of the origin above the sphere, metres.
    origin_height_m: f32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(0) var<uniform> place: MassPlace;

struct Varyings {
    @builtin(position) position: vec4f,
    @location(0) normal: vec3f,
    @location(1) @interpolate(flat) colour: vec3f,
    @location(2) transmitted: vec3f,
    @location(3) scattered: vec3f,
}

fn focus_from_world(v: vec3f) -> vec3f {
    return place.focus_from_world_x * v.x + place.focus_from_world_y * v.y + place.focus_from_world_z * v.z;
}

@vertex
fn mass_vertex(
    @location(0) offset_m: vec3f,
    @location(1) normal_in_world: vec3f,
    @location(2) encoded: vec4f,
) -> Varyings {
    let offset = focus_from_world(offset_m);
    let from_eye = place.origin_from_eye_m + offset;
    var out = Varyings(
        frame.clip_from_eye * vec4f(from_eye, 1.0),
        focus_from_world(normal_in_world),
        decode_srgb(encoded.rgb),
        vec3f(1.0),
        vec3f(0.0),
    );
    if (HAS_HAZE) {
        let towards_eye = -normalize(from_eye);
        let height_m = place.origin_height_m + dot(offset, place.up_in_focus);
        let air = GROUND_AIR * air_between(height_m, place.up_in_focus, towards_eye);
        out.transmitted = transmitted(air);
        out.scattered = scattered(
            air,
            dot(place.up_in_focus, frame.sun_in_focus),
            -dot(towards_eye, frame.sun_in_focus),
        );
    }
    return out;
}

@fragment
fn mass_fragment(in: Varyings) -> @location(0) vec4f {
    var light = in.colour * lit(normalize(in.normal), place.up_in_focus, frame.sun_in_focus);
    if (HAS_HAZE) {
        light = light * in.transmitted + in.scattered;
    }
    return to_pixel(light, in.position.xy);
}
