//! One file per format.

#[cfg(feature = "flatgeobuf")]
pub(crate) mod flatgeobuf;
pub(crate) mod geojson;
#[cfg(feature = "geopackage")]
pub(crate) mod geopackage;
#[cfg(feature = "shapefile")]
pub(crate) mod shapefile;
#[cfg(feature = "geopackage")]
mod wkb;
