//! Clipmap geometry.
