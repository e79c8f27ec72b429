//! The terrain pass: draws visible sectors, coloured and lit per fragment.
//!
//! Invariant: a pipeline holds exactly what its [`TerrainKey`] names; a scene without colours,
//! normals or air runs shaders without them.

use std::collections::BTreeMap;

use relievo_shaders::Entry;
use relievo_shaders::layout::RingVertexData;

use crate::bind;
use crate::mesh::{MeshBuffers, MeshSelection};
use crate::targets;

/// What a scene uses, and so which pipeline draws it.
#[expect(
    clippy::struct_excessive_bools,
    reason = "each switches a part of the shader"
)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TerrainKey {
    /// Whether some source colours the ground.
    pub colour: bool,
    /// Whether the ground is lit.
    pub normals: bool,
    /// Whether there is air.
    pub haze: bool,
    /// Whether one choice of levels serves colours and normals.
    pub shared_levels: bool,
    /// Whether a fragment between two levels mixes both.
    pub blends_levels: bool,
    /// Most taps along a footprint's major axis.
    pub max_taps: u32,
}

/// Layouts, shaders and pipelines of the terrain pass; a pipeline is made when a scene first needs
/// it.
#[derive(Debug)]
pub struct TerrainPass {
    module: wgpu::ShaderModule,
    layout: wgpu::BindGroupLayout,
    pipeline_layout: wgpu::PipelineLayout,
    sampler: wgpu::Sampler,
    pipelines: BTreeMap<TerrainKey, wgpu::RenderPipeline>,
}

impl TerrainPass {
    /// The pass; `frame` is the layout of group 0.
    pub fn new(device: &wgpu::Device, frame: &wgpu::BindGroupLayout) -> Self {
        let fragment = wgpu::ShaderStages::FRAGMENT;
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("terrain/layout"),
            entries: &[
                bind::texture(0, fragment, wgpu::TextureViewDimension::D2Array, true),
                bind::texture(1, fragment, wgpu::TextureViewDimension::D2Array, true),
                bind::sampler(2),
            ],
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("terrain/pipeline layout"),
            bind_group_layouts: &[Some(frame), Some(&layout)],
            immediate_size: 0,
        });
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("terrain/wrapping"),
            address_mode_u: wgpu::AddressMode::Repeat,
            address_mode_v: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let module = bind::module(device, Entry::Terrain);
        Self {
            module,
            layout,
            pipeline_layout,
            sampler,
            pipelines: BTreeMap::new(),
        }
    }

    /// Binds the textures.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        colours: &wgpu::TextureView,
        normals: &wgpu::TextureView,
    ) -> wgpu::BindGroup {
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("terrain/group"),
            layout: &self.layout,
            entries: &[
                bind::view(0, colours),
                bind::view(1, normals),
                wgpu::BindGroupEntry {
                    binding: 2,
                    resource: wgpu::BindingResource::Sampler(&self.sampler),
                },
            ],
        })
    }

    /// Keys of the pipelines made so far, in order.
    pub fn pipeline_keys(&self) -> Vec<TerrainKey> {
        self.pipelines.keys().copied().collect()
    }

    /// Draws a selection of the mesh.
    pub fn draw(
        &mut self,
        device: &wgpu::Device,
        pass: &mut wgpu::RenderPass<'_>,
        key: TerrainKey,
        group: &wgpu::BindGroup,
        mesh: &MeshBuffers,
        selection: &MeshSelection,
    ) {
        let Self {
            module,
            pipeline_layout,
            pipelines,
            ..
        } = self;
        let pipeline = pipelines
            .entry(key)
            .or_insert_with(|| pipeline(device, module, pipeline_layout, key));
        pass.set_pipeline(pipeline);
        pass.set_bind_group(1, group, &[]);
        pass.set_vertex_buffer(0, mesh.displaced().slice(..));
        pass.set_vertex_buffer(1, mesh.vertices().slice(..));
        pass.set_index_buffer(mesh.indices().slice(..), wgpu::IndexFormat::Uint32);
        for draw in &selection.draws {
            pass.draw_indexed(draw.indices.clone(), draw.base_vertex, 0..1);
        }
    }
}

fn pipeline(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    key: TerrainKey,
) -> wgpu::RenderPipeline {
    let attribute = |location| wgpu::VertexAttribute {
        format: wgpu::VertexFormat::Float32x4,
        offset: 0,
        shader_location: location,
    };
    let attributes = [[attribute(0)], [attribute(1)]];
    let buffer = |attributes| {
        Some(wgpu::VertexBufferLayout {
            array_stride: size_of::<RingVertexData>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes,
        })
    };
    let constants = [
        ("HAS_COLOUR", bind::switch(key.colour)),
        ("HAS_NORMALS", bind::switch(key.normals)),
        ("HAS_HAZE", bind::switch(key.haze)),
        ("SHARED_LEVELS", bind::switch(key.shared_levels)),
        ("BLENDS_LEVELS", bind::switch(key.blends_levels)),
        ("MAX_TAPS", f64::from(key.max_taps)),
    ];
    let specialised = wgpu::PipelineCompilationOptions {
        constants: &constants,
        ..Default::default()
    };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("terrain/pipeline"),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("terrain_vertex"),
            compilation_options: specialised.clone(),
            buffers: &[buffer(&attributes[0]), buffer(&attributes[1])],
        },
        primitive: wgpu::PrimitiveState {
            cull_mode: Some(wgpu::Face::Back),
            ..Default::default()
        },
        depth_stencil: Some(targets::depth_state(true, wgpu::CompareFunction::Greater)),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some("terrain_fragment"),
            compilation_options: specialised,
            targets: &[Some(targets::COLOUR_FORMAT.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
