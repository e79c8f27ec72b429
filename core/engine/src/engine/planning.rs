//! From a view to windows: which clip levels are shown, and where they lie.

use std::sync::Arc;

use relievo_planet::Planet;
use relievo_planet::clipmap::plan::{PlanInput, Quality};

use super::Engine;
use crate::frame::ClipKind;
use crate::terrain::{self, Bounds};
use crate::view::View;

/// What a plan was made for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PlanQuery {
    view: View,
    planet: Planet,
    exaggeration: f64,
    ground: (Bounds, f64),
    finest: (u8, u8),
    /// Which clipmaps are drawn.
    shows: [bool; 3],
}

impl Engine {
    /// What a plan depends on beside the view: bounds of the drawn terrain, and its height below the
    /// eye.
    pub(super) fn ground(&self, view: &View) -> (Bounds, f64) {
        (
            terrain::bounds(&self.stacks.height),
            self.ground_m(view.camera.map_point()),
        )
    }

    /// What is asked of the planner for a view; the ground is that of the latest plan.
    pub(super) fn plan_input<'a>(&self, view: &View, terrain: &'a Bounds) -> PlanInput<'a> {
        let settings = &self.project.planet;
        PlanInput {
            camera: view.camera,
            planet: settings.body.figure(),
            viewport_px: view.viewport_px,
            ground_m: self.planned_on.1,
            terrain,
            exaggeration: self.exaggeration(),
            quality: Quality {
                layout: view.layout,
                colour_samples: view.colour_window,
                height_texel_px: view.height_texel_px,
                colour_texel_px: view.colour_texel_px,
                max_taps: view.max_taps,
                finest_height_level: self.finest.0,
                finest_colour_level: self.finest.1,
            },
        }
    }

    /// All that decides a plan beside the plan before it.
    fn plan_query(&self, view: &View) -> PlanQuery {
        let settings = &self.project.planet;
        PlanQuery {
            view: *view,
            planet: settings.body.figure(),
            exaggeration: self.exaggeration(),
            ground: self.planned_on,
            finest: self.finest,
            shows: ClipKind::ALL.map(|kind| self.shown.root(kind).is_some()),
        }
    }

    /// Whether the plan is final and every window has the shape and place that it says.
    fn follows(&self) -> bool {
        self.plan.as_ref().is_some_and(|plan| {
            plan.settled
                && ClipKind::ALL.into_iter().all(|kind| {
                    let levels = if kind == ClipKind::Height {
                        &plan.heights
                    } else {
                        &plan.colours
                    };
                    self.shown.root(kind).is_none() || self.stacks.get(kind).follows(levels)
                })
        })
    }

    pub(super) fn replan(&mut self, view: &View) {
        if !self.dirty && self.plan.as_ref().is_some_and(|p| p.settled) {
            return;
        }
        let below = view.camera.map_point();
        let (terrain, ground_m) = self.ground(view);
        self.planned_on = (terrain, ground_m);
        let near = self.plan.as_ref().map_or(below, |p| p.focus);
        let target = self.target();
        let windows = [view.layout.height_window, view.colour_window];
        let found_for = Some((target.revision, near, windows));
        if self.finest_for != found_for {
            let [heights, colours] = windows.map(|size| target.finest_near(near, size));
            (self.finest, self.finest_for) = ((heights, colours), found_for);
        }
        let asked = self.plan_query(view);
        if self.planned_for == Some(asked) && self.follows() {
            // Tiles arrived or have other names: nothing that a plan depends on.
            return;
        }
        self.planned_for = Some(asked);
        let mut planner = std::mem::take(&mut self.planner);
        let plan = planner.plan(&self.plan_input(view, &terrain));
        self.planner = planner;
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
}
