//! Plan views of a site: both versions lit from the north-west, and how their heights differ.

use core::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use glam::{DVec2, DVec3};
use relievo_analysis::{AnalysisError, LocalFrame, MapBox};
use relievo_graph::NodeIndex;
use relievo_planet::{Grid, GridCrs, Lattice, MapPoint, Planet, SampleRect};
use relievo_raster::colour::to_u8;
use relievo_raster::{Block, Cancel, normal};

use super::ground::failed;
use crate::scene::Scene;

/// Widest picture in pixels.
const WIDEST: u32 = 2048;

/// Grey of ground without colour, as sRGB.
const PLAIN: [f32; 3] = [0.78, 0.78, 0.76];

/// Colours of the difference, from deepest cut through none to highest fill, as sRGB (ColorBrewer's
/// RdBu, reversed, by Cynthia Brewer).
pub const DIFFERENCE_COLOURS: [[u8; 3]; 9] = [
    [33, 102, 172],
    [67, 147, 195],
    [146, 197, 222],
    [209, 229, 240],
    [247, 247, 247],
    [253, 219, 199],
    [244, 165, 130],
    [214, 96, 77],
    [178, 24, 43],
];

/// An opaque picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// sRGB red, green and blue, row by row from the north.
    pub rgb: Vec<u8>,
}

/// Pictures of a site, north up.
#[derive(Clone, Debug, PartialEq)]
pub struct SitePictures {
    /// The first version.
    pub a: Picture,
    /// The second version.
    pub b: Picture,
    /// Second minus first heights in [`DIFFERENCE_COLOURS`], over the second version's relief.
    pub difference: Picture,
    /// The difference in metres that the last colour means; its negative is the first colour's.
    pub range_m: f64,
    /// Metres on the ground across the pictures.
    pub width_m: f64,
    /// Longitude and latitude of the middle in degrees.
    pub centre_deg: (f64, f64),
}

impl SitePictures {
    pub(super) fn new(
        scenes: &[Arc<Scene>; 2],
        area: &MapBox,
        planet: Planet,
        width: u32,
        cancel: &Cancel,
    ) -> Result<Self, AnalysisError> {
        let plan = Plan::of(area, planet);
        let width = width.clamp(1, WIDEST);
        let spacing_m = plan.size_m.x / f64::from(width);
        let height = ((plan.size_m.y / spacing_m).round() as u32).clamp(1, WIDEST);
        let lattice = plan.lattice(DVec2::new(f64::from(width), f64::from(height)));
        let rect = SampleRect::at(0, 0, i64::from(width), i64::from(height));
        let grid = Grid::new(Arc::new(lattice), rect);
        let view = |scene: &Scene| View::of(scene, &grid, cancel);
        let (a, b) = (view(&scenes[0])?, view(&scenes[1])?);
        let differences: Vec<f32> = b
            .heights
            .iter()
            .zip(&a.heights)
            .map(|(b, a)| b - a)
            .collect();
        let largest = differences
            .iter()
            .map(|d| d.abs())
            .filter(|d| d.is_finite());
        let range_m = round_up(f64::from(largest.fold(0.0_f32, f32::max)));
        let difference = b.picture(width, height, |i| {
            let share = f64::from(differences[i]) / range_m;
            if share.is_finite() {
                diverging(share)
            } else {
                PLAIN
            }
        });
        Ok(Self {
            a: a.picture(width, height, |i| a.colour(i)),
            b: b.picture(width, height, |i| b.colour(i)),
            difference,
            range_m,
            width_m: plan.size_m.x,
            centre_deg: plan.centre.to_degrees(),
        })
    }
}

/// What a picture shows.
struct Plan {
    area: MapBox,
    /// Around a pole a frame in which that is in the middle; elsewhere the map itself.
    frame: Option<LocalFrame>,
    centre: MapPoint,
    /// Metres across and down, in the middle.
    size_m: DVec2,
}

impl Plan {
    fn of(area: &MapBox, planet: Planet) -> Self {
        let [north, south] = [area.north_colat_rad, area.south_colat_rad];
        if area.width_rad() > PI {
            let (pole, reach_rad) = if north < PI - south {
                (0.0, south)
            } else {
                (PI, PI - north)
            };
            let centre = MapPoint::new(area.west_rad, pole);
            return Self {
                area: *area,
                frame: Some(LocalFrame::new(planet, centre)),
                centre,
                size_m: DVec2::splat(2.0 * reach_rad.min(FRAC_PI_2) * planet.radius_m),
            };
        }
        let (lon, colat) = (
            f64::midpoint(area.west_rad, area.east_rad),
            f64::midpoint(north, south),
        );
        Self {
            area: *area,
            frame: None,
            centre: MapPoint::new(lon, colat).normalised(),
            size_m: planet.metres_per_radian(colat) * DVec2::new(area.width_rad(), south - north),
        }
    }

    /// So many pixels across and down.
    fn lattice(&self, pixels: DVec2) -> Lattice {
        if let Some(frame) = &self.frame {
            let corner_m = 0.5 * DVec2::new(-self.size_m.x, self.size_m.y);
            return frame.lattice(corner_m, self.size_m.x / pixels.x);
        }
        let area = &self.area;
        let size = DVec2::new(
            area.width_rad(),
            area.south_colat_rad - area.north_colat_rad,
        );
        Lattice {
            crs: GridCrs::Map,
            origin: DVec2::new(area.west_rad, area.north_colat_rad),
            step: size / pixels,
            columns_around: None,
        }
    }
}

/// A version on the grid of a picture.
struct View {
    heights: Vec<f32>,
    colour: Option<Block>,
    light: Vec<f32>,
}

impl View {
    fn of(scene: &Scene, grid: &Grid, cancel: &Cancel) -> Result<Self, AnalysisError> {
        let ask = |node: NodeIndex| scene.graph.evaluate(node, grid, cancel).map_err(failed);
        let light = match scene.roots.normal {
            Some(node) => light(&ask(node)?),
            None => vec![1.0; grid.rect.area() as usize],
        };
        Ok(Self {
            heights: ask(scene.roots.height)?.plane(0).to_vec(),
            colour: scene.roots.colour.map(ask).transpose()?,
            light,
        })
    }

    /// Colour of a pixel over plain ground.
    fn colour(&self, i: usize) -> [f32; 3] {
        let Some(colour) = &self.colour else {
            return PLAIN;
        };
        let alpha = colour.plane(3)[i];
        [0, 1, 2].map(|c| PLAIN[c] + (colour.plane(c)[i] - PLAIN[c]) * alpha)
    }

    fn picture(&self, width: u32, height: u32, colour: impl Fn(usize) -> [f32; 3]) -> Picture {
        let lit = |i: usize| colour(i).map(|c| to_u8(c * self.light[i]));
        Picture {
            width,
            height,
            rgb: (0..self.light.len()).flat_map(lit).collect(),
        }
    }
}

/// How bright ground is under a sun in the north-west, 45° high; level ground is 1.
fn light(normals: &Block) -> Vec<f32> {
    let sun = DVec3::new(-0.5, 0.5, core::f64::consts::FRAC_1_SQRT_2);
    let (east, north) = (normals.plane(0), normals.plane(1));
    east.iter()
        .zip(north)
        .map(|(x, y)| {
            let facing = normal::unit([*x, *y]).dot(sun).max(0.0) / sun.z;
            (0.35 + 0.65 * facing).min(1.3) as f32
        })
        .collect()
}

/// The colour of a difference from −1 to 1.
fn diverging(share: f64) -> [f32; 3] {
    let at = (share.clamp(-1.0, 1.0) + 1.0) * 4.0;
    let first = (at as usize).min(7);
    let part = (at - first as f64) as f32;
    let of = |i: usize, c: usize| f32::from(DIFFERENCE_COLOURS[i][c]) / 255.0;
    [0, 1, 2].map(|c| of(first, c) + (of(first + 1, c) - of(first, c)) * part)
}

/// The next 1, 2 or 5 times a power of ten; 1 for nothing.
fn round_up(value: f64) -> f64 {
    if !(value.is_finite() && value > 0.0) {
        return 1.0;
    }
    let power = 10.0_f64.powi(value.log10().floor() as i32);
    let steps = [1.0, 2.0, 5.0, 10.0];
    let fits = steps
        .into_iter()
        .find(|s| s * power >= value * (1.0 - 1e-9));
    fits.unwrap_or(10.0) * power
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_in_the_middle_of_the_colours_and_ends_are_ends() {
        let bytes = |share| diverging(share).map(to_u8);
        assert_eq!(bytes(0.0), DIFFERENCE_COLOURS[4]);
        assert_eq!(bytes(-1.0), DIFFERENCE_COLOURS[0]);
        assert_eq!(bytes(7.0), DIFFERENCE_COLOURS[8]);
    }

    #[test]
    fn ranges_are_round_and_hold_all() {
        for (value, range) in [(0.7, 1.0), (1.2, 2.0), (2.0, 2.0), (37.0, 50.0), (0.0, 1.0)] {
            assert!((round_up(value) - range).abs() < 1e-12, "{value}");
        }
    }
}
