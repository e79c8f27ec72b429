//! The suite `noise`: its errors.

use relievo_accuracy::suites::noise::SUITE;
use relievo_accuracy::{Cell, Content, Context, DeviceWish};

#[test]
fn the_spectrum_keeps_the_stated_power_law_the_better_the_closer_the_bands() {
    let report = (SUITE.run)(&Context::new(true, DeviceWish::Without, &|_| ())).unwrap();
    let figure = report.figures.iter().find(|f| f.name == "table").unwrap();
    let Content::Table(table) = &figure.content else {
        panic!("a table")
    };
    let number = |cell: &Cell| match cell {
        Cell::Number(value) => *value,
        Cell::Text(text) => panic!("a number, not {text}"),
    };
    for families in table.rows.chunks(7) {
        let deviations: Vec<f64> = families.iter().map(|row| number(&row[5])).collect();
        let name = &families[0][0];
        for row in families.iter().filter(|row| number(&row[1]) <= 2.0) {
            let (stated, fitted) = (number(&row[3]), number(&row[4]));
            assert!((stated - fitted).abs() < 0.3, "{row:?}");
        }
        // Lacunarities up to 2, and of 4.
        let close = deviations[..4]
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min);
        assert!(close < 0.8, "{name:?}: {deviations:?}");
        assert!(deviations[6] > 2.0 * close, "{name:?}: {deviations:?}");
    }
}
