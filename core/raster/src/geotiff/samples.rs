//! From stored samples to working values: heights in metres, straight display-referred colours.

use half::f16;
use tiff::decoder::DecodingResult;

use crate::Block;

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
trait Stored: Copy + PartialOrd {
    fn value(self) -> f64;
    /// The stored values, from the first to the second, that mean nodata.
    fn nodata(nodata: f64) -> Option<(Self, Self)>;
}

macro_rules! stored_integers {
    ($($t:ty: $value:expr),*) => {$(
        impl Stored for $t {
            #[inline]
            fn value(self) -> f64 {
                $value(self)
            }
            #[inline]
            fn nodata(nodata: f64) -> Option<(Self, Self)> {
                let stored = nodata as $t;
                (stored.value() == nodata).then_some((stored, stored))
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
    fn nodata(nodata: f64) -> Option<(Self, Self)> {
        let (low, high) = about(nodata);
        Some((low as f32, high as f32))
    }
}

impl Stored for f64 {
    fn value(self) -> f64 {
        self
    }
    fn nodata(nodata: f64) -> Option<(Self, Self)> {
        Some(about(nodata))
    }
}

impl Stored for f16 {
    fn value(self) -> f64 {
        self.to_f64()
    }
    fn nodata(nodata: f64) -> Option<(Self, Self)> {
        let stored = Self::from_f64(nodata);
        Some((stored, stored))
    }
}

/// Programs write the lowest float with few digits: huge nodata values match by their first five.
fn about(nodata: f64) -> (f64, f64) {
    let slack = if nodata.abs() > 1e30 {
        1e-5 * nodata.abs()
    } else {
        0.0
    };
    (nodata - slack, nodata + slack)
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

    /// Writes `convert` of every sample of a window into rows that start `stride` samples apart;
    /// NaN for nodata, what is missing, and what is not finite.
    fn fill(
        &self,
        window: Window,
        nodata: Option<f64>,
        out: &mut [f32],
        stride: usize,
        convert: impl Fn(f64) -> f32,
    ) {
        for (y, row) in out.chunks_mut(stride).take(window.height).enumerate() {
            let row = &mut row[..window.width];
            let start = (window.y + y) * window.chunk_width + window.x;
            let filled = self.samples.map_or(0, |samples| {
                with_slice!(samples, slice => {
                    let line = slice.get(start * self.step + self.first..).unwrap_or_default();
                    if self.step == 1 {
                        fill_row(line.iter(), nodata, row, &convert)
                    } else {
                        fill_row(line.iter().step_by(self.step), nodata, row, &convert)
                    }
                })
            });
            row[filled..].fill(f32::NAN);
        }
    }

    /// The stored bytes of a window's rows, each with those of all bands; `None` where they are no
    /// bytes or some are missing.
    fn bytes(&self, window: Window) -> Option<impl Iterator<Item = &[u8]>> {
        let Some(DecodingResult::U8(bytes)) = self.samples else {
            return None;
        };
        let pitch = window.chunk_width * self.step;
        let end = (window.y + window.height).checked_sub(1)? * pitch
            + (window.x + window.width) * self.step;
        (end <= bytes.len()).then(|| {
            (0..window.height).map(move |y| {
                let start = (window.y + y) * pitch + window.x * self.step;
                &bytes[start..start + window.width * self.step]
            })
        })
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
            if let Some((low, high)) = nodata.and_then(T::nodata) {
                for sample in samples {
                    let is_nodata = (low..=high).contains(sample);
                    put(target + found, sample.value(), is_nodata);
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

/// Converts as many samples as there are, up to a row; returns how many.
#[inline]
fn fill_row<'a, T: Stored + 'a>(
    samples: impl ExactSizeIterator<Item = &'a T>,
    nodata: Option<f64>,
    row: &mut [f32],
    convert: impl Fn(f64) -> f32,
) -> usize {
    let count = samples.len().min(row.len());
    let shown = |sample: T| {
        let v = convert(sample.value());
        if v.is_finite() { v } else { f32::NAN }
    };
    if let Some((low, high)) = nodata.and_then(T::nodata) {
        for (v, sample) in row.iter_mut().zip(samples) {
            *v = if *sample >= low && *sample <= high {
                f32::NAN
            } else {
                shown(*sample)
            };
        }
    } else {
        for (v, sample) in row.iter_mut().zip(samples) {
            *v = shown(*sample);
        }
    }
    count
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
    /// Heights of a window into rows that start `stride` samples apart; NaN for nodata.
    pub(crate) fn read(
        &self,
        band: &BandView<'_>,
        alpha: Option<&BandView<'_>>,
        window: Window,
        out: &mut [f32],
        stride: usize,
    ) {
        if self.scale == 1.0 && self.offset == 0.0 {
            band.fill(window, self.nodata, out, stride, |v| v as f32);
        } else {
            band.fill(window, self.nodata, out, stride, |v| {
                (v * self.scale + self.offset) as f32
            });
        }
        if let Some(alpha) = alpha {
            alpha.for_each(window, None, |i, value, _| {
                if value <= 0.0 || value.is_nan() {
                    out[i / window.width * stride + i % window.width] = f32::NAN;
                }
            });
        }
    }
}

impl Colours {
    /// What [`Colours::read`] gives, written into a block from sample `start` of its planes on, where
    /// that is simple: bytes without nodata, palette or multiplied alpha. Whether it was.
    pub(crate) fn read_bytes(
        &self,
        bands: [&BandView<'_>; 3],
        alpha: Option<&BandView<'_>>,
        window: Window,
        start: usize,
        out: &mut Block,
    ) -> bool {
        let multiplied = self.alpha.is_some_and(|a| a.associated);
        if self.palette.is_some() || self.nodata.is_some() || multiplied {
            return false;
        }
        let (low, gain) = (self.range.0, 1.0 / (self.range.1 - self.range.0));
        let shown: [f32; 256] = core::array::from_fn(|v| {
            let shown = ((v as f64 - low) * gain) as f32;
            if self.clamp {
                shown.clamp(0.0, 1.0)
            } else {
                shown
            }
        });
        if !shown.iter().all(|v| v.is_finite()) {
            return false;
        }
        let stride = out.width();
        let planes: [&mut [f32]; 4] = out.planes_mut();
        let [r, g, b, a] = planes.map(|plane| plane[start..].chunks_mut(stride));
        let [Some(red), Some(green), Some(blue)] = bands.map(|band| band.bytes(window)) else {
            return false;
        };
        let opacity = match (alpha, self.alpha) {
            (Some(view), Some(how)) => match view.bytes(window) {
                Some(lines) => Some((view, how, lines)),
                None => return false,
            },
            _ => None,
        };
        let width = window.width;
        for ((plane, lines), band) in [(r, red), (g, green)]
            .into_iter()
            .chain([(b, blue)])
            .zip(bands)
        {
            for (row, line) in plane.zip(lines) {
                for (v, pixel) in row[..width].iter_mut().zip(line.chunks_exact(band.step)) {
                    *v = shown[usize::from(pixel[band.first])];
                }
            }
        }
        let Some((view, how, lines)) = opacity else {
            for row in a.take(window.height) {
                row[..width].fill(1.0);
            }
            return true;
        };
        for (row, line) in a.zip(lines) {
            for (v, pixel) in row[..width].iter_mut().zip(line.chunks_exact(view.step)) {
                *v = ((f64::from(pixel[view.first]) / how.full) as f32).clamp(0.0, 1.0);
            }
        }
        let [r, g, b, a] = out.planes_mut();
        for y in 0..window.height {
            let row = start + y * stride..start + y * stride + width;
            for i in row {
                if a[i] <= 0.0 {
                    (r[i], g[i], b[i], a[i]) = (0.0, 0.0, 0.0, 0.0);
                }
            }
        }
        true
    }

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
