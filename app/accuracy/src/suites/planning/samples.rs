//! Heights of elements on samples: an area's mean by the share that is covered, or by places in it.

use core::hint::black_box;
use std::sync::Arc;

use glam::DVec2;
use relievo_engine::earthwork::{
    Corridor, Design, Element, Frame, Outcome, Polygon, Prepared, Profile, Samples, Section, Shape,
    Side, Surface, Vertex,
};
use relievo_engine::planet::{MapPoint, Planet};

use crate::timing::in_turns;
use crate::{Chart, Content, Context, Curve, Figure, Point, Report, SuiteError, Work};

/// How a sample gets its height.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Method {
    /// As tiles do: exactly at the centre of wide elements, by covered area for narrow ones.
    Tiles,
    /// The mean of so many places along each side of the sample.
    Places(usize),
}

impl Method {
    const ALL: [Self; 4] = [
        Self::Tiles,
        Self::Places(1),
        Self::Places(2),
        Self::Places(4),
    ];

    fn name(self) -> String {
        match self {
            Self::Tiles => "as tiles are made".to_owned(),
            Self::Places(1) => "at the centre".to_owned(),
            Self::Places(n) => format!("mean of {n} × {n} places"),
        }
    }
}

/// Largest distance between places whose mean is the truth, metres, and how many there are along a side
/// of a sample at least.
const TRUTH: (f64, usize) = (0.25, 8);

pub(super) fn measure(context: &Context) -> Result<Report, SuiteError> {
    let scenes = [
        (
            "platform",
            "A platform of 60 m with side slopes",
            platform(),
        ),
        ("road", "A road of 8 m with side slopes", road()),
        ("tin", "A triangulated pit of 60 m with side slopes", pit()),
    ];
    let half_m = context.pick(64.0, 128.0);
    let mut report = Report::default();
    let mut far = Vec::new();
    for (name, title, element) in scenes {
        let scene = Scene::new(element);
        let spacings: &[f64] = context.pick(&[2.0, 16.0], &[1.0, 2.0, 4.0, 8.0, 16.0, 32.0]);
        let mut errors = Vec::new();
        for spacing_m in spacings {
            context.go_on()?;
            let grid = Lattice::new(&scene, *spacing_m, half_m);
            let truth = scene.means(&grid, TRUTH.1.max((spacing_m / TRUTH.0) as usize));
            let ground = scene.ground(&grid);
            for method in Method::ALL {
                let found = scene.heights(&grid, method);
                errors.push((method, *spacing_m, error_m(&found, &truth, &ground)));
            }
            if *spacing_m == 16.0 && name == "road" {
                far = errors.iter().filter(|e| e.1 == 16.0).map(|e| e.2).collect();
            }
        }
        let scene = &scene;
        let mut works: Vec<Work> = errors
            .iter()
            .map(|(method, spacing_m, _)| {
                let (method, grid) = (*method, Lattice::new(scene, *spacing_m, half_m));
                Work::new((grid.side * grid.side) as f64, move || {
                    black_box(scene.heights(black_box(&grid), method));
                })
            })
            .collect();
        let times = in_turns(context, &mut works)?;
        let curves = spacings.iter().map(|spacing_m| {
            let of = errors
                .iter()
                .zip(&times)
                .filter(|((_, m, _), _)| m == spacing_m);
            Curve {
                name: format!("samples of {spacing_m} m"),
                points: of
                    .map(|((method, _, error_m), time)| {
                        Point::timed(method.name(), *time, *error_m)
                    })
                    .collect(),
                joined: true,
            }
        });
        report.figures.push(Figure::new(
            name,
            title,
            format!(
                "On ground that rises by 1 in 10. Error: root mean square, over the samples that the element changes, of the height \
                 against the mean of exact heights inside the sample, {} m apart or less. One thread, a square of {} m.",
                TRUTH.0,
                2.0 * half_m
            ),
            // Which samples there are is not for choice: no front over all of them.
            Content::Chart(Chart {
                marks_front: false,
                ..Chart::trade("ns per sample", "height error", "m", curves.collect())
            }),
        ));
    }
    if let [tiles, centre, _, four] = far[..] {
        report.summary.push(format!(
            "A road of 8 m on samples of 16 m is off by {tiles:.2} m as tiles are made, by {centre:.2} m if each sample takes the height at \
             its centre, and by {four:.2} m with the mean of 16 places."
        ));
    }
    Ok(report)
}

/// An element on a slope.
struct Scene {
    frame: Frame,
    design: Design,
}

/// Square samples around the middle of a scene.
struct Lattice {
    lon_rad: Vec<f64>,
    colat_rad: Vec<f64>,
    side: usize,
    spacing_m: f64,
}

fn middle() -> MapPoint {
    MapPoint::from_degrees(11.0, 47.0)
}

impl Lattice {
    fn new(scene: &Scene, spacing_m: f64, half_m: f64) -> Self {
        let side = (2.0 * half_m / spacing_m) as usize;
        let (lon_rad, colat_rad) = axes(scene, side, spacing_m);
        Self {
            lon_rad,
            colat_rad,
            side,
            spacing_m,
        }
    }
}

/// Longitudes and colatitudes of the centres of `side` × `side` samples.
fn axes(scene: &Scene, side: usize, spacing_m: f64) -> (Vec<f64>, Vec<f64>) {
    let origin = scene.frame.origin();
    let metres = Planet::EARTH.metres_per_radian(origin.colat_rad);
    let at_m = |i: usize| (i as f64 + 0.5 - side as f64 / 2.0) * spacing_m;
    let lon = (0..side).map(|i| origin.lon_rad + at_m(i) / metres.x);
    let colat = (0..side).map(|i| origin.colat_rad + at_m(i) / metres.y);
    (lon.collect(), colat.collect())
}

impl Scene {
    fn new(element: Element) -> Self {
        let prepared = Prepared::new(Planet::EARTH, Arc::new(element));
        // Their heights are given: none stands on the ground.
        let shaped = prepared.ready().cloned();
        Self {
            frame: Frame::new(Planet::EARTH, middle()),
            design: Design::new(Planet::EARTH, shaped.into_iter().collect()),
        }
    }

    /// Height of the ground: a plane of the map.
    fn ground_m(&self, lon_rad: f64) -> f64 {
        let origin = self.frame.origin();
        let metres = Planet::EARTH.metres_per_radian(origin.colat_rad);
        500.0 + 0.1 * (lon_rad - origin.lon_rad) * metres.x
    }

    fn ground(&self, grid: &Lattice) -> Vec<f64> {
        let row = grid.lon_rad.iter().map(|lon| self.ground_m(*lon));
        row.cycle().take(grid.side * grid.side).collect()
    }

    fn outcomes(&self, lon_rad: &[f64], colat_rad: &[f64], spacing_m: f64) -> Vec<f64> {
        let ground = lon_rad.iter().map(|lon| Outcome {
            height_m: self.ground_m(*lon),
            by: None,
        });
        let count = lon_rad.len() * colat_rad.len();
        let mut all: Vec<Outcome> = ground.cycle().take(count).collect();
        let samples = Samples::Map { lon_rad, colat_rad };
        self.design.outcomes(&samples, spacing_m, &mut all);
        all.iter().map(|o| o.height_m).collect()
    }

    fn heights(&self, grid: &Lattice, method: Method) -> Vec<f64> {
        match method {
            Method::Tiles => self.outcomes(&grid.lon_rad, &grid.colat_rad, grid.spacing_m),
            Method::Places(1) => self.outcomes(&grid.lon_rad, &grid.colat_rad, 0.0),
            Method::Places(n) => self.means(grid, n),
        }
    }

    /// Means of `n` × `n` exact heights in each sample, a row of samples at a time.
    fn means(&self, grid: &Lattice, n: usize) -> Vec<f64> {
        let (lon, colat) = axes(self, grid.side * n, grid.spacing_m / n as f64);
        let mut means = Vec::with_capacity(grid.side * grid.side);
        for rows in colat.chunks(n) {
            let fine = self.outcomes(&lon, rows, 0.0);
            means.extend((0..grid.side).map(|column| {
                let row = |r: usize| &fine[r * lon.len() + column * n..][..n];
                let sum: f64 = (0..n).flat_map(row).sum();
                sum / (n * n) as f64
            }));
        }
        means
    }
}

/// Root mean square error over what the element changes.
fn error_m(found: &[f64], truth: &[f64], ground: &[f64]) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for ((found, truth), ground) in found.iter().zip(truth).zip(ground) {
        if (truth - ground).abs() > 1e-9 {
            sum += (found - truth) * (found - truth);
            count += 1;
        }
    }
    libm::sqrt(sum / f64::from(count.max(1)))
}

fn vertices(at_m: &[(f64, f64, Option<f64>)]) -> Vec<Vertex> {
    let frame = Frame::new(Planet::EARTH, middle());
    let vertex = |(x, y, height_m): &(f64, f64, Option<f64>)| Vertex {
        place: frame.to_map(DVec2::new(*x, *y)),
        height_m: *height_m,
    };
    at_m.iter().map(vertex).collect()
}

fn side() -> Side {
    Side {
        cut_slope: 1.0,
        fill_slope: 0.5,
        wall: false,
        max_reach_m: 60.0,
    }
}

fn platform() -> Element {
    // Not along the samples.
    let outline = vertices(&[
        (-31.0, -28.0, None),
        (28.0, -31.0, None),
        (31.0, 28.0, None),
        (-28.0, 31.0, None),
    ]);
    Element {
        shape: Shape::Polygon(Polygon {
            outline,
            holes: Vec::new(),
            breaklines: Vec::new(),
            surface: Surface::Platform { height_m: 503.0 },
        }),
        side: side(),
    }
}

fn pit() -> Element {
    let outline = vertices(&[
        (-31.0, -28.0, Some(498.0)),
        (28.0, -31.0, Some(501.0)),
        (31.0, 28.0, Some(503.0)),
        (-28.0, 31.0, Some(497.0)),
    ]);
    let bottom = vertices(&[(-9.0, -4.0, Some(488.0)), (12.0, 7.0, Some(490.0))]);
    Element {
        shape: Shape::Polygon(Polygon {
            outline,
            holes: Vec::new(),
            breaklines: vec![bottom],
            surface: Surface::Tin,
        }),
        side: side(),
    }
}

fn road() -> Element {
    let line = vertices(&[
        (-100.0, -37.0, Some(497.0)),
        (3.0, 5.0, Some(502.0)),
        (100.0, 11.0, Some(507.0)),
    ]);
    Element {
        shape: Shape::Corridor(Corridor {
            line,
            profile: Profile::Heights,
            section: Section::Road {
                width_m: 8.0,
                crossfall_percent: 2.5,
            },
        }),
        side: side(),
    }
}
