//! The file format: what is read is what is written, and faults say where they are.

#![allow(clippy::unwrap_used, reason = "a test may stop")]

use std::path::Path;

use proptest::prelude::*;
use relievo_project::{LayerKind, OpenProjectError, Project};
use serde_json::{Value, json};

const EVERYTHING: &str = include_str!("data/everything.relievo");

fn read(text: &str) -> Result<Project, OpenProjectError> {
    Project::from_json(text, Path::new("p.relievo"))
}

fn message(value: &Value) -> String {
    read(&value.to_string()).unwrap_err().to_string()
}

fn with_layer(layer: &Value) -> Value {
    json!({ "version": 1, "layers": [layer] })
}

#[test]
fn a_canonical_file_is_written_back_byte_for_byte() {
    let project = read(EVERYTHING).unwrap();
    assert_eq!(project.to_json(), EVERYTHING);
    assert_eq!(read(&project.to_json()).unwrap(), project);
}

#[test]
fn a_new_project_is_short() {
    insta::assert_snapshot!(Project::default().to_json(), @r#"
    {
      "version": 1,
      "planet": {
        "preset": "earth"
      },
      "camera": {
        "lon_deg": 0.0,
        "lat_deg": 0.0,
        "altitude_m": 15000000.0
      },
      "layers": []
    }
    "#);
}

#[test]
fn an_unknown_layer_is_kept_and_inert() {
    let project = read(EVERYTHING).unwrap();
    let unknown = project
        .layers
        .iter()
        .find(|layer| layer.id.0 == "roads")
        .unwrap();
    assert_eq!(
        unknown.kind,
        LayerKind::Unknown {
            kind: "cadastre".into()
        }
    );
    assert_eq!(unknown.extra["features"]["type"], "FeatureCollection");
}

#[test]
fn a_newer_version_is_refused_with_both_versions() {
    let message = message(&json!({ "version": 7 }));
    assert_eq!(
        message,
        "this program reads versions up to 1, the file has version 7: open it with a newer Relievo: \"p.relievo\""
    );
}

#[test]
fn a_fault_says_line_place_expected_and_found() {
    let text = "{\n  \"version\": 1,\n  \"layers\": [\n    {\"id\": \"a\", \"kind\": \"imagery\", \"path\": \"a.tif\",\n     \"opacity\": 2}\n  ]\n}\n";
    assert_eq!(
        read(text).unwrap_err().to_string(),
        "line 5, at /layers/0/opacity: expected 0 to 1, found 2: \"p.relievo\""
    );
}

#[test]
fn wrong_values_are_named() {
    let imagery = |member: &str, value: Value| {
        let mut layer = json!({ "id": "a", "kind": "imagery", "path": "a.tif" });
        layer[member] = value;
        with_layer(&layer)
    };
    let tint = |stops: Value| with_layer(&json!({ "id": "a", "kind": "tint", "stops": stops }));
    let cases = [
        (json!([]), "an object"),
        (json!({}), "a member \"version\""),
        (json!({ "version": "1" }), "at /version"),
        (json!({ "version": 0 }), "1 or more"),
        (
            json!({ "version": 1, "planet": {} }),
            "\"preset\" or \"radius_m\"",
        ),
        (
            json!({ "version": 1, "planet": { "preset": "pluto" } }),
            "earth mars moon",
        ),
        (
            json!({ "version": 1, "planet": { "preset": "mars", "radius_m": 5 } }),
            "found both",
        ),
        (
            json!({ "version": 1, "sun": { "anchor_lon_deg": 5 } }),
            "or neither",
        ),
        (
            json!({ "version": 1, "quality": { "colour_window_samples": 1000 } }),
            "2048",
        ),
        (
            json!({ "version": 1, "quality": { "aim": "speed" } }),
            "/quality/aim: expected one of adapter error frame_time, found \"speed\"",
        ),
        (
            json!({ "version": 1, "quality": { "error_px": 0 } }),
            "/quality/error_px",
        ),
        (
            json!({ "version": 1, "quality": { "frame_budget_ms": 2000 } }),
            "/quality/frame_budget_ms",
        ),
        (imagery("id", json!("a b")), "found \"a b\""),
        (imagery("path", json!("")), "not empty"),
        (imagery("path", json!(null)), "expected a text, found null"),
        (
            imagery("blend", json!("burn")),
            "normal multiply add screen overlay",
        ),
        (imagery("bands", json!([1, 2])), "one, three or four"),
        (
            imagery("adjust", json!({ "gain": [1, 1, 17] })),
            "/adjust/gain/2",
        ),
        (imagery("adjust", json!({ "gain": [1, 1] })), "3 numbers"),
        (imagery("georeference", json!({})), "the four edges"),
        (
            imagery("georeference", json!({ "west": 0 })),
            "some of them",
        ),
        (
            imagery(
                "georeference",
                json!({ "west": 170, "east": -170, "south": 0, "north": 1 }),
            ),
            "add 360",
        ),
        (tint(json!([])), "1 to 1000 stops"),
        (tint(json!([{ "height_m": 0, "colour": "red" }])), "#rrggbb"),
        (
            tint(
                json!([{ "height_m": 0, "colour": "#000000" }, { "height_m": 0, "colour": "#000000" }]),
            ),
            "/layers/0/stops/1/height_m",
        ),
        (
            with_layer(&json!({ "id": "a", "kind": "detail", "lowest_m": 100, "highest_m": 100 })),
            "/layers/0/highest_m: expected more than lowest_m, 100",
        ),
        (
            json!({ "version": 1, "layers": [{ "id": "a", "kind": "x" }, { "id": "a", "kind": "x" }] }),
            "/layers/1/id",
        ),
    ];
    for (value, part) in cases {
        let message = message(&value);
        assert!(
            message.contains(part) && !message.contains('\n'),
            "{value}: {message}"
        );
    }
}

#[test]
fn a_repeated_member_is_refused_instead_of_losing_one() {
    let message = read("{\"version\": 1, \"layers\": [], \"layers\": []}")
        .unwrap_err()
        .to_string();
    assert!(message.contains("\"layers\" twice"), "{message}");
}

#[test]
fn a_byte_order_mark_and_crlf_are_accepted() {
    let windows = format!("\u{feff}{}", EVERYTHING.replace('\n', "\r\n"));
    assert_eq!(read(&windows).unwrap().to_json(), EVERYTHING);
}

#[test]
fn a_name_of_a_known_field_among_the_unknown_ones_cannot_change_a_default() {
    let mut project = read(EVERYTHING).unwrap();
    project.layers[0]
        .extra
        .insert("visible".into(), false.into());
    let visible = project.layers[0].visible;
    assert_eq!(read(&project.to_json()).unwrap().layers[0].visible, visible);
}

fn any_json() -> impl Strategy<Value = Value> {
    let leaf = prop_oneof![
        Just(Value::Null),
        any::<bool>().prop_map(Value::from),
        any::<f64>().prop_map(Value::from),
        any::<i64>().prop_map(Value::from),
        ".*".prop_map(Value::from),
        Just(json!("imagery")),
    ];
    leaf.prop_recursive(4, 40, 6, |inner| {
        let name = prop_oneof![
            Just("version".to_owned()),
            Just("layers".to_owned()),
            Just("kind".to_owned()),
            Just("planet".to_owned()),
            ".{0,5}",
        ];
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..6).prop_map(Value::from),
            prop::collection::vec((name, inner), 0..6)
                .prop_map(|members| Value::Object(members.into_iter().collect())),
        ]
    })
}

/// All places of a value as JSON pointers.
fn places(value: &Value, at: &str, all: &mut Vec<String>) {
    all.push(at.to_owned());
    match value {
        Value::Array(items) => {
            items
                .iter()
                .enumerate()
                .for_each(|(i, item)| places(item, &format!("{at}/{i}"), all));
        }
        Value::Object(map) => {
            map.iter()
                .for_each(|(name, item)| places(item, &format!("{at}/{name}"), all));
        }
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(400) })]

    #[test]
    fn any_text_is_read_or_refused_in_one_line(text in ".*") {
        if let Err(error) = read(&text) {
            prop_assert!(!error.to_string().contains('\n'));
        }
    }

    #[test]
    fn any_json_is_read_or_refused(mut value in any_json()) {
        drop(read(&value.to_string()));
        if let Value::Object(map) = &mut value {
            map.insert("version".into(), 1.into());
        }
        if let Ok(project) = read(&value.to_string()) {
            prop_assert_eq!(read(&project.to_json()).unwrap(), project);
        }
    }

    #[test]
    fn a_valid_file_with_one_value_replaced_is_read_or_refused(
        place in any::<prop::sample::Index>(), new in any_json(),
    ) {
        let mut value: Value = serde_json::from_str(EVERYTHING).unwrap();
        let mut all = Vec::new();
        places(&value, "", &mut all);
        *value.pointer_mut(place.get::<String>(&all)).unwrap() = new;
        if let Ok(project) = read(&value.to_string()) {
            prop_assert_eq!(read(&project.to_json()).unwrap(), project);
        }
    }

    #[test]
    fn a_file_cut_or_damaged_anywhere_is_read_or_refused(at in any::<prop::sample::Index>(), byte in any::<u8>()) {
        let mut bytes = EVERYTHING.as_bytes().to_vec();
        let at = at.index(bytes.len());
        bytes[at] = byte;
        drop(read(&String::from_utf8_lossy(&bytes)));
        drop(read(&String::from_utf8_lossy(&bytes[..at])));
    }
}
