//! Errors in the form of \[Liv07\] tables 4 to 6, beside the paper's own figures.
//!
//! What differs: the paper renders Puget Sound on a plane with a mesh that follows the screen; here are
//! a project's own grounds on a planet and a mesh that follows the map. The paper measures at vertices,
//! against the vertices of the data; here each pixel is measured, against the surface of the data, so
//! what lies between vertices counts.

use relievo_engine::Engine;

use super::paths::{Path, angles_deg};
use super::{Bench, Errors, Measured, Setting};
use crate::{Cell, Content, Figure, SuiteError, Table};

/// \[Liv07\] tables 4 and 5 for a window of 640 × 480: grid, Hausdorff distance, greatest and mean
/// screen-space error, pixels.
const BY_MESH: [(&str, [f64; 3]); 6] = [
    ("150 × 600", [3.9, 6.0, 2.3]),
    ("200 × 800", [3.8, 5.3, 2.1]),
    ("430 × 430", [1.9, 5.9, 2.2]),
    ("300 × 900", [2.2, 4.2, 1.0]),
    ("600 × 600", [1.2, 4.9, 1.6]),
    ("400 × 1600", [1.0, 3.4, 0.3]),
];

/// \[Liv07\] table 6, a grid of 200 × 800 in a window of 640 × 480: angle of view in degrees below the
/// horizon, greatest error over flat and mountainous ground, pixels.
const BY_ANGLE: [(f64, [f64; 2]); 10] = [
    (90.0, [0.1, 0.2]),
    (80.0, [0.5, 1.1]),
    (70.0, [0.6, 1.8]),
    (60.0, [1.0, 2.7]),
    (50.0, [1.3, 3.4]),
    (40.0, [1.6, 4.1]),
    (30.0, [1.8, 4.5]),
    (20.0, [1.9, 4.9]),
    (10.0, [2.1, 5.2]),
    (0.0, [2.1, 5.3]),
];

/// What both tables' captions say of the paper's figures.
const DIFFERS: &str = "Rows and columns of [Liv07] are the paper's: Puget Sound, a mesh that follows the screen, errors at vertices \
     only, 640 × 480 pixels. Ours: this project's ground, a mesh that follows the map, errors at all pixels.";

fn row(name: String, of: [f64; 3], height_px: f64) -> Vec<Cell> {
    let [distortion, max, mean] = of;
    let percent = |px: f64| Cell::from(100.0 * px / height_px);
    vec![
        name.into(),
        distortion.into(),
        max.into(),
        percent(max),
        mean.into(),
        percent(mean),
    ]
}

/// A path's meshes with the default size of a height sample.
pub(super) fn mesh_rows(path: &Path, measured: &[Measured]) -> Vec<(String, [f64; 3])> {
    let standard = measured.iter().filter(|m| {
        let steps = m.setting.steps;
        m.setting
            == Setting {
                steps,
                ..Setting::STANDARD
            }
    });
    let values = standard.map(|m| {
        let name = format!("{} ({})", m.setting.name(), path.name);
        let px = [m.distortion.hausdorff_px(), m.errors.max, m.errors.mean];
        (name, px)
    });
    values.collect()
}

/// Tables 4 and 5: errors by mesh.
pub(super) fn by_mesh(bench: &Bench, ours: Vec<(String, [f64; 3])>) -> Figure {
    let height_px = f64::from(bench.size_px[1]);
    let mut rows: Vec<Vec<Cell>> = ours
        .into_iter()
        .map(|(name, px)| row(name, px, height_px))
        .collect();
    let paper = |(name, px): &(&str, [f64; 3])| row(format!("[Liv07]: {name}"), *px, 480.0);
    rows.extend(BY_MESH.iter().map(paper));
    let head = [
        "mesh",
        "distortion, px",
        "max error, px",
        "max error, % of the height",
        "mean error, px",
        "mean error, % of the height",
    ];
    Figure::new(
        "livny-mesh",
        "Errors by mesh, as [Liv07] tables 4 and 5",
        format!(
            "{DIFFERS} Our picture is {} × {} pixels, looking 30° down.",
            bench.size_px[0], bench.size_px[1]
        ),
        Content::Table(Table {
            head: head.map(str::to_owned).to_vec(),
            rows,
        }),
    )
}

/// Table 6: errors by the angle of view.
pub(super) fn by_angle(
    bench: &Bench,
    engine: &mut Engine,
    paths: &[Path],
) -> Result<Figure, SuiteError> {
    let mut rows = Vec::new();
    for angle_deg in angles_deg(bench.context) {
        let mut row: Vec<Cell> = vec![angle_deg.into()];
        let paper = BY_ANGLE.iter().find(|(angle, _)| *angle == angle_deg);
        for (index, path) in paths.iter().enumerate() {
            bench.context.go_on()?;
            let mut all = Vec::new();
            for camera in path.cameras(-angle_deg) {
                let still = bench.draw(engine, camera, Setting::STANDARD)?;
                all.extend(bench.offsets(engine, &still)?);
            }
            let errors = Errors::of(all.iter().map(|o| o.screen_px));
            row.extend([errors.mean, errors.p99, errors.max].map(Cell::from));
            let theirs = paper.map_or(f64::NAN, |(_, px)| px[index.min(1)]);
            row.push(theirs.into());
        }
        rows.push(row);
    }
    let mut head = vec!["view angle, ° below the horizon".to_owned()];
    for path in paths {
        let errors = ["mean error", "p99 error", "max error", "[Liv07]: max error"];
        head.extend(errors.map(|e| format!("{}: {e}, px", path.name)));
    }
    Ok(Figure::new(
        "angles",
        "Screen-space error by the angle of view, as [Liv07] table 6",
        format!(
            "{DIFFERS} The paper's mesh has 200 × 800 vertices, ours is the default of a graphics processor."
        ),
        Content::Table(Table { head, rows }),
    ))
}
