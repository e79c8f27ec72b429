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
        if both.is_empty() {
            Self::default()
        } else {
            both
        }
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

    /// The samples that do not lie in `hole`, as at most four disjoint rectangles.
    pub fn minus(&self, hole: &Self) -> Vec<Self> {
        let hole = self.intersection(hole);
        if hole.is_empty() {
            return if self.is_empty() {
                Vec::new()
            } else {
                vec![*self]
            };
        }
        [
            Self::new(self.min, I64Vec2::new(self.max.x, hole.min.y)),
            Self::new(I64Vec2::new(self.min.x, hole.max.y), self.max),
            Self::new(
                I64Vec2::new(self.min.x, hole.min.y),
                I64Vec2::new(hole.min.x, hole.max.y),
            ),
            Self::new(
                I64Vec2::new(hole.max.x, hole.min.y),
                I64Vec2::new(self.max.x, hole.max.y),
            ),
        ]
        .into_iter()
        .filter(|r| !r.is_empty())
        .collect()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn disjoint_rectangles_intersect_in_the_canonical_empty_one() {
        let a = SampleRect::at(0, 0, 4, 4);
        assert_eq!(
            a.intersection(&SampleRect::at(9, 9, 1, 1)),
            SampleRect::default()
        );
        assert!(
            !a.overlaps(&SampleRect::at(4, 0, 4, 4)),
            "half-open: sides that touch share nothing"
        );
    }

    #[test]
    fn an_empty_rectangle_adds_nothing_to_a_union() {
        let a = SampleRect::at(3, 4, 5, 6);
        assert_eq!(a.union(&SampleRect::default()), a);
        assert_eq!(SampleRect::at(90, 90, 0, 5).union(&a), a);
    }

    fn rects() -> impl Strategy<Value = SampleRect> {
        (-9..9_i64, -9..9_i64, 0..9_i64, 0..9_i64)
            .prop_map(|(x, y, w, h)| SampleRect::at(x, y, w, h))
    }

    proptest! {
        #[test]
        fn a_sample_is_in_the_intersection_when_it_is_in_both(
            a in rects(), b in rects(), x in -10..20_i64, y in -10..20_i64,
        ) {
            let sample = I64Vec2::new(x, y);
            let both = a.intersection(&b);
            prop_assert_eq!(both.contains(sample), a.contains(sample) && b.contains(sample));
            prop_assert_eq!(a.overlaps(&b), both.area() > 0);
            prop_assert!(a.union(&b).contains_rect(&a) && a.union(&b).contains_rect(&b));
        }

        #[test]
        fn a_rectangle_minus_another_is_disjoint_and_whole(a in rects(), b in rects()) {
            let parts = a.minus(&b);
            let area: i64 = parts.iter().map(SampleRect::area).sum();
            prop_assert_eq!(area, a.area() - a.intersection(&b).area());
            prop_assert!(parts.iter().all(|part| a.contains_rect(part) && !part.overlaps(&b)));
        }

        #[test]
        fn growing_and_shrinking_return(a in rects(), samples in 0..5_i64) {
            prop_assert_eq!(a.grow(samples).grow(-samples), a);
        }
    }
}
