//! The suites about pictures, small: what the clipmaps show is what the reference says.
//!
//! They need a graphics adapter; a software one will do.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use relievo_accuracy::suites::{colour, convergence, geometry, quality};
use relievo_accuracy::{Cell, Content, Context, DeviceWish, Report, Suite, Table};

fn report(suite: Suite) -> Report {
    (suite.run)(&Context::new(true, DeviceWish::IfAny, &|_| ())).unwrap()
}

fn table<'a>(report: &'a Report, name: &str) -> &'a Table {
    let figure = report.figures.iter().find(|f| f.name == name).unwrap();
    let Content::Table(table) = &figure.content else {
        panic!("{name} is a table")
    };
    table
}

/// Numbers of a column, for the rows whose words `of` accepts.
fn column(table: &Table, head: &str, of: impl Fn(&[Cell]) -> bool) -> Vec<f64> {
    let at = table.head.iter().position(|h| h == head).unwrap();
    let rows = table.rows.iter().filter(|row| of(row));
    rows.map(|row| match &row[at] {
        Cell::Number(number) => *number,
        Cell::Text(text) => panic!("{head}: {text}"),
    })
    .collect()
}

#[test]
fn without_an_adapter_the_suites_say_what_is_missing() {
    for suite in [
        colour::SUITE,
        geometry::SUITE,
        quality::SUITE,
        convergence::SUITE,
    ] {
        let context = Context::new(true, DeviceWish::Without, &|_| ());
        let report = (suite.run)(&context).unwrap();
        assert!(
            report.summary[0].contains("no graphics device"),
            "{report:?}"
        );
    }
}

mod on_device {
    use super::*;

    #[test]
    fn the_clipmaps_show_the_colours_of_the_reference() {
        let report = report(colour::SUITE);
        let table = table(&report, "table");
        assert_eq!(
            table.rows.len(),
            8,
            "two views, two windows, two numbers of taps"
        );
        let with = |window: f64, taps: f64| {
            move |row: &[Cell]| row[1] == Cell::Number(window) && row[2] == Cell::Number(taps)
        };
        let sharp = column(table, "mean ΔE00", with(1024.0, 8.0));
        let coarse = column(table, "mean ΔE00", with(256.0, 1.0));
        for (sharp, coarse) in sharp.iter().zip(&coarse) {
            assert!(*sharp < 2.0 && *sharp <= coarse + 0.1, "{sharp} {coarse}");
        }
        let alike = column(table, "SSIM of L*", with(1024.0, 8.0));
        assert!(alike.iter().all(|s| *s > 0.9), "{alike:?}");
        // The truth is sure of itself.
        let confirmed = column(table, "truth, halved spacing, mean of 1", |_| true);
        assert!(confirmed.iter().all(|c| *c < 0.01), "{confirmed:?}");
        assert!(
            report
                .figures
                .iter()
                .any(|f| matches!(f.content, Content::Picture(_)))
        );
    }

    #[test]
    fn the_clipmaps_show_the_ground_where_the_reference_has_it() {
        let report = report(geometry::SUITE);
        let table = table(&report, "table");
        let mesh = |name: &'static str| move |row: &[Cell]| row[1] == Cell::from(name);
        let fine = column(table, "mean error, px", mesh("512 × 40"));
        let coarse = column(table, "mean error, px", mesh("64 × 8"));
        assert_eq!((fine.len(), coarse.len()), (2, 2));
        for (fine, coarse) in fine.iter().zip(&coarse) {
            assert!(
                *fine > 0.0 && *fine < 0.3 && fine < coarse,
                "{fine} {coarse}"
            );
        }
        let sparse = column(table, "distortion, px", mesh("64 × 8"));
        let dense = column(table, "distortion, px", mesh("512 × 40"));
        assert!(
            dense.iter().zip(&sparse).all(|(d, s)| d < s),
            "{dense:?} {sparse:?}"
        );
    }

    #[test]
    fn the_front_of_quality_is_one_that_the_studio_reads_and_finer_settings_are_truer() {
        let report = report(quality::SUITE);
        let table = table(&report, "front");
        let mut text = table.head.join(",");
        for row in &table.rows {
            let cells = row.iter().map(|cell| match cell {
                Cell::Number(number) => number.to_string(),
                Cell::Text(text) => panic!("{text}"),
            });
            text = text + "\n" + &cells.collect::<Vec<_>>().join(",");
        }
        let front = relievo_gpu::Front::parse(&text).unwrap();
        // Times differ from run to run; errors do not: the coarsest is worst whatever it costs.
        let trade = report.figures.iter().find(|f| f.name == "trade").unwrap();
        let Content::Chart(trade) = &trade.content else {
            panic!("trade is a chart")
        };
        // Those that are offered and the others.
        let all: Vec<_> = trade.curves.iter().flat_map(|c| &c.points).collect();
        assert_eq!(all.len(), 6, "three meshes with two numbers of taps");
        let error = |setting: &str| {
            let point = all.iter().find(|p| p.setting.starts_with(setting)).unwrap();
            point.y
        };
        for mesh in ["64 × 8", "192 × 20", "512 × 40"] {
            let (blurred, sharp) = (
                error(&format!("{mesh}, 1 taps")),
                error(&format!("{mesh}, 8 taps")),
            );
            assert!(
                blurred > 2.0 * sharp && sharp > 0.0,
                "{mesh}: {blurred} {sharp}"
            );
        }
        assert!(
            error("64 × 8, 8 taps") > 1.2 * error("512 × 40, 8 taps"),
            "{all:?}"
        );
        let truest = all.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
        assert_eq!(
            front.points().last().unwrap().error_px,
            truest,
            "the truest is kept"
        );
    }

    #[test]
    fn after_a_jump_the_picture_becomes_the_converged_one() {
        let report = report(convergence::SUITE);
        let table = table(&report, "jump-table");
        assert!(
            table
                .rows
                .iter()
                .all(|row| row.contains(&Cell::from("yes")))
        );
        let last = column(table, "error of the last frame, ΔE00", |_| true);
        assert!(last.iter().all(|e| *e < 0.05), "{last:?}");
    }
}
