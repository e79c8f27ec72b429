//! Laws of the clipmaps: whatever the view and the tiles at hand, textures hold what they should, no
//! read leaves a valid rectangle, nothing visible is culled, and what is wanted is enough.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec2, DVec3, I64Vec2, Vec2};
use proptest::prelude::*;
use relievo_planet::clipmap::cull::{Culler, Patch};
use relievo_planet::clipmap::valid::{COLOUR_FILTER_MARGIN, HEIGHT_FILTER_MARGIN};
use relievo_planet::clipmap::view::{FocusFrame, View};
use relievo_planet::clipmap::{
    HeightRange, LevelPlan, LevelView, Plan, PlanInput, Planner, Quality, RingMesh, Window,
    colour_level_for, height_level_for, valid_rect,
};
use relievo_planet::map::wrap_longitude;
use relievo_planet::{Camera, LevelKey, MapPoint, Planet, TileKey};

/// A window's texture, simulated: every texel remembers which sample was written into it.
struct Texture {
    window: Option<Window>,
    texels: Vec<Option<(LevelKey, I64Vec2)>>,
}

impl Texture {
    fn new(size: u32) -> Self {
        Self {
            window: None,
            texels: vec![None; (size * size) as usize],
        }
    }

    fn move_to(&mut self, window: Window) -> Vec<I64Vec2> {
        let mut written = Vec::new();
        for new in window.update_from(self.window.as_ref()) {
            for (key, rect) in window.level.tiles_touching(&new) {
                let pieces = window.upload_pieces(key, &new);
                assert!(pieces.len() <= 4);
                assert!(!pieces.is_empty(), "{rect:?} touches {new:?}");
                for piece in pieces {
                    for y in 0..piece.in_tile.height() {
                        for x in 0..piece.in_tile.width() {
                            let step = I64Vec2::new(x, y);
                            let texel = piece.storage + step;
                            let sample = key.rect().min + piece.in_tile.min + step;
                            let at = texel.y * i64::from(window.size) + texel.x;
                            self.texels[at as usize] = Some((window.level, sample));
                            written.push(texel);
                        }
                    }
                }
            }
        }
        self.window = Some(window);
        written
    }

    fn check(&self) {
        let window = self.window.expect("moved");
        for y in window.rect.min.y..window.rect.max.y {
            for x in window.rect.min.x..window.rect.max.x {
                let sample = I64Vec2::new(x, y);
                let texel = window.storage_of(sample);
                let at = texel.y * i64::from(window.size) + texel.x;
                let expected = (window.level, window.level.wrap_sample(sample));
                assert_eq!(self.texels[at as usize], Some(expected), "{window:?}");
            }
        }
    }
}

fn places() -> impl Strategy<Value = MapPoint> {
    let lon = prop_oneof![-PI..PI, (PI - 0.02)..(PI + 0.02)];
    let colat = prop_oneof![0.0..PI, 0.0..0.02, (PI - 0.02)..PI, Just(0.0), Just(PI)];
    (lon, colat).prop_map(|(lon, colat)| MapPoint::new(lon, colat))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn any_walk_of_updates_leaves_what_a_fresh_fill_would(
        start in places(),
        n in 0_u8..10,
        size in prop_oneof![Just(256_u32), Just(512)],
        steps in prop::collection::vec((-0.6..0.6_f64, -0.6..0.6_f64, -1_i8..=1, 0..8_u8), 1..7),
    ) {
        let mut texture = Texture::new(size);
        let mut m = n + 1;
        let mut place = start;
        for (east, south, dm, jump) in steps {
            if jump == 0 {
                m = m.saturating_add_signed(dm).min(n + 1);
            }
            let level = LevelKey::new(m, n);
            let reach = level.step_rad() * f64::from(size);
            place = MapPoint::new(place.lon_rad + east * reach.x, place.colat_rad + south * reach.y)
                .normalised();
            texture.move_to(Window::place(level, place, size));
            texture.check();
        }
    }

    /// \[CH07\] 5.2: with tiles as large as the window, split the texture at the old and the new
    /// wrap-around position; of the nine regions exactly those with another tile are copied.
    #[test]
    fn with_windows_as_large_as_tiles_updates_are_the_nine_regions(
        place in places(),
        move_east in -1.0..1.0_f64,
        move_south in -1.0..1.0_f64,
    ) {
        let level = LevelKey::new(7, 6);
        let old = Window::place(level, place, 256);
        let reach = level.step_rad() * 256.0;
        let to = MapPoint::new(
            place.lon_rad + move_east * reach.x,
            (place.colat_rad + move_south * reach.y).clamp(0.0, PI),
        );
        let new = Window::place(level, to, 256);
        let mut texture = Texture::new(256);
        texture.move_to(old);
        let written = texture.move_to(new);
        texture.check();

        // The paper's procedure, texel region by texel region.
        let tile_at = |w: &Window, texel: I64Vec2| {
            let sample = w.rect.min + (texel - w.rect.min).rem_euclid(I64Vec2::splat(256));
            level.wrap_sample(sample).div_euclid(I64Vec2::splat(256))
        };
        let cuts = |a: i64, b: i64| {
            let mut cuts = vec![0, a.rem_euclid(256), b.rem_euclid(256), 256];
            cuts.sort_unstable();
            cuts
        };
        let (xs, ys) = (cuts(old.rect.min.x, new.rect.min.x), cuts(old.rect.min.y, new.rect.min.y));
        let mut expected = vec![false; 256 * 256];
        for y in ys.windows(2) {
            for x in xs.windows(2) {
                if x[0] == x[1] || y[0] == y[1] {
                    continue;
                }
                let corner = I64Vec2::new(x[0], y[0]);
                let changed = tile_at(&old, corner) != tile_at(&new, corner);
                for row in y[0]..y[1] {
                    for column in x[0]..x[1] {
                        expected[(row * 256 + column) as usize] = changed;
                    }
                }
            }
        }
        let mut found = vec![false; 256 * 256];
        for texel in written {
            let at = (texel.y * 256 + texel.x) as usize;
            prop_assert!(!found[at], "written twice");
            found[at] = true;
        }
        prop_assert!(found == expected);
    }
}

/// A view with everything that planning needs.
#[derive(Clone, Copy, Debug)]
struct Case {
    camera: Camera,
    viewport: [u32; 2],
    ground_m: f64,
    range: HeightRange,
    quality: Quality,
}

const PLANET: Planet = Planet::EARTH;

impl Case {
    fn plan(&self) -> Plan {
        Planner::new().plan(&self.input())
    }

    fn input(&self) -> PlanInput<'_> {
        PlanInput {
            camera: self.camera,
            planet: PLANET,
            viewport_px: self.viewport,
            ground_m: self.ground_m,
            terrain: &self.range,
            exaggeration: 1.0,
            quality: self.quality,
        }
    }

    fn view(&self) -> View {
        View::new(&self.camera, &PLANET, self.viewport)
    }

    /// First point along a ray on the sphere of a height, unless lower terrain hides it.
    fn visible_point(&self, place: DVec2, height_m: f64) -> Option<(DVec3, f64)> {
        let view = self.view();
        let ray = view.ray(place).normalize();
        let hit = |radius: f64| {
            let along = ray.dot(view.eye);
            let inside = along * along - view.eye.length_squared() + radius * radius;
            (inside >= 0.0)
                .then(|| [-along - inside.sqrt(), -along + inside.sqrt()])
                .and_then(|ts| ts.into_iter().find(|&t| t > 0.0))
        };
        let distance = hit(PLANET.radius_m + height_m)?;
        if hit(PLANET.radius_m + self.range.min_m).is_some_and(|t| t < distance) {
            return None;
        }
        Some((view.eye + ray * distance, distance * ray.dot(view.forward)))
    }
}

fn cases() -> impl Strategy<Value = Case> {
    let place = places();
    let shape = (0.3..8.0_f64, 0.0..TAU, -FRAC_PI_2..0.6_f64, 0.2..1.6_f64);
    let terrain = (-400.0..1000.0_f64, 1.0..8000.0_f64, 0.0..1.0_f64);
    let size = prop_oneof![Just(256_u32), Just(1024), Just(2048)];
    (place, shape, terrain, size, 200_u32..2000).prop_map(
        |(place, (log_height, heading, pitch, fov), (low, relief, part), size, width)| {
            let range = HeightRange {
                min_m: low,
                max_m: low + relief,
            };
            let ground_m = low + part * relief;
            let place = place.normalised();
            Case {
                camera: Camera {
                    lon_rad: place.lon_rad,
                    lat_rad: place.lat_rad(),
                    altitude_m: ground_m + libm::pow(10.0, log_height),
                    heading_rad: heading,
                    pitch_rad: pitch,
                    fov_y_rad: fov,
                },
                viewport: [width, 960],
                ground_m,
                range,
                quality: Quality {
                    colour_samples: size,
                    ..Quality::default()
                },
            }
        },
    )
}

fn delta_from(focus: MapPoint, point: MapPoint) -> Vec2 {
    Vec2::new(
        wrap_longitude(point.lon_rad - focus.lon_rad) as f32,
        (point.colat_rad - focus.colat_rad) as f32,
    )
}

fn views(
    levels: &[LevelPlan],
    margin: f64,
    resident: impl Fn(&LevelPlan, TileKey) -> bool,
) -> Vec<LevelView> {
    levels
        .iter()
        .map(|l| {
            let valid = valid_rect(l, |k| resident(l, k));
            LevelView::new(l, &valid, Some(&valid), 1.0, margin)
        })
        .collect()
}

fn is_wanted(level: &LevelPlan, key: TileKey) -> bool {
    level
        .window
        .tile_rect(key)
        .is_some_and(|r| level.wanted.contains_rect(&r))
}

/// A reproducible coin for a tile.
fn coin(key: TileKey, seed: u64, part: u64) -> bool {
    let mut x =
        seed ^ u64::from(key.row) << 32 ^ u64::from(key.column) ^ u64::from(key.level.n) << 56;
    x = (x ^ (x >> 31)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    (x ^ (x >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 60 < part
}

/// Checks that every texel that a filtered read touches holds a sample of a resident tile.
fn check_reads(
    level: &LevelPlan,
    view: &LevelView,
    delta: Vec2,
    reach: f32,
    resident: &impl Fn(TileKey) -> bool,
) {
    let offset = view.offset_of(delta);
    let window = level.window;
    for along in [
        Vec2::ZERO,
        Vec2::X * reach,
        -Vec2::X * reach,
        Vec2::Y * reach,
        -Vec2::Y * reach,
    ] {
        let mut tap = offset + along;
        tap.y = tap.y.clamp(view.tap_rows.x, view.tap_rows.y);
        let corner = (view.focus_in_storage + tap - 0.5).floor();
        for (x, y) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            // A bilinear tap clamped to the outermost row weighs the row beyond by nothing.
            let weight = (view.focus_in_storage + tap - 0.5 - corner).y;
            if y == 1 && weight < 1e-3 || y == 0 && weight > 1.0 - 1e-3 {
                continue;
            }
            let texel = corner.as_i64vec2() + I64Vec2::new(x, y);
            let period = window.period();
            let sample = window.rect.min + (texel - window.rect.min).rem_euclid(period);
            assert!(
                window.rect.contains(sample),
                "{sample} outside {window:?}, offset {offset}"
            );
            let wrapped = level.level.wrap_sample(sample);
            let tile = wrapped.div_euclid(I64Vec2::splat(256));
            let key = TileKey::new(level.level, tile.x, tile.y).expect("inside the level");
            assert!(
                resident(key),
                "{key} is not resident: offset {offset} of {view:?}"
            );
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]

    #[test]
    fn no_choice_reads_outside_a_valid_rectangle(
        case in cases(),
        seed in any::<u64>(),
        part in 4_u64..=16,
        points in prop::collection::vec((places(), 0.0..1.0_f64, 0.0..TAU), 40),
    ) {
        let plan = case.plan();
        let resident = |_: &LevelPlan, k| coin(k, seed, part);
        let colours = views(&plan.colours, COLOUR_FILTER_MARGIN, resident);
        let heights = views(&plan.heights, HEIGHT_FILTER_MARGIN, resident);
        for (anywhere, size, azimuth) in points {
            let level = (size * heights.len() as f64) as usize;
            let radius = 3.0 * libm::exp2(-size * heights.len() as f64);
            let near = FocusFrame::at(plan.focus).direction(radius, azimuth);
            for point in [anywhere, MapPoint::from_direction(near)] {
                let delta = delta_from(plan.focus, point);
                if let Some(c) = height_level_for(&heights, level, 0.5, delta) {
                    for i in [c.fine, c.coarse] {
                        let ok = |k| coin(k, seed, part);
                        check_reads(&plan.heights[i], &heights[i], delta, 0.0, &ok);
                    }
                }
                let footprint = (radius * 1e-3) as f32;
                if let Some(c) = colour_level_for(&colours, footprint, delta) {
                    for i in [c.fine, c.coarse] {
                        let ok = |k| coin(k, seed, part);
                        check_reads(&plan.colours[i], &colours[i], delta, 4.0, &ok);
                    }
                }
            }
        }
    }

    #[test]
    fn wanted_tiles_are_all_that_a_converged_picture_reads(
        case in cases(),
        points in prop::collection::vec(((-1.0..1.0_f64, -1.0..1.0_f64), 0.0..1.0_f64), 60),
    ) {
        let plan = case.plan();
        let all = views(&plan.colours, COLOUR_FILTER_MARGIN, |_, _| true);
        let wanted = views(&plan.colours, COLOUR_FILTER_MARGIN, is_wanted);
        for ((x, y), part) in points {
            let height = case.range.min_m + part * (case.range.max_m - case.range.min_m);
            let Some((point, depth)) = case.visible_point(DVec2::new(x, y), height) else { continue };
            let footprint = (depth * plan.pixel_rad / PLANET.radius_m) as f32;
            let delta = delta_from(plan.focus, MapPoint::from_direction(point));
            let best = colour_level_for(&all, footprint, delta);
            let got = colour_level_for(&wanted, footprint, delta);
            prop_assert_eq!(best, got, "delta {} footprint {}", delta, footprint);
        }
    }

    /// Tiles that are wanted but not selected may hold anything: nothing that is seen reads them.
    #[test]
    fn a_converged_picture_reads_selected_tiles_only(
        case in cases(),
        points in prop::collection::vec(((-1.0..1.0_f64, -1.0..1.0_f64), 0.0..1.0_f64), 60),
    ) {
        let plan = case.plan();
        let all = views(&plan.colours, COLOUR_FILTER_MARGIN, |_, _| true);
        for ((x, y), part) in points {
            let height = case.range.min_m + part * (case.range.max_m - case.range.min_m);
            let Some((point, depth)) = case.visible_point(DVec2::new(x, y), height) else { continue };
            let footprint = (depth * plan.pixel_rad / PLANET.radius_m) as f32;
            let delta = delta_from(plan.focus, MapPoint::from_direction(point));
            if let Some(choice) = colour_level_for(&all, footprint, delta) {
                for i in [choice.fine, choice.coarse] {
                    let level = &plan.colours[i];
                    check_reads(level, &all[i], delta, 4.0, &|key| level.selects(key));
                }
            }
        }
    }

    #[test]
    fn wanted_height_tiles_are_all_that_visible_vertices_read(case in cases(), pick in 0..1000_usize) {
        let plan = case.plan();
        let mesh = RingMesh::new(32, 4).unwrap();
        let all = views(&plan.heights, HEIGHT_FILTER_MARGIN, |_, _| true);
        let wanted = views(&plan.heights, HEIGHT_FILTER_MARGIN, is_wanted);
        let frame = FocusFrame::at(plan.focus);
        let mut parts: Vec<_> = plan
            .sectors
            .iter()
            .map(|s| (s.ring, s.visible, mesh.ring_vertices(s.ring), mesh.ring_indices()))
            .collect();
        let last = *plan.rings.end();
        parts.push((last, plan.disc_sectors, mesh.disc_vertices(last), mesh.disc_indices()));
        for (ring, visible, vertices, indices) in parts {
            let level = plan.height_level_of_ring(ring);
            for (k, range) in indices.sectors.iter().enumerate() {
                if visible & (1 << k) == 0 {
                    continue;
                }
                for i in (range.start..range.end).skip(pick % 7).step_by(5) {
                    let v = vertices[indices.indices[i as usize] as usize];
                    let [x, y, z] = v.position.map(f64::from);
                    let p = MapPoint::from_direction(frame.south * x + frame.east * y + frame.up * (1.0 - z));
                    let delta = delta_from(plan.focus, p);
                    let best = height_level_for(&all, level, v.rim, delta);
                    let got = height_level_for(&wanted, level, v.rim, delta);
                    prop_assert_eq!(best, got, "ring {} delta {}", ring, delta);
                }
            }
        }
    }

    #[test]
    fn what_can_be_seen_is_never_culled(
        case in cases(),
        places in prop::collection::vec(((-1.0..1.0_f64, -1.0..1.0_f64), 0.0..1.0_f64), 40),
        ratio in 1.05..4.0_f64,
        part in 0.0..1.0_f64,
    ) {
        let plan = case.plan();
        let culler = Culler::new(case.view(), &PLANET, case.range.min_m);
        let frame = FocusFrame::at(plan.focus);
        for ((x, y), height) in places {
            let height = case.range.min_m + height * (case.range.max_m - case.range.min_m);
            let Some((point, depth)) = case.visible_point(DVec2::new(x, y), height) else { continue };
            let d = point.normalize();
            let (u, v) = (d.dot(frame.south), d.dot(frame.east));
            let angle = libm::atan2(libm::hypot(u, v), d.dot(frame.up));
            let azimuth = libm::atan2(v, u);
            let (inner, step) = (angle / libm::pow(ratio, part), TAU / 16.0);
            let outer = (inner * ratio).min(PI);
            let from = azimuth - part * step;
            let patch = Patch::sector(&frame, (inner, outer), (from, from + step));
            let seen = culler.sees(&patch, &case.range);
            let Some(seen) = seen else { panic!("culled {patch:?}") };
            prop_assert!(seen.min_m - 1e-3 <= height && height <= seen.max_m + 1e-3, "{:?}", seen);
            let (near, far) = culler.depth_range(&patch, &seen);
            prop_assert!(near <= depth * (1.0 + 1e-9) + 1e-3 && depth <= far * (1.0 + 1e-9) + 1e-3);
            prop_assert!(libm::acos(d.dot(plan.eye_in_world.normalize()).min(1.0)) <= plan.horizon_rad + 1e-6);
        }
    }
}
