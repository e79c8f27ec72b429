//! What draws the planet in a window: a renderer on the window's own device.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use eframe::{egui, egui_wgpu};
use relievo_engine::{Frame, project};
use relievo_gpu::{FrameStats, Gpu, Picture, Quality, ReadError, RenderError, Renderer, Setting};

use crate::picture::{self, Fineness};

/// Samples along the smallest colour window that is worth drawing with.
const LEAST_WINDOW: u32 = 256;

/// Levels that a view of a whole planet needs.
const LEAST_LAYERS: u32 = 32;

/// A renderer for a window.
pub(crate) struct Stage {
    gpu: Gpu,
    renderer: Arc<Mutex<Renderer>>,
    quality: Quality,
    most_window: u32,
    stats: Option<FrameStats>,
}

impl Stage {
    /// A stage on a window's device for a project's settings, or for a setting of the front, with colour
    /// windows of at most `most_window` samples, as far as the device's textures go.
    ///
    /// # Errors
    /// One line that says why the adapter does not do.
    pub(crate) fn new(
        state: &egui_wgpu::RenderState,
        settings: &project::Quality,
        chosen: Option<&Setting>,
        most_window: u32,
    ) -> Result<Self, String> {
        let limits = state.device.limits();
        let side = limits.max_texture_dimension_2d;
        if side < LEAST_WINDOW || limits.max_texture_array_layers < LEAST_LAYERS {
            return Err(format!(
                "the graphics adapter {} is too small: textures of {side} pixels and {} layers, expected {LEAST_WINDOW} and {LEAST_LAYERS}",
                state.adapter.get_info().name,
                limits.max_texture_array_layers,
            ));
        }
        let gpu = Gpu::shared(&state.adapter, &state.device, &state.queue);
        // Windows are powers of two.
        let most_window = most_window.min(1 << side.ilog2());
        let fineness = picture::fineness(settings, gpu.class, chosen);
        let quality = limited(fineness.quality, most_window);
        let renderer =
            Renderer::new(&gpu, state.target_format, quality).map_err(|e| e.to_string())?;
        Ok(Self {
            gpu,
            renderer: Arc::new(Mutex::new(renderer)),
            quality,
            most_window,
            stats: None,
        })
    }

    /// Whether a project's settings ask for other windows than it draws with: for these it takes another
    /// stage.
    pub(crate) fn has_other_windows(&self, settings: &project::Quality) -> bool {
        let fineness = picture::fineness(settings, self.gpu.class, None);
        limited(fineness.quality, self.most_window).colour_window != self.quality.colour_window
    }

    /// How finely a project is drawn with the windows that it has; `chosen`: a setting of the front.
    pub(crate) fn fineness(
        &self,
        settings: &project::Quality,
        chosen: Option<&Setting>,
    ) -> Fineness {
        let fineness = picture::fineness(settings, self.gpu.class, chosen);
        let colour_window = self.quality.colour_window;
        Fineness {
            quality: Quality {
                colour_window,
                ..fineness.quality
            },
            ..fineness
        }
    }

    /// The largest windows that are smaller than those it draws with; `None` at the smallest.
    pub(crate) fn smaller_window(&self) -> Option<u32> {
        let smaller = self.quality.colour_window / 2;
        (smaller >= LEAST_WINDOW).then_some(smaller)
    }

    /// What is spent by default on its adapter.
    pub(crate) fn standard(&self) -> Quality {
        Quality::for_adapter(self.gpu.class)
    }

    /// Whether the device is gone.
    pub(crate) fn is_lost(&self) -> bool {
        self.gpu.loss.is_lost()
    }

    /// Name of the adapter.
    pub(crate) fn adapter(&self) -> &str {
        &self.gpu.info.name
    }

    /// What the latest frame cost.
    pub(crate) fn stats(&self) -> Option<&FrameStats> {
        self.stats.as_ref()
    }

    /// Draws a frame, made for a view of that fineness, into the stage's own picture. `rests` says whether
    /// nothing moves.
    ///
    /// # Errors
    /// When the device is lost or has no room, or an upload does not fit.
    pub(crate) fn draw(
        &mut self,
        frame: &Frame,
        fineness: &Fineness,
        rests: bool,
    ) -> Result<(), RenderError> {
        let label = Some("stage/encoder");
        let mut encoder = self
            .gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor { label });
        let mut renderer = lock(&self.renderer);
        if fineness.quality != self.quality {
            match renderer.set_quality(fineness.quality) {
                Ok(()) => self.quality = fineness.quality,
                // It is drawn as before, which is no less right.
                Err(error) => tracing::warn!("{error}"),
            }
        }
        renderer.set_rests(rests);
        let stats = renderer.render(frame, &mut encoder)?;
        drop(renderer);
        self.gpu.queue.submit([encoder.finish()]);
        self.stats = Some(stats);
        Ok(())
    }

    /// A shape that shows the latest picture in a rectangle.
    pub(crate) fn shape(&self, rect: egui::Rect) -> egui::Shape {
        egui_wgpu::Callback::new_paint_callback(rect, Blit(Arc::clone(&self.renderer))).into()
    }

    /// The latest picture in memory.
    ///
    /// # Errors
    /// When the device is lost.
    pub(crate) fn picture(&self) -> Result<Picture, ReadError> {
        lock(&self.renderer).read_back()
    }
}

fn limited(quality: Quality, most_window: u32) -> Quality {
    Quality {
        colour_window: quality.colour_window.min(most_window),
        ..quality
    }
}

/// A renderer is whole after any panic: it holds no half-made state between calls.
fn lock(renderer: &Mutex<Renderer>) -> MutexGuard<'_, Renderer> {
    renderer.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Shows the picture inside egui's own pass.
struct Blit(Arc<Mutex<Renderer>>);

impl egui_wgpu::CallbackTrait for Blit {
    fn paint(
        &self,
        _info: egui::PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        _resources: &egui_wgpu::CallbackResources,
    ) {
        lock(&self.0).blit(pass);
    }
}

/// How a window's device is opened.
pub(crate) fn wgpu_options() -> egui_wgpu::WgpuConfiguration {
    let mut setup = egui_wgpu::WgpuSetupCreateNew::without_display_handle();
    let native =
        wgpu::Backends::VULKAN | wgpu::Backends::METAL | wgpu::Backends::DX12 | wgpu::Backends::GL;
    setup.instance_descriptor.backends = wgpu::Backends::from_env().unwrap_or(native);
    setup.device_descriptor = Arc::new(relievo_gpu::device_descriptor);
    egui_wgpu::WgpuConfiguration {
        wgpu_setup: setup.into(),
        ..egui_wgpu::WgpuConfiguration::default()
    }
}
