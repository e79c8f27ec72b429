//! Layers of the runtime document.

use crate::{
    Adjust, ColourDetail, ContoursLayer, Dated, DetailLayer, Extra, LayerId, Mask, SlopeLayer,
    TintLayer, VectorLayer,
};

/// One layer of the stack.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Stable id, unique in the project.
    pub id: LayerId,
    /// What people call it; up to 1000 bytes.
    pub name: String,
    /// Whether it takes part. Default true.
    pub visible: bool,
    /// How much of it covers what lies below, 0 to 1; heights are mixed in the same way. Default 1.
    pub opacity: f64,
    /// Whether edits in the window are refused. Default false.
    pub locked: bool,
    /// Where it shows; of layers with colours only. Default everywhere.
    pub mask: Option<Mask>,
    /// Its place in a series of pictures of one ground at different times. Default none.
    pub dated: Option<Dated>,
    /// What it is.
    pub kind: LayerKind,
    /// Unknown fields of the file; for [`LayerKind::Unknown`] all of the layer's own fields.
    pub extra: Extra,
}

impl Layer {
    /// A visible, opaque, unlocked layer.
    pub fn new(id: LayerId, name: impl Into<String>, kind: LayerKind) -> Self {
        Self {
            id,
            name: name.into(),
            visible: true,
            opacity: 1.0,
            locked: false,
            mask: None,
            dated: None,
            kind,
            extra: Extra::new(),
        }
    }

    /// The raster file behind the layer, where there is one.
    pub fn source(&self) -> Option<&Source> {
        match &self.kind {
            LayerKind::Imagery(imagery) => Some(&imagery.source),
            LayerKind::Height(height) => Some(&height.source),
            LayerKind::Noise(_)
            | LayerKind::Detail(_)
            | LayerKind::Tint(_)
            | LayerKind::Slope(_)
            | LayerKind::Contours(_)
            | LayerKind::Vector(_)
            | LayerKind::Unknown { .. } => None,
        }
    }

    /// The path of the file behind the layer as it is stored, raster or vector, where there is one.
    pub fn path(&self) -> Option<&str> {
        match &self.kind {
            LayerKind::Vector(vector) => Some(&vector.path),
            LayerKind::Imagery(_)
            | LayerKind::Height(_)
            | LayerKind::Noise(_)
            | LayerKind::Detail(_)
            | LayerKind::Tint(_)
            | LayerKind::Slope(_)
            | LayerKind::Contours(_)
            | LayerKind::Unknown { .. } => self.source().map(|source| source.path.as_str()),
        }
    }
}

/// What a layer is.
#[derive(Clone, Debug, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "a project has dozens of layers, most of them imagery"
)]
pub enum LayerKind {
    /// Colours from a raster file.
    Imagery(ImageryLayer),
    /// Heights from a raster file.
    Height(HeightLayer),
    /// Heights from fractal noise.
    Noise(NoiseLayer),
    /// Heights of the layers below, continued beyond their own resolution.
    Detail(DetailLayer),
    /// Colours from the heights of the shown ground.
    Tint(TintLayer),
    /// Colours from the steepness of the shown ground.
    Slope(SlopeLayer),
    /// Lines of equal height of the shown ground.
    Contours(ContoursLayer),
    /// Features from a vector file.
    Vector(Box<VectorLayer>),
    /// A kind that a newer program made: kept, shown by name, without effect.
    Unknown {
        /// The kind's name in the file.
        kind: String,
    },
}

impl LayerKind {
    /// Whether a layer of this kind can show in a part of the map only: whether it has colours. Kinds
    /// that are not known may.
    pub fn may_be_masked(&self) -> bool {
        !matches!(self, Self::Height(_) | Self::Noise(_) | Self::Detail(_))
    }

    /// The kind's name in the file: `imagery`, `height`, `noise`, `detail`, `tint`, `slope`,
    /// `contours`, `vector` or the unknown name.
    pub fn name(&self) -> &str {
        match self {
            Self::Imagery(_) => "imagery",
            Self::Height(_) => "height",
            Self::Noise(_) => "noise",
            Self::Detail(_) => "detail",
            Self::Tint(_) => "tint",
            Self::Slope(_) => "slope",
            Self::Contours(_) => "contours",
            Self::Vector(_) => "vector",
            Self::Unknown { kind } => kind,
        }
    }
}

/// A raster file and how to read it.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// The file: relative to the project's folder with forward slashes (`data/a.tif`, `../b.jpg`),
    /// or absolute. See [`resolve_path`](crate::resolve_path).
    pub path: String,
    /// Where its pixels lie, where the file does not say or says it wrongly.
    pub georeference: Option<Georeference>,
    /// The value that means "no data", instead of the file's own.
    pub nodata: Option<f64>,
    /// How samples between pixels are made. Default bilinear.
    pub resampling: Resampling,
    /// Width in metres on the ground over which the layer fades in from its edge, 0 (a hard edge, the
    /// default) to 10⁷.
    pub edge_fade_m: f64,
    /// How the colours of a set of tiles mean heights; of height layers only. `None`: as its metadata
    /// say.
    pub encoding: Option<HeightEncoding>,
    /// From where rows of a set of tiles count. `None`: as its metadata or its kind say.
    pub tile_rows: Option<TileRows>,
}

/// How the colours of a set of tiles mean heights.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum HeightEncoding {
    /// Mapbox Terrain-RGB: −10 000 m + (65 536 R + 256 G + B) · 0.1 m.
    TerrainRgb,
    /// Terrarium: 256 R + G + B / 256 − 32 768 m.
    Terrarium,
}

/// From where rows of a set of tiles count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TileRows {
    /// From north, as in XYZ folders.
    Xyz,
    /// From south, as in MBTiles and TMS folders.
    Tms,
}

impl Source {
    /// The file with everything else as it says itself.
    pub fn new(path: impl Into<String>) -> Self {
        Self {
            path: path.into(),
            georeference: None,
            nodata: None,
            resampling: Resampling::Bilinear,
            edge_fade_m: 0.0,
            encoding: None,
            tile_rows: None,
        }
    }
}

/// Replaces what a file says about its place. At least one of both is given.
#[derive(Clone, Debug, PartialEq)]
pub struct Georeference {
    /// The coordinate system: `EPSG:n`, `ESRI:n` or a proj string. `None`: the file's own; where
    /// that says nothing, longitude and latitude in degrees.
    pub crs: Option<String>,
    /// Outer edges of the image in units of the system. `None`: the file's own transform.
    pub extent: Option<Extent>,
    /// Unknown fields of the file.
    pub extra: Extra,
}

/// Outer edges of a north-up image, in degrees in geographic systems, else in the system's unit
/// (mostly metres). `east` exceeds `west` (add 360° across the antimeridian), `north` exceeds `south`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Left edge.
    pub west: f64,
    /// Bottom edge.
    pub south: f64,
    /// Right edge.
    pub east: f64,
    /// Top edge.
    pub north: f64,
}

/// How samples between pixels are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Resampling {
    /// The nearest pixel.
    Nearest,
    /// Linear between 2 × 2 pixels.
    #[default]
    Bilinear,
    /// Cubic between 4 × 4 pixels.
    Bicubic,
}

/// How a layer's colour meets what lies below.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Blend {
    /// Covers.
    #[default]
    Normal,
    /// Product: darkens.
    Multiply,
    /// Sum: lightens.
    Add,
    /// Inverted product of the inverses: lightens gently.
    Screen,
    /// Multiply in shadows, screen in lights.
    Overlay,
    /// Less the layer: darkens.
    Subtract,
    /// How far the two are apart.
    Difference,
    /// Like the difference, with less contrast.
    Exclusion,
    /// The darker of each channel.
    Darken,
    /// The lighter of each channel.
    Lighten,
    /// What lies below is lightened to reflect the layer.
    ColourDodge,
    /// What lies below is darkened to reflect the layer.
    ColourBurn,
    /// Multiply where the layer is dark, screen where it is light.
    HardLight,
    /// Darkens or lightens gently, as the layer says.
    SoftLight,
    /// The layer's hue alone.
    Hue,
    /// The layer's saturation alone.
    Saturation,
    /// The layer's hue and saturation.
    Colour,
    /// The layer's luminosity alone.
    Luminosity,
}

/// How stored numbers of an image become colours.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum Stretch {
    /// 8-bit numbers as they are, others between their 2nd and 98th percentile.
    #[default]
    Auto,
    /// The full range of their type; floats from 0 to 1.
    Full,
    /// From the lowest to the highest.
    MinMax,
    /// Between two percentiles, 0 to 100, the first below the second.
    Percentile {
        /// Percent of the numbers that are shown as black.
        low: f64,
        /// Percent of the numbers below those that are shown as white.
        high: f64,
    },
    /// Between two stored values, which differ.
    Range {
        /// Shown as black.
        black: f64,
        /// Shown as white.
        white: f64,
    },
}

/// Colours from a raster file.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageryLayer {
    /// The file.
    pub source: Source,
    /// Which bands are red, green, blue (and alpha), counted from 1: one (grey), three or four.
    /// `None`: as the file says.
    pub bands: Option<Vec<u16>>,
    /// How stored numbers become colours.
    pub stretch: Stretch,
    /// Metres from the edge of its data within which its colours bend to those below, 0 (not at all, the
    /// default) to 10⁷.
    pub seam_blend_m: f64,
    /// sRGB colour of what has no data within the file. `None`: what lies below shows.
    pub missing: Option<[u8; 3]>,
    /// Detail beyond the file's resolution, the first at the bottom; up to 16.
    pub detail: Vec<ColourDetail>,
    /// How it meets the layers below.
    pub blend: Blend,
    /// Colour adjustment.
    pub adjust: Adjust,
}

impl ImageryLayer {
    /// The file, unadjusted.
    pub fn new(source: Source) -> Self {
        Self {
            source,
            bands: None,
            stretch: Stretch::Auto,
            seam_blend_m: 0.0,
            missing: None,
            detail: Vec::new(),
            blend: Blend::Normal,
            adjust: Adjust::default(),
        }
    }
}

/// Heights from a raster file.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightLayer {
    /// The file.
    pub source: Source,
    /// Which band, counted from 1. `None`: the first.
    pub band: Option<u16>,
    /// Metres per unit of the file, −10⁶ to 10⁶. Default 1.
    pub vertical_scale: f64,
    /// Metres added after scaling, −10⁷ to 10⁷. Default 0.
    pub offset_m: f64,
}

impl HeightLayer {
    /// The file, its values as metres.
    pub fn new(source: Source) -> Self {
        Self {
            source,
            band: None,
            vertical_scale: 1.0,
            offset_m: 0.0,
        }
    }
}

/// Heights from fractal noise.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseLayer {
    /// The noise.
    pub noise: Noise,
}

/// Fractal 3-D simplex noise on the sphere.
#[derive(Clone, Debug, PartialEq)]
pub struct Noise {
    /// Chooses the pattern.
    pub seed: u32,
    /// Largest height of the first octave in metres, 0 to 10⁶.
    pub amplitude_m: f64,
    /// Wavelength of the first octave in metres, 10⁻³ to 10⁹.
    pub wavelength_m: f64,
    /// Number of octaves, 1 to 32. Default 8.
    pub octaves: u32,
    /// Factor on the frequency from octave to octave, 1 to 8. Default 2.
    pub lacunarity: f64,
    /// Factor on the amplitude from octave to octave (persistence), 0 to 1. Default 0.5.
    pub gain: f64,
    /// Whether octaves are folded to sharp ridges. Default false.
    pub ridged: bool,
    /// Metres added to the noise, −10⁷ to 10⁷. Default 0.
    pub offset_m: f64,
    /// Whether it adds to the heights below or replaces them.
    pub mode: NoiseMode,
}

impl Default for Noise {
    fn default() -> Self {
        Self {
            seed: 0,
            amplitude_m: 1000.0,
            wavelength_m: 1_000_000.0,
            octaves: 8,
            lacunarity: 2.0,
            gain: 0.5,
            ridged: false,
            offset_m: 0.0,
            mode: NoiseMode::Add,
        }
    }
}

/// How noise meets the heights below.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum NoiseMode {
    /// Replaces them (mixed by opacity).
    Replace,
    /// Adds to them; where there are none, to 0.
    #[default]
    Add,
}
