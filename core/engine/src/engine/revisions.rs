//! Revisions: the one that is shown, and the one that is being made behind it.
//!
//! Invariant: a revision is published only when everything that it would replace on the screen is
//! there, and one that is being made is finished before the next one starts.

use std::sync::Arc;

use relievo_graph::ContentId;
use relievo_planet::TileKey;

use super::Engine;
use super::asking::named;
use super::overlays::Synthesised;
use crate::compile;
use crate::frame::ClipKind;
use crate::scenarios::as_shown;
use crate::scene::Scene;
use crate::sources::News;

impl Engine {
    /// Starts making the project's current state unless a revision is being made already: that one
    /// is finished first, so a drag cannot starve the fine levels.
    pub(super) fn recompile(&mut self) {
        self.hear_of_sources();
        let drags = self.history.is_dragging();
        // However a drag ended: to the last bit as if there had been none.
        self.stale |= !drags && self.target().mixed_apart;
        if self.stale && std::mem::take(&mut self.stuck) {
            // It reads a file that is no more, so it would never be finished.
            self.making = None;
        }
        if !self.stale || self.making.is_some() {
            return;
        }
        self.stale = false;
        self.revisions += 1;
        let compared = self.difference.as_ref();
        let compared = compared.map(|(of, by)| (as_shown(&self.project, of.as_ref()), *by));
        let wish = compile::Wish {
            pinned: self.edited.pinned(&self.project, drags),
            difference: compared.as_ref().map(|(other, by)| (&**other, *by)),
            synthesised: self.synthesised == Synthesised::Coloured,
            marks: &self.marks,
        };
        let mut compiled = compile::compile(
            &as_shown(&self.project, self.project.scenario.as_ref()),
            &self.folder,
            &self.sources,
            &self.nodes,
            &wish,
        );
        self.nodes.keep(&mut compiled);
        self.messages.replace_sources(&compiled.problems);
        let mut scene = compiled.into_scene(self.revisions, Some(&self.shown));
        scene.drag = drags.then_some(self.drags);
        self.making = Some(Arc::new(scene));
        self.dirty = true;
    }

    /// Takes in what happened to files.
    pub(super) fn hear_of_sources(&mut self) {
        let news = self.sources.take_news();
        self.file_news += u64::from(news != News::None);
        match news {
            News::None => {}
            News::Opened => self.stale = true,
            News::Replaced => {
                self.stale = true;
                self.forget_failed_tiles();
                self.messages.forget_tiles();
            }
        }
    }

    /// Has tiles made again that could not be made.
    pub(super) fn forget_failed_tiles(&mut self) {
        self.tiles.forget_failures();
        for (_, stack) in self.stacks.each_mut() {
            stack.forget_failures();
        }
        self.dirty = true;
    }

    /// The revision that new tiles are made for.
    pub(super) fn target(&self) -> &Arc<Scene> {
        self.making.as_ref().unwrap_or(&self.shown)
    }

    /// Whether everything that a new revision would replace on the screen is there.
    pub(super) fn is_ready(&self, scene: &Scene) -> bool {
        self.visible(scene).all(|(kind, key, id)| {
            let stack = self.stacks.get(kind);
            !stack.shows(key) || stack.holds(key, id) || self.arrived.contains_key(&id)
        })
    }

    /// Names under a revision of all tiles that the converged picture reads.
    fn visible<'a>(
        &'a self,
        scene: &'a Scene,
    ) -> impl Iterator<Item = (ClipKind, TileKey, ContentId)> + 'a {
        self.plan
            .iter()
            .flat_map(|p| p.selected_tiles())
            .flat_map(move |(kind, key)| named(scene, kind, key))
    }

    pub(super) fn publish(&mut self) {
        if let Some(scene) = self.making.take() {
            let before = std::mem::replace(&mut self.shown, scene);
            self.forget_moment(&before);
            if !self.history.is_dragging() {
                self.before_drag = None;
            }
            self.dirty = true;
        }
    }
}
