//! The suite `transform`: its errors, on the processor and on a device.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use relievo_accuracy::suites::transform::SUITE;
use relievo_accuracy::{Chart, Content, Context, DeviceWish, Report};

fn report(device: DeviceWish) -> Report {
    (SUITE.run)(&Context::new(true, device, &|_| ())).unwrap()
}

fn chart<'a>(report: &'a Report, name: &str) -> &'a Chart {
    let figure = report.figures.iter().find(|f| f.name == name).unwrap();
    let Content::Chart(chart) = &figure.content else {
        panic!("{name} is a chart")
    };
    chart
}

/// Errors of a form's points, in the order of its settings.
fn errors(chart: &Chart, form: &str) -> Vec<f64> {
    let curve = chart.curves.iter().find(|c| c.name == form).unwrap();
    curve.points.iter().map(|p| p.y).collect()
}

/// What holds on the processor and on every device.
fn assert_what_is_drawn_with_is_exact(chart: &Chart, bound: f64) {
    let drawn = errors(chart, "cancellation-free, polynomial");
    assert!(drawn.iter().all(|e| *e > 0.0 && *e <= bound), "{drawn:?}");
    // The thousandth that is printed for the approximation holds eastward only: towards a pole its second
    // order counts, eight times as much where it is meant to be used.
    let approximate = errors(chart, "[CH06] eq. 11 and 14");
    assert!((2e-3..1e-2).contains(&approximate[0]), "{approximate:?}");
    assert!(chart.marks_front);
    let finite = |p: &relievo_accuracy::Point| p.x > 0.0 && p.x.is_finite();
    assert!(chart.curves.iter().flat_map(|c| &c.points).all(finite));
}

#[test]
fn on_the_processor_the_form_without_cancellation_is_a_thousand_times_as_exact_as_those_printed() {
    let report = report(DeviceWish::Without);
    let cpu = chart(&report, "cpu");
    assert_what_is_drawn_with_is_exact(cpu, 6e-7);
    let everywhere = errors(chart(&report, "cpu-all"), "cancellation-free, polynomial");
    assert!(everywhere[0] <= 6e-7, "{everywhere:?}");
    let drawn = errors(cpu, "cancellation-free, polynomial");
    for form in ["[CH06] eq. 4", "[CH06] eq. 4, polynomial", "[CH06] blended"] {
        let printed = errors(cpu, form);
        assert!(printed[0] > 1000.0 * drawn[0], "{form}: {printed:?}");
    }
    // Half a metre that no level makes smaller.
    let printed = errors(chart(&report, "level-metres"), "[CH06] eq. 4");
    assert!(
        printed.iter().all(|e| (0.2..30.0).contains(e)),
        "{printed:?}"
    );
    // At a pole the approximation is no number, which is told and not drawn.
    let by_colatitude = errors(chart(&report, "colatitude"), "[CH06] eq. 11 and 14");
    assert!(!by_colatitude[0].is_finite() && by_colatitude[6].is_finite());
    let told = report.summary.last().unwrap();
    assert!(told.contains("Nothing was measured on a graphics device"));
}

#[test]
fn two_runs_find_the_same_errors() {
    let [a, b] = [(); 2].map(|()| report(DeviceWish::Without));
    for name in ["level-metres", "level-parts", "colatitude"] {
        // Through text, for NaN is never equal.
        assert_eq!(
            format!("{:?}", chart(&a, name)),
            format!("{:?}", chart(&b, name))
        );
    }
}

mod on_device {
    use super::*;

    #[test]
    fn on_the_device_too_the_form_that_is_drawn_with_is_exact_to_a_millionth_of_the_ring() {
        let report = report(DeviceWish::IfAny);
        assert_what_is_drawn_with_is_exact(chart(&report, "device"), 1e-6);
    }
}
