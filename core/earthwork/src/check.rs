//! Numbers that users typed, brought into range.

use core::ops::RangeInclusive;

use relievo_planet::{MapPoint, Planet};

use crate::element::{Section, Side};
use crate::frame::Frame;
use crate::warning::{WarningKind, Warnings};

/// Heights that are possible, metres.
pub(crate) const HEIGHTS_M: RangeInclusive<f64> = -1e7..=1e7;

/// Widths and depths that are possible, metres.
const WIDTHS_M: RangeInclusive<f64> = 0.01..=100_000.0;

/// A number in range: the nearest possible, `default` in place of what is none.
pub(crate) fn number(
    value: f64,
    range: &RangeInclusive<f64>,
    default: f64,
    warnings: &mut Warnings,
) -> f64 {
    if value.is_nan() {
        warnings.add(WarningKind::NotANumber, None);
        return default;
    }
    if !range.contains(&value) {
        warnings.add(WarningKind::OutOfRange, None);
    }
    value.clamp(*range.start(), *range.end())
}

/// A vertex's height; what is no number is missing.
pub(crate) fn height(value: Option<f64>, warnings: &mut Warnings) -> Option<f64> {
    let value = value?;
    if value.is_finite() {
        Some(number(value, &HEIGHTS_M, 0.0, warnings))
    } else {
        warnings.add(WarningKind::NotANumber, None);
        None
    }
}

/// Whether a place can be used.
pub(crate) fn place(place: MapPoint, warnings: &mut Warnings) -> bool {
    // Far outside of a turn nothing is left of a coordinate's digits.
    let good = place.lon_rad.abs() < 1e6 && place.colat_rad.abs() < 1e6;
    if !good {
        warnings.add(WarningKind::NotANumber, None);
    }
    good
}

pub(crate) fn side(side: &Side, warnings: &mut Warnings) -> Side {
    let default = Side::default();
    let mut slope = |v, d| number(v, &Side::SLOPES, d, warnings);
    let (cut_slope, fill_slope) = (
        slope(side.cut_slope, default.cut_slope),
        slope(side.fill_slope, default.fill_slope),
    );
    let reaches = 0.0..=Side::LARGEST_REACH_M;
    Side {
        cut_slope,
        fill_slope,
        wall: side.wall,
        max_reach_m: number(side.max_reach_m, &reaches, default.max_reach_m, warnings),
    }
}

pub(crate) fn section(section: &Section, warnings: &mut Warnings) -> Section {
    let mut width = |v| number(v, &WIDTHS_M, 1.0, warnings);
    match *section {
        Section::Road {
            width_m,
            crossfall_percent,
        } => Section::Road {
            width_m: width(width_m),
            crossfall_percent: number(crossfall_percent, &(-100.0..=100.0), 0.0, warnings),
        },
        Section::Dam { crest_width_m } => Section::Dam {
            crest_width_m: width(crest_width_m),
        },
        Section::Trench {
            bottom_width_m,
            depth_m,
        } => Section::Trench {
            bottom_width_m: width(bottom_width_m),
            depth_m: number(depth_m, &(0.0..=100_000.0), 1.0, warnings),
        },
        Section::Channel {
            bottom_width_m,
            depth_m,
            bank_slope,
        } => Section::Channel {
            bottom_width_m: width(bottom_width_m),
            depth_m: number(depth_m, &(0.0..=1000.0), 1.0, warnings),
            bank_slope: number(bank_slope, &Side::SLOPES, 0.5, warnings),
        },
    }
}

/// A frame in the middle of places; `None` if there is none.
pub(crate) fn frame_amid(planet: Planet, places: impl Iterator<Item = MapPoint>) -> Option<Frame> {
    let mut first = None;
    let mut sum = glam::DVec3::ZERO;
    for p in places {
        first = first.or(Some(p));
        sum += p.to_unit();
    }
    let first = first?;
    let middle = if sum.length() > 1e-6 {
        MapPoint::from_direction(sum)
    } else {
        first
    };
    Some(Frame::new(planet, middle))
}
