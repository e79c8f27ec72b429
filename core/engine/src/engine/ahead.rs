//! Where the camera is going, and what will be visible there: prefetched after all that is visible
//! now, so that it costs nothing while visible work is waiting.

use relievo_graph::ContentId;
use relievo_planet::camera::PathAhead;
use relievo_planet::clipmap::{Plan, PlanInput, Planner};
use relievo_tiles::{Focus, Want};
use rustc_hash::FxHashSet;

use super::Engine;
use super::asking::named;
use crate::scene::Scene;
use crate::view::View;

/// How far ahead the path is looked along, seconds: about the time that a frame's tiles take, and as
/// far as a hand keeps to what it does.
const AHEAD_S: [f64; 2] = [0.2, 0.6];

/// The camera's path on a clock that runs while frames are asked for.
#[derive(Default)]
pub(super) struct Ahead {
    path: PathAhead,
    clock_s: f64,
    moving: bool,
}

impl Engine {
    /// Notes where the camera is, `dt_s` after it was looked at last.
    pub(super) fn observe(&mut self, view: &View, dt_s: f32) {
        if !dt_s.is_finite() {
            // A still: time does not pass, and nothing lies ahead.
            self.ahead = Ahead::default();
            return;
        }
        self.ahead.clock_s += f64::from(dt_s.max(0.0));
        let radius_m = self.project.planet.body.figure().radius_m;
        let ground_m = self.planned_on.1 * self.exaggeration();
        let clock_s = self.ahead.clock_s;
        let path = &mut self.ahead.path;
        path.observe(clock_s, &view.camera, ground_m, radius_m);
        let moving = path.after(AHEAD_S[0]).is_some();
        // What was asked for along a path that has ended is taken back.
        self.dirty |= self.ahead.moving && !moving;
        self.ahead.moving = moving;
    }

    /// Tiles along the path that are not made yet, and where the camera is and will be.
    pub(super) fn wants_ahead(
        &self,
        scene: &Scene,
        plan: &Plan,
        asked: &FxHashSet<ContentId>,
    ) -> (Vec<Want>, Focus) {
        let mut focus = Focus {
            finest: finest(plan),
            ..Focus::from(plan.focus)
        };
        let mut wants = Vec::new();
        let Some(view) = self.view else {
            return (wants, focus);
        };
        let mut told = FxHashSet::default();
        for seconds in AHEAD_S {
            let Some(camera) = self.ahead.path.after(seconds) else {
                break;
            };
            let there = Planner::new().plan(&PlanInput {
                ground_m: self.ground_m(camera.map_point()),
                camera,
                ..self.plan_input(&view, &self.planned_on.0)
            });
            focus.ahead = there.focus;
            focus.finest = focus.finest.max(finest(&there));
            for (kind, key) in there.wanted_tiles() {
                for (kind, key, id) in named(scene, kind, key) {
                    let is_new = !asked.contains(&id) && told.insert(id);
                    if is_new && wants.len() < self.prefetch && self.tiles.get(id).is_none() {
                        wants.extend(scene.root(kind).map(|root| scene.want(root, key)));
                    }
                }
            }
        }
        (wants, focus)
    }
}

/// Finest level of a plan.
fn finest(plan: &Plan) -> u8 {
    let last = [plan.heights.last(), plan.colours.last()];
    last.into_iter()
        .flatten()
        .map(|l| l.level.n)
        .max()
        .unwrap_or(0)
}
