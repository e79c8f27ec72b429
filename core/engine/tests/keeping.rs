//! Work that is not saved survives the engine: journal, recovery, locks, scenarios in the picture.

#![allow(clippy::unwrap_used, reason = "a test may stop")]

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use relievo_engine::project::{
    Change, ChangeKind, Edit, Element, ElementKind, JournalOptions, Layer, LayerKind,
    LayerOverride, LockError, Noise, NoiseLayer, Polygon, Project, Replace, Scenario, SurfaceKind,
    Vertex, abandoned, save_atomic,
};
use relievo_engine::{Engine, EngineOptions, Guarded};

fn options() -> EngineOptions {
    EngineOptions {
        threads: Some(1),
        memory: 16 << 20,
        cache_folder: None,
        ..EngineOptions::default()
    }
}

fn journal() -> JournalOptions {
    JournalOptions {
        state_folder: None,
        gather: Duration::from_millis(1),
    }
}

fn hills() -> Layer {
    let noise = Noise {
        offset_m: 500.0,
        amplitude_m: 10.0,
        ..Noise::default()
    };
    Layer::new(
        "hills".into(),
        "Hills",
        LayerKind::Noise(NoiseLayer { noise }),
    )
}

fn open(path: &Path) -> (Engine, Guarded) {
    let (mut engine, stamp) = Engine::open(path, options()).unwrap();
    let guarded = engine.guard(path, stamp, journal());
    (engine, guarded)
}

fn opacity(opacity: f64) -> Edit {
    let id = "hills".into();
    Edit::SetOpacity { id, opacity }
}

#[test]
fn unsaved_edits_are_offered_again_replayed_and_gone_after_a_save() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.relievo");
    let mut project = Project::default();
    project.layers.push(hills());
    save_atomic(&path, &project, Replace::Never).unwrap();

    let (mut engine, guarded) = open(&path);
    assert!(guarded.offer.is_none() && guarded.held.is_none());
    engine.apply(opacity(0.5)).unwrap();
    engine.apply(opacity(0.25)).unwrap();
    engine.undo().unwrap();
    let id = "hills".into();
    let name = "Downs".to_owned();
    engine.apply(Edit::SetName { id, name }).unwrap();
    let before = engine.project().to_json();
    let (_, second) = open(&path);
    assert!(matches!(second.held, Some(LockError::Held { .. })));
    drop(engine);

    let (mut engine, guarded) = open(&path);
    let recovery = guarded.offer.unwrap();
    assert_eq!(engine.recover(&recovery), (recovery.edits().len(), None));
    assert_eq!(engine.project().to_json(), before);
    engine.apply(opacity(0.75)).unwrap();
    let latest = engine.project().to_json();
    drop(engine);

    let (mut engine, guarded) = open(&path);
    engine.recover(&guarded.offer.unwrap());
    assert_eq!(engine.project().to_json(), latest);
    engine.go_to(0).unwrap();
    assert_eq!(engine.project().layers[0], hills());
    engine.go_to(usize::MAX).unwrap();
    assert_eq!(engine.project().to_json(), latest);
    let other = folder.path().join("b.relievo");
    engine.save(&other, Replace::Never).unwrap();
    engine.apply(opacity(0.125)).unwrap();
    engine.forget_unsaved();
    drop(engine);
    for path in [&path, &other] {
        assert!(open(path).1.offer.is_none(), "{path:?}");
    }
    let names = std::fs::read_dir(folder.path()).unwrap();
    assert_eq!(names.count(), 2, "nothing is left behind");
}

#[test]
fn an_offer_that_nobody_answers_is_made_again_whatever_is_done_meanwhile() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.relievo");
    save_atomic(&path, &Project::default(), Replace::Never).unwrap();
    let add = Edit::AddLayer {
        index: None,
        layer: Box::new(hills()),
    };
    let (mut engine, _) = open(&path);
    engine.apply(add.clone()).unwrap();
    drop(engine);
    // Edits and a save of later runs do not take the offer away.
    for save in [false, true] {
        let (mut engine, guarded) = open(&path);
        assert_eq!(guarded.offer.unwrap().edits(), std::slice::from_ref(&add));
        engine.apply(add.clone()).unwrap();
        engine.apply(opacity(0.5)).unwrap();
        if save {
            engine.save(&path, Replace::Always).unwrap();
        }
        engine.forget_unsaved();
    }
    let (mut engine, guarded) = open(&path);
    let offer = guarded.offer.unwrap();
    assert!(!offer.fits(), "the file was saved since");
    engine.decline(offer).unwrap();
    engine.forget_unsaved();
    drop(engine);
    assert!(open(&path).1.offer.is_none());
}

#[test]
fn a_project_without_a_name_survives_too() {
    let state = tempfile::tempdir().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let untitled = || {
        let mut engine = Engine::new(Project::default(), folder.path(), options()).unwrap();
        engine.guard_untitled(state.path(), journal()).unwrap();
        engine
    };
    let add = Edit::AddLayer {
        index: None,
        layer: Box::new(hills()),
    };
    // One is left without an edit, one is dismissed, one crashes.
    drop(untitled());
    let mut engine = untitled();
    engine.apply(add.clone()).unwrap();
    engine.forget_unsaved();
    drop(engine);
    let mut engine = untitled();
    engine.apply(add).unwrap();
    assert!(abandoned(state.path()).is_empty(), "it is open");
    drop(engine);

    let found = abandoned(state.path());
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].folder, folder.path());
    let (project, stamp) = relievo_engine::project::open(&found[0].path).unwrap();
    let mut engine = Engine::new(project, &found[0].folder, options()).unwrap();
    let options = JournalOptions {
        state_folder: Some(state.path().to_owned()),
        ..journal()
    };
    let guarded = engine.guard(&found[0].path, stamp, options);
    engine.recover(&guarded.offer.unwrap());
    assert_eq!(engine.project().layers, [hills()]);
    let path = folder.path().join("named.relievo");
    engine.save(&path, Replace::Never).unwrap();
    drop(engine);
    assert!(abandoned(state.path()).is_empty());
    let left = std::fs::read_dir(state.path().join("journals")).unwrap();
    assert_eq!(left.count(), 0, "nothing is left behind");
    assert!(open(&path).1.offer.is_none());
}

#[test]
fn a_scenario_is_what_questions_see() {
    let mut project = Project::default();
    project.layers.push(hills());
    let scenario = Scenario {
        layers: vec![LayerOverride {
            id: "hills".into(),
            visible: Some(false),
            opacity: None,
            extra: relievo_engine::project::Extra::new(),
        }],
        changes: vec![Change::from(ChangeKind::Add {
            element: Arc::new(Element::new(
                "p".into(),
                "P",
                ElementKind::Polygon(Polygon::new(vec![Vertex::new(0.0, 0.0)], SurfaceKind::Tin)),
            )),
            index: None,
        })],
        ..Scenario::new("flat".into(), "Flat", None)
    };
    project.scenarios.push(scenario);
    let mut engine = Engine::new(project, Path::new("."), options()).unwrap();
    engine.wait_for_sources();
    let place = relievo_engine::planet::MapPoint::from_degrees(10.0, 20.0);
    let cancel = relievo_engine::raster::Cancel::default();
    let height =
        |questions: relievo_engine::Questions| questions.place(place, &cancel).unwrap().height_m;
    let flat = "flat".into();
    assert!(height(engine.questions()) > 400.0);
    assert_eq!(height(engine.questions_in(Some(&flat))), 0.0);
    let id = Some(flat);
    engine.apply(Edit::ShowScenario { id }).unwrap();
    assert_eq!(height(engine.questions()), 0.0);
    assert!(height(engine.questions_in(None)) > 400.0);
    let shown = relievo_engine::as_shown(engine.project(), engine.project().scenario.as_ref());
    assert_eq!(shown.elements.len(), 1);
}
