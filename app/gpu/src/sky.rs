//! The sky pass: fills what the terrain left.

use relievo_shaders::Entry;

use crate::bind;
use crate::targets;

/// Pipelines of the sky pass, without and with air. Immutable.
#[derive(Debug)]
pub struct SkyPass {
    pipelines: [wgpu::RenderPipeline; 2],
}

impl SkyPass {
    /// The pass; `frame` is the layout of group 0.
    pub fn new(device: &wgpu::Device, frame: &wgpu::BindGroupLayout) -> Self {
        let module = bind::module(device, Entry::Sky);
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("sky/pipeline layout"),
            bind_group_layouts: &[Some(frame)],
            immediate_size: 0,
        });
        let pipeline = |haze| {
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("sky/pipeline"),
                layout: Some(&layout),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("sky_vertex"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState::default(),
                // At infinity: only where no terrain has written a depth.
                depth_stencil: Some(targets::depth_state(
                    false,
                    wgpu::CompareFunction::GreaterEqual,
                )),
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some("sky_fragment"),
                    compilation_options: wgpu::PipelineCompilationOptions {
                        constants: &[("HAS_HAZE", bind::switch(haze))],
                        ..Default::default()
                    },
                    targets: &[Some(targets::COLOUR_FORMAT.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        Self {
            pipelines: [pipeline(false), pipeline(true)],
        }
    }

    /// Draws the sky; group 0 is already bound.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, haze: bool) {
        pass.set_pipeline(&self.pipelines[usize::from(haze)]);
        pass.draw(0..3, 0..1);
    }
}
