//! Planning elements, from the project's to those that change heights.
//!
//! An element that an edit leaves alone is shared by all revisions and scenarios that hold it, and so is
//! what was prepared for it: a drag prepares the one element that it changes.

use std::collections::{HashMap, VecDeque};
use std::sync::Arc;

use parking_lot::Mutex;
use relievo_earthwork as earthwork;
use relievo_graph::Artefacts;
use relievo_graph::nodes::{Earthwork, PlacedElement};
use relievo_planet::{MapPoint, Planet};
use relievo_project::{
    BrushTool, Element, ElementId, ElementKind, ProfileKind, SectionKind, SideSlopes, SurfaceKind,
    Vertices,
};

/// Compilations for which an element that nobody uses any more is kept: for undo, and for scenarios
/// that are compared.
const KEPT_FOR: u64 = 16;

/// Nodes of other lists that are kept.
const NODES_KEPT: usize = 4;

/// Elements that were prepared.
#[derive(Default)]
pub(crate) struct ElementCache {
    kept: Mutex<Kept>,
    artefacts: Arc<Artefacts>,
}

#[derive(Default)]
struct Kept {
    /// By the element's address, which stays its own while it is kept here.
    placed: HashMap<usize, Placed>,
    /// Those of the last plans, the latest first: scenarios that are switched to and fro cost nothing.
    nodes: VecDeque<Arc<Earthwork>>,
    clock: u64,
}

impl Kept {
    fn node(&mut self, planet: Planet, placed: Vec<Arc<PlacedElement>>) -> Arc<Earthwork> {
        let same = self.nodes.iter().position(|n| n.is_of(planet, &placed));
        let node = match (
            same.and_then(|at| self.nodes.remove(at)),
            self.nodes.front(),
        ) {
            (Some(same), _) => same,
            (None, Some(latest)) => Arc::new(latest.following(planet, placed)),
            (None, None) => Arc::new(Earthwork::new(planet, placed)),
        };
        self.nodes.push_front(Arc::clone(&node));
        self.nodes.truncate(NODES_KEPT);
        node
    }
}

struct Placed {
    #[expect(
        dead_code,
        reason = "no other element can have its address while it lives"
    )]
    element: Arc<Element>,
    planet: Planet,
    node: Option<Arc<PlacedElement>>,
    /// What is odd about it, a line each.
    warnings: Vec<String>,
    used: u64,
}

impl Placed {
    fn new(element: &Arc<Element>, planet: Planet) -> Self {
        let node = place(planet, element);
        Self {
            warnings: warnings(element, node.as_deref()),
            element: Arc::clone(element),
            planet,
            node,
            used: 0,
        }
    }
}

/// Elements as a graph needs them.
pub(crate) struct Plan {
    /// Those that take part, the first at the bottom.
    pub(crate) placed: Vec<(Arc<Element>, Arc<PlacedElement>)>,
    /// What is odd: whose, its name, and what.
    pub(crate) warnings: Vec<(ElementId, String)>,
    /// The node, if there is anything to do.
    pub(crate) node: Option<Arc<Earthwork>>,
}

impl ElementCache {
    /// Where artefacts are kept from revision to revision.
    pub(crate) fn artefacts(&self) -> &Arc<Artefacts> {
        &self.artefacts
    }

    /// Number of elements that are kept.
    pub(crate) fn len(&self) -> usize {
        self.kept.lock().placed.len()
    }

    /// Prepares visible elements that are not prepared yet.
    pub(crate) fn plan(&self, planet: Planet, elements: &[Arc<Element>]) -> Plan {
        let mut kept = self.kept.lock();
        kept.clock += 1;
        let now = kept.clock;
        let mut plan = Plan {
            placed: Vec::new(),
            warnings: Vec::new(),
            node: None,
        };
        for element in elements.iter().filter(|e| e.visible) {
            let address = Arc::as_ptr(element).addr();
            let slot = kept.placed.entry(address);
            let slot = slot.or_insert_with(|| Placed::new(element, planet));
            if slot.planet != planet {
                *slot = Placed::new(element, planet);
            }
            slot.used = now;
            let warnings = slot.warnings.iter().cloned();
            plan.warnings
                .extend(warnings.map(|text| (element.id.clone(), text)));
            if let Some(placed) = &slot.node {
                plan.placed.push((Arc::clone(element), Arc::clone(placed)));
            }
        }
        kept.placed.retain(|_, p| p.used + KEPT_FOR > now);
        let placed: Vec<_> = plan.placed.iter().map(|(_, p)| Arc::clone(p)).collect();
        plan.node = (!placed.is_empty()).then(|| kept.node(planet, placed));
        plan
    }
}

impl Plan {
    /// Spacing in metres at which the finest of the elements is worth looking at.
    pub(crate) fn detail_m(&self) -> Option<f64> {
        let of = |(_, placed): &(Arc<Element>, Arc<PlacedElement>)| detail_m(placed);
        self.placed.iter().map(of).reduce(f64::min)
    }
}

/// An eighth of what is narrow about an element, so that its edges are seen; 0.25 to 2 m.
fn detail_m(placed: &PlacedElement) -> f64 {
    let (low, high) = (0.25, 2.0);
    let width_m = match &placed.prepared().element().shape {
        earthwork::Shape::Polygon(_) => return 0.5,
        earthwork::Shape::Corridor(c) => match c.section {
            earthwork::Section::Road { width_m, .. } => width_m,
            earthwork::Section::Dam { crest_width_m } => crest_width_m,
            earthwork::Section::Trench { bottom_width_m, .. }
            | earthwork::Section::Channel { bottom_width_m, .. } => bottom_width_m,
        },
        earthwork::Shape::Brush(strokes) => strokes
            .iter()
            .map(|s| s.radius_m)
            .fold(high * 8.0, f64::min),
    };
    (width_m / 8.0).clamp(low, high)
}

/// What is odd about an element as far as it is known without the ground.
fn warnings(element: &Element, node: Option<&PlacedElement>) -> Vec<String> {
    let name = &element.name;
    let lists = element.vertex_lists();
    let missing = lists.iter().filter_map(|list| list.missing());
    let missing = missing.map(|file| {
        let vertices = file.vertices;
        format!("element {name:?}: {vertices} vertices lie in a file that is missing")
    });
    let mut all: Vec<String> = missing.collect();
    let Some(placed) = node else {
        all.push(format!(
            "element {name:?} is of a kind that a newer program made; it is left out"
        ));
        return all;
    };
    let prepared = placed.prepared();
    // What is known with the ground says more where there is no need for it.
    let odd = match prepared.ready() {
        Some(shaped) => shaped.warnings(),
        None => prepared.warnings(),
    };
    all.extend(odd.iter().map(|w| format!("element {name:?}: {w}")));
    all
}

fn place(planet: Planet, element: &Element) -> Option<Arc<PlacedElement>> {
    let element = Arc::new(converted(element)?);
    let prepared = earthwork::Prepared::new(planet, element);
    Some(Arc::new(PlacedElement::new(Arc::new(prepared))))
}

/// The element in the terms of the crate that computes it; `None` for kinds that a newer program made.
pub(crate) fn converted(element: &Element) -> Option<earthwork::Element> {
    let shape = match &element.kind {
        ElementKind::Polygon(polygon) => earthwork::Shape::Polygon(earthwork::Polygon {
            outline: vertices(&polygon.outline),
            holes: polygon.holes.iter().map(vertices).collect(),
            breaklines: polygon.breaklines.iter().map(vertices).collect(),
            surface: surface(&polygon.surface.kind)?,
        }),
        ElementKind::Corridor(corridor) => earthwork::Shape::Corridor(earthwork::Corridor {
            line: vertices(&corridor.line),
            profile: match corridor.profile.kind {
                ProfileKind::Heights => earthwork::Profile::Heights,
                ProfileKind::Follow { offset_m, smooth_m } => {
                    earthwork::Profile::Follow { offset_m, smooth_m }
                }
                ProfileKind::Unknown { .. } => return None,
            },
            section: section(&corridor.section.kind)?,
        }),
        // A stroke of an unknown tool leaves the others as they are.
        ElementKind::Brush(brush) => {
            earthwork::Shape::Brush(brush.strokes.iter().filter_map(stroke).collect())
        }
        ElementKind::Unknown { .. } => return None,
    };
    Some(earthwork::Element {
        shape,
        side: side(&element.side),
    })
}

fn vertices(list: &Vertices) -> Vec<earthwork::Vertex> {
    let vertex = |v: &relievo_project::Vertex| earthwork::Vertex {
        place: MapPoint::from_degrees(v.lon_deg, v.lat_deg),
        height_m: v.height_m,
    };
    list.as_slice().iter().map(vertex).collect()
}

fn side(side: &SideSlopes) -> earthwork::Side {
    earthwork::Side {
        cut_slope: side.cut_slope,
        fill_slope: side.fill_slope,
        wall: side.wall,
        max_reach_m: side.max_reach_m,
    }
}

fn surface(kind: &SurfaceKind) -> Option<earthwork::Surface> {
    Some(match *kind {
        SurfaceKind::Platform { height_m } => earthwork::Surface::Platform { height_m },
        SurfaceKind::Plane {
            height_m,
            slope_percent,
            aspect_deg,
        } => earthwork::Surface::Plane {
            height_m,
            slope_percent,
            aspect_deg,
        },
        SurfaceKind::Tin => earthwork::Surface::Tin,
        SurfaceKind::Offset { offset_m } => earthwork::Surface::Offset { offset_m },
        SurfaceKind::Smooth => earthwork::Surface::Smooth,
        SurfaceKind::Unknown { .. } => return None,
    })
}

fn section(kind: &SectionKind) -> Option<earthwork::Section> {
    Some(match *kind {
        SectionKind::Road {
            width_m,
            crossfall_percent,
        } => earthwork::Section::Road {
            width_m,
            crossfall_percent,
        },
        SectionKind::Dam { crest_width_m } => earthwork::Section::Dam { crest_width_m },
        SectionKind::Trench {
            bottom_width_m,
            depth_m,
        } => earthwork::Section::Trench {
            bottom_width_m,
            depth_m,
        },
        SectionKind::Channel {
            bottom_width_m,
            depth_m,
            bank_slope,
        } => earthwork::Section::Channel {
            bottom_width_m,
            depth_m,
            bank_slope,
        },
        SectionKind::Unknown { .. } => return None,
    })
}

fn stroke(stroke: &relievo_project::Stroke) -> Option<earthwork::Stroke> {
    let tool = match stroke.tool {
        BrushTool::Raise { strength_m } => earthwork::Tool::Raise { strength_m },
        BrushTool::Lower { strength_m } => earthwork::Tool::Lower { strength_m },
        BrushTool::Smooth { strength } => earthwork::Tool::Smooth { strength },
        BrushTool::Flatten { height_m, strength } => {
            earthwork::Tool::Flatten { height_m, strength }
        }
        BrushTool::Unknown { .. } => return None,
    };
    Some(earthwork::Stroke {
        tool,
        radius_m: stroke.radius_m,
        hardness: stroke.hardness,
        points: vertices(&stroke.points).iter().map(|v| v.place).collect(),
    })
}
