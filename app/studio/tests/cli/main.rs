//! The command line as scripts see it, in this process.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod commands;
mod measure;
mod outputs;
#[cfg(feature = "report")]
mod report;
mod shared;
