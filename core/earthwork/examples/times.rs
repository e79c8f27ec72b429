//! Times of what a drag waits for: `cargo run --release -p relievo-earthwork --example times`.
#![expect(clippy::print_stdout, reason = "its output")]

use std::sync::Arc;
use std::time::Instant;

use glam::DVec2;
use relievo_earthwork::{
    Design, Element, Frame, MapIndex, MapRect, Outcome, Polygon, Prepared, Samples, Shape, Side,
    Surface, Vertex,
};
use relievo_planet::{MapPoint, Planet};

/// A ring of `corners` corners with a wavy edge.
fn ring(frame: &Frame, centre: DVec2, radius_m: f64, corners: usize, surface: Surface) -> Element {
    let vertex = |k: usize| {
        let angle = core::f64::consts::TAU * k as f64 / corners as f64;
        let wave = 1.0 + 0.1 * libm::sin(angle * 9.0);
        let (sin, cos) = libm::sincos(angle);
        Vertex {
            place: frame.to_map(centre + DVec2::new(cos, sin) * radius_m * wave),
            height_m: Some(10.0 + 2.0 * libm::sin(angle * 3.0)),
        }
    };
    Element {
        shape: Shape::Polygon(Polygon {
            outline: (0..corners).map(vertex).collect(),
            holes: Vec::new(),
            breaklines: Vec::new(),
            surface,
        }),
        side: Side::default(),
    }
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}

/// Median time of a tile of 256 by 256 samples around a place.
fn tile_ms(design: &Design, middle: MapPoint, spacing_m: f64) -> f64 {
    let step = spacing_m / 6.37e6;
    let lon: Vec<f64> = (0..256)
        .map(|i| middle.lon_rad + f64::from(i - 128) * step / libm::sin(middle.colat_rad))
        .collect();
    let colat: Vec<f64> = (0..256)
        .map(|i| middle.colat_rad + f64::from(i - 128) * step)
        .collect();
    let samples = Samples::Map {
        lon_rad: &lon,
        colat_rad: &colat,
    };
    let mut times: Vec<f64> = (0..15)
        .map(|_| {
            let ground = Outcome {
                height_m: 3.0,
                by: None,
            };
            let mut out = vec![ground; 256 * 256];
            let start = Instant::now();
            design.outcomes(&samples, spacing_m, &mut out);
            milliseconds(start)
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[7]
}

fn main() {
    let planet = Planet::EARTH;
    let frame = Frame::new(planet, MapPoint::from_degrees(11.4, 47.2));
    let platform = Surface::Platform { height_m: 20.0 };
    for (name, surface, corners) in [
        ("platform, 100 edges", platform, 100),
        ("triangles, 100 edges", Surface::Tin, 100),
        ("platform, 10 000 edges", platform, 10_000),
        ("platform, 1 000 000 edges", platform, 1_000_000),
        ("triangles, 100 000 edges", Surface::Tin, 100_000),
    ] {
        let element = Arc::new(ring(&frame, DVec2::ZERO, 100.0, corners, surface));
        let start = Instant::now();
        let prepared = Prepared::new(planet, element);
        let shape = prepared.shape(&[]);
        let prepare = milliseconds(start);
        let design = Design::new(planet, vec![shape]);
        let inside = tile_ms(&design, frame.origin(), 1.0);
        let edge = tile_ms(&design, frame.to_map(DVec2::new(100.0, 0.0)), 0.25);
        println!(
            "{name}: prepared in {prepare:.2} ms, a tile of all of it {inside:.2} ms, of its edge {edge:.2} ms"
        );
    }
    let many: Vec<Prepared> = (0..10_000)
        .map(|k| {
            let centre = DVec2::new(f64::from(k % 100), f64::from(k / 100)) * 300.0;
            Prepared::new(planet, Arc::new(ring(&frame, centre, 40.0, 20, platform)))
        })
        .collect();
    let start = Instant::now();
    let index = MapIndex::new(many.iter().map(Prepared::reach));
    println!("index of 10 000 elements: {:.2} ms", milliseconds(start));
    let p = frame.to_map(DVec2::splat(15_000.0));
    let rect = MapRect {
        west_rad: p.lon_rad,
        east_rad: p.lon_rad + 1e-4,
        north_rad: p.colat_rad,
        south_rad: p.colat_rad + 1e-4,
    };
    let start = Instant::now();
    let near = index.touching(&rect);
    let touching = near
        .iter()
        .filter(|i| many[**i as usize].touches(&rect))
        .count();
    println!(
        "{touching} of {} near a tile touch it: {:.3} ms",
        near.len(),
        milliseconds(start)
    );
    let shapes = many.iter().map(|p| p.shape(&[])).collect();
    let start = Instant::now();
    let design = Design::new(planet, shapes);
    println!("a design of 10 000: {:.2} ms", milliseconds(start));
    for spacing in [1.0, 10.0, 120.0, 2000.0] {
        println!(
            "a tile of it at {spacing} m: {:.1} ms",
            tile_ms(&design, p, spacing)
        );
    }
}
