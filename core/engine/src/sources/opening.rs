//! Opening a file as a layer asks for it.

use std::path::Path;
use std::sync::Arc;

use relievo_project::{Georeference, HeightEncoding, Source, Stretch, TileRows};
use relievo_raster::RasterFile;
use relievo_raster::open::{self as raster_open, OpenOptions, open};

use relievo_vector as vector;

use super::{Request, Shared, SourceState, What};
use crate::vectors::OpenFeatures;

impl Shared {
    /// Opens a file as its layer asks for it; one line where that cannot be.
    pub(super) fn open(self: &Arc<Self>, request: &Request) -> Result<SourceState, String> {
        match &request.what {
            What::Raster {
                source,
                bands,
                stretch,
            } => {
                let file = self.open_raster(request, source, bands.as_deref(), *stretch)?;
                Ok(SourceState::Open(file))
            }
            What::Vector { layer, crs } => {
                let options = vector::OpenOptions {
                    crs: crs.as_deref().map(Arc::from),
                    layer: layer.clone(),
                    cancel: self.cancel.clone(),
                    ..vector::OpenOptions::default()
                };
                let (features, summary) =
                    vector::open(&request.key.path, &options).map_err(|e| e.to_string())?;
                Ok(SourceState::Features(Arc::new(OpenFeatures {
                    features: Arc::new(features),
                    summary,
                })))
            }
        }
    }

    /// Opens a raster, with a pyramid if it needs one.
    fn open_raster(
        self: &Arc<Self>,
        request: &Request,
        source: &Source,
        bands: Option<&[u16]>,
        stretch: Stretch,
    ) -> Result<Arc<dyn RasterFile>, String> {
        let path = &request.key.path;
        let progress = {
            let (shared, key) = (Arc::clone(self), request.key.clone());
            move |done: f32| shared.progress(&key, done)
        };
        let mut options = OpenOptions {
            cache_dir: self.cache_folder.clone(),
            progress: Some(Arc::new(progress)),
            cancel: self.cancel.clone(),
            chunk_cache: Arc::clone(&self.chunks),
            as_bands: Some(request.key.bands),
            // People count bands from 1.
            select: bands.map(|b| b.iter().map(|n| n.saturating_sub(1)).collect()),
            nodata: source.nodata,
            stretch: match stretch {
                Stretch::Auto => raster_open::Stretch::Auto,
                Stretch::Full => raster_open::Stretch::Full,
                Stretch::MinMax => raster_open::Stretch::MinMax,
                Stretch::Percentile { low, high } => raster_open::Stretch::Percentile { low, high },
                Stretch::Range { black, white } => raster_open::Stretch::Range {
                    low: black,
                    high: white,
                },
            },
            encoding: source.encoding.map(|e| match e {
                HeightEncoding::TerrainRgb => raster_open::HeightEncoding::TerrainRgb,
                HeightEncoding::Terrarium => raster_open::HeightEncoding::Terrarium,
            }),
            tile_rows: source.tile_rows.map(|r| match r {
                TileRows::Xyz => raster_open::TileRows::FromNorth,
                TileRows::Tms => raster_open::TileRows::FromSouth,
            }),
            ..OpenOptions::default()
        };
        if let Some(place) = &source.georeference {
            place_by(&mut options, place, path)?;
        }
        let file = open(path, &options).map_err(|e| e.to_string())?;
        if file.info().georeference.is_none() {
            return Err(format!(
                "expected a place on the planet, found no georeference; give the layer an extent: \"{}\"",
                path.display()
            ));
        }
        Ok(file)
    }
}

/// Turns what the project says of a file's place into what the reader takes.
fn place_by(options: &mut OpenOptions, place: &Georeference, path: &Path) -> Result<(), String> {
    let Some(extent) = place.extent else {
        options.crs = place.crs.as_deref().map(Arc::from);
        return Ok(());
    };
    // The extent is one of outer edges, so the size in pixels is needed first.
    let probe = OpenOptions {
        make_pyramid: false,
        ..options.clone()
    };
    // A file that cannot be opened without a place (heights whose name says none) opens with any.
    let anywhere = OpenOptions {
        georeference: Some(relievo_raster::file::Georeference {
            crs: Arc::from("EPSG:4326"),
            plane_from_pixel: [0.0, 1.0, 0.0, 0.0, 0.0, -1.0],
        }),
        ..probe.clone()
    };
    let file = match open(path, &probe) {
        Ok(file) => file,
        Err(_) => open(path, &anywhere).map_err(|e| e.to_string())?,
    };
    let full = file.info().overviews[0];
    let (dx, dy) = (
        (extent.east - extent.west) / f64::from(full.width),
        (extent.south - extent.north) / f64::from(full.height),
    );
    let own = file
        .info()
        .georeference
        .as_ref()
        .map(|g| Arc::clone(&g.crs));
    let crs = place.crs.as_deref().map(Arc::from).or(own);
    options.georeference = Some(relievo_raster::file::Georeference {
        crs: crs.unwrap_or_else(|| Arc::from("EPSG:4326")),
        plane_from_pixel: [extent.west, dx, 0.0, extent.north, 0.0, dy],
    });
    Ok(())
}
