//! One file per format.

pub(crate) mod flatgeobuf;
pub(crate) mod geojson;
pub(crate) mod geopackage;
pub(crate) mod shapefile;
mod wkb;
