//! Artefacts: named like samples, made once, kept for all graphs that share a store. So is what cut points
//! give on the grids that artefacts read: what another artefact reads again, after an edit above it, is there.

use std::collections::HashMap;
use std::sync::Arc;

use parking_lot::Mutex;
use relievo_planet::{Grid, Lattice};
use relievo_raster::{Block, Cancel};

use super::resolve::Resolver;
use super::run::{Maker, Reader};
use super::{Graph, NodeIndex};
use crate::node::{Artefact, Made};
use crate::{ContentId, IdHasher, RenderError};

/// Artefacts kept by their names, least recently used ones dropped beyond a number of bytes.
pub struct Artefacts {
    made: Store,
    read: Store,
}

struct Store {
    kept: Mutex<Kept>,
    most_bytes: usize,
}

#[derive(Default)]
struct Kept {
    slots: HashMap<ContentId, Slot>,
    bytes: usize,
    clock: u64,
    made: u64,
}

struct Slot {
    /// Locked while it is made, so that whoever else needs it waits.
    made: Arc<Mutex<Option<Made>>>,
    bytes: usize,
    used: u64,
}

/// Bytes of artefacts that are kept unless stated otherwise.
const MOST_BYTES: usize = 256 << 20;

/// Bytes of what they read that are kept: a view of seams reads some 30 MB.
const MOST_READ_BYTES: usize = 96 << 20;

impl Default for Artefacts {
    fn default() -> Self {
        Self::with_room(MOST_BYTES)
    }
}

impl Artefacts {
    /// A store that keeps about `most_bytes`; what is in use stays as long as it is.
    pub fn with_room(most_bytes: usize) -> Self {
        Self {
            made: Store::new(most_bytes),
            read: Store::new(MOST_READ_BYTES),
        }
    }

    /// How many were made so far.
    pub fn made(&self) -> u64 {
        self.made.kept.lock().made
    }

    /// How many are kept.
    pub fn len(&self) -> usize {
        self.made.kept.lock().slots.len()
    }

    /// Whether none is kept.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// How often samples were evaluated for artefacts to read.
    pub fn evaluated(&self) -> u64 {
        self.read.kept.lock().made
    }

    /// What a cut point gives on a grid, kept under its name.
    pub(super) fn samples(
        &self,
        name: ContentId,
        bytes: usize,
        make: impl FnOnce() -> Result<Block, RenderError>,
    ) -> Result<Arc<Block>, RenderError> {
        let made = self.read.get(name, bytes, || Ok(Arc::new(make()?)))?;
        Ok(made.downcast().expect("samples are kept as blocks"))
    }
}

impl Store {
    fn new(most_bytes: usize) -> Self {
        Self {
            kept: Mutex::default(),
            most_bytes,
        }
    }

    fn get(
        &self,
        id: ContentId,
        bytes: usize,
        make: impl FnOnce() -> Result<Made, RenderError>,
    ) -> Result<Made, RenderError> {
        let slot = {
            let mut kept = self.kept.lock();
            kept.clock += 1;
            let now = kept.clock;
            if !kept.slots.contains_key(&id) {
                kept.bytes += bytes;
            }
            let slot = kept.slots.entry(id).or_insert_with(|| Slot {
                made: Arc::default(),
                bytes,
                used: now,
            });
            slot.used = now;
            let slot = Arc::clone(&slot.made);
            kept.shrink(self.most_bytes, id);
            slot
        };
        let mut made = slot.lock();
        if let Some(made) = &*made {
            return Ok(Arc::clone(made));
        }
        let new = make()?;
        *made = Some(Arc::clone(&new));
        self.kept.lock().made += 1;
        Ok(new)
    }
}

impl Kept {
    /// Drops what was not used for longest, but never `wanted`.
    fn shrink(&mut self, most_bytes: usize, wanted: ContentId) {
        while self.bytes > most_bytes {
            // Ties cannot be: the clock ticks at every use.
            let others = self.slots.iter().filter(|(id, _)| **id != wanted);
            let Some(oldest) = others.min_by_key(|(_, s)| s.used).map(|(id, _)| *id) else {
                return;
            };
            if let Some(slot) = self.slots.remove(&oldest) {
                self.bytes -= slot.bytes;
            }
        }
    }
}

/// Name of an artefact of a node: its parameters and the samples that it reads.
pub(super) fn name(graph: &Graph, node: NodeIndex, artefact: &dyn Artefact) -> ContentId {
    let mut parameters = IdHasher::default();
    artefact.identify(&mut parameters);
    let key = (node, parameters.finish());
    if let Some(name) = graph.artefact_names.lock().get(&key) {
        return *name;
    }
    let mut id = IdHasher::default();
    id.bytes(b"artefact").id(key.1);
    // Mostly all of one lattice.
    let mut resolver: Option<(Arc<Lattice>, Resolver)> = None;
    for (input, grid) in artefact.reads() {
        id.int(input as i64).grid(&grid);
        let input = graph.entry(node).inputs[input];
        let same = |(lattice, _): &(Arc<Lattice>, Resolver)| Arc::ptr_eq(lattice, &grid.lattice);
        let (_, resolver) = match &mut resolver {
            Some(known) if same(known) => known,
            other => other.insert((
                Arc::clone(&grid.lattice),
                Resolver::new(graph, Arc::clone(&grid.lattice), None),
            )),
        };
        resolver.add_surroundings(input, &grid.rect, &mut id);
    }
    let name = id.finish();
    graph.artefact_names.lock().insert(key, name);
    name
}

/// All artefacts that a node needs on a grid.
pub(super) fn all(
    graph: &Graph,
    node: NodeIndex,
    grid: &Grid,
    cancel: &Cancel,
) -> Result<Vec<Made>, RenderError> {
    let wanted = graph.entry(node).node.artefacts(grid);
    let mut made = Vec::with_capacity(wanted.len());
    for artefact in wanted {
        let id = name(graph, node, &*artefact);
        made.push(graph.artefacts.made.get(id, artefact.bytes(), || {
            let mut blocks = Vec::new();
            for (input, grid) in artefact.reads() {
                if cancel.is_cancelled() {
                    return Err(RenderError::Cancelled);
                }
                let input = graph.entry(node).inputs[input];
                let resolver = Resolver::new(graph, Arc::clone(&grid.lattice), None);
                let mut maker = Maker::new(resolver, Reader::Keep, cancel);
                blocks.push(maker.gather(input, &grid.rect)?);
            }
            artefact.make(&blocks, cancel)
        })?);
    }
    Ok(made)
}
