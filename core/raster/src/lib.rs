//! Samples: tiles, kernels, readers and writers of raster files.
//!
//! Invariant: everything here is a pure function of files and arguments; nothing knows of graphs,
//! caches of tiles, projects or GPUs. No input makes it panic, hang, or take memory in proportion
//! to what a header merely claims.

pub mod block;
pub mod chunk_cache;
pub mod colour;
pub mod crs;
pub mod edge;
pub mod file;
pub mod kernel;
pub mod normal;
pub mod open;
pub mod power;
pub mod reduce;
#[cfg(feature = "sqlite")]
pub mod sqlite;
pub mod tile;
pub mod vector;
pub mod warp;
pub mod worldfile;
pub mod write;

mod asciigrid;
mod fault;
mod geotiff;
mod hgt;
#[cfg(feature = "openexr")]
mod openexr;
mod parts;
mod picture;
mod prj;
mod pyramid;
mod text;
mod tileset;

pub use block::{Bands, Block};
pub use file::{Cancel, PixelRect, RasterFile, RasterInfo};
pub use tile::{Normal, Sample, SampleType, Tile, TileBuilder};
