//! Which tiles each clip level holds: from finished tiles to uploads and valid rectangles.
//!
//! Invariant: where a converged picture reads (the plan's selected tiles), a level's valid rectangle
//! holds samples of one revision only, all of them uploaded. A window that moves, a tile that comes
//! late and a tile whose content changed are the same case: some part of a tile's rectangle is not
//! covered by the content with the right name yet. Between the selected tiles a rectangle may span
//! tiles that are stale: samples of an older revision that no visible fragment reads. So a revision
//! is complete as soon as its selected tiles are.

use std::collections::HashMap;
use std::sync::Arc;

use relievo_graph::ContentId;
use relievo_planet::clipmap::valid::{
    COLOUR_FILTER_MARGIN, HEIGHT_FILTER_MARGIN, ValidRect, valid_rect,
};
use relievo_planet::clipmap::{LevelPlan, TileSet, Window, choose};
use relievo_planet::{LevelKey, MapPoint, SampleRect, TILE_SAMPLES, TileKey};
use relievo_raster::{Sample, Tile};
use relievo_tiles::TileState;
use rustc_hash::FxHashMap;

use crate::frame::{ClipKind, LevelView, Upload};

/// Seconds in which newly valid detail fades in.
const FADE_S: f32 = 0.25;

/// The levels of one clipmap.
pub(crate) struct Stack {
    kind: ClipKind,
    levels: Vec<Level>,
}

struct Level {
    plan: LevelPlan,
    slots: FxHashMap<TileKey, Slot>,
    valid: ValidRect,
    /// The part of `valid` that has faded in already.
    settled: ValidRect,
    fade: f32,
    /// Whether tiles or window changed since `valid` was found.
    touched: bool,
}

const NOTHING: ValidRect = ValidRect {
    rect: SampleRect::new(glam::I64Vec2::ZERO, glam::I64Vec2::ZERO),
    whole_circle: false,
};

/// A tile in a window's storage.
struct Slot {
    id: ContentId,
    /// Whether another content should be there by now.
    stale: bool,
    /// What of the tile has been uploaded, counted from the tile's first sample.
    covered: SampleRect,
    /// Kept where the CPU asks for samples too: heights under the camera and the pointer.
    tile: Option<Arc<Tile>>,
    /// Whether it stands in for a tile that cannot be made.
    failed: bool,
}

impl Stack {
    pub(crate) fn new(kind: ClipKind) -> Self {
        Self {
            kind,
            levels: Vec::new(),
        }
    }

    /// Forgets everything uploaded: the textures are gone.
    pub(crate) fn clear(&mut self) {
        self.levels.clear();
    }

    /// Moves windows to where the plan has them; what stays inside stays resident.
    ///
    /// A level whose columns change their width (its m) shows its old window, moved along, until
    /// `ready` says that all wanted tiles of the new one can be had at once.
    pub(crate) fn follow(
        &mut self,
        plans: &[LevelPlan],
        focus: MapPoint,
        ready: impl Fn(&LevelPlan) -> bool,
    ) {
        let mut old: HashMap<u8, Level> =
            self.levels.drain(..).map(|l| (l.plan.level.n, l)).collect();
        for plan in plans {
            let kept = old
                .remove(&plan.level.n)
                .filter(|l| l.plan.window.size == plan.window.size);
            self.levels.push(match kept {
                Some(level) if level.plan.level == plan.level => level.moved(plan.clone()),
                Some(level) if !level.valid.rect.is_empty() && !ready(plan) => {
                    let moved = with_columns_of(level.plan.level, plan, focus);
                    level.moved(moved)
                }
                _ => Level::new(plan.clone()),
            });
        }
    }

    /// Whether the windows are where a plan has them.
    pub(crate) fn follows(&self, plans: &[LevelPlan]) -> bool {
        let windows = self.levels.iter().map(|l| l.plan.window);
        windows.eq(plans.iter().map(|p| p.window))
    }

    /// Whether all that the window needs of a tile is uploaded with this content.
    pub(crate) fn holds(&self, key: TileKey, id: ContentId) -> bool {
        self.levels
            .iter()
            .filter(|l| l.plan.level == key.level)
            .any(|l| {
                l.slots
                    .get(&key)
                    .is_some_and(|s| s.id == id && s.covered.contains_rect(&l.needed(key)))
            })
    }

    /// Whether something of this tile, whatever its content, is on the screen.
    pub(crate) fn shows(&self, key: TileKey) -> bool {
        self.levels
            .iter()
            .any(|l| l.plan.level == key.level && l.slots.get(&key).is_some_and(|s| !s.stale))
    }

    /// Brings windows up to date: what has another name now is stale, or dropped where it may be
    /// read; uploads what `find` gives, at
    /// most `budget` copies. Returns whether something is left that `find` had but the budget did
    /// not allow.
    pub(crate) fn update(
        &mut self,
        name: impl Fn(TileKey) -> ContentId,
        find: impl Fn(ContentId) -> Option<TileState>,
        budget: &mut usize,
        uploads: &mut Vec<Upload>,
    ) -> bool {
        let mut left = false;
        for (layer, level) in self.levels.iter_mut().enumerate() {
            left |= level.update(self.kind, layer as u32, &name, &find, budget, uploads);
        }
        left
    }

    /// Forgets what stands in for tiles that could not be made, so that they are asked for again.
    pub(crate) fn forget_failures(&mut self) {
        for level in &mut self.levels {
            let before = level.slots.len();
            level.slots.retain(|_, slot| !slot.failed);
            level.touched |= level.slots.len() != before;
        }
    }

    /// Number of tiles that the levels hold parts of.
    pub(crate) fn tiles(&self) -> usize {
        self.levels.iter().map(|l| l.slots.len()).sum()
    }

    /// Advances fades and takes up newly valid rectangles. `dt_s` is the time since the last call;
    /// infinite to fade in at once.
    pub(crate) fn settle(&mut self, dt_s: f32) {
        for level in &mut self.levels {
            level.settle(dt_s);
        }
    }

    /// What the front-end is told.
    pub(crate) fn views(&self) -> Vec<LevelView> {
        self.levels
            .iter()
            .enumerate()
            .map(|(layer, level)| LevelView {
                layer: layer as u32,
                window: level.plan.window,
                view: level.view(self.kind),
            })
            .collect()
    }

    /// Lowest and highest height of the resident tiles; `None` without any.
    pub(crate) fn height_range_m(&self) -> Option<(f32, f32)> {
        let slots = self.levels.iter().flat_map(|l| l.slots.values());
        let ranges = slots.filter_map(|s| s.tile.as_ref()?.height_range_m());
        ranges.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    /// The finest resident tile that holds a map point, with the point's position in it in samples.
    pub(crate) fn tile_at(&self, point: MapPoint) -> Option<(TileKey, &Arc<Tile>)> {
        self.levels.iter().rev().find_map(|l| {
            let sample = l.plan.level.sample_from_map(point).floor().as_i64vec2();
            let sample = sample.clamp(glam::I64Vec2::ZERO, l.plan.level.samples() - 1);
            let tile = sample / TILE_SAMPLES;
            let key = TileKey::new(l.plan.level, tile.x, tile.y)?;
            let slot = l.slots.get(&key)?;
            Some((key, slot.tile.as_ref()?))
        })
    }
}

/// The plan for the same rows in columns of another width.
fn with_columns_of(level: LevelKey, plan: &LevelPlan, focus: MapPoint) -> LevelPlan {
    let window = Window::place(level, focus, plan.window.size);
    let focus_in_sample = window.sample_of(focus);
    let columns = level.samples().x as f64 / plan.level.samples().x as f64;
    let carried = |x: f64| focus_in_sample.x + (x - plan.focus_in_sample.x) * columns;
    let to_tile = |x: f64| (carried(x) / TILE_SAMPLES as f64).floor() as i64 * TILE_SAMPLES;
    let mut wanted = plan.wanted;
    wanted.min.x = to_tile(wanted.min.x as f64);
    wanted.max.x = to_tile(wanted.max.x as f64) + TILE_SAMPLES;
    let mut centre_in_sample = plan.centre_in_sample;
    centre_in_sample.x = carried(centre_in_sample.x);
    let mut selected = TileSet::none_of(&window);
    selected.insert(&wanted);
    LevelPlan {
        level,
        window,
        selected,
        wanted,
        focus_in_sample,
        centre_in_sample,
    }
}

impl Level {
    fn new(plan: LevelPlan) -> Self {
        Self {
            plan,
            slots: FxHashMap::default(),
            valid: NOTHING,
            settled: NOTHING,
            fade: 1.0,
            touched: true,
        }
    }

    fn moved(mut self, plan: LevelPlan) -> Self {
        let before = self.plan.window;
        let window = plan.window;
        let around = plan.level.samples().x;
        self.plan = plan;
        // A step over the antimeridian renames columns by a whole turn.
        let centre = |w: &Window| i64::midpoint(w.rect.min.x, w.rect.max.x);
        let turns = (2 * (centre(&window) - centre(&before)) + around).div_euclid(2 * around);
        let rename = glam::I64Vec2::new(turns * around, 0);
        for part in [&mut self.valid, &mut self.settled] {
            if !part.whole_circle {
                part.rect = part.rect.shift(rename).intersection(&window.rect);
            }
        }
        self.touched = true;
        self.slots.retain(|key, slot| {
            let Some(rect) = window.tile_rect(*key) else {
                return false;
            };
            let inside = rect.intersection(&window.rect).shift(-rect.min);
            slot.covered = slot.covered.intersection(&inside);
            !slot.covered.is_empty()
        });
        self
    }

    /// The part of a tile that the window shows, counted from the tile's first sample.
    fn needed(&self, key: TileKey) -> SampleRect {
        let window = &self.plan.window;
        window.tile_rect(key).map_or_else(SampleRect::default, |r| {
            r.intersection(&window.rect).shift(-r.min)
        })
    }

    fn update(
        &mut self,
        kind: ClipKind,
        layer: u32,
        name: &impl Fn(TileKey) -> ContentId,
        find: &impl Fn(ContentId) -> Option<TileState>,
        budget: &mut usize,
        uploads: &mut Vec<Upload>,
    ) -> bool {
        let mut left = false;
        for (key, rect) in self.plan.window.tiles() {
            // Names cost more than all else here, and most of a window nobody looks at.
            if !rect.overlaps(&self.plan.wanted) && !self.slots.contains_key(&key) {
                continue;
            }
            let id = name(key);
            let needed = rect.intersection(&self.plan.window.rect).shift(-rect.min);
            let covered = match self.slots.get_mut(&key) {
                Some(slot) if slot.id == id => {
                    slot.stale = false;
                    slot.covered
                }
                Some(slot) => {
                    self.touched |= !slot.stale;
                    slot.stale = true;
                    SampleRect::default()
                }
                None => SampleRect::default(),
            };
            if covered.contains_rect(&needed) {
                continue;
            }
            let Some(state) = find(id) else { continue };
            if *budget == 0 {
                left = true;
                continue;
            }
            *budget -= 1;
            let (tile, failed) = match state {
                TileState::Ready(tile) => (tile, false),
                TileState::Failed(_) => (stand_in(kind), true),
            };
            for missing in needed.minus(&covered) {
                for piece in self
                    .plan
                    .window
                    .upload_pieces(key, &missing.shift(rect.min))
                {
                    uploads.push(Upload {
                        clipmap: kind,
                        layer,
                        storage: [piece.storage.x as u32, piece.storage.y as u32],
                        tile: Arc::clone(&tile),
                        source: [piece.in_tile.min.x as u32, piece.in_tile.min.y as u32],
                        size: [piece.in_tile.width() as u32, piece.in_tile.height() as u32],
                    });
                }
            }
            let tile = (kind == ClipKind::Height).then_some(tile);
            self.slots.insert(
                key,
                Slot {
                    id,
                    stale: false,
                    covered: needed,
                    tile,
                    failed,
                },
            );
            self.touched = true;
        }
        left
    }

    fn settle(&mut self, dt_s: f32) {
        if self.fade < 1.0 {
            self.fade = (self.fade + dt_s / FADE_S).min(1.0);
        }
        if self.fade >= 1.0 {
            self.settled = self.valid;
        }
        if !self.touched {
            return;
        }
        let best = self.readable();
        let grows = best.whole_circle || best.rect.contains_rect(&self.valid.rect);
        if grows && self.fade < 1.0 {
            // What is fading in goes on; the next growth waits for it, so that nothing jumps.
            return;
        }
        self.touched = false;
        if best == self.valid {
            return;
        }
        self.settled.rect = self.settled.rect.intersection(&best.rect);
        self.settled.whole_circle &= best.whole_circle;
        self.valid = best;
        self.fade = if dt_s.is_infinite() || self.settled == best {
            1.0
        } else {
            0.0
        };
    }

    /// The largest rectangle that is uploaded.
    fn readable(&self) -> ValidRect {
        let resident = |key: TileKey| {
            self.slots.get(&key).is_some_and(|s| {
                s.covered.contains_rect(&self.needed(key)) && !(s.stale && self.plan.selects(key))
            })
        };
        let mut best = valid_rect(&self.plan, resident);
        if best.whole_circle {
            // The same columns whatever the focus, so that a turn is no change.
            best.rect.min.x = 0;
            best.rect.max.x = self.plan.level.samples().x;
        }
        best
    }

    fn view(&self, kind: ClipKind) -> choose::LevelView {
        let margin = if kind == ClipKind::Height {
            HEIGHT_FILTER_MARGIN
        } else {
            COLOUR_FILTER_MARGIN
        };
        choose::LevelView::new(
            &self.plan,
            &self.valid,
            Some(&self.settled),
            self.fade,
            margin,
        )
    }
}

/// What is drawn where a tile cannot be made: level ground at the datum, in a colour that no terrain has.
fn stand_in(kind: ClipKind) -> Arc<Tile> {
    Arc::new(Tile::uniform(match kind {
        ClipKind::Height => Sample::Height(0.0),
        ClipKind::Colour => Sample::Rgba8([206, 66, 125, 255]),
        ClipKind::Normal => Sample::Normal(Default::default()),
    }))
}
