//! The command line as scripts see it, in this process.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod commands;
mod files;
mod matching;
mod measure;
mod outputs;
mod problems;
#[cfg(feature = "report")]
mod report;
mod shared;
