//! Two versions of a project against each other: what is dug and filled, element by element.
//!
//! Going from the first version to the second, changes are made one after the other in the order of the
//! second version's list, what is taken away where it stood. An element's row is what its own step
//! changes, so the net volumes of all rows add up to the total's. Noise that is added to other heights, and
//! detail beyond the data, are left out: they are no survey.

mod notes;
mod pair;
mod sites;
mod steps;
mod version;

use std::sync::Arc;

use relievo_analysis::{AnalysisError, Ground, MapBox, VolumeSettings, Volumes, volumes};
use relievo_planet::{LevelKey, Planet};
use relievo_project::{ElementId, Project};

use super::Task;
use super::extent;
use super::pictures::SitePictures;
use crate::compile::{NodeCache, Wish, compile};
use crate::engine::Engine;
use crate::scene::Scene;
use pair::{FINEST_M, Pair};
use sites::{Widths, apart, meet};
use steps::{state, steps};
use version::{as_shown, surveyed, with_elements};

pub use steps::Step;
pub use version::Version;

/// Most elements that are compared one by one.
const MOST_ELEMENTS: usize = 2000;

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
    /// Heights of both versions without noise and detail, and all steps between.
    pub(super) measured: [Arc<Scene>; 2],
    /// Both versions with all they have.
    pub(super) shown: [Arc<Scene>; 2],
    /// Both versions' ground alone, whose fineness is the data's.
    bare: [Arc<Scene>; 2],
    steps: Vec<Planned>,
    sites: Vec<MapBox>,
    widths: Widths,
    notes: Vec<String>,
}

/// How many times more sparsely than it should a measurement may begin at most.
const COARSEST: f64 = 1e9;

/// A step that is to be measured.
struct Planned {
    id: ElementId,
    name: String,
    kind: String,
    step: Step,
    scenes: [Arc<Scene>; 2],
    sites: Vec<MapBox>,
}

impl Engine {
    /// Compiles two versions of the project and every step between them. With `bounds` nothing counts but
    /// what lies inside them, and there everything does, also where versions show different layers;
    /// without, the surroundings of elements that differ are measured. Opens no file: those that are not
    /// open yet are left out, as in [`Engine::questions`].
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
            let compiled = compile(
                project,
                self.folder(),
                self.sources(),
                &nodes,
                &Wish::default(),
            );
            Arc::new(compiled.into_scene(0, None))
        };
        let [from, to] = [a, b].map(|version| {
            let mut elements = version.elements(project);
            elements.retain(|element| element.visible);
            elements
        });
        let order = steps(&from, &to);
        let differing = order.iter().filter(|entry| entry.step.is_some()).count();
        if differing > MOST_ELEMENTS {
            return Err(format!(
                "expected at most {MOST_ELEMENTS} elements that differ, found {differing}"
            ));
        }
        // Where each entry may change the ground, in either version.
        let reaches: Vec<Option<MapBox>> = order
            .iter()
            .map(|entry| {
                let both = [&entry.before, &entry.after].into_iter().flatten();
                both.filter_map(|element| extent::reach(element, &planet))
                    .reduce(|one, other| one.joined(&other))
            })
            .collect();
        let (first, last) = (surveyed(project, a), surveyed(project, b));
        let mut planned = Vec::new();
        for (done, (entry, reach)) in order.iter().zip(&reaches).enumerate() {
            let element = entry.after.as_ref().or(entry.before.as_ref());
            let (Some(step), Some(reach), Some(element)) = (entry.step, reach, element) else {
                continue;
            };
            // Only what may reach the same ground decides this step.
            let near = |index: usize| {
                let other = reaches.get(index).and_then(Option::as_ref);
                other.is_some_and(|other| meet(other, reach))
            };
            let scenes = [done, done + 1].map(|count| {
                let elements = state(&order, count).filter(|(index, _)| near(*index));
                let elements = elements.map(|(_, element)| Arc::clone(element)).collect();
                scene(&with_elements(&last, elements))
            });
            planned.push(Planned {
                id: element.id.clone(),
                name: element.name.clone(),
                kind: element.kind.name().to_owned(),
                step,
                scenes,
                sites: bounds.map_or_else(|| vec![*reach], |bounds| bounds.shared(reach)),
            });
        }
        let mut notes = notes::notes(project, [a, b]);
        notes.extend(notes::of_grounds(project, &first, &last, bounds.is_some()));
        let reordered = from
            .iter()
            .map(|e| &e.id)
            .ne(state(&order, 0).map(|(_, e)| &e.id));
        if reordered {
            notes.push("The order of elements differs: where they overlap, rows do not add up to the total.".to_owned());
        }
        let sites = match bounds {
            None => apart(planned.iter().flat_map(|step| step.sites.iter().copied())),
            Some(bounds) => vec![*bounds],
        };
        let narrow: Vec<(MapBox, f64)> = from
            .iter()
            .chain(&to)
            .flat_map(|element| extent::narrow(element, &planet))
            .collect();
        Ok(Comparison {
            names: [a.name(project), b.name(project)],
            planet,
            bare: [&first, &last].map(&scene),
            measured: [
                scene(&with_elements(&first, from.clone())),
                scene(&with_elements(&last, to.clone())),
            ],
            shown: [
                scene(&with_elements(&as_shown(project, a), from)),
                scene(&with_elements(&as_shown(project, b), to)),
            ],
            steps: planned,
            sites,
            widths: Widths::new(&narrow),
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
        let places = self.steps.iter().map(|step| step.sites.len());
        let parts = (places.sum::<usize>() + self.sites.len()).max(1) as f64;
        let mut done = 0.0;
        let mut sparse: Vec<&str> = Vec::new();
        let mut measure = |name, scenes: &[Arc<Scene>; 2], sites: &[MapBox]| {
            let mut sum = Volumes::default();
            for site in sites {
                let progress = |share: f64| (task.progress)((done + share) / parts);
                let part = Task {
                    cancel: task.cancel,
                    progress: &progress,
                };
                let (found, coarser) = self.measure_site(scenes, site, settings, &part)?;
                if coarser > 1.0 && sparse.last() != Some(&name) {
                    sparse.push(name);
                }
                sum = sum.and(&found);
                done += 1.0;
            }
            Ok::<_, AnalysisError>(sum)
        };
        let mut notes = self.notes.clone();
        let mut elements = Vec::new();
        for step in &self.steps {
            elements.push(ElementChange {
                id: step.id.clone(),
                name: step.name.clone(),
                kind: step.kind.clone(),
                step: step.step,
                volumes: measure(step.name.as_str(), &step.scenes, &step.sites)?,
            });
        }
        let total = measure("total", &self.measured, &self.sites)?;
        if !sparse.is_empty() {
            notes.push(format!(
                "Too few samples to begin as finely as data and narrow elements ask for, so that thin parts may be missed beyond the stated errors; allow more: {}.",
                notes::listed(&sparse)
            ));
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
        SitePictures::new(&self.shown, site, self.planet, width, task.cancel).map(Some)
    }

    /// What changes at a site, and how many times more sparsely it was looked at than data and narrow
    /// elements ask for, to stay within the samples allowed.
    fn measure_site(
        &self,
        scenes: &[Arc<Scene>; 2],
        site: &MapBox,
        settings: &VolumeSettings,
        task: &Task,
    ) -> Result<(Volumes, f64), AnalysisError> {
        let mut pair = Pair {
            scenes,
            planet: self.planet,
            cancel: task.cancel,
            widths: &self.widths,
            coarser: 1.0,
        };
        let data_m = self
            .bare
            .iter()
            .map(|scene| pair.ground(scene).finest_level(site))
            .map(|n| LevelKey::new(0, n).step_rad().y * self.planet.radius_m)
            .fold(f64::INFINITY, f64::min);
        let height_m = (site.south_colat_rad - site.north_colat_rad) * self.planet.radius_m;
        // Ground without data has no spacing of its own.
        let finest_m = settings
            .spacing_m
            .min(data_m)
            .min(height_m / 32.0)
            .max(FINEST_M);
        loop {
            let spacing_m = finest_m * pair.coarser;
            let settings = VolumeSettings {
                spacing_m,
                ..*settings
            };
            match volumes(&pair, site, &settings, task) {
                // Too large an area for so fine a beginning; halving finds what matters.
                Err(AnalysisError::Refused(_)) if pair.coarser < COARSEST => pair.coarser *= 2.0,
                result => return Ok((result?, pair.coarser)),
            }
        }
    }
}
