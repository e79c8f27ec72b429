//! Charts as SVG.
//!
//! Colours are few and fixed, so that the page can turn them for a dark background by name.

use plotters::coord::Shift;
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::scale::Scale;
use super::{WriteError, escaped};
use crate::{Axis, Chart, Figure, Machine, Point, number};

/// Size of a chart, pixels.
const SIZE: (u32, u32) = (980, 520);
/// Width of the key at its right.
const KEY_WIDTH: u32 = 300;
/// Rows of the key.
const KEY_ROW: i32 = 20;
/// Characters in a row of the key.
const KEY_CHARACTERS: usize = 42;

/// Paper, ink and grid: the page's style sheet names them too.
const PAPER: RGBColor = RGBColor(0xFF, 0xFF, 0xFF);
const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
const GRID: RGBColor = RGBColor(0xDD, 0xDD, 0xDD);

/// Colours of curves, told apart with any colour vision and on light and dark (after M. Okabe and
/// K. Ito, 2008); shapes differ too.
const COLOURS: [RGBColor; 8] = [
    RGBColor(0x00, 0x72, 0xB2),
    RGBColor(0xD5, 0x5E, 0x00),
    RGBColor(0x00, 0x9E, 0x73),
    RGBColor(0xCC, 0x79, 0xA7),
    RGBColor(0x9A, 0x7D, 0x0A),
    RGBColor(0x56, 0xB4, 0xE9),
    RGBColor(0x8A, 0x6F, 0xD8),
    RGBColor(0x80, 0x80, 0x80),
];

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Plane<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<Scale, Scale>>;
type Failed = Box<dyn core::error::Error>;

impl Ranged for Scale {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, place: &f64, (from, to): (i32, i32)) -> i32 {
        let share = (place - self.low) / (self.high - self.low);
        from + libm::round(f64::from(to - from) * share) as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() {
            Vec::new()
        } else {
            self.ticks.clone()
        }
    }

    fn range(&self) -> core::ops::Range<f64> {
        self.low..self.high
    }
}

impl ValueFormatter<f64> for Scale {
    fn format(place: &f64) -> String {
        number::text(*place)
    }

    fn format_ext(&self, place: &f64) -> String {
        self.label(*place)
    }
}

/// A chart for the page: no background of its own.
pub(super) fn inline(figure: &Figure, chart: &Chart) -> Result<String, WriteError> {
    drawn(figure, chart, None)
}

/// A chart as a file: with paper, title and what it was measured on.
pub(super) fn file(
    figure: &Figure,
    chart: &Chart,
    machine: &Machine,
) -> Result<String, WriteError> {
    drawn(figure, chart, Some(machine))
}

fn drawn(figure: &Figure, chart: &Chart, machine: Option<&Machine>) -> Result<String, WriteError> {
    let mut drawing = Drawing {
        chart,
        scales: [
            Scale::new(&chart.x, values(chart, |p| p.x)),
            Scale::new(&chart.y, values(chart, |p| p.y)),
        ],
        front: chart.marked(),
        tips: String::new(),
    };
    let mut svg = String::new();
    drawing
        .draw(&mut svg, figure, machine)
        .map_err(|reason| WriteError::Chart {
            figure: figure.name.clone(),
            reason: reason.to_string(),
        })?;
    // What the library cannot write: a name for who cannot see it, and what a pointer rests on.
    let label = format!(
        "<svg role=\"img\" aria-label=\"{}\" font-variant-numeric=\"tabular-nums\" ",
        escaped(&format!(
            "{}: {} against {}",
            figure.title,
            chart.y.title(),
            chart.x.title()
        ))
    );
    let svg = svg.replacen("<svg ", &label, 1);
    Ok(svg.replacen("</svg>", &format!("{}</svg>", drawing.tips), 1))
}

fn values(chart: &Chart, of: fn(&Point) -> f64) -> impl Iterator<Item = f64> {
    let points = chart.curves.iter().flat_map(|curve| &curve.points);
    // A point is drawn if both of its values can be.
    points
        .filter(|p| p.x.is_finite() && p.y.is_finite())
        .map(of)
}

struct Drawing<'a> {
    chart: &'a Chart,
    scales: [Scale; 2],
    front: Vec<(usize, usize)>,
    /// Elements that tell about points when a pointer rests on them.
    tips: String,
}

impl Drawing<'_> {
    fn draw(
        &mut self,
        svg: &mut String,
        figure: &Figure,
        machine: Option<&Machine>,
    ) -> Result<(), Failed> {
        // A file has a title, and two lines at its foot.
        let (above, below) = if machine.is_some() { (36, 42) } else { (0, 0) };
        let key = self.key();
        let key_height = key.len() as u32 * KEY_ROW as u32 + 44;
        let (width, height) = (SIZE.0, SIZE.1.max(key_height) + above + below);
        let root = SVGBackend::with_string(svg, (width, height)).into_drawing_area();
        if let Some(machine) = machine {
            root.fill(&PAPER)?;
            let line = machine.line();
            let (on, by) = line.split_once("; ").unwrap_or((&line, ""));
            draw_text(&root, &figure.title, (16, 22), 20)?;
            draw_text(&root, on, (16, height as i32 - 30), 12)?;
            draw_text(&root, by, (16, height as i32 - 14), 12)?;
        }
        let plot = root.margin(above, below, 0, KEY_WIDTH);
        self.draw_plot(&root, &plot)?;
        for (row, (curve, text)) in key.iter().enumerate() {
            let at = (
                (width - KEY_WIDTH) as i32 + 10,
                above as i32 + 30 + row as i32 * KEY_ROW,
            );
            if let Some(curve) = curve {
                draw_mark(&root, *curve, at)?;
            }
            draw_text(&root, text, (at.0 + 14, at.1), 13)?;
        }
        root.present()?;
        Ok(())
    }

    fn draw_plot(&mut self, root: &Area, plot: &Area) -> Result<(), Failed> {
        let [x, y] = self.scales.clone();
        let mut plane: Plane = ChartBuilder::on(plot)
            .margin(14)
            .x_label_area_size(46)
            .y_label_area_size(72)
            .build_cartesian_2d(x.clone(), y)?;
        plane
            .configure_mesh()
            .axis_style(INK)
            .bold_line_style(GRID)
            .label_style(("sans-serif", 13).into_font().color(&INK))
            .axis_desc_style(("sans-serif", 14).into_font().color(&INK))
            .x_desc(self.chart.x.title())
            .y_desc(self.chart.y.title())
            .draw()?;
        self.draw_front(&mut plane)?;
        for (c, curve) in self.chart.curves.iter().enumerate() {
            if curve.joined {
                // A point without a place breaks the line.
                for run in curve.points.split(|p| self.place(p).is_none()) {
                    let places: Vec<_> = run.iter().filter_map(|p| self.place(p)).collect();
                    plane.draw_series(LineSeries::new(places, colour(c).stroke_width(2)))?;
                }
            }
            for (p, point) in curve.points.iter().enumerate() {
                let Some(place) = self.place(point) else {
                    continue;
                };
                if let Some(ends) = point.x_quartiles {
                    let end = |end| self.scales[0].place(end).unwrap_or(place.0);
                    let ends = ends.map(|at| (end(at).clamp(x.low, x.high), place.1));
                    plane.draw_series([PathElement::new(ends, colour(c).stroke_width(1))])?;
                }
                let at = plane.backend_coord(&place);
                draw_mark(root, c, at)?;
                self.tips += &self.tip(&curve.name, point, at);
                if let Some(rank) = self.front.iter().position(|on| *on == (c, p)) {
                    let number = (rank + 1).to_string();
                    draw_text(root, &number, (at.0 + 7, at.1 - 9), 13)?;
                }
            }
        }
        Ok(())
    }

    /// Steps through the points of the front: below and left of them there is nothing.
    fn draw_front(&self, plane: &mut Plane) -> Result<(), Failed> {
        let points = self.front.iter().filter_map(|(c, p)| {
            let curve = self.chart.curves.get(*c)?;
            self.place(curve.points.get(*p)?)
        });
        let mut steps: Vec<(f64, f64)> = Vec::new();
        for (x, y) in points {
            if let Some((_, before)) = steps.last().copied() {
                steps.push((x, before));
            }
            steps.push((x, y));
        }
        if steps.len() > 1 {
            let style = INK.mix(0.45).stroke_width(1);
            plane.draw_series(DashedLineSeries::new(steps, 5, 4, style))?;
        }
        Ok(())
    }

    fn place(&self, point: &Point) -> Option<(f64, f64)> {
        let [x, y] = &self.scales;
        Some((x.place(point.x)?, y.place(point.y)?))
    }

    fn tip(&self, curve: &str, point: &Point, (x, y): (i32, i32)) -> String {
        let value = |axis: &Axis, value| format!("{} {}", number::text(value), axis.unit);
        let text = format!(
            "{curve}, {}: {}; {}",
            point.setting,
            value(&self.chart.x, point.x),
            value(&self.chart.y, point.y)
        );
        format!(
            "<circle cx=\"{x}\" cy=\"{y}\" r=\"9\" fill-opacity=\"0\"><title>{}</title></circle>\n",
            escaped(&text)
        )
    }

    /// Names of curves, and of the points on the front by their numbers.
    fn key(&self) -> Vec<(Option<usize>, String)> {
        let mut rows: Vec<(Option<usize>, String)> = Vec::new();
        for (c, curve) in self.chart.curves.iter().enumerate() {
            for (i, line) in wrapped(&curve.name).into_iter().enumerate() {
                rows.push(((i == 0).then_some(c), line));
            }
        }
        if !self.front.is_empty() {
            rows.push((None, String::new()));
            rows.push((None, "Nothing beats:".to_owned()));
        }
        for (rank, (c, p)) in self.front.iter().enumerate() {
            let curve = &self.chart.curves[*c];
            let setting = &curve.points[*p].setting;
            let text = if setting.is_empty() {
                curve.name.clone()
            } else if self.chart.curves.len() == 1 {
                setting.clone()
            } else {
                format!("{}, {setting}", curve.name)
            };
            for (i, line) in wrapped(&text).into_iter().enumerate() {
                let number = if i == 0 {
                    format!("{}  {line}", rank + 1)
                } else {
                    format!("    {line}")
                };
                rows.push((None, number));
            }
        }
        rows
    }
}

fn colour(curve: usize) -> RGBColor {
    COLOURS[curve % COLOURS.len()]
}

/// The mark of a curve's points, around a pixel.
fn draw_mark(area: &Area, curve: usize, (x, y): (i32, i32)) -> Result<(), Failed> {
    let style = colour(curve).filled();
    let corners: &[(i32, i32)] = match curve % COLOURS.len() {
        0 => {
            area.draw(&Circle::new((x, y), 5, style))?;
            return Ok(());
        }
        1 => &[(-5, -5), (5, -5), (5, 5), (-5, 5)],
        2 => &[(0, -6), (6, 5), (-6, 5)],
        3 => &[(0, -7), (7, 0), (0, 7), (-7, 0)],
        4 => &[(0, 6), (6, -5), (-6, -5)],
        5 => &[(-2, -6), (2, -6), (2, 6), (-2, 6)],
        6 => &[(-6, -2), (6, -2), (6, 2), (-6, 2)],
        _ => &[(-3, -5), (3, -5), (6, 0), (3, 5), (-3, 5), (-6, 0)],
    };
    let corners: Vec<_> = corners.iter().map(|(dx, dy)| (x + dx, y + dy)).collect();
    area.draw(&Polygon::new(corners, style))?;
    Ok(())
}

/// A line of text from a pixel to the right, at its middle height.
fn draw_text(area: &Area, text: &str, at: (i32, i32), size: u32) -> Result<(), Failed> {
    if text.is_empty() {
        return Ok(());
    }
    let style = ("sans-serif", size).into_font().color(&INK);
    let style = style.pos(Pos::new(HPos::Left, VPos::Center));
    area.draw_text(text, &style, at)?;
    Ok(())
}

/// A text in rows of the key.
fn wrapped(text: &str) -> Vec<String> {
    let mut rows = vec![String::new()];
    for word in text.split_whitespace() {
        let last = rows.len() - 1;
        let row = &mut rows[last];
        if !row.is_empty() && row.chars().count() + 1 + word.chars().count() > KEY_CHARACTERS {
            rows.push(word.to_owned());
        } else {
            if !row.is_empty() {
                row.push(' ');
            }
            row.push_str(word);
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Content, Curve, Figure};

    fn curve(name: &str, points: &[(f64, f64)]) -> Curve {
        Curve {
            name: name.to_owned(),
            points: (points.iter())
                .map(|(x, y)| Point::new(format!("{x} & {y}"), *x, *y))
                .collect(),
            joined: true,
        }
    }

    fn svg(curves: Vec<Curve>) -> String {
        let chart = Chart::trade("ns", "error", "m", curves);
        let figure = Figure::new("f", "A <title>", "", Content::Chart(chart.clone()));
        let machine = Machine::here(None);
        file(&figure, &chart, &machine).unwrap()
    }

    #[test]
    fn every_finite_point_can_be_pointed_at_and_the_front_is_numbered() {
        let svg = svg(vec![
            curve("a", &[(1.0, 1e-3), (10.0, 1e-6), (20.0, f64::INFINITY)]),
            curve("b", &[(2.0, 2e-3), (3.0, 0.0)]),
        ]);
        assert_eq!(svg.matches("<title>").count(), 4);
        assert!(svg.contains("1 &amp; 0.001: 1 ns; 0.001 m"), "{svg}");
        assert!(svg.contains("1  a, 1 &amp; 0.001") && svg.contains("2  b, 3 &amp; 0"));
        assert!(!svg.contains("b, 2 &amp; 0.002\n</text>"), "beaten");
        assert!(svg.contains("A &lt;title&gt;"));
    }

    #[test]
    fn a_chart_without_points_or_with_one_is_drawn() {
        assert!(svg(Vec::new()).contains("</svg>"));
        assert!(svg(vec![curve("a", &[(0.0, 0.0)])]).contains("</svg>"));
        assert!(svg(vec![curve("a", &[(f64::NAN, 0.0)])]).contains("</svg>"));
    }

    #[test]
    fn long_names_are_wrapped_and_not_lost() {
        let text =
            "a very long name of a method with many settings that nobody could read in a row";
        let rows = wrapped(text);
        assert!(rows.len() > 1 && rows.iter().all(|row| row.chars().count() <= KEY_CHARACTERS));
        assert_eq!(rows.join(" "), text);
    }
}
