//! Finding an adapter and opening a device on it.
//!
//! Invariant: nothing is asked of an adapter that it does not have; one that lacks what drawing
//! needs is refused by name. Absent: windows; a window's own device is wrapped by [`Gpu::shared`].

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::quality::AdapterClass;
use crate::readback::{self, ReadError};

/// Smallest limits that the clipmap front-end works with.
const MIN_TEXTURE_SIDE: u32 = 4096;
/// See [`MIN_TEXTURE_SIDE`].
const MIN_LAYERS: u32 = 32;

/// Why there is no device to draw with.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// No driver answered.
    #[error(
        "no graphics adapter found: install a Vulkan driver (on Debian libvulkan1 and \
         mesa-vulkan-drivers, which also holds a software one)"
    )]
    NoAdapter(#[source] wgpu::RequestAdapterError),
    /// An adapter cannot do what drawing needs.
    #[error("{adapter} has {what} {found}, drawing needs {needed}")]
    TooSmall {
        /// Its name.
        adapter: String,
        /// The limit.
        what: &'static str,
        /// Its value.
        found: u32,
        /// The least that would do.
        needed: u32,
    },
    /// The driver refused a device.
    #[error("cannot open a device on {adapter}")]
    Device {
        /// Its name.
        adapter: String,
        /// The driver's reason.
        source: wgpu::RequestDeviceError,
    },
}

/// Knows whether a device has been lost; clones look at the same device.
#[derive(Clone, Debug, Default)]
pub struct LossWatch(Arc<AtomicBool>);

impl LossWatch {
    /// Watches a device. Replaces any other loss callback of the device.
    pub fn of(device: &wgpu::Device) -> Self {
        let watch = Self::default();
        let flag = Arc::clone(&watch.0);
        device.set_device_lost_callback(move |reason, message| {
            tracing::warn!(?reason, message, "graphics device lost");
            flag.store(true, Ordering::Release);
        });
        watch
    }

    /// Whether the device is gone for good: everything made with it has to be made again.
    pub fn is_lost(&self) -> bool {
        self.0.load(Ordering::Acquire)
    }
}

/// A device with its queue and what is known of the adapter.
#[derive(Clone, Debug)]
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// Name, driver and kind of the adapter.
    pub info: wgpu::AdapterInfo,
    /// How fast it is, roughly.
    pub class: AdapterClass,
    /// Whether the device is lost.
    pub loss: LossWatch,
}

impl Gpu {
    /// Opens a device without any window: Vulkan, Metal or DirectX 12 where there is one, else
    /// OpenGL. `WGPU_BACKEND` narrows the choice.
    ///
    /// # Errors
    /// If no adapter answers, the best one is too small, or it refuses a device.
    pub fn headless() -> Result<Self, GpuError> {
        let native = wgpu::Backends::VULKAN | wgpu::Backends::METAL | wgpu::Backends::DX12;
        let allowed = wgpu::Backends::from_env().unwrap_or(wgpu::Backends::all());
        Self::open(allowed & native).or_else(|error| match error {
            GpuError::NoAdapter(_) => Self::open(allowed & wgpu::Backends::GL),
            other @ (GpuError::TooSmall { .. } | GpuError::Device { .. }) => Err(other),
        })
    }

    /// Waits until the device has done all that was submitted.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn wait(&self) -> Result<(), ReadError> {
        readback::wait(&self.device)
    }

    fn open(backends: wgpu::Backends) -> Result<Self, GpuError> {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = backends;
        let instance = wgpu::Instance::new(descriptor);
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            force_fallback_adapter: false,
            compatible_surface: None,
            apply_limit_buckets: false,
        }))
        .map_err(GpuError::NoAdapter)?;
        check(&adapter)?;
        let (device, queue) = pollster::block_on(
            adapter.request_device(&device_descriptor(&adapter)),
        )
        .map_err(|source| GpuError::Device {
            adapter: adapter.get_info().name,
            source,
        })?;
        Ok(Self::shared(&adapter, &device, &queue))
    }

    /// Wraps a device that belongs to someone else, such as a window.
    pub fn shared(adapter: &wgpu::Adapter, device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let info = adapter.get_info();
        let class = AdapterClass::of(&info);
        let loss = LossWatch::of(device);
        device.on_uncaptured_error(Arc::new(mind_error));
        tracing::info!(adapter = info.name, ?class, backend = ?info.backend, "graphics device");
        Self {
            device: device.clone(),
            queue: queue.clone(),
            info,
            class,
            loss,
        }
    }
}

/// What becomes of an error that nobody expected. Without memory the device is lost, which whoever
/// draws finds out and can do something about; anything else is a bug.
///
/// # Panics
/// On what is a bug.
fn mind_error(error: wgpu::Error) {
    match error {
        wgpu::Error::OutOfMemory { source } => {
            tracing::error!("the graphics device has no memory left: {source}");
        }
        error @ (wgpu::Error::Validation { .. } | wgpu::Error::Internal { .. }) => {
            panic!("the graphics device was used wrongly, which is a bug: {error}");
        }
    }
}

/// Refuses an adapter that cannot hold clipmaps.
fn check(adapter: &wgpu::Adapter) -> Result<(), GpuError> {
    let limits = adapter.limits();
    let needs = [
        (
            "a largest texture side of",
            limits.max_texture_dimension_2d,
            MIN_TEXTURE_SIDE,
        ),
        (
            "a number of texture layers of",
            limits.max_texture_array_layers,
            MIN_LAYERS,
        ),
        (
            "storage buffers per stage of",
            limits.max_storage_buffers_per_shader_stage,
            2,
        ),
    ];
    match needs.into_iter().find(|(_, found, needed)| found < needed) {
        Some((what, found, needed)) => Err(GpuError::TooSmall {
            adapter: adapter.get_info().name,
            what,
            found,
            needed,
        }),
        None => Ok(()),
    }
}

/// The device that drawing wants from an adapter: also for a window that opens its own.
pub fn device_descriptor(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
    let has = adapter.limits();
    wgpu::DeviceDescriptor {
        label: Some("device/relievo"),
        required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
        required_limits: wgpu::Limits {
            max_texture_dimension_2d: has.max_texture_dimension_2d.min(16_384),
            max_texture_array_layers: has.max_texture_array_layers.min(256),
            max_buffer_size: has.max_buffer_size.min(1 << 30),
            max_storage_buffer_binding_size: has.max_storage_buffer_binding_size.min(1 << 27),
            ..wgpu::Limits::default().or_worse_values_from(&has)
        },
        experimental_features: wgpu::ExperimentalFeatures::disabled(),
        memory_hints: wgpu::MemoryHints::Performance,
        trace: wgpu::Trace::Off,
    }
}
