//! All reports on one page that needs nothing else: no script, no font, no network.

use core::fmt::Write;

use super::{WriteError, escaped, file_name, svg};
use crate::{Cell, Chart, Content, Figure, Machine, Picture, Report, Suite, Table, number};

const STYLE: &str = include_str!("page.css");

/// The page.
pub(super) fn page(
    reports: &[(&Suite, Report)],
    fronts: &Figure,
    machine: &Machine,
) -> Result<String, WriteError> {
    let mut html = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n\
         <title>Relievo: error against run time</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <header>\n<h1>Error against run time</h1>\n<p class=\"sub\">{}</p>\n</header>\n",
        escaped(&machine.line())
    );
    html += &contents(reports);
    html += "<main>\n";
    for (suite, report) in reports {
        html += &section(suite, report, machine)?;
    }
    if let Content::Table(table) = &fronts.content {
        // Writing to a string never fails.
        let _always = writeln!(
            html,
            "<section id=\"fronts\"><h2>{}</h2>\n<p class=\"sub\">{}</p>\n{}</section>",
            escaped(&fronts.title),
            escaped(&fronts.caption),
            rows(table)
        );
    }
    html += "</main>\n<footer>\n<p>Times are medians of repetitions in which all settings took turns; \
             thin lines at points reach from the lower to the upper quartile. In charts of error against time, \
             numbered points are the <b>pareto front</b>: nothing measured is both faster and more exact. \
             On logarithmic axes a value of zero stands at the tick 0. Exact numbers are in the files beside this page.</p>\n\
             </footer>\n</body>\n</html>\n";
    Ok(html)
}

fn contents(reports: &[(&Suite, Report)]) -> String {
    let mut html = "<nav aria-label=\"Suites\">\n<ul>\n".to_owned();
    for (suite, _) in reports {
        let (name, sentence) = (escaped(suite.name), escaped(suite.sentence));
        let _always = writeln!(
            html,
            "<li><a href=\"#{name}\">{name}</a> <span>{sentence}</span></li>"
        );
    }
    html + "<li><a href=\"#fronts\">What nothing beats</a> <span>All pareto fronts in one table.</span></li>\n</ul>\n</nav>\n"
}

fn section(suite: &Suite, report: &Report, machine: &Machine) -> Result<String, WriteError> {
    let name = escaped(suite.name);
    let mut html = format!(
        "<section id=\"{name}\" aria-labelledby=\"{name}-title\">\n<h2 id=\"{name}-title\">{name}</h2>\n\
         <p class=\"sub\">{}</p>\n",
        escaped(suite.sentence)
    );
    for paragraph in &report.summary {
        let _always = writeln!(html, "<p>{}</p>", escaped(paragraph));
    }
    for figure in &report.figures {
        html += &one_figure(suite, figure, machine)?;
    }
    Ok(html + "</section>\n")
}

fn one_figure(suite: &Suite, figure: &Figure, machine: &Machine) -> Result<String, WriteError> {
    let id = escaped(&format!("{}-{}", suite.name, figure.name));
    let (shown, extensions): (String, &[&str]) = match &figure.content {
        Content::Chart(chart) => {
            let drawn = svg::inline(figure, chart)?;
            let points = points(chart);
            let details =
                format!("<details><summary>All points as a table</summary>\n{points}</details>\n");
            (
                format!("<div class=\"scroll\">{drawn}</div>\n{details}"),
                &["svg", "csv"],
            )
        }
        Content::Table(table) => (rows(table), &["csv"]),
        Content::Picture(picture) => (image(picture), &["png"]),
    };
    let files: Vec<String> = extensions
        .iter()
        .map(|extension| {
            let file = escaped(&file_name(suite, &figure.name, extension));
            format!("<a href=\"{file}\">{extension}</a>")
        })
        .collect();
    Ok(format!(
        "<figure id=\"{id}\">\n<h3>{}</h3>\n{shown}<figcaption>{}<br><small>{} · {}</small></figcaption>\n</figure>\n",
        escaped(&figure.title),
        escaped(&figure.caption),
        escaped(&machine.line()),
        files.join(" ")
    ))
}

/// A chart's points, for who does not look at charts.
fn points(chart: &Chart) -> String {
    let front = chart.marked();
    let mut table = Table {
        head: ["curve", "setting", &chart.x.title(), &chart.y.title()]
            .map(str::to_owned)
            .to_vec(),
        rows: Vec::new(),
    };
    if chart.marks_front {
        table.head.push("front".to_owned());
    }
    for (c, curve) in chart.curves.iter().enumerate() {
        for (p, point) in curve.points.iter().enumerate() {
            let mut cells: Vec<Cell> = vec![
                curve.name.as_str().into(),
                point.setting.as_str().into(),
                point.x.into(),
                point.y.into(),
            ];
            if chart.marks_front {
                let rank = front.iter().position(|on| *on == (c, p));
                cells.push(
                    rank.map_or_else(String::new, |r| (r + 1).to_string())
                        .into(),
                );
            }
            table.rows.push(cells);
        }
    }
    rows(&table)
}

fn rows(table: &Table) -> String {
    let mut html = "<div class=\"scroll\" tabindex=\"0\"><table>\n<thead><tr>".to_owned();
    for head in &table.head {
        html.extend(["<th scope=\"col\">", &escaped(head), "</th>"]);
    }
    html += "</tr></thead>\n<tbody>\n";
    for cells in &table.rows {
        html += "<tr>";
        for cell in cells {
            match cell {
                Cell::Text(text) => html.extend(["<td>", &escaped(text), "</td>"]),
                Cell::Number(value) => {
                    html.extend(["<td class=\"number\">", &number::text(*value), "</td>"]);
                }
            }
        }
        html += "</tr>\n";
    }
    html + "</tbody>\n</table></div>\n"
}

fn image(picture: &Picture) -> String {
    format!(
        "<img alt=\"{}\" src=\"data:image/png;base64,{}\">\n",
        escaped(&picture.description),
        base64(&picture.png)
    )
}

/// RFC 4648.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let byte = |i: usize| u32::from(chunk.get(i).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for i in 0..4 {
            let digit = DIGITS[(bits >> (18 - 6 * i) & 63) as usize];
            text.push(if i <= chunk.len() {
                char::from(digit)
            } else {
                '='
            });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_written_as_rfc_4648_says() {
        for (bytes, text) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }
}
