//! How features look.

use crate::Value;

/// Straight sRGB red, green, blue, 0 to 1, and alpha.
pub type Colour = [f32; 4];

/// A length on the ground, or in samples of the level that is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Length {
    /// Metres on the ellipsoid.
    Metres(f64),
    /// Samples of the level: pixels on the screen, more or less. Counted along meridians, so that
    /// it is as wide in all directions on the ground.
    Pixels(f64),
}

impl Length {
    /// Longest, in metres or samples: a hundredth of the Earth's circumference is a wide stroke.
    pub const MAX: f64 = 400_000.0;

    /// In metres, where samples are `sample_m` apart; never negative, NaN counts as 0.
    pub fn metres(self, sample_m: f64) -> f64 {
        let v = match self {
            Self::Metres(v) => v,
            Self::Pixels(v) => v.min(1024.0) * sample_m,
        };
        if v > 0.0 { v.min(Self::MAX) } else { 0.0 }
    }
}

/// Shape of a point's symbol.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum SymbolShape {
    /// A disc.
    #[default]
    Circle,
    /// A square, sides along meridians and parallels.
    Square,
    /// A square on its corner.
    Diamond,
    /// A triangle, point to the north.
    Triangle,
    /// An upright cross.
    Cross,
    /// A star of five points.
    Star,
}

/// The symbol of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Symbol {
    /// Its shape.
    pub shape: SymbolShape,
    /// Its diameter.
    pub size: Length,
}

/// Lines over the inside of polygons.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hatch {
    /// Colour of the lines.
    pub colour: Colour,
    /// From line to line.
    pub spacing: Length,
    /// Width of the lines.
    pub width: Length,
    /// Direction of the lines, clockwise from north, at the middle latitude of the features.
    pub angle_deg: f64,
    /// Whether a second set of lines crosses the first.
    pub crossed: bool,
}

/// What a class of features has instead of the style's own; `None` leaves that as it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Class {
    /// Which features.
    pub of: ClassOf,
    /// Colour of the inside and of symbols.
    pub fill: Option<Colour>,
    /// Colour of the line.
    pub stroke: Option<Colour>,
}

/// Which values of the property make a class.
#[derive(Clone, Debug, PartialEq)]
pub enum ClassOf {
    /// This value ([`Value::means`]).
    Equals(Value),
    /// Numbers from `min` up to, without, `max`.
    Range {
        /// Least; `None`: any.
        min: Option<f64>,
        /// First beyond; `None`: any.
        max: Option<f64>,
    },
}

impl ClassOf {
    /// Whether a value belongs to it.
    pub fn contains(&self, value: &Value) -> bool {
        match self {
            Self::Equals(v) => v.means(value),
            Self::Range { min, max } => value
                .as_number()
                .is_some_and(|v| min.is_none_or(|min| v >= min) && max.is_none_or(|max| v < max)),
        }
    }
}

/// Looks by a property's value: the first class that fits is taken, else the style as it is.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct By {
    /// Name of the property.
    pub property: String,
    /// The classes.
    pub classes: Vec<Class>,
}

/// How features look. Drawn below each other in this order, for all features: fills, hatches,
/// casings, strokes, symbols; among each, later classes lie above. Within a class overlapping
/// features are one shape: a half-transparent fill is not darker where two overlap.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Style {
    /// Inside of polygons and symbols.
    pub fill: Option<Colour>,
    /// Lines, outlines of polygons and symbols.
    pub stroke: Option<Colour>,
    /// Width of the stroke. Narrower than a sample it fades instead of vanishing.
    pub stroke_width: Option<Length>,
    /// A wider line below the stroke: its colour and how far it stands out on each side.
    pub casing: Option<(Colour, Length)>,
    /// Lengths of dashes and gaps, in units of the stroke width's kind; empty: none.
    pub dash: Vec<f64>,
    /// Hatch of polygons.
    pub hatch: Option<Hatch>,
    /// Symbol of points.
    pub symbol: Option<Symbol>,
    /// Looks by a property.
    pub by: Option<By>,
    /// Drawn where samples are at least so many metres apart.
    pub min_sample_m: Option<f64>,
    /// Drawn where samples are at most so many metres apart.
    pub max_sample_m: Option<f64>,
}

impl Style {
    /// Whether it is drawn where samples are `sample_m` metres apart.
    pub fn is_drawn_at(&self, sample_m: f64) -> bool {
        self.min_sample_m.is_none_or(|min| sample_m >= min)
            && self.max_sample_m.is_none_or(|max| sample_m <= max)
    }

    /// How far from a feature it reaches, in metres.
    pub(crate) fn reach_m(&self, sample_m: f64) -> f64 {
        let sample = sample_m * 1.5;
        let mut half = 0.0_f64;
        if self.stroke.is_some() || self.casing.is_some() {
            let stroke = self.stroke_width.map_or(0.0, |w| w.metres(sample_m));
            half = 0.5 * stroke.max(sample_m);
        }
        if let Some((_, width)) = self.casing {
            half += width.metres(sample_m);
        }
        if let Some(symbol) = self.symbol {
            half += 0.5 * symbol.size.metres(sample_m).max(sample_m) * 1.5;
        }
        half + sample
    }
}
