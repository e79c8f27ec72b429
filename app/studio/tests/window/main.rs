//! The window as people use it.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod basics;
mod drawing;
mod panes;
mod shared;
mod tutorial;
