//! Relievo's two faces of one engine: the window and the command line.
//!
//! Invariant: a project changes through `Engine::apply` only, whichever face asks; the window never
//! makes a tile and never waits for one. Absent: geometry, kernels, GPU code.

pub mod cli;
#[cfg(feature = "window")]
pub mod commands;
mod coverage;
mod picture;
mod report;
#[cfg(feature = "window")]
pub mod window;
