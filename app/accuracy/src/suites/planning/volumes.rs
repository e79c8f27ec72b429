//! Volumes against closed forms, by samples and by time.

use core::f64::consts::PI;
use core::hint::black_box;

use glam::{DVec2, I64Vec2};
use relievo_analysis::{
    AnalysisError, Between, Ground, MapBox, Unwatched, VolumeSettings, volumes,
};
use relievo_engine::planet::map::wrap_longitude;
use relievo_engine::planet::{Grid, MapPoint, Planet};

use crate::timing::in_turns;
use crate::{Axis, Chart, Content, Context, Curve, Figure, Point, Report, SuiteError, Work};

/// Spacings that are halved nowhere, metres.
const UNIFORM_M: [f64; 6] = [16.0, 8.0, 4.0, 2.0, 1.0, 0.5];

/// Shares of the volume to which spacings are halved from 4 m on.
const TOLERANCES: [f64; 4] = [1e-1, 1e-2, 1e-3, 1e-4];

/// Metres around the middle that are measured.
const HALF_M: f64 = 70.0;

/// Heights by a formula of metres east and north of a middle.
struct Formula(fn(DVec2) -> f64);

fn middle() -> MapPoint {
    MapPoint::from_degrees(11.0, 47.0)
}

impl Ground for Formula {
    fn planet(&self) -> Planet {
        Planet::EARTH
    }

    fn finest_level(&self, _area: &MapBox) -> u8 {
        12
    }

    fn heights(&self, grid: &Grid) -> Result<Vec<f32>, AnalysisError> {
        let rect = grid.rect;
        let rows = rect.min.y..rect.max.y;
        let places = rows.flat_map(|y| (rect.min.x..rect.max.x).map(move |x| I64Vec2::new(x, y)));
        let heights = places.map(|sample| (self.0)(metres(grid.lattice.map_point(sample))) as f32);
        Ok(heights.collect())
    }
}

/// Metres along the circle of latitude and along meridians, so that areas are the ellipsoid's.
fn metres(place: MapPoint) -> DVec2 {
    let middle = middle();
    let lon_rad = wrap_longitude(place.lon_rad - middle.lon_rad);
    DVec2::new(
        Planet::EARTH.metres_per_radian(place.colat_rad).x * lon_rad,
        Planet::EARTH.metres_per_radian(middle.colat_rad).y * (middle.colat_rad - place.colat_rad),
    )
}

/// Not symmetric about the middle, as no survey is.
fn area() -> MapBox {
    let metres = Planet::EARTH.metres_per_radian(middle().colat_rad);
    let far_m = 1.013 * HALF_M;
    MapBox {
        west_rad: middle().lon_rad - HALF_M / metres.x,
        east_rad: middle().lon_rad + far_m / metres.x,
        north_colat_rad: middle().colat_rad - far_m / metres.y,
        south_colat_rad: middle().colat_rad + HALF_M / metres.y,
    }
}

/// Two grounds, and the exact sum of cut and fill between them in cubic metres.
struct Case {
    name: &'static str,
    before: Formula,
    after: Formula,
    exact_m3: f64,
}

fn cases() -> [Case; 3] {
    // The platform's rim lies 1 m below the cone; the batter meets the cone after 1 / 0.6 m.
    let (r, reach) = (30.0, 1.0 / 0.6);
    let inside = PI * r * r * 2.0;
    let batter =
        r * (reach - 0.3 * reach * reach) + reach * reach / 2.0 - 0.2 * reach * reach * reach;
    // A crest of 6 m at 20 m, faces of 0.4, in a valley whose sides rise by 0.5.
    let (v, c, m, w) = (0.5, 20.0, 0.4, 6.0);
    [
        Case {
            name: "platform on a cone",
            before: Formula(cone),
            after: Formula(|p| {
                let away = (p.length() - 30.0).max(0.0);
                cone(p).clamp(100.0 - 0.5 * away, 100.0 + 0.5 * away)
            }),
            exact_m3: inside + 2.0 * PI * batter,
        },
        Case {
            name: "dam across a valley",
            before: Formula(|p| 0.5 * p.x.abs()),
            after: Formula(|p| {
                let face = 20.0 - 0.4 * (p.y.abs() - 3.0).max(0.0);
                face.max(0.5 * p.x.abs())
            }),
            exact_m3: c * c / v * w + 2.0 * c * c * c / (3.0 * m * v),
        },
        Case {
            name: "box with walls, askew",
            before: Formula(|_| 50.0),
            after: Formula(|p| {
                let turned = DVec2::from_angle(0.3).rotate(p);
                let inside = turned.x.abs() < 17.3 && turned.y.abs() < 9.1;
                if inside { 40.0 } else { 50.0 }
            }),
            exact_m3: 10.0 * 34.6 * 18.2,
        },
    ]
}

fn cone(p: DVec2) -> f64 {
    104.0 - 0.1 * p.length()
}

/// A volume as it was found.
struct Found {
    setting: String,
    settings: VolumeSettings,
    samples: f64,
    error: f64,
    stated: f64,
}

impl Case {
    fn measure(&self, settings: &VolumeSettings) -> Result<relievo_analysis::Volumes, SuiteError> {
        let change = Between {
            before: &self.before,
            after: &self.after,
        };
        volumes(&change, &area(), settings, &Unwatched)
            .map_err(|error| SuiteError::System(error.to_string()))
    }

    fn found(&self, setting: String, settings: VolumeSettings) -> Result<Found, SuiteError> {
        let found = self.measure(&settings)?;
        let value = found.cut_m3.value + found.fill_m3.value;
        Ok(Found {
            setting,
            settings,
            samples: found.samples as f64,
            error: (value / self.exact_m3 - 1.0).abs(),
            stated: (found.cut_m3.error + found.fill_m3.error) / self.exact_m3,
        })
    }

    fn uniform(&self, least_m: f64) -> Result<Vec<Found>, SuiteError> {
        let spacings = UNIFORM_M.into_iter().filter(|m| *m >= least_m);
        let settings = |spacing_m| VolumeSettings {
            tolerance: f64::INFINITY,
            ..VolumeSettings::from_spacing(spacing_m)
        };
        spacings
            .map(|m| self.found(format!("spacing {m} m"), settings(m)))
            .collect()
    }

    fn adaptive(&self, least: f64) -> Result<Vec<Found>, SuiteError> {
        let tolerances = TOLERANCES.into_iter().filter(|t| *t >= least);
        let settings = |tolerance| VolumeSettings {
            tolerance,
            ..VolumeSettings::from_spacing(4.0)
        };
        tolerances
            .map(|t| self.found(format!("tolerance {t:.0e}"), settings(t)))
            .collect()
    }
}

pub(super) fn measure(context: &Context) -> Result<Report, SuiteError> {
    let cases = cases();
    let mut curves = Vec::new();
    for case in &cases {
        context.go_on()?;
        let uniform = case.uniform(context.pick(1.0, 0.0))?;
        let adaptive = case.adaptive(context.pick(1e-3, 0.0))?;
        curves.push((format!("{}, one spacing", case.name), case, uniform));
        curves.push((
            format!("{}, halved where needed", case.name),
            case,
            adaptive,
        ));
    }
    let mut works: Vec<Work> = Vec::new();
    for (_, case, found) in &curves {
        for found in found {
            works.push(Work::new(1e6, move || {
                // Whether it works was seen before.
                let done = case.measure(black_box(&found.settings));
                black_box(done.is_ok());
            }));
        }
    }
    let times = in_turns(context, &mut works)?;
    drop(works);
    let mut times = times.into_iter();
    let timed: Vec<Curve> = curves
        .iter()
        .map(|(name, _, found)| Curve {
            name: name.clone(),
            points: found
                .iter()
                .zip(times.by_ref())
                .map(|(f, time)| Point::timed(f.setting.clone(), time, f.error))
                .collect(),
            joined: true,
        })
        .collect();
    let by_samples = curves.iter().map(|(name, _, found)| Curve {
        name: name.clone(),
        points: found
            .iter()
            .map(|f| Point::new(f.setting.clone(), f.samples, f.error))
            .collect(),
        joined: true,
    });
    let stated = curves.iter().map(|(name, _, found)| Curve {
        name: name.clone(),
        points: found
            .iter()
            .map(|f| Point::new(f.setting.clone(), f.stated, f.error))
            .collect(),
        joined: false,
    });
    let all = || curves.iter().flat_map(|(_, _, found)| found);
    let honest = all().filter(|f| f.error <= f.stated + 1e-6).count();
    let error = || Axis::log("error of the volume", "parts of the volume");
    let figure = |name: &str, title: &str, caption: &str, x: Axis, curves, marks_front| {
        let chart = Chart {
            x,
            y: error(),
            curves,
            marks_front,
        };
        Figure::new(name, title, caption, Content::Chart(chart))
    };
    Ok(Report {
        summary: vec![format!(
            "Volumes: in {honest} of {} measurements the true volume lies within the error that the program states beside it.",
            all().count()
        )],
        figures: vec![
            figure(
                "volume-samples",
                "Volumes by samples",
                "Cut and fill together against their closed form. One spacing for all of the area, or halved where the error is largest until \
                 it is within the tolerance.",
                Axis::log("samples", ""),
                by_samples.collect(),
                true,
            ),
            figure(
                "volume-time",
                "Volumes by time",
                "The same by time, one thread, on grounds that are formulas.",
                Axis::log("run time", "ms"),
                timed,
                true,
            ),
            figure(
                "volume-stated",
                "Stated and true errors of volumes",
                "The error that is stated beside a volume, and the one it has: below the diagonal the statement holds.",
                Axis::log("stated error", "parts of the volume"),
                stated.collect(),
                false,
            ),
        ],
    })
}
