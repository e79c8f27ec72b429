//! The stored document: layers, planning elements, scenarios, edits, undo and the file format.
//!
//! Invariant: what is read is what is written. Unknown fields and unknown kinds of layers pass
//! through a load and a save untouched; an [`Edit`] followed by its inverse leaves the same bytes.
//! Runtime types (here) and stored types (the private module `stored`) are different types, so that
//! the file format can stay still while the program moves.
//!
//! Deliberately absent: pixels, raster files (a path is only text here), the graph, and threads but
//! for the one that writes the [`Journal`].

mod adjust;
mod apply;
mod build;
mod colour_detail;
mod detail;
mod document;
mod edit;
mod element;
mod error;
mod file;
mod history;
mod id;
mod journal;
mod json;
mod label;
mod layer;
mod lock;
mod mask;
mod paths;
mod reference;
mod relief;
mod scenario;
mod series;
mod side;
mod stored;
mod vector_layer;
mod vertices;

pub use adjust::{Adjust, AdjustSpace, ClearColour, CurvePoint, NEUTRAL_TEMPERATURE_K, ToneCurves};
pub use apply::EditError;
pub use build::{NewProjectError, SourceRole, layer_from_source};
pub use colour_detail::{ColourDetail, DetailBy};
pub use detail::{Detail, DetailLayer, DetailMethod};
pub use document::{
    Aim, Auto, Body, Bookmark, CameraSettings, Extra, PlanetSettings, Project, Quality, Sun,
    SunAnchor,
};
pub use edit::{Affects, Aspect, Edit};
pub use element::{
    Brush, BrushTool, Corridor, Element, ElementKind, ElementStyle, Polygon, Profile, ProfileKind,
    Section, SectionKind, SideSlopes, Stroke, Surface, SurfaceKind,
};
pub use error::{OpenProjectError, SaveProjectError};
pub use file::{
    FileStamp, Replace, free_name_beside, is_unchanged, open, read_text, save_atomic, save_with,
};
pub use history::History;
pub use id::{ElementId, LayerId, ScenarioId};
pub use journal::{
    Abandoned, Journal, JournalOptions, Recovery, RecoveryError, abandoned, forget_untitled,
    is_untitled, keep_untitled,
};
pub use json::{MOST_BYTES, schema, schema_text};
pub use layer::{
    Blend, Extent, Georeference, HeightEncoding, HeightLayer, ImageryLayer, Layer, LayerKind,
    Noise, NoiseLayer, NoiseMode, Resampling, Source, Stretch, TileRows,
};
pub use lock::{Holder, LockError, ProjectLock};
pub use mask::{Lens, LensShape, Mask, MaskRange};
pub use paths::{resolve_path, store_path};
pub use reference::WrongReference;
pub use relief::{
    ContoursLayer, SlopeLayer, SlopeStop, SlopeUnit, Tint, TintInterpolation, TintLayer, TintStop,
};
pub use scenario::{Change, ChangeKind, LayerOverride, Scenario};
pub use series::{Date, Dated, parse_date};
pub use side::{MissingGeometry, side_folder};
pub use stored::fault::{Fault, quote};
pub use vector_layer::{
    Casing, ClassMatch, ClassedBy, Extrude, Hatch, Label, PointSymbol, StyleClass, Symbol,
    VectorLayer, VectorStyle, Width, WidthUnit,
};
pub use vertices::{ContentHash, SideFile, Vertex, Vertices};
