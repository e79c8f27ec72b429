//! An animated journey from one view to another.
//!
//! Height and way over ground follow the path of van Wijk and Nuij, "Smooth and efficient zooming
//! and panning" (2003): it climbs no higher than pays and looks equally fast throughout. The
//! camera is a function of the time since the start alone, so that frame times play no part.

use glam::{DQuat, DVec3};

use super::{Camera, MIN_HEIGHT_M, clamp_altitude, clamp_pitch};
use crate::Planet;

/// ρ of van Wijk and Nuij: how much zooming costs against panning; √2 is what their users chose.
const RHO: f64 = core::f64::consts::SQRT_2;

/// Seconds per unit of the path's length.
const SECONDS_PER_LENGTH: f64 = 0.45;

/// Shortest and longest journey in seconds.
const DURATION_S: (f64, f64) = (0.4, 6.0);

/// A journey between two cameras.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GoTo {
    from: Camera,
    to: Camera,
    from_ground_m: f64,
    to_ground_m: f64,
    /// Axis and angle of the great circle.
    axis: DVec3,
    angle_rad: f64,
    /// Turn about the vertical left at the end when the heading is carried along the way.
    turn_rad: f64,
    path: ZoomPath,
    duration_s: f64,
}

impl GoTo {
    /// The journey between two views.
    ///
    /// - `from_ground_m`, `to_ground_m`: height of the ground below each above the datum; the
    ///   path is made from heights above it. Higher ground between them is the caller's to mind
    ///   with [`Camera::above_ground`].
    pub fn new(
        planet: &Planet,
        from: Camera,
        from_ground_m: f64,
        to: Camera,
        to_ground_m: f64,
    ) -> Self {
        let (up_from, up_to) = (from.local_frame().up, to.local_frame().up);
        let cross = up_from.cross(up_to);
        let angle_rad = libm::atan2(cross.length(), up_from.dot(up_to));
        // To the antipode, or on the spot, every great circle is as short: straight ahead.
        let axis = if cross.length() > 1e-12 {
            cross.normalize()
        } else {
            from.axes().right * -1.0
        };
        let carried = DQuat::from_axis_angle(axis, angle_rad) * from.axes().right;
        let right = to.axes().right;
        let turn_rad = libm::atan2(carried.cross(right).dot(up_to), carried.dot(right));
        let path = ZoomPath::new(
            from.altitude_m - from_ground_m,
            to.altitude_m - to_ground_m,
            angle_rad * planet.radius_m,
        );
        let (shortest, longest) = DURATION_S;
        let duration_s = if from == to {
            0.0
        } else {
            (path.length * SECONDS_PER_LENGTH).clamp(shortest, longest)
        };
        Self {
            from,
            to,
            from_ground_m,
            to_ground_m,
            axis,
            angle_rad,
            turn_rad,
            path,
            duration_s,
        }
    }

    /// How long it takes, seconds.
    pub fn duration_s(&self) -> f64 {
        self.duration_s
    }

    /// Whether the journey has ended `time_s` seconds after its start.
    pub fn is_over(&self, time_s: f64) -> bool {
        time_s >= self.duration_s
    }

    /// The camera `time_s` seconds after the start: exactly the first view up to 0, exactly the
    /// last from [`Self::duration_s`] on. What is not a number counts as 0.
    pub fn at(&self, time_s: f64) -> Camera {
        if self.is_over(time_s) {
            return self.to;
        }
        if time_s.is_nan() || time_s <= 0.0 {
            return self.from;
        }
        let x = time_s / self.duration_s;
        let share = x * x * (3.0 - 2.0 * x);
        let (way, height_m) = self.path.at(share);
        let ground_m = self.from_ground_m + (self.to_ground_m - self.from_ground_m) * way;
        let rotation = DQuat::from_axis_angle(self.axis, self.angle_rad * way);
        let up = rotation * self.from.local_frame().up;
        let right =
            DQuat::from_axis_angle(up, self.turn_rad * share) * (rotation * self.from.axes().right);
        let mix = |from: f64, to: f64| from + (to - from) * share;
        let level = Camera {
            pitch_rad: clamp_pitch(mix(self.from.pitch_rad, self.to.pitch_rad)),
            fov_y_rad: mix(self.from.fov_y_rad, self.to.fov_y_rad),
            ..self.from
        };
        level.with_frame(up, right, clamp_altitude(ground_m + height_m, ground_m))
    }
}

/// The optimal path in the space of way over ground and height.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ZoomPath {
    from_m: f64,
    to_m: f64,
    /// Way over ground.
    way_m: f64,
    /// r₀ of the paper; `None` where there is next to no way and the path is a mere zoom.
    start: Option<f64>,
    /// Length S of the path, without unit.
    length: f64,
}

impl ZoomPath {
    fn new(from_m: f64, to_m: f64, way_m: f64) -> Self {
        let (from_m, to_m) = (from_m.max(MIN_HEIGHT_M), to_m.max(MIN_HEIGHT_M));
        let zoom = Self {
            from_m,
            to_m,
            way_m,
            start: None,
            length: (libm::log(to_m / from_m) / RHO).abs(),
        };
        // A way this short beside the height cannot be seen, and b below would only lose digits.
        if way_m < 1e-9 * from_m.max(to_m) {
            return zoom;
        }
        // b₀ and b₁ of the paper's eq. 9, written so that the difference of squares is exact.
        let squares = (to_m - from_m) * (to_m + from_m);
        let rho4_way2 = RHO.powi(4) * way_m * way_m;
        let b = |height_m: f64, sign: f64| {
            (squares + sign * rho4_way2) / (2.0 * height_m * RHO * RHO * way_m)
        };
        let (start, end) = (-libm::asinh(b(from_m, 1.0)), -libm::asinh(b(to_m, -1.0)));
        Self {
            start: Some(start),
            length: ((end - start) / RHO).max(0.0),
            ..zoom
        }
    }

    /// Share of the way (0 to 1) and height in metres at a share of the path's length.
    fn at(&self, share: f64) -> (f64, f64) {
        let Some(start) = self.start else {
            return (
                share,
                self.from_m * libm::pow(self.to_m / self.from_m, share),
            );
        };
        // cosh r₀ tanh(ρs + r₀) − sinh r₀ = sinh(ρs) / cosh(ρs + r₀): nothing cancels.
        let x = RHO * self.length * share;
        let cosh = libm::cosh(x + start);
        let way_m = self.from_m / (RHO * RHO) * (libm::sinh(x) / cosh);
        (
            (way_m / self.way_m).clamp(0.0, 1.0),
            self.from_m * (libm::cosh(start) / cosh),
        )
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::tests::{cameras, is_sane, planets};
    use super::*;

    proptest! {
        #[test]
        fn a_journey_begins_and_ends_where_it_should_without_a_jump(
            planet in planets(), from in cameras(), to in cameras(),
        ) {
            let journey = GoTo::new(&planet, from, 0.0, to, 0.0);
            prop_assert_eq!(journey.at(0.0), from);
            prop_assert_eq!(journey.at(f64::NAN), from);
            prop_assert_eq!(journey.at(journey.duration_s()), to);
            prop_assert_eq!(journey.at(1e9), to);
            for (near, end) in [(journey.at(1e-7), from), (journey.at(journey.duration_s() * (1.0 - 1e-8)), to)] {
                let scale = (end.altitude_m + 1.0) * 1e-4 + 1e-6;
                prop_assert!(near.eye(&planet).distance(end.eye(&planet)) < scale, "{near:?} {end:?}");
                prop_assert!((near.axes().right - end.axes().right).length() < 1e-5, "{near:?} {end:?}");
                prop_assert!((near.axes().forward - end.axes().forward).length() < 1e-5);
            }
        }

        #[test]
        fn every_moment_of_a_journey_is_a_sane_view(
            planet in planets(), from in cameras(), to in cameras(), share in 0.0..1.0,
            ground in (-400.0..8000.0, -400.0..8000.0),
        ) {
            let (from, to) = (from.above_ground(ground.0), to.above_ground(ground.1));
            let journey = GoTo::new(&planet, from, ground.0, to, ground.1);
            let there = journey.at(journey.duration_s() * share);
            prop_assert!(is_sane(&there));
            prop_assert!(there.altitude_m >= ground.0.min(ground.1) + 0.999 * MIN_HEIGHT_M);
            prop_assert!(there.altitude_m <= super::super::MAX_ALTITUDE_M);
        }

        #[test]
        fn the_path_meets_both_ends(
            from in 1.0..1e8, to in 1.0..1e8, exponent in -2.0..8.4_f64,
        ) {
            let path = ZoomPath::new(from, to, libm::exp10(exponent));
            let ((way_0, height_0), (way_1, height_1)) = (path.at(0.0), path.at(1.0));
            prop_assert!(way_0 < 1e-12 && (height_0 / from - 1.0).abs() < 1e-9);
            prop_assert!((way_1 - 1.0).abs() < 1e-5 && (height_1 / to - 1.0).abs() < 1e-5, "{way_1} {}", height_1 / to);
        }
    }

    #[test]
    fn a_far_journey_climbs_and_a_near_one_does_not() {
        let view = |lon, altitude| {
            Camera::from_degrees(lon, 40.0, altitude, 0.0, -60.0, 60.0).expect("valid")
        };
        let far = GoTo::new(&Planet::EARTH, view(0.0, 1e3), 0.0, view(90.0, 1e3), 0.0);
        assert!(far.at(far.duration_s() / 2.0).altitude_m > 1e6);
        let near = GoTo::new(&Planet::EARTH, view(0.0, 1e3), 0.0, view(0.001, 1e3), 0.0);
        assert!(near.at(near.duration_s() / 2.0).altitude_m < 1.1e3);
    }
}
