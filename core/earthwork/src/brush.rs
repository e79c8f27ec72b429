//! Brushes: strokes as functions of the distance to their paths.

use glam::DVec2;
use relievo_planet::{MapPoint, Planet};

use crate::check;
use crate::element::{Stroke, Tool};
use crate::footprint::Footprint;
use crate::frame::Frame;
use crate::patch::{Patch, Positions};
use crate::prepared::GroundNeed;
use crate::tree::{Bounds, Tree};
use crate::warning::{WarningKind, Warnings};

/// Radii that are possible, metres.
const RADII_M: core::ops::RangeInclusive<f64> = 0.01..=100_000.0;

/// Nodes of a smoothing stroke's lattice along a radius.
const NODES_PER_RADIUS: f64 = 6.0;

/// Nodes of a smoothing stroke's lattice, at most.
const MOST_NODES: f64 = 400_000.0;

/// A stroke in its frame.
#[derive(Clone, Debug)]
struct Path {
    frame: Frame,
    tool: Tool,
    radius_m: f64,
    /// Radius of full effect.
    core_m: f64,
    lines: Vec<(DVec2, DVec2)>,
    tree: Tree,
    length_m: f64,
}

/// Ground averaged around the nodes of a lattice; NaN where no node is.
#[derive(Clone, Debug)]
struct Smoothed {
    lattice: Lattice,
    heights: Vec<f64>,
}

/// Nodes (i, j) at `origin + (i, j) · step`.
#[derive(Clone, Copy, Debug)]
struct Lattice {
    origin: DVec2,
    step: f64,
    columns: usize,
    rows: usize,
}

/// Strokes that wait for heights of the ground.
#[derive(Clone, Debug)]
pub(crate) struct Draft {
    paths: Vec<Path>,
    /// Lattices of the smoothing strokes, and which nodes have places.
    lattices: Vec<Option<(Lattice, Vec<usize>)>>,
}

/// Strokes, ready for evaluation.
#[derive(Clone, Debug)]
pub(crate) struct Brush {
    strokes: Vec<(Path, Option<Smoothed>)>,
}

fn line_distance((a, b): (DVec2, DVec2), p: DVec2) -> f64 {
    let d = b - a;
    let square = d.length_squared();
    let t = if square > 0.0 {
        ((p - a).dot(d) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (a + d * t - p).length()
}

impl Path {
    fn new(planet: Planet, stroke: &Stroke, warnings: &mut Warnings) -> Option<Self> {
        let places: Vec<MapPoint> = stroke
            .points
            .iter()
            .copied()
            .filter(|p| check::place(*p, warnings))
            .map(MapPoint::normalised)
            .collect();
        let frame = check::frame_amid(planet, places.iter().copied());
        let Some(frame) = frame else {
            warnings.add(WarningKind::NoExtent, None);
            return None;
        };
        let points: Vec<DVec2> = places.iter().map(|p| frame.from_map(*p)).collect();
        let lines: Vec<(DVec2, DVec2)> = if points.len() == 1 {
            vec![(points[0], points[0])]
        } else {
            points.windows(2).map(|w| (w[0], w[1])).collect()
        };
        let radius_m = check::number(stroke.radius_m, &RADII_M, 1.0, warnings);
        let share = check::number(stroke.hardness, &(0.0..=1.0), 0.5, warnings);
        let mut height = |h| check::number(h, &check::HEIGHTS_M, 0.0, warnings);
        let tool = match stroke.tool {
            Tool::Raise { strength_m } => Tool::Raise {
                strength_m: height(strength_m),
            },
            Tool::Lower { strength_m } => Tool::Lower {
                strength_m: height(strength_m),
            },
            Tool::Flatten { height_m, strength } => Tool::Flatten {
                height_m: height(height_m),
                strength: check::number(strength, &(0.0..=1.0), 1.0, warnings),
            },
            Tool::Smooth { strength } => Tool::Smooth {
                strength: check::number(strength, &(0.0..=1.0), 1.0, warnings),
            },
        };
        let bounds: Vec<Bounds> = lines
            .iter()
            .map(|(a, b)| Bounds::flat(a.min(*b), a.max(*b)))
            .collect();
        Some(Self {
            frame,
            tool,
            radius_m,
            core_m: radius_m * share,
            tree: Tree::new(&bounds),
            length_m: lines.iter().map(|(a, b)| (*b - *a).length()).sum(),
            lines,
        })
    }

    fn distance(&self, p: DVec2) -> f64 {
        self.tree.least(
            |b| b.distance(p),
            |i| line_distance(self.lines[i as usize], p),
        )
    }

    /// Weight at a distance: 1 in the core, from there a smooth step down to 0 at the radius.
    #[inline]
    fn weight(&self, distance: f64) -> f64 {
        if distance <= self.core_m {
            return 1.0;
        }
        if distance >= self.radius_m {
            return 0.0;
        }
        let t = (self.radius_m - distance) / (self.radius_m - self.core_m);
        t * t * (3.0 - 2.0 * t)
    }

    /// Mean weight of a sample wider than the stroke.
    fn mean_weight(&self, distance: f64, spacing_m: f64) -> f64 {
        let fade = self.radius_m - self.core_m;
        let integral = |u: f64| {
            let v = u.abs();
            let falling = if v > self.core_m && fade > 0.0 {
                let t = ((self.radius_m - v) / fade).max(0.0);
                // Integral of 3t² − 2t³ from t to 1.
                fade * (0.5 - (t * t * t - t * t * t * t / 2.0))
            } else {
                0.0
            };
            (v.min(self.core_m) + falling).copysign(u)
        };
        let across = (integral(distance + spacing_m / 2.0) - integral(distance - spacing_m / 2.0))
            / spacing_m;
        let along = ((self.length_m + self.core_m + self.radius_m) / spacing_m).min(1.0);
        (across * along).clamp(0.0, 1.0)
    }

    /// What it makes of a height, with a weight.
    #[inline]
    fn act(&self, before: f64, weight: f64, smoothed: Option<f64>) -> f64 {
        match self.tool {
            Tool::Raise { strength_m } => before + weight * strength_m,
            Tool::Lower { strength_m } => before - weight * strength_m,
            Tool::Flatten { height_m, strength } => {
                before + weight * strength * (height_m - before)
            }
            Tool::Smooth { strength } => match smoothed {
                Some(s) if s.is_finite() => before + weight * strength * (s - before),
                _ => before,
            },
        }
    }
}

impl Lattice {
    fn node(&self, i: usize, j: usize) -> DVec2 {
        self.origin + DVec2::new(i as f64, j as f64) * self.step
    }
}

impl Smoothed {
    /// Quadratic spline over the nodes around: smooth, and nowhere outside of their heights.
    fn at(&self, p: DVec2) -> Option<f64> {
        let l = &self.lattice;
        let at = (p - l.origin) / l.step;
        let nearest = (at + 0.5).floor();
        let (i, j) = (nearest.x, nearest.y);
        if i < 1.0 || j < 1.0 || i + 1.0 >= l.columns as f64 || j + 1.0 >= l.rows as f64 {
            return None;
        }
        let weights = |t: f64| {
            let t = t + 0.5;
            [0.5 * (1.0 - t) * (1.0 - t), 0.5 + t - t * t, 0.5 * t * t]
        };
        let (wx, wy) = (weights(at.x - i), weights(at.y - j));
        let mut sum = 0.0;
        for (dj, wy) in wy.iter().enumerate() {
            for (di, wx) in wx.iter().enumerate() {
                let (i, j) = (i as usize + di - 1, j as usize + dj - 1);
                sum += wx * wy * self.heights[j * l.columns + i];
            }
        }
        sum.is_finite().then_some(sum)
    }
}

impl Draft {
    /// Checks strokes; `None` if there is nothing to draw.
    pub(crate) fn new(planet: Planet, strokes: &[Stroke], warnings: &mut Warnings) -> Option<Self> {
        let paths: Vec<Path> = strokes
            .iter()
            .filter_map(|s| Path::new(planet, s, warnings))
            .collect();
        if paths.is_empty() {
            return None;
        }
        let lattices = paths.iter().map(|p| lattice_of(p, warnings)).collect();
        Some(Self { paths, lattices })
    }

    pub(crate) fn footprint(&self) -> Footprint {
        let reach = self.paths.iter().map(|p| p.radius_m).fold(0.0, f64::max);
        let parts = self
            .paths
            .iter()
            .map(|p| (p.frame, p.lines.clone()))
            .collect();
        Footprint::new(parts, None, reach)
    }

    /// Area within the reach, about.
    pub(crate) fn area_m2(&self) -> f64 {
        let area = |p: &Path| 2.0 * p.radius_m * (p.length_m + 2.0 * p.radius_m);
        self.paths.iter().map(area).sum()
    }

    /// Heights of the ground that decide it.
    pub(crate) fn need(&self) -> Option<GroundNeed> {
        let mut need = GroundNeed {
            places: Vec::new(),
            spacing_m: f64::INFINITY,
        };
        for (path, lattice) in self.paths.iter().zip(&self.lattices) {
            if let Some((lattice, nodes)) = lattice {
                need.spacing_m = need.spacing_m.min(lattice.step);
                let place = |n: &usize| {
                    let node = lattice.node(n % lattice.columns, n / lattice.columns);
                    path.frame.to_map(node)
                };
                need.places.extend(nodes.iter().map(place));
            }
        }
        (!need.places.is_empty()).then_some(need)
    }

    /// The strokes; `ground_m` are the heights that [`Self::need`] asks for.
    pub(crate) fn shape(&self, ground_m: &[f64]) -> Brush {
        let mut brush = Brush {
            strokes: Vec::new(),
        };
        let mut used = 0;
        for (path, lattice) in self.paths.iter().zip(&self.lattices) {
            let smoothed = lattice.as_ref().map(|(lattice, nodes)| {
                let mut heights = vec![f64::NAN; lattice.columns * lattice.rows];
                for n in nodes {
                    let node = lattice.node(n % lattice.columns, n / lattice.columns);
                    // With what earlier strokes made of it.
                    let place = path.frame.to_map(node);
                    heights[*n] = brush.height_m(place, ground_m[used]);
                    used += 1;
                }
                Smoothed {
                    lattice: *lattice,
                    heights: blurred(&heights, lattice, path.radius_m / 2.0),
                }
            });
            brush.strokes.push((path.clone(), smoothed));
        }
        brush
    }
}

/// A lattice around a smoothing stroke's path, and its nodes within one and a half radii.
fn lattice_of(path: &Path, warnings: &mut Warnings) -> Option<(Lattice, Vec<usize>)> {
    if !matches!(path.tool, Tool::Smooth { .. }) {
        return None;
    }
    let around = 1.6 * path.radius_m;
    let (mut min, mut max) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for (a, b) in &path.lines {
        min = min.min(a.min(*b));
        max = max.max(a.max(*b));
    }
    let (min, max) = (min - around, max + around);
    let size = max - min;
    let mut step = path.radius_m / NODES_PER_RADIUS;
    let coarsest = (size.x * size.y / MOST_NODES).sqrt();
    if step < coarsest {
        step = coarsest;
        warnings.add(WarningKind::CoarseGround, None);
    }
    let lattice = Lattice {
        origin: min,
        step,
        columns: (size.x / step).ceil() as usize + 1,
        rows: (size.y / step).ceil() as usize + 1,
    };
    let nodes = (0..lattice.columns * lattice.rows)
        .filter(|n| {
            let node = lattice.node(n % lattice.columns, n / lattice.columns);
            path.distance(node) <= around
        })
        .collect();
    Some((lattice, nodes))
}

/// Averages with a bell of standard deviation `radius / 2`, over the nodes that are there.
fn blurred(heights: &[f64], lattice: &Lattice, radius_m: f64) -> Vec<f64> {
    let sigma = (radius_m / 2.0 / lattice.step).max(0.5);
    let far = libm::ceil(2.5 * sigma) as i64;
    let kernel: Vec<f64> = (-far..=far)
        .map(|k| libm::exp(-0.5 * (k as f64 / sigma) * (k as f64 / sigma)))
        .collect();
    let (columns, rows) = (lattice.columns as i64, lattice.rows as i64);
    // Sums of weights and of weighted heights, along rows and then along columns.
    let mut sums: Vec<(f64, f64)> = heights
        .iter()
        .map(|h| if h.is_nan() { (0.0, 0.0) } else { (1.0, *h) })
        .collect();
    for along_rows in [true, false] {
        let from = sums.clone();
        for j in 0..rows {
            for i in 0..columns {
                let mut sum = (0.0, 0.0);
                for (k, w) in (-far..=far).zip(&kernel) {
                    let (x, y) = if along_rows { (i + k, j) } else { (i, j + k) };
                    if (0..columns).contains(&x) && (0..rows).contains(&y) {
                        let v = from[(y * columns + x) as usize];
                        sum.0 += w * v.0;
                        sum.1 += w * v.1;
                    }
                }
                sums[(j * columns + i) as usize] = sum;
            }
        }
    }
    sums.iter()
        .map(|(w, h)| if *w > 0.0 { h / w } else { f64::NAN })
        .collect()
}

impl Brush {
    /// What it makes of a height at a place.
    pub(crate) fn height_m(&self, place: MapPoint, before_m: f64) -> f64 {
        let mut height = before_m;
        for (path, smoothed) in &self.strokes {
            let p = path.frame.from_map(place);
            let weight = path.weight(path.distance(p));
            if weight > 0.0 {
                height = path.act(height, weight, smoothed.as_ref().and_then(|s| s.at(p)));
            }
        }
        height
    }

    /// What it makes of the heights of a patch; calls `touched` for those that it acts on.
    pub(crate) fn apply(
        &self,
        patch: &Patch,
        spacing_m: f64,
        positions: &mut Positions,
        heights: &mut [f64],
        acts: &[bool],
        mut touched: impl FnMut(usize),
    ) {
        let mut near = Vec::new();
        for (path, smoothed) in &self.strokes {
            patch.positions(&path.frame, positions);
            let (centre, radius) = positions.disc();
            let distance = path.distance(centre);
            let narrow = 2.0 * path.radius_m < 2.0 * spacing_m;
            let reach = path.radius_m + if narrow { spacing_m / 2.0 } else { 0.0 };
            if distance > reach + radius + 1e-6 {
                continue;
            }
            let limit = distance + 2.0 * radius + 1e-6;
            near.clear();
            path.tree
                .visit(|b| b.distance(centre) <= limit, |i| near.push(i));
            for (k, p) in positions
                .points
                .iter()
                .enumerate()
                .filter(|(k, _)| acts[*k])
            {
                let distance = near
                    .iter()
                    .map(|i| line_distance(path.lines[*i as usize], *p))
                    .fold(f64::INFINITY, f64::min);
                let weight = if narrow {
                    path.mean_weight(distance, spacing_m)
                } else {
                    path.weight(distance)
                };
                if weight > 0.0 {
                    let smoothed = smoothed.as_ref().and_then(|s| s.at(*p));
                    heights[k] = path.act(heights[k], weight, smoothed);
                    touched(k);
                }
            }
        }
    }
}
