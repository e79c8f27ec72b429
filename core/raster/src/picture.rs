//! JPEG, PNG and WebP pictures: decoded as a whole once, read from a pyramid afterwards.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::sync::{Arc, OnceLock};

use image::{ColorType, DynamicImage, ImageDecoder, ImageReader, Limits};

use crate::file::{CHANGED, Cancel, OverviewInfo, PixelRect, RasterFile, RasterInfo, ReadError};
use crate::open::{OpenError, OpenOptions, content_hash, placed};
use crate::parts::assert_inside;
use crate::{Bands, Block, prj, pyramid, worldfile};

mod limits;

use crate::text::one_line;
use limits::{MAX_SIDE, MOST_BYTES, TooLarge};

/// Kinds of pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    /// JPEG.
    Jpeg,
    /// Portable Network Graphics.
    Png,
    /// WebP, lossy or lossless; of an animation the first picture.
    WebP,
}

impl Format {
    fn name(self) -> &'static str {
        match self {
            Self::Jpeg => "JPEG",
            Self::Png => "PNG",
            Self::WebP => "WebP",
        }
    }

    fn codec(self) -> image::ImageFormat {
        match self {
            Self::Jpeg => image::ImageFormat::Jpeg,
            Self::Png => image::ImageFormat::Png,
            Self::WebP => image::ImageFormat::WebP,
        }
    }
}

/// A picture, decoded when its samples are first asked for.
struct Picture {
    info: RasterInfo,
    format: Format,
    pixels: OnceLock<Result<DynamicImage, ReadError>>,
    /// What the file was when it was opened.
    content: [u8; 32],
    fingerprint: [u8; 32],
}

/// Reads a picture's header and finds or makes its pyramid.
pub(crate) fn open(
    path: &Path,
    format: Format,
    options: &OpenOptions,
) -> Result<Arc<dyn RasterFile>, OpenError> {
    let io = |e: std::io::Error| OpenError::Io {
        reason: e.to_string(),
        path: path.to_owned(),
    };
    let mut hash = content_hash(path).map_err(io)?;
    let content = *hash.finalize().as_bytes();
    hash.update(options.sample_facts().as_bytes());
    let fingerprint = *hash.finalize().as_bytes();
    let decoder = decoder(path, format).map_err(|e| decode_error(e, format, path))?;
    if let Err(reason) = limits::check(path, format, decoder.total_bytes()).map_err(io)? {
        let (format, path, (width, height)) =
            (format.name(), path.to_owned(), decoder.dimensions());
        return Err(match reason {
            TooLarge::Memory(needed) => OpenError::Unsupported {
                format,
                reason: format!(
                    "expected pixels that decode within {} MiB, found {width} x {height} that take {} MiB",
                    MOST_BYTES >> 20,
                    needed >> 20
                ),
                path,
            },
            TooLarge::Claim(length) => OpenError::Damaged {
                format,
                reason: format!(
                    "expected the bytes of {width} x {height} pixels, found a file of {length} bytes"
                ),
                path,
            },
        });
    }
    let info = describe(
        decoder.dimensions(),
        decoder.color_type(),
        path,
        format,
        options,
    )?;
    let picture = Picture {
        info,
        format,
        pixels: OnceLock::new(),
        content,
        fingerprint,
    };
    if !options.make_pyramid {
        return Ok(Arc::new(picture));
    }
    pyramid::complete(Arc::new(picture), true, fingerprint, options)
}

/// A decoder that has read the header and keeps to the limits.
fn decoder(path: &Path, format: Format) -> image::ImageResult<impl ImageDecoder> {
    let mut reader = ImageReader::with_format(BufReader::new(File::open(path)?), format.codec());
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(MOST_BYTES);
    reader.limits(limits.clone());
    let decoder = reader.into_decoder()?;
    limits.check_support(&image::LimitSupport::default())?;
    let (width, height) = decoder.dimensions();
    limits.check_dimensions(width, height)?;
    limits.reserve(decoder.total_bytes())?;
    Ok(decoder)
}

fn decode_error(error: image::ImageError, format: Format, path: &Path) -> OpenError {
    let path = path.to_owned();
    let format = format.name();
    match error {
        image::ImageError::IoError(e)
            if e.kind() != std::io::ErrorKind::UnexpectedEof && e.raw_os_error().is_some() =>
        {
            OpenError::Io {
                reason: e.to_string(),
                path,
            }
        }
        image::ImageError::Limits(_) => OpenError::Unsupported {
            format,
            reason: format!(
                "expected at most {} MiB of pixels with sides below {MAX_SIDE}, found more",
                MOST_BYTES >> 20
            ),
            path,
        },
        image::ImageError::Unsupported(e) => OpenError::Unsupported {
            format,
            reason: one_line(e),
            path,
        },
        image::ImageError::IoError(_) => OpenError::Damaged {
            format,
            reason: "the file ends before the picture does".into(),
            path,
        },
        other @ (image::ImageError::Decoding(_)
        | image::ImageError::Encoding(_)
        | image::ImageError::Parameter(_)) => OpenError::Damaged {
            format,
            reason: one_line(other),
            path,
        },
    }
}

fn describe(
    (width, height): (u32, u32),
    colour: ColorType,
    path: &Path,
    format: Format,
    options: &OpenOptions,
) -> Result<RasterInfo, OpenError> {
    if width == 0 || height == 0 {
        let reason = format!("expected a picture with pixels, found {width} x {height}");
        return Err(OpenError::Damaged {
            format: format.name(),
            reason,
            path: path.to_owned(),
        });
    }
    let band_count = u16::from(colour.channel_count());
    let refused = |reason: String| OpenError::Options {
        reason,
        path: path.to_owned(),
    };
    let bands = match options.as_bands {
        None | Some(Bands::Colour) => Bands::Colour,
        Some(Bands::Height) if band_count <= 2 => Bands::Height,
        Some(Bands::Height) => {
            return Err(refused(format!(
                "expected 1 band for heights, found {band_count}"
            )));
        }
        Some(other) => {
            return Err(refused(format!(
                "pictures hold heights or colours, {other:?} was asked for"
            )));
        }
    };
    if options.select.is_some() {
        return Err(refused("bands of pictures cannot be selected".into()));
    }
    let beside = worldfile::beside(path).map_err(|(companion, reason)| OpenError::Companion {
        reason,
        companion,
        path: path.to_owned(),
    });
    // A given georeference makes what lies beside the file meaningless, damaged or not.
    let affine = if options.georeference.is_some() {
        None
    } else {
        beside?
    };
    let named = affine.and_then(|_| prj::beside(path));
    let assumed = affine.and_then(|a| worldfile::assumed_crs(&a, width, height));
    let crs = named.or(assumed.map(str::to_owned));
    let bits = colour.bits_per_pixel() / band_count;
    Ok(RasterInfo {
        path: path.to_owned(),
        format: format.name(),
        overviews: vec![OverviewInfo { width, height }],
        bands,
        band_count,
        sample_type: format!("uint{bits}"),
        compression: match format {
            Format::Jpeg => "JPEG".into(),
            Format::Png => "Deflate".into(),
            Format::WebP => "WebP".into(),
        },
        deep_colour: bands == Bands::Colour && bits > 8,
        nodata: options.nodata,
        may_have_holes: options.nodata.is_some() || colour.has_alpha(),
        georeference: placed(affine, crs, options),
    })
}

impl Picture {
    /// The decoded picture.
    fn pixels(&self) -> Result<&DynamicImage, ReadError> {
        let path = &self.info.path;
        let refused = |error| match decode_error(error, self.format, path) {
            OpenError::Io { reason, path } => ReadError::Io { reason, path },
            OpenError::Damaged {
                format,
                reason,
                path,
            } => ReadError::Damaged {
                format,
                reason,
                path,
            },
            other @ (OpenError::UnknownFormat { .. }
            | OpenError::Unsupported { .. }
            | OpenError::Companion { .. }
            | OpenError::Options { .. }
            | OpenError::Pyramid { .. }
            | OpenError::Cancelled { .. }) => ReadError::Damaged {
                format: self.format.name(),
                reason: other.to_string(),
                path: path.clone(),
            },
        };
        let decode = || {
            let decoder = decoder(path, self.format).map_err(refused)?;
            // The library takes its room without asking whether there is any.
            let bytes = decoder.total_bytes();
            if Vec::<u8>::new().try_reserve_exact(bytes as usize).is_err() {
                return Err(ReadError::Io {
                    reason: format!("there is no memory for its {} MiB of pixels", bytes >> 20),
                    path: path.clone(),
                });
            }
            DynamicImage::from_decoder(decoder).map_err(refused)
        };
        // What was read while another program wrote belongs to neither of the contents.
        let unchanged = |read: Result<DynamicImage, ReadError>| match content_hash(path) {
            Ok(hash) if *hash.finalize().as_bytes() == self.content => read,
            Ok(_other) => Err(ReadError::Io {
                reason: CHANGED.to_owned(),
                path: path.clone(),
            }),
            Err(error) => Err(ReadError::Io {
                reason: error.to_string(),
                path: path.clone(),
            }),
        };
        let pixels = self
            .pixels
            .get_or_init(|| unchanged(decode()))
            .as_ref()
            .map_err(Clone::clone)?;
        let size = self.info.overviews[0];
        if (pixels.width(), pixels.height()) == (size.width, size.height) {
            return Ok(pixels);
        }
        // The file changed between the reading of its header and the decoding of its pixels.
        let reason = format!(
            "expected {} x {} pixels, found {} x {}",
            size.width,
            size.height,
            pixels.width(),
            pixels.height()
        );
        Err(ReadError::Damaged {
            format: self.format.name(),
            reason,
            path: path.clone(),
        })
    }
}

impl RasterFile for Picture {
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
        let size = self.info.overviews[overview];
        assert_inside(rect, size);
        if cancel.is_cancelled() {
            return Err(ReadError::Cancelled);
        }
        out.reshape(self.info.bands, rect.width as usize, rect.height as usize);
        let pixels = self.pixels()?;
        let bits = pixels.color().bits_per_pixel() / u16::from(pixels.color().channel_count());
        let full = if bits > 8 { 65535.0 } else { 255.0 };
        let nodata = self.info.nodata.map(|v| v as f32);
        let place = Place {
            width: size.width as usize,
            rect,
            nodata,
            shown_nodata: nodata.map(|v| v / full),
        };
        #[expect(
            clippy::wildcard_enum_match_arm,
            reason = "the decoder's enum may grow, and what else there is converts alike"
        )]
        match pixels {
            DynamicImage::ImageLuma8(p) => place.copy(p, |[v]: [u8; 1]| grey(v, 255), out),
            DynamicImage::ImageLumaA8(p) => place.copy(
                p,
                |[v, a]: [u8; 2]| Pixel {
                    alpha: f32::from(a) / 255.0,
                    ..grey(v, 255)
                },
                out,
            ),
            DynamicImage::ImageRgb8(p) => place.copy(
                p,
                |c: [u8; 3]| Pixel::colour(c.map(|v| f32::from(v) / 255.0), 1.0),
                out,
            ),
            DynamicImage::ImageRgba8(p) => {
                place.copy(
                    p,
                    |[r, g, b, a]: [u8; 4]| {
                        Pixel::colour(
                            [r, g, b].map(|v| f32::from(v) / 255.0),
                            f32::from(a) / 255.0,
                        )
                    },
                    out,
                );
            }
            DynamicImage::ImageLuma16(p) => place.copy(p, |[v]: [u16; 1]| grey(v, 65535), out),
            DynamicImage::ImageLumaA16(p) => {
                place.copy(
                    p,
                    |[v, a]: [u16; 2]| Pixel {
                        alpha: f32::from(a) / 65535.0,
                        ..grey(v, 65535)
                    },
                    out,
                );
            }
            other => {
                // Every other kind that these formats hold has three or four channels of 16 bits.
                let wide = other
                    .crop_imm(rect.x, rect.y, rect.width, rect.height)
                    .into_rgba16();
                let place = Place {
                    width: rect.width as usize,
                    rect: PixelRect { x: 0, y: 0, ..rect },
                    ..place
                };
                place.copy(
                    &wide,
                    |[r, g, b, a]: [u16; 4]| {
                        Pixel::colour(
                            [r, g, b].map(|v| f32::from(v) / 65535.0),
                            f32::from(a) / 65535.0,
                        )
                    },
                    out,
                );
            }
        }
        Ok(())
    }
}

/// A pixel as colour and, for one band, as the number that is stored.
struct Pixel {
    stored: f32,
    colour: [f32; 3],
    alpha: f32,
}

impl Pixel {
    fn colour(colour: [f32; 3], alpha: f32) -> Self {
        Self {
            stored: f32::NAN,
            colour,
            alpha,
        }
    }
}

fn grey(value: impl Into<u16>, full: u16) -> Pixel {
    let stored = f32::from(value.into());
    Pixel {
        stored,
        colour: [stored / f32::from(full); 3],
        alpha: 1.0,
    }
}

/// A rectangle of an image of so many columns.
#[derive(Clone, Copy)]
struct Place {
    width: usize,
    rect: PixelRect,
    /// Stored value that means nodata.
    nodata: Option<f32>,
    /// The same as a colour channel shows it.
    shown_nodata: Option<f32>,
}

impl Place {
    fn copy<T: Copy, const N: usize>(
        &self,
        samples: &[T],
        pixel: impl Fn([T; N]) -> Pixel,
        out: &mut Block,
    ) {
        let (x, width) = (self.rect.x as usize, self.rect.width as usize);
        let heights = out.bands() == Bands::Height;
        let mut i = 0;
        for y in self.rect.y as usize..(self.rect.y + self.rect.height) as usize {
            let start = (y * self.width + x) * N;
            for chunk in samples[start..start + width * N].as_chunks::<N>().0 {
                let pixel = pixel(*chunk);
                if heights {
                    out.plane_mut(0)[i] = if pixel.alpha > 0.0 && self.nodata != Some(pixel.stored)
                    {
                        pixel.stored
                    } else {
                        f32::NAN
                    };
                } else if pixel.alpha > 0.0
                    && self.shown_nodata.is_none_or(|v| pixel.colour != [v; 3])
                {
                    for (plane, value) in pixel.colour.into_iter().enumerate() {
                        out.plane_mut(plane)[i] = value;
                    }
                    out.plane_mut(3)[i] = pixel.alpha;
                } else {
                    (0..4).for_each(|plane| out.plane_mut(plane)[i] = 0.0);
                }
                i += 1;
            }
        }
    }
}
