// terrain.wgsl: vertex entry `terrain_vertex`, fragment entry `terrain_fragment`.
// Colours the ground: finds its place on the map and its clip levels per fragment, lights it and
// puts the air in front of it. Specialised to what a scene uses by the overrides below.
// Spaces: as lib/frame.wgsl; the map transform runs per fragment, so that the azimuth seam beyond
//         a pole needs no vertices of its own.

#import lib/frame
#import lib/transform
#import lib/clipmap
#import lib/sky
#import lib/light

// What the scene uses.
override HAS_COLOUR: bool = true;
override HAS_NORMALS: bool = true;
override HAS_HAZE: bool = true;
// Whether normals have the windows of the colours, so that one choice of levels serves both.
override SHARED_LEVELS: bool = false;
// Whether two levels are read and mixed; else one of them is read, by chance in proportion.
override BLENDS_LEVELS: bool = true;
// Most taps along the major axis of a footprint.
override MAX_TAPS: u32 = 8u;

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> clip_levels: array<LevelView, LEVEL_SLOTS>;
@group(1) @binding(0) var colours: texture_2d_array<f32>;
@group(1) @binding(1) var normals: texture_2d_array<f32>;
@group(1) @binding(2) var wrapping: sampler;

// Linear light of ground that no source colours.
const BARE_GROUND: vec3f = vec3f(0.23, 0.22, 0.20);

struct Varyings {
    @builtin(position) position: vec4f,
    @location(0) vertex: vec3f,
    @location(1) depth_m: f32,
    @location(2) height_m: f32,
    // The air between the eye and the ground: what it lets through, and the light it adds.
    @location(3) transmitted: vec3f,
    @location(4) scattered: vec3f,
}

@vertex
fn terrain_vertex(@location(0) displaced: vec4f, @location(1) vertex: vec4f) -> Varyings {
    var out = Varyings(
        frame.clip_from_eye * vec4f(displaced.xyz, 1.0),
        vertex.xyz,
        dot(displaced.xyz, frame.ray_forward),
        displaced.w,
        vec3f(1.0),
        vec3f(0.0),
    );
    if (HAS_HAZE) {
        // Air changes little over a triangle, and its formulas are dear.
        let towards_eye = -normalize(displaced.xyz);
        let up = normalize(vec3f(vertex.xy, 1.0 - vertex.z));
        let air = GROUND_AIR * air_between(displaced.w, up, towards_eye);
        out.transmitted = transmitted(air);
        out.scattered = scattered(
            air,
            dot(up, frame.sun_in_focus),
            -dot(towards_eye, frame.sun_in_focus),
        );
    }
    return out;
}

// A fragment's footprint on the ground.
struct Footprint {
    minor_rad: f32,  // size to choose levels by, as an angle at the planet's centre
    major_rad: f32,  // length of the longer axis, not below minor_rad
    major: vec2f,    // its direction: (east, south), unit length
}

// `dx`, `dy`: steps on the unit sphere to the next pixel, (east, south) in radians; `size_rad`:
// the footprint of a pixel seen at right angles.
fn footprint_of(dx: vec2f, dy: vec2f, size_rad: f32) -> Footprint {
    // Scaled to about 1, since squares of squares of tiny angles leave the range of f32.
    let a = dx / size_rad;
    let b = dy / size_rad;
    let xx = a.x * a.x + b.x * b.x;
    let xy = a.x * a.y + b.x * b.y;
    let yy = a.y * a.y + b.y * b.y;
    let half_gap = 0.5 * (xx - yy);
    let longest = 0.5 * (xx + yy) + sqrt(half_gap * half_gap + xy * xy);
    var major = vec2f(1.0, 0.0);
    if (abs(xy) > 1e-6 * longest) {
        major = normalize(vec2f(xy, longest - xx));
    } else if (yy > xx) {
        major = vec2f(0.0, 1.0);
    }
    // A footprint cut by the horizon has no end.
    let major_rad = clamp(sqrt(longest), 1.0, {{MAX_ANISOTROPY}}) * size_rad;
    return Footprint(max(size_rad, major_rad / f32(MAX_TAPS)), major_rad, major);
}

// What the ground's textures say.
struct Ground {
    colour: vec4f,
    stereographic: vec2f, // coordinates of the unit normal
}

// Means of a level's texels along the footprint's major axis.
fn filtered(level: u32, delta: vec2f, axis: vec2f, length_rad: f32, colour: bool, normal: bool) -> Ground {
    let per_rad = clip_levels[level].samples_per_rad;
    let centre = delta * per_rad;
    // Taps spread over the part of the axis that a single bilinear tap does not cover.
    let spread_rad = max(length_rad - clip_levels[level].texel_rad, 0.0);
    let taps = clamp(ceil(length_rad / clip_levels[level].texel_rad - 0.25), 1.0, f32(MAX_TAPS));
    let layer = clip_levels[level].layer;
    var sum = Ground(vec4f(0.0), vec2f(0.0));
    for (var k = 0.5; k < taps; k += 1.0) {
        let along = (k / taps - 0.5) * spread_rad * step(1.5, taps);
        let offset = clamp(centre + axis * along * per_rad, clip_levels[level].valid_min, clip_levels[level].valid_max);
        let place = storage_of(level, offset) / frame.colour_window;
        if (colour) {
            sum.colour += textureSampleLevel(colours, wrapping, place, layer, 0.0);
        }
        if (normal) {
            sum.stereographic += textureSampleLevel(normals, wrapping, place, layer, 0.0).xy;
        }
    }
    return Ground(sum.colour / taps, sum.stereographic / taps);
}

// The levels of a choice, mixed. `chance`: 0 to 1, even over neighbouring pixels.
fn mixed(
    first: u32,
    choice: LevelChoice,
    delta: vec2f,
    footprint: Footprint,
    axis: vec2f,
    chance: f32,
    colour: bool,
    normal: bool,
) -> Ground {
    let length_rad = footprint.major_rad;
    if (!BLENDS_LEVELS) {
        let level = select(choice.fine, choice.coarse, chance < choice.coarse_weight);
        return filtered(first + level, delta, axis, length_rad, colour, normal);
    }
    var value = Ground(vec4f(0.0), vec2f(0.0));
    if (choice.coarse_weight < 1.0) {
        let fine = filtered(first + choice.fine, delta, axis, length_rad, colour, normal);
        let weight = 1.0 - choice.coarse_weight;
        value = Ground(weight * fine.colour, weight * fine.stereographic);
    }
    if (choice.coarse_weight > 0.0) {
        let coarse = filtered(first + choice.coarse, delta, axis, length_rad, colour, normal);
        let weight = choice.coarse_weight;
        value = Ground(value.colour + weight * coarse.colour, value.stereographic + weight * coarse.stereographic);
    }
    return value;
}

@fragment
fn terrain_fragment(in: Varyings) -> @location(0) vec4f {
    // Steps to the next pixel come from the vector, which unlike the map coordinates jumps nowhere.
    let step_x = dpdx(in.vertex);
    let step_y = dpdy(in.vertex);

    let sin_cos = frame.sin_cos_colat;
    let delta = map_delta(in.vertex, sin_cos);
    let place = meridian_of(in.vertex, sin_cos);
    let up = normalize(vec3f(place.px, in.vertex.y, place.pz));
    let rho = max(place.rho, 1e-12);
    let east = select(vec3f(-in.vertex.y, place.px, 0.0) / rho, vec3f(0.0, 1.0, 0.0), place.rho < 1e-12);
    let north = cross(up, east);

    let turned_x = meridian_from_focus(vec3f(step_x.xy, -step_x.z), sin_cos);
    let turned_y = meridian_from_focus(vec3f(step_y.xy, -step_y.z), sin_cos);
    let depth_m = max(in.depth_m, 1e-3);
    let footprint = footprint_of(
        vec2f(dot(turned_x, east), -dot(turned_x, north)),
        vec2f(dot(turned_y, east), -dot(turned_y, north)),
        depth_m * frame.pixel_rad / (frame.radius_m + in.height_m),
    );
    // The axis in map radians; a quarter turn at most, at a pole itself.
    let axis = vec2f(footprint.major.x / max(rho, footprint.major_rad), footprint.major.y);

    let chance = pixel_noise(in.position.xy);
    var colour = vec4f(0.0);
    var normal = up;
    if (HAS_COLOUR) {
        let stack = LevelStack({{COLOUR_SLOT}}u, frame.colour_levels);
        let choice = colour_level_for(stack, footprint.minor_rad, delta);
        if (choice.fine != NO_LEVEL) {
            let read = mixed(stack.first, choice, delta, footprint, axis, chance, true, SHARED_LEVELS);
            colour = read.colour;
            if (SHARED_LEVELS) {
                normal = ground_normal(read.stereographic, east, north, up);
            }
        }
    }
    if (HAS_NORMALS && !SHARED_LEVELS) {
        let stack = LevelStack({{NORMAL_SLOT}}u, frame.normal_levels);
        let choice = colour_level_for(stack, footprint.minor_rad, delta);
        if (choice.fine != NO_LEVEL) {
            let read = mixed(stack.first, choice, delta, footprint, axis, chance, false, true);
            normal = ground_normal(read.stereographic, east, north, up);
        }
    }

    var ground = mix(BARE_GROUND, colour.rgb, colour.a);
    if (HAS_NORMALS) {
        ground *= lit(normal, up, meridian_from_focus(frame.sun_in_focus, sin_cos));
    }
    if (HAS_HAZE) {
        ground = ground * in.transmitted + in.scattered;
    }
    return to_pixel(ground, in.position.xy);
}
