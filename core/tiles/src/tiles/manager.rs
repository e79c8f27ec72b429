//! The manager: what is wanted becomes tasks.

use std::collections::HashSet;

use parking_lot::MutexGuard;

use super::{Finished, Shared, Want};
use crate::queue::{Job, Rank};

impl Shared {
    /// The manager: turns wants into tasks whenever they change.
    pub(super) fn manage(&self) {
        let mut state = self.state.lock();
        loop {
            while state.inbox.is_none() && !state.closing {
                self.asked.wait(&mut state);
            }
            if state.closing {
                return;
            }
            let Some((wants, focus)) = state.inbox.take() else {
                continue;
            };
            state.managing = true;
            let forgotten = std::mem::take(&mut state.forgotten);
            let freed: Vec<_> = forgotten
                .into_iter()
                .filter_map(|id| state.cache.remove(id))
                .collect();
            // To give memory back takes longer than others should wait.
            MutexGuard::unlocked(&mut state, || drop(freed));
            state.queue.clear();
            if let Some(want) = wants.first() {
                state.storing.follow(&want.graph);
            }
            let wanted: HashSet<_> = wants.iter().map(|w| w.id).collect();
            state.cache.set_wanted(|id| wanted.contains(&id), focus);
            state.wanted = wanted;
            let mut told = HashSet::new();
            for (rank, want) in wants.into_iter().enumerate() {
                if state.inbox.is_some() || state.closing {
                    break;
                }
                if !told.insert(want.id) {
                    continue;
                }
                if let Some(found) = state.cache.get(want.id) {
                    state.finished.push(Finished {
                        id: want.id,
                        state: found,
                    });
                    continue;
                }
                let Want {
                    graph,
                    node,
                    key,
                    id,
                } = want;
                let job = Job {
                    graph,
                    node,
                    key,
                    id,
                };
                state.resolve(job, rank as Rank);
                self.work.notify_one();
                if state.queue.is_loading() {
                    self.read.notify_one();
                }
                // Others must get the lock between two wants, or drawing would stall on a long list.
                MutexGuard::bump(&mut state);
            }
            state.managing = false;
            self.progress.notify_all();
            self.work.notify_all();
            self.read.notify_all();
            self.write.notify_one();
            self.wake();
        }
    }
}
