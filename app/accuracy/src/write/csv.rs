//! Figures as comma-separated values (RFC 4180) with full precision, notes in lines that begin with `#`.

use crate::{Cell, Chart, Figure, Machine, Table};

/// A chart: a row for each point.
pub(super) fn chart(figure: &Figure, chart: &Chart, machine: &Machine) -> String {
    let mut csv = head(figure, machine);
    let quartile = |name: &str| format!("{} ({name} quartile)", chart.x.title());
    let heads = [
        "curve",
        "setting",
        &chart.x.title(),
        &chart.y.title(),
        &quartile("lower"),
        &quartile("upper"),
        "on the front",
    ];
    csv += &row(heads.iter().map(|head| quoted(head)));
    let front = if chart.marks_front {
        chart.front()
    } else {
        Vec::new()
    };
    for (c, curve) in chart.curves.iter().enumerate() {
        for (p, point) in curve.points.iter().enumerate() {
            let [low, high] = point
                .x_quartiles
                .map_or([String::new(), String::new()], |all| all.map(number));
            csv += &row([
                quoted(&curve.name),
                quoted(&point.setting),
                number(point.x),
                number(point.y),
                low,
                high,
                u8::from(front.contains(&(c, p))).to_string(),
            ]);
        }
    }
    csv
}

/// A table.
pub(super) fn table(figure: &Figure, table: &Table, machine: &Machine) -> String {
    let mut csv = head(figure, machine);
    csv += &row(table.head.iter().map(|head| quoted(head)));
    for cells in &table.rows {
        csv += &row(cells.iter().map(|cell| match cell {
            Cell::Text(text) => quoted(text),
            Cell::Number(value) => number(*value),
        }));
    }
    csv
}

fn head(figure: &Figure, machine: &Machine) -> String {
    let line = |text: &str| format!("# {}\n", text.replace(['\r', '\n'], " "));
    line(&figure.title) + &line(&figure.caption) + &line(&machine.line())
}

fn row(cells: impl IntoIterator<Item = String>) -> String {
    cells.into_iter().collect::<Vec<_>>().join(",") + "\n"
}

fn number(value: f64) -> String {
    format!("{value:?}")
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) || text.starts_with('#') {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}
