//! Asks what is under the pointer at the data's own resolution, on a thread of its own.
//!
//! Only the latest question counts: a new one cancels the one before.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use relievo_engine::planet::MapPoint;
use relievo_engine::raster::Cancel;
use relievo_engine::{PlaceAnswer, Questions};

use super::inbox::Waker;

/// A place in a state of the project.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spot {
    /// Where.
    pub(crate) point: MapPoint,
    /// Which state of the project.
    pub(crate) revision: u64,
}

struct Request {
    spot: Spot,
    questions: Questions,
    cancel: Cancel,
}

#[derive(Default)]
struct State {
    request: Option<Request>,
    answer: Option<(Spot, Option<PlaceAnswer>)>,
    closing: bool,
}

#[derive(Default)]
struct Shared {
    state: Mutex<State>,
    asked: Condvar,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn answer_all(&self, waker: &Waker) {
        loop {
            let mut state = self.lock();
            let request = loop {
                if state.closing {
                    return;
                }
                match state.request.take() {
                    Some(request) => break request,
                    None => {
                        state = self
                            .asked
                            .wait(state)
                            .unwrap_or_else(PoisonError::into_inner);
                    }
                }
            };
            drop(state);
            let found = request.questions.place(request.spot.point, &request.cancel);
            if request.cancel.is_cancelled() {
                continue;
            }
            self.lock().answer = Some((request.spot, found.ok()));
            waker.wake();
        }
    }
}

/// The thread and the way to it.
pub(crate) struct Probe {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
    asked: Option<(Spot, Cancel)>,
}

impl Probe {
    /// Starts the thread.
    ///
    /// # Errors
    /// When the system refuses it.
    pub(crate) fn new(waker: Waker) -> std::io::Result<Self> {
        let shared = Arc::new(Shared::default());
        let mine = Arc::clone(&shared);
        let thread = std::thread::Builder::new().name("relievo-probe".to_owned());
        let thread = thread.spawn(move || mine.answer_all(&waker))?;
        Ok(Self {
            shared,
            thread: Some(thread),
            asked: None,
        })
    }

    /// Asks about a spot, unless it is the one that was asked about last.
    pub(crate) fn ask(&mut self, spot: Spot, questions: impl FnOnce() -> Questions) {
        if self.asked.as_ref().is_some_and(|(asked, _)| *asked == spot) {
            return;
        }
        self.forget();
        let cancel = Cancel::default();
        self.asked = Some((spot, cancel.clone()));
        self.shared.lock().request = Some(Request {
            spot,
            questions: questions(),
            cancel,
        });
        self.shared.asked.notify_one();
    }

    /// Stops asking.
    pub(crate) fn forget(&mut self) {
        if let Some((_, cancel)) = self.asked.take() {
            cancel.cancel();
        }
        self.shared.lock().request = None;
    }

    /// The answer for a spot, once it is there.
    pub(crate) fn answer(&self, spot: Spot) -> Option<PlaceAnswer> {
        let state = self.shared.lock();
        state
            .answer
            .as_ref()
            .filter(|(s, _)| *s == spot)
            .and_then(|(_, answer)| answer.clone())
    }
}

impl Drop for Probe {
    fn drop(&mut self) {
        self.forget();
        self.shared.lock().closing = true;
        self.shared.asked.notify_one();
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            tracing::error!("the thread that answers questions ended by a panic");
        }
    }
}
