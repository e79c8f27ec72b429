//! Boxes in longitude and latitude.

use core::f64::consts::{FRAC_PI_2, TAU};

use glam::DVec2;

/// A closed box in longitude (x) and latitude (y), radians. Longitudes may lie beyond ±π.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Bounds {
    /// West and south.
    pub min: DVec2,
    /// East and north.
    pub max: DVec2,
}

impl Bounds {
    /// The box around points; `None` without points.
    pub fn around(points: impl IntoIterator<Item = DVec2>) -> Option<Self> {
        points
            .into_iter()
            .map(|p| Self { min: p, max: p })
            .reduce(|a, b| a.union(&b))
    }

    /// The box around both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// Whether some point lies in both.
    pub fn overlaps(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }

    /// Whether all of the other lies inside.
    pub fn contains(&self, other: &Self) -> bool {
        self.min.cmple(other.min).all() && other.max.cmple(self.max).all()
    }

    /// The point in the middle.
    pub fn centre(&self) -> DVec2 {
        0.5 * (self.min + self.max)
    }

    /// Width and height.
    pub fn size(&self) -> DVec2 {
        self.max - self.min
    }

    /// Moved eastward by whole turns.
    #[must_use]
    pub fn turned(&self, turns: i32) -> Self {
        let by = DVec2::new(f64::from(turns) * TAU, 0.0);
        Self {
            min: self.min + by,
            max: self.max + by,
        }
    }

    /// Grown on all sides, within the poles.
    #[must_use]
    pub fn grow(&self, by: DVec2) -> Self {
        Self {
            min: DVec2::new(self.min.x - by.x, (self.min.y - by.y).max(-FRAC_PI_2)),
            max: DVec2::new(self.max.x + by.x, (self.max.y + by.y).min(FRAC_PI_2)),
        }
    }

    /// The turns by which something in `self` has to be moved to lie over something in `other`.
    pub(crate) fn turns_onto(&self, other: &Self) -> core::ops::RangeInclusive<i32> {
        let first = libm::ceil((other.min.x - self.max.x) / TAU - 1e-12);
        let last = libm::floor((other.max.x - self.min.x) / TAU + 1e-12);
        // Boxes are a few turns wide at most; more would be somebody's mistake.
        (first.max(-64.0) as i32)..=(last.min(64.0) as i32)
    }

    /// Whether a segment has a point inside (separating axes).
    pub(crate) fn touches(&self, a: DVec2, b: DVec2) -> bool {
        let (low, high) = (a.min(b), a.max(b));
        if !(low.cmple(self.max).all() && high.cmpge(self.min).all()) {
            return false;
        }
        let d = b - a;
        let half = 0.5 * self.size();
        let m = self.centre() - a;
        (d.x * m.y - d.y * m.x).abs() <= half.x * d.y.abs() + half.y * d.x.abs() + 1e-15
    }
}
