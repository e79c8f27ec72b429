//! The file's own types, apart from the runtime's: a stored version never changes once released.
//!
//! Everything goes through [`serde_json::Value`] with a place in hand, so that every fault names where
//! it is, and through the same door both ways, so that what can be written can be read.

#[macro_use]
pub(crate) mod value;

pub(crate) mod adjust;
pub(crate) mod blend;
pub(crate) mod colour;
pub(crate) mod colour_detail;
pub(crate) mod convert;
pub(crate) mod edits;
pub(crate) mod elements;
pub(crate) mod fault;
pub(crate) mod mask;
pub(crate) mod migrate;
pub(crate) mod noise;
pub(crate) mod parse;
pub(crate) mod range;
pub(crate) mod rasters;
pub(crate) mod relief;
pub(crate) mod scenarios;
pub(crate) mod series;
pub(crate) mod settings;
pub(crate) mod stretch;
pub(crate) mod v1;
pub(crate) mod vector;
pub(crate) mod vertices;
