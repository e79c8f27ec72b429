// measure.wgsl: compute entries `measure` and `choose`.
// Evaluate the map transform and the choice of levels for buffers of inputs, so that tests compare
// them on this very device with their twins and with the truth. Draw nothing.
// Spaces: as lib/transform.wgsl and lib/clipmap.wgsl.
// Twins:  relievo_planet::transform::map_delta_f32, relievo_planet::clipmap::choose.

#import lib/transform
#import lib/clipmap

struct MeasureInput {
    sin_cos_colat: vec2f,
    count: u32,
    levels: u32,
}

@group(0) @binding(0) var<uniform> input: MeasureInput;
@group(0) @binding(1) var<storage, read> queries: array<vec4f>;
@group(0) @binding(2) var<storage, read_write> results: array<vec4f>;
@group(0) @binding(3) var<uniform> clip_levels: array<LevelView, LEVEL_SLOTS>;

// Query: (u, v, 1 - w, unused). Result: (longitude, colatitude) from the focus in radians, zeros.
@compute @workgroup_size(64)
fn measure(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= input.count) {
        return;
    }
    results[id.x] = vec4f(map_delta(queries[id.x].xyz, input.sin_cos_colat), 0.0, 0.0);
}

// (fine, coarse, weight of the coarse one, 1), or zeros where no level is valid.
fn reported(choice: LevelChoice) -> vec4f {
    if (choice.fine == NO_LEVEL) {
        return vec4f(0.0);
    }
    return vec4f(f32(choice.fine), f32(choice.coarse), choice.coarse_weight, 1.0);
}

// Query: (longitude, colatitude from the focus, footprint in radians, level - rim). Results: the
// choice for a colour, then for a height.
@compute @workgroup_size(64)
fn choose(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= input.count) {
        return;
    }
    let query = queries[id.x];
    let stack = LevelStack(0u, input.levels);
    let level = ceil(query.w);
    results[2u * id.x] = reported(colour_level_for(stack, query.z, query.xy));
    results[2u * id.x + 1u] = reported(height_level_for(stack, u32(level), level - query.w, query.xy));
}
