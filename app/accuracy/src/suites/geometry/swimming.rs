//! How far heights move on the screen when the focus moves by a texel.

use glam::{DVec2, DVec3};
use relievo_engine::planet::Camera;
use relievo_engine::planet::clipmap::view::View;
use relievo_engine::{Engine, Offset};
use relievo_gpu::Still;

use super::paths::Path;
use super::{Bench, Errors, Setting};
use crate::{Cell, Content, Figure, SuiteError, Table};

/// A table of settings on each path.
pub(super) fn figure(
    bench: &Bench,
    engine: &mut Engine,
    paths: &[Path],
) -> Result<Figure, SuiteError> {
    let mut rows = Vec::new();
    let meshes: &[[u32; 2]] = if bench.context.quick {
        &[[512, 40]]
    } else {
        &[[64, 8], [192, 20], [512, 40]]
    };
    for steps in meshes {
        let setting = Setting {
            steps: *steps,
            ..Setting::STANDARD
        };
        for path in paths {
            bench.context.go_on()?;
            let mut px = Vec::new();
            for camera in path.cameras(-30.0) {
                px.extend(moved(bench, engine, camera, setting)?.px);
            }
            let errors = Errors::of(px.into_iter());
            let mut row: Vec<Cell> = vec![setting.name().into(), path.name.into()];
            row.extend([errors.mean, errors.p99, errors.max].map(Cell::from));
            rows.push(row);
        }
    }
    let head = [
        "mesh, around × rows",
        "path",
        "mean, px",
        "p99, px",
        "max, px",
    ];
    Ok(Figure::new(
        "swimming",
        "Swimming: a fixed place's height on the screen when the focus moves by a texel",
        "Two converged pictures whose cameras are one sample of the finest height level apart; the difference \
         of their heights at the same places of the map, projected onto the screen, looking 30° down.",
        Content::Table(Table {
            head: head.map(str::to_owned).to_vec(),
            rows,
        }),
    ))
}

/// A camera's picture, beside one from a sample of the finest height level farther.
pub(super) struct Moved {
    pub(super) still: Still,
    pub(super) offsets: Vec<Offset>,
    /// For each pixel how far its ground moves on the screen; NaN where one of the two does not show it.
    pub(super) px: Vec<f64>,
}

pub(super) fn moved(
    bench: &Bench,
    engine: &mut Engine,
    camera: Camera,
    setting: Setting,
) -> Result<Moved, SuiteError> {
    let first = bench.draw(engine, camera, setting)?;
    let before = bench.offsets(engine, &first)?;
    let texel_rad = first
        .frame
        .heights
        .last()
        .map_or(0.0, |level| level.window.level.step_rad().y);
    let farther = Camera {
        lon_rad: camera.lon_rad + texel_rad / libm::cos(camera.lat_rad).max(0.01),
        ..camera
    };
    let second = bench.draw(engine, farther, setting)?;
    let after = bench.offsets(engine, &second)?;
    let shown = |still: &Still| {
        let read = still.renderer.read_distances();
        read.map_err(|error| SuiteError::System(error.to_string()))
    };
    let (shown_first, shown_second) = (shown(&first)?, shown(&second)?);
    let [a, b] = [&first, &second].map(Projection::of);
    let width = bench.size_px[0] as usize;
    let swims = before
        .iter()
        .zip(&shown_first)
        .enumerate()
        .map(|(i, (offset, depth))| {
            let pixel = DVec2::new((i % width) as f64, (i / width) as f64) + 0.5;
            let place = a.place(pixel, f64::from(*depth));
            let there = b.height_near(place, &after, &shown_second)?;
            // Projected as the offset itself was.
            let scale = offset.screen_px / offset.height_m.abs();
            Some((there - offset.height_m).abs() * scale)
        });
    let px = swims.map(|s| s.unwrap_or(f64::NAN)).collect();
    Ok(Moved {
        still: first,
        offsets: before,
        px,
    })
}

/// From pixels to the world and back.
struct Projection {
    view: View,
    size: DVec2,
}

impl Projection {
    fn of(still: &Still) -> Self {
        let frame = &still.frame;
        Self {
            view: View::new(&frame.camera, &frame.planet, frame.viewport_px),
            size: DVec2::from(frame.viewport_px.map(f64::from)),
        }
    }

    /// World place of a pixel's ground, metres.
    fn place(&self, pixel: DVec2, depth_m: f64) -> DVec3 {
        let at = pixel / self.size * 2.0 - 1.0;
        self.view.eye + self.view.ray(DVec2::new(at.x, -at.y)) * depth_m
    }

    /// Offset in height at a place, between the four pixels around it, where all of them show its
    /// surroundings.
    fn height_near(&self, place: DVec3, offsets: &[Offset], shown: &[f32]) -> Option<f64> {
        let from_eye = place - self.view.eye;
        let depth = from_eye.dot(self.view.forward);
        let at = DVec2::new(from_eye.dot(self.view.right), -from_eye.dot(self.view.up)) / depth;
        let pixel = 0.5 * (at / self.view.tan_half + 1.0) * self.size - 0.5;
        let corner = pixel.floor();
        let inside = corner.cmpge(DVec2::ZERO).all() && (corner + 1.0).cmplt(self.size).all();
        if depth <= 0.0 || !inside {
            return None;
        }
        let f = pixel - corner;
        let (width, first) = (self.size.x as usize, corner.as_usizevec2());
        let mut sum = 0.0;
        for (dx, dy, weight) in [
            (0, 0, (1.0 - f.x) * (1.0 - f.y)),
            (1, 0, f.x * (1.0 - f.y)),
            (0, 1, (1.0 - f.x) * f.y),
            (1, 1, f.x * f.y),
        ] {
            let i = (first.y + dy) * width + first.x + dx;
            let near = (f64::from(*shown.get(i)?) / depth - 1.0).abs() < 0.05;
            if !near {
                return None;
            }
            sum += weight * offsets.get(i)?.height_m;
        }
        Some(sum)
    }
}
