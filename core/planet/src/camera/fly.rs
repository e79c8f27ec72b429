//! The flying camera: keys steer a velocity that a critically damped spring brings to its target.
//!
//! The spring is solved in closed form and the way over the sphere to fourth order on fixed small
//! panels, so that a path does not depend on how frames cut it.

use glam::{DQuat, DVec2, DVec3};

use super::{Camera, MAX_ALTITUDE_M, MIN_HEIGHT_M};
use crate::Planet;

/// Stiffness of the spring in 1/s: the velocity is within 2 % of its target after 0.73 s.
const SPRING_PER_S: f64 = 8.0;

/// Level speed at full deflection: heights above the ground per second.
const LEVEL_SPEED_PER_S: f64 = 1.5;

/// Climb at full deflection: natural logarithm of the height per second.
const CLIMB_PER_S: f64 = 1.0;

/// Longest part of a frame that is integrated at once, seconds.
const PANEL_S: f64 = 1.0 / 240.0;

/// Longest frame that is followed, seconds; a longer one counts as this.
const LONGEST_FRAME_S: f64 = 60.0;

/// What the keys ask for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlyInput {
    /// To the right (D) or left (A), −1 to 1.
    pub right: f64,
    /// Ahead along the heading (W) or back (S), level, −1 to 1.
    pub forward: f64,
    /// Climb (E) or descend (Q), −1 to 1.
    pub up: f64,
    /// Factor on all speeds, 0 to 100; 1 is usual.
    pub boost: f64,
}

impl Default for FlyInput {
    fn default() -> Self {
        Self {
            right: 0.0,
            forward: 0.0,
            up: 0.0,
            boost: 1.0,
        }
    }
}

impl FlyInput {
    /// The velocity that is asked for: (right, forward, climb) per second, in heights.
    fn target(&self) -> DVec3 {
        let unit = |x: f64| {
            if x.is_finite() {
                x.clamp(-1.0, 1.0)
            } else {
                0.0
            }
        };
        let boost = if self.boost.is_finite() {
            self.boost.clamp(0.0, 100.0)
        } else {
            1.0
        };
        let level = DVec2::new(unit(self.right), unit(self.forward)).clamp_length_max(1.0);
        (level * LEVEL_SPEED_PER_S).extend(unit(self.up) * CLIMB_PER_S) * boost
    }
}

/// The motion of a flying camera between frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fly {
    /// (right, forward, climb): heights above the ground per second; climb is d ln(height) / dt.
    velocity: DVec3,
    /// Rate of change of `velocity`, 1/s².
    acceleration: DVec3,
}

impl Fly {
    /// At rest.
    pub fn new() -> Self {
        Self::default()
    }

    /// Whether it moves or will move without further input, so that frames must go on.
    pub fn is_moving(&self) -> bool {
        self.velocity.length() > 1e-5 || self.acceleration.length() > 1e-4
    }

    /// Stops at once.
    pub fn stop(&mut self) {
        *self = Self::default();
    }

    /// The camera `frame_s` seconds later, with `input` held down all the while.
    ///
    /// - `ground_m`: height of the ground below the eye above the datum; the eye stays
    ///   [`super::MIN_HEIGHT_M`] above it and below [`MAX_ALTITUDE_M`]. Speed is in proportion to
    ///   the height above it.
    /// - `frame_s`: 0 or more; 0 changes nothing. What is not a number counts as 0.
    ///
    /// The way follows the planet's curvature and the heading is carried along it, over a pole
    /// without a spin.
    #[must_use]
    pub fn advance(
        &mut self,
        camera: &Camera,
        planet: &Planet,
        ground_m: f64,
        input: &FlyInput,
        frame_s: f64,
    ) -> Camera {
        if !(frame_s > 0.0 && ground_m.is_finite()) {
            return *camera;
        }
        let frame_s = frame_s.min(LONGEST_FRAME_S);
        let target = input.target();
        let panels = (frame_s / PANEL_S).ceil().max(1.0);
        let panel_s = frame_s / panels;
        let highest = libm::log((MAX_ALTITUDE_M - ground_m).max(MIN_HEIGHT_M));
        let lowest = libm::log(MIN_HEIGHT_M);
        let mut log_height = libm::log((camera.altitude_m - ground_m).max(MIN_HEIGHT_M));
        let mut climbs = false;
        let mut turn = DQuat::IDENTITY;
        for _ in 0..panels as u32 {
            let spring = Spring {
                from: *self,
                target,
            };
            // Rotation rate of the (right, forward, up) frame in itself at a time in the panel.
            let rate = |time_s: f64| {
                let height_m =
                    libm::exp((log_height + spring.way(time_s).z).clamp(lowest, highest));
                let eye_m = (planet.radius_m + ground_m + height_m).max(height_m);
                let velocity = spring.state(time_s).velocity * (height_m / eye_m);
                DVec3::new(-velocity.y, velocity.x, 0.0)
            };
            // Magnus to fourth order on the two Gauss nodes.
            let node = 0.5 / 3.0_f64.sqrt();
            let (a, b) = (rate((0.5 - node) * panel_s), rate((0.5 + node) * panel_s));
            let commutator = a.cross(b) * (3.0_f64.sqrt() / 12.0 * panel_s * panel_s);
            turn *= DQuat::from_scaled_axis((a + b) * (panel_s / 2.0) + commutator);
            let climb = spring.way(panel_s).z;
            climbs |= climb != 0.0;
            log_height = (log_height + climb).clamp(lowest, highest);
            *self = spring.state(panel_s);
        }
        self.settle();
        let altitude_m = if climbs {
            super::clamp_altitude(ground_m + libm::exp(log_height), ground_m)
        } else {
            super::clamp_altitude(camera.altitude_m, ground_m)
        };
        if turn == DQuat::IDENTITY {
            return Camera {
                altitude_m,
                ..*camera
            };
        }
        let local = camera.local_frame();
        let (sin_h, cos_h) = libm::sincos(camera.heading_rad);
        let right = cos_h * local.east - sin_h * local.north;
        let forward = sin_h * local.east + cos_h * local.north;
        let world = |body: DVec3| body.x * right + body.y * forward + body.z * local.up;
        let turn = turn.normalize();
        camera.with_frame(world(turn * DVec3::Z), world(turn * DVec3::X), altitude_m)
    }

    /// Forgets motion too small to see in any number of frames.
    fn settle(&mut self) {
        if self.velocity.length() < 1e-12 && self.acceleration.length() < 1e-11 {
            self.stop();
        }
    }
}

/// A critically damped spring towards a constant target velocity.
struct Spring {
    from: Fly,
    target: DVec3,
}

impl Spring {
    /// Coefficients of v(t) = target + (c₁ + c₂ t) e^(−ωt).
    fn coefficients(&self) -> (DVec3, DVec3) {
        let c1 = self.from.velocity - self.target;
        (c1, self.from.acceleration + SPRING_PER_S * c1)
    }

    /// Velocity and acceleration after `time_s`.
    fn state(&self, time_s: f64) -> Fly {
        let (c1, c2) = self.coefficients();
        let decay = libm::exp(-SPRING_PER_S * time_s);
        let rest = (c1 + c2 * time_s) * decay;
        Fly {
            velocity: self.target + rest,
            acceleration: c2 * decay - SPRING_PER_S * rest,
        }
    }

    /// Integral of the velocity over 0 to `time_s`.
    fn way(&self, time_s: f64) -> DVec3 {
        let (c1, c2) = self.coefficients();
        let x = SPRING_PER_S * time_s;
        let lost = -libm::expm1(-x);
        let lost_twice = lost - x * libm::exp(-x);
        self.target * time_s
            + c1 * (lost / SPRING_PER_S)
            + c2 * (lost_twice / (SPRING_PER_S * SPRING_PER_S))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::tests::{cameras, is_sane, planets};
    use super::*;

    fn inputs() -> impl Strategy<Value = FlyInput> {
        let axis = || prop_oneof![Just(0.0), Just(1.0), Just(-1.0), -1.0..1.0];
        (axis(), axis(), axis(), 0.1..4.0).prop_map(|(right, forward, up, boost)| FlyInput {
            right,
            forward,
            up,
            boost,
        })
    }

    fn moving() -> impl Strategy<Value = Fly> {
        (-2.0..2.0, -2.0..2.0, -1.0..1.0).prop_map(|(x, y, z)| Fly {
            velocity: DVec3::new(x, y, z),
            acceleration: DVec3::new(z, x, y),
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn a_path_does_not_depend_on_how_frames_cut_it(
            planet in planets(), camera in cameras(), fly in moving(), input in inputs(),
            seconds in 0.01..10.0, frames in 2..200_u32,
        ) {
            let (mut one, mut many) = (fly, fly);
            let at_once = one.advance(&camera, &planet, 0.0, &input, seconds);
            let mut cut = camera;
            for _ in 0..frames {
                cut = many.advance(&cut, &planet, 0.0, &input, seconds / f64::from(frames));
            }
            prop_assert!((one.velocity - many.velocity).length() < 1e-9);
            let reached = [cut, at_once].iter().any(|c| c.altitude_m >= MAX_ALTITUDE_M || c.altitude_m <= MIN_HEIGHT_M);
            if !reached && (10.0..1e7).contains(&camera.altitude_m) {
                prop_assert!((at_once.altitude_m / cut.altitude_m - 1.0).abs() < 1e-9);
                prop_assert!((at_once.local_frame().up - cut.local_frame().up).length() < 1e-6);
                prop_assert!((at_once.axes().right - cut.axes().right).length() < 1e-6);
            }
        }

        #[test]
        fn no_frame_time_leaves_the_limits(
            planet in planets(), camera in cameras(), fly in moving(), input in inputs(),
            seconds in prop_oneof![Just(0.0), Just(1e-3), Just(10.0), Just(1e9), Just(f64::NAN), Just(-1.0)],
            ground_m in prop_oneof![Just(0.0), Just(-400.0), Just(8000.0)],
        ) {
            let mut fly = fly;
            let after = fly.advance(&camera, &planet, ground_m, &input, seconds);
            prop_assert!(is_sane(&after) && fly.velocity.is_finite());
            if seconds > 0.0 {
                prop_assert!(after.altitude_m >= ground_m + MIN_HEIGHT_M && after.altitude_m <= MAX_ALTITUDE_M);
            } else {
                prop_assert_eq!(after, camera);
            }
        }

        #[test]
        fn without_input_it_comes_to_rest(camera in cameras(), fly in moving()) {
            let mut fly = fly;
            let first = fly.advance(&camera, &Planet::EARTH, 0.0, &FlyInput::default(), 10.0);
            prop_assert!(!fly.is_moving());
            let later = fly.advance(&first, &Planet::EARTH, 0.0, &FlyInput::default(), 10.0);
            prop_assert!(later.eye(&Planet::EARTH).distance(first.eye(&Planet::EARTH)) < 1e-6 * first.altitude_m.max(1.0));
        }
    }

    #[test]
    fn over_the_pole_the_view_goes_straight_on() {
        let camera = Camera::from_degrees(20.0, 89.99, 1000.0, 0.0, -10.0, 60.0).expect("valid");
        let mut fly = Fly::new();
        let input = FlyInput {
            forward: 1.0,
            ..FlyInput::default()
        };
        let mut at = camera;
        for _ in 0..600 {
            let before = at.axes();
            at = fly.advance(&at, &Planet::EARTH, 0.0, &input, 1.0 / 240.0);
            assert!((at.axes().right - before.right).length() < 1e-5, "{at:?}");
        }
        assert!(
            at.map_point().colat_rad > 0.0 && libm::cos(at.heading_rad) < -0.99,
            "now it flies south"
        );
        assert!(
            (camera.axes().right - at.axes().right).length() < 1e-9,
            "on one great circle"
        );
    }

    #[test]
    fn speed_is_in_proportion_to_the_height() {
        let way = |altitude: f64| {
            let camera = Camera::from_degrees(0.0, 0.0, altitude, 90.0, 0.0, 60.0).expect("valid");
            let mut fly = Fly::new();
            let input = FlyInput {
                forward: 1.0,
                ..FlyInput::default()
            };
            let after = fly.advance(&camera, &Planet::EARTH, 0.0, &input, 2.0);
            after.map_point().angle_to(camera.map_point()) * (Planet::EARTH.radius_m + altitude)
        };
        assert!((way(1000.0) / way(10.0) - 100.0).abs() < 0.01);
    }
}
