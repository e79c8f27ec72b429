//! Options that say what is kept from run to run, and where.

use std::path::PathBuf;

use relievo_engine::{DEFAULT_DISK_CACHE_BYTES, EngineOptions, default_cache_folder};

// Where pyramids of big images and finished tiles are kept. (Not a doc comment: clap would show it as
// what the program is for.)
// Its group would have the name of the program's.
#[derive(Clone, Debug, clap::Args)]
#[group(skip)]
pub(crate) struct Arguments {
    /// Folder for pyramids of big images and finished tiles, kept from run to run; made if it is not
    /// there. Default: the user's cache folder.
    #[arg(long, global = true, value_name = "FOLDER")]
    cache_dir: Option<PathBuf>,
    /// Keep nothing from run to run.
    #[arg(long, global = true, conflicts_with_all = ["cache_dir", "cache_size"])]
    no_cache: bool,
    /// Most that finished tiles take in the cache folder, in MiB; 0 keeps none.
    #[arg(long, global = true, value_name = "MIB", default_value_t = DEFAULT_DISK_CACHE_BYTES >> 20,
        value_parser = clap::value_parser!(u64).range(0..=1 << 30))]
    cache_size: u64,
}

/// The same, decided.
#[derive(Clone, Debug)]
pub struct Cache {
    /// The folder; `None`: nothing is kept.
    pub folder: Option<PathBuf>,
    /// Most that finished tiles take, in bytes.
    pub bytes: u64,
}

impl Default for Cache {
    /// The user's cache folder.
    fn default() -> Self {
        Self {
            folder: default_cache_folder(),
            bytes: DEFAULT_DISK_CACHE_BYTES,
        }
    }
}

impl Arguments {
    pub(crate) fn decide(self) -> Cache {
        let folder = if self.no_cache {
            None
        } else {
            self.cache_dir.or_else(default_cache_folder)
        };
        Cache {
            folder,
            bytes: self.cache_size << 20,
        }
    }
}

/// How engines work for a command.
pub(crate) fn engine_options(threads: Option<usize>, cache: &Cache) -> EngineOptions {
    EngineOptions {
        threads,
        cache_folder: cache.folder.clone(),
        disk_cache: cache.bytes,
        ..EngineOptions::default()
    }
}
