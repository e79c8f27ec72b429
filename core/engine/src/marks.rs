//! What is shown over the colours of the ground and is no part of the project: results of
//! measurements.
//!
//! They are nodes like any other, so they lie on the terrain at every zoom, hidden by what stands before
//! them. Questions about the project never see them.

use core::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DVec2, I64Vec2};
use relievo_analysis::{ContourLine, MapBox, Sight, Viewshed};
use relievo_graph::ImageNode;
use relievo_graph::nodes::{Memory, Vector};
use relievo_planet::{Grid, LevelKey, MapPoint, Planet, SampleRect};
use relievo_raster::{Bands, Block};
use relievo_vector::style::{Colour, Length};
use relievo_vector::{Builder, Drawing, Style};

use crate::compile::level_of_step;
use crate::vectors;

/// Most samples that a mark keeps: 32 MiB.
const MOST_SAMPLES: i64 = 1 << 21;

/// Something that lies over the colours of the ground.
#[derive(Clone)]
pub struct Mark {
    pub(crate) node: Arc<dyn ImageNode>,
    /// Finest level that it is worth.
    pub(crate) finest: u8,
}

impl Mark {
    /// What is seen and what is hidden in two colours (straight sRGB and alpha), as fine as the viewshed
    /// or as two million samples allow. Takes about 0.2 s for those.
    pub fn of_viewshed(found: &Viewshed, visible: Colour, hidden: Colour) -> Self {
        let (planet, centre) = (*found.frame.planet(), found.frame.centre);
        let radius_m = (found.reach as f64 + 0.5) * found.spacing_m;
        let area = MapBox::around(centre, (radius_m / found.frame.mean_radius_m()).min(PI));
        let mut n = level_of_step(found.spacing_m / planet.radius_m);
        let (level, rect) = loop {
            let level = area.level(n);
            let rect = samples_in(&area, level);
            if rect.area() <= MOST_SAMPLES || n == 0 {
                break (level, rect);
            }
            n -= 1;
        };
        let lattice = Arc::new(level.lattice());
        let (width, height) = (rect.width() as usize, rect.height() as usize);
        let mut colours = Block::new(Bands::Colour, width, height);
        let [red, green, blue, alpha] = colours.planes_mut();
        for i in 0..width * height {
            let sample = rect.min + I64Vec2::new((i % width) as i64, (i / width) as i64);
            let at_m = planet.offset_m(centre, lattice.map_point(sample));
            let colour = match found.sight(at_m) {
                Sight::Visible => visible,
                Sight::Hidden => hidden,
                Sight::Outside => [0.0; 4],
            };
            [red[i], green[i], blue[i], alpha[i]] = colour;
        }
        Self {
            node: Arc::new(Memory::new(&Grid::new(lattice, rect), colours)),
            finest: n,
        }
    }

    /// A body of water that ends at a shore (rings as in [`Flood`](relievo_analysis::Flood)), in the
    /// colours of both.
    ///
    /// # Errors
    /// One line where the shore has more vertices than can be drawn.
    pub fn of_flood(
        shore: &[ContourLine],
        planet: Planet,
        water: Colour,
        line: Colour,
    ) -> Result<Self, String> {
        let mut features = Builder::degrees();
        // Around the water, then around its islands.
        for is_hole in [false, true] {
            let rings = shore.iter().filter(|ring| is_island(ring) == is_hole);
            for ring in rings {
                features.ring(degrees(ring), is_hole)?;
            }
        }
        features.feature()?;
        let style = Style {
            fill: Some(water),
            stroke: Some(line),
            stroke_width: Some(Length::Pixels(1.5)),
            ..Style::default()
        };
        Self::drawn(features, style, planet)
    }

    /// Contours as lines of one colour, about `width_px` pixels wide.
    ///
    /// # Errors
    /// One line where they have more vertices than can be drawn.
    pub fn of_lines(
        lines: &[ContourLine],
        planet: Planet,
        colour: Colour,
        width_px: f64,
    ) -> Result<Self, String> {
        let mut features = Builder::degrees();
        for line in lines {
            let first = line.points.first().filter(|_| line.closed);
            let closing = first.map(|p| degree(*p, line.points.last()));
            features.line(degrees(line).chain(closing))?;
            features.feature()?;
        }
        let style = Style {
            stroke: Some(colour),
            stroke_width: Some(Length::Pixels(width_px)),
            ..Style::default()
        };
        Self::drawn(features, style, planet)
    }

    fn drawn(features: Builder, style: Style, planet: Planet) -> Result<Self, String> {
        let drawing = Drawing::new(Arc::new(features.finish()?), style, planet);
        Ok(Self {
            node: Arc::new(Vector::new(Arc::new(drawing))),
            finest: level_of_step(vectors::FINEST_M / planet.radius_m),
        })
    }
}

/// The samples of a level that touch an area, once around at most.
fn samples_in(area: &MapBox, level: LevelKey) -> SampleRect {
    let (lattice, size) = (level.lattice(), level.samples());
    let at = |x, y| lattice.sample_from_plane(DVec2::new(x, y));
    let first = at(area.west_rad, area.north_colat_rad).floor().as_i64vec2();
    let last = at(area.east_rad, area.south_colat_rad).ceil().as_i64vec2();
    let min = I64Vec2::new(first.x, first.y.clamp(0, size.y - 1));
    let max = I64Vec2::new(
        last.x.clamp(first.x + 1, first.x + size.x),
        last.y.clamp(min.y + 1, size.y),
    );
    SampleRect::new(min, max)
}

fn degrees(line: &ContourLine) -> impl Iterator<Item = [f64; 2]> + '_ {
    line.points.iter().map(|point| degree(*point, None))
}

/// A place in degrees, on the same turn as another.
fn degree(point: MapPoint, near: Option<&MapPoint>) -> [f64; 2] {
    let turns = near.map_or(0.0, |near| ((near.lon_rad - point.lon_rad) / TAU).round());
    [
        (point.lon_rad + turns * TAU).to_degrees(),
        90.0 - point.colat_rad.to_degrees(),
    ]
}

/// Whether a ring of a shore goes around dry ground: it has that to its left.
fn is_island(ring: &ContourLine) -> bool {
    let next = ring.points.iter().cycle().skip(1);
    let twice: f64 = ring
        .points
        .iter()
        .zip(next)
        .map(|(a, b)| (b.lon_rad - a.lon_rad) * (a.colat_rad + b.colat_rad))
        .sum();
    twice > 0.0
}

#[cfg(test)]
mod tests {
    use relievo_analysis::LocalFrame;
    use relievo_graph::{GraphBuilder, Known};
    use relievo_raster::Cancel;

    use super::*;

    /// Water all around an island; longitudes and latitudes in degrees.
    fn shore() -> Vec<ContourLine> {
        let ring = |points: &[[f64; 2]]| ContourLine {
            height_m: 0.0,
            points: points
                .iter()
                .map(|[lon, lat]| MapPoint::new(lon.to_radians(), (90.0 - lat).to_radians()))
                .collect(),
            closed: true,
        };
        // Clockwise around the water, across the antimeridian, counter-clockwise around the island.
        let shore = ring(&[[179.0, -1.0], [179.0, 1.0], [181.0, 1.0], [181.0, -1.0]]);
        let island = ring(&[[179.8, -0.2], [180.2, -0.2], [180.2, 0.2], [179.8, 0.2]]);
        vec![island, shore]
    }

    /// The alpha of a mark at a place.
    fn alpha(mark: &Mark, lon_deg: f64, lat_deg: f64) -> f32 {
        let level = LevelKey::new(9, 8);
        let at = level.sample_from_map(MapPoint::from_degrees(lon_deg, lat_deg));
        let rect = SampleRect::at(at.x.floor() as i64, at.y.floor() as i64, 1, 1);
        let grid = Grid::new(Arc::new(level.lattice()), rect);
        let mut builder = GraphBuilder::default();
        let node = builder.add(Arc::clone(&mark.node), &[]);
        let graph = builder.build();
        if mark.node.known(&grid, &[]) == Known::Uniform([0.0; 4]) {
            return 0.0;
        }
        graph
            .evaluate(node, &grid, &Cancel::default())
            .unwrap()
            .plane(3)[0]
    }

    #[test]
    fn water_is_drawn_up_to_its_shore_and_not_on_islands() {
        let mark = Mark::of_flood(&shore(), Planet::EARTH, [0.0, 0.0, 1.0, 0.5], [0.0; 4]).unwrap();
        for (lon, lat, water) in [
            (179.4, 0.0, true),
            (-179.4, 0.5, true),
            (180.0, 0.0, false),
            (178.5, 0.0, false),
        ] {
            assert_eq!(alpha(&mark, lon, lat) > 0.4, water, "{lon}, {lat}");
        }
    }

    #[test]
    fn a_viewshed_lies_where_it_was_measured_also_around_a_pole() {
        for (lon, lat) in [(10.0, 45.0), (179.99, -20.0), (30.0, 89.99)] {
            let reach = 50;
            let side = 2 * reach + 1;
            // The northern half is hidden, as rows run from the north.
            let sights = (0..side * side).map(|i| {
                if i / side < reach {
                    Sight::Hidden
                } else {
                    Sight::Visible
                }
            });
            let found = Viewshed {
                frame: LocalFrame::new(Planet::EARTH, MapPoint::from_degrees(lon, lat)),
                spacing_m: 1000.0,
                reach,
                sights: sights.collect(),
                visible_m2: 1.0,
                area_m2: 1.0,
                ground_m: 0.0,
            };
            let mark = Mark::of_viewshed(&found, [1.0; 4], [0.0, 0.0, 0.0, 0.5]);
            let at = |x, y| {
                let (lon, lat) = found.frame.place(DVec2::new(x, y)).to_degrees();
                alpha(&mark, lon, lat)
            };
            assert_eq!(
                [at(0.0, 20_000.0), at(0.0, -20_000.0), at(0.0, 60_000.0)],
                [0.5, 1.0, 0.0],
                "{lon}, {lat}"
            );
        }
    }
}
