//! ESRI ASCII grids (`.asc`): heights as decimal text.
//!
//! A file may be larger than memory: one pass notes where every so many numbers begin, and runs of
//! numbers are decoded when a region asks for them. A large file is copied into the pyramid, since
//! text is slow to read again and again.
//!
//! Source: ESRI, "ASCII raster format"; also `dx` and `dy` of other programs, and GRASS's `*` for
//! nodata.

mod header;
mod index;

use std::path::Path;
use std::sync::{Arc, OnceLock};

use tiff::decoder::DecodingResult;

use crate::chunk_cache::{ChunkCache, ChunkKey};
use crate::fault::{Fault, damaged};
use crate::file::{Cancel, OverviewInfo, PixelRect, RasterFile, RasterInfo, ReadError};
use crate::geotiff::{Bytes, Chunk};
use crate::open::{OpenError, OpenOptions, content_hash, placed};
use crate::parts::assert_inside;
use crate::{Bands, Block, prj, pyramid, worldfile};
use header::Header;
use index::{Index, RUN, Tokens};

pub(crate) use header::is_one;

/// The format's name in messages.
const FORMAT: &str = "ASCII grid";
/// Numbers from which on level 0 is copied into the pyramid.
const COPIED_FROM: u64 = 1 << 20;
/// Bytes looked at to tell whole numbers from others.
const LOOK_BYTES: u64 = 64 << 10;

/// An open grid.
struct AsciiGrid {
    info: RasterInfo,
    bytes: Bytes,
    header: Header,
    /// Value that means nodata, as the nearest f32.
    nodata: Option<f32>,
    index: OnceLock<Result<Index, ReadError>>,
    fingerprint: [u8; 32],
    cache: Arc<ChunkCache>,
    /// Number of the file in the cache.
    number: u64,
}

/// Opens a grid and finds or makes its pyramid.
pub(crate) fn open(path: &Path, options: &OpenOptions) -> Result<Arc<dyn RasterFile>, OpenError> {
    let io = |e: std::io::Error| OpenError::Io {
        reason: e.to_string(),
        path: path.to_owned(),
    };
    let mut hash = content_hash(path).map_err(io)?;
    hash.update(options.sample_facts().as_bytes());
    let fingerprint = *hash.finalize().as_bytes();
    let bytes = Bytes::open(path).map_err(io)?;
    let header = Header::read(&bytes).map_err(|f| f.on_open(FORMAT, path))?;
    let refused = |reason: &str| OpenError::Options {
        reason: reason.into(),
        path: path.to_owned(),
    };
    if options.as_bands.is_some_and(|b| b != Bands::Height) {
        return Err(refused("expected use as heights, found use as colours"));
    }
    if options.select.as_ref().is_some_and(|s| s != &[0]) {
        return Err(refused("expected band 1, found another: the file has one"));
    }
    let affine = header.plane_from_pixel();
    let crs = prj::beside(path).or_else(|| {
        worldfile::assumed_crs(&affine, header.width, header.height).map(str::to_owned)
    });
    let nodata = options.nodata.or(header.nodata);
    let info = RasterInfo {
        path: path.to_owned(),
        format: FORMAT,
        overviews: vec![OverviewInfo {
            width: header.width,
            height: header.height,
        }],
        bands: Bands::Height,
        band_count: 1,
        sample_type: sample_type(&bytes, &header).into(),
        compression: "none (text)".into(),
        deep_colour: false,
        nodata,
        may_have_holes: true,
        georeference: placed(Some(affine), crs, options),
    };
    let cache = Arc::clone(&options.chunk_cache);
    let number = cache.new_file();
    let samples = header.samples();
    let grid = AsciiGrid {
        info,
        bytes,
        header,
        nodata: nodata.map(|v| v as f32),
        index: OnceLock::new(),
        fingerprint,
        cache,
        number,
    };
    if !options.make_pyramid {
        return Ok(Arc::new(grid));
    }
    // All of the text is looked at once, so that a file that ends too soon is refused now.
    grid.index(&options.cancel)
        .map_err(|e| OpenError::from_read(e, path))?;
    let copy = samples >= COPIED_FROM;
    pyramid::complete(Arc::new(grid), copy, fingerprint, options)
}

/// Whole numbers or not, as far as the beginning shows.
fn sample_type(bytes: &Bytes, header: &Header) -> &'static str {
    let length = (bytes.length() - header.data_at).min(LOOK_BYTES);
    let start = bytes.vec_at(header.data_at, length).unwrap_or_default();
    let whole = !start.iter().any(|b| matches!(b, b'.' | b',' | b'e' | b'E'));
    if whole { "int32 text" } else { "float32 text" }
}

impl AsciiGrid {
    fn index(&self, cancel: &Cancel) -> Result<&Index, ReadError> {
        if let Some(known) = self.index.get() {
            return known.as_ref().map_err(Clone::clone);
        }
        let made = Index::make(&self.bytes, &self.header, cancel);
        let made = match made {
            Ok(Some(index)) => Ok(index),
            // Not kept: the next reader may have more patience.
            Ok(None) => return Err(ReadError::Cancelled),
            Err(fault) => Err(fault.on_read(FORMAT, &self.info.path)),
        };
        self.index
            .get_or_init(|| made)
            .as_ref()
            .map_err(Clone::clone)
    }

    /// A run of decoded numbers from the cache.
    fn run(&self, index: &Index, run: u64) -> Result<Arc<Chunk>, Fault> {
        let key = ChunkKey {
            file: self.number,
            image: 0,
            plane: 0,
            column: run as u32,
            row: (run >> 32) as u32,
        };
        let chunk = self.cache.get(key, || -> Result<_, Fault> {
            let count = (self.header.samples() - run * RUN).min(RUN) as usize;
            let mut tokens = Tokens::new(&self.bytes, index.start_of(run));
            let mut values = Vec::with_capacity(count);
            for _ in 0..count {
                values.push(self.value(tokens.next()?)?);
            }
            Ok(Some(Chunk {
                samples: DecodingResult::F32(values),
            }))
        })?;
        chunk.ok_or_else(|| Fault::Damaged("expected numbers, found none".into()))
    }

    fn value(&self, token: &[u8]) -> Result<f32, Fault> {
        if token == b"*" {
            return Ok(f32::NAN);
        }
        match header::number::<f32>(token) {
            Some(v) if v.is_finite() && Some(v) != self.nodata => Ok(v),
            Some(_) => Ok(f32::NAN),
            None => damaged(format!(
                "expected a number, found {:?}",
                String::from_utf8_lossy(token)
            )),
        }
    }
}

impl RasterFile for AsciiGrid {
    fn info(&self) -> &RasterInfo {
        &self.info
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
        assert_inside(rect, self.info.overviews[overview]);
        let width = rect.width as usize;
        out.reshape(Bands::Height, width, rect.height as usize);
        let index = self.index(cancel)?;
        for (y, row) in out.plane_mut(0).chunks_exact_mut(width.max(1)).enumerate() {
            if cancel.is_cancelled() {
                return Err(ReadError::Cancelled);
            }
            let first =
                (u64::from(rect.y) + y as u64) * u64::from(self.header.width) + u64::from(rect.x);
            let mut done = 0;
            while done < width {
                let at = first + done as u64;
                let chunk = self
                    .run(index, at / RUN)
                    .map_err(|f| f.on_read(FORMAT, &self.info.path))?;
                let from = (at % RUN) as usize;
                let count = (width - done).min(RUN as usize - from);
                if let DecodingResult::F32(values) = &chunk.samples {
                    row[done..done + count].copy_from_slice(&values[from..from + count]);
                }
                done += count;
            }
        }
        Ok(())
    }
}

impl Drop for AsciiGrid {
    fn drop(&mut self) {
        self.cache.forget_file(self.number);
    }
}

#[cfg(test)]
mod tests;
