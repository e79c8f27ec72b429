//! The published JSON Schema says what the reader does.

use std::path::Path;

use relievo_project::{Edit, Project, schema, schema_text};
use serde_json::{Value, json};

const EVERYTHING: &str = include_str!("data/everything.relievo");

#[test]
fn the_published_schema_is_the_programs() {
    let published = std::fs::read_to_string(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../docs/relievo.schema.json"
    ));
    assert!(
        published.unwrap_or_default() == schema_text(),
        "the schema has changed: run `relievo schema > docs/relievo.schema.json`"
    );
}

#[test]
fn sample_documents_fit_the_schema() {
    let validator = jsonschema::validator_for(&schema()).unwrap();
    for text in [EVERYTHING.to_owned(), Project::default().to_json()] {
        let value: Value = serde_json::from_str(&text).unwrap();
        let faults: Vec<String> = validator
            .iter_errors(&value)
            .map(|e| format!("{}: {e}", e.instance_path()))
            .collect();
        assert!(faults.is_empty(), "{faults:#?}");
    }
}

#[test]
fn what_the_schema_refuses_the_reader_refuses() {
    let validator = jsonschema::validator_for(&schema()).unwrap();
    for (pointer, wrong) in [
        ("/version", json!(2)),
        ("/planet/vertical_exaggeration", json!(-1)),
        ("/camera/lat_deg", json!(91)),
        ("/camera/lon_deg", json!("east")),
        ("/quality/colour_window_samples", json!(1000)),
        ("/quality/mesh_density", json!(0)),
        ("/quality/aim", json!("speed")),
        ("/quality/error_px", json!(0.001)),
        ("/quality/frame_budget_ms", json!(0)),
        ("/layers/0/opacity", json!(1.5)),
        ("/layers/0/id", json!("a b")),
        ("/layers/0/adjust/gain", json!([1, 1, 17])),
        ("/layers/0/blend", json!("burn")),
        ("/layers/1/band", json!(0)),
        ("/layers/2/octaves", json!(0)),
        ("/layers/3/stops/0/colour", json!("red")),
        ("/layers/5/style/stroke_width/unit", json!("pt")),
        ("/layers/5/style/extrude", json!({ "height_m": -1 })),
        ("/layers/6/stops/1/slope_deg", json!(91)),
        ("/layers/6/stops/0/opacity", json!(-0.5)),
        ("/layers/6/mask/polygon/corners_m", json!([[0, 0], [1, 0]])),
        ("/layers/6/mask/polygon/corners_m", json!(vec![[0, 0]; 257])),
        ("/layers/6/mask/polygon/corners_m/1", json!([0, 0, 0])),
        ("/layers/6/mask/polygon/corners_m/1/0", json!(1.1e7)),
        ("/layers/6/mask/polygon/fade_m", json!(-1)),
        ("/layers/7/interval_m", json!(0)),
        ("/layers/7/colour", json!("brown")),
        ("/layers/8/strength", json!(5)),
        ("/layers/8/method", json!("fourier")),
        ("/layers/8/shortest_m", json!(0)),
        ("/elements/0/outline/1", json!([0, 0, 0, 0])),
        ("/elements/0/outline/1/1", json!(91)),
        ("/elements/0/surface/height_m", json!("high")),
        ("/elements/0/side/cut_slope", json!(0)),
        ("/elements/4/outline/vertices", json!(-1)),
        ("/elements/6/section/width_m", json!(0)),
        ("/elements/10/strokes/0/strength_m", json!(null)),
        ("/scenarios/0/changes/1/element/line/0", json!([0])),
        ("/scenarios/0/layers/0/opacity", json!(2)),
        ("/bookmarks/0/camera/lat_deg", json!(91)),
    ] {
        let mut value: Value = serde_json::from_str(EVERYTHING).unwrap();
        *value.pointer_mut(pointer).unwrap() = wrong;
        assert!(
            !validator.is_valid(&value),
            "the schema accepts a wrong {pointer}"
        );
        assert!(
            Project::from_json(&value.to_string(), Path::new("p")).is_err(),
            "the reader accepts a wrong {pointer}"
        );
    }
}

#[test]
fn edits_fit_the_schema_of_edits_and_read_back() {
    let mut whole = schema();
    whole["$ref"] = "#/$defs/edits".into();
    let mut edits_schema = json!({ "$schema": whole["$schema"], "$ref": "#/$defs/edits" });
    edits_schema["$defs"] = whole["$defs"].take();
    let validator = jsonschema::validator_for(&edits_schema).unwrap();

    let text = include_str!("data/edits.json");
    let edits = Edit::list_from_json(text, Path::new("edits.json")).unwrap();
    assert_eq!(Edit::list_to_json(&edits), text);
    let faults: Vec<String> = validator
        .iter_errors(&serde_json::from_str(text).unwrap())
        .map(|e| format!("{}: {e}", e.instance_path()))
        .collect();
    assert!(faults.is_empty(), "{faults:#?}");
    assert!(!validator.is_valid(&json!([{ "edit": "set_opacity", "id": "a", "opacty": 1 }])));
}
