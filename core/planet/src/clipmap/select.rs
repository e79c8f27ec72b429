//! Which tiles of each level the converged picture can read.
//!
//! The visible ground is cut into cells of a polar grid around the nadir. Each cell that the frustum
//! and the horizon leave over says which depths it shows, hence which levels its fragments select,
//! and adds its bounding box to those levels; one that is large beside the samples it selects is cut
//! in four first. Everything is conservative, so no visible fragment selects a tile outside; cells
//! are small, so little is wanted in vain.

use core::f64::consts::{PI, TAU};

use super::choose::{FOOTPRINT_BLEND_OCTAVES, MAX_ANISOTROPY};
use super::cull::{Culler, Patch};
use super::levels::{longitude_half_width, texel_rad};
use super::plan::{HeightRange, LevelPlan, TerrainBounds};
use super::rings::SECTORS;
use super::valid::EDGE_BAND;
use super::view::FocusFrame;
use crate::{MapPoint, SampleRect, TILE_SAMPLES};

/// Azimuth cells around the nadir.
const CELL_AZIMUTHS: u32 = 24;

/// Ratio of a cell's outer to its inner distance.
const CELL_RATIO: f64 = 1.5;

/// Radius in samples of the finest level it selects above which a cell is cut in four: about a
/// quarter of a tile.
const CELL_RADIUS_SAMPLES: f64 = 96.0;

/// How often a cell may be cut.
const CELL_SPLITS: u32 = 2;

/// A sector of an annulus around the nadir.
#[derive(Clone, Copy, Debug)]
struct Cell {
    radii_rad: (f64, f64),
    azimuths_rad: (f64, f64),
}

impl Cell {
    fn quarters(self) -> [Self; 4] {
        let ((inner, outer), (from, to)) = (self.radii_rad, self.azimuths_rad);
        let (radius, azimuth) = (0.5 * (inner + outer), 0.5 * (from + to));
        [
            ((inner, radius), (from, azimuth)),
            ((inner, radius), (azimuth, to)),
            ((radius, outer), (from, azimuth)),
            ((radius, outer), (azimuth, to)),
        ]
        .map(|(radii_rad, azimuths_rad)| Self {
            radii_rad,
            azimuths_rad,
        })
    }
}

/// Heights as drawn: a range with exaggeration applied.
pub(super) fn drawn(range: HeightRange, exaggeration: f64) -> HeightRange {
    HeightRange {
        min_m: range.min_m * exaggeration,
        max_m: range.max_m * exaggeration,
    }
}

/// The box of the map that bounds a patch.
#[derive(Clone, Copy, Debug)]
struct MapBox {
    centre: MapPoint,
    half_lon_rad: f64,
    colat_rad: (f64, f64),
}

impl MapBox {
    fn of(patch: &Patch) -> Self {
        let centre = MapPoint::from_direction(patch.centre);
        let colat = centre.colat_rad;
        Self {
            centre,
            half_lon_rad: longitude_half_width(colat, patch.radius_rad),
            colat_rad: (
                (colat - patch.radius_rad).max(0.0),
                (colat + patch.radius_rad).min(PI),
            ),
        }
    }

    /// The samples of a level's window inside the box and `margin` samples around it, in up to three
    /// pieces of which some may be empty. The second value tells whether the window holds the box
    /// with its margin.
    fn in_window(&self, plan: &LevelPlan, margin: f64) -> ([SampleRect; 3], bool) {
        let step = plan.level.step_rad();
        let window = plan.window.rect;
        let around = plan.level.samples();
        let centre = plan.window.sample_of(self.centre);
        let rows = (
            self.colat_rad.0 / step.y - margin,
            self.colat_rad.1 / step.y + margin,
        );
        let (top, bottom) = (
            (libm::floor(rows.0) as i64).max(0),
            (libm::ceil(rows.1) as i64).min(around.y),
        );
        let half = self.half_lon_rad / step.x + margin;
        let whole = 2.0 * half >= around.x as f64;
        let (left, right) = if whole {
            (window.min.x, window.max.x)
        } else {
            (
                libm::floor(centre.x - half) as i64,
                libm::ceil(centre.x + half) as i64,
            )
        };
        let boxed = SampleRect::new((left, top).into(), (right, bottom).into());
        let covered = [-1, 0, 1].map(|turn| {
            let copy = boxed.shift((turn * around.x, 0).into());
            copy.intersection(&window)
        });
        let columns_held = plan.window.is_whole_circle()
            || (!whole && left >= window.min.x && right <= window.max.x);
        let held = columns_held && top >= window.min.y && bottom <= window.max.y;
        (covered, held)
    }
}

/// Adds a box to a level's wanted samples; tells whether the window holds all of it.
fn want(plan: &mut LevelPlan, piece: &MapBox, filter_margin: f64) -> bool {
    // A reader in the outer band would blend into the coarser level, were its neighbours missing.
    let (rects, held) = piece.in_window(plan, filter_margin + EDGE_BAND + 1.0);
    for rect in &rects {
        plan.wanted = plan.wanted.union(rect);
        plan.selected.insert(rect);
    }
    held
}

/// Grows every level's wanted samples to whole tiles.
pub(super) fn align_to_tiles(levels: &mut [LevelPlan]) {
    for plan in levels.iter_mut().filter(|p| !p.wanted.is_empty()) {
        let tile = TILE_SAMPLES;
        if plan.window.is_whole_circle() {
            // Offsets from the focus end half a turn away. A rectangle across that line would be two,
            // so whoever looks over a pole wants the whole circle.
            let around = plan.window.rect.width();
            let opposite = libm::floor(plan.focus_in_sample.x) as i64 + around / 2;
            let first = opposite.rem_euclid(around) / tile * tile;
            if plan.wanted.min.x < first + tile && plan.wanted.max.x > first {
                (plan.wanted.min.x, plan.wanted.max.x) = (0, around);
            }
        }
        let (min, max) = (plan.wanted.min, plan.wanted.max);
        plan.wanted = SampleRect::new(
            min.div_euclid(glam::I64Vec2::splat(tile)) * tile,
            (max + (tile - 1)).div_euclid(glam::I64Vec2::splat(tile)) * tile,
        );
    }
}

/// What selection needs of a view.
pub(super) struct Scene<'a> {
    pub(super) culler: Culler,
    pub(super) terrain: &'a dyn TerrainBounds,
    pub(super) exaggeration: f64,
    /// Drawn heights of the whole terrain.
    pub(super) everywhere: HeightRange,
    pub(super) radius_m: f64,
    pub(super) pixel_rad: f64,
    pub(super) horizon_rad: f64,
    /// Height of the eye above the terrain as an angle.
    pub(super) clearance_rad: f64,
    /// Most taps that a fragment spreads along its footprint.
    pub(super) max_taps: u32,
}

impl Scene<'_> {
    /// Drawn heights inside a patch that can be seen, if any.
    pub(super) fn seen(&self, patch: &Patch) -> Option<HeightRange> {
        self.culler.sees(patch, &self.everywhere)?;
        let centre = MapPoint::from_direction(patch.centre);
        let near = drawn(
            self.terrain.near(centre, patch.radius_rad),
            self.exaggeration,
        );
        self.culler.sees(patch, &near)
    }

    /// Marks what fragments can select in colour levels (coarse to fine, consecutive in n).
    pub(super) fn select_colours(&self, nadir: MapPoint, levels: &mut [LevelPlan], margin: f64) {
        let frame = FocusFrame::at(nadir);
        let mut inner = 0.0;
        let mut outer = (0.5 * self.clearance_rad).min(self.horizon_rad / 16.0);
        // 128 octaves reach from atoms to planets: a bound that only a view that is no number needs.
        for _ in 0..128 {
            let patches = Patch::sectors(&frame, (inner, outer), CELL_AZIMUTHS);
            for (k, patch) in patches.enumerate() {
                let step = TAU / f64::from(CELL_AZIMUTHS);
                let cell = Cell {
                    radii_rad: (inner, outer),
                    azimuths_rad: (k as f64 * step, (k + 1) as f64 * step),
                };
                self.select_cell(&frame, cell, &patch, CELL_SPLITS, levels, margin);
            }
            if outer >= self.horizon_rad || outer >= PI {
                return;
            }
            inner = outer;
            outer = (outer * CELL_RATIO).min(self.horizon_rad).min(PI);
        }
    }

    /// Adds one cell to the levels that its fragments select; a cell that is large beside their
    /// samples is cut in four first, at most `splits` times.
    fn select_cell(
        &self,
        frame: &FocusFrame,
        cell: Cell,
        patch: &Patch,
        splits: u32,
        levels: &mut [LevelPlan],
        margin: f64,
    ) {
        let Some(heights) = self.seen(patch) else {
            return;
        };
        let (near_m, far_m) = self.culler.depth_range(patch, &heights);
        if far_m <= 0.0 || levels.is_empty() {
            return;
        }
        let footprint = |depth_m: f64| depth_m.max(0.0) * self.pixel_rad / self.radius_m;
        // Rounding of f32 in the shader may shift a selection by this much.
        let finest = by_footprint(levels, footprint(near_m) * (1.0 - 1e-5));
        if splits > 0 && patch.radius_rad > CELL_RADIUS_SAMPLES * texel_rad(levels[finest].level.n)
        {
            for part in cell.quarters() {
                let patch = Patch::sector(frame, part.radii_rad, part.azimuths_rad);
                self.select_cell(frame, part, &patch, splits - 1, levels, margin);
            }
            return;
        }
        let blend = libm::exp2(f64::from(FOOTPRINT_BLEND_OCTAVES));
        let longest = (MAX_ANISOTROPY / f64::from(self.max_taps)).max(1.0);
        let coarsest = by_footprint(levels, footprint(far_m) * blend * longest * (1.0 + 1e-5));
        let piece = MapBox::of(patch);
        for i in (0..=finest).rev() {
            let held = want(&mut levels[i], &piece, margin);
            if held && i <= coarsest {
                break;
            }
        }
        // A base for everything, so that there is something to show from the first tile on.
        want(&mut levels[0], &piece, margin);
    }

    /// Visible sectors of the annulus between two angles around the focus, and what their vertices
    /// read. `level` is the index of the ring's level; between `rim_rad` and `outer_rad` its vertices
    /// blend into `rim_level`.
    pub(super) fn select_ring(
        &self,
        frame: &FocusFrame,
        (inner_rad, rim_rad, outer_rad): (f64, f64, f64),
        (level, rim_level): (usize, usize),
        levels: &mut [LevelPlan],
        margin: f64,
    ) -> u32 {
        let mut visible = 0;
        let bodies = Patch::sectors(frame, (inner_rad, rim_rad), SECTORS);
        let rims = Patch::sectors(frame, (rim_rad, outer_rad), SECTORS);
        for (k, (body, rim)) in bodies.zip(rims).enumerate() {
            if self.seen(&body).is_none() && self.seen(&rim).is_none() {
                continue;
            }
            visible |= 1 << k;
            for (patch, blends) in [(body, false), (rim, true)] {
                let piece = MapBox::of(&patch);
                let mut i = level;
                // What a window does not hold is read from the next coarser one.
                while !want(&mut levels[i], &piece, margin) && i > 0 {
                    i -= 1;
                }
                if blends {
                    want(&mut levels[rim_level], &piece, margin);
                }
                want(&mut levels[0], &piece, margin);
            }
        }
        visible
    }
}

/// Index of the finest level whose texel is not smaller than a footprint (the twin's rule).
fn by_footprint(levels: &[LevelPlan], footprint_rad: f64) -> usize {
    levels
        .iter()
        .rposition(|l| texel_rad(l.level.n) >= footprint_rad)
        .unwrap_or(0)
}

/// Where a view's centre meets the ground, or comes nearest to it.
pub(super) fn view_centre(view: &super::view::View, ground_radius_m: f64) -> MapPoint {
    let along = view.forward.dot(view.eye);
    let inside = along * along - view.eye.length_squared() + ground_radius_m * ground_radius_m;
    // Past the planet: the point of the ray that is nearest to it.
    let distance = (-along - inside.max(0.0).sqrt()).max(0.0);
    MapPoint::from_direction(view.eye + view.forward * distance)
}
