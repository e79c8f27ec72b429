//! Evaluates all forms of the map transform on the device: how exact and how fast each is there.

use glam::Vec2;
use relievo_engine::planet::transform::classic::ClassicFocus;
use relievo_engine::planet::transform::forms::Form;
use relievo_shaders::Entry;
use relievo_shaders::layout::FormsInput;
use wgpu::util::DeviceExt;

use crate::bind;
use crate::device::Gpu;
use crate::readback::{self, ReadError};

/// Vertices that are evaluated at once at most.
pub const MOST_VERTICES: usize = 1 << 20;

/// A pipeline for each form. Immutable.
#[derive(Debug)]
pub struct FormMeter {
    /// In the order of [`Form::ALL`].
    pipelines: Vec<wgpu::ComputePipeline>,
}

/// A form with the vertices that it is to be evaluated for, all on the device.
#[derive(Debug)]
pub struct PreparedForm {
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    results: wgpu::Buffer,
    vertices: u32,
}

impl FormMeter {
    /// The meter on a device.
    pub fn new(device: &wgpu::Device) -> Self {
        let module = bind::module(device, Entry::Forms);
        let pipeline = |number: usize| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some("forms/pipeline"),
                layout: None,
                module: &module,
                entry_point: Some("forms"),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants: &[("FORM", number as f64)],
                    ..wgpu::PipelineCompilationOptions::default()
                },
                cache: None,
            })
        };
        Self {
            pipelines: (0..Form::ALL.len()).map(pipeline).collect(),
        }
    }

    /// Puts at most [`MOST_VERTICES`] vertices (u, v, 1 − w) around a focus on the device; more are left
    /// out. Each run will evaluate each of them `repeats` times.
    pub fn prepare(
        &self,
        gpu: &Gpu,
        form: Form,
        vertices: &[[f32; 3]],
        colat_rad: f64,
        repeats: u32,
    ) -> PreparedForm {
        let number = Form::ALL.iter().position(|known| *known == form);
        let pipeline = &self.pipelines[number.unwrap_or_default()];
        let vertices = &vertices[..vertices.len().min(MOST_VERTICES)];
        // A buffer of nothing cannot be bound.
        let mut queries = vec![[0.0_f32; 4]; vertices.len().max(1)];
        for (query, [u, v, one_minus_w]) in queries.iter_mut().zip(vertices) {
            *query = [*u, *v, *one_minus_w, 0.0];
        }
        let focus = ClassicFocus::new(colat_rad);
        let input = FormsInput {
            sin_cos_colat: focus.sin_cos_colat.to_array(),
            colat_rad: focus.colat_rad,
            distortion: focus.distortion,
            count: vertices.len() as u32,
            repeats,
            ..FormsInput::default()
        };
        let buffer = |label, contents: &[u8], usage| {
            let descriptor = wgpu::util::BufferInitDescriptor {
                label: Some(label),
                contents,
                usage,
            };
            gpu.device.create_buffer_init(&descriptor)
        };
        let uniform = wgpu::BufferUsages::UNIFORM;
        let input = buffer("forms/input", bytemuck::bytes_of(&input), uniform);
        let storage = wgpu::BufferUsages::STORAGE;
        let queries = buffer("forms/queries", bytemuck::cast_slice(&queries), storage);
        let results = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("forms/results"),
            size: queries.size(),
            usage: storage | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let entries = [
            bind::whole(0, &input),
            bind::whole(1, &queries),
            bind::whole(2, &results),
        ];
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("forms/group"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        PreparedForm {
            pipeline: pipeline.clone(),
            group,
            results,
            vertices: vertices.len() as u32,
        }
    }
}

impl PreparedForm {
    /// Evaluates all vertices and waits until that is done.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn run(&self, gpu: &Gpu) -> Result<(), ReadError> {
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor {
                label: Some("forms/encoder"),
            });
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &self.group, &[]);
            pass.dispatch_workgroups(self.vertices.div_ceil(64), 1, 1);
        }
        gpu.queue.submit([encoder.finish()]);
        readback::wait(&gpu.device)
    }

    /// (Δφ, Δθ) in radians of all vertices, as of the latest run.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn deltas(&self, gpu: &Gpu) -> Result<Vec<Vec2>, ReadError> {
        let bytes = readback::contents(&gpu.device, &gpu.queue, &self.results)?;
        let results: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&bytes);
        let deltas = results
            .into_iter()
            .map(|[lon, colat, ..]| Vec2::new(lon, colat));
        Ok(deltas.take(self.vertices as usize).collect())
    }
}
