//! Long work on a thread of its own, of which only the latest counts: new work cancels what was asked
//! for before.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use relievo_engine::raster::Cancel;

use super::inbox::Waker;

type Work<A> = Box<dyn FnOnce(&Cancel) -> A + Send>;

struct State<K, A> {
    asked: Option<(K, Work<A>, Cancel)>,
    answer: Option<(K, A)>,
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
            let (key, work, cancel) = loop {
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
            let answer = work(&cancel);
            if cancel.is_cancelled() {
                continue;
            }
            self.lock().answer = Some((key, answer));
            waker.wake();
        }
    }
}

/// A thread, the question that it works at (`K` tells questions apart) and its latest answer.
pub(crate) struct Latest<K, A> {
    shared: Arc<Shared<K, A>>,
    thread: Option<JoinHandle<()>>,
    asked: Option<(K, Cancel)>,
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

    /// Asks a question, unless it is the one that was asked last.
    pub(crate) fn ask<W>(&mut self, key: K, work: impl FnOnce() -> W)
    where
        W: FnOnce(&Cancel) -> A + Send + 'static,
    {
        if self.asked.as_ref().is_some_and(|(asked, _)| *asked == key) {
            return;
        }
        self.forget();
        let cancel = Cancel::default();
        self.asked = Some((key.clone(), cancel.clone()));
        self.shared.lock().asked = Some((key, Box::new(work()), cancel));
        self.shared.woken.notify_one();
    }

    /// The answer to a question, once it is there.
    pub(crate) fn answer(&self, key: &K) -> Option<A> {
        let state = self.shared.lock();
        let answer = state.answer.as_ref().filter(|(k, _)| k == key);
        answer.map(|(_, answer)| answer.clone())
    }

    /// The answer that came last, whatever was asked since.
    pub(crate) fn last(&self) -> Option<A> {
        let state = self.shared.lock();
        state.answer.as_ref().map(|(_, answer)| answer.clone())
    }
}

impl<K, A> Latest<K, A> {
    /// Stops asking.
    pub(crate) fn forget(&mut self) {
        if let Some((_, cancel)) = self.asked.take() {
            cancel.cancel();
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
            |cancel: &Cancel| {
                while !cancel.is_cancelled() {
                    std::thread::yield_now();
                }
                1
            }
        });
        latest.ask(2, || |_: &Cancel| 20);
        for _ in 0..20_000 {
            if latest.answer(&2).is_some() {
                break;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        assert_eq!(latest.answer(&2), Some(20));
        assert_eq!(latest.answer(&1), None);
        assert_eq!(latest.last(), Some(20));
    }
}
