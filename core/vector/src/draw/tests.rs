use std::sync::Arc;

use core::f64::consts::PI;

use glam::DVec2;
use proptest::prelude::*;
use relievo_planet::{Grid, LevelKey, MapPoint, Planet, SampleRect};
use relievo_raster::{Bands, Block, Cancel};

use super::*;
use crate::features::Builder;
use crate::style::{By, Class, ClassOf, Hatch, Length, Symbol, SymbolShape};
use crate::{Features, Value};

const RED: Colour = [1.0, 0.0, 0.0, 1.0];
const BLUE: Colour = [0.0, 0.0, 1.0, 0.5];

fn fill(colour: Colour) -> Style {
    Style {
        fill: Some(colour),
        ..Style::default()
    }
}

fn stroke(width: Length) -> Style {
    Style {
        stroke: Some(RED),
        stroke_width: Some(width),
        ..Style::default()
    }
}

/// Everything at once.
fn full() -> Style {
    Style {
        fill: Some(BLUE),
        stroke: Some(RED),
        stroke_width: Some(Length::Pixels(2.5)),
        casing: Some(([0.0, 0.0, 0.0, 1.0], Length::Pixels(1.0))),
        dash: vec![7.0, 3.0],
        hatch: Some(Hatch {
            colour: [0.0, 1.0, 0.0, 1.0],
            spacing: Length::Pixels(9.0),
            width: Length::Pixels(1.5),
            angle_deg: 30.0,
            crossed: true,
        }),
        symbol: Some(Symbol {
            shape: SymbolShape::Star,
            size: Length::Pixels(11.0),
        }),
        by: Some(By {
            property: "kind".into(),
            classes: vec![Class {
                of: ClassOf::Equals(Value::Int(1)),
                fill: Some([1.0, 1.0, 0.0, 0.8]),
                stroke: None,
            }],
        }),
        ..Style::default()
    }
}

fn draw(drawing: &Drawing, grid: &Grid) -> Block {
    let mut out = Block::new(
        Bands::Colour,
        grid.rect.width() as usize,
        grid.rect.height() as usize,
    );
    drawing.render(grid, &mut out, &Cancel::default()).unwrap();
    out
}

fn drawing(features: Features, style: Style) -> Drawing {
    Drawing::new(Arc::new(features), style, Planet::EARTH)
}

/// A grid of a level around a place in degrees.
fn around(level: LevelKey, lon: f64, lat: f64, size: i64) -> Grid {
    let s = level.sample_from_map(MapPoint::from_degrees(lon, lat));
    let rect = SampleRect::at(s.x as i64 - size / 2, s.y as i64 - size / 2, size, size);
    Grid::new(Arc::new(level.lattice()), rect)
}

/// A grid in squares.
fn pieces(grid: &Grid, size: i64) -> impl Iterator<Item = Grid> {
    let rect = grid.rect;
    let rows = (rect.min.y..rect.max.y).step_by(size as usize);
    let columns = move || (rect.min.x..rect.max.x).step_by(size as usize);
    rows.flat_map(move |y| columns().map(move |x| (x, y)))
        .map(move |(x, y)| grid.with_rect(SampleRect::at(x, y, size, size).intersection(&rect)))
}

/// Square metres that a drawing covers, by alpha.
fn area_m2(block: &Block, grid: &Grid) -> f64 {
    let mut area = 0.0;
    for (i, a) in block.plane(3).iter().enumerate() {
        let row = grid.rect.min.y + (i / block.width()) as i64;
        let p = grid.lattice.centre(I64Vec2::new(0, row));
        let size = Planet::EARTH.metres_per_radian(p.y) * grid.lattice.step.abs();
        area += f64::from(*a) * size.x * size.y;
    }
    area
}

/// A line of some metres from a place in some direction.
fn segment(lon: f64, lat: f64, azimuth_deg: f64, length_m: f64) -> Vec<[f64; 2]> {
    let per_rad = Planet::EARTH.metres_per_radian((90.0 - lat).to_radians());
    let (sin, cos) = azimuth_deg.to_radians().sin_cos();
    let d = DVec2::new(sin, cos) * length_m / per_rad;
    vec![[lon, lat], [lon + d.x.to_degrees(), lat + d.y.to_degrees()]]
}

#[test]
fn a_one_metre_line_has_its_width_in_every_direction_and_at_every_latitude() {
    for lat in [0.0, -40.0, 65.0, 80.0, 89.0] {
        for azimuth in [0.0, 30.0, 45.0, 90.0, 135.0] {
            for lon in [-170.0, 0.0, 111.65] {
                let mut b = Builder::degrees();
                b.line(segment(lon, lat, azimuth, 6.0)).unwrap();
                let drawing = drawing(b.finish().unwrap(), stroke(Length::Metres(1.0)));
                // About as wide as high on the ground.
                let narrower = (-lat.to_radians().cos().log2()) as u8;
                let level = LevelKey::new(21 - narrower, 20);
                let grid = around(level, lon, lat, 512);
                let covered = area_m2(&draw(&drawing, &grid), &grid);
                // With its round ends.
                let exact = 6.0 + PI / 4.0;
                assert!(
                    (covered / exact - 1.0).abs() < 0.04,
                    "{covered} m² at {lat}, azimuth {azimuth}"
                );
            }
        }
    }
}

#[test]
fn a_line_narrower_than_a_sample_fades_instead_of_vanishing() {
    let mut b = Builder::degrees();
    b.line(segment(10.0, 50.0, 37.0, 4000.0)).unwrap();
    let features = Arc::new(b.finish().unwrap());
    let level = LevelKey::new(13, 12);
    let grid = around(level, 10.02, 50.015, 512);
    for width in [4.0, 1.0, 0.25] {
        let style = stroke(Length::Metres(width));
        let drawing = Drawing::new(Arc::clone(&features), style, Planet::EARTH);
        let covered = area_m2(&draw(&drawing, &grid), &grid);
        assert!(
            (covered / (4000.0 * width) - 1.0).abs() < 0.05,
            "{width}: {covered}"
        );
    }
}

#[test]
fn a_fill_covers_the_area_that_it_has_on_the_ground() {
    let ring = [[10.0, 60.0], [12.0, 60.2], [11.8, 61.0], [10.3, 60.8]];
    let mut b = Builder::degrees();
    b.ring(ring, false).unwrap();
    b.ring(
        [[10.8, 60.4], [11.2, 60.4], [11.2, 60.6], [10.8, 60.6]],
        true,
    )
    .unwrap();
    let drawing = drawing(b.finish().unwrap(), fill(RED));
    let grid = around(LevelKey::new(8, 8), 11.0, 60.5, 800);
    let covered = area_m2(&draw(&drawing, &grid), &grid);
    // The same integral in narrow strips of latitude.
    let width = |ring: &[[f64; 2]], lat: f64| {
        let mut at: Vec<f64> = (0..ring.len())
            .filter_map(|i| {
                let (a, b) = (ring[i], ring[(i + 1) % ring.len()]);
                ((a[1] > lat) != (b[1] > lat))
                    .then(|| a[0] + (b[0] - a[0]) * (lat - a[1]) / (b[1] - a[1]))
            })
            .collect();
        at.sort_by(f64::total_cmp);
        at.chunks_exact(2).map(|c| c[1] - c[0]).sum::<f64>()
    };
    let hole = [[10.8, 60.4], [11.2, 60.4], [11.2, 60.6], [10.8, 60.6]];
    let steps = 20_000;
    let exact: f64 = (0..steps)
        .map(|i| {
            let lat = 59.9 + 1.2 * (f64::from(i) + 0.5) / f64::from(steps);
            let m = Planet::EARTH.metres_per_radian((90.0 - lat).to_radians());
            let w = (width(&ring, lat) - width(&hole, lat)).to_radians();
            w * m.x * m.y * (1.2 / f64::from(steps)).to_radians()
        })
        .sum();
    assert!(
        (covered / exact - 1.0).abs() < 2e-3,
        "{covered} for {exact}"
    );
}

/// A mix of everything in a few degrees around a place.
fn mix(lon: f64, lat: f64) -> Features {
    let mut b = Builder::degrees();
    let p = |x: f64, y: f64| [lon + x, lat + y];
    b.ring(
        [p(-1.5, -1.0), p(1.0, -1.2), p(1.3, 0.9), p(-1.1, 1.1)],
        false,
    )
    .unwrap();
    b.ring(
        [p(-0.4, -0.3), p(-0.4, 0.3), p(0.3, 0.2), p(0.4, -0.4)],
        true,
    )
    .unwrap();
    b.property("kind", Value::Int(1)).unwrap();
    b.feature().unwrap();
    b.line((0..300).map(|i| {
        let t = f64::from(i) * 0.01;
        p(t - 1.5, 0.7 * (t * 5.0).sin())
    }))
    .unwrap();
    b.feature().unwrap();
    b.points([p(0.5, 0.5), p(-0.7, 0.2), p(0.0, -0.8)]).unwrap();
    b.feature().unwrap();
    b.finish().unwrap()
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

fn house(count: i32, i: i32, moved: f64) -> [[f64; 2]; 5] {
    let (x, y) = (f64::from(i % count), f64::from(i / count));
    let (sin, cos) = f64::from(i).sin_cos();
    let size = 0.00005 + 0.00003 * cos;
    [
        (-1.0, -0.7),
        (1.0, -0.7),
        (1.0, 0.7),
        (0.3, 0.2),
        (-1.0, 0.7),
    ]
    .map(|(u, v)| {
        let (u, v) = (u * cos - v * sin, u * sin + v * cos);
        [8.0 + x * 0.0002 + u * size + moved, y * 0.0002 + v * size]
    })
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

/// Also where a ring is smaller than its stroke and is drawn by the shape around it.
#[test]
fn a_stroke_covers_what_lies_within_half_its_width_of_the_line() {
    let metres = Planet::EARTH.metres_per_radian(core::f64::consts::FRAC_PI_2);
    for (n, widths_m) in [
        (13, [10.0, 20.0, 40.0]),
        (14, [5.0, 8.0, 20.0]),
        (16, [1.5, 3.0, 9.0]),
    ] {
        for i in 0..8 {
            let ring = house(8, i, 0.0);
            let corners = ring.map(|p| DVec2::from(p.map(f64::to_radians)));
            let grid = around(LevelKey::new(n, n), ring[0][0], ring[0][1], 40);
            let (low, high) = corners
                .iter()
                .fold((corners[0], corners[0]), |(low, high), c| {
                    (low.min(*c), high.max(*c))
                });
            if (high - low).cmplt(0.5 * grid.lattice.step).all() {
                // Drawn by its area alone.
                continue;
            }
            for width_m in widths_m {
                let mut b = Builder::degrees();
                b.ring(ring, false).unwrap();
                let drawing = drawing(b.finish().unwrap(), stroke(Length::Metres(width_m)));
                let block = draw(&drawing, &grid);
                let (mut sum, mut worst, mut count) = (0.0, 0.0_f64, 0.0);
                for (k, alpha) in block.plane(3).iter().enumerate() {
                    let sample = DVec2::new((k % 40) as f64, (k / 40) as f64);
                    let points = (0..64).map(|j| {
                        let at =
                            sample + (DVec2::new(f64::from(j % 8), f64::from(j / 8)) + 0.5) / 8.0;
                        let at = grid.lattice.origin
                            + (grid.rect.min.as_dvec2() + at) * grid.lattice.step;
                        DVec2::new(at.x, core::f64::consts::FRAC_PI_2 - at.y)
                    });
                    let inside = points.filter(|p| {
                        (0..5).any(|e| {
                            let (a, b) = (corners[e] * metres, corners[(e + 1) % 5] * metres);
                            let (d, v) = (b - a, *p * metres - a);
                            let t = (v.dot(d) / d.length_squared()).clamp(0.0, 1.0);
                            (v - d * t).length() <= 0.5 * width_m
                        })
                    });
                    let exact = inside.count() as f64 / 64.0;
                    let difference = (f64::from(*alpha) - exact).abs();
                    if exact > 0.0 || *alpha > 0.0 {
                        sum += difference;
                        count += 1.0;
                    }
                    worst = worst.max(difference);
                }
                let name = format!("level {n}, house {i}, {width_m} m");
                assert!(
                    sum / count < 0.05 && worst < 0.3,
                    "{name}: {} {worst}",
                    sum / count
                );
            }
        }
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
fn neighbours_of_one_class_leave_no_seam() {
    let mut b = Builder::degrees();
    for i in 0..40 {
        let x = f64::from(i) * 0.0371;
        b.ring(
            [
                [x, 0.0],
                [x + 0.0371, 0.0],
                [x + 0.0471, 1.0],
                [x + 0.01, 1.0],
            ],
            false,
        )
        .unwrap();
        b.feature().unwrap();
    }
    let drawing = drawing(b.finish().unwrap(), fill(RED));
    let grid = around(LevelKey::new(9, 8), 0.7, 0.5, 100);
    assert!(
        draw(&drawing, &grid).plane(3)[40 * 100 + 10..40 * 100 + 90]
            .iter()
            .all(|a| *a == 1.0)
    );
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

#[test]
fn a_style_is_drawn_only_at_its_scales() {
    let style = Style {
        max_sample_m: Some(100.0),
        ..fill(RED)
    };
    let drawing = drawing(mix(0.0, 0.0), style);
    assert!(!drawing.reaches(&around(LevelKey::new(5, 5), 0.0, 0.5, 16)));
    assert!(drawing.reaches(&around(LevelKey::new(13, 12), 0.0, 0.5, 16)));
}

#[test]
fn classes_by_value_and_range_have_their_colours() {
    let mut b = Builder::degrees();
    for (i, height) in [3.0, 12.0, 40.0].into_iter().enumerate() {
        let x = i as f64;
        b.ring([[x, 0.0], [x + 1.0, 0.0], [x + 1.0, 1.0], [x, 1.0]], false)
            .unwrap();
        b.property("height", Value::Float(height)).unwrap();
        b.feature().unwrap();
    }
    let class = |min, max, colour| Class {
        of: ClassOf::Range { min, max },
        fill: Some(colour),
        stroke: None,
    };
    let style = Style {
        by: Some(By {
            property: "height".into(),
            classes: vec![
                class(None, Some(10.0), [0.0, 1.0, 0.0, 1.0]),
                class(Some(10.0), Some(20.0), [0.0, 0.0, 1.0, 1.0]),
            ],
        }),
        ..fill(RED)
    };
    let drawing = drawing(b.finish().unwrap(), style);
    for (lon, expected) in [
        (0.5, [0.0, 1.0, 0.0]),
        (1.5, [0.0, 0.0, 1.0]),
        (2.5, [1.0, 0.0, 0.0]),
    ] {
        let block = draw(&drawing, &around(LevelKey::new(10, 9), lon, 0.5, 1));
        for (plane, v) in expected.into_iter().enumerate() {
            assert!((block.plane(plane)[0] - v).abs() < 1e-4, "{lon}");
        }
    }
}

#[test]
fn dashes_have_their_length_and_go_on_from_tile_to_tile() {
    let mut b = Builder::degrees();
    b.line(segment(8.0, 47.0, 90.0, 1000.0)).unwrap();
    let style = Style {
        dash: vec![30.0, 20.0],
        ..stroke(Length::Metres(40.0))
    };
    let drawing = drawing(b.finish().unwrap(), style);
    let grid = around(LevelKey::new(15, 14), 8.0066, 47.0, 1000);
    let covered = area_m2(&draw(&drawing, &grid), &grid);
    assert!((covered / 24_000.0 - 1.0).abs() < 0.02, "{covered}");
}

#[test]
fn a_projected_grid_shows_the_same_areas() {
    let ring = [
        [-111.7, 40.2],
        [-111.6, 40.21],
        [-111.61, 40.3],
        [-111.72, 40.28],
    ];
    let mut b = Builder::degrees();
    b.ring(ring, false).unwrap();
    let drawing = drawing(b.finish().unwrap(), fill(RED));
    let utm = Lattice {
        crs: relievo_planet::GridCrs::Projected("EPSG:26912".into()),
        origin: DVec2::new(430_000.0, 4_470_000.0),
        step: DVec2::new(30.0, -30.0),
        columns_around: None,
    };
    let projected = Grid::new(Arc::new(utm), SampleRect::at(0, 0, 900, 800));
    let alphas: f64 = draw(&drawing, &projected)
        .plane(3)
        .iter()
        .map(|a| f64::from(*a))
        .sum();
    let map = around(LevelKey::new(12, 11), -111.66, 40.25, 900);
    let on_map = area_m2(&draw(&drawing, &map), &map);
    // UTM shortens by 0.9996 at its middle meridian.
    assert!(
        (alphas * 900.0 / on_map - 0.9992).abs() < 1e-3,
        "{} {on_map}",
        alphas * 900.0
    );
}

#[test]
fn absurd_widths_and_coordinates_draw_something_or_nothing_but_end() {
    let mut b = Builder::degrees();
    b.line([
        [-36_000.0, -90.0],
        [36_000.0, 90.0],
        [1e-300, 0.0],
        [0.0, 0.0],
    ])
    .unwrap();
    b.ring([[0.0, 90.0], [120.0, 90.0], [240.0, 90.0]], false)
        .unwrap();
    b.ring([[0.0, 0.0], [1e-15, 0.0], [0.0, 1e-15], [0.0, 0.0]], false)
        .unwrap();
    let features = Arc::new(b.finish().unwrap());
    for length in [0.0, f64::NAN, -1.0, 1e-300, 1e300, f64::INFINITY] {
        for unit in [Length::Metres, Length::Pixels] {
            let style = Style {
                stroke_width: Some(unit(length)),
                dash: vec![length, 1e-9, length],
                hatch: Some(Hatch {
                    colour: RED,
                    spacing: unit(length),
                    width: unit(1.0),
                    angle_deg: length,
                    crossed: false,
                }),
                symbol: Some(Symbol {
                    shape: SymbolShape::Circle,
                    size: unit(length),
                }),
                ..full()
            };
            let drawing = Drawing::new(Arc::clone(&features), style, Planet::EARTH);
            for level in [LevelKey::new(1, 0), LevelKey::new(25, 24)] {
                let block = draw(&drawing, &around(level, 0.0, 0.0, 64));
                assert!(block.samples().iter().all(|v| v.is_finite()));
            }
        }
    }
}

#[test]
fn where_a_file_cut_a_polygon_at_the_antimeridian_there_is_no_stroke() {
    let mut b = Builder::degrees();
    b.ring(
        [[170.0, 60.0], [180.0, 60.0], [180.0, 70.0], [170.0, 70.0]],
        false,
    )
    .unwrap();
    b.ring(
        [
            [-180.0, 60.0],
            [-170.0, 60.0],
            [-170.0, 70.0],
            [-180.0, 70.0],
        ],
        false,
    )
    .unwrap();
    let drawing = drawing(b.finish().unwrap(), stroke(Length::Pixels(2.0)));
    for (lon, there) in [
        (180.0, false),
        (-179.99, false),
        (170.0, true),
        (-170.0, true),
    ] {
        let block = draw(&drawing, &around(LevelKey::new(6, 5), lon, 65.0, 4));
        let any = block.plane(3).iter().any(|a| *a > 0.0);
        assert_eq!(any, there, "{lon}");
    }
}
