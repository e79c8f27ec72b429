//! Bind group 0: what every pass of a frame reads.

use relievo_shaders::layout::FrameUniform;

use crate::bind;
use crate::uniforms::LevelUniforms;

/// The frame's uniforms and their bind group.
#[derive(Debug)]
pub struct FrameGroup {
    frame: wgpu::Buffer,
    levels: wgpu::Buffer,
    layout: wgpu::BindGroupLayout,
    group: wgpu::BindGroup,
}

impl FrameGroup {
    /// Buffers of zeros.
    pub fn new(device: &wgpu::Device) -> Self {
        let buffer = |label, size| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let frame = buffer("frame_group/frame", size_of::<FrameUniform>() as u64);
        let levels = buffer("frame_group/levels", size_of::<LevelUniforms>() as u64);
        let stages = wgpu::ShaderStages::COMPUTE | wgpu::ShaderStages::VERTEX_FRAGMENT;
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("frame_group/layout"),
            entries: &[
                bind::uniform(0, stages, false),
                bind::uniform(1, stages, false),
            ],
        });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("frame_group/group"),
            layout: &layout,
            entries: &[bind::whole(0, &frame), bind::whole(1, &levels)],
        });
        Self {
            frame,
            levels,
            layout,
            group,
        }
    }

    /// Its layout.
    pub fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    /// The group.
    pub fn group(&self) -> &wgpu::BindGroup {
        &self.group
    }

    /// Replaces the uniforms from the next submission on.
    pub fn write(&self, queue: &wgpu::Queue, frame: &FrameUniform, levels: &LevelUniforms) {
        queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(frame));
        queue.write_buffer(&self.levels, 0, bytemuck::cast_slice(levels));
    }
}
