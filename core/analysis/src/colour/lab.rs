//! CIELAB from display values.

/// A colour in CIELAB, white D65.
///
/// Source: \[CIE04\] 8.2.1; primaries of \[IEC99\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lab {
    /// Lightness, 0 to 100.
    pub l: f64,
    /// Green (negative) to red.
    pub a: f64,
    /// Blue (negative) to yellow.
    pub b: f64,
}

/// White point of sRGB: its own matrix's row sums, so that white has no hue.
const WHITE: [f64; 3] = [0.950_470, 1.0, 1.088_830];

/// XYZ from linear sRGB.
const XYZ: [[f64; 3]; 3] = [
    [0.412_456_4, 0.357_576_1, 0.180_437_5],
    [0.212_672_9, 0.715_152_2, 0.072_175_0],
    [0.019_333_9, 0.119_192_0, 0.950_304_1],
];

impl Lab {
    /// From display values, sRGB encoded, 0 to 1.
    pub fn from_srgb(encoded: [f32; 3]) -> Self {
        let linear = encoded.map(|value| {
            let value = f64::from(value);
            if value <= 0.040_45 {
                value / 12.92
            } else {
                libm::pow((value + 0.055) / 1.055, 2.4)
            }
        });
        let relative = |row: usize| {
            let sum: f64 = XYZ[row].iter().zip(&linear).map(|(m, v)| m * v).sum();
            compressed(sum / WHITE[row])
        };
        let [x, y, z] = [relative(0), relative(1), relative(2)];
        Self {
            l: 116.0 * y - 16.0,
            a: 500.0 * (x - y),
            b: 200.0 * (y - z),
        }
    }
}

fn compressed(t: f64) -> f64 {
    const EDGE: f64 = 6.0 / 29.0;
    if t > EDGE * EDGE * EDGE {
        libm::cbrt(t)
    } else {
        t / (3.0 * EDGE * EDGE) + 4.0 / 29.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn greys_have_no_hue_and_red_is_where_the_tables_have_it() {
        for (value, l) in [(0.0, 0.0), (1.0, 100.0), (0.466_327, 50.0)] {
            let grey = Lab::from_srgb([value; 3]);
            assert!(
                (grey.l - l).abs() < 0.01 && grey.a.abs() < 0.01 && grey.b.abs() < 0.01,
                "{grey:?}"
            );
        }
        // Lindbloom's calculator, sRGB (1, 0, 0), D65.
        let red = Lab::from_srgb([1.0, 0.0, 0.0]);
        assert!((red.l - 53.2408).abs() < 1e-2, "{red:?}");
        assert!(
            (red.a - 80.0925).abs() < 1e-2 && (red.b - 67.2032).abs() < 1e-2,
            "{red:?}"
        );
    }
}
