//! The suites, one file each.

pub mod transform;

use crate::Suite;

/// All of them, in the order of a full report.
pub const ALL: &[Suite] = &[transform::SUITE];

/// The suite that is called so.
pub fn called(name: &str) -> Option<&'static Suite> {
    ALL.iter().find(|suite| suite.name == name)
}
