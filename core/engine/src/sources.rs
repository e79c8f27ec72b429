//! The files behind layers: opened in the background, each once, and kept while a layer names them.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use crossbeam_channel::{Receiver, Sender, bounded};
use parking_lot::{Condvar, Mutex};
use relievo_project::{Georeference, LayerKind, Project, Source, resolve_path};
use relievo_raster::chunk_cache::ChunkCache;
use relievo_raster::open::{DEFAULT_CHUNK_CACHE_BYTES, OpenOptions, open};
use relievo_raster::{Bands, Cancel, RasterFile};

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
    /// Ready to read.
    Open(Arc<dyn RasterFile>),
    /// Cannot be opened: one line that says why.
    Failed(String),
}

struct State {
    files: HashMap<SourceKey, SourceState>,
    changed: bool,
}

struct Shared {
    state: Mutex<State>,
    settled: Condvar,
    cancel: Cancel,
    /// Decoded parts of all files.
    chunks: Arc<ChunkCache>,
    cache_folder: Option<PathBuf>,
    wake: Option<Arc<dyn Fn() + Send + Sync>>,
}

struct Request {
    key: SourceKey,
    source: Source,
    bands: Option<Vec<u16>>,
}

/// All files that the project's layers name.
pub struct Sources {
    shared: Arc<Shared>,
    requests: Option<Sender<Request>>,
    threads: Vec<JoinHandle<()>>,
}

impl Sources {
    pub(crate) fn new(
        cache_folder: Option<PathBuf>,
        wake: Option<Arc<dyn Fn() + Send + Sync>>,
    ) -> std::io::Result<Self> {
        let shared = Arc::new(Shared {
            state: Mutex::new(State {
                files: HashMap::new(),
                changed: false,
            }),
            settled: Condvar::new(),
            cancel: Cancel::default(),
            chunks: Arc::new(ChunkCache::new(DEFAULT_CHUNK_CACHE_BYTES)),
            cache_folder,
            wake,
        });
        let (sender, receiver) = bounded::<Request>(WAITING);
        let mut threads = Vec::new();
        for n in 0..OPENERS {
            let (shared, receiver) = (Arc::clone(&shared), receiver.clone());
            let thread = std::thread::Builder::new().name(format!("relievo-opener-{n}"));
            threads.push(thread.spawn(move || shared.open_all(&receiver))?);
        }
        Ok(Self {
            shared,
            requests: Some(sender),
            threads,
        })
    }

    /// Opens what the project's layers name and is not open yet; forgets what none names.
    pub(crate) fn require(&self, project: &Project, folder: &Path) {
        let mut state = self.shared.state.lock();
        let mut named = HashSet::new();
        for layer in &project.layers {
            let Some((key, source, bands)) = request_of(&layer.kind, folder) else {
                continue;
            };
            named.insert(key.clone());
            if state.files.contains_key(&key) {
                continue;
            }
            let request = Request {
                key: key.clone(),
                source,
                bands,
            };
            if self
                .requests
                .as_ref()
                .is_some_and(|r| r.try_send(request).is_ok())
            {
                state.files.insert(key, SourceState::Opening(0.0));
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
            .retain(|_, s| !matches!(s, SourceState::Failed(_)));
    }

    /// The state of a layer's file; `None` for layers without one.
    pub fn state(&self, kind: &LayerKind, folder: &Path) -> Option<SourceState> {
        let (key, ..) = request_of(kind, folder)?;
        let state = self.shared.state.lock();
        Some(
            state
                .files
                .get(&key)
                .cloned()
                .unwrap_or(SourceState::Opening(0.0)),
        )
    }

    /// Number of files that are being opened.
    pub fn opening(&self) -> usize {
        let state = self.shared.state.lock();
        state
            .files
            .values()
            .filter(|s| matches!(s, SourceState::Opening(_)))
            .count()
    }

    /// Whether a file was opened or refused since the last call.
    pub(crate) fn take_changed(&self) -> bool {
        std::mem::take(&mut self.shared.state.lock().changed)
    }

    /// Waits until a file is opened or refused, or the time is over.
    pub(crate) fn wait(&self, timeout: Duration) {
        let mut state = self.shared.state.lock();
        if !state.changed {
            self.shared.settled.wait_for(&mut state, timeout);
        }
    }
}

impl Drop for Sources {
    fn drop(&mut self) {
        self.shared.cancel.cancel();
        self.requests = None;
        for thread in self.threads.drain(..) {
            if thread.join().is_err() {
                tracing::error!("a thread that opens files ended by a panic");
            }
        }
    }
}

impl Shared {
    fn open_all(self: &Arc<Self>, requests: &Receiver<Request>) {
        for request in requests {
            if self.cancel.is_cancelled() {
                return;
            }
            let key = request.key;
            let opened = self.open(&key, &request.source, request.bands);
            let mut state = self.state.lock();
            if let Some(slot) = state.files.get_mut(&key) {
                *slot = match opened {
                    Ok(file) => SourceState::Open(file),
                    Err(reason) => SourceState::Failed(reason),
                };
                state.changed = true;
            }
            drop(state);
            self.settled.notify_all();
            self.wake();
        }
    }

    fn open(
        self: &Arc<Self>,
        key: &SourceKey,
        source: &Source,
        bands: Option<Vec<u16>>,
    ) -> Result<Arc<dyn RasterFile>, String> {
        let progress = {
            let (shared, key) = (Arc::clone(self), key.clone());
            move |done: f32| {
                if let Some(state) = shared.state.lock().files.get_mut(&key) {
                    *state = SourceState::Opening(done);
                }
                shared.wake();
            }
        };
        let mut options = OpenOptions {
            cache_dir: self.cache_folder.clone(),
            progress: Some(Arc::new(progress)),
            cancel: self.cancel.clone(),
            chunk_cache: Arc::clone(&self.chunks),
            as_bands: Some(key.bands),
            // People count bands from 1.
            select: bands.map(|b| b.into_iter().map(|n| n.saturating_sub(1)).collect()),
            nodata: source.nodata,
            ..OpenOptions::default()
        };
        if let Some(place) = &source.georeference {
            Self::place(&mut options, place, &key.path)?;
        }
        let file = open(&key.path, &options).map_err(|e| e.to_string())?;
        if file.info().georeference.is_none() {
            return Err(format!(
                "expected a place on the planet, found no georeference; give the layer an extent: \"{}\"",
                key.path.display()
            ));
        }
        Ok(file)
    }

    /// Turns what the project says of a file's place into what the reader takes.
    fn place(options: &mut OpenOptions, place: &Georeference, path: &Path) -> Result<(), String> {
        let Some(extent) = place.extent else {
            options.crs = place.crs.as_deref().map(Arc::from);
            return Ok(());
        };
        // The extent is one of outer edges, so the size in pixels is needed first.
        let probe = OpenOptions {
            make_pyramid: false,
            ..options.clone()
        };
        let file = open(path, &probe).map_err(|e| e.to_string())?;
        let full = file.info().overviews[0];
        let (dx, dy) = (
            (extent.east - extent.west) / f64::from(full.width),
            (extent.south - extent.north) / f64::from(full.height),
        );
        let own = file
            .info()
            .georeference
            .as_ref()
            .map(|g| Arc::clone(&g.crs));
        let crs = place.crs.as_deref().map(Arc::from).or(own);
        options.georeference = Some(relievo_raster::file::Georeference {
            crs: crs.unwrap_or_else(|| Arc::from("EPSG:4326")),
            plane_from_pixel: [extent.west, dx, 0.0, extent.north, 0.0, dy],
        });
        Ok(())
    }

    fn wake(&self) {
        if let Some(wake) = &self.wake {
            wake();
        }
    }
}

/// The file of a layer and how it is read.
fn request_of(kind: &LayerKind, folder: &Path) -> Option<(SourceKey, Source, Option<Vec<u16>>)> {
    let (source, bands, chosen) = match kind {
        LayerKind::Imagery(l) => (&l.source, Bands::Colour, l.bands.clone()),
        LayerKind::Height(l) => (&l.source, Bands::Height, l.band.map(|b| vec![b])),
        LayerKind::Noise(_) | LayerKind::Tint(_) | LayerKind::Unknown { .. } => return None,
    };
    let place = source.georeference.as_ref();
    let (crs, extent) = (
        place.and_then(|g| g.crs.as_deref()),
        place.and_then(|g| g.extent),
    );
    let key = SourceKey {
        path: resolve_path(folder, &source.path),
        bands,
        options: format!("{crs:?} {extent:?} {:?} {chosen:?}", source.nodata),
    };
    Some((key, source.clone(), chosen))
}
