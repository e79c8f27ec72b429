//! The suite `planning`: its errors.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use relievo_accuracy::suites::planning::SUITE;
use relievo_accuracy::{Chart, Content, Context, DeviceWish, Report};

fn chart<'a>(report: &'a Report, name: &str) -> &'a Chart {
    let figure = report.figures.iter().find(|f| f.name == name).unwrap();
    let Content::Chart(chart) = &figure.content else {
        panic!("a chart")
    };
    chart
}

/// The error of a setting of a curve.
fn error(chart: &Chart, curve: &str, setting: &str) -> f64 {
    let curve = chart
        .curves
        .iter()
        .find(|c| c.name.contains(curve))
        .unwrap();
    let point = curve
        .points
        .iter()
        .find(|p| p.setting.contains(setting))
        .unwrap();
    point.y
}

#[test]
fn covered_area_beats_centres_solvers_agree_and_volumes_converge() {
    let report = (SUITE.run)(&Context::new(true, DeviceWish::Without, &|_| ())).unwrap();

    let road = chart(&report, "road");
    let of = |method: &str| error(road, "16 m", method);
    assert!(of("as tiles") > 0.0 && of("as tiles") < 0.8 * of("at the centre"));
    for element in ["platform", "tin", "road"] {
        let chart = chart(&report, element);
        let (centre, four) = (
            error(chart, " 2 m", "centre"),
            error(chart, " 2 m", "4 × 4"),
        );
        assert!(four < 0.5 * centre, "{element}: {four} {centre}");
    }

    let infill = chart(&report, "infill-height");
    assert!(error(infill, "direct", "solved") < 1e-12);
    assert!(error(infill, "multigrid", "12 V-cycles") < 1e-8);
    assert!(error(infill, "conjugate", "128 steps") < 1e-6);
    assert!(error(infill, "Gauss-Seidel", "256 sweeps") < 1.0);

    let volume = chart(&report, "volume-samples");
    for case in ["platform on a cone, one", "dam across a valley, one"] {
        let order = libm::log2(error(volume, case, " 4 m") / error(volume, case, " 1 m")) / 2.0;
        assert!(order > 1.5, "{case}: {order}");
    }
    let stated = chart(&report, "volume-stated");
    for curve in &stated.curves {
        for point in &curve.points {
            assert!(point.y <= point.x + 1e-6, "{}: {point:?}", curve.name);
        }
    }
}
