//! The thread that writes a journal.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Seek as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::PoisonError;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::{
    Entry, JournalOptions, MAGIC, Mailbox, Recovery, aside, beside, checksum, in_state_folder,
};
use crate::FileStamp;

pub(super) struct Writer {
    project: PathBuf,
    /// What the edits extend.
    stamp: FileStamp,
    options: JournalOptions,
    /// Made with the first edit.
    file: Option<(File, PathBuf)>,
    /// Bytes of the file that are whole records.
    length: u64,
}

impl Writer {
    pub(super) fn new(project: &Path, stamp: FileStamp, options: JournalOptions) -> Self {
        Self {
            project: project.to_owned(),
            stamp,
            options,
            file: None,
            length: 0,
        }
    }

    pub(super) fn resume(recovery: &Recovery, options: JournalOptions) -> Self {
        let file = OpenOptions::new().write(true).open(recovery.file());
        Self {
            project: recovery.project().to_owned(),
            stamp: recovery.stamp(),
            options,
            file: file.ok().map(|file| (file, recovery.file().to_owned())),
            length: recovery.length(),
        }
    }

    pub(super) fn run(mut self, mailbox: &Mailbox) {
        loop {
            let mut shared = mailbox.lock();
            while shared.entries.is_empty() && shared.waiting.is_empty() && !shared.is_over {
                let woken = mailbox.wake.wait(shared);
                shared = woken.unwrap_or_else(PoisonError::into_inner);
            }
            // More edits of a drag come soon: they cost one sync together.
            let until = Instant::now() + self.options.gather;
            while shared.waiting.is_empty() && !shared.is_over {
                let left = until.saturating_duration_since(Instant::now());
                if left == Duration::ZERO {
                    break;
                }
                let woken = mailbox.wake.wait_timeout(shared, left);
                shared = woken.unwrap_or_else(PoisonError::into_inner).0;
            }
            let entries = core::mem::take(&mut shared.entries);
            let waiting = core::mem::take(&mut shared.waiting);
            let is_over = shared.is_over;
            drop(shared);
            let had_entries = !entries.is_empty();
            let result = self.write(&entries);
            if had_entries {
                let problem = result.err().map(|error| {
                    let path = self
                        .file
                        .as_ref()
                        .map_or_else(|| beside(&self.project), |f| f.1.clone());
                    format!("cannot keep edits safe until the next save: {error}: {path:?}")
                });
                let mut shared = mailbox.lock();
                // What could not be written is tried again, before what came since.
                if problem.is_some() {
                    let newer = core::mem::replace(&mut shared.entries, entries);
                    shared.entries.extend(newer);
                }
                shared.problem = problem;
                if shared.problem.is_some() && !is_over {
                    drop(shared);
                    drop(waiting);
                    std::thread::sleep(self.options.gather);
                    continue;
                }
            }
            for done in waiting {
                // Whoever asked may have stopped waiting.
                done.try_send(()).ok();
            }
            if is_over {
                return;
            }
        }
    }

    fn write(&mut self, entries: &[Entry]) -> io::Result<()> {
        let mut bytes = Vec::new();
        // What a save made superfluous is not written at all.
        let last_saved = entries
            .iter()
            .rposition(|entry| matches!(entry, Entry::Saved(_) | Entry::Discard));
        let rest = if let Some(place) = last_saved {
            if let Entry::Saved(stamp) = &entries[place] {
                self.stamp = *stamp;
            }
            self.remove()?;
            &entries[place + 1..]
        } else {
            entries
        };
        for entry in rest {
            let value = match entry {
                Entry::Edit(edit) => serde_json::to_value(edit).map_err(io::Error::other)?,
                Entry::Saving(stamp) => json!({ "saving": stamp.to_string() }),
                Entry::Saved(_) | Entry::Discard => continue,
            };
            push_record(&value, &mut bytes)?;
        }
        if bytes.is_empty() {
            return Ok(());
        }
        if self.file.is_none() {
            let mut start = MAGIC.to_vec();
            let head = json!({
                "project": self.project.to_string_lossy(),
                "extends": self.stamp.to_string(),
                "version": crate::stored::v1::VERSION,
            });
            push_record(&head, &mut start)?;
            self.file = Some(self.create(&start)?);
            self.length = start.len() as u64;
        }
        let length = self.length;
        let Some((file, _)) = &mut self.file else {
            return Ok(());
        };
        // A record that was torn before is written over.
        file.set_len(length)?;
        file.seek(io::SeekFrom::Start(length))?;
        file.write_all(&bytes)?;
        file.sync_data()?;
        self.length = length + bytes.len() as u64;
        Ok(())
    }

    /// Makes the journal's file beside the project, or in the state folder.
    fn create(&self, start: &[u8]) -> io::Result<(File, PathBuf)> {
        let make = |path: &Path| -> io::Result<File> {
            if let Ok(None) = Recovery::look(path, &self.project, self.stamp) {
                // What is left of a save that a crash cut short, or nothing.
                drop(fs::remove_file(path));
            }
            if path.exists() {
                fs::rename(path, aside(path))?;
            }
            let mut file = OpenOptions::new().write(true).create_new(true).open(path)?;
            file.write_all(start)?;
            file.sync_all()?;
            if let Some(folder) = path.parent().filter(|f| !f.as_os_str().is_empty()) {
                crate::file::sync_folder(folder)?;
            }
            Ok(file)
        };
        let path = beside(&self.project);
        let refused = match make(&path) {
            Ok(file) => return Ok((file, path)),
            Err(error) => error,
        };
        let Some(state_folder) = &self.options.state_folder else {
            return Err(refused);
        };
        let path = in_state_folder(&self.project, state_folder);
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder)?;
        }
        let file = make(&path)?;
        Ok((file, path))
    }

    fn remove(&mut self) -> io::Result<()> {
        let Some((file, path)) = self.file.take() else {
            return Ok(());
        };
        drop(file);
        match fs::remove_file(path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        }
    }
}

fn push_record(value: &Value, bytes: &mut Vec<u8>) -> io::Result<()> {
    let payload = serde_json::to_vec(value)?;
    let length = u32::try_from(payload.len())
        .ok()
        .filter(|length| *length as usize <= super::MOST_RECORD_BYTES)
        .ok_or_else(|| io::Error::other("an edit too long for the journal"))?;
    bytes.extend_from_slice(&length.to_le_bytes());
    bytes.extend_from_slice(&checksum(&payload));
    bytes.extend_from_slice(&payload);
    Ok(())
}
