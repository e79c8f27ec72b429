//! Work on several threads whose results do not show how many there were.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use crate::ground::{AnalysisError, Watch, go_on};

/// Results of `work` for 0 to `count`, in this order, made on up to `threads` threads. The first
/// error (of the lowest index that was reached) ends the work; `done` is told how many are finished.
pub(crate) fn map<R: Send>(
    count: usize,
    threads: usize,
    watch: &dyn Watch,
    done: &(dyn Fn(usize) + Sync),
    work: &(dyn Fn(usize) -> Result<R, AnalysisError> + Sync),
) -> Result<Vec<R>, AnalysisError> {
    let threads = threads.clamp(1, 64).min(count);
    let (next, finished) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let failed: Mutex<Option<(usize, AnalysisError)>> = Mutex::new(None);
    let made: Mutex<Vec<(usize, R)>> = Mutex::new(Vec::with_capacity(count));
    let run = || {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= count {
                return;
            }
            match go_on(watch).and_then(|()| work(index)) {
                Ok(result) => {
                    lock(&made).push((index, result));
                    done(finished.fetch_add(1, Ordering::Relaxed) + 1);
                }
                Err(error) => {
                    next.store(count, Ordering::Relaxed);
                    let mut failed = lock(&failed);
                    if failed.as_ref().is_none_or(|(at, _)| index < *at) {
                        *failed = Some((index, error));
                    }
                    return;
                }
            }
        }
    };
    thread::scope(|scope| {
        for helper in 1..threads {
            let named = thread::Builder::new().name(format!("relievo-analysis-{helper}"));
            // Without another thread this one does it all.
            if named.spawn_scoped(scope, run).is_err() {
                break;
            }
        }
        run();
    });
    if let Some((_, error)) = lock(&failed).take() {
        return Err(error);
    }
    let mut made = made
        .into_inner()
        .unwrap_or_else(std::sync::PoisonError::into_inner);
    made.sort_unstable_by_key(|(index, _)| *index);
    Ok(made.into_iter().map(|(_, result)| result).collect())
}

/// A panic elsewhere ends the scope anyway.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner)
}
