//! Stills: drawn once, when nothing is missing any more.

use std::time::{Duration, Instant};

use relievo_engine::{ClipKind, Engine, Frame, View};

use crate::device::Gpu;
use crate::quality::Look;
use crate::readback::ReadError;
use crate::renderer::{RenderError, Renderer};
use crate::stats::FrameStats;

/// How many frames may pass without a settled plan once nothing is missing.
const MOST_SETTLING_FRAMES: u32 = 200;

/// Why there is no still.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StillError {
    /// Somebody asked to stop.
    #[error("cancelled")]
    Cancelled,
    /// The engine has no frame for the view.
    #[error("the view was not taken")]
    NoFrame,
    /// The device refused.
    #[error(transparent)]
    Render(#[from] RenderError),
}

/// A picture that is drawn and submitted.
#[derive(Debug)]
pub struct Still {
    /// What drew it.
    pub renderer: Renderer,
    /// The last frame, without its uploads.
    pub frame: Frame,
    /// What the drawn frame cost.
    pub drawn: FrameStats,
    /// Whether nothing is missing.
    pub converged: bool,
}

impl Still {
    /// Waits until nothing is missing, or the time is over, and draws. `watch` is told the share that
    /// is done, 0 to 1, and says whether to go on.
    ///
    /// # Errors
    /// [`StillError`].
    pub fn draw(
        engine: &mut Engine,
        view: View,
        gpu: &Gpu,
        mut renderer: Renderer,
        limit: Option<Duration>,
        watch: &mut dyn FnMut(f64) -> bool,
    ) -> Result<Self, StillError> {
        let started = Instant::now();
        engine.set_view(view);
        // Nobody sees a still before it is done: what comes is kept for the one frame that is drawn.
        let (mut held, mut most_pending) = (Vec::new(), 1);
        let mut settling = 0;
        loop {
            let mut frame = engine.drain(f32::INFINITY).ok_or(StillError::NoFrame)?;
            let complete = frame.is_converged() && frame.uploads.is_empty();
            settling += u32::from(complete);
            let converged = complete && (frame.plan.settled || settling > MOST_SETTLING_FRAMES);
            let over = limit.is_some_and(|l| started.elapsed() >= l);
            most_pending = most_pending.max(frame.pending);
            if !watch(1.0 - frame.pending as f64 / most_pending as f64) {
                return Err(StillError::Cancelled);
            }
            held.append(&mut frame.uploads);
            if converged || over {
                // Levels that an earlier plan had are gone.
                held.retain(|upload| (upload.layer as usize) < levels(&frame, upload.clipmap));
                frame.uploads = held;
                let drawn = Self::submit(&mut renderer, &frame, gpu)?;
                frame.uploads.clear();
                return Ok(Self {
                    renderer,
                    frame,
                    drawn,
                    converged,
                });
            }
            if !complete {
                let left = limit.map_or(Duration::MAX, |l| l.saturating_sub(started.elapsed()));
                engine.wait(left.min(Duration::from_millis(100)));
            }
        }
    }

    /// Draws a frame with a renderer of one's own, and submits it.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn submit(
        renderer: &mut Renderer,
        frame: &Frame,
        gpu: &Gpu,
    ) -> Result<FrameStats, RenderError> {
        let descriptor = wgpu::CommandEncoderDescriptor::default();
        let mut encoder = gpu.device.create_command_encoder(&descriptor);
        let drawn = renderer.render(frame, &mut encoder)?;
        gpu.queue.submit([encoder.finish()]);
        Ok(drawn)
    }

    /// Draws the picture once more and waits for the device, to be timed. Each call draws, because the
    /// air differs by what nobody sees.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn redraw(&mut self, gpu: &Gpu) -> Result<(), RenderError> {
        let look = self.renderer.look();
        let usual = Look::default().haze;
        let haze = if look.haze == usual {
            usual * 1.000_01
        } else {
            usual
        };
        self.renderer.set_look(Look { haze });
        self.drawn = Self::submit(&mut self.renderer, &self.frame, gpu)?;
        match gpu.wait() {
            Ok(()) => Ok(()),
            Err(ReadError::DeviceLost) => Err(RenderError::DeviceLost),
        }
    }
}

/// Number of levels of a clipmap.
fn levels(frame: &Frame, clipmap: ClipKind) -> usize {
    match clipmap {
        ClipKind::Height => frame.heights.len(),
        ClipKind::Colour => frame.colours.len(),
        ClipKind::Normal => frame.normals.len(),
    }
}
