//! Bodies that stand on the ground of the picture.

use std::sync::Arc;

use relievo_project::LayerKind;

use super::Engine;
use crate::masses::MassMesh;
use crate::masses::making::{Around, Bodies, Extruded};
use crate::sources::SourceState;
use crate::vectors;
use crate::view::View;

impl Engine {
    /// Bodies of visible vector layers near the view; asks for those that are missing.
    pub(super) fn bodies(&mut self, view: &View) -> Vec<Arc<MassMesh>> {
        let settings = &self.project.planet;
        let rows = f64::from(view.viewport_px[1].max(1));
        let around = Around {
            scene: Arc::clone(&self.shown),
            planet: settings.body.figure(),
            exaggeration: self.exaggeration(),
            place: self
                .plan
                .as_ref()
                .map_or_else(|| view.camera.map_point(), |p| p.focus),
            pixel_rad: 2.0 * libm::tan(0.5 * view.camera.fov_y_rad) / rows,
        };
        if let Some(drawn) = self.bodies.as_ref().and_then(|b| b.as_before(&around)) {
            return drawn;
        }
        let layers = self.extruded();
        if layers.is_empty() {
            self.bodies = None;
            return Vec::new();
        }
        if self.bodies.is_none() {
            let wake = self.wake.clone().unwrap_or_else(|| Arc::new(|| {}));
            match Bodies::new(wake) {
                Ok(bodies) => self.bodies = Some(bodies),
                Err(error) => tracing::warn!("bodies are not drawn: {error}"),
            }
        }
        let bodies = self.bodies.as_mut();
        bodies.map_or_else(Vec::new, |bodies| bodies.follow(&layers, around))
    }

    /// The layers of the shown scenario whose areas stand as bodies.
    fn extruded(&self) -> Vec<Extruded> {
        let project = &self.project;
        let mut found = Vec::new();
        let layers = project.layers_in(project.scenario.as_ref());
        for layer in &*layers {
            let LayerKind::Vector(vector) = &layer.kind else {
                continue;
            };
            let Some(extrude) = &vector.style.extrude else {
                continue;
            };
            let hidden = !layer.visible || layer.is_superseded(&layers, project.date);
            if hidden || layer.opacity <= 0.0 {
                continue;
            }
            let state = self.sources.state(&layer.kind, &self.folder);
            if let Some(SourceState::Features(open)) = state {
                found.push(Extruded {
                    layer: layer.id.clone(),
                    features: Arc::clone(&open.features),
                    style: Arc::new(vectors::style(&vector.style)),
                    extrude: extrude.clone(),
                });
            }
        }
        found
    }
}
