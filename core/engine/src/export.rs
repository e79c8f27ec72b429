//! What a project and its measurements come to as features for other programs.
//!
//! Coordinates are rounded to 10⁻⁹ degrees (0.1 mm on Earth), heights to 0.1 mm. Lines go on beyond ±180°;
//! the writers of `relievo-vector` cut them there.

mod elements;
mod rasters;

use relievo_analysis::{AnalysisError, ContourLine, Flood, Profile};
use relievo_earthwork::{DaylightLine, Ending};
use relievo_planet::MapPoint;
use relievo_project::Element;
use relievo_vector::Value;
use relievo_vector::write::{Feature, Geometry, Position};
use std::sync::Arc;

use crate::analysis::{Task, failed};
use crate::query::Questions;

pub use rasters::{write_flood, write_viewshed};

/// Contours as lines at their heights, with `height_m` and `closed`; closed ones end where they begin.
pub fn contour_features(lines: &[ContourLine]) -> Vec<Feature> {
    let feature = |line: &ContourLine| Feature {
        geometry: Geometry::Lines(vec![ring(line)]),
        properties: vec![
            property("height_m", line.height_m),
            ("closed".to_owned(), Value::Bool(line.closed)),
        ],
    };
    lines.iter().map(feature).collect()
}

/// The area that water covers, at its level, with what is known of it: a polygon with its islands, or the
/// lines of its shore where it goes around a pole or ends in missing ground.
pub fn flood_features(flood: &Flood) -> Vec<Feature> {
    // The dry ground lies to the left: clockwise around water, counter-clockwise around islands.
    let (outer, islands): (Vec<_>, Vec<_>) = flood
        .shore
        .iter()
        .partition(|line| twice_area(&line.points) < 0.0);
    let whole = flood
        .shore
        .iter()
        .all(|line| line.closed && !goes_around(line));
    let geometry = match &outer[..] {
        [outer] if whole => {
            let rings = core::iter::once(*outer).chain(islands).map(ring);
            Geometry::Polygons(vec![rings.collect()])
        }
        _ => Geometry::Lines(flood.shore.iter().map(ring).collect()),
    };
    vec![Feature {
        geometry,
        properties: vec![
            property("level_m", flood.level_m),
            property("area_m2", flood.area_m2),
            property("volume_m3", flood.volume_m3),
            property("deepest_m", flood.deepest_m),
            property("shore_m", flood.shore_m),
        ],
    }]
}

/// A profile as a line on the ground, in parts where heights are missing, with its sums.
pub fn profile_features(profile: &Profile) -> Vec<Feature> {
    let places: Vec<MapPoint> = profile.points.iter().map(|p| p.place).collect();
    let heights: Vec<f64> = profile.points.iter().map(|p| p.height_m).collect();
    let points = positions(&places, &heights);
    let known = points.split(|p| p.height_m.is_none());
    let parts = known.filter(|part| part.len() > 1).map(<[_]>::to_vec);
    let (lowest, highest) = profile.range_m.unzip();
    vec![Feature {
        geometry: Geometry::Lines(parts.collect()),
        properties: vec![
            property("length_m", profile.length_m),
            property("surface_length_m", profile.surface_length_m),
            property("climb_m", profile.climb_m),
            property("descent_m", profile.descent_m),
            property("steepest_percent", 100.0 * profile.steepest),
            property("lowest_m", lowest),
            property("highest_m", highest),
        ],
    }]
}

impl Questions {
    /// Outlines, axes and strokes of those elements that take part, with their names, kinds and measures.
    /// A vertex has the height that the element alone gives the ground there; a geometry has heights
    /// where all its vertices have one.
    ///
    /// # Errors
    /// [`AnalysisError`].
    pub fn element_features(
        &self,
        elements: &[Arc<Element>],
        task: &Task,
    ) -> Result<Vec<Feature>, AnalysisError> {
        let mut features = Vec::new();
        for (done, element) in elements.iter().enumerate() {
            (task.progress)(done as f64 / elements.len() as f64);
            let Some(shape) = self
                .element_shape(&element.id, task.cancel)
                .map_err(failed)?
            else {
                continue;
            };
            let heights = |places: &[MapPoint]| self.heights_of(&shape, places, task);
            elements::features(element, &heights, &mut features)?;
        }
        Ok(features)
    }

    /// Lines where the work of elements ends, each element taken alone: where slopes meet the ground, and
    /// walls where they do not within their reach. Found on cells of `spacing_m` metres, at the ground's
    /// heights.
    ///
    /// # Errors
    /// [`AnalysisError`].
    pub fn daylight_features(
        &self,
        elements: &[Arc<Element>],
        spacing_m: f64,
        task: &Task,
    ) -> Result<Vec<Feature>, AnalysisError> {
        if !(spacing_m.is_finite() && spacing_m > 0.0) {
            return Err(AnalysisError::Refused(format!(
                "expected a positive spacing in metres, found {spacing_m}"
            )));
        }
        let mut features = Vec::new();
        for (done, element) in elements.iter().enumerate() {
            (task.progress)(done as f64 / elements.len() as f64);
            let found = self.element(&element.id, spacing_m, task.cancel);
            for DaylightLine { ending, places } in
                found.map_err(failed)?.into_iter().flat_map(|a| a.daylight)
            {
                let heights = self.ground_heights_m(&places, spacing_m, task.cancel);
                let line = positions(&places, &heights.map_err(failed)?);
                let mut properties = elements::named(element);
                properties.push(text(
                    "ending",
                    match ending {
                        Ending::Meets => "meets the ground",
                        Ending::ReachWall => "wall at its reach",
                    },
                ));
                features.push(Feature {
                    geometry: Geometry::Lines(vec![whole_or_flat(line)]),
                    properties,
                });
            }
        }
        Ok(features)
    }

    /// Heights that an element alone gives the ground at places; NaN where there is none.
    fn heights_of(
        &self,
        shape: &Arc<relievo_earthwork::Shaped>,
        places: &[MapPoint],
        task: &Task,
    ) -> Result<Vec<f64>, AnalysisError> {
        /// Metres at which the ground is read for single vertices.
        const SPACING_M: f64 = 1.0;
        let ground = self
            .ground_heights_m(places, SPACING_M, task.cancel)
            .map_err(failed)?;
        let design = relievo_earthwork::Design::new(self.planet, vec![Arc::clone(shape)]);
        let height = |(place, ground_m): (&MapPoint, f64)| design.height(*place, ground_m).height_m;
        Ok(places.iter().zip(ground).map(height).collect())
    }
}

fn property(name: &str, value: impl Into<Option<f64>>) -> (String, Value) {
    (
        name.to_owned(),
        value.into().map_or(Value::Null, Value::Float),
    )
}

fn text(name: &str, value: &str) -> (String, Value) {
    (name.to_owned(), Value::from(value))
}

/// Places of a line, each less than half a turn from the one before, with heights that are numbers.
fn positions(places: &[MapPoint], heights: &[f64]) -> Vec<Position> {
    let mut before: Option<f64> = None;
    let place = |(place, height_m): (&MapPoint, &f64)| {
        let (lon_deg, lat_deg) = (
            place.lon_rad.to_degrees(),
            90.0 - place.colat_rad.to_degrees(),
        );
        let turns = before.map_or(0.0, |before| ((before - lon_deg) / 360.0).round());
        let lon_deg = lon_deg + 360.0 * turns;
        before = Some(lon_deg);
        Position {
            lon_deg: rounded(lon_deg, 1e9),
            lat_deg: rounded(lat_deg, 1e9),
            height_m: height_m.is_finite().then(|| rounded(*height_m, 1e4)),
        }
    };
    places.iter().zip(heights).map(place).collect()
}

/// A line with heights at all its places, or at none.
fn whole_or_flat(mut line: Vec<Position>) -> Vec<Position> {
    if line.iter().any(|p| p.height_m.is_none()) {
        for p in &mut line {
            p.height_m = None;
        }
    }
    line
}

fn rounded(value: f64, per_unit: f64) -> f64 {
    (value * per_unit).round() / per_unit
}

/// A contour's points; a closed one ends where it begins, perhaps a turn on.
fn ring(line: &ContourLine) -> Vec<Position> {
    let mut places = line.points.clone();
    places.extend(line.points.first().filter(|_| line.closed));
    positions(&places, &vec![line.height_m; places.len()])
}

/// Whether a closed line goes around a pole.
fn goes_around(line: &ContourLine) -> bool {
    let ring = ring(line);
    matches!((ring.first(), ring.last()), (Some(first), Some(last)) if (first.lon_deg - last.lon_deg).abs() > 180.0)
}

/// Twice the area on the map in square radians, positive counter-clockwise seen from above.
fn twice_area(points: &[MapPoint]) -> f64 {
    let edges = points.iter().zip(points.iter().cycle().skip(1));
    edges
        .map(|(a, b)| b.lon_rad * a.colat_rad - a.lon_rad * b.colat_rad)
        .sum()
}
