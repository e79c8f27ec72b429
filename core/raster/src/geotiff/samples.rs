//! From stored samples to working values: heights in metres, straight display-referred colours.

use half::f16;
use tiff::decoder::DecodingResult;

/// What the stored samples of a file mean.
#[derive(Clone, Debug)]
pub(crate) enum Meaning {
    /// One band of heights.
    Height(Heights),
    /// One or three bands of colour.
    Colour(Colours),
}

/// How stored samples become heights.
#[derive(Clone, Debug)]
pub(crate) struct Heights {
    /// Band of the file.
    pub(crate) band: u16,
    /// Metres per stored unit.
    pub(crate) scale: f64,
    /// Metres at stored 0.
    pub(crate) offset: f64,
    /// Band that is 0 where there is no height.
    pub(crate) alpha: Option<u16>,
    /// Stored value that means nodata.
    pub(crate) nodata: Option<f64>,
}

/// How stored samples become colours.
#[derive(Clone, Debug)]
pub(crate) struct Colours {
    /// Bands of red, green and blue; thrice the same for grey.
    pub(crate) bands: [u16; 3],
    /// Colours by stored value.
    pub(crate) palette: Option<Vec<[f32; 4]>>,
    /// Stored value shown as 0 and as 1.
    pub(crate) range: (f64, f64),
    /// Whether values outside the range are cut off.
    pub(crate) clamp: bool,
    /// Band of alpha, its full value, and whether colours are multiplied with it.
    pub(crate) alpha: Option<Alpha>,
    /// Stored value that means nodata where all colour bands have it.
    pub(crate) nodata: Option<f64>,
}

/// Where alpha is and how it counts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Alpha {
    /// Band of the file.
    pub(crate) band: u16,
    /// Stored value of full opacity.
    pub(crate) full: f64,
    /// Whether stored colours are multiplied with it.
    pub(crate) associated: bool,
}

/// A chunk of one band (or of all, interleaved) and how to walk it; `None` where the file leaves
/// the chunk out.
pub(crate) struct BandView<'a> {
    /// Samples of the chunk.
    pub(crate) samples: Option<&'a DecodingResult>,
    /// Samples from pixel to pixel.
    pub(crate) step: usize,
    /// First sample of the band within a pixel.
    pub(crate) first: usize,
}

/// A rectangle within a chunk: rows start `chunk_width` pixels apart.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Window {
    pub(crate) chunk_width: usize,
    pub(crate) x: usize,
    pub(crate) y: usize,
    pub(crate) width: usize,
    pub(crate) height: usize,
}

/// A sample type that a file may hold.
trait Stored: Copy {
    fn value(self) -> f64;
    fn is(self, nodata: f64) -> bool;
}

macro_rules! stored_integers {
    ($($t:ty: $value:expr),*) => {$(
        impl Stored for $t {
            #[inline]
            fn value(self) -> f64 {
                $value(self)
            }
            #[inline]
            fn is(self, nodata: f64) -> bool {
                self.value() == nodata
            }
        }
    )*};
}
stored_integers!(
    u8: f64::from,
    i8: f64::from,
    u16: f64::from,
    i16: f64::from,
    u32: f64::from,
    i32: f64::from,
    u64: |v| v as f64,
    i64: |v| v as f64
);

impl Stored for f32 {
    fn value(self) -> f64 {
        self.into()
    }
    fn is(self, nodata: f64) -> bool {
        self == nodata as f32 || is_about(self.into(), nodata)
    }
}

impl Stored for f64 {
    fn value(self) -> f64 {
        self
    }
    fn is(self, nodata: f64) -> bool {
        self == nodata || is_about(self, nodata)
    }
}

impl Stored for f16 {
    fn value(self) -> f64 {
        self.to_f64()
    }
    fn is(self, nodata: f64) -> bool {
        self == Self::from_f64(nodata)
    }
}

/// Programs write the lowest float with few digits: huge nodata values match by their first five.
fn is_about(value: f64, nodata: f64) -> bool {
    nodata.abs() > 1e30 && (value - nodata).abs() <= 1e-5 * nodata.abs()
}

/// Calls `$call` with the typed slice of a decoding result.
macro_rules! with_slice {
    ($samples:expr, $slice:ident => $call:expr) => {
        match $samples {
            DecodingResult::U8($slice) => $call,
            DecodingResult::I8($slice) => $call,
            DecodingResult::U16($slice) => $call,
            DecodingResult::I16($slice) => $call,
            DecodingResult::U32($slice) => $call,
            DecodingResult::I32($slice) => $call,
            DecodingResult::U64($slice) => $call,
            DecodingResult::I64($slice) => $call,
            DecodingResult::F16($slice) => $call,
            DecodingResult::F32($slice) => $call,
            DecodingResult::F64($slice) => $call,
        }
    };
}

impl BandView<'_> {
    /// Calls `put(i, value, nodata)` for every pixel of the window, `i` counting row by row.
    /// Missing chunks and samples are NaN and nodata.
    pub(crate) fn for_each(
        &self,
        window: Window,
        nodata: Option<f64>,
        mut put: impl FnMut(usize, f64, bool),
    ) {
        let count = window.width * window.height;
        let Some(samples) = self.samples else {
            (0..count).for_each(|i| put(i, f64::NAN, true));
            return;
        };
        with_slice!(samples, slice => self.walk(slice, window, nodata, put));
    }

    #[inline]
    fn walk<T: Stored>(
        &self,
        slice: &[T],
        window: Window,
        nodata: Option<f64>,
        mut put: impl FnMut(usize, f64, bool),
    ) {
        for row in 0..window.height {
            let start = ((window.y + row) * window.chunk_width + window.x) * self.step + self.first;
            let target = row * window.width;
            let samples = slice
                .get(start..)
                .unwrap_or_default()
                .iter()
                .step_by(self.step)
                .take(window.width);
            let mut found = 0;
            if let Some(nodata) = nodata {
                for sample in samples {
                    put(target + found, sample.value(), sample.is(nodata));
                    found += 1;
                }
            } else {
                for sample in samples {
                    put(target + found, sample.value(), false);
                    found += 1;
                }
            }
            (found..window.width).for_each(|i| put(target + i, f64::NAN, true));
        }
    }
}

impl Meaning {
    /// Whether stored values between the given ones may become holes.
    pub(crate) fn may_have_holes(&self, (low, high): (f64, f64)) -> bool {
        match self {
            Self::Height(how) => {
                let beyond = |v: f64| !((v * how.scale + how.offset) as f32).is_finite();
                how.nodata.is_some() || how.alpha.is_some() || beyond(low) || beyond(high)
            }
            Self::Colour(how) => how.nodata.is_some() || how.alpha.is_some(),
        }
    }
}

impl Heights {
    /// Heights of a window; NaN for nodata.
    pub(crate) fn read(
        &self,
        band: &BandView<'_>,
        alpha: Option<&BandView<'_>>,
        window: Window,
        out: &mut Vec<f32>,
    ) {
        out.clear();
        out.resize(window.width * window.height, f32::NAN);
        let plain = self.scale == 1.0 && self.offset == 0.0;
        band.for_each(window, self.nodata, |i, value, nodata| {
            let metres = if plain {
                value as f32
            } else {
                (value * self.scale + self.offset) as f32
            };
            out[i] = if nodata || !metres.is_finite() {
                f32::NAN
            } else {
                metres
            };
        });
        if let Some(alpha) = alpha {
            alpha.for_each(window, None, |i, value, _| {
                if value <= 0.0 || value.is_nan() {
                    out[i] = f32::NAN;
                }
            });
        }
    }
}

impl Colours {
    /// Colours of a window, pixel by pixel.
    pub(crate) fn read(
        &self,
        bands: [&BandView<'_>; 3],
        alpha: Option<&BandView<'_>>,
        window: Window,
        out: &mut Vec<[f32; 4]>,
    ) {
        out.clear();
        // Alpha counts the bands that have data until all three are read.
        out.resize(window.width * window.height, [0.0; 4]);
        let (low, gain) = (self.range.0, 1.0 / (self.range.1 - self.range.0));
        if let Some(palette) = &self.palette {
            bands[0].for_each(window, self.nodata, |i, value, nodata| {
                if !nodata && let Some(colour) = palette.get(value as usize) {
                    out[i] = *colour;
                }
            });
        } else {
            let grey = self.bands[0] == self.bands[1] && self.bands[0] == self.bands[2];
            for (c, band) in bands.iter().enumerate().take(if grey { 1 } else { 3 }) {
                band.for_each(window, self.nodata, |i, value, nodata| {
                    let shown = ((value - low) * gain) as f32;
                    let pixel = &mut out[i];
                    if shown.is_nan() {
                        // One band without a value makes the pixel nodata, whatever the others say.
                        pixel[3] = f32::NEG_INFINITY;
                        return;
                    }
                    let shown = if self.clamp {
                        shown.clamp(0.0, 1.0)
                    } else {
                        shown
                    };
                    if grey {
                        pixel[..3].fill(shown);
                    } else {
                        pixel[c] = shown;
                    }
                    pixel[3] += f32::from(u8::from(!nodata));
                });
            }
            for pixel in out.iter_mut() {
                pixel[3] = if pixel[3] > 0.0 { 1.0 } else { 0.0 };
            }
        }
        if let (Some(view), Some(how)) = (alpha, self.alpha) {
            view.for_each(window, None, |i, value, _| {
                let opacity = ((value / how.full) as f32).clamp(0.0, 1.0);
                let opacity = if opacity.is_nan() { 0.0 } else { opacity };
                let pixel = &mut out[i];
                if how.associated && opacity > 0.0 {
                    for channel in &mut pixel[..3] {
                        *channel /= opacity;
                        if self.clamp {
                            *channel = channel.min(1.0);
                        }
                    }
                }
                pixel[3] *= opacity;
            });
        }
        for pixel in out.iter_mut() {
            if pixel[3] <= 0.0 || !pixel.iter().all(|v| v.is_finite()) {
                *pixel = [0.0; 4];
            }
        }
    }
}
