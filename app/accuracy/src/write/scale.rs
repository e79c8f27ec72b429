//! From values to places along an axis.

use crate::{Axis, number};

/// Ticks of an axis at most, about.
const MOST_TICKS: f64 = 8.0;

/// Room beyond the outermost points, as a part of the axis.
const MARGIN: f64 = 0.06;

/// An axis over some values. Places are values, or their decadic logarithms.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Scale {
    /// Place of the axis' beginning.
    pub(super) low: f64,
    /// Place of its end.
    pub(super) high: f64,
    /// Places of the ticks.
    pub(super) ticks: Vec<f64>,
    log: bool,
    /// Where a logarithmic axis shows values of zero and below, if there are any.
    zero: Option<f64>,
}

impl Scale {
    pub(super) fn new(axis: &Axis, values: impl Iterator<Item = f64>) -> Self {
        let values: Vec<f64> = values.filter(|v| v.is_finite()).collect();
        let shown = |v: &&f64| !axis.log || **v > 0.0;
        let places = values
            .iter()
            .filter(shown)
            .map(|v| if axis.log { libm::log10(*v) } else { *v });
        let (mut low, mut high) = places
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
                (low.min(p), high.max(p))
            });
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        let zero = (axis.log && values.iter().any(|v| *v <= 0.0)).then_some(low - 1.0);
        low = zero.unwrap_or(low);
        // A single value gets room on both sides.
        let least = if axis.log {
            0.3
        } else {
            high.abs().max(1.0) * 0.1
        };
        let margin = ((high - low) * MARGIN).max((least - (high - low)) * 0.5);
        (low, high) = (low - margin, high + margin);
        let mut ticks = if axis.log {
            decades(low, high)
        } else {
            round_steps(low, high)
        };
        if let Some(zero) = zero {
            ticks.retain(|tick| *tick > zero + 0.5);
            ticks.insert(0, zero);
        }
        Self {
            low,
            high,
            ticks,
            log: axis.log,
            zero,
        }
    }

    /// Place of a value; `None` where it has none.
    pub(super) fn place(&self, value: f64) -> Option<f64> {
        match value {
            v if !v.is_finite() => None,
            v if !self.log => Some(v),
            v if v > 0.0 => Some(libm::log10(v)),
            _ => self.zero,
        }
    }

    /// What stands at a tick.
    pub(super) fn label(&self, tick: f64) -> String {
        if self.zero == Some(tick) {
            return "0".to_owned();
        }
        if !self.log {
            return number::text(tick);
        }
        let whole = libm::round(tick);
        if (tick - whole).abs() < 1e-9 && !(-2.0..5.0).contains(&whole) {
            return number::power_of_ten(whole as i32);
        }
        number::text(libm::pow(10.0, tick))
    }
}

/// Powers of ten, and 2 and 5 times them where there is room.
fn decades(low: f64, high: f64) -> Vec<f64> {
    let (first, last) = (libm::ceil(low) as i32, libm::floor(high) as i32);
    let step = libm::ceil(f64::from(last - first + 1) / MOST_TICKS).max(1.0) as usize;
    if last - first >= 2 {
        return (first..=last).step_by(step).map(f64::from).collect();
    }
    let all: &[f64] = if high - low < 0.7 {
        &[1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0]
    } else {
        &[1.0, 2.0, 5.0]
    };
    let places = (first - 1..=last).flat_map(|power| {
        all.iter()
            .map(move |part| f64::from(power) + libm::log10(*part))
    });
    places.filter(|p| (low..=high).contains(p)).collect()
}

/// Multiples of 1, 2 or 5 times a power of ten.
fn round_steps(low: f64, high: f64) -> Vec<f64> {
    let rough = (high - low) / MOST_TICKS;
    let power = libm::pow(10.0, libm::floor(libm::log10(rough)));
    let step = [1.0, 2.0, 5.0, 10.0]
        .map(|part| part * power)
        .into_iter()
        .find(|step| *step >= rough)
        .unwrap_or(rough);
    let first = libm::ceil(low / step) as i64;
    let last = libm::floor(high / step) as i64;
    (first..=last).map(|k| k as f64 * step).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn zero_has_a_place_below_everything_else_on_a_logarithmic_axis() {
        let scale = Scale::new(&Axis::log("error", "m"), [0.0, 1e-7, 1e-3].into_iter());
        let zero = scale.place(0.0).unwrap();
        assert!(zero < scale.place(1e-7).unwrap() && zero > scale.low);
        assert_eq!(scale.label(zero), "0");
        assert_eq!(scale.label(-7.0), "10⁻⁷");
        assert_eq!(scale.place(f64::NAN), None);
    }

    proptest! {
        #[test]
        fn every_value_lies_between_the_ends_and_there_are_a_few_ticks(
            values in prop::collection::vec(1e-12..1e12_f64, 1..20), log: bool,
        ) {
            let axis = Axis { log, ..Axis::log("", "") };
            let scale = Scale::new(&axis, values.iter().copied());
            for value in values {
                let place = scale.place(value).unwrap();
                prop_assert!(scale.low < place && place < scale.high);
            }
            prop_assert!((2..=24).contains(&scale.ticks.len()), "{:?}", scale);
            prop_assert!(scale.ticks.iter().all(|t| (scale.low..=scale.high).contains(t)));
        }
    }
}
