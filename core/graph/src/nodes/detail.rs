//! Heights continued beyond the data's own resolution by the power law that the data follow.

mod field;
mod ladder;
mod steepness;
mod survey;
mod waves;

use std::sync::Arc;

use glam::I64Vec2;
use relievo_planet::{Grid, GridCrs, Planet};
use relievo_raster::vector::on_widest;
use relievo_raster::{Bands, Block};

use super::ground::Ground;
use super::lanes::{LANES, Lanes};
use super::noise::{scrambled, simplex};
use crate::node::{Artefact, Made};
use crate::{ContentId, IdHasher, ImageNode, Job, Known, RenderError};
use field::{Circle, Field, spacing_m, touched};
use ladder::{Octave, octaves, smooth};
use survey::{PatchOf, Survey};
use waves::Waves;

/// The node's kind, by which answers know it.
pub const KIND: &str = "detail";

/// How octaves of detail are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DetailMethod {
    /// Simplex noise: hills and hollows of about a size.
    Simplex,
    /// Plane waves of all lengths of the octave: nothing missing between octaves, several times dearer.
    Spectral,
}

/// What detail to make of a source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetailParams {
    /// Another seed gives unrelated detail.
    pub seed: u64,
    /// A factor on its heights, 0 to 16; 1 goes on as the data do.
    pub strength: f64,
    /// How octaves are made.
    pub method: DetailMethod,
    /// How much steeper ground is rougher, 0 (all of a region alike) to 1 (in proportion).
    pub slope: f64,
    /// Lowest and highest ground that gets detail, metres above the datum.
    pub heights_m: [f64; 2],
    /// Metres of height within these over which it fades in.
    pub fade_m: f64,
    /// Shortest wavelength in metres.
    pub shortest_m: f64,
    /// Metres between samples of the source.
    pub spacing_m: f64,
}

/// What the node gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Gives {
    /// The source's heights with detail.
    Heights,
    /// How high the detail is about, in metres.
    Amount,
}

/// An octave that can be made.
#[derive(Clone, Debug)]
struct Band {
    octave: Octave,
    scale: f64,
    seed: u32,
    waves: Option<Waves>,
}

/// A source's heights and octaves that are finer than its samples. Input: the source's heights, holes among
/// them.
///
/// How rough the source is, and how that grows with the wavelength, is measured patch by patch around each
/// place as [`roughness`](crate::roughness) does, on a grid of the source's own fineness and so the same at
/// every zoom. The octaves continue that law: what a source lacks of an octave is added, so that there is
/// neither a gap nor a step at its resolution. Steeper places get more and gentler ones less, such that a
/// region's energy stays that of the law; level water and what is about it get nothing, holes stay holes.
///
/// Octaves are powers of two metres long and made in space ([`Noise`](super::Noise)): no seam, no pole, and
/// the same waves whatever the source. They fade out where a grid cannot show them.
#[derive(Clone, Debug)]
pub struct Detail {
    planet: Planet,
    params: DetailParams,
    gives: Gives,
    octaves: Vec<Band>,
    survey: Arc<Survey>,
    name: ContentId,
}

impl Detail {
    /// Numbers out of their ranges count as the nearest in it, those that are not finite as the usual ones:
    /// a strength and a wavelength of 1, half of the slope, all heights, a source of 1 m.
    pub fn new(planet: Planet, params: &DetailParams) -> Self {
        let sane = |v: f64, default: f64| if v.is_finite() { v } else { default };
        let or_all = |v: f64, all: f64| if v.is_nan() { all } else { v };
        let params = DetailParams {
            strength: sane(params.strength, 1.0).clamp(0.0, 16.0),
            slope: sane(params.slope, 0.5).clamp(0.0, 1.0),
            heights_m: [
                or_all(params.heights_m[0], f64::NEG_INFINITY),
                or_all(params.heights_m[1], f64::INFINITY),
            ],
            fade_m: sane(params.fade_m, 0.0).max(0.0),
            shortest_m: sane(params.shortest_m, 1.0).max(ladder::SHORTEST_M),
            spacing_m: sane(params.spacing_m, 1.0).clamp(1e-3, 1e7),
            ..*params
        };
        let wanted = if params.strength > 0.0 {
            octaves(params.spacing_m, params.shortest_m)
        } else {
            Vec::new()
        };
        let made = wanted.into_iter().map(|octave| {
            let exponent = i64::from(octave.exponent) as u64;
            let seed = (scrambled(scrambled(params.seed).wrapping_add(exponent)) >> 32) as u32;
            let scale = planet.radius_m / octave.wavelength_m;
            let waves = (params.method == DetailMethod::Spectral).then(|| Waves::new(scale, seed));
            Band {
                octave,
                scale,
                seed,
                waves,
            }
        });
        let octaves: Vec<Band> = made.collect();
        let longest_m = octaves.first().map_or(1.0, |o| o.octave.wavelength_m);
        let ln_gain = match params.method {
            DetailMethod::Simplex => simplex_ln_gain,
            DetailMethod::Spectral => waves_ln_gain,
        };
        let survey = Survey::new(planet, params.spacing_m, params.slope, longest_m, ln_gain);
        let name = Self::named(&planet, &params, Gives::Heights);
        Self {
            planet,
            params,
            gives: Gives::Heights,
            octaves,
            survey: Arc::new(survey),
            name,
        }
    }

    /// The same, giving how high its detail is about (the root of its mean square, in metres) instead of
    /// heights: 0 without, NaN where the source has a hole.
    #[must_use]
    pub fn amount(mut self) -> Self {
        self.gives = Gives::Amount;
        self.name = Self::named(&self.planet, &self.params, self.gives);
        self
    }

    /// Wavelengths below this are made up, metres: two samples of the source. `None` if none is.
    pub fn synthesised_below_m(&self) -> Option<f64> {
        (!self.octaves.is_empty()).then_some(2.0 * self.params.spacing_m)
    }

    /// All that decides what is made, but for the planet.
    pub fn params(&self) -> &DetailParams {
        &self.params
    }

    /// The shortest wavelength that is made, metres; `None` if none is.
    pub fn shortest_m(&self) -> Option<f64> {
        self.octaves.last().map(|o| o.octave.wavelength_m)
    }

    fn named(planet: &Planet, params: &DetailParams, gives: Gives) -> ContentId {
        let mut id = IdHasher::default();
        id.int(params.seed as i64)
            .int(params.method as i64)
            .int(gives as i64);
        for v in [
            params.strength,
            params.slope,
            params.heights_m[0],
            params.heights_m[1],
            params.fade_m,
            params.shortest_m,
            params.spacing_m,
            planet.radius_m,
            planet.equatorial_radius_m,
            planet.flattening,
        ] {
            id.float(v);
        }
        id.finish()
    }

    /// Whether no grid of these samples can show any octave.
    fn is_too_coarse(&self, grid: &Grid) -> bool {
        // The shortest samples of any row show most.
        let spacing_m = grid.lattice.step.y.abs() * self.planet.radius_m;
        let shows = |o: &Band| o.octave.shown(spacing_m) > 0.0;
        self.octaves.is_empty()
            || grid.lattice.crs == GridCrs::Map && !self.octaves.iter().any(shows)
    }

    /// How much detail ground of a height gets, 0 to 1.
    fn share_at(&self, height_m: f64) -> f64 {
        let [low, high] = self.params.heights_m;
        let within = (height_m - low).min(high - height_m);
        if within == f64::INFINITY {
            return 1.0;
        }
        if self.params.fade_m > 0.0 {
            smooth(within / self.params.fade_m)
        } else {
            f64::from(within >= 0.0)
        }
    }

    /// Detail at some places.
    fn lanes(&self, places: &Places, out: &mut Lanes) {
        *out = [0.0; LANES];
        let mut height_m = places.height_m;
        for made in &self.octaves {
            let mut amplitude_m = [0.0; LANES];
            let mut any = false;
            // On the map all samples of a row are alike.
            let usual_m = places.spacing_m[0];
            let usual = made.octave.shown(usual_m);
            for ((a, h), spacing_m) in amplitude_m.iter_mut().zip(&height_m).zip(&places.spacing_m)
            {
                if *h != 0.0 {
                    let alike = *spacing_m == usual_m;
                    let shown = if alike {
                        usual
                    } else {
                        made.octave.shown(*spacing_m)
                    };
                    *a = h * shown as f32;
                    any |= *a != 0.0;
                }
            }
            if any && self.gives == Gives::Amount {
                let variance = match self.params.method {
                    DetailMethod::Simplex => SIMPLEX_VARIANCE,
                    DetailMethod::Spectral => 1.0,
                };
                for (o, a) in out.iter_mut().zip(&amplitude_m) {
                    *o += a * a * variance;
                }
            } else if any {
                on_widest(
                    #[inline(always)]
                    || {
                        let mut noise = [0.0; LANES];
                        match &made.waves {
                            Some(waves) => waves.at(&places.unit, &mut noise),
                            None => simplex(&places.unit, made.scale, made.seed, &mut noise),
                        }
                        for ((o, a), n) in out.iter_mut().zip(&amplitude_m).zip(&noise) {
                            *o += a * n;
                        }
                    },
                );
            }
            for (h, falloff) in height_m.iter_mut().zip(&places.falloff) {
                *h *= falloff;
            }
        }
        if self.gives == Gives::Amount {
            for o in out {
                *o = o.sqrt();
            }
        }
    }
}

/// Samples that are worked on together.
struct Places {
    unit: [[f64; LANES]; 3],
    spacing_m: [f64; LANES],
    /// Of the longest octave.
    height_m: Lanes,
    falloff: Lanes,
}

impl ImageNode for Detail {
    fn kind(&self) -> &'static str {
        KIND
    }

    fn output(&self) -> Bands {
        Bands::Height
    }

    /// Artefacts are for nodes that are not.
    fn is_pointwise(&self) -> bool {
        false
    }

    fn identify(&self, grid: &Grid, id: &mut IdHasher) {
        id.id(self.name).grid(grid);
    }

    fn known(&self, grid: &Grid, inputs: &[Known]) -> Known {
        match inputs[0] {
            Known::Uniform([height_m, ..]) if self.gives == Gives::Amount => {
                // What is level gets nothing.
                let amount_m = if height_m.is_nan() { f32::NAN } else { 0.0 };
                if height_m.is_nan() || self.is_too_coarse(grid) {
                    Known::Uniform([amount_m, 0.0, 0.0, 0.0])
                } else {
                    Known::Complete
                }
            }
            known if known.is_complete(Bands::Height) => Known::Complete,
            Known::Nothing | Known::Complete | Known::Uniform(_) => Known::Nothing,
        }
    }

    fn identity(&self, grid: &Grid, inputs: &[Known]) -> Option<usize> {
        let idle = inputs[0].is_absent(Bands::Height) || self.is_too_coarse(grid);
        (idle && self.gives == Gives::Heights).then_some(0)
    }

    fn artefacts(&self, grid: &Grid) -> Vec<Arc<dyn Artefact>> {
        if self.is_too_coarse(grid) {
            return Vec::new();
        }
        // A grid whose coordinate system is not known is refused where it is rendered.
        let touched = touched(&self.survey, grid, KIND).unwrap_or_default();
        let patches = touched.into_iter().map(|(row, column)| PatchOf {
            survey: Arc::clone(&self.survey),
            column,
            row,
        });
        patches
            .map(|patch| Arc::new(patch) as Arc<dyn Artefact>)
            .collect()
    }

    fn render(&self, job: &Job, inputs: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        self.render_from(job, &[], inputs, out)
    }

    fn render_from(
        &self,
        job: &Job,
        artefacts: &[Made],
        inputs: &[&Block],
        out: &mut Block,
    ) -> Result<(), RenderError> {
        let Grid { lattice, rect } = job.grid;
        let ground = Ground::new(lattice, KIND)?;
        let field = Field::new(&self.survey, artefacts);
        let width = out.width().max(1);
        let heights = inputs[0].plane(0).chunks_exact(width);
        let mut line = Line {
            ground: &ground,
            field: &field,
            on: None,
            first: rect.min.x,
            columns: vec![(f64::NAN, (0.0, 0.0)); width],
            places: Places {
                unit: [[0.0; LANES]; 3],
                spacing_m: [1.0; LANES],
                height_m: [0.0; LANES],
                falloff: [0.0; LANES],
            },
        };
        let rows = out.plane_mut(0).chunks_exact_mut(width).zip(heights);
        for ((row, heights), y) in rows.zip(rect.min.y..) {
            if job.cancel.is_cancelled() {
                return Err(RenderError::Cancelled);
            }
            let strips = row.chunks_mut(LANES).zip(heights.chunks(LANES));
            for ((strip, heights), first) in strips.zip((rect.min.x..).step_by(LANES)) {
                line.places.height_m = [0.0; LANES];
                let mut any = false;
                for (lane, h) in heights.iter().enumerate() {
                    let sample = I64Vec2::new(first + lane as i64, y);
                    any |= !h.is_nan() && self.place(&mut line, sample, *h, lane);
                }
                let mut detail = [0.0; LANES];
                if any {
                    self.lanes(&line.places, &mut detail);
                }
                for ((o, h), d) in strip.iter_mut().zip(heights).zip(&detail) {
                    *o = match self.gives {
                        Gives::Amount if h.is_nan() => f32::NAN,
                        Gives::Amount => *d,
                        Gives::Heights if *d == 0.0 => *h,
                        Gives::Heights => h + d,
                    };
                }
            }
        }
        Ok(())
    }
}

impl Detail {
    /// Puts a sample into a lane; whether it gets any detail.
    fn place(&self, line: &mut Line, sample: I64Vec2, height_m: f32, lane: usize) -> bool {
        let share = self.params.strength * self.share_at(f64::from(height_m));
        if share == 0.0 {
            return false;
        }
        let Some(place) = line.ground.point(sample.as_dvec2() + 0.5) else {
            return false;
        };
        let on = match &mut line.on {
            Some(on) if on.colat_rad == place.colat_rad => on,
            before => before.insert(On::new(line.field, place.colat_rad)),
        };
        let spacing_m = match spacing_m(line.ground, &self.planet, sample, || on.sin_colat) {
            Some(spacing_m) if 2.0 * spacing_m < self.survey.longest_m() => spacing_m,
            _nothing_shows => return false,
        };
        let rough = line.field.at(&on.circle, place.lon_rad);
        if rough.height_m == 0.0 {
            return false;
        }
        let column = &mut line.columns[(sample.x - line.first) as usize];
        if column.0 != place.lon_rad {
            *column = (place.lon_rad, libm::sincos(place.lon_rad));
        }
        let (sin_lon, cos_lon) = column.1;
        let places = &mut line.places;
        places.spacing_m[lane] = spacing_m;
        places.height_m[lane] = rough.height_m * share as f32;
        places.falloff[lane] = rough.falloff;
        places.unit[0][lane] = on.sin_colat * cos_lon;
        places.unit[1][lane] = on.sin_colat * sin_lon;
        places.unit[2][lane] = on.cos_colat;
        true
    }
}

/// A line of samples on the way.
struct Line<'a> {
    ground: &'a Ground<'a>,
    field: &'a Field<'a>,
    /// Of the sample before: on the map all of a row lie on one.
    on: Option<On>,
    /// The first column, and the longitude of each with its sine and cosine: on the map those of the row before.
    first: i64,
    columns: Vec<(f64, (f64, f64))>,
    places: Places,
}

/// A circle of latitude.
struct On {
    colat_rad: f64,
    sin_colat: f64,
    cos_colat: f64,
    circle: Circle,
}

impl On {
    fn new(field: &Field, colat_rad: f64) -> Self {
        let (sin_colat, cos_colat) = libm::sincos(colat_rad);
        Self {
            colat_rad,
            sin_colat,
            cos_colat,
            circle: field.circle(colat_rad),
        }
    }
}

/// The variance of simplex noise.
const SIMPLEX_VARIANCE: f32 = 0.1538;

/// Logarithms of the energy, at a lag of 1, of octaves of each method that are as high as their wavelengths
/// to the power of H, all octaves from the shortest to the longest together; for H of 0.3, 0.4 and so on.
///
/// ∫ g(x) x^(−2H−1) dx / ln 2 over the mean squared second difference g of one octave at a lag of x
/// wavelengths, by the trapezium rule: of simplex noise from its correlation at 400,000 places, of
/// plane waves of all directions 6 − 8 sin t / t + sin 2t / t with t = 2πx.
const LN_GAINS: [[f64; 2]; 11] = [
    [1.5899, 3.3770],
    [1.5849, 3.3297],
    [1.6464, 3.3491],
    [1.7556, 3.4136],
    [1.9017, 3.5121],
    [2.0785, 3.6384],
    [2.2827, 3.7893],
    [2.5125, 3.9634],
    [2.7679, 4.1608],
    [3.0496, 4.3828],
    [3.3599, 4.6320],
];

fn ln_gain(exponent: f64, method: usize) -> f64 {
    let at = ((exponent - 0.3) * 10.0).clamp(0.0, (LN_GAINS.len() - 2) as f64);
    let first = (at as usize).min(LN_GAINS.len() - 2);
    let [low, high] = [LN_GAINS[first][method], LN_GAINS[first + 1][method]];
    low + (high - low) * (at - first as f64)
}

fn simplex_ln_gain(exponent: f64) -> f64 {
    ln_gain(exponent, 0)
}

fn waves_ln_gain(exponent: f64) -> f64 {
    ln_gain(exponent, 1)
}

#[cfg(test)]
mod tests;
