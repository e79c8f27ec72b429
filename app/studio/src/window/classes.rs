//! Classes of features by a property: each value for itself, or ranges of numbers, with colours that tell
//! them apart.

use std::collections::HashMap;

use relievo_engine::project::{ClassMatch, ClassedBy, Extra, StyleClass};
use relievo_engine::vector::{Features, Value};
use serde_json::json;

/// Most classes of single values: the most frequent ones; more cannot be told apart anyway.
const MOST_VALUES: usize = 60;

/// Turns of hue from one class to the next: the golden ratio, so that neighbours differ.
const HUE_STEP: f64 = 0.618_033_988_75;

/// Colours of ranges from the lowest to the highest: viridis, by Nathaniel Smith and Stéfan van der Walt
/// (public domain).
const RAMP: [[u8; 3]; 5] = [
    [68, 1, 84],
    [59, 82, 139],
    [33, 145, 140],
    [94, 201, 98],
    [253, 231, 37],
];

/// How classes are made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) enum Method {
    /// One for each value.
    #[default]
    Unique,
    /// Ranges that are equally wide.
    EqualIntervals,
    /// Ranges that hold equally many features.
    Quantiles,
}

impl Method {
    /// All of them with their names.
    pub(crate) const ALL: [(Self, &'static str); 3] = [
        (Self::Unique, "Each value"),
        (Self::EqualIntervals, "Equal intervals"),
        (Self::Quantiles, "Equal counts"),
    ];
}

/// What is asked for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Recipe {
    pub(crate) property: String,
    pub(crate) method: Method,
    /// Number of ranges, at least 1.
    pub(crate) count: usize,
    /// Whether insides are coloured; otherwise lines are.
    pub(crate) fills: bool,
}

/// Makes the classes of a file's features.
///
/// # Errors
/// One line where the property gives none.
pub(crate) fn make(features: &Features, recipe: &Recipe) -> Result<ClassedBy, String> {
    let column = features
        .columns()
        .iter()
        .position(|c| **c == *recipe.property);
    let column = column.ok_or_else(|| {
        format!(
            "expected a property of the file, found {:?}",
            recipe.property
        )
    })?;
    let values = (0..features.len()).map(|feature| features.value(feature, column));
    let matches = match recipe.method {
        Method::Unique => unique(values),
        Method::EqualIntervals | Method::Quantiles => {
            let mut numbers: Vec<f64> = values.filter_map(Value::as_number).collect();
            numbers.sort_by(f64::total_cmp);
            ranges(&edges(&numbers, recipe))
        }
    };
    if matches.is_empty() {
        let expected = if recipe.method == Method::Unique {
            "values"
        } else {
            "numbers"
        };
        return Err(format!(
            "expected {expected} in the property {:?}, found none",
            recipe.property
        ));
    }
    let count = matches.len();
    let class = |(at, matches): (usize, ClassMatch)| {
        let colour = if recipe.method == Method::Unique {
            hue(at)
        } else {
            ramp(at as f64 / (count - 1).max(1) as f64)
        };
        StyleClass {
            matches,
            fill: recipe.fills.then_some(colour),
            stroke: (!recipe.fills).then_some(colour),
            extra: Extra::new(),
        }
    };
    Ok(ClassedBy {
        property: recipe.property.clone(),
        classes: matches.into_iter().enumerate().map(class).collect(),
        extra: Extra::new(),
    })
}

/// The most frequent values in their own order: numbers, then texts.
fn unique<'a>(values: impl Iterator<Item = &'a Value>) -> Vec<ClassMatch> {
    let mut counts: HashMap<String, (usize, &Value)> = HashMap::new();
    for value in values.filter(|value| **value != Value::Null) {
        counts.entry(value.to_string()).or_insert((0, value)).0 += 1;
    }
    let mut all: Vec<(String, usize, &Value)> = counts
        .into_iter()
        .map(|(text, (count, value))| (text, count, value))
        .collect();
    all.sort_by(|a, b| b.1.cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
    all.truncate(MOST_VALUES);
    let number = |value: &Value| value.as_number().unwrap_or(f64::INFINITY);
    all.sort_by(|a, b| {
        let by_number = number(a.2).total_cmp(&number(b.2));
        by_number.then_with(|| a.0.cmp(&b.0))
    });
    all.into_iter()
        .map(|(text, _, value)| {
            ClassMatch::Value(match value {
                Value::Bool(v) => json!(v),
                Value::Int(v) => json!(v),
                Value::Float(v) => json!(v),
                Value::Text(_) | Value::Null => json!(text),
            })
        })
        .collect()
}

/// The numbers that part the ranges, rising; `numbers` are sorted.
fn edges(numbers: &[f64], recipe: &Recipe) -> Vec<f64> {
    let (Some(low), Some(high)) = (numbers.first(), numbers.last()) else {
        return Vec::new();
    };
    let count = recipe.count.clamp(1, numbers.len().max(1));
    let edge = |k: usize| {
        if recipe.method == Method::Quantiles {
            numbers[k * numbers.len() / count]
        } else {
            low + (high - low) * k as f64 / count as f64
        }
    };
    let mut edges: Vec<f64> = (1..count).map(edge).filter(|edge| edge > low).collect();
    edges.dedup();
    if edges.is_empty() {
        // One value, or one range: below and from it on.
        edges.push(*low);
    }
    edges
}

/// The ranges between edges, open at both ends.
fn ranges(edges: &[f64]) -> Vec<ClassMatch> {
    let (Some(first), Some(last)) = (edges.first(), edges.last()) else {
        return Vec::new();
    };
    let range = |min, max| ClassMatch::Range { min, max };
    let inner = edges.windows(2).map(|e| range(Some(e[0]), Some(e[1])));
    core::iter::once(range(None, Some(*first)))
        .chain(inner)
        .chain([range(Some(*last), None)])
        .collect()
}

/// What people call a class.
pub(crate) fn title(matches: &ClassMatch) -> String {
    match matches {
        ClassMatch::Value(serde_json::Value::String(text)) => text.clone(),
        ClassMatch::Value(value) => value.to_string(),
        ClassMatch::Range { min, max } => match (min, max) {
            (Some(min), Some(max)) => format!("{} to {}", short(*min), short(*max)),
            (Some(min), None) => format!("from {}", short(*min)),
            (None, Some(max)) => format!("below {}", short(*max)),
            (None, None) => "any number".to_owned(),
        },
    }
}

/// A number with at most four digits behind the point.
fn short(value: f64) -> String {
    let text = format!("{value:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn hue(at: usize) -> [u8; 3] {
    let turn = (0.58 + HUE_STEP * at as f64).fract() as f32;
    // Every second round is darker.
    let value = if at.is_multiple_of(2) { 0.85 } else { 0.68 };
    let [r, g, b] = eframe::egui::ecolor::Hsva::new(turn, 0.55, value, 1.0).to_srgb();
    [r, g, b]
}

fn ramp(share: f64) -> [u8; 3] {
    let at = share.clamp(0.0, 1.0) * (RAMP.len() - 1) as f64;
    let first = (at as usize).min(RAMP.len() - 2);
    let part = at - first as f64;
    core::array::from_fn(|c| {
        let (a, b) = (f64::from(RAMP[first][c]), f64::from(RAMP[first + 1][c]));
        (a + (b - a) * part).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use relievo_engine::vector::Builder;

    use super::*;

    fn features(values: &[Value]) -> Features {
        let mut builder = Builder::degrees();
        for value in values {
            builder.points([[0.0, 0.0]]).unwrap();
            builder.property("p", value.clone()).unwrap();
            builder.feature().unwrap();
        }
        builder.finish().unwrap()
    }

    fn titles(values: &[Value], method: Method, count: usize) -> Vec<String> {
        let recipe = Recipe {
            property: "p".to_owned(),
            method,
            count,
            fills: true,
        };
        let made = make(&features(values), &recipe).unwrap();
        made.classes.iter().map(|c| title(&c.matches)).collect()
    }

    #[test]
    fn each_value_is_a_class_numbers_before_texts_and_nothing_for_nothing() {
        let values = [
            Value::from("b"),
            Value::Int(10),
            Value::Int(9),
            Value::from("a"),
            Value::Int(9),
            Value::Null,
        ];
        assert_eq!(titles(&values, Method::Unique, 5), ["9", "10", "a", "b"]);
    }

    #[test]
    fn ranges_are_equally_wide_or_hold_equally_many_and_leave_nothing_out() {
        let values: Vec<Value> = [0.0, 1.0, 2.0, 3.0, 100.0, 200.0].map(Value::from).to_vec();
        assert_eq!(
            titles(&values, Method::EqualIntervals, 2),
            ["below 100", "from 100"]
        );
        assert_eq!(
            titles(&values, Method::Quantiles, 3),
            ["below 2", "2 to 100", "from 100"]
        );
        // Values that do not differ make no ranges of nothing.
        let alike = vec![Value::from(7.0); 9];
        assert_eq!(titles(&alike, Method::Quantiles, 4), ["below 7", "from 7"]);
    }

    #[test]
    fn a_property_without_numbers_makes_no_ranges() {
        let recipe = Recipe {
            property: "p".to_owned(),
            method: Method::Quantiles,
            count: 3,
            fills: true,
        };
        let error = make(&features(&[Value::from("x")]), &recipe).unwrap_err();
        assert_eq!(error, "expected numbers in the property \"p\", found none");
        let missing = Recipe {
            property: "q".to_owned(),
            ..recipe
        };
        assert!(make(&features(&[Value::from("x")]), &missing).is_err());
    }
}
