//! How the window looks, kept from one run to the next: colours, size, where the panes lie.

use std::path::{Path, PathBuf};

use eframe::egui::{Context, ThemePreference};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::panes::Layout;
use super::remembered;

/// Factors on the size of text and controls that one can choose.
const SCALES: [f32; 11] = [0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.25, 1.5, 1.75, 2.0, 2.5];

/// The kept file. Members that are not known are dropped: it is no document.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(default)]
struct Stored {
    theme: ThemePreference,
    scale: Option<f32>,
    panes: Option<Value>,
}

/// What the user chose.
#[derive(Debug)]
pub(crate) struct Settings {
    /// Where it is kept; `None`: nowhere.
    file: Option<PathBuf>,
    theme: ThemePreference,
    scale: f32,
}

impl Settings {
    /// What is kept in a folder, with the layout of the panes.
    pub(crate) fn load(folder: Option<&Path>) -> (Self, Layout) {
        let file = folder.map(|f| f.join("window.json"));
        let stored: Stored = file.as_deref().map(remembered::read).unwrap_or_default();
        let (least, most) = (SCALES[0], SCALES[SCALES.len() - 1]);
        let scale = stored.scale.filter(|s| (least..=most).contains(s));
        let settings = Self {
            file,
            theme: stored.theme,
            scale: scale.unwrap_or(1.0),
        };
        (settings, Layout::of(stored.panes.as_ref()))
    }

    /// Keeps everything.
    pub(crate) fn save(&self, layout: &Layout) {
        let Some(file) = &self.file else { return };
        let stored = Stored {
            theme: self.theme,
            scale: Some(self.scale),
            panes: layout.to_value(),
        };
        remembered::write(file, &stored);
    }

    /// Makes a window look so.
    pub(crate) fn apply(&self, ctx: &Context) {
        ctx.set_theme(self.theme);
        ctx.set_zoom_factor(self.scale);
        ctx.options_mut(|options| {
            // The table of commands has these keys.
            options.zoom_with_keyboard = false;
            // On a slow adapter a frame between press and release can take longer than any limit.
            options.input_options.max_click_duration = f64::INFINITY;
        });
    }

    /// Dark, light, or as the system asks for.
    pub(crate) fn set_theme(&mut self, theme: ThemePreference) {
        self.theme = theme;
    }

    /// Which of them was chosen.
    pub(crate) fn theme(&self) -> ThemePreference {
        self.theme
    }

    /// The next larger or smaller factor.
    pub(crate) fn step_scale(&mut self, larger: bool) {
        let next = if larger {
            SCALES.into_iter().find(|s| *s > self.scale)
        } else {
            SCALES.into_iter().rev().find(|s| *s < self.scale)
        };
        self.scale = next.unwrap_or(self.scale);
    }

    /// As large as the system says.
    pub(crate) fn usual_scale(&mut self) {
        self.scale = 1.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::window::Pane;

    #[test]
    fn what_was_chosen_is_there_again_in_the_next_run() {
        let folder = tempfile::tempdir().unwrap();
        let (mut settings, mut layout) = Settings::load(Some(folder.path()));
        settings.set_theme(ThemePreference::Light);
        settings.step_scale(true);
        layout.open(Pane::Graph);
        settings.save(&layout);
        let (again, layout) = Settings::load(Some(folder.path()));
        assert_eq!(again.theme(), ThemePreference::Light);
        assert_eq!(again.scale, 1.1);
        assert!(layout.is_open(Pane::Graph));
    }

    #[test]
    fn the_size_stays_in_its_range() {
        let (mut settings, _) = Settings::load(None);
        for _ in 0..20 {
            settings.step_scale(true);
        }
        assert_eq!(settings.scale, 2.5);
        for _ in 0..20 {
            settings.step_scale(false);
        }
        assert_eq!(settings.scale, 0.6);
        settings.usual_scale();
        assert_eq!(settings.scale, 1.0);
    }

    #[test]
    fn a_damaged_file_changes_nothing() {
        let folder = tempfile::tempdir().unwrap();
        for text in [
            "{",
            "7",
            r#"{"scale": 1e30, "theme": "Pink"}"#,
            r#"{"scale": 90.0, "panes": []}"#,
        ] {
            std::fs::write(folder.path().join("window.json"), text).unwrap();
            let (settings, layout) = Settings::load(Some(folder.path()));
            assert_eq!(settings.scale, 1.0);
            assert!(layout.is_open(Pane::Layers));
        }
    }
}
