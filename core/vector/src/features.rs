//! Features in memory: vertices in longitude and latitude, properties, an index by place.

mod bounds;
mod build;
mod chunks;
mod index;
mod reach;
mod ring;

use std::sync::Arc;

use glam::DVec2;

use crate::Value;
pub use bounds::Bounds;
pub use build::{Builder, Limits, Outline};
pub(crate) use chunks::{Visit, Walker};
use index::Index;
pub(crate) use reach::Hit;
pub(crate) use ring::on_antimeridian;

/// What the vertices of a part are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Shape {
    /// Points, each for itself.
    Points,
    /// A line through them.
    Line,
    /// The outer ring of a polygon; the last vertex is the first, or the first a turn further on.
    Outer,
    /// A hole in a polygon, likewise.
    Hole,
}

/// A piece of a feature.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub(crate) shape: Shape,
    /// The pole that a ring goes around, 1 for north and −1 for south: the inside reaches from the
    /// vertices to that pole. 0 for all others.
    pub(crate) pole: i8,
    pub(crate) feature: u32,
    first: u32,
    length: u32,
    /// First of its chunks, if it is long enough to have any.
    chunks: u32,
    pub(crate) bounds: Bounds,
}

impl Part {
    /// Place of its first vertex among all features' vertices.
    pub(crate) fn first_vertex(&self) -> usize {
        self.first as usize
    }
}

/// A feature.
#[derive(Clone, Debug)]
struct Feature {
    first_part: u32,
    parts: u32,
    /// Names its geometry.
    hash: [u8; 16],
    properties: Box<[(u16, Value)]>,
}

/// Features, immutable and shared.
///
/// Longitudes are in radians and run on across the antimeridian: a part's vertices follow each other
/// without jumps, and its middle lies between −π and π.
#[derive(Debug)]
pub struct Features {
    vertices: Vec<DVec2>,
    parts: Vec<Part>,
    all: Vec<Feature>,
    columns: Vec<Arc<str>>,
    chunks: Vec<Bounds>,
    index: Index,
    hash: [u8; 32],
    /// Vertices that the file has and that lie nowhere on the planet.
    pub(crate) lost: u64,
}

impl Features {
    /// Number of features.
    pub fn len(&self) -> usize {
        self.all.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// Number of vertices of all features.
    pub fn vertices(&self) -> usize {
        self.vertices.len()
    }

    /// Number of vertices that were left out because they lie nowhere on the planet.
    pub fn lost_vertices(&self) -> u64 {
        self.lost
    }

    /// Names of the properties, in the order in which they were first met.
    pub fn columns(&self) -> &[Arc<str>] {
        &self.columns
    }

    /// Names everything about all features: equal names mean equal features.
    pub fn fingerprint(&self) -> [u8; 32] {
        self.hash
    }

    /// Bytes that the features take in memory, without what the allocator adds.
    pub fn memory_bytes(&self) -> usize {
        let properties: usize = self
            .all
            .iter()
            .map(|f| {
                let text: usize = f
                    .properties
                    .iter()
                    .map(|(_, v)| if let Value::Text(t) = v { t.len() } else { 0 })
                    .sum();
                size_of_val(&*f.properties) + text
            })
            .sum();
        self.vertices.len() * size_of::<DVec2>()
            + self.parts.len() * size_of::<Part>()
            + self.all.len() * size_of::<Feature>()
            + self.chunks.len() * size_of::<Bounds>()
            + self.index.memory_bytes()
            + properties
    }

    /// The box around everything; `None` where there is nothing.
    pub fn bounds(&self) -> Option<Bounds> {
        self.index.bounds()
    }

    /// The value of a feature's property; [`Value::Null`] where it has none.
    pub fn property(&self, feature: usize, name: &str) -> &Value {
        let column = self.columns.iter().position(|c| **c == *name);
        column.map_or(&Value::Null, |column| self.value(feature, column))
    }

    /// The value of a feature's property by the place of its name in [`Self::columns`].
    pub fn value(&self, feature: usize, column: usize) -> &Value {
        let properties = &self.all[feature].properties;
        properties
            .iter()
            .find(|(c, _)| usize::from(*c) == column)
            .map_or(&Value::Null, |(_, v)| v)
    }

    /// A feature's properties in the file's order.
    pub fn properties(&self, feature: usize) -> impl Iterator<Item = (&str, &Value)> {
        let properties = self.all[feature].properties.iter();
        properties.map(|(column, value)| (&*self.columns[usize::from(*column)], value))
    }

    /// A feature's pieces: what each is, and its vertices as longitude and latitude in radians.
    pub fn outlines(&self, feature: usize) -> impl Iterator<Item = Outline<'_>> {
        self.parts_of(feature).map(|part| Outline {
            shape: part.shape,
            pole: part.pole,
            lonlat_rad: self.vertices_of(part),
        })
    }

    /// The box around a feature; `None` where it has no geometry.
    pub fn bounds_of(&self, feature: usize) -> Option<Bounds> {
        self.parts_of(feature)
            .map(|p| p.bounds)
            .reduce(|a, b| a.union(&b))
    }

    pub(crate) fn hash_of(&self, feature: usize) -> [u8; 16] {
        self.all[feature].hash
    }

    pub(crate) fn part(&self, part: u32) -> &Part {
        &self.parts[part as usize]
    }

    fn parts_of(&self, feature: usize) -> core::slice::Iter<'_, Part> {
        let f = &self.all[feature];
        self.parts[f.first_part as usize..][..f.parts as usize].iter()
    }

    pub(crate) fn vertices_of(&self, part: &Part) -> &[DVec2] {
        &self.vertices[part.first as usize..][..part.length as usize]
    }
}

#[cfg(test)]
mod tests;
