//! The suites, one file each.

pub mod colour;
pub mod convergence;
pub mod detail;
pub mod geometry;
pub mod leaving_out;
pub mod noise;
pub mod planning;
pub mod quality;
pub mod resample;
pub mod stability;
pub mod transform;

use crate::Suite;

/// All of them, in the order of a full report.
pub const ALL: &[Suite] = &[
    transform::SUITE,
    geometry::SUITE,
    colour::SUITE,
    quality::SUITE,
    convergence::SUITE,
    resample::SUITE,
    planning::SUITE,
    noise::SUITE,
    detail::SUITE,
    stability::SUITE,
    leaving_out::SUITE,
];
