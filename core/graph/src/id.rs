//! Content ids: names of results, computed without making any sample.

/// Names what a node gives on a tile: a hash over everything that can touch its samples. Equal ids
/// mean equal bytes, so undo, scenario switches and reopening hit the cache.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ContentId(pub [u8; 32]);

/// Collects what decides a result. Fields are length-prefixed, so no two sequences collide.
#[derive(Default)]
pub struct IdHasher(blake3::Hasher);

impl IdHasher {
    /// Adds bytes.
    pub fn bytes(&mut self, bytes: &[u8]) -> &mut Self {
        self.0
            .update(&(bytes.len() as u64).to_le_bytes())
            .update(bytes);
        self
    }

    /// Adds an integer.
    pub fn int(&mut self, value: i64) -> &mut Self {
        self.0.update(&value.to_le_bytes());
        self
    }

    /// Adds a float by its bits; all NaNs are the same, and so are both zeros.
    pub fn float(&mut self, value: f64) -> &mut Self {
        let canonical = if value.is_nan() {
            f64::NAN
        } else {
            value + 0.0
        };
        self.0.update(&canonical.to_bits().to_le_bytes());
        self
    }

    /// Adds another result.
    pub fn id(&mut self, id: ContentId) -> &mut Self {
        self.0.update(&id.0);
        self
    }

    /// The id of all that was added.
    pub fn finish(&self) -> ContentId {
        ContentId(*self.0.finalize().as_bytes())
    }
}
