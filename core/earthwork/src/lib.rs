//! Planning surfaces: polygons, corridors and brushes that change the ground's heights.
//!
//! Pure geometry in f64 metres in local frames on the ellipsoid; no pixels, files or threads. Input is
//! never refused: whatever is odd about it is named in a [`Warning`] and drawn as well as can be.
//!
//! Elements ([`element`]) are [`Prepared`] one by one; those that stand on the ground say where they
//! need its heights ([`Prepared::need`]) and become [`Shaped`] with them. A [`Design`] is a list of
//! shaped elements and answers heights at places. The same places get the same bits however they are
//! asked for.

mod brush;
mod check;
mod corridor;
pub mod daylight;
pub mod design;
pub mod element;
mod envelope;
mod footprint;
pub mod frame;
pub mod harmonic;
mod identity;
pub mod index;
mod infill;
mod patch;
mod polygon;
pub mod prepared;
mod rings;
mod solid;
mod strip;
mod tin;
mod tree;
mod twofold;
pub mod warning;

pub use daylight::{DaylightLine, Ending, HeightsOf};
pub use design::{Design, Outcome, Part, Samples};
pub use element::{
    Corridor, Element, Polygon, Profile, Section, Shape, Side, Stroke, Surface, Tool, Vertex,
};
pub use frame::{Frame, MapRect};
pub use harmonic::harmonic;
pub use index::MapIndex;
pub use prepared::{GroundNeed, Prepared, Shaped};
pub use warning::{Warning, WarningKind};
