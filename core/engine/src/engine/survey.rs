//! What is odd about planning elements on their ground: side slopes that end in walls at their reach,
//! boundaries too steep for them. Found out by a thread of its own while a whole picture is shown.

use std::collections::HashMap;
use std::sync::Arc;

use parking_lot::Mutex;
use relievo_graph::ContentId;
use relievo_graph::nodes::PlacedElement;
use relievo_planet::{LevelKey, TileKey};
use relievo_project::ElementId;
use relievo_raster::Cancel;

use super::Engine;
use crate::message::{Message, Severity};
use crate::query::Questions;
use crate::scene::Scene;

/// Cells along an element's reach on which its slopes are followed to the ground.
const CELLS: f64 = 150.0;

/// What is known of elements on a ground.
#[derive(Default)]
pub(super) struct Survey {
    /// The revision that was looked at last.
    revision: u64,
    /// Names the ground that all of it is about.
    ground: Option<ContentId>,
    /// Warnings of elements, by the element's address, which stays its own while it is kept here.
    known: HashMap<usize, (Arc<PlacedElement>, Vec<String>)>,
    running: Option<Running>,
}

type Found = Vec<(Arc<PlacedElement>, Vec<String>)>;

/// Elements that are being looked at.
struct Running {
    cancel: Cancel,
    found: Arc<Mutex<(Found, bool)>>,
}

impl Drop for Running {
    fn drop(&mut self) {
        self.cancel.cancel();
    }
}

impl Engine {
    /// Takes what was found, and looks at elements that are not known yet once nothing else is to be
    /// done. Never waits.
    pub(super) fn survey(&mut self) {
        let scene = Arc::clone(&self.shown);
        let survey = &mut self.survey;
        let mut news = false;
        if let Some(running) = &survey.running {
            let mut found = running.found.lock();
            for (placed, warnings) in found.0.drain(..) {
                let address = Arc::as_ptr(&placed).addr();
                survey.known.insert(address, (placed, warnings));
                news = true;
            }
            let ended = found.1;
            drop(found);
            // Tiles come first: the revision that is being made will be looked at anew.
            if ended || survey.revision != scene.revision || self.making.is_some() {
                survey.running = None;
            }
        }
        let rests = self.making.is_none() && !self.stale && self.pending == 0;
        if rests && survey.revision != scene.revision && survey.running.is_none() {
            survey.revision = scene.revision;
            news = true;
            let whole = TileKey::new(LevelKey::new(0, 0), 0, 0);
            let ground = whole.map(|key| scene.name(scene.roots.ground, key));
            if survey.ground != ground {
                survey.ground = ground;
                survey.known.clear();
            }
            let placed = scene.elements.node.as_ref();
            let placed = placed.map_or(&[][..], |node| node.elements());
            let here: HashMap<usize, usize> = placed
                .iter()
                .enumerate()
                .map(|(i, p)| (Arc::as_ptr(p).addr(), i))
                .collect();
            survey.known.retain(|address, _| here.contains_key(address));
            let mut missing: Vec<usize> = here
                .into_iter()
                .filter(|(address, _)| !survey.known.contains_key(address))
                .map(|(_, i)| i)
                .collect();
            missing.sort_unstable();
            if !missing.is_empty() {
                let planet = self.project.planet.body.figure();
                let questions = Questions {
                    scene: Arc::clone(&scene),
                    surveyed: Arc::clone(&scene),
                    planet,
                };
                let wake = self.wake.clone().unwrap_or_else(|| Arc::new(|| {}));
                survey.running = start(questions, missing, wake);
            }
        }
        if news {
            let problems = survey.messages(&scene);
            self.messages.replace_ground(problems);
        }
    }
}

impl Survey {
    /// What is known of the elements of a scene.
    fn messages(&self, scene: &Scene) -> Vec<Message> {
        let Some(node) = &scene.elements.node else {
            return Vec::new();
        };
        let pairs = scene.elements.all.iter().zip(node.elements());
        let warnings = pairs.flat_map(|(element, placed)| {
            let known = self.known.get(&Arc::as_ptr(placed).addr());
            let warnings = known.map_or(&[][..], |(_, warnings)| warnings);
            warnings.iter().map(|warning| Message {
                severity: Severity::Warning,
                layer: None,
                element: Some(element.id.clone()),
                text: format!("element {:?}: {warning}", element.name),
            })
        });
        warnings.collect()
    }
}

/// Looks at elements, by their positions, on a thread of its own.
fn start(
    questions: Questions,
    elements: Vec<usize>,
    wake: Arc<dyn Fn() + Send + Sync>,
) -> Option<Running> {
    let cancel = Cancel::default();
    let found = Arc::new(Mutex::new((Vec::new(), false)));
    let running = Running {
        cancel: cancel.clone(),
        found: Arc::clone(&found),
    };
    let work = move || {
        for i in elements {
            let scene = &questions.scene;
            let (Some(element), Some(node)) = (scene.elements.all.get(i), &scene.elements.node)
            else {
                break;
            };
            let placed = Arc::clone(&node.elements()[i]);
            let Some(warnings) = warnings(&questions, &element.id, &placed, &cancel) else {
                break;
            };
            let any = !warnings.is_empty();
            found.lock().0.push((placed, warnings));
            if any {
                wake();
            }
        }
        found.lock().1 = true;
        wake();
    };
    let thread = std::thread::Builder::new().name("relievo-survey".to_owned());
    match thread.spawn(work) {
        Ok(_) => Some(running),
        Err(error) => {
            tracing::warn!("planning elements are not looked at: {error}");
            None
        }
    }
}

/// What is odd about an element on the ground; `None` once nobody wants to know. A ground that cannot
/// be read says so elsewhere.
fn warnings(
    questions: &Questions,
    id: &ElementId,
    placed: &PlacedElement,
    cancel: &Cancel,
) -> Option<Vec<String>> {
    let reach = placed.prepared().reach().iter();
    let high_rad = reach.map(|r| r.south_rad - r.north_rad).fold(0.0, f64::max);
    let spacing_m = (high_rad * questions.planet.radius_m / CELLS).clamp(0.5, 50.0);
    let answer = questions.element(id, spacing_m, cancel);
    if cancel.is_cancelled() {
        return None;
    }
    Some(answer.ok().flatten().map_or_else(Vec::new, |a| a.warnings))
}
