//! Workers: they make tiles.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use relievo_graph::RenderError;
use relievo_raster::{Cancel, Tile};
use thread_priority::{ThreadPriority, ThreadPriorityValue};

use super::Shared;
use super::state::State;
use crate::cache::{Cost, TileState};
use crate::log::LogEntry;
use crate::queue::{Inputs, Job};

/// A tile that the disk has not given after this is made instead.
const PATIENCE: Duration = Duration::from_millis(100);

/// A little below normal: drawing comes first, but where the processor draws, too, the lowest
/// priority would leave nothing for tiles at all.
pub(super) fn below_normal() -> ThreadPriority {
    ThreadPriorityValue::try_from(40).map_or(ThreadPriority::Min, ThreadPriority::Crossplatform)
}

/// Makes a tile. A panic in a node is a bug, but one tile's: it must not take a worker with it and
/// leave everybody waiting.
fn make(job: &Job, inputs: &Inputs, cancel: &Cancel) -> Result<Tile, RenderError> {
    let tile_of = |node, key| Arc::clone(&inputs.tiles[&(node, key)]);
    let made = catch_unwind(AssertUnwindSafe(|| {
        job.graph.make(job.node, job.key, &tile_of, cancel)
    }));
    made.unwrap_or_else(|_| {
        Err(RenderError::Node {
            node: job.graph.node(job.node).kind(),
            reason: format!("panicked while making tile {}; this is a bug", job.key),
        })
    })
}

impl Shared {
    /// A worker: takes the first task that can run.
    pub(super) fn work_on(&self) {
        let mut state = self.state.lock();
        loop {
            let Some((job, inputs)) = state.queue.start() else {
                if state.closing {
                    return;
                }
                if let Some((job, rank)) = state.queue.give_up_load(PATIENCE) {
                    state.resolve_making(job, rank);
                    self.work.notify_all();
                } else if state.queue.is_loading() {
                    self.work.wait_for(&mut state, PATIENCE);
                } else {
                    self.work.wait(&mut state);
                }
                continue;
            };
            if state.closing {
                return;
            }
            drop(state);
            let started = Instant::now();
            let result = make(&job, &inputs, &self.cancel);
            let own = started.elapsed();
            self.busy_ns
                .fetch_add(own.as_nanos() as u64, Ordering::Relaxed);
            let cost = Cost {
                own,
                whole: own + inputs.cost,
            };
            drop(inputs);
            state = self.state.lock();
            self.keep(&mut state, &job, result, cost);
            self.tell(&mut state);
        }
    }

    fn keep(&self, state: &mut State, job: &Job, result: Result<Tile, RenderError>, cost: Cost) {
        let ready = result.is_ok();
        let outcome = match result {
            Ok(tile) => {
                state.stats.made += 1;
                if state.is_dear(job.id, &tile, cost) {
                    state.storing.add(job.clone(), cost.whole);
                }
                TileState::Ready(Arc::new(tile))
            }
            Err(RenderError::Cancelled) => {
                state.queue.finish(job.id, None);
                return;
            }
            Err(error) => {
                state.stats.failed += 1;
                tracing::warn!("tile {} failed: {error}", job.key);
                TileState::Failed(Arc::new(error))
            }
        };
        if self.log {
            let kind = job.graph.node(job.node).kind();
            state.log.push(LogEntry {
                graph: Arc::downgrade(&job.graph),
                node: job.node,
                kind,
                key: job.key,
                id: job.id,
                ready,
                cost: cost.own,
            });
        }
        state.done(job, &outcome, cost);
    }
}
