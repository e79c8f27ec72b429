//! The engine: one project, its revisions, one view.

mod ahead;
mod asking;
mod bodies;
mod edited;
mod edits;
mod exaggeration;
mod follow;
mod keeping;
mod leaving_out;
mod moments;
mod options;
mod overlays;
mod picture;
mod planning;
mod revisions;
mod survey;
mod tally;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use glam::DVec3;
use parking_lot::Mutex;
use relievo_graph::ContentId;
use relievo_planet::MapPoint;
use relievo_planet::clipmap::plan::HeightRange;
use relievo_planet::clipmap::{Plan, Planner};
use relievo_project::{History, Project, ScenarioId};
use relievo_tiles::{LogEntry, TileState, Tiles};
use rustc_hash::{FxHashMap, FxHashSet};

use self::ahead::Ahead;
pub use self::keeping::Guarded;
pub use self::options::{
    DEFAULT_DISK_CACHE_BYTES, EngineOptions, EngineStats, Kept, OpenError, default_cache_folder,
    default_state_folder, folder_of,
};
pub(crate) use self::picture::{air, sun};
use self::planning::PlanQuery;
use self::tally::Tally;
pub use self::tally::{Made, NodeReport};
use crate::compile::{self, NodeCache};
use crate::difference::HeightDifference;
use crate::frame::{ClipKind, Frame};
use crate::labels::LabelCache;
use crate::marks::Mark;
use crate::masses::making::Bodies;
use crate::message::{Message, Messages};
use crate::query::{Questions, WITHOUT_DETAIL};
use crate::residency::Stack;
use crate::scenarios::as_shown;
use crate::scene::Scene;
use crate::sources::Sources;
use crate::terrain::{self, Bounds};
use crate::view::View;

/// Copies into textures in one frame, so that a burst of finished tiles does not make one frame long.
const UPLOADS_PER_FRAME: usize = 96;

/// One project, edited and shown.
pub struct Engine {
    project: Project,
    history: History,
    keeper: Option<keeping::Keeper>,
    folder: PathBuf,
    sources: Sources,
    nodes: NodeCache,
    pub(crate) label_cache: LabelCache,
    tiles: Tiles,
    tally: Option<Tally>,
    messages: Messages,
    edited: edited::Edited,
    difference: Option<(Option<ScenarioId>, HeightDifference)>,
    synthesised: overlays::Synthesised,
    /// What lies over the project's colours.
    marks: Vec<Mark>,
    revisions: u64,
    /// Drags so far, and what was there before the latest.
    drags: u64,
    before_drag: Option<Arc<Scene>>,
    /// Counts what happened to files.
    file_news: u64,
    shown: Arc<Scene>,
    /// The revision that is being made, and the edit that waits behind it.
    making: Option<Arc<Scene>>,
    stale: bool,
    view: Option<View>,
    planner: Planner,
    /// Finest levels n of heights and colours that the data is worth near the focus.
    finest: (u8, u8),
    /// What they were found for: a revision, a focus, samples of the windows.
    finest_for: Option<(u64, MapPoint, [u32; 2])>,
    ahead: Ahead,
    /// Tiles asked for along the path, at most.
    prefetch: usize,
    plan: Option<Arc<Plan>>,
    planned_for: Option<PlanQuery>,
    /// The ground that the plan was made for.
    planned_on: (Bounds, f64),
    stacks: Stacks,
    /// Finished tiles that no window has taken yet.
    arrived: FxHashMap<ContentId, TileState>,
    asked: FxHashSet<ContentId>,
    /// Those of them that the shown revision reads too: they are shown as they come.
    asked_for_shown: FxHashSet<ContentId>,
    dirty: bool,
    pending: usize,
    /// Bodies on the ground, while some layer has any.
    bodies: Option<Bodies>,
    /// What is odd about planning elements on their ground.
    survey: survey::Survey,
    wake: Option<Arc<dyn Fn() + Send + Sync>>,
    /// Layers that decide nothing visible, as found out last.
    unseen: Mutex<Option<leaving_out::Unseen>>,
    /// A visible tile waits for a file to be opened again.
    stuck: bool,
}

struct Stacks {
    height: Stack,
    colour: Stack,
    normal: Stack,
}

impl Stacks {
    fn each_mut(&mut self) -> [(ClipKind, &mut Stack); 3] {
        [
            (ClipKind::Height, &mut self.height),
            (ClipKind::Colour, &mut self.colour),
            (ClipKind::Normal, &mut self.normal),
        ]
    }

    fn get(&self, kind: ClipKind) -> &Stack {
        match kind {
            ClipKind::Height => &self.height,
            ClipKind::Colour => &self.colour,
            ClipKind::Normal => &self.normal,
        }
    }
}

impl Engine {
    /// An engine on a project whose relative paths start at `folder`.
    ///
    /// # Errors
    /// When the system refuses a thread.
    pub fn new(project: Project, folder: &Path, options: EngineOptions) -> std::io::Result<Self> {
        let tile_options = options.tiles();
        let tally = (options.tally && !options.log).then(Tally::default);
        let prefetch = asking::prefetch_for(options.memory);
        let wake = options.wake.clone();
        let sources = Sources::new(options.cache_folder, options.wake, options.watch)?;
        let nodes = NodeCache::default();
        let label_cache = LabelCache::default();
        let nothing = compile::Wish::default();
        let empty = compile::compile(&Project::default(), folder, &sources, &nodes, &nothing);
        let engine = Self {
            project,
            history: History::default(),
            keeper: None,
            folder: folder.to_owned(),
            sources,
            nodes,
            label_cache,
            tiles: Tiles::new(tile_options)?,
            tally,
            messages: Messages::default(),
            edited: edited::Edited::default(),
            difference: None,
            synthesised: overlays::Synthesised::default(),
            marks: Vec::new(),
            revisions: 0,
            drags: 0,
            before_drag: None,
            file_news: 0,
            shown: Arc::new(empty.into_scene(0, None)),
            making: None,
            stale: true,
            view: None,
            planner: Planner::default(),
            finest: (0, 0),
            finest_for: None,
            ahead: Ahead::default(),
            prefetch,
            plan: None,
            planned_for: None,
            planned_on: (
                Bounds(HeightRange {
                    min_m: 0.0,
                    max_m: 0.0,
                }),
                0.0,
            ),
            stacks: Stacks {
                height: Stack::new(ClipKind::Height),
                colour: Stack::new(ClipKind::Colour),
                normal: Stack::new(ClipKind::Normal),
            },
            arrived: FxHashMap::default(),
            asked: FxHashSet::default(),
            asked_for_shown: FxHashSet::default(),
            dirty: true,
            pending: 0,
            unseen: Mutex::default(),
            stuck: false,
            bodies: None,
            survey: survey::Survey::default(),
            wake,
        };
        engine.sources.require(&engine.project, &engine.folder);
        Ok(engine)
    }

    /// The project as it is now.
    pub fn project(&self) -> &Project {
        &self.project
    }

    /// The folder that relative paths start at.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Undo and redo: what they would do, and whether they can.
    pub fn history(&self) -> &History {
        &self.history
    }

    /// Tries files and tiles again that failed before.
    pub fn retry(&mut self) {
        self.sources.forget_failures();
        self.forget_failed_tiles();
        self.sources.require(&self.project, &self.folder);
        self.messages.clear();
        self.stale = true;
    }

    /// Looks at all files once, as happens every [`EngineOptions::watch`]. When two looks agree that
    /// a file changed on disk it is opened again. Reads no samples, but may take long where a
    /// network does not answer.
    pub fn look_at_files(&self) {
        self.sources.look();
    }

    /// Sets what the picture is seen through. Returns at once.
    pub fn set_view(&mut self, view: View) {
        if self.view != Some(view) {
            self.view = Some(view);
            self.dirty = true;
        }
    }

    /// Everything uploaded is lost (another device): all comes again.
    pub fn forget_uploads(&mut self) {
        for (_, stack) in self.stacks.each_mut() {
            stack.clear();
        }
        self.plan = None;
        self.planner = Planner::default();
        self.dirty = true;
    }

    /// One step: takes finished tiles, publishes a finished revision, plans, asks for what is
    /// missing, and says what to upload and draw. Never waits. `dt_s` is the time since the last
    /// call, infinite for stills; `None` until a view is set.
    pub fn drain(&mut self, dt_s: f32) -> Option<Frame> {
        let view = self.view?;
        self.count_made();
        self.take_finished();
        self.recompile();
        let mut uploads = Vec::new();
        let ready = self
            .making
            .as_ref()
            .is_some_and(|scene| self.is_ready(scene));
        if ready {
            self.publish();
        }
        self.replan(&view);
        self.tell_exaggeration();
        self.observe(&view, dt_s);
        let mut budget = if ready || dt_s.is_infinite() {
            usize::MAX
        } else {
            UPLOADS_PER_FRAME
        };
        let left = self.update_windows(&mut budget, &mut uploads, dt_s);
        self.ask(!dt_s.is_infinite());
        self.dirty |= left;
        // New heights can move the focus and uncover ground, and windows take their final shape step by
        // step: the plan must fit what it led to.
        self.dirty |= self.plan.as_ref().is_some_and(|p| !p.settled);
        if uploads.iter().any(|u| u.clipmap == ClipKind::Height)
            && self.ground(&view) != self.planned_on
        {
            self.dirty = true;
        }
        let masses = self.bodies(&view);
        self.survey();
        Some(self.frame(&view, uploads, masses))
    }

    /// Waits until a finished tile or an opened file is there to drain, or the time is over; `true`
    /// when all work that was asked for is done. For offline work only.
    pub fn wait(&self, timeout: Duration) -> bool {
        if self.sources.opening() > 0 {
            self.sources.wait(timeout.min(Duration::from_millis(50)));
            return false;
        }
        match &self.bodies {
            Some(bodies) if bodies.pending() > 0 => {
                bodies.wait(timeout.min(Duration::from_millis(50)));
                false
            }
            Some(_) | None => self.tiles.wait(timeout),
        }
    }

    /// Whether files are still being opened or a revision is being made.
    pub fn is_busy(&self) -> bool {
        self.stale || self.making.is_some() || self.sources.opening() > 0
    }

    /// Waits until every file is open or refused. For offline work only.
    pub fn wait_for_sources(&mut self) {
        while self.sources.opening() > 0 {
            self.sources.wait(Duration::from_millis(100));
        }
        self.hear_of_sources();
        self.stale = true;
        self.recompile();
    }

    /// The project as it is now, with every file that is open, for questions that are asked of it on
    /// any thread while it may change here.
    pub fn questions(&self) -> Questions {
        self.questions_in(self.project.scenario.as_ref())
    }

    /// What measurements leave out of the ground that is shown, in a sentence; `None` if they leave out
    /// nothing. Of the revision on the screen: it may be asked every frame.
    pub fn left_out_of_measures(&self) -> Option<&'static str> {
        self.shown.is_synthesised().then_some(WITHOUT_DETAIL)
    }

    /// As [`Self::questions`], of a scenario that need not be shown; `None` is the base.
    pub fn questions_in(&self, scenario: Option<&ScenarioId>) -> Questions {
        let scene = |project: &Project| {
            let wish = compile::Wish::default();
            let compiled =
                compile::compile(project, &self.folder, &self.sources, &self.nodes, &wish);
            Arc::new(compiled.into_scene(0, None))
        };
        let shown = as_shown(&self.project, scenario);
        let whole = scene(&shown);
        Questions {
            surveyed: if whole.is_synthesised() {
                scene(&compile::without_detail(&shown))
            } else {
                Arc::clone(&whole)
            },
            scene: whole,
            planet: self.project.planet.body.figure(),
        }
    }

    /// Counts how often files were opened, refused or changed: with as many edits answers are the same.
    pub fn file_news(&self) -> u64 {
        self.file_news
    }

    /// The files behind the layers.
    pub fn sources(&self) -> &Sources {
        &self.sources
    }

    /// What users should know, each once, newest last.
    pub fn messages(&self) -> &[Message] {
        self.messages.all()
    }

    /// Which tiles were made since the last call; empty unless asked for in the options.
    pub fn take_log(&self) -> Vec<LogEntry> {
        self.tiles.take_log()
    }

    /// What the engine is doing and did.
    pub fn stats(&self) -> EngineStats {
        EngineStats {
            tiles: self.tiles.stats(),
            pending: self.pending,
            opening: self.sources.opening(),
            busy_ns: self.tiles.busy().as_nanos(),
            kept: self.kept(),
        }
    }

    fn kept(&self) -> Kept {
        let stacks = [
            &self.stacks.height,
            &self.stacks.colour,
            &self.stacks.normal,
        ];
        let making = self.making.as_ref().map_or(0, |scene| scene.names());
        Kept {
            resident: stacks.iter().map(|s| s.tiles()).sum(),
            arrived: self.arrived.len(),
            asked: self.asked.len(),
            names: self.shown.names() + making,
            files: self.sources.len(),
            nodes: self.nodes.len(),
            messages: self.messages.all().len(),
        }
    }

    /// Height of the drawn ground in metres without exaggeration, from what is on the screen; 0
    /// before anything is.
    pub fn ground_m(&self, point: MapPoint) -> f64 {
        terrain::ground_m(&self.stacks.height, point)
    }

    /// Where a ray from the eye meets the drawn ground, and the ground's height there in metres.
    pub fn cast(&self, eye: DVec3, direction: DVec3) -> Option<(MapPoint, f64)> {
        let planet = self.project.planet.body.figure();
        terrain::cast(
            &self.stacks.height,
            planet,
            self.exaggeration(),
            eye,
            direction,
        )
    }
}
