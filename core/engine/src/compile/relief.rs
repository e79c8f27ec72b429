//! Nodes of layers that are drawn from the shape of the ground.

use relievo_graph::nodes::{ContourLines, ContourStyle, Stop, Tint};
use relievo_planet::Planet;
use relievo_project::{ContoursLayer, SlopeLayer, Tint as ProjectTint, TintInterpolation};
use relievo_raster::colour::from_u8;

/// Samples finer than this show nothing new of contour lines, in metres: heights are f32.
pub(super) const FINEST_CONTOURS_M: f64 = 0.25;

/// Colours by height.
pub(super) fn tint(from: &ProjectTint) -> Result<Tint, String> {
    let stops = from
        .stops
        .iter()
        .map(|s| stop(s.height_m, s.colour, 1.0))
        .collect();
    table(stops, from.interpolation)
}

/// Colours by the angle of the ground, in degrees.
pub(super) fn slope(from: &SlopeLayer) -> Result<Tint, String> {
    let stops = from
        .stops
        .iter()
        .map(|s| stop(s.slope_deg, s.colour, s.opacity))
        .collect();
    table(stops, from.interpolation)
}

/// Lines of equal height.
pub(super) fn contours(from: &ContoursLayer, planet: Planet) -> Result<ContourLines, String> {
    let style = ContourStyle {
        interval_m: from.interval_m,
        base_m: from.base_m,
        index_every: from.index_every,
        rgb: from.colour.map(from_u8),
        width: from.width_px as f32,
        index_width: from.index_width_px as f32,
    };
    ContourLines::new(planet, style).map_err(|e| e.to_string())
}

fn stop(at: f64, colour: [u8; 3], opacity: f64) -> Stop {
    let [r, g, b] = colour.map(from_u8);
    Stop {
        height_m: at as f32,
        rgba: [r, g, b, opacity as f32],
    }
}

/// Stops that are one in f32 count as the last of them.
fn table(mut stops: Vec<Stop>, interpolation: TintInterpolation) -> Result<Tint, String> {
    stops.dedup_by(|here, before| {
        let same = here.height_m == before.height_m;
        if same {
            *before = *here;
        }
        same
    });
    let smooth = interpolation == TintInterpolation::Smooth;
    Tint::new(&stops, smooth).map_err(|e| e.to_string())
}
