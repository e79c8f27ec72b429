//! The files behind layers: opened in the background, each once, and kept while a layer names them.
//!
//! A file that changes on disk is noticed by looking at its path now and then, and opened again; it
//! has another fingerprint then, so that exactly what depends on it is made again. Until the new
//! one is open the old one stays, so that a file that is being written shows no errors.

mod opening;
mod watch;

use std::collections::{HashMap, HashSet};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, bounded};
use parking_lot::{Condvar, Mutex};
use relievo_graph::RenderError;
use relievo_project::{LayerKind, Project, Source, Stretch, resolve_path};
use relievo_raster::chunk_cache::ChunkCache;
use relievo_raster::open::DEFAULT_CHUNK_CACHE_BYTES;
use relievo_raster::{Bands, Cancel, RasterFile};

use crate::vectors::OpenFeatures;

use self::watch::{Attempt, Found, Step, Watch};

/// Files that may wait to be opened; more wait for the next call of `require`.
const WAITING: usize = 256;

/// Threads that open files: making a pyramid takes seconds, and must not hold up a small file.
const OPENERS: usize = 2;

/// What identifies an open file: two layers that read it alike share it.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct SourceKey {
    path: PathBuf,
    bands: Bands,
    /// The other options, as text: overrides hold floats, which are compared by how they are written.
    options: String,
}

/// What became of a file.
#[derive(Clone)]
pub enum SourceState {
    /// Being opened; 0 to 1 while a pyramid is made.
    Opening(f32),
    /// Ready to read. Where the file changed on disk it stays so until the new one is open.
    Open(Arc<dyn RasterFile>),
    /// Read: features of a vector layer. Where the file changed on disk it stays so until the new
    /// one is read; companions of a Shapefile are read with it, and not looked at by themselves.
    Features(Arc<OpenFeatures>),
    /// Cannot be opened, or is gone: one line that says why.
    Failed(String),
}

/// What happened to files since they were last asked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum News {
    /// Nothing.
    #[default]
    None,
    /// Files were opened or refused for the first time.
    Opened,
    /// Files changed: what could not be read of them may be readable now, and the other way round.
    Replaced,
}

/// How a file is opened.
#[derive(Clone)]
struct Request {
    key: SourceKey,
    what: What,
}

/// What a file is opened as.
#[derive(Clone)]
enum What {
    Raster {
        source: Source,
        bands: Option<Vec<u16>>,
        stretch: Stretch,
    },
    Vector {
        layer: Option<String>,
        crs: Option<String>,
    },
}

/// A file that some layer names.
struct Slot {
    state: SourceState,
    request: Request,
    /// Whether an opener has it, or will.
    queued: bool,
    watch: Watch,
}

#[derive(Default)]
struct State {
    files: HashMap<SourceKey, Slot>,
    news: News,
}

struct Shared {
    state: Mutex<State>,
    settled: Condvar,
    cancel: Cancel,
    /// Whether somebody looks at the files now and then.
    watching: bool,
    /// Decoded parts of all files.
    chunks: Arc<ChunkCache>,
    cache_folder: Option<PathBuf>,
    wake: Option<Arc<dyn Fn() + Send + Sync>>,
}

/// All files that the project's layers name.
pub struct Sources {
    shared: Arc<Shared>,
    requests: Option<Sender<Request>>,
    /// Ends the thread that looks at files when it is dropped.
    looking: Option<Sender<()>>,
    threads: Vec<JoinHandle<()>>,
}

impl Sources {
    /// - `watch`: how often files are looked at; `None`: only by [`Self::look`], and a file that
    ///   changes while it is read is an error then.
    pub(crate) fn new(
        cache_folder: Option<PathBuf>,
        wake: Option<Arc<dyn Fn() + Send + Sync>>,
        watch: Option<Duration>,
    ) -> std::io::Result<Self> {
        let shared = Arc::new(Shared {
            state: Mutex::default(),
            settled: Condvar::new(),
            cancel: Cancel::default(),
            watching: watch.is_some(),
            chunks: Arc::new(ChunkCache::new(DEFAULT_CHUNK_CACHE_BYTES)),
            cache_folder,
            wake,
        });
        let (sender, receiver) = bounded::<Request>(WAITING);
        let mut sources = Self {
            shared,
            requests: Some(sender.clone()),
            looking: None,
            threads: Vec::new(),
        };
        for n in 0..OPENERS {
            let receiver = receiver.clone();
            sources.spawn(format!("relievo-opener-{n}"), move |shared| {
                shared.open_all(&receiver);
            })?;
        }
        if let Some(every) = watch {
            let (end, ended) = bounded::<()>(0);
            sources.looking = Some(end);
            sources.spawn("relievo-looker".to_owned(), move |shared| {
                while ended.recv_timeout(every) == Err(RecvTimeoutError::Timeout) {
                    shared.look(&sender);
                }
            })?;
        }
        Ok(sources)
    }

    fn spawn(
        &mut self,
        name: String,
        body: impl FnOnce(&Arc<Shared>) + Send + 'static,
    ) -> std::io::Result<()> {
        let shared = Arc::clone(&self.shared);
        let thread = std::thread::Builder::new().name(name);
        self.threads.push(thread.spawn(move || body(&shared))?);
        Ok(())
    }

    /// Opens what the project's layers name and is not open yet; forgets what none names.
    pub(crate) fn require(&self, project: &Project, folder: &Path) {
        let mut state = self.shared.state.lock();
        let mut named = HashSet::new();
        for layer in &project.layers {
            let Some(request) = request_of(&layer.kind, folder) else {
                continue;
            };
            named.insert(request.key.clone());
            if state.files.contains_key(&request.key) {
                continue;
            }
            if self
                .requests
                .as_ref()
                .is_some_and(|r| r.try_send(request.clone()).is_ok())
            {
                let slot = Slot {
                    state: SourceState::Opening(0.0),
                    request,
                    queued: true,
                    watch: Watch::default(),
                };
                state.files.insert(slot.request.key.clone(), slot);
            }
        }
        // An opener that is still busy with a forgotten file drops its result.
        state.files.retain(|key, _| named.contains(key));
    }

    /// Tries files again that could not be opened.
    pub(crate) fn forget_failures(&self) {
        self.shared
            .state
            .lock()
            .files
            .retain(|_, slot| !matches!(slot.state, SourceState::Failed(_)));
    }

    /// Looks at all files now, as the looking thread does. Two looks that agree that a file changed
    /// have it opened again.
    pub(crate) fn look(&self) {
        if let Some(requests) = &self.requests {
            self.shared.look(requests);
        }
    }

    /// The file whose change on disk is why a tile could not be made, where looks will lead to its
    /// being opened again.
    pub(crate) fn changed_file<'e>(&self, error: &'e RenderError) -> Option<&'e Path> {
        match error {
            RenderError::Read(error) if self.shared.watching && error.is_change() => error.path(),
            RenderError::Read(_) | RenderError::Cancelled | RenderError::Node { .. } => None,
        }
    }

    /// A read found that a file is not what it was when it was opened.
    pub(crate) fn distrust(&self, path: &Path) {
        let mut state = self.shared.state.lock();
        #[expect(
            clippy::iter_over_hash_type,
            reason = "sets a flag on each entry: order cannot matter"
        )]
        for slot in state.files.values_mut() {
            if slot.request.key.path == path && !slot.queued {
                slot.watch.distrust();
            }
        }
    }

    /// The state of a layer's file; `None` for layers without one.
    pub fn state(&self, kind: &LayerKind, folder: &Path) -> Option<SourceState> {
        let key = request_of(kind, folder)?.key;
        let state = self.shared.state.lock();
        let slot = state.files.get(&key);
        Some(slot.map_or(SourceState::Opening(0.0), |s| s.state.clone()))
    }

    /// Number of files that are being opened, for the first time or again.
    pub fn opening(&self) -> usize {
        let state = self.shared.state.lock();
        state.files.values().filter(|s| s.queued).count()
    }

    /// Number of files that are kept.
    pub(crate) fn len(&self) -> usize {
        self.shared.state.lock().files.len()
    }

    /// What happened since the last call.
    pub(crate) fn take_news(&self) -> News {
        std::mem::take(&mut self.shared.state.lock().news)
    }

    /// Waits until a file is opened or refused, or the time is over.
    pub(crate) fn wait(&self, timeout: Duration) {
        let mut state = self.shared.state.lock();
        if state.news == News::None {
            self.shared.settled.wait_for(&mut state, timeout);
        }
    }
}

impl Drop for Sources {
    fn drop(&mut self) {
        self.shared.cancel.cancel();
        self.looking = None;
        self.requests = None;
        for thread in self.threads.drain(..) {
            if thread.join().is_err() {
                tracing::error!("a thread that opens files ended by a panic");
            }
        }
    }
}

impl Shared {
    /// An opener: takes requests until there is nobody left to make one.
    fn open_all(self: &Arc<Self>, requests: &Receiver<Request>) {
        for request in requests {
            if self.cancel.is_cancelled() {
                return;
            }
            let path = &request.key.path;
            let before = Found::at(path);
            // A panic in a reader is a bug, but one file's: it must neither take the thread with it
            // nor leave whoever waits for the file waiting.
            let open = || self.open(&request);
            let opened = match &before {
                Found::File { .. } => {
                    catch_unwind(AssertUnwindSafe(open)).unwrap_or_else(|_told| {
                        Err(format!("panicked while opening; this is a bug: {path:?}"))
                    })
                }
                Found::Nothing(reason) => Err(reason.clone()),
            };
            let mut attempt = Attempt {
                after: Found::at(path),
                before,
                opened: opened.is_ok(),
                patient: false,
            };
            let mut state = self.state.lock();
            if let Some(slot) = state.files.get_mut(&request.key) {
                slot.queued = false;
                let shown = matches!(slot.state, SourceState::Open(_) | SourceState::Features(_));
                attempt.patient = self.watching && shown;
                if slot.watch.tried(attempt) {
                    let first = matches!(slot.state, SourceState::Opening(_));
                    slot.state = match opened {
                        Ok(open) => open,
                        Err(reason) => SourceState::Failed(reason),
                    };
                    let news = if first { News::Opened } else { News::Replaced };
                    state.news = state.news.max(news);
                }
            }
            drop(state);
            self.settled.notify_all();
            self.wake();
        }
    }

    /// Looks at the path of every file once.
    fn look(&self, requests: &Sender<Request>) {
        let paths: HashSet<PathBuf> = {
            let state = self.state.lock();
            let idle = state.files.values().filter(|s| !s.queued);
            idle.map(|s| s.request.key.path.clone()).collect()
        };
        // Without the lock: a network that does not answer must hold nobody up.
        let found: HashMap<PathBuf, Found> = paths
            .into_iter()
            .take_while(|_| !self.cancel.is_cancelled())
            .map(|path| {
                let found = Found::at(&path);
                (path, found)
            })
            .collect();
        let mut lost = false;
        let mut state = self.state.lock();
        for slot in state.files.values_mut().filter(|s| !s.queued) {
            let Some(found) = found.get(&slot.request.key.path) else {
                continue;
            };
            match slot.watch.look(found.clone()) {
                Step::Wait => {}
                Step::Reopen => slot.queued = requests.try_send(slot.request.clone()).is_ok(),
                Step::Lost(reason) => {
                    slot.state = SourceState::Failed(reason);
                    lost = true;
                }
            }
        }
        if lost {
            state.news = News::Replaced;
            drop(state);
            self.settled.notify_all();
            self.wake();
        }
    }

    /// A pyramid is made to some part.
    fn progress(&self, key: &SourceKey, done: f32) {
        if let Some(slot) = self.state.lock().files.get_mut(key)
            && let SourceState::Opening(share) = &mut slot.state
        {
            *share = done;
        }
        self.wake();
    }

    fn wake(&self) {
        if let Some(wake) = &self.wake {
            wake();
        }
    }
}

/// The file of a layer and how it is read.
fn request_of(kind: &LayerKind, folder: &Path) -> Option<Request> {
    if let LayerKind::Vector(vector) = kind {
        let (layer, crs) = (vector.source_layer.clone(), vector.crs.clone());
        let key = SourceKey {
            path: resolve_path(folder, &vector.path),
            bands: Bands::Colour,
            options: format!("vector {layer:?} {crs:?}"),
        };
        let what = What::Vector { layer, crs };
        return Some(Request { key, what });
    }
    let (source, bands, chosen, stretch) = match kind {
        LayerKind::Imagery(l) => (&l.source, Bands::Colour, l.bands.clone(), l.stretch),
        LayerKind::Height(l) => {
            let chosen = l.band.map(|b| vec![b]);
            (&l.source, Bands::Height, chosen, Stretch::Auto)
        }
        LayerKind::Noise(_)
        | LayerKind::Detail(_)
        | LayerKind::Tint(_)
        | LayerKind::Slope(_)
        | LayerKind::Contours(_)
        | LayerKind::Vector(_)
        | LayerKind::Unknown { .. } => return None,
    };
    let place = source.georeference.as_ref();
    let (crs, extent) = (
        place.and_then(|g| g.crs.as_deref()),
        place.and_then(|g| g.extent),
    );
    let key = SourceKey {
        path: resolve_path(folder, &source.path),
        bands,
        options: format!(
            "{crs:?} {extent:?} {:?} {chosen:?} {:?} {:?} {stretch:?}",
            source.nodata, source.encoding, source.tile_rows
        ),
    };
    let what = What::Raster {
        source: source.clone(),
        bands: chosen,
        stretch,
    };
    Some(Request { key, what })
}
