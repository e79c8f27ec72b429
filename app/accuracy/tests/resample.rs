//! The suite `resample`: its errors.

use relievo_accuracy::suites::resample::SUITE;
use relievo_accuracy::{Chart, Content, Context, DeviceWish};

#[test]
fn kernels_places_and_poles_are_as_exact_as_they_state() {
    let report = (SUITE.run)(&Context::new(true, DeviceWish::Without, &|_| ())).unwrap();
    let chart = |name: &str| -> &Chart {
        let figure = report.figures.iter().find(|f| f.name == name).unwrap();
        let Content::Chart(chart) = &figure.content else {
            panic!("{name} is a chart")
        };
        chart
    };
    let errors = |figure: &str, curve: &str| -> Vec<f64> {
        let curve = chart(figure).curves.iter().find(|c| c.name == curve);
        curve.unwrap().points.iter().map(|p| p.y).collect()
    };
    // Kernels: each is better than the one before by far; settings are exact, 0.002, 0.02, ... pixels.
    let [nearest, bilinear, bicubic] =
        ["nearest", "bilinear", "bicubic"].map(|kernel| errors("kernels", kernel));
    assert!(nearest[2] > 3.0 * bilinear[2] && bilinear[2] > 3.0 * bicubic[2]);
    assert!(bicubic[2] < 0.01, "{bicubic:?}");
    // What is shown with loses next to nothing by interpolating places; ten times as much does.
    for exactly in [&nearest, &bilinear, &bicubic] {
        assert!(exactly[2] < 1.1 * exactly[0], "{exactly:?}");
    }
    // Places keep their tolerance.
    let places = errors("places", "interpolated along lines and parabolas");
    for (found, tolerance) in places.iter().zip([1e-4, 0.002, 0.02, 0.125, 0.5]) {
        assert!(*found <= tolerance + 3e-5, "{places:?}");
    }
    assert!(places[4] > places[0], "{places:?}");
    // About a pole a kernel that may not widen along rows is wrong; the one that is shown with is not.
    let poles = errors("poles", "kernel round on the ground");
    assert!(poles[4] < 0.05 && poles[0] > 2.0 * poles[4], "{poles:?}");
    assert!(report.summary[1].contains("GDAL"));
}
