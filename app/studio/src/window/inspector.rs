//! The settings of the selected layer.

mod adjust;
mod colour_detail;
mod dated;
pub(crate) mod element;
mod heights;
mod mask;
mod relief;
mod tint;
mod vector;

use eframe::egui::{self, CollapsingHeader, RichText, ScrollArea, TextEdit, Ui};
use relievo_engine::project::{
    Blend, Edit, HeightLayer, ImageryLayer, Layer, LayerId, LayerKind, Project, Resampling, Source,
    TintLayer,
};
use relievo_engine::{Engine, SourceState};

use super::action::Action;
use super::controls::{self, Number};
use crate::commands::{Command, entry_of};
pub(crate) use element::ElementForm;

const OPACITY: Number = Number::new(
    "Opacity",
    "How much of the layer covers what lies below",
    0.0..=1.0,
    1.0,
);
const EDGE_FADE: Number = Number::new(
    "Edge fade",
    "Width over which the layer fades in from its edge, on the ground",
    0.0..=100_000.0,
    0.0,
)
.unit(" m", 0)
.logarithmic();

const SEAM_BLEND: Number = Number::new(
    "Seam blend",
    "How far from the edge of its data the layer's colours bend to those below; its pattern stays",
    0.0..=1_000_000.0,
    0.0,
)
.unit(" m", 0)
.logarithmic();

const BLENDS: [(Blend, &str); 18] = [
    (Blend::Normal, "Normal"),
    (Blend::Multiply, "Multiply"),
    (Blend::Add, "Add"),
    (Blend::Screen, "Screen"),
    (Blend::Overlay, "Overlay"),
    (Blend::Subtract, "Subtract"),
    (Blend::Difference, "Difference"),
    (Blend::Exclusion, "Exclusion"),
    (Blend::Darken, "Darken"),
    (Blend::Lighten, "Lighten"),
    (Blend::ColourDodge, "Colour dodge"),
    (Blend::ColourBurn, "Colour burn"),
    (Blend::HardLight, "Hard light"),
    (Blend::SoftLight, "Soft light"),
    (Blend::Hue, "Hue"),
    (Blend::Saturation, "Saturation"),
    (Blend::Colour, "Colour"),
    (Blend::Luminosity, "Luminosity"),
];

const RESAMPLINGS: [(Resampling, &str); 3] = [
    (Resampling::Nearest, "Nearest pixel"),
    (Resampling::Bilinear, "Bilinear"),
    (Resampling::Bicubic, "Bicubic"),
];

/// What the inspector remembers from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct Inspector {
    /// The name that is being typed.
    name: Option<(LayerId, String)>,
    /// The place in a series that is being typed.
    dated: dated::Typed,
}

impl Inspector {
    /// Draws it.
    pub(crate) fn show(
        &mut self,
        ui: &mut Ui,
        engine: &Engine,
        selected: Option<&LayerId>,
        actions: &mut Vec<Action>,
    ) {
        ScrollArea::vertical()
            .auto_shrink([false, false])
            .show(ui, |ui| {
                if let Some(layer) = selected.and_then(|id| engine.project().layer(id)) {
                    self.layer(ui, engine, layer, actions);
                } else {
                    ui.add_space(8.0);
                    ui.weak("Select a layer to see its settings.");
                }
                ui.add_space(8.0);
            });
    }

    fn layer(&mut self, ui: &mut Ui, engine: &Engine, layer: &Layer, actions: &mut Vec<Action>) {
        let id = &layer.id;
        ui.push_id(&id.0, |ui| {
            ui.add_enabled_ui(!layer.locked, |ui| {
                self.name(ui, layer, actions);
                file(ui, engine, layer, actions);
                let opacity = |opacity| Edit::SetOpacity {
                    id: id.clone(),
                    opacity,
                };
                controls::number(ui, &OPACITY, layer.opacity, actions, opacity);
                match &layer.kind {
                    LayerKind::Imagery(l) => imagery(ui, engine.project(), layer, l, actions),
                    LayerKind::Height(l) => height(ui, id, l, actions),
                    LayerKind::Noise(l) => heights::noise(ui, id, &l.noise, actions),
                    LayerKind::Detail(l) => heights::detail(ui, id, &l.detail, actions),
                    LayerKind::Tint(l) => tint_layer(ui, id, l, actions),
                    LayerKind::Slope(l) => {
                        blend(ui, id, l.blend, actions);
                        section(ui, "Colours", |ui| relief::slope(ui, id, l, actions));
                    }
                    LayerKind::Contours(l) => {
                        blend(ui, id, l.blend, actions);
                        section(ui, "Lines", |ui| relief::contours(ui, id, l, actions));
                    }
                    LayerKind::Vector(l) => {
                        let state = engine.sources().state(&layer.kind, engine.folder());
                        let features = if let Some(SourceState::Features(open)) = &state {
                            Some(&*open.features)
                        } else {
                            None
                        };
                        section(ui, "Style", |ui| {
                            vector::show(ui, id, &l.style, features, actions);
                        });
                    }
                    LayerKind::Unknown { kind } => {
                        ui.weak(format!(
                            "A layer of kind {kind}, made by a newer Relievo. It is kept as it is."
                        ));
                    }
                }
                let is_known = !matches!(layer.kind, LayerKind::Unknown { .. });
                if is_known && layer.kind.may_be_masked() {
                    mask::show(ui, engine.project(), layer, actions);
                }
                if is_known {
                    dated::show(ui, &mut self.dated, engine.project(), layer, actions);
                }
            });
            ui.add_space(6.0);
            ui.horizontal(|ui| {
                let mut locked = layer.locked;
                let hint = "A locked layer cannot be changed in the window";
                if ui
                    .checkbox(&mut locked, "Locked")
                    .on_hover_text(hint)
                    .changed()
                {
                    actions.push(Action::Edit(Edit::SetLocked {
                        id: id.clone(),
                        locked,
                    }));
                }
                for command in [Command::ZoomToLayer, Command::RemoveLayer] {
                    let entry = entry_of(command);
                    let enabled = command == Command::ZoomToLayer || !layer.locked;
                    let button = ui.add_enabled(enabled, egui::Button::new(entry.title));
                    if button.on_hover_text(entry.help).clicked() {
                        actions.push(Action::Run(command));
                    }
                }
            });
        });
    }

    fn name(&mut self, ui: &mut Ui, layer: &Layer, actions: &mut Vec<Action>) {
        if self.name.as_ref().is_none_or(|(id, _)| *id != layer.id) {
            self.name = Some((layer.id.clone(), layer.name.clone()));
        }
        let Some((_, text)) = &mut self.name else {
            return;
        };
        ui.horizontal(|ui| {
            let label = controls::name(ui, "Name", false);
            let hint = layer.id.0.as_str();
            let field = TextEdit::singleline(text)
                .desired_width(f32::INFINITY)
                .char_limit(250)
                .hint_text(hint);
            let response = ui
                .add(field)
                .labelled_by(label.id)
                .on_hover_text("What the list calls the layer");
            if response.lost_focus() && *text != layer.name {
                if ui.input(|i| i.key_pressed(egui::Key::Escape)) {
                    text.clone_from(&layer.name);
                } else {
                    actions.push(Action::Edit(Edit::SetName {
                        id: layer.id.clone(),
                        name: text.trim().to_owned(),
                    }));
                }
            } else if !response.has_focus() && *text != layer.name {
                text.clone_from(&layer.name);
            }
        });
    }
}

/// What lies behind a layer.
fn file(ui: &mut Ui, engine: &Engine, layer: &Layer, actions: &mut Vec<Action>) {
    let Some(path) = layer.path() else { return };
    let state = engine.sources().state(&layer.kind, engine.folder());
    ui.horizontal(|ui| {
        controls::name(ui, "File", false);
        ui.add(egui::Label::new(path).truncate())
            .on_hover_text(path);
    });
    let text = match state {
        Some(SourceState::Open(file)) => {
            let info = file.info();
            let (size, crs) = (
                info.overviews[0],
                info.georeference.as_ref().map_or("no system", |g| &*g.crs),
            );
            format!(
                "{} × {} px, {}, {crs}",
                size.width, size.height, info.sample_type
            )
        }
        Some(SourceState::Features(open)) => format!(
            "{} features, {} vertices, {}, {}",
            open.features.len(),
            open.features.vertices(),
            open.summary.format,
            open.summary.crs
        ),
        Some(SourceState::Opening(share)) => format!("being opened, {:.0} %", share * 100.0),
        Some(SourceState::Failed(reason)) => {
            let text = RichText::new(format!("! {reason}"))
                .small()
                .color(ui.visuals().error_fg_color);
            ui.add(egui::Label::new(text).wrap());
            let entry = entry_of(Command::Locate);
            if ui.button(entry.title).on_hover_text(entry.help).clicked() {
                actions.push(Action::Run(Command::Locate));
            }
            return;
        }
        None => return,
    };
    ui.add(egui::Label::new(RichText::new(text).small().weak()).wrap());
}

fn imagery(
    ui: &mut Ui,
    project: &Project,
    layer: &Layer,
    imagery: &ImageryLayer,
    actions: &mut Vec<Action>,
) {
    let id = &layer.id;
    blend(ui, id, imagery.blend, actions);
    source(ui, id, &imagery.source, actions);
    edges(ui, id, imagery, actions);
    colour_detail::show(ui, project, layer, &imagery.detail, actions);
    section(ui, "Adjust", |ui| {
        adjust::show(ui, id, &imagery.adjust, actions);
    });
}

/// How the layer meets what lies below where its data end.
fn edges(ui: &mut Ui, id: &LayerId, imagery: &ImageryLayer, actions: &mut Vec<Action>) {
    let seam = |seam_blend_m| Edit::SetSeamBlend {
        id: id.clone(),
        seam_blend_m,
    };
    controls::number(ui, &SEAM_BLEND, imagery.seam_blend_m, actions, seam);
    if let Some(missing) = vector::colour(ui, "Fill holes", imagery.missing) {
        let id = id.clone();
        actions.push(Action::Edit(Edit::SetMissing { id, missing }));
    }
}

fn height(ui: &mut Ui, id: &LayerId, layer: &HeightLayer, actions: &mut Vec<Action>) {
    source(ui, id, &layer.source, actions);
    section(ui, "Heights", |ui| heights::scale(ui, id, layer, actions));
}

fn tint_layer(ui: &mut Ui, id: &LayerId, layer: &TintLayer, actions: &mut Vec<Action>) {
    blend(ui, id, layer.blend, actions);
    section(ui, "Colours", |ui| tint::show(ui, id, &layer.tint, actions));
    section(ui, "Adjust", |ui| {
        adjust::show(ui, id, &layer.adjust, actions);
    });
}

fn blend(ui: &mut Ui, id: &LayerId, value: Blend, actions: &mut Vec<Action>) {
    let edit = |blend| Edit::SetBlend {
        id: id.clone(),
        blend,
    };
    controls::choice(
        ui,
        "Blend",
        "How the layer meets what lies below",
        &BLENDS,
        value,
        actions,
        edit,
    );
}

fn source(ui: &mut Ui, id: &LayerId, source: &Source, actions: &mut Vec<Action>) {
    let edit = |resampling| Edit::SetResampling {
        id: id.clone(),
        resampling,
    };
    let hint = "How samples between the file's pixels are made";
    controls::choice(
        ui,
        "Resampling",
        hint,
        &RESAMPLINGS,
        source.resampling,
        actions,
        edit,
    );
    let fade = |edge_fade_m| Edit::SetEdgeFade {
        id: id.clone(),
        edge_fade_m,
    };
    controls::number(ui, &EDGE_FADE, source.edge_fade_m, actions, fade);
}

fn section(ui: &mut Ui, title: &str, content: impl FnOnce(&mut Ui)) {
    ui.add_space(4.0);
    CollapsingHeader::new(RichText::new(title).strong())
        .default_open(true)
        .show_unindented(ui, content);
}
