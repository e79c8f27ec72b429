//! A file in memory.

use std::path::PathBuf;
use std::sync::Arc;

use relievo_planet::Planet;
use relievo_raster::file::{Georeference, OverviewInfo, ReadError};
use relievo_raster::kernel::Kernel;
use relievo_raster::warp::Warp;
use relievo_raster::{Bands, Block, Cancel, PixelRect, RasterFile, RasterInfo};

const SIDE: u32 = 64;

/// 64 × 64 heights of 10 m, 8 by 8 degrees around (4° E, 4° N).
pub(crate) struct Flat(RasterInfo);

impl Flat {
    pub(crate) fn warp(may_have_holes: bool, planet: Planet) -> Arc<Warp> {
        let info = RasterInfo {
            path: PathBuf::from("flat"),
            format: "memory",
            overviews: vec![OverviewInfo {
                width: SIDE,
                height: SIDE,
            }],
            bands: Bands::Height,
            band_count: 1,
            sample_type: "float32".into(),
            compression: "none".into(),
            deep_colour: false,
            nodata: None,
            may_have_holes,
            georeference: Some(Georeference {
                crs: "EPSG:4326".into(),
                plane_from_pixel: [0.0, 0.125, 0.0, 8.0, 0.0, -0.125],
            }),
        };
        Arc::new(
            Warp::new(Arc::new(Self(info)), planet, Kernel::Bilinear).expect("a file with a place"),
        )
    }
}

impl RasterFile for Flat {
    fn info(&self) -> &RasterInfo {
        &self.0
    }

    fn fingerprint(&self) -> [u8; 32] {
        [7; 32]
    }

    fn read(
        &self,
        _overview: usize,
        rect: PixelRect,
        out: &mut Block,
        _cancel: &Cancel,
    ) -> Result<(), ReadError> {
        out.reshape(Bands::Height, rect.width as usize, rect.height as usize);
        out.samples_mut().fill(10.0);
        Ok(())
    }
}
