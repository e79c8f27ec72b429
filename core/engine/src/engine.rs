//! The engine: one project, its revisions, one view.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use glam::DVec3;
use relievo_graph::ContentId;
use relievo_planet::clipmap::plan::{HeightRange, PlanInput, Quality};
use relievo_planet::clipmap::{ClipKind as PlanKind, Plan, Planner};
use relievo_planet::{Camera, MapPoint, TileKey};
use relievo_project::{
    Affects, Aspect, Body, Edit, EditError, FileStamp, History, LayerId, OpenProjectError, Project,
    Replace, SaveProjectError,
};
use relievo_tiles::{LogEntry, TileState, Tiles, TilesOptions, Want};

use crate::compile::{self, NodeCache};
use crate::frame::{ClipKind, Frame, Sun, Upload};
use crate::message::{Message, Messages};
use crate::query::Questions;
use crate::residency::Stack;
use crate::scene::Scene;
use crate::sources::Sources;
use crate::terrain::{self, Bounds};
use crate::view::View;

/// Side of the height windows in samples: a tile, which holds the whole circle near a pole.
const HEIGHT_WINDOW: u32 = 256;

/// Copies into textures in one frame, so that a burst of finished tiles does not make one frame long.
const UPLOADS_PER_FRAME: usize = 96;

/// Tiles asked for beyond what is visible.
const PREFETCH: usize = 384;

/// How an engine works.
pub struct EngineOptions {
    /// Worker threads; `None`: all cores but one.
    pub threads: Option<usize>,
    /// Bound of the tile cache in bytes.
    pub memory: usize,
    /// Where pyramids of big images are kept; `None`: nowhere, they are made in memory.
    pub cache_folder: Option<PathBuf>,
    /// Whether [`Engine::take_log`] records which tiles were made.
    pub log: bool,
    /// Called from other threads when there is something to drain.
    pub wake: Option<Arc<dyn Fn() + Send + Sync>>,
}

impl Default for EngineOptions {
    /// All cores but one, 1 GiB, the user's cache folder.
    fn default() -> Self {
        Self {
            threads: None,
            memory: 1 << 30,
            cache_folder: default_cache_folder(),
            log: false,
            wake: None,
        }
    }
}

/// The user's cache folder for Relievo, where the system has one.
pub fn default_cache_folder() -> Option<PathBuf> {
    directories::ProjectDirs::from("", "", "relievo").map(|d| d.cache_dir().to_owned())
}

/// Why a project could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The file.
    #[error(transparent)]
    Project(#[from] OpenProjectError),
    /// The system.
    #[error("cannot start the threads that make tiles: {0}")]
    Threads(std::io::Error),
}

/// The folder that a project's relative paths start at.
pub fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// What the engine is doing and did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EngineStats {
    /// The scheduler and its cache.
    pub tiles: relievo_tiles::Stats,
    /// Visible tiles that are still to come.
    pub pending: usize,
    /// Files that are being opened.
    pub opening: usize,
    /// Time all workers together spent making tiles, nanoseconds.
    pub busy_ns: u128,
}

/// One project, edited and shown.
pub struct Engine {
    project: Project,
    history: History,
    folder: PathBuf,
    sources: Sources,
    nodes: NodeCache,
    tiles: Tiles,
    messages: Messages,
    /// The layer that is being edited: what lies below it is pinned.
    pinned: Option<LayerId>,
    revisions: u64,
    shown: Arc<Scene>,
    /// The revision that is being made, and the edit that waits behind it.
    making: Option<Arc<Scene>>,
    stale: bool,
    view: Option<View>,
    planner: Planner,
    plan: Option<Arc<Plan>>,
    /// The ground that the plan was made for.
    planned_on: (Bounds, f64),
    stacks: Stacks,
    /// Finished tiles that no window has taken yet.
    arrived: HashMap<ContentId, TileState>,
    asked: HashSet<ContentId>,
    dirty: bool,
    pending: usize,
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
        let mut tile_options = TilesOptions {
            memory: options.memory,
            log: options.log,
            ..TilesOptions::default()
        };
        if let Some(threads) = options.threads {
            tile_options.threads = threads.max(1);
        }
        if let Some(wake) = options.wake.clone() {
            tile_options.wake = Some(Box::new(move || wake()));
        }
        let sources = Sources::new(options.cache_folder, options.wake)?;
        let nodes = NodeCache::default();
        let empty = compile::compile(&Project::default(), folder, &sources, &nodes, None);
        let engine = Self {
            project,
            history: History::default(),
            folder: folder.to_owned(),
            sources,
            nodes,
            tiles: Tiles::new(tile_options)?,
            messages: Messages::default(),
            pinned: None,
            revisions: 0,
            shown: Arc::new(empty.into_scene(0)),
            making: None,
            stale: true,
            view: None,
            planner: Planner::default(),
            plan: None,
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
            arrived: HashMap::new(),
            asked: HashSet::new(),
            dirty: true,
            pending: 0,
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

    /// Applies an edit: the only way to change a project. The picture follows as tiles get ready.
    ///
    /// # Errors
    /// When the edit does not fit the project; nothing has changed then.
    pub fn apply(&mut self, edit: Edit) -> Result<(), EditError> {
        let affects = edit.affects();
        self.history.apply(&mut self.project, edit)?;
        self.changed(&affects);
        Ok(())
    }

    /// Starts a drag: all edits until [`Self::end_drag`] are one undo step.
    pub fn begin_drag(&mut self) {
        self.history.begin_drag(&self.project);
    }

    /// Ends a drag.
    pub fn end_drag(&mut self) {
        self.history.end_drag(&self.project);
    }

    /// Ends a drag and takes it back.
    pub fn cancel_drag(&mut self) {
        if let Some(edit) = self.history.cancel_drag(&mut self.project) {
            self.changed(&edit.affects());
        }
    }

    /// Takes the last edit back; `false` if there is none.
    ///
    /// # Errors
    /// When the step does not fit the project any more; it is gone then.
    pub fn undo(&mut self) -> Result<bool, EditError> {
        let edit = self.history.undo(&mut self.project)?;
        Ok(edit.inspect(|e| self.changed(&e.affects())).is_some())
    }

    /// Makes the last undone edit again; `false` if there is none.
    ///
    /// # Errors
    /// When the step does not fit the project any more; it is gone then.
    pub fn redo(&mut self) -> Result<bool, EditError> {
        let edit = self.history.redo(&mut self.project)?;
        Ok(edit.inspect(|e| self.changed(&e.affects())).is_some())
    }

    /// Tries files and tiles again that failed before.
    pub fn retry(&mut self) {
        self.sources.forget_failures();
        self.tiles.forget_failures();
        self.sources.require(&self.project, &self.folder);
        self.messages.clear();
        self.stale = true;
        self.dirty = true;
    }

    /// Opens a project file.
    ///
    /// # Errors
    /// [`OpenError`] when the file cannot be read or is no project, or the system refuses a thread.
    pub fn open(path: &Path, options: EngineOptions) -> Result<(Self, FileStamp), OpenError> {
        let (project, stamp) = relievo_project::open(path)?;
        let engine = Self::new(project, folder_of(path), options).map_err(OpenError::Threads)?;
        Ok((engine, stamp))
    }

    /// Saves the project, whole or not at all. In another folder than before, relative paths are
    /// rewritten so that they still lead to the same files.
    ///
    /// # Errors
    /// [`SaveProjectError`]; the file on disk is then untouched.
    pub fn save(&mut self, path: &Path, replace: Replace) -> Result<FileStamp, SaveProjectError> {
        let folder = folder_of(path);
        if folder == self.folder {
            return relievo_project::save_atomic(path, &self.project, replace);
        }
        let moved = self.project.rebased(&self.folder, folder);
        let stamp = relievo_project::save_atomic(path, &moved, replace)?;
        self.history.rebase(&self.folder, folder);
        self.project = moved;
        folder.clone_into(&mut self.folder);
        self.sources.require(&self.project, &self.folder);
        Ok(stamp)
    }

    fn changed(&mut self, affects: &[Affects]) {
        for affect in affects {
            match affect {
                Affects::Layer { aspect, .. } if !aspect.is_visible() => {}
                Affects::Layer { id, aspect } => {
                    self.stale = true;
                    let edits_value =
                        matches!(aspect, Aspect::Adjust | Aspect::Opacity | Aspect::Blend);
                    self.pinned = edits_value.then(|| id.clone());
                }
                Affects::Planet | Affects::Exaggeration => {
                    self.stale = true;
                    self.dirty = true;
                }
                Affects::Camera | Affects::Sun | Affects::Quality => self.dirty = true,
            }
        }
        self.sources.require(&self.project, &self.folder);
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
        self.dirty = true;
    }

    /// One step: takes finished tiles, publishes a finished revision, plans, asks for what is
    /// missing, and says what to upload and draw. Never waits. `dt_s` is the time since the last
    /// call, infinite for stills; `None` until a view is set.
    pub fn drain(&mut self, dt_s: f32) -> Option<Frame> {
        let view = self.view?;
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
        let mut budget = if ready || dt_s.is_infinite() {
            usize::MAX
        } else {
            UPLOADS_PER_FRAME
        };
        self.update_windows(&mut budget, &mut uploads, dt_s);
        self.ask(!dt_s.is_infinite());
        // New heights can move the focus and uncover ground, and windows take their final shape step by
        // step: the plan must fit what it led to.
        self.dirty |= self.plan.as_ref().is_some_and(|p| !p.settled);
        if uploads.iter().any(|u| u.clipmap == ClipKind::Height)
            && self.ground(&view) != self.planned_on
        {
            self.dirty = true;
        }
        Some(self.frame(&view, uploads))
    }

    /// Waits until a finished tile or an opened file is there to drain, or the time is over; `true`
    /// when all work that was asked for is done. For offline work only.
    pub fn wait(&self, timeout: Duration) -> bool {
        if self.sources.opening() > 0 {
            self.sources.wait(timeout.min(Duration::from_millis(50)));
            return false;
        }
        self.tiles.wait(timeout)
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
        self.sources.take_changed();
        self.stale = true;
        self.recompile();
    }

    /// The project as it is now, with every file that is open, for questions that are asked of it on
    /// any thread while it may change here.
    pub fn questions(&self) -> Questions {
        let pinned = None;
        let compiled = compile::compile(
            &self.project,
            &self.folder,
            &self.sources,
            &self.nodes,
            pinned,
        );
        let planet = self.project.planet.body.figure();
        Questions {
            scene: Arc::new(compiled.into_scene(0)),
            planet,
        }
    }

    /// The files behind the layers.
    pub fn sources(&self) -> &Sources {
        &self.sources
    }

    /// What users should know, each once, newest last.
    pub fn messages(&self) -> &[Message] {
        self.messages.all()
    }

    /// Layers that the shown picture leaves out, and why: hidden, opacity 0, no file.
    pub fn left_out(&self) -> &[(LayerId, &'static str)] {
        &self.shown.left_out
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
        let exaggeration = self.project.planet.vertical_exaggeration;
        terrain::cast(&self.stacks.height, planet, exaggeration, eye, direction)
    }

    fn take_finished(&mut self) {
        for done in self.tiles.take_finished() {
            if let TileState::Failed(error) = &done.state {
                self.messages.tile_failed(error);
            }
            if self.asked.contains(&done.id) {
                self.arrived.insert(done.id, done.state);
                self.dirty = true;
            }
        }
    }

    /// Starts making the project's current state unless a revision is being made already: that one
    /// is finished first, so a drag cannot starve the fine levels.
    fn recompile(&mut self) {
        if self.sources.take_changed() {
            self.stale = true;
        }
        if !self.stale || self.making.is_some() {
            return;
        }
        self.stale = false;
        self.revisions += 1;
        let compiled = compile::compile(
            &self.project,
            &self.folder,
            &self.sources,
            &self.nodes,
            self.pinned.as_ref(),
        );
        self.messages.replace_sources(&compiled.problems);
        self.making = Some(Arc::new(compiled.into_scene(self.revisions)));
        self.dirty = true;
    }

    /// The revision that new tiles are made for.
    fn target(&self) -> &Arc<Scene> {
        self.making.as_ref().unwrap_or(&self.shown)
    }

    /// Whether everything that a new revision would replace on the screen is there.
    fn is_ready(&self, scene: &Scene) -> bool {
        self.visible(scene).all(|(kind, key, id)| {
            let stack = self.stacks.get(kind);
            !stack.shows(key) || stack.holds(key, id) || self.arrived.contains_key(&id)
        })
    }

    /// Names of all visible tiles under a revision.
    fn visible<'a>(
        &'a self,
        scene: &'a Scene,
    ) -> impl Iterator<Item = (ClipKind, TileKey, ContentId)> + 'a {
        self.plan
            .iter()
            .flat_map(|p| p.wanted_tiles())
            .flat_map(move |(kind, key)| named(scene, kind, key))
    }

    fn publish(&mut self) {
        if let Some(scene) = self.making.take() {
            self.shown = scene;
            self.dirty = true;
        }
    }

    /// What a plan depends on beside the view: bounds of the drawn terrain, and its height below the
    /// eye.
    fn ground(&self, view: &View) -> (Bounds, f64) {
        (
            terrain::bounds(&self.stacks.height),
            self.ground_m(view.camera.map_point()),
        )
    }

    fn replan(&mut self, view: &View) {
        if !self.dirty && self.plan.as_ref().is_some_and(|p| p.settled) {
            return;
        }
        let settings = &self.project.planet;
        let planet = settings.body.figure();
        let below = view.camera.map_point();
        let (terrain, ground_m) = self.ground(view);
        self.planned_on = (terrain, ground_m);
        let near = self.plan.as_ref().map_or(below, |p| p.focus);
        let target = self.target();
        let finest_height = target.finest_near(near, HEIGHT_WINDOW);
        let finest_colour = target.finest_near(near, view.colour_window);
        let plan = self.planner.plan(&PlanInput {
            camera: view.camera,
            planet,
            viewport_px: view.viewport_px,
            ground_m,
            terrain: &terrain,
            exaggeration: settings.vertical_exaggeration,
            quality: Quality {
                height_samples: HEIGHT_WINDOW,
                colour_samples: view.colour_window,
                height_texel_px: view.height_texel_px,
                colour_texel_px: view.colour_texel_px,
                finest_height_level: finest_height,
                finest_colour_level: finest_colour,
            },
        });
        let shown = Arc::clone(&self.shown);
        let (arrived, tiles) = (&self.arrived, &self.tiles);
        for (kind, stack) in self.stacks.each_mut() {
            let Some(root) = shown.root(kind) else {
                stack.clear();
                continue;
            };
            let levels = if kind == ClipKind::Height {
                &plan.heights
            } else {
                &plan.colours
            };
            stack.follow(levels, plan.focus, |level| {
                level.wanted_tiles().into_iter().all(|key| {
                    let id = shown.name(root, key);
                    arrived.contains_key(&id) || tiles.get(id).is_some()
                })
            });
        }
        self.plan = Some(Arc::new(plan));
    }

    fn update_windows(&mut self, budget: &mut usize, uploads: &mut Vec<Upload>, dt_s: f32) {
        let shown = Arc::clone(&self.shown);
        let (arrived, tiles) = (&self.arrived, &self.tiles);
        let mut left = false;
        for (kind, stack) in self.stacks.each_mut() {
            if let (true, Some(root)) = (self.dirty, shown.root(kind)) {
                let find = |id| arrived.get(&id).cloned().or_else(|| tiles.get(id));
                left |= stack.update(|key| shown.name(root, key), find, budget, uploads);
            }
            stack.settle(dt_s);
        }
        if !left && self.making.is_none() {
            self.arrived.clear();
        }
    }

    /// Asks the scheduler for what is missing: visible tiles first, then the rest of the windows if
    /// somebody may move there.
    fn ask(&mut self, prefetch: bool) {
        if !std::mem::take(&mut self.dirty) {
            return;
        }
        let scene = Arc::clone(self.target());
        let Some(plan) = self.plan.clone() else {
            return;
        };
        let mut wants: Vec<Want> = Vec::new();
        self.missing(&scene, plan.wanted_tiles(), usize::MAX, &mut wants);
        self.pending = wants
            .iter()
            .filter(|w| !self.arrived.contains_key(&w.id))
            .count();
        if prefetch && self.making.is_none() {
            self.missing(&scene, plan.prefetch_tiles(), PREFETCH, &mut wants);
        }
        self.asked = wants.iter().map(|w| w.id).collect();
        let asked = &self.asked;
        self.arrived.retain(|id, _| asked.contains(id));
        wants.retain(|w| !self.arrived.contains_key(&w.id));
        self.tiles.want(wants, plan.focus);
    }

    fn missing(
        &self,
        scene: &Scene,
        tiles: Vec<(PlanKind, TileKey)>,
        most: usize,
        wants: &mut Vec<Want>,
    ) {
        let end = wants.len().saturating_add(most);
        for (kind, key) in tiles {
            for (kind, key, id) in named(scene, kind, key) {
                if wants.len() >= end {
                    return;
                }
                if let (false, Some(root)) =
                    (self.stacks.get(kind).holds(key, id), scene.root(kind))
                {
                    wants.push(scene.want(root, key));
                }
            }
        }
    }

    fn frame(&self, view: &View, uploads: Vec<Upload>) -> Frame {
        let settings = &self.project.planet;
        let planet = settings.body.figure();
        let plan = self.plan.clone().expect("replan made one just before");
        Frame {
            revision: self.shown.revision,
            planet,
            exaggeration: settings.vertical_exaggeration,
            camera: view.camera,
            viewport_px: view.viewport_px,
            near_m: (plan.clearance_m * 0.25).max(0.05),
            height_window: HEIGHT_WINDOW,
            colour_window: view.colour_window,
            heights: self.stacks.height.views(),
            colours: self.stacks.colour.views(),
            normals: self.stacks.normal.views(),
            sun: sun(&self.project, &view.camera),
            air: air(settings.body),
            uploads,
            pending: self.pending + usize::from(self.is_busy() || self.dirty),
            plan,
        }
    }
}

/// The clipmap tiles behind a planned one, with their names.
fn named(
    scene: &Scene,
    kind: PlanKind,
    key: TileKey,
) -> impl Iterator<Item = (ClipKind, TileKey, ContentId)> + '_ {
    let kinds: &[ClipKind] = match kind {
        PlanKind::Heights => &[ClipKind::Height],
        PlanKind::Colours => &[ClipKind::Colour, ClipKind::Normal],
    };
    kinds
        .iter()
        .filter_map(move |k| Some((*k, key, scene.name(scene.root(*k)?, key))))
}

/// Density of a body's air at the datum relative to Earth's. Mars has 1.6 % of Earth's, but its dust
/// makes the sky twice as bright as so much clear air would.
fn air(body: Body) -> f32 {
    match body {
        Body::Earth | Body::Custom(_) => 1.0,
        Body::Mars => 0.03,
        Body::Moon => 0.0,
    }
}

/// Direction and strength of the light: azimuth and elevation hold at the anchor.
fn sun(project: &Project, camera: &Camera) -> Sun {
    let settings = &project.sun;
    let at = match settings.anchor {
        relievo_project::SunAnchor::Viewer => MapPoint::new(
            camera.lon_rad,
            core::f64::consts::FRAC_PI_2 - camera.lat_rad,
        ),
        relievo_project::SunAnchor::Place { lon_deg, lat_deg } => {
            MapPoint::from_degrees(lon_deg, lat_deg)
        }
    };
    let up = at.to_unit();
    let east = DVec3::new(-at.lon_rad.sin(), at.lon_rad.cos(), 0.0);
    let north = up.cross(east);
    let (azimuth, elevation) = (
        settings.azimuth_deg.to_radians(),
        settings.elevation_deg.to_radians(),
    );
    let level = north * azimuth.cos() + east * azimuth.sin();
    Sun {
        direction_in_world: level * elevation.cos() + up * elevation.sin(),
        ambient: settings.ambient as f32,
    }
}
