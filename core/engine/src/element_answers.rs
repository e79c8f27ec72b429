//! Questions about planning elements: their shapes, where their work ends, what is odd about them.

use std::sync::Arc;

use relievo_earthwork::{DaylightLine, Design, Ending, Part, Prepared, Shaped};
use relievo_graph::RenderError;
use relievo_planet::{Grid, MapPoint};
use relievo_project::{Element, ElementId};
use relievo_raster::Cancel;

use crate::element_colours;
use crate::query::Questions;

/// Where an element's work ends, and what is odd about it on this ground.
#[derive(Clone, Debug, PartialEq)]
pub struct ElementAnswer {
    /// Where slopes meet the ground, and walls where they do not.
    pub daylight: Vec<DaylightLine>,
    /// What is odd, a line each.
    pub warnings: Vec<String>,
}

impl Questions {
    /// Ids of all planning elements that take part, the first at the bottom.
    pub fn elements(&self) -> impl Iterator<Item = &ElementId> {
        self.scene.elements.all.iter().map(|e| &e.id)
    }

    /// Heights of the ground, without planning elements, at places, read about `spacing_m` metres
    /// apart; NaN where there are none.
    ///
    /// # Errors
    /// When a source cannot be read, or work was cancelled.
    pub fn ground_heights_m(
        &self,
        places: &[MapPoint],
        spacing_m: f64,
        cancel: &Cancel,
    ) -> Result<Vec<f64>, RenderError> {
        let scene = &self.scene;
        let ground = scene.roots.ground;
        scene
            .graph
            .heights_at(ground, &self.planet, places, spacing_m, cancel)
    }

    /// The element's exact shape on this ground; `None` if it takes no part.
    ///
    /// # Errors
    /// When a source cannot be read, or work was cancelled.
    pub fn element_shape(
        &self,
        id: &ElementId,
        cancel: &Cancel,
    ) -> Result<Option<Arc<Shaped>>, RenderError> {
        match self.prepared(id) {
            Some(prepared) => self.shape(&prepared, cancel).map(Some),
            None => Ok(None),
        }
    }

    /// All elements' exact shapes on this ground, in the order of [`Self::elements`].
    ///
    /// # Errors
    /// When a source cannot be read, or work was cancelled.
    pub fn design(&self, cancel: &Cancel) -> Result<Design, RenderError> {
        let node = self.scene.elements.node.as_ref();
        let placed = node.map_or(&[][..], |node| node.elements());
        let shapes: Result<Vec<Arc<Shaped>>, RenderError> = placed
            .iter()
            .map(|p| self.shape(p.prepared(), cancel))
            .collect();
        Ok(Design::new(self.planet, shapes?))
    }

    /// Where an element's work ends, taken alone, on cells of `spacing_m` metres, and what is odd
    /// about it; `None` if it takes no part.
    ///
    /// # Errors
    /// When a source cannot be read, or work was cancelled.
    pub fn element(
        &self,
        id: &ElementId,
        spacing_m: f64,
        cancel: &Cancel,
    ) -> Result<Option<ElementAnswer>, RenderError> {
        let Some(shape) = self.element_shape(id, cancel)? else {
            return Ok(None);
        };
        let daylight = shape.daylight(spacing_m, &mut |places| {
            self.ground_heights_m(places, spacing_m, cancel)
        })?;
        let mut warnings: Vec<String> = shape.warnings().iter().map(ToString::to_string).collect();
        let walls = daylight.iter().find(|l| l.ending == Ending::ReachWall);
        if let Some(line) = walls {
            let wall = relievo_earthwork::Warning {
                kind: relievo_earthwork::WarningKind::ReachWall,
                place: line.places.first().copied(),
                count: 1,
            };
            warnings.push(wall.to_string());
        }
        Ok(Some(ElementAnswer { daylight, warnings }))
    }

    /// The element that decides the height at a place, and how; `None` where the ground does.
    pub(crate) fn decides(
        &self,
        place: MapPoint,
        grid: &Grid,
        cancel: &Cancel,
    ) -> Result<Option<(&Arc<Element>, Part)>, RenderError> {
        let elements = &self.scene.elements;
        let Some(node) = &elements.node else {
            return Ok(None);
        };
        let near = node.touching(grid);
        if near.is_empty() {
            return Ok(None);
        }
        let shapes: Result<Vec<Arc<Shaped>>, RenderError> = near
            .iter()
            .map(|i| self.shape(node.elements()[*i as usize].prepared(), cancel))
            .collect();
        let ground = self
            .scene
            .graph
            .evaluate(self.scene.roots.ground, grid, cancel)?;
        let ground_m = f64::from(ground.samples()[0]);
        let outcome = Design::new(self.planet, shapes?).height(place, ground_m);
        Ok(outcome
            .by
            .map(|(k, part)| (&elements.all[near[k as usize] as usize], part)))
    }

    /// The element whose colour lies on top at a place, if one has any there.
    pub(crate) fn colours(&self, grid: &Grid) -> Option<&Arc<Element>> {
        let elements = &self.scene.elements;
        let near = elements.node.as_ref()?.touching(grid);
        let mut near = near.iter().rev().map(|i| &elements.all[*i as usize]);
        near.find(|element| element_colours::shows(element, self.planet, grid))
    }

    fn prepared(&self, id: &ElementId) -> Option<Arc<Prepared>> {
        let elements = &self.scene.elements;
        let at = elements.all.iter().position(|e| e.id == *id)?;
        let placed = elements.node.as_ref()?.elements().get(at)?;
        Some(Arc::clone(placed.prepared()))
    }

    fn shape(&self, prepared: &Prepared, cancel: &Cancel) -> Result<Arc<Shaped>, RenderError> {
        let heights = match prepared.need() {
            Some(need) => self.ground_heights_m(&need.places, need.spacing_m, cancel)?,
            None => Vec::new(),
        };
        Ok(prepared.shape(&heights))
    }
}
