//! Long work on a thread of its own, of which only the latest counts: new work cancels what was asked
//! for before.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use relievo_engine::analysis::Task;
use relievo_engine::raster::Cancel;

use super::inbox::Waker;

type Work<A> = Box<dyn FnOnce(&Task) -> A + Send>;

/// What a question comes with.
#[derive(Clone)]
struct Handle {
    cancel: Cancel,
    /// The part that is done, 0 to 1, as bits.
    share: Arc<AtomicU32>,
}

/// An answer with its question.
#[derive(Clone, Debug)]
pub(crate) struct Answered<K, A> {
    pub(crate) key: K,
    pub(crate) answer: A,
    /// How long it took.
    pub(crate) took: Duration,
}

/// What became of the question that was asked last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Waiting {
    /// It is answered, or there is none.
    No,
    /// Its answer is on the way.
    Busy {
        /// The part that is done, 0 to 1.
        share: f32,
        /// When it was asked.
        since: Instant,
    },
    /// Somebody stopped it.
    Stopped,
}

struct State<K, A> {
    asked: Option<(K, Work<A>, Handle)>,
    answer: Option<Answered<K, A>>,
    closing: bool,
}

struct Shared<K, A> {
    state: Mutex<State<K, A>>,
    woken: Condvar,
}

impl<K, A> Shared<K, A> {
    fn lock(&self) -> MutexGuard<'_, State<K, A>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn work(&self, waker: &Waker) {
        loop {
            let mut state = self.lock();
            let (key, work, Handle { cancel, share }) = loop {
                if state.closing {
                    return;
                }
                match state.asked.take() {
                    Some(asked) => break asked,
                    None => {
                        state = self
                            .woken
                            .wait(state)
                            .unwrap_or_else(PoisonError::into_inner);
                    }
                }
            };
            drop(state);
            let began = Instant::now();
            let answer = work(&Task {
                cancel: &cancel,
                progress: &|done| share.store((done as f32).to_bits(), Ordering::Relaxed),
            });
            if cancel.is_cancelled() {
                continue;
            }
            let took = began.elapsed();
            self.lock().answer = Some(Answered { key, answer, took });
            waker.wake();
        }
    }
}

/// A thread, the question that it works at (`K` tells questions apart) and its latest answer.
pub(crate) struct Latest<K, A> {
    shared: Arc<Shared<K, A>>,
    thread: Option<JoinHandle<()>>,
    asked: Option<(K, Handle, Instant)>,
}

impl<K, A> Latest<K, A>
where
    K: Clone + PartialEq + Send + 'static,
    A: Clone + Send + 'static,
{
    /// Starts the thread.
    ///
    /// # Errors
    /// When the system refuses it.
    pub(crate) fn new(name: &str, waker: Waker) -> std::io::Result<Self> {
        let shared = Arc::new(Shared {
            state: Mutex::new(State {
                asked: None,
                answer: None,
                closing: false,
            }),
            woken: Condvar::new(),
        });
        let mine = Arc::clone(&shared);
        let thread = std::thread::Builder::new().name(name.to_owned());
        let thread = thread.spawn(move || mine.work(&waker))?;
        Ok(Self {
            shared,
            thread: Some(thread),
            asked: None,
        })
    }

    /// Asks a question, unless it is the one that was asked last (be it stopped).
    pub(crate) fn ask<W>(&mut self, key: K, work: impl FnOnce() -> W)
    where
        W: FnOnce(&Task) -> A + Send + 'static,
    {
        if self.asked.as_ref().is_some_and(|(asked, ..)| *asked == key) {
            return;
        }
        self.forget();
        let handle = Handle {
            cancel: Cancel::default(),
            share: Arc::default(),
        };
        self.asked = Some((key.clone(), handle.clone(), Instant::now()));
        self.shared.lock().asked = Some((key, Box::new(work()), handle));
        self.shared.woken.notify_one();
    }

    /// The answer to a question, once it is there.
    pub(crate) fn answer(&self, key: &K) -> Option<A> {
        let state = self.shared.lock();
        let answer = state.answer.as_ref().filter(|a| a.key == *key);
        answer.map(|a| a.answer.clone())
    }

    /// The answer that came last, whatever was asked since.
    pub(crate) fn last(&self) -> Option<Answered<K, A>> {
        self.shared.lock().answer.clone()
    }

    /// What became of the question that was asked last.
    pub(crate) fn waiting(&self) -> Waiting {
        match &self.asked {
            None => Waiting::No,
            Some((_, handle, _)) if handle.cancel.is_cancelled() => Waiting::Stopped,
            Some((key, handle, since)) => {
                let state = self.shared.lock();
                if state.answer.as_ref().is_some_and(|a| a.key == *key) {
                    return Waiting::No;
                }
                Waiting::Busy {
                    share: f32::from_bits(handle.share.load(Ordering::Relaxed)),
                    since: *since,
                }
            }
        }
    }

    /// Stops what is being worked at; it is not asked again by itself.
    pub(crate) fn stop(&mut self) {
        if let (Waiting::Busy { .. }, Some((_, handle, _))) = (self.waiting(), &self.asked) {
            handle.cancel.cancel();
            self.shared.lock().asked = None;
        }
    }

    /// Forgets the last answer, too.
    pub(crate) fn clear(&mut self) {
        self.forget();
        self.shared.lock().answer = None;
    }
}

impl<K, A> Latest<K, A> {
    /// Stops asking.
    pub(crate) fn forget(&mut self) {
        if let Some((_, handle, _)) = self.asked.take() {
            handle.cancel.cancel();
        }
        self.shared.lock().asked = None;
    }
}

impl<K, A> Drop for Latest<K, A> {
    fn drop(&mut self) {
        self.forget();
        self.shared.lock().closing = true;
        self.shared.woken.notify_one();
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            tracing::error!("a thread that answers questions ended by a panic");
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn only_the_latest_question_is_answered_and_the_one_before_is_cancelled() {
        let mut latest = Latest::new("test", Waker::default()).unwrap();
        latest.ask(1, || {
            |task: &Task| {
                while !task.cancel.is_cancelled() {
                    std::thread::yield_now();
                }
                1
            }
        });
        latest.ask(2, || |_: &Task| 20);
        for _ in 0..20_000 {
            if latest.answer(&2).is_some() {
                break;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        assert_eq!(latest.answer(&2), Some(20));
        assert_eq!(latest.answer(&1), None);
        assert_eq!(latest.last().map(|a| a.answer), Some(20));
    }

    #[test]
    fn what_is_stopped_says_so_and_is_asked_again_only_once_forgotten() {
        let mut latest = Latest::new("test", Waker::default()).unwrap();
        let forever = || {
            |task: &Task| {
                (task.progress)(0.25);
                while !task.cancel.is_cancelled() {
                    std::thread::yield_now();
                }
            }
        };
        latest.ask(1, forever);
        let halted = |latest: &Latest<i32, ()>| matches!(latest.waiting(), Waiting::Busy { share, .. } if share == 0.25);
        while !halted(&latest) {
            std::thread::yield_now();
        }
        latest.stop();
        latest.ask(1, forever);
        assert_eq!(latest.waiting(), Waiting::Stopped);
        latest.forget();
        latest.ask(1, forever);
        assert!(matches!(latest.waiting(), Waiting::Busy { .. }));
    }
}
