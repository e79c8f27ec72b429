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

/// What goes first when room is needed. Only [`Eviction::Worth`] is used by the program; the others
/// are what it is measured against.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Eviction {
    /// What is cheap to make again, far from where the camera is or will be, in tiles and levels, and
    /// was not wanted for long.
    #[default]
    Worth,
    /// What is far from the focus, in tiles of its own level: \[CH07\] 4.2.
    Distance,
    /// What came first.
    Fifo,
}

/// Where the camera looks, for what is near and far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Focus {
    /// Where the clipmaps are centred.
    pub at: MapPoint,
    /// Where they will be centred before long.
    pub ahead: MapPoint,
    /// Finest level n that is wanted now or before long.
    pub finest: u8,
}

impl From<MapPoint> for Focus {
    /// A camera that stays.
    fn from(at: MapPoint) -> Self {
        Self {
            at,
            ahead: at,
            finest: u8::MAX,
        }
    }
}

struct Entry {
    state: TileState,
    key: TileKey,
    cost: Cost,
    /// Whether the latest wants name it.
    wanted: bool,
    /// Insertions so far when it came, and when it was wanted last.
    came: u64,
    used: u64,
}

/// Tiles by content id; memory stays at or below a bound at all times.
///
/// When room is needed, what goes first is what is cheap to make again and far from where the camera
/// is or will be, counted in tiles of its own level, so that coarse levels count as near, and in levels
/// beyond the finest that is wanted, and what nobody wanted for long (\[CH07\] 4.2 asks for more than
/// the plain distance). What the
/// latest wants name goes last.
pub struct Cache {
    entries: HashMap<ContentId, Entry>,
    bound: usize,
    used: usize,
    focus: Focus,
    eviction: Eviction,
    inserted: u64,
    evicted: u64,
}

impl Cache {
    /// An empty cache of at most `bound` bytes.
    pub fn new(bound: usize) -> Self {
        Self {
            entries: HashMap::new(),
            bound,
            used: 0,
            focus: MapPoint::new(0.0, 0.0).into(),
            eviction: Eviction::default(),
            inserted: 0,
            evicted: 0,
        }
    }

    /// The same with another order of eviction.
    #[must_use]
    pub fn with_eviction(self, eviction: Eviction) -> Self {
        Self { eviction, ..self }
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
    pub fn set_wanted(&mut self, wanted: impl Fn(ContentId) -> bool, focus: Focus) {
        self.focus = focus;
        #[expect(
            clippy::iter_over_hash_type,
            reason = "sets a flag on each entry: order cannot matter"
        )]
        for (id, entry) in &mut self.entries {
            entry.wanted = wanted(*id);
            if entry.wanted {
                entry.used = self.inserted;
            }
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
        self.inserted += 1;
        self.entries.insert(
            id,
            Entry {
                state,
                key,
                cost,
                wanted,
                came: self.inserted,
                used: self.inserted,
            },
        );
    }

    /// Takes a tile out that nobody will want again.
    pub fn remove(&mut self, id: ContentId) -> Option<TileState> {
        let entry = self.entries.remove(&id)?;
        self.used -= entry.state.memory();
        Some(entry.state)
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

    /// What it would mean to lose a tile.
    fn worth(&self, entry: &Entry) -> f64 {
        match self.eviction {
            Eviction::Fifo => entry.came as f64,
            Eviction::Distance => -distance_sq(entry.key, self.focus.at),
            Eviction::Worth => {
                let near = distance_sq(entry.key, self.focus.at);
                let near = near.min(distance_sq(entry.key, self.focus.ahead));
                // Twice as far for each level that is finer than what can be seen.
                let levels = entry.key.level.n.saturating_sub(self.focus.finest);
                let far = (1.0 + near.min(FAR_SQ)) * f64::from(1_u32 << (2 * levels.min(15)));
                // Beyond the surroundings no place is likelier than another: what was seen last counts.
                let age = 1.0 + (self.inserted - entry.used) as f64 / HALF_LIFE;
                entry.cost.own.as_secs_f64() / (far * age)
            }
        }
    }

    /// Removes tiles until `memory` more bytes fit, and an eighth of the bound beyond that, so that
    /// the sort is paid once for many insertions.
    fn make_room(&mut self, memory: usize) {
        let target = self.bound.saturating_sub(memory + self.bound / 8);
        let mut order: Vec<_> = self
            .entries
            .iter()
            .map(|(id, e)| (e.wanted, self.worth(e), *id))
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

/// Squared distance in tiles from which on everything is equally far.
const FAR_SQ: f64 = 64.0;

/// Insertions after which a tile that nobody wanted since is worth half.
const HALF_LIFE: f64 = 256.0;

/// Squared distance of a tile's centre from a point in tiles of its own level.
fn distance_sq(key: TileKey, point: MapPoint) -> f64 {
    let level = key.level;
    let centre = key.rect().min.as_dvec2() + 128.0;
    let mut offset = (level.sample_from_map(point) - centre).abs() / 256.0;
    offset.x = offset.x.min(level.tiles().x as f64 - offset.x);
    offset.length_squared()
}

#[cfg(test)]
mod tests {
    use relievo_planet::LevelKey;
    use relievo_raster::{Block, Sample, SampleType};

    use std::collections::BTreeMap;

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
        cache.set_wanted(
            |_| false,
            MapPoint::new(0.0, core::f64::consts::FRAC_PI_2).into(),
        );
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

    #[test]
    fn what_lies_ahead_stays_and_what_is_finer_than_the_view_goes() {
        let mut cache = Cache::new(4 * 263_000);
        let here = MapPoint::new(0.0, core::f64::consts::FRAC_PI_2);
        let mut focus = Focus::from(here);
        focus.ahead = MapPoint::new(-1.0, here.colat_rad);
        focus.finest = 5;
        let ms = Duration::from_millis(1);
        cache.set_wanted(|_| false, focus);
        let ahead = key(22);
        assert!(distance_sq(ahead, focus.ahead) < 1.0);
        let fine = TileKey::new(LevelKey::new(10, 9), 512, 256).unwrap();
        assert!(distance_sq(fine, here) < 1.0);
        cache.insert(id(1), ahead, tile(), ms.into(), false);
        cache.insert(id(2), fine, tile(), ms.into(), false);
        cache.insert(id(3), key(42), tile(), ms.into(), false); // as far behind as the first is ahead
        cache.insert(id(4), key(31), tile(), ms.into(), false);
        cache.insert(id(5), key(32), tile(), ms.into(), false);
        assert!(cache.contains(id(1)) && cache.contains(id(4)) && cache.contains(id(5)));
        assert!(!cache.contains(id(2)) || !cache.contains(id(3)));
    }

    #[test]
    fn the_bound_holds_under_ten_thousand_jumps_and_slider_moves() {
        for eviction in [Eviction::Worth, Eviction::Distance, Eviction::Fifo] {
            let bound = 3_000_000;
            let mut cache = Cache::new(bound).with_eviction(eviction);
            let (full, uniform) = (
                tile(),
                TileState::Ready(Arc::new(Tile::uniform(Sample::Height(1.0)))),
            );
            let mut random = 1_u64;
            let mut next = |below: u64| {
                random = random
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1);
                (random >> 33) % below
            };
            for jump in 0..10_000_u64 {
                let at = MapPoint::new(next(628) as f64 / 100.0, next(314) as f64 / 100.0);
                let mut wanted = BTreeMap::new();
                for _ in 0..next(6) {
                    // The slider's value is part of the name, the place of the key.
                    let level = LevelKey::new(next(12) as u8, next(12) as u8);
                    let tiles = level.tiles();
                    let (x, y) = (next(tiles.x as u64) as i64, next(tiles.y as u64) as i64);
                    let mut name = [0; 32];
                    name[..8].copy_from_slice(&next(1 << 30).to_le_bytes());
                    name[8..16].copy_from_slice(&(jump / 7).to_le_bytes());
                    wanted.insert(ContentId(name), TileKey::new(level, x, y).unwrap());
                }
                cache.set_wanted(|id| wanted.contains_key(&id), at.into());
                for (id, key) in &wanted {
                    let state = if next(3) == 0 { &uniform } else { &full };
                    let cost = Duration::from_micros(next(20_000));
                    cache.insert(*id, *key, state.clone(), cost.into(), next(2) == 0);
                    assert!(cache.used() <= bound);
                }
                let sum: usize = cache.entries.values().map(|e| e.state.memory()).sum();
                assert_eq!(sum, cache.used());
            }
            assert!(cache.evicted() > 1000);
        }
    }
}
