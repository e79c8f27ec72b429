//! Figures as comma-separated values (RFC 4180) with full precision, notes in lines that begin with `#`.

use crate::{Cell, Chart, Content, Figure, Machine, Table};

/// A figure under its title, its caption and what it was measured on; a picture has nothing more.
pub(super) fn figure(figure: &Figure, machine: &Machine) -> String {
    let line = |text: &str| format!("# {}\n", text.replace(['\r', '\n'], " "));
    let head = line(&figure.title) + &line(&figure.caption) + &line(&machine.line());
    head + &match &figure.content {
        Content::Chart(of) => chart(of),
        Content::Table(of) => table(of),
        Content::Picture(_) => String::new(),
    }
}

/// A row for each point.
fn chart(chart: &Chart) -> String {
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
    let mut csv = row(heads.iter().map(|head| quoted(head)));
    let front = chart.marked();
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

/// Rows under a head.
fn table(table: &Table) -> String {
    let mut csv = row(table.head.iter().map(|head| quoted(head)));
    for cells in &table.rows {
        csv += &row(cells.iter().map(|cell| match cell {
            Cell::Text(text) => quoted(text),
            Cell::Number(value) => number(*value),
        }));
    }
    csv
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
