//! Carrying out what panels, keys, dialogs and other threads ask for.

use std::path::{Path, PathBuf};

use eframe::egui::{self, ViewportCommand};
use relievo_engine::SourceState;
use relievo_engine::planet::MapPoint;
use relievo_engine::project::{
    Adjust, Blend, Edit, Layer, LayerId, LayerKind, Noise, NoiseLayer, SaveProjectError,
    SourceRole, Tint, TintInterpolation, TintLayer, TintStop, layer_from_source, resolve_path,
};
use relievo_engine::raster::crs::Crs;
use relievo_engine::relink::{self, Link};

use super::{Dragging, Studio};
use crate::commands::Command;
use crate::coverage::Coverage;
use crate::window::action::Action;
use crate::window::dialogs::{Answer, Destination, Dialog, Then};
use crate::window::inbox::{Event, Purpose};
use crate::window::layers;
use crate::window::messages::Weight;

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
    /// Carries out what a panel asks for.
    pub(super) fn carry_out(&mut self, action: Action, ctx: &egui::Context) {
        match action {
            Action::Edit(_) | Action::BeginDrag if self.dragging == Dragging::TakenBack => {}
            Action::Edit(edit) => self.edit(edit),
            Action::BeginDrag => {
                self.document.begin_drag();
                self.dragging = Dragging::Yes;
            }
            Action::EndDrag => {
                // egui ends a drag at Escape by itself, while the button is still down.
                if self.dragging == Dragging::Yes
                    && !ctx.input(|i| i.key_pressed(egui::Key::Escape))
                {
                    self.document.end_drag();
                    self.dragging = Dragging::No;
                }
            }
            Action::Select(id) => {
                self.selected = id;
                self.inspector.show_layer();
            }
            Action::Run(command) => self.run(command, ctx),
            Action::Open(path) => self.unless_changed(Then::Open(path), ctx),
            Action::ClearRecent => self.recent.clear(),
        }
    }

    /// Applies an edit; one that does not fit is told.
    fn edit(&mut self, edit: Edit) {
        let quality = matches!(edit, Edit::SetQuality { .. });
        if let Err(error) = self.document.apply(edit) {
            self.log
                .add(Weight::Error, format!("the edit does not fit: {error}"));
        }
        if quality {
            self.fit_stage();
        }
    }

    fn run(&mut self, command: Command, ctx: &egui::Context) {
        match command {
            Command::New => self.unless_changed(Then::New, ctx),
            Command::Open => self.unless_changed(Then::PickProject, ctx),
            Command::Save => self.save(None, false, ctx),
            Command::SaveAs => self.pick(Purpose::Save),
            Command::Screenshot => self.pick(Purpose::Picture),
            Command::AddFiles => self.pick(Purpose::Add),
            Command::Quit => ctx.send_viewport_cmd(ViewportCommand::Close),
            Command::Undo | Command::Redo => self.undo_or_redo(command == Command::Undo),
            Command::AddNoise => self.add_made(
                "Noise",
                LayerKind::Noise(NoiseLayer {
                    noise: Noise::default(),
                }),
            ),
            Command::AddTint => self.add_made("Height colours", LayerKind::Tint(map_colours())),
            Command::RemoveLayer | Command::MoveUp | Command::MoveDown | Command::ToggleVisible => {
                self.edit_selected(command);
            }
            Command::ZoomToLayer => self.zoom_to_layer(),
            Command::Locate => {
                self.locating.clone_from(&self.selected);
                self.pick(Purpose::Locate);
            }
            Command::NorthUp => self.north_up(),
            Command::ResetView => self.fly_to(self.document.project().camera.to_camera()),
            Command::GoTo => self.dialog = Some(Dialog::GoTo(Destination::of(self.camera()))),
            Command::ToggleLayers => self.panels.layers ^= true,
            Command::ToggleInspector => self.panels.inspector ^= true,
            Command::ToggleMessages => self.panels.messages ^= true,
            Command::Retry => {
                self.log.clear();
                self.document.engine_mut().retry();
            }
            Command::Help => self.dialog = Some(Dialog::Help),
        }
    }

    fn undo_or_redo(&mut self, undo: bool) {
        let done = if undo {
            self.document.undo()
        } else {
            self.document.redo()
        };
        if let Err(error) = done {
            self.log.add(Weight::Error, error.to_string());
        }
        self.keep_selection();
        self.fit_stage();
    }

    /// Selects another layer where the selected one is gone.
    fn keep_selection(&mut self) {
        let project = self.document.project();
        if self
            .selected
            .as_ref()
            .is_none_or(|id| project.layer(id).is_none())
        {
            self.selected = project.layers.last().map(|l| l.id.clone());
        }
    }

    fn edit_selected(&mut self, command: Command) {
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

    fn add_made(&mut self, name: &str, kind: LayerKind) {
        let engine = self.document.engine();
        let id = engine.history().fresh_layer_id(engine.project(), name);
        self.selected = Some(id.clone());
        self.edit(Edit::AddLayer {
            index: None,
            layer: Box::new(Layer::new(id, name, kind)),
        });
        self.inspector.show_layer();
    }

    /// Adds layers for files as one undo step.
    fn add_sources(&mut self, files: Vec<(PathBuf, Result<SourceRole, String>)>) {
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
                    self.panels.messages = true;
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
        self.inspector.show_layer();
        if was_empty {
            // The file is still being opened; where it lies is known to a later command only.
            self.log
                .add(Weight::News, "Press F to fly to the new layer");
        }
    }

    fn zoom_to_layer(&mut self) {
        let engine = self.document.engine();
        let layer = self
            .selected
            .as_ref()
            .and_then(|id| engine.project().layer(id));
        let state = layer.and_then(|l| engine.sources().state(&l.kind, engine.folder()));
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
        let to = Coverage::of(&crs, &place.plane_from_pixel, file.info()).camera(&planet);
        self.fly_to(to);
    }

    fn fly_to(&mut self, to: relievo_engine::planet::Camera) {
        let planet = self.document.project().planet.body.figure();
        let below = MapPoint::new(to.lon_rad, core::f64::consts::FRAC_PI_2 - to.lat_rad);
        let (here_m, there_m) = (self.ground_below_m(), self.ground_m(below));
        self.navigation.fly_to(&planet, here_m, to, there_m);
    }

    fn pick(&mut self, purpose: Purpose) {
        let own = self.document.path().map(Path::to_owned);
        let folder = self.document.engine().folder().to_owned();
        let named =
            |extension: &str| Some(folder.join(self.document.name()).with_extension(extension));
        let start = match purpose {
            Purpose::Save => own.or_else(|| named("relievo")),
            Purpose::Picture => named("png"),
            Purpose::Open | Purpose::Add => own.or_else(|| Some(folder.join("file"))),
            Purpose::Locate => self.located_beside().or(own),
        };
        self.inbox.pick(purpose, start);
    }

    /// Where the file of the layer that is being located was, if its folder is still there.
    fn located_beside(&self) -> Option<PathBuf> {
        let engine = self.document.engine();
        let layer = engine.project().layer(self.locating.as_ref()?)?;
        let file = resolve_path(engine.folder(), &layer.source()?.path);
        file.parent().is_some_and(Path::is_dir).then_some(file)
    }

    /// Links a layer to a file that was chosen for it. Where files that other layers miss lie beside
    /// it the user is asked about them first.
    pub fn locate(&self, layer: LayerId, file: &Path) {
        let file = std::path::absolute(file).unwrap_or_else(|_odd| file.to_owned());
        let engine = self.document.engine();
        let (project, folder) = (engine.project().clone(), engine.folder().to_owned());
        self.inbox
            .look_beside(Link { layer, file }, project, folder);
    }

    /// Links layers to files as one undo step.
    fn relink(&mut self, links: &[Link]) {
        match relink::relink(self.document.engine().folder(), links) {
            Ok(Some(edit)) => {
                self.edit(edit);
                let files = if links.len() == 1 { "file" } else { "files" };
                self.log
                    .add(Weight::News, format!("linked {} {files}", links.len()));
            }
            Ok(None) => {}
            Err(file) => {
                let text = format!("expected a path in Unicode, found {file:?}");
                self.log.add(Weight::Error, text);
                self.panels.messages = true;
            }
        }
    }

    /// A file was located: asks about others that lie beside it, or links it.
    fn located(&mut self, link: Link, beside: Vec<Link>) {
        let project = self.document.project();
        if project.layer(&link.layer).is_none() {
            return;
        }
        let named = |other: Link| {
            let layer = project.layer(&other.layer).filter(|l| !l.locked)?;
            Some((other, layers::name_of(layer)))
        };
        let beside: Vec<_> = beside.into_iter().filter_map(named).collect();
        if beside.is_empty() {
            self.relink(&[link]);
        } else {
            self.dialog = Some(Dialog::Relink { link, beside });
        }
    }

    /// Does something that loses the project, after asking about unsaved changes.
    pub(super) fn unless_changed(&mut self, then: Then, ctx: &egui::Context) {
        if self.document.is_changed() {
            self.dialog = Some(Dialog::Unsaved(then));
        } else {
            self.go_on(then, ctx);
        }
    }

    fn go_on(&mut self, then: Then, ctx: &egui::Context) {
        match then {
            Then::Quit => {
                self.closing = true;
                ctx.send_viewport_cmd(ViewportCommand::Close);
            }
            Then::PickProject => self.pick(Purpose::Open),
            Then::Open(path) => {
                if let Err(error) = self.open_project(&path) {
                    self.log.add(Weight::Error, error.to_string());
                    self.panels.messages = true;
                    self.look_for_recent();
                }
            }
            Then::New => self.start_new(),
        }
    }

    /// Saves to a path or to the project's own file; asks for a name where there is none.
    fn save(&mut self, path: Option<&Path>, overwrite: bool, ctx: &egui::Context) {
        if path.is_none() && self.document.path().is_none() {
            self.pick(Purpose::Save);
            return;
        }
        let camera = *self.camera();
        match self.document.save(path, &camera, overwrite) {
            Ok(()) => {
                self.log
                    .add(Weight::News, format!("saved {}", self.document.name()));
                self.remember();
                if let Some(then) = self.after_save.take() {
                    self.go_on(then, ctx);
                }
            }
            Err(SaveProjectError::ChangedOnDisk { .. }) => {
                self.dialog = Some(Dialog::ChangedOnDisk);
            }
            Err(error @ (SaveProjectError::Write { .. } | SaveProjectError::Exists { .. })) => {
                self.after_save = None;
                self.log.add(Weight::Error, error.to_string());
                self.panels.messages = true;
            }
        }
    }

    /// Takes what other threads have to say.
    pub(super) fn take_events(&mut self, ctx: &egui::Context) {
        for event in self.inbox.take() {
            match event {
                Event::Picked {
                    purpose,
                    paths,
                    seen,
                } => {
                    if paths.is_empty() && !seen {
                        let start = self.document.engine().folder().join("");
                        self.dialog = Some(Dialog::Path(purpose, start.display().to_string()));
                    } else if paths.is_empty() {
                        (self.after_save, self.locating) = (None, None);
                    }
                    self.use_paths(purpose, paths, ctx);
                }
                Event::Looked(files) => self.add_sources(files),
                Event::Located { link, beside } => self.located(link, beside),
                Event::Missing(projects) => self.recent.set_missing(projects),
                Event::PictureSaved(Ok(path)) => {
                    self.log.add(
                        Weight::News,
                        format!("saved the picture {}", path.display()),
                    );
                }
                Event::PictureSaved(Err(reason)) => {
                    self.log.add(Weight::Error, reason);
                    self.panels.messages = true;
                }
            }
        }
    }

    fn use_paths(&mut self, purpose: Purpose, paths: Vec<PathBuf>, ctx: &egui::Context) {
        let Some(first) = paths.first().cloned() else {
            return;
        };
        match purpose {
            Purpose::Open => self.go_on(Then::Open(first), ctx),
            Purpose::Save => self.save(Some(&with_extension(first, "relievo")), true, ctx),
            Purpose::Add => self.inbox.look_at(paths),
            Purpose::Locate => {
                if let Some(layer) = self.locating.take() {
                    self.locate(layer, &first);
                }
            }
            Purpose::Picture => match self
                .stage
                .as_ref()
                .map(crate::window::stage::Stage::picture)
            {
                Some(Ok(picture)) => self
                    .inbox
                    .save_picture(with_extension(first, "png"), picture),
                Some(Err(error)) => self.log.add(Weight::Error, error.to_string()),
                None => {}
            },
        }
    }

    /// Takes the answer to a dialog.
    pub(super) fn take_answer(&mut self, answer: Answer, ctx: &egui::Context) {
        match answer {
            Answer::Cancel => (self.after_save, self.locating) = (None, None),
            Answer::Save(then) => {
                self.after_save = Some(then);
                self.save(None, false, ctx);
            }
            Answer::Discard(then) => self.go_on(then, ctx),
            Answer::Overwrite => self.save(None, true, ctx),
            Answer::SaveAs => self.pick(Purpose::Save),
            Answer::Reload => {
                if let Some(path) = self.document.path().map(Path::to_owned) {
                    self.go_on(Then::Open(path), ctx);
                }
            }
            Answer::GoTo(to) => self.fly_to(to.camera(self.camera())),
            Answer::Path(purpose, path) => self.use_paths(purpose, vec![path], ctx),
            Answer::Relink(links) => self.relink(&links),
        }
    }
}

fn with_extension(path: PathBuf, extension: &str) -> PathBuf {
    if path.extension().is_some() {
        path
    } else {
        path.with_extension(extension)
    }
}

fn map_colours() -> TintLayer {
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
