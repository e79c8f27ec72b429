// displace.wgsl: compute entry `displace`.
// Lifts the vertices of the static rings to the terrain and moves them to the eye.
// Spaces: vertices = (u, v, 1 - w, ring - rim) in focus space; output = metres from the eye along
//         the focus' axes, and the height above the sphere in metres (exaggerated).
// Twin:   app/gpu/tests/twins.rs compares it with relievo-planet.

#import lib/frame
#import lib/transform
#import lib/clipmap

struct DisplaceRange {
    first: u32,
    count: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> clip_levels: array<LevelView, LEVEL_SLOTS>;
@group(1) @binding(0) var heights: texture_2d_array<f32>;
@group(1) @binding(1) var<storage, read> vertices: array<vec4f>;
@group(1) @binding(2) var<storage, read_write> displaced: array<vec4f>;
@group(1) @binding(3) var<uniform> range: DisplaceRange;

// Height of a level at `delta` from the focus over the reference, metres: bilinear by hand, because
// 32-bit floats need not be filterable and columns wrap with the level's own period. The reference is
// taken off first, where the difference of like heights is exact.
fn rise_at(level: u32, delta: vec2f) -> f32 {
    let offset = delta * clip_levels[level].samples_per_rad;
    let corner = storage_of(level, offset) - 0.5;
    let low = floor(corner);
    let t = corner - low;
    let period = vec2i(clip_levels[level].period);
    let a = (vec2i(low) + period) % period;
    let b = (a + 1) % period;
    let layer = i32(clip_levels[level].layer);
    let north = mix(
        textureLoad(heights, vec2i(a.x, a.y), layer, 0).x - frame.reference_height_m,
        textureLoad(heights, vec2i(b.x, a.y), layer, 0).x - frame.reference_height_m,
        t.x,
    );
    let south = mix(
        textureLoad(heights, vec2i(a.x, b.y), layer, 0).x - frame.reference_height_m,
        textureLoad(heights, vec2i(b.x, b.y), layer, 0).x - frame.reference_height_m,
        t.x,
    );
    return mix(north, south, t.y);
}

// Height of the terrain at a vertex over the reference, metres; the datum where no level is valid.
fn terrain_rise(vertex: vec4f) -> f32 {
    if (frame.height_levels == 0u) {
        return -frame.reference_height_m;
    }
    let delta = map_delta(vertex.xyz, frame.sin_cos_colat);
    let ring = ceil(vertex.w);
    let rim = ring - vertex.w;
    let level = u32(clamp(i32(ring) + frame.first_height_ring, 0, i32(frame.height_levels) - 1));
    // A ring that reads the coarsest level, or shares its level with the wider one, has none to
    // blend into.
    let blends = i32(level) == i32(ring) + frame.first_height_ring;
    let stack = LevelStack(0u, frame.height_levels);
    let choice = height_level_for(stack, level, select(0.0, rim, blends), delta);
    if (choice.fine == NO_LEVEL) {
        return -frame.reference_height_m;
    }
    var rise = 0.0;
    if (choice.coarse_weight < 1.0) {
        rise = (1.0 - choice.coarse_weight) * rise_at(choice.fine, delta);
    }
    if (choice.coarse_weight > 0.0) {
        rise += choice.coarse_weight * rise_at(choice.coarse, delta);
    }
    return rise;
}

@compute @workgroup_size(64)
fn displace(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= range.count) {
        return;
    }
    let vertex = vertices[range.first + id.x];
    // Twin: relievo_planet::transform::displaced_f32.
    let rise = terrain_rise(vertex) * frame.exaggeration;
    let height = frame.reference_drawn_m + rise;
    // (R + h) * (u, v, w) - (0, 0, R + r), r the drawn reference, without the difference of two planet
    // radii or of two mountains.
    let from_focus = (frame.radius_m + height) * vec3f(vertex.x, vertex.y, -vertex.z)
        + vec3f(0.0, 0.0, rise);
    displaced[range.first + id.x] = vec4f(from_focus + frame.focus_from_eye_m, height);
}
