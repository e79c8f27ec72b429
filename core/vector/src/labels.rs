//! Where texts of features go.

use glam::DVec2;

use crate::features::{Features, Outline, Shape};

/// The text of a feature and its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// Which feature.
    pub feature: u32,
    /// The text, as it is shown: one line of at most [`LONGEST`] characters.
    pub text: String,
    /// Longitude and latitude in radians.
    pub lonlat_rad: DVec2,
    /// Larger is more important: people where the feature says how many live there, else the size
    /// of its box in square radians, below 1.
    pub weight: f64,
}

/// Characters of a label at most.
pub const LONGEST: usize = 80;

/// Properties that say how many people live at a place, the first that a file has.
const PEOPLE: [&str; 4] = ["pop_max", "population", "pop", "POP_MAX"];

/// Latitudes at which the widest inside of a polygon is looked for.
const LOOKS: u32 = 7;

/// Labels of all features that have a text in a property, the most important first; among equals
/// the file's order.
pub fn labels(features: &Features, property: &str) -> Vec<Label> {
    let people = PEOPLE
        .iter()
        .find_map(|name| features.columns().iter().position(|c| **c == **name));
    let column = features.columns().iter().position(|c| **c == *property);
    let Some(column) = column else {
        return Vec::new();
    };
    let mut labels: Vec<Label> = (0..features.len())
        .filter_map(|feature| {
            let text: String = features.value(feature, column).to_string();
            let text: String = text
                .trim()
                .chars()
                .map(|c| if c.is_control() { ' ' } else { c })
                .take(LONGEST)
                .collect();
            if text.is_empty() {
                return None;
            }
            let lonlat_rad = anchor(features, feature)?;
            let size = features.bounds_of(feature)?.size();
            let people = people.and_then(|c| features.value(feature, c).as_number());
            let weight = match people {
                Some(people) if people >= 1.0 => people,
                _ => (size.x * size.y + 1e-6 * (size.x + size.y)).min(0.999),
            };
            Some(Label {
                feature: feature as u32,
                text,
                lonlat_rad,
                weight,
            })
        })
        .collect();
    labels.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    labels
}

/// The place of a feature's text: the middle of the widest inside of its largest polygon, the middle
/// of its longest line, or its first point.
fn anchor(features: &Features, feature: usize) -> Option<DVec2> {
    let extent = |o: &Outline| {
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for v in o.lonlat_rad {
            (low, high) = (low.min(*v), high.max(*v));
        }
        high - low
    };
    let rank = |o: &Outline| {
        let size = extent(o);
        match o.shape {
            Shape::Outer => Some((2, size.x * size.y)),
            Shape::Line => Some((1, size.x + size.y)),
            Shape::Points => Some((0, 0.0)),
            Shape::Hole => None,
        }
    };
    let mut best: Option<((u8, f64), usize)> = None;
    for (i, outline) in features.outlines(feature).enumerate() {
        if let Some(rank) = rank(&outline)
            && best.is_none_or(|(b, _)| rank > b)
        {
            best = Some((rank, i));
        }
    }
    let (_, i) = best?;
    let mut outlines = features.outlines(feature).skip(i);
    let outline = outlines.next()?;
    match outline.shape {
        Shape::Points => outline.lonlat_rad.first().copied(),
        Shape::Line => Some(middle(outline.lonlat_rad)),
        Shape::Outer | Shape::Hole => {
            let holes: Vec<Outline> = outlines.take_while(|o| o.shape == Shape::Hole).collect();
            Some(widest(&outline, &holes))
        }
    }
}

/// The place half-way along a line, by length in the map.
fn middle(line: &[DVec2]) -> DVec2 {
    let length: f64 = line.windows(2).map(|e| e[0].distance(e[1])).sum();
    let mut left = 0.5 * length;
    for edge in line.windows(2) {
        let here = edge[0].distance(edge[1]);
        if here >= left && here > 0.0 {
            return edge[0] + (edge[1] - edge[0]) * (left / here);
        }
        left -= here;
    }
    line[0]
}

/// The middle of the widest inside of a polygon along some circles of latitude.
fn widest(outer: &Outline, holes: &[Outline]) -> DVec2 {
    let latitudes = outer.lonlat_rad.iter().map(|v| v.y);
    let (low, high) = latitudes.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), y| {
        (l.min(y), h.max(y))
    });
    let mut best = (0.0, outer.lonlat_rad[0]);
    for look in 1..=LOOKS {
        let y = low + (high - low) * f64::from(look) / f64::from(LOOKS + 1);
        let mut crossings: Vec<f64> = Vec::new();
        for ring in core::iter::once(outer).chain(holes) {
            for edge in ring.lonlat_rad.windows(2) {
                let (a, b) = (edge[0], edge[1]);
                if (a.y <= y) != (b.y <= y) {
                    crossings.push(a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y));
                }
            }
        }
        crossings.sort_by(f64::total_cmp);
        // The middle latitudes win where all are about as wide.
        let favour = 1.0 - 0.02 * (f64::from(look) - 0.5 * f64::from(LOOKS + 1)).abs();
        for pair in crossings.chunks_exact(2) {
            let width = (pair[1] - pair[0]) * favour;
            if width > best.0 {
                best = (width, DVec2::new(0.5 * (pair[0] + pair[1]), y));
            }
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Builder, Value};

    fn named(b: &mut Builder, name: &str) {
        b.property("name", Value::from(name)).unwrap();
        b.feature().unwrap();
    }

    #[test]
    fn a_text_lies_inside_its_polygon_and_not_in_a_hole() {
        let mut b = Builder::degrees();
        // A U: the middle of its box is outside.
        b.ring(
            [
                [0.0, 0.0],
                [3.0, 0.0],
                [3.0, 4.0],
                [2.0, 4.0],
                [2.0, 1.0],
                [1.0, 1.0],
                [1.0, 4.0],
                [0.0, 4.0],
            ],
            false,
        )
        .unwrap();
        b.ring([[0.2, 0.2], [0.2, 0.8], [1.4, 0.8], [1.4, 0.2]], true)
            .unwrap();
        named(&mut b, "U");
        let features = b.finish().unwrap();
        let at = labels(&features, "name")[0].lonlat_rad.map(f64::to_degrees);
        let inside = (0.0..3.0).contains(&at.x) && (0.0..4.0).contains(&at.y);
        let in_gap = (1.0..2.0).contains(&at.x) && at.y > 1.0;
        let in_hole = (0.2..1.4).contains(&at.x) && (0.2..0.8).contains(&at.y);
        assert!(inside && !in_gap && !in_hole, "{at}");
    }

    #[test]
    fn the_important_come_first_and_what_has_no_text_has_no_label() {
        let mut b = Builder::degrees();
        for (name, people) in [
            ("village", 100),
            ("city", 1_000_000),
            ("", 5),
            ("town", 20_000),
        ] {
            b.points([[8.0, 47.0]]).unwrap();
            b.property("pop_max", Value::Int(people)).unwrap();
            named(&mut b, name);
        }
        let features = b.finish().unwrap();
        let found: Vec<String> = labels(&features, "name")
            .into_iter()
            .map(|l| l.text)
            .collect();
        assert_eq!(found, ["city", "town", "village"]);
        assert_eq!(labels(&features, "nombre"), []);
    }

    #[test]
    fn a_text_on_a_line_lies_half_way() {
        let mut b = Builder::degrees();
        b.line([[0.0, 0.0], [1.0, 0.0], [10.0, 0.0]]).unwrap();
        named(&mut b, "line");
        let at = labels(&b.finish().unwrap(), "name")[0].lonlat_rad;
        assert!((at.x.to_degrees() - 5.0).abs() < 1e-9);
    }
}
