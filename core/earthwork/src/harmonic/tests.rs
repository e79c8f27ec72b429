use proptest::prelude::*;

use super::*;

/// A mesh of right triangles over `columns` × `rows` cells; each place from its column and row.
fn mesh(
    columns: usize,
    rows: usize,
    place: impl Fn(usize, usize) -> DVec2,
) -> (Vec<DVec2>, Vec<[usize; 3]>, Vec<bool>) {
    let index = |c: usize, r: usize| r * (columns + 1) + c;
    let (mut at, mut triangles, mut is_rim) = (Vec::new(), Vec::new(), Vec::new());
    for r in 0..=rows {
        for c in 0..=columns {
            at.push(place(c, r));
            is_rim.push(c == 0 || r == 0 || c == columns || r == rows);
            if c < columns && r < rows {
                let [a, b, d, e] = [
                    index(c, r),
                    index(c + 1, r),
                    index(c, r + 1),
                    index(c + 1, r + 1),
                ];
                triangles.extend([[a, b, e], [a, e, d]]);
            }
        }
    }
    (at, triangles, is_rim)
}

/// Largest error of a plane, given at the rim, over what the plane spans.
fn error_of_plane(at: &[DVec2], triangles: &[[usize; 3]], is_rim: &[bool], gradient: DVec2) -> f64 {
    let plane: Vec<f64> = at.iter().map(|p| 250.0 + gradient.dot(*p)).collect();
    let known: Vec<Option<f64>> = plane
        .iter()
        .zip(is_rim)
        .map(|(h, rim)| rim.then_some(*h))
        .collect();
    let found = harmonic(at, triangles, &known);
    let (low, high) = plane
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
            (l.min(*v), h.max(*v))
        });
    let worst = found
        .iter()
        .zip(&plane)
        .map(|(f, p)| (f - p).abs())
        .fold(0.0, f64::max);
    worst / (high - low)
}

/// Places of a lattice whose last cells are `ratio` times as long as the first.
fn graded(cells: usize, ratio: f64) -> Vec<f64> {
    let grow = libm::pow(ratio, 1.0 / (cells - 1) as f64);
    let mut at = vec![0.0];
    let mut step = 1.0;
    for k in 0..cells {
        at.push(at[k] + step);
        step *= grow;
    }
    let length = at[cells];
    at.iter().map(|x| x / length).collect()
}

#[test]
fn a_plane_stays_a_plane_whatever_the_condition_number() {
    // Cells of aspect 10⁶ give conductances from 10⁻⁶ to 10⁶, hence condition numbers of 10¹².
    for stretch in [1.0, 1e-3, 1e-6] {
        let (at, triangles, is_rim) = mesh(40, 40, |c, r| DVec2::new(c as f64, r as f64 * stretch));
        for gradient in [DVec2::new(1.0, 0.0), DVec2::new(0.0, 1.0 / stretch)] {
            let error = error_of_plane(&at, &triangles, &is_rim, gradient);
            assert!(error < 1e-12, "stretched by {stretch}: {error:e}");
        }
    }
    // The Delaunay triangles of stretched rows that are shifted against each other, where cotangents of
    // 10³ and more cancel.
    for stretch in [1e-2, 1e-4, 1e-6] {
        let (at, _, is_rim) = mesh(24, 24, |c, r| {
            DVec2::new(c as f64 + 0.37 * (r % 3) as f64, r as f64 * stretch)
        });
        let (triangles, _) = crate::tin::triangulate(&at, &[]).expect("an area");
        let error = error_of_plane(&at, &triangles, &is_rim, DVec2::new(1.0, 0.3 / stretch));
        assert!(
            error < 1e-12,
            "shifted rows stretched by {stretch}: {error:e}"
        );
    }
    // Cells that shrink to a millionth towards a corner.
    let x = graded(48, 1e6);
    let (at, triangles, is_rim) = mesh(48, 48, |c, r| DVec2::new(x[c], x[r]));
    let error = error_of_plane(&at, &triangles, &is_rim, DVec2::new(1.0, -0.5));
    assert!(error < 1e-12, "graded: {error:e}");
}

#[test]
fn conductances_of_needles_are_their_closed_forms() {
    // A rhombus a kilometre long and a millimetre wide: cot α + cot β of the short diagonal and of a
    // side, against the closed forms.
    let (half, thin) = (500.0, 5e-4);
    let at = [
        DVec2::new(-half, 0.0),
        DVec2::new(0.0, -thin),
        DVec2::new(half, 0.0),
        DVec2::new(0.0, thin),
    ];
    let found = conductances(&at, &[[0, 1, 3], [1, 2, 3]]);
    let short = found
        .iter()
        .find(|e| (e.0, e.1) == (1, 3))
        .expect("the short diagonal")
        .2;
    let exact = (half * half - thin * thin) / (half * thin);
    assert!((short / exact - 1.0).abs() < 1e-15, "{short} {exact}");
    let side = found
        .iter()
        .find(|e| (e.0, e.1) == (0, 1))
        .expect("a side")
        .2;
    assert!((side * half / thin - 1.0).abs() < 1e-15, "{side}");
}

#[test]
fn an_island_gets_the_mean_and_nothing_known_gives_zero() {
    let at: Vec<DVec2> = (0..6)
        .map(|i| DVec2::new(f64::from(i % 2) + f64::from(i / 3) * 10.0, f64::from(i % 3)))
        .collect();
    let triangles = [[0, 1, 2], [3, 4, 5]];
    let heights = harmonic(
        &at,
        &triangles,
        &[Some(4.0), Some(8.0), None, None, None, None],
    );
    assert_eq!(heights[3..], [6.0, 6.0, 6.0]);
    assert_eq!(harmonic(&at, &triangles, &[None; 6]), vec![0.0; 6]);
    assert_eq!(harmonic(&[], &[], &[]), Vec::<f64>::new());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn no_height_leaves_the_range_of_the_known_ones_on_any_mesh(
        jitter in prop::collection::vec((-0.9..0.9_f64, -0.9..0.9_f64), 169), stretch in -9.0..9.0_f64,
        rim in prop::collection::vec(-1e5..1e5_f64, 169),
    ) {
        // Nodes that are moved so far that triangles overlap and turn over.
        let stretch = libm::exp10(stretch);
        let (at, triangles, is_rim) = mesh(12, 12, |c, r| {
            let (x, y) = jitter[r * 13 + c];
            DVec2::new(c as f64 + x, (r as f64 + y) * stretch)
        });
        let known: Vec<Option<f64>> = rim.iter().zip(&is_rim).map(|(h, rim)| rim.then_some(*h)).collect();
        let (low, high) = known.iter().flatten().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
        for height_m in harmonic(&at, &triangles, &known) {
            prop_assert!(height_m >= low - 1e-9 && height_m <= high + 1e-9, "{height_m}");
        }
    }
}
