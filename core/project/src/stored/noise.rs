//! Layers of heights that no file has as they lie in version 1 of the file: noise, and detail beyond the data.

use super::range;

fields! {
    /// Heights from fractal 3-D simplex noise.
    Noise {
        /// Chooses the pattern; 0 where left out.
        seed: Option<u32>,
        /// Largest height of the first octave in metres.
        amplitude_m: f64 = range::AMPLITUDE_M,
        /// Wavelength of the first octave in metres.
        wavelength_m: f64 = range::WAVELENGTH_M,
        /// Number of octaves; 8 where left out.
        octaves: Option<u32> = range::OCTAVES,
        /// Factor on the frequency from octave to octave; 2 where left out.
        lacunarity: Option<f64> = range::LACUNARITY,
        /// Factor on the amplitude from octave to octave; 0.5 where left out.
        gain: Option<f64> = range::SHARE,
        /// Whether octaves are folded to sharp ridges; false where left out.
        ridged: Option<bool>,
        /// Metres added to the noise; 0 where left out.
        offset_m: Option<f64> = range::HEIGHT_M,
        /// Whether the noise adds to the heights below or replaces them; add where left out.
        mode: Option<NoiseMode>,
    }
}

names! {
    /// How noise meets the heights below.
    NoiseMode for crate::NoiseMode {
        /// Replaces them.
        Replace = "replace",
        /// Adds to them.
        Add = "add",
    }
}

fields! {
    /// Heights of the layers below, continued beyond their own resolution by the power law that they follow.
    Detail {
        /// Chooses the pattern; 0 where left out.
        seed: Option<u32>,
        /// Factor on the heights that are added; 1 where left out.
        strength: Option<f64> = range::FACTOR,
        /// How octaves are made; simplex where left out.
        method: Option<DetailMethod>,
        /// How much steeper ground is rougher; 0.5 where left out.
        slope: Option<f64> = range::SHARE,
        /// Lowest ground in metres that gets detail; any where left out.
        lowest_m: Option<f64> = range::HEIGHT_M,
        /// Highest ground in metres that gets detail, above `lowest_m`; any where left out.
        highest_m: Option<f64> = range::HEIGHT_M,
        /// Metres of height within these bounds over which it fades in; 50 where left out.
        fade_m: Option<f64> = range::EDGE_FADE_M,
        /// Shortest wavelength in metres; 1 where left out.
        shortest_m: Option<f64> = range::WAVELENGTH_M,
    }
}

names! {
    /// How octaves of detail are made.
    DetailMethod for crate::DetailMethod {
        /// 3-D simplex noise.
        Simplex = "simplex",
        /// Sums of waves of all lengths.
        Spectral = "spectral",
    }
}
