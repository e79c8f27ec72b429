//! Vector features: read from files, styled, found by place, drawn into blocks of samples, written.
//!
//! Places are longitude and latitude in radians. Edges are straight lines in longitude and latitude
//! (RFC 7946), also those of files in projected systems, of which only the vertices are transformed.
//!
//! Invariant: no input makes anything here panic, hang, or take memory in proportion to what a header
//! merely claims; the same features and style give the same samples for a whole as for its parts.
//!
//! Absent: which layer lies on which (`relievo-project`), caches of tiles (`relievo-tiles`).

pub mod draw;
pub mod error;
pub mod features;
pub mod labels;
pub mod open;
pub mod places;
pub mod style;
pub mod value;
pub mod write;

mod read;

pub use draw::Drawing;
pub use error::VectorError;
pub use features::{Bounds, Builder, Features, Limits, Outline, Shape};
pub use open::{OpenOptions, Summary, is_vector, open};
pub use style::Style;
pub use value::Value;
