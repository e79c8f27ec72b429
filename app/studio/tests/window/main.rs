//! The window as people use it.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod analysis;
mod basics;
mod colours;
mod drawing;
mod keeping;
mod lens;
mod panes;
mod quality;
mod shared;
mod tutorial;
mod vectors;
