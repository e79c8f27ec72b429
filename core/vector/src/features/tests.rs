use core::f64::consts::{FRAC_PI_2, PI, TAU};
use core::ops::ControlFlow;

use proptest::prelude::*;

use super::*;

fn polygon(rings: &[&[[f64; 2]]]) -> Features {
    let mut b = Builder::degrees();
    for (i, ring) in rings.iter().enumerate() {
        b.ring(ring.iter().copied(), i > 0).unwrap();
    }
    b.finish().unwrap()
}

/// Whether a place in degrees lies inside.
fn is_inside(features: &Features, lon_deg: f64, lat_deg: f64) -> bool {
    let p = DVec2::new(lon_deg, lat_deg).map(f64::to_radians);
    let here = Bounds { min: p, max: p };
    let mut winding = 0;
    for hit in features.hits(&here) {
        let at = p - DVec2::new(f64::from(hit.turns) * TAU, 0.0);
        winding += features.winding(features.part(hit.part), at);
    }
    winding != 0
}

#[test]
fn a_polygon_across_the_antimeridian_has_its_inside_there() {
    for ring in [
        [[170.0, 40.0], [-170.0, 40.0], [-170.0, 50.0], [170.0, 50.0]],
        [[170.0, 40.0], [190.0, 40.0], [190.0, 50.0], [170.0, 50.0]],
        [[-170.0, 50.0], [170.0, 50.0], [170.0, 40.0], [-170.0, 40.0]],
    ] {
        let features = polygon(&[&ring]);
        for lon in [175.0, 180.0, -180.0, -175.0, 535.0] {
            assert!(is_inside(&features, lon, 45.0), "{lon}");
        }
        for lon in [165.0, -165.0, 0.0] {
            assert!(!is_inside(&features, lon, 45.0), "{lon}");
        }
    }
}

#[test]
fn a_ring_around_a_pole_has_the_pole_inside() {
    let north = [[45.0, 40.0], [135.0, 40.0], [-135.0, 40.0], [-45.0, 40.0]];
    let mut backwards = north;
    backwards.reverse();
    for ring in [north, backwards] {
        let features = polygon(&[&ring]);
        for lon in [-179.0, -45.0, 0.0, 45.0, 100.0, 180.0] {
            assert!(is_inside(&features, lon, 41.0) && is_inside(&features, lon, 89.9));
            assert!(!is_inside(&features, lon, 39.0) && !is_inside(&features, lon, -89.0));
        }
        let south = polygon(&[&ring.map(|[lon, lat]| [lon, -lat])]);
        assert!(is_inside(&south, 77.0, -89.9) && !is_inside(&south, 77.0, 89.0));
    }
}

#[test]
fn a_hole_around_the_pole_leaves_a_band() {
    let ring = |lat: f64| [45.0, 135.0, 225.0, 315.0].map(|lon| [lon, lat]);
    let features = polygon(&[&ring(40.0), &ring(70.0)]);
    for lon in [-170.0, 0.0, 46.0] {
        assert!(is_inside(&features, lon, 55.0));
        assert!(!is_inside(&features, lon, 80.0) && !is_inside(&features, lon, 30.0));
    }
}

#[test]
fn the_corners_of_a_map_of_the_world_do_not_wrap() {
    let features = polygon(&[&[[-180.0, 40.0], [180.0, 40.0], [180.0, 50.0], [-180.0, 50.0]]]);
    for lon in [-179.0, 0.0, 100.0] {
        assert!(is_inside(&features, lon, 45.0) && !is_inside(&features, lon, 55.0));
    }
}

#[test]
fn places_in_a_polar_projection_enclose_the_pole_that_they_do_there() {
    let crs = relievo_raster::crs::Crs::parse("EPSG:3031").unwrap();
    let mut b = Builder::new(
        Some(crs),
        Limits::default(),
        relievo_raster::Cancel::default(),
    );
    let r = 1e7;
    // Reaches beyond the equator: only the plane knows which side is inside.
    b.ring([[r, r], [-r, r], [-r, -r], [r, -r]], false).unwrap();
    let features = b.finish().unwrap();
    assert!(is_inside(&features, 10.0, -89.0) && !is_inside(&features, 10.0, 80.0));
}

#[test]
fn more_than_the_limits_allow_is_refused_in_one_line() {
    let limits = Limits {
        vertices: 3,
        ..Limits::default()
    };
    let mut b = Builder::new(None, limits, relievo_raster::Cancel::default());
    b.line([[0.0, 0.0], [1.0, 1.0]]).unwrap();
    let error = b.line([[0.0, 0.0], [1.0, 1.0]]).unwrap_err();
    assert!(error.contains("at most 3 vertices"), "{error}");
}

#[test]
fn vertices_that_are_nowhere_are_counted_and_nothing_but_those_is_refused() {
    let mut b = Builder::degrees();
    b.line([[0.0, 0.0], [f64::NAN, 1.0], [0.0, 91.0], [2.0, 2.0]])
        .unwrap();
    assert_eq!(b.finish().unwrap().lost_vertices(), 2);
    let mut b = Builder::degrees();
    b.points([[500_000.0, 4_000_000.0]]).unwrap();
    let error = b.finish().unwrap_err();
    assert!(error.contains("is the system right"), "{error}");
}

#[test]
fn properties_keep_their_order_and_numbers_match_what_they_mean() {
    let mut b = Builder::degrees();
    b.property("b", Value::Int(2)).unwrap();
    b.property("a", Value::from("2")).unwrap();
    b.feature().unwrap();
    let features = b.finish().unwrap();
    let names: Vec<&str> = features.properties(0).map(|(name, _)| name).collect();
    assert_eq!(names, ["b", "a"]);
    assert!(features.property(0, "b").means(&Value::Float(2.0)));
    assert!(features.property(0, "a").means(&Value::Int(2)));
    assert_eq!(features.property(0, "c"), &Value::Null);
}

/// A wiggly line of many vertices around the globe's middle.
fn line(count: usize, seed: u64) -> Vec<[f64; 2]> {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut random = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let mut p = [random() * 300.0, random() * 100.0];
    (0..count)
        .map(|_| {
            p = [p[0] + random(), (p[1] + random()).clamp(-89.0, 89.0)];
            p
        })
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn the_index_finds_what_looking_at_everything_finds(
        seed in 0..1000_u64, at in (-200.0..200.0, -90.0..90.0), size in (0.0..30.0, 0.0..30.0),
    ) {
        let mut b = Builder::degrees();
        for i in 0..40 {
            b.line(line(3 + (i % 5) * 40, seed * 100 + i as u64)).unwrap();
            b.feature().unwrap();
        }
        let features = b.finish().unwrap();
        let min = DVec2::new(at.0, at.1).map(f64::to_radians);
        let wanted = Bounds { min, max: min + DVec2::new(size.0, size.1).map(f64::to_radians) };
        let mut found = Vec::new();
        features.reaching(&wanted, true, |f| { found.push(f); ControlFlow::Continue(()) });
        let by_looking: Vec<usize> = (0..features.len()).filter(|f| {
            features.outlines(*f).any(|o| {
                (-2..=2).any(|turns| {
                    let wanted = wanted.turned(turns);
                    o.lonlat_rad.windows(2).any(|e| wanted.touches(e[0], e[1]))
                })
            })
        }).collect();
        prop_assert_eq!(found, by_looking);
    }

    #[test]
    fn boxes_around_runs_do_not_change_what_is_inside(seed in 0..1000_u64, count in 3..2000_usize) {
        let ring: Vec<[f64; 2]> = (0..count).map(|i| {
            let (sin, cos) = (TAU * i as f64 / count as f64).sin_cos();
            let r = 20.0 + 10.0 * ((i as f64 * 0.37 + seed as f64).sin());
            [r * cos, r * sin]
        }).collect();
        let features = polygon(&[&ring]);
        for k in 0..50 {
            let p = DVec2::new(f64::from(k * 7 % 50) * 1.3 - 32.0, f64::from(k) * 1.3 - 32.0);
            let mut odd = false;
            for i in 0..count {
                let (a, b) = (ring[i], ring[(i + 1) % count]);
                if (a[1] > p.y) != (b[1] > p.y)
                    && p.x < (b[0] - a[0]) * (p.y - a[1]) / (b[1] - a[1]) + a[0] {
                    odd = !odd;
                }
            }
            prop_assert_eq!(is_inside(&features, p.x, p.y), odd);
        }
    }
}

#[test]
fn a_part_that_encloses_a_pole_is_bounded_by_it() {
    let features = polygon(&[&[[0.0, 60.0], [120.0, 60.0], [-120.0, 60.0]]]);
    let bounds = features.bounds().unwrap();
    assert!(
        bounds.max.y >= FRAC_PI_2
            && bounds.size().x >= TAU - 1e-12
            && bounds.centre().x.abs() <= PI
    );
}
