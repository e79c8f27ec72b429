//! Planning elements of version 1.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde_json::Value;

use super::colour::StoredColour;
use super::fault::{At, Fault};
use super::range;
use super::value::{Fields as _, Stored, With, object};
use super::vertices::StoredVertices;
use crate::Extra;

fields! {
    /// What every element has.
    ElementBase {
        /// Stable id, unique among the elements: letters, digits, `-`, `_` and `.`.
        #[schemars(regex(pattern = r"^[A-Za-z0-9._-]{1,64}$"))]
        id: String,
        /// What people call it; the id where left out.
        #[schemars(length(max = range::LONGEST_NAME))]
        name: Option<String>,
        /// Whether it takes part; true where left out.
        visible: Option<bool>,
        /// Whether edits in the window are refused; false where left out.
        locked: Option<bool>,
        /// Colours; none where left out.
        style: Option<With<ElementStyle>>,
        /// How it meets the ground beside it.
        side: Option<With<SideSlopes>>,
    }
}

fields! {
    /// Colours of an element on the ground.
    ElementStyle {
        /// Inside; not painted where left out.
        fill: Option<StoredColour>,
        /// How much the fill covers; 1 where left out.
        fill_opacity: Option<f64> = range::SHARE,
        /// Along the boundary or line; not painted where left out.
        stroke: Option<StoredColour>,
        /// Width of the stroke in metres on the ground; 1 where left out.
        stroke_width_m: Option<f64> = range::REACH_M,
    }
}

fields! {
    /// How an element meets the ground beside it.
    SideSlopes {
        /// Rise over run where ground is taken away; 0.5 where left out.
        cut_slope: Option<f64> = range::SIDE_SLOPE,
        /// Rise over run where ground is filled up; 0.5 where left out.
        fill_slope: Option<f64> = range::SIDE_SLOPE,
        /// Vertical at the boundary, no batters; false where left out.
        wall: Option<bool>,
        /// Farthest a batter may go in metres; 200 where left out.
        max_reach_m: Option<f64> = range::REACH_M,
    }
}

tagged! {
    /// Kinds of elements.
    ElementKind of ElementKinds by "kind", "What an element is; elements of other kinds are kept and have no effect." {
        /// An area with a surface.
        Polygon(Polygon) = "polygon" {
            /// The outer ring, not closed.
            outline: StoredVertices,
            /// Inner rings, which the surface leaves out; none where left out.
            #[schemars(length(max = range::MOST_LISTS))]
            holes: Option<Vec<StoredVertices>>,
            /// Lines with heights that a triangulation follows; none where left out.
            #[schemars(length(max = range::MOST_LISTS))]
            breaklines: Option<Vec<StoredVertices>>,
            /// The heights inside.
            surface: Surface,
        }
        /// A line with a height profile and a cross-section.
        Corridor(Corridor) = "corridor" {
            /// The axis.
            line: StoredVertices,
            /// Heights along the axis; those of the vertices where left out.
            profile: Option<Profile>,
            /// Shape across the axis.
            section: Section,
        }
        /// Freehand strokes.
        Brush(Brush) = "brush" {
            /// The strokes, the first at the bottom.
            #[schemars(length(max = range::MOST_LISTS))]
            strokes: Vec<Stroke>,
        }
    }
}

tagged! {
    /// Surfaces.
    Surface of Surfaces by "type", "The heights inside a polygon; other types are kept and have no effect." {
        /// Level.
        Platform(Platform) = "platform" {
            /// Metres above the datum.
            height_m: f64 = range::HEIGHT_M,
        }
        /// Falling evenly.
        Plane(Plane) = "plane" {
            /// Metres above the datum at the outline's first vertex.
            height_m: f64 = range::HEIGHT_M,
            /// Fall in per cent.
            slope_percent: f64 = range::SLOPE_PERCENT,
            /// Direction in which it falls, degrees clockwise from north.
            aspect_deg: f64 = range::TURN_DEG,
        }
        /// A triangulation through the vertices' heights, missing ones from the ground, and breaklines.
        Tin(Tin) = "tin" {}
        /// The ground, shifted.
        Offset(Offset) = "offset" {
            /// Metres, up positive.
            offset_m: f64 = range::HEIGHT_M,
        }
        /// A smooth infill from the ground's heights along the boundary.
        Smooth(Smooth) = "smooth" {}
    }
}

tagged! {
    /// Profiles.
    Profile of Profiles by "type", "Heights along a corridor's axis; other types are kept and have no effect." {
        /// Linear between the vertices' heights; missing ones by length, at the ends from the ground.
        Heights(Heights) = "heights" {}
        /// The ground along the line, smoothed and shifted.
        Follow(Follow) = "follow" {
            /// Metres, up positive; 0 where left out.
            offset_m: Option<f64> = range::HEIGHT_M,
            /// Length in metres over which the ground is smoothed; 0 where left out.
            smooth_m: Option<f64> = range::REACH_M,
        }
    }
}

tagged! {
    /// Sections.
    Section of Sections by "type", "Shape across a corridor's axis; other types are kept and have no effect." {
        /// A roadway.
        Road(Road) = "road" {
            /// Width of the roadway in metres.
            width_m: f64 = range::SECTION_M,
            /// Fall from the axis to both sides in per cent; 0 where left out.
            crossfall_percent: Option<f64> = range::CROSSFALL_PERCENT,
        }
        /// A dam: its crest; the side slopes do the rest.
        Dam(Dam) = "dam" {
            /// Width of the crest in metres.
            crest_width_m: f64 = range::SECTION_M,
        }
        /// A trench below the profile.
        Trench(Trench) = "trench" {
            /// Width of the bottom in metres.
            bottom_width_m: f64 = range::SECTION_M,
            /// Depth below the profile in metres.
            depth_m: f64 = range::REACH_M,
        }
        /// A channel below the profile, with banks of its own.
        Channel(Channel) = "channel" {
            /// Width of the bottom in metres.
            bottom_width_m: f64 = range::SECTION_M,
            /// Depth below the profile in metres.
            depth_m: f64 = range::REACH_M,
            /// Rise over run of the banks.
            bank_slope: f64 = range::SIDE_SLOPE,
        }
    }
}

fields! {
    /// What every stroke has.
    StrokeBase {
        /// Radius in metres on the ground.
        radius_m: f64 = range::BRUSH_RADIUS_M,
        /// Share of the radius with full effect; 0.5 where left out.
        hardness: Option<f64> = range::SHARE,
        /// The way of the brush.
        points: StoredVertices,
    }
}

tagged! {
    /// Tools of a brush.
    StrokeTool of StrokeTools by "tool", "What a stroke does; other tools are kept and have no effect." {
        /// Adds height.
        Raise(Raise) = "raise" {
            /// Metres at the centre.
            strength_m: f64 = range::REACH_M,
        }
        /// Takes height away.
        Lower(Lower) = "lower" {
            /// Metres at the centre.
            strength_m: f64 = range::REACH_M,
        }
        /// Evens the ground out.
        SmoothOut(SmoothOut) = "smooth" {
            /// How much of the way to the smoothed ground.
            strength: f64 = range::SHARE,
        }
        /// Brings the ground to a height.
        Flatten(Flatten) = "flatten" {
            /// Metres above the datum.
            height_m: f64 = range::HEIGHT_M,
            /// How much of the way to that height.
            strength: f64 = range::SHARE,
        }
    }
}

/// Declares an object that has base fields and those that a tag names.
macro_rules! based {
    ($(#[$meta:meta])* $name:ident = $base:ident + $kind:ident) => {
        $(#[$meta])*
        #[derive(Clone, Debug, PartialEq)]
        pub(crate) struct $name {
            /// What all have.
            pub(crate) base: $base,
            /// What its kind has, and the rest.
            pub(crate) kind: $kind,
        }

        impl Stored for $name {
            fn read(value: Value, at: &At<'_>) -> Result<Self, Fault> {
                let mut map = object(value, at)?;
                let base = $base::take(&mut map, at)?;
                let kind = $kind::take(map, at)?;
                Ok(Self { base, kind })
            }

            fn write(&self) -> Value {
                let mut map = Extra::new();
                self.base.put(&mut map);
                self.kind.put($base::NAMES, &mut map);
                Value::Object(map)
            }
        }

        impl JsonSchema for $name {
            fn schema_name() -> Cow<'static, str> {
                stringify!($name).into()
            }

            fn json_schema(generator: &mut SchemaGenerator) -> Schema {
                let all = [
                    generator.subschema_for::<$base>(),
                    generator.subschema_for::<$kind>(),
                ];
                schemars::json_schema!({ "type": "object", "allOf": all })
            }
        }
    };
}

based! {
    /// A planning element.
    Element = ElementBase + ElementKind
}

based! {
    /// One stroke of a brush.
    Stroke = StrokeBase + StrokeTool
}
