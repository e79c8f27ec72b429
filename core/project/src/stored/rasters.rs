//! Layers from raster files as they lie in version 1 of the file.

use super::adjust::Adjust;
use super::blend::Blend;
use super::colour::StoredColour;
use super::colour_detail::ColourDetail;
use super::range;
use super::stretch::StoredStretch;
use super::value::With;

fields! {
    /// Colours from a raster file.
    Imagery {
        /// The file: relative to the project's folder with forward slashes, or absolute.
        #[schemars(length(min = 1, max = range::LONGEST_PATH))]
        path: String,
        /// Replaces what the file says about its place.
        georeference: Option<With<Georeference>>,
        /// The value that means "no data", instead of the file's own.
        nodata: Option<f64> = range::NODATA,
        /// From where rows of a set of tiles count; as the set says where left out.
        tile_rows: Option<TileRows>,
        /// Which bands are red, green, blue (and alpha), counted from 1: one (grey), three or four.
        #[schemars(length(min = 1, max = 4))]
        bands: Option<Vec<u32>> => range::BAND,
        /// How stored numbers become colours; auto where left out.
        stretch: Option<StoredStretch>,
        /// How samples between pixels are made; bilinear where left out.
        resampling: Option<Resampling>,
        /// Width in metres over which the layer fades in from its edge; 0 where left out.
        edge_fade_m: Option<f64> = range::EDGE_FADE_M,
        /// Metres from the edge of its data within which the layer's colours bend to those below; 0 where
        /// left out.
        seam_blend_m: Option<f64> = range::EDGE_FADE_M,
        /// Colour of what has no data within the file; what lies below shows where left out.
        missing: Option<StoredColour>,
        /// Detail beyond the file's resolution, the first at the bottom; none where left out.
        #[schemars(length(max = range::MOST_DETAILS))]
        detail: Option<Vec<With<ColourDetail>>>,
        /// How the colour meets what lies below; normal where left out.
        blend: Option<Blend>,
        /// Colour adjustment; none where left out.
        adjust: Option<With<Adjust>>,
    }
}

fields! {
    /// Heights from a raster file.
    Height {
        /// The file: relative to the project's folder with forward slashes, or absolute.
        #[schemars(length(min = 1, max = range::LONGEST_PATH))]
        path: String,
        /// Replaces what the file says about its place.
        georeference: Option<With<Georeference>>,
        /// The value that means "no data", instead of the file's own.
        nodata: Option<f64> = range::NODATA,
        /// How the colours of a set of tiles mean heights; as the set says where left out.
        encoding: Option<HeightEncoding>,
        /// From where rows of a set of tiles count; as the set says where left out.
        tile_rows: Option<TileRows>,
        /// Which band, counted from 1; the first where left out.
        band: Option<u32> = range::BAND,
        /// How samples between pixels are made; bilinear where left out.
        resampling: Option<Resampling>,
        /// Width in metres over which the layer fades in from its edge; 0 where left out.
        edge_fade_m: Option<f64> = range::EDGE_FADE_M,
        /// Metres per unit of the file; 1 where left out.
        vertical_scale: Option<f64> = range::VERTICAL_SCALE,
        /// Metres added after scaling; 0 where left out.
        offset_m: Option<f64> = range::HEIGHT_M,
    }
}

fields! {
    /// Replaces what a file says about its place: `crs`, or all four edges, or both. Edges are in
    /// degrees in geographic systems, else in the system's unit.
    Georeference {
        /// The coordinate system: `EPSG:n`, `ESRI:n` or a proj string.
        #[schemars(length(min = 1, max = range::LONGEST_PATH))]
        crs: Option<String>,
        /// Left edge of the image.
        west: Option<f64> = range::COORDINATE,
        /// Bottom edge of the image.
        south: Option<f64> = range::COORDINATE,
        /// Right edge of the image, above `west`.
        east: Option<f64> = range::COORDINATE,
        /// Top edge of the image, above `south`.
        north: Option<f64> = range::COORDINATE,
    }
}

names! {
    /// How the colours of a set of tiles mean heights.
    HeightEncoding for crate::HeightEncoding {
        /// Mapbox Terrain-RGB: −10 000 m + (65 536 R + 256 G + B) · 0.1 m.
        TerrainRgb = "terrain-rgb",
        /// 256 R + G + B / 256 − 32 768 m.
        Terrarium = "terrarium",
    }
}

names! {
    /// From where rows of a set of tiles count.
    TileRows for crate::TileRows {
        /// From north.
        Xyz = "xyz",
        /// From south.
        Tms = "tms",
    }
}

names! {
    /// How samples between pixels are made.
    Resampling for crate::Resampling {
        /// The nearest pixel.
        Nearest = "nearest",
        /// Linear between 2 × 2 pixels.
        Bilinear = "bilinear",
        /// Cubic between 4 × 4 pixels.
        Bicubic = "bicubic",
    }
}
