//! What a pane shows while it waits: nothing for half a second, then how far the work is and a button
//! that stops it.

use std::time::Duration;

use eframe::egui::{ProgressBar, Ui};

use super::latest::{Latest, Waiting};

/// What is over sooner needs no bar.
const PATIENCE: Duration = Duration::from_millis(500);

/// How often the bar is drawn.
const BEAT: Duration = Duration::from_millis(100);

/// Draws it; `what` is what is waited for.
pub(crate) fn show<K, A>(ui: &mut Ui, latest: &mut Latest<K, A>, what: &str)
where
    K: Clone + PartialEq + Send + 'static,
    A: Clone + Send + 'static,
{
    match latest.waiting() {
        Waiting::No => {}
        Waiting::Busy { share, since } => {
            let left = PATIENCE.saturating_sub(since.elapsed());
            ui.ctx().request_repaint_after(left.max(BEAT));
            if !left.is_zero() {
                return;
            }
            ui.horizontal(|ui| {
                let hint = format!("{what}: what was found so far is given up");
                if ui.button("Cancel").on_hover_text(hint).clicked() {
                    latest.stop();
                }
                let bar = ProgressBar::new(share).desired_width(ui.available_width().min(320.0));
                ui.add(bar.text(format!("{what}: {:.0} %", share * 100.0)));
            });
        }
        Waiting::Stopped => {
            ui.horizontal(|ui| {
                ui.weak(format!("{what} was stopped."));
                let again = ui.button("Go on");
                if again.on_hover_text("Begin again").clicked() {
                    latest.forget();
                }
            });
        }
    }
}
