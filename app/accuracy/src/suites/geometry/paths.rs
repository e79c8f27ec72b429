//! Places to look from: where the ground is flat and where it is mountainous.

use relievo_engine::planet::{Camera, MapPoint};
use relievo_engine::{Engine, Questions};

use crate::scene::failed;
use crate::{Context, SuiteError};

/// Height of the eye above the ground in metres.
const HEIGHT_M: f64 = 1500.0;

/// Places around one whose heights say how rough the ground is, and how far away they are.
const AROUND: [(f64, f64); 6] = [
    (3e3, 0.0),
    (-3e3, 1e3),
    (1e3, 3e3),
    (-1e3, -3e3),
    (8e3, 6e3),
    (-6e3, 8e3),
];

/// Places along a great circle, each with the ground's height.
pub(crate) struct Path {
    pub(crate) name: &'static str,
    places: Vec<(MapPoint, f64)>,
    heading_rad: f64,
}

impl Path {
    /// The flattest and the roughest of some places around the project's own camera.
    pub(crate) fn find(engine: &Engine, context: &Context) -> Result<Vec<Self>, SuiteError> {
        let questions = engine.questions();
        let exaggeration = engine.project().planet.vertical_exaggeration;
        let radius_m = engine.project().planet.body.figure().radius_m;
        let own = engine.project().camera.to_camera();
        let reach_rad = (0.3 * own.altitude_m / radius_m).min(0.6);
        let side = context.pick(3, 9);
        let mut found: Vec<(f64, MapPoint)> = Vec::new();
        for i in 0..side * side {
            context.go_on()?;
            let offset = |k: i32| (f64::from(k) + 0.5) / f64::from(side) * 2.0 - 1.0;
            let lat = (own.lat_rad + offset(i / side) * reach_rad).clamp(-1.4, 1.4);
            let lon = own.lon_rad + offset(i % side) * reach_rad / libm::cos(lat);
            let place = MapPoint::new(lon, core::f64::consts::FRAC_PI_2 - lat).normalised();
            found.push((relief_m(&questions, place, radius_m, context)?, place));
        }
        found.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        let (Some((_, flat)), Some((_, rough))) = (found.first(), found.last()) else {
            return Ok(Vec::new());
        };
        let along = |name, start: MapPoint| -> Result<Self, SuiteError> {
            let count = context.pick(1, 2);
            let mut places = Vec::new();
            for k in 0..count {
                let east_rad = f64::from(k) * 2.0 * HEIGHT_M / radius_m;
                let lon_rad = start.lon_rad + east_rad / libm::sin(start.colat_rad).max(0.01);
                let place = MapPoint::new(lon_rad, start.colat_rad).normalised();
                let ground_m = height_m(&questions, place, context)? * exaggeration;
                places.push((place, ground_m));
            }
            Ok(Self {
                name,
                places,
                heading_rad: 1.0,
            })
        };
        Ok(vec![along("flat", *flat)?, along("mountainous", *rough)?])
    }

    /// Cameras at all places with one angle of view.
    pub(crate) fn cameras(&self, pitch_deg: f64) -> Vec<Camera> {
        let camera = |(place, ground_m): &(MapPoint, f64)| Camera {
            lon_rad: place.lon_rad,
            lat_rad: place.lat_rad(),
            altitude_m: ground_m + HEIGHT_M,
            heading_rad: self.heading_rad,
            pitch_rad: pitch_deg.to_radians(),
            fov_y_rad: 60.0_f64.to_radians(),
        };
        self.places.iter().map(camera).collect()
    }
}

/// Degrees below the horizon, as \[Liv07\] table 6 has them.
pub(crate) fn angles_deg(context: &Context) -> Vec<f64> {
    let step = context.pick(5, 1);
    (0..=9)
        .rev()
        .step_by(step)
        .map(|k| f64::from(k) * 10.0)
        .collect()
}

fn height_m(questions: &Questions, at: MapPoint, context: &Context) -> Result<f64, SuiteError> {
    let answer = questions.place(at, &context.cancel);
    Ok(answer.map_err(|error| failed(&error))?.height_m)
}

/// Difference of the lowest and the highest of some heights around a place, metres.
fn relief_m(
    questions: &Questions,
    at: MapPoint,
    radius_m: f64,
    context: &Context,
) -> Result<f64, SuiteError> {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for (east_m, south_m) in AROUND {
        let lon = at.lon_rad + east_m / radius_m / libm::sin(at.colat_rad).max(0.01);
        let place = MapPoint::new(lon, at.colat_rad + south_m / radius_m).normalised();
        let height_m = height_m(questions, place, context)?;
        (low, high) = (low.min(height_m), high.max(height_m));
    }
    Ok(high - low)
}
