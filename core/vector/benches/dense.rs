//! Tiles of a city of 100,000 buildings: how long the slowest tile of each level takes, in time of the
//! processor that this thread has had (Linux; 0 elsewhere), so that other load does not count.
//!
//! `cargo bench -p relievo-vector --bench dense`

#![expect(clippy::print_stdout, reason = "a bench says what it found")]

use std::sync::Arc;

use relievo_planet::{LevelKey, MapPoint, Planet, TileKey};
use relievo_raster::{Bands, Block, Cancel};
use relievo_vector::features::Builder;
use relievo_vector::style::{Length, Style};
use relievo_vector::{Drawing, Features};

const BUILDINGS: usize = 100_000;
const LON: f64 = -111.65;
const LAT: f64 = 40.25;

fn main() {
    let features = Arc::new(city());
    let style = |stroke_width, casing| Style {
        fill: Some([0.8, 0.5, 0.2, 0.7]),
        stroke: Some([0.3, 0.1, 0.0, 1.0]),
        stroke_width: Some(stroke_width),
        casing,
        ..Style::default()
    };
    let white = [1.0; 4];
    for (name, style) in [
        ("stroke of 1 px", style(Length::Pixels(1.0), None)),
        ("stroke of 1 m", style(Length::Metres(1.0), None)),
        (
            "stroke of 3 px and casing",
            style(Length::Pixels(3.0), Some((white, Length::Pixels(1.0)))),
        ),
    ] {
        let drawing = Drawing::new(Arc::clone(&features), style, Planet::EARTH);
        println!("{BUILDINGS} buildings, {name}");
        for n in 6..=18 {
            let level = LevelKey::new(n, n);
            let (mut slowest, mut named, mut most) = (0, 0, 0);
            for tile in tiles(level) {
                let grid = tile.grid();
                let start = own_ns();
                std::hint::black_box(drawing.fingerprint(&grid));
                named = named.max(own_ns() - start);
                let count = drawing.count(&grid);
                let mut out = Block::new(Bands::Colour, 256, 256);
                let start = own_ns();
                let drawn = drawing.render(&grid, &mut out, &Cancel::default());
                drawn.expect("a map can be drawn");
                slowest = slowest.max(own_ns() - start);
                most = most.max(count);
            }
            println!(
                "  level {n:2}: {most:6} buildings in a tile, {:7.1} ms to draw, {:6.1} ms to name",
                slowest as f64 / 1e6,
                named as f64 / 1e6
            );
        }
    }
}

/// Nanoseconds of the processor that this thread has had.
fn own_ns() -> u64 {
    let stat = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let had = stat.split_whitespace().next().and_then(|s| s.parse().ok());
    had.unwrap_or(0)
}

/// Tiles about the middle of the city.
fn tiles(level: LevelKey) -> Vec<TileKey> {
    let at = level.sample_from_map(MapPoint::from_degrees(LON, LAT));
    let (column, row) = ((at.x / 256.0) as i64, (at.y / 256.0) as i64);
    let around = (-1..=1).flat_map(|y| (-1..=1).map(move |x| (column + x, row + y)));
    around
        .filter_map(|(x, y)| TileKey::new(level, x, y))
        .collect()
}

/// Houses of 8 to 20 m in a square of about 10 km, turned this way and that.
fn city() -> Features {
    let mut builder = Builder::degrees();
    let side = 317;
    let spacing_deg = 0.1 / f64::from(side);
    let mut state = 1_u64;
    let mut random = move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 40) as f64 / f64::from(1 << 24)
    };
    for i in 0..BUILDINGS as i32 {
        let (x, y) = (f64::from(i % side), f64::from(i / side));
        let lon = LON + (x - 158.5 + 0.3 * random()) * spacing_deg;
        let lat = LAT + (y - 158.5 + 0.3 * random()) * spacing_deg;
        let (a, b) = (
            (4.0 + 6.0 * random()) / 85_000.0,
            (4.0 + 6.0 * random()) / 111_000.0,
        );
        let turn = random();
        let (sin, cos) = (libm::sin(turn), libm::cos(turn));
        let ring = [
            (-a, -b),
            (a, -b),
            (a, b),
            (0.2 * a, b),
            (0.2 * a, 0.3 * b),
            (-a, 0.3 * b),
        ]
        .map(|(x, y)| [lon + x * cos - y * sin, lat + x * sin + y * cos]);
        builder.ring(ring, false).expect("a ring");
        builder.feature().expect("a feature");
    }
    builder.finish().expect("features")
}
