//! The pass of bodies that stand on the ground.
//!
//! Invariant: buffers are those of the latest frame's meshes, by their names; a frame without bodies
//! makes no pipeline and binds nothing.

use std::collections::BTreeMap;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use relievo_engine::planet::clipmap::view::{FocusFrame, View};
use relievo_engine::{Frame, MassMesh};
use relievo_shaders::Entry;
use relievo_shaders::layout::MassPlace;
use wgpu::util::{BufferInitDescriptor, DeviceExt};

use crate::bind;
use crate::targets;

/// A vertex as the device reads it.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Vertex {
    offset_m: [f32; 3],
    normal: [f32; 3],
    rgba: [u8; 4],
}

/// One mesh on the device.
#[derive(Debug)]
struct Loaded {
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    count: u32,
    place: wgpu::Buffer,
    group: wgpu::BindGroup,
    /// Whether the view can see it.
    visible: bool,
}

/// Layouts and pipelines of the pass, and the meshes that are drawn.
#[derive(Debug)]
pub struct MassPass {
    frame: wgpu::BindGroupLayout,
    layout: wgpu::BindGroupLayout,
    /// Without and with air; made when first needed.
    pipelines: [Option<wgpu::RenderPipeline>; 2],
    loaded: BTreeMap<u64, Loaded>,
}

impl MassPass {
    /// The pass; `frame` is the layout of group 0.
    pub fn new(device: &wgpu::Device, frame: &wgpu::BindGroupLayout) -> Self {
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("masses/layout"),
            entries: &[bind::uniform(0, wgpu::ShaderStages::VERTEX_FRAGMENT, false)],
        });
        Self {
            frame: frame.clone(),
            layout,
            pipelines: [None, None],
            loaded: BTreeMap::new(),
        }
    }

    /// Brings the frame's meshes to the device, forgets others and says where each lies from the
    /// eye. Returns whether something came or went.
    pub fn follow(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, frame: &Frame) -> bool {
        let before = self.loaded.len();
        let wanted = |id: &u64| frame.masses.iter().any(|m| m.id == *id);
        self.loaded.retain(|id, _| wanted(id));
        let mut changed = self.loaded.len() != before;
        let view = View::new(&frame.camera, &frame.planet, frame.viewport_px);
        for mesh in &frame.masses {
            let loaded = self.loaded.entry(mesh.id).or_insert_with(|| {
                changed = true;
                load(device, &self.layout, mesh)
            });
            loaded.visible = is_in_front(&view, mesh);
            let place = place_of(frame, &view, mesh);
            queue.write_buffer(&loaded.place, 0, bytemuck::bytes_of(&place));
        }
        changed
    }

    /// Triangles that are drawn.
    pub fn triangles(&self) -> u64 {
        let visible = self.loaded.values().filter(|m| m.visible);
        visible.map(|m| u64::from(m.count / 3)).sum()
    }

    /// Memory on the device, bytes.
    pub fn memory(&self) -> u64 {
        let bytes = |m: &Loaded| m.vertices.size() + m.indices.size() + m.place.size();
        self.loaded.values().map(bytes).sum()
    }

    /// Draws all meshes; group 0 is already bound.
    pub fn draw(&mut self, device: &wgpu::Device, pass: &mut wgpu::RenderPass<'_>, haze: bool) {
        if self.triangles() == 0 {
            return;
        }
        let layouts = [Some(&self.frame), Some(&self.layout)];
        let pipeline = self.pipelines[usize::from(haze)]
            .get_or_insert_with(|| pipeline(device, &layouts, haze));
        pass.set_pipeline(pipeline);
        for mesh in self.loaded.values().filter(|m| m.visible) {
            pass.set_bind_group(1, &mesh.group, &[]);
            pass.set_vertex_buffer(0, mesh.vertices.slice(..));
            pass.set_index_buffer(mesh.indices.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..mesh.count, 0, 0..1);
        }
    }
}

fn load(device: &wgpu::Device, layout: &wgpu::BindGroupLayout, mesh: &Arc<MassMesh>) -> Loaded {
    let vertices: Vec<Vertex> = mesh
        .vertices
        .iter()
        .map(|v| Vertex {
            offset_m: v.offset_m,
            normal: v.normal,
            rgba: v.rgba,
        })
        .collect();
    let buffer = |label, contents: &[u8], usage| {
        device.create_buffer_init(&BufferInitDescriptor {
            label: Some(label),
            contents,
            usage,
        })
    };
    let place = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("masses/place"),
        size: size_of::<MassPlace>() as u64,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("masses/group"),
        layout,
        entries: &[bind::whole(0, &place)],
    });
    Loaded {
        vertices: buffer(
            "masses/vertices",
            bytemuck::cast_slice(&vertices),
            wgpu::BufferUsages::VERTEX,
        ),
        indices: buffer(
            "masses/indices",
            bytemuck::cast_slice(&mesh.indices),
            wgpu::BufferUsages::INDEX,
        ),
        count: mesh.indices.len() as u32,
        place,
        group,
        visible: true,
    }
}

/// Whether some part of a mesh may lie before the eye.
fn is_in_front(view: &View, mesh: &MassMesh) -> bool {
    (mesh.origin_in_world - view.eye).dot(view.forward) > -mesh.radius_m
}

fn place_of(frame: &Frame, view: &View, mesh: &MassMesh) -> MassPlace {
    let at = FocusFrame::at(frame.plan.focus);
    let turned = |v: DVec3| {
        DVec3::new(at.south.dot(v), at.east.dot(v), at.up.dot(v))
            .as_vec3()
            .to_array()
    };
    MassPlace {
        focus_from_world_x: turned(DVec3::X),
        focus_from_world_y: turned(DVec3::Y),
        focus_from_world_z: turned(DVec3::Z),
        origin_from_eye_m: turned(mesh.origin_in_world - view.eye),
        up_in_focus: turned(mesh.origin_in_world.normalize_or(DVec3::Z)),
        origin_height_m: (mesh.origin_in_world.length() - frame.planet.radius_m) as f32,
        ..MassPlace::default()
    }
}

fn pipeline(
    device: &wgpu::Device,
    layouts: &[Option<&wgpu::BindGroupLayout>],
    haze: bool,
) -> wgpu::RenderPipeline {
    let module = bind::module(device, Entry::Masses);
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("masses/pipeline layout"),
        bind_group_layouts: layouts,
        immediate_size: 0,
    });
    let constants = [("HAS_HAZE", bind::switch(haze))];
    let specialised = wgpu::PipelineCompilationOptions {
        constants: &constants,
        ..Default::default()
    };
    let attributes = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Unorm8x4];
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("masses/pipeline"),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("mass_vertex"),
            compilation_options: specialised.clone(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: size_of::<Vertex>() as u64,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &attributes,
            })],
        },
        primitive: wgpu::PrimitiveState {
            cull_mode: Some(wgpu::Face::Back),
            ..Default::default()
        },
        depth_stencil: Some(targets::depth_state(true, wgpu::CompareFunction::Greater)),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("mass_fragment"),
            compilation_options: specialised,
            targets: &[Some(targets::COLOUR_FORMAT.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
