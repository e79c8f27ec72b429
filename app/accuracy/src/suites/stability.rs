//! Suite `stability`: extreme cases and stiff systems, each against an independent truth or a closed
//! form.

mod colours;
mod motion;
mod places;
mod relief;
mod solids;

use std::time::Instant;

use crate::{Content, Context, Figure, Report, Suite, SuiteError, Table};

/// The suite.
pub const SUITE: Suite = Suite {
    name: "stability",
    sentence: "How far off the formulas are at poles, on mountains, with stiff systems and beyond their ranges.",
    run,
};

/// One row of the table.
struct Case {
    /// What is extreme.
    name: &'static str,
    /// What it is compared with.
    truth: &'static str,
    /// What the error is given in.
    unit: &'static str,
    /// The error stays below this.
    limit: f64,
    /// What happens towards the extreme, and beyond it.
    degrades: &'static str,
    /// Finds the worst error.
    measure: fn(Extent) -> Found,
}

/// How much is tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Extent {
    /// A few seconds in all, for tests.
    Quick,
    /// Everything.
    Full,
}

impl Extent {
    /// One of two numbers.
    fn pick<T>(self, quick: T, full: T) -> T {
        match self {
            Self::Quick => quick,
            Self::Full => full,
        }
    }
}

/// Worst errors of a case.
#[derive(Clone, Copy, Debug, Default)]
struct Found {
    /// Of what the program does; NaN where something was no number.
    worst: f64,
    /// Of the textbook form that it replaces, where there is one.
    plain: Option<f64>,
}

impl Found {
    /// Without a textbook form.
    fn only(worst: f64) -> Self {
        Self { worst, plain: None }
    }
}

/// The larger of two errors, and NaN if one is: an error that is no number is the worst.
fn worse(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() {
        f64::NAN
    } else {
        a.max(b)
    }
}

/// The worst of some errors.
fn worst(errors: impl IntoIterator<Item = f64>) -> f64 {
    errors.into_iter().fold(0.0, worse)
}

fn cases() -> impl Iterator<Item = &'static Case> {
    [
        places::CASES,
        relief::CASES,
        colours::CASES,
        motion::CASES,
        solids::CASES,
    ]
    .into_iter()
    .flatten()
}

fn run(context: &Context) -> Result<Report, SuiteError> {
    let extent = if context.quick {
        Extent::Quick
    } else {
        Extent::Full
    };
    let count = cases().count();
    let mut rows = Vec::with_capacity(count);
    let mut beyond = Vec::new();
    for (done, case) in cases().enumerate() {
        context.step(done, count)?;
        let start = Instant::now();
        let found = (case.measure)(extent);
        let time_ms = start.elapsed().as_secs_f64() * 1e3;
        // An error that is no number counts as too large.
        if found.worst.is_nan() || found.worst > case.limit {
            beyond.push(case.name);
        }
        rows.push(vec![
            case.name.into(),
            case.unit.into(),
            found.worst.into(),
            case.limit.into(),
            found.plain.map_or_else(|| "".into(), Into::into),
            case.degrades.into(),
            case.truth.into(),
            time_ms.into(),
        ]);
    }
    let verdict = if beyond.is_empty() {
        format!("All {count} cases stay within their limits.")
    } else {
        format!("Beyond their limits: {}.", beyond.join("; "))
    };
    let head = [
        "case",
        "error in",
        "worst error",
        "limit",
        "worst error of the textbook form",
        "towards the extreme",
        "compared with",
        "time of the case, ms",
    ];
    let table = Table {
        head: head.map(str::to_owned).to_vec(),
        rows,
    };
    Ok(Report {
        summary: vec![
            verdict,
            "Where a textbook form is given, it is what the program would do without the method it has instead."
                .to_owned(),
        ],
        figures: vec![Figure::new(
            "stability",
            "Extreme cases and stiff systems",
            "Worst error of each case over all samples of it. The same cases are tests.",
            Content::Table(table),
        )],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_case_stays_within_its_limit() {
        for case in cases() {
            let found = (case.measure)(Extent::Quick);
            assert!(found.worst <= case.limit, "{}: {found:?}", case.name);
            assert!(case.limit.is_finite() && !case.degrades.is_empty());
        }
    }

    #[test]
    fn what_replaced_a_textbook_form_is_better_than_it() {
        for case in cases() {
            let found = (case.measure)(Extent::Quick);
            if let Some(plain) = found.plain {
                let is_better = plain.is_nan() || plain > 3.0 * found.worst;
                assert!(is_better, "{}: {found:?}", case.name);
            }
        }
    }
}
