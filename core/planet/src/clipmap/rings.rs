//! The static concentric mesh: rings that halve in radius, a disc inside the last, a cap beyond the
//! first.
//!
//! Vertices are computed in f64 and stored so that a ring of any size keeps full f32 precision. All
//! rings share one topology, so one index buffer serves them all; the same holds for the discs.
//! Invariant: vertices on the border of two parts have equal bits in both, so nothing can gape.
//!
//! Along the meridian through the focus (azimuths 0 and π) vertices are doubled: one belongs to the
//! eastern half, one to the western ([`RingVertex::side`]). Beyond a pole their longitudes from the
//! focus are +π and −π, and a triangle must interpolate towards its own (\[CH06\] 4.4).
//!
//! Source: \[CH06\] 3.4, with κ < 1 so that a ring lies inside its window with room for filtering.

use core::f64::consts::{PI, TAU};
use core::ops::Range;

use super::plan::Layout;

/// Part of its window's half height that a ring takes.
pub const KAPPA: f64 = 0.7;

/// Azimuth sectors into which every ring is cut for culling.
pub const SECTORS: u32 = 16;

/// The narrowest ring: its radius is 0.1 m on Earth.
pub const NARROWEST_RING: u8 = 27;

/// One vertex of the mesh, in the focus frame of the unit sphere: +u south, +v east.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[repr(C)]
pub struct RingVertex {
    /// sin θ̃ cos φ̃, sin θ̃ sin φ̃ and 1 − cos θ̃ (as 2 sin²(θ̃/2)), so that the direction is
    /// (x, y, 1 − z).
    pub position: [f32; 3],
    /// Weight of the next coarser height level: 0 inside the ring to exactly 1 at its outer rim.
    pub rim: f32,
    /// +1 for the eastern half (0 ≤ azimuth ≤ π), −1 for the western: the sign that Δφ takes where
    /// the vertex lies on the meridian opposite to the focus.
    pub side: f32,
}

/// Topology of the mesh and maker of its vertices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RingMesh {
    azimuth_steps: u32,
    radial_steps: u32,
    disc_rows: Vec<u32>,
    layout: Layout,
}

/// Triangles (three indices each, counter-clockwise seen from outside) of one part of the mesh, in
/// [`SECTORS`] consecutive runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SectorIndices {
    /// Indices into the part's vertices.
    pub indices: Vec<u32>,
    /// Which of them belong to each sector; sector k spans the azimuths k to k + 1 times 2π / 16.
    pub sectors: Vec<Range<u32>>,
}

/// A mesh was asked for that cannot be cut into sectors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeshStepsError {
    /// The azimuth steps asked for.
    pub azimuth_steps: u32,
    /// The radial steps asked for.
    pub radial_steps: u32,
}

impl core::fmt::Display for MeshStepsError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(
            f,
            "a ring needs a multiple of {SECTORS} azimuth steps up to 8192 and 1 to 1024 radial \
             steps, not {} and {}",
            self.azimuth_steps, self.radial_steps
        )
    }
}

impl core::error::Error for MeshStepsError {}

impl RingMesh {
    /// A mesh of `azimuth_steps` (a multiple of [`SECTORS`], at most 8192) by `radial_steps` (1 to
    /// 1024) quads in every ring.
    ///
    /// # Errors
    /// If the steps are out of range.
    pub fn new(azimuth_steps: u32, radial_steps: u32) -> Result<Self, MeshStepsError> {
        let fits = (SECTORS..=8192).contains(&azimuth_steps)
            && azimuth_steps.is_multiple_of(SECTORS)
            && (1..=1024).contains(&radial_steps);
        if !fits {
            return Err(MeshStepsError {
                azimuth_steps,
                radial_steps,
            });
        }
        Ok(Self {
            azimuth_steps,
            radial_steps,
            disc_rows: disc_rows(azimuth_steps, radial_steps),
            layout: Layout::STANDARD,
        })
    }

    /// The same mesh for levels that blend otherwise.
    #[must_use]
    pub fn with_layout(self, layout: Layout) -> Self {
        Self { layout, ..self }
    }

    /// Outer radius of a ring as a central angle: κ 2^−ring π; the inner radius is that of
    /// `ring + 1`.
    pub fn outer_radius_rad(ring: u8) -> f64 {
        KAPPA * PI * libm::exp2(-f64::from(ring))
    }

    /// Vertices of a ring, from its outer rim inwards.
    pub fn ring_vertices(&self, ring: u8) -> Vec<RingVertex> {
        let outer = Self::outer_radius_rad(ring);
        let (m, begins) = (self.radial_steps, self.layout.rim_begins());
        let mut vertices = Vec::new();
        for j in 0..=m {
            // exp2(−1) is exact, so the last row is the next ring's first, bit for bit.
            let part = libm::exp2(-f64::from(j) / f64::from(m));
            let rim = ((part - begins) / (1.0 - begins)).clamp(0.0, 1.0) as f32;
            push_row(&mut vertices, outer * part, self.azimuth_steps, rim);
        }
        vertices
    }

    /// Vertices of the disc inside a ring, from the ring's inner rim to the focus.
    pub fn disc_vertices(&self, ring: u8) -> Vec<RingVertex> {
        let radius = Self::outer_radius_rad(ring + 1);
        let rows = self.disc_rows.len() as f64;
        let mut vertices = Vec::new();
        for (j, &steps) in self.disc_rows.iter().enumerate() {
            push_row(
                &mut vertices,
                radius * ((rows - j as f64) / rows),
                steps,
                0.0,
            );
        }
        for side in [1.0, -1.0] {
            vertices.push(RingVertex {
                position: [0.0; 3],
                rim: 0.0,
                side,
            });
        }
        vertices
    }

    /// Vertices of the cap beyond ring 0, from the antipode of the focus to ring 0's outer rim.
    pub fn cap_vertices(&self) -> Vec<RingVertex> {
        let (rim, rows) = (Self::outer_radius_rad(0), self.cap_row_count());
        let mut vertices = Vec::new();
        for j in 0..=rows {
            let angle = PI + (rim - PI) * (f64::from(j) / f64::from(rows));
            push_row(
                &mut vertices,
                if j == rows { rim } else { angle },
                self.azimuth_steps,
                0.0,
            );
        }
        vertices
    }

    /// Triangles of a ring: `2 · azimuth_steps · radial_steps`.
    pub fn ring_indices(&self) -> SectorIndices {
        Self::indices_of(
            &vec![self.azimuth_steps; self.radial_steps as usize + 1],
            false,
        )
    }

    /// Triangles of a disc.
    pub fn disc_indices(&self) -> SectorIndices {
        Self::indices_of(&self.disc_rows, true)
    }

    /// Triangles of the cap.
    pub fn cap_indices(&self) -> SectorIndices {
        Self::indices_of(
            &vec![self.azimuth_steps; self.cap_row_count() as usize + 1],
            false,
        )
    }

    /// Rows of quads in the cap, about as long as those of ring 0.
    fn cap_row_count(&self) -> u32 {
        let row = KAPPA * PI * core::f64::consts::LN_2 / f64::from(self.radial_steps);
        libm::ceil((1.0 - KAPPA) * PI / row).max(1.0) as u32
    }

    /// Triangles between consecutive rows with the given numbers of azimuth steps, where a row has
    /// as many steps as the one before or half as many; then, if `centre`, a fan to the two last
    /// vertices.
    fn indices_of(rows: &[u32], centre: bool) -> SectorIndices {
        let mut starts = vec![0];
        for steps in rows {
            starts.push(starts[starts.len() - 1] + steps + 2);
        }
        let mut out = SectorIndices {
            indices: Vec::new(),
            sectors: Vec::new(),
        };
        for sector in 0..SECTORS {
            let begin = out.indices.len() as u32;
            let west = sector >= SECTORS / 2;
            let vertex = |row: usize, step: u32| {
                starts[row] + sector * (rows[row] / SECTORS) + step + u32::from(west)
            };
            for row in 0..rows.len() {
                let steps = rows[row] / SECTORS;
                if row + 1 < rows.len() {
                    let halved = rows[row + 1] < rows[row];
                    for k in 0..steps {
                        let (a, b) = (vertex(row, k), vertex(row, k + 1));
                        if halved {
                            let (c, d) = (vertex(row + 1, k / 2), vertex(row + 1, k / 2 + 1));
                            if k.is_multiple_of(2) {
                                out.indices.extend([a, b, c]);
                            } else {
                                out.indices.extend([a, b, d, c, a, d]);
                            }
                        } else {
                            let (c, d) = (vertex(row + 1, k), vertex(row + 1, k + 1));
                            out.indices.extend([a, b, c, c, b, d]);
                        }
                    }
                } else if centre {
                    let focus = starts[rows.len()] + u32::from(west);
                    for k in 0..steps {
                        out.indices
                            .extend([vertex(row, k), vertex(row, k + 1), focus]);
                    }
                }
            }
            out.sectors.push(begin..out.indices.len() as u32);
        }
        out
    }
}

/// Azimuth steps of the disc's rows from its rim inwards, without its centre: as long as the rows of
/// the ring outside it, and half as many steps in every octave of radius as long as sectors allow.
fn disc_rows(azimuth_steps: u32, radial_steps: u32) -> Vec<u32> {
    let count = libm::ceil(f64::from(radial_steps) / core::f64::consts::LN_2) as u32;
    let mut steps = azimuth_steps;
    let mut octave = count;
    (0..count)
        .map(|j| {
            if 2 * (count - j) <= octave && (steps / SECTORS).is_multiple_of(2) {
                steps /= 2;
                octave = count - j;
            }
            steps
        })
        .collect()
}

/// One circle of vertices: `steps / 2 + 1` of the eastern half, then as many of the western.
fn push_row(vertices: &mut Vec<RingVertex>, angle_rad: f64, steps: u32, rim: f32) {
    let sin_angle = if angle_rad >= PI {
        0.0
    } else {
        libm::sin(angle_rad)
    };
    let sin_half = libm::sin(0.5 * angle_rad);
    let versine = 2.0 * sin_half * sin_half;
    let half = steps / 2;
    for (side, first) in [(1.0, 0), (-1.0, half)] {
        for k in first..=first + half {
            // On the meridian of the focus v is exactly 0 and both copies agree in every bit.
            let (cos_azimuth, sin_azimuth) = match k {
                k if k == 0 || k == steps => (1.0, 0.0),
                k if k == half => (-1.0, 0.0),
                k => {
                    let (s, c) = libm::sincos(TAU * f64::from(k) / f64::from(steps));
                    (c, s)
                }
            };
            vertices.push(RingVertex {
                position: [
                    (sin_angle * cos_azimuth) as f32,
                    (sin_angle * sin_azimuth) as f32,
                    versine as f32,
                ],
                rim,
                side,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    fn bits(v: &RingVertex) -> [u32; 3] {
        v.position.map(|x| (x + 0.0).to_bits())
    }

    #[test]
    fn neighbouring_parts_share_their_border_bit_for_bit() {
        let mesh = RingMesh::new(96, 7).unwrap();
        let row = 98;
        for ring in 0..NARROWEST_RING {
            let (outer, inner) = (mesh.ring_vertices(ring), mesh.ring_vertices(ring + 1));
            let disc = mesh.disc_vertices(ring);
            for k in 0..row {
                let rim = &outer[outer.len() - row + k];
                assert_eq!(bits(rim), bits(&inner[k]));
                assert_eq!(bits(rim), bits(&disc[k]));
                assert_eq!((rim.rim, inner[k].rim), (0.0, 1.0));
            }
        }
        let (cap, ring) = (mesh.cap_vertices(), mesh.ring_vertices(0));
        for k in 0..row {
            assert_eq!(bits(&cap[cap.len() - row + k]), bits(&ring[k]));
        }
    }

    #[test]
    fn every_edge_inside_the_mesh_has_a_triangle_on_both_sides() {
        let mesh = RingMesh::new(64, 6).unwrap();
        let mut edges: HashMap<([u32; 3], [u32; 3]), i32> = HashMap::new();
        let parts = [
            (mesh.cap_vertices(), mesh.cap_indices()),
            (mesh.ring_vertices(0), mesh.ring_indices()),
            (mesh.ring_vertices(1), mesh.ring_indices()),
            (mesh.disc_vertices(1), mesh.disc_indices()),
        ];
        for (vertices, indices) in &parts {
            for t in indices.indices.chunks(3) {
                let p: Vec<_> = t.iter().map(|&i| bits(&vertices[i as usize])).collect();
                if p[0] == p[1] || p[1] == p[2] || p[2] == p[0] {
                    continue; // the fan around the antipode has triangles of no area
                }
                for (a, b) in [(p[0], p[1]), (p[1], p[2]), (p[2], p[0])] {
                    *edges.entry((a, b)).or_default() += 1;
                    *edges.entry((b, a)).or_default() -= 1;
                }
            }
        }
        assert!(
            edges.values().all(|&n| n == 0),
            "a closed surface, consistently oriented"
        );
    }

    #[test]
    fn triangles_are_counter_clockwise_seen_from_outside() {
        let mesh = RingMesh::new(64, 6).unwrap();
        for (vertices, indices) in [
            (mesh.ring_vertices(2), mesh.ring_indices()),
            (mesh.disc_vertices(2), mesh.disc_indices()),
        ] {
            for t in indices.indices.chunks(3) {
                let p = |i: usize| {
                    let [u, v, w] = vertices[t[i] as usize].position.map(f64::from);
                    glam::DVec3::new(u, v, 1.0 - w)
                };
                let normal = (p(1) - p(0)).cross(p(2) - p(0));
                assert!(normal.dot(p(0)) > 0.0, "{t:?}");
            }
        }
    }

    #[test]
    fn sectors_hold_the_azimuths_that_they_say() {
        let mesh = RingMesh::new(64, 6).unwrap();
        let vertices = mesh.ring_vertices(3);
        let indices = mesh.ring_indices();
        assert_eq!(indices.indices.len(), 3 * 2 * 64 * 6);
        for (k, range) in indices.sectors.iter().enumerate() {
            for &i in &indices.indices[range.start as usize..range.end as usize] {
                let v = vertices[i as usize];
                let azimuth = f64::from(v.position[1]).atan2(f64::from(v.position[0]));
                let from = TAU * k as f64 / f64::from(SECTORS);
                let off = (azimuth - from + 1e-6).rem_euclid(TAU);
                assert!(off <= TAU / f64::from(SECTORS) + 2e-6, "sector {k}: {off}");
                assert_eq!(v.side > 0.0, k < 8);
            }
        }
    }

    #[test]
    fn a_blend_is_as_wide_as_the_layout_says_and_ends_at_the_rim() {
        for (blend_percent, begins) in [(1, 0.995), (25, 0.875), (50, 0.75), (100, 0.5)] {
            let layout = Layout {
                blend_percent,
                ..Layout::STANDARD
            };
            let mesh = RingMesh::new(16, 200).unwrap().with_layout(layout);
            let vertices = mesh.ring_vertices(3);
            assert_eq!(
                (vertices[0].rim, vertices[vertices.len() - 1].rim),
                (1.0, 0.0)
            );
            for (j, row) in vertices.chunks(18).enumerate() {
                let part = (-(j as f64) / 200.0).exp2();
                assert_eq!(row[0].rim > 0.0, part > begins, "{blend_percent} {part}");
            }
        }
    }

    #[test]
    fn a_mesh_that_cannot_be_cut_into_sectors_is_refused() {
        assert!(RingMesh::new(100, 4).is_err());
        assert!(RingMesh::new(64, 0).is_err());
    }
}
