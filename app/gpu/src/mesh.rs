//! The static rings on the GPU: made once for a quality, never touched again.
//!
//! Invariant: vertices of all parts lie in one buffer and all rings share one index buffer, so a
//! part is drawn by its base vertex and a run of indices per visible sector.

use core::ops::Range;

use relievo_engine::planet::clipmap::Plan;
use relievo_engine::planet::clipmap::rings::{
    MeshStepsError, NARROWEST_RING, RingMesh, RingVertex, SECTORS,
};
use relievo_shaders::layout::RingVertexData;
use wgpu::util::DeviceExt;

use crate::quality::Quality;

/// A part of the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    Cap,
    Ring(u8),
    Disc(u8),
}

/// Where a kind of part has its indices.
#[derive(Clone, Debug)]
struct Topology {
    /// Of the first index in the shared buffer.
    first: u32,
    /// Runs of indices by sector, relative to `first`.
    sectors: Vec<Range<u32>>,
}

/// One indexed draw.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshDraw {
    /// Indices.
    pub indices: Range<u32>,
    /// Added to every index.
    pub base_vertex: i32,
}

/// What a plan draws.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MeshSelection {
    /// Draws, nearest parts first.
    pub draws: Vec<MeshDraw>,
    /// Runs of vertices that they use, at most a few.
    pub vertices: Vec<Range<u32>>,
    /// Triangles drawn.
    pub triangles: u64,
    /// Triangles that drawing all sectors would take.
    pub triangles_without_culling: u64,
}

/// Buffers of the mesh.
#[derive(Debug)]
pub struct MeshBuffers {
    vertices: wgpu::Buffer,
    displaced: wgpu::Buffer,
    indices: wgpu::Buffer,
    vertex_count: u32,
    ring_vertices: u32,
    disc_vertices: u32,
    ring: Topology,
    disc: Topology,
    cap: Topology,
}

impl MeshBuffers {
    /// The mesh of a quality.
    ///
    /// # Errors
    /// If its steps cannot be cut into sectors.
    pub fn new(device: &wgpu::Device, quality: &Quality) -> Result<Self, MeshStepsError> {
        let mesh =
            RingMesh::new(quality.azimuth_steps, quality.radial_steps)?.with_layout(quality.layout);
        let mut vertices: Vec<RingVertexData> = Vec::new();
        for ring in 0..=NARROWEST_RING {
            push(&mut vertices, &mesh.ring_vertices(ring), ring);
        }
        let ring_vertices = vertices.len() as u32 / (u32::from(NARROWEST_RING) + 1);
        let discs_begin = vertices.len() as u32;
        for ring in 0..=NARROWEST_RING {
            push(&mut vertices, &mesh.disc_vertices(ring), ring);
        }
        let disc_vertices = (vertices.len() as u32 - discs_begin) / (u32::from(NARROWEST_RING) + 1);
        push(&mut vertices, &mesh.cap_vertices(), 0);

        let mut indices: Vec<u32> = Vec::new();
        let mut topology = |part: relievo_engine::planet::clipmap::rings::SectorIndices| {
            let first = indices.len() as u32;
            indices.extend(part.indices);
            Topology {
                first,
                sectors: part.sectors,
            }
        };
        let (ring, disc, cap) = (
            topology(mesh.ring_indices()),
            topology(mesh.disc_indices()),
            topology(mesh.cap_indices()),
        );
        let vertex_count = vertices.len() as u32;
        Ok(Self {
            vertices: device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("mesh/vertices"),
                contents: bytemuck::cast_slice(&vertices),
                usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::STORAGE,
            }),
            displaced: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("mesh/displaced"),
                size: u64::from(vertex_count) * 16,
                usage: wgpu::BufferUsages::VERTEX
                    | wgpu::BufferUsages::STORAGE
                    | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            }),
            indices: device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("mesh/indices"),
                contents: bytemuck::cast_slice(&indices),
                usage: wgpu::BufferUsages::INDEX,
            }),
            vertex_count,
            ring_vertices,
            disc_vertices,
            ring,
            disc,
            cap,
        })
    }

    /// Static vertices: [`RingVertexData`].
    pub fn vertices(&self) -> &wgpu::Buffer {
        &self.vertices
    }

    /// Displaced vertices: position from the eye and height, four f32 each.
    pub fn displaced(&self) -> &wgpu::Buffer {
        &self.displaced
    }

    /// Indices of all parts, u32.
    pub fn indices(&self) -> &wgpu::Buffer {
        &self.indices
    }

    /// Vertices of all parts.
    pub fn vertex_count(&self) -> u32 {
        self.vertex_count
    }

    /// Memory it takes in bytes.
    pub fn memory(&self) -> u64 {
        self.vertices.size() + self.displaced.size() + self.indices.size()
    }

    /// What a plan shows of the mesh: the disc first, then rings from the narrowest, so that near
    /// ground hides far ground before it is coloured.
    pub fn select(&self, plan: &Plan) -> MeshSelection {
        let all = (1_u32 << SECTORS) - 1;
        let (widest, finest) = (*plan.rings.start(), (*plan.rings.end()).min(NARROWEST_RING));
        let mut parts = vec![(Part::Disc(finest), plan.disc_sectors)];
        for ring in (widest..=finest).rev() {
            let visible = plan
                .sectors
                .iter()
                .find(|s| s.ring == ring)
                .map_or(0, |s| s.visible);
            parts.push((Part::Ring(ring), visible));
        }
        if plan.cap {
            parts.push((Part::Cap, all));
        }
        let mut selection = MeshSelection::default();
        for (part, visible) in parts {
            let (topology, vertices) = self.place(part);
            let triangles = |run: &Range<u32>| u64::from(run.end - run.start) / 3;
            selection.triangles_without_culling +=
                topology.sectors.iter().map(triangles).sum::<u64>();
            if visible & all == 0 {
                continue;
            }
            selection.vertices.push(vertices.clone());
            for run in visible_runs(topology, visible & all) {
                selection.triangles += triangles(&run);
                selection.draws.push(MeshDraw {
                    indices: topology.first + run.start..topology.first + run.end,
                    base_vertex: vertices.start as i32,
                });
            }
        }
        selection.vertices = joined(core::mem::take(&mut selection.vertices));
        selection
    }

    /// Topology and vertices of a part.
    fn place(&self, part: Part) -> (&Topology, Range<u32>) {
        let rings = u32::from(NARROWEST_RING) + 1;
        let run = |first: u32, count: u32| first..first + count;
        match part {
            Part::Ring(ring) => (
                &self.ring,
                run(u32::from(ring) * self.ring_vertices, self.ring_vertices),
            ),
            Part::Disc(ring) => {
                let first = rings * self.ring_vertices + u32::from(ring) * self.disc_vertices;
                (&self.disc, run(first, self.disc_vertices))
            }
            Part::Cap => (
                &self.cap,
                rings * (self.ring_vertices + self.disc_vertices)..self.vertex_count,
            ),
        }
    }
}

fn push(out: &mut Vec<RingVertexData>, vertices: &[RingVertex], ring: u8) {
    out.extend(vertices.iter().map(|v| RingVertexData {
        vertex: v.position,
        ring_minus_rim: f32::from(ring) - v.rim,
    }));
}

/// Runs of indices of neighbouring visible sectors.
fn visible_runs(topology: &Topology, visible: u32) -> Vec<Range<u32>> {
    let runs = topology
        .sectors
        .iter()
        .enumerate()
        .filter(|(k, _)| visible >> k & 1 == 1);
    joined(runs.map(|(_, run)| run.clone()).collect())
}

/// Sorted ranges with touching ones joined.
fn joined(mut ranges: Vec<Range<u32>>) -> Vec<Range<u32>> {
    ranges.sort_by_key(|r| r.start);
    let mut out: Vec<Range<u32>> = Vec::new();
    for range in ranges {
        match out.last_mut() {
            Some(last) if last.end == range.start => last.end = range.end,
            _ => out.push(range),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbouring_sectors_are_one_draw() {
        let topology = Topology {
            first: 0,
            sectors: (0..4).map(|k| k * 6..k * 6 + 6).collect(),
        };
        assert_eq!(visible_runs(&topology, 0b1011), vec![0..12, 18..24]);
        assert_eq!(visible_runs(&topology, 0), Vec::<Range<u32>>::new());
    }
}
