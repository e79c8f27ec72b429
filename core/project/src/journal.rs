//! The autosaved journal: edits since the last save, on disk within two seconds.
//!
//! A journal is a file beside the project (or in the user's state folder where that is read-only). It
//! names the hash of the project's file that it extends, and holds one record for each edit: length,
//! checksum, JSON. A thread writes and syncs it, so that whoever edits never waits for the disk. A
//! record that was torn by a crash is dropped with all behind it. Before a save replaces the project,
//! the journal notes what the project will be, so that after a crash it is known which of its edits
//! the file already has.

mod reader;
mod untitled;
mod writer;

use std::io;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

pub use reader::{Recovery, RecoveryError};
pub use untitled::{Abandoned, abandoned, forget_untitled, is_untitled, keep_untitled};

use crate::{Edit, FileStamp};

/// Where journals lie and how soon edits are in them.
#[derive(Clone, Debug)]
pub struct JournalOptions {
    /// The user's folder for what programs keep between runs: journals of projects in folders that
    /// cannot be written lie there. `None`: such projects have no journal.
    pub state_folder: Option<PathBuf>,
    /// How long the writer gathers edits before it writes and syncs them. Default 1 s, which leaves
    /// the disk another second to stay below two.
    pub gather: Duration,
}

impl Default for JournalOptions {
    fn default() -> Self {
        Self {
            state_folder: None,
            gather: Duration::from_secs(1),
        }
    }
}

/// What the writer is to do, in the order of events.
#[derive(Debug)]
enum Entry {
    Edit(Box<Edit>),
    /// The project's file is about to become this.
    Saving(FileStamp),
    /// The project's file is this now.
    Saved(FileStamp),
    /// The file is not needed any more.
    Discard,
}

#[derive(Debug, Default)]
struct Shared {
    entries: Vec<Entry>,
    /// Those who wait until everything before them is on disk.
    waiting: Vec<std::sync::mpsc::SyncSender<()>>,
    /// Nothing comes any more.
    is_over: bool,
    problem: Option<String>,
}

#[derive(Debug, Default)]
struct Mailbox {
    shared: Mutex<Shared>,
    wake: Condvar,
}

impl Mailbox {
    fn lock(&self) -> std::sync::MutexGuard<'_, Shared> {
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Keeps the edits of one project since its last save. Dropped, it writes what is left and stays on
/// disk; [`Journal::discard`] takes it away.
#[derive(Debug)]
pub struct Journal {
    mailbox: Arc<Mailbox>,
    thread: Option<JoinHandle<()>>,
}

impl Journal {
    /// A journal for the project at `project`, whose file's content is `stamp`. The file is made with
    /// the first edit; one that is there from earlier is kept under another name (`.old` behind it).
    ///
    /// # Errors
    /// Where the system refuses a thread.
    pub fn start(project: &Path, stamp: FileStamp, options: JournalOptions) -> io::Result<Self> {
        let writer = writer::Writer::new(project, stamp, options);
        Self::run(writer)
    }

    /// Goes on with a journal whose edits have been replayed.
    ///
    /// # Errors
    /// Where the system refuses a thread.
    pub fn resume(recovery: &Recovery, options: JournalOptions) -> io::Result<Self> {
        Self::run(writer::Writer::resume(recovery, options))
    }

    fn run(writer: writer::Writer) -> io::Result<Self> {
        let mailbox = Arc::new(Mailbox::default());
        let theirs = Arc::clone(&mailbox);
        let thread = std::thread::Builder::new()
            .name("relievo-journal".to_owned())
            .spawn(move || writer.run(&theirs))?;
        Ok(Self {
            mailbox,
            thread: Some(thread),
        })
    }

    /// Notes an edit that has been applied (an undo or redo as the edit that it applied). Costs a
    /// copy of the edit, in which geometry is shared.
    pub fn record(&self, edit: &Edit) {
        let mut shared = self.mailbox.lock();
        // Of a run of edits of one value only the last matters.
        let key = edit.merge_key();
        // Where a change stands among others depends on those before.
        let key = key.filter(|_| !places_change(edit));
        if key.is_some()
            && let Some(Entry::Edit(last)) = shared.entries.last_mut()
            && last.merge_key() == key
        {
            **last = edit.clone();
            return;
        }
        shared.entries.push(Entry::Edit(Box::new(edit.clone())));
        drop(shared);
        self.mailbox.wake.notify_one();
    }

    /// Notes what the project's file is about to become, before it does: see
    /// [`save_with`](crate::save_with). Waits until that is on disk, at most two seconds.
    pub fn saving(&self, stamp: FileStamp) {
        self.send(Entry::Saving(stamp));
        self.flush(Duration::from_secs(2));
    }

    /// Notes that the project's file is this now: the edits before are not needed any more.
    pub fn saved(&self, stamp: FileStamp) {
        self.send(Entry::Saved(stamp));
    }

    /// Ends the journal and removes its file: the project was closed, its edits not wanted.
    pub fn discard(self) {
        self.send(Entry::Discard);
    }

    /// Waits until all edits so far are on disk; `false` where that took too long or failed.
    pub fn flush(&self, at_most: Duration) -> bool {
        let (done, is_done): (_, Receiver<()>) = sync_channel(1);
        self.mailbox.lock().waiting.push(done);
        self.mailbox.wake.notify_one();
        match is_done.recv_timeout(at_most) {
            Ok(()) => self.problem().is_none(),
            Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => false,
        }
    }

    /// Why the last edits could not be written, in a line that names the file; the writer tries again
    /// with the next.
    pub fn problem(&self) -> Option<String> {
        self.mailbox.lock().problem.clone()
    }

    fn send(&self, entry: Entry) {
        self.mailbox.lock().entries.push(entry);
        self.mailbox.wake.notify_one();
    }
}

impl Drop for Journal {
    fn drop(&mut self) {
        self.mailbox.lock().is_over = true;
        self.mailbox.wake.notify_one();
        if let Some(thread) = self.thread.take() {
            drop(thread.join());
        }
    }
}

/// Whether an edit puts a change among those of a scenario.
fn places_change(edit: &Edit) -> bool {
    if let Edit::Batch { edits, .. } = edit {
        return edits.iter().any(places_change);
    }
    matches!(edit, Edit::SetChange { .. })
}

/// Begins a journal.
const MAGIC: &[u8; 18] = b"relievo journal 1\n";
/// Length and checksum before each record.
const RECORD_HEAD_BYTES: usize = 12;
/// Longest record.
const MOST_RECORD_BYTES: usize = 1 << 30;

/// The journal beside a project.
fn beside(project: &Path) -> PathBuf {
    let mut name = project.as_os_str().to_owned();
    name.push(".journal");
    PathBuf::from(name)
}

/// Where a journal goes that makes room for another.
fn aside(journal: &Path) -> PathBuf {
    let mut name = journal.as_os_str().to_owned();
    name.push(".old");
    PathBuf::from(name)
}

/// The journal of a project in a state folder.
fn in_state_folder(project: &Path, state_folder: &Path) -> PathBuf {
    let full = std::path::absolute(project).unwrap_or_else(|_odd| project.to_owned());
    let hash = blake3::hash(full.as_os_str().as_encoded_bytes());
    let name = project.file_name().unwrap_or_default().to_string_lossy();
    let number = &hash.to_hex()[..16];
    state_folder
        .join("journals")
        .join(format!("{number}-{name}.journal"))
}

/// The first eight bytes of the payload's hash.
fn checksum(payload: &[u8]) -> [u8; 8] {
    let hash = blake3::hash(payload);
    let mut sum = [0; 8];
    sum.copy_from_slice(&hash.as_bytes()[..8]);
    sum
}
