//! Lists of vertices: shared, so that copies of a project and undo steps do not copy geometry.

use core::fmt;
use std::sync::{Arc, OnceLock};

/// A place on the ground, with a height where the list's owner takes heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Longitude in degrees east, −360 to 360. Neighbours lie less than 180° apart: a line across
    /// the antimeridian goes on beyond 180.
    pub lon_deg: f64,
    /// Latitude in degrees north, −90 to 90.
    pub lat_deg: f64,
    /// Metres above the datum, −10⁷ to 10⁷. `None`: the ground's, or what lies between neighbours.
    pub height_m: Option<f64>,
}

impl Vertex {
    /// A vertex without a height of its own.
    pub fn new(lon_deg: f64, lat_deg: f64) -> Self {
        Self {
            lon_deg,
            lat_deg,
            height_m: None,
        }
    }

    /// A vertex with a height.
    pub fn at_height(lon_deg: f64, lat_deg: f64, height_m: f64) -> Self {
        Self {
            lon_deg,
            lat_deg,
            height_m: Some(height_m),
        }
    }
}

/// The hash of a list's content (BLAKE3), which also names the file beside the project that holds it.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ContentHash(pub [u8; 32]);

impl ContentHash {
    /// From 64 lower-case hexadecimal digits.
    pub fn from_hex(text: &str) -> Option<Self> {
        let is_canonical = text
            .bytes()
            .all(|b| b.is_ascii_digit() || (b'a'..=b'f').contains(&b));
        let hash = blake3::Hash::from_hex(text).ok().filter(|_| is_canonical)?;
        Some(Self(*hash.as_bytes()))
    }
}

impl fmt::Display for ContentHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&blake3::Hash::from(self.0).to_hex())
    }
}

impl fmt::Debug for ContentHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// A list of vertices that lies in a file of its own beside the project.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct SideFile {
    /// Names the file and says what must be in it.
    pub hash: ContentHash,
    /// How many vertices it holds.
    pub vertices: u32,
}

/// A list of vertices: an outline, a hole, a line, the points of a stroke. Cheap to clone.
///
/// Lists of more than 10 000 vertices lie in files beside the project. One whose file is missing or
/// damaged counts as empty and keeps its reference, so that saving does not lose it.
#[derive(Clone)]
pub struct Vertices(Inner);

#[derive(Clone)]
enum Inner {
    Here(Arc<List>),
    Elsewhere(SideFile),
}

struct List {
    vertices: Vec<Vertex>,
    /// Hash of the bytes in a side file; made when it is first asked for.
    hash: OnceLock<ContentHash>,
}

impl Vertices {
    /// An empty list.
    pub fn new() -> Self {
        Self::from(Vec::new())
    }

    /// A list that lies in a file which is not loaded.
    pub fn elsewhere(side_file: SideFile) -> Self {
        Self(Inner::Elsewhere(side_file))
    }

    /// The vertices; none where they lie in a file that is missing.
    pub fn as_slice(&self) -> &[Vertex] {
        match &self.0 {
            Inner::Here(list) => &list.vertices,
            Inner::Elsewhere(_) => &[],
        }
    }

    /// The file that should hold the vertices, where they are not here.
    pub fn missing(&self) -> Option<&SideFile> {
        match &self.0 {
            Inner::Here(_) => None,
            Inner::Elsewhere(side_file) => Some(side_file),
        }
    }

    /// Whether both are one list in memory (or name one file): equal without a look at the vertices.
    pub fn is_same(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (Inner::Here(a), Inner::Here(b)) => Arc::ptr_eq(a, b),
            (Inner::Elsewhere(a), Inner::Elsewhere(b)) => a == b,
            _ => false,
        }
    }

    /// Hash of the content: equal for equal vertices, made once a list.
    pub fn content_hash(&self) -> ContentHash {
        match &self.0 {
            Inner::Here(list) => *list
                .hash
                .get_or_init(|| ContentHash(*blake3::hash(&to_bytes(&list.vertices)).as_bytes())),
            Inner::Elsewhere(side_file) => side_file.hash,
        }
    }

    /// The same list as a reference to its file.
    pub(crate) fn to_side_file(&self) -> SideFile {
        match &self.0 {
            Inner::Here(list) => SideFile {
                hash: self.content_hash(),
                vertices: u32::try_from(list.vertices.len()).unwrap_or(u32::MAX),
            },
            Inner::Elsewhere(side_file) => side_file.clone(),
        }
    }

    /// Bytes of the file that holds the list.
    pub(crate) fn to_side_bytes(&self) -> Vec<u8> {
        to_bytes(self.as_slice())
    }

    /// A list from the bytes of its file; what is wrong with them in words.
    pub(crate) fn from_side_bytes(bytes: &[u8], expected: &SideFile) -> Result<Self, String> {
        let hash = ContentHash(*blake3::hash(bytes).as_bytes());
        if hash != expected.hash {
            return Err(format!("expected content {}, found {hash}", expected.hash));
        }
        let vertices = from_bytes(bytes).ok_or("expected a list of vertices, found other bytes")?;
        let list = List {
            vertices,
            hash: OnceLock::from(hash),
        };
        Ok(Self(Inner::Here(Arc::new(list))))
    }
}

/// Begins a file of vertices; the number is the version of what follows.
const MAGIC: &[u8; 16] = b"relievo vertex 1";
/// Longitude, latitude, height as little-endian doubles; NaN for no height.
const VERTEX_BYTES: usize = 24;

fn to_bytes(vertices: &[Vertex]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(MAGIC.len() + vertices.len() * VERTEX_BYTES);
    bytes.extend_from_slice(MAGIC);
    for vertex in vertices {
        let height_m = vertex.height_m.unwrap_or(f64::NAN);
        for number in [vertex.lon_deg, vertex.lat_deg, height_m] {
            bytes.extend_from_slice(&number.to_le_bytes());
        }
    }
    bytes
}

fn from_bytes(bytes: &[u8]) -> Option<Vec<Vertex>> {
    let body = bytes.strip_prefix(MAGIC)?;
    let (vertices, []) = body.as_chunks::<VERTEX_BYTES>() else {
        return None;
    };
    let number = |bytes: &[u8]| bytes.try_into().map(f64::from_le_bytes).ok();
    vertices
        .iter()
        .map(|vertex| {
            let height_m = number(&vertex[16..])?;
            Some(Vertex {
                lon_deg: number(&vertex[..8])?,
                lat_deg: number(&vertex[8..16])?,
                height_m: (!height_m.is_nan()).then_some(height_m),
            })
        })
        .collect()
}

impl core::ops::Deref for Vertices {
    type Target = [Vertex];

    fn deref(&self) -> &[Vertex] {
        self.as_slice()
    }
}

impl Default for Vertices {
    fn default() -> Self {
        Self::new()
    }
}

impl From<Vec<Vertex>> for Vertices {
    fn from(vertices: Vec<Vertex>) -> Self {
        Self(Inner::Here(Arc::new(List {
            vertices,
            hash: OnceLock::new(),
        })))
    }
}

impl FromIterator<Vertex> for Vertices {
    fn from_iter<T: IntoIterator<Item = Vertex>>(vertices: T) -> Self {
        Self::from(vertices.into_iter().collect::<Vec<_>>())
    }
}

impl PartialEq for Vertices {
    fn eq(&self, other: &Self) -> bool {
        self.is_same(other)
            || matches!((&self.0, &other.0), (Inner::Here(a), Inner::Here(b)) if a.vertices == b.vertices)
    }
}

impl fmt::Debug for Vertices {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Inner::Here(list) => list.vertices.fmt(f),
            Inner::Elsewhere(side_file) => side_file.fmt(f),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_of_a_side_file_read_back_and_damage_is_named() {
        let list: Vertices = (0..5)
            .map(|i| Vertex {
                lon_deg: f64::from(i),
                lat_deg: -0.1,
                height_m: (i % 2 == 0).then_some(1.5),
            })
            .collect();
        let (file, mut bytes) = (list.to_side_file(), list.to_side_bytes());
        assert_eq!(Vertices::from_side_bytes(&bytes, &file), Ok(list));
        assert_eq!(file.vertices, 5);
        assert_eq!(
            ContentHash::from_hex(&file.hash.to_string()),
            Some(file.hash)
        );
        bytes[20] ^= 1;
        let message = Vertices::from_side_bytes(&bytes, &file).unwrap_err();
        assert!(message.starts_with("expected content"), "{message}");
    }
}
