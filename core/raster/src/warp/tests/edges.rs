//! Distances to where a source ends.

use super::*;
use crate::edge::EdgeDistance;

#[test]
fn distances_to_an_edge_are_those_to_the_outline_and_to_holes() {
    let cancel = Cancel::default();
    let holed = |x: f64, y: f64| {
        if (x - 150.0).hypot(y - 150.0) < 20.0 {
            f64::NAN
        } else {
            1.0
        }
    };
    let warp = warp(utm(300, 2, holed));
    let edge = EdgeDistance::new(&warp, &cancel).expect("memory does not fail");
    let grid = level_grid(9, -111.5, 40.5, 600, 500);
    let distance = edge.distances_m(&warp, &grid).expect("a known system");
    let out = render(&warp, &grid);
    let (mut far, mut none) = (0, 0);
    for (d, h) in distance.samples().iter().zip(out.samples()) {
        assert!(!h.is_nan() || *d < 170.0, "a hole is {d} m from one");
        far += usize::from(*d >= 3000.0);
        none += usize::from(*d <= 0.0);
    }
    assert!(far > 1000 && none > 1000, "{far} {none}");
    // Neighbours lie 80 m apart, and distances between coarse pixels are interpolated. How far outside a
    // place lies is not said everywhere.
    for row in distance.samples().chunks_exact(600) {
        let inside = |d: f32| d.clamp(0.0, 3000.0);
        assert!(
            row.windows(2)
                .all(|p| (inside(p[0]) - inside(p[1])).abs() < 160.0)
        );
    }
    let part = edge
        .distances_m(&warp, &part_of(&grid, 37, 101, 90, 70))
        .expect("a known system");
    let mut cut = Block::new(Bands::Height, 90, 70);
    cut.copy_from(&distance, (37, 101), (0, 0), (90, 70));
    assert_eq!(bits(&part), bits(&cut));
}

#[test]
fn a_globe_has_no_edge() {
    let warp = warp(globe(64, -180.0, 0, |_, _| 1.0));
    let edge = EdgeDistance::new(&warp, &Cancel::default()).expect("memory does not fail");
    assert!(edge.is_endless() && warp.covers_globe());
    let distance = edge
        .distances_m(&warp, &level_grid(3, 180.0, 0.0, 8, 8))
        .expect("a known system");
    assert!(distance.samples().iter().all(|d| *d == f32::MAX));
}

proptest! {
    #[test]
    fn no_sample_is_nearer_to_the_outline_than_what_is_known_of_its_grid(
        n in 7..12_u8, lon in -112.0..-111.0_f64, lat in 40.2..40.8_f64, width in 1..300_i64, height in 1..300_i64,
    ) {
            for warp in [warp(utm(300, 2, |_, _| 1.0)), warp(globe(64, -180.0, 0, |_, _| 1.0))] {
            let grid = level_grid(n, lon, lat, width, height);
            let least = EdgeDistance::least_m(&warp, &grid);
            let edge = EdgeDistance::to_outline(&warp);
            let all = edge.distances_m(&warp, &grid).expect("a known system");
            let nearest = all.samples().iter().copied().fold(f32::INFINITY, f32::min);
            prop_assert!(least <= f64::from(nearest.max(0.0)) || nearest == f32::MAX, "{least} {nearest}");
        }
    }
}

#[test]
fn what_is_known_of_a_grid_in_the_middle_is_nearly_all_of_its_distance() {
    let warp = warp(utm(300, 2, |_, _| 1.0));
    let (place, size_m) = warp.middle().expect("on the map");
    let (lon_deg, lat_deg) = place.to_degrees();
    let grid = level_grid(14, lon_deg, lat_deg, 4, 4);
    let least = EdgeDistance::least_m(&warp, &grid);
    let half_m = 0.5 * size_m[0].min(size_m[1]);
    assert!(
        least > 0.95 * half_m && least <= half_m,
        "{least} of {half_m}"
    );
}
