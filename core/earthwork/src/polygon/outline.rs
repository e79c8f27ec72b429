//! Rings as drawn: cleaned, cut where they cross, and reduced to what really bounds the area.

use std::collections::{HashMap, HashSet};

use glam::DVec2;
use relievo_planet::MapPoint;

use crate::check;
use crate::frame::Frame;
use crate::rings::{Cut, Rings, cuts, perimeter, twice_area};
use crate::tin::Corner;
use crate::warning::{WarningKind, Warnings};

/// Corners nearer to each other than this are one, metres.
const SAME_M: f64 = 1e-6;

/// Heights that differ by no more agree, metres.
const AGREE_M: f64 = 1e-3;

/// An area's lines in a frame.
#[derive(Clone, Debug)]
pub(crate) struct Outline {
    /// Outline and holes as drawn.
    pub(crate) rings: Vec<Vec<DVec2>>,
    /// The outline's first vertex.
    pub(crate) first: DVec2,
    /// Everything that lines stand on; heights are NaN where nothing says them.
    pub(crate) corners: Vec<Corner>,
    /// Pieces of the boundary, the area to their left.
    pub(crate) boundary: Vec<[u32; 2]>,
    /// Pieces of breaklines inside.
    pub(crate) breaks: Vec<[u32; 2]>,
}

type Line = Vec<(MapPoint, Option<f64>)>;

/// Finds corners by the bits of their coordinates, and settles their heights.
struct Corners {
    all: Vec<Corner>,
    at: HashMap<(u64, u64), u32>,
    /// How many heights were averaged; 0 for a vertex's own.
    crossed: Vec<u32>,
}

impl Corners {
    fn corner(&mut self, p: DVec2) -> u32 {
        let p = p + 0.0;
        *self
            .at
            .entry((p.x.to_bits(), p.y.to_bits()))
            .or_insert_with(|| {
                self.all.push(Corner {
                    at: p,
                    height_m: f64::NAN,
                });
                self.crossed.push(0);
                (self.all.len() - 1) as u32
            })
    }

    /// A vertex says its height; the first one counts.
    fn own(&mut self, i: u32, height: Option<f64>) -> bool {
        let known = &mut self.all[i as usize].height_m;
        match height {
            Some(h) if known.is_nan() => *known = h,
            Some(h) => return (*known - h).abs() <= AGREE_M,
            None => {}
        }
        true
    }

    /// A line passes at a height.
    fn passing(&mut self, i: u32, height: f64) -> bool {
        let known = self.all[i as usize].height_m;
        let n = &mut self.crossed[i as usize];
        if height.is_nan() {
            return true;
        }
        if known.is_nan() {
            (self.all[i as usize].height_m, *n) = (height, 1);
            return true;
        }
        let agrees = (known - height).abs() <= AGREE_M;
        if *n > 0 {
            *n += 1;
            self.all[i as usize].height_m += (height - known) / f64::from(*n);
        }
        agrees
    }
}

impl Outline {
    /// `None` if no ring is left. `heights`: whether those of vertices count.
    pub(crate) fn new(
        frame: &Frame,
        rings: &[Line],
        lines: &[Line],
        heights: bool,
        warnings: &mut Warnings,
    ) -> Option<Self> {
        let mut cleaned: Vec<Vec<(DVec2, Option<f64>)>> = Vec::new();
        for (k, ring) in rings.iter().enumerate() {
            let ring = clean(frame, ring, true, warnings);
            if ring.len() >= 3 {
                cleaned.push(ring);
            } else if k == 0 {
                warnings.add(WarningKind::NoExtent, rings[0].first().map(|v| v.0));
                return None;
            } else if !rings[k].is_empty() {
                warnings.add(WarningKind::HoleOutside, rings[k].first().map(|v| v.0));
            }
        }
        let ring_count = cleaned.len();
        cleaned.extend(
            lines
                .iter()
                .map(|l| clean(frame, l, false, warnings))
                .filter(|l| l.len() >= 2),
        );
        if heights {
            for v in cleaned.iter_mut().flatten() {
                v.1 = check::height(v.1, warnings);
            }
        }
        let first = cleaned[0][0].0;
        let points: Vec<Vec<DVec2>> = cleaned[..ring_count]
            .iter()
            .map(|r| r.iter().map(|v| v.0).collect())
            .collect();
        let mut outline = Self {
            first,
            corners: Vec::new(),
            boundary: Vec::new(),
            breaks: Vec::new(),
            rings: points,
        };
        outline.cut(frame, &cleaned, ring_count, heights, warnings);
        let (width, _) = outline.size_m();
        if width < 1e-3 {
            warnings.add(WarningKind::Sliver, Some(frame.to_map(first)));
        }
        if outline.boundary.is_empty() {
            warnings.add(WarningKind::NoExtent, Some(frame.to_map(first)));
            return None;
        }
        Some(outline)
    }

    /// Cuts all lines where they meet and sorts the pieces.
    fn cut(
        &mut self,
        frame: &Frame,
        cleaned: &[Vec<(DVec2, Option<f64>)>],
        ring_count: usize,
        heights: bool,
        warnings: &mut Warnings,
    ) {
        // All segments, with the line they belong to and the next vertex along it.
        let mut segments = Vec::new();
        let mut of: Vec<(usize, usize, usize)> = Vec::new();
        for (l, line) in cleaned.iter().enumerate() {
            let closed = l < ring_count;
            for i in 0..line.len() - usize::from(!closed) {
                let next = (i + 1) % line.len();
                segments.push((line[i].0, line[next].0));
                of.push((l, i, next));
            }
        }
        let neighbours = |i: u32, k: u32| {
            let ((la, a, an), (lb, b, bn)) = (of[i as usize], of[k as usize]);
            la == lb && (an == b || bn == a)
        };
        let all = cuts(&segments, neighbours);
        // Breaklines may end on the boundary; rings may not meet.
        let bits = |p: DVec2| (p.x.to_bits(), p.y.to_bits());
        let mut breaks: HashSet<(u64, u64)> = cleaned[ring_count..]
            .iter()
            .flatten()
            .map(|v| bits(v.0))
            .collect();
        let on_ring = |c: &Cut| of[c.on as usize].0 < ring_count;
        breaks.extend(all.iter().filter(|c| !on_ring(c)).map(|c| bits(c.point)));
        for c in all.iter().filter(|c| on_ring(c)) {
            if !breaks.contains(&bits(c.point)) {
                warnings.add(WarningKind::SelfCrossing, Some(frame.to_map(c.point)));
            }
        }
        let mut corners = Corners {
            all: Vec::new(),
            at: HashMap::new(),
            crossed: Vec::new(),
        };
        let mut disagree = Vec::new();
        for v in cleaned.iter().flatten() {
            let i = corners.corner(v.0);
            if heights && !corners.own(i, v.1) {
                disagree.push(v.0);
            }
        }
        let uncut_rings = !all.iter().any(|c| of[c.on as usize].0 < ring_count);
        let rings = Rings::new(&self.rings[0], &self.rings[1..]);
        let mut kept = vec![None; ring_count];
        let mut from_cut = 0;
        for (s, (a, b)) in segments.iter().enumerate() {
            let (line, i, next) = of[s];
            let mut here = from_cut;
            while here < all.len() && all[here].on == s as u32 {
                here += 1;
            }
            let mut before = corners.corner(*a);
            for c in &all[from_cut..here] {
                let corner = corners.corner(c.point);
                if let (true, Some(za), Some(zb)) =
                    (heights, cleaned[line][i].1, cleaned[line][next].1)
                    && !corners.passing(corner, za + c.at * (zb - za))
                {
                    disagree.push(c.point);
                }
                self.piece(
                    &corners,
                    [before, corner],
                    line,
                    &rings,
                    (ring_count, false),
                    &mut kept,
                );
                before = corner;
            }
            from_cut = here;
            let last = corners.corner(*b);
            self.piece(
                &corners,
                [before, last],
                line,
                &rings,
                (ring_count, uncut_rings),
                &mut kept,
            );
        }
        for (hole, kept) in kept.iter().enumerate().skip(1) {
            if *kept == Some(Side::Neither) {
                warnings.add(
                    WarningKind::HoleOutside,
                    Some(frame.to_map(self.rings[hole][0])),
                );
            }
        }
        if self.lost_break(&corners, cleaned, ring_count, &rings) {
            warnings.add(WarningKind::BreaklineOutside, None);
        }
        for p in disagree {
            warnings.add(WarningKind::HeightsDisagree, Some(frame.to_map(p)));
        }
        self.corners = corners.all;
    }

    fn lost_break(
        &self,
        corners: &Corners,
        cleaned: &[Vec<(DVec2, Option<f64>)>],
        ring_count: usize,
        rings: &Rings,
    ) -> bool {
        let bounding: HashSet<u32> = self.boundary.iter().flatten().copied().collect();
        let on_boundary = |p: DVec2| {
            let corner = corners.at.get(&(p.x.to_bits(), p.y.to_bits()));
            corner.is_some_and(|c| bounding.contains(c))
        };
        cleaned[ring_count..]
            .iter()
            .flatten()
            .any(|v| !rings.contains(v.0) && !on_boundary(v.0 + 0.0))
    }

    /// Takes a piece in where it bounds the area, or breaks it inside. Where no ring is cut, one piece
    /// answers for all of its ring.
    fn piece(
        &mut self,
        corners: &Corners,
        piece: [u32; 2],
        line: usize,
        rings: &Rings,
        (ring_count, uncut): (usize, bool),
        kept: &mut [Option<Side>],
    ) {
        if piece[0] == piece[1] {
            return;
        }
        let [a, b] = piece.map(|k| corners.all[k as usize].at);
        if line >= ring_count {
            if rings.contains((a + b) * 0.5) {
                self.breaks.push(piece);
            }
            return;
        }
        let side = match kept[line] {
            Some(side) if uncut => side,
            _ => side_of(rings, a, b),
        };
        // A hole is lost only if all of it is.
        if kept[line].is_none() || side != Side::Neither {
            kept[line] = Some(side);
        }
        match side {
            Side::Left => self.boundary.push(piece),
            Side::Right => self.boundary.push([piece[1], piece[0]]),
            Side::Neither => {}
        }
    }

    /// Splits the boundary into pieces no longer than `spacing_m`.
    pub(crate) fn refine(&mut self, spacing_m: f64) {
        let mut fine = Vec::new();
        for [a, b] in &self.boundary {
            let (from, to) = (self.corners[*a as usize].at, self.corners[*b as usize].at);
            let parts = ((to - from).length() / spacing_m).ceil().clamp(1.0, 1e6) as usize;
            let mut before = *a;
            for k in 1..parts {
                self.corners.push(Corner {
                    at: from + (to - from) * (k as f64 / parts as f64),
                    height_m: f64::NAN,
                });
                let next = (self.corners.len() - 1) as u32;
                fine.push([before, next]);
                before = next;
            }
            fine.push([before, *b]);
        }
        self.boundary = fine;
    }

    fn ends(&self) -> impl Iterator<Item = (DVec2, DVec2)> + '_ {
        let at = |i: u32| self.corners[i as usize].at;
        self.boundary.iter().map(move |[a, b]| (at(*a), at(*b)))
    }

    /// Length of the boundary in metres.
    pub(crate) fn boundary_m(&self) -> f64 {
        self.ends().map(|(a, b)| (b - a).length()).sum()
    }

    /// Width and length of a strip with the same area and boundary.
    pub(crate) fn size_m(&self) -> (f64, f64) {
        let twice: f64 = if self.boundary.is_empty() {
            self.rings.first().map_or(0.0, |r| twice_area(r).abs())
        } else {
            let o = self.first;
            self.ends().map(|(a, b)| (a - o).perp_dot(b - o)).sum()
        };
        let around = if self.boundary.is_empty() {
            self.rings.first().map_or(0.0, |r| perimeter(r))
        } else {
            self.boundary_m()
        };
        let width = (twice / around.max(f64::MIN_POSITIVE)).max(0.0);
        (width, (around / 2.0 - width).max(width))
    }
}

/// On which side of a piece the area lies.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Side {
    Left,
    Right,
    Neither,
}

fn side_of(rings: &Rings, a: DVec2, b: DVec2) -> Side {
    let d = b - a;
    let off = d.perp().normalize_or_zero() * (d.length() * 1e-3).min(1e-3);
    // Slivers thinner than the offset are seen from nearer.
    for near in [1.0, 1e-2, 1e-4] {
        let middle = (a + b) * 0.5;
        let (left, right) = (
            rings.contains(middle + off * near),
            rings.contains(middle - off * near),
        );
        match (left, right) {
            (true, false) => return Side::Left,
            (false, true) => return Side::Right,
            _ => {}
        }
    }
    Side::Neither
}

/// A line in the frame without vertices that stand in one place, nor a repeated end of a ring.
fn clean(
    frame: &Frame,
    line: &[(MapPoint, Option<f64>)],
    closed: bool,
    warnings: &mut Warnings,
) -> Vec<(DVec2, Option<f64>)> {
    let mut kept: Vec<(DVec2, Option<f64>)> = Vec::with_capacity(line.len());
    for (place, height) in line {
        let p = frame.from_map(*place);
        if kept.last().is_some_and(|k| (k.0 - p).length() <= SAME_M) {
            warnings.add(WarningKind::DuplicateVertex, Some(*place));
        } else {
            kept.push((p, *height));
        }
    }
    // Files close rings by repeating the first vertex: nothing to complain about.
    while closed && kept.len() > 1 && (kept[0].0 - kept[kept.len() - 1].0).length() <= SAME_M {
        kept.pop();
    }
    kept
}
