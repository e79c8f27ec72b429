//! A window on a project, mostly without a GPU.

use std::path::{Path, PathBuf};

use eframe::egui::accesskit::Role;
use eframe::egui::{Key, Modifiers, Pos2, Rect, vec2};
use egui_kittest::kittest::Queryable;
use egui_kittest::{Harness, HarnessBuilder};
use relievo::window::{Studio, StudioOptions};
use relievo_engine::project::{Layer, LayerKind};

/// A project of noise and two tints.
pub(crate) const PROJECT: &str = r##"{"version": 1, "layers": [
    {"id": "hills", "name": "Hills", "kind": "noise", "amplitude_m": 900.0, "wavelength_m": 500000.0, "octaves": 3},
    {"id": "low", "name": "Low tint", "kind": "tint", "stops": [{"height_m": 0.0, "colour": "#102030"}]},
    {"id": "high", "name": "High tint", "kind": "tint", "stops": [{"height_m": 0.0, "colour": "#f0e0d0"}]}]}"##;

/// A view from 20 km straight down on ground at the datum.
pub(crate) const PLAIN: &str = r#"{"version": 1,
    "camera": {"lon_deg": 10.0, "lat_deg": 45.0, "altitude_m": 20000.0},
    "layers": [{"id": "hills", "name": "Hills", "kind": "noise", "amplitude_m": 1.0, "wavelength_m": 500000.0, "octaves": 3}]}"#;

/// A window on a project in a folder of its own.
pub(crate) struct Window {
    pub(crate) harness: Harness<'static, Studio>,
    pub(crate) file: PathBuf,
    folder: tempfile::TempDir,
}

impl Window {
    pub(crate) fn open(text: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("sample.relievo");
        std::fs::write(&file, text).unwrap();
        Self::start(folder, file, true)
    }

    /// A window that draws the planet, on the machine's graphics device or in software.
    pub(crate) fn open_drawn(folder: tempfile::TempDir, file: PathBuf) -> Self {
        let builder = Harness::builder().with_size(vec2(1280.0, 800.0)).wgpu();
        Self::start_in(folder, file, true, builder)
    }

    /// The next run on the same file.
    pub(crate) fn again(self) -> Self {
        self.restarted(true)
    }

    /// The program ended without warning and is started again; `open`: on the file.
    pub(crate) fn restarted(self, open: bool) -> Self {
        let Self {
            harness,
            file,
            folder,
        } = self;
        drop(harness);
        Self::start(folder, file, open)
    }

    /// The window is closed in order.
    pub(crate) fn end(&mut self) {
        self.harness.state_mut().finish();
    }

    /// A window with a list of recent projects in the folder; `open`: on the file.
    pub(crate) fn start(folder: tempfile::TempDir, file: PathBuf, open: bool) -> Self {
        let builder = Harness::builder().with_size(vec2(1200.0, 800.0));
        Self::start_in(folder, file, open, builder)
    }

    fn start_in(
        folder: tempfile::TempDir,
        file: PathBuf,
        open: bool,
        builder: HarnessBuilder<Studio>,
    ) -> Self {
        let mut studio = Studio::new(StudioOptions {
            threads: Some(1),
            cache_folder: None,
            disk_cache: 0,
            state_folder: Some(folder.path().join("state")),
            file_dialogs: false,
        })
        .unwrap();
        if open {
            studio.open_project(&file).unwrap();
        }
        let harness = builder.build_eframe(|cc| {
            studio.attach(cc);
            studio
        });
        let mut window = Self {
            harness,
            file,
            folder,
        };
        window.harness.run_steps(3);
        window
    }

    pub(crate) fn steps(&mut self) {
        self.harness.run_steps(3);
    }

    /// Goes on until something that another thread has to say is there.
    pub(crate) fn until(&mut self, what: &str, there: impl Fn(&Self) -> bool) {
        for _ in 0..20_000 {
            if there(self) {
                return;
            }
            self.harness.run_steps(1);
            std::thread::yield_now();
        }
        panic!("never came: {what}");
    }

    /// The rectangle of the planet's picture.
    pub(crate) fn view(&self) -> Rect {
        self.harness.get_by_label("View of the planet").rect()
    }

    pub(crate) fn click_at(&mut self, at: Pos2) {
        self.harness.hover_at(at);
        self.harness.run_steps(1);
        self.harness.drag_at(at);
        self.harness.run_steps(1);
        self.harness.drop_at(at);
        self.steps();
        // So that the next click is no double click.
        self.harness.run_steps(30);
    }

    pub(crate) fn has_button(&self, label: &str) -> bool {
        self.harness
            .query_by_role_and_label(Role::Button, label)
            .is_some()
    }

    pub(crate) fn click(&mut self, label: &str) {
        self.harness
            .get_by_role_and_label(Role::Button, label)
            .click();
        self.steps();
    }

    pub(crate) fn press(&mut self, modifiers: Modifiers, key: Key) {
        self.harness.key_press_modifiers(modifiers, key);
        self.steps();
    }

    pub(crate) fn layers(&self) -> &[Layer] {
        &self.harness.state().document().project().layers
    }

    pub(crate) fn order(&self) -> Vec<&str> {
        self.layers().iter().map(|l| l.id.0.as_str()).collect()
    }

    pub(crate) fn brightness(&self, id: &str) -> f64 {
        match &self.layers().iter().find(|l| l.id.0 == id).unwrap().kind {
            LayerKind::Tint(tint) => tint.adjust.brightness,
            other @ (LayerKind::Imagery(_)
            | LayerKind::Height(_)
            | LayerKind::Noise(_)
            | LayerKind::Detail(_)
            | LayerKind::Slope(_)
            | LayerKind::Contours(_)
            | LayerKind::Vector(_)
            | LayerKind::Unknown { .. }) => panic!("expected a tint, found {}", other.name()),
        }
    }

    pub(crate) fn undo_label(&self) -> Option<String> {
        self.harness
            .state()
            .document()
            .engine()
            .history()
            .undo_label()
            .map(str::to_owned)
    }

    /// Drags with the main button in a few steps.
    pub(crate) fn drag(&mut self, from: Pos2, to: Pos2) {
        self.harness.hover_at(from);
        self.harness.run_steps(1);
        self.harness.drag_at(from);
        self.harness.run_steps(1);
        for i in 1..=4 {
            self.harness.hover_at(from + (to - from) * (i as f32 / 4.0));
            self.harness.run_steps(1);
        }
        self.harness.drop_at(to);
        self.steps();
    }

    /// A point of the view, in shares of its height from its middle.
    pub(crate) fn at(&self, x: f32, y: f32) -> Pos2 {
        let view = self.view();
        view.center() + vec2(x, y) * view.height()
    }

    /// Answers the question for a path, where there is no file dialog.
    pub(crate) fn type_path(&mut self, path: &Path) {
        self.until("the question for a path", |w| {
            w.harness
                .query_by_role_and_label(Role::TextInput, "Path")
                .is_some()
        });
        self.harness
            .get_by_role_and_label(Role::TextInput, "Path")
            .focus();
        self.steps();
        self.harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
        self.harness
            .get_by_role_and_label(Role::TextInput, "Path")
            .type_text(path.to_str().unwrap());
        self.press(Modifiers::NONE, Key::Enter);
    }
}

/// The sample project with its data, in a folder of its own.
pub(crate) fn sample() -> (tempfile::TempDir, PathBuf) {
    let projects = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../projects");
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data");
    std::fs::create_dir(&data).unwrap();
    for file in std::fs::read_dir(projects.join("data")).unwrap() {
        let file = file.unwrap();
        std::fs::copy(file.path(), data.join(file.file_name())).unwrap();
    }
    let file = folder.path().join("my-plan.relievo");
    std::fs::copy(projects.join("earth.relievo"), &file).unwrap();
    (folder, file)
}
