//! How often each value of a layer is seen in the visible region, before and after its adjustment.

use std::sync::Arc;

use glam::{DVec2, DVec3, I64Vec2};
use relievo_graph::RenderError;
use relievo_planet::map::wrap_longitude;
use relievo_planet::{Camera, Grid, GridCrs, Lattice, MapPoint, Planet, SampleRect};
use relievo_project::LayerId;
use relievo_raster::{Bands, Block, Cancel};

use crate::Questions;
use crate::analysis::{MapBox, Task};
use crate::sampling::Stage;

/// Bins of a histogram.
pub const BINS: usize = 128;

/// Columns and rows of the samples that are taken.
const SAMPLES: I64Vec2 = I64Vec2::new(224, 160);

/// Rows that are evaluated at once.
const BAND: usize = 16;

/// Rays along a side of the picture that say which region is visible.
const RAYS: i32 = 17;

/// Counts of one plane of samples.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Counts {
    /// What the plane holds: `Height`, `Red`, `Green`, `Blue`.
    pub name: &'static str,
    /// As the source gives them, from the least value to the largest.
    pub before: Vec<u32>,
    /// As they meet what lies below.
    pub after: Vec<u32>,
}

/// A layer's values in the visible region.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// Least and largest value of the first and last bin: metres, or 0 and 1 for colours.
    pub range: (f64, f64),
    /// One for each plane.
    pub counts: Vec<Counts>,
    /// Samples that were counted.
    pub samples: u32,
}

impl Questions {
    /// Counts a layer's values on about 36,000 places that are evenly spread over the longitudes and
    /// colatitudes that a camera sees; terrain does not hide any. `None` where the layer takes no
    /// part in the picture or nothing of it is seen.
    ///
    /// - `aspect`: width / height of the picture.
    ///
    /// # Errors
    /// When a source cannot be read, or work was cancelled.
    pub fn histogram(
        &self,
        layer: &LayerId,
        camera: &Camera,
        aspect: f64,
        task: &Task,
    ) -> Result<Option<Histogram>, RenderError> {
        let Some(grid) = visible_grid(camera, &self.planet, aspect) else {
            return Ok(None);
        };
        let before = self.in_bands(layer, Stage::Source, &grid, (0.0, task))?;
        let after = self.in_bands(layer, Stage::Adjusted, &grid, (0.5, task))?;
        let (Some(before), Some(after)) = (before, after) else {
            return Ok(None);
        };
        let seen = visible(camera, &self.planet, aspect, &grid);
        Ok(count(&before, &after, &seen))
    }

    /// A layer's samples, a few rows at a time, as the second half of a task or the first.
    fn in_bands(
        &self,
        layer: &LayerId,
        stage: Stage,
        grid: &Grid,
        (done, task): (f64, &Task),
    ) -> Result<Option<Block>, RenderError> {
        let (width, height) = (grid.rect.width(), grid.rect.height());
        let mut whole: Option<Block> = None;
        for row in (0..height).step_by(BAND) {
            let rows = (BAND as i64).min(height - row);
            let rect = SampleRect::at(grid.rect.min.x, grid.rect.min.y + row, width, rows);
            let band = self.layer_samples(layer, stage, &grid.with_rect(rect), task.cancel)?;
            let Some(band) = band else { return Ok(None) };
            let size = (width as usize, height as usize);
            let whole = whole.get_or_insert_with(|| Block::new(band.bands(), size.0, size.1));
            for plane in 0..band.bands().planes() {
                let first = row as usize * size.0;
                let samples = band.plane(plane);
                whole.plane_mut(plane)[first..first + samples.len()].copy_from_slice(samples);
            }
            (task.progress)(done + 0.5 * (row + rows) as f64 / height as f64);
        }
        Ok(whole)
    }
}

impl Questions {
    /// The box around the longitudes and colatitudes that a camera sees; `None` for the sky.
    pub fn seen_area(&self, camera: &Camera, aspect: f64) -> Option<MapBox> {
        let grid = visible_grid(camera, &self.planet, aspect)?;
        let first = grid.lattice.origin;
        let last = first + SAMPLES.as_dvec2() * grid.lattice.step;
        let west_rad = wrap_longitude(first.x);
        Some(MapBox {
            west_rad,
            east_rad: west_rad + (last.x - first.x).min(core::f64::consts::TAU),
            north_colat_rad: first.y.max(0.0),
            south_colat_rad: last.y.min(core::f64::consts::PI),
        })
    }
}

/// Heights of the ground on an even grid over the longitudes and colatitudes that a camera sees.
#[derive(Clone, Debug, PartialEq)]
pub struct SeenHeights {
    /// Where the samples lie, 224 by 160.
    pub grid: Grid,
    /// Metres above the datum, row by row.
    pub heights_m: Vec<f32>,
}

impl Questions {
    /// Heights of the ground over what a camera sees; `None` for the sky. The same camera gives the
    /// same grid, so that two revisions can be compared.
    ///
    /// # Errors
    /// When a source cannot be read, or work was cancelled.
    pub fn seen_heights(
        &self,
        camera: &Camera,
        aspect: f64,
        cancel: &Cancel,
    ) -> Result<Option<SeenHeights>, RenderError> {
        let Some(grid) = visible_grid(camera, &self.planet, aspect) else {
            return Ok(None);
        };
        let root = self.scene.roots.height;
        let heights = self.scene.graph.evaluate(root, &grid, cancel)?;
        Ok(Some(SeenHeights {
            grid,
            heights_m: heights.plane(0).to_vec(),
        }))
    }
}

/// A grid over the longitudes and colatitudes that a camera sees; `None` for the sky.
fn visible_grid(camera: &Camera, planet: &Planet, aspect: f64) -> Option<Grid> {
    let side = |i: i32| 2.0 * f64::from(i) / f64::from(RAYS - 1) - 1.0;
    let rays = (0..RAYS).flat_map(|j| (0..RAYS).map(move |i| DVec2::new(side(i), side(j))));
    let seen: Vec<MapPoint> = rays
        .filter_map(|ndc| camera.ground_at(planet, 0.0, ndc, aspect))
        .map(MapPoint::from_direction)
        .collect();
    let first = *seen.first()?;
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for point in &seen {
        let east = wrap_longitude(point.lon_rad - first.lon_rad);
        let at = DVec2::new(first.lon_rad + east, point.colat_rad);
        (low, high) = (low.min(at), high.max(at));
    }
    // Beyond half a turn a pole is seen, or so much that all longitudes are as good.
    if high.x - low.x > core::f64::consts::PI {
        (low.x, high.x) = (-core::f64::consts::PI, core::f64::consts::PI);
        if low.y < core::f64::consts::PI - high.y {
            low.y = 0.0;
        } else {
            high.y = core::f64::consts::PI;
        }
    }
    let least = 1e-9;
    let step = ((high - low) / SAMPLES.as_dvec2()).max(DVec2::splat(least));
    let lattice = Lattice {
        crs: GridCrs::Map,
        origin: low,
        step,
        columns_around: None,
    };
    Some(Grid::new(
        Arc::new(lattice),
        SampleRect::new(I64Vec2::ZERO, SAMPLES),
    ))
}

/// Which samples of a grid are inside the picture and on the near side.
fn visible(camera: &Camera, planet: &Planet, aspect: f64, grid: &Grid) -> Vec<bool> {
    let (eye, basis) = (camera.eye(planet), camera.basis(planet));
    let half_y = (0.5 * camera.fov_y_rad).tan();
    let half = DVec2::new(half_y * aspect, half_y);
    let is_seen = |point: DVec3| {
        let view = basis.view_from_world(point - eye);
        view.z > 0.0
            && view.x.abs() <= half.x * view.z
            && view.y.abs() <= half.y * view.z
            && point.dot(eye) > planet.radius_m * planet.radius_m
    };
    let rows = (0..SAMPLES.y).flat_map(|j| (0..SAMPLES.x).map(move |i| I64Vec2::new(i, j)));
    rows.map(|at| is_seen(grid.lattice.map_point(at).to_unit() * planet.radius_m))
        .collect()
}

fn count(before: &Block, after: &Block, seen: &[bool]) -> Option<Histogram> {
    let names: &[&'static str] = match before.bands() {
        Bands::Height => &["Height"],
        Bands::Colour => &["Red", "Green", "Blue"],
        Bands::Mask | Bands::Normal => return None,
    };
    if after.bands() != before.bands() {
        return None;
    }
    let is_there = |block: &Block, at: usize| match block.bands() {
        Bands::Colour => block.plane(3)[at] > 0.0,
        Bands::Height | Bands::Mask | Bands::Normal => !block.plane(0)[at].is_nan(),
    };
    let chosen = |block: &Block| -> Vec<usize> {
        let all = (0..seen.len()).filter(|at| seen[*at]);
        all.filter(|at| is_there(block, *at)).collect()
    };
    let (at_before, at_after) = (chosen(before), chosen(after));
    if at_before.is_empty() {
        return None;
    }
    let range = if before.bands() == Bands::Height {
        let values = at_before.iter().map(|at| before.plane(0)[*at]);
        let values = values.chain(at_after.iter().map(|at| after.plane(0)[*at]));
        let (low, high) = values.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), v| {
            (low.min(v), high.max(v))
        });
        (f64::from(low), f64::from(high))
    } else {
        (0.0, 1.0)
    };
    let bins = |block: &Block, plane: usize, at: &[usize]| {
        let mut bins = vec![0_u32; BINS];
        let scale = BINS as f64 / (range.1 - range.0).max(1e-9);
        for at in at {
            let value = f64::from(block.plane(plane)[*at]);
            let bin = ((value - range.0) * scale).clamp(0.0, BINS as f64 - 1.0);
            bins[bin as usize] += 1;
        }
        bins
    };
    let of_plane = |(plane, name): (usize, &&'static str)| Counts {
        name,
        before: bins(before, plane, &at_before),
        after: bins(after, plane, &at_after),
    };
    Some(Histogram {
        range,
        counts: names.iter().enumerate().map(of_plane).collect(),
        samples: at_before.len() as u32,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const EARTH: Planet = Planet::EARTH;

    fn seen(camera: &Camera) -> (Grid, usize) {
        let grid = visible_grid(camera, &EARTH, 1.5).unwrap();
        let seen = visible(camera, &EARTH, 1.5, &grid);
        (grid, seen.into_iter().filter(|s| *s).count())
    }

    #[test]
    fn the_grid_covers_what_is_seen_also_across_the_date_line_and_a_pole() {
        for (lon, lat, altitude) in [
            (10.0, 45.0, 2e4),
            (179.99, -30.0, 3e5),
            (33.0, 89.9, 1e6),
            (0.0, 0.0, 2e7),
        ] {
            let camera = Camera::from_degrees(lon, lat, altitude, 20.0, -80.0, 50.0).unwrap();
            let (grid, count) = seen(&camera);
            assert!(count > 6_000, "{lon} {lat}: {count}");
            for ndc in [DVec2::ZERO, DVec2::new(0.9, 0.9), DVec2::new(-0.9, -0.5)] {
                let Some(hit) = camera.ground_at(&EARTH, 0.0, ndc, 1.5) else {
                    continue;
                };
                let point = MapPoint::from_direction(hit);
                let plane = DVec2::new(point.lon_rad, point.colat_rad);
                let around = core::f64::consts::TAU / grid.lattice.step.x;
                let mut at = grid.lattice.sample_from_plane(plane);
                at.x = at.x.rem_euclid(around);
                assert!(
                    at.x <= 224.5 && (-0.5..=160.5).contains(&at.y),
                    "{lon} {lat} {ndc}: {at}"
                );
            }
        }
    }

    #[test]
    fn the_sky_has_no_histogram() {
        let camera = Camera::from_degrees(0.0, 0.0, 100.0, 0.0, 60.0, 30.0).unwrap();
        assert!(visible_grid(&camera, &EARTH, 1.5).is_none());
    }

    #[test]
    fn counts_add_up_and_absent_samples_are_left_out() {
        let mut before = Block::filled(Bands::Height, 4, 1, &[5.0]);
        before
            .samples_mut()
            .copy_from_slice(&[0.0, 1.0, f32::NAN, 3.0]);
        let mut after = before.clone();
        after.samples_mut().iter_mut().for_each(|v| *v *= 2.0);
        let found = count(&before, &after, &[true, true, true, false]).unwrap();
        assert_eq!(found.range, (0.0, 2.0));
        assert_eq!(found.samples, 2);
        let sum = |bins: &[u32]| bins.iter().sum::<u32>();
        assert_eq!(
            (sum(&found.counts[0].before), sum(&found.counts[0].after)),
            (2, 2)
        );
        assert_eq!(
            (
                found.counts[0].before[BINS / 2],
                found.counts[0].after[BINS - 1]
            ),
            (1, 1)
        );
        assert!(count(&before, &after, &[false; 4]).is_none());
    }
}
