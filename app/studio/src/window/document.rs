//! The open project: the engine that shows it, the file that it came from, and whether they differ.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use relievo_engine::planet::Camera;
use relievo_engine::project::{
    self, Abandoned, Edit, EditError, FileStamp, JournalOptions, Project, Recovery, Replace,
    SaveProjectError,
};
use relievo_engine::{Engine, EngineOptions, Guarded, OpenError};

/// A project in the window.
pub struct Document {
    engine: Engine,
    path: Option<PathBuf>,
    stamp: Option<FileStamp>,
    /// What the file holds.
    saved: Project,
    changed: bool,
    /// Counts changes, undo and redo included.
    revision: u64,
    /// Where a project without a file is kept safe from its first edit on.
    unguarded: Option<PathBuf>,
    /// Why it is not, for the log.
    trouble: Option<String>,
}

impl Document {
    /// An empty Earth without a file.
    ///
    /// # Errors
    /// When the system refuses threads.
    pub fn empty(options: EngineOptions) -> std::io::Result<Self> {
        let folder = std::env::current_dir().unwrap_or_else(|_gone| PathBuf::from("."));
        Ok(Self::of(
            Engine::new(Project::default(), &folder, options)?,
            None,
            None,
        ))
    }

    /// A project file.
    ///
    /// # Errors
    /// [`OpenError`].
    pub fn open(path: &Path, options: EngineOptions) -> Result<Self, OpenError> {
        let path = std::path::absolute(path).unwrap_or_else(|_odd| path.to_owned());
        let (engine, stamp) = Engine::open(&path, options)?;
        Ok(Self::of(engine, Some(path), Some(stamp)))
    }

    /// Guards the project's file against crashes and other programs; says what was found. Nothing
    /// for a project without a file.
    pub(crate) fn guard(&mut self, state_folder: Option<&Path>) -> Guarded {
        let (Some(path), Some(stamp)) = (&self.path, self.stamp) else {
            return Guarded::default();
        };
        self.engine
            .guard(path, stamp, journal_options(state_folder))
    }

    /// Makes edits again that were never saved: how many, and why no more.
    pub(crate) fn recover(&mut self, recovery: &Recovery) -> (usize, Option<EditError>) {
        let done = self.engine.recover(recovery);
        self.note_change();
        done
    }

    /// What the file was when it was read or written last.
    pub(crate) fn stamp(&self) -> Option<FileStamp> {
        self.stamp
    }

    /// Makes the step the present one up to which so many steps can be undone.
    ///
    /// # Errors
    /// When a step does not fit any more.
    pub fn go_to(&mut self, position: usize) -> Result<bool, EditError> {
        let done = self.engine.go_to(position);
        self.note_change();
        done
    }

    fn of(engine: Engine, path: Option<PathBuf>, stamp: Option<FileStamp>) -> Self {
        let saved = engine.project().clone();
        Self {
            engine,
            path,
            stamp,
            saved,
            changed: false,
            revision: 0,
            unguarded: None,
            trouble: None,
        }
    }

    /// An untitled project of a run that did not end well, and the edits that it lacks.
    ///
    /// # Errors
    /// [`OpenError`].
    pub(crate) fn abandoned(
        found: &Abandoned,
        state_folder: &Path,
        options: EngineOptions,
    ) -> Result<(Self, Guarded), OpenError> {
        let (project, stamp) = project::open(&found.path)?;
        let mut engine =
            Engine::new(project, &found.folder, options).map_err(OpenError::Threads)?;
        let guarded = engine.guard(&found.path, stamp, journal_options(Some(state_folder)));
        Ok((Self::of(engine, None, None), guarded))
    }

    /// Keeps edits safe from the first one on, while the project has no file.
    pub(crate) fn guard_untitled(&mut self, state_folder: Option<&Path>) {
        self.unguarded = state_folder.map(Path::to_owned);
    }

    /// Before the first edit of a project without a file: its beginning goes to the state folder.
    fn before_edit(&mut self) {
        let Some(folder) = self.unguarded.take() else {
            return;
        };
        let options = journal_options(Some(&folder));
        if let Err(error) = self.engine.guard_untitled(&folder, options) {
            self.trouble = Some(format!("edits are kept safe only by saving: {error}"));
        }
    }

    /// Why edits are not kept safe; once.
    pub(crate) fn take_trouble(&mut self) -> Option<String> {
        self.trouble.take()
    }

    /// The engine.
    pub fn engine(&self) -> &Engine {
        &self.engine
    }

    /// The engine, for everything but changes of the project, which go through [`Self::apply`].
    pub fn engine_mut(&mut self) -> &mut Engine {
        &mut self.engine
    }

    /// The project as it is now.
    pub fn project(&self) -> &Project {
        self.engine.project()
    }

    /// Its file, once it has one.
    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// Whether there is something to save; the camera does not count.
    pub fn is_changed(&self) -> bool {
        self.changed
    }

    /// Counts changes of the project.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// What the window's title calls it.
    pub fn name(&self) -> String {
        let stem = self.path.as_ref().and_then(|p| p.file_stem());
        stem.map_or_else(
            || "Untitled".to_owned(),
            |s| s.to_string_lossy().into_owned(),
        )
    }

    /// Applies an edit.
    ///
    /// # Errors
    /// When it does not fit; nothing has changed then.
    pub fn apply(&mut self, edit: Edit) -> Result<(), EditError> {
        self.before_edit();
        self.engine.apply(edit)?;
        self.note_change();
        Ok(())
    }

    /// Starts a drag: all edits until [`Self::end_drag`] are one undo step.
    pub fn begin_drag(&mut self) {
        self.before_edit();
        self.engine.begin_drag();
    }

    /// Ends a drag.
    pub fn end_drag(&mut self) {
        self.engine.end_drag();
    }

    /// Ends a drag and takes it back.
    pub fn cancel_drag(&mut self) {
        self.engine.cancel_drag();
        self.note_change();
    }

    /// Takes the last edit back.
    ///
    /// # Errors
    /// When the step does not fit any more.
    pub fn undo(&mut self) -> Result<bool, EditError> {
        let done = self.engine.undo();
        self.note_change();
        done
    }

    /// Makes the last undone edit again.
    ///
    /// # Errors
    /// When the step does not fit any more.
    pub fn redo(&mut self) -> Result<bool, EditError> {
        let done = self.engine.redo();
        self.note_change();
        done
    }

    /// Saves the project with the camera as it is, to `path` or to its own file.
    ///
    /// Its own file is replaced if it still is what it was, another one if `replace` says so.
    ///
    /// # Errors
    /// [`SaveProjectError`]; the file is then as it was.
    ///
    /// # Panics
    /// Without a path and a file.
    pub fn save(
        &mut self,
        path: Option<&Path>,
        camera: &Camera,
        overwrite: bool,
    ) -> Result<(), SaveProjectError> {
        let path = path
            .or(self.path.as_deref())
            .expect("a new project is saved under a name")
            .to_owned();
        let path = std::path::absolute(&path).unwrap_or(path);
        let replace = match self.stamp {
            Some(stamp) if !overwrite && self.path.as_ref() == Some(&path) => {
                Replace::IfUnchanged(stamp)
            }
            _ => Replace::Always,
        };
        let edit = Edit::SetCamera {
            camera: self.project().camera.with_camera(camera),
        };
        // A camera out of the format's range is no reason not to save the rest.
        if let Err(error) = self.engine.apply(edit) {
            tracing::warn!("the camera is not saved: {error}");
        }
        self.stamp = Some(self.engine.save(&path, replace)?);
        self.path = Some(path);
        self.unguarded = None;
        self.saved = self.engine.project().clone();
        self.changed = false;
        Ok(())
    }

    fn note_change(&mut self) {
        self.revision += 1;
        let (now, saved) = (self.engine.project(), &self.saved);
        let same = now.elements.len() == saved.elements.len()
            && now
                .elements
                .iter()
                .zip(&saved.elements)
                .all(|(a, b)| Arc::ptr_eq(a, b) || a == b);
        self.changed = !same
            || now.layers != saved.layers
            || now.scenarios != saved.scenarios
            || now.scenario != saved.scenario
            || now.bookmarks != saved.bookmarks
            || now.planet != saved.planet
            || now.sun != saved.sun
            || now.quality != saved.quality
            || now.extra != saved.extra;
    }
}

fn journal_options(state_folder: Option<&Path>) -> JournalOptions {
    JournalOptions {
        state_folder: state_folder.map(Path::to_owned),
        ..JournalOptions::default()
    }
}
