//! Progress bars on standard error, where somebody looks at it.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Steps of a bar.
const STEPS: u64 = 1000;

/// A bar that goes away when it is dropped; invisible unless standard error is a terminal.
pub(crate) struct Progress(ProgressBar);

impl Progress {
    /// A bar for work that is called so.
    pub(crate) fn new(work: &'static str) -> Self {
        let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::stderr());
        if let Ok(style) =
            ProgressStyle::with_template("{msg} {bar:32} {percent:>3} % {elapsed} (left: {eta})")
        {
            bar.set_style(style);
        }
        bar.set_message(work);
        Self(bar)
    }

    /// Shows that a share of 0 to 1 is done.
    pub(crate) fn set(&self, share: f64) {
        self.0
            .set_position((share.clamp(0.0, 1.0) * STEPS as f64) as u64);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
