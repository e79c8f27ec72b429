//! The stored document: layers, planet, camera, edits, undo and the file format.
//!
//! Invariant: what is read is what is written. Unknown fields and unknown kinds of layers pass
//! through a load and a save untouched; an [`Edit`] followed by its inverse leaves the same bytes.
//! Runtime types (here) and stored types (the private module `stored`) are different types, so that
//! the file format can stay still while the program moves.
//!
//! Deliberately absent: pixels, raster files (a path is only text here), threads and the graph.

mod document;
mod edit;
mod layer;

pub use document::{
    Auto, Body, CameraSettings, Extra, PlanetSettings, Project, Quality, Sun, SunAnchor,
};
pub use edit::{Affects, Aspect, Edit};
pub use layer::{
    Adjust, Blend, Extent, Georeference, HeightLayer, ImageryLayer, Layer, LayerId, LayerKind, Noise,
    NoiseLayer, NoiseMode, Resampling, Source, Tint, TintInterpolation, TintLayer, TintStop,
};
