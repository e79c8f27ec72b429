//! Edits, their inverses and the history.

#![allow(clippy::unwrap_used, reason = "a test may stop")]

mod any;
mod history;
mod laws;
mod refused;

use std::path::Path;

use relievo_project::{Affects, Aspect, Edit, Project};

/// A project in which every member of the format has a value of its own.
const EVERYTHING: &str = include_str!("../data/everything.relievo");

fn everything() -> Project {
    Project::from_json(EVERYTHING, Path::new("p.relievo")).unwrap()
}

fn opacity(opacity: f64) -> Edit {
    Edit::SetOpacity {
        id: "blue-marble".into(),
        opacity,
    }
}

#[test]
fn an_edit_tells_which_layer_and_what_of_it() {
    let affects = Edit::Batch {
        label: String::new(),
        edits: vec![opacity(0.1), opacity(0.2)],
    }
    .affects();
    assert_eq!(
        affects,
        [Affects::Layer {
            id: "blue-marble".into(),
            aspect: Aspect::Opacity
        }]
    );
}
