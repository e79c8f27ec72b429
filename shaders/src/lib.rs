//! WGSL sources, their composition, and the Rust mirrors of their layouts.
//!
//! Invariant: every entry point of every specialisation is valid WGSL and every mirrored struct
//! has the offsets that WGSL gives it (`tests/`), without any GPU.
//! Absent: wgpu, pipelines, devices.

pub mod compose;
pub mod layout;

pub use compose::{ComposeError, Entry, compose};
