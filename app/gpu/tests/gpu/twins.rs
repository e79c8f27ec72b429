//! Shaders compute what their CPU twins compute.

use core::f64::consts::PI;

use glam::Vec2;
use relievo_engine::planet::MapPoint;
use relievo_engine::planet::transform::{FocusFrame, RingVertex, map_delta_f32};
use relievo_gpu::measure::TransformMeter;

use crate::scene::gpu;

#[test]
fn on_this_device_the_transform_errs_by_less_than_five_in_ten_million_of_the_radius() {
    let meter = TransformMeter::new(&gpu().device);
    for colat_deg in [0.0, 1e-5, 0.3, 7.0, 45.0, 90.0, 133.0, 179.9, 180.0_f64] {
        for ring in [1, 2, 4, 8, 12, 16, 20, 24] {
            let error = meter.worst_error(gpu(), colat_deg / 180.0 * PI, ring, 256, 8).unwrap();
            assert!(error <= 5e-7, "ring {ring} at {colat_deg} degrees: {error:e} of its radius");
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
        let found = meter.map_deltas(gpu(), &vertices, frame.sin_cos_f32()).unwrap();
        for (vertex, found) in vertices.iter().zip(found) {
            let twin = map_delta_f32(*vertex, frame.sin_cos_f32());
            // A device may round a division or contract a product; no more than that.
            let allowed = Vec2::splat(1.2e-6).max(twin.abs() * 1e-6);
            assert!((found - twin).abs().cmple(allowed).all(), "{colat}: {vertex:?}: {found} and {twin}");
        }
    }
}

#[test]
fn the_focus_has_no_offset_on_the_device_either() {
    let meter = TransformMeter::new(&gpu().device);
    for colat in [0.0, 0.5, 1.5, PI] {
        let frame = FocusFrame::new(MapPoint::new(0.0, colat));
        let found = meter.map_deltas(gpu(), &[[0.0; 3]], frame.sin_cos_f32()).unwrap();
        assert_eq!(found[0], Vec2::ZERO, "{colat}");
    }
}
