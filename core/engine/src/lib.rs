//! The one door of core: open a project, apply edits, set the view, drain what to upload.
//!
//! Invariants: only [`Engine::apply`] (and undo, redo) changes a project; nothing here waits for a
//! tile on the caller's thread; nothing here knows a window or a GPU.

pub mod frame;

pub use frame::{ClipKind, Frame, LevelView, Sun, Upload};
