//! The coarse colours with which pieces of exemplars are compared.

use glam::{DVec2, I64Vec2};
use relievo_planet::SampleRect;

use super::coarse::Coarse;

/// A coarse colour with which a piece is compared.
pub(super) struct Wanted {
    /// The sample, from the first one south-east of the centre (or at it).
    pub(super) column: i64,
    pub(super) row: i64,
    pub(super) light: [f32; 3],
}

/// The coarse colours around the centre of a patch.
pub(super) struct Around {
    pub(super) samples: Vec<Wanted>,
    /// Of each sample, and alpha 1.
    pub(super) encoded: Vec<[f32; 4]>,
    /// Mean of all, if all are there and there are several.
    pub(super) mean: Option<[f32; 4]>,
}

/// Coarse samples to either side with which a piece is compared, where patches are 2^`exponent` coarse
/// samples apart; 0 is only the sample at the centre.
pub(super) fn half(exponent: i32) -> i64 {
    // Centres that are several samples apart lie on corners of samples.
    match exponent {
        2.. => 3,
        1 => 2,
        _ => 0,
    }
}

impl Around {
    /// Around a centre in coarse samples; `None` where there is nothing. Beyond a pole rows are
    /// mirrored.
    pub(super) fn new(
        coarse: &Coarse,
        centre: DVec2,
        exponent: i32,
        mirrored: bool,
    ) -> Option<Self> {
        let half = half(exponent);
        let nearest = centre.floor().as_i64vec2();
        let rect = SampleRect::new(nearest - half, nearest + half.max(1));
        let mut samples = Vec::with_capacity(rect.area() as usize);
        let mut encoded = Vec::with_capacity(rect.area() as usize);
        let mut sum = [0.0; 4];
        for y in rect.min.y..rect.max.y {
            for x in rect.min.x..rect.max.x {
                let sample = I64Vec2::new(x, y);
                let at = coarse.at(sample);
                if coarse.there[at] {
                    let [r, g, b] = coarse.encoded[at];
                    let row = y - nearest.y;
                    samples.push(Wanted {
                        column: x - nearest.x,
                        row: if mirrored && half > 0 { -1 - row } else { row },
                        light: coarse.light.get(at),
                    });
                    encoded.push([r, g, b, 1.0]);
                    for (sum, v) in sum.iter_mut().zip([r, g, b, 1.0]) {
                        *sum += v;
                    }
                }
            }
        }
        let count = samples.len() as f32;
        let all = half > 0 && samples.len() == rect.area() as usize;
        (!samples.is_empty()).then_some(Self {
            samples,
            encoded,
            mean: all.then(|| sum.map(|v| v / count)),
        })
    }
}
