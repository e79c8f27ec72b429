//! Planning elements: what a planner draws on the ground.
//!
//! They act on the heights that all height layers make together (*the ground*), and may paint colour
//! above all colour layers. "Offset", "follow" and infill refer to that ground, never to other elements.

use crate::{ElementId, Extra, Vertices};

/// One planning element.
#[derive(Clone, Debug, PartialEq)]
pub struct Element {
    /// Stable id, unique in the base and in each scenario.
    pub id: ElementId,
    /// What people call it; up to 1000 bytes.
    pub name: String,
    /// Whether it takes part. Default true.
    pub visible: bool,
    /// Whether edits in the window are refused. Default false.
    pub locked: bool,
    /// What it is.
    pub kind: ElementKind,
    /// Its colours.
    pub style: ElementStyle,
    /// How it meets the ground beside it.
    pub side: SideSlopes,
    /// Unknown fields of the file; for [`ElementKind::Unknown`] all of the element's own fields.
    pub extra: Extra,
}

impl Element {
    /// A visible, unlocked element without colour and with the default side slopes.
    pub fn new(id: ElementId, name: impl Into<String>, kind: ElementKind) -> Self {
        Self {
            id,
            name: name.into(),
            visible: true,
            locked: false,
            kind,
            style: ElementStyle::default(),
            side: SideSlopes::default(),
            extra: Extra::new(),
        }
    }

    /// All lists of vertices: a polygon's outline, holes and breaklines; a corridor's line; the
    /// points of a brush's strokes.
    pub fn vertex_lists(&self) -> Vec<&Vertices> {
        match &self.kind {
            ElementKind::Polygon(polygon) => core::iter::once(&polygon.outline)
                .chain(&polygon.holes)
                .chain(&polygon.breaklines)
                .collect(),
            ElementKind::Corridor(corridor) => vec![&corridor.line],
            ElementKind::Brush(brush) => brush.strokes.iter().map(|s| &s.points).collect(),
            ElementKind::Unknown { .. } => Vec::new(),
        }
    }

    /// The same lists, in the same order, to change.
    pub fn vertex_lists_mut(&mut self) -> Vec<&mut Vertices> {
        match &mut self.kind {
            ElementKind::Polygon(polygon) => core::iter::once(&mut polygon.outline)
                .chain(&mut polygon.holes)
                .chain(&mut polygon.breaklines)
                .collect(),
            ElementKind::Corridor(corridor) => vec![&mut corridor.line],
            ElementKind::Brush(brush) => brush.strokes.iter_mut().map(|s| &mut s.points).collect(),
            ElementKind::Unknown { .. } => Vec::new(),
        }
    }
}

/// What an element is.
#[derive(Clone, Debug, PartialEq)]
pub enum ElementKind {
    /// An area with a surface.
    Polygon(Polygon),
    /// A line with a height profile and a cross-section.
    Corridor(Corridor),
    /// Freehand strokes.
    Brush(Brush),
    /// A kind that a newer program made: kept, shown by name, without effect.
    Unknown {
        /// The kind's name in the file.
        kind: String,
    },
}

impl ElementKind {
    /// The kind's name in the file: `polygon`, `corridor`, `brush` or the unknown name.
    pub fn name(&self) -> &str {
        match self {
            Self::Polygon(_) => "polygon",
            Self::Corridor(_) => "corridor",
            Self::Brush(_) => "brush",
            Self::Unknown { kind } => kind,
        }
    }
}

/// Colours of an element on the ground.
#[derive(Clone, Debug, PartialEq)]
pub struct ElementStyle {
    /// sRGB red, green, blue inside. `None`: not painted.
    pub fill: Option<[u8; 3]>,
    /// How much the fill covers, 0 to 1. Default 1.
    pub fill_opacity: f64,
    /// sRGB red, green, blue along the boundary or line. `None`: not painted.
    pub stroke: Option<[u8; 3]>,
    /// Width of the stroke in metres on the ground, 0 to 10⁵. Default 1.
    pub stroke_width_m: f64,
    /// Unknown fields of the file.
    pub extra: Extra,
}

impl Default for ElementStyle {
    fn default() -> Self {
        Self {
            fill: None,
            fill_opacity: 1.0,
            stroke: None,
            stroke_width_m: 1.0,
            extra: Extra::new(),
        }
    }
}

/// How an element meets the ground beside it.
#[derive(Clone, Debug, PartialEq)]
pub struct SideSlopes {
    /// Rise over run where ground is taken away, 0.01 to 100. Default 0.5.
    pub cut_slope: f64,
    /// Rise over run where ground is filled up, 0.01 to 100. Default 0.5.
    pub fill_slope: f64,
    /// Vertical at the boundary, no batters. Default false.
    pub wall: bool,
    /// Farthest a batter may go in metres, 0 to 10⁵: one that has not met the ground there ends in a
    /// wall. Default 200.
    pub max_reach_m: f64,
    /// Unknown fields of the file.
    pub extra: Extra,
}

impl Default for SideSlopes {
    fn default() -> Self {
        Self {
            cut_slope: 0.5,
            fill_slope: 0.5,
            wall: false,
            max_reach_m: 200.0,
            extra: Extra::new(),
        }
    }
}

/// An area with a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Polygon {
    /// The outer ring, not closed (the last vertex differs from the first).
    pub outline: Vertices,
    /// Inner rings, which the surface leaves out.
    pub holes: Vec<Vertices>,
    /// Lines with heights that a [`SurfaceKind::Tin`] follows.
    pub breaklines: Vec<Vertices>,
    /// The heights inside.
    pub surface: Surface,
}

impl Polygon {
    /// A polygon without holes and breaklines.
    pub fn new(outline: impl Into<Vertices>, surface: SurfaceKind) -> Self {
        Self {
            outline: outline.into(),
            holes: Vec::new(),
            breaklines: Vec::new(),
            surface: surface.into(),
        }
    }
}

/// The heights inside a polygon.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// How they are made.
    pub kind: SurfaceKind,
    /// Unknown fields of the file; for [`SurfaceKind::Unknown`] all of the surface's own fields.
    pub extra: Extra,
}

/// How heights inside a polygon are made.
#[derive(Clone, Debug, PartialEq)]
pub enum SurfaceKind {
    /// Level.
    Platform {
        /// Metres above the datum, −10⁷ to 10⁷.
        height_m: f64,
    },
    /// Falling evenly.
    Plane {
        /// Metres above the datum at the outline's first vertex, −10⁷ to 10⁷.
        height_m: f64,
        /// Fall in per cent, 0 to 10 000.
        slope_percent: f64,
        /// Direction in which it falls, degrees clockwise from north, −360 to 360.
        aspect_deg: f64,
    },
    /// A triangulation through the vertices' heights (missing ones from the ground) and breaklines.
    Tin,
    /// The ground, shifted.
    Offset {
        /// Metres, up positive, −10⁷ to 10⁷.
        offset_m: f64,
    },
    /// A smooth infill from the ground's heights along the boundary.
    Smooth,
    /// A type that a newer program made: kept, without effect.
    Unknown {
        /// Its name in the file.
        name: String,
    },
}

/// A line with a height profile and a cross-section.
#[derive(Clone, Debug, PartialEq)]
pub struct Corridor {
    /// The axis.
    pub line: Vertices,
    /// Heights along the axis.
    pub profile: Profile,
    /// Shape across the axis.
    pub section: Section,
}

impl Corridor {
    /// A corridor.
    pub fn new(line: impl Into<Vertices>, profile: ProfileKind, section: SectionKind) -> Self {
        Self {
            line: line.into(),
            profile: profile.into(),
            section: section.into(),
        }
    }
}

/// Heights along a corridor's axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// How they are made.
    pub kind: ProfileKind,
    /// Unknown fields of the file; for [`ProfileKind::Unknown`] all of the profile's own fields.
    pub extra: Extra,
}

/// How heights along a corridor's axis are made.
#[derive(Clone, Debug, PartialEq)]
pub enum ProfileKind {
    /// Linear between the vertices' heights; missing ones by length between their neighbours, at the
    /// ends from the ground.
    Heights,
    /// The ground along the line, smoothed and shifted.
    Follow {
        /// Metres, up positive, −10⁷ to 10⁷.
        offset_m: f64,
        /// Length in metres over which the ground is smoothed, 0 to 10⁵. Default 0.
        smooth_m: f64,
    },
    /// A type that a newer program made: kept, without effect.
    Unknown {
        /// Its name in the file.
        name: String,
    },
}

/// Shape across a corridor's axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// Which.
    pub kind: SectionKind,
    /// Unknown fields of the file; for [`SectionKind::Unknown`] all of the section's own fields.
    pub extra: Extra,
}

/// Which shape a corridor has across its axis. Widths are in metres, 0.01 to 10⁵.
#[derive(Clone, Debug, PartialEq)]
pub enum SectionKind {
    /// A roadway.
    Road {
        /// Width of the roadway.
        width_m: f64,
        /// Fall from the axis to both sides in per cent, −100 to 100. Default 0.
        crossfall_percent: f64,
    },
    /// A dam: its crest; the side slopes do the rest.
    Dam {
        /// Width of the crest.
        crest_width_m: f64,
    },
    /// A trench below the profile.
    Trench {
        /// Width of the bottom.
        bottom_width_m: f64,
        /// Depth below the profile in metres, 0 to 10⁵.
        depth_m: f64,
    },
    /// A channel below the profile, with banks of their own.
    Channel {
        /// Width of the bottom.
        bottom_width_m: f64,
        /// Depth below the profile in metres, 0 to 10⁵.
        depth_m: f64,
        /// Rise over run of the banks, 0.01 to 100.
        bank_slope: f64,
    },
    /// A type that a newer program made: kept, without effect.
    Unknown {
        /// Its name in the file.
        name: String,
    },
}

/// Freehand strokes, the first at the bottom.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Brush {
    /// The strokes, at most 100 000.
    pub strokes: Vec<Stroke>,
}

/// One stroke of a brush.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// What it does.
    pub tool: BrushTool,
    /// Radius in metres on the ground, 0.01 to 10⁶.
    pub radius_m: f64,
    /// Share of the radius with full effect, 0 to 1; beyond it the effect fades. Default 0.5.
    pub hardness: f64,
    /// The way of the brush; heights have no meaning here.
    pub points: Vertices,
    /// Unknown fields of the file; for [`BrushTool::Unknown`] all of the stroke's own fields.
    pub extra: Extra,
}

/// What a stroke of a brush does.
#[derive(Clone, Debug, PartialEq)]
pub enum BrushTool {
    /// Adds height.
    Raise {
        /// Metres at the centre, 0 to 10⁵.
        strength_m: f64,
    },
    /// Takes height away.
    Lower {
        /// Metres at the centre, 0 to 10⁵.
        strength_m: f64,
    },
    /// Evens the ground out.
    Smooth {
        /// How much of the way to the smoothed ground, 0 to 1.
        strength: f64,
    },
    /// Brings the ground to a height.
    Flatten {
        /// Metres above the datum, −10⁷ to 10⁷.
        height_m: f64,
        /// How much of the way to that height, 0 to 1.
        strength: f64,
    },
    /// A tool that a newer program made: kept, without effect.
    Unknown {
        /// Its name in the file.
        name: String,
    },
}

macro_rules! from_kind {
    ($($name:ident from $kind:ident,)*) => {$(
        impl From<$kind> for $name {
            fn from(kind: $kind) -> Self {
                Self { kind, extra: Extra::new() }
            }
        }
    )*};
}

from_kind! {
    Surface from SurfaceKind,
    Profile from ProfileKind,
    Section from SectionKind,
}
