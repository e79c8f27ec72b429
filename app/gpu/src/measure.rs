//! Evaluates the shaders' map transform on the device, to measure its error there.

use glam::{DVec2, Vec2};
use relievo_engine::planet::MapPoint;
use relievo_engine::planet::clipmap::rings::KAPPA;
use relievo_engine::planet::transform::{FocusFrame, RingVertex, map_delta_f64};
use relievo_shaders::Entry;
use relievo_shaders::layout::MeasureInput;
use wgpu::util::DeviceExt;

use crate::bind;
use crate::device::Gpu;
use crate::readback::{self, ReadError};

/// The measuring pipeline. Immutable.
#[derive(Debug)]
pub struct TransformMeter {
    pipeline: wgpu::ComputePipeline,
}

impl TransformMeter {
    /// The meter on a device.
    pub fn new(device: &wgpu::Device) -> Self {
        let module = bind::module(device, Entry::Measure);
        Self {
            pipeline: device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some("measure/pipeline"),
                layout: None,
                module: &module,
                entry_point: Some("measure"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            }),
        }
    }

    /// (Δφ, Δθ) in radians of vertices (u, v, 1 − w) around a focus, as the device computes them.
    ///
    /// # Errors
    /// If the device is lost.
    ///
    /// # Panics
    /// With more than a million vertices.
    pub fn map_deltas(&self, gpu: &Gpu, vertices: &[[f32; 3]], sin_cos_colat: Vec2) -> Result<Vec<Vec2>, ReadError> {
        assert!(vertices.len() <= 1_000_000, "at most a million vertices at once");
        if vertices.is_empty() {
            return Ok(Vec::new());
        }
        let device = &gpu.device;
        let padded: Vec<[f32; 4]> = vertices.iter().map(|[u, v, w]| [*u, *v, *w, 0.0]).collect();
        let buffer = |label, contents: &[u8], usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(label), contents, usage })
        };
        let input = MeasureInput { sin_cos_colat: sin_cos_colat.to_array(), count: vertices.len() as u32, unused: 0 };
        let input = buffer("measure/input", bytemuck::bytes_of(&input), wgpu::BufferUsages::UNIFORM);
        let stored = buffer("measure/vertices", bytemuck::cast_slice(&padded), wgpu::BufferUsages::STORAGE);
        let results = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("measure/results"),
            size: stored.size(),
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("measure/group"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &[bind::whole(0, &input), bind::whole(1, &stored), bind::whole(2, &results)],
        });
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("measure/encoder") });
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups((vertices.len() as u32).div_ceil(64), 1, 1);
        }
        gpu.queue.submit([encoder.finish()]);
        let bytes = readback::contents(device, &gpu.queue, &results)?;
        let results: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&bytes);
        Ok(results.into_iter().map(|[lon, colat, ..]| Vec2::new(lon, colat)).collect())
    }

    /// Largest error on the ground of the transform on this device, as a part of the radius of
    /// ring `level`, over a polar grid of `azimuths` × `radii` vertices around a focus.
    ///
    /// The truth is computed in f64 from the very f32 vertices and the focus' exact colatitude.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn worst_error(&self, gpu: &Gpu, colat_rad: f64, level: u8, azimuths: u32, radii: u32) -> Result<f64, ReadError> {
        let frame = FocusFrame::new(MapPoint::new(0.0, colat_rad));
        let ring_rad = KAPPA * core::f64::consts::PI / f64::from(1_u32 << level);
        let vertices: Vec<[f32; 3]> = (0..radii)
            .flat_map(|j| (0..azimuths).map(move |k| (j, k)))
            .map(|(j, k)| {
                let angle = ring_rad * (1.0 - 0.5 * f64::from(j) / f64::from(radii));
                let azimuth = (f64::from(k) + 0.37) / f64::from(azimuths) * core::f64::consts::TAU;
                RingVertex::from_polar(angle, azimuth).to_f32()
            })
            .collect();
        let found = self.map_deltas(gpu, &vertices, frame.sin_cos_f32())?;
        let worst = vertices.iter().zip(found).map(|(vertex, found)| {
            let [u, v, one_minus_w] = vertex.map(f64::from);
            let truth = map_delta_f64(RingVertex { u, v, one_minus_w }, frame.sin_colat, frame.cos_colat);
            ground_distance(colat_rad, truth, found.as_dvec2())
        });
        Ok(worst.fold(0.0, f64::max) / ring_rad)
    }
}

/// Distance on the unit sphere between two places given relative to a focus.
fn ground_distance(colat_rad: f64, a: DVec2, b: DVec2) -> f64 {
    // For places this near the local metric is exact enough; at a pole longitudes do not count.
    let lon = relievo_engine::planet::map::wrap_longitude(a.x - b.x);
    let sin_colat = (colat_rad + a.y).sin();
    (lon * sin_colat).hypot(a.y - b.y)
}
