//! The octaves of detail: powers of two metres on every planet, weighed by what data lack.

/// Octaves are at least so long, metres: below, f64 coordinates run out of digits.
pub(super) const SHORTEST_M: f64 = 1.0 / 64.0;

/// Octaves at most.
const MOST: i32 = 40;

/// One octave of detail.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Octave {
    /// The exponent of its wavelength: 2 to this power metres.
    pub(super) exponent: i32,
    pub(super) wavelength_m: f64,
    /// How much of it the data lack, as a factor on heights, 0 to 1.
    pub(super) lacking: f64,
}

impl Octave {
    /// The factor on heights on a grid with samples of this size: 0 where they cannot show the octave.
    pub(super) fn shown(&self, spacing_m: f64) -> f64 {
        self.lacking * smooth((self.wavelength_m / spacing_m - 2.0) / 2.0)
    }
}

/// Octaves that data of a spacing lack, longest first, down to about a shortest wavelength.
pub(super) fn octaves(spacing_m: f64, shortest_m: f64) -> Vec<Octave> {
    let longest = libm::floor(libm::log2(LONGEST * spacing_m)) as i32;
    let least_m = shortest_m.max(SHORTEST_M);
    let octave = |exponent: i32| {
        let wavelength_m = libm::exp2(f64::from(exponent));
        Octave {
            exponent,
            wavelength_m,
            lacking: lacking(wavelength_m / spacing_m),
        }
    };
    (longest - MOST + 1..=longest)
        .rev()
        .map(octave)
        .take_while(|octave| octave.wavelength_m >= least_m)
        .filter(|octave| octave.lacking > 0.0)
        .collect()
}

/// Wavelengths, in samples of the data, from which on data lack nothing of an octave, and up to which
/// they lack all of it.
const LONGEST: f64 = 8.0;
const WHOLE: f64 = 2.828_427_124_746_190_3;

/// How much data lack of an octave whose wavelength is so many of their samples.
///
/// Bilinear heights between samples that are means have lost a third of a wave 4 samples long and all but
/// a sixth at 2; an octave of noise holds longer and shorter waves too. This smooth step, found by least
/// squares, brings the sum within 0.3 dB (root mean square) of the law for exponents of 0.4 to 1.
fn lacking(wavelength: f64) -> f64 {
    smooth(libm::log2(LONGEST / wavelength) / libm::log2(LONGEST / WHOLE))
}

/// 0 below 0, 1 above 1, smooth between.
pub(super) fn smooth(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn octaves_begin_where_data_lack_something_and_end_at_the_shortest() {
        let all = octaves(81.56, 1.0);
        assert_eq!(all.first().map(|o| o.exponent), Some(9));
        assert_eq!(all.last().map(|o| o.exponent), Some(0));
        assert!(all.windows(2).all(|pair| {
            pair[0].exponent == pair[1].exponent + 1 && pair[0].lacking <= pair[1].lacking
        }));
        assert!(all[0].lacking < 0.2 && all[3].lacking == 1.0, "{all:?}");
    }

    #[test]
    fn data_finer_than_the_shortest_octave_lack_nothing() {
        assert!(octaves(0.1, 1.0).is_empty());
        assert!(octaves(1e-6, 1e-9).is_empty());
        assert!(octaves(1e9, 0.0).len() <= MOST as usize);
    }
}
