//! Features drawn into blocks.

mod ground;
mod looks;
mod parts;

use std::sync::Arc;

use glam::DVec2;
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

/// A line of some metres from a place in some direction.
fn segment(lon: f64, lat: f64, azimuth_deg: f64, length_m: f64) -> Vec<[f64; 2]> {
    let per_rad = Planet::EARTH.metres_per_radian((90.0 - lat).to_radians());
    let (sin, cos) = azimuth_deg.to_radians().sin_cos();
    let d = DVec2::new(sin, cos) * length_m / per_rad;
    vec![[lon, lat], [lon + d.x.to_degrees(), lat + d.y.to_degrees()]]
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
