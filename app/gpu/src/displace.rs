//! The displacement pass: ring vertices to positions from the eye.

use core::ops::Range;

use relievo_shaders::Entry;
use relievo_shaders::layout::DisplaceRange;

use crate::bind;
use crate::mesh::MeshBuffers;

/// Threads of a workgroup: `@workgroup_size` of the shader.
const WORKGROUP: u32 = 64;

/// Distance between two ranges in their buffer: the alignment that every adapter accepts.
const RANGE_STRIDE: u64 = 256;

/// Most runs of vertices in a frame: rings, disc, cap and gaps between visible rings.
const MAX_RANGES: usize = 32;

/// Pipeline and layouts of the displacement pass. Immutable.
#[derive(Debug)]
pub struct DisplacePass {
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
}

/// What it works on: rebuilt when the height texture is.
#[derive(Debug)]
pub struct DisplaceGroup {
    ranges: wgpu::Buffer,
    group: wgpu::BindGroup,
}

impl DisplacePass {
    /// The pass; `frame` is the layout of group 0.
    pub fn new(device: &wgpu::Device, frame: &wgpu::BindGroupLayout) -> Self {
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("displace/layout"),
            entries: &[
                bind::texture(
                    0,
                    wgpu::ShaderStages::COMPUTE,
                    wgpu::TextureViewDimension::D2Array,
                    false,
                ),
                bind::storage(1, true),
                bind::storage(2, false),
                bind::uniform(3, wgpu::ShaderStages::COMPUTE, true),
            ],
        });
        let module = bind::module(device, Entry::Displace);
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("displace/pipeline layout"),
            bind_group_layouts: &[Some(frame), Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("displace/pipeline"),
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: Some("displace"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        Self { pipeline, layout }
    }

    /// Binds heights and mesh.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        heights: &wgpu::TextureView,
        mesh: &MeshBuffers,
    ) -> DisplaceGroup {
        let ranges = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("displace/ranges"),
            size: RANGE_STRIDE * MAX_RANGES as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let range = wgpu::BufferBinding {
            buffer: &ranges,
            offset: 0,
            size: wgpu::BufferSize::new(size_of::<DisplaceRange>() as u64),
        };
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("displace/group"),
            layout: &self.layout,
            entries: &[
                bind::view(0, heights),
                bind::whole(1, mesh.vertices()),
                bind::whole(2, mesh.displaced()),
                wgpu::BindGroupEntry {
                    binding: 3,
                    resource: wgpu::BindingResource::Buffer(range),
                },
            ],
        });
        DisplaceGroup { ranges, group }
    }

    /// Displaces runs of vertices.
    pub fn run(
        &self,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        frame: &wgpu::BindGroup,
        draw: &DisplaceGroup,
        vertices: &[Range<u32>],
        timestamps: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) {
        let vertices = within_capacity(vertices);
        for (k, run) in vertices.iter().enumerate() {
            let range = DisplaceRange {
                first: run.start,
                count: run.end - run.start,
            };
            queue.write_buffer(
                &draw.ranges,
                k as u64 * RANGE_STRIDE,
                bytemuck::bytes_of(&range),
            );
        }
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("displace/pass"),
            timestamp_writes: timestamps,
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, frame, &[]);
        for (k, run) in vertices.iter().enumerate() {
            pass.set_bind_group(1, &draw.group, &[(k as u64 * RANGE_STRIDE) as u32]);
            pass.dispatch_workgroups((run.end - run.start).div_ceil(WORKGROUP), 1, 1);
        }
    }
}

/// The runs, or one run over all of them where there are too many.
fn within_capacity(vertices: &[Range<u32>]) -> Vec<Range<u32>> {
    match (vertices.first(), vertices.last()) {
        (Some(first), Some(last)) if vertices.len() > MAX_RANGES => {
            std::iter::once(first.start..last.end).collect()
        }
        _ => vertices.to_vec(),
    }
}
