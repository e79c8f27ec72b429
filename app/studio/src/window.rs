//! The window: a studio around one engine.
//!
//! ```text
//! panels --Action--> Studio --Edit--> Document (engine) --drain--> Frame --> Stage (GPU) --> viewport
//! pointer, keys --> Navigation --> Camera --set_view--^
//! ```
//!
//! Invariant: panels read the project and ask for actions; only the studio carries them out, between
//! frames. The thread that draws never makes a tile and never waits for one.

mod action;
mod analysis;
mod bookmarks;
mod classes;
mod compare;
mod controls;
mod dialogs;
mod document;
mod elements;
mod governor;
mod graph;
mod histogram;
mod history;
mod inbox;
mod inspector;
mod latest;
mod layers;
mod matching;
mod messages;
mod navigation;
mod pace;
mod palette;
mod panes;
mod place;
mod probe;
mod profile;
mod recent;
mod remembered;
mod scenarios;
mod scene;
mod settings;
mod stage;
mod start;
mod statistics;
mod status;
mod studio;
mod theme;
mod tools;
mod trade;
mod viewport;
mod waiting;

use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::Rc;

use eframe::egui;
use relievo_engine::OpenError;
use relievo_engine::raster::Cancel;

use crate::cli::Cache;

pub use compare::Mode;
pub use document::Document;
pub use navigation::Navigation;
pub use panes::Pane;
pub use studio::{Studio, StudioOptions};
pub use tools::Tool;

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
pub enum OpenWindowError {
    /// The project cannot be opened: one line.
    #[error("{0}")]
    Project(String),
    /// No display, no graphics adapter, no threads: one line.
    #[error("{0}")]
    System(String),
}

/// Opens the studio on a project, or on an empty Earth, and returns when it is closed or `cancel` is
/// asked for; changes that are not saved are then asked about as ever.
///
/// # Errors
/// [`OpenWindowError`] when the project cannot be opened or the system has no place for a window.
pub fn open(
    project: Option<PathBuf>,
    threads: Option<usize>,
    cache: Cache,
    cancel: &Cancel,
) -> Result<(), OpenWindowError> {
    let options = StudioOptions {
        threads,
        cache_folder: cache.folder,
        disk_cache: cache.bytes,
        ..StudioOptions::default()
    };
    let mut studio = Studio::new(options).map_err(|e| OpenWindowError::System(e.to_string()))?;
    if let Some(path) = project {
        studio.open_project(&path).map_err(|error| match error {
            OpenError::Project(_) => OpenWindowError::Project(error.to_string()),
            OpenError::Threads(_) => OpenWindowError::System(error.to_string()),
        })?;
    }
    studio
        .close_when(cancel)
        .map_err(|e| OpenWindowError::System(e.to_string()))?;
    let studio = Rc::new(RefCell::new(studio));
    loop {
        let shared = Rc::clone(&studio);
        let create = Box::new(move |cc: &eframe::CreationContext<'_>| {
            shared.borrow_mut().attach(cc);
            Ok(Box::new(Window(shared)) as Box<dyn eframe::App>)
        });
        eframe::run_native("Relievo", native_options(), create)
            .map_err(|e| OpenWindowError::System(no_window(&e)))?;
        // A window whose device is lost cannot draw itself any more: another takes its place.
        if !studio.borrow_mut().take_restart() {
            studio.borrow_mut().finish();
            return Ok(());
        }
    }
}

fn native_options() -> eframe::NativeOptions {
    eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_inner_size([1280.0, 860.0])
            .with_min_inner_size([640.0, 420.0])
            .with_app_id("relievo")
            .with_title("Relievo"),
        renderer: eframe::Renderer::Wgpu,
        wgpu_options: stage::wgpu_options(),
        ..eframe::NativeOptions::default()
    }
}

/// What a failure to open a window means, in one line.
fn no_window(error: &eframe::Error) -> String {
    // What comes before the last colon are places in the source of libraries.
    let text = error.to_string();
    let text = text.rsplit(": ").next().unwrap_or(&text);
    let hint = if matches!(error, eframe::Error::Wgpu(_)) {
        "; install a graphics driver (on Debian libvulkan1 and mesa-vulkan-drivers), or use `relievo render`"
    } else {
        "; the studio needs a display, `relievo render` does not"
    };
    format!("cannot open a window: {text}{hint}")
}

/// What eframe draws: the studio, which outlives windows.
struct Window(Rc<RefCell<Studio>>);

impl eframe::App for Window {
    fn ui(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) {
        self.0.borrow_mut().ui(ui, frame);
    }
}
