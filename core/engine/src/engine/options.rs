//! How an engine works and what it reports of itself.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use relievo_project::OpenProjectError;
use relievo_tiles::{DiskOptions, TilesOptions};

/// Bound of the finished tiles in the cache folder unless told otherwise.
pub const DEFAULT_DISK_CACHE_BYTES: u64 = 2 << 30;

/// How an engine works.
pub struct EngineOptions {
    /// Worker threads; `None`: all cores but one.
    pub threads: Option<usize>,
    /// Bound of the tile cache in bytes.
    pub memory: usize,
    /// Where pyramids of big images and finished tiles are kept from run to run; `None`: nowhere,
    /// pyramids are made in memory.
    pub cache_folder: Option<PathBuf>,
    /// Bound in bytes of the finished tiles in the cache folder; 0: none are kept there.
    pub disk_cache: u64,
    /// Whether [`Engine::take_log`](super::Engine::take_log) records which tiles were made.
    pub log: bool,
    /// Whether [`Engine::nodes`](super::Engine::nodes) counts what each node made. Not together with `log`.
    pub tally: bool,
    /// How often files are looked at, so that one that changed on disk, came back or is gone is
    /// noticed; `None`: only when [`Engine::look_at_files`](super::Engine::look_at_files) is called.
    pub watch: Option<Duration>,
    /// Called from other threads when there is something to drain.
    pub wake: Option<Arc<dyn Fn() + Send + Sync>>,
}

impl Default for EngineOptions {
    /// All cores but one, 1 GiB, the user's cache folder with 2 GiB of tiles, files as they were opened.
    fn default() -> Self {
        Self {
            threads: None,
            memory: 1 << 30,
            cache_folder: default_cache_folder(),
            disk_cache: DEFAULT_DISK_CACHE_BYTES,
            log: false,
            tally: false,
            watch: None,
            wake: None,
        }
    }
}

impl EngineOptions {
    pub(super) fn tiles(&self) -> TilesOptions {
        let mut tiles = TilesOptions {
            memory: self.memory,
            log: self.log || self.tally,
            ..TilesOptions::default()
        };
        if let Some(threads) = self.threads {
            tiles.threads = threads.max(1);
        }
        if let Some(wake) = self.wake.clone() {
            tiles.wake = Some(Box::new(move || wake()));
        }
        if let (Some(folder), 1..) = (&self.cache_folder, self.disk_cache) {
            tiles.disk = Some(DiskOptions {
                bytes: self.disk_cache,
                ..DiskOptions::new(folder.clone())
            });
        }
        tiles
    }
}

/// The user's cache folder for Relievo, where the system has one.
pub fn default_cache_folder() -> Option<PathBuf> {
    directories::ProjectDirs::from("", "", "relievo").map(|d| d.cache_dir().to_owned())
}

/// The user's folder for what Relievo keeps between runs, journals among it, where the system has one.
pub fn default_state_folder() -> Option<PathBuf> {
    directories::ProjectDirs::from("", "", "relievo")
        .map(|d| d.state_dir().unwrap_or(d.data_local_dir()).to_owned())
}

/// Why a project could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The file.
    #[error(transparent)]
    Project(#[from] OpenProjectError),
    /// The system.
    #[error("cannot start the threads that make tiles: {0}")]
    Threads(std::io::Error),
}

/// The folder that a project's relative paths start at.
pub fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// What the engine is doing and did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EngineStats {
    /// The scheduler and its cache.
    pub tiles: relievo_tiles::Stats,
    /// Visible tiles that are still to come.
    pub pending: usize,
    /// Files that are being opened.
    pub opening: usize,
    /// Time all workers together spent making tiles, nanoseconds.
    pub busy_ns: u128,
    /// What the engine remembers beside the cache.
    pub kept: Kept,
}

/// Sizes of what the engine remembers, each of which stays bounded however long it runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Kept {
    /// Tiles in windows.
    pub resident: usize,
    /// Finished tiles that no window has taken yet.
    pub arrived: usize,
    /// Tiles that are asked for.
    pub asked: usize,
    /// Names of tiles.
    pub names: usize,
    /// Files.
    pub files: usize,
    /// Nodes that outlive their revision, with the geometry of their files.
    pub nodes: usize,
    /// Messages.
    pub messages: usize,
}
