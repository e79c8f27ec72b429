//! Large projects: what they hold comes back. `cargo test -p relievo-project --test scale -- --nocapture`
//! prints the times.

#![allow(clippy::unwrap_used, reason = "a test may stop")]

use std::sync::Arc;
use std::time::Instant;

use relievo_project::{
    Edit, Element, ElementKind, History, Polygon, Project, Replace, Scenario, SurfaceKind, Vertex,
    open, save_atomic,
};

fn element(i: u32) -> Arc<Element> {
    let (row, column) = (f64::from(i / 100), f64::from(i % 100));
    let outline: Vec<Vertex> = (0..20_u32)
        .map(|k| {
            let angle = f64::from(k) * core::f64::consts::TAU / 20.0;
            Vertex::at_height(
                column * 0.01 + 0.004 * angle.cos(),
                row * 0.01 + 0.004 * angle.sin(),
                f64::from(i),
            )
        })
        .collect();
    let height_m = f64::from(i);
    let polygon = Polygon::new(outline, SurfaceKind::Platform { height_m });
    let id = format!("p{i}");
    Arc::new(Element::new(
        id.as_str().into(),
        format!("Platform {i}"),
        ElementKind::Polygon(polygon),
    ))
}

#[test]
fn ten_thousand_elements_come_back_and_a_thousand_steps_are_undone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.relievo");
    let mut project = Project {
        elements: (0..10_000).map(element).collect(),
        ..Project::default()
    };
    let time = |what: &str, since: Instant| eprintln!("{what}: {:.1?}", since.elapsed());
    let start = Instant::now();
    save_atomic(&path, &project, Replace::Never).unwrap();
    time("save", start);
    eprintln!("{} bytes", std::fs::metadata(&path).unwrap().len());
    let start = Instant::now();
    let (opened, _) = open(&path).unwrap();
    time("open", start);
    assert_eq!(opened, project);

    let scenario = Box::new(Scenario::new("s".into(), "S", None));
    let index = None;
    project
        .apply(Edit::AddScenario { index, scenario })
        .unwrap();
    let before = project.clone();
    let mut history = History::default();
    let start = Instant::now();
    for i in 0..1000 {
        let mut element = (*project.elements[i * 7]).clone();
        let list = element.vertex_lists_mut().remove(0);
        let mut outline = list.to_vec();
        outline[3].lon_deg += 1e-5;
        *list = outline.into();
        let element = Arc::new(element);
        let scenario = (i % 2 == 0).then(|| "s".into());
        history
            .apply(&mut project, Edit::ReplaceElement { scenario, element })
            .unwrap();
    }
    time("1000 edits", start);
    let start = Instant::now();
    let id = "s".into();
    let elements = project.elements_in(Some(&id));
    time("elements of a scenario with 500 changes", start);
    assert_eq!(elements.len(), 10_000);
    let start = Instant::now();
    history.go_to(&mut project, 0).unwrap();
    time("undo of 1000 steps", start);
    assert_eq!(project, before);
}
