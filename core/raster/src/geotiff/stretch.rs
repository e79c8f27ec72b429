//! The range of stored numbers that is shown as 0 to 1.

use crate::open::Stretch;

/// Kinds of stored numbers, as far as a stretch cares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Numbers {
    /// Integers of at most 8 bits.
    Bytes,
    /// Wider integers.
    Integers,
    /// Floats.
    Floats,
}

/// Shown range of samples that lie as `values` does (a sample of them, without nodata); `full` is
/// the range of their type. `None` to leave values as they are.
pub(crate) fn range(
    values: &mut [f64],
    stretch: Stretch,
    full: (f64, f64),
    numbers: Numbers,
) -> Option<(f64, f64)> {
    let stretch = match stretch {
        Stretch::Auto if numbers == Numbers::Bytes => return None,
        Stretch::Auto
            if numbers == Numbers::Floats && values.iter().all(|v| (0.0..=1.0).contains(v)) =>
        {
            return None;
        }
        Stretch::Auto => Stretch::Percentile {
            low: 2.0,
            high: 98.0,
        },
        given @ (Stretch::Full
        | Stretch::MinMax
        | Stretch::Percentile { .. }
        | Stretch::Range { .. }) => given,
    };
    let (low, high) = match stretch {
        Stretch::Auto | Stretch::Full => return None,
        Stretch::Range { low, high } => (low, high),
        Stretch::MinMax => percentiles(values, 0.0, 100.0)?,
        Stretch::Percentile { low, high } => percentiles(values, low, high)?,
    };
    if low.is_finite() && high.is_finite() && low != high {
        return Some((low, high));
    }
    // One value everywhere: shown as it lies in the type's range.
    Some(full)
}

fn percentiles(values: &mut [f64], low: f64, high: f64) -> Option<(f64, f64)> {
    let last = values.len().checked_sub(1)?;
    values.sort_unstable_by(f64::total_cmp);
    let at = |percent: f64| {
        values[(libm::round(percent.clamp(0.0, 100.0) / 100.0 * last as f64) as usize).min(last)]
    };
    Some((at(low), at(high)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_leave_out_the_extremes_and_full_leaves_all_as_it_is() {
        let mut values: Vec<f64> = (0..=100).rev().map(f64::from).collect();
        let full = (0.0, 65535.0);
        assert_eq!(
            range(&mut values, Stretch::Auto, full, Numbers::Integers),
            Some((2.0, 98.0))
        );
        assert_eq!(
            range(&mut values, Stretch::MinMax, full, Numbers::Integers),
            Some((0.0, 100.0))
        );
        assert_eq!(
            range(&mut values, Stretch::Full, full, Numbers::Integers),
            None
        );
        assert_eq!(
            range(&mut values, Stretch::Auto, full, Numbers::Bytes),
            None
        );
        assert_eq!(
            range(&mut [3.0, 3.0], Stretch::MinMax, full, Numbers::Integers),
            Some(full)
        );
        assert_eq!(
            range(&mut [], Stretch::MinMax, full, Numbers::Integers),
            None
        );
    }
}
