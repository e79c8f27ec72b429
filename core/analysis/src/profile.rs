//! Heights along a line.

use relievo_planet::{LevelKey, MapPoint};

use crate::geodesic::Measure;
use crate::ground::{AnalysisError, Ground, Watch, go_on};
use crate::map_box::MapBox;
use crate::sampler::Sampler;

/// Pieces in which a line looks for the fineness of its data.
const PIECES: usize = 128;

/// How a profile is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfileSettings {
    /// Metres between points, positive; `None` takes the spacing of the data under each part of the
    /// line.
    pub spacing_m: Option<f64>,
    /// Most points; a line that needs more is refused.
    pub max_points: usize,
}

impl Default for ProfileSettings {
    /// The data's spacing, at most 2²⁰ points.
    fn default() -> Self {
        Self {
            spacing_m: None,
            max_points: 1 << 20,
        }
    }
}

/// One point of a profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfilePoint {
    /// Where it lies.
    pub place: MapPoint,
    /// Metres along the line's geodesics from its start.
    pub distance_m: f64,
    /// Height in metres; NaN where there is none.
    pub height_m: f64,
    /// Rise over run, without unit, of the step that ends here (of the first step at the start):
    /// positive uphill. NaN beside a point without height.
    pub slope: f64,
}

/// A profile and what it sums to.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Points from the line's start to its end, every vertex of the line among them.
    pub points: Vec<ProfilePoint>,
    /// Length of the line in metres along the ellipsoid.
    pub length_m: f64,
    /// Length in metres along the surface, from point to point; steps without height count by their
    /// length on the ellipsoid.
    pub surface_length_m: f64,
    /// Sum of all rises from point to point in metres.
    pub climb_m: f64,
    /// Sum of all falls in metres, positive.
    pub descent_m: f64,
    /// Largest magnitude of a step's slope, rise over run without unit; 0 if no step has one.
    pub steepest: f64,
    /// Lowest and highest height in metres; `None` where no point has one.
    pub range_m: Option<(f64, f64)>,
}

/// The profile along a line of geodesic legs.
///
/// Heights are bilinear between the data's own samples, so points between them add nothing: the
/// spacing of the data loses nothing but what lies between two rows of samples crossed at an angle.
///
/// # Errors
/// [`AnalysisError`]; `Refused` for fewer than two points, a line without length, a spacing that is
/// not positive, or more points than allowed.
pub fn profile(
    ground: &dyn Ground,
    line: &[MapPoint],
    settings: &ProfileSettings,
    watch: &dyn Watch,
) -> Result<Profile, AnalysisError> {
    let refused = |text: String| Err(AnalysisError::Refused(text));
    if line.len() < 2
        || line
            .iter()
            .any(|p| !p.lon_rad.is_finite() || !p.colat_rad.is_finite())
    {
        return refused(format!(
            "expected a line of at least 2 finite points, found {}",
            line.len()
        ));
    }
    if let Some(spacing_m) = settings.spacing_m
        && !(spacing_m.is_finite() && spacing_m > 0.0)
    {
        return refused(format!(
            "expected a positive spacing in metres, found {spacing_m}"
        ));
    }
    let measure = Measure::new(&ground.planet());
    let legs: Vec<Leg> = line
        .windows(2)
        .map(|ends| Leg::new(&measure, ends[0], ends[1]))
        .collect();
    let length_m: f64 = legs.iter().map(|leg| leg.length_m).sum();
    if length_m <= 0.0 {
        return refused(
            "expected a line with length, found all its points at one place".to_owned(),
        );
    }
    let steps = plan(ground, &measure, &legs, length_m, settings)?;
    let radius_m = ground.planet().radius_m;
    let spacing_cells = steps.iter().map(|s| s.spacing_m / cell_m(s.n, radius_m));
    let mut sampler = Sampler::new(ground, spacing_cells.fold(f64::INFINITY, f64::min));
    let mut points = Vec::new();
    let mut before_m = 0.0;
    for (index, step) in steps.iter().enumerate() {
        let leg = &legs[step.leg];
        // The end of a step is the start of the next one.
        let last = index + 1 == steps.len();
        for i in 0..step.count + usize::from(last) {
            if i % 64 == 0 {
                go_on(watch)?;
                watch.progress((before_m + step.from_m) / length_m);
            }
            let share = i as f64 / step.count as f64;
            let along_m = step.from_m + (step.to_m - step.from_m) * share;
            let place = leg.at(&measure, along_m);
            points.push(ProfilePoint {
                place,
                distance_m: before_m + along_m,
                height_m: sampler.height_m(place, step.n)?,
                slope: f64::NAN,
            });
        }
        if steps
            .get(index + 1)
            .is_some_and(|next| next.leg != step.leg)
        {
            before_m += leg.length_m;
        }
    }
    watch.progress(1.0);
    Ok(summed(points, length_m))
}

/// One geodesic of a line.
struct Leg {
    from: MapPoint,
    to: MapPoint,
    azimuth_rad: f64,
    length_m: f64,
}

impl Leg {
    fn new(measure: &Measure, from: MapPoint, to: MapPoint) -> Self {
        let (from, to) = (from.normalised(), to.normalised());
        let (length_m, azimuth_rad) = measure.way(from, to);
        Self {
            from,
            to,
            azimuth_rad,
            length_m,
        }
    }

    fn at(&self, measure: &Measure, along_m: f64) -> MapPoint {
        if along_m <= 0.0 {
            self.from
        } else if along_m >= self.length_m {
            self.to
        } else {
            measure.destination(self.from, self.azimuth_rad, along_m)
        }
    }
}

/// Evenly spaced points of a part of a leg.
struct Step {
    leg: usize,
    from_m: f64,
    to_m: f64,
    /// Steps from the first to the last point.
    count: usize,
    spacing_m: f64,
    /// Level of the data under it.
    n: u8,
}

/// Height of a cell of a level in metres.
fn cell_m(n: u8, radius_m: f64) -> f64 {
    LevelKey::new(0, n).step_rad().y * radius_m
}

fn plan(
    ground: &dyn Ground,
    measure: &Measure,
    legs: &[Leg],
    length_m: f64,
    settings: &ProfileSettings,
) -> Result<Vec<Step>, AnalysisError> {
    let planet = ground.planet();
    let mut steps = Vec::new();
    let mut total = 1.0_f64;
    for (index, leg) in legs
        .iter()
        .enumerate()
        .filter(|(_, leg)| leg.length_m > 0.0)
    {
        let pieces = libm::ceil(leg.length_m / length_m * PIECES as f64).max(1.0);
        for piece in 0..pieces as usize {
            let from_m = leg.length_m * (piece as f64 / pieces);
            let to_m = leg.length_m * ((piece + 1) as f64 / pieces);
            let middle = leg.at(measure, f64::midpoint(from_m, to_m));
            let reach_rad =
                0.51 * (to_m - from_m) / (planet.equatorial_radius_m * (1.0 - planet.flattening));
            let n = ground.finest_level(&MapBox::around(middle, reach_rad));
            let spacing_m = settings.spacing_m.unwrap_or(cell_m(n, planet.radius_m));
            let count = libm::ceil((to_m - from_m) / spacing_m * (1.0 - 1e-9)).max(1.0);
            total += count;
            steps.push(Step {
                leg: index,
                from_m,
                to_m,
                count: count.min(1e12) as usize,
                spacing_m,
                n,
            });
        }
    }
    if total > settings.max_points as f64 {
        return Err(AnalysisError::Refused(format!(
            "expected a profile of at most {} points, found {total:.0}: a spacing of {:.3} m would do",
            settings.max_points,
            length_m / (settings.max_points as f64 * 0.9 - (PIECES + legs.len()) as f64).max(1.0),
        )));
    }
    Ok(steps)
}

fn summed(mut points: Vec<ProfilePoint>, length_m: f64) -> Profile {
    let (mut surface_length_m, mut climb_m, mut descent_m) = (0.0, 0.0, 0.0);
    let mut steepest = 0.0_f64;
    for i in 1..points.len() {
        let run_m = points[i].distance_m - points[i - 1].distance_m;
        let rise_m = points[i].height_m - points[i - 1].height_m;
        if rise_m.is_nan() {
            surface_length_m += run_m;
            continue;
        }
        surface_length_m += libm::hypot(run_m, rise_m);
        climb_m += rise_m.max(0.0);
        descent_m += (-rise_m).max(0.0);
        if run_m > 0.0 {
            points[i].slope = rise_m / run_m;
            steepest = steepest.max((rise_m / run_m).abs());
        }
    }
    if points.len() > 1 {
        points[0].slope = points[1].slope;
    }
    let heights = points.iter().map(|p| p.height_m).filter(|h| h.is_finite());
    let range_m = heights.fold(None, |range: Option<(f64, f64)>, h| {
        Some(range.map_or((h, h), |(low, high)| (low.min(h), high.max(h))))
    });
    Profile {
        points,
        length_m,
        surface_length_m,
        climb_m,
        descent_m,
        steepest,
        range_m,
    }
}
