// lib/classic.wgsl: library, no entry point, no bindings.
// The map transforms that [CH06] prints, for measurements only: nothing that draws uses them.
// Spaces: as lib/transform.wgsl.
// Twin:   core/planet/src/transform/classic.rs, same names and order.
// Source: [CH06] 4.2, eq. 4, 11 and 14.

#import lib/transform

struct ClassicFocus {
    sin_cos_colat: vec2f,
    colat_rad: f32,
    distortion: f32,
}

// Eq. 4 with the driver's functions.
fn map_delta_printed(vertex: vec3f, focus: ClassicFocus) -> vec2f {
    let p = meridian_of(vertex, focus.sin_cos_colat);
    return vec2f(atan2(vertex.y, p.px), acos(clamp(p.pz, -1.0, 1.0)) - focus.colat_rad);
}

// The same with the polynomial; acos(pz) as the angle of (pz, rho).
fn map_delta_printed_poly(vertex: vec3f, focus: ClassicFocus) -> vec2f {
    let p = meridian_of(vertex, focus.sin_cos_colat);
    return vec2f(atan2_poly(vertex.y, p.px), atan2_poly(p.rho, p.pz) - focus.colat_rad);
}

// Eq. 11 and 14.
fn map_delta_approximate(vertex: vec3f, focus: ClassicFocus) -> vec2f {
    return vec2f(vertex.y * focus.distortion, vertex.x);
}

// How much of the approximation is used: 1 up to pi / 1024 from the focus, 0 from pi / 512 and
// within pi / 48 of a pole.
fn approximation_share(vertex: vec3f, focus: ClassicFocus) -> f32 {
    let from_pole = min(focus.colat_rad, 3.14159274 - focus.colat_rad);
    if (from_pole < 0.0654498488) {
        return 0.0;
    }
    let angle_rad = sqrt(2.0 * vertex.z);
    return clamp(2.0 - angle_rad / 0.00306796166, 0.0, 1.0);
}

// Eq. 4 outside, eq. 11 and 14 inside, blended between.
fn map_delta_blended(vertex: vec3f, focus: ClassicFocus) -> vec2f {
    let share = approximation_share(vertex, focus);
    if (share >= 1.0) {
        return map_delta_approximate(vertex, focus);
    }
    let printed = map_delta_printed(vertex, focus);
    if (share <= 0.0) {
        return printed;
    }
    return printed + (map_delta_approximate(vertex, focus) - printed) * share;
}

// The same with the polynomial.
fn map_delta_blended_poly(vertex: vec3f, focus: ClassicFocus) -> vec2f {
    let share = approximation_share(vertex, focus);
    if (share >= 1.0) {
        return map_delta_approximate(vertex, focus);
    }
    let printed = map_delta_printed_poly(vertex, focus);
    if (share <= 0.0) {
        return printed;
    }
    return printed + (map_delta_approximate(vertex, focus) - printed) * share;
}

// lib/transform's form with the driver's arc tangent.
fn map_delta_builtin(vertex: vec3f, sin_cos_colat: vec2f) -> vec2f {
    let s = sin_cos_colat.x;
    let c = sin_cos_colat.y;
    let p = meridian_of(vertex, sin_cos_colat);
    var d = p.rho - p.px;
    if (p.px > 0.0) {
        d = vertex.y * vertex.y / (p.rho + p.px);
    }
    return vec2f(
        atan2(vertex.y, p.px),
        atan2(vertex.x + c * d, p.rho * s + p.pz * c),
    );
}
