//! Which part of the map a set of tiles covers, and in which levels.

use core::f64::consts::PI;

use super::store::{Description, TileAt, TileExtent};
use crate::fault::{Fault, damaged, unsupported};
use crate::file::OverviewInfo;

/// Half of the side of the map in metres, on the sphere of Web Mercator.
pub(super) const HALF_MAP_M: f64 = 6_378_137.0 * PI;
/// Longest side of the raster: coordinates of pixels have room to spare in 32 bits.
const MAX_SIDE: u64 = (1 << 31) - 1;
/// A level of this size needs no coarser one.
const COARSEST_SIDE: u64 = 256;

/// Which part of the map the raster is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Frame {
    /// Side of tiles in pixels.
    pub(super) side: u32,
    pub(super) max_zoom: u8,
    /// Number of own levels.
    pub(super) levels: u8,
    /// First column and row of pixels of level 0, a multiple of 2^(levels − 1).
    pub(super) origin: (u64, u64),
    /// Columns and rows of level 0, a multiple as well.
    pub(super) size: (u64, u64),
}

impl Frame {
    pub(super) fn of(description: &Description, side: u32) -> Result<Self, Fault> {
        let zoom = description.max_zoom;
        let map = u64::from(side) << zoom;
        let (mut x, mut y) = ((0, map), (0, map));
        if let Some(bounds) = description.hints.bounds_deg {
            (x, y) = pixels_of(bounds, map);
        } else if let Some(extent) = description.extent {
            let up = u32::from(zoom - extent.zoom.min(zoom));
            let pixels = |(first, end): (u32, u32)| {
                let pixel = |tile: u32| (u64::from(tile) << up) * u64::from(side);
                (pixel(first).min(map), pixel(end).min(map))
            };
            (x, y) = (pixels(extent.columns), pixels(extent.rows));
        }
        if x.0 >= x.1 || y.0 >= y.1 {
            return damaged("expected bounds with an area on the map, found none");
        }
        let zooms = zoom - description.min_zoom;
        let longest = (x.1 - x.0).max(y.1 - y.0);
        let coarser = (0..zooms)
            .find(|k| longest >> k <= COARSEST_SIDE)
            .unwrap_or(zooms);
        let step = 1_u64 << coarser;
        let aligned = |(first, end): (u64, u64)| (first / step * step, end.div_ceil(step) * step);
        let (x, y) = (aligned(x), aligned(y));
        let size = (x.1 - x.0, y.1 - y.0);
        if size.0.max(size.1) > MAX_SIDE {
            return unsupported(format!(
                "expected at most {MAX_SIDE} pixels a side, found {} × {} at zoom {zoom}",
                size.0, size.1
            ));
        }
        Ok(Self {
            side,
            max_zoom: zoom,
            levels: coarser + 1,
            origin: (x.0, y.0),
            size,
        })
    }

    pub(super) fn size_of(&self, level: u8) -> OverviewInfo {
        OverviewInfo {
            width: (self.size.0 >> level) as u32,
            height: (self.size.1 >> level) as u32,
        }
    }

    pub(super) fn plane_from_pixel(&self) -> [f64; 6] {
        let map = (u64::from(self.side) << self.max_zoom) as f64;
        let pixel_m = 2.0 * HALF_MAP_M / map;
        [
            self.origin.0 as f64 * pixel_m - HALF_MAP_M,
            pixel_m,
            0.0,
            HALF_MAP_M - self.origin.1 as f64 * pixel_m,
            0.0,
            -pixel_m,
        ]
    }
}

/// Columns and rows of pixels that hold bounds in degrees, on a map of so many pixels a side.
fn pixels_of([west, south, east, north]: [f64; 4], map: u64) -> ((u64, u64), (u64, u64)) {
    let side = map as f64;
    let column = |lon: f64| ((lon + 180.0) / 360.0 * side).clamp(0.0, side);
    let row = |lat: f64| {
        let lat_rad = lat.to_radians().clamp(-1.5, 1.5);
        let y = libm::asinh(libm::tan(lat_rad)) / PI;
        ((0.5 - 0.5 * y) * side).clamp(0.0, side)
    };
    // Bounds are decimal: a hair beyond a pixel's edge is the edge.
    let hair = 1e-3;
    let columns = if (-180.0..=180.0).contains(&west) && (-180.0..=180.0).contains(&east) {
        (column(west), column(east))
    } else {
        // Across the antimeridian.
        (0.0, side)
    };
    let range = |first: f64, end: f64| {
        (
            libm::floor(first + hair).min(side - 1.0) as u64,
            libm::ceil(end - hair).max(1.0) as u64,
        )
    };
    (range(columns.0, columns.1), range(row(north), row(south)))
}

/// The tiles of the finest zoom that cover all the tiles given, unless there are none.
pub(super) fn extent_of(tiles: impl Iterator<Item = TileAt> + Clone) -> Option<TileExtent> {
    let zoom = tiles.clone().map(|t| t.zoom).max()?;
    let (mut columns, mut rows) = ((u32::MAX, 0), (u32::MAX, 0));
    for tile in tiles {
        let up = zoom - tile.zoom;
        columns = (
            columns.0.min(tile.column << up),
            columns.1.max((tile.column + 1) << up),
        );
        rows = (rows.0.min(tile.row << up), rows.1.max((tile.row + 1) << up));
    }
    Some(TileExtent {
        zoom,
        columns,
        rows,
    })
}
