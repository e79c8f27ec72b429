//! Daylight lines: where an element's work ends and the ground goes on.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DVec2, I64Vec2};
use relievo_planet::MapPoint;

use crate::frame::Frame;
use crate::patch::Patch;
use crate::prepared::{Form, Shaped};
use crate::solid::{Hit, Interior, Scratch, Solid};

/// How the work ends along a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Ending {
    /// It meets the ground.
    Meets,
    /// The side slope has not met the ground within its reach: a wall.
    ReachWall,
}

/// A part of where an element's work ends.
#[derive(Clone, Debug, PartialEq)]
pub struct DaylightLine {
    /// How it ends there.
    pub ending: Ending,
    /// Corners of the line in order; the last repeats the first where it closes.
    pub places: Vec<MapPoint>,
}

/// Cells along a side of the blocks that are looked at.
const BLOCK: i64 = 16;

/// Corners of cells that are looked at, about, at most.
const MOST_CORNERS: f64 = 600_000.0;

/// What a corner of a cell says.
#[derive(Clone, Copy)]
struct Corner {
    ground_m: f64,
    acts: bool,
}

/// Horizontal (false) or vertical (true) edge from a corner on.
type EdgeOf = (I64Pair, bool);
type I64Pair = (i64, i64);

/// Answers heights at places, in metres, in their order; NaN where there is none.
pub type HeightsOf<'a, E> = dyn FnMut(&[MapPoint]) -> Result<Vec<f64>, E> + 'a;

impl Shaped {
    /// Lines along which the element's work, taken alone, ends: where slopes meet the ground, and
    /// walls where they do not within their reach. Found on cells of `spacing_m` metres (more where
    /// the element is large); crossings are exact for ground linear along their sides. Empty for
    /// brushes.
    ///
    /// `ground` answers heights at places, in metres, in their order; NaN where there is none.
    ///
    /// # Errors
    /// Those of `ground`.
    pub fn daylight<E>(
        &self,
        spacing_m: f64,
        ground: &mut HeightsOf<'_, E>,
    ) -> Result<Vec<DaylightLine>, E> {
        let Form::Solid(solid) = &self.form else {
            return Ok(Vec::new());
        };
        let Some(cells) = Cells::around(solid, spacing_m) else {
            return Ok(Vec::new());
        };
        let mut crossings: BTreeMap<EdgeOf, (DVec2, Ending)> = BTreeMap::new();
        let mut links: BTreeMap<EdgeOf, Vec<EdgeOf>> = BTreeMap::new();
        for block in &cells.blocks {
            let first = I64Vec2::new(block.0, block.1) * BLOCK;
            let side = BLOCK + 1;
            let places: Vec<MapPoint> = (0..side * side)
                .map(|k| cells.place(first + I64Vec2::new(k % side, k / side)))
                .collect();
            let heights = ground(&places)?;
            let acts = acting(solid, &places, &heights);
            let corner = |at: I64Vec2| {
                let k = ((at.y - first.y) * side + at.x - first.x) as usize;
                Corner {
                    ground_m: heights[k],
                    acts: acts[k].0,
                }
            };
            for y in first.y..first.y + BLOCK {
                for x in first.x..first.x + BLOCK {
                    cells.cell(
                        solid,
                        I64Vec2::new(x, y),
                        &corner,
                        &mut crossings,
                        &mut links,
                    );
                }
            }
        }
        Ok(lines(&cells.frame, &crossings, links))
    }
}

/// Whether the element acts at places, and whether they lie beyond its reach.
fn acting(solid: &Solid, places: &[MapPoint], ground: &[f64]) -> Vec<(bool, bool)> {
    let mut scratch = Scratch::default();
    let mut hits: Vec<Hit> = Vec::new();
    if !solid.evaluate(&Patch::Places(places), None, &mut scratch, &mut hits) {
        return vec![(false, true); places.len()];
    }
    hits.iter()
        .zip(ground)
        .map(|(hit, ground)| {
            if let Some(surface) = hit.inside_m {
                let stays =
                    (!solid.raises && surface >= *ground) || (!solid.lowers && surface <= *ground);
                return (!stays, false);
            }
            match solid.limits(&hit.sides) {
                Some((low, high, _)) => (*ground < low || *ground > high, false),
                None => (false, solid.slopes.is_some()),
            }
        })
        .collect()
}

/// Cells near a boundary.
struct Cells {
    frame: Frame,
    step: f64,
    blocks: BTreeSet<I64Pair>,
}

impl Cells {
    fn around(solid: &Solid, spacing_m: f64) -> Option<Self> {
        let first = solid.parts.first()?;
        let frame = first.frame;
        let reach = solid.reach_m;
        // Boundary and inside, as boxes of the common frame.
        let mut boxes: Vec<(DVec2, DVec2)> = Vec::new();
        for part in &solid.parts {
            let common = |p: DVec2| {
                if part.frame == frame {
                    p
                } else {
                    frame.from_map(part.frame.to_map(p))
                }
            };
            // Neighbours along the boundary share a box, long lines are cut: no box is much larger
            // than the reach, and there are few.
            let large = reach.max(50.0);
            let mut open: Option<(DVec2, DVec2)> = None;
            for (a, b) in part.envelope.lines() {
                let pieces = ((b - a).length() / large).ceil().clamp(1.0, 1000.0);
                for k in 0..pieces as usize {
                    let (s, t) = (k as f64 / pieces, (k + 1) as f64 / pieces);
                    let (p, q) = (common(a + (b - a) * s), common(a + (b - a) * t));
                    let (min, max) = (p.min(q), p.max(q));
                    open = Some(match open {
                        Some((low, high))
                            if (high.max(max) - low.min(min)).max_element() <= 2.0 * large =>
                        {
                            (low.min(min), high.max(max))
                        }
                        full => {
                            boxes.extend(full.map(|(low, high)| (low - reach, high + reach)));
                            (min, max)
                        }
                    });
                }
            }
            boxes.extend(open.map(|(low, high)| (low - reach, high + reach)));
            if let Interior::Strip(_) = part.interior {
                for (a, b) in part.envelope.lines() {
                    boxes.push((common(a.min(b)), common(a.max(b))));
                }
            }
        }
        let area: f64 = boxes
            .iter()
            .map(|(min, max)| (*max - *min).element_product().max(0.0))
            .sum::<f64>()
            .min(4e12);
        // Boxes overlap many times, so this is coarser than it need be only for odd shapes.
        let (low, high) = boxes.iter().fold(
            (DVec2::INFINITY, DVec2::NEG_INFINITY),
            |(low, high), (min, max)| (low.min(*min), high.max(*max)),
        );
        let whole = (high - low).element_product().max(0.0);
        let step = spacing_m
            .max(1e-3)
            .max((area.min(whole) / MOST_CORNERS).sqrt());
        let size = step * BLOCK as f64;
        let mut blocks = BTreeSet::new();
        for (min, max) in boxes {
            let (from, to) = ((min - step) / size, (max + step) / size);
            for y in from.y.floor() as i64..=to.y.floor() as i64 {
                for x in from.x.floor() as i64..=to.x.floor() as i64 {
                    blocks.insert((x, y));
                }
            }
        }
        Some(Self {
            frame,
            step,
            blocks,
        })
    }

    fn point(&self, corner: I64Vec2) -> DVec2 {
        corner.as_dvec2() * self.step
    }

    fn place(&self, corner: I64Vec2) -> MapPoint {
        self.frame.to_map(self.point(corner))
    }

    /// Adds the crossings of a cell's sides and links those that a line joins.
    fn cell(
        &self,
        solid: &Solid,
        at: I64Vec2,
        corner: &dyn Fn(I64Vec2) -> Corner,
        crossings: &mut BTreeMap<EdgeOf, (DVec2, Ending)>,
        links: &mut BTreeMap<EdgeOf, Vec<EdgeOf>>,
    ) {
        let ring = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(x, y)| at + I64Vec2::new(x, y));
        let acts = ring.map(|c| corner(c).acts);
        if acts.iter().all(|a| *a == acts[0]) {
            return;
        }
        let pair = |c: I64Vec2| (c.x, c.y);
        // Sides in order around the cell: bottom, right, top, left.
        let sides: [EdgeOf; 4] = [
            (pair(ring[0]), false),
            (pair(ring[1]), true),
            (pair(ring[3]), false),
            (pair(ring[0]), true),
        ];
        let mut crossed = Vec::with_capacity(4);
        for k in 0..4 {
            let next = (k + 1) % 4;
            if acts[k] == acts[next] {
                continue;
            }
            crossings.entry(sides[k]).or_insert_with(|| {
                let (inner, outer) = if acts[k] { (k, next) } else { (next, k) };
                self.crossing(
                    solid,
                    (self.point(ring[inner]), corner(ring[inner]).ground_m),
                    (self.point(ring[outer]), corner(ring[outer]).ground_m),
                )
            });
            crossed.push(sides[k]);
        }
        // Where work touches corner to corner, lines go around what acts.
        let joined: &[(usize, usize)] = match (crossed.len(), acts[0]) {
            (2, _) => &[(0, 1)],
            (4, true) => &[(0, 3), (1, 2)],
            _ => &[(0, 1), (2, 3)],
        };
        for (a, b) in joined {
            links.entry(crossed[*a]).or_default().push(crossed[*b]);
            links.entry(crossed[*b]).or_default().push(crossed[*a]);
        }
    }

    /// Where work ends between a corner where the element acts and one where it does not.
    fn crossing(
        &self,
        solid: &Solid,
        (mut inner, inner_m): (DVec2, f64),
        (mut outer, outer_m): (DVec2, f64),
    ) -> (DVec2, Ending) {
        let (from, way) = (inner, outer - inner);
        let ground = |p: DVec2| {
            let share = (p - from).length() / way.length();
            inner_m + share * (outer_m - inner_m)
        };
        let mut beyond = false;
        for _ in 0..24 {
            let middle = (inner + outer) * 0.5;
            let place = self.frame.to_map(middle);
            let (acts, far) = acting(solid, &[place], &[ground(middle)])[0];
            if acts {
                inner = middle;
            } else {
                (outer, beyond) = (middle, far);
            }
        }
        if !beyond {
            let place = self.frame.to_map(outer);
            beyond = acting(solid, &[place], &[ground(outer)])[0].1;
        }
        let ending = if beyond {
            Ending::ReachWall
        } else {
            Ending::Meets
        };
        ((inner + outer) * 0.5, ending)
    }
}

/// Joins crossings into lines, split where the ending changes.
fn lines(
    frame: &Frame,
    crossings: &BTreeMap<EdgeOf, (DVec2, Ending)>,
    mut links: BTreeMap<EdgeOf, Vec<EdgeOf>>,
) -> Vec<DaylightLine> {
    let mut all = Vec::new();
    // Open ends first, then what is closed.
    let ends: Vec<EdgeOf> = links
        .iter()
        .filter(|(_, to)| to.len() == 1)
        .map(|(from, _)| *from)
        .collect();
    let starts: Vec<EdgeOf> = ends.into_iter().chain(links.keys().copied()).collect();
    for start in starts {
        let mut chain = vec![start];
        let mut here = start;
        while let Some(next) = links.get_mut(&here).and_then(Vec::pop) {
            if let Some(back) = links.get_mut(&next)
                && let Some(k) = back.iter().position(|b| *b == here)
            {
                back.swap_remove(k);
            }
            chain.push(next);
            here = next;
        }
        if chain.len() < 2 {
            continue;
        }
        let corners: Vec<(MapPoint, Ending)> = chain
            .iter()
            .map(|edge| {
                let (p, ending) = crossings[edge];
                (frame.to_map(p), ending)
            })
            .collect();
        let mut run: Vec<MapPoint> = vec![corners[0].0];
        let mut ending = corners[1].1;
        for pair in corners.windows(2) {
            // A stretch is a wall if its end is.
            if pair[1].1 != ending {
                all.push(DaylightLine {
                    ending,
                    places: core::mem::replace(&mut run, vec![pair[0].0]),
                });
                ending = pair[1].1;
            }
            run.push(pair[1].0);
        }
        all.push(DaylightLine {
            ending,
            places: run,
        });
    }
    all.retain(|line| line.places.len() > 1);
    all
}
