//! Tiles: asked of the scheduler, taken back when they are finished, put into windows.

use std::sync::Arc;

use relievo_graph::ContentId;
use relievo_planet::TileKey;
use relievo_planet::clipmap::ClipKind as PlanKind;
use relievo_tiles::{Focus, TileState, Want};
use rustc_hash::FxHashSet;

use super::Engine;
use crate::frame::{ClipKind, Upload};
use crate::scene::Scene;

/// Tiles asked for beyond what is visible, for a cache of so many bytes: more than a part of it
/// would push itself out again.
pub(super) fn prefetch_for(memory: usize) -> usize {
    const MOST: usize = 384;
    const TILE_BYTES: usize = 256 * 256 * 4;
    MOST.min(memory / 8 / TILE_BYTES)
}

impl Engine {
    /// Takes finished tiles. One that failed because its file was changed under it is no failure
    /// while somebody sees to the file: what is on the screen stays until it can be made.
    pub(super) fn take_finished(&mut self) {
        for done in self.tiles.take_finished() {
            let asked = self.asked.contains(&done.id);
            if let TileState::Failed(error) = &done.state {
                if let Some(file) = self.sources.changed_file(error) {
                    if asked {
                        self.sources.distrust(file);
                        self.stuck = true;
                    }
                    continue;
                }
                self.messages.tile_failed(error);
            }
            if asked {
                // What only the revision that is being made reads waits until all of it is there.
                self.dirty |= self.making.is_none() || self.asked_for_shown.contains(&done.id);
                self.arrived.insert(done.id, done.state);
            }
        }
    }

    /// Brings windows up to date. Whether something is left that is there but more than `budget` copies.
    pub(super) fn update_windows(
        &mut self,
        budget: &mut usize,
        uploads: &mut Vec<Upload>,
        dt_s: f32,
    ) -> bool {
        let shown = Arc::clone(&self.shown);
        let (arrived, tiles, sources) = (&self.arrived, &self.tiles, &self.sources);
        let lasts = |state: &TileState| match state {
            TileState::Ready(_) => true,
            TileState::Failed(error) => sources.changed_file(error).is_none(),
        };
        let mut left = false;
        for (kind, stack) in self.stacks.each_mut() {
            if let (true, Some(root)) = (self.dirty, shown.root(kind)) {
                let kept = |id| tiles.get(id).filter(lasts);
                let find = |id| arrived.get(&id).cloned().or_else(|| kept(id));
                left |= stack.update(|key| shown.name(root, key), find, budget, uploads);
            }
            stack.settle(dt_s);
        }
        if !left && self.making.is_none() {
            self.arrived.clear();
        }
        left
    }

    /// Asks the scheduler for what is missing: for a revision that is being made what it will be
    /// published with, else all wanted tiles, then, unless it is a still, what will be visible along
    /// the camera's path. The rest of the windows is not asked for: see `docs/reports/scheduling.md`.
    pub(super) fn ask(&mut self, prefetch: bool) {
        if !std::mem::take(&mut self.dirty) {
            let arrived = |id| self.arrived.contains_key(id);
            self.pending = self.asked.iter().filter(|id| !arrived(id)).count();
            return;
        }
        let scene = Arc::clone(self.target());
        let Some(plan) = self.plan.clone() else {
            return;
        };
        let tiles = if self.making.is_some() {
            plan.selected_tiles()
        } else {
            plan.wanted_tiles()
        };
        let (mut wants, for_shown) = self.missing(&scene, tiles);
        self.asked_for_shown = for_shown;
        self.pending = wants
            .iter()
            .filter(|w| !self.arrived.contains_key(&w.id))
            .count();
        let prefetch = prefetch && self.making.is_none();
        self.asked = wants.iter().map(|w| w.id).collect();
        let asked = &self.asked;
        self.arrived.retain(|id, _| asked.contains(id));
        let mut focus = Focus::from(plan.focus);
        if prefetch {
            // Tiles along the path are waited for in the cache: no window has a place for them yet.
            let (ahead, both) = self.wants_ahead(&scene, &plan, &self.asked);
            wants.extend(ahead);
            focus = both;
        }
        wants.retain(|w| !self.arrived.contains_key(&w.id));
        self.tiles.want(wants, focus);
    }

    /// Tiles of a revision that no window has, and the names of those that the shown one reads too.
    fn missing(
        &self,
        scene: &Scene,
        tiles: Vec<(PlanKind, TileKey)>,
    ) -> (Vec<Want>, FxHashSet<ContentId>) {
        let mut wants = Vec::new();
        let mut for_shown = FxHashSet::default();
        for (kind, key) in tiles {
            for (kind, key, id) in named(scene, kind, key) {
                if self.stacks.get(kind).holds(key, id) {
                    continue;
                }
                wants.extend(scene.root(kind).map(|root| scene.want(root, key)));
                let shown = self.shown.root(kind);
                if shown.is_some_and(|root| self.shown.name(root, key) == id) {
                    for_shown.insert(id);
                }
            }
        }
        (wants, for_shown)
    }
}

/// The clipmap tiles behind a planned one, with their names.
pub(super) fn named(
    scene: &Scene,
    kind: PlanKind,
    key: TileKey,
) -> impl Iterator<Item = (ClipKind, TileKey, ContentId)> + '_ {
    let kinds: &[ClipKind] = match kind {
        PlanKind::Heights => &[ClipKind::Height],
        PlanKind::Colours => &[ClipKind::Colour, ClipKind::Normal],
    };
    kinds
        .iter()
        .filter_map(move |k| Some((*k, key, scene.name(scene.root(*k)?, key))))
}
