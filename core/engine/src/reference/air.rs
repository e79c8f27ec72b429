//! Air and sky in f64: the same formulas as `shaders/wgsl/lib/sky.wgsl` and `sky.wgsl`.
//!
//! Spaces: world axes; heights in metres above the sphere; air in vertical columns at the datum.

use glam::DVec3;

/// Light scattered out of a ray per vertical air mass, red, green, blue.
const SCATTER: DVec3 = DVec3::new(0.050, 0.108, 0.245);
/// Haze that whitens the lowest air, per vertical air mass.
const HAZE_SCATTER: f64 = 0.012;
const SUN_RADIUS_RAD: f64 = 0.0075;
/// Part of the air's scattering that is shown before ground.
const GROUND_AIR: f64 = 0.45;
/// Scale height of Earth's air over Earth's radius; other planets' airs are scaled likewise.
const SCALE_HEIGHT_PER_RADIUS: f64 = 8_000.0 / 6_371_008.8;

/// The air around a planet, as one eye sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Air {
    radius_m: f64,
    scale_height_m: f64,
    /// Density at the datum relative to Earth's; 0 for none.
    haze: f64,
    eye_altitude_m: f64,
    eye_up: DVec3,
    /// Unit vector towards the sun.
    sun: DVec3,
}

/// What the air between the eye and a place does to its light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Veil {
    pub(super) transmitted: DVec3,
    pub(super) scattered: DVec3,
}

impl Air {
    /// Air of a density around a sphere, seen from `eye` in world metres.
    pub(super) fn new(radius_m: f64, haze: f64, eye: DVec3, sun: DVec3) -> Self {
        Self {
            radius_m,
            scale_height_m: radius_m * SCALE_HEIGHT_PER_RADIUS,
            haze: haze.clamp(0.0, 8.0),
            eye_altitude_m: eye.length() - radius_m,
            eye_up: eye.normalize_or(DVec3::Z),
            sun,
        }
    }

    /// Before a place of the ground `height_m` above the sphere; `direction` is the ray's, of unit
    /// length.
    pub(super) fn before(&self, height_m: f64, up: DVec3, direction: DVec3) -> Veil {
        if self.haze <= 0.0 {
            return Veil {
                transmitted: DVec3::ONE,
                scattered: DVec3::ZERO,
            };
        }
        let air = GROUND_AIR * self.between(height_m, up, -direction);
        Veil {
            transmitted: self.transmitted(air),
            scattered: self.scattered(air, up.dot(self.sun), direction.dot(self.sun)),
        }
    }

    /// Linear light of the sky in a direction of unit length.
    pub(super) fn sky(&self, ray: DVec3) -> DVec3 {
        let sun_angle = (ray - self.sun).length();
        let disc = 1.0 - smoothstep(0.85 * SUN_RADIUS_RAD, SUN_RADIUS_RAD, sun_angle);
        let mut sun = DVec3::new(12.0, 11.6, 11.0);
        let mut light = DVec3::ZERO;
        if self.haze > 0.0 {
            let up = ray.dot(self.eye_up);
            let lowest_up = if up < 0.0 {
                (self.eye_up - ray * up).normalize_or(self.eye_up)
            } else {
                self.eye_up
            };
            let sun_up = lowest_up.dot(self.sun);
            let air = self.out_to_space(self.eye_altitude_m, up);
            light = self.scattered(air, sun_up, ray.dot(self.sun));
            sun *= self.transmitted(air);
            let near = libm::exp(-18.0 * sun_angle) * 0.35;
            light += near * sun_in_air(sun_up) * (DVec3::ONE - self.transmitted(0.6 * air));
        }
        light + disc * sun
    }

    fn rising(&self, height_m: f64, up: f64) -> f64 {
        let x = (self.radius_m + height_m) / self.scale_height_m;
        let height_m = height_m.max(-4.0 * self.scale_height_m);
        let density = libm::exp(-height_m / self.scale_height_m);
        density * (core::f64::consts::FRAC_PI_2 * x).sqrt() * scaled_erfc((0.5 * x).sqrt() * up)
    }

    fn lowest_height(&self, height_m: f64, up: f64) -> f64 {
        let r = self.radius_m + height_m;
        height_m - r * up * up / (1.0 + (1.0 - up * up).max(0.0).sqrt())
    }

    fn out_to_space(&self, height_m: f64, up: f64) -> f64 {
        if up >= 0.0 {
            return self.rising(height_m, up);
        }
        let lowest = self
            .lowest_height(height_m, up)
            .max(-4.0 * self.scale_height_m);
        2.0 * self.rising(lowest, 0.0) - self.rising(height_m, -up)
    }

    fn between(&self, height_m: f64, up: DVec3, towards_eye: DVec3) -> f64 {
        let up_here = up.dot(towards_eye);
        let up_at_eye = self.eye_up.dot(towards_eye);
        let air = if up_at_eye < 0.0 {
            self.out_to_space(self.eye_altitude_m, -up_at_eye)
                - self.out_to_space(height_m, -up_here)
        } else {
            self.out_to_space(height_m, up_here) - self.out_to_space(self.eye_altitude_m, up_at_eye)
        };
        air.max(0.0)
    }

    fn transmitted(&self, air: f64) -> DVec3 {
        ((SCATTER + HAZE_SCATTER) * (-air * self.haze)).map(libm::exp)
    }

    fn scattered(&self, air: f64, sun_up: f64, towards_sun: f64) -> DVec3 {
        let forward = libm::pow(towards_sun.max(0.0), 12.0);
        let glow = 1.0 + 0.35 * forward * libm::exp(-2.0 * sun_up.max(0.0));
        let white = DVec3::new(0.80, 0.90, 1.0) * 0.92;
        sun_in_air(sun_up) * white * glow * (DVec3::ONE - self.transmitted(air))
    }
}

/// exp(x²) erfc(x) for x ≥ 0, Ren and MacKenzie's closed form, which is part of the picture's
/// definition: the reference shows the same air, not a better one.
fn scaled_erfc(x: f64) -> f64 {
    let root = 1.772_453_9 * x;
    2.911 / (1.911 * root + (root * root + 8.473_921).sqrt())
}

fn sun_in_air(sun_up: f64) -> DVec3 {
    let day = smoothstep(-0.16, 0.12, sun_up);
    let low = libm::exp(-(sun_up + 0.06).max(0.0) * 11.0);
    day * DVec3::ONE.lerp(DVec3::new(1.0, 0.62, 0.36), low)
}

/// As WGSL's: 0 below `low`, 1 above `high`, smooth between.
pub(super) fn smoothstep(low: f64, high: f64, x: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
