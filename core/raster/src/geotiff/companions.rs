//! Files beside a TIFF: overviews (`.ovr`), masks (`.msk`) and GDAL's notes (`.aux.xml`).

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::pam::Pam;
use crate::open::content_hash;

/// Bytes of notes read at most: more are no notes.
const MOST_NOTES_BYTES: u64 = 4 << 20;

/// What lies beside a TIFF.
#[derive(Debug, Default)]
pub(crate) struct Companions {
    /// `NAME.tif.ovr`: further levels.
    pub(super) overviews: Option<PathBuf>,
    /// `NAME.tif.msk` and its own overviews: masks.
    pub(super) masks: Vec<PathBuf>,
    /// `NAME.tif.aux.xml`.
    notes: Option<PathBuf>,
}

impl Companions {
    /// Looks beside a file.
    pub(crate) fn beside(path: &Path) -> Self {
        let beside = |ending: &str| {
            let mut name = path.as_os_str().to_owned();
            name.push(ending);
            let companion = PathBuf::from(name);
            companion.is_file().then_some(companion)
        };
        Self {
            overviews: beside(".ovr"),
            masks: [".msk", ".msk.ovr"]
                .into_iter()
                .filter_map(beside)
                .collect(),
            notes: beside(".aux.xml"),
        }
    }

    /// Adds what tells one state of the companions from another.
    pub(super) fn hash_into(&self, hash: &mut blake3::Hasher) {
        for path in self.overviews.iter().chain(&self.masks).chain(&self.notes) {
            // One that vanished meanwhile counts as none.
            if let Ok(own) = content_hash(path) {
                hash.update(own.finalize().as_bytes());
            }
        }
    }

    /// The notes; none if there are none or they make no sense.
    pub(super) fn notes(&self) -> Pam {
        let Some(path) = &self.notes else {
            return Pam::default();
        };
        let mut text = Vec::new();
        match File::open(path).and_then(|f| f.take(MOST_NOTES_BYTES).read_to_end(&mut text)) {
            Ok(_) => Pam::parse(&String::from_utf8_lossy(&text)),
            Err(error) => {
                tracing::warn!(?path, %error, "notes beside a file are left out");
                Pam::default()
            }
        }
    }
}
