//! A comparison as JSON and as a table.

use relievo_engine::analysis::{Amount, ComparisonReport, Volumes};
use serde_json::{Map, Value, json};

/// A column: name with unit, what to read, digits after the point.
pub(crate) type Quantity = (&'static str, fn(&Volumes) -> Amount, usize);

/// Quantities in the order of columns.
pub(crate) const QUANTITIES: [Quantity; 8] = [
    ("cut_m3", |v| v.cut_m3, 2),
    ("fill_m3", |v| v.fill_m3, 2),
    ("net_m3", |v| v.net_m3, 2),
    ("plan_area_m2", |v| v.plan_area_m2, 2),
    ("surface_area_m2", |v| v.surface_area_m2, 2),
    ("highest_cut_m", |v| v.highest_cut_m, 3),
    ("highest_fill_m", |v| v.highest_fill_m, 3),
    ("mean_slope_deg", |v| v.mean_slope_deg, 2),
];

pub(super) fn json(report: &ComparisonReport) -> Value {
    let elements: Vec<Value> = report
        .elements
        .iter()
        .map(|element| {
            let mut row = Map::new();
            row.insert("id".to_owned(), json!(element.id.0));
            row.insert("name".to_owned(), json!(element.name));
            row.insert("kind".to_owned(), json!(element.kind));
            row.insert("step".to_owned(), json!(element.step.name()));
            row.extend(quantities(&element.volumes));
            Value::Object(row)
        })
        .collect();
    json!({
        "a": report.names[0],
        "b": report.names[1],
        "elements": elements,
        "total": quantities(&report.total),
        "notes": report.notes,
    })
}

fn quantities(volumes: &Volumes) -> Map<String, Value> {
    let mut row = Map::new();
    for (name, of, _) in QUANTITIES {
        let amount = of(volumes);
        row.insert(
            name.to_owned(),
            json!({ "value": amount.value, "error": amount.error }),
        );
    }
    row.insert("finest_spacing_m".to_owned(), json!(volumes.finest_m));
    row.insert("samples".to_owned(), json!(volumes.samples));
    row
}

pub(super) fn csv(report: &ComparisonReport) -> String {
    let mut text = String::from("id,name,kind,step");
    for (name, _, _) in QUANTITIES {
        text.extend([",", name, ",", name, "_error"]);
    }
    text.push('\n');
    let mut row = |cells: [&str; 4], volumes: &Volumes| {
        text += &cells.map(quoted).join(",");
        for (_, of, digits) in QUANTITIES {
            let amount = of(volumes);
            let pair = format!(",{:.digits$},{:.digits$}", amount.value, amount.error);
            text += &pair;
        }
        text.push('\n');
    };
    for element in &report.elements {
        let cells = [
            &element.id.0,
            element.name.as_str(),
            &element.kind,
            element.step.name(),
        ];
        row(cells, &element.volumes);
    }
    row(["", "total", "", ""], &report.total);
    text
}

/// A field of a table (RFC 4180).
fn quoted(cell: &str) -> String {
    if cell.contains(['"', ',', '\n', '\r']) {
        format!("\"{}\"", cell.replace('"', "\"\""))
    } else {
        cell.to_owned()
    }
}
