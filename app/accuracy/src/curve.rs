//! Curves of settings: one point for each, and which of them nothing beats.

/// What an axis shows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Axis {
    /// What it is: `run time`, `error on the ground`.
    pub quantity: String,
    /// Its unit, empty for plain numbers: `ns per vertex`, `m`.
    pub unit: String,
    /// Whether it is divided into powers of ten.
    pub log: bool,
}

impl Axis {
    /// A logarithmic axis.
    pub fn log(quantity: impl Into<String>, unit: impl Into<String>) -> Self {
        Self {
            quantity: quantity.into(),
            unit: unit.into(),
            log: true,
        }
    }

    /// An axis of equal steps.
    pub fn linear(quantity: impl Into<String>, unit: impl Into<String>) -> Self {
        Self {
            log: false,
            ..Self::log(quantity, unit)
        }
    }

    /// Quantity and unit: `run time, ns per vertex`.
    pub fn title(&self) -> String {
        if self.unit.is_empty() {
            self.quantity.clone()
        } else {
            format!("{}, {}", self.quantity, self.unit)
        }
    }
}

/// One setting of what was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// What was set: `kernel cubic`, `level 12`.
    pub setting: String,
    /// Along the first axis, usually a time.
    pub x: f64,
    /// Along the second, usually an error. What is not finite is in the table but not in the picture.
    pub y: f64,
    /// The quartiles of `x` where it was measured repeatedly.
    pub x_quartiles: Option<[f64; 2]>,
}

impl Point {
    /// A point without a spread.
    pub fn new(setting: impl Into<String>, x: f64, y: f64) -> Self {
        Self {
            setting: setting.into(),
            x,
            y,
            x_quartiles: None,
        }
    }

    /// An error against the time that it takes.
    pub fn timed(setting: impl Into<String>, time: crate::Spread, error: f64) -> Self {
        Self {
            x_quartiles: Some([time.low, time.high]),
            ..Self::new(setting, time.median, error)
        }
    }

    /// Whether this is no worse along both axes, where less is better, and better along one.
    fn beats(&self, other: &Self) -> bool {
        self.x <= other.x && self.y <= other.y && (self.x < other.x || self.y < other.y)
    }
}

/// Points of one method.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Its method.
    pub name: String,
    /// Its settings, in the order in which they are joined.
    pub points: Vec<Point>,
    /// Whether a line joins them: settings that follow each other.
    pub joined: bool,
}

impl Curve {
    /// Joined curves of points, each with its curve's name: in the order in which names first come.
    pub fn grouped(points: impl IntoIterator<Item = (String, Point)>) -> Vec<Self> {
        let mut curves: Vec<Self> = Vec::new();
        for (name, point) in points {
            match curves.iter_mut().find(|curve| curve.name == name) {
                Some(curve) => curve.points.push(point),
                None => curves.push(Self {
                    name,
                    points: vec![point],
                    joined: true,
                }),
            }
        }
        curves
    }
}

/// Curves on two axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// The axis of [`Point::x`].
    pub x: Axis,
    /// The axis of [`Point::y`].
    pub y: Axis,
    /// The curves.
    pub curves: Vec<Curve>,
    /// Whether less is better along both axes, so that the front is marked.
    pub marks_front: bool,
}

impl Chart {
    /// Error against time: logarithmic axes, the front marked.
    pub fn trade(time_unit: &str, error: &str, error_unit: &str, curves: Vec<Curve>) -> Self {
        Self {
            x: Axis::log("run time", time_unit),
            y: Axis::log(error, error_unit),
            curves,
            marks_front: true,
        }
    }

    /// What is marked: the front, or nothing.
    pub(crate) fn marked(&self) -> Vec<(usize, usize)> {
        if self.marks_front {
            self.front()
        } else {
            Vec::new()
        }
    }

    /// The pareto front: indices of curve and point of all that no other point beats, by x. Points
    /// that are not finite are never on it; of equal points all are.
    pub fn front(&self) -> Vec<(usize, usize)> {
        let all = || {
            let points = self.curves.iter().enumerate().flat_map(|(c, curve)| {
                let indexed = curve.points.iter().enumerate();
                indexed.map(move |(p, point)| ((c, p), point))
            });
            points.filter(|(_, point)| point.x.is_finite() && point.y.is_finite())
        };
        let mut front: Vec<_> = all()
            .filter(|(_, point)| !all().any(|(_, other)| other.beats(point)))
            .collect();
        front.sort_by(|(_, a), (_, b)| a.x.total_cmp(&b.x).then(b.y.total_cmp(&a.y)));
        front.into_iter().map(|(index, _)| index).collect()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn chart(points: &[(f64, f64)]) -> Chart {
        let points = points.iter().map(|(x, y)| Point::new("", *x, *y));
        let curve = Curve {
            name: String::new(),
            points: points.collect(),
            joined: false,
        };
        Chart::trade("ns", "error", "m", vec![curve])
    }

    #[test]
    fn what_is_slower_and_no_better_is_not_on_the_front() {
        let chart = chart(&[(3.0, 1.0), (1.0, 9.0), (2.0, 9.0), (4.0, 2.0), (5.0, 0.5)]);
        assert_eq!(chart.front(), [(0, 1), (0, 0), (0, 4)]);
    }

    #[test]
    fn equal_points_share_the_front_and_broken_ones_never_reach_it() {
        let chart = chart(&[
            (1.0, 1.0),
            (1.0, 1.0),
            (f64::NAN, 0.0),
            (0.5, f64::INFINITY),
        ]);
        assert_eq!(chart.front(), [(0, 0), (0, 1)]);
    }

    proptest! {
        #[test]
        fn whatever_is_off_the_front_is_beaten_by_something_on_it(
            points in prop::collection::vec((0..20_u8, 0..20_u8), 0..40),
        ) {
            let points: Vec<_> = points.into_iter().map(|(x, y)| (f64::from(x), f64::from(y))).collect();
            let chart = chart(&points);
            let front = chart.front();
            prop_assert_eq!(front.is_empty(), points.is_empty());
            let all = &chart.curves.first().unwrap().points;
            for (p, point) in all.iter().enumerate() {
                let beaten = front.iter().any(|(_, on)| all[*on].beats(point));
                prop_assert_eq!(beaten, !front.contains(&(0, p)));
            }
            // Along the front error falls as time grows.
            for pair in front.windows(2) {
                prop_assert!(all[pair[0].1].x <= all[pair[1].1].x && all[pair[0].1].y >= all[pair[1].1].y);
            }
        }
    }
}
