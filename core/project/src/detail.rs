//! Layers that continue heights beyond the data's own resolution.

/// Continues the height layers below it beyond their own resolution. Synthesised: measurements leave it out.
#[derive(Clone, Debug, PartialEq)]
pub struct DetailLayer {
    /// How.
    pub detail: Detail,
}

/// How heights are continued: by the power law that each layer's own data follow around a place.
#[derive(Clone, Debug, PartialEq)]
pub struct Detail {
    /// Chooses the pattern.
    pub seed: u32,
    /// Factor on the heights that are added, 0 to 4. Default 1: as the data go on.
    pub strength: f64,
    /// How octaves are made.
    pub method: DetailMethod,
    /// How much steeper ground is rougher: 0 (all of a region alike) to 1 (in proportion). Default 0.5.
    pub slope: f64,
    /// Lowest ground in metres that gets detail, −10⁷ to 10⁷. `None`: however low.
    pub lowest_m: Option<f64>,
    /// Highest ground in metres that gets detail, above the lowest. `None`: however high.
    pub highest_m: Option<f64>,
    /// Metres of height within these bounds over which detail fades in, 0 to 10⁷. Default 50.
    pub fade_m: f64,
    /// Shortest wavelength in metres, 10⁻³ to 10⁹. Default 1.
    pub shortest_m: f64,
}

impl Default for Detail {
    fn default() -> Self {
        Self {
            seed: 0,
            strength: 1.0,
            method: DetailMethod::Simplex,
            slope: 0.5,
            lowest_m: None,
            highest_m: None,
            fade_m: 50.0,
            shortest_m: 1.0,
        }
    }
}

/// How octaves of detail are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum DetailMethod {
    /// 3-D simplex noise.
    #[default]
    Simplex,
    /// Sums of waves of all lengths: nearer to the law between octaves, several times dearer.
    Spectral,
}
