//! All elements together: who decides a place's height.
//!
//! Inside an element its surface counts; among several the last in the list; insides beat side
//! slopes. Outside of all, the ground is brought between the lowest and highest height that each
//! element's sides leave, one after the other in the order of the list: where they agree that is
//! their joint envelope, and where they contradict each other the later one wins, without a jump.
//! Brushes act on what the elements before them made; elements narrower than two samples act by
//! the share of a sample that they cover, on top of what lies below them in the list.

use std::sync::Arc;

use core::f64::consts::PI;

use relievo_planet::{MapPoint, Planet};

use crate::frame::MapRect;
use crate::index::MapIndex;
use crate::patch::{Patch, Window};
use crate::prepared::{Form, Shaped};
use crate::solid::{Hit, Scratch, Solid};

/// How an element came to decide a height.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Part {
    /// Inside: its own surface.
    Interior,
    /// Its side slope lowered the ground.
    Cut,
    /// Its side slope raised the ground.
    Fill,
    /// A side slope next to a boundary that is steeper than it: it ends in walls.
    Wall,
    /// A stroke.
    Brush,
}

/// A height, and which element decided it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Metres above the datum.
    pub height_m: f64,
    /// Position in the list of the last element that changed it, and how; `None` for the ground.
    pub by: Option<(u32, Part)>,
}

/// Where heights are wanted.
#[derive(Clone, Copy, Debug)]
pub enum Samples<'a> {
    /// Columns crossed with rows of the map, row by row: longitudes and colatitudes in radians.
    Map {
        /// Longitude of each column.
        lon_rad: &'a [f64],
        /// Colatitude of each row.
        colat_rad: &'a [f64],
    },
    /// Places row by row, `width` in each row; neighbours should lie close together.
    Places {
        /// All places; a whole number of rows.
        places: &'a [MapPoint],
        /// Places in a row.
        width: usize,
    },
}

/// Safety against rounding of an element's rectangles, metres.
const SLACK_M: f64 = 1e-3;

/// Side of the pieces that are evaluated together, samples.
const BLOCK: usize = 16;

/// A list of elements with heights, the first at the bottom.
#[derive(Clone, Debug)]
pub struct Design {
    planet: Planet,
    elements: Vec<Arc<Shaped>>,
    index: MapIndex,
}

impl Design {
    /// The elements in the order of the list: later ones win.
    pub fn new(planet: Planet, elements: Vec<Arc<Shaped>>) -> Self {
        Self {
            planet,
            index: MapIndex::new(elements.iter().map(|e| e.reach())),
            elements,
        }
    }

    /// The elements.
    pub fn elements(&self) -> &[Arc<Shaped>] {
        &self.elements
    }

    /// The exact height at a place whose ground has a height: that of an infinitely fine sample.
    pub fn height(&self, place: MapPoint, ground_m: f64) -> Outcome {
        let mut outcome = [Outcome {
            height_m: ground_m,
            by: None,
        }];
        self.outcomes(
            &Samples::Places {
                places: &[place],
                width: 1,
            },
            0.0,
            &mut outcome,
        );
        outcome[0]
    }

    /// Replaces the ground's heights, in metres, by the design's. `spacing_m` is the side of a
    /// sample on the ground: elements narrower than two of them act by area coverage; 0 for exact
    /// heights.
    ///
    /// The same to the bit for any division into calls.
    ///
    /// # Panics
    /// If there are not as many heights as samples.
    pub fn outcomes(&self, samples: &Samples, spacing_m: f64, outcomes: &mut [Outcome]) {
        match *samples {
            Samples::Map { lon_rad, colat_rad } => {
                assert_eq!(
                    outcomes.len(),
                    lon_rad.len() * colat_rad.len(),
                    "a height a sample"
                );
                let width = lon_rad.len();
                for (band, rows) in colat_rad.chunks(BLOCK).enumerate() {
                    for (column, columns) in lon_rad.chunks(BLOCK).enumerate() {
                        let first = band * BLOCK * width + column * BLOCK;
                        let patch = Patch::Map {
                            lon_rad: columns,
                            colat_rad: rows,
                        };
                        let ends = |all: &[f64]| {
                            let far = |low: f64, v: &f64| low.min(*v);
                            let low = all.iter().fold(f64::INFINITY, far);
                            (
                                low,
                                all.iter().fold(f64::NEG_INFINITY, |high, v| high.max(*v)),
                            )
                        };
                        let ((west, east), (north, south)) = (ends(columns), ends(rows));
                        let corners = [(west, north), (east, south)];
                        let rect = MapRect::of_places(
                            corners
                                .into_iter()
                                .map(|(lon, colat)| MapPoint::new(lon, colat)),
                        )
                        .filter(|_| east - west < 1.0 && north >= 0.0 && south <= PI);
                        self.block(
                            &patch,
                            rect,
                            spacing_m,
                            (first, columns.len(), width),
                            outcomes,
                        );
                    }
                }
            }
            Samples::Places { places, width } => {
                assert_eq!(outcomes.len(), places.len(), "a height a sample");
                let mut piece = Vec::new();
                let height = places.len().checked_div(width).unwrap_or(0);
                for row in (0..height).step_by(BLOCK) {
                    for column in (0..width).step_by(BLOCK) {
                        let columns = BLOCK.min(width - column);
                        piece.clear();
                        for r in row..(row + BLOCK).min(height) {
                            let from = r * width + column;
                            piece.extend_from_slice(&places[from..from + columns]);
                        }
                        let first = row * width + column;
                        let patch = Patch::Places(&piece);
                        let rect = MapRect::of_places(piece.iter().copied());
                        self.block(&patch, rect, spacing_m, (first, columns, width), outcomes);
                    }
                }
            }
        }
    }

    fn block(
        &self,
        patch: &Patch,
        rect: Option<MapRect>,
        spacing_m: f64,
        (first, columns, width): (usize, usize, usize),
        outcomes: &mut [Outcome],
    ) {
        let grown = rect.map(|r| r.grow(&self.planet, spacing_m));
        let near: Vec<u32> = match &grown {
            Some(rect) => self.index.touching(rect),
            None => (0..self.elements.len() as u32).collect(),
        };
        let mut scratch = Scratch::default();
        let mut hits: Vec<Hits> = Vec::new();
        for e in near {
            let shaped = &self.elements[e as usize];
            let mut of = Hits {
                number: e,
                form: &shaped.form,
                window: patch.whole(),
                found: Vec::new(),
            };
            let acts = match &shaped.form {
                Form::Solid(solid) => {
                    let around = is_narrow(solid, spacing_m).then_some(spacing_m);
                    if rect.is_some() {
                        let boxes = shaped.reach().iter();
                        let boxes = boxes.map(|b| b.grow(&self.planet, around.unwrap_or(SLACK_M)));
                        of.window = patch.window(boxes);
                    }
                    let part = patch.part(&of.window);
                    part.len() > 0 && solid.evaluate(&part, around, &mut scratch, &mut of.found)
                }
                Form::Brush(_) => true,
                Form::Nothing => false,
            };
            if acts {
                hits.push(of);
            }
        }
        if hits.is_empty() {
            return;
        }
        let place = |k: usize| first + k / columns * width + k % columns;
        let count = patch.len();
        let ground: Vec<f64> = (0..count).map(|k| outcomes[place(k)].height_m).collect();
        let mut heights = ground.clone();
        let mut by: Vec<Option<(u32, Part)>> = vec![None; count];
        // The last inside counts, and everything below it does not.
        let mut inside: Vec<Option<u32>> = vec![None; count];
        for of in hits.iter().rev() {
            let Form::Solid(solid) = of.form else {
                continue;
            };
            if is_narrow(solid, spacing_m) {
                continue;
            }
            for (k, hit) in of.samples(columns) {
                if let (None, Some(surface)) = (inside[k], hit.inside_m) {
                    inside[k] = Some(of.number);
                    heights[k] = solid.inside(surface, ground[k]);
                    by[k] = Some((of.number, Part::Interior));
                }
            }
        }
        let mut acts = vec![true; count];
        for of in &hits {
            let number = of.number;
            match of.form {
                Form::Solid(solid) => {
                    let narrow = is_narrow(solid, spacing_m);
                    for (k, hit) in of.samples(columns) {
                        let done = if narrow {
                            (inside[k].is_none_or(|i| i < number))
                                .then(|| solid.covered(hit, heights[k], spacing_m))
                        } else {
                            inside[k].is_none().then(|| solid.side(hit, heights[k]))
                        };
                        if let Some((height, part)) = done.flatten() {
                            heights[k] = height;
                            by[k] = Some((number, part));
                        }
                    }
                }
                Form::Brush(brush) => {
                    for (act, inside) in acts.iter_mut().zip(&inside) {
                        *act = inside.is_none_or(|i| i < number);
                    }
                    brush.apply(
                        patch,
                        spacing_m,
                        &mut scratch.positions,
                        &mut heights,
                        &acts,
                        |k| by[k] = Some((number, Part::Brush)),
                    );
                }
                Form::Nothing => {}
            }
        }
        for (k, (height_m, by)) in heights.into_iter().zip(by).enumerate() {
            if by.is_some() {
                outcomes[place(k)] = Outcome { height_m, by };
            }
        }
    }
}

/// What an element says in a part of a block.
struct Hits<'a> {
    number: u32,
    form: &'a Form,
    window: Window,
    found: Vec<Hit>,
}

impl Hits<'_> {
    /// Each hit with its place in a block of rows of `columns` samples.
    fn samples(&self, columns: usize) -> impl Iterator<Item = (usize, &Hit)> {
        let Window {
            columns: within,
            rows,
        } = &self.window;
        let width = within.len().max(1);
        let first = rows.start * columns + within.start;
        let places = (0..self.found.len()).map(move |j| first + j / width * columns + j % width);
        places.zip(&self.found)
    }
}

fn is_narrow(solid: &Solid, spacing_m: f64) -> bool {
    solid.width_m < 2.0 * spacing_m
}

impl Solid {
    /// Height inside.
    fn inside(&self, surface_m: f64, ground_m: f64) -> f64 {
        let height = if self.on_ground {
            ground_m + surface_m
        } else {
            surface_m
        };
        // What only raises, or only lowers, leaves the ground where it is beyond that already.
        if (!self.lowers && ground_m > height) || (!self.raises && ground_m < height) {
            ground_m
        } else {
            height
        }
    }

    /// What sides make of a height outside, if anything.
    fn side(&self, hit: &Hit, before_m: f64) -> Option<(f64, Part)> {
        let (low, high, steep) = self.limits(&hit.sides)?;
        if before_m < low {
            Some((low, if steep { Part::Wall } else { Part::Fill }))
        } else if before_m > high {
            Some((high, if steep { Part::Wall } else { Part::Cut }))
        } else {
            None
        }
    }

    /// What an element narrower than two samples makes of a height.
    fn covered(&self, hit: &Hit, before_m: f64, spacing_m: f64) -> Option<(f64, Part)> {
        if hit.sides.distance_m.is_infinite() {
            return None;
        }
        let (share, target) = self.cover(hit, before_m, spacing_m);
        (share > 0.0).then_some((before_m + share * (target - before_m), Part::Interior))
    }
}
