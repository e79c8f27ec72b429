//! Kernels: the value of a window of samples between its samples.
//!
//! Heights: NaN is a hole. Weights are renormalised over what is valid, and a sample is NaN when
//! less than half of the kernel's weight lies on valid samples (GDAL's bilinear keeps a sample when
//! the pixel that contains it is valid, which differs by a fraction of a pixel along holes).
//! Colours: premultiplied linear light, where a hole is simply transparent.
//!
//! Every value is `v₀ + Σ w (v − v₀) / Σ w` about one of the samples, so a constant window gives
//! that constant to the bit and large heights lose nothing.

/// How samples are interpolated where the result is at least as fine as the source. Where it is
/// coarser, all but [`Kernel::Nearest`] average with a tent as wide as the footprint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Kernel {
    /// The sample whose area contains the place, for classes and masks.
    Nearest,
    /// Linear in both directions.
    #[default]
    Bilinear,
    /// Cubic convolution with a = −½; beside a hole of heights it falls back to bilinear.
    ///
    /// Source: R. Keys, Cubic convolution interpolation for digital image processing, 1981.
    Bicubic,
}

/// A window of one or four planes, inside larger ones.
pub(crate) struct Window<'a> {
    pub(crate) planes: &'a [&'a [f32]],
    /// Index of the window's first sample in each plane.
    pub(crate) offset: usize,
    /// Samples from one row of the planes to the next.
    pub(crate) stride: usize,
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Whether some height in the window is NaN.
    pub(crate) has_holes: bool,
}

/// Footprint of a kernel: radius of its tent along columns and rows in samples, 1 ≤ r < 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Footprint {
    pub(crate) kernel: Kernel,
    pub(crate) radius_x: f32,
    pub(crate) radius_y: f32,
}

impl Window<'_> {
    /// Whether some sample of the first plane is NaN.
    pub(crate) fn find_hole(&self) -> bool {
        (0..self.height).any(|line| {
            let row = &self.planes[0][self.offset + line * self.stride..][..self.width];
            // No early end: counts vectorise.
            row.iter()
                .fold(0_u32, |holes, v| holes + u32::from(v.is_nan()))
                > 0
        })
    }

    /// Evaluates a row of places (`x`, `y`: continuous, centres at +½, two samples inside the window;
    /// places outside clamp) into one row per plane.
    pub(crate) fn sample_row(
        &self,
        footprint: Footprint,
        x: &[f32],
        y: &[f32],
        out: &mut [&mut [f32]],
    ) {
        if self.width < 4 || self.height < 4 {
            for row in out {
                row.fill(f32::NAN);
            }
            return;
        }
        let magnifies = footprint.radius_x <= 1.0 && footprint.radius_y <= 1.0;
        for (plane, row) in self.planes.iter().zip(out.iter_mut()) {
            match footprint.kernel {
                Kernel::Nearest => self.nearest(plane, x, y, row),
                _ if self.has_holes => self.with_holes(plane, footprint, x, y, row),
                Kernel::Bicubic if magnifies => self.taps(plane, x, y, row, keys, keys),
                _ if magnifies => self.bilinear(plane, x, y, row),
                Kernel::Bilinear | Kernel::Bicubic => {
                    let (rx, ry) = (1.0 / footprint.radius_x, 1.0 / footprint.radius_y);
                    self.taps(plane, x, y, row, |f| tent(f, rx), |f| tent(f, ry));
                }
            }
        }
    }

    fn nearest(&self, plane: &[f32], x: &[f32], y: &[f32], row: &mut [f32]) {
        for ((x, y), v) in x.iter().zip(y).zip(row) {
            let column = (*x as usize).min(self.width - 1);
            let line = (*y as usize).min(self.height - 1);
            *v = plane[self.offset + line * self.stride + column];
        }
    }

    fn bilinear(&self, plane: &[f32], x: &[f32], y: &[f32], row: &mut [f32]) {
        let (last_column, last_row) = (self.width as i32 - 2, self.height as i32 - 2);
        for ((x, y), v) in x.iter().zip(y).zip(row) {
            let (x, y) = (x - 0.5, y - 0.5);
            let (column, line) = (
                (x as i32).clamp(0, last_column),
                (y as i32).clamp(0, last_row),
            );
            let (fx, fy) = (x - column as f32, y - line as f32);
            let at = self.offset + line as usize * self.stride + column as usize;
            let (north, south) = (
                &plane[at..at + 2],
                &plane[at + self.stride..at + self.stride + 2],
            );
            let n = north[0] + (north[1] - north[0]) * fx;
            let s = south[0] + (south[1] - south[0]) * fx;
            *v = n + (s - n) * fy;
        }
    }

    /// The first of the four columns and rows about a place, and where between the inner two it is.
    #[inline]
    fn four_taps(&self, x: f32, y: f32) -> (usize, f32, f32) {
        let (x, y) = (x - 0.5, y - 0.5);
        let column = (x as i32).clamp(1, self.width as i32 - 3);
        let line = (y as i32).clamp(1, self.height as i32 - 3);
        (
            self.offset + (line as usize - 1) * self.stride + column as usize - 1,
            x - column as f32,
            y - line as f32,
        )
    }

    #[inline]
    fn taps(
        &self,
        plane: &[f32],
        x: &[f32],
        y: &[f32],
        row: &mut [f32],
        weights_x: impl Fn(f32) -> [f32; 4],
        weights_y: impl Fn(f32) -> [f32; 4],
    ) {
        for ((x, y), v) in x.iter().zip(y).zip(row) {
            let (first, fx, fy) = self.four_taps(*x, *y);
            let (wx, wy) = (weights_x(fx), weights_y(fy));
            let centre = plane[first + self.stride + 1];
            let mut sums = [0.0_f32; 4];
            for (line, wy) in wy.iter().enumerate() {
                let at = first + line * self.stride;
                let values = &plane[at..at + 4];
                for i in 0..4 {
                    sums[i] += (values[i] - centre) * (wx[i] * wy);
                }
            }
            let sum = (sums[0] + sums[1]) + (sums[2] + sums[3]);
            let weight = total(wx) * total(wy);
            *v = centre + sum / weight;
        }
    }

    fn with_holes(
        &self,
        plane: &[f32],
        footprint: Footprint,
        x: &[f32],
        y: &[f32],
        row: &mut [f32],
    ) {
        let (rx, ry) = (1.0 / footprint.radius_x, 1.0 / footprint.radius_y);
        let cubic = footprint.kernel == Kernel::Bicubic && rx >= 1.0 && ry >= 1.0;
        for ((x, y), v) in x.iter().zip(y).zip(row) {
            let (first, fx, fy) = self.four_taps(*x, *y);
            let whole = (0..4).all(|l| {
                let at = first + l * self.stride;
                plane[at..at + 4].iter().all(|v| !v.is_nan())
            });
            let (wx, wy) = if cubic && whole {
                (keys(fx), keys(fy))
            } else {
                (tent(fx, rx), tent(fy, ry))
            };
            let mut base = None;
            let (mut sum, mut valid) = (0.0_f32, 0.0_f32);
            for (line, wy) in wy.iter().enumerate() {
                let at = first + line * self.stride;
                for (value, wx) in plane[at..at + 4].iter().zip(&wx) {
                    let w = wx * wy;
                    if w != 0.0 && !value.is_nan() {
                        let base = *base.get_or_insert(*value);
                        sum += (value - base) * w;
                        valid += w;
                    }
                }
            }
            *v = match base {
                // A trace of slack: half a kernel's weight is valid along a straight edge.
                Some(base) if valid >= 0.499_999 * (total(wx) * total(wy)) => base + sum / valid,
                _ => f32::NAN,
            };
        }
    }
}

#[inline]
fn total(w: [f32; 4]) -> f32 {
    (w[0] + w[1]) + (w[2] + w[3])
}

/// Weights of four samples at −1, 0, 1, 2 for a place `f` between 0 and 1: a tent of half-width
/// `1 / inverse_radius`, 1 ≤ radius ≤ 2. Not normalised.
#[inline]
fn tent(f: f32, inverse_radius: f32) -> [f32; 4] {
    [f + 1.0, f, 1.0 - f, 2.0 - f].map(|distance| (1.0 - distance.abs() * inverse_radius).max(0.0))
}

/// Weights of four samples at −1, 0, 1, 2 for a place `f` between 0 and 1: Keys's cubic, a = −½.
#[inline]
fn keys(f: f32) -> [f32; 4] {
    let (f2, f3) = (f * f, f * f * f);
    [
        -0.5 * f3 + f2 - 0.5 * f,
        1.5 * f3 - 2.5 * f2 + 1.0,
        -1.5 * f3 + 2.0 * f2 + 0.5 * f,
        0.5 * f3 - 0.5 * f2,
    ]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const SIZE: usize = 8;

    fn sample(plane: &[f32], kernel: Kernel, radius: f32, x: f32, y: f32) -> f32 {
        let window = Window {
            planes: &[plane],
            offset: 0,
            stride: SIZE,
            width: SIZE,
            height: SIZE,
            has_holes: plane.iter().any(|v| v.is_nan()),
        };
        let mut out = [0.0];
        let footprint = Footprint {
            kernel,
            radius_x: radius,
            radius_y: radius,
        };
        window.sample_row(footprint, &[x], &[y], &mut [&mut out[..]]);
        out[0]
    }

    fn plane(f: impl Fn(f32, f32) -> f32) -> Vec<f32> {
        (0..SIZE * SIZE)
            .map(|i| f((i % SIZE) as f32 + 0.5, (i / SIZE) as f32 + 0.5))
            .collect()
    }

    fn kernels() -> impl Strategy<Value = Kernel> {
        prop::sample::select(vec![Kernel::Nearest, Kernel::Bilinear, Kernel::Bicubic])
    }

    proptest! {
        #[test]
        fn a_constant_stays_constant_to_the_bit_beside_holes_too(
            value in -9e3..9e3_f32, radius in 1.0..2.0_f32, x in 2.0..6.0_f32, y in 2.0..6.0_f32,
            kernel in kernels(), holes in any::<u64>(),
        ) {
            for holes in [0, holes & holes.rotate_left(7)] {
                let p: Vec<f32> = (0..64).map(|i| if holes >> i & 1 == 1 { f32::NAN } else { value }).collect();
                let v = sample(&p, kernel, radius, x, y);
                prop_assert!(v.to_bits() == value.to_bits() || (holes != 0 && v.is_nan()), "{v}");
            }
        }

        #[test]
        fn a_ramp_is_reproduced_between_samples(x in 2.0..6.0_f32, y in 2.0..6.0_f32, kernel in kernels()) {
            prop_assume!(kernel != Kernel::Nearest);
            let v = sample(&plane(|x, y| 3.0 * x - 2.0 * y + 100.0), kernel, 1.0, x, y);
            prop_assert!((v - (3.0 * x - 2.0 * y + 100.0)).abs() < 1e-4);
        }

        #[test]
        fn a_tent_as_wide_as_a_sample_is_bilinear(x in 2.0..6.0_f32, y in 2.0..6.0_f32) {
            let p = plane(|x, y| x * x * 7.0 + x * y);
            let (a, b) = (sample(&p, Kernel::Bilinear, 1.0, x, y), sample(&p, Kernel::Bilinear, 1.000_001, x, y));
            prop_assert!((a - b).abs() < 1e-3);
        }
    }

    #[test]
    fn a_place_most_of_whose_weight_is_a_hole_is_a_hole() {
        let p = plane(|x, _| if x < 4.0 { f32::NAN } else { 5.0 });
        assert!(sample(&p, Kernel::Bilinear, 1.0, 3.9, 4.0).is_nan());
        assert_eq!(sample(&p, Kernel::Bilinear, 1.0, 4.1, 4.0), 5.0);
    }

    #[test]
    fn cubic_convolution_passes_through_the_samples() {
        let p = plane(|x, y| x * x - y);
        assert_eq!(sample(&p, Kernel::Bicubic, 1.0, 3.5, 4.5), 3.5 * 3.5 - 4.5);
    }
}
