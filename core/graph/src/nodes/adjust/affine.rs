//! Affine maps of colours: what most adjustments are, so that several cost no more than one.

use glam::DMat3;

/// Rec. 709 weights of red, green and blue in luma (display values) and luminance (linear light).
pub(super) const LUMA: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Rows: one output channel from (red, green, blue, 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Affine(pub(super) [[f64; 4]; 3]);

impl Affine {
    pub(super) const IDENTITY: Self = Self([
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
    ]);

    /// A matrix alone, by its rows.
    pub(super) fn linear(m: [[f64; 3]; 3]) -> Self {
        Self(m.map(|[r, g, b]| [r, g, b, 0.0]))
    }

    /// A matrix alone.
    pub(super) fn of(m: DMat3) -> Self {
        Self::linear(core::array::from_fn(|r| m.row(r).to_array()))
    }

    /// Factors and sums of each channel.
    pub(super) fn channels(gain: [f64; 3], offset: [f64; 3]) -> Self {
        let mut map = Self::IDENTITY;
        for (c, row) in map.0.iter_mut().enumerate() {
            (row[c], row[3]) = (gain[c], offset[c]);
        }
        map
    }

    /// A factor on the distance from `pivot`.
    pub(super) fn contrast(factor: f64, pivot: f64) -> Self {
        Self::channels([factor; 3], [pivot * (1.0 - factor); 3])
    }

    /// luma + s · (colour − luma).
    pub(super) fn saturation(s: f64) -> Self {
        Self::linear(luma_mix(s))
    }

    /// Rotation about the grey axis within planes of equal luma: L + cos·(I − L) + sin·S, where S turns
    /// by a right angle and its rows, weighted by luma, add up to nothing.
    ///
    /// Source: `hueRotate` of W3C Filter Effects 1 with Rec. 709 weights.
    pub(super) fn hue(angle_rad: f64) -> Self {
        let [lr, lg, lb] = LUMA;
        let (sin, cos) = libm::sincos(angle_rad);
        let quarter = [
            [-lr, -lg, 1.0 - lb],
            [
                (lr * lr + lb * (1.0 - lr)) / lg,
                lr - lb,
                -(lr * (1.0 - lb) + lb * lb) / lg,
            ],
            [lr - 1.0, lg, lb],
        ];
        let mix = luma_mix(cos);
        Self::linear(core::array::from_fn(|r| {
            core::array::from_fn(|c| mix[r][c] + sin * quarter[r][c])
        }))
    }

    /// This after `first`. The identity changes no bit of the other.
    pub(super) fn after(self, first: Self) -> Self {
        if first == Self::IDENTITY {
            return self;
        }
        if self == Self::IDENTITY {
            return first;
        }
        Self(self.0.map(|row| {
            core::array::from_fn(|c| {
                let sum = row[0] * first.0[0][c] + row[1] * first.0[1][c] + row[2] * first.0[2][c];
                if c == 3 { sum + row[3] } else { sum }
            })
        }))
    }

    /// As it is applied.
    pub(super) fn singles(self) -> [[f32; 4]; 3] {
        self.0.map(|row| row.map(|v| v as f32 + 0.0))
    }
}

/// The matrix of these rows.
pub(super) fn matrix(rows: [[f64; 3]; 3]) -> DMat3 {
    DMat3::from_cols_array_2d(&rows).transpose()
}

fn luma_mix(s: f64) -> [[f64; 3]; 3] {
    core::array::from_fn(|r| {
        core::array::from_fn(|c| LUMA[c] * (1.0 - s) + if r == c { s } else { 0.0 })
    })
}
