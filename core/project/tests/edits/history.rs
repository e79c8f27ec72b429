//! Steps back and forth, and how they are called.

use relievo_project::{Adjust, CameraSettings, Edit, History, LayerId, LayerKind};

use crate::{EVERYTHING, everything, opacity};

#[test]
fn a_whole_drag_is_one_step_back_to_where_it_began() {
    let (mut project, mut history) = (everything(), History::default());
    history.begin_drag(&project);
    for i in 0..100 {
        history
            .apply(&mut project, opacity(f64::from(i) / 100.0))
            .unwrap();
    }
    history.end_drag(&project);
    assert_eq!(history.undo_label(), Some("Opacity of Blue Marble"));
    assert_eq!(history.undo(&mut project).unwrap(), Some(opacity(0.75)));
    assert_eq!(project.to_json(), EVERYTHING);
    assert_eq!(history.undo_label(), None);
    history.redo(&mut project).unwrap();
    assert_eq!(project.layers[0].opacity, 0.99);
}

#[test]
fn a_drag_that_sets_values_of_two_layers_leaves_a_step_as_small_as_one_of_its_edits() {
    let both = |value: f64| Edit::Batch {
        label: "Both".to_owned(),
        edits: ["blue-marble", "tint"]
            .map(|id| Edit::SetOpacity {
                id: id.into(),
                opacity: value,
            })
            .to_vec(),
    };
    let (mut project, mut history) = (everything(), History::default());
    history.begin_drag(&project);
    for i in 0..100 {
        history
            .apply(&mut project, both(f64::from(i) / 100.0))
            .unwrap();
    }
    history.end_drag(&project);
    let Some(Edit::Batch { edits, .. }) = history.undo(&mut project).unwrap() else {
        panic!("one batch");
    };
    assert_eq!(edits.len(), 2);
    assert_eq!(project.to_json(), EVERYTHING);
    history.redo(&mut project).unwrap();
    assert_eq!(project.layers[0].opacity, 0.99);
}

#[test]
fn a_cancelled_drag_leaves_no_trace() {
    let (mut project, mut history) = (everything(), History::default());
    history.begin_drag(&project);
    history.apply(&mut project, opacity(0.1)).unwrap();
    assert_eq!(history.cancel_drag(&mut project), Some(opacity(0.75)));
    assert_eq!(project.to_json(), EVERYTHING);
    assert_eq!(history.undo_label(), None);
}

#[test]
fn an_adjustment_is_called_by_the_slider_that_moved() {
    let (mut project, mut history) = (everything(), History::default());
    let LayerKind::Imagery(imagery) = &project.layers[0].kind else {
        panic!("an imagery layer")
    };
    let adjust = Adjust {
        brightness: 0.5,
        ..imagery.adjust.clone()
    };
    history
        .apply(
            &mut project,
            Edit::SetAdjust {
                id: "blue-marble".into(),
                adjust,
            },
        )
        .unwrap();
    assert_eq!(history.undo_label(), Some("Brightness of Blue Marble"));
}

#[test]
fn a_camera_move_is_not_undone_and_keeps_what_can_be_redone() {
    let (mut project, mut history) = (everything(), History::default());
    history.apply(&mut project, opacity(0.1)).unwrap();
    history.undo(&mut project).unwrap();
    history
        .apply(
            &mut project,
            Edit::SetCamera {
                camera: CameraSettings::default(),
            },
        )
        .unwrap();
    assert_eq!(history.undo_label(), None);
    assert_eq!(history.redo_label(), Some("Opacity of Blue Marble"));
}

#[test]
fn the_history_drops_its_oldest_steps_beyond_its_memory() {
    let mut project = everything();
    let mut history = History::new(20_000);
    for i in 0..1000 {
        history
            .apply(&mut project, opacity(f64::from(i) / 1000.0))
            .unwrap();
        assert!(history.bytes() <= 20_000);
    }
    let mut steps = 0;
    while history.undo(&mut project).unwrap().is_some() {
        steps += 1;
    }
    assert!((10..1000).contains(&steps), "{steps}");
}

#[test]
fn an_id_that_an_undo_would_bring_back_is_not_given_again() {
    let (mut project, mut history) = (everything(), History::default());
    history
        .apply(&mut project, Edit::RemoveLayer { id: "tint".into() })
        .unwrap();
    assert_eq!(
        history.fresh_layer_id(&project, "Tint"),
        LayerId::from("tint-2")
    );
}
