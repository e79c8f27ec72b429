//! Edits that are refused change nothing and say why.

use std::path::Path;

use relievo_project::{
    Adjust, ClearColour, CurvePoint, Edit, Extra, HeightEncoding, Stretch, ToneCurves,
};

use crate::{EVERYTHING, everything, opacity};

#[test]
fn a_batch_that_fails_half_way_changes_nothing() {
    let mut project = everything();
    let edits = vec![
        opacity(0.1),
        Edit::RemoveLayer {
            id: "nobody".into(),
        },
    ];
    let error = project
        .apply(Edit::Batch {
            label: String::new(),
            edits,
        })
        .unwrap_err();
    assert_eq!(
        error.to_string(),
        "edit 1 of the batch: expected the id of a layer, found \"nobody\""
    );
    assert_eq!(project.to_json(), EVERYTHING);
}

#[test]
fn values_that_no_file_can_hold_are_refused() {
    let mut project = everything();
    for wrong in [f64::NAN, f64::INFINITY, -0.1, 1.1] {
        project.apply(opacity(wrong)).unwrap_err();
    }
    let nodata = Some(f64::NAN);
    project
        .apply(Edit::SetNodata {
            id: "wasatch".into(),
            nodata,
        })
        .unwrap_err();
    let adjust = Adjust {
        brightness: f64::NAN,
        ..Adjust::default()
    };
    project
        .apply(Edit::SetAdjust {
            id: "blue-marble".into(),
            adjust,
        })
        .unwrap_err();
    assert_eq!(project.to_json(), EVERYTHING);
}

#[test]
fn adjustments_beyond_their_ranges_or_without_sense_are_refused_by_member() {
    let point = |input, output| CurvePoint {
        input,
        output,
        extra: Extra::new(),
    };
    let curves = |points: &[CurvePoint]| ToneCurves {
        channels: [Vec::new(), points.to_vec(), Vec::new()],
        ..ToneCurves::default()
    };
    let clear = |from, to| ClearColour {
        colour: [0, 255, 0],
        from,
        to,
        extra: Extra::new(),
    };
    let mut project = everything();
    let mut refused = |change: &dyn Fn(&mut Adjust), member: &str| {
        let mut adjust = Adjust::default();
        change(&mut adjust);
        let edit = Edit::SetAdjust {
            id: "blue-marble".into(),
            adjust,
        };
        let line = project.apply(edit).unwrap_err().to_string();
        assert!(line.contains(member), "{member}: {line}");
    };
    refused(&|a| a.temperature_k = 900.0, "temperature_k");
    refused(&|a| a.tint = f64::NAN, "tint");
    refused(&|a| a.mix[1][2] = 17.0, "mix_green/2");
    refused(&|a| a.strength = 1.1, "strength");
    refused(
        &|a| a.curves = curves(&[point(0.5, 0.1), point(0.5, 0.2)]),
        "curves/green/1/input",
    );
    refused(
        &|a| a.curves = curves(&[point(0.5, 1.1)]),
        "curves/green/0/output",
    );
    refused(
        &|a| a.curves = curves(&vec![point(0.0, 0.0); 300]),
        "at most 256 points",
    );
    refused(&|a| a.clear = Some(clear(0.5, 0.5)), "clear/to");
    assert_eq!(project.to_json(), EVERYTHING);
}

#[test]
fn only_imagery_is_stretched_and_only_between_numbers_that_make_sense() {
    let mut project = everything();
    let set = |id: &str, stretch| Edit::SetStretch {
        id: id.into(),
        stretch,
    };
    let line = project
        .apply(set("wasatch", Stretch::Full))
        .unwrap_err()
        .to_string();
    assert!(line.contains("imagery layer"), "{line}");
    for nonsense in [
        Stretch::Percentile {
            low: 50.0,
            high: 50.0,
        },
        Stretch::Percentile {
            low: -1.0,
            high: 50.0,
        },
        Stretch::Percentile {
            low: 2.0,
            high: 101.0,
        },
        Stretch::Range {
            black: 7.0,
            white: 7.0,
        },
        Stretch::Range {
            black: f64::NAN,
            white: 7.0,
        },
        Stretch::Range {
            black: 0.0,
            white: f64::INFINITY,
        },
    ] {
        let line = project
            .apply(set("blue-marble", nonsense))
            .unwrap_err()
            .to_string();
        assert!(
            line.contains("percentile") && !line.contains('\n'),
            "{line}"
        );
    }
    assert_eq!(project.to_json(), EVERYTHING);
    project
        .apply(set(
            "blue-marble",
            Stretch::Range {
                black: 3000.0,
                white: 0.0,
            },
        ))
        .unwrap();
    assert!(project.to_json().contains("\"range\""));
}

#[test]
fn only_heights_have_an_encoding() {
    let mut project = everything();
    let wrong = Edit::SetTiles {
        id: "blue-marble".into(),
        encoding: Some(HeightEncoding::Terrarium),
        tile_rows: None,
    };
    let line = project.apply(wrong).unwrap_err().to_string();
    assert!(line.contains("height layer"), "{line}");
    assert_eq!(project.to_json(), EVERYTHING);
}

#[test]
fn a_slip_of_the_pen_in_a_script_is_named() {
    let text = "[\n {\"edit\": \"set_visible\", \"id\": \"a\", \"visible\": true, \"opcity\": 1}]";
    let message = Edit::list_from_json(text, Path::new("e.json"))
        .unwrap_err()
        .to_string();
    assert_eq!(
        message,
        "line 2, at /0/opcity: expected no such member in set_visible, found 1: \"e.json\""
    );
}

#[test]
fn masks_beyond_their_ranges_and_of_layers_without_colours_are_refused() {
    let refused = |kind: &str, mask: &str| {
        let edits = format!(
            r#"[{{"edit": "add_layer", "layer": {{"id": "a", "kind": {kind}, "mask": {mask}}}}}]"#
        );
        Edit::list_from_json(&edits, Path::new("edits.json"))
            .unwrap_err()
            .to_string()
    };
    let slope = r##""slope", "stops": [{"slope_deg": 0.0, "colour": "#000000"}]"##;
    let line = refused(slope, r#"{"heights": {"from_m": 10.0, "to_m": 5.0}}"#);
    assert!(
        line.contains("to_m") && line.contains("no less than from_m"),
        "{line}"
    );
    let line = refused(slope, r#"{"slopes": {"from_deg": -1.0, "to_deg": 5.0}}"#);
    assert!(line.contains("from_deg"), "{line}");
    let line = refused(
        slope,
        r#"{"circle": {"lon_deg": 0.0, "lat_deg": 91.0, "radius_m": 1.0}}"#,
    );
    assert!(line.contains("lat_deg"), "{line}");
    let polygon = |corners_m: &str| {
        let polygon = format!(r#"{{"lon_deg": 0.0, "lat_deg": 0.0, "corners_m": {corners_m}}}"#);
        refused(slope, &format!(r#"{{"polygon": {polygon}}}"#))
    };
    for (corners_m, expected) in [
        (
            "[[0, 0], [1, 0]]",
            "corners_m: expected 3 to 256 corners, found 2",
        ),
        ("5", "corners_m: expected an array of corners, found 5"),
        (
            "[[0, 0], [1, 0], [1]]",
            "corners_m/2: expected [east, north] in metres, found an array of 1",
        ),
        (
            "[[0, 0], [1, 0], [1, null]]",
            "corners_m/2: expected [east, north] in metres, found [1,null]",
        ),
        (
            "[[0, 0], [1, 0], [1, -10000001]]",
            "corners_m/2/1: expected -10000000 to 10000000, found -10000001",
        ),
    ] {
        let line = polygon(corners_m);
        assert!(line.contains(expected), "{line}");
    }
    let line = refused(
        slope,
        r#"{"circle": {"lon_deg": 0.0, "lat_deg": 0.0, "radius_m": 1.0},
            "polygon": {"lon_deg": 0.0, "lat_deg": 0.0, "corners_m": [[0, 0], [1, 0], [1, 1]]}}"#,
    );
    assert!(
        line.contains("mask/polygon: expected a circle or a polygon, found both"),
        "{line}"
    );
    let line = refused(slope, r#"{"vector": "no layer's id"}"#);
    assert!(line.contains("vector"), "{line}");
    let line = refused(r#""noise", "amplitude_m": 1.0, "wavelength_m": 5.0"#, "{}");
    assert!(
        line.contains("layer with colours") && line.contains("noise"),
        "{line}"
    );
}
