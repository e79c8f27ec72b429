//! One answer for a place, however and wherever it is asked for.

use glam::DVec2;
use relievo_earthwork::{Design, Frame, Outcome, Samples, Section, Side};
use relievo_planet::{MapPoint, Planet};

use crate::common::{alps, at, corridor, platform, shaped, square};
use crate::mixed;

#[test]
fn a_grid_its_parts_and_single_places_agree_to_the_bit() {
    let frame = alps();
    let design = Design::new(Planet::EARTH, mixed(&frame));
    let origin = frame.origin();
    let step = 5.3e-7;
    let lon: Vec<f64> = (0..90)
        .map(|i| origin.lon_rad + (f64::from(i) - 45.0) * step * 1.4)
        .collect();
    let colat: Vec<f64> = (0..80)
        .map(|i| origin.colat_rad + (f64::from(i) - 40.0) * step)
        .collect();
    for spacing_m in [0.0, 2.0, 12.0] {
        let ground = |i: usize, k: usize| ((i * 7 + k * 13) % 29) as f64 * 0.3 - 2.0;
        let run = |columns: core::ops::Range<usize>, rows: core::ops::Range<usize>| {
            let mut out: Vec<Outcome> = rows
                .clone()
                .flat_map(|k| columns.clone().map(move |i| (i, k)))
                .map(|(i, k)| Outcome {
                    height_m: ground(i, k),
                    by: None,
                })
                .collect();
            let samples = Samples::Map {
                lon_rad: &lon[columns],
                colat_rad: &colat[rows],
            };
            design.outcomes(&samples, spacing_m, &mut out);
            out
        };
        let whole = run(0..90, 0..80);
        let changed = whole.iter().filter(|o| o.by.is_some()).count();
        assert!(changed > 3000, "{changed}");
        let part = run(31..77, 5..64);
        for (k, row) in part.chunks(46).enumerate() {
            for (i, o) in row.iter().enumerate() {
                let w = whole[(k + 5) * 90 + i + 31];
                assert_eq!(
                    (o.height_m.to_bits(), o.by),
                    (w.height_m.to_bits(), w.by),
                    "{i} {k}"
                );
            }
        }
        let places: Vec<MapPoint> = colat
            .iter()
            .flat_map(|c| lon.iter().map(move |l| MapPoint::new(*l, *c)))
            .collect();
        let mut out: Vec<Outcome> = (0..80)
            .flat_map(|k| (0..90).map(move |i| (i, k)))
            .map(|(i, k)| Outcome {
                height_m: ground(i, k),
                by: None,
            })
            .collect();
        design.outcomes(
            &Samples::Places {
                places: &places,
                width: 90,
            },
            spacing_m,
            &mut out,
        );
        assert!(
            out == whole,
            "places in rows give what rows and columns give"
        );
        if spacing_m == 0.0 {
            for k in (0..7200).step_by(61) {
                let o = design.height(places[k], ground(k % 90, k / 90));
                assert_eq!(o, whole[k], "{k}");
            }
        }
    }
}

#[test]
fn the_same_element_is_the_same_at_the_antimeridian_and_at_the_poles() {
    let heights = |lon: f64, lat: f64| -> Vec<f64> {
        let frame = Frame::new(Planet::EARTH, MapPoint::from_degrees(lon, lat));
        let design = Design::new(Planet::EARTH, mixed(&frame));
        (0..400)
            .map(|k| {
                let p = DVec2::new(f64::from(k % 20) - 10.0, f64::from(k / 20) - 10.0) * 15.3;
                at(&design, &frame, p.x, p.y, 1.0).height_m
            })
            .collect()
    };
    // Frames of parts are turned against each other near a pole, so not to the last digit.
    let here = heights(11.4, 47.2);
    for (lon, lat) in [
        (180.0, 47.2),
        (-180.0, -10.0),
        (33.0, 90.0),
        (0.0, -90.0),
        (120.0, 89.9995),
    ] {
        for (k, (a, b)) in here.iter().zip(heights(lon, lat)).enumerate() {
            // A plane's aspect turns with the meridians.
            assert!(
                (a - b).abs() < 2e-3 || lat.abs() > 80.0,
                "{lon} {lat} {k}: {a} {b}"
            );
        }
    }
    let pad = |lon: f64, lat: f64| {
        let frame = Frame::new(Planet::EARTH, MapPoint::from_degrees(lon, lat));
        let design = Design::new(
            Planet::EARTH,
            vec![shaped(&frame, platform(&frame, &square(30.0), 9.0))],
        );
        (0..=40)
            .map(|k| {
                at(
                    &design,
                    &frame,
                    f64::from(k) * 2.0 - 40.0,
                    33.0 - f64::from(k % 7),
                    0.0,
                )
                .height_m
            })
            .collect::<Vec<f64>>()
    };
    for (lon, lat) in [(180.0, 0.0), (77.0, 90.0), (0.0, -90.0), (5.0, 89.9999)] {
        for (a, b) in pad(0.0, 50.0).iter().zip(pad(lon, lat)) {
            assert!((a - b).abs() < 1e-4, "{lon} {lat}: {a} {b}");
        }
    }
}

#[test]
fn a_road_finer_than_the_samples_is_no_row_of_dashes() {
    let frame = alps();
    let section = Section::Road {
        width_m: 10.0,
        crossfall_percent: 0.0,
    };
    let line: Vec<(f64, f64, f64)> = vec![(-4000.0, -900.0, 3.0), (4000.0, 1100.0, 3.0)];
    let design = Design::new(
        Planet::EARTH,
        vec![shaped(
            &frame,
            corridor(&frame, &line, section, Side::default()),
        )],
    );
    let exact = 8246.2 * (10.0 * 3.0 + 9.0 / 0.5);
    for spacing in [20.0, 60.0, 150.0] {
        let side = (9000.0 / spacing) as usize;
        let places: Vec<MapPoint> = (0..side * side)
            .map(|k| {
                let p = DVec2::new((k % side) as f64 + 0.5, (k / side) as f64 + 0.5) * spacing;
                frame.to_map(p - 4500.0)
            })
            .collect();
        let mut out = vec![
            Outcome {
                height_m: 0.0,
                by: None
            };
            side * side
        ];
        design.outcomes(
            &Samples::Places {
                places: &places,
                width: side,
            },
            spacing,
            &mut out,
        );
        let volume: f64 = out.iter().map(|o| o.height_m).sum::<f64>() * spacing * spacing;
        assert!(
            (volume / exact - 1.0).abs() < 0.06,
            "{spacing}: {volume} of {exact}"
        );
        // Every column that the road passes holds about as much of it.
        for i in side / 10..side * 9 / 10 {
            let column: f64 = (0..side).map(|k| out[k * side + i].height_m).sum::<f64>() * spacing;
            let mean = 48.0 * 8246.2 / 8000.0;
            assert!(
                (column / mean - 1.0).abs() < 0.25,
                "{spacing} {i}: {column} {mean}"
            );
        }
    }
}
