//! Surface normals from heights.

use glam::I64Vec2;
use relievo_planet::{Grid, GridCrs, Planet, SampleRect};
use relievo_raster::normal::coordinates_of_slope;
use relievo_raster::vector::on_widest;
use relievo_raster::{Bands, Block};

use super::ground::Ground;
use crate::{IdHasher, ImageNode, Job, Known, RenderError};

const KIND: &str = "normals";

/// The unit normal of the surface of heights in the local frame of each sample, as the coordinates of
/// [`relievo_raster::normal`]. Input: heights.
///
/// With e the exaggeration, the slopes are central differences over the distance on the ellipsoid
/// (M towards north, N sin θ towards east), at height 0:
///
/// - zx = e (h east − h west) / (2 Δx), zy = e (h north − h south) / (2 Δy)
/// - normal ∝ (−zx, −zy, 1)
///
/// Where one neighbour has no height the difference is one-sided, where nothing is left the ground
/// counts as level. On a level of many columns near a pole Δx goes to 0 with sin θ while Δy does not:
/// slopes stay right as long as heights are smooth on the ground, which holds for levels whose m
/// falls towards the poles; otherwise the east component shows the noise of heights. On projected
/// grids the differences go along columns and rows and are turned to east and north.
#[derive(Clone, Copy, Debug)]
pub struct Normals {
    planet: Planet,
    exaggeration: f64,
}

impl Normals {
    /// `exaggeration` is the factor of heights, finite (else 1); 1 is natural.
    pub fn new(planet: Planet, exaggeration: f64) -> Self {
        Self {
            planet,
            exaggeration: if exaggeration.is_finite() {
                exaggeration
            } else {
                1.0
            },
        }
    }
}

/// Mean difference of a sample to the neighbours before and after it.
#[inline(always)]
fn difference(before: f32, here: f32, after: f32) -> f32 {
    let both = (after - before) * 0.5;
    let (ahead, behind) = (after - here, here - before);
    let one = if ahead.is_nan() { behind } else { ahead };
    let any = if both.is_nan() { one } else { both };
    if any.is_nan() { 0.0 } else { any }
}

/// A row of heights with one more sample on either side, between the rows north and south of it.
struct Rows<'a> {
    north: &'a [f32],
    here: &'a [f32],
    south: &'a [f32],
}

impl Rows<'_> {
    /// Calls `each` with the differences to the east and to the south.
    #[inline(always)]
    fn differences(
        &self,
        east: &mut [f32],
        north: &mut [f32],
        each: impl Fn(f32, f32) -> [f32; 2],
    ) {
        let width = east.len();
        let (west, here, right) = (
            &self.here[..width],
            &self.here[1..=width],
            &self.here[2..width + 2],
        );
        let (above, below) = (&self.north[1..=width], &self.south[1..=width]);
        for i in 0..width {
            let across = difference(west[i], here[i], right[i]);
            let down = difference(above[i], here[i], below[i]);
            [east[i], north[i]] = each(across, down);
        }
    }
}

impl ImageNode for Normals {
    fn kind(&self) -> &'static str {
        KIND
    }

    fn version(&self) -> u32 {
        2
    }

    fn output(&self) -> Bands {
        Bands::Normal
    }

    fn is_pointwise(&self) -> bool {
        false
    }

    fn required(&self, _input: usize, out: SampleRect) -> SampleRect {
        if out.is_empty() { out } else { out.grow(1) }
    }

    fn invalidated(&self, _input: usize, changed: SampleRect) -> SampleRect {
        if changed.is_empty() {
            changed
        } else {
            changed.grow(1)
        }
    }

    fn identify(&self, grid: &Grid, id: &mut IdHasher) {
        id.float(self.planet.equatorial_radius_m)
            .float(self.planet.flattening)
            .float(self.exaggeration);
        id.int(grid.rect.min.y).int(grid.rect.max.y);
        if grid.lattice.crs == GridCrs::Map {
            // Around the planet all columns are alike.
            id.float(grid.lattice.origin.y)
                .float(grid.lattice.step.x)
                .float(grid.lattice.step.y);
        } else {
            id.int(grid.rect.min.x).int(grid.rect.max.x);
            id.lattice(&grid.lattice);
        }
    }

    fn known(&self, _grid: &Grid, inputs: &[Known]) -> Known {
        // Also where there is no height at all.
        if matches!(inputs[0], Known::Uniform(_)) {
            Known::Uniform([0.0; 4])
        } else {
            Known::Nothing
        }
    }

    fn render(&self, job: &Job, inputs: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        let Grid { lattice, rect } = job.grid;
        let ground = Ground::new(lattice, KIND)?;
        let width = out.width();
        let (heights, stride) = (inputs[0].plane(0), inputs[0].width());
        let [east, north] = out.planes_mut();
        let lines = east
            .chunks_exact_mut(width.max(1))
            .zip(north.chunks_exact_mut(width.max(1)));
        for (row, (east, north)) in lines.enumerate() {
            if job.cancel.is_cancelled() {
                return Err(RenderError::Cancelled);
            }
            let line = |k: usize| &heights[(row + k) * stride..(row + k + 1) * stride];
            let rows = Rows {
                north: line(0),
                here: line(1),
                south: line(2),
            };
            let y = rect.min.y + row as i64;
            if lattice.crs == GridCrs::Map {
                let colat_rad = lattice.map_point(I64Vec2::new(0, y)).colat_rad;
                let step_m = self.planet.metres_per_radian(colat_rad) * lattice.step;
                let per_x = (self.exaggeration / step_m.x) as f32;
                let per_y = (-self.exaggeration / step_m.y) as f32;
                on_widest(
                    #[inline(always)]
                    || {
                        rows.differences(east, north, |across, down| {
                            coordinates_of_slope(across * per_x, down * per_y)
                        });
                    },
                );
            } else {
                rows.differences(east, north, |across, down| [across, down]);
                for (i, (east, north)) in east.iter_mut().zip(north).enumerate() {
                    let steps =
                        ground.steps_m(&self.planet, I64Vec2::new(rect.min.x + i as i64, y));
                    [*east, *north] = steps.map_or([0.0; 2], |[column, down]| {
                        // Slopes g with g · column step = one difference, g · row step = the other.
                        let (a, b) = (
                            f64::from(*east) * self.exaggeration,
                            f64::from(*north) * self.exaggeration,
                        );
                        let area = column.perp_dot(down);
                        let (zx, zy) = (
                            (a * down.y - b * column.y) / area,
                            (b * column.x - a * down.x) / area,
                        );
                        if zx.is_finite() && zy.is_finite() {
                            coordinates_of_slope(zx as f32, zy as f32)
                        } else {
                            [0.0; 2]
                        }
                    });
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DVec2;
    use relievo_planet::{Lattice, LevelKey};
    use relievo_raster::Cancel;
    use relievo_raster::normal::unit;

    use super::*;

    fn normals(lattice: Lattice, rect: SampleRect, heights: impl Fn(i64, i64) -> f32) -> Block {
        let node = Normals::new(Planet::EARTH, 1.0);
        let around = node.required(0, rect);
        let mut input = Block::new(
            Bands::Height,
            around.width() as usize,
            around.height() as usize,
        );
        let width = input.width();
        for (i, h) in input.samples_mut().iter_mut().enumerate() {
            *h = heights(
                around.min.x + (i % width) as i64,
                around.min.y + (i / width) as i64,
            );
        }
        let mut out = Block::new(Bands::Normal, rect.width() as usize, rect.height() as usize);
        let grid = Grid::new(Arc::new(lattice), rect);
        node.render(
            &Job {
                grid: &grid,
                cancel: &Cancel::default(),
            },
            &[&input],
            &mut out,
        )
        .unwrap();
        out
    }

    #[test]
    fn a_plane_rising_east_leans_west_by_its_slope() {
        let lattice = LevelKey::new(10, 9).lattice();
        let y = 60_000;
        let colat = lattice.map_point(I64Vec2::new(0, y)).colat_rad;
        let dx = Planet::EARTH.metres_per_radian(colat).x * lattice.step.x;
        let out = normals(lattice, SampleRect::at(0, y, 4, 1), |x, _| {
            (x as f64 * dx * 0.75) as f32
        });
        for (e, n) in out.plane(0).iter().zip(out.plane(1)) {
            let normal = unit([*e, *n]);
            assert!(
                (normal.x + 0.6).abs() < 1e-3 && normal.y.abs() < 1e-6,
                "{normal}"
            );
        }
    }

    #[test]
    fn rows_agree_with_single_samples_to_the_bit() {
        let height = |x: i64, y: i64| match (x * 7 + y * 13) % 11 {
            0 => f32::NAN,
            k => k as f32 * 37.5 + x as f32,
        };
        let lattice = LevelKey::new(10, 9).lattice();
        let (rect, step) = (SampleRect::at(5, 60_000, 83, 3), lattice.step);
        let out = normals(lattice.clone(), rect, height);
        for (i, (e, n)) in out.plane(0).iter().zip(out.plane(1)).enumerate() {
            let (x, y) = (5 + i as i64 % 83, 60_000 + i as i64 / 83);
            let colat = lattice.map_point(I64Vec2::new(0, y)).colat_rad;
            let step_m = Planet::EARTH.metres_per_radian(colat) * step;
            let across = difference(height(x - 1, y), height(x, y), height(x + 1, y));
            let down = difference(height(x, y - 1), height(x, y), height(x, y + 1));
            let (zx, zy) = (
                across * (1.0 / step_m.x) as f32,
                down * (-1.0 / step_m.y) as f32,
            );
            let [east, north] = coordinates_of_slope(zx, zy);
            assert_eq!(
                (e.to_bits(), n.to_bits()),
                (east.to_bits(), north.to_bits()),
                "{i}"
            );
        }
    }

    #[test]
    fn a_plane_rising_south_leans_north() {
        let out = normals(
            LevelKey::new(10, 9).lattice(),
            SampleRect::at(0, 60_000, 2, 2),
            |_, y| y as f32 * 100.0,
        );
        assert!(
            out.plane(1).iter().all(|n| unit([0.0, *n]).y > 0.5)
                && out.plane(0).iter().all(|e| *e == 0.0)
        );
    }

    #[test]
    fn holes_make_differences_one_sided_and_all_holes_level() {
        assert_eq!(difference(1.0, 2.0, f32::NAN), 1.0);
        assert_eq!(difference(f32::NAN, 2.0, 5.0), 3.0);
        assert_eq!(difference(1.0, f32::NAN, 5.0), 2.0);
        assert_eq!(difference(1.0, f32::NAN, f32::NAN), 0.0);
        let out = normals(
            LevelKey::new(1, 0).lattice(),
            SampleRect::at(5, 5, 3, 3),
            |_, _| f32::NAN,
        );
        assert!(out.samples().iter().all(|v| *v == 0.0));
    }

    #[test]
    fn infinite_heights_give_no_nan() {
        let spike = |x: i64, _| if x == 6 { f32::INFINITY } else { -f32::MAX };
        let out = normals(
            LevelKey::new(1, 0).lattice(),
            SampleRect::at(4, 5, 5, 3),
            spike,
        );
        assert!(
            out.samples().iter().all(|v| !v.is_nan()),
            "{:?}",
            out.samples()
        );
    }

    #[test]
    fn a_projected_grid_agrees_with_the_map() {
        let lattice = Lattice {
            crs: GridCrs::Projected("EPSG:32633".into()),
            origin: DVec2::new(500_000.0, 5_000_000.0),
            step: DVec2::new(30.0, -30.0),
            columns_around: None,
        };
        let out = normals(lattice, SampleRect::at(0, 0, 3, 3), |x, y| {
            (x as f32 - y as f32) * 15.0
        });
        // On the central meridian: zx = ½, zy = ½, so both components are −½ / √1.5.
        for (x, y) in out.plane(0).iter().zip(out.plane(1)) {
            let normal = unit([*x, *y]);
            let off = (normal + 0.408_25).truncate().abs();
            assert!(off.max_element() < 1e-3, "{normal}");
        }
    }
}
