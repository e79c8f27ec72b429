//! Content ids: names of results, computed without making any sample.

use relievo_planet::{Grid, GridCrs, Lattice};

/// Names what a node gives on a tile: a hash over everything that can touch its samples. Equal ids
/// mean equal bytes, so undo, scenario switches and reopening hit the cache.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ContentId(pub [u8; 32]);

/// Bytes that are hashed in one go; most names take fewer.
const SHORT: usize = 256;

/// Collects what decides a result. Fields are length-prefixed, so no two sequences collide.
pub struct IdHasher {
    /// What was added last.
    buffer: [u8; SHORT],
    used: usize,
    /// What came before, once the buffer was full.
    before: Option<Box<blake3::Hasher>>,
    /// Name of the grid that all additions are about, if it was computed already.
    grid: Option<ContentId>,
}

impl Default for IdHasher {
    fn default() -> Self {
        Self {
            buffer: [0; SHORT],
            used: 0,
            before: None,
            grid: None,
        }
    }
}

impl IdHasher {
    /// A hasher for results on one grid, whose name ([`Self::grid_name`]) need not be computed anew.
    pub(crate) fn on(grid: ContentId) -> Self {
        Self {
            grid: Some(grid),
            ..Self::default()
        }
    }

    /// Adds bytes.
    pub fn bytes(&mut self, bytes: &[u8]) -> &mut Self {
        self.add(&(bytes.len() as u64).to_le_bytes()).add(bytes)
    }

    /// Adds an integer.
    pub fn int(&mut self, value: i64) -> &mut Self {
        self.add(&value.to_le_bytes())
    }

    /// Adds a float by its bits; all NaNs are the same, and so are both zeros.
    pub fn float(&mut self, value: f64) -> &mut Self {
        let canonical = if value.is_nan() {
            f64::NAN
        } else {
            value + 0.0
        };
        self.add(&canonical.to_bits().to_le_bytes())
    }

    /// Adds another result.
    pub fn id(&mut self, id: ContentId) -> &mut Self {
        self.add(&id.0)
    }

    /// Adds the grid on which a node that depends on position is asked for samples: its lattice and
    /// its rectangle.
    pub fn grid(&mut self, grid: &Grid) -> &mut Self {
        let name = self.grid.unwrap_or_else(|| Self::grid_name(grid));
        self.id(name)
    }

    /// What [`Self::grid`] adds.
    pub(crate) fn grid_name(grid: &Grid) -> ContentId {
        let mut name = Self::default();
        name.lattice(&grid.lattice);
        for corner in [grid.rect.min, grid.rect.max] {
            name.int(corner.x).int(corner.y);
        }
        name.finish()
    }

    /// Adds everything that says where a lattice's samples lie.
    pub fn lattice(&mut self, lattice: &Lattice) -> &mut Self {
        match &lattice.crs {
            GridCrs::Map => self.bytes(b"map"),
            GridCrs::Projected(crs) => self.bytes(b"projected").bytes(crs.as_bytes()),
        };
        self.float(lattice.origin.x)
            .float(lattice.origin.y)
            .float(lattice.step.x)
            .float(lattice.step.y)
            .int(lattice.columns_around.unwrap_or(-1))
    }

    /// The id of all that was added.
    pub fn finish(&self) -> ContentId {
        let last = &self.buffer[..self.used];
        let hash = match &self.before {
            None => blake3::hash(last),
            Some(before) => before.clone().update(last).finalize(),
        };
        ContentId(*hash.as_bytes())
    }

    fn add(&mut self, bytes: &[u8]) -> &mut Self {
        if bytes.len() > SHORT - self.used {
            let before = self.before.get_or_insert_default();
            before.update(&self.buffer[..self.used]);
            self.used = 0;
            if bytes.len() > SHORT {
                before.update(bytes);
                return self;
            }
        }
        self.buffer[self.used..self.used + bytes.len()].copy_from_slice(bytes);
        self.used += bytes.len();
        self
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn an_id_depends_on_bytes_not_on_how_they_were_buffered(
            parts in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..400), 0..8),
        ) {
            let mut id = IdHasher::default();
            let mut all = Vec::new();
            for part in &parts {
                id.bytes(part);
                all.extend_from_slice(&(part.len() as u64).to_le_bytes());
                all.extend_from_slice(part);
            }
            prop_assert_eq!(id.finish(), ContentId(*blake3::hash(&all).as_bytes()));
            prop_assert_eq!(id.finish(), id.finish());
        }
    }
}
