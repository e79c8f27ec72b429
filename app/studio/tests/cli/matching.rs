//! Layers brought to one look.

use serde_json::Value;

use crate::shared::{good, in_folder, refused, sample_file, text_file};

#[test]
fn a_layer_matched_to_another_looks_like_it_and_stays_editable() {
    let folder = tempfile::tempdir().unwrap();
    let aerial = sample_file("data/provo-aerial.tif");
    let layer = |id: &str, adjust: &str| {
        format!(
            r#"{{"id": "{id}", "name": "{id}", "kind": "imagery", "path": "{aerial}", "adjust": {adjust}}}"#
        )
    };
    let hazy = r#"{"gain": [0.7, 0.8, 0.6], "offset": [0.1, 0.12, 0.2]}"#;
    let text = format!(
        r#"{{"version": 1, "layers": [{}, {}]}}"#,
        layer("below", hazy),
        layer("above", "{}")
    );
    let project = text_file(folder.path(), "two.relievo", &text);
    let before = good(&["compare", &project, "--layers", "above,below"]).json();
    assert!(
        before["ciede2000"]["mean"].as_f64().unwrap() > 5.0,
        "{before}"
    );
    for (method, most) in [("mean", 0.1), ("histogram", 1.0), ("regression", 0.1)] {
        let edits = in_folder(folder.path(), "edits.json");
        let told = good(&[
            "match", &project, "--layer", "above", "--method", method, "-o", &edits,
        ])
        .json();
        assert_eq!(
            told["ciede2000_before"]["mean"],
            before["ciede2000"]["mean"]
        );
        let matched = in_folder(folder.path(), "matched.relievo");
        good(&["apply", &project, &edits, "-o", &matched]);
        let after = good(&["compare", &matched, "--layers", "above,below"]).json();
        let mean = after["ciede2000"]["mean"].as_f64().unwrap();
        assert!(mean < most, "{method}: {mean}");
        for figure in ["mean", "p95"] {
            assert_eq!(
                told["ciede2000_after"][figure], after["ciede2000"][figure],
                "{method}: what was foretold is what is shown"
            );
        }
    }
    let unknown = refused(&["match", &project, "--layer", "nothing"]);
    assert!(
        unknown.contains("nothing") && unknown.contains("below, above"),
        "{unknown}"
    );
    let lowest = refused(&["match", &project, "--layer", "below"]);
    assert!(lowest.contains("nothing below"), "{lowest}");
    let elsewhere = refused(&["match", &project, "--layer", "above", "--region", "0,0,1,1"]);
    assert!(
        elsewhere.contains("at least 50 places") && elsewhere.contains("found 0"),
        "{elsewhere}"
    );
}

#[test]
fn several_layers_balanced_at_once_look_like_the_one_that_is_held() {
    let folder = tempfile::tempdir().unwrap();
    let aerial = sample_file("data/provo-aerial.tif");
    // Three copies of one picture, told apart by what is added to them: what a balance of own colours has
    // nothing to do for, and of a held layer as it is shown all the more.
    let layer = |id: &str, adjust: &str| {
        format!(
            r#"{{"id": "{id}", "name": "{id}", "kind": "imagery", "path": "{aerial}", "adjust": {adjust}}}"#
        )
    };
    let hazy = r#"{"gain": [0.7, 0.8, 0.6], "offset": [0.1, 0.12, 0.2]}"#;
    let layers = [layer("held", hazy), layer("a", "{}"), layer("b", "{}")];
    let text = format!(r#"{{"version": 1, "layers": [{}]}}"#, layers.join(", "));
    let project = text_file(folder.path(), "three.relievo", &text);
    let edits = in_folder(folder.path(), "edits.json");
    let told = good(&[
        "balance", &project, "--layers", "held,a,b", "--hold", "held", "-o", &edits,
    ])
    .json();
    let overlaps = told["overlaps"].as_array().unwrap();
    assert_eq!(overlaps.len(), 3, "{told}");
    let mean = |overlap: &Value, when: &str| overlap[when]["mean"].as_f64().unwrap();
    assert!(mean(&overlaps[0], "ciede2000_before") > 5.0, "{told}");
    let balanced = in_folder(folder.path(), "balanced.relievo");
    good(&["apply", &project, &edits, "-o", &balanced]);
    for (overlap, id) in overlaps.iter().zip(["a", "b"]) {
        let shown = good(&["compare", &balanced, "--layers", &format!("{id},held")]).json();
        let shown = shown["ciede2000"]["mean"].as_f64().unwrap();
        assert!(shown < 0.2, "{id}: {shown}");
        // The same colours in the other order.
        let foretold = mean(overlap, "ciede2000_after");
        assert!((shown - foretold).abs() < 1e-6, "{id}: {shown} {foretold}");
    }
    let held = std::fs::read_to_string(&edits).unwrap();
    assert!(!held.contains("held"), "{held}");
    let one = refused(&["balance", &project, "--layers", "a"]);
    assert!(one.contains("at least two layers"), "{one}");
    let twice = refused(&["balance", &project, "--layers", "a,a"]);
    assert!(twice.contains("each layer once"), "{twice}");
    let other = refused(&["balance", &project, "--layers", "a,b", "--hold", "held"]);
    assert!(other.contains("one of the layers"), "{other}");
}
