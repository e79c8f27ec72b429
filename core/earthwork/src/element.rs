//! What a planner draws: plain input, unchecked. Whatever is wrong with it becomes a
//! [`crate::Warning`] when it is prepared, never an error.

use relievo_planet::MapPoint;

/// A corner of an outline, a breakline or a corridor's line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Where it is.
    pub place: MapPoint,
    /// Its height in metres above the datum; `None` where the surface says it, or the ground does.
    pub height_m: Option<f64>,
}

/// One planning element: a shape and its side slopes.
#[derive(Clone, Debug, PartialEq)]
pub struct Element {
    /// What it is.
    pub shape: Shape,
    /// How it meets the ground; brushes have no sides.
    pub side: Side,
}

/// The kinds of elements.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// An area with a surface of its own.
    Polygon(Polygon),
    /// A line with a height profile and a cross-section.
    Corridor(Corridor),
    /// Freehand strokes, applied one after the other to what lies below them in the list.
    Brush(Vec<Stroke>),
}

/// An area. Edges are straight in the polygon's frame, which is as good as geodesics for planning.
#[derive(Clone, Debug, PartialEq)]
pub struct Polygon {
    /// Corners in order, either way round, not closed. Where an outline crosses itself, whatever it
    /// goes around at all belongs to the area.
    pub outline: Vec<Vertex>,
    /// Areas left out.
    pub holes: Vec<Vec<Vertex>>,
    /// Lines that a TIN's triangles do not cross.
    pub breaklines: Vec<Vec<Vertex>>,
    /// The heights inside.
    pub surface: Surface,
}

/// Heights inside a polygon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Surface {
    /// Level.
    Platform {
        /// Metres above the datum.
        height_m: f64,
    },
    /// An inclined plane.
    Plane {
        /// Metres above the datum at the outline's first vertex.
        height_m: f64,
        /// Rise over run in per cent, 0 or more.
        slope_percent: f64,
        /// Direction in which it falls, degrees clockwise from north.
        aspect_deg: f64,
    },
    /// Triangles through the vertices' heights; missing ones come from the ground.
    Tin,
    /// The ground, raised or lowered.
    Offset {
        /// Metres up.
        offset_m: f64,
    },
    /// A membrane through the ground's heights at the boundary: what was inside is smoothed away.
    Smooth,
}

/// A line with a profile and a section.
#[derive(Clone, Debug, PartialEq)]
pub struct Corridor {
    /// Corners of the axis in order.
    pub line: Vec<Vertex>,
    /// Heights along the axis.
    pub profile: Profile,
    /// What it looks like across.
    pub section: Section,
}

/// Heights along a corridor's axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Profile {
    /// Linear by length between the vertices' heights; missing ones are left out, and come from the
    /// ground at both ends.
    Heights,
    /// The ground along the axis, averaged over a length, raised.
    Follow {
        /// Metres up.
        offset_m: f64,
        /// Length in metres of the axis over which the ground is averaged, 0 or more.
        smooth_m: f64,
    },
}

/// What a corridor looks like across, seen along its line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Section {
    /// A road that falls from its axis to both sides.
    Road {
        /// Width in metres.
        width_m: f64,
        /// Fall to both sides in per cent.
        crossfall_percent: f64,
    },
    /// A dam: it only ever raises the ground.
    Dam {
        /// Width of the crest in metres.
        crest_width_m: f64,
    },
    /// A trench below the profile: it only ever lowers the ground.
    Trench {
        /// Width of the bottom in metres.
        bottom_width_m: f64,
        /// Depth below the profile in metres.
        depth_m: f64,
    },
    /// A bed below the profile with banks up to it; raised on dams where the ground is lower.
    Channel {
        /// Width of the bottom in metres.
        bottom_width_m: f64,
        /// Depth of the bottom below the profile in metres.
        depth_m: f64,
        /// Rise over run of the banks.
        bank_slope: f64,
    },
}

/// Side slopes: how an element meets the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side {
    /// Rise over run where the ground is cut, [`Side::SLOPES`].
    pub cut_slope: f64,
    /// Rise over run where it is filled, [`Side::SLOPES`].
    pub fill_slope: f64,
    /// A vertical wall at the boundary instead of slopes.
    pub wall: bool,
    /// How far slopes reach in metres; one that has not met the ground there ends in a wall.
    pub max_reach_m: f64,
}

impl Side {
    /// Rises over runs that are possible; others are taken as the nearest of these.
    pub const SLOPES: core::ops::RangeInclusive<f64> = 0.01..=100.0;
    /// Largest reach in metres.
    pub const LARGEST_REACH_M: f64 = 100_000.0;
}

impl Default for Side {
    /// 1 : 2 both ways, 200 m.
    fn default() -> Self {
        Self {
            cut_slope: 0.5,
            fill_slope: 0.5,
            wall: false,
            max_reach_m: 200.0,
        }
    }
}

/// One stroke of a brush.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// What it does.
    pub tool: Tool,
    /// Distance in metres from the path at which it ends.
    pub radius_m: f64,
    /// Share of the radius in which it acts fully, 0 to 1; from there it fades out smoothly.
    pub hardness: f64,
    /// The path.
    pub points: Vec<MapPoint>,
}

/// What a stroke does to the heights below it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tool {
    /// Adds to them.
    Raise {
        /// Metres up where it acts fully.
        strength_m: f64,
    },
    /// Takes from them.
    Lower {
        /// Metres down where it acts fully.
        strength_m: f64,
    },
    /// Brings them to one height.
    Flatten {
        /// Metres above the datum.
        height_m: f64,
        /// Share, 0 to 1.
        strength: f64,
    },
    /// Replaces the ground by its average over half a radius around (with what earlier strokes of
    /// the same brush made of it).
    Smooth {
        /// Share, 0 to 1.
        strength: f64,
    },
}
