//! Lines with a width: outlined in metres on the ground, each vertex with the scale of its own
//! latitude, so that a stroke is as wide along meridians as across them, near the poles too.

use core::f64::consts::{FRAC_PI_2, TAU};
use std::sync::LazyLock;

use glam::DVec2;

use super::canvas::{CELL, Canvas, Path};
use super::outline::bend;
use super::plane::{Plane, Window};
use super::{DrawError, Painter, Shown};
use crate::features::{Bounds, Shape, Visit, Walker, on_antimeridian};
use crate::style::Length;

/// Half a stroke is drawn at most this wide, in samples: more covers any cell.
const WIDEST: f64 = 4096.0;

/// A bend whose gap is smaller than this many samples needs no round join.
const GAP: f64 = 0.08;

/// Dashes with a period below this many samples are drawn as an even, lighter line.
const FINEST_PERIOD: f64 = 1.5;

/// A vertex of a line in samples of the cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    at: DVec2,
    /// Samples to a metre.
    scale: DVec2,
    /// Metres along the line.
    along_m: f64,
}

/// Dashes and gaps in metres.
struct Dashes {
    lengths_m: Vec<f64>,
    period_m: f64,
}

impl Painter<'_> {
    /// The mask of the lines and rings among the hits with a width, as one shape. Returns how much
    /// of the colour shows: a stroke narrower than a sample is drawn a sample wide and fainter.
    pub(super) fn stroke(
        &self,
        shown: &[Shown],
        width_m: f64,
        dashed: bool,
        canvas: &mut Canvas,
    ) -> Result<f64, DrawError> {
        let sample_m = self.plane.sample_m;
        let drawn_m = width_m.max(sample_m);
        let mut fade = width_m / drawn_m;
        let mut dashes = if dashed { self.dashes() } else { None };
        if let Some(d) = &dashes
            && d.period_m < FINEST_PERIOD * sample_m
        {
            let drawn: f64 = d.lengths_m.iter().step_by(2).sum();
            fade *= drawn / d.period_m;
            dashes = None;
        }
        let path = canvas.path();
        let mut stroker = Stroker {
            half_m: 0.5 * drawn_m,
            joins: dashes.is_none(),
            path,
            corners: Vec::new(),
        };
        let mut runs = Runs::default();
        let (mut line, mut pieces) = (Vec::new(), Pieces::default());
        let lines = |shape| shape != Shape::Points;
        self.each(shown, lines, |shown| {
            let Shown {
                sheet,
                window,
                hit,
                part,
            } = *shown;
            runs.clip = window.reached.turned(-hit.turns);
            if part.bounds.size().cmplt(self.speck(&runs.clip)).all() {
                self.speckle_line(shown, drawn_m, stroker.path);
                return;
            }
            if dashes.is_none() && self.blot(shown, stroker.half_m, stroker.path) {
                return;
            }
            runs.tolerance = self.tolerance(&runs.clip);
            runs.rings = part.shape != Shape::Line;
            let lengths = dashes.as_ref().map(|_| sheet.lengths(&self.drawing.planet));
            runs.lengths = lengths.map(|l| &l[part.first_vertex()..]);
            runs.clear();
            sheet.features.walk(part, &mut runs);
            let turn = DVec2::new(f64::from(hit.turns) * TAU, 0.0);
            for run in runs.all() {
                place(self.plane, window, turn, run, &mut line);
                pieces.cut(&line, stroker.half_m);
                for piece in pieces.all() {
                    match &dashes {
                        None => stroker.line(piece),
                        Some(dashes) => stroker.dashes(piece, dashes),
                    }
                }
            }
        })?;
        canvas.fill();
        Ok(fade)
    }

    /// A line's area of a width.
    fn speckle_line(&self, shown: &Shown, width_m: f64, path: &mut Path) {
        let (window, part) = (shown.window, shown.part);
        let centre = part.bounds.centre();
        let turn = DVec2::new(f64::from(shown.hit.turns) * TAU, 0.0);
        let Some(at) = self.plane.sample(window, centre + turn) else {
            return;
        };
        let metres = self.plane.planet.metres_per_radian(FRAC_PI_2 - centre.y);
        let edges = shown.sheet.features.vertices_of(part).windows(2);
        let length_m: f64 = edges.map(|e| ((e[1] - e[0]) * metres).length()).sum();
        let scale = self.plane.samples_per_m(centre);
        path.speck(at, length_m * width_m * scale.x * scale.y);
    }

    fn dashes(&self) -> Option<Dashes> {
        let style = &self.drawing.style;
        let pixels = matches!(style.stroke_width, Some(Length::Pixels(_)));
        let unit_m = if pixels { self.plane.sample_m } else { 1.0 };
        let mut lengths_m: Vec<f64> = style
            .dash
            .iter()
            .map(|d| if *d > 0.0 { d.min(1e9) * unit_m } else { 0.0 })
            .collect();
        if lengths_m.len() % 2 == 1 {
            lengths_m.extend_from_within(..);
        }
        let period_m: f64 = lengths_m.iter().sum();
        let gaps: f64 = lengths_m.iter().skip(1).step_by(2).sum();
        (gaps > 0.0).then_some(Dashes {
            lengths_m,
            period_m,
        })
    }
}

/// Adds a closed polygon's outline with a width, in samples of the cell, to the path.
pub(super) fn outline_of(path: &mut Path, polygon: &[DVec2], scale: DVec2, width_m: f64) {
    let mut stroker = Stroker {
        half_m: 0.5 * width_m,
        joins: true,
        path,
        corners: Vec::new(),
    };
    let vertex = |at: &DVec2| Vertex {
        at: *at,
        scale,
        along_m: 0.0,
    };
    let line: Vec<Vertex> = polygon.iter().chain(polygon.first()).map(vertex).collect();
    stroker.line(&line);
}

/// Vertices that follow each other, in longitude and latitude, with metres along the line.
type Run = Vec<(DVec2, f64)>;

/// Collects what a box shows of a line.
#[derive(Default)]
struct Runs<'a> {
    clip: Bounds,
    tolerance: DVec2,
    /// Whether edges along the antimeridian and the poles are left out: they are where somebody cut
    /// a polygon, not where it ends.
    rings: bool,
    lengths: Option<&'a [f64]>,
    found: Vec<Run>,
    used: usize,
    /// Whether the next vertex begins a run.
    fresh: bool,
}

impl Runs<'_> {
    fn clear(&mut self) {
        (self.used, self.fresh) = (0, true);
    }

    fn all(&self) -> &[Run] {
        &self.found[..self.used]
    }

    fn begin(&mut self, vertex: DVec2, along_m: f64) {
        if self.used == self.found.len() {
            self.found.push(Vec::new());
        }
        let run = &mut self.found[self.used];
        run.clear();
        run.push((vertex, along_m));
        self.used += 1;
        self.fresh = false;
    }
}

impl Walker for Runs<'_> {
    fn look(&mut self, bounds: &Bounds) -> Visit {
        if !self.clip.overlaps(bounds) {
            Visit::Skip
        } else if bounds.size().cmplt(self.tolerance).all() {
            Visit::Chord
        } else {
            Visit::Open
        }
    }

    fn chain(&mut self, vertices: &[DVec2], at: usize, stride: usize) -> bool {
        let along = |i: usize| self.lengths.map_or(0.0, |l| l[at + i * stride]);
        let first = vertices[0];
        let first_along = along(0);
        if self.fresh {
            self.begin(first, first_along);
        }
        let mut kept = first;
        let last = vertices.len() - 1;
        for (i, v) in vertices.iter().enumerate().skip(1) {
            if i != last && (*v - kept).abs().cmplt(self.tolerance).all() {
                continue;
            }
            let along_m = self.lengths.map_or(0.0, |l| l[at + i * stride]);
            if self.rings && is_cut(kept, *v) {
                self.begin(*v, along_m);
            } else {
                self.found[self.used - 1].push((*v, along_m));
            }
            kept = *v;
        }
        true
    }

    fn skipped(&mut self) {
        self.fresh = true;
    }
}

/// Whether an edge of a ring lies on the antimeridian or on a pole.
fn is_cut(a: DVec2, b: DVec2) -> bool {
    let on_meridian = (a.x - b.x).abs() < 1e-9 && on_antimeridian(a.x) && on_antimeridian(b.x);
    let at_pole = |v: DVec2| v.y.abs() > FRAC_PI_2 - 1e-9;
    on_meridian || (at_pole(a) && at_pole(b))
}

/// A run in samples of the cell, bent as the projection bends it.
fn place(plane: &Plane, window: &Window, turn: DVec2, run: &Run, line: &mut Vec<Vertex>) {
    line.clear();
    let mut between = Vec::new();
    let mut before: Option<(DVec2, f64)> = None;
    for (lonlat, along_m) in run {
        let lonlat = *lonlat + turn;
        let Some(at) = plane.sample(window, lonlat) else {
            before = None;
            continue;
        };
        let scale = plane.samples_per_m(lonlat);
        if let Some((from, from_m)) = before
            && !plane.is_map()
        {
            between.clear();
            bend(plane, window, from, lonlat, 6, &mut between);
            let count = between.len() as f64 + 1.0;
            for (i, at) in between.iter().enumerate() {
                let share = (i + 1) as f64 / count;
                let along_m = from_m + (along_m - from_m) * share;
                line.push(Vertex {
                    at: *at,
                    scale,
                    along_m,
                });
            }
        }
        line.push(Vertex {
            at,
            scale,
            along_m: *along_m,
        });
        before = Some((lonlat, *along_m));
    }
}

/// The pieces of a line near the cell: long edges are cut, so that no coordinate is large.
#[derive(Default)]
struct Pieces {
    vertices: Vec<Vertex>,
    starts: Vec<usize>,
}

impl Pieces {
    fn cut(&mut self, line: &[Vertex], half_m: f64) {
        self.vertices.clear();
        self.starts.clear();
        let reach = line
            .iter()
            .map(|v| (half_m * v.scale).min(DVec2::splat(WIDEST)))
            .fold(DVec2::ZERO, DVec2::max)
            + 8.0;
        let (low, high) = (-reach, DVec2::splat(CELL as f64) + reach);
        if let [only] = line {
            self.starts.push(0);
            self.vertices.push(*only);
        }
        for edge in line.windows(2) {
            let Some([a, b]) = shortened(edge[0], edge[1], low, high) else {
                continue;
            };
            if self.starts.is_empty() || self.vertices.last().is_none_or(|v| v.at != a.at) {
                self.starts.push(self.vertices.len());
                self.vertices.push(a);
            }
            self.vertices.push(b);
        }
    }

    fn all(&self) -> impl Iterator<Item = &[Vertex]> {
        let ends = self.starts.iter().skip(1).copied();
        let ends = ends.chain([self.vertices.len()]);
        self.starts
            .iter()
            .zip(ends)
            .map(|(start, end)| &self.vertices[*start..end])
    }
}

/// The part of an edge between two corners (Liang and Barsky).
fn shortened(a: Vertex, b: Vertex, low: DVec2, high: DVec2) -> Option<[Vertex; 2]> {
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    let d = b.at - a.at;
    for axis in 0..2 {
        for (step, room) in [
            (-d[axis], a.at[axis] - low[axis]),
            (d[axis], high[axis] - a.at[axis]),
        ] {
            if step == 0.0 {
                if room < 0.0 {
                    return None;
                }
            } else if step < 0.0 {
                from = from.max(room / step);
            } else {
                to = to.min(room / step);
            }
        }
    }
    if from > to {
        return None;
    }
    let at = |share: f64| {
        if share <= 0.0 {
            a
        } else if share >= 1.0 {
            b
        } else {
            Vertex {
                at: a.at + d * share,
                scale: a.scale + (b.scale - a.scale) * share,
                along_m: a.along_m + (b.along_m - a.along_m) * share,
            }
        }
    };
    Some([at(from), at(to)])
}

/// Outlines lines as polygons of one direction, whose union is the stroke.
struct Stroker<'a> {
    half_m: f64,
    joins: bool,
    path: &'a mut Path,
    /// Room for a polygon.
    corners: Vec<DVec2>,
}

impl Stroker<'_> {
    /// A line with round ends and joins.
    fn line(&mut self, line: &[Vertex]) {
        let mut before: Option<DVec2> = None;
        let mut roomy = false;
        for (i, v) in line.iter().enumerate() {
            let after = line.get(i + 1).and_then(|next| direction(v, next));
            let is_roomy = |next| self.is_roomy(v, next);
            let roomy_after = line.get(i + 1).is_some_and(is_roomy);
            match (before, after) {
                (Some(before), Some(after)) if self.joins && roomy && roomy_after => {
                    self.wedge(v, before, after);
                }
                _ if self.joins && self.needs_join(v, before, after) => self.disc(v),
                _ => {}
            }
            if let Some(next) = line.get(i + 1) {
                if let Some(along) = after {
                    self.edge(v, next, along);
                    roomy = roomy_after;
                }
                before = after.or(before);
            }
        }
    }

    /// Whether an edge is as long as the stroke is wide: then it covers what a join has on the inner
    /// side of a bend.
    fn is_roomy(&self, a: &Vertex, b: &Vertex) -> bool {
        let d = (b.at - a.at) / (0.5 * (a.scale + b.scale));
        d.length_squared() > 4.0 * self.half_m * self.half_m
    }

    /// The round outer side of a bend.
    fn wedge(&mut self, v: &Vertex, before: DVec2, after: DVec2) {
        let radii = self.radii(v);
        let radius = radii.max_element();
        if before.dot(after) >= 0.0 && (after - before).length() * radius <= GAP {
            return;
        }
        let outside = if before.perp_dot(after) > 0.0 {
            -1.0
        } else {
            1.0
        };
        let aside = |along: DVec2| outside * DVec2::new(-along.y, along.x);
        let (from, to) = (aside(before), aside(after));
        self.corners.clear();
        self.corners.extend([v.at, v.at + from * radii]);
        arc(from, to, radius, &mut |u| {
            self.corners.push(v.at + u * radii);
        });
        self.corners.push(v.at + to * radii);
        self.path.polygon(&self.corners);
    }

    /// Pieces of a line, cut off straight.
    fn dashes(&mut self, line: &[Vertex], dashes: &Dashes) {
        let (Some(first), Some(last)) = (line.first(), line.last()) else {
            return;
        };
        let (from_m, to_m) = (first.along_m, last.along_m);
        // Dashes near the cell, of lines that are a million of them long.
        let mut start_m = libm::floor(from_m / dashes.period_m) * dashes.period_m;
        let mut piece: Vec<Vertex> = Vec::new();
        let mut edge = 0;
        while start_m < to_m {
            let mut at_m = start_m;
            for pair in dashes.lengths_m.chunks_exact(2) {
                let (begin, end) = (at_m.max(from_m), (at_m + pair[0]).min(to_m));
                at_m += pair[0] + pair[1];
                if begin >= end {
                    continue;
                }
                while edge + 2 < line.len() && line[edge + 1].along_m <= begin {
                    edge += 1;
                }
                piece.clear();
                piece.push(between(&line[edge], &line[edge + 1], begin));
                let mut k = edge;
                while k + 2 < line.len() && line[k + 1].along_m < end {
                    k += 1;
                    piece.push(line[k]);
                }
                piece.push(between(&line[k], &line[k + 1], end));
                self.joined(&piece);
            }
            start_m += dashes.period_m;
        }
    }

    /// A line with round joins and straight ends.
    fn joined(&mut self, piece: &[Vertex]) {
        for (i, edge) in piece.windows(2).enumerate() {
            let Some(along) = direction(&edge[0], &edge[1]) else {
                continue;
            };
            if i > 0 {
                self.disc(&edge[0]);
            }
            self.edge(&edge[0], &edge[1], along);
        }
    }

    fn needs_join(&self, v: &Vertex, before: Option<DVec2>, after: Option<DVec2>) -> bool {
        let (Some(before), Some(after)) = (before, after) else {
            return true;
        };
        let radius = self.half_m * v.scale.max_element();
        let gap = (after - before).length() * radius;
        before.dot(after) < 0.0 || gap > GAP
    }

    /// One edge as a polygon. `along` is its direction in metres.
    fn edge(&mut self, a: &Vertex, b: &Vertex, along: DVec2) {
        let across = DVec2::new(-along.y, along.x);
        let aside = |v: &Vertex| across * self.radii(v);
        let (na, nb) = (aside(a), aside(b));
        self.path
            .polygon(&[a.at + na, a.at - na, b.at - nb, b.at + nb]);
    }

    fn disc(&mut self, v: &Vertex) {
        let radii = self.radii(v);
        let table = circle(radii.max_element());
        self.corners.clear();
        self.corners.extend(table.iter().map(|u| v.at + *u * radii));
        self.path.polygon(&self.corners);
    }

    fn radii(&self, v: &Vertex) -> DVec2 {
        (self.half_m * v.scale).min(DVec2::splat(WIDEST))
    }
}

/// Unit vectors between two others, where a circle of a radius in samples needs corners to look round.
pub(super) fn arc(from: DVec2, to: DVec2, radius: f64, corner: &mut impl FnMut(DVec2)) {
    let steps = circle(radius).len();
    // A regular polygon's corners are this far apart.
    let apart = (circle(radius)[1] - circle(radius)[0]).length();
    halve(from, to, apart * 1.01, steps, corner);
}

fn halve(from: DVec2, to: DVec2, apart: f64, most: usize, corner: &mut impl FnMut(DVec2)) {
    if most < 2 || (to - from).length() <= apart {
        return;
    }
    let sum = from + to;
    let length = sum.length();
    // Half a turn has no middle: any side will do.
    let middle = if length > 1e-9 {
        sum / length
    } else {
        DVec2::new(-from.y, from.x)
    };
    halve(from, middle, apart, most / 2, corner);
    corner(middle);
    halve(middle, to, apart, most / 2, corner);
}

/// Unit vector from one vertex to another in metres; `None` where they are one.
fn direction(a: &Vertex, b: &Vertex) -> Option<DVec2> {
    let d = (b.at - a.at) / (0.5 * (a.scale + b.scale));
    let length = d.length();
    (length > 0.0).then(|| d / length)
}

/// The vertex at a length along an edge.
fn between(a: &Vertex, b: &Vertex, along_m: f64) -> Vertex {
    let length = b.along_m - a.along_m;
    let share = if length > 0.0 {
        ((along_m - a.along_m) / length).clamp(0.0, 1.0)
    } else {
        0.0
    };
    Vertex {
        at: a.at + (b.at - a.at) * share,
        scale: a.scale + (b.scale - a.scale) * share,
        along_m,
    }
}

/// Corners of a unit circle, enough for a radius in samples to look round; in the direction of
/// edges.
pub(super) fn circle(radius: f64) -> &'static [DVec2] {
    static TABLES: LazyLock<[Vec<DVec2>; 5]> = LazyLock::new(|| {
        [8, 16, 32, 64, 128].map(|corners| {
            (0..corners)
                .map(|i| {
                    let (sin, cos) = libm::sincos(TAU * f64::from(i) / f64::from(corners));
                    DVec2::new(cos, sin)
                })
                .collect()
        })
    });
    let table = [1.5, 6.0, 24.0, 96.0]
        .iter()
        .position(|most| radius < *most)
        .unwrap_or(4);
    &TABLES[table]
}
