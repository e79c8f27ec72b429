//! The tile cache: one map by content id, bounded by bytes.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Duration;

use relievo_graph::{ContentId, RenderError};
use relievo_planet::{MapPoint, TileKey};
use relievo_raster::Tile;

/// What became of a tile. Failure is a state: kept, so that it is drawn and reported once instead
/// of being tried again each frame; a changed cause has another content id.
#[derive(Clone, Debug)]
pub enum TileState {
    /// Made.
    Ready(Arc<Tile>),
    /// Cannot be made.
    Failed(Arc<RenderError>),
}

impl TileState {
    fn memory(&self) -> usize {
        const OVERHEAD: usize = 256;
        OVERHEAD
            + match self {
                Self::Ready(tile) => tile.memory(),
                Self::Failed(_) => 0,
            }
    }
}

/// Time that a tile took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    /// To make it from what it reads, or to read it from disk: what it costs to lose it.
    pub own: Duration,
    /// To make it with everything that it reads.
    pub whole: Duration,
}

impl From<Duration> for Cost {
    /// Of a tile that reads nothing.
    fn from(own: Duration) -> Self {
        Self { own, whole: own }
    }
}

struct Entry {
    state: TileState,
    key: TileKey,
    cost: Cost,
    /// Whether the latest wants name it.
    wanted: bool,
}

/// Tiles by content id; memory stays at or below a bound at all times.
///
/// When room is needed, what goes first is what is cheap to make again and far from the focus,
/// counted in tiles of its own level, so that coarse levels count as near (\[CH07\] 4.2 asks for
/// more than the plain distance). What the latest wants name goes last.
pub struct Cache {
    entries: HashMap<ContentId, Entry>,
    bound: usize,
    used: usize,
    focus: MapPoint,
    evicted: u64,
}

impl Cache {
    /// An empty cache of at most `bound` bytes.
    pub fn new(bound: usize) -> Self {
        Self {
            entries: HashMap::new(),
            bound,
            used: 0,
            focus: MapPoint::new(0.0, 0.0),
            evicted: 0,
        }
    }

    /// The state of a tile, if it is kept.
    pub fn get(&self, id: ContentId) -> Option<TileState> {
        self.entries.get(&id).map(|e| e.state.clone())
    }

    /// The state of a tile, if it is kept, and what it cost with everything that it reads.
    pub fn get_with_cost(&self, id: ContentId) -> Option<(TileState, Duration)> {
        let entry = self.entries.get(&id)?;
        Some((entry.state.clone(), entry.cost.whole))
    }

    /// Whether a tile is kept.
    pub fn contains(&self, id: ContentId) -> bool {
        self.entries.contains_key(&id)
    }

    /// Bytes kept.
    pub fn used(&self) -> usize {
        self.used
    }

    /// Tiles removed to make room since the start.
    pub fn evicted(&self) -> u64 {
        self.evicted
    }

    /// Names what is wanted from now on and where the focus is.
    pub fn set_wanted(&mut self, wanted: impl Fn(ContentId) -> bool, focus: MapPoint) {
        self.focus = focus;
        #[expect(
            clippy::iter_over_hash_type,
            reason = "sets a flag on each entry: order cannot matter"
        )]
        for (id, entry) in &mut self.entries {
            entry.wanted = wanted(*id);
        }
    }

    /// Keeps a tile, making room as needed. A tile larger than the bound is not kept.
    pub fn insert(
        &mut self,
        id: ContentId,
        key: TileKey,
        state: TileState,
        cost: Cost,
        wanted: bool,
    ) {
        let memory = state.memory();
        if memory > self.bound || self.contains(id) {
            return;
        }
        if self.used + memory > self.bound {
            self.make_room(memory);
        }
        self.used += memory;
        self.entries.insert(
            id,
            Entry {
                state,
                key,
                cost,
                wanted,
            },
        );
    }

    /// Forgets tiles that could not be made, so that they are tried again (a file came back).
    pub fn forget_failures(&mut self) {
        let used = &mut self.used;
        self.entries.retain(|_, e| {
            let keep = matches!(e.state, TileState::Ready(_));
            if !keep {
                *used -= e.state.memory();
            }
            keep
        });
    }

    /// Removes tiles until `memory` more bytes fit, and an eighth of the bound beyond that, so that
    /// the sort is paid once for many insertions.
    fn make_room(&mut self, memory: usize) {
        let target = self.bound.saturating_sub(memory + self.bound / 8);
        let mut order: Vec<_> = self
            .entries
            .iter()
            .map(|(id, e)| (e.wanted, worth(e, self.focus), *id))
            .collect();
        order.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
        for (wanted, _, id) in order {
            let enough = if wanted { self.bound - memory } else { target };
            if self.used <= enough {
                break;
            }
            if let Some(entry) = self.entries.remove(&id) {
                self.used -= entry.state.memory();
                self.evicted += 1;
            }
        }
    }
}

/// Seconds to remake over the squared distance to the focus in tiles of the entry's own level.
fn worth(entry: &Entry, focus: MapPoint) -> f64 {
    let level = entry.key.level;
    let centre = entry.key.rect().min.as_dvec2() + 128.0;
    let mut offset = (level.sample_from_map(focus) - centre).abs() / 256.0;
    offset.x = offset.x.min(level.tiles().x as f64 - offset.x);
    entry.cost.own.as_secs_f64() / (1.0 + offset.length_squared())
}

#[cfg(test)]
mod tests {
    use relievo_planet::LevelKey;
    use relievo_raster::{Block, Sample, SampleType};

    use super::*;

    fn id(n: u8) -> ContentId {
        ContentId([n; 32])
    }

    fn tile() -> TileState {
        let mut block = Block::new(relievo_raster::Bands::Height, 256, 256);
        block.samples_mut()[0] = 1.0;
        TileState::Ready(Arc::new(Tile::from_block(&block, SampleType::Height)))
    }

    fn key(column: i64) -> TileKey {
        TileKey::new(LevelKey::new(6, 5), column, 16).unwrap()
    }

    #[test]
    fn the_bound_is_kept_whatever_is_inserted() {
        let mut cache = Cache::new(1_000_000);
        for n in 0..50 {
            cache.insert(
                id(n),
                key(i64::from(n)),
                tile(),
                Duration::from_millis(1).into(),
                n % 2 == 0,
            );
            assert!(cache.used() <= 1_000_000);
        }
        assert!(cache.evicted() > 40);
    }

    #[test]
    fn what_is_cheap_and_far_goes_before_what_is_dear_or_near_or_wanted() {
        let mut cache = Cache::new(4 * 263_000);
        cache.set_wanted(|_| false, MapPoint::new(0.0, core::f64::consts::FRAC_PI_2));
        cache.insert(
            id(1),
            key(32),
            tile(),
            Duration::from_millis(1).into(),
            false,
        ); // near
        cache.insert(
            id(2),
            key(0),
            tile(),
            Duration::from_millis(1).into(),
            false,
        ); // far
        cache.insert(
            id(3),
            key(1),
            tile(),
            Duration::from_secs(100).into(),
            false,
        ); // far but dear
        cache.insert(id(4), key(2), tile(), Duration::from_millis(1).into(), true); // far but wanted
        cache.insert(
            id(5),
            key(32),
            tile(),
            Duration::from_millis(1).into(),
            false,
        );
        assert!(!cache.contains(id(2)));
        assert!(cache.contains(id(3)) && cache.contains(id(4)) && cache.contains(id(5)));
    }

    #[test]
    fn a_failure_is_kept_until_it_is_forgotten() {
        let mut cache = Cache::new(1000);
        cache.insert(
            id(1),
            key(0),
            TileState::Failed(Arc::new(RenderError::Cancelled)),
            Cost::default(),
            true,
        );
        cache.insert(
            id(2),
            key(1),
            TileState::Ready(Arc::new(Tile::uniform(Sample::Height(1.0)))),
            Cost::default(),
            true,
        );
        cache.forget_failures();
        assert!(!cache.contains(id(1)) && cache.contains(id(2)));
    }
}
