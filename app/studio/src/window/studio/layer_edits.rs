//! What commands do to layers.

use std::path::PathBuf;

use relievo_engine::SourceState;
use relievo_engine::planet::Camera;
use relievo_engine::project::{
    Adjust, Blend, ClassedBy, Edit, Layer, LayerId, LayerKind, SourceRole, Tint, TintInterpolation,
    TintLayer, TintStop, VectorStyle, layer_from_source,
};
use relievo_engine::raster::crs::Crs;

use super::Studio;
use crate::commands::Command;
use crate::coverage::Coverage;
use crate::window::classes::Recipe;
use crate::window::layers;
use crate::window::messages::Weight;
use crate::window::panes::Pane;

/// Heights and colours of a new layer of height colours: a map's.
const COLOURS: [(f64, [u8; 3]); 8] = [
    (-8000.0, [22, 50, 92]),
    (-200.0, [110, 164, 196]),
    (-1.0, [176, 208, 220]),
    (0.0, [96, 140, 92]),
    (400.0, [152, 176, 112]),
    (1500.0, [206, 186, 132]),
    (3500.0, [160, 126, 100]),
    (6000.0, [246, 246, 246]),
];

impl Studio {
    pub(super) fn edit_selected(&mut self, command: Command) {
        let Some(id) = self.selected.clone() else {
            return;
        };
        let project = self.document.project();
        let (Some(layer), Some(index)) = (project.layer(&id), project.layer_index(&id)) else {
            return;
        };
        let edit = if command == Command::RemoveLayer {
            let neighbour = index.checked_sub(1).unwrap_or(index + 1);
            self.selected = project.layers.get(neighbour).map(|l| l.id.clone());
            Some(Edit::RemoveLayer { id })
        } else if command == Command::ToggleVisible {
            Some(Edit::SetVisible {
                visible: !layer.visible,
                id,
            })
        } else {
            layers::step(self.document.engine(), &id, command == Command::MoveUp)
        };
        if let Some(edit) = edit {
            self.edit(edit);
        }
    }

    /// Selects another layer where the selected one is gone.
    pub(super) fn keep_selection(&mut self) {
        let project = self.document.project();
        if self
            .selected
            .as_ref()
            .is_none_or(|id| project.layer(id).is_none())
        {
            self.selected = project.layers.last().map(|l| l.id.clone());
        }
    }

    pub(super) fn add_made(&mut self, name: &str, kind: LayerKind) {
        let engine = self.document.engine();
        let id = engine.history().fresh_layer_id(engine.project(), name);
        self.selected = Some(id.clone());
        self.edit(Edit::AddLayer {
            index: None,
            layer: Box::new(Layer::new(id, name, kind)),
        });
        self.layout.open(Pane::Inspector);
    }

    /// Adds layers for files as one undo step.
    pub(super) fn add_sources(&mut self, files: Vec<(PathBuf, Result<SourceRole, String>)>) {
        let engine = self.document.engine();
        let was_empty = engine.project().layers.is_empty();
        let mut after = engine.project().clone();
        let mut edits = Vec::new();
        for (path, role) in files {
            let path = std::path::absolute(&path).unwrap_or(path);
            let stem = path
                .file_stem()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned();
            let id = engine.history().fresh_layer_id(&after, &stem);
            let made = role.and_then(|role| {
                layer_from_source(id, engine.folder(), &path, role).map_err(|e| e.to_string())
            });
            match made {
                Ok(layer) => {
                    after.layers.push(layer.clone());
                    edits.push(Edit::AddLayer {
                        index: None,
                        layer: Box::new(layer),
                    });
                }
                Err(reason) => {
                    self.log.add(Weight::Error, reason);
                    self.layout.open(Pane::Messages);
                }
            }
        }
        if edits.is_empty() {
            return;
        }
        let label = if edits.len() == 1 {
            String::new()
        } else {
            format!("Add {} layers", edits.len())
        };
        self.selected = after.layers.last().map(|l| l.id.clone());
        self.edit(Edit::Batch { label, edits });
        self.layout.open(Pane::Inspector);
        if was_empty {
            // The file is still being opened; where it lies is known to a later command only.
            self.log
                .add(Weight::News, "Press F to fly to the new layer");
        }
    }

    /// Has classes made of a vector layer's features.
    pub(super) fn classify(&self, id: LayerId, recipe: Recipe) {
        let engine = self.document.engine();
        let layer = engine.project().layer(&id);
        let state = layer.and_then(|l| engine.sources().state(&l.kind, engine.folder()));
        if let Some(SourceState::Features(open)) = state {
            self.inbox.classify(id, open, recipe);
        }
    }

    /// Gives a vector layer the classes that were made.
    pub(super) fn classified(&mut self, id: LayerId, made: Result<ClassedBy, String>) {
        let made = match made {
            Ok(made) => made,
            Err(reason) => {
                self.log.add(Weight::Error, reason);
                self.layout.open(Pane::Messages);
                return;
            }
        };
        let kind = self.document.project().layer(&id).map(|l| l.kind.clone());
        if let Some(LayerKind::Vector(vector)) = kind {
            let style = VectorStyle {
                by: Some(made),
                ..vector.style
            };
            self.edit(Edit::SetVectorStyle {
                id,
                style: Box::new(style),
            });
        }
    }

    pub(super) fn zoom_to_layer(&mut self) {
        let engine = self.document.engine();
        let layer = self
            .selected
            .as_ref()
            .and_then(|id| engine.project().layer(id));
        let state = layer.and_then(|l| engine.sources().state(&l.kind, engine.folder()));
        if let Some(SourceState::Features(open)) = &state {
            let planet = engine.project().planet.body.figure();
            if let Some(seen) = Coverage::of_features(&open.features) {
                self.fly_above(seen.camera(&planet));
            }
            return;
        }
        let Some(SourceState::Open(file)) = state else {
            self.log.add(
                Weight::Warning,
                "the layer's file is not open, so its place is not known",
            );
            return;
        };
        let planet = engine.project().planet.body.figure();
        let place = file.info().georeference.as_ref();
        let Some((crs, place)) = place.and_then(|g| Some((Crs::parse(&g.crs).ok()?, g))) else {
            return;
        };
        let seen = Coverage::of(&crs, &place.plane_from_pixel, file.info());
        self.fly_above(seen.camera(&planet));
    }

    pub(super) fn fly_to(&mut self, to: Camera) {
        let planet = self.document.project().planet.body.figure();
        let (here_m, there_m) = (self.ground_below_m(), self.ground_m(to.map_point()));
        self.navigation.fly_to(&planet, here_m, to, there_m);
    }

    /// Flies to a camera whose altitude counts from the ground, which may not be known there yet.
    pub(super) fn fly_above(&mut self, to: Camera) {
        let planet = self.document.project().planet.body.figure();
        let (here_m, there_m) = (self.ground_below_m(), self.ground_m(to.map_point()));
        self.navigation.fly_above(&planet, here_m, to, there_m);
    }
}

/// A layer that colours heights like a map.
pub(super) fn map_colours() -> TintLayer {
    let stops = COLOURS
        .map(|(height_m, colour)| TintStop::new(height_m, colour))
        .to_vec();
    let tint = Tint {
        stops,
        interpolation: TintInterpolation::Smooth,
    };
    TintLayer {
        tint,
        blend: Blend::Normal,
        adjust: Adjust::default(),
    }
}
