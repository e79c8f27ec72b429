//! Ties the parts together: from a view to a plan.

use std::collections::BTreeMap;

use super::cull::Culler;
use super::focus::focus_of;
use super::levels::{coarsest_level, finest_level, horizon_rad, next_columns_exponent, reach_rad};
use super::plan::{ClipKind, Layout, LevelPlan, Plan, PlanInput, RingSectors};
use super::rings::{KAPPA, NARROWEST_RING, RingMesh};
use super::select::{Scene, align_to_tiles, drawn, view_centre};
use super::tile_set::TileSet;
use super::valid::{COLOUR_FILTER_MARGIN, HEIGHT_FILTER_MARGIN};
use super::view::{FocusFrame, View};
use super::window::Window;
use crate::ellipsoid::LEAST_RADIUS_SHARE;
use crate::tile::MAX_EXPONENT;
use crate::{LevelKey, MapPoint, SampleRect};

/// Nearer than this to the terrain nothing gets finer, metres.
const LEAST_CLEARANCE_M: f64 = 0.1;

/// Finest level n of any plan: finer samples than 4 cm on Earth are noise, and m = n + 1 must exist.
const FINEST_LEVEL: u8 = if MAX_EXPONENT < 25 {
    MAX_EXPONENT - 1
} else {
    24
};

/// Plans views one after the other. Its memory holds only the windows of the plan before, which keep
/// the exponents of columns steady; a fresh planner gives every window its ideal shape.
#[derive(Clone, Debug, Default)]
pub struct Planner {
    windows: BTreeMap<(ClipKind, u8), Window>,
}

impl Planner {
    /// A planner without memory.
    pub fn new() -> Self {
        Self::default()
    }

    /// Plans a view. Costs a fraction of a millisecond.
    ///
    /// A view that is not finite, or whose fields are out of range, gives a plan of no use, in which
    /// little or nothing is visible; it neither panics nor hangs.
    ///
    /// # Panics
    /// If a window size of the quality is not a power of two from 256 to 65536.
    pub fn plan(&mut self, input: &PlanInput) -> Plan {
        let planet = input.planet;
        let quality = input.quality;
        let view = View::new(&input.camera, &planet, input.viewport_px);
        let heights_range = drawn(input.terrain.everywhere(), input.exaggeration);
        let ground_m = input.ground_m * input.exaggeration;
        let clearance_m = (input.camera.altitude_m - ground_m).max(LEAST_CLEARANCE_M);
        let ground_radius_m =
            (planet.radius_m + ground_m).max(LEAST_RADIUS_SHARE * planet.radius_m);
        let pixel_rad = 2.0 * view.tan_half.y / f64::from(input.viewport_px[1].max(1));
        let horizon = horizon_rad(
            view.eye.length(),
            planet.radius_m + heights_range.max_m,
            planet.radius_m + heights_range.min_m,
        );
        let nadir = MapPoint::from_direction(view.eye);
        let focus = focus_of(
            quality.layout.focus,
            &input.camera,
            clearance_m,
            ground_radius_m,
        );
        let centre = view_centre(&view, ground_radius_m);
        let scene = Scene {
            culler: Culler::new(view, &planet, heights_range.min_m),
            terrain: input.terrain,
            exaggeration: input.exaggeration,
            everywhere: heights_range,
            radius_m: planet.radius_m,
            pixel_rad,
            horizon_rad: horizon,
            clearance_rad: clearance_m / planet.radius_m,
            max_taps: quality.max_taps.max(1),
        };

        let before = core::mem::take(&mut self.windows);
        let mut settled = true;
        let mut place = |kind, size: u32, texel_px, cap: u8| -> Vec<LevelPlan> {
            let coarsest = coarsest_level(size);
            let cap = cap.min(FINEST_LEVEL);
            let finest = finest_level(
                clearance_m,
                pixel_rad,
                texel_px,
                planet.radius_m,
                coarsest,
                cap,
            );
            (coarsest..=finest)
                .map(|n| {
                    let old = before.get(&(kind, n));
                    let (window, final_shape) = place_window(old, n, focus, size);
                    settled &= final_shape;
                    self.windows.insert((kind, n), window);
                    LevelPlan {
                        level: window.level,
                        window,
                        selected: TileSet::none_of(&window),
                        wanted: SampleRect::default(),
                        focus_in_sample: window.sample_of(focus),
                        centre_in_sample: window.sample_of(centre),
                    }
                })
                .collect()
        };
        let mut heights = place(
            ClipKind::Heights,
            quality.layout.height_window,
            quality.height_texel_px,
            quality.finest_height_level,
        );
        let mut colours = place(
            ClipKind::Colours,
            quality.colour_samples,
            quality.colour_texel_px,
            quality.finest_colour_level,
        );

        let seen_rad = horizon + nadir.angle_to(focus);
        let drawn = draw_rings(&scene, &quality.layout, focus, seen_rad, &mut heights);
        scene.select_colours(nadir, &mut colours, COLOUR_FILTER_MARGIN);
        align_to_tiles(&mut heights);
        align_to_tiles(&mut colours);
        Plan {
            focus,
            eye_in_world: view.eye,
            clearance_m,
            pixel_rad,
            horizon_rad: horizon,
            rings: drawn.first..=drawn.last,
            sectors: drawn.sectors,
            disc_sectors: drawn.disc,
            cap: seen_rad > KAPPA * core::f64::consts::PI,
            heights,
            colours,
            settled,
        }
    }
}

/// Which parts of the mesh are drawn.
struct DrawnRings {
    first: u8,
    last: u8,
    sectors: Vec<RingSectors>,
    disc: u32,
}

/// The window of level n, its shape kept steady against the one before; and whether that is final.
fn place_window(before: Option<&Window>, n: u8, focus: MapPoint, size: u32) -> (Window, bool) {
    let focus = focus.normalised();
    let place = |in_use| {
        let (m, done) = next_columns_exponent(in_use, n, focus.colat_rad, reach_rad(n, size), size);
        (Window::place(LevelKey::new(m, n), focus, size), done)
    };
    if let Some(before) = before.filter(|b| b.size == size) {
        // After a jump nothing of the old window is of use: take the ideal shape at once.
        let moved = Window::place(before.level, focus, size);
        if moved.update_from(Some(before)) != [moved.rect] {
            return place(Some(before.level.m));
        }
    }
    place(None)
}

/// Chooses the rings, culls their sectors and marks the height tiles that they read.
fn draw_rings(
    scene: &Scene,
    layout: &Layout,
    focus: MapPoint,
    seen_rad: f64,
    heights: &mut [LevelPlan],
) -> DrawnRings {
    let frame = FocusFrame::at(focus);
    // Ring i reads level index i − 1 (rings 0 and 1 the coarsest), so the finest level is ring:
    let last = (heights.len() as u8).min(NARROWEST_RING - 1);
    let first = (0..=last)
        .rev()
        .find(|&i| RingMesh::outer_radius_rad(i) >= seen_rad)
        .unwrap_or(0);
    let mut sectors = Vec::new();
    let margin = HEIGHT_FILTER_MARGIN;
    if seen_rad > RingMesh::outer_radius_rad(0) {
        let rim = RingMesh::outer_radius_rad(0);
        let pi = core::f64::consts::PI;
        scene.select_ring(&frame, (rim, 0.5 * (rim + pi), pi), (0, 0), heights, margin);
    }
    for ring in first..=last {
        let outer = RingMesh::outer_radius_rad(ring);
        let radii = (
            RingMesh::outer_radius_rad(ring + 1),
            layout.rim_begins() * outer,
            outer,
        );
        let levels = (
            usize::from(ring.saturating_sub(1)),
            usize::from(ring.saturating_sub(2)),
        );
        let visible = scene.select_ring(&frame, radii, levels, heights, margin);
        if visible != 0 {
            sectors.push(RingSectors { ring, visible });
        }
    }
    let rim = RingMesh::outer_radius_rad(last + 1);
    let level = usize::from(last.saturating_sub(1));
    let disc = scene.select_ring(
        &frame,
        (0.0, 0.5 * rim, rim),
        (level, level),
        heights,
        margin,
    );
    DrawnRings {
        first,
        last,
        sectors,
        disc,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clipmap::{HeightRange, Quality};
    use crate::{Camera, Planet};

    const FLAT: HeightRange = HeightRange {
        min_m: 0.0,
        max_m: 100.0,
    };

    fn input(lon_deg: f64, lat_deg: f64, altitude_m: f64, pitch_deg: f64) -> PlanInput<'static> {
        PlanInput {
            camera: Camera {
                lon_rad: lon_deg.to_radians(),
                lat_rad: lat_deg.to_radians(),
                altitude_m,
                heading_rad: 0.0,
                pitch_rad: pitch_deg.to_radians(),
                fov_y_rad: 1.0,
            },
            planet: Planet::EARTH,
            viewport_px: [1280, 960],
            ground_m: 0.0,
            terrain: &FLAT,
            exaggeration: 1.0,
            quality: Quality::default(),
        }
    }

    #[test]
    fn the_same_view_planned_again_is_the_same_plan() {
        let mut planner = Planner::new();
        let first = planner.plan(&input(11.0, 46.0, 3000.0, -30.0));
        assert!(first.settled);
        assert_eq!(first, planner.plan(&input(11.0, 46.0, 3000.0, -30.0)));
    }

    #[test]
    fn a_walk_to_the_pole_settles_in_the_shape_of_a_fresh_plan_or_one_step_wider() {
        let mut planner = Planner::new();
        for step in 0..=400 {
            let view = input(20.0, 80.0 + 0.025 * f64::from(step), 20_000.0, -90.0);
            let mut plan = planner.plan(&view);
            for _ in 0..30 {
                if plan.settled {
                    break;
                }
                plan = planner.plan(&view);
            }
            assert!(plan.settled);
            let fresh = Planner::new().plan(&view);
            for (walked, fresh) in plan.colours.iter().zip(&fresh.colours) {
                let wider = fresh.level.m - walked.level.m.min(fresh.level.m);
                assert!(
                    walked.level.m <= fresh.level.m && wider <= 1,
                    "{walked:?} {fresh:?}"
                );
            }
        }
    }

    #[test]
    fn tiles_come_coarse_before_fine_and_the_views_centre_first() {
        let plan = Planner::new().plan(&input(11.0, 46.0, 3000.0, -45.0));
        let tiles = plan.wanted_tiles();
        assert!(tiles.is_sorted_by_key(|(_, key)| key.level.n));
        let finest = plan.colours.last().unwrap();
        let first = finest.wanted_tiles()[0];
        let rect = finest.window.tile_rect(first).unwrap();
        assert!(
            rect.grow(128)
                .contains(finest.centre_in_sample.floor().as_i64vec2())
        );
        let prefetch = plan.prefetch_tiles();
        assert!(prefetch.iter().all(|t| !tiles.contains(t)));
    }

    #[test]
    fn a_view_from_afar_draws_the_whole_disc_with_coarse_levels_only() {
        let plan = Planner::new().plan(&input(0.0, 0.0, 1e8, -90.0));
        assert!(
            plan.heights.len() <= 2 && *plan.rings.start() <= 1,
            "{:?}",
            plan.rings
        );
        assert!(!plan.cap);
    }

    #[test]
    fn a_view_that_is_no_view_neither_panics_nor_hangs() {
        let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300];
        for x in bad {
            for which in 0..8 {
                let mut view = input(0.0, 0.0, 10.0, -10.0);
                let range = HeightRange {
                    min_m: -x,
                    max_m: x,
                };
                match which {
                    0 => view.camera.lon_rad = x,
                    1 => view.camera.lat_rad = x,
                    2 => view.camera.altitude_m = x,
                    3 => view.camera.pitch_rad = x,
                    4 => view.camera.fov_y_rad = x,
                    5 => view.ground_m = x,
                    6 => view.exaggeration = x,
                    _ => view.terrain = &range,
                }
                let plan = Planner::new().plan(&view);
                assert!(plan.wanted_tiles().len() < 10_000);
            }
        }
        let mut view = input(0.0, 0.0, 10.0, -10.0);
        view.viewport_px = [0, 0];
        Planner::new().plan(&view);
    }
}
