//! What holds for any edits in any order.

use std::path::Path;

use proptest::prelude::*;
use relievo_project::{CameraSettings, Edit, History, LensShape, Project};

use crate::any::edit;
use crate::{EVERYTHING, everything};

/// Canonical text without the camera, whose moves are not undone.
fn without_camera(project: &Project) -> String {
    Project {
        camera: CameraSettings::default(),
        ..project.clone()
    }
    .to_json()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(100) })]

    #[test]
    fn undoing_all_edits_restores_the_same_bytes(edits in prop::collection::vec(edit(), 0..30)) {
        let mut project = everything();
        let mut inverses = Vec::new();
        for edit in edits {
            let before = project.to_json();
            if let Ok(inverse) = project.apply(edit) {
                inverses.push(inverse);
            } else {
                prop_assert_eq!(project.to_json(), before, "a refused edit changed something");
            }
            // Every state that edits reach can be saved and opened.
            let opened = Project::from_json(&project.to_json(), Path::new("p")).unwrap();
            prop_assert_eq!(&opened, &project);
        }
        for inverse in inverses.into_iter().rev() {
            project.apply(inverse).unwrap();
        }
        prop_assert_eq!(project.to_json(), EVERYTHING);
    }

    #[test]
    fn undo_all_and_redo_all_lead_to_the_same_ends(
        edits in prop::collection::vec((edit(), any::<bool>()), 0..30),
    ) {
        let mut project = everything();
        let mut history = History::default();
        for (edit, toggles_drag) in edits {
            if toggles_drag && history.is_dragging() {
                history.end_drag(&project);
            } else if toggles_drag {
                history.begin_drag(&project);
            }
            drop(history.apply(&mut project, edit));
        }
        history.end_drag(&project);
        let end = without_camera(&project);
        while history.undo(&mut project).unwrap().is_some() {}
        prop_assert_eq!(without_camera(&project), without_camera(&everything()));
        while history.redo(&mut project).unwrap().is_some() {}
        prop_assert_eq!(without_camera(&project), end);
    }

    #[test]
    fn edits_read_back_from_json(edit in edit()) {
        let text = Edit::list_to_json(std::slice::from_ref(&edit));
        if let Ok(read) = Edit::list_from_json(&text, Path::new("e")) {
            prop_assert_eq!(&read[0], &edit);
        }
    }
}

#[test]
fn a_lens_that_is_a_polygon_is_set_by_an_edit_and_taken_back() {
    let text = r#"[{"edit": "set_mask", "id": "tint", "mask": {"polygon": {"lon_deg": 7.5, "lat_deg": 46.5,
        "corners_m": [[-100, -50.5], [100, -50.5], [0, 101]], "drawn_by": "hand"}}}]"#;
    let mut project = Project::from_json(EVERYTHING, Path::new("p.relievo")).unwrap();
    let [edit] = &Edit::list_from_json(text, Path::new("e.json")).unwrap()[..] else {
        panic!("one edit");
    };
    let inverse = project.apply(edit.clone()).unwrap();
    let mask = |project: &Project| project.layer(&"tint".into()).unwrap().mask.clone().unwrap();
    let lens = mask(&project).lens.unwrap();
    assert_eq!((lens.lon_deg, lens.lat_deg, lens.fade_m), (7.5, 46.5, 0.0));
    assert_eq!(
        lens.shape,
        LensShape::Polygon {
            corners_m: vec![[-100.0, -50.5], [100.0, -50.5], [0.0, 101.0]]
        }
    );
    assert_eq!(lens.extra["drawn_by"], "hand");
    let again = Project::from_json(&project.to_json(), Path::new("p.relievo")).unwrap();
    assert_eq!(mask(&again), mask(&project));
    project.apply(inverse).unwrap();
    assert_eq!(project.to_json(), EVERYTHING);
}
