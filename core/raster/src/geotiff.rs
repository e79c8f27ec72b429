//! GeoTIFF and Cloud Optimised GeoTIFF.
//!
//! Directories are read here, with bounds on everything; other crates decode single chunks.
//! Strips, tiles, planar and interleaved bands, integers of 1 to 64 bits, floats of 16 to 64,
//! palettes, alpha, nodata, overviews and masks inside the file or beside it, and chunks that a
//! sparse file leaves out.

mod bytes;
mod chunk;
mod companions;
mod control_points;
mod geokeys;
mod georeference;
mod ifd;
mod jpeg;
mod layout;
#[cfg(feature = "lerc")]
mod lerc;
mod levels;
mod meaning;
mod metadata;
mod packed;
mod pam;
mod read;
mod samples;
mod stretch;
mod strip;
mod webp;

use std::path::Path;
use std::sync::Arc;

pub(crate) use bytes::Bytes;
pub(crate) use chunk::Chunk;
pub(crate) use georeference::check_affine;
#[cfg(feature = "openexr")]
pub(crate) use stretch::{Numbers, range as shown_range};

use crate::chunk_cache::ChunkCache;
use crate::fault;
use crate::file::{Cancel, OverviewInfo, PixelRect, RasterFile, RasterInfo, ReadError};
use crate::open::{OpenError, OpenOptions, content_hash, placed};
use crate::parts::assert_inside;
use crate::{Bands, Block, pyramid, worldfile};
pub(crate) use companions::Companions;
use fault::Fault;
use geokeys::GeoKeys;
use georeference::Placement;
use ifd::{Ifd, TiffBytes, tag};
use layout::{Layout, SampleFormat, compression_name, photometric};
use levels::Level;
use meaning::{Choice, HeightScale, MeaningError, full_range};
use metadata::BandMetadata;
use pam::Pam;
use samples::Meaning;

/// The format's name in messages.
const FORMAT: &str = "GeoTIFF";
/// Decoded bytes of a chunk above which level 0 is copied into the pyramid too: a region of
/// interest would cost too much.
const AWKWARD_CHUNK_BYTES: u64 = 8 << 20;
/// An open TIFF.
pub(crate) struct GeoTiff {
    info: RasterInfo,
    remarks: Vec<String>,
    levels: Vec<Level>,
    meaning: Meaning,
    fingerprint: [u8; 32],
    cache: Arc<ChunkCache>,
    /// Number of the file in the cache.
    number: u64,
}

/// Opens a TIFF file and completes its pyramid.
pub(crate) fn open(path: &Path, options: &OpenOptions) -> Result<Arc<dyn RasterFile>, OpenError> {
    let io = |e: std::io::Error| OpenError::Io {
        reason: e.to_string(),
        path: path.to_owned(),
    };
    let mut hash = content_hash(path).map_err(io)?;
    hash.update(options.sample_facts().as_bytes());
    let beside = Companions::beside(path);
    beside.hash_into(&mut hash);
    let fingerprint = *hash.finalize().as_bytes();
    let bytes = Bytes::open(path).map_err(io)?;
    let tiff = GeoTiff::from_bytes(bytes, path, &beside, fingerprint, options)?;
    let level = &tiff.levels[0].image.layout;
    let awkward = level.row_bytes() * u64::from(level.chunk_height) > AWKWARD_CHUNK_BYTES;
    pyramid::complete(Arc::new(tiff), awkward, fingerprint, options)
}

impl GeoTiff {
    /// Reads the directories of a TIFF; samples are read later.
    pub(crate) fn from_bytes(
        bytes: Bytes,
        path: &Path,
        beside: &Companions,
        fingerprint: [u8; 32],
        options: &OpenOptions,
    ) -> Result<Self, OpenError> {
        let refuse = |error: MeaningError| match error {
            MeaningError::File(fault) => open_error(fault, path),
            MeaningError::Options(reason) => OpenError::Options {
                reason,
                path: path.to_owned(),
            },
        };
        let (file, directories) = TiffBytes::open(bytes).map_err(|f| open_error(f, path))?;
        let mut tiff =
            Self::build(file, &directories, path, beside, fingerprint, options).map_err(refuse)?;
        tiff.stretch(options.stretch)
            .map_err(|e| OpenError::from_read(e, path))?;
        if tiff.info.georeference.is_none() && options.georeference.is_none() {
            tiff.place_beside(path, options)?;
        }
        Ok(tiff)
    }

    fn build(
        file: TiffBytes,
        directories: &[Ifd],
        path: &Path,
        beside: &Companions,
        fingerprint: [u8; 32],
        options: &OpenOptions,
    ) -> Result<Self, MeaningError> {
        let ifd = &directories[0];
        let file = Arc::new(file);
        let levels = levels::read(&file, directories, beside)?;
        let layout = &levels[0].image.layout;
        let keys = GeoKeys::read(&file, ifd)?;
        let choice = Choice::of(layout, options)?;
        let own_nodata = file
            .text(ifd, tag::GDAL_NODATA, 256)?
            .as_deref()
            .and_then(metadata::nodata);
        let notes = beside.notes();
        let nodata = options
            .nodata
            .or(own_nodata)
            .or_else(|| notes.nodata(choice.selected[0]));
        let scale = height_scale(&file, ifd, &keys, &notes, choice.selected[0])?;
        let meaning = meaning::meaning(&file, ifd, layout, &choice, &scale, nodata)?;
        let placement = match (&options.georeference, Placement::read(&file, ifd, &keys)) {
            (Some(_), _) => Placement::default(),
            (None, placement) => placement?,
        };
        let remarks = placement.remark.iter().cloned().collect();
        let georeference = placed(placement.plane_from_pixel, placement.crs.clone(), options)
            .or_else(|| placement.georeference());
        let info = RasterInfo {
            path: path.to_owned(),
            format: FORMAT,
            overviews: levels
                .iter()
                .map(|l| OverviewInfo {
                    width: l.image.layout.width,
                    height: l.image.layout.height,
                })
                .collect(),
            bands: choice.bands,
            band_count: layout.samples,
            sample_type: sample_type(layout),
            compression: compression_name(layout).into(),
            deep_colour: choice.bands == Bands::Colour
                && layout.photometric != photometric::PALETTE
                && layout.bits > 8,
            nodata,
            may_have_holes: meaning.may_have_holes(full_range(layout))
                || layout.format == SampleFormat::Float
                || levels.iter().any(|l| l.mask.is_some() || l.may_be_sparse()),
            georeference,
        };
        let cache = Arc::clone(&options.chunk_cache);
        let number = cache.new_file();
        Ok(Self {
            info,
            remarks,
            levels,
            meaning,
            fingerprint,
            cache,
            number,
        })
    }

    /// Takes the position of pixels from a world file, where the file itself has none.
    fn place_beside(&mut self, path: &Path, options: &OpenOptions) -> Result<(), OpenError> {
        let found =
            worldfile::beside(path).map_err(|(companion, reason)| OpenError::Companion {
                reason,
                companion,
                path: path.to_owned(),
            })?;
        if let Some(affine) = found {
            let size = self.info.overviews[0];
            let assumed =
                worldfile::assumed_crs(&affine, size.width, size.height).map(str::to_owned);
            self.info.georeference = placed(Some(affine), assumed, options);
        }
        Ok(())
    }
}

impl RasterFile for GeoTiff {
    fn info(&self) -> &RasterInfo {
        &self.info
    }

    fn remarks(&self) -> &[String] {
        &self.remarks
    }

    fn fingerprint(&self) -> [u8; 32] {
        self.fingerprint
    }

    fn read(
        &self,
        overview: usize,
        rect: PixelRect,
        out: &mut Block,
        cancel: &Cancel,
    ) -> Result<(), ReadError> {
        let size = self.info.overviews[overview];
        assert_inside(rect, size);
        out.reshape(self.info.bands, rect.width as usize, rect.height as usize);
        self.read_level(overview, rect, out, cancel)
    }
}

impl Drop for GeoTiff {
    fn drop(&mut self) {
        self.cache.forget_file(self.number);
    }
}

fn height_scale(
    file: &TiffBytes,
    ifd: &Ifd,
    keys: &GeoKeys,
    notes: &Pam,
    band: u16,
) -> Result<HeightScale, Fault> {
    let xml = file
        .text(ifd, tag::GDAL_METADATA, 16 << 20)?
        .unwrap_or_default();
    let metadata = notes.complete(band, BandMetadata::of_band(&xml, band));
    let metres = match metadata.unit {
        Some(_) => metadata.metres(),
        None => keys.vertical_metres().unwrap_or(1.0),
    };
    Ok(HeightScale {
        scale: metadata.scale.unwrap_or(1.0) * metres,
        offset: metadata.offset.unwrap_or(0.0) * metres,
    })
}

fn sample_type(layout: &Layout) -> String {
    let name = match layout.format {
        SampleFormat::Unsigned => "uint",
        SampleFormat::Signed => "int",
        SampleFormat::Float => "float",
    };
    let palette = if layout.photometric == photometric::PALETTE {
        " palette"
    } else {
        ""
    };
    format!("{name}{}{palette}", layout.bits)
}

fn open_error(fault: Fault, path: &Path) -> OpenError {
    fault.on_open(FORMAT, path)
}

fn read_error(fault: Fault, path: &Path) -> ReadError {
    fault.on_read(FORMAT, path)
}
