//! Files of vectors: recognised by content, read whole.

use std::fs::File;
use std::io::Read;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;

use relievo_raster::Cancel;
use relievo_raster::crs::Crs;

use crate::error::{Fault, unsupported};
use crate::features::{Features, Limits};
use crate::{VectorError, read};

/// How a file is read.
#[derive(Clone, Debug, Default)]
pub struct OpenOptions {
    /// The coordinate system, instead of the file's own.
    pub crs: Option<Arc<str>>,
    /// Which of a GeoPackage's tables of features; `None`: the first.
    pub layer: Option<String>,
    /// How much is taken in.
    pub limits: Limits,
    /// Asks to stop.
    pub cancel: Cancel,
}

/// What a file says of itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Summary {
    /// Name of the format.
    pub format: &'static str,
    /// The coordinate system that its coordinates were read in.
    pub crs: Arc<str>,
    /// Tables of features of a GeoPackage, the one that was read among them.
    pub layers: Vec<String>,
    /// What users should know: how it was read where the file leaves that open.
    pub remarks: Vec<String>,
}

/// The formats that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    GeoJson,
    Shapefile,
    GeoPackage,
    FlatGeobuf,
}

impl Format {
    fn name(self) -> &'static str {
        match self {
            Self::GeoJson => "GeoJSON",
            Self::Shapefile => "Shapefile",
            Self::GeoPackage => "GeoPackage",
            Self::FlatGeobuf => "FlatGeobuf",
        }
    }

    /// The format of a file that begins with some bytes.
    fn of(head: &[u8]) -> Option<Self> {
        let text = head.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(head);
        if head.starts_with(b"fgb\x03") {
            Some(Self::FlatGeobuf)
        } else if head.starts_with(&9994_u32.to_be_bytes()) {
            Some(Self::Shapefile)
        } else if head.starts_with(b"SQLite format 3\0")
            && (head.get(68..72) == Some(b"GPKG")
                || head.get(68..71) == Some(b"GP1")
                || head.get(68..72) == Some(&[0; 4]))
        {
            Some(Self::GeoPackage)
        } else if text.iter().find(|b| !b.is_ascii_whitespace()) == Some(&b'{') {
            Some(Self::GeoJson)
        } else {
            None
        }
    }
}

/// Whether a file looks like vectors, by its first bytes; `false` where it cannot be read. A SQLite
/// database counts if it says that it is a GeoPackage with features.
pub fn is_vector(path: &Path) -> bool {
    match format_of(path) {
        #[cfg(feature = "geopackage")]
        Ok(Some(Format::GeoPackage)) => read::geopackage::has_features(path),
        Ok(Some(Format::GeoJson)) => {
            // A project is JSON too.
            let named = path.extension().and_then(|e| e.to_str());
            named.is_none_or(|e| !e.eq_ignore_ascii_case("relievo"))
        }
        // A format that this program was built without is told when it is opened.
        Ok(Some(_)) => true,
        Ok(None) | Err(_) => false,
    }
}

fn format_of(path: &Path) -> std::io::Result<Option<Format>> {
    let mut head = Vec::new();
    File::open(path)?.take(512).read_to_end(&mut head)?;
    Ok(Format::of(&head))
}

/// Reads a file of vectors: GeoJSON, Shapefile, GeoPackage or FlatGeobuf.
///
/// # Errors
/// [`VectorError`], one line that names the file: it cannot be read, is damaged or cut short, holds
/// more than the limits allow, or its coordinate system is not known.
pub fn open(path: &Path, options: &OpenOptions) -> Result<(Features, Summary), VectorError> {
    let io = |e: std::io::Error| Fault::from(e).of("vector", path);
    let length = std::fs::metadata(path).map_err(io)?.len();
    let Some(format) = format_of(path).map_err(io)? else {
        let expected =
            "expected GeoJSON, a Shapefile, a GeoPackage or FlatGeobuf, found something else";
        return unsupported(expected).map_err(|e: Fault| e.of("vector", path));
    };
    let name = format.name();
    let read = || -> Result<(Features, Summary), Fault> {
        if length > options.limits.file_bytes {
            return unsupported(format!(
                "expected at most {} bytes, found {length}",
                options.limits.file_bytes
            ));
        }
        match format {
            Format::GeoJson => read::geojson::read(path, options),
            #[cfg(feature = "shapefile")]
            Format::Shapefile => read::shapefile::read(path, options),
            #[cfg(feature = "geopackage")]
            Format::GeoPackage => read::geopackage::read(path, options),
            #[cfg(feature = "flatgeobuf")]
            Format::FlatGeobuf => read::flatgeobuf::read(path, options),
            #[cfg(not(all(
                feature = "shapefile",
                feature = "geopackage",
                feature = "flatgeobuf"
            )))]
            left_out => unsupported(format!(
                "found {}, which this program was built without",
                left_out.name()
            )),
        }
    };
    // Some of the libraries that decode these formats index before they look: what breaks them is
    // damage in the file, and the file's alone.
    let read = catch_unwind(AssertUnwindSafe(read)).unwrap_or_else(|_told| {
        Err(Fault::Damaged(
            "expected offsets and lengths within the file, found others".into(),
        ))
    });
    read.map_err(|fault| fault.of(name, path))
}

/// The system in which coordinates are read: what the user says, else what the file says, else
/// longitude and latitude. Systems of other bodies are fine: their longitudes pass as they are.
pub(crate) fn system(
    options: &OpenOptions,
    own: Option<String>,
    remarks: &mut Vec<String>,
) -> Result<(Option<Crs>, Arc<str>), Fault> {
    let text: Arc<str> = match (&options.crs, own) {
        (Some(given), _) => Arc::clone(given),
        (None, Some(own)) => own.into(),
        (None, None) => {
            remarks.push(
                "names no coordinate system known here: read as longitude and latitude in degrees"
                    .into(),
            );
            return Ok((None, "EPSG:4326".into()));
        }
    };
    match Crs::parse(&text) {
        Ok(crs) => Ok((Some(crs), text)),
        Err(error) => unsupported(error.to_string()),
    }
}
