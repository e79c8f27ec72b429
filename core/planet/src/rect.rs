//! Half-open rectangles of samples.

use glam::I64Vec2;

/// Half-open rectangle of samples of one lattice: `min` inside, `max` outside.
///
/// `x` counts columns eastward, `y` counts rows southward. A rectangle may lie partly or wholly
/// outside its lattice's extent: columns then wrap and rows reflect over the poles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub struct SampleRect {
    /// First column and row inside.
    pub min: I64Vec2,
    /// First column and row beyond the end.
    pub max: I64Vec2,
}

impl SampleRect {
    /// The rectangle between two corners; empty when `max` does not exceed `min`.
    pub const fn new(min: I64Vec2, max: I64Vec2) -> Self {
        Self { min, max }
    }

    /// The rectangle with its first sample at (`column`, `row`) and the given size.
    pub const fn at(column: i64, row: i64, width: i64, height: i64) -> Self {
        Self::new(
            I64Vec2::new(column, row),
            I64Vec2::new(column + width, row + height),
        )
    }

    /// Number of columns, never negative.
    pub fn width(&self) -> i64 {
        (self.max.x - self.min.x).max(0)
    }

    /// Number of rows, never negative.
    pub fn height(&self) -> i64 {
        (self.max.y - self.min.y).max(0)
    }

    /// Number of samples, never negative.
    pub fn area(&self) -> i64 {
        self.width() * self.height()
    }

    /// Whether it holds no sample.
    pub fn is_empty(&self) -> bool {
        self.width() == 0 || self.height() == 0
    }

    /// Whether the sample lies inside.
    pub fn contains(&self, sample: I64Vec2) -> bool {
        sample.cmpge(self.min).all() && sample.cmplt(self.max).all()
    }

    /// Whether every sample of `other` lies inside; true for an empty `other`.
    pub fn contains_rect(&self, other: &Self) -> bool {
        other.is_empty() || (other.min.cmpge(self.min).all() && other.max.cmple(self.max).all())
    }

    /// The samples that lie in both; empty (and canonical) when there are none.
    #[must_use]
    pub fn intersection(&self, other: &Self) -> Self {
        let both = Self::new(self.min.max(other.min), self.max.min(other.max));
        if both.is_empty() { Self::default() } else { both }
    }

    /// Whether some sample lies in both.
    pub fn overlaps(&self, other: &Self) -> bool {
        !self.intersection(other).is_empty()
    }

    /// The smallest rectangle that holds both; an empty one does not count.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        match (self.is_empty(), other.is_empty()) {
            (true, _) => *other,
            (_, true) => *self,
            _ => Self::new(self.min.min(other.min), self.max.max(other.max)),
        }
    }

    /// Grown by `samples` on all four sides (shrunk when negative).
    #[must_use]
    pub fn grow(&self, samples: i64) -> Self {
        Self::new(self.min - samples, self.max + samples)
    }

    /// Moved by `offset`.
    #[must_use]
    pub fn shift(&self, offset: I64Vec2) -> Self {
        Self::new(self.min + offset, self.max + offset)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn disjoint_rectangles_intersect_in_the_canonical_empty_one() {
        let a = SampleRect::at(0, 0, 4, 4);
        assert_eq!(a.intersection(&SampleRect::at(9, 9, 1, 1)), SampleRect::default());
        assert!(!a.overlaps(&SampleRect::at(4, 0, 4, 4)), "half-open: sides that touch share nothing");
    }

    #[test]
    fn an_empty_rectangle_adds_nothing_to_a_union() {
        let a = SampleRect::at(3, 4, 5, 6);
        assert_eq!(a.union(&SampleRect::default()), a);
        assert_eq!(SampleRect::at(90, 90, 0, 5).union(&a), a);
    }
}
