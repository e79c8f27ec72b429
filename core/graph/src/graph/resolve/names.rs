//! What results are called: content ids of what nodes resolve to.

use relievo_planet::SampleRect;
use relievo_raster::SampleType;

use super::{Resolver, Source};
use crate::graph::regions::Region;
use crate::graph::{NodeIndex, artefacts};
use crate::{ContentId, IdHasher, Known};

impl Resolver<'_> {
    /// Name of a tile that stores `source`, which is what a cut point of type `stored` resolved to.
    pub(in crate::graph) fn tile_id(
        &mut self,
        source: Source,
        stored: SampleType,
        at: usize,
    ) -> ContentId {
        match source {
            Source::Uniform(value) => {
                let mut id = IdHasher::default();
                add_uniform(value, i64::from(stored.tag()), &mut id);
                id.finish()
            }
            Source::Raw(_) | Source::Cut(_) => self.name(source, at),
        }
    }

    fn known_id(&self, source: Source, at: usize) -> Option<ContentId> {
        match source {
            Source::Uniform(_) => None,
            Source::Raw(node) => self.slot(node, at)?.raw_id,
            Source::Cut(node) => self.slot(node, at)?.cut_id,
        }
    }

    /// Name of samples that are not uniform.
    pub(in crate::graph) fn name(&mut self, source: Source, at: usize) -> ContentId {
        if let Some(id) = self.known_id(source, at) {
            return id;
        }
        let mut stack = vec![source];
        while let Some(&top) = stack.last() {
            if self.known_id(top, at).is_none() {
                let before = stack.len();
                self.for_each_source_here(top, at, |this, source| {
                    if !matches!(source, Source::Uniform(_)) && this.known_id(source, at).is_none()
                    {
                        stack.push(source);
                    }
                });
                if stack.len() > before {
                    continue;
                }
                match top {
                    Source::Raw(node) => {
                        self.slot_mut(node, at).raw_id = Some(self.raw_id(node, at));
                    }
                    Source::Cut(node) => {
                        self.slot_mut(node, at).cut_id = Some(self.cut_id(node, at));
                    }
                    Source::Uniform(_) => {}
                }
            }
            stack.pop();
        }
        self.known_id(source, at).expect("just named")
    }

    fn cut_id(&mut self, node: NodeIndex, at: usize) -> ContentId {
        let mut id = IdHasher::default();
        let stored = self.graph.entry(node).cut.expect("a cut point");
        let raw = self.raw(node, at).source;
        if let (true, Source::Raw(_)) = (stored.is_exact(), raw) {
            // What is kept exactly is what the node gives: a pin renames nothing that reads it.
            return self.known_id(raw, at).expect("inputs are named first");
        }
        id.bytes(b"cut").int(i64::from(stored.tag()));
        self.add(raw, at, &mut id);
        id.finish()
    }

    fn raw_id(&mut self, node: NodeIndex, at: usize) -> ContentId {
        let entry = self.graph.entry(node);
        let grid = self.grid(at);
        let name = *self.places[at]
            .grid
            .get_or_insert_with(|| IdHasher::grid_name(&grid));
        let mut id = IdHasher::on(name);
        id.bytes(entry.node.kind().as_bytes())
            .int(i64::from(entry.node.version()));
        entry.node.identify(&grid, &mut id);
        for artefact in entry.node.artefacts(&grid) {
            id.id(artefacts::name(self.graph, node, &*artefact));
        }
        id.int(entry.inputs.len() as i64);
        for (k, input) in entry.inputs.iter().enumerate() {
            if entry.node.is_pointwise() {
                let source = self.resolve(*input, at).source;
                self.add(source, at, &mut id);
            } else {
                let rect = entry.node.required(k, self.rect(at));
                self.add_surroundings(*input, &rect, &mut id);
            }
        }
        id.finish()
    }

    /// Names everything a rectangle touches, and how it is put together.
    pub(in crate::graph) fn add_surroundings(
        &mut self,
        input: NodeIndex,
        rect: &SampleRect,
        id: &mut IdHasher,
    ) {
        if let Known::Uniform(value) = self.known_over(input, rect) {
            add_uniform(value, UNSTORED, id);
            return;
        }
        let regions = self.regions(rect);
        id.int(regions.len() as i64);
        for region in regions {
            let Region {
                from,
                to,
                size,
                over_pole,
                ..
            } = region;
            for (x, y) in [from, to, size] {
                id.int((x as i64) << 32 | y as i64);
            }
            id.int(i64::from(over_pole));
            let at = self.place(region.piece);
            let source = self.resolve(input, at).source;
            self.id_if_needed(source, at);
            self.add(source, at, id);
        }
    }

    fn id_if_needed(&mut self, source: Source, at: usize) {
        if !matches!(source, Source::Uniform(_)) {
            self.name(source, at);
        }
    }

    /// Adds a value, or a name that is there already.
    fn add(&self, source: Source, at: usize, id: &mut IdHasher) {
        match source {
            Source::Uniform(value) => add_uniform(value, UNSTORED, id),
            Source::Raw(_) | Source::Cut(_) => {
                id.bytes(b"id")
                    .id(self.known_id(source, at).expect("inputs are named first"));
            }
        }
    }
}

/// In place of a sample type for values between nodes.
const UNSTORED: i64 = 0;

fn add_uniform(value: [f32; 4], tag: i64, id: &mut IdHasher) {
    id.bytes(b"uniform").int(tag);
    for v in value {
        // By its bits, not as a number: an uncut −0 is another input than 0.
        id.int(if v.is_nan() {
            i64::MIN
        } else {
            i64::from(v.to_bits())
        });
    }
}
