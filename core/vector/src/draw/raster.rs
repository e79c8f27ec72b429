//! Polygons into coverage: which of 8 × 8 points of each sample of a cell lie inside.
//!
//! Every polygon sets its points, so shapes that overlap are one shape, and thousands of buildings in
//! a cell cost what their own edges do. Crossings are computed in f64 from the same end of an edge
//! whichever polygon it belongs to: neighbours leave no point out between them.

use core::ops::Range;

use glam::DVec2;

use super::canvas::CELL;

/// Points along a side of a sample.
const FINE: usize = 8;

/// Points along a side of the cell.
const SIDE: usize = CELL * FINE;

/// Words of a row of points.
const WORDS: usize = SIDE / 64;

/// Points of a sample.
pub(super) const POINTS: u16 = (FINE * FINE) as u16;

/// The points of a cell that are covered.
pub(super) struct Raster {
    /// A bit for each point, row by row; a byte holds a row of a sample's points.
    bits: Vec<u64>,
    /// Rows of samples in which some point is covered.
    rows: Range<usize>,
    /// The polygon that is being gathered.
    edges: Vec<Edge>,
    /// Edges that cross the current row.
    active: Vec<Edge>,
    /// Where they do: the first point to the right, and whether the edge goes up.
    crossings: Vec<u32>,
}

/// An edge of a polygon that crosses rows of points.
#[derive(Clone, Copy)]
struct Edge {
    rows: (u32, u32),
    /// Where it crosses row 0, in points, and how far it goes in a row.
    x: f64,
    step: f64,
    up: u32,
}

impl Edge {
    /// `None` where it crosses no row of the cell.
    fn new(a: DVec2, b: DVec2) -> Option<Self> {
        let up = a.y > b.y;
        let (top, bottom) = if up { (b, a) } else { (a, b) };
        // The first row whose middle is not above; written so that NaN is nowhere.
        let row = |y: f64| libm::ceil(y - 0.5).clamp(0.0, SIDE as f64) as u32;
        let rows = (row(top.y), row(bottom.y));
        if rows.0 >= rows.1 {
            return None;
        }
        let step = (bottom.x - top.x) / (bottom.y - top.y);
        Some(Self {
            rows,
            x: top.x + (0.5 - top.y) * step,
            step,
            up: u32::from(up),
        })
    }

    /// The first point that is not left of it in a row.
    fn crossing(&self, row: u32) -> u32 {
        let x = self.x + f64::from(row) * self.step;
        (x - 0.5).ceil().clamp(0.0, SIDE as f64) as u32
    }
}

impl Raster {
    pub(super) fn new() -> Self {
        Self {
            bits: vec![0; WORDS * SIDE],
            rows: 0..0,
            edges: Vec::new(),
            active: Vec::new(),
            crossings: Vec::new(),
        }
    }

    /// Gathers a ring of the polygon, in samples of the cell, closed by itself.
    pub(super) fn ring(&mut self, points: &[DVec2]) {
        let Some(last) = points.last() else { return };
        if !points.iter().all(|p| p.is_finite()) {
            return;
        }
        let mut before = *last * FINE as f64;
        for p in points {
            let here = *p * FINE as f64;
            self.edges.extend(Edge::new(before, here));
            before = here;
        }
    }

    /// Covers the inside of the rings that were gathered: where their windings do not cancel.
    pub(super) fn fill(&mut self) {
        let mut edges = std::mem::take(&mut self.edges);
        edges.sort_unstable_by_key(|e| e.rows.0);
        let mut waiting = edges.iter().peekable();
        while let Some(first) = waiting.peek() {
            let mut row = first.rows.0;
            let start = row;
            loop {
                while let Some(edge) = waiting.next_if(|e| e.rows.0 == row) {
                    self.active.push(*edge);
                }
                if self.active.is_empty() {
                    break;
                }
                self.row(row);
                row += 1;
                self.active.retain(|e| e.rows.1 > row);
            }
            self.touch(start as usize / FINE..(row as usize).div_ceil(FINE));
        }
        edges.clear();
        self.edges = edges;
    }

    /// Covers what lies between the active edges in a row.
    fn row(&mut self, row: u32) {
        if let [a, b] = self.active[..] {
            let (a, b) = (a.crossing(row), b.crossing(row));
            self.cover(row, a.min(b), a.max(b));
            return;
        }
        self.crossings.clear();
        let crossings = self.active.iter().map(|e| (e.crossing(row) << 1) | e.up);
        self.crossings.extend(crossings);
        self.crossings.sort_unstable();
        let (mut winding, mut from) = (0_i32, 0);
        for i in 0..self.crossings.len() {
            let (x, up) = (self.crossings[i] >> 1, self.crossings[i] & 1);
            if winding == 0 {
                from = x;
            }
            winding += if up == 1 { 1 } else { -1 };
            if winding == 0 {
                self.cover(row, from, x);
            }
        }
    }

    /// Covers points of a row.
    fn cover(&mut self, row: u32, from: u32, to: u32) {
        if from >= to {
            return;
        }
        let line = &mut self.bits[row as usize * WORDS..][..WORDS];
        let (first, last) = (from as usize / 64, (to as usize - 1) / 64);
        let left = u64::MAX << (from % 64);
        let right = u64::MAX >> (63 - (to - 1) % 64);
        if first == last {
            line[first] |= left & right;
        } else {
            line[first] |= left;
            line[first + 1..last].fill(u64::MAX);
            line[last] |= right;
        }
    }

    /// Notes rows of samples in which something is covered.
    pub(super) fn touch(&mut self, rows: Range<usize>) {
        self.rows = if self.rows.is_empty() {
            rows
        } else {
            self.rows.start.min(rows.start)..self.rows.end.max(rows.end)
        };
    }

    /// The rows that were touched, which are then forgotten.
    pub(super) fn take_rows(&mut self) -> Range<usize> {
        std::mem::take(&mut self.rows)
    }

    /// How many points of each sample of a row are covered; none is any more.
    pub(super) fn take_row(&mut self, row: usize, covered: &mut [u8; CELL]) {
        let lines = &mut self.bits[row * FINE * WORDS..][..FINE * WORDS];
        for (word, samples) in covered.chunks_exact_mut(8).enumerate() {
            // Eight samples at a time: a count in each byte.
            let mut counts = 0;
            for line in 0..FINE {
                counts += counts_of_bytes(lines[line * WORDS + word]);
            }
            samples.copy_from_slice(&counts.to_le_bytes());
        }
        lines.fill(0);
    }
}

/// The number of bits in each byte.
fn counts_of_bytes(bits: u64) -> u64 {
    let pairs = bits - ((bits >> 1) & 0x5555_5555_5555_5555);
    let fours = (pairs & 0x3333_3333_3333_3333) + ((pairs >> 2) & 0x3333_3333_3333_3333);
    (fours + (fours >> 4)) & 0x0f0f_0f0f_0f0f_0f0f
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Covered share of all samples together.
    fn area(raster: &mut Raster) -> f64 {
        let mut counts = [0; CELL];
        let mut sum = 0_u64;
        for row in raster.take_rows() {
            raster.take_row(row, &mut counts);
            sum += counts.iter().map(|c| u64::from(*c)).sum::<u64>();
        }
        sum as f64 / f64::from(POINTS)
    }

    /// Whether rings wind around a point.
    fn winds(rings: &[Vec<DVec2>], p: DVec2) -> bool {
        let mut winding = 0;
        for ring in rings {
            for (i, b) in ring.iter().enumerate() {
                let a = ring[(i + ring.len() - 1) % ring.len()];
                let side = (*b - a).perp_dot(p - a);
                if a.y <= p.y && b.y > p.y && side > 0.0 {
                    winding += 1;
                } else if a.y > p.y && b.y <= p.y && side < 0.0 {
                    winding -= 1;
                }
            }
        }
        winding != 0
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]

        #[test]
        fn a_point_is_covered_where_some_polygon_winds_around_it(
            polygons in prop::collection::vec(prop::collection::vec(
                prop::collection::vec((-30.0..300.0_f64, -30.0..300.0_f64), 0..7), 1..3), 1..4),
            looks in prop::collection::vec((0..SIDE as u32, 0..SIDE as u32), 60),
        ) {
            let polygons: Vec<Vec<Vec<DVec2>>> = polygons
                .into_iter()
                .map(|rings| rings.into_iter().map(|r| r.into_iter().map(DVec2::from).collect()).collect())
                .collect();
            let mut raster = Raster::new();
            for rings in &polygons {
                for ring in rings {
                    raster.ring(ring);
                }
                raster.fill();
            }
            for (x, y) in looks {
                let p = (DVec2::new(f64::from(x), f64::from(y)) + 0.5) / FINE as f64;
                let bit = raster.bits[y as usize * WORDS + x as usize / 64] >> (x % 64) & 1;
                prop_assert_eq!(bit == 1, polygons.iter().any(|rings| winds(rings, p)), "{}", p);
            }
        }
    }

    #[test]
    fn areas_are_those_of_the_shapes() {
        let mut raster = Raster::new();
        let square = |a: f64, b: f64| [(a, a), (b, a), (b, b), (a, b)].map(DVec2::from);
        raster.ring(&square(10.0, 20.0));
        let mut hole = square(12.0, 14.0);
        hole.reverse();
        raster.ring(&hole);
        raster.fill();
        // Partly the same place again, and wholly beyond the cell.
        raster.ring(&square(15.0, 25.0));
        raster.fill();
        raster.ring(&square(-50.0, -10.0));
        raster.fill();
        assert_eq!(area(&mut raster), 100.0 - 4.0 + 75.0);
        raster.ring(&square(-1e9, 1e9));
        raster.fill();
        assert_eq!(area(&mut raster), (CELL * CELL) as f64);
        assert_eq!(area(&mut raster), 0.0);
    }

    #[test]
    fn numbers_that_are_none_cover_nothing_that_matters() {
        let mut raster = Raster::new();
        let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300];
        for v in bad {
            raster.ring(&[DVec2::new(v, 1.0), DVec2::new(1.0, v), DVec2::splat(v)]);
            raster.fill();
        }
        assert!(area(&mut raster) <= (CELL * CELL) as f64);
    }
}
