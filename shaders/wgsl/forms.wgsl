// forms.wgsl: compute entry `forms`.
// Evaluates one form of the map transform for a buffer of vertices, as often as asked for, so that
// its error and its cost on this very device can be told. Draws nothing.
// Spaces: as lib/transform.wgsl.
// Twin:   relievo_planet::transform::forms::Form, whose order gives the numbers.

#import lib/classic

struct FormsInput {
    focus: ClassicFocus,
    count: u32,
    repeats: u32,
    zero: f32, // 0, which the compiler cannot know
    padding: f32,
}

override FORM: u32 = 0u;

@group(0) @binding(0) var<uniform> input: FormsInput;
@group(0) @binding(1) var<storage, read> queries: array<vec4f>;
@group(0) @binding(2) var<storage, read_write> results: array<vec4f>;

fn evaluate(vertex: vec3f) -> vec2f {
    switch FORM {
        case 0u: { return map_delta_printed(vertex, input.focus); }
        case 1u: { return map_delta_printed_poly(vertex, input.focus); }
        case 2u: { return map_delta_approximate(vertex, input.focus); }
        case 3u: { return map_delta_blended(vertex, input.focus); }
        case 4u: { return map_delta_blended_poly(vertex, input.focus); }
        case 5u: { return map_delta_builtin(vertex, input.focus.sin_cos_colat); }
        default: { return map_delta(vertex, input.focus.sin_cos_colat); }
    }
}

// Query: (u, v, 1 - w, unused). Result: (longitude, colatitude) from the focus in radians, zeros.
@compute @workgroup_size(64)
fn forms(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= input.count) {
        return;
    }
    let vertex = queries[id.x].xyz;
    let result = evaluate(vertex);
    // Each repetition waits for the one before, and changes nothing.
    var last = result;
    for (var i = 1u; i < input.repeats; i++) {
        last = evaluate(vertex + input.zero * last.x);
    }
    results[id.x] = vec4f(result, input.zero * last);
}
