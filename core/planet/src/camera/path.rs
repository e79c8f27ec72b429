//! Where a camera is going, judged from where it was.
//!
//! Frame times are irregular, so that differences of consecutive positions say little. Here every
//! position has a time, and speeds are medians of the slopes between all pairs of the last moments
//! (Theil and Sen): one late frame, or one that was drawn from a late reading of the mouse, changes
//! nothing. Speeds are relative to the height above the ground: an approach that comes down
//! by a third each second, with the target fixed on the screen, is a motion at constant speed in these
//! coordinates.

use std::collections::VecDeque;

use glam::{DQuat, DVec3};

use super::Camera;
use crate::MapPoint;
use crate::map::wrap_longitude;

/// Only the last so many seconds count.
const MEMORY_S: f64 = 0.4;

/// Positions that are kept are so far apart at least; but the latest is always kept.
const APART_S: f64 = 0.03;

/// A position that is farther than this from where it was expected, in heights above the ground and
/// in what the motion explains, is a jump.
const JUMP_HEIGHTS: f64 = 3.0;

/// Slower than this, in heights a second, octaves a second or radians a second, is standing still.
const STILL: f64 = 0.01;

/// A camera at a time.
#[derive(Clone, Copy, Debug)]
struct Moment {
    time_s: f64,
    up: DVec3,
    log_height: f64,
    heading_rad: f64,
    pitch_rad: f64,
}

/// What a camera changes by in a second.
#[derive(Clone, Copy, Debug, Default)]
struct Speed {
    /// Turn of the direction from the planet's centre: axis times radians per radian of height.
    turn: DVec3,
    log_height: f64,
    heading_rad: f64,
    pitch_rad: f64,
}

/// Learns a camera's motion from its timestamped positions and continues it.
#[derive(Clone, Debug, Default)]
pub struct PathAhead {
    moments: VecDeque<Moment>,
    /// The latest camera, and its ground and its height above it in radians.
    last: Option<(Camera, f64, f64)>,
    speed: Speed,
}

impl PathAhead {
    /// Adds where the camera is.
    ///
    /// - `time_s`: any clock that runs on, in seconds. A time before the last one starts anew.
    /// - `ground_m`: height of the ground below the camera, on the scale of its altitude.
    /// - `radius_m`: the planet's.
    pub fn observe(&mut self, time_s: f64, camera: &Camera, ground_m: f64, radius_m: f64) {
        let height_rad = (camera.altitude_m - ground_m).max(0.1) / radius_m;
        let mut now = Moment {
            time_s,
            up: camera.map_point().to_unit(),
            log_height: libm::log(height_rad),
            heading_rad: camera.heading_rad,
            pitch_rad: camera.pitch_rad,
        };
        let finite = now.up.is_finite() && now.log_height.is_finite() && time_s.is_finite();
        if !finite || !(now.heading_rad + now.pitch_rad).is_finite() {
            *self = Self::default();
            return;
        }
        if let Some(before) = self.moments.back() {
            now.heading_rad =
                before.heading_rad + wrap_longitude(now.heading_rad - before.heading_rad);
            if time_s <= before.time_s || self.is_jump(before, &now) {
                self.moments.clear();
            }
        }
        self.moments.retain(|m| m.time_s >= time_s - MEMORY_S);
        let kept = self.moments.len();
        if kept >= 2 && self.moments[kept - 1].time_s - self.moments[kept - 2].time_s < APART_S {
            self.moments.pop_back();
        }
        self.moments.push_back(now);
        self.last = Some((*camera, ground_m, height_rad));
        self.speed = self.learn();
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Where the camera will be in `seconds` if it goes on; `None` while it stands still or too little
    /// is known.
    pub fn after(&self, seconds: f64) -> Option<Camera> {
        let (camera, ground_m, height_rad) = self.last?;
        let speed = self.speed;
        let fastest = speed.turn.length().max(speed.log_height.abs());
        if fastest
            .max(speed.heading_rad.abs())
            .max(speed.pitch_rad.abs())
            < STILL
        {
            return None;
        }
        // The height changes by e^(rate · t), and the way along the ground by its integral.
        let rate = speed.log_height;
        let factor = libm::exp((rate * seconds).clamp(-5.0, 5.0));
        let way = if rate.abs() * seconds < 1e-6 {
            seconds
        } else {
            (factor - 1.0) / rate
        };
        let turn = DQuat::from_scaled_axis(speed.turn * (height_rad * way));
        let up = turn * camera.map_point().to_unit();
        let point = MapPoint::from_direction(up);
        Some(Camera {
            lon_rad: point.lon_rad,
            lat_rad: point.lat_rad(),
            altitude_m: ground_m + (camera.altitude_m - ground_m) * factor,
            heading_rad: camera.heading_rad + speed.heading_rad * seconds,
            pitch_rad: (camera.pitch_rad + speed.pitch_rad * seconds)
                .clamp(-core::f64::consts::FRAC_PI_2, super::MAX_PITCH_RAD),
            ..camera
        })
    }

    /// Whether a position cannot belong to the motion so far.
    fn is_jump(&self, before: &Moment, now: &Moment) -> bool {
        let dt_s = now.time_s - before.time_s;
        let heights = turn_between(before.up, now.up).length() / libm::exp(before.log_height);
        let explained = self.speed.turn.length() * dt_s;
        let octaves = (now.log_height - before.log_height).abs();
        let explained_octaves = self.speed.log_height.abs() * dt_s;
        heights > JUMP_HEIGHTS + 3.0 * explained || octaves > 1.0 + 3.0 * explained_octaves
    }

    /// Medians of the slopes between all pairs that are not too close.
    fn learn(&self) -> Speed {
        let mut slopes: [Vec<f64>; 6] = Default::default();
        for (i, a) in self.moments.iter().enumerate() {
            for b in self.moments.range(i + 1..) {
                let dt_s = b.time_s - a.time_s;
                if dt_s < APART_S {
                    continue;
                }
                let height_rad = libm::exp(0.5 * (a.log_height + b.log_height));
                let turn = turn_between(a.up, b.up) / (height_rad * dt_s);
                let rest = [
                    b.log_height - a.log_height,
                    b.heading_rad - a.heading_rad,
                    b.pitch_rad - a.pitch_rad,
                ];
                let all = turn.to_array().into_iter().chain(rest.map(|d| d / dt_s));
                for (slope, list) in all.zip(&mut slopes) {
                    list.push(slope);
                }
            }
        }
        let [x, y, z, log_height, heading_rad, pitch_rad] = slopes.map(median);
        Speed {
            turn: DVec3::new(x, y, z),
            log_height,
            heading_rad,
            pitch_rad,
        }
    }
}

/// The shortest rotation that takes one unit vector to another: axis times angle in radians.
///
/// Along a great circle it is in proportion to the way, however long, where a difference of the
/// vectors is a chord that turns on the way.
fn turn_between(from: DVec3, to: DVec3) -> DVec3 {
    let cross = from.cross(to);
    let sin = cross.length();
    if sin == 0.0 {
        return DVec3::ZERO;
    }
    cross * (libm::atan2(sin, from.dot(to)) / sin)
}

/// The middle of some numbers, 0 for less than three: two could be anything.
fn median(mut numbers: Vec<f64>) -> f64 {
    if numbers.len() < 3 {
        return 0.0;
    }
    let middle = numbers.len() / 2;
    *numbers.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const R: f64 = 6_371_008.8;

    fn camera(lon_deg: f64, lat_deg: f64, altitude_m: f64) -> Camera {
        Camera::from_degrees(lon_deg, lat_deg, altitude_m, 350.0, -60.0, 60.0).unwrap()
    }

    /// A flight that comes down by `rate` a second while it goes north-east, at time t.
    fn flight(t_s: f64, rate: f64, heights_per_s: f64) -> Camera {
        let altitude_m = 1e3 * libm::exp(-rate * t_s);
        let way = if rate == 0.0 {
            t_s
        } else {
            (1.0 - libm::exp(-rate * t_s)) / rate
        };
        let degrees = (heights_per_s * 1e3 / R * way).to_degrees();
        let mut at = camera(170.0 + degrees / libm::cos(0.7), 40.0 + degrees, altitude_m);
        at.heading_rad = wrap_longitude(6.2 + 0.3 * t_s);
        at
    }

    /// Distance between two cameras in heights of the second, and in octaves.
    fn error(found: &Camera, expected: &Camera) -> (f64, f64) {
        let angle = found.map_point().angle_to(expected.map_point());
        let log = libm::log2(found.altitude_m / expected.altitude_m);
        (angle * R / expected.altitude_m, log.abs())
    }

    proptest! {
        #[test]
        fn a_steady_flight_is_foreseen_whatever_the_clock_does(
            gaps in prop::collection::vec(0.002..0.09_f64, 30..60),
            rate in -0.5..1.5_f64, speed in -8.0..8.0_f64,
        ) {
            prop_assume!(rate.abs() > 0.05 && speed.abs() > 0.05);
            let mut path = PathAhead::default();
            let mut t_s = 0.0;
            for gap in gaps {
                t_s += gap;
                path.observe(t_s, &flight(t_s, rate, speed), 0.0, R);
            }
            let ahead = path.after(0.4).unwrap();
            let (heights, octaves) = error(&ahead, &flight(t_s + 0.4, rate, speed));
            let way = speed.abs() * 0.4 + 0.05;
            prop_assert!(heights < 0.15 * way && octaves < 0.02, "{heights} of {way}, {octaves}");
            let turned = wrap_longitude(ahead.heading_rad - flight(t_s + 0.4, rate, speed).heading_rad);
            prop_assert!(turned.abs() < 0.01);
        }

        #[test]
        fn late_readings_are_outvoted(late in prop::collection::vec(0..40_usize, 0..7), seed in 0..9_u32) {
            // Some frames show the camera where it was up to 30 ms ago.
            let mut path = PathAhead::default();
            for frame in 0..40 {
                let t_s = f64::from(frame) / 60.0;
                let is_late = late.contains(&(frame as usize));
                let read_s = if is_late { t_s - 0.03 } else { t_s };
                path.observe(t_s + f64::from((frame * 7 + seed) % 5) * 1e-3, &flight(read_s, 0.3, 2.0), 0.0, R);
            }
            let (heights, octaves) = error(&path.after(0.3).unwrap(), &flight(39.0 / 60.0 + 0.3, 0.3, 2.0));
            prop_assert!(heights < 0.15 && octaves < 0.05, "{heights} {octaves}");
        }
    }

    #[test]
    fn a_stall_does_not_send_the_camera_away() {
        let mut path = PathAhead::default();
        let times = (0..30).map(|i| f64::from(i) / 60.0);
        for t_s in times.chain([0.85, 0.87, 0.89, 0.92]) {
            path.observe(t_s, &flight(t_s, 0.5, 3.0), 0.0, R);
        }
        let (heights, octaves) = error(&path.after(0.3).unwrap(), &flight(1.22, 0.5, 3.0));
        assert!(heights < 0.2 && octaves < 0.05, "{heights} {octaves}");
    }

    #[test]
    fn a_jump_is_no_motion_and_neither_is_standing_still() {
        let mut path = PathAhead::default();
        assert!(path.after(0.5).is_none());
        for i in 0..30 {
            path.observe(f64::from(i) / 60.0, &camera(10.0, 10.0, 5e4), 0.0, R);
        }
        assert!(path.after(0.5).is_none());
        path.observe(0.51, &camera(60.0, -40.0, 5e4), 0.0, R);
        assert!(path.after(0.5).is_none());
        for i in 32..60 {
            path.observe(f64::from(i) / 60.0, &camera(60.0, -40.0, 5e4), 0.0, R);
        }
        assert!(path.after(0.5).is_none());
    }

    #[test]
    fn a_flight_over_a_pole_goes_on_beyond_it() {
        let mut path = PathAhead::default();
        let at = |t_s: f64| {
            let past = 0.2 * (t_s - 0.5);
            let lon = if past < 0.0 { 20.0 } else { -160.0 };
            camera(lon, 90.0 - past.abs(), 2e4)
        };
        for i in 0..=30 {
            let t_s = f64::from(i) / 60.0;
            path.observe(t_s, &at(t_s), 0.0, R);
        }
        let (heights, _) = error(&path.after(0.4).unwrap(), &at(0.9));
        assert!(heights < 0.05, "{heights}");
    }

    proptest! {
        #[test]
        fn a_great_circle_is_foreseen_to_rounding_however_fast_it_is_flown(
            exponent in -7.0..0.7_f64, lon in -180.0..180.0_f64, tilt in -1.5..1.5_f64,
        ) {
            // Up to five radians a second, around the planet in little more than one, and just not a jump
            // a frame.
            let rate_rad = libm::exp10(exponent);
            let (start, axis) = (DVec3::new(libm::cos(lon), libm::sin(lon), 0.0), DVec3::new(-libm::sin(lon) * libm::sin(tilt), libm::cos(lon) * libm::sin(tilt), libm::cos(tilt)));
            let at = |t_s: f64| {
                let up = DQuat::from_axis_angle(axis, rate_rad * t_s) * start;
                let point = MapPoint::from_direction(up);
                camera(point.lon_rad.to_degrees(), point.lat_rad().to_degrees(), 2e5)
            };
            let mut path = PathAhead::default();
            for frame in 0..40 {
                path.observe(f64::from(frame) / 60.0, &at(f64::from(frame) / 60.0), 0.0, R);
            }
            if let Some(ahead) = path.after(0.5) {
                let way = rate_rad * 0.5;
                let miss = ahead.map_point().angle_to(at(39.0 / 60.0 + 0.5).map_point());
                prop_assert!(miss < 1e-9 * way + 1e-12, "{miss:e} of {way}");
            } else {
                prop_assert!(rate_rad * R / 2e5 < 2.0 * STILL);
            }
        }
    }

    #[test]
    fn what_is_no_number_is_forgotten() {
        let mut path = PathAhead::default();
        for bad in [f64::NAN, f64::INFINITY] {
            for i in 0..20 {
                let t_s = f64::from(i) / 60.0;
                path.observe(t_s, &flight(t_s, 0.5, 3.0), 0.0, R);
            }
            let mut broken = flight(0.4, 0.5, 3.0);
            broken.altitude_m = bad;
            path.observe(0.4, &broken, 0.0, R);
            assert!(path.after(0.5).is_none());
            path.observe(bad, &flight(0.4, 0.5, 3.0), 0.0, R);
            assert!(path.after(0.5).is_none());
        }
    }
}
