//! Heights packed into the colours of a tile.

use core::fmt;

/// How the colour of a tile's pixel means a height.
///
/// Black, the lowest code of both, means nodata unless the options name another height; so do
/// transparent pixels. Pixels are decoded before anything is interpolated: mixing codes would give
/// heights that are far from both.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum HeightEncoding {
    /// Mapbox Terrain-RGB: −10 000 m + (65 536 R + 256 G + B) · 0.1 m.
    TerrainRgb,
    /// Terrarium: 256 R + G + B / 256 − 32 768 m.
    Terrarium,
}

impl HeightEncoding {
    /// The encoding that a name means: `terrain-rgb`, `terrainrgb`, `mapbox` or `terrarium`, in any
    /// case.
    pub fn from_name(name: &str) -> Option<Self> {
        match name.trim().to_ascii_lowercase().as_str() {
            "terrain-rgb" | "terrain_rgb" | "terrainrgb" | "mapbox" => Some(Self::TerrainRgb),
            "terrarium" => Some(Self::Terrarium),
            _ => None,
        }
    }

    /// The name in project files and on the command line: `terrain-rgb` or `terrarium`.
    pub fn name(self) -> &'static str {
        match self {
            Self::TerrainRgb => "terrain-rgb",
            Self::Terrarium => "terrarium",
        }
    }

    /// The height in metres that a colour means: the nearest f32 to the exact value.
    pub fn height_m(self, [r, g, b]: [u8; 3]) -> f32 {
        let code = f64::from(u32::from_be_bytes([0, r, g, b]));
        match self {
            // One division of whole numbers, so that 0.1 leaves no error.
            Self::TerrainRgb => ((code - 100_000.0) / 10.0) as f32,
            Self::Terrarium => (code / 256.0 - 32_768.0) as f32,
        }
    }
}

impl fmt::Display for HeightEncoding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_mean_the_heights_that_the_encodings_publish() {
        let mapbox = HeightEncoding::TerrainRgb;
        assert_eq!(mapbox.height_m([0, 0, 0]), -10_000.0);
        assert_eq!(mapbox.height_m([1, 134, 160]), 0.0);
        assert_eq!(mapbox.height_m([1, 134, 161]), 0.1);
        assert_eq!(mapbox.height_m([255, 255, 255]), 1_667_721.5);
        let terrarium = HeightEncoding::Terrarium;
        assert_eq!(terrarium.height_m([128, 0, 0]), 0.0);
        assert_eq!(terrarium.height_m([0, 0, 0]), -32_768.0);
        assert_eq!(terrarium.height_m([255, 255, 255]), 32_767.996);
        assert_eq!(terrarium.height_m([127, 255, 128]), -0.5);
    }

    #[test]
    fn every_name_that_is_written_is_read() {
        for encoding in [HeightEncoding::TerrainRgb, HeightEncoding::Terrarium] {
            assert_eq!(HeightEncoding::from_name(encoding.name()), Some(encoding));
        }
        assert_eq!(HeightEncoding::from_name("gray16"), None);
    }
}
