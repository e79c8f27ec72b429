//! Kernels: the value of a window of samples between its samples.
//!
//! Heights: NaN is a hole. Weights are renormalised over what is valid, and a sample is NaN when
//! less than half of the kernel's weight lies on valid samples (GDAL's bilinear keeps a sample when
//! the pixel that contains it is valid, which differs by a fraction of a pixel along holes).
//! Colours: premultiplied linear light, where a hole is simply transparent.
//!
//! Every value is `v₀ + Σ w (v − v₀) / Σ w` about one of the samples, so a constant window gives
//! that constant to the bit and large heights lose nothing.

use crate::vector::floor;

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

impl Kernel {
    /// A number for names, never reused.
    pub fn tag(self) -> i64 {
        match self {
            Self::Nearest => 0,
            Self::Bilinear => 1,
            Self::Bicubic => 2,
        }
    }
}

/// A window of one or four planes, inside larger ones.
pub(crate) struct Window<'a> {
    pub(crate) planes: &'a [&'a [f32]],
    /// The same samples of four planes side by side, where there are such: the four values of a
    /// pixel are fetched together.
    pub(crate) pixels: Option<&'a [[f32; 4]]>,
    /// Index of the window's first sample in each plane.
    pub(crate) offset: usize,
    /// Samples from one row of the planes to the next.
    pub(crate) stride: usize,
    pub(crate) width: usize,
    pub(crate) height: usize,
}

/// Footprint of a kernel: radius of its tent along columns and rows in samples, 1 ≤ r < 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Footprint {
    pub(crate) kernel: Kernel,
    pub(crate) radius_x: f32,
    pub(crate) radius_y: f32,
}

/// Places that are worked on together.
pub(crate) const LANES: usize = 16;

/// One value of each.
pub(crate) type Lane = [f32; LANES];

/// Of each place: index of the first sample about it, and where between two samples it is.
struct Lanes {
    first: [u32; LANES],
    fx: [f32; LANES],
    fy: [f32; LANES],
}

impl Window<'_> {
    /// Evaluates places (`x`, `y`: continuous, centres at +½, two samples inside the window; places
    /// outside clamp) into one lane per plane. Runs on vectors where it is inlined into a kernel
    /// that does.
    #[inline(always)]
    pub(crate) fn sample(&self, footprint: Footprint, x: &Lane, y: &Lane, out: &mut [Lane]) {
        if self.width < 4 || self.height < 4 {
            for lane in out {
                lane.fill(f32::NAN);
            }
            return;
        }
        let magnifies = footprint.radius_x <= 1.0 && footprint.radius_y <= 1.0;
        let (rx, ry) = (1.0 / footprint.radius_x, 1.0 / footprint.radius_y);
        match footprint.kernel {
            Kernel::Nearest => {
                for (plane, lane) in self.planes.iter().zip(out) {
                    self.nearest(plane, x, y, lane);
                }
            }
            Kernel::Bilinear if magnifies => self.bilinear(x, y, out),
            Kernel::Bicubic if magnifies => self.taps(x, y, out, [keys, keys], (1.0, 1.0)),
            Kernel::Bilinear | Kernel::Bicubic => {
                self.taps(
                    x,
                    y,
                    out,
                    [rx, ry].map(|r| {
                        #[inline(always)]
                        move |f| tent(f, r)
                    }),
                    (rx, ry),
                );
            }
        }
    }

    #[inline(always)]
    fn nearest(&self, plane: &[f32], x: &Lane, y: &Lane, out: &mut Lane) {
        for ((x, y), v) in x.iter().zip(y).zip(out) {
            let column = (*x as usize).min(self.width - 1);
            let line = (*y as usize).min(self.height - 1);
            *v = plane[self.offset + line * self.stride + column];
        }
    }

    #[inline(always)]
    fn bilinear(&self, x: &Lane, y: &Lane, out: &mut [Lane]) {
        let at = self.lanes(x, y, 0, 2);
        if let (Some(pixels), [_, _, _, _]) = (self.pixels, &*out) {
            let mut holes = false;
            let mut values = [[0.0_f32; 4]; LANES];
            for (i, value) in values.iter_mut().enumerate() {
                let about = &pixels[at.first[i] as usize..][..self.stride + 2];
                let (nw, ne) = (about[0], about[1]);
                let (sw, se) = (about[self.stride], about[self.stride + 1]);
                for c in 0..4 {
                    let n = nw[c] + (ne[c] - nw[c]) * at.fx[i];
                    let s = sw[c] + (se[c] - sw[c]) * at.fx[i];
                    value[c] = n + (s - n) * at.fy[i];
                    holes |= value[c].is_nan();
                }
            }
            for (c, out) in out.iter_mut().enumerate() {
                for (out, value) in out.iter_mut().zip(&values) {
                    *out = value[c];
                }
            }
            if !holes {
                return;
            }
        }
        for (plane, out) in self.planes.iter().zip(out) {
            // Neighbours are fetched together.
            let (mut north, mut south) = ([[0.0_f32; 2]; LANES], [[0.0_f32; 2]; LANES]);
            for (i, first) in at.first.iter().enumerate() {
                // One check of bounds for all four.
                let about = &plane[*first as usize..][..self.stride + 2];
                north[i] = [about[0], about[1]];
                south[i] = [about[self.stride], about[self.stride + 1]];
            }
            for i in 0..LANES {
                let n = north[i][0] + (north[i][1] - north[i][0]) * at.fx[i];
                let s = south[i][0] + (south[i][1] - south[i][0]) * at.fx[i];
                out[i] = n + (s - n) * at.fy[i];
            }
            self.mend(plane, x, y, (1.0, 1.0), out);
        }
    }

    /// The first of the columns and rows about each place, of which `before` lie west and north of
    /// the one at or before it, and where between that and the next one the place is; `after` is how
    /// far from the window's end that one stays.
    #[inline(always)]
    fn lanes(&self, x: &Lane, y: &Lane, before: u32, after: u32) -> Lanes {
        let (offset, stride) = (self.offset as u32, self.stride as u32);
        let begin = before as f32;
        let end = [self.width, self.height].map(|n| (n as u32 - after) as f32);
        // NaN counts as the beginning.
        let clamp = |v: f32, end: f32| {
            let v = if v > begin { v } else { begin };
            if v < end { v } else { end }
        };
        let mut at = Lanes {
            first: [0; LANES],
            fx: [0.0; LANES],
            fy: [0.0; LANES],
        };
        for i in 0..LANES {
            let (x, y) = (x[i] - 0.5, y[i] - 0.5);
            let ((column, west), (line, north)) =
                (floor(clamp(x, end[0])), floor(clamp(y, end[1])));
            at.first[i] = offset + (line - before) * stride + (column - before);
            at.fx[i] = x - west;
            at.fy[i] = y - north;
        }
        at
    }

    /// Sums over 4 × 4 samples about each place. Beside holes: with tents of the inverse radii
    /// `tents`.
    #[inline(always)]
    fn taps(
        &self,
        x: &Lane,
        y: &Lane,
        out: &mut [Lane],
        weights: [impl Fn(f32) -> [f32; 4]; 2],
        tents: (f32, f32),
    ) {
        let at = self.lanes(x, y, 1, 3);
        let [weights_x, weights_y] = weights;
        let wx = at.fx.map(weights_x);
        let wy = at.fy.map(weights_y);
        let share: [f32; LANES] = core::array::from_fn(|i| 1.0 / (total(wx[i]) * total(wy[i])));
        for (plane, out) in self.planes.iter().zip(out) {
            for (i, v) in out.iter_mut().enumerate() {
                // One check of bounds for all sixteen.
                let about = &plane[at.first[i] as usize..][..3 * self.stride + 4];
                let centre = about[self.stride + 1];
                let mut columns = [0.0_f32; 4];
                for (line, w) in wy[i].iter().enumerate() {
                    let values = &about[line * self.stride..][..4];
                    for (sum, value) in columns.iter_mut().zip(values) {
                        *sum += (value - centre) * w;
                    }
                }
                let [a, b, c, d] = core::array::from_fn(|k| columns[k] * wx[i][k]);
                *v = centre + ((a + b) + (c + d)) * share[i];
            }
            self.mend(plane, x, y, tents, out);
        }
    }

    /// Replaces values that are NaN because a sample is.
    #[inline(always)]
    fn mend(&self, plane: &[f32], x: &Lane, y: &Lane, tents: (f32, f32), out: &mut Lane) {
        // Not short-circuited, so that it runs on vectors.
        if out.iter().fold(false, |holes, v| holes | v.is_nan()) {
            self.mend_holes(plane, x, y, tents, out);
        }
    }

    #[inline(never)]
    fn mend_holes(&self, plane: &[f32], x: &Lane, y: &Lane, tents: (f32, f32), out: &mut Lane) {
        let at = self.lanes(x, y, 1, 3);
        for (i, v) in out.iter_mut().enumerate().filter(|(_, v)| v.is_nan()) {
            let (wx, wy) = (tent(at.fx[i], tents.0), tent(at.fy[i], tents.1));
            *v = self.beside_holes(plane, at.first[i] as usize, wx, wy);
        }
    }

    /// The value of a place some of whose 4 × 4 samples are NaN.
    fn beside_holes(&self, plane: &[f32], first: usize, wx: [f32; 4], wy: [f32; 4]) -> f32 {
        let lines: [&[f32]; 4] = core::array::from_fn(|line| {
            let at = first + line * self.stride;
            &plane[at..at + 4]
        });
        // The inner four have more than half of any kernel's weight.
        if lines[1..3].iter().all(|l| l[1].is_nan() && l[2].is_nan()) {
            return f32::NAN;
        }
        let (mut base, mut sum, mut valid) = (None, 0.0_f32, 0.0_f32);
        for (values, wy) in lines.iter().zip(&wy) {
            for (value, wx) in values.iter().zip(&wx) {
                let w = wx * wy;
                if w != 0.0 && !value.is_nan() {
                    let base = *base.get_or_insert(*value);
                    sum += (value - base) * w;
                    valid += w;
                }
            }
        }
        match base {
            // A trace of slack: half a kernel's weight is valid along a straight edge.
            Some(base) if valid >= 0.499_999 * (total(wx) * total(wy)) => base + sum / valid,
            _ => f32::NAN,
        }
    }
}

#[inline(always)]
fn total(w: [f32; 4]) -> f32 {
    (w[0] + w[1]) + (w[2] + w[3])
}

/// Weights of four samples at −1, 0, 1, 2 for a place `f` between 0 and 1: a tent of half-width
/// `1 / inverse_radius`, 1 ≤ radius ≤ 2. Not normalised.
#[inline(always)]
fn tent(f: f32, inverse_radius: f32) -> [f32; 4] {
    [f + 1.0, f, 1.0 - f, 2.0 - f].map(|distance| (1.0 - distance.abs() * inverse_radius).max(0.0))
}

/// Weights of four samples at −1, 0, 1, 2 for a place `f` between 0 and 1: Keys's cubic, a = −½.
#[inline(always)]
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
            pixels: None,
            offset: 0,
            stride: SIZE,
            width: SIZE,
            height: SIZE,
        };
        let mut out = [[0.0; LANES]];
        let footprint = Footprint {
            kernel,
            radius_x: radius,
            radius_y: radius,
        };
        window.sample(footprint, &[x; LANES], &[y; LANES], &mut out);
        assert!(out[0].iter().all(|v| v.to_bits() == out[0][0].to_bits()));
        out[0][0]
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
        fn vectors_of_any_width_give_the_same_bits(
            values in prop::collection::vec(prop_oneof![9 => -9e3..9e3_f32, 1 => Just(f32::NAN)], SIZE * SIZE),
            x in prop::array::uniform16(-1.0..9.0_f32), y in prop::array::uniform16(-1.0..9.0_f32),
            radius in prop_oneof![Just(1.0_f32), 1.0..2.0_f32], kernel in kernels(),
        ) {
            let window = Window { planes: &[&values[..]], pixels: None, offset: 0, stride: SIZE, width: SIZE, height: SIZE };
            let footprint = Footprint { kernel, radius_x: radius, radius_y: radius };
            let mut widest = [[0.0; LANES]];
            crate::vector::on_widest(
                #[inline(always)]
                || window.sample(footprint, &x, &y, &mut widest),
            );
            let mut plain = [[0.0; LANES]];
            window.sample(footprint, &x, &y, &mut plain);
            prop_assert_eq!(widest[0].map(f32::to_bits), plain[0].map(f32::to_bits));
        }

        #[test]
        fn pixels_side_by_side_give_the_bits_of_their_planes(
            values in prop::collection::vec(prop::array::uniform4(prop_oneof![99 => 0.0..1.0_f32, 1 => Just(f32::NAN)]), SIZE * SIZE),
            x in prop::array::uniform16(-1.0..9.0_f32), y in prop::array::uniform16(-1.0..9.0_f32),
        ) {
            let planes: [Vec<f32>; 4] = core::array::from_fn(|c| values.iter().map(|v| v[c]).collect());
            let planes: [&[f32]; 4] = core::array::from_fn(|c| &planes[c][..]);
            let footprint = Footprint { kernel: Kernel::Bilinear, radius_x: 1.0, radius_y: 1.0 };
            let [together, apart] = [Some(&values[..]), None].map(|pixels| {
                let window = Window { planes: &planes, pixels, offset: 0, stride: SIZE, width: SIZE, height: SIZE };
                let mut out = [[0.0; LANES]; 4];
                window.sample(footprint, &x, &y, &mut out);
                out.map(|lane| lane.map(f32::to_bits))
            });
            prop_assert_eq!(together, apart);
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
