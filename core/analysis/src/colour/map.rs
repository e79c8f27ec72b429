//! Affine maps of colours, and the one that fits pairs best.

use glam::{DMat3, DVec3};

use super::ColourPair;

/// A colour as a vector.
pub(super) fn vector(rgb: [f32; 3]) -> DVec3 {
    DVec3::from(rgb.map(f64::from))
}

/// c ↦ M c + t on display values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColourMap {
    /// M.
    pub matrix: DMat3,
    /// t.
    pub offset: DVec3,
}

impl ColourMap {
    /// The map that changes nothing.
    pub const IDENTITY: Self = Self {
        matrix: DMat3::IDENTITY,
        offset: DVec3::ZERO,
    };

    /// The image of a colour.
    pub fn apply(&self, rgb: [f32; 3]) -> DVec3 {
        self.matrix * vector(rgb) + self.offset
    }

    /// How far a pair's first colour, mapped, is from its second.
    pub(super) fn residual(&self, pair: &ColourPair) -> f64 {
        self.apply(pair.from).distance(vector(pair.to))
    }

    /// The map with the least weighted sum of squares, drawn towards the identity by as much as
    /// `STIFFNESS` of the colours' own variance: what the pairs do not say stays as it is.
    pub(super) fn least_squares<'a>(
        pairs: impl Iterator<Item = (&'a ColourPair, f64)> + Clone,
    ) -> Self {
        const STIFFNESS: f64 = 1e-4;
        /// Variance of display values below which nothing can be said.
        const LEAST_VARIANCE: f64 = 1e-9;
        let (mut weight, mut from, mut to) = (0.0, DVec3::ZERO, DVec3::ZERO);
        for (pair, w) in pairs.clone() {
            weight += w;
            from += w * vector(pair.from);
            to += w * vector(pair.to);
        }
        if weight <= 0.0 {
            return Self::IDENTITY;
        }
        let (from, to) = (from / weight, to / weight);
        let (mut own, mut crossed) = (DMat3::ZERO, DMat3::ZERO);
        for (pair, w) in pairs {
            let (x, y) = (vector(pair.from) - from, vector(pair.to) - to);
            own += outer(x * w, x);
            crossed += outer(y * w, x);
        }
        let (own, crossed) = (own * weight.recip(), crossed * weight.recip());
        let variance = own.x_axis.x + own.y_axis.y + own.z_axis.z;
        let stiff = DMat3::IDENTITY * (STIFFNESS * variance + LEAST_VARIANCE);
        let matrix = (crossed + stiff) * (own + stiff).inverse();
        Self {
            matrix,
            offset: to - matrix * from,
        }
    }
}

/// a bᵀ.
fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}
