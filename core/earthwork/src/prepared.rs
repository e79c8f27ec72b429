//! Elements, prepared: checked, in frames, and, once the ground is known, ready for evaluation.

use std::sync::Arc;

use relievo_planet::{MapPoint, Planet};

use crate::brush::{self, Brush};
use crate::element::{Element, Shape};
use crate::footprint::Footprint;
use crate::frame::MapRect;
use crate::solid::Solid;
use crate::warning::{Warning, WarningKind, Warnings};
use crate::{corridor, polygon};

/// Heights of the ground that an element stands on.
#[derive(Clone, Debug, PartialEq)]
pub struct GroundNeed {
    /// Where.
    pub places: Vec<MapPoint>,
    /// At which spacing in metres the ground decides enough of it: the same at every zoom.
    pub spacing_m: f64,
}

/// An element that was checked and laid out, apart from what depends on the ground's heights.
#[derive(Clone, Debug)]
pub struct Prepared {
    element: Arc<Element>,
    planet: Planet,
    draft: Draft,
    footprint: Arc<Footprint>,
    /// Area within its reach, square metres, about.
    area_m2: f64,
    need: Option<Arc<GroundNeed>>,
    warnings: Warnings,
    /// The shape of an element that needs no ground.
    ready: Option<Arc<Shaped>>,
}

#[derive(Clone, Debug)]
enum Draft {
    Polygon(polygon::Draft),
    Corridor(corridor::Draft),
    Brush(brush::Draft),
    Nothing,
}

/// An element with all of its heights.
#[derive(Clone, Debug)]
pub struct Shaped {
    pub(crate) form: Form,
    pub(crate) footprint: Arc<Footprint>,
    warnings: Warnings,
}

#[derive(Clone, Debug)]
pub(crate) enum Form {
    Solid(Solid),
    Brush(Brush),
    Nothing,
}

impl Prepared {
    /// Checks an element and lays it out. Nothing is refused: see [`Prepared::warnings`].
    pub fn new(planet: Planet, element: Arc<Element>) -> Self {
        let mut warnings = Warnings::default();
        let draft = match &element.shape {
            Shape::Polygon(p) => {
                polygon::Draft::new(planet, p, &element.side, &mut warnings).map(Draft::Polygon)
            }
            Shape::Corridor(c) => {
                corridor::Draft::new(planet, c, &element.side, &mut warnings).map(Draft::Corridor)
            }
            Shape::Brush(strokes) => {
                brush::Draft::new(planet, strokes, &mut warnings).map(Draft::Brush)
            }
        };
        let draft = draft.unwrap_or(Draft::Nothing);
        let (footprint, need, area_m2) = match &draft {
            Draft::Polygon(d) => (d.footprint(), d.need(), d.area_m2()),
            Draft::Corridor(d) => (d.footprint(), d.need(), d.area_m2()),
            Draft::Brush(d) => (d.footprint(), d.need(), d.area_m2()),
            Draft::Nothing => (Footprint::default(), None, 0.0),
        };
        let mut prepared = Self {
            element,
            planet,
            draft,
            footprint: Arc::new(footprint),
            area_m2,
            need: need.map(Arc::new),
            warnings,
            ready: None,
        };
        if prepared.need.is_none() {
            prepared.ready = Some(Arc::new(prepared.make(&[])));
        }
        prepared
    }

    /// The element.
    pub fn element(&self) -> &Arc<Element> {
        &self.element
    }

    /// The planet it stands on.
    pub fn planet(&self) -> Planet {
        self.planet
    }

    /// What is odd about it, without regard to the ground.
    pub fn warnings(&self) -> &[Warning] {
        self.warnings.all()
    }

    /// Rectangles of the map outside of which it changes nothing.
    pub fn reach(&self) -> &[MapRect] {
        self.footprint.boxes()
    }

    /// Whether it may change something in a rectangle: always true where it does, rarely elsewhere.
    pub fn touches(&self, rect: &MapRect) -> bool {
        self.footprint.touches(rect)
    }

    /// Whether it is worth evaluating on samples of side `spacing_m` metres: one that changes 100 m over
    /// all of its reach, but the mean height of a sample by less than a thousandth of the sample's
    /// side, is not. So that far away a city of elements costs nothing.
    pub fn matters_at(&self, spacing_m: f64) -> bool {
        100.0 * self.area_m2 >= 1e-3 * spacing_m * spacing_m * spacing_m
    }

    /// Heights of the ground that decide it; `None` if it depends on none beforehand (most kinds).
    pub fn need(&self) -> Option<&Arc<GroundNeed>> {
        self.need.as_ref()
    }

    /// The shape of an element that needs no ground.
    pub fn ready(&self) -> Option<&Arc<Shaped>> {
        self.ready.as_ref()
    }

    /// The element with all of its heights. `ground_m` are the heights of [`Prepared::need`]'s places
    /// in their order; what is no number counts as the mean of the others.
    ///
    /// # Panics
    /// If there are not as many heights as places.
    pub fn shape(&self, ground_m: &[f64]) -> Arc<Shaped> {
        if let Some(ready) = &self.ready {
            return Arc::clone(ready);
        }
        let places = self.need.as_ref().map_or(0, |n| n.places.len());
        assert_eq!(ground_m.len(), places, "a height for each place");
        Arc::new(self.make(ground_m))
    }

    fn make(&self, ground_m: &[f64]) -> Shaped {
        let mut warnings = self.warnings.clone();
        let mut ground = ground_m.to_vec();
        let (sum, count) = ground
            .iter()
            .filter(|h| h.is_finite())
            .fold((0.0, 0_usize), |(sum, n), h| (sum + h, n + 1));
        if count < ground.len() {
            let mean = if count > 0 { sum / count as f64 } else { 0.0 };
            for h in ground.iter_mut().filter(|h| !h.is_finite()) {
                *h = mean;
                warnings.add(WarningKind::GroundMissing, None);
            }
        }
        let form = match &self.draft {
            Draft::Polygon(d) => Form::Solid(d.shape(&ground, &mut warnings)),
            Draft::Corridor(d) => Form::Solid(d.shape(&ground, &mut warnings)),
            Draft::Brush(d) => Form::Brush(d.shape(&ground)),
            Draft::Nothing => Form::Nothing,
        };
        Shaped {
            form,
            footprint: Arc::clone(&self.footprint),
            warnings,
        }
    }

    /// Gives everything that decides the element's heights, but for the ground, to a hash.
    pub fn identify(&self, add: &mut dyn FnMut(f64)) {
        for v in [self.planet.equatorial_radius_m, self.planet.flattening] {
            add(v);
        }
        crate::identity::element(&self.element, add);
    }
}

impl Shaped {
    /// What is odd about it.
    pub fn warnings(&self) -> &[Warning] {
        self.warnings.all()
    }

    /// Rectangles of the map outside of which it changes nothing.
    pub fn reach(&self) -> &[MapRect] {
        self.footprint.boxes()
    }
}
