//! The ranges of all numbers in the file, each in this one place: the reader, the edits and the
//! JSON Schema take them from here.

/// A closed range.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Range<T> {
    /// Smallest value inside.
    pub(crate) min: T,
    /// Largest value inside.
    pub(crate) max: T,
}

const fn range<T: Copy>(min: T, max: T) -> Range<T> {
    Range { min, max }
}

pub(crate) const SHARE: Range<f64> = range(0.0, 1.0);
pub(crate) const TURN_DEG: Range<f64> = range(-360.0, 360.0);
pub(crate) const LATITUDE_DEG: Range<f64> = range(-90.0, 90.0);
pub(crate) const ALTITUDE_M: Range<f64> = range(-1e5, 1e9);
pub(crate) const FIELD_OF_VIEW_DEG: Range<f64> = range(1.0, 170.0);
pub(crate) const RADIUS_M: Range<f64> = range(1.0, 1e9);
pub(crate) const FLATTENING: Range<f64> = range(0.0, 0.5);
pub(crate) const EXAGGERATION: Range<f64> = range(0.0, 100.0);
pub(crate) const TEXEL_PX: Range<f64> = range(0.25, 16.0);
pub(crate) const MESH_DENSITY: Range<f64> = range(0.1, 10.0);
pub(crate) const ERROR_PX: Range<f64> = range(0.01, 100.0);
pub(crate) const FRAME_BUDGET_MS: Range<f64> = range(1.0, 1000.0);
/// Also the limits of projected coordinates: far beyond any planet.
pub(crate) const COORDINATE: Range<f64> = range(-1e10, 1e10);
pub(crate) const EDGE_FADE_M: Range<f64> = range(0.0, 1e7);
/// Of encoded colours: black to white is √3.
pub(crate) const TOLERANCE: Range<f64> = range(0.0, 2.0);
/// Beyond heights of a mask.
pub(crate) const MASK_FADE_M: Range<f64> = range(0.0, 1e7);
/// Radii of lenses: around any planet.
pub(crate) const LENS_M: Range<f64> = range(0.0, 1e10);
/// Corners of lenses, from their centre.
pub(crate) const CORNER_M: Range<f64> =
    range(-crate::LensShape::FARTHEST_M, crate::LensShape::FARTHEST_M);
pub(crate) const NODATA: Range<f64> = range(f64::MIN, f64::MAX);
pub(crate) const BAND: Range<u32> = range(1, 65_535);
pub(crate) const SIGNED_SHARE: Range<f64> = range(-1.0, 1.0);
pub(crate) const FACTOR: Range<f64> = range(0.0, 4.0);
pub(crate) const HUE_DEG: Range<f64> = range(-180.0, 180.0);
pub(crate) const GAMMA: Range<f64> = range(0.1, 10.0);
pub(crate) const GAIN: Range<f64> = range(0.0, 16.0);
pub(crate) const SIGNED_GAIN: Range<f64> = range(-16.0, 16.0);
pub(crate) const TEMPERATURE_K: Range<f64> = range(1667.0, 25_000.0);
pub(crate) const LIGHT_TINT: Range<f64> = range(-100.0, 100.0);
pub(crate) const VERTICAL_SCALE: Range<f64> = range(-1e6, 1e6);
pub(crate) const HEIGHT_M: Range<f64> = range(-1e7, 1e7);
pub(crate) const AMPLITUDE_M: Range<f64> = range(0.0, 1e6);
pub(crate) const WAVELENGTH_M: Range<f64> = range(1e-3, 1e9);
pub(crate) const OCTAVES: Range<u32> = range(1, 32);
pub(crate) const LACUNARITY: Range<f64> = range(1.0, 8.0);
pub(crate) const SLOPE_DEG: Range<f64> = range(0.0, 90.0);
/// Between contour lines.
pub(crate) const INTERVAL_M: Range<f64> = range(1e-3, 1e6);
pub(crate) const INDEX_EVERY: Range<u32> = range(0, 1000);
pub(crate) const LINE_PX: Range<f64> = range(0.0, 100.0);
pub(crate) const SIDE_SLOPE: Range<f64> = range(0.01, 100.0);
/// Reaches, depths, strokes and smoothing lengths of elements.
pub(crate) const REACH_M: Range<f64> = range(0.0, 1e5);
/// Widths of roads, crests and bottoms.
pub(crate) const SECTION_M: Range<f64> = range(0.01, 1e5);
pub(crate) const SLOPE_PERCENT: Range<f64> = range(0.0, 1e4);
pub(crate) const CROSSFALL_PERCENT: Range<f64> = range(-100.0, 100.0);
pub(crate) const BRUSH_RADIUS_M: Range<f64> = range(0.01, 1e6);
/// Widths in metres or pixels.
pub(crate) const WIDTH: Range<f64> = range(0.0, 1e6);
pub(crate) const LABEL_PX: Range<f64> = range(4.0, 200.0);
/// n of scales 1 : n.
pub(crate) const SCALE: Range<f64> = range(0.0, 1e12);

/// Sides of a colour window in samples.
pub(crate) const COLOUR_WINDOWS: [u32; 5] = [256, 512, 1024, 2048, 4096];
/// Most layers in a project.
pub(crate) const MOST_LAYERS: usize = 10_000;
/// Most points of a tone curve.
pub(crate) const MOST_CURVE_POINTS: usize = 256;
/// Most kinds of detail of a layer.
pub(crate) const MOST_DETAILS: usize = crate::ColourDetail::MOST;
/// Most layers that are examples of one kind of detail.
pub(crate) const MOST_EXAMPLES: usize = crate::DetailBy::MOST_EXAMPLES;
/// Corners of a lens.
pub(crate) const CORNERS: Range<usize> = range(
    crate::LensShape::LEAST_CORNERS,
    crate::LensShape::MOST_CORNERS,
);
/// Most stops of a table of colours.
pub(crate) const MOST_STOPS: usize = 1000;
/// Longest path and coordinate system in bytes.
pub(crate) const LONGEST_PATH: usize = 4096;
/// Longest name of a layer in bytes.
pub(crate) const LONGEST_NAME: usize = 1000;
/// Most edits in a batch.
pub(crate) const MOST_EDITS: usize = 100_000;
/// Most elements of the base, and most changes of a scenario.
pub(crate) const MOST_ELEMENTS: usize = 100_000;
/// Most scenarios in a project.
pub(crate) const MOST_SCENARIOS: usize = 1000;
/// Most bookmarks in a project.
pub(crate) const MOST_BOOKMARKS: usize = 10_000;
/// Most vertices of a list.
pub(crate) const MOST_VERTICES: usize = 10_000_000;
/// Most holes and breaklines of a polygon, and strokes of a brush.
pub(crate) const MOST_LISTS: usize = 100_000;
/// Most lengths of a dash.
pub(crate) const MOST_DASHES: usize = 32;
/// Most classes of a style.
pub(crate) const MOST_CLASSES: usize = 10_000;
