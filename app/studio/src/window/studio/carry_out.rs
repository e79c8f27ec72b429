//! Carrying out what panels and keys ask for.

use eframe::egui::{self, ThemePreference, ViewportCommand};
use relievo_engine::project::{
    ContoursLayer, Detail, DetailLayer, Edit, LayerKind, Noise, NoiseLayer, ScenarioId, SlopeLayer,
};

use super::layer_edits::map_colours;
use super::{Dragging, Studio};
use crate::commands::Command;
use crate::window::action::Action;
use crate::window::bookmarks;
use crate::window::dialogs::{Destination, Dialog, Then};
use crate::window::inbox::Purpose;
use crate::window::messages::Weight;
use crate::window::palette::Palette;
use crate::window::panes::Pane;
use crate::window::tools::Tool;
use crate::window::tools::lens::with_lens;

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
                self.select_element(None);
                self.layout.open(Pane::Inspector);
            }
            Action::SelectElement(id) => self.select_element(id),
            Action::ChooseVertex(id, spot) => self.tools.vertex = Some((id, spot)),
            Action::Fly(to) => self.fly_to(to),
            Action::Compare(other, mode) => self.compare_with(other, mode),
            Action::Jump(steps) => {
                let here = self.document.engine().history().undo_count();
                if let Err(error) = self.document.go_to(here.saturating_add_signed(steps)) {
                    self.log.add(Weight::Error, error.to_string());
                }
                self.keep_selection();
                self.fit_stage();
            }
            Action::FlyTo(id) => {
                self.selected = Some(id);
                self.zoom_to_layer();
            }
            Action::Locate(id) => {
                self.selected = Some(id);
                self.run(Command::Locate, ctx);
            }
            Action::Classify(id, recipe) => self.classify(id, recipe),
            Action::PutLens(id) => {
                let lens = self.usual_lens();
                self.edit(with_lens(self.document.project(), &id, &lens));
            }
            Action::Export(export) => self.pick(Purpose::Export(export)),
            Action::Hide(pane) => self.layout.hide(pane),
            Action::Show(pane) => self.layout.open(pane),
            Action::Run(command) => self.run(command, ctx),
            Action::Open(path) => self.unless_changed(Then::Open(path), ctx),
            Action::ClearRecent => self.recent.clear(),
        }
    }

    /// Applies an edit; one that does not fit is told.
    pub(super) fn edit(&mut self, edit: Edit) {
        let quality = matches!(edit, Edit::SetQuality { .. });
        if let Err(error) = self.document.apply(edit) {
            self.log
                .add(Weight::Error, format!("the edit does not fit: {error}"));
        }
        if quality {
            self.fit_stage();
        }
    }

    pub(super) fn run(&mut self, command: Command, ctx: &egui::Context) {
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
            Command::AddDetail => self.add_made(
                "Detail",
                LayerKind::Detail(DetailLayer {
                    detail: Detail::default(),
                }),
            ),
            Command::Synthesised => {
                let engine = self.document.engine_mut();
                engine.show_synthesised(!engine.shows_synthesised());
            }
            Command::AddTint => self.add_made("Height colours", LayerKind::Tint(map_colours())),
            Command::AddSlope => self.add_made("Slopes", LayerKind::Slope(SlopeLayer::default())),
            Command::AddContours => {
                self.add_made("Contours", LayerKind::Contours(ContoursLayer::default()));
            }
            Command::RemoveLayer
            | Command::MoveUp
            | Command::MoveDown
            | Command::ToggleVisible
            | Command::ZoomToLayer
                if self.run_on_element(command) => {}
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
            Command::GoTo => {
                let body = self.document.project().planet.body;
                self.dialog = Some(Dialog::GoTo(Destination::of(self.camera(), body)));
            }
            Command::Toggle(pane) => self.layout.toggle(pane),
            Command::ResetPanes => self.layout.reset(),
            Command::Use(tool) => self.take_tool(tool),
            Command::Compare(mode) => {
                let other = self.usual_other();
                self.compare_with(other, mode);
            }
            Command::StopComparing => self.stop_comparing(),
            Command::Volumes => {
                self.measure_volumes();
                self.layout.open(Pane::Volumes);
            }
            Command::Contours => {
                self.contour_view();
                self.layout.open(Pane::Contours);
            }
            Command::ClearResults => self.analyses.clear(),
            Command::AddBookmark => self.add_bookmark(),
            Command::Palette => self.palette = Some(Palette::opened(ctx)),
            Command::FollowSystem => self.set_theme(ThemePreference::System, ctx),
            Command::Dark => self.set_theme(ThemePreference::Dark, ctx),
            Command::Light => self.set_theme(ThemePreference::Light, ctx),
            Command::Larger | Command::Smaller | Command::UsualSize => self.scale(command, ctx),
            Command::Retry => {
                self.log.clear();
                self.document.engine_mut().retry();
            }
            Command::Help => self.dialog = Some(Dialog::Help),
        }
    }

    /// Takes a tool for the terrain, and shows the pane that belongs to it.
    fn take_tool(&mut self, tool: Tool) {
        self.tools.choose(tool);
        match tool {
            Tool::Select => {}
            Tool::Observer => self.layout.open(Pane::Viewshed),
            Tool::Water => self.layout.open(Pane::Flood),
            Tool::Hole | Tool::Breakline => self.layout.open(Pane::Inspector),
            Tool::Lens | Tool::LensOutline => {
                self.select_element(None);
                self.layout.open(Pane::Inspector);
            }
            Tool::Polygon | Tool::Corridor | Tool::Brush | Tool::Measure => {
                if !self.layout.is_open(Pane::Elements) {
                    self.layout.open(Pane::Elements);
                }
            }
        }
    }

    pub(super) fn undo_or_redo(&mut self, undo: bool) {
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

    fn add_bookmark(&mut self) {
        let count = self.document.project().bookmarks.len();
        let bookmark = bookmarks::of(self.camera(), format!("Bookmark {}", count + 1));
        self.edit(Edit::AddBookmark {
            index: None,
            bookmark,
        });
        self.layout.open(Pane::Bookmarks);
    }

    /// What a scenario is compared with unless somebody says so: what it was compared with before,
    /// its parent, or for the base the first of all.
    fn usual_other(&self) -> Option<ScenarioId> {
        if let Some(compare) = &self.compare {
            return compare.other.clone();
        }
        let project = self.document.project();
        match &project.scenario {
            Some(id) => project.scenario(id)?.parent.clone(),
            None => project.scenarios.first().map(|s| s.id.clone()),
        }
    }

    fn set_theme(&mut self, theme: ThemePreference, ctx: &egui::Context) {
        self.settings.set_theme(theme);
        self.keep_settings(ctx);
    }

    fn scale(&mut self, command: Command, ctx: &egui::Context) {
        if command == Command::UsualSize {
            self.settings.usual_scale();
        } else {
            self.settings.step_scale(command == Command::Larger);
        }
        self.keep_settings(ctx);
    }

    fn keep_settings(&self, ctx: &egui::Context) {
        self.settings.apply(ctx);
        self.settings.save(&self.layout);
    }
}
