//! Error against run time: what every approximation costs and what it saves.
//!
//! ```text
//! Suite::run(&Context) -> Report of Figures --write::to_folder--> index.html, NAME.csv, NAME.svg, NAME.png
//! ```
//!
//! Invariant: errors are computed, never estimated from times, and come out the same on every run;
//! times are medians of interleaved repetitions and are only reported. What is measured lives in the
//! room that uses it; only the measuring is here. Absent: windows, edits.
//!
//! A suite is one file in `suites/`; it is added to [`suites::ALL`].

pub mod context;
pub mod curve;
pub mod machine;
pub mod metric;
pub mod number;
mod scene;
pub mod suite;
pub mod suites;
pub mod timing;
pub mod write;

pub use context::{Context, DeviceWish};
pub use curve::{Axis, Chart, Curve, Point};
pub use machine::Machine;
pub use suite::{Cell, Content, Figure, Picture, Report, Suite, SuiteError, Table};
pub use timing::{Spread, Work};
