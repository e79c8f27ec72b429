//! The stored document: layers, planet, camera, edits, undo and the file format.
//!
//! Invariant: what is read is what is written. Unknown fields and unknown kinds of layers pass
//! through a load and a save untouched; an [`Edit`] followed by its inverse leaves the same bytes.
//! Runtime types (here) and stored types (the private module `stored`) are different types, so that
//! the file format can stay still while the program moves.
//!
//! Deliberately absent: pixels, raster files (a path is only text here), threads and the graph.

mod apply;
mod build;
mod document;
mod edit;
mod error;
mod file;
mod history;
mod json;
mod label;
mod layer;
mod paths;
mod stored;

pub use apply::EditError;
pub use build::{NewProjectError, SourceRole, layer_from_source};
pub use document::{
    Auto, Body, CameraSettings, Extra, PlanetSettings, Project, Quality, Sun, SunAnchor,
};
pub use edit::{Affects, Aspect, Edit};
pub use error::{OpenProjectError, SaveProjectError};
pub use file::{FileStamp, Replace, is_unchanged, open, read_text, save_atomic};
pub use history::History;
pub use json::{MOST_BYTES, schema, schema_text};
pub use layer::{
    Adjust, Blend, Extent, Georeference, HeightEncoding, HeightLayer, ImageryLayer, Layer, LayerId,
    LayerKind, Noise, NoiseLayer, NoiseMode, Resampling, Source, Stretch, TileRows, Tint,
    TintInterpolation, TintLayer, TintStop,
};
pub use paths::{resolve_path, store_path};
pub use stored::fault::Fault;
