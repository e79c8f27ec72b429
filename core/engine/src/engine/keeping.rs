//! Keeping work safe: the lock that says who has a project, and the journal of unsaved edits.
//!
//! Invariant: with a project that is guarded, every edit is in the journal in the order in which it
//! changed the project, undo and redo included, and the caller never waits for the disk but on a save.

use std::path::{Path, PathBuf};

use relievo_project::{
    Edit, EditError, FileStamp, Journal, JournalOptions, LockError, ProjectLock, Recovery,
    RecoveryError, SaveProjectError, forget_untitled, is_untitled,
};

use super::Engine;

/// What guarding a project found.
#[derive(Debug, Default)]
pub struct Guarded {
    /// Edits that were made before a crash and never saved: for [`Engine::recover`] or
    /// [`Engine::decline`]. Until then nothing of them changes.
    pub offer: Option<Recovery>,
    /// Another program has the project open. Its journal is left alone, so edits made here are not
    /// kept safe until they are saved.
    pub held: Option<LockError>,
    /// A journal is there that cannot be read. It is kept under another name.
    pub unreadable: Option<RecoveryError>,
}

/// What keeps a project's edits.
#[derive(Debug)]
pub(super) struct Keeper {
    path: PathBuf,
    stamp: FileStamp,
    options: JournalOptions,
    /// `None` until the first edit, and where an offer is not answered yet.
    journal: Option<Journal>,
    /// Why there is no journal.
    problem: Option<String>,
    /// The journal of an offer that nobody has answered; it is offered again next time.
    undecided: Option<PathBuf>,
    /// `None` where the folder is read-only.
    _lock: Option<ProjectLock>,
}

impl Keeper {
    fn new(path: &Path, stamp: FileStamp, options: JournalOptions) -> Result<Self, LockError> {
        let lock = match ProjectLock::take(path) {
            Ok(lock) => Some(lock),
            Err(error @ LockError::Held { .. }) => return Err(error),
            Err(LockError::Failed { source, .. }) => {
                tracing::debug!("no lock for {path:?}: {source}");
                None
            }
        };
        Ok(Self {
            path: path.to_owned(),
            stamp,
            options,
            journal: None,
            problem: None,
            undecided: None,
            _lock: lock,
        })
    }

    fn journal(&mut self) -> Option<&Journal> {
        if self.journal.is_none() && self.problem.is_none() {
            match Journal::start(&self.path, self.stamp, self.options.clone()) {
                Ok(journal) => self.journal = Some(journal),
                Err(error) => self.problem = Some(format!("cannot keep edits safe: {error}")),
            }
        }
        self.journal.as_ref()
    }

    /// Throws the journal away, and all of a project that never got a name.
    fn forget(self) {
        if let Some(journal) = self.journal {
            journal.discard();
        }
        if let Some(offered) = &self.undecided
            && let Err(error) = Recovery::put_back(offered)
        {
            tracing::warn!("edits of an earlier run stay aside: {error}: {offered:?}");
        }
        let state_folder = self.options.state_folder.as_deref();
        if state_folder.is_some_and(|folder| is_untitled(&self.path, folder)) {
            forget_untitled(&self.path);
        }
    }

    fn record(&mut self, edit: &Edit) {
        if let Some(journal) = self.journal() {
            journal.record(edit);
        }
    }

    /// Hears what the project's file is about to become.
    pub(super) fn saving(&self, path: &Path, stamp: FileStamp) {
        if let (true, Some(journal)) = (path == self.path, &self.journal) {
            journal.saving(stamp);
        }
    }
}

impl Engine {
    /// Guards the project, which was read from `path` with this stamp, against crashes and against
    /// other programs: takes its lock and keeps a journal of its edits from now on.
    pub fn guard(&mut self, path: &Path, stamp: FileStamp, options: JournalOptions) -> Guarded {
        let state_folder = options.state_folder.clone();
        self.keeper = None;
        let keeper = match Keeper::new(path, stamp, options) {
            Ok(keeper) => keeper,
            Err(held) => {
                return Guarded {
                    held: Some(held),
                    ..Guarded::default()
                };
            }
        };
        self.keeper = Some(keeper);
        Recovery::tidy(path, stamp, state_folder.as_deref());
        match Recovery::find(path, stamp, state_folder.as_deref()) {
            Ok(offer) => {
                if let (Some(offer), Some(keeper)) = (&offer, &mut self.keeper) {
                    keeper.undecided = Some(offer.file().to_owned());
                }
                Guarded {
                    offer,
                    ..Guarded::default()
                }
            }
            Err(error) => Guarded {
                unreadable: Some(error),
                ..Guarded::default()
            },
        }
    }

    /// Guards a project that has no file yet: its beginning and its journal lie in the state folder
    /// until it is saved under a name or [`Self::forget_unsaved`] is called. After a crash
    /// [`abandoned`](relievo_project::abandoned) lists it; such a file is opened and guarded like any.
    ///
    /// # Errors
    /// Where nothing can be written there; edits are then not kept safe.
    pub fn guard_untitled(
        &mut self,
        state_folder: &Path,
        mut options: JournalOptions,
    ) -> Result<(), SaveProjectError> {
        let (path, stamp) =
            relievo_project::keep_untitled(&self.project, &self.folder, state_folder)?;
        options.state_folder = Some(state_folder.to_owned());
        self.guard(&path, stamp, options);
        Ok(())
    }

    /// Applies the edits of a journal, each a step that can be undone, up to the first that does not
    /// fit. Gives how many were applied and why no more were. The journal goes on.
    pub fn recover(&mut self, recovery: &Recovery) -> (usize, Option<EditError>) {
        let keeper = self.keeper.take();
        let mut problem = None;
        let mut count = 0;
        for edit in recovery.edits() {
            if let Err(error) = self.apply(edit.clone()) {
                problem = Some(error);
                break;
            }
            count += 1;
        }
        self.keeper = keeper;
        let Some(keeper) = &mut self.keeper else {
            return (count, problem);
        };
        keeper.undecided = None;
        if problem.is_none() && recovery.fits() {
            match Journal::resume(recovery, keeper.options.clone()) {
                Ok(journal) => keeper.journal = Some(journal),
                Err(error) => keeper.problem = Some(format!("cannot keep edits safe: {error}")),
            }
        } else {
            // The old journal is kept under another name: it holds what did not fit.
            for edit in &recovery.edits()[..count] {
                keeper.record(edit);
            }
        }
        (count, problem)
    }

    /// Throws the edits of a journal away.
    ///
    /// # Errors
    /// Where its file cannot be removed.
    pub fn decline(&mut self, recovery: Recovery) -> std::io::Result<()> {
        if let Some(keeper) = &mut self.keeper {
            keeper.undecided = None;
        }
        recovery.discard()
    }

    /// Ends the guard and throws its journal away: the project is closed and its unsaved edits are not
    /// wanted. An engine that is only dropped leaves the journal, and the edits are offered again.
    pub fn forget_unsaved(&mut self) {
        if let Some(keeper) = self.keeper.take() {
            keeper.forget();
        }
    }

    /// Whether edits are kept safe, and where not, why: a line for the user.
    pub fn keeping_problem(&self) -> Option<String> {
        let keeper = self.keeper.as_ref()?;
        let journal = keeper.journal.as_ref();
        journal
            .and_then(Journal::problem)
            .or_else(|| keeper.problem.clone())
    }

    /// Notes an edit that has changed the project.
    pub(super) fn keep(&mut self, edit: &Edit) {
        if let Some(keeper) = &mut self.keeper {
            keeper.record(edit);
        }
    }

    /// Whether edits are noted.
    pub(super) fn keeps(&self) -> bool {
        self.keeper.is_some()
    }

    /// Notes a save: the journal begins anew, under the project's new name where it has one.
    pub(super) fn kept_saved(&mut self, path: &Path, stamp: FileStamp) {
        let Some(keeper) = &mut self.keeper else {
            return;
        };
        if keeper.path == path {
            keeper.stamp = stamp;
            if let Some(journal) = &keeper.journal {
                journal.saved(stamp);
            }
            return;
        }
        let options = keeper.options.clone();
        // Its lock goes first, so that saving under a name and back again works.
        self.forget_unsaved();
        self.keeper = Keeper::new(path, stamp, options).ok();
    }
}
