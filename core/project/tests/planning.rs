//! Planning elements and scenarios: edits, inverses, what scenarios make of the base.

#![allow(clippy::unwrap_used, reason = "a test may stop")]
#![allow(clippy::wildcard_enum_match_arm, reason = "most edits act in no base")]

use std::path::Path;
use std::sync::Arc;

use proptest::prelude::*;
use relievo_project::{
    Bookmark, CameraSettings, Change, ChangeKind, Edit, EditError, Element, ElementId, ElementKind,
    ElementStyle, Extra, History, LayerOverride, Polygon, Project, Scenario, ScenarioId,
    SurfaceKind, Vertex,
};

const EVERYTHING: &str = include_str!("data/everything.relievo");

fn read(text: &str) -> Project {
    Project::from_json(text, Path::new("p.relievo")).unwrap()
}

fn platform(id: &str, height_m: f64) -> Element {
    let outline: Vec<Vertex> = [(0.0, 0.0), (0.01, 0.0), (0.01, 0.01), (0.0, 0.01)]
        .map(|(lon, lat)| Vertex::new(lon, lat))
        .to_vec();
    let polygon = Polygon::new(outline, SurfaceKind::Platform { height_m });
    Element::new(id.into(), id.to_uppercase(), ElementKind::Polygon(polygon))
}

/// A base of a, b, c, d and a tree of scenarios: one, and two on it, and other beside them.
fn small() -> Project {
    let mut project = Project::default();
    for id in ["a", "b", "c", "d"] {
        let element = Arc::new(platform(id, 1.0));
        project
            .apply(Edit::AddElement {
                scenario: None,
                index: None,
                element,
            })
            .unwrap();
    }
    for (id, parent) in [("one", None), ("two", Some("one")), ("other", None)] {
        let scenario = Scenario::new(id.into(), id, parent.map(Into::into));
        let scenario = Box::new(scenario);
        let index = None;
        project
            .apply(Edit::AddScenario { index, scenario })
            .unwrap();
    }
    project
}

fn ids(project: &Project, scenario: Option<&str>) -> Vec<String> {
    let scenario = scenario.map(ScenarioId::from);
    let elements = project.elements_in(scenario.as_ref());
    elements.iter().map(|e| e.id.0.clone()).collect()
}

fn element_id() -> impl Strategy<Value = ElementId> {
    prop::sample::select(vec!["a", "b", "c", "d", "e", "f"]).prop_map(ElementId::from)
}

fn scenario_id() -> impl Strategy<Value = ScenarioId> {
    prop::sample::select(vec!["one", "two", "other", "new-1", "new-2"]).prop_map(ScenarioId::from)
}

fn element() -> impl Strategy<Value = Arc<Element>> {
    (element_id(), -1e7..1.1e7_f64).prop_map(|(id, h)| Arc::new(platform(&id.0, h)))
}

fn change() -> impl Strategy<Value = Change> {
    let index = || prop::option::of(0..6_usize);
    prop_oneof![
        (element(), index()).prop_map(|(element, index)| ChangeKind::Add { element, index }.into()),
        (element(), index())
            .prop_map(|(element, index)| ChangeKind::Replace { element, index }.into()),
        element_id().prop_map(|id| ChangeKind::Remove { id }.into()),
    ]
}

/// Any edit of elements, scenarios and bookmarks, many of which do not fit.
#[expect(clippy::too_many_lines, reason = "one arm for each edit")]
fn edit() -> impl Strategy<Value = Edit> {
    let place = || prop::option::of(scenario_id());
    let index = || prop::option::of(0..6_usize);
    let bookmark = "[a-z]{0,3}".prop_map(|name| Bookmark {
        name,
        camera: CameraSettings::default(),
        extra: Extra::new(),
    });
    let elements = prop_oneof![
        (place(), index(), element()).prop_map(|(scenario, index, element)| Edit::AddElement {
            scenario,
            index,
            element
        }),
        (place(), element_id()).prop_map(|(scenario, id)| Edit::RemoveElement { scenario, id }),
        (place(), element())
            .prop_map(|(scenario, element)| Edit::ReplaceElement { scenario, element }),
        (place(), element_id(), 0..6_usize).prop_map(|(scenario, id, index)| Edit::MoveElement {
            scenario,
            id,
            index
        }),
        (place(), element_id(), "[a-z]{0,3}")
            .prop_map(|(scenario, id, name)| Edit::SetElementName { scenario, id, name }),
        (place(), element_id(), any::<bool>()).prop_map(|(scenario, id, visible)| {
            Edit::SetElementVisible {
                scenario,
                id,
                visible,
            }
        }),
        (place(), element_id(), any::<bool>()).prop_map(|(scenario, id, locked)| {
            Edit::SetElementLocked {
                scenario,
                id,
                locked,
            }
        }),
        (place(), element_id(), -0.1..1.1_f64).prop_map(|(scenario, id, fill_opacity)| {
            let style = ElementStyle {
                fill: Some([1, 2, 3]),
                fill_opacity,
                ..ElementStyle::default()
            };
            Edit::SetElementStyle {
                scenario,
                id,
                style,
            }
        }),
    ];
    let scenarios = prop_oneof![
        (scenario_id(), index(), change()).prop_map(|(scenario, index, change)| {
            Edit::SetChange {
                scenario,
                id: change.element_id().unwrap().clone(),
                index,
                change: Some(change),
            }
        }),
        (scenario_id(), element_id()).prop_map(|(scenario, id)| Edit::SetChange {
            scenario,
            id,
            index: None,
            change: None
        }),
        (scenario_id(), prop::collection::vec(change(), 0..4))
            .prop_map(|(scenario, changes)| Edit::SetChanges { scenario, changes }),
        (index(), scenario_id(), place()).prop_map(|(index, id, parent)| Edit::AddScenario {
            index,
            scenario: Box::new(Scenario::new(id, "New", parent)),
        }),
        scenario_id().prop_map(|id| Edit::RemoveScenario { id }),
        (scenario_id(), "[a-z]{0,3}").prop_map(|(id, name)| Edit::RenameScenario { id, name }),
        (scenario_id(), scenario_id()).prop_map(|(id, new_id)| Edit::DuplicateScenario {
            id,
            new_id,
            name: "Copy".into()
        }),
        scenario_id().prop_map(|id| Edit::MergeScenario { id }),
        (scenario_id(), place()).prop_map(|(id, parent)| Edit::SetScenarioParent { id, parent }),
        (scenario_id(), prop::option::of(any::<bool>())).prop_map(|(scenario, visible)| {
            let id = "layer".into();
            let layer = visible.map(|visible| LayerOverride {
                id: "layer".into(),
                visible: Some(visible),
                opacity: None,
                extra: Extra::new(),
            });
            Edit::SetScenarioLayer {
                scenario,
                id,
                index: None,
                layer,
            }
        }),
        place().prop_map(|id| Edit::ShowScenario { id }),
        (index(), bookmark.clone())
            .prop_map(|(index, bookmark)| Edit::AddBookmark { index, bookmark }),
        (0..3_usize).prop_map(|index| Edit::RemoveBookmark { index }),
        (0..3_usize, bookmark)
            .prop_map(|(index, bookmark)| Edit::ReplaceBookmark { index, bookmark }),
    ];
    prop_oneof![3 => elements, 2 => scenarios].prop_recursive(2, 6, 3, |inner| {
        prop::collection::vec(inner, 0..4).prop_map(|edits| Edit::Batch {
            label: String::new(),
            edits,
        })
    })
}

/// What every scenario shows.
fn shown(project: &Project) -> Vec<(ScenarioId, Vec<Arc<Element>>, Vec<relievo_project::Layer>)> {
    let all = project.scenarios.iter();
    all.map(|scenario| {
        let id = Some(&scenario.id);
        let layers = project.layers_in(id).into_owned();
        (scenario.id.clone(), project.elements_in(id), layers)
    })
    .collect()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(150) })]

    #[test]
    fn any_edits_undone_give_the_same_bytes_and_replayed_from_a_script_too(
        edits in prop::collection::vec(edit(), 0..25),
    ) {
        let start = small();
        let mut project = start.clone();
        let mut history = History::default();
        let mut applied = Vec::new();
        for edit in edits {
            let before = project.clone();
            if history.apply(&mut project, edit.clone()).is_ok() {
                applied.push(edit);
            } else {
                prop_assert_eq!(&project, &before, "a refused edit changed something");
            }
        }
        let end = project.to_json();
        prop_assert_eq!(&read(&end), &project);
        let script = Edit::list_to_json(&applied);
        let mut replayed = start.clone();
        for edit in Edit::list_from_json(&script, Path::new("e.json")).unwrap() {
            replayed.apply(edit).unwrap();
        }
        prop_assert_eq!(replayed.to_json(), &*end);
        while history.undo(&mut project).unwrap().is_some() {}
        prop_assert_eq!(project.to_json(), start.to_json());
        history.go_to(&mut project, usize::MAX).unwrap();
        prop_assert_eq!(project.to_json(), end);
    }

    #[test]
    fn a_merge_changes_nothing_that_the_scenario_and_those_on_it_show(
        edits in prop::collection::vec(edit(), 0..25), merged in scenario_id(),
    ) {
        let mut project = small();
        for edit in edits {
            project.apply(edit).ok();
        }
        let before = shown(&project);
        let Some(of) = project.scenario(&merged) else { return Ok(()) };
        let parent = of.parent.clone();
        let (_, elements, layers) = before.iter().find(|(id, ..)| *id == merged).unwrap();
        let on_it: Vec<ScenarioId> = project
            .scenarios
            .iter()
            .filter(|s| project.lineage(Some(&s.id)).iter().any(|above| above.id == merged))
            .map(|s| s.id.clone())
            .collect();
        project.apply(Edit::MergeScenario { id: merged.clone() }).unwrap();
        prop_assert_eq!(&project.elements_in(parent.as_ref()), elements);
        prop_assert_eq!(&*project.layers_in(parent.as_ref()), &**layers);
        prop_assert!(project.scenario(&merged).is_none());
        for (id, elements, layers) in before.iter().filter(|(id, ..)| on_it.contains(id) && *id != merged) {
            prop_assert_eq!(&project.elements_in(Some(id)), elements);
            prop_assert_eq!(&*project.layers_in(Some(id)), &**layers);
        }
    }

    #[test]
    fn an_element_edit_in_a_scenario_does_there_what_it_does_in_a_base_and_nothing_to_the_base(
        edits in prop::collection::vec(edit(), 0..20), last in edit(),
    ) {
        let mut project = small();
        for edit in edits {
            project.apply(edit).ok();
        }
        let scenario = ScenarioId::from("two");
        if project.scenario(&scenario).is_none() {
            return Ok(());
        }
        // A project whose base is what the scenario shows takes the same edit.
        let mut flat = Project {
            elements: project.elements_in(Some(&scenario)),
            ..Project::default()
        };
        let (mut there, mut here) = (last.clone(), last);
        for (edit, place) in [(&mut there, Some(scenario.clone())), (&mut here, None)] {
            match edit {
                Edit::AddElement { scenario, .. }
                | Edit::RemoveElement { scenario, .. }
                | Edit::ReplaceElement { scenario, .. }
                | Edit::MoveElement { scenario, .. }
                | Edit::SetElementName { scenario, .. }
                | Edit::SetElementVisible { scenario, .. }
                | Edit::SetElementLocked { scenario, .. }
                | Edit::SetElementStyle { scenario, .. } => *scenario = place,
                _ => return Ok(()),
            }
        }
        let base = project.elements.clone();
        let in_scenario = project.apply(there);
        prop_assert_eq!(in_scenario.is_ok(), flat.apply(here).is_ok());
        prop_assert_eq!(&project.elements_in(Some(&scenario)), &flat.elements);
        prop_assert_eq!(project.elements, base);
    }
}

#[test]
fn a_scenario_changes_what_it_says_and_shares_the_rest() {
    let project = read(EVERYTHING);
    let base = ids(&project, None);
    let dam = ids(&project, Some("with-dam"));
    assert_eq!(dam[0], "big-dam", "added at the bottom");
    let rest: Vec<&String> = base.iter().filter(|id| *id != "pit").collect();
    assert_eq!(dam[1..].iter().collect::<Vec<_>>(), rest);
    assert_eq!(ids(&project, Some("with-dam-2"))[2], "big-dam");
    assert_eq!(ids(&project, Some("nobody")), base);

    let id = ScenarioId::from("with-dam");
    let shared = project.elements_in(Some(&id));
    let road = |elements: &[Arc<Element>]| {
        let road = elements.iter().find(|e| e.id.0 == "road");
        Arc::clone(road.unwrap())
    };
    assert!(Arc::ptr_eq(&road(&shared), &road(&project.elements)));
    let streets = |layers: &[relievo_project::Layer]| {
        let layer = layers.iter().find(|l| l.id.0 == "streets").unwrap();
        (layer.visible, layer.opacity)
    };
    assert_eq!(streets(&project.layers_in(None)), (false, 1.0));
    assert_eq!(streets(&project.layers_in(Some(&id))), (true, 0.5));
    assert_eq!(project.scenario_called("With dam").unwrap().id, id);
    assert_eq!(project.scenario_called("with-dam").unwrap().id, id);
}

#[test]
fn a_circle_of_scenarios_is_refused_in_files_and_edits() {
    let file = |a: &str, b: &str| {
        format!(
            "{{\"version\": 1, \"scenarios\": [\n{{\"id\": \"a\"{a}}},\n{{\"id\": \"b\"{b}}}]}}"
        )
    };
    let message = |text: &str| {
        Project::from_json(text, Path::new("p.relievo"))
            .unwrap_err()
            .to_string()
    };
    let circle = message(&file(", \"parent\": \"b\"", ", \"parent\": \"a\""));
    assert!(
        circle.starts_with("line 2, at /scenarios/0/parent: expected a tree"),
        "{circle}"
    );
    let nobody = message(&file("", ", \"parent\": \"x\""));
    assert!(nobody.contains("expected the id of a scenario, found \"x\""));

    let mut project = small();
    let before = project.clone();
    for (id, parent) in [("one", "two"), ("one", "one")] {
        let error = project
            .apply(Edit::SetScenarioParent {
                id: id.into(),
                parent: Some(parent.into()),
            })
            .unwrap_err();
        assert!(matches!(error, EditError::Cycle { .. }), "{error}");
    }
    let id = "one".into();
    let error = project.apply(Edit::RemoveScenario { id }).unwrap_err();
    assert!(matches!(error, EditError::HasChildren { .. }), "{error}");
    assert_eq!(project, before);
}

#[test]
fn one_moved_vertex_is_a_difference_of_one_line_and_one_step_with_its_name() {
    let (mut project, mut history) = (small(), History::default());
    let before = project.to_json();
    let mut element = (*project.elements[1]).clone();
    let list = element.vertex_lists_mut().remove(0);
    let mut outline = list.to_vec();
    outline[2].lon_deg = 0.0125;
    outline[2].height_m = Some(7.5);
    *list = outline.into();
    let element = Arc::new(element);
    let scenario = None;
    history
        .apply(&mut project, Edit::ReplaceElement { scenario, element })
        .unwrap();
    let after = project.to_json();
    let differing: Vec<(&str, &str)> = before
        .lines()
        .zip(after.lines())
        .filter(|(a, b)| a != b)
        .collect();
    assert_eq!(
        differing,
        [("        [0.01, 0.01],", "        [0.0125, 0.01, 7.5],")]
    );
    assert_eq!(history.undo_label(), Some("Move vertex of B"));
    history.undo(&mut project).unwrap();
    assert_eq!(project.to_json(), before);
}

#[test]
fn a_drag_in_a_scenario_is_one_small_step() {
    for scenario in [None, Some(ScenarioId::from("two"))] {
        let (mut project, mut history) = (small(), History::default());
        let before = project.to_json();
        history.begin_drag(&project);
        for i in 0..100 {
            let element = Arc::new(platform("b", f64::from(i)));
            let scenario = scenario.clone();
            history
                .apply(&mut project, Edit::ReplaceElement { scenario, element })
                .unwrap();
        }
        history.end_drag(&project);
        assert_eq!(history.position(), 1);
        assert!(history.bytes() < 5000, "{} bytes", history.bytes());
        assert_eq!(history.undo_label(), Some("Surface of B"));
        let edit = history.undo(&mut project).unwrap().unwrap();
        assert!(!matches!(edit, Edit::Batch { .. }));
        assert_eq!(project.to_json(), before);
    }
}

#[test]
fn the_history_can_be_listed_and_gone_to() {
    let (mut project, mut history) = (small(), History::default());
    let mut texts = vec![project.to_json()];
    for id in ["a", "b", "c"] {
        let edit = Edit::RemoveElement {
            scenario: None,
            id: id.into(),
        };
        history.apply(&mut project, edit).unwrap();
        texts.push(project.to_json());
    }
    for position in [3, 0, 2, 1, 3] {
        history.go_to(&mut project, position).unwrap();
        assert_eq!(history.position(), position);
        assert_eq!(project.to_json(), texts[position]);
        let labels: Vec<&str> = history.labels().collect();
        assert_eq!(labels, ["Remove A", "Remove B", "Remove C"]);
    }
}

#[test]
fn a_thousand_steps_of_a_long_outline_stay_within_the_memory_and_are_undone() {
    let outline: Vec<Vertex> = (0..20_000)
        .map(|i| Vertex::new(f64::from(i) * 1e-5, 0.0))
        .collect();
    let mut long = platform("long", 1.0);
    *long.vertex_lists_mut().remove(0) = outline.into();
    let mut project = small();
    let element = Arc::new(long.clone());
    let (scenario, index) = (None, None);
    project
        .apply(Edit::AddElement {
            scenario,
            index,
            element,
        })
        .unwrap();
    let start = project.to_json();
    let mut history = History::new(4 << 20);
    for i in 0..1000 {
        let mut element = long.clone();
        if let ElementKind::Polygon(polygon) = &mut element.kind {
            let height_m = f64::from(i);
            polygon.surface = SurfaceKind::Platform { height_m }.into();
        }
        let element = Arc::new(element);
        let scenario = None;
        history
            .apply(&mut project, Edit::ReplaceElement { scenario, element })
            .unwrap();
    }
    assert_eq!(history.position(), 1000, "geometry is shared by all steps");
    assert!(history.bytes() <= 4 << 20);
    history.go_to(&mut project, 0).unwrap();
    assert_eq!(project.to_json(), start);
}

#[test]
fn an_edit_names_what_it_cannot_find() {
    let mut project = small();
    let mut message = |edit| project.apply(edit).unwrap_err().to_string();
    let id = ElementId::from("x");
    assert_eq!(
        message(Edit::RemoveElement {
            scenario: None,
            id: id.clone()
        }),
        "expected the id of an element of the base, found \"x\""
    );
    assert_eq!(
        message(Edit::RemoveElement {
            scenario: Some("one".into()),
            id: id.clone()
        }),
        "expected the id of an element of scenario \"one\", found \"x\""
    );
    assert_eq!(
        message(Edit::RemoveElement {
            scenario: Some("none".into()),
            id
        }),
        "expected the id of a scenario, found \"none\""
    );
    let outline = vec![Vertex::new(0.0, 91.0)];
    let polygon = Polygon::new(outline, SurfaceKind::Tin);
    let element = Element::new("y".into(), "y", ElementKind::Polygon(polygon));
    assert_eq!(
        message(Edit::AddElement {
            scenario: None,
            index: None,
            element: Arc::new(element)
        }),
        "at /element/outline/0/1: expected -90 to 90, found 91"
    );
}
