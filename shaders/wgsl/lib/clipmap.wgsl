// lib/clipmap.wgsl: library, no entry point, no bindings.
// Which clip levels a vertex or a fragment reads, and where a sample lies in its texture.
// Spaces: offsets = samples of one level from the focus; storage = texels of the level's layer.
// Needs:  the entry declares `clip_levels: array<LevelView, LEVEL_SLOTS>`; a stack of levels is
//         `count` entries from `first`, coarse to fine.
// Twin:   core/planet/src/clipmap/choose.rs, same names and order.
// Source: [CH06] 5.2; [CH07] future work 2; explicit level as in [Cra07].

const LEVEL_SLOTS: u32 = {{LEVEL_SLOTS}}u;
const NO_LEVEL: u32 = 0xffffffffu;

// What a shader knows of one clip level in one frame; see the twin for the meaning of each field.
struct LevelView {
    focus_in_storage: vec2f,
    samples_per_rad: vec2f,
    valid_min: vec2f,
    valid_max: vec2f,
    settled_min: vec2f,
    settled_max: vec2f,
    tap_rows: vec2f,
    period: vec2f, // texels after which storage repeats, columns and rows
    fade: f32,
    edge_band: f32,
    texel_rad: f32,
    layer: u32,
}

struct LevelStack {
    first: u32,
    count: u32,
}

// Two levels to read: (1 - coarse_weight) * fine + coarse_weight * coarse. `fine` is NO_LEVEL
// where nothing is valid.
struct LevelChoice {
    fine: u32,
    coarse: u32,
    coarse_weight: f32,
}

fn contains(level: u32, offset: vec2f) -> bool {
    return all(offset >= clip_levels[level].valid_min) && all(offset <= clip_levels[level].valid_max);
}

// 0 outside a rectangle, rising linearly to 1 over `band` inside its sides.
fn rise(offset: vec2f, low: vec2f, high: vec2f, band: f32) -> f32 {
    let inside = min(offset - low, high - offset);
    return clamp(min(inside.x, inside.y) / band, 0.0, 1.0);
}

fn level_weight(level: u32, offset: vec2f) -> f32 {
    let band = clip_levels[level].edge_band;
    let valid = rise(offset, clip_levels[level].valid_min, clip_levels[level].valid_max, band);
    let settled = rise(offset, clip_levels[level].settled_min, clip_levels[level].settled_max, band);
    return max(valid * clip_levels[level].fade, min(settled, valid));
}

// Finest level no finer than `start` that may be read at `delta`.
fn finest_readable(stack: LevelStack, start: u32, delta: vec2f) -> u32 {
    var left = min(start + 1u, stack.count);
    while (left > 0u) {
        left -= 1u;
        let level = stack.first + left;
        if (contains(level, delta * clip_levels[level].samples_per_rad)) {
            return left;
        }
    }
    return NO_LEVEL;
}

fn with_coarser(stack: LevelStack, fine: u32, delta: vec2f, own_weight: f32) -> LevelChoice {
    var choice = LevelChoice(fine, fine, 0.0);
    if (own_weight < 1.0 && fine > 0u) {
        let coarse = finest_readable(stack, fine - 1u, delta);
        if (coarse != NO_LEVEL) {
            choice.coarse = coarse;
            choice.coarse_weight = 1.0 - own_weight;
        }
    }
    return choice;
}

// `level`: index of the ring's level in the stack; `rim`: 0 inside the ring to exactly 1 at its
// outer rim, where the next coarser level takes over.
fn height_level_for(stack: LevelStack, level: u32, rim: f32, delta: vec2f) -> LevelChoice {
    var start = level;
    var blend = rim;
    if (rim >= 1.0) {
        start = select(level - 1u, 0u, level == 0u);
        blend = 0.0;
    }
    let fine = finest_readable(stack, start, delta);
    if (fine == NO_LEVEL) {
        return LevelChoice(NO_LEVEL, NO_LEVEL, 0.0);
    }
    var own = level_weight(stack.first + fine, delta * clip_levels[stack.first + fine].samples_per_rad);
    if (fine == start) {
        own = min(own, 1.0 - blend);
    }
    return with_coarser(stack, fine, delta, own);
}

// Levels are consecutive. `footprint_rad`: size of the fragment as an angle at the planet's centre, positive.
fn colour_level_for(stack: LevelStack, footprint_rad: f32, delta: vec2f) -> LevelChoice {
    if (stack.count == 0u) {
        return LevelChoice(NO_LEVEL, NO_LEVEL, 0.0);
    }
    // Texels halve exactly from level to level, so the exponent of the ratio counts the levels.
    let ratio = clip_levels[stack.first].texel_rad / footprint_rad;
    var by_footprint = 0u;
    if (ratio >= 1.0) {
        by_footprint = min((bitcast<u32>(ratio) >> 23u) - 127u, stack.count - 1u);
    }
    let fine = finest_readable(stack, by_footprint, delta);
    if (fine == NO_LEVEL) {
        return LevelChoice(NO_LEVEL, NO_LEVEL, 0.0);
    }
    let level = stack.first + fine;
    var own = level_weight(level, delta * clip_levels[level].samples_per_rad);
    if (fine == by_footprint) {
        own = min(own, footprint_weight(clip_levels[level].texel_rad, footprint_rad));
    }
    return with_coarser(stack, fine, delta, own);
}

// 0 where a level's texel equals the footprint, 1 from half an octave on.
fn footprint_weight(texel_rad: f32, footprint_rad: f32) -> f32 {
    return clamp((texel_rad / footprint_rad - 1.0) / {{FOOTPRINT_BLEND_SPAN}}, 0.0, 1.0);
}

// Continuous texel position in the level's layer of a sample at `offset` from the focus: columns
// wrap with the storage's period, rows stop at the last one that may be read.
fn storage_of(level: u32, offset: vec2f) -> vec2f {
    let row = clamp(offset.y, clip_levels[level].tap_rows.x, clip_levels[level].tap_rows.y);
    let texel = clip_levels[level].focus_in_storage + vec2f(offset.x, row);
    return texel - clip_levels[level].period * floor(texel / clip_levels[level].period);
}
