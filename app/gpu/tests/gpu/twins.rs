//! Shaders compute what their CPU twins compute.

use core::f64::consts::PI;

use glam::Vec2;
use relievo_engine::planet::MapPoint;
use relievo_engine::planet::clipmap::choose::{LevelView, UNBOUNDED};
use relievo_engine::planet::clipmap::{LevelChoice, colour_level_for, height_level_for};
use relievo_engine::planet::transform::{FocusFrame, RingVertex, map_delta_f32};
use relievo_gpu::measure::{ChoiceQuery, TransformMeter};

use crate::scene::gpu;

#[test]
fn on_this_device_the_transform_errs_by_less_than_five_in_ten_million_of_the_radius() {
    let meter = TransformMeter::new(&gpu().device);
    for colat_deg in [0.0, 1e-5, 0.3, 7.0, 45.0, 90.0, 133.0, 179.9, 180.0_f64] {
        for ring in [1, 2, 4, 8, 12, 16, 20, 24] {
            let error = meter
                .worst_error(gpu(), colat_deg / 180.0 * PI, ring, 256, 8)
                .unwrap();
            assert!(
                error <= 5e-7,
                "ring {ring} at {colat_deg} degrees: {error:e} of its radius"
            );
        }
    }
}

#[test]
fn the_transform_agrees_with_its_twin() {
    let meter = TransformMeter::new(&gpu().device);
    for colat in [0.0, 0.02, 0.9, 2.0, PI] {
        let frame = FocusFrame::new(MapPoint::new(0.3, colat));
        let vertices: Vec<[f32; 3]> = (0..2000)
            .map(|k| {
                let angle = 2.2 * 0.995_f64.powi(k);
                RingVertex::from_polar(angle, f64::from(k) * 2.399).to_f32()
            })
            .collect();
        let found = meter
            .map_deltas(gpu(), &vertices, frame.sin_cos_f32())
            .unwrap();
        for (vertex, found) in vertices.iter().zip(found) {
            let twin = map_delta_f32(*vertex, frame.sin_cos_f32());
            // A device may round a division or contract a product; no more than that.
            let allowed = Vec2::splat(1.2e-6).max(twin.abs() * 1e-6);
            assert!(
                (found - twin).abs().cmple(allowed).all(),
                "{colat}: {vertex:?}: {found} and {twin}"
            );
        }
    }
}

#[test]
fn the_focus_has_no_offset_on_the_device_either() {
    let meter = TransformMeter::new(&gpu().device);
    for colat in [0.0, 0.5, 1.5, PI] {
        let frame = FocusFrame::new(MapPoint::new(0.0, colat));
        let found = meter
            .map_deltas(gpu(), &[[0.0; 3]], frame.sin_cos_f32())
            .unwrap();
        assert_eq!(found[0], Vec2::ZERO, "{colat}");
    }
}

/// Levels with every irregularity: whole circles, poles, nothing valid, fading, small rectangles.
fn levels() -> Vec<LevelView> {
    let level = |n: i32, half: f32| LevelView {
        focus_in_storage: Vec2::splat(100.25),
        samples_per_rad: Vec2::new(81.0, 81.5) * (2.0_f32).powi(n),
        valid_min: Vec2::new(-half, -0.9 * half),
        valid_max: Vec2::new(0.8 * half, half),
        settled_min: Vec2::new(-0.5 * half, -half),
        settled_max: Vec2::new(half, 0.5 * half),
        fade: 0.4,
        tap_rows: Vec2::new(-half, half),
        edge_band: 16.0,
        texel_rad: (2.0_f32).powi(-n) / 81.5,
    };
    let mut levels: Vec<LevelView> = (0..10).map(|n| level(n, 120.0)).collect();
    (levels[0].valid_min, levels[0].valid_max) = (Vec2::splat(-UNBOUNDED), Vec2::splat(UNBOUNDED));
    (levels[4].valid_min, levels[4].valid_max) = (Vec2::splat(UNBOUNDED), Vec2::splat(-UNBOUNDED));
    levels[7].valid_max.y = UNBOUNDED;
    levels
}

#[test]
fn the_device_chooses_the_levels_that_the_twin_chooses() {
    let meter = TransformMeter::new(&gpu().device);
    let levels = levels();
    let queries: Vec<ChoiceQuery> = (0..20_000)
        .map(|k| {
            let (a, b) = (
                f64::from(k) * 0.618_034 % 1.0,
                f64::from(k) * 0.754_878 % 1.0,
            );
            let radius = 2.0_f64.powf(-11.0 * a);
            let (sin, cos) = (b * 2.0 * PI).sin_cos();
            ChoiceQuery {
                delta_rad: Vec2::new((radius * sin) as f32, (radius * cos) as f32),
                footprint_rad: 2.0_f32.powf(-(f64::from(k) * 0.569_84 % 1.0 * 18.0) as f32),
                level_minus_rim: (k % 10) as f32
                    - if k % 3 == 0 {
                        0.0
                    } else {
                        (k % 41) as f32 / 41.0
                    },
            }
        })
        .map(|q| ChoiceQuery {
            level_minus_rim: q.level_minus_rim.max(0.0),
            ..q
        })
        .collect();
    let same = |device: Option<LevelChoice>, twin: Option<LevelChoice>| match (device, twin) {
        (Some(a), Some(b)) => {
            // A weight of nothing may be rounded away, and its level with it.
            let coarse = a.coarse == b.coarse || a.coarse_weight.max(b.coarse_weight) < 1e-5;
            a.fine == b.fine && coarse && (a.coarse_weight - b.coarse_weight).abs() < 1e-5
        }
        (a, b) => a == b,
    };
    let found = meter.choices(gpu(), &levels, &queries).unwrap();
    assert_eq!(found.len(), queries.len());
    for (q, [colour, height]) in queries.iter().zip(found) {
        let twin = colour_level_for(&levels, q.footprint_rad, q.delta_rad);
        assert!(same(colour, twin), "{q:?}: {colour:?}, not {twin:?}");
        let level = q.level_minus_rim.ceil();
        let twin = height_level_for(
            &levels,
            level as usize,
            level - q.level_minus_rim,
            q.delta_rad,
        );
        assert!(same(height, twin), "{q:?}: {height:?}, not {twin:?}");
    }
}
