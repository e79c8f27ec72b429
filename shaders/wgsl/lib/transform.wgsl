// lib/transform.wgsl: library, no entry point, no bindings.
// From a vertex of the static rings to its place on the map, relative to the focus.
// Spaces: (u, v, 1 - w) = point of the unit sphere in focus space, u south, v east; results in
//         radians of longitude and colatitude from the focus.
// Twin:   core/planet/src/transform.rs, same names and order; app/gpu/tests/transform_on_device.rs.
// Source: derived in core/planet/src/transform.rs; replaces [CH06] 4.2 and its approximation.

// Arc tangent of 0 <= t <= 1, radians: minimax polynomial, because drivers' own atan is only good
// to 4e-6 (22 m on Earth).
fn atan_poly(t: f32) -> f32 {
    let s = t * t;
    return t * ({{ATAN_0}} + s * ({{ATAN_1}} + s * ({{ATAN_2}} + s * ({{ATAN_3}} + s * ({{ATAN_4}}
        + s * ({{ATAN_5}} + s * ({{ATAN_6}} + s * ({{ATAN_7}} + s * {{ATAN_8}}))))))));
}

// Angle of (x, y) from +x, radians, -pi to pi; 0 for (0, 0).
fn atan2_poly(y: f32, x: f32) -> f32 {
    let ax = abs(x);
    let ay = abs(y);
    let largest = max(ax, ay);
    let smallest = min(ax, ay);
    var r = atan_poly(smallest / max(largest, 1e-37));
    if (ay > ax) {
        r = 1.57079637 - r;
    }
    if (x < 0.0) {
        r = 3.14159274 - r;
    }
    return select(r, -r, y < 0.0);
}

// A point of the sphere with respect to the planet's axis, in the frame turned about the focus'
// east axis so that its third axis runs through the north pole.
struct Meridian {
    px: f32,  // towards the focus' meridian, away from the axis
    pz: f32,  // along the axis, north
    rho: f32, // distance from the axis
}

// `vertex`: (u, v, 1 - w); `sin_cos_colat`: (s, c) of the focus.
fn meridian_of(vertex: vec3f, sin_cos_colat: vec2f) -> Meridian {
    let s = sin_cos_colat.x;
    let c = sin_cos_colat.y;
    let w = 1.0 - vertex.z;
    let px = s * w + c * vertex.x;
    let pz = c * w - s * vertex.x;
    let rho = sqrt(px * px + vertex.y * vertex.y);
    return Meridian(px, pz, rho);
}

// (longitude, colatitude) of a vertex minus those of the focus, radians. Subtracts nothing of like
// size: good to 5e-7 of the ring's radius at every level and colatitude.
// The vertex need not have length 1: only its direction from the planet's centre matters.
fn map_delta(vertex: vec3f, sin_cos_colat: vec2f) -> vec2f {
    let s = sin_cos_colat.x;
    let c = sin_cos_colat.y;
    let p = meridian_of(vertex, sin_cos_colat);
    var d = p.rho - p.px;
    if (p.px > 0.0) {
        d = vertex.y * vertex.y / (p.rho + p.px);
    }
    return vec2f(
        atan2_poly(vertex.y, p.px),
        atan2_poly(vertex.x + c * d, p.rho * s + p.pz * c),
    );
}
