//! Threads that the disk may hold up: readers of finished tiles, and their writer.

use std::sync::Arc;
use std::time::Instant;

use parking_lot::MutexGuard;

use super::Shared;
use crate::cache::{Cost, TileState};

impl Shared {
    /// A reader: takes the first tile that may lie on disk.
    pub(super) fn read_on(&self, lists: bool) {
        let mut state = self.state.lock();
        let Some(disk) = state.disk.clone() else {
            return;
        };
        if lists {
            MutexGuard::unlocked(&mut state, || disk.list());
        }
        loop {
            if state.closing {
                return;
            }
            let Some(id) = state.queue.start_load() else {
                self.read.wait(&mut state);
                continue;
            };
            let started = Instant::now();
            let found = MutexGuard::unlocked(&mut state, || disk.load(id));
            let Some((job, rank)) = state.queue.end_load(id) else {
                continue;
            };
            match found {
                Some(loaded) => {
                    state.stats.loaded += 1;
                    let cost = Cost {
                        own: started.elapsed(),
                        whole: loaded.cost,
                    };
                    state.done(&job, &TileState::Ready(Arc::new(loaded.tile)), cost);
                }
                None if state.wanted.contains(&id) || state.queue.is_read(id) => {
                    state.resolve_making(job, rank);
                }
                None => {}
            }
            self.tell(&mut state);
        }
    }

    /// The writer: stores what was dear while nothing is wanted.
    pub(super) fn write_on(&self) {
        let mut state = self.state.lock();
        let Some(disk) = state.disk.clone() else {
            return;
        };
        loop {
            let due = state.storing.due_in();
            match due {
                None if state.closing => return,
                Some(wait) if !state.closing && state.is_idle() && !wait.is_zero() => {
                    self.write.wait_for(&mut state, wait);
                    continue;
                }
                Some(_) if state.closing || state.is_idle() => {}
                _ => {
                    self.write.wait(&mut state);
                    continue;
                }
            }
            let Some((next, graph)) = state.storing.next() else {
                continue;
            };
            let Some(TileState::Ready(tile)) = state.cache.get(next.id()) else {
                continue;
            };
            let stored = MutexGuard::unlocked(&mut state, || {
                next.is_of(&graph) && disk.save(next.id(), &tile, next.cost)
            });
            state.stats.stored += u64::from(stored);
        }
    }
}
