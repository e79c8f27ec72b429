//! Questions about single places, answered at the data's own resolution and not from the screen.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use relievo_earthwork::Part;
use relievo_graph::{Graph, NodeIndex, RenderError};
use relievo_planet::clipmap::levels::{columns_exponent, reach_rad};
use relievo_planet::{Grid, GridCrs, Lattice, LevelKey, MapPoint, Planet, SampleRect};
use relievo_project::LayerId;
use relievo_raster::colour::to_u8;
use relievo_raster::{Bands, Block, Cancel};

use crate::scene::Scene;

/// Side in samples of the windows whose levels are asked.
const WINDOW: u32 = 1024;

/// What is said of measures where detail is shown.
pub(crate) const WITHOUT_DETAIL: &str =
    "Detail beyond the data's own resolution is left out of all measures.";

/// What a project has at a place.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct PlaceAnswer {
    /// Longitude in degrees, −180 ≤ lon < 180.
    pub lon_deg: f64,
    /// Latitude in degrees.
    pub lat_deg: f64,
    /// Height in metres above the datum, without exaggeration.
    pub height_m: f64,
    /// Height by the data alone, where detail beyond their resolution changes it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub data_height_m: Option<f64>,
    /// There: wavelengths below this, in metres, are synthesised.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub synthesised_below_m: Option<f64>,
    /// Straight red, green, blue and alpha as 8-bit sRGB; `None` where the project has no colour.
    pub colour: Option<[u8; 4]>,
    /// Colour by the files alone, where detail beyond their resolution changes it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub data_colour: Option<[u8; 4]>,
    /// There: patterns shorter than this, in metres, are synthesised.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub colour_synthesised_below_m: Option<f64>,
    /// Slope of the ground in degrees.
    pub slope_deg: Option<f64>,
    /// What made the height, in order of evaluation.
    pub height_made_by: Vec<Maker>,
    /// What made the colour, in order of evaluation.
    pub colour_made_by: Vec<Maker>,
    /// Spacing in metres at which the answer was evaluated.
    pub spacing_m: f64,
}

/// A node that had a part in a value.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Maker {
    /// Kind of the node.
    pub node: &'static str,
    /// The layer it belongs to.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub layer: Option<String>,
    /// The planning element that decides there, by its id.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub element: Option<String>,
    /// How the element decides the height: by its `interior`, by a `cut`, a `fill` or a `wall` beside it,
    /// or by a `brush`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub part: Option<&'static str>,
}

impl Maker {
    /// Whether it draws colours of planning elements.
    fn is_of_elements(&self) -> bool {
        self.node == "vector" && self.layer.is_none()
    }
}

fn name_of(part: Part) -> &'static str {
    match part {
        Part::Interior => "interior",
        Part::Cut => "cut",
        Part::Fill => "fill",
        Part::Wall => "wall",
        Part::Brush => "brush",
    }
}

/// A revision that questions can be asked of on any thread, whatever happens to the project
/// meanwhile.
#[derive(Clone)]
pub struct Questions {
    pub(crate) scene: Arc<Scene>,
    /// The same without synthesised detail: what is measured.
    pub(crate) surveyed: Arc<Scene>,
    pub(crate) planet: Planet,
}

impl Questions {
    /// Height, colour and slope at a place, evaluated there at the spacing of the finest data; the colour, where
    /// anything is synthesised, as it is drawn.
    ///
    /// # Errors
    /// When a source cannot be read, or work was cancelled.
    pub fn place(&self, point: MapPoint, cancel: &Cancel) -> Result<PlaceAnswer, RenderError> {
        let scene = &self.scene;
        let point = point.normalised();
        let step_rad = LevelKey::new(0, scene.finest_of_ground()).step_rad().y;
        let grid = one_sample(point, step_rad);
        let ask = |node: NodeIndex| -> Result<Block, RenderError> {
            scene.graph.evaluate(node, &grid, cancel)
        };
        let height_m = f64::from(ask(scene.roots.height)?.samples()[0]);
        let detail = self.detail(height_m, &grid, cancel)?;
        let shown_grid = if scene.is_synthesised() {
            level_sample(point, scene.finest_near(point, WINDOW))
        } else {
            grid.clone()
        };
        let colour = colour_of(scene, &shown_grid, cancel)?;
        let colour_detail = self.colour_detail(colour, &shown_grid, cancel)?;
        let slope_deg = match scene.roots.normal {
            Some(_) => Some(self.slope_deg(point, step_rad, cancel)?),
            None => None,
        };
        let (lon_deg, lat_deg) = point.to_degrees();
        let mut height_made_by = self.makers(&scene.graph, scene.roots.height, &grid);
        if let Some((element, part)) = self.decides(point, &grid, cancel)? {
            for maker in height_made_by.iter_mut().filter(|m| m.node == "earthwork") {
                maker.element = Some(element.id.0.clone());
                maker.part = Some(name_of(part));
            }
        }
        let makers = |root| self.makers(&scene.graph, root, &shown_grid);
        let mut colour_made_by = scene.roots.colour.map_or_else(Vec::new, makers);
        // What no layer draws, elements do; the one on top is the last.
        let painted = colour_made_by.iter_mut().rev();
        if let Some(maker) = painted.into_iter().find(|m| m.is_of_elements()) {
            maker.element = self.colours(&grid).map(|e| e.id.0.clone());
        }
        Ok(PlaceAnswer {
            lon_deg,
            lat_deg,
            height_m,
            data_height_m: detail.map(|(data_m, _)| data_m),
            synthesised_below_m: detail.map(|(_, below_m)| below_m),
            colour,
            data_colour: colour_detail.map(|(data, _)| data),
            colour_synthesised_below_m: colour_detail.map(|(_, below_m)| below_m),
            slope_deg,
            height_made_by,
            colour_made_by,
            spacing_m: step_rad * self.planet.radius_m,
        })
    }

    /// The same project without detail beyond the data's own resolution, as measurements see it: for files
    /// that are to hold nothing made up.
    #[must_use]
    pub fn without_detail(&self) -> Self {
        Self {
            scene: Arc::clone(&self.surveyed),
            ..self.clone()
        }
    }

    /// What measurements leave out of the shown ground, in a sentence; `None` if they leave out nothing.
    pub fn left_out_of_measures(&self) -> Option<&'static str> {
        (!Arc::ptr_eq(&self.scene, &self.surveyed)).then_some(WITHOUT_DETAIL)
    }

    /// The data's own height where detail changes it, and the wavelength below which that is made up.
    fn detail(
        &self,
        height_m: f64,
        grid: &Grid,
        cancel: &Cancel,
    ) -> Result<Option<(f64, f64)>, RenderError> {
        let (scene, surveyed) = (&self.scene, &self.surveyed);
        if Arc::ptr_eq(scene, surveyed) {
            return Ok(None);
        }
        let data = surveyed
            .graph
            .evaluate(surveyed.roots.height, grid, cancel)?;
        let data_m = f64::from(data.samples()[0]);
        if data_m == height_m || (data_m.is_nan() && height_m.is_nan()) {
            return Ok(None);
        }
        // The source on top that has heights there.
        for node in scene
            .graph
            .made_by(scene.roots.height, grid)
            .into_iter()
            .rev()
        {
            let Some(below_m) = scene.synthesised_below_m(node) else {
                continue;
            };
            if !scene.graph.evaluate(node, grid, cancel)?.samples()[0].is_nan() {
                return Ok(Some((data_m, below_m)));
            }
        }
        Ok(None)
    }

    /// The files' own colour where detail changes it, and how long patterns are that are made up.
    fn colour_detail(
        &self,
        colour: Option<[u8; 4]>,
        grid: &Grid,
        cancel: &Cancel,
    ) -> Result<Option<([u8; 4], f64)>, RenderError> {
        let (scene, surveyed) = (&self.scene, &self.surveyed);
        let Some(root) = scene.roots.colour.filter(|_| !Arc::ptr_eq(scene, surveyed)) else {
            return Ok(None);
        };
        let data = colour_of(surveyed, grid, cancel)?;
        let Some(data) = data.filter(|data| Some(*data) != colour) else {
            return Ok(None);
        };
        // The layer on top that has colours there.
        for node in scene.graph.made_by(root, grid).into_iter().rev() {
            let is_colour = scene.graph.node(node).output() == Bands::Colour;
            let Some(below_m) = scene.synthesised_below_m(node).filter(|_| is_colour) else {
                continue;
            };
            if scene.graph.evaluate(node, grid, cancel)?.samples()[3] > 0.0 {
                return Ok(Some((data, below_m)));
            }
        }
        Ok(None)
    }

    /// Slope from central differences along two great circles that cross at the point, so that a
    /// pole is a place like any other.
    fn slope_deg(
        &self,
        point: MapPoint,
        step_rad: f64,
        cancel: &Cancel,
    ) -> Result<f64, RenderError> {
        let up = point.to_unit();
        let along = [
            up.any_orthonormal_vector(),
            up.cross(up.any_orthonormal_vector()),
        ];
        let height_at = |direction: DVec3| -> Result<f64, RenderError> {
            let grid = one_sample(
                MapPoint::from_direction(up + direction * step_rad),
                step_rad,
            );
            let heights = self
                .scene
                .graph
                .evaluate(self.scene.roots.height, &grid, cancel)?;
            Ok(f64::from(heights.samples()[0]))
        };
        let run_m = 2.0 * step_rad * self.planet.meridian_radius_m(point.lat_rad());
        let mut steepness_sq = 0.0;
        for direction in along {
            let rise_m = height_at(direction)? - height_at(-direction)?;
            steepness_sq += (rise_m / run_m).powi(2);
        }
        Ok(steepness_sq.sqrt().atan().to_degrees())
    }

    fn makers(&self, graph: &Graph, node: NodeIndex, grid: &Grid) -> Vec<Maker> {
        let named = |id: &LayerId| id.0.clone();
        graph
            .made_by(node, grid)
            .into_iter()
            .map(|n| Maker {
                node: graph.node(n).kind(),
                layer: self.scene.layers.of.get(&n).map(named),
                element: None,
                part: None,
            })
            .collect()
    }
}

/// The colour of one sample, where a scene has colours.
fn colour_of(scene: &Scene, grid: &Grid, cancel: &Cancel) -> Result<Option<[u8; 4]>, RenderError> {
    let Some(root) = scene.roots.colour else {
        return Ok(None);
    };
    let block = scene.graph.evaluate(root, grid, cancel)?;
    let samples = block.samples();
    Ok(Some([0, 1, 2, 3].map(|i| to_u8(samples[i]))))
}

/// The sample of a level around a point, as a window of [`WINDOW`] samples draws it: what is synthesised
/// depends on the level's lattice.
fn level_sample(point: MapPoint, n: u8) -> Grid {
    let reach_rad = reach_rad(n, WINDOW);
    let level = LevelKey::new(columns_exponent(n, point.colat_rad, reach_rad, WINDOW), n);
    let at = level.sample_from_map(point).floor().as_i64vec2();
    Grid::new(Arc::new(level.lattice()), SampleRect::at(at.x, at.y, 1, 1))
}

/// A grid of one sample, square on the ground, with its centre at a point.
fn one_sample(point: MapPoint, step_rad: f64) -> Grid {
    let step = DVec2::new(step_rad / point.colat_rad.sin().max(step_rad), step_rad);
    let lattice = Lattice {
        crs: GridCrs::Map,
        origin: DVec2::new(point.lon_rad, point.colat_rad) - 0.5 * step,
        step,
        columns_around: None,
    };
    Grid::new(Arc::new(lattice), SampleRect::at(0, 0, 1, 1))
}
