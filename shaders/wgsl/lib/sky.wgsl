// lib/sky.wgsl: library, no entry point, no bindings.
// An exponential atmosphere around a sphere: how much air lies along a ray, what it lets through
// and what light it adds. Terrain and sky use the same functions, so they meet at the horizon.
// Spaces: heights in metres above the sphere; `up` = cosine between a ray and the local vertical.
// Needs:  the entry declares `frame: Frame`.
// Source: optical depth after Chapman, with Ren and MacKenzie's closed form of erfc (2007, error
//         below 1 %); single scattering of a white sun whose light fades at the terminator.

// Light scattered out of a ray per vertical air mass, red, green, blue (Earth's clear air).
const SCATTER: vec3f = vec3f(0.050, 0.108, 0.245);
// Haze that whitens the lowest air, per vertical air mass, all colours alike.
const HAZE_SCATTER: f32 = 0.012;
const SUN_RADIUS_RAD: f32 = 0.0075;

// exp(x^2) erfc(x) for x >= 0.
fn scaled_erfc(x: f32) -> f32 {
    let root = 1.7724539 * x;
    return 2.911 / (1.911 * root + sqrt(root * root + 8.473921));
}

// Air from a point outward to infinity along a ray that does not descend (up >= 0), in units of
// the vertical column at the datum.
fn rising_air(height_m: f32, up: f32) -> f32 {
    let x = (frame.radius_m + height_m) / frame.scale_height_m;
    let density = exp(-max(height_m, -4.0 * frame.scale_height_m) / frame.scale_height_m);
    return density * sqrt(1.5707964 * x) * scaled_erfc(sqrt(0.5 * x) * up);
}

// Height of the lowest point of the ray's whole line.
fn lowest_height(height_m: f32, up: f32) -> f32 {
    let r = frame.radius_m + height_m;
    return height_m - r * up * up / (1.0 + sqrt(max(1.0 - up * up, 0.0)));
}

// Air from a point outward to infinity in any direction; a ray that descends is not stopped by the
// ground.
fn air_to_space(height_m: f32, up: f32) -> f32 {
    if (up >= 0.0) {
        return rising_air(height_m, up);
    }
    let lowest = max(lowest_height(height_m, up), -4.0 * frame.scale_height_m);
    return 2.0 * rising_air(lowest, 0.0) - rising_air(height_m, -up);
}

// What of the light of `air` columns arrives.
fn transmitted(air: f32) -> vec3f {
    return exp(-(SCATTER + HAZE_SCATTER) * air * frame.haze);
}

// Colour and strength of sunlight in the air at a place with the sun's elevation cosine `sun_up`:
// white by day, red at the terminator, gone at night.
fn sun_in_air(sun_up: f32) -> vec3f {
    let day = smoothstep(-0.16, 0.12, sun_up);
    let low = exp(-max(sun_up + 0.06, 0.0) * 11.0);
    return day * mix(vec3f(1.0), vec3f(1.0, 0.62, 0.36), low);
}

// Light that the air along a ray adds, for a ray through `air` columns whose lowest place has the
// sun at `sun_up`, seen `towards_sun` (cosine) from it.
fn scattered(air: f32, sun_up: f32, towards_sun: f32) -> vec3f {
    let lit = sun_in_air(sun_up);
    let forward = pow(max(towards_sun, 0.0), 12.0);
    let glow = 1.0 + 0.35 * forward * exp(-2.0 * max(sun_up, 0.0));
    let white = vec3f(0.80, 0.90, 1.0) * 0.92;
    return lit * white * glow * (1.0 - transmitted(air));
}

// Part of the air's scattering that is shown before ground: imagery from space was taken through
// the same air already. At the horizon both saturate, so ground and sky still meet there.
const GROUND_AIR: f32 = 0.45;

// Air between the eye and a place `height_m` above the sphere, in columns. `towards_eye`: unit
// vector from the place.
fn air_between(height_m: f32, up: vec3f, towards_eye: vec3f) -> f32 {
    let up_here = dot(up, towards_eye);
    let up_at_eye = dot(frame.eye_up_in_focus, towards_eye);
    var air = 0.0;
    if (up_at_eye < 0.0) {
        // The place is higher: count from the eye, where the air is denser.
        air = air_to_space(frame.altitude_m, -up_at_eye) - air_to_space(height_m, -up_here);
    } else {
        air = air_to_space(height_m, up_here) - air_to_space(frame.altitude_m, up_at_eye);
    }
    return max(air, 0.0);
}
