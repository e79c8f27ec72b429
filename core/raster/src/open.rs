//! Opening a raster file of any known format.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock};
use std::time::UNIX_EPOCH;

use crate::chunk_cache::ChunkCache;
use crate::file::{Cancel, Georeference, RasterFile, ReadError};
#[cfg(feature = "openexr")]
use crate::openexr;
pub use crate::tileset::HeightEncoding;
use crate::tileset::{self, Kind};
use crate::{Bands, asciigrid, geotiff, hgt, picture};

/// Bytes of decoded samples that the chunk cache holds unless told otherwise.
pub const DEFAULT_CHUNK_CACHE_BYTES: usize = 256 << 20;

/// Called with the part that is done, 0 to 1, while a pyramid is made.
pub type Progress = Arc<dyn Fn(f32) + Send + Sync>;

/// How stored numbers of more than 8 bits become colours.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Stretch {
    /// 8-bit samples and palettes as they are; floats as they are if all lie between 0 and 1;
    /// others like [`Stretch::Percentile`] from 2 to 98 percent.
    #[default]
    Auto,
    /// The range of the stored type (0 to 1 for floats, unclamped).
    Full,
    /// The lowest value is shown as 0, the highest as 1.
    MinMax,
    /// The same after so many percent of the lowest and above so many percent are left out; one
    /// range for all bands, so hues stay.
    Percentile {
        /// Percent below what is shown as 0, 0 to 100.
        low: f64,
        /// Percent below what is shown as 1, 0 to 100.
        high: f64,
    },
    /// Given stored values.
    Range {
        /// Shown as 0.
        low: f64,
        /// Shown as 1.
        high: f64,
    },
}

/// From where the rows of a set of tiles count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TileRows {
    /// Row 0 lies in the north: XYZ, as folders and web maps have it.
    FromNorth,
    /// Row 0 lies in the south: TMS, as MBTiles and gdal2tiles have it.
    FromSouth,
}

/// What to make of a file beyond what it says of itself.
#[derive(Clone)]
pub struct OpenOptions {
    /// Where the pixels lie, whatever the file says.
    pub georeference: Option<Georeference>,
    /// The coordinate system for a file whose pixels have plane coordinates but no system (a world
    /// file, say), or another one than the file says.
    pub crs: Option<Arc<str>>,
    /// Folder for pyramids of files without overviews; `None` keeps them in memory.
    pub cache_dir: Option<PathBuf>,
    /// Whether overviews that the file lacks are made. Without them a file lists its own only.
    pub make_pyramid: bool,
    /// Told how far a pyramid is.
    pub progress: Option<Progress>,
    /// Stops the making of a pyramid.
    pub cancel: Cancel,
    /// Decoded chunks, shared by all files that are opened with clones of these options.
    pub chunk_cache: Arc<ChunkCache>,
    /// What to read the file as; by default one band of data is heights, except 1-bit pictures.
    pub as_bands: Option<Bands>,
    /// Bands of the file to use, counted from 0: one for heights, one or three for colours.
    pub select: Option<Vec<u16>>,
    /// How numbers become colours.
    pub stretch: Stretch,
    /// Stored value that means nodata, instead of the one that the file states: heights with it are
    /// NaN, and colours whose bands all have it are transparent. Lossy compression blurs values, so
    /// that few pixels of a JPEG have exactly the one that they were given.
    pub nodata: Option<f64>,
    /// How the colours of tiles mean heights; by default as the set's metadata say. Only sets of
    /// tiles have encodings.
    pub encoding: Option<HeightEncoding>,
    /// From where rows of tiles count; by default as the set's metadata or else its kind say.
    pub tile_rows: Option<TileRows>,
}

impl Default for OpenOptions {
    fn default() -> Self {
        Self {
            georeference: None,
            crs: None,
            cache_dir: None,
            make_pyramid: true,
            progress: None,
            cancel: Cancel::default(),
            chunk_cache: Arc::new(ChunkCache::new(DEFAULT_CHUNK_CACHE_BYTES)),
            as_bands: None,
            select: None,
            stretch: Stretch::Auto,
            nodata: None,
            encoding: None,
            tile_rows: None,
        }
    }
}

/// Why a file could not be opened.
#[derive(Clone, Debug, thiserror::Error)]
pub enum OpenError {
    /// The operating system says no.
    #[error("cannot read the file: {reason}: {path:?}")]
    Io {
        /// What the system said.
        reason: String,
        /// The file.
        path: PathBuf,
    },
    /// The content is of no known format.
    #[error(
        "expected a GeoTIFF, JPEG, PNG, WebP, OpenEXR, ASCII grid or SRTM file or a set of tiles, found {found}: {path:?}"
    )]
    UnknownFormat {
        /// What it seems to be.
        found: String,
        /// The file.
        path: PathBuf,
    },
    /// The content breaks its format.
    #[error("damaged {format} file: {reason}: {path:?}")]
    Damaged {
        /// Name of the format.
        format: &'static str,
        /// Expected and found.
        reason: String,
        /// The file.
        path: PathBuf,
    },
    /// The content is in order, but nothing here reads it.
    #[error("cannot use the {format} file: {reason}: {path:?}")]
    Unsupported {
        /// Name of the format.
        format: &'static str,
        /// Expected and found.
        reason: String,
        /// The file.
        path: PathBuf,
    },
    /// A companion file (a world file) is not in order.
    #[error("unusable companion of {path:?}: {reason}: {companion:?}")]
    Companion {
        /// Expected and found.
        reason: String,
        /// The companion.
        companion: PathBuf,
        /// The file.
        path: PathBuf,
    },
    /// What the options ask for does not fit the file.
    #[error("the file does not fit what is asked of it: {reason}: {path:?}")]
    Options {
        /// Expected and found.
        reason: String,
        /// The file.
        path: PathBuf,
    },
    /// Its pyramid could not be made.
    #[error("cannot make overviews: {reason}: {path:?}")]
    Pyramid {
        /// What went wrong.
        reason: String,
        /// The file.
        path: PathBuf,
    },
    /// Somebody asked to stop.
    #[error("cancelled while opening {path:?}")]
    Cancelled {
        /// The file.
        path: PathBuf,
    },
}

impl OpenError {
    /// The same trouble met while reading samples to open the file.
    pub(crate) fn from_read(error: ReadError, file: &Path) -> Self {
        match error {
            ReadError::Cancelled => Self::Cancelled {
                path: file.to_owned(),
            },
            ReadError::Io { reason, path } => Self::Io { reason, path },
            ReadError::Damaged {
                format,
                reason,
                path,
            } => Self::Damaged {
                format,
                reason,
                path,
            },
        }
    }
}

/// Whether a path is a set of tiles: a folder of them, MBTiles or PMTiles. Only the beginning is
/// looked at; `false` where nothing can be read.
pub fn is_tile_set(path: &Path) -> bool {
    let mut head = [0; 7];
    if path.is_dir() {
        return tileset::is_folder_of_tiles(path);
    }
    File::open(path).is_ok_and(|mut f| f.read_exact(&mut head).is_ok())
        && (head.starts_with(b"SQLite") || head == *b"PMTiles")
}

/// Opens a file; its content, not its name, decides the format.
///
/// With [`OpenOptions::make_pyramid`] (the default) the file's list of overviews ends with a small
/// one: those that the file lacks are made now and kept in the cache folder.
///
/// # Errors
/// [`OpenError`]: one line that says what was expected and what was found, with the path last.
pub fn open(path: &Path, options: &OpenOptions) -> Result<Arc<dyn RasterFile>, OpenError> {
    let io = |e: io::Error| OpenError::Io {
        reason: e.to_string(),
        path: path.to_owned(),
    };
    let metadata = std::fs::metadata(path).map_err(io)?;
    if metadata.is_dir() && tileset::is_folder_of_tiles(path) {
        return tileset::open(path, Kind::Folder, options);
    }
    if !metadata.is_file() {
        // A pipe would keep the reader waiting, a device would never end.
        let found = if metadata.is_dir() {
            "a folder without tiles"
        } else {
            "a pipe or a device"
        };
        return Err(OpenError::UnknownFormat {
            found: found.into(),
            path: path.to_owned(),
        });
    }
    let length = metadata.len();
    let mut head = Vec::new();
    File::open(path)
        .and_then(|f| f.take(16).read_to_end(&mut head))
        .map_err(io)?;
    match head.as_slice() {
        #[cfg(feature = "sqlite")]
        [b'S', b'Q', b'L', b'i', b't', b'e', ..] => {
            return tileset::open(path, Kind::MbTiles, options);
        }
        [b'P', b'M', b'T', b'i', b'l', b'e', b's', ..] => {
            return tileset::open(path, Kind::PmTiles, options);
        }
        _ if options.encoding.is_some() => {
            return Err(OpenError::Options {
                reason: "expected a set of tiles for an encoding of heights, found a single file"
                    .into(),
                path: path.to_owned(),
            });
        }
        _ => {}
    }
    match head.as_slice() {
        // A format without a header: its first samples may look like anything.
        _ if hgt::is_one(path, length) => hgt::open(path, options),
        [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => geotiff::open(path, options),
        [0xff, 0xd8, 0xff, ..] => picture::open(path, picture::Format::Jpeg, options),
        [0x89, b'P', b'N', b'G', 0x0d, 0x0a, 0x1a, 0x0a, ..] => {
            picture::open(path, picture::Format::Png, options)
        }
        [
            b'R',
            b'I',
            b'F',
            b'F',
            _,
            _,
            _,
            _,
            b'W',
            b'E',
            b'B',
            b'P',
            ..,
        ] => picture::open(path, picture::Format::WebP, options),
        #[cfg(feature = "openexr")]
        [0x76, 0x2f, 0x31, 0x01, ..] => openexr::open(path, options),
        text if asciigrid::is_one(text) => asciigrid::open(path, options),
        _ if hgt::is_named(path) => hgt::open(path, options),
        other => Err(OpenError::UnknownFormat {
            found: describe(other),
            path: path.to_owned(),
        }),
    }
}

/// What a file that is not supported may be.
fn describe(head: &[u8]) -> String {
    match head {
        [] => "an empty file".into(),
        [0x89, b'H', b'D', b'F', ..] => "an HDF5 file".into(),
        [b'R', b'I', b'F', b'F', ..] => "a RIFF file that is no WebP".into(),
        [b'{' | b'[', ..] => "JSON text".into(),
        [b'P', b'K', ..] => "a ZIP archive".into(),
        // Met only in programs that were built without the reader.
        [0x76, 0x2f, 0x31, 0x01, ..] => {
            "OpenEXR, which this program was built without (feature \"openexr\")".into()
        }
        [b'S', b'Q', b'L', b'i', b't', b'e', ..] => {
            "a SQLite database, which this program was built without (feature \"sqlite\")".into()
        }
        other => {
            let hex: Vec<String> = other.iter().take(4).map(|b| format!("{b:02x}")).collect();
            format!("a file that starts with {}", hex.join(" "))
        }
    }
}

/// A hash over what changes when a file's content does: its length, modification time and absolute
/// path. The path, because files of one name, size and date lie in many a folder.
pub(crate) fn content_hash(path: &Path) -> io::Result<blake3::Hasher> {
    static VERSION: LazyLock<[u8; 32]> =
        LazyLock::new(|| *blake3::hash(b"relievo raster file 2").as_bytes());
    let metadata = std::fs::metadata(path)?;
    // Times before 1970 and systems without them count as 1970.
    let modified = metadata
        .modified()
        .ok()
        .and_then(|t| t.duration_since(UNIX_EPOCH).ok())
        .unwrap_or_default();
    let mut hash = blake3::Hasher::new();
    hash.update(&*VERSION);
    hash.update(&metadata.len().to_le_bytes());
    hash.update(&modified.as_nanos().to_le_bytes());
    let path = std::path::absolute(path)?;
    hash.update(path.as_os_str().as_encoded_bytes());
    Ok(hash)
}

impl OpenOptions {
    /// The part of the options that decides samples, as bytes for a hash.
    pub(crate) fn sample_facts(&self) -> String {
        format!(
            "{:?} {:?} {:?} {:?}",
            self.as_bands, self.select, self.stretch, self.nodata
        )
    }
}

/// The file's own georeference as the options amend it.
pub(crate) fn placed(
    own: Option<[f64; 6]>,
    own_crs: Option<String>,
    options: &OpenOptions,
) -> Option<Georeference> {
    if let Some(given) = &options.georeference {
        return Some(given.clone());
    }
    let crs = options.crs.clone().or_else(|| own_crs.map(Arc::from))?;
    Some(Georeference {
        crs,
        plane_from_pixel: own?,
    })
}
