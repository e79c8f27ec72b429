//! Moments of a drag: made, shown, forgotten.

use std::collections::HashSet;

use relievo_graph::{ContentId, NodeIndex};
use relievo_planet::TileKey;

use super::Engine;
use super::asking::named;
use crate::scene::Scene;

impl Engine {
    /// Forgets tiles of a moment of a drag once it is replaced: to undo leads back to before all of the
    /// drag, so nobody comes back to them, and they would push out what is of use.
    pub(super) fn forget_moment(&self, before: &Scene) {
        let goes_on = before.drag.is_some() && before.drag == self.shown.drag;
        let Some(plan) = self.plan.as_ref().filter(|_| goes_on || before.mixed_apart) else {
            return;
        };
        let of = |scene: &Scene, kind, key| Some(scene.name(scene.root(kind)?, key));
        let mut passed: HashSet<ContentId> = HashSet::new();
        let mut roots: Vec<(NodeIndex, TileKey)> = Vec::new();
        for (kind, key) in plan.wanted_tiles() {
            for (kind, key, id) in named(before, kind, key) {
                let mut others = [Some(&self.shown), self.before_drag.as_ref()]
                    .into_iter()
                    .flatten();
                if others.all(|scene| of(scene, kind, key) != Some(id)) {
                    passed.insert(id);
                    roots.extend(before.root(kind).map(|root| (root, key)));
                }
            }
        }
        self.forget_what_they_read(before, roots, &mut passed);
        self.tiles.forget(passed);
    }

    /// Adds what tiles read that changes from moment to moment as they do: mostly nothing.
    fn forget_what_they_read(
        &self,
        before: &Scene,
        mut tiles: Vec<(NodeIndex, TileKey)>,
        passed: &mut HashSet<ContentId>,
    ) {
        let (old, new) = (&before.graph, &self.shown.graph);
        let lasting = old.shared_with(new);
        let roots = [
            Some(before.roots.height),
            before.roots.colour,
            before.roots.normal,
        ];
        let passing: HashSet<NodeIndex> = old
            .cuts()
            .filter(|cut| !lasting.contains(cut) && !roots.contains(&Some(*cut)))
            .collect();
        if passing.is_empty() {
            return;
        }
        let stored: HashSet<NodeIndex> = new.cuts().collect();
        while let Some((node, key)) = tiles.pop() {
            for (cut, key) in old.dependencies(node, key) {
                if !passing.contains(&cut) {
                    continue;
                }
                let id = old.content_id(cut, key);
                let stays = stored.contains(&cut) && new.content_id(cut, key) == id;
                if !stays && passed.insert(id) {
                    tiles.push((cut, key));
                }
            }
        }
    }
}
