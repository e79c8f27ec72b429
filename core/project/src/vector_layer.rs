//! Vector layers: features from a file, drawn over the colours or standing on the ground.

use serde_json::Value;

use crate::Extra;

/// Features from a vector file.
#[derive(Clone, Debug, PartialEq)]
pub struct VectorLayer {
    /// The file: relative to the project's folder with forward slashes, or absolute. See
    /// [`resolve_path`](crate::resolve_path).
    pub path: String,
    /// Which layer of a file that holds several (GeoPackage). `None`: the first.
    pub source_layer: Option<String>,
    /// The coordinate system (`EPSG:n`, `ESRI:n` or a proj string), instead of the file's own.
    pub crs: Option<String>,
    /// How features are drawn.
    pub style: VectorStyle,
}

impl VectorLayer {
    /// The file, drawn in the default style.
    pub fn new(path: impl Into<String>) -> Self {
        Self {
            path: path.into(),
            source_layer: None,
            crs: None,
            style: VectorStyle::default(),
        }
    }
}

/// How features are drawn. Colours are sRGB red, green, blue.
#[derive(Clone, Debug, PartialEq)]
pub struct VectorStyle {
    /// Inside areas. `None`: not filled.
    pub fill: Option<[u8; 3]>,
    /// How much the fill covers, 0 to 1. Default 1.
    pub fill_opacity: f64,
    /// Along lines and boundaries. `None`: not stroked.
    pub stroke: Option<[u8; 3]>,
    /// Width of the stroke. Default 1 px.
    pub stroke_width: Width,
    /// A wider line below the stroke. `None`: none.
    pub casing: Option<Casing>,
    /// Lengths of strokes and gaps in turn, in the unit of the stroke's width, 0 to 10⁶ each, at
    /// most 32. Empty (the default): solid.
    pub dash: Vec<f64>,
    /// Lines across areas. `None`: none.
    pub hatch: Option<Hatch>,
    /// Symbols at points. `None`: none.
    pub point: Option<PointSymbol>,
    /// Texts at features. `None`: none.
    pub label: Option<Label>,
    /// Colours by a property. `None`: all features alike.
    pub by: Option<ClassedBy>,
    /// Drawn only where the map's scale is 1 : n with n at least this (at 96 dots per inch), 0 to 10¹².
    pub min_scale: Option<f64>,
    /// Drawn only where the map's scale is 1 : n with n at most this (at 96 dots per inch), 0 to 10¹².
    pub max_scale: Option<f64>,
    /// Areas stand as masses of this height. `None`: flat.
    pub extrude: Option<Extrude>,
    /// Unknown fields of the file.
    pub extra: Extra,
}

impl Default for VectorStyle {
    fn default() -> Self {
        Self {
            fill: None,
            fill_opacity: 1.0,
            stroke: None,
            stroke_width: Width::px(1.0),
            casing: None,
            dash: Vec::new(),
            hatch: None,
            point: None,
            label: None,
            by: None,
            min_scale: None,
            max_scale: None,
            extrude: None,
            extra: Extra::new(),
        }
    }
}

impl VectorStyle {
    /// What a new layer has: thin orange lines, areas lightly filled, discs at points, so that all
    /// of it shows over imagery.
    pub fn visible() -> Self {
        Self {
            fill: Some([0xff, 0x8c, 0x1a]),
            fill_opacity: 0.3,
            stroke: Some([0xe6, 0x5c, 0x00]),
            stroke_width: Width::px(1.5),
            point: Some(PointSymbol::default()),
            ..Self::default()
        }
    }
}

/// A width on the ground or on the screen.
#[derive(Clone, Debug, PartialEq)]
pub struct Width {
    /// In `unit`, 0 to 10⁶.
    pub value: f64,
    /// Metres or pixels.
    pub unit: WidthUnit,
    /// Unknown fields of the file.
    pub extra: Extra,
}

impl Width {
    /// Pixels on the screen.
    pub fn px(value: f64) -> Self {
        Self {
            value,
            unit: WidthUnit::Pixels,
            extra: Extra::new(),
        }
    }

    /// Metres on the ground.
    pub fn m(value: f64) -> Self {
        Self {
            value,
            unit: WidthUnit::Metres,
            extra: Extra::new(),
        }
    }
}

/// What a width is measured in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum WidthUnit {
    /// Metres on the ground.
    Metres,
    /// Pixels on the screen.
    Pixels,
}

/// A wider line below a stroke.
#[derive(Clone, Debug, PartialEq)]
pub struct Casing {
    /// Its colour.
    pub colour: [u8; 3],
    /// How far it stands out on each side of the stroke.
    pub width: Width,
    /// Unknown fields of the file.
    pub extra: Extra,
}

/// Parallel lines across areas.
#[derive(Clone, Debug, PartialEq)]
pub struct Hatch {
    /// Distance between lines.
    pub spacing: Width,
    /// Direction of the lines in degrees clockwise from north, −360 to 360. Default 45.
    pub angle_deg: f64,
    /// Their colour. `None`: the stroke's.
    pub colour: Option<[u8; 3]>,
    /// Their width. Default 1 px.
    pub width: Width,
    /// Whether a second set crosses the first at a right angle. Default false.
    pub cross: bool,
    /// Unknown fields of the file.
    pub extra: Extra,
}

/// A symbol at a point.
#[derive(Clone, Debug, PartialEq)]
pub struct PointSymbol {
    /// Its shape. Default circle.
    pub symbol: Symbol,
    /// Its diameter. Default 6 px.
    pub size: Width,
    /// Unknown fields of the file.
    pub extra: Extra,
}

impl Default for PointSymbol {
    fn default() -> Self {
        Self {
            symbol: Symbol::Circle,
            size: Width::px(6.0),
            extra: Extra::new(),
        }
    }
}

/// The shape of a point symbol.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Symbol {
    /// A disc.
    #[default]
    Circle,
    /// A square on its side.
    Square,
    /// A square on its corner.
    Diamond,
    /// A triangle, pointing up.
    Triangle,
    /// An upright cross.
    Cross,
    /// A star of five points.
    Star,
}

/// Texts at features.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// The property that holds the text, 1 to 1000 bytes.
    pub property: String,
    /// Height of the letters in pixels, 4 to 200. Default 12.
    pub size_px: f64,
    /// Colour of the letters. Default black.
    pub colour: [u8; 3],
    /// Colour around the letters. `None`: none.
    pub halo: Option<[u8; 3]>,
    /// Unknown fields of the file.
    pub extra: Extra,
}

/// Colours by a property of the features. The first class that fits counts; features that fit none
/// have the style's own colours.
#[derive(Clone, Debug, PartialEq)]
pub struct ClassedBy {
    /// The property, 1 to 1000 bytes.
    pub property: String,
    /// The classes, at most 10 000.
    pub classes: Vec<StyleClass>,
    /// Unknown fields of the file.
    pub extra: Extra,
}

/// Features of a property's value or range, and their colours.
#[derive(Clone, Debug, PartialEq)]
pub struct StyleClass {
    /// Which.
    pub matches: ClassMatch,
    /// Inside areas. `None`: the style's.
    pub fill: Option<[u8; 3]>,
    /// Along lines and boundaries. `None`: the style's.
    pub stroke: Option<[u8; 3]>,
    /// Unknown fields of the file.
    pub extra: Extra,
}

/// Which values of a property belong to a class.
#[derive(Clone, Debug, PartialEq)]
pub enum ClassMatch {
    /// This value: a text, a number, true or false.
    Value(Value),
    /// Numbers from `min` (included) to `max` (excluded); without a limit where `None`. At least one
    /// is given.
    Range {
        /// Lowest number inside.
        min: Option<f64>,
        /// Lowest number above.
        max: Option<f64>,
    },
}

/// How high areas stand as masses.
#[derive(Clone, Debug, PartialEq)]
pub enum Extrude {
    /// All alike: metres above the ground, 0 to 10⁵.
    HeightM(f64),
    /// By a property that holds metres.
    Property(String),
}
