//! Times that can be compared: contestants take turns, and the middle counts.

use std::time::{Duration, Instant};

use crate::{Context, SuiteError};

/// Shortest time of one repetition, nanoseconds: what is faster runs several times in it.
const SHORTEST_NS: f64 = 2e6;

/// Runs in one repetition at most.
const MOST_RUNS: u32 = 1 << 20;

/// A time with its spread, in whatever unit it was asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// The middle of all repetitions.
    pub median: f64,
    /// A quarter of them is below.
    pub low: f64,
    /// A quarter of them is above.
    pub high: f64,
}

impl Spread {
    /// The spread of some times; `None` of none.
    pub fn of(mut times: Vec<f64>) -> Option<Self> {
        times.sort_by(f64::total_cmp);
        let at = |share: f64| times.get((share * (times.len() as f64 - 1.0)).round() as usize);
        Some(Self {
            median: *at(0.5)?,
            low: *at(0.25)?,
            high: *at(0.75)?,
        })
    }

    /// In another unit.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Self {
            median: self.median * factor,
            low: self.low * factor,
            high: self.high * factor,
        }
    }
}

/// What is timed: a call, and how many units (samples, vertices, frames) it makes.
pub struct Work<'a> {
    /// Units made by a call.
    pub units: f64,
    /// The call.
    pub call: Box<dyn FnMut() + 'a>,
}

impl core::fmt::Debug for Work<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Work")
            .field("units", &self.units)
            .finish_non_exhaustive()
    }
}

impl<'a> Work<'a> {
    /// Work that makes `units` a call. Results should go through [`core::hint::black_box`].
    pub fn new(units: f64, call: impl FnMut() + 'a) -> Self {
        Self {
            units,
            call: Box::new(call),
        }
    }

    fn time_ns(&mut self, runs: u32) -> f64 {
        let start = Instant::now();
        for _ in 0..runs {
            (self.call)();
        }
        start.elapsed().as_nanos() as f64 / f64::from(runs)
    }
}

/// Repetitions that are made however long they take.
const LEAST: usize = 3;

/// Time after which no further repetition begins: slow works are known to the same share by fewer.
const ENOUGH: Duration = Duration::from_secs(30);

/// Nanoseconds a unit of each work: the median of several repetitions (few in a quick run, and of works
/// that take long), one after the other of all works in turn, so that a machine that slows down slows
/// all of them.
///
/// # Errors
/// [`SuiteError::Cancelled`].
pub fn in_turns(context: &Context, works: &mut [Work]) -> Result<Vec<Spread>, SuiteError> {
    let repetitions = context.pick(LEAST, 15);
    let mut runs = Vec::new();
    for work in works.iter_mut() {
        context.go_on()?;
        // The first call also fills caches: its time is too long rather than too short.
        let once_ns = work.time_ns(1).max(1.0);
        runs.push(((SHORTEST_NS / once_ns) as u32).clamp(1, MOST_RUNS));
    }
    let mut times = vec![Vec::new(); works.len()];
    let started = Instant::now();
    for done in 0..repetitions {
        if done >= LEAST && started.elapsed() >= ENOUGH {
            break;
        }
        for ((work, runs), times) in works.iter_mut().zip(&runs).zip(&mut times) {
            context.go_on()?;
            times.push(work.time_ns(*runs) / work.units);
        }
    }
    // Every work has at least one repetition.
    Ok(times.into_iter().filter_map(Spread::of).collect())
}

#[cfg(test)]
mod tests {
    use core::cell::RefCell;

    use super::*;
    use crate::DeviceWish;

    #[test]
    fn works_take_turns_and_each_gets_a_time() {
        let log = RefCell::new(String::new());
        let work = |name: char| {
            let log = &log;
            Work::new(1.0, move || {
                let mut log = log.borrow_mut();
                // Runs of one repetition count once.
                if !log.ends_with(name) {
                    log.push(name);
                }
            })
        };
        let context = Context::new(true, DeviceWish::Without, &|_| ());
        let times = in_turns(&context, &mut [work('a'), work('b')]).unwrap();
        assert_eq!(times.len(), 2);
        assert_eq!(*log.borrow(), "abababab");
    }

    #[test]
    fn the_spread_of_times_is_their_middle_half() {
        let spread = Spread::of(vec![5.0, 1.0, 4.0, 2.0, 3.0]).unwrap();
        assert_eq!((spread.low, spread.median, spread.high), (2.0, 3.0, 4.0));
        assert_eq!(Spread::of(Vec::new()), None);
    }

    #[test]
    fn a_cancelled_measurement_ends() {
        let context = Context::new(true, DeviceWish::Without, &|_| ());
        context.cancel.cancel();
        let result = in_turns(&context, &mut [Work::new(1.0, || ())]);
        assert_eq!(result, Err(SuiteError::Cancelled));
    }
}
