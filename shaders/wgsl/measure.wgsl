// measure.wgsl: compute entry `measure`.
// Evaluates the map transform for a buffer of vertices, so that its error on this very device can
// be compared with the truth. Draws nothing.
// Spaces: vertices = (u, v, 1 - w, unused); results = (longitude, colatitude) from the focus in
//         radians, then zeros.
// Twin:   relievo_planet::transform::map_delta_f32.

#import lib/transform

struct MeasureInput {
    sin_cos_colat: vec2f,
    count: u32,
    unused: u32,
}

@group(0) @binding(0) var<uniform> input: MeasureInput;
@group(0) @binding(1) var<storage, read> vertices: array<vec4f>;
@group(0) @binding(2) var<storage, read_write> results: array<vec4f>;

@compute @workgroup_size(64)
fn measure(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= input.count) {
        return;
    }
    results[id.x] = vec4f(map_delta(vertices[id.x].xyz, input.sin_cos_colat), 0.0, 0.0);
}
