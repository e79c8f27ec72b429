//! The suite `detail`: continued ground is rougher than thinned ground, and nearly as rough as the truth.

use relievo_accuracy::suites::detail::SUITE;
use relievo_accuracy::{Content, Context, DeviceWish};

#[test]
fn thinned_ground_that_is_continued_is_nearly_as_rough_as_it_was() {
    let mut context = Context::new(true, DeviceWish::Without, &|_| ());
    let project = concat!(env!("CARGO_MANIFEST_DIR"), "/../../projects/earth.relievo");
    context.project = Some(project.into());
    let report = (SUITE.run)(&context).unwrap();
    let spectra = report.figures.iter().find(|f| f.name == "spectra").unwrap();
    let Content::Chart(chart) = &spectra.content else {
        panic!("a chart was expected");
    };
    // From 76 m to 611 m the thinned heights, 652 m apart, know nothing.
    let off: Vec<f64> = chart.curves[..3]
        .iter()
        .map(|curve| {
            let known = curve.points.iter().filter(|p| (70.0..700.0).contains(&p.x));
            let off: Vec<f64> = known.map(|p| p.y.abs()).collect();
            assert_eq!(off.len(), 4);
            assert!(off.iter().all(|y| y.is_finite()), "{off:?}");
            off.into_iter().fold(0.0, f64::max)
        })
        .collect();
    assert!(off[0] > 10.0, "{off:?}");
    assert!(off[1] < 4.0 && off[2] < 4.0, "{off:?}");
}
