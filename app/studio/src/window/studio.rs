//! The studio: what the window holds from frame to frame.

mod answers;
mod carry_out;
mod device;
mod docked;
mod elements;
mod files;
mod frame;
mod keeping;
mod layer_edits;
mod menus;
mod opening;
mod possible;

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use eframe::egui::Ui;
use eframe::egui_wgpu::RenderState;
use relievo_engine::planet::{Camera, MapPoint};
use relievo_engine::project::{Abandoned, ElementId, FileStamp, LayerId, Recovery};
use relievo_engine::raster::Cancel;
use relievo_engine::{DEFAULT_DISK_CACHE_BYTES, EngineOptions, default_cache_folder};
use relievo_gpu::Front;

use super::analysis::Analyses;
use super::bookmarks::Bookmarks;
use super::compare::Compare;
use super::dialogs::{Dialog, Then};
use super::document::Document;
use super::governor::Governor;
use super::graph::GraphView;
use super::histogram::Histograms;
use super::inbox::{Inbox, Waker};
use super::inspector::{ElementForm, Inspector};
use super::matching::Matching;
use super::messages::Log;
use super::navigation::Navigation;
use super::pace::Pace;
use super::palette::Palette;
use super::panes::{Layout, Pane};
use super::probe::Probe;
use super::profile::Profiles;
use super::recent::{self, Recent};
use super::scenarios::Scenarios;
use super::settings::Settings;
use super::stage::Stage;
use super::start;
use super::status::{Notation, Status};
use super::tools::Tools;

/// How often files of the project are looked at.
const WATCH: Duration = Duration::from_secs(1);

/// How a studio works.
#[derive(Clone, Debug)]
pub struct StudioOptions {
    /// Threads that make tiles; `None`: all cores but one.
    pub threads: Option<usize>,
    /// Where pyramids of big images and finished tiles are kept; `None`: nowhere.
    pub cache_folder: Option<PathBuf>,
    /// Most that finished tiles take there, in bytes.
    pub disk_cache: u64,
    /// Where the list of recent projects is kept; `None`: nowhere.
    pub state_folder: Option<PathBuf>,
    /// Whether files are chosen in the system's dialogs; otherwise their paths are typed.
    pub file_dialogs: bool,
}

impl Default for StudioOptions {
    /// All cores but one, the user's folders.
    fn default() -> Self {
        Self {
            threads: None,
            cache_folder: default_cache_folder(),
            disk_cache: DEFAULT_DISK_CACHE_BYTES,
            state_folder: recent::default_state_folder(),
            file_dialogs: true,
        }
    }
}

/// A drag of a control.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Dragging {
    #[default]
    No,
    /// Its edits become one undo step.
    Yes,
    /// It was taken back; what it still says is ignored until the button is up.
    TakenBack,
}

/// The window's content.
pub struct Studio {
    options: StudioOptions,
    waker: Waker,
    pub(super) document: Document,
    pub(super) navigation: Navigation,
    pub(super) stage: Option<Stage>,
    pub(super) stage_error: Option<String>,
    pub(super) selected: Option<LayerId>,
    pub(super) selected_element: Option<ElementId>,
    inspector: Inspector,
    element_form: ElementForm,
    bookmarks: Bookmarks,
    scenarios: Scenarios,
    pub(super) tools: Tools,
    pub(super) compare: Option<Compare>,
    /// The window's device.
    pub(super) render_state: Option<RenderState>,
    pub(super) layout: Layout,
    settings: Settings,
    palette: Option<Palette>,
    pub(super) histograms: Histograms,
    pub(super) matching: Matching,
    graph: GraphView,
    pub(super) profiles: Profiles,
    pub(super) analyses: Analyses,
    /// A place that another pane points at.
    pub(super) marked: Option<MapPoint>,
    /// Width over height of the view.
    pub(super) aspect: f64,
    pub(super) dialog: Option<Dialog>,
    pub(super) inbox: Inbox,
    pub(super) probe: Probe,
    pub(super) status: Status,
    notation: Notation,
    pub(super) log: Log,
    pub(super) dragging: Dragging,
    pub(super) pace: Pace,
    pub(super) governor: Governor,
    /// The camera of the picture that is shown.
    pub(super) drawn_camera: Option<Camera>,
    /// The layer whose file is being located.
    pub(super) locating: Option<LayerId>,
    pub(super) recent: Recent,
    /// Projects that come with the program.
    pub(super) samples: Vec<PathBuf>,
    /// What happens once a save under a new name has succeeded.
    pub(super) after_save: Option<Then>,
    /// The window may close without a question.
    pub(super) closing: bool,
    /// Edits of a run that did not end well, until somebody says what becomes of them.
    offer: Option<Recovery>,
    /// Untitled projects that are offered, with the number of edits of each.
    abandoned: Vec<(Abandoned, usize)>,
    /// The state of the file about whose change the user was asked.
    told_changed: Option<FileStamp>,
    restart: bool,
    /// The stage's windows do not fit the project's quality any more.
    refit: bool,
    /// Largest colour windows that the device has room for, as far as is known.
    pub(super) most_window: u32,
    /// Asks the window to close, once.
    interrupted: Option<Cancel>,
    title: String,
}

impl Studio {
    /// A studio with an empty Earth, without a window yet.
    ///
    /// # Errors
    /// When the system refuses threads.
    pub fn new(options: StudioOptions) -> std::io::Result<Self> {
        let waker = Waker::default();
        let mut document = Document::empty(engine_options(&options, &waker))?;
        document.guard_untitled(options.state_folder.as_deref());
        let (settings, layout) = Settings::load(options.state_folder.as_deref());
        Ok(Self {
            navigation: Navigation::new(document.project().camera.to_camera()),
            document,
            stage: None,
            stage_error: None,
            selected: None,
            selected_element: None,
            inspector: Inspector::default(),
            element_form: ElementForm::default(),
            bookmarks: Bookmarks::default(),
            scenarios: Scenarios::default(),
            tools: Tools::default(),
            compare: None,
            render_state: None,
            layout,
            settings,
            palette: None,
            histograms: Histograms::new("relievo-histogram", waker.clone())?,
            matching: Matching::new(waker.clone())?,
            graph: GraphView::default(),
            profiles: Profiles::new("relievo-profile", waker.clone())?,
            analyses: Analyses::new(&waker)?,
            marked: None,
            aspect: 1.0,
            dialog: None,
            inbox: Inbox::new(waker.clone()),
            probe: Probe::new("relievo-probe", waker.clone())?,
            status: Status::default(),
            notation: Notation::default(),
            log: Log::default(),
            dragging: Dragging::No,
            pace: Pace::default(),
            governor: Governor::new(Front::measured()),
            drawn_camera: None,
            locating: None,
            recent: Recent::load(options.state_folder.as_deref()),
            samples: start::samples(),
            after_save: None,
            closing: false,
            offer: None,
            abandoned: Vec::new(),
            told_changed: None,
            restart: false,
            refit: false,
            most_window: u32::MAX,
            interrupted: None,
            title: String::new(),
            options,
            waker,
        })
    }

    /// The open project.
    pub fn document(&self) -> &Document {
        &self.document
    }

    /// How engines of this window work.
    pub(super) fn engine_options(&self) -> EngineOptions {
        engine_options(&self.options, &self.waker)
    }

    /// What wakes this window.
    pub(super) fn waker(&self) -> Waker {
        self.waker.clone()
    }

    /// How coordinates are written.
    pub(super) fn notation(&self) -> Notation {
        self.notation
    }

    /// The viewer.
    pub fn camera(&self) -> &Camera {
        self.navigation.camera()
    }

    /// Whether a pane is shown and not behind another.
    pub fn shows(&self, pane: Pane) -> bool {
        self.layout.is_in_front(pane)
    }

    /// The selected layer.
    pub fn selected(&self) -> Option<&LayerId> {
        self.selected.as_ref()
    }

    /// Turns north up around the middle of the picture.
    pub(super) fn north_up(&mut self) {
        let planet = self.document.project().planet.body.figure();
        let (here_m, middle) = (self.ground_below_m(), self.middle());
        self.navigation.north_up(&planet, here_m, middle);
    }
}

impl eframe::App for Studio {
    fn ui(&mut self, ui: &mut Ui, frame: &mut eframe::Frame) {
        self.one_frame(ui, frame);
    }
}

fn engine_options(options: &StudioOptions, waker: &Waker) -> EngineOptions {
    let waker = waker.clone();
    EngineOptions {
        threads: options.threads,
        cache_folder: options.cache_folder.clone(),
        disk_cache: options.disk_cache,
        wake: Some(Arc::new(move || waker.wake())),
        watch: Some(WATCH),
        tally: true,
        ..EngineOptions::default()
    }
}
