//! Colour to alpha: a colour becomes transparent, what is mixed with it keeps the rest.

/// A colour that becomes transparent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clear {
    /// The colour, display values 0 to 1.
    pub rgb: [f64; 3],
    /// Distances from it, 0 to 1, at which a colour is fully clear and still fully opaque; the first below
    /// the second. A distance is the part of the way to the end of the channel's range, the greatest of
    /// the channels.
    pub from: f64,
    /// See `from`.
    pub to: f64,
}

impl Clear {
    /// Numbers that make sense: those that are none count as 0, the distances lie apart.
    pub(super) fn sane(self) -> Self {
        let unit = |v: f64| {
            if v.is_finite() {
                v.clamp(0.0, 1.0)
            } else {
                0.0
            }
        };
        let from = unit(self.from).min(1.0 - 1e-6);
        Self {
            rgb: self.rgb.map(unit),
            from,
            to: unit(self.to).max(from + 1e-6),
        }
    }

    /// What is left of a colour, and the factor on its alpha: laid over the cleared colour it is the
    /// colour that was, wherever something is left.
    pub(super) fn apply(&self, rgb: [f32; 3]) -> ([f32; 3], f32) {
        let mut distance = 0.0_f32;
        let key = self.rgb.map(|v| v as f32);
        for (v, key) in rgb.iter().zip(key) {
            let reach = if *v > key { 1.0 - key } else { key };
            let away = (v - key).abs();
            let part = if away == 0.0 { 0.0 } else { away / reach };
            distance = distance.max(part);
        }
        let (from, to) = (self.from as f32, self.to as f32);
        let left = ((distance - from) / (to - from)).clamp(0.0, 1.0);
        if left >= 1.0 {
            return (rgb, 1.0);
        }
        if left <= 0.0 {
            return ([0.0; 3], 0.0);
        }
        let rest = [0, 1, 2].map(|c: usize| (rgb[c] - key[c]) / left + key[c]);
        (rest, left)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn over_the_cleared_colour_it_is_what_it_was(
            rgb in prop::array::uniform3(0.0..1.0_f32), key in prop::array::uniform3(0.0..1.0_f64),
        ) {
            let clear = Clear { rgb: key, from: 0.0, to: 1.0 }.sane();
            let (rest, left) = clear.apply(rgb);
            prop_assume!(left > 0.0);
            for c in 0..3 {
                let over = rest[c] * left + key[c] as f32 * (1.0 - left);
                prop_assert!((over - rgb[c]).abs() < 1e-5);
                prop_assert!((-1e-4..=1.0001).contains(&rest[c]), "{rest:?}");
            }
        }
    }

    #[test]
    fn the_colour_itself_goes_and_what_is_far_stays() {
        let clear = Clear {
            rgb: [1.0, 1.0, 1.0],
            from: 0.1,
            to: 0.5,
        };
        assert_eq!(clear.apply([1.0, 0.95, 1.0]), ([0.0; 3], 0.0));
        assert_eq!(clear.apply([0.2, 0.3, 0.1]), ([0.2, 0.3, 0.1], 1.0));
        let (_, left) = clear.apply([0.7; 3]);
        assert!((left - 0.5).abs() < 1e-6);
        assert_eq!(
            clear.apply([f32::NAN, 0.0, 0.0]).1,
            1.0,
            "the other channels are far"
        );
        let odd = Clear {
            rgb: [f64::NAN; 3],
            from: 2.0,
            to: -1.0,
        }
        .sane();
        assert!(odd.from < odd.to && odd.to <= 1.0 + 1e-6);
    }
}
