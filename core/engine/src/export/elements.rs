//! Planning elements as features.

use relievo_analysis::AnalysisError;
use relievo_planet::MapPoint;
use relievo_project::{
    BrushTool, Corridor, Element, ElementKind, Polygon, ProfileKind, SectionKind, SurfaceKind,
    Vertices,
};
use relievo_vector::Value;
use relievo_vector::write::{Feature, Geometry, Position};

use super::{positions, property, text, whole_or_flat};

/// Heights at places in metres, NaN where there are none.
type Heights<'a> = dyn Fn(&[MapPoint]) -> Result<Vec<f64>, AnalysisError> + 'a;

/// Adds an element's features: a polygon and its breaklines, an axis, or strokes.
pub(super) fn features(
    element: &Element,
    heights: &Heights,
    features: &mut Vec<Feature>,
) -> Result<(), AnalysisError> {
    let line = |vertices: &Vertices| -> Result<Vec<Position>, AnalysisError> {
        let places: Vec<MapPoint> = vertices
            .as_slice()
            .iter()
            .map(|v| MapPoint::from_degrees(v.lon_deg, v.lat_deg))
            .collect();
        Ok(positions(&places, &heights(&places)?))
    };
    let mut add = |part: &str, geometry: Geometry, more: Vec<(String, Value)>| {
        let mut properties = named(element);
        properties.push(text("part", part));
        properties.extend(more);
        features.push(Feature {
            geometry,
            properties,
        });
    };
    match &element.kind {
        ElementKind::Polygon(polygon) => {
            let rings = core::iter::once(&polygon.outline).chain(&polygon.holes);
            let rings: Vec<Vec<Position>> = rings.map(line).collect::<Result<_, _>>()?;
            let mut measures = surface(polygon);
            measures.extend(sides(element));
            add(
                "outline",
                Geometry::Polygons(vec![flat_together(rings)]),
                measures,
            );
            for breakline in &polygon.breaklines {
                let line = whole_or_flat(line(breakline)?);
                add("breakline", Geometry::Lines(vec![line]), Vec::new());
            }
        }
        ElementKind::Corridor(corridor) => {
            let mut measures = section(corridor);
            measures.extend(sides(element));
            let line = whole_or_flat(line(&corridor.line)?);
            add("axis", Geometry::Lines(vec![line]), measures);
        }
        ElementKind::Brush(brush) => {
            for stroke in &brush.strokes {
                let line = whole_or_flat(line(&stroke.points)?);
                let geometry = match line.len() {
                    1 => Geometry::Points(line),
                    _ => Geometry::Lines(vec![line]),
                };
                let mut measures = tool(&stroke.tool);
                measures.push(property("radius_m", stroke.radius_m));
                measures.push(property("hardness", stroke.hardness));
                add("stroke", geometry, measures);
            }
        }
        ElementKind::Unknown { .. } => {}
    }
    Ok(())
}

/// Which element it is.
pub(super) fn named(element: &Element) -> Vec<(String, Value)> {
    vec![
        text("id", &element.id.0),
        text("name", &element.name),
        text("kind", element.kind.name()),
    ]
}

fn flat_together(mut rings: Vec<Vec<Position>>) -> Vec<Vec<Position>> {
    if rings.iter().flatten().any(|p| p.height_m.is_none()) {
        for p in rings.iter_mut().flatten() {
            p.height_m = None;
        }
    }
    rings
}

fn surface(polygon: &Polygon) -> Vec<(String, Value)> {
    let name = |name| text("surface", name);
    match &polygon.surface.kind {
        SurfaceKind::Platform { height_m } => {
            vec![name("platform"), property("height_m", *height_m)]
        }
        SurfaceKind::Plane {
            height_m,
            slope_percent,
            aspect_deg,
        } => vec![
            name("plane"),
            property("height_m", *height_m),
            property("slope_percent", *slope_percent),
            property("aspect_deg", *aspect_deg),
        ],
        SurfaceKind::Tin => vec![name("tin")],
        SurfaceKind::Offset { offset_m } => vec![name("offset"), property("offset_m", *offset_m)],
        SurfaceKind::Smooth => vec![name("smooth")],
        SurfaceKind::Unknown { name: unknown } => vec![name(unknown)],
    }
}

fn section(corridor: &Corridor) -> Vec<(String, Value)> {
    let mut found = match &corridor.profile.kind {
        ProfileKind::Heights => vec![text("profile", "heights")],
        ProfileKind::Follow { offset_m, smooth_m } => vec![
            text("profile", "follow"),
            property("offset_m", *offset_m),
            property("smooth_m", *smooth_m),
        ],
        ProfileKind::Unknown { name } => vec![text("profile", name)],
    };
    let name = |name| text("section", name);
    found.extend(match &corridor.section.kind {
        SectionKind::Road {
            width_m,
            crossfall_percent,
        } => vec![
            name("road"),
            property("width_m", *width_m),
            property("crossfall_percent", *crossfall_percent),
        ],
        SectionKind::Dam { crest_width_m } => {
            vec![name("dam"), property("width_m", *crest_width_m)]
        }
        SectionKind::Trench {
            bottom_width_m,
            depth_m,
        } => vec![
            name("trench"),
            property("width_m", *bottom_width_m),
            property("depth_m", *depth_m),
        ],
        SectionKind::Channel {
            bottom_width_m,
            depth_m,
            bank_slope,
        } => vec![
            name("channel"),
            property("width_m", *bottom_width_m),
            property("depth_m", *depth_m),
            property("bank_slope", *bank_slope),
        ],
        SectionKind::Unknown { name: unknown } => vec![name(unknown)],
    });
    found
}

fn tool(tool: &BrushTool) -> Vec<(String, Value)> {
    let name = |name| text("tool", name);
    match tool {
        BrushTool::Raise { strength_m } => vec![name("raise"), property("strength_m", *strength_m)],
        BrushTool::Lower { strength_m } => vec![name("lower"), property("strength_m", *strength_m)],
        BrushTool::Smooth { strength } => vec![name("smooth"), property("strength", *strength)],
        BrushTool::Flatten { height_m, strength } => vec![
            name("flatten"),
            property("height_m", *height_m),
            property("strength", *strength),
        ],
        BrushTool::Unknown { name: unknown } => vec![name(unknown)],
    }
}

fn sides(element: &Element) -> Vec<(String, Value)> {
    let side = &element.side;
    vec![
        property("cut_slope", side.cut_slope),
        property("fill_slope", side.fill_slope),
        ("wall".to_owned(), Value::Bool(side.wall)),
        property("max_reach_m", side.max_reach_m),
    ]
}
