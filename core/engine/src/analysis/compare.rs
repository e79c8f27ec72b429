//! Two versions of a project against each other: what is dug and filled, element by element.
//!
//! Going from the first version to the second, changes are made one after the other in the order of the
//! second version's list, what is taken away where it stood. An element's row is what its own step
//! changes, so the net volumes of all rows add up to the total's. Noise that is added to other heights is
//! left out: it is no survey.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use glam::DVec2;
use relievo_analysis::{AnalysisError, Change, Ground, LocalFrame, MapBox, Region, Volumes};
use relievo_analysis::{VolumeSettings, volumes};
use relievo_graph::RenderError;
use relievo_planet::{Grid, LevelKey, MapPoint, Planet};
use relievo_project::{Element, ElementId, LayerKind, NoiseMode, Project, ScenarioId};
use relievo_raster::Cancel;

use super::extent::Extent;
use super::pictures::SitePictures;
use super::{SceneGround, Task};
use crate::compile::{NodeCache, compile};
use crate::engine::Engine;
use crate::scene::Scene;

/// Most elements that are compared one by one.
const MOST_ELEMENTS: usize = 2000;

/// Finest spacing in metres to begin with.
const FINEST_M: f64 = 0.02;

/// A state of a project's elements and layers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Version {
    /// The base without any element.
    Ground,
    /// The base.
    Base,
    /// A scenario.
    Scenario(ScenarioId),
}

impl Version {
    /// The version that people call so: `ground`, `base`, a scenario's name or its id.
    pub fn called(project: &Project, text: &str) -> Option<Self> {
        match text {
            "base" => Some(Self::Base),
            "ground" => Some(Self::Ground),
            _ => project
                .scenario_called(text)
                .map(|scenario| Self::Scenario(scenario.id.clone())),
        }
    }

    /// What people call it.
    pub fn name(&self, project: &Project) -> String {
        match self {
            Self::Ground => "ground".to_owned(),
            Self::Base => "base".to_owned(),
            Self::Scenario(id) => project
                .scenario(id)
                .map_or_else(|| id.0.clone(), |scenario| scenario.name.clone()),
        }
    }

    fn scenario(&self) -> Option<&ScenarioId> {
        match self {
            Self::Ground | Self::Base => None,
            Self::Scenario(id) => Some(id),
        }
    }

    fn elements(&self, project: &Project) -> Vec<Arc<Element>> {
        match self {
            Self::Ground => Vec::new(),
            Self::Base | Self::Scenario(_) => {
                let mut elements = project.elements_in(self.scenario());
                elements.retain(|element| element.visible);
                elements
            }
        }
    }
}

/// What becomes of an element from one version to the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Only the second version has it.
    Added,
    /// Only the first version has it.
    Removed,
    /// Both have it, differently.
    Changed,
}

impl Step {
    /// `added`, `removed` or `changed`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Added => "added",
            Self::Removed => "removed",
            Self::Changed => "changed",
        }
    }
}

/// What the step of one element comes to.
#[derive(Clone, Debug)]
pub struct ElementChange {
    /// The element's id.
    pub id: ElementId,
    /// Its name in the second version, or in the first if it is removed.
    pub name: String,
    /// Its kind's name in the file.
    pub kind: String,
    /// What becomes of it.
    pub step: Step,
    /// What it changes.
    pub volumes: Volumes,
}

/// Two versions, measured.
#[derive(Clone, Debug)]
pub struct ComparisonReport {
    /// Names of both versions.
    pub names: [String; 2],
    /// Element by element, in the order of the steps.
    pub elements: Vec<ElementChange>,
    /// From the first to the second version at once.
    pub total: Volumes,
    /// What else users should know.
    pub notes: Vec<String>,
}

/// Two versions of a project, compiled, to be measured and shown on any thread.
pub struct Comparison {
    names: [String; 2],
    pub(super) planet: Planet,
    /// Heights of both versions without noise, and all steps between.
    measured: [Arc<Scene>; 2],
    /// Both versions with all they have.
    pub(super) shown: [Arc<Scene>; 2],
    steps: Vec<Planned>,
    sites: Vec<Site>,
    notes: Vec<String>,
}

/// A step that is to be measured.
struct Planned {
    id: ElementId,
    name: String,
    kind: String,
    step: Step,
    scenes: [Arc<Scene>; 2],
    site: Site,
}

/// Where something changes.
#[derive(Clone, Debug)]
pub(super) struct Site {
    pub(super) region: Region,
    width_m: f64,
}

impl Engine {
    /// Compiles two versions of the project and every step between them. `bounds` adds an area (the square
    /// around it) that is measured as a whole, for versions that show different layers. Opens no file: those that are
    /// not open yet are left out, as in [`Engine::questions`].
    ///
    /// # Errors
    /// One line, when more elements differ than can be compared one by one.
    pub fn comparison(
        &self,
        a: &Version,
        b: &Version,
        bounds: Option<&MapBox>,
    ) -> Result<Comparison, String> {
        let project = self.project();
        let planet = project.planet.body.figure();
        let nodes = NodeCache::default();
        let scene = |project: &Project| -> Arc<Scene> {
            let compiled = compile(project, self.folder(), self.sources(), &nodes, None);
            Arc::new(compiled.into_scene(0))
        };
        let (from, to) = (a.elements(project), b.elements(project));
        let order = steps(&from, &to);
        let differing = order.iter().filter(|entry| entry.step.is_some()).count();
        if differing > MOST_ELEMENTS {
            return Err(format!(
                "expected at most {MOST_ELEMENTS} elements that differ, found {differing}"
            ));
        }
        let (first, last) = (surveyed(project, a), surveyed(project, b));
        let mut planned = Vec::new();
        let mut circles = Vec::new();
        for (done, entry) in order.iter().enumerate() {
            let Some(step) = entry.step else { continue };
            let element = entry.after.as_ref().or(entry.before.as_ref());
            let extents: Vec<Extent> = [&entry.before, &entry.after]
                .into_iter()
                .flatten()
                .filter_map(|element| Extent::of(element, &planet))
                .collect();
            let (Some(element), Some(extent)) = (element, around(&planet, &extents)) else {
                continue;
            };
            circles.push(extent);
            // Only what may reach the same ground decides this step.
            let near = |element: &Element| {
                Extent::of(element, &planet).is_some_and(|other| meet(&planet, &extent, &other))
            };
            let scenes = [done, done + 1].map(|count| {
                let elements = state(&order, count).filter(|e| near(e)).cloned().collect();
                scene(&with_elements(&last, elements))
            });
            planned.push(Planned {
                id: element.id.clone(),
                name: element.name.clone(),
                kind: element.kind.name().to_owned(),
                step,
                scenes,
                site: site(planet, &extent),
            });
        }
        let mut notes = Vec::new();
        if first.layers != last.layers {
            notes.push(match bounds {
                Some(_) => "The versions show different height layers: the total counts them within the bounds, the rows of elements stand on the second version's ground.",
                None => "The versions show different height layers: the total counts them where elements change; give bounds to count them elsewhere. Rows of elements stand on the second version's ground.",
            }.to_owned());
        }
        if project.layers.iter().any(is_added_noise) {
            notes.push(
                "Noise that is added to other heights is left out of all measures.".to_owned(),
            );
        }
        circles.extend(bounds.map(|area| circle_of(&planet, area)));
        let reordered = from
            .iter()
            .map(|e| &e.id)
            .ne(state(&order, 0).map(|e| &e.id));
        if reordered {
            notes.push("The order of elements differs: where they overlap, rows do not add up to the total.".to_owned());
        }
        Ok(Comparison {
            names: [a.name(project), b.name(project)],
            planet,
            measured: [
                scene(&with_elements(&first, from.clone())),
                scene(&with_elements(&last, to.clone())),
            ],
            shown: [
                scene(&with_elements(&as_shown(project, a), from)),
                scene(&with_elements(&as_shown(project, b), to)),
            ],
            steps: planned,
            sites: clusters(planet, circles),
            notes,
        })
    }
}

impl Comparison {
    /// Names of both versions.
    pub fn names(&self) -> &[String; 2] {
        &self.names
    }

    /// Number of places, apart from each other, at which something may change.
    pub fn sites(&self) -> usize {
        self.sites.len()
    }

    /// Measures every element's step and the whole. `settings` say how finely; their spacing is the
    /// coarsest to begin with: data and elements that are finer begin finer.
    ///
    /// # Errors
    /// [`AnalysisError`].
    pub fn measure(
        &self,
        settings: &VolumeSettings,
        task: &Task,
    ) -> Result<ComparisonReport, AnalysisError> {
        let parts = (self.steps.len() + self.sites.len()).max(1) as f64;
        let mut notes = self.notes.clone();
        let mut elements = Vec::new();
        let measure = |done: usize, scenes: &[Arc<Scene>; 2], site: &Site| {
            let progress = |share: f64| (task.progress)((done as f64 + share) / parts);
            let part = Task {
                cancel: task.cancel,
                progress: &progress,
            };
            self.measure_site(scenes, site, settings, &part)
        };
        for (done, step) in self.steps.iter().enumerate() {
            elements.push(ElementChange {
                id: step.id.clone(),
                name: step.name.clone(),
                kind: step.kind.clone(),
                step: step.step,
                volumes: measure(done, &step.scenes, &step.site)?,
            });
        }
        let mut total = Volumes::default();
        for (index, site) in self.sites.iter().enumerate() {
            let of_site = measure(self.steps.len() + index, &self.measured, site)?;
            total = total.and(&of_site);
        }
        if total.samples == 0 {
            notes.push("Nothing differs.".to_owned());
        }
        (task.progress)(1.0);
        Ok(ComparisonReport {
            names: self.names.clone(),
            elements,
            total,
            notes,
        })
    }

    /// Pictures of a site (below [`Comparison::sites`]), `width` pixels wide: both versions from above
    /// and the difference of heights. `None` for a site that does not exist.
    ///
    /// # Errors
    /// [`AnalysisError`].
    pub fn pictures(
        &self,
        site: usize,
        width: u32,
        task: &Task,
    ) -> Result<Option<SitePictures>, AnalysisError> {
        let Some(site) = self.sites.get(site) else {
            return Ok(None);
        };
        SitePictures::new(&self.shown, &site.region, width, task.cancel).map(Some)
    }

    fn measure_site(
        &self,
        scenes: &[Arc<Scene>; 2],
        site: &Site,
        settings: &VolumeSettings,
        task: &Task,
    ) -> Result<Volumes, AnalysisError> {
        let pair = Pair {
            scenes,
            planet: self.planet,
            cancel: task.cancel,
        };
        let half_m = 0.5 * (site.region.max_m - site.region.min_m).length();
        let area = MapBox::around(site.region.frame.centre, half_m / self.planet.radius_m);
        let data_m = scenes
            .iter()
            .map(|scene| pair.ground(scene).finest_level(&area))
            .map(|n| LevelKey::new(0, n).step_rad().y * self.planet.radius_m)
            .fold(f64::INFINITY, f64::min);
        let mut spacing_m = settings
            .spacing_m
            .min(data_m)
            .min(site.width_m / 4.0)
            .max(FINEST_M);
        loop {
            let settings = VolumeSettings {
                spacing_m,
                ..*settings
            };
            match volumes(&pair, &site.region, &settings, task) {
                // Too large an area for so fine a beginning; halving finds what matters.
                Err(AnalysisError::Refused(_)) if spacing_m < half_m / 64.0 => spacing_m *= 2.0,
                result => return result,
            }
        }
    }
}

/// The heights of two scenes.
pub(super) struct Pair<'a> {
    pub(super) scenes: &'a [Arc<Scene>; 2],
    pub(super) planet: Planet,
    pub(super) cancel: &'a Cancel,
}

impl Pair<'_> {
    fn ground<'a>(&'a self, scene: &'a Scene) -> SceneGround<'a> {
        SceneGround {
            scene,
            node: scene.roots.height,
            planet: self.planet,
            cancel: self.cancel,
        }
    }
}

impl Change for Pair<'_> {
    fn planet(&self) -> Planet {
        self.planet
    }

    fn same(&self, grid: &Grid) -> bool {
        let name = |scene: &Scene| scene.graph.evaluation_id(scene.roots.height, grid);
        name(&self.scenes[0]) == name(&self.scenes[1])
    }

    fn heights(&self, grid: &Grid) -> Result<(Vec<f64>, Vec<f64>), AnalysisError> {
        let heights = |scene| -> Result<Vec<f64>, AnalysisError> {
            let found = self.ground(scene).heights(grid)?;
            Ok(found.into_iter().map(f64::from).collect())
        };
        Ok((heights(&self.scenes[0])?, heights(&self.scenes[1])?))
    }
}

/// A graph's error as a measurement's.
pub(super) fn failed(error: RenderError) -> AnalysisError {
    match error {
        RenderError::Cancelled => AnalysisError::Cancelled,
        error @ (RenderError::Read(_) | RenderError::Node { .. }) => {
            AnalysisError::Ground(Box::new(error))
        }
    }
}

fn is_added_noise(layer: &relievo_project::Layer) -> bool {
    let added =
        matches!(&layer.kind, LayerKind::Noise(noise) if noise.noise.mode == NoiseMode::Add);
    layer.visible && added
}

/// A version's layers; elements are put in later.
fn as_shown(project: &Project, version: &Version) -> Project {
    Project {
        layers: project.layers_in(version.scenario()).into_owned(),
        elements: Vec::new(),
        scenarios: Vec::new(),
        scenario: None,
        ..project.clone()
    }
}

/// A version's heights without colours and without noise that is added.
fn surveyed(project: &Project, version: &Version) -> Project {
    let mut project = as_shown(project, version);
    project.layers.retain(|layer| {
        let gives_heights = matches!(layer.kind, LayerKind::Height(_) | LayerKind::Noise(_));
        gives_heights && layer.visible && !is_added_noise(layer)
    });
    project
}

fn with_elements(project: &Project, elements: Vec<Arc<Element>>) -> Project {
    Project {
        elements,
        ..project.clone()
    }
}

/// An element of either version.
struct Entry {
    before: Option<Arc<Element>>,
    after: Option<Arc<Element>>,
    /// `None` where both are equally shaped.
    step: Option<Step>,
}

/// All elements of both versions in the order of the second one; those that only the first one has
/// follow what they followed there.
fn steps(from: &[Arc<Element>], to: &[Arc<Element>]) -> Vec<Entry> {
    let before: HashMap<&ElementId, &Arc<Element>> = from.iter().map(|e| (&e.id, e)).collect();
    let kept: HashSet<&ElementId> = to.iter().map(|e| &e.id).collect();
    // What goes, by what it follows.
    let mut behind: HashMap<Option<&ElementId>, Vec<&Arc<Element>>> = HashMap::new();
    let mut last = None;
    for element in from {
        if kept.contains(&element.id) {
            last = Some(&element.id);
        } else {
            behind.entry(last).or_default().push(element);
        }
    }
    let gone = |id: Option<&ElementId>| -> Vec<Entry> {
        let gone = behind.get(&id).into_iter().flatten();
        gone.map(|element| Entry {
            before: Some(Arc::clone(element)),
            after: None,
            step: Some(Step::Removed),
        })
        .collect()
    };
    let mut order: Vec<Entry> = gone(None);
    for element in to {
        let before = before.get(&element.id).map(|e| Arc::clone(e));
        let step = match &before {
            None => Some(Step::Added),
            // Names and colours move no ground.
            Some(before) if before.kind == element.kind && before.side == element.side => None,
            Some(_) => Some(Step::Changed),
        };
        order.push(Entry {
            before,
            after: Some(Arc::clone(element)),
            step,
        });
        order.extend(gone(Some(&element.id)));
    }
    order
}

/// The elements after the first `done` entries have become what they become.
fn state(order: &[Entry], done: usize) -> impl Iterator<Item = &Arc<Element>> {
    order.iter().enumerate().filter_map(move |(index, entry)| {
        if index < done {
            entry.after.as_ref()
        } else {
            entry.before.as_ref()
        }
    })
}

/// One circle around others.
fn around(planet: &Planet, circles: &[Extent]) -> Option<Extent> {
    let first = circles.first()?;
    let radii = circles
        .iter()
        .map(|c| planet.offset_m(first.centre, c.centre).length() * 1.01 + c.radius_m);
    let widths = circles.iter().map(|c| c.width_m);
    Some(Extent {
        centre: first.centre,
        radius_m: radii.fold(0.0, f64::max),
        width_m: widths.fold(f64::INFINITY, f64::min),
    })
}

fn meet(planet: &Planet, a: &Extent, b: &Extent) -> bool {
    planet.offset_m(a.centre, b.centre).length() * 0.99 <= a.radius_m + b.radius_m
}

fn circle_of(planet: &Planet, area: &MapBox) -> Extent {
    let centre = MapPoint::new(
        f64::midpoint(area.west_rad, area.east_rad),
        f64::midpoint(area.north_colat_rad, area.south_colat_rad),
    );
    let corners = [
        (area.west_rad, area.north_colat_rad),
        (area.west_rad, area.south_colat_rad),
    ];
    let radii = corners.map(|(x, y)| planet.offset_m(centre, MapPoint::new(x, y)).length());
    Extent {
        centre,
        radius_m: radii[0].max(radii[1]),
        width_m: f64::INFINITY,
    }
}

fn site(planet: Planet, extent: &Extent) -> Site {
    Site {
        region: Region {
            frame: LocalFrame::new(planet, extent.centre),
            min_m: DVec2::splat(-extent.radius_m),
            max_m: DVec2::splat(extent.radius_m),
        },
        width_m: extent.width_m,
    }
}

/// Squares that hold all circles and do not overlap: what is measured in one is not in another.
fn clusters(planet: Planet, circles: Vec<Extent>) -> Vec<Site> {
    let mut apart: Vec<Extent> = Vec::new();
    for circle in circles {
        let mut grown = circle;
        // A square reaches √2 farther than its circle.
        let wide = |c: &Extent| Extent {
            radius_m: c.radius_m * 1.5,
            ..*c
        };
        while let Some(index) = apart
            .iter()
            .position(|other| meet(&planet, &wide(&grown), &wide(other)))
        {
            let other = apart.swap_remove(index);
            grown = joined(&planet, &grown, &other);
        }
        apart.push(grown);
    }
    apart.iter().map(|extent| site(planet, extent)).collect()
}

/// The smallest circle around two, nearly.
fn joined(planet: &Planet, a: &Extent, b: &Extent) -> Extent {
    let (large, small) = if a.radius_m >= b.radius_m {
        (a, b)
    } else {
        (b, a)
    };
    let between_m = planet.offset_m(large.centre, small.centre).length();
    let width_m = a.width_m.min(b.width_m);
    if between_m * 1.01 + small.radius_m <= large.radius_m {
        return Extent { width_m, ..*large };
    }
    let radius_m = 0.5 * (between_m * 1.01 + large.radius_m + small.radius_m);
    let share = ((radius_m - large.radius_m) / between_m.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    let (from, to) = (large.centre.to_unit(), small.centre.to_unit());
    let centre = MapPoint::from_direction(from + (to - from) * share).normalised();
    let reach = |c: &Extent| planet.offset_m(centre, c.centre).length() * 1.01 + c.radius_m;
    Extent {
        centre,
        radius_m: radius_m.max(reach(large)).max(reach(small)),
        width_m,
    }
}
