// lib/light.wgsl: library, no entry point, no bindings.
// Light of the sun and the sky on the ground, and how linear light becomes a pixel.
// Spaces: *_in_meridian = Cartesian, x away from the axis on the focus' meridian, y east at the
//         focus, z north along the axis.
// Needs:  the entry declares `frame: Frame`.

// A direction in focus space (south, east, up) turned into meridian space.
fn meridian_from_focus(direction: vec3f, sin_cos_colat: vec2f) -> vec3f {
    let s = sin_cos_colat.x;
    let c = sin_cos_colat.y;
    return vec3f(s * direction.z + c * direction.x, direction.y, c * direction.z - s * direction.x);
}

// Unit normal of the ground from its stereographic coordinates, (east, north) / (1 + up), steepened
// with the heights.
fn ground_normal(stereographic: vec2f, east: vec3f, north: vec3f, up: vec3f) -> vec3f {
    // Means of coordinates lie within the unit disc; only what rounds beyond it would overhang.
    let upward = max(1.0 - dot(stereographic, stereographic), 0.0);
    let tilt = 2.0 * stereographic * frame.exaggeration;
    // Nothing is left of a wall that is drawn without height.
    return normalize(east * tilt.x + north * tilt.y + up * max(upward, 1e-6));
}

// Factor on the ground's colour. Level ground under a high sun gets 1, so imagery keeps its look.
fn lit(normal: vec3f, up: vec3f, sun: vec3f) -> vec3f {
    let sun_up = dot(up, sun);
    // The sun sets where the planet hides it, not where a slope still faces it.
    let above_horizon = smoothstep(-0.05, 0.10, sun_up);
    let direct = max(dot(normal, sun), 0.0) * above_horizon;
    let warm = mix(vec3f(1.0, 0.72, 0.50), vec3f(1.0), smoothstep(0.0, 0.35, sun_up));
    let open_sky = 0.6 + 0.4 * dot(normal, up);
    let day = 0.04 + 0.96 * smoothstep(-0.20, 0.15, sun_up);
    return (1.0 - frame.ambient) * 1.30 * direct * warm
        + frame.ambient * open_sky * day * vec3f(0.92, 0.97, 1.08);
}

// Display value of linear light, sRGB encoded.
fn encode_srgb(linear: vec3f) -> vec3f {
    let low = linear * 12.92;
    let high = 1.055 * pow(max(linear, vec3f(0.0031308)), vec3f(1.0 / 2.4)) - 0.055;
    return select(high, low, linear <= vec3f(0.0031308));
}

// Linear light of a display value that is sRGB encoded.
fn decode_srgb(encoded: vec3f) -> vec3f {
    let low = encoded / 12.92;
    let high = pow((encoded + 0.055) / 1.055, vec3f(2.4));
    return select(high, low, encoded <= vec3f(0.04045));
}

// Keeps bright light inside the display's range: the identity below 0.8, then a shoulder.
fn shoulder(linear: vec3f) -> vec3f {
    let over = max(linear - 0.8, vec3f(0.0));
    return min(linear, vec3f(0.8)) + over / (1.0 + over / 0.2);
}

// Noise from 0 to 1 that depends on the pixel only, even over any few neighbours.
fn pixel_noise(pixel: vec2f) -> f32 {
    return fract(52.9829189 * fract(dot(floor(pixel), vec2f(0.06711056, 0.00583715))));
}

// Half a quantum of noise, so that skies show no bands.
fn dither(pixel: vec2f) -> f32 {
    return (pixel_noise(pixel) - 0.5) / 255.0;
}

// The pixel for linear light: display range, sRGB encoded by hand, dithered.
fn to_pixel(linear: vec3f, pixel: vec2f) -> vec4f {
    return vec4f(encode_srgb(shoulder(linear)) + dither(pixel), 1.0);
}
