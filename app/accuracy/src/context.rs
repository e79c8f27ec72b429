//! What a suite runs with.

use std::path::PathBuf;
use std::sync::OnceLock;

use relievo_engine::raster::Cancel;
use relievo_gpu::{AdapterClass, Gpu};

use crate::SuiteError;

/// Whether suites may look for a graphics adapter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviceWish {
    /// The best one that answers, if any.
    IfAny,
    /// None: what needs one says so in its table.
    Without,
}

/// What a suite runs with.
pub struct Context<'a> {
    /// Whether to measure fewer settings less often: enough to see that all works.
    pub quick: bool,
    /// Threads for what is made on several, at least 1. What is timed runs on one unless it says so.
    pub threads: usize,
    /// A project to measure on, where a suite takes one; its own scenes without.
    pub project: Option<PathBuf>,
    /// Whether other programs that are installed may be run beside ours. Without them a suite says so.
    pub peers: bool,
    /// Asks to stop.
    pub cancel: Cancel,
    /// Takes the share that is done, 0 to 1.
    pub progress: &'a dyn Fn(f64),
    device: DeviceWish,
    gpu: OnceLock<Result<Gpu, String>>,
}

impl core::fmt::Debug for Context<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Context")
            .field("quick", &self.quick)
            .field("threads", &self.threads)
            .field("project", &self.project)
            .field("device", &self.device)
            .finish_non_exhaustive()
    }
}

impl<'a> Context<'a> {
    /// A context without a project and without other programs, for all cores.
    pub fn new(quick: bool, device: DeviceWish, progress: &'a dyn Fn(f64)) -> Self {
        Self {
            quick,
            threads: std::thread::available_parallelism().map_or(2, usize::from),
            project: None,
            peers: false,
            cancel: Cancel::default(),
            progress,
            device,
            gpu: OnceLock::new(),
        }
    }

    /// The device, opened when first asked for; why there is none otherwise.
    ///
    /// # Errors
    /// A sentence for the report.
    pub fn gpu(&self) -> Result<&Gpu, &str> {
        let open = || match self.device {
            DeviceWish::Without => Err("no graphics device was asked for".to_owned()),
            DeviceWish::IfAny => Gpu::headless().map_err(|error| error.to_string()),
        };
        self.gpu.get_or_init(open).as_ref().map_err(String::as_str)
    }

    /// Name of the adapter, if a suite has opened it.
    pub fn adapter(&self) -> Option<String> {
        let gpu = self.gpu.get()?.as_ref().ok()?;
        Some(gpu.info.name.clone())
    }

    /// One of two values: for a quick run or a full one.
    pub fn pick<T>(&self, quick: T, full: T) -> T {
        if self.quick { quick } else { full }
    }

    /// Size of pictures: of a quick run, of a full one; half the sides where the device draws and the
    /// reference is looked at in software, so that a full run ends while somebody waits.
    pub fn picture_px(&self, quick: [u32; 2], full: [u32; 2]) -> [u32; 2] {
        let is_software = |gpu: &Gpu| gpu.class == AdapterClass::Software;
        if self.gpu().is_ok_and(is_software) {
            self.pick(quick, full.map(|side| side / 2))
        } else {
            self.pick(quick, full)
        }
    }

    /// Tells how much is done, `done` of `all` steps, and whether to go on.
    ///
    /// # Errors
    /// [`SuiteError::Cancelled`].
    pub fn step(&self, done: usize, all: usize) -> Result<(), SuiteError> {
        (self.progress)(done as f64 / all.max(1) as f64);
        self.go_on()
    }

    /// Whether to go on.
    ///
    /// # Errors
    /// [`SuiteError::Cancelled`].
    pub fn go_on(&self) -> Result<(), SuiteError> {
        if self.cancel.is_cancelled() {
            return Err(SuiteError::Cancelled);
        }
        Ok(())
    }
}
