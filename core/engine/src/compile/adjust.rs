//! A project's colour adjustment as a node's parameters.

use relievo_graph::nodes::{AdjustParams, AdjustSpace, Clear, Curve, WhiteBalance};
use relievo_project::{Adjust, AdjustSpace as ProjectSpace, CurvePoint};
use relievo_raster::colour::from_u8;

/// The parameters.
pub(crate) fn adjustment(adjust: &Adjust) -> AdjustParams {
    AdjustParams {
        space: match adjust.space {
            ProjectSpace::Display => AdjustSpace::Display,
            ProjectSpace::Linear => AdjustSpace::Linear,
            ProjectSpace::Perceptual => AdjustSpace::Perceptual,
        },
        white: WhiteBalance {
            temperature_k: adjust.temperature_k,
            tint: adjust.tint,
        },
        mix: adjust.mix,
        gain: adjust.gain,
        offset: adjust.offset,
        brightness: adjust.brightness,
        contrast: adjust.contrast,
        hue_deg: adjust.hue_deg,
        saturation: adjust.saturation,
        gamma: adjust.gamma,
        curve: curve(&adjust.curves.all),
        curves: adjust
            .curves
            .channels
            .each_ref()
            .map(|points| curve(points)),
        invert: adjust.invert,
        clear: adjust.clear.as_ref().map(|clear| Clear {
            rgb: clear.colour.map(|v| f64::from(from_u8(v))),
            from: clear.from,
            to: clear.to,
        }),
        strength: adjust.strength,
    }
}

fn curve(points: &[CurvePoint]) -> Curve {
    let points: Vec<[f64; 2]> = points.iter().map(|p| [p.input, p.output]).collect();
    Curve::through(&points)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_of_the_project_are_those_of_the_node() {
        assert_eq!(adjustment(&Adjust::default()), AdjustParams::default());
    }
}
