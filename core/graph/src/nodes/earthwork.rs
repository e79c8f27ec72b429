//! Planning elements: ground heights in, planned heights out.

mod ground_shape;
mod reach;
mod reaches;

use std::sync::Arc;

use relievo_earthwork::{Design, Outcome, Prepared, Samples, Shaped};
use relievo_planet::{Grid, GridCrs, MapPoint, Planet, SampleRect};
use relievo_raster::{Bands, Block};

use super::ground::Ground;
use crate::node::{Artefact, Made};
use crate::{ContentId, IdHasher, ImageNode, Job, Known, RenderError};
use ground_shape::GroundShape;
use reaches::{Reaches, Touching};

const KIND: &str = "earthwork";

/// An element, prepared and named: made once and shared by all revisions that hold it.
pub struct PlacedElement {
    prepared: Arc<Prepared>,
    name: ContentId,
    shape: Option<Arc<GroundShape>>,
}

impl PlacedElement {
    /// Names a prepared element.
    pub fn new(prepared: Arc<Prepared>) -> Self {
        let mut id = IdHasher::default();
        prepared.identify(&mut |v| {
            id.float(v);
        });
        let name = id.finish();
        Self {
            shape: GroundShape::new(&prepared, name).map(Arc::new),
            prepared,
            name,
        }
    }

    /// The prepared element.
    pub fn prepared(&self) -> &Arc<Prepared> {
        &self.prepared
    }
}

/// The heights of a list of planning elements on a ground: its only input.
///
/// An element takes part in the name of a grid's samples only if it may reach them, so an edit gives
/// new names to tiles in its reach and to no others. Elements that stand on the ground read it on
/// grids of their own, as artefacts: the same at every zoom. Where none reaches, the ground is handed
/// through.
pub struct Earthwork {
    planet: Planet,
    elements: Vec<Arc<PlacedElement>>,
    reaches: Reaches,
}

impl Earthwork {
    /// The elements in the order of their list: later ones win.
    pub fn new(planet: Planet, elements: Vec<Arc<PlacedElement>>) -> Self {
        Self {
            planet,
            reaches: Reaches::new(&elements),
            elements,
        }
    }

    /// The same with another list. What is known of elements that both have costs nothing again: a
    /// drag costs what the dragged element does, whatever else there is.
    #[must_use]
    pub fn following(&self, planet: Planet, elements: Vec<Arc<PlacedElement>>) -> Self {
        let reaches = if self.planet == planet {
            self.reaches.follow(&elements)
        } else {
            Reaches::new(&elements)
        };
        Self {
            planet,
            elements,
            reaches,
        }
    }

    /// Whether it has these very elements on this planet.
    pub fn is_of(&self, planet: Planet, elements: &[Arc<PlacedElement>]) -> bool {
        let pairs = self.elements.iter().zip(elements);
        self.planet == planet
            && self.elements.len() == elements.len()
            && pairs.fold(true, |same, (a, b)| same & Arc::ptr_eq(a, b))
    }

    /// The elements.
    pub fn elements(&self) -> &[Arc<PlacedElement>] {
        &self.elements
    }

    /// Positions in the list of those that may change samples of a grid.
    pub fn touching(&self, grid: &Grid) -> Arc<[u32]> {
        self.found(grid).map_or_else(Arc::default, |t| t.positions)
    }

    fn found(&self, grid: &Grid) -> Option<Touching> {
        if self.elements.is_empty() || grid.rect.is_empty() {
            return None;
        }
        // A plane that shows no place has no spacing, and nothing is left out there.
        let spacing_m = self.spacing_m(grid).unwrap_or(0.0);
        Some(self.reaches.touching(grid, spacing_m, &self.elements))
    }

    /// Whether no element may change a sample of a grid.
    pub fn is_idle(&self, grid: &Grid) -> bool {
        self.touching(grid).is_empty()
    }

    fn design(&self, touching: &[u32], made: &[Made]) -> Result<Design, RenderError> {
        let mut made = made.iter();
        let mut shaped: Vec<Arc<Shaped>> = Vec::with_capacity(touching.len());
        for i in touching {
            let element = &self.elements[*i as usize];
            let shape = match element.prepared.ready() {
                Some(ready) => Some(Arc::clone(ready)),
                None => made
                    .next()
                    .and_then(|m| Arc::downcast::<Shaped>(Arc::clone(m)).ok()),
            };
            shaped.push(shape.ok_or_else(|| RenderError::Node {
                node: KIND,
                reason: "an element's heights on the ground were expected, none was made".into(),
            })?);
        }
        Ok(Design::new(self.planet, shaped))
    }

    /// Side of a sample on the ground, one for all of a lattice so that wholes equal their parts.
    fn spacing_m(&self, grid: &Grid) -> Result<f64, RenderError> {
        let lattice = &grid.lattice;
        if lattice.crs == GridCrs::Map {
            return Ok(lattice.step.y.abs() * self.planet.equatorial_radius_m);
        }
        let steps = Ground::new(lattice, KIND)?.steps_m(&self.planet, glam::I64Vec2::ZERO);
        Ok(steps.map_or(0.0, |[column, row]| column.perp_dot(row).abs().sqrt()))
    }

    /// Heights of the rows `rect` of the job's grid, in place.
    fn rows(
        design: &Design,
        grid: &Grid,
        spacing_m: f64,
        outcomes: &mut [Outcome],
    ) -> Result<(), RenderError> {
        let Grid { lattice, rect } = grid;
        let centre = |x: i64, y: i64| lattice.centre(glam::I64Vec2::new(x, y));
        let colat: Vec<f64> = (rect.min.y..rect.max.y).map(|y| centre(0, y).y).collect();
        let on_map = lattice.crs == GridCrs::Map;
        if on_map
            && colat
                .iter()
                .all(|c| (0.0..=core::f64::consts::PI).contains(c))
        {
            let lon: Vec<f64> = (rect.min.x..rect.max.x).map(|x| centre(x, 0).x).collect();
            let samples = Samples::Map {
                lon_rad: &lon,
                colat_rad: &colat,
            };
            design.outcomes(&samples, spacing_m, outcomes);
            return Ok(());
        }
        let ground = Ground::new(lattice, KIND)?;
        // What the plane shows nowhere keeps its height: far places are reached by nothing.
        let mut nowhere = Vec::new();
        let mut places = Vec::with_capacity(outcomes.len());
        for y in rect.min.y..rect.max.y {
            for x in rect.min.x..rect.max.x {
                let sample = glam::DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let place = ground.point(sample);
                if place.is_none() {
                    nowhere.push((places.len(), outcomes[places.len()]));
                }
                let before = places.last().copied().unwrap_or(MapPoint::new(0.0, 0.0));
                places.push(place.unwrap_or(before));
            }
        }
        let samples = Samples::Places {
            places: &places,
            width: rect.width() as usize,
        };
        design.outcomes(&samples, spacing_m, outcomes);
        for (k, outcome) in nowhere {
            outcomes[k] = outcome;
        }
        Ok(())
    }
}

/// Rows that are made at once.
const ROWS: i64 = 32;

impl ImageNode for Earthwork {
    fn kind(&self) -> &'static str {
        KIND
    }

    fn output(&self) -> Bands {
        Bands::Height
    }

    /// Its samples depend on nothing but those below them and artefacts, but it is no part of a run:
    /// the ground is kept while an element is dragged.
    fn is_pointwise(&self) -> bool {
        false
    }

    fn identify(&self, grid: &Grid, id: &mut IdHasher) {
        id.float(self.planet.equatorial_radius_m)
            .float(self.planet.flattening)
            .grid(grid);
        if let Some(touching) = self.found(grid) {
            id.id(touching.name);
        }
    }

    fn known(&self, _grid: &Grid, inputs: &[Known]) -> Known {
        if inputs[0].is_complete(Bands::Height) {
            Known::Complete
        } else {
            Known::Nothing
        }
    }

    fn identity(&self, grid: &Grid, _inputs: &[Known]) -> Option<usize> {
        self.is_idle(grid).then_some(0)
    }

    fn artefacts(&self, grid: &Grid) -> Vec<Arc<dyn Artefact>> {
        let touching = self.touching(grid);
        touching
            .iter()
            .filter_map(|i| self.elements[*i as usize].shape.clone())
            .map(|shape| shape as Arc<dyn Artefact>)
            .collect()
    }

    fn render(&self, job: &Job, inputs: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        self.render_from(job, &[], inputs, out)
    }

    fn render_from(
        &self,
        job: &Job,
        artefacts: &[Made],
        inputs: &[&Block],
        out: &mut Block,
    ) -> Result<(), RenderError> {
        out.samples_mut().copy_from_slice(inputs[0].samples());
        let touching = self.touching(job.grid);
        if touching.is_empty() {
            return Ok(());
        }
        let design = self.design(&touching, artefacts)?;
        let spacing_m = self.spacing_m(job.grid)?;
        let rect = job.grid.rect;
        let width = out.width();
        let mut outcomes: Vec<Outcome> = Vec::with_capacity(width * ROWS as usize);
        let mut first = rect.min.y;
        while first < rect.max.y {
            if job.cancel.is_cancelled() {
                return Err(RenderError::Cancelled);
            }
            let last = (first + ROWS).min(rect.max.y);
            let from = (first - rect.min.y) as usize * width;
            let to = (last - rect.min.y) as usize * width;
            let heights = &mut out.samples_mut()[from..to];
            outcomes.clear();
            outcomes.extend(heights.iter().map(|h| Outcome {
                height_m: f64::from(*h),
                by: None,
            }));
            let rows = SampleRect::at(rect.min.x, first, rect.width(), last - first);
            let grid = job.grid.with_rect(rows);
            Self::rows(&design, &grid, spacing_m, &mut outcomes)?;
            for (h, o) in heights.iter_mut().zip(&outcomes) {
                if o.by.is_some() {
                    *h = o.height_m as f32;
                }
            }
            first = last;
        }
        Ok(())
    }
}
