//! From samples of a grid to places in a source: exact at nodes, interpolated between them.
//!
//! Nodes are the samples whose global indices are multiples of [`NODE`]. The four cells of a group
//! share nine nodes; the middle ones tell how far the outer ones would have missed, and a cell a
//! quarter of that. A cell that may miss by more than half of [`Approximation::tolerance_px`] between its
//! corners looks at its own centre and the middles of its edges. With these it has nine nodes of its own:
//! it is bilinear after all, or biquadratic where the group's parabolas foresaw them, or falls into four.
//! All of it depends on global indices only, so blocks and wholes agree bit for bit.

use glam::{DVec2, I64Vec2};
use relievo_planet::{Grid, GridCrs, Lattice, MapPoint, SampleRect};

use super::Approximation;
use super::places::{Nine, Places};
use super::plane::{SourcePlane, lonlat_from_plane, plane_from_lonlat};
use super::window::Scale;
use crate::crs::Crs;
use crate::file::OverviewInfo;
use crate::kernel::{Footprint, Kernel, LANES};

/// Samples between nodes.
pub(crate) const NODE: i64 = LANES as i64;
/// Samples along a cell that does not fall apart any more: each sample of it is projected.
const SMALLEST: i64 = 4;
/// Where the curvature goes from nothing to twice its mean along a cell, places miss the most not in
/// the middle and by 1.026 times as much as there.
const OFF_MIDDLE: f64 = 1.03;
/// Samples along a group of two by two cells.
const GROUP: i64 = 2 * NODE;
/// A patch that needs more pixels at once is done sample by sample.
const LARGEST_WINDOW: i64 = 1 << 22;
/// A footprint this much wider than a pixel is still sampled bilinearly: a tent that widened at
/// once would blur a source that is merely shown in another system at its own resolution.
const SLACK: f64 = 1.25;

/// Samples that are read from the same level with the same kernel.
pub(crate) struct Patch {
    /// The samples, whether or not the rectangle that is asked for holds them all.
    pub(crate) rect: SampleRect,
    pub(crate) scale: Scale,
    pub(crate) footprint: Footprint,
    /// The pixels it needs, unwrapped, at `scale`.
    pub(crate) window: SampleRect,
    /// Relative to the window's corner.
    pub(crate) places: Places<[f32; 2]>,
    /// Places with a coordinate outside of these lie outside of the source, relative to `window`.
    pub(crate) inside: [[f32; 2]; 2],
}

/// The plane a grid is regular in.
pub(crate) enum Target {
    /// Longitude and latitude; degrees if from a named system, else the map's radians.
    Map,
    Degrees,
    Projected(Crs),
    /// The source's own projected system.
    Same,
}

/// Everything that places depend on.
pub(crate) struct Geometry<'a> {
    pub(crate) source: &'a SourcePlane,
    pub(crate) overviews: &'a [OverviewInfo],
    pub(crate) kernel: Kernel,
    pub(crate) approximation: Approximation,
    pub(crate) radius_m: f64,
    pub(crate) lattice: &'a Lattice,
    pub(crate) target: Target,
}

impl Geometry<'_> {
    /// Longitude (any turn) and latitude (beyond ±90 past a pole) in degrees of a continuous
    /// sample index whose centre is the sample's.
    fn degrees(&self, sample: DVec2) -> Option<DVec2> {
        let p = self.lattice.origin + (sample + 0.5) * self.lattice.step;
        match &self.target {
            Target::Map => Some(DVec2::new(p.x.to_degrees(), 90.0 - p.y.to_degrees())),
            Target::Degrees => Some(p),
            Target::Projected(crs) => {
                lonlat_from_plane(crs, p).map(|p| DVec2::new(p.x.to_degrees(), p.y.to_degrees()))
            }
            Target::Same => lonlat_from_plane(&self.source.crs, p)
                .map(|p| DVec2::new(p.x.to_degrees(), p.y.to_degrees())),
        }
    }

    /// The place on the source's plane, NaN where it has none. Longitudes take any turn.
    fn plane(&self, sample: DVec2) -> DVec2 {
        if let Target::Same = self.target {
            return self.lattice.origin + (sample + 0.5) * self.lattice.step;
        }
        let Some(mut p) = self.degrees(sample) else {
            return DVec2::NAN;
        };
        let geographic = self.source.crs.is_geographic();
        // A source that reflects over the poles takes rows beyond them as they are.
        if p.y.abs() > 90.0 && !(geographic && self.source.reflects == [true; 2]) {
            let point = MapPoint::from_degrees(p.x, p.y).normalised();
            p = DVec2::new(point.lon_rad.to_degrees(), point.lat_rad().to_degrees());
        }
        if geographic {
            p
        } else {
            plane_from_lonlat(
                &self.source.crs,
                DVec2::new(p.x.to_radians(), p.y.to_radians()),
            )
            .unwrap_or(DVec2::NAN)
        }
    }

    /// Places of a plane point whose longitude is on the turn nearest to `near_deg`, in pixels.
    fn pixel(&self, mut plane: DVec2, near_deg: f64) -> DVec2 {
        if self.source.crs.is_geographic() {
            plane.x -= 360.0 * ((plane.x - near_deg) / 360.0).round();
        }
        self.source.pixel_from_plane.transform_point2(plane)
    }

    /// Size of a sample on the ground in metres along columns and rows (for the source's own
    /// system: in its unit).
    fn ground_step(&self, centre: DVec2, span: f64) -> DVec2 {
        let step = self.lattice.step.abs();
        match &self.target {
            Target::Same => step,
            Target::Map | Target::Degrees => {
                let lat = self.degrees(centre).map_or(0.0, |p| p.y.to_radians());
                let unit = if let Target::Map = self.target {
                    1.0
                } else {
                    1.0_f64.to_radians()
                };
                step * unit * self.radius_m * DVec2::new(libm::cos(lat).abs(), 1.0)
            }
            Target::Projected(_) => {
                let half = 0.5 * span.max(1.0);
                let length = |offset: DVec2| {
                    let (a, b) = (
                        self.degrees(centre - offset)?,
                        self.degrees(centre + offset)?,
                    );
                    let point = |p: DVec2| MapPoint::from_degrees(p.x, p.y);
                    Some(point(a).angle_to(point(b)) * self.radius_m / (2.0 * half))
                };
                match (length(DVec2::new(half, 0.0)), length(DVec2::new(0.0, half))) {
                    (Some(x), Some(y)) => DVec2::new(x, y),
                    _ => step,
                }
            }
        }
    }

    /// Radius of the kernel along columns and rows in pixels of the full image: a disc on the
    /// ground whose half-value radius is half of the sample's longer side.
    ///
    /// - `change`: change of place per sample along columns and along rows, where known.
    fn radii(&self, centre: DVec2, span: f64, change: Option<[DVec2; 2]>) -> DVec2 {
        let ground = self.ground_step(centre, span);
        let diameter = ground.max_element();
        let radii = if self.source.is_upright_geographic() {
            let lat = self.degrees(centre).map_or(0.0, |p| p.y.to_radians());
            let slimmest = (0.5 * diameter / self.radius_m).clamp(1e-12, 1.0);
            let sin_colat = libm::cos(lat).abs().max(slimmest);
            let m = self.source.plane_from_pixel.matrix2;
            let pixel_m = DVec2::new(m.x_axis.x.abs() * sin_colat, m.y_axis.y.abs())
                .map(f64::to_radians)
                * self.radius_m;
            diameter / pixel_m
        } else if let Some([column, row]) = change {
            let (u, v) = (column / ground.x.max(1e-300), row / ground.y.max(1e-300));
            DVec2::new(libm::hypot(u.x, v.x), libm::hypot(u.y, v.y)) * diameter
        } else {
            DVec2::ONE
        };
        radii.map(|r| if r.is_finite() { r } else { 1.0 })
    }

    /// Pixels of the full image per pixel of an overview.
    fn overview_pixel(&self, overview: usize) -> DVec2 {
        let info = &self.overviews[overview];
        self.source.size / DVec2::new(f64::from(info.width), f64::from(info.height))
    }

    /// The level to read and the kernel there for a kernel of the given radii at full size: the
    /// coarsest overview whose pixels do not exceed the footprint, shrunk further by halves where
    /// there is none, so that radii at the scale are below 2.
    fn scale(&self, radii: DVec2) -> (Scale, Footprint) {
        let fits = |o: &usize| (radii / self.overview_pixel(*o)).min_element() >= 1.0 - 1e-9;
        let mut overview = (0..self.overviews.len()).rev().find(fits).unwrap_or(0);
        while overview + 1 < self.overviews.len()
            && radii.x / self.overview_pixel(overview).x > self.approximation.widest_px
        {
            overview += 1;
        }
        let left = radii / self.overview_pixel(overview);
        let halve = |mut radius: f64| {
            let mut halvings = 0;
            while radius >= 2.0 && halvings < 30 && self.kernel != Kernel::Nearest {
                radius *= 0.5;
                halvings += 1;
            }
            let radius = if radius < SLACK {
                1.0
            } else {
                1.0 + (radius - SLACK) / (2.0 - SLACK)
            };
            (halvings, (radius as f32).clamp(1.0, 2.0))
        };
        let ((shrink_x, radius_x), (shrink_y, radius_y)) = (halve(left.x), halve(left.y));
        (
            Scale {
                overview,
                shrink_x,
                shrink_y,
            },
            Footprint {
                kernel: self.kernel,
                radius_x,
                radius_y,
            },
        )
    }

    /// Pixels of the full image per pixel at a scale.
    pub(crate) fn scale_pixel(&self, scale: Scale) -> DVec2 {
        self.overview_pixel(scale.overview)
            * DVec2::new(
                f64::from(1_u32 << scale.shrink_x),
                f64::from(1_u32 << scale.shrink_y),
            )
    }

    /// All patches that hold a sample of `rect` and see the source.
    pub(crate) fn patches(&self, rect: &SampleRect) -> Vec<Patch> {
        let mut patches = Vec::new();
        if rect.is_empty() {
            return patches;
        }
        let first = rect.min.div_euclid(I64Vec2::splat(GROUP));
        let last = (rect.max - 1).div_euclid(I64Vec2::splat(GROUP));
        // Exact planes of all nodes, each made once.
        let across = (2 * (last.x - first.x + 1) + 1) as usize;
        let down = (2 * (last.y - first.y + 1) + 1) as usize;
        let nodes: Vec<DVec2> = (0..across * down)
            .map(|i| {
                let node = I64Vec2::new((i % across) as i64, (i / across) as i64);
                self.plane((first * GROUP + node * NODE).as_dvec2())
            })
            .collect();
        for gy in first.y..=last.y {
            for gx in first.x..=last.x {
                let group = I64Vec2::new(gx, gy);
                let at = ((group - first) * 2).as_usizevec2();
                let nine = core::array::from_fn(|i| nodes[(at.y + i / 3) * across + at.x + i % 3]);
                self.group(group * GROUP, &nine, rect, &mut patches);
            }
        }
        patches
    }

    /// The patches of a group that begins at sample `start` and has the given nine nodes.
    fn group(
        &self,
        start: I64Vec2,
        nodes: &[DVec2; 9],
        rect: &SampleRect,
        patches: &mut Vec<Patch>,
    ) {
        // The turn of longitudes: the source's for the middle, the middle's for the rest.
        let source_deg = self.source.centre().x;
        let middle_deg = nodes[4].x - 360.0 * ((nodes[4].x - source_deg) / 360.0).round();
        let pixels = nodes.map(|p| self.pixel(p, middle_deg));
        let group = Nine(pixels);
        for (at, corners) in group.quarters() {
            let min = start + at * NODE;
            let cell = SampleRect::at(min.x, min.y, NODE, NODE);
            if cell.overlaps(rect) {
                self.cell(&cell, corners, (&group, at), middle_deg, rect, patches);
            }
        }
    }

    /// The patches of a cell, the quarter `at` of a square with nine nodes.
    fn cell(
        &self,
        cell: &SampleRect,
        corners: [DVec2; 4],
        (around, at): (&Nine, I64Vec2),
        middle_deg: f64,
        rect: &SampleRect,
        patches: &mut Vec<Patch>,
    ) {
        let [nw, ne, sw, se] = corners;
        let side = cell.width() as f64;
        let change = [
            (ne - nw + se - sw) * (0.5 / side),
            (sw - nw + se - ne) * (0.5 / side),
        ];
        let change = Some(change).filter(|c| c[0].is_finite() && c[1].is_finite());
        let start = cell.min.as_dvec2();
        let centre_of = |r: &SampleRect| (r.min + r.max).as_dvec2() * 0.5 - 0.5;
        let radii = self.radii(centre_of(cell), side, change);
        let (scale, _) = self.scale(radii);
        let pixel = self.scale_pixel(scale);
        let within = |miss: DVec2, part: f64| {
            (miss / pixel).length() <= part * self.approximation.tolerance_px
        };
        let nine = || {
            let node = |x: f64, y: f64| {
                let sample = start + DVec2::new(x, y) * (0.5 * side);
                self.pixel(self.plane(sample), middle_deg)
            };
            let [n, w, centre] = [node(1.0, 0.0), node(0.0, 1.0), node(1.0, 1.0)];
            let [e, s] = [node(2.0, 1.0), node(1.0, 2.0)];
            Nine([nw, n, ne, w, centre, e, sw, s, se])
        };
        // Where the kernel's shape changes much within the cell, beside a pole, cells fall apart.
        let varies = self.source.is_upright_geographic() && {
            let first = self.radii(start, 1.0, change);
            let last = self.radii(start + (side - 1.0), 1.0, change);
            let (wider, slimmer) = ((first / last).max_element(), (last / first).max_element());
            wider.max(slimmer) > 1.25
        };
        let wraps = self.wraps_inside(corners);
        let mut own = None;
        let linear = !wraps
            && (within(around.miss() * 0.25, 0.5)
                || within(own.insert(nine()).miss(), 1.0 / OFF_MIDDLE));
        let by_row =
            linear && varies && !matches!(self.target, Target::Projected(_) | Target::Same);

        if linear && !varies {
            let places = Places::Corners(corners);
            return self.push(*cell, radii, places, rect, patches);
        }
        if by_row {
            for row in 0..cell.height() {
                let v = row as f64 / side;
                let (west, east) = (nw + (sw - nw) * v, ne + (se - ne) * v);
                let r = SampleRect::at(cell.min.x, cell.min.y + row, cell.width(), 1);
                let radii = self.radii(centre_of(&r), 1.0, change);
                let places = Places::Corners([west, east, west, east]);
                self.push(r, radii, places, rect, patches);
            }
            return;
        }
        let own = own.unwrap_or_else(nine);
        // With nodes twice as dense parabolas miss by an eighth.
        if !varies && !wraps && within(own.missed_by(around, at) * 0.125, 0.5) {
            return self.push(*cell, radii, Places::Nine(own), rect, patches);
        }
        if cell.width() > SMALLEST {
            let half = cell.width() / 2;
            for (at, corners) in own.quarters() {
                let min = cell.min + half * at;
                let quarter = SampleRect::at(min.x, min.y, half, half);
                if quarter.overlaps(rect) {
                    self.cell(&quarter, corners, (&own, at), middle_deg, rect, patches);
                }
            }
            return;
        }
        let near = if self.source.columns_around.is_some() {
            middle_deg
        } else {
            self.source.centre().x
        };
        let exact = |sample: I64Vec2| self.pixel(self.plane(sample.as_dvec2()), near);
        if varies || wraps || self.source.is_upright_geographic() {
            let samples = cell.intersection(rect);
            for y in samples.min.y..samples.max.y {
                for x in samples.min.x..samples.max.x {
                    let sample = I64Vec2::new(x, y);
                    let radii = self.radii(sample.as_dvec2(), 1.0, change);
                    let place = Places::Each(vec![exact(sample)]);
                    self.push(SampleRect::at(x, y, 1, 1), radii, place, rect, patches);
                }
            }
        } else {
            let places = (0..cell.area())
                .map(|i| exact(cell.min + I64Vec2::new(i % SMALLEST, i / SMALLEST)))
                .collect();
            self.push(*cell, radii, Places::Each(places), rect, patches);
        }
    }

    /// Whether a cell of a source that does not run around the globe sees both of its ends.
    fn wraps_inside(&self, corners: [DVec2; 4]) -> bool {
        if !self.source.crs.is_geographic() || self.source.columns_around.is_some() {
            return false;
        }
        let turn = self.source.pixel_from_plane.matrix2 * DVec2::new(360.0, 0.0);
        let low = corners.into_iter().reduce(DVec2::min).unwrap_or_default();
        let high = corners.into_iter().reduce(DVec2::max).unwrap_or_default();
        [turn, -turn]
            .into_iter()
            .any(|t| self.sees(low + t, high + t))
            && self.sees(low, high)
    }

    /// Whether places between two corners (pixels of the full image) touch the source.
    fn sees(&self, low: DVec2, high: DVec2) -> bool {
        let x =
            self.source.columns_around.is_some() || (high.x >= 0.0 && low.x <= self.source.size.x);
        let y = (high.y >= 0.0 || self.source.reflects[0])
            && (low.y <= self.source.size.y || self.source.reflects[1]);
        x && y
    }

    fn push(
        &self,
        samples: SampleRect,
        radii: DVec2,
        places: Places<DVec2>,
        rect: &SampleRect,
        patches: &mut Vec<Patch>,
    ) {
        if !samples.overlaps(rect) {
            return;
        }
        let Some((low, high)) = places.bounds() else {
            return;
        };
        if !self.sees(low, high) {
            return;
        }
        // Exact places far outside of the source need no pixels.
        let (low, high) = if let Places::Each(_) = places {
            let (mut start, mut end) = (DVec2::ZERO, self.source.size);
            if self.source.columns_around.is_some() {
                (start.x, end.x) = (f64::MIN, f64::MAX);
            }
            if self.source.reflects == [true; 2] {
                (start.y, end.y) = (f64::MIN, f64::MAX);
            }
            (low.clamp(start, end), high.clamp(start, end))
        } else {
            (low, high)
        };
        let (scale, footprint) = self.scale(radii);
        let pixel = self.scale_pixel(scale);
        let min = (low / pixel - 0.5).floor().as_i64vec2() - 1;
        let max = (high / pixel - 0.5).floor().as_i64vec2() + 4;
        let window = SampleRect::new(min, max);
        if window.area() > LARGEST_WINDOW && samples.area() > 1 {
            let size = (samples.max - samples.min).as_dvec2();
            for i in 0..samples.area() {
                let at = I64Vec2::new(i % samples.width(), i / samples.width());
                let sample = SampleRect::at(samples.min.x + at.x, samples.min.y + at.y, 1, 1);
                let place = places.at(i as usize, at.as_dvec2() / size);
                self.push(sample, radii, Places::Each(vec![place]), rect, patches);
            }
            return;
        }
        let relative = |p: DVec2| {
            let r = p / pixel - min.as_dvec2();
            [r.x as f32, r.y as f32]
        };
        let mut inside = [relative(DVec2::ZERO), relative(self.source.size)];
        if self.source.columns_around.is_some() {
            (inside[0][0], inside[1][0]) = (f32::NEG_INFINITY, f32::INFINITY);
        }
        if self.source.reflects[0] {
            inside[0][1] = f32::NEG_INFINITY;
        }
        if self.source.reflects[1] {
            inside[1][1] = f32::INFINITY;
        }
        patches.push(Patch {
            rect: samples,
            scale,
            footprint,
            window,
            places: places.map(relative),
            inside,
        });
    }
}

/// The target of a grid for a source.
pub(crate) fn target(grid: &Grid, source: &SourcePlane) -> Result<Target, super::WarpError> {
    Ok(match &grid.lattice.crs {
        GridCrs::Map => Target::Map,
        GridCrs::Projected(name) => {
            let crs = super::plane::parse_crs(name)?;
            if crs.is_geographic() {
                Target::Degrees
            } else if crs.same_as(&source.crs) {
                Target::Same
            } else {
                Target::Projected(crs)
            }
        }
    })
}
