//! Motion: frame times, springs, journeys and paths.

use core::f64::consts::PI;

use glam::{DQuat, DVec3};
use relievo_engine::planet::camera::{Fly, FlyInput, PathAhead};
use relievo_engine::planet::{Camera, MapPoint, Planet};

use super::{Case, Extent, Found, worse, worst};

pub(super) const CASES: &[Case] = &[
    Case {
        name: "frame times of 0 and 10 s: the way of a flight",
        truth: "600 frames in the same time; 0 s: the camera before",
        unit: "heights above the ground",
        limit: 1e-6,
        degrades: "not at all: the spring is solved in closed form, the way to fourth order",
        measure: frame_times,
    },
    Case {
        name: "spring-damped camera at steps of 1 µs to 60 s: height after a climb",
        truth: "the closed form of a critically damped spring",
        unit: "parts of the height",
        limit: 1e-9,
        degrades: "not at all; frames beyond 60 s count as 60 s",
        measure: spring,
    },
    Case {
        name: "cameras faster than can be followed, to 5 rad/s around the planet: half a second ahead",
        truth: "the great circle",
        unit: "parts of the way",
        limit: 1e-6,
        degrades: "not at all on great circles; more than three heights a frame are jumps, for which nothing is foreseen or fetched",
        measure: extrapolation,
    },
];

fn camera(lat_deg: f64, altitude_m: f64) -> Camera {
    Camera {
        lon_rad: PI,
        lat_rad: lat_deg.to_radians(),
        altitude_m,
        heading_rad: 0.7,
        pitch_rad: -0.5,
        fov_y_rad: 1.0,
    }
}

fn frame_times(extent: Extent) -> Found {
    let latitudes = extent.pick(&[0.0, 89.999][..], &[0.0, 45.0, 89.999, 90.0][..]);
    let mut worst_heights = 0.0;
    for lat_deg in latitudes {
        for altitude_m in [1.0, 1e3, 1e6] {
            let input = FlyInput {
                right: 0.3,
                forward: 0.8,
                up: 0.1,
                boost: 1.0,
            };
            let fly = |frames: u32, total_s: f64| {
                let (mut fly, mut at) = (Fly::new(), camera(*lat_deg, altitude_m));
                for _ in 0..frames {
                    at = fly.advance(
                        &at,
                        &Planet::EARTH,
                        0.0,
                        &input,
                        total_s / f64::from(frames),
                    );
                }
                at
            };
            let still = fly(5, 0.0);
            let (once, often) = (fly(1, 10.0), fly(600, 10.0));
            let way =
                (once.eye(&Planet::EARTH) - often.eye(&Planet::EARTH)).length() / often.altitude_m;
            let stayed = if still == camera(*lat_deg, altitude_m) {
                0.0
            } else {
                f64::NAN
            };
            worst_heights = worse(worst_heights, worse(way, stayed));
        }
    }
    Found::only(worst_heights)
}

fn spring(extent: Extent) -> Found {
    // v(t) = c (1 − (1 + ωt) e^−ωt), whose integral is the logarithm of the height.
    let omega = 8.0;
    let log_height =
        |c: f64, t: f64| c * (t - 2.0 / omega + (t + 2.0 / omega) * libm::exp(-omega * t));
    let steps = extent.pick(
        &[(1e-6, 2000), (0.1, 30), (10.0, 1)][..],
        &[
            (1e-6, 100_000),
            (1e-3, 4000),
            (0.016, 400),
            (0.1, 50),
            (1.0, 8),
            (10.0, 1),
            (60.0, 1),
        ][..],
    );
    let of = |up: f64| {
        worst(steps.iter().map(|(step_s, count)| {
            let input = FlyInput {
                up,
                ..FlyInput::default()
            };
            let (mut fly, mut at) = (Fly::new(), camera(10.0, 10.0));
            for _ in 0..*count {
                at = fly.advance(&at, &Planet::EARTH, 0.0, &input, *step_s);
            }
            let exact = 10.0 * libm::exp(log_height(up, step_s * f64::from(*count)));
            (at.altitude_m / exact.clamp(1.0, 1e8) - 1.0).abs()
        }))
    };
    Found::only(worst([1.0, -0.1].map(of)))
}

fn extrapolation(extent: Extent) -> Found {
    const ALTITUDE_M: f64 = 2e5;
    let count = extent.pick(60, 2000);
    let (mut missed, mut plain) = (0.0, 0.0);
    for k in 0..count {
        let k = f64::from(k);
        let rate_rad = 5.0 * libm::exp2(-8.0 * (k * 0.618_034).fract());
        let (lon, tilt) = (k * 2.399, 1.5 * (2.0 * (k * 0.754_878).fract() - 1.0));
        let ((sin_l, cos_l), (sin_t, cos_t)) = (libm::sincos(lon), libm::sincos(tilt));
        let start = DVec3::new(cos_l, sin_l, 0.0);
        let axis = DVec3::new(-sin_l * sin_t, cos_l * sin_t, cos_t);
        let up = |time_s: f64| DQuat::from_axis_angle(axis, rate_rad * time_s) * start;
        let at = |time_s: f64| {
            let place = MapPoint::from_direction(up(time_s));
            Camera {
                lon_rad: place.lon_rad,
                lat_rad: place.lat_rad(),
                ..camera(0.0, ALTITUDE_M)
            }
        };
        let mut path = PathAhead::default();
        for frame in 0..40 {
            let time_s = f64::from(frame) / 60.0;
            path.observe(time_s, &at(time_s), 0.0, Planet::EARTH.radius_m);
        }
        let (now, ahead_s) = (39.0 / 60.0, 0.5);
        let truth = at(now + ahead_s).map_point();
        let way = rate_rad * ahead_s;
        let found = path
            .after(ahead_s)
            .map_or(f64::NAN, |c| c.map_point().angle_to(truth) / way);
        missed = worse(missed, found);
        // Straight on along the chord of the last frames.
        let chord = (up(now) - up(now - 0.4)) / 0.4;
        let straight = MapPoint::from_direction(up(now) + chord * ahead_s);
        plain = worse(plain, straight.angle_to(truth) / way);
    }
    Found {
        worst: missed,
        plain: Some(plain),
    }
}
