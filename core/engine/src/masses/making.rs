//! Making meshes on a thread of their own, and keeping those that are near.
//!
//! Invariant: the caller's thread never makes a mesh and never waits for one; a mesh stays until
//! another of its cell takes its place.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;
use std::time::Duration;

use crossbeam_channel::{Receiver, Select, Sender, TrySendError, bounded, unbounded};
use glam::I64Vec2;
use relievo_planet::{Grid, LevelKey, MapPoint, Planet, SampleRect, TileKey};
use relievo_project::{Extrude, LayerId};
use relievo_raster::{Block, Cancel, colour};
use relievo_vector::{Features, Style};

use super::MassMesh;
use super::cells::{CELL_LEVEL, Cells, middle_of};
use super::prism::{self, Site, Standing};
use crate::scene::Scene;

/// Cells of all layers that are kept at most.
const MOST_CELLS: usize = 256;
/// Bodies farther away than this are not drawn, metres.
const FARTHEST_M: f64 = 60_000.0;
/// Height of an ordinary body: one that is less than a pixel high is not missed.
const ORDINARY_M: f64 = 30.0;
/// Finest level at which the ground below bodies is evaluated: 2.4 m on Earth.
const GROUND_LEVEL: u8 = 15;
/// Colour of bodies without a fill.
const PLASTER: [u8; 3] = [214, 208, 198];
/// Highest body, metres.
const HIGHEST_M: f64 = 1e5;
/// Jobs that wait at the thread's door.
const WAITING: usize = 4;

/// A layer whose areas stand as bodies.
pub(crate) struct Extruded {
    pub(crate) layer: LayerId,
    pub(crate) features: Arc<Features>,
    pub(crate) style: Arc<Style>,
    pub(crate) extrude: Extrude,
}

/// Where bodies are wanted, and on what they stand.
pub(crate) struct Around {
    pub(crate) scene: Arc<Scene>,
    pub(crate) planet: Planet,
    pub(crate) exaggeration: f64,
    /// Where the eye looks from.
    pub(crate) place: MapPoint,
    /// Angle of a pixel, radians.
    pub(crate) pixel_rad: f64,
}

impl Around {
    /// Whether the same bodies are wanted: a scene is one revision, with all its layers.
    fn is_like(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.scene, &other.scene)
            && self.planet == other.planet
            && self.exaggeration == other.exaggeration
            && self.place == other.place
            && self.pixel_rad == other.pixel_rad
    }
}

/// A mesh to make.
struct Job {
    name: u64,
    cell: TileKey,
    members: Arc<[u32]>,
    features: Arc<Features>,
    style: Arc<Style>,
    extrude: Extrude,
    scene: Arc<Scene>,
    planet: Planet,
    exaggeration: f64,
}

enum Task {
    Sort(Arc<Features>),
    Make(Box<Job>),
}

enum Done {
    Sorted(usize, Arc<Cells>),
    /// `None` where nothing stands, or the ground could not be read.
    Made(u64, Option<Arc<MassMesh>>),
}

/// What is drawn in a cell of a layer.
struct Shown {
    name: u64,
    mesh: Option<Arc<MassMesh>>,
}

/// The bodies of a project.
pub(crate) struct Bodies {
    tasks: Sender<Task>,
    done: Receiver<Done>,
    cancel: Cancel,
    /// Cells of features, by where those are in memory.
    sorted: HashMap<usize, Arc<Cells>>,
    /// What the thread is at.
    asked: HashSet<u64>,
    sorting: HashSet<usize>,
    /// Meshes that came and whose cell has not taken them yet.
    made: HashMap<u64, Option<Arc<MassMesh>>>,
    shown: HashMap<(LayerId, TileKey), Shown>,
    pending: usize,
    /// What was asked for last, and what was drawn.
    latest: Option<(Around, Vec<Arc<MassMesh>>)>,
}

impl Drop for Bodies {
    fn drop(&mut self) {
        self.cancel.cancel();
    }
}

impl Bodies {
    /// Starts the thread; `wake` is called when something is finished.
    ///
    /// # Errors
    /// When the system refuses a thread.
    pub(crate) fn new(wake: Arc<dyn Fn() + Send + Sync>) -> std::io::Result<Self> {
        let (tasks, to_do) = bounded::<Task>(WAITING);
        // As many at most as tasks were let in.
        let (finished, done) = unbounded();
        let cancel = Cancel::default();
        let stop = cancel.clone();
        std::thread::Builder::new()
            .name("relievo-bodies".to_owned())
            .spawn(move || {
                for task in to_do {
                    if stop.is_cancelled() {
                        return;
                    }
                    let answer = match task {
                        Task::Sort(features) => Done::Sorted(
                            Arc::as_ptr(&features).addr(),
                            Arc::new(Cells::new(&features)),
                        ),
                        Task::Make(job) => Done::Made(job.name, make(&job, &stop)),
                    };
                    if finished.send(answer).is_err() {
                        return;
                    }
                    wake();
                }
            })?;
        Ok(Self {
            tasks,
            done,
            cancel,
            sorted: HashMap::new(),
            asked: HashSet::new(),
            sorting: HashSet::new(),
            made: HashMap::new(),
            shown: HashMap::new(),
            pending: 0,
            latest: None,
        })
    }

    /// Meshes of what is wanted that are still to come.
    pub(crate) fn pending(&self) -> usize {
        self.pending
    }

    /// Waits until something is finished or the time is over.
    pub(crate) fn wait(&self, timeout: Duration) {
        let mut finished = Select::new();
        finished.recv(&self.done);
        // Nothing is taken here: whether it was the time or a mesh, the next frame will see.
        let _ready = finished.ready_timeout(timeout);
    }

    fn take(&mut self, done: Done) {
        match done {
            Done::Sorted(features, cells) => {
                self.sorting.remove(&features);
                self.sorted.insert(features, cells);
            }
            Done::Made(name, mesh) => {
                self.asked.remove(&name);
                self.made.insert(name, mesh);
            }
        }
    }

    /// What was drawn last, if that is still right: a view that rests costs nothing.
    pub(crate) fn as_before(&self, around: &Around) -> Option<Vec<Arc<MassMesh>>> {
        let (latest, drawn) = self.latest.as_ref()?;
        (self.pending == 0 && latest.is_like(around)).then(|| drawn.clone())
    }

    /// Takes what is finished, asks for what is missing, and gives what is to be drawn.
    pub(crate) fn follow(&mut self, layers: &[Extruded], around: Around) -> Vec<Arc<MassMesh>> {
        while let Ok(done) = self.done.try_recv() {
            self.take(done);
        }
        self.pending = 0;
        let used: HashSet<usize> = layers.iter().map(|l| address(&l.features)).collect();
        self.sorted.retain(|features, _| used.contains(features));
        let mut wanted: HashSet<(LayerId, TileKey)> = HashSet::new();
        let mut drawn = Vec::new();
        let reach_m = (ORDINARY_M / around.pixel_rad.max(1e-9)).min(FARTHEST_M);
        let reach_rad = reach_m / around.planet.radius_m;
        for layer in layers {
            let Some(cells) = self.cells_of(&layer.features) else {
                self.pending += 1;
                continue;
            };
            let bodies = name_of_bodies(layer, &around);
            let most = MOST_CELLS.saturating_sub(wanted.len());
            for cell in cells.near(around.place, reach_rad, most) {
                let Some(members) = cells.members(cell) else {
                    continue;
                };
                let name = name_of(&bodies, cell, &around);
                let key = (layer.layer.clone(), cell);
                if let Some(mesh) = self.made.remove(&name) {
                    self.shown.insert(key.clone(), Shown { name, mesh });
                }
                if self.shown.get(&key).is_none_or(|s| s.name != name) {
                    self.pending += 1;
                    self.ask(name, cell, members, layer, &around);
                }
                drawn.extend(self.shown.get(&key).and_then(|s| s.mesh.clone()));
                wanted.insert(key);
            }
        }
        self.shown.retain(|key, _| wanted.contains(key));
        if self.pending == 0 {
            self.made.clear();
        }
        self.latest = Some((around, drawn.clone()));
        drawn
    }

    fn cells_of(&mut self, features: &Arc<Features>) -> Option<Arc<Cells>> {
        let key = address(features);
        if let Some(cells) = self.sorted.get(&key) {
            return Some(Arc::clone(cells));
        }
        if !self.sorting.contains(&key)
            && self
                .tasks
                .try_send(Task::Sort(Arc::clone(features)))
                .is_ok()
        {
            self.sorting.insert(key);
        }
        None
    }

    fn ask(
        &mut self,
        name: u64,
        cell: TileKey,
        members: &Arc<[u32]>,
        layer: &Extruded,
        around: &Around,
    ) {
        if self.asked.contains(&name) {
            return;
        }
        let job = Job {
            name,
            cell,
            members: Arc::clone(members),
            features: Arc::clone(&layer.features),
            style: Arc::clone(&layer.style),
            extrude: layer.extrude.clone(),
            scene: Arc::clone(&around.scene),
            planet: around.planet,
            exaggeration: around.exaggeration,
        };
        match self.tasks.try_send(Task::Make(Box::new(job))) {
            Ok(()) => {
                self.asked.insert(name);
            }
            // The thread is busy: it is asked again with the next frame, nearest cells first.
            Err(TrySendError::Full(_) | TrySendError::Disconnected(_)) => {}
        }
    }
}

fn address(features: &Arc<Features>) -> usize {
    Arc::as_ptr(features).addr()
}

/// Names all that decides a layer's meshes beside the ground.
fn name_of_bodies(layer: &Extruded, around: &Around) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&layer.features.fingerprint());
    hasher.update(format!("{:?} {:?}", layer.extrude, layer.style).as_bytes());
    hasher.update(&around.exaggeration.to_le_bytes());
    hasher.update(&around.planet.radius_m.to_le_bytes());
    hasher.finalize()
}

/// Names a cell's mesh by all that decides it.
fn name_of(bodies: &blake3::Hash, cell: TileKey, around: &Around) -> u64 {
    let ground = around.scene.name(around.scene.roots.height, cell);
    let mut hasher = blake3::Hasher::new();
    hasher.update(bodies.as_bytes());
    hasher.update(format!("{cell:?} {ground:?}").as_bytes());
    let [a, b, c, d, e, f, g, h, ..] = *hasher.finalize().as_bytes();
    u64::from_le_bytes([a, b, c, d, e, f, g, h])
}

fn make(job: &Job, cancel: &Cancel) -> Option<Arc<MassMesh>> {
    let ground = Ground::new(job, cancel)?;
    let middle = middle_of(job.cell);
    let ground_m = |place| ground.height_m(place);
    let site = Site {
        radius_m: job.planet.radius_m,
        exaggeration: job.exaggeration,
        ground_m: &ground_m,
    };
    let height_m = ground_m(middle) * job.exaggeration;
    let mut mesh = MassMesh {
        id: job.name,
        origin_in_world: middle.to_unit() * (job.planet.radius_m + height_m),
        radius_m: 0.0,
        vertices: Vec::new(),
        indices: Vec::new(),
    };
    for feature in job.members.iter().map(|f| *f as usize) {
        if cancel.is_cancelled() {
            return None;
        }
        let Some(height_m) = body_height_m(&job.extrude, &job.features, feature) else {
            continue;
        };
        let standing = Standing {
            height_m,
            colour: colour_of(&job.style, &job.features, feature),
        };
        prism::add(&mut mesh, job.features.outlines(feature), standing, &site);
    }
    (!mesh.indices.is_empty()).then(|| Arc::new(mesh))
}

/// Colour of a feature's body: the fill of its class, or of the style.
fn colour_of(style: &Style, features: &Features, feature: usize) -> [u8; 3] {
    let class = style.by.as_ref().and_then(|by| {
        let value = features.property(feature, &by.property);
        by.classes.iter().find(|class| class.of.contains(value))
    });
    let fill = class.and_then(|class| class.fill).or(style.fill);
    fill.map_or(PLASTER, |[r, g, b, _]| [r, g, b].map(colour::to_u8))
}

/// How high a feature stands above the ground, metres; `None` without a body: where the height is no
/// number, or none above the ground.
pub(crate) fn body_height_m(extrude: &Extrude, features: &Features, feature: usize) -> Option<f64> {
    let height_m = match extrude {
        Extrude::HeightM(height_m) => Some(*height_m),
        Extrude::Property(name) => features.property(feature, name).as_number(),
    };
    height_m.filter(|h| *h > 0.0 && *h <= HIGHEST_M)
}

/// Heights of the evaluated ground of a cell.
struct Ground {
    grid: Grid,
    heights: Block,
    level: LevelKey,
}

impl Ground {
    fn new(job: &Job, cancel: &Cancel) -> Option<Self> {
        let finer = job.scene.finest().clamp(CELL_LEVEL, GROUND_LEVEL) - CELL_LEVEL;
        let level = LevelKey::new(job.cell.level.m + finer, job.cell.level.n + finer);
        let cell = job.cell.rect();
        // Bodies whose middle lies in the cell stick out of it.
        let margin = (cell.width() << finer) / 8;
        let rect = SampleRect::new(
            cell.min * (1_i64 << finer) - I64Vec2::splat(margin),
            cell.max * (1_i64 << finer) + margin,
        );
        let rows = SampleRect::new(
            I64Vec2::new(rect.min.x, rect.min.y.max(0)),
            I64Vec2::new(rect.max.x, rect.max.y.min(level.samples().y)),
        );
        let grid = Grid::new(Arc::new(level.lattice()), rows);
        let root = job.scene.roots.height;
        match job.scene.graph.evaluate(root, &grid, cancel) {
            Ok(heights) => Some(Self {
                grid,
                heights,
                level,
            }),
            Err(error) => {
                tracing::warn!("bodies have no ground to stand on: {error}");
                None
            }
        }
    }

    /// Bilinear height at a place, as that of the nearest sample outside; 0 where there is none.
    fn height_m(&self, place: MapPoint) -> f64 {
        let rect = &self.grid.rect;
        let mut at = self.level.sample_from_map(place) - 0.5;
        let around = self.level.samples().x as f64;
        let middle = 0.5 * (rect.min.x + rect.max.x) as f64;
        at.x -= ((at.x - middle) / around).round() * around;
        let last = (rect.max - rect.min - 1).as_dvec2();
        let at = (at - rect.min.as_dvec2()).clamp(glam::DVec2::ZERO, last);
        let low = at.floor().min((last - 1.0).max(glam::DVec2::ZERO));
        let t = at - low;
        let (x, y) = (low.x as usize, low.y as usize);
        let h = |dx: usize, dy: usize| {
            let x = (x + dx).min(self.heights.width() - 1);
            let y = (y + dy).min(self.heights.height() - 1);
            let v = f64::from(self.heights.plane(0)[y * self.heights.width() + x]);
            if v.is_finite() { v } else { 0.0 }
        };
        let north = h(0, 0) + (h(1, 0) - h(0, 0)) * t.x;
        let south = h(0, 1) + (h(1, 1) - h(0, 1)) * t.x;
        north + (south - north) * t.y
    }
}
