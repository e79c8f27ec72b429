//! Patches of the evaluated ground, made when a ray first needs them and kept within a stated memory,
//! for other pictures of the same ground too.
//!
//! Invariant: a patch is a pure function of its key, so pictures do not depend on what was forgotten.

use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use parking_lot::Mutex;
use relievo_graph::RenderError;
use relievo_planet::MapPoint;
use relievo_raster::colour::linear_from_srgb;
use relievo_raster::{Bands, Block, Cancel, normal};

use super::field::{CELLS, Field, PatchKey, Spot};
use super::light::BARE_GROUND;

/// Samples along a side of a patch.
const SIDE: usize = CELLS as usize + 1;

/// Steps of a pyramid of maxima: blocks of 1 to [`CELLS`] cells.
pub(super) const STEPS: usize = CELLS.ilog2() as usize + 1;

/// Heights of a patch and the pyramid of their maxima, metres without exaggeration; and the planes and
/// cones on which the sides of its cells lie.
#[derive(Debug)]
pub(super) struct Heights {
    samples: Vec<f32>,
    /// Sine and cosine of the longitude of each column of samples.
    meridians: Vec<[f64; 2]>,
    /// Cosine of the colatitude of each row of samples.
    cones: Vec<f64>,
    /// For each step k: the greatest height over blocks of 2^k cells, corners included.
    maxima: [Vec<f32>; STEPS],
}

/// The ground's look in a patch: linear light and world-space normals.
#[derive(Debug)]
pub(super) struct Look {
    colours: Vec<[f32; 3]>,
    /// `None` when nothing is lit.
    normals: Option<Vec<[f32; 3]>>,
}

/// Bilinear weights of the four samples around a spot, north west first, and the first one's index.
fn corners(spot: &Spot) -> (usize, [f64; 4]) {
    let last = (CELLS - 1) as f64;
    let (x, y) = (
        spot.u.floor().clamp(0.0, last),
        spot.v.floor().clamp(0.0, last),
    );
    let (fx, fy) = (spot.u - x, spot.v - y);
    let weights = [
        (1.0 - fx) * (1.0 - fy),
        fx * (1.0 - fy),
        (1.0 - fx) * fy,
        fx * fy,
    ];
    (y as usize * SIDE + x as usize, weights)
}

impl Heights {
    fn new(key: &PatchKey, samples: Vec<f32>) -> Self {
        let cells = CELLS as usize;
        let cell = |i: usize| {
            let (x, y) = (i % cells, i / cells);
            let at = y * SIDE + x;
            let north = samples[at].max(samples[at + 1]);
            north.max(samples[at + SIDE].max(samples[at + SIDE + 1]))
        };
        let mut maxima: [Vec<f32>; STEPS] = Default::default();
        maxima[0] = (0..cells * cells).map(cell).collect();
        for k in 1..STEPS {
            let side = cells >> k;
            let finer = &maxima[k - 1];
            let of = |i: usize| {
                let at = 2 * (i / side) * (2 * side) + 2 * (i % side);
                let north = finer[at].max(finer[at + 1]);
                north.max(finer[at + 2 * side].max(finer[at + 2 * side + 1]))
            };
            let coarser = (0..side * side).map(of).collect();
            maxima[k] = coarser;
        }
        let meridian = |x: usize| {
            let (sin, cos) = libm::sincos(key.map_point(x as f64, 0.0).lon_rad);
            [sin, cos]
        };
        Self {
            samples,
            meridians: (0..SIDE).map(meridian).collect(),
            cones: (0..SIDE)
                .map(|y| libm::cos(key.map_point(0.0, y as f64).colat_rad))
                .collect(),
            maxima,
        }
    }

    /// The sides of the block of 2^k cells that holds cell (x, y): sine and cosine of the longitudes of
    /// the western and the eastern one, cosines of the colatitudes of the northern and the southern one.
    pub(super) fn sides(&self, k: usize, x: usize, y: usize) -> ([[f64; 2]; 2], [f64; 2]) {
        let ends = |cell: usize| [(cell >> k) << k, ((cell >> k) + 1) << k];
        (
            ends(x).map(|column| self.meridians[column]),
            ends(y).map(|row| self.cones[row]),
        )
    }

    /// Height at a spot of the patch, bilinear between sample centres, metres.
    pub(super) fn at(&self, spot: &Spot) -> f64 {
        let (at, [nw, ne, sw, se]) = corners(spot);
        let h = |i: usize| f64::from(self.samples[i]);
        nw * h(at) + ne * h(at + 1) + sw * h(at + SIDE) + se * h(at + SIDE + 1)
    }

    /// The greatest height over the block of 2^k cells that holds cell (x, y), metres.
    pub(super) fn maximum(&self, k: usize, x: usize, y: usize) -> f64 {
        let side = CELLS as usize >> k;
        f64::from(self.maxima[k][(y >> k) * side + (x >> k)])
    }

    /// The greatest height, metres.
    pub(super) fn highest(&self) -> f64 {
        f64::from(self.maxima[STEPS - 1][0])
    }

    /// The least height, metres.
    pub(super) fn lowest(&self) -> f64 {
        f64::from(self.samples.iter().copied().fold(f32::INFINITY, f32::min))
    }
}

impl Look {
    fn new(key: &PatchKey, colours: Option<&Block>, normals: Option<&Block>) -> Self {
        let count = SIDE * SIDE;
        let bare = BARE_GROUND.as_vec3().to_array();
        let colours = colours.filter(|b| b.bands() == Bands::Colour);
        let colours = colours.map_or_else(
            || vec![bare; count],
            |block| {
                let ground = |i: usize| {
                    let alpha = block.plane(3)[i].clamp(0.0, 1.0);
                    let mixed = |band: usize| {
                        let light = linear_from_srgb(block.plane(band)[i]);
                        bare[band] + (light - bare[band]) * alpha
                    };
                    [mixed(0), mixed(1), mixed(2)]
                };
                (0..count).map(ground).collect()
            },
        );
        let normals = normals.map(|block| {
            let world = |i: usize| {
                let (x, y) = ((i % SIDE) as f64, (i / SIDE) as f64);
                let local = Local::at(key.map_point(x, y).normalised());
                let unit = normal::unit([block.plane(0)[i], block.plane(1)[i]]);
                let normal = local.east * unit.x + local.north * unit.y + local.up * unit.z;
                normal.as_vec3().to_array()
            };
            (0..count).map(world).collect()
        });
        Self { colours, normals }
    }

    /// Linear light of the unlit ground at a spot.
    pub(super) fn colour(&self, spot: &Spot) -> DVec3 {
        blend(&self.colours, spot)
    }

    /// Normal without exaggeration at a spot, not of unit length; `None` when nothing is lit.
    pub(super) fn normal(&self, spot: &Spot) -> Option<DVec3> {
        self.normals.as_ref().map(|normals| blend(normals, spot))
    }
}

fn blend(samples: &[[f32; 3]], spot: &Spot) -> DVec3 {
    let (at, [nw, ne, sw, se]) = corners(spot);
    let v = |i: usize| DVec3::from(samples[i].map(f64::from));
    v(at) * nw + v(at + 1) * ne + v(at + SIDE) * sw + v(at + SIDE + 1) * se
}

/// East, north and up at a place of the map.
struct Local {
    east: DVec3,
    north: DVec3,
    up: DVec3,
}

impl Local {
    fn at(point: MapPoint) -> Self {
        let (sin_lon, cos_lon) = libm::sincos(point.lon_rad);
        let up = point.to_unit();
        let east = DVec3::new(-sin_lon, cos_lon, 0.0);
        Self {
            east,
            north: up.cross(east),
            up,
        }
    }
}

/// What is kept of one kind of patches.
struct Store<T> {
    kept: HashMap<PatchKey, (u64, Arc<T>)>,
    /// How many may be kept.
    most: usize,
    /// Counts uses.
    clock: u64,
}

impl<T> Default for Store<T> {
    fn default() -> Self {
        Self {
            kept: HashMap::new(),
            most: 4,
            clock: 0,
        }
    }
}

impl<T> Store<T> {
    fn get(&mut self, key: &PatchKey) -> Option<Arc<T>> {
        self.clock += 1;
        let (used, patch) = self.kept.get_mut(key)?;
        *used = self.clock;
        Some(Arc::clone(patch))
    }

    /// Keeps a patch; when there are too many, the half that was used longest ago is forgotten.
    fn put(&mut self, key: PatchKey, patch: Arc<T>) {
        if self.kept.len() >= self.most {
            let mut uses: Vec<u64> = self.kept.values().map(|(used, _)| *used).collect();
            let middle = uses.len() / 2;
            let (_, limit, _) = uses.select_nth_unstable(middle);
            let limit = *limit;
            self.kept.retain(|_, (used, _)| *used >= limit);
        }
        self.kept.insert(key, (self.clock, patch));
    }
}

/// What pictures of one ground keep of it.
#[derive(Default)]
pub(super) struct Kept {
    heights: Mutex<Store<Heights>>,
    looks: Mutex<Store<Look>>,
}

/// The patches of one picture.
pub(super) struct Patches<'a, F> {
    field: &'a F,
    kept: &'a Kept,
    cancel: &'a Cancel,
    /// Greatest height of any patch that was read, as the bits of an f64 that is not negative.
    highest: AtomicU64,
}

impl<'a, F: Field> Patches<'a, F> {
    /// Those of a field, of which about `memory` bytes are kept.
    pub(super) fn new(field: &'a F, kept: &'a Kept, memory: usize, cancel: &'a Cancel) -> Self {
        let (height_bytes, look_bytes) = (SIDE * SIDE * 4 * 7 / 3, SIDE * SIDE * 24);
        kept.heights.lock().most = (memory / 2 / height_bytes).max(4);
        kept.looks.lock().most = (memory / 2 / look_bytes).max(4);
        Self {
            field,
            kept,
            cancel,
            highest: AtomicU64::new(0),
        }
    }

    /// Greatest height that was met, metres without exaggeration, at least 0.
    pub(super) fn highest_m(&self) -> f64 {
        f64::from_bits(self.highest.load(Ordering::Relaxed))
    }

    /// Heights of a patch.
    pub(super) fn heights(&self, key: PatchKey) -> Result<Arc<Heights>, RenderError> {
        let patch = kept_or_made(&self.kept.heights, key, self.cancel, || {
            let samples = self.field.heights(&key.grid(), self.cancel)?;
            Ok(Heights::new(&key, samples))
        })?;
        // The bits of positive numbers are in their order.
        let highest = patch.highest().max(0.0).to_bits();
        self.highest.fetch_max(highest, Ordering::Relaxed);
        Ok(patch)
    }

    fn look(&self, key: PatchKey) -> Result<Arc<Look>, RenderError> {
        kept_or_made(&self.kept.looks, key, self.cancel, || {
            let grid = key.grid();
            let colours = self.field.colours(&grid, self.cancel)?;
            let normals = self.field.normals(&grid, self.cancel)?;
            Ok(Look::new(&key, colours.as_ref(), normals.as_ref()))
        })
    }
}

fn kept_or_made<T>(
    store: &Mutex<Store<T>>,
    key: PatchKey,
    cancel: &Cancel,
    make: impl FnOnce() -> Result<T, RenderError>,
) -> Result<Arc<T>, RenderError> {
    if let Some(kept) = store.lock().get(&key) {
        return Ok(kept);
    }
    if cancel.is_cancelled() {
        return Err(RenderError::Cancelled);
    }
    let made = Arc::new(make()?);
    store.lock().put(key, Arc::clone(&made));
    Ok(made)
}

/// Slots of a reader, per kind: for 8 × 8 neighbours in each of 4 levels.
const RECENT: usize = 256;

/// One thread's way to patches: those it used last without asking for a lock.
pub(super) struct Reader<'a, F> {
    patches: &'a Patches<'a, F>,
    heights: Vec<Option<(PatchKey, Arc<Heights>)>>,
    looks: Vec<Option<(PatchKey, Arc<Look>)>>,
}

impl<'a, F: Field> Reader<'a, F> {
    pub(super) fn new(patches: &'a Patches<'a, F>) -> Self {
        Self {
            patches,
            heights: vec![None; RECENT],
            looks: vec![None; RECENT],
        }
    }

    /// Heights of a patch.
    pub(super) fn heights(&mut self, key: PatchKey) -> Result<&Heights, RenderError> {
        let slot = &mut self.heights[slot_of(&key)];
        if slot.as_ref().is_none_or(|(held, _)| *held != key) {
            *slot = Some((key, self.patches.heights(key)?));
        }
        let (_, patch) = slot.as_ref().expect("filled just before");
        Ok(patch)
    }

    /// Look of a patch.
    pub(super) fn look(&mut self, key: PatchKey) -> Result<&Look, RenderError> {
        let slot = &mut self.looks[slot_of(&key)];
        if slot.as_ref().is_none_or(|(held, _)| *held != key) {
            *slot = Some((key, self.patches.look(key)?));
        }
        let (_, patch) = slot.as_ref().expect("filled just before");
        Ok(patch)
    }
}

/// Neighbours in columns, rows and levels get different slots.
fn slot_of(key: &PatchKey) -> usize {
    let low = |i: i64, bits: u32| (i & ((1 << bits) - 1)) as usize;
    low(key.column, 3) | low(key.row, 3) << 3 | low(i64::from(key.level.n), 2) << 6
}
