//! Spaces, map coordinates, the tile grid and clipmap geometry of a planet.
//!
//! Pure maths in f64. Invariant: this crate never sees a pixel, a file, a thread or a GPU.
//!
//! Spaces used throughout (names of values end in them):
//!
//! - **map**: plate carrée, longitude `lon_rad` (east positive) and colatitude `colat_rad`
//!   (0 at the north pole, π at the south pole).
//! - **lattice**: integer sample indices (column, row) of a [`Lattice`]; samples are areas, the centre
//!   of sample `i` lies at `i + ½`.
//! - **world**: planet-fixed Cartesian metres, z through the north pole, x through longitude 0.
//! - **focus**: Cartesian metres at a focus point on the sphere, x south, y east, z up.

pub mod camera;
pub mod clipmap;
pub mod ellipsoid;
pub mod grid_memory;
pub mod lattice;
pub mod map;
pub mod rect;
pub mod tile;
pub mod transform;

pub use camera::Camera;
pub use ellipsoid::Planet;
pub use grid_memory::GridMemory;
pub use lattice::{Grid, GridCrs, Lattice};
pub use map::MapPoint;
pub use rect::SampleRect;
pub use tile::{LevelKey, TILE_SAMPLES, TileKey};
