//! What other threads have to say: chosen files, what they hold, pictures that are saved.
//!
//! The thread that draws never opens a file dialog or a raster file itself.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use eframe::egui;
use relievo_engine::OpenFeatures;
use relievo_engine::project::{
    self, Abandoned, ClassedBy, FileStamp, LayerId, Project, Recovery, SourceRole, abandoned,
    is_unchanged,
};
use relievo_engine::raster::Bands;
use relievo_engine::raster::open::{OpenOptions, open};
use relievo_engine::relink::{self, Link};
use relievo_engine::vector::is_vector;
use relievo_gpu::Picture;

use super::analysis::Export;
use super::classes::{self, Recipe};
use crate::picture;

/// A dialog that ends sooner was never shown: no portal, no desktop.
const UNSEEN: Duration = Duration::from_millis(400);

/// Wakes the window from any thread.
#[derive(Clone, Debug, Default)]
pub(crate) struct Waker(Arc<Mutex<Option<egui::Context>>>);

impl Waker {
    /// Wakes this window from now on.
    pub(crate) fn attach(&self, ctx: &egui::Context) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(ctx.clone());
    }

    /// Asks for a frame.
    pub(crate) fn wake(&self) {
        let ctx = self
            .0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone();
        if let Some(ctx) = ctx {
            ctx.request_repaint();
        }
    }
}

/// What files are asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// To open as a project.
    Open,
    /// To save the project to.
    Save,
    /// To add as layers.
    Add,
    /// To save the picture to.
    Picture,
    /// To link a layer to.
    Locate,
    /// To write what was measured to.
    Export(Export),
}

/// Something that happened on another thread.
#[derive(Debug)]
pub(crate) enum Event {
    /// Files were chosen; none: the dialog was closed.
    Picked {
        /// What for.
        purpose: Purpose,
        /// Which.
        paths: Vec<PathBuf>,
        /// Whether there was a dialog at all.
        seen: bool,
    },
    /// What files to add hold, or one line that says why one cannot be used.
    Looked(Vec<(PathBuf, Result<SourceRole, String>)>),
    /// A layer's file was located; others that were missing lie beside it.
    Located {
        /// The layer and its file.
        link: Link,
        /// The others and theirs.
        beside: Vec<Link>,
    },
    /// Another program changed a project's file.
    ProjectChanged(PathBuf),
    /// Which of the recent projects are not there.
    Missing(Vec<PathBuf>),
    /// Untitled projects of runs that did not end well, with the number of edits of each.
    Abandoned(Vec<(Abandoned, usize)>),
    /// Classes of a vector layer were made, or one line that says why not.
    Classified(LayerId, Result<ClassedBy, String>),
    /// A picture was saved.
    PictureSaved(Result<PathBuf, String>),
}

/// Events of all threads, and the doors to them.
#[derive(Debug, Default)]
pub(crate) struct Inbox {
    events: Arc<Mutex<Vec<Event>>>,
    waker: Waker,
    picking: Arc<AtomicBool>,
}

impl Inbox {
    /// An inbox that wakes the window.
    pub(crate) fn new(waker: Waker) -> Self {
        Self {
            waker,
            ..Self::default()
        }
    }

    /// Everything that came since the last call.
    pub(crate) fn take(&self) -> Vec<Event> {
        std::mem::take(&mut *self.events.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Shows the system's file dialog; only one at a time.
    pub(crate) fn pick(&self, purpose: Purpose, start: Option<PathBuf>) {
        if self.picking.swap(true, Ordering::AcqRel) {
            return;
        }
        let mut dialog = rfd::AsyncFileDialog::new();
        if let Some(start) = start {
            dialog = match (start.parent(), start.file_name()) {
                (Some(folder), Some(name))
                    if matches!(
                        purpose,
                        Purpose::Save | Purpose::Picture | Purpose::Export(_)
                    ) =>
                {
                    dialog
                        .set_directory(folder)
                        .set_file_name(name.to_string_lossy())
                }
                (Some(folder), _) => dialog.set_directory(folder),
                (None, _) => dialog,
            };
        }
        let picking = Arc::clone(&self.picking);
        let work = move || {
            let asked = Instant::now();
            let paths = pollster::block_on(ask(purpose, dialog));
            picking.store(false, Ordering::Release);
            Event::Picked {
                purpose,
                seen: !paths.is_empty() || asked.elapsed() > UNSEEN,
                paths,
            }
        };
        if !self.work("relievo-dialog", work) {
            self.picking.store(false, Ordering::Release);
        }
    }

    /// Looks what files hold that shall become layers.
    pub(crate) fn look_at(&self, paths: Vec<PathBuf>) {
        self.work("relievo-look", move || {
            let look = |path: PathBuf| {
                if is_vector(&path) {
                    return (path, Ok(SourceRole::Vector));
                }
                let options = OpenOptions {
                    make_pyramid: false,
                    ..OpenOptions::default()
                };
                let role = open(&path, &options)
                    .map_err(|e| e.to_string())
                    .map(|file| match file.info().bands {
                        Bands::Height => SourceRole::Height,
                        Bands::Colour | Bands::Mask | Bands::Normal => SourceRole::Imagery,
                    });
                (path, role)
            };
            Event::Looked(paths.into_iter().map(look).collect())
        });
    }

    /// Looks whether files that other layers miss lie beside the one that was chosen for a layer.
    pub(crate) fn look_beside(&self, link: Link, project: Project, folder: PathBuf) {
        self.work("relievo-locate", move || {
            let mut missing = relink::missing(&project, &folder);
            missing.retain(|other| other.layer != link.layer);
            let beside = match link.file.parent() {
                Some(folder) => relink::found_in(folder, &missing),
                None => Vec::new(),
            };
            Event::Located { link, beside }
        });
    }

    /// Looks whether a project's file still is what it was; says so only if it is not.
    pub(crate) fn look_at_project(&self, path: PathBuf, stamp: FileStamp) {
        let (events, waker) = (Arc::clone(&self.events), self.waker.clone());
        let run = move || {
            // One that cannot be read now is told when it is saved.
            if matches!(is_unchanged(&path, stamp), Ok(false)) {
                let mut events = events.lock().unwrap_or_else(PoisonError::into_inner);
                events.push(Event::ProjectChanged(path));
                waker.wake();
            }
        };
        let thread = std::thread::Builder::new().name("relievo-file".to_owned());
        if let Err(error) = thread.spawn(run) {
            tracing::error!("cannot start the thread relievo-file: {error}");
        }
    }

    /// Looks which projects are not there.
    pub(crate) fn look_for(&self, projects: Vec<PathBuf>) {
        self.work("relievo-recent", move || {
            let missing = projects.into_iter().filter(|p| !p.is_file());
            Event::Missing(missing.collect())
        });
    }

    /// Looks for untitled projects of runs that did not end well.
    pub(crate) fn look_for_abandoned(&self, state_folder: PathBuf) {
        self.work("relievo-abandoned", move || {
            let counted = |found: Abandoned| {
                let (_, stamp) = project::open(&found.path).ok()?;
                let recovery = Recovery::find(&found.path, stamp, Some(&state_folder)).ok()??;
                Some((found, recovery.edits().len()))
            };
            let all = abandoned(&state_folder).into_iter();
            Event::Abandoned(all.filter_map(counted).collect())
        });
    }

    /// Makes classes of a vector layer's features.
    pub(crate) fn classify(&self, id: LayerId, open: Arc<OpenFeatures>, recipe: Recipe) {
        self.work("relievo-classes", move || {
            Event::Classified(id, classes::make(&open.features, &recipe))
        });
    }

    /// Writes a picture.
    pub(crate) fn save_picture(&self, path: PathBuf, picture: Picture) {
        self.work("relievo-picture", move || {
            let written = picture::write(&path, &picture);
            Event::PictureSaved(written.map(|()| path).map_err(|e| e.to_string()))
        });
    }

    /// Does work on a thread of its own; `false` when the system refuses one.
    fn work(&self, name: &str, work: impl FnOnce() -> Event + Send + 'static) -> bool {
        let (events, waker) = (Arc::clone(&self.events), self.waker.clone());
        let run = move || {
            let event = work();
            events
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .push(event);
            waker.wake();
        };
        let spawned = std::thread::Builder::new().name(name.to_owned()).spawn(run);
        if let Err(error) = &spawned {
            tracing::error!("cannot start the thread {name}: {error}");
        }
        spawned.is_ok()
    }
}

async fn ask(purpose: Purpose, dialog: rfd::AsyncFileDialog) -> Vec<PathBuf> {
    let project = |d: rfd::AsyncFileDialog| d.add_filter("Relievo project", &["relievo"]);
    let one = |file: Option<rfd::FileHandle>| file.iter().map(|f| f.path().to_owned()).collect();
    match purpose {
        Purpose::Open => one(project(dialog).set_title("Open project").pick_file().await),
        Purpose::Save => one(project(dialog).set_title("Save project").save_file().await),
        Purpose::Picture => one(dialog
            .add_filter("PNG", &["png"])
            .set_title("Save picture")
            .save_file()
            .await),
        Purpose::Export(export) => one(dialog
            .add_filter(export.extension(), &[export.extension()])
            .set_title(export.title())
            .save_file()
            .await),
        Purpose::Locate => one(dialog
            .set_title("Locate the layer's file")
            .pick_file()
            .await),
        Purpose::Add => {
            let images = [
                "tif", "tiff", "jpg", "jpeg", "png", "webp", "exr", "hgt", "asc", "mbtiles",
                "pmtiles",
            ];
            let files = dialog
                .add_filter("Raster files", &images)
                .set_title("Add files")
                .pick_files()
                .await;
            files
                .unwrap_or_default()
                .iter()
                .map(|f| f.path().to_owned())
                .collect()
        }
    }
}
