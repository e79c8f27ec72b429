//! What every reader of a raster file offers: regions of interest of any overview, as f32 blocks.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::{Bands, Block};

/// A token that asks long work to stop; clones share the request.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<AtomicBool>);

impl Cancel {
    /// Asks to stop.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether somebody asked to stop.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Half-open rectangle of pixels of one overview of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelRect {
    /// First column.
    pub x: u32,
    /// First row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

/// Size of one level of a file's own pyramid; level 0 is the full image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OverviewInfo {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

/// Where a file's pixels lie: pixel (x, y) of level 0, corners at integers, in a coordinate system.
#[derive(Clone, Debug, PartialEq)]
pub struct Georeference {
    /// The system: `EPSG:n`, `ESRI:n` or a proj string.
    pub crs: Arc<str>,
    /// `[x0, dx/dcol, dx/drow, y0, dy/dcol, dy/drow]`: plane coordinates (degrees in geographic
    /// systems, east and north positive) of the outer corner of pixel (0, 0) and their change per
    /// pixel; PixelIsPoint is already accounted for.
    pub plane_from_pixel: [f64; 6],
}

/// What a file says of itself.
#[derive(Clone, Debug)]
pub struct RasterInfo {
    /// The file.
    pub path: PathBuf,
    /// Name of the format, for people: `GeoTIFF`, `JPEG`.
    pub format: &'static str,
    /// The levels, finest first; at least one, none with a side of zero.
    pub overviews: Vec<OverviewInfo>,
    /// What [`RasterFile::read`] gives: [`Bands::Height`] for one band of data, else
    /// [`Bands::Colour`].
    pub bands: Bands,
    /// Bands in the file.
    pub band_count: u16,
    /// Stored sample type, for people: `int16`, `float32`, `uint8 palette`.
    pub sample_type: String,
    /// Compression, for people.
    pub compression: String,
    /// Whether a colour file needs more than 8 bits a channel.
    pub deep_colour: bool,
    /// Stored value that means nodata, as the options or else the file state it.
    pub nodata: Option<f64>,
    /// Whether some sample of some overview may be a hole (a NaN height, a colour whose alpha is
    /// not 1). `false` is a promise that rests on the file's structure: neither nodata nor masks
    /// nor alpha nor floats, and no chunk left out.
    pub may_have_holes: bool,
    /// Where the pixels lie; `None` if neither the file nor its companions say.
    pub georeference: Option<Georeference>,
}

/// What the system is said to have said of a file that another program changed since it was opened.
pub(crate) const CHANGED: &str = "expected the file as it was opened, found it changed on disk";

/// Why a region could not be read.
#[derive(Clone, Debug, thiserror::Error)]
pub enum ReadError {
    /// Somebody asked to stop.
    #[error("cancelled")]
    Cancelled,
    /// The file cannot be read at the operating system's level.
    #[error("cannot read {path:?}: {reason}")]
    Io {
        /// What the system said.
        reason: String,
        /// The file.
        path: PathBuf,
    },
    /// The file's content breaks its format.
    #[error("damaged {format} file: {reason}: {path:?}")]
    Damaged {
        /// Name of the format.
        format: &'static str,
        /// Expected and found.
        reason: String,
        /// The file.
        path: PathBuf,
    },
}

impl ReadError {
    /// Whether another program changed the file since it was opened: opened again it may be in
    /// order.
    pub fn is_change(&self) -> bool {
        matches!(self, Self::Io { reason, .. } if reason == CHANGED)
    }

    /// The file; `None` when somebody asked to stop.
    pub fn path(&self) -> Option<&Path> {
        match self {
            Self::Cancelled => None,
            Self::Io { path, .. } | Self::Damaged { path, .. } => Some(path),
        }
    }
}

/// An open raster file. Reads may run in any number of threads at once and give the same samples
/// in any order.
pub trait RasterFile: Send + Sync {
    /// What the file says of itself.
    fn info(&self) -> &RasterInfo;

    /// What a user should know of how the file was understood, a line each: a place that was fitted,
    /// say.
    fn remarks(&self) -> &[String] {
        &[]
    }

    /// 32 bytes that change when the content does: a hash over the file's length, modification time
    /// and path, or over the content.
    fn fingerprint(&self) -> [u8; 32];

    /// Reads a rectangle of an overview into `out` (reshaped to fit): heights in metres with scale
    /// and offset applied and NaN for nodata, or straight display-referred RGBA with alpha 0 for
    /// nodata and masked pixels.
    ///
    /// # Errors
    /// [`ReadError`] when the file is damaged or gone, or work was cancelled.
    ///
    /// # Panics
    /// If the overview does not exist or the rectangle does not lie inside it.
    fn read(
        &self,
        overview: usize,
        rect: PixelRect,
        out: &mut Block,
        cancel: &Cancel,
    ) -> Result<(), ReadError>;

    /// The file's path.
    fn path(&self) -> &Path {
        &self.info().path
    }
}
