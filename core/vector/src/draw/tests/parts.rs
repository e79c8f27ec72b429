//! Tiles, levels and patches of a drawing: each shows its part of the whole, and is named after it.

use proptest::prelude::*;

use super::*;

/// A grid in squares.
fn pieces(grid: &Grid, size: i64) -> impl Iterator<Item = Grid> {
    let rect = grid.rect;
    let rows = (rect.min.y..rect.max.y).step_by(size as usize);
    let columns = move || (rect.min.x..rect.max.x).step_by(size as usize);
    rows.flat_map(move |y| columns().map(move |x| (x, y)))
        .map(move |(x, y)| grid.with_rect(SampleRect::at(x, y, size, size).intersection(&rect)))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn a_whole_equals_its_tiles(
        x in -300..300_i64, y in -300..300_i64, w in 1..400_i64, h in 1..300_i64,
        cut in (0.0..1.0_f64, 0.0..1.0_f64), lon in prop_oneof![Just(0.2), Just(179.9), Just(-120.0)],
        lat in prop_oneof![Just(0.1), Just(-60.0), Just(88.5)],
    ) {
        let drawing = drawing(mix(lon, lat), full());
        let level = LevelKey::new(8, 8);
        let s = level.sample_from_map(MapPoint::from_degrees(lon, lat)).as_i64vec2();
        let whole = Grid::new(Arc::new(level.lattice()), SampleRect::at(s.x + x, s.y + y, w, h));
        let all = draw(&drawing, &whole);
        let (cx, cy) = ((cut.0 * w as f64) as i64, (cut.1 * h as f64) as i64);
        for (px, pw) in [(0, cx), (cx, w - cx)] {
            for (py, ph) in [(0, cy), (cy, h - cy)] {
                if pw == 0 || ph == 0 {
                    continue;
                }
                let rect = SampleRect::at(whole.rect.min.x + px, whole.rect.min.y + py, pw, ph);
                let mut of_whole = Block::new(Bands::Colour, pw as usize, ph as usize);
                of_whole.copy_from(&all, (px as usize, py as usize), (0, 0), (pw as usize, ph as usize));
                prop_assert_eq!(draw(&drawing, &whole.with_rect(rect)), of_whole);
            }
        }
    }

    #[test]
    fn nothing_is_drawn_where_nothing_reaches(
        x in 0..60_i64, y in 0..30_i64, lat in prop_oneof![Just(0.1), Just(-60.0), Just(85.0)],
    ) {
        let drawing = drawing(mix(17.0, lat), full());
        let grid = Grid::new(Arc::new(LevelKey::new(3, 3).lattice()), SampleRect::at(x * 32, y * 64, 32, 64));
        if !drawing.reaches(&grid) {
            prop_assert!(draw(&drawing, &grid).samples().iter().all(|v| *v == 0.0));
        }
    }
}

/// Houses of about 14 m in a field of `count` × `count`, turned this way and that.
fn city(count: i32) -> Features {
    let mut b = Builder::degrees();
    for i in 0..count * count {
        b.ring(house(count, i, 0.0), false).unwrap();
        b.feature().unwrap();
    }
    b.finish().unwrap()
}

/// A level from afar shows what a level from near by shows, averaged over its samples.
#[test]
fn a_city_from_afar_is_the_average_of_the_city_from_near_by() {
    let style = Style {
        stroke: Some([0.3, 0.3, 0.3, 1.0]),
        stroke_width: Some(Length::Metres(2.0)),
        ..fill(RED)
    };
    let drawing = drawing(city(24), style);
    let exact = LevelKey::new(18, 18);
    let s = exact.sample_from_map(MapPoint::from_degrees(8.0024, 0.0024));
    let first = (s.x as i64 / 4096 * 4096, s.y as i64 / 4096 * 4096);
    let fine = Grid::new(
        Arc::new(exact.lattice()),
        SampleRect::at(first.0, first.1, 4096, 4096),
    );
    let near = draw(&drawing, &fine);
    let all = near.plane(3);
    for halvings in [2, 4, 6] {
        let level = LevelKey::new(18 - halvings, 18 - halvings);
        let size = 1_i64 << halvings;
        let rect = SampleRect::at(first.0 / size, first.1 / size, 4096 / size, 4096 / size);
        let far = draw(&drawing, &Grid::new(Arc::new(level.lattice()), rect));
        let mut differences = Vec::new();
        for (i, alpha) in far.plane(3).iter().enumerate() {
            let (x, y) = (
                i % far.width() * size as usize,
                i / far.width() * size as usize,
            );
            let rows = (y..y + size as usize).map(|row| &all[row * 4096 + x..][..size as usize]);
            let mean = rows.flatten().sum::<f32>() / (size * size) as f32;
            differences.push(f64::from((alpha - mean).abs()));
        }
        let count = differences.len() as f64;
        let mean = differences.iter().sum::<f64>() / count;
        let worst = differences.iter().copied().fold(0.0, f64::max);
        assert!(mean < 0.02, "{halvings}: {mean}");
        assert!(worst < 0.25, "{halvings}: {worst}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn a_patched_drawing_is_the_drawing_of_all_that_is_left(
        changed in 0..36_i32, moved in -3e-4..3e-4_f64, level in 13..18_u8, dashed in any::<bool>(),
    ) {
        let style = Style {
            stroke: Some(RED),
            stroke_width: Some(Length::Metres(3.0)),
            dash: if dashed { vec![4.0, 2.0] } else { Vec::new() },
            ..fill(BLUE)
        };
        let mut moved_house = Builder::degrees();
        moved_house.ring(house(6, changed, moved), false).unwrap();
        moved_house.feature().unwrap();
        let added = Arc::new(moved_house.finish().unwrap());
        let base = Arc::new(drawing(city(6), style.clone()));
        let patched = base.patched(vec![changed as usize], added).unwrap();
        let mut all = Builder::degrees();
        for i in 0..36 {
            all.ring(house(6, i, if i == changed { moved } else { 0.0 }), false).unwrap();
            all.feature().unwrap();
        }
        let whole = drawing(all.finish().unwrap(), style);
        let grid = around(LevelKey::new(level, level), 8.0005, 0.0005, 300);
        let mut unlike = 0;
        for piece in pieces(&grid, 50) {
            prop_assert_eq!(patched.fingerprint(&piece), whole.fingerprint(&piece));
            prop_assert_eq!(patched.reaches(&piece), whole.reaches(&piece));
            unlike += usize::from(patched.fingerprint(&piece) != base.fingerprint(&piece));
        }
        prop_assert!(unlike < 36, "the others are named as before");
        prop_assert_eq!(patched.fingerprint(&grid), whole.fingerprint(&grid));
        prop_assert_eq!(patched.count(&grid), whole.count(&grid));
        prop_assert_eq!(draw(&patched, &grid), draw(&whole, &grid));
    }
}

#[test]
fn columns_wrap_and_rows_come_back_over_the_pole() {
    let drawing = drawing(mix(179.9, 88.5), full());
    let level = LevelKey::new(5, 6);
    let lattice = Arc::new(level.lattice());
    let size = level.samples();
    let here = draw(
        &drawing,
        &Grid::new(
            Arc::clone(&lattice),
            SampleRect::at(size.x - 40, 0, 80, 120),
        ),
    );
    let there = draw(
        &drawing,
        &Grid::new(Arc::clone(&lattice), SampleRect::at(-40, 0, 80, 120)),
    );
    assert_eq!(here, there);
    assert!(here.plane(3).iter().any(|a| *a > 0.0));
    // Rows above the pole mirror those below it on the other side.
    let above = draw(
        &drawing,
        &Grid::new(lattice, SampleRect::at(size.x / 2 - 40, -120, 80, 120)),
    );
    let mut differ = 0;
    for row in 0..120 {
        for column in 0..80 {
            let a = here.plane(3)[row * 80 + column];
            let b = above.plane(3)[(119 - row) * 80 + column];
            differ += usize::from((a - b).abs() > 0.3);
        }
    }
    assert!(differ < 60, "{differ} samples differ");
}

#[test]
fn names_change_with_what_reaches_and_with_nothing_else() {
    let style = stroke(Length::Pixels(1.0));
    let with = |far: f64| {
        let mut b = Builder::degrees();
        b.line([[0.0, 0.0], [1.0, 1.0]]).unwrap();
        b.feature().unwrap();
        b.line([[90.0, 0.0], [91.0, far]]).unwrap();
        drawing(b.finish().unwrap(), style.clone())
    };
    let (a, b) = (with(1.0), with(2.0));
    let level = LevelKey::new(6, 5);
    let near = around(level, 0.5, 0.5, 64);
    let far = around(level, 90.5, 0.5, 64);
    assert_eq!(a.fingerprint(&near), b.fingerprint(&near));
    assert_ne!(a.fingerprint(&far), b.fingerprint(&far));
    let wider = Drawing::new(
        Arc::clone(a.features()),
        stroke(Length::Pixels(2.0)),
        Planet::EARTH,
    );
    assert_ne!(a.fingerprint(&near), wider.fingerprint(&near));
}
