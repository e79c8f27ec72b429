//! Fractal noise on the sphere: detail beyond the data's own resolution, or a whole planet.

mod simplex;

use glam::{DVec2, I64Vec2};
use relievo_planet::{Grid, GridCrs, Planet};
use relievo_raster::vector::on_widest;
use relievo_raster::{Bands, Block};

use super::ground::Ground;
use super::lanes::{LANES, Lanes};
use super::memory::add_grid;
use crate::{ContentId, IdHasher, ImageNode, Job, Known, RenderError};
use simplex::simplex;

const KIND: &str = "noise";

/// Most octaves that a noise has; a factor of 2 each spans all scales of a planet.
pub const MAX_OCTAVES: u32 = 32;

/// What noise to make.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseParams {
    /// Another seed gives unrelated noise.
    pub seed: u64,
    /// Largest height of the first octave in metres, clamped to ±10³⁰.
    pub amplitude_m: f64,
    /// Size of the first octave's features in metres on the ground, at least 0.01.
    pub wavelength_m: f64,
    /// Number of octaves, clamped to [`MAX_OCTAVES`].
    pub octaves: u32,
    /// Each octave's wavelength is the one before divided by this; clamped to 1.01 to 100, usually 2.
    pub lacunarity: f64,
    /// Each octave's amplitude is the one before times this; clamped to 0 to 1, usually ½.
    pub gain: f64,
    /// Whether octaves are folded to ridges: 1 − 2 |n| instead of n.
    pub ridged: bool,
}

/// One octave as it is evaluated.
#[derive(Clone, Copy, Debug)]
struct Octave {
    /// Features in a radius.
    scale: f64,
    wavelength_m: f64,
    amplitude_m: f64,
    seed: u32,
}

impl Octave {
    /// The amplitude on a grid with samples of this size: 0 where they cannot show the octave.
    fn shown_m(&self, spacing_m: f64) -> f32 {
        let t = ((self.wavelength_m / spacing_m - 2.0) / 2.0).clamp(0.0, 1.0);
        (self.amplitude_m * (t * t * (3.0 - 2.0 * t))) as f32
    }
}

/// Scrambles all bits (the finaliser of SplitMix64, G. Steele and others, 2014).
pub(super) fn scrambled(seed: u64) -> u64 {
    let h = (seed ^ (seed >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let h = (h ^ (h >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    h ^ (h >> 31)
}

/// Unit vectors to some samples, axis by axis.
type Units = [[f64; LANES]; 3];

/// Fractal simplex noise in metres of height. No inputs.
///
/// The sum over octaves of amplitude · n(P / wavelength), P the sample's place on the sphere in
/// metres: no seam at the antimeridian, nothing special at the poles. An octave fades out smoothly
/// where its wavelength falls from 4 to 2 samples of the grid on the ground (the longer side of a
/// sample counts), so coarse levels are low-pass filtered and cost only what they can show.
///
/// Source: F. K. Musgrave in *Texturing and Modeling* (2003), chapters 14 (fractional Brownian
/// motion) and 16 (ridges; without his feedback between octaves).
#[derive(Clone, Debug)]
pub struct Noise {
    planet: Planet,
    params: NoiseParams,
    octaves: Vec<Octave>,
    /// Of the parameters and the sphere.
    name: ContentId,
}

impl Noise {
    /// Numbers that are not finite count as 0 height (`amplitude_m`), 1 km, 2 and ½.
    pub fn new(planet: Planet, params: &NoiseParams) -> Self {
        let sane = |v: f64, default: f64| if v.is_finite() { v } else { default };
        let params = NoiseParams {
            amplitude_m: sane(params.amplitude_m, 0.0).clamp(-1e30, 1e30),
            wavelength_m: sane(params.wavelength_m, 1000.0).max(0.01),
            octaves: params.octaves.min(MAX_OCTAVES),
            lacunarity: sane(params.lacunarity, 2.0).clamp(1.01, 100.0),
            gain: sane(params.gain, 0.5).clamp(0.0, 1.0),
            ..*params
        };
        let (mut wavelength_m, mut amplitude_m) = (params.wavelength_m, params.amplitude_m);
        let mut octaves = Vec::new();
        for octave in 0..params.octaves {
            // Below a centimetre f64 coordinates run out of digits.
            if wavelength_m < 0.01 || amplitude_m == 0.0 {
                break;
            }
            let seed = scrambled(scrambled(params.seed).wrapping_add(u64::from(octave)));
            octaves.push(Octave {
                scale: planet.radius_m / wavelength_m,
                wavelength_m,
                amplitude_m,
                seed: (seed >> 32) as u32,
            });
            wavelength_m /= params.lacunarity;
            amplitude_m *= params.gain;
        }
        let mut name = IdHasher::default();
        name.int(params.seed as i64)
            .int(i64::from(params.octaves))
            .int(i64::from(params.ridged));
        for v in [
            params.amplitude_m,
            params.wavelength_m,
            params.lacunarity,
            params.gain,
            planet.radius_m,
        ] {
            name.float(v);
        }
        Self {
            planet,
            params,
            octaves,
            name: name.finish(),
        }
    }

    /// Adds an octave to heights in metres.
    #[inline(always)]
    fn add_lanes(&self, octave: &Octave, unit: &Units, amplitude_m: &Lanes, height_m: &mut Lanes) {
        let mut noise = [0.0; LANES];
        simplex(unit, octave.scale, octave.seed, &mut noise);
        if self.params.ridged {
            for n in &mut noise {
                *n = 1.0 - 2.0 * n.abs();
            }
        }
        for ((h, n), a) in height_m.iter_mut().zip(&noise).zip(amplitude_m) {
            *h += *a * *n;
        }
    }

    /// [`Self::add_lanes`] on the widest vectors.
    fn add(&self, octave: &Octave, unit: &Units, amplitude_m: &Lanes, height_m: &mut Lanes) {
        on_widest(
            #[inline(always)]
            || self.add_lanes(octave, unit, amplitude_m, height_m),
        );
    }

    fn render_map(&self, job: &Job, out: &mut Block) -> Result<(), RenderError> {
        let Grid { lattice, rect } = job.grid;
        // Not brought into range: beyond a pole the sine of the colatitude is negative, which is the
        // opposite meridian.
        let columns: Vec<(f64, f64)> = (rect.min.x..rect.max.x)
            .map(|x| libm::sincos(lattice.centre(I64Vec2::new(x, 0)).x))
            .collect();
        let mut unit: Units = [[0.0; LANES]; 3];
        for (line, y) in out
            .plane_mut(0)
            .chunks_exact_mut(columns.len().max(1))
            .zip(rect.min.y..)
        {
            if job.cancel.is_cancelled() {
                return Err(RenderError::Cancelled);
            }
            let (sin_colat, cos_colat) = libm::sincos(lattice.centre(I64Vec2::new(0, y)).y);
            let spacing = DVec2::new(lattice.step.x * sin_colat, lattice.step.y)
                .abs()
                .max_element();
            let spacing_m = spacing * self.planet.radius_m;
            unit[2] = [cos_colat; LANES];
            for (line, columns) in line.chunks_mut(LANES).zip(columns.chunks(LANES)) {
                for (l, (sin_lon, cos_lon)) in columns.iter().enumerate() {
                    unit[0][l] = sin_colat * cos_lon;
                    unit[1][l] = sin_colat * sin_lon;
                }
                let mut height_m = [0.0; LANES];
                for octave in &self.octaves {
                    let amplitude_m = octave.shown_m(spacing_m);
                    if amplitude_m != 0.0 {
                        self.add(octave, &unit, &[amplitude_m; LANES], &mut height_m);
                    }
                }
                line.copy_from_slice(&height_m[..line.len()]);
            }
        }
        Ok(())
    }

    fn render_projected(&self, job: &Job, out: &mut Block) -> Result<(), RenderError> {
        let Grid { lattice, rect } = job.grid;
        let ground = Ground::new(lattice, KIND)?;
        let width = out.width().max(1);
        let mut unit: Units = [[0.0; LANES]; 3];
        for (line, y) in out.plane_mut(0).chunks_exact_mut(width).zip(rect.min.y..) {
            if job.cancel.is_cancelled() {
                return Err(RenderError::Cancelled);
            }
            for (line, first) in line.chunks_mut(LANES).zip((rect.min.x..).step_by(LANES)) {
                let mut spacing_m = [f64::INFINITY; LANES];
                let mut height_m = [f32::NAN; LANES];
                for l in 0..line.len() {
                    let sample = I64Vec2::new(first + l as i64, y);
                    let place = ground
                        .point(sample.as_dvec2() + 0.5)
                        .zip(ground.steps_m(&self.planet, sample));
                    if let Some((point, [column, row])) = place {
                        spacing_m[l] = column.length().max(row.length());
                        height_m[l] = 0.0;
                        for (axis, v) in point.to_unit().to_array().into_iter().enumerate() {
                            unit[axis][l] = v;
                        }
                    }
                }
                for octave in &self.octaves {
                    let amplitude_m = spacing_m.map(|spacing_m| octave.shown_m(spacing_m));
                    if amplitude_m.iter().any(|a| *a != 0.0) {
                        self.add(octave, &unit, &amplitude_m, &mut height_m);
                    }
                }
                line.copy_from_slice(&height_m[..line.len()]);
            }
        }
        Ok(())
    }
}

impl ImageNode for Noise {
    fn kind(&self) -> &'static str {
        KIND
    }

    fn version(&self) -> u32 {
        2
    }

    fn output(&self) -> Bands {
        Bands::Height
    }

    fn is_pointwise(&self) -> bool {
        true
    }

    fn identify(&self, grid: &Grid, id: &mut IdHasher) {
        id.id(self.name);
        if grid.lattice.crs != GridCrs::Map {
            id.float(self.planet.equatorial_radius_m)
                .float(self.planet.flattening);
        }
        add_grid(grid, id);
    }

    fn known(&self, grid: &Grid, _inputs: &[Known]) -> Known {
        let nothing = Known::Uniform([0.0; 4]);
        if self.octaves.is_empty() && grid.lattice.crs == GridCrs::Map {
            return nothing;
        }
        if grid.lattice.crs != GridCrs::Map {
            return Known::Nothing;
        }
        // The shortest samples of any row show most.
        let spacing_m = grid.lattice.step.y.abs() * self.planet.radius_m;
        let longest = self
            .octaves
            .first()
            .map_or(0.0, |octave| octave.wavelength_m);
        if longest / spacing_m <= 2.0 {
            nothing
        } else {
            Known::Complete
        }
    }

    fn render(&self, job: &Job, _inputs: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        match job.grid.lattice.crs {
            GridCrs::Map => self.render_map(job, out),
            GridCrs::Projected(_) => self.render_projected(job, out),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use proptest::prelude::*;
    use relievo_planet::{LevelKey, SampleRect};
    use relievo_raster::Cancel;

    use super::*;

    fn params() -> NoiseParams {
        NoiseParams {
            seed: 1,
            amplitude_m: 1000.0,
            wavelength_m: 3e6,
            octaves: 6,
            lacunarity: 2.0,
            gain: 0.5,
            ridged: false,
        }
    }

    fn heights(params: &NoiseParams, level: LevelKey, rect: SampleRect) -> Vec<f32> {
        let mut out = Block::new(Bands::Height, rect.width() as usize, rect.height() as usize);
        let grid = Grid::new(Arc::new(level.lattice()), rect);
        let node = Noise::new(Planet::EARTH, params);
        node.render(
            &Job {
                grid: &grid,
                cancel: &Cancel::default(),
            },
            &[],
            &mut out,
        )
        .unwrap();
        out.samples().to_vec()
    }

    #[test]
    fn there_is_no_seam_at_the_antimeridian_and_no_artefact_at_a_pole() {
        let level = LevelKey::new(3, 2);
        let size = level.samples();
        let west = heights(&params(), level, SampleRect::at(0, 500, 1, 1))[0];
        let east = heights(&params(), level, SampleRect::at(size.x - 1, 500, 1, 1))[0];
        assert!((west - east).abs() < 40.0, "{west} {east}");
        let ring = heights(&params(), level, SampleRect::at(0, 0, size.x, 1));
        let (low, high) = ring
            .iter()
            .fold((f32::MAX, f32::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
        assert!(
            high - low < 80.0,
            "all samples around the pole are near each other: {low} {high}"
        );
    }

    #[test]
    fn octaves_too_fine_for_a_level_are_left_out() {
        let fine = NoiseParams {
            wavelength_m: 1000.0,
            ..params()
        };
        let level = LevelKey::new(1, 0);
        assert!(
            heights(&fine, level, SampleRect::at(0, 0, 9, 9))
                .iter()
                .all(|h| *h == 0.0)
        );
        let grid = Grid::new(Arc::new(level.lattice()), SampleRect::at(0, 0, 9, 9));
        assert_eq!(
            Noise::new(Planet::EARTH, &fine).known(&grid, &[]),
            Known::Uniform([0.0; 4])
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]
        #[test]
        fn any_parameters_give_finite_heights(
            amplitude_m: f64, wavelength_m: f64, lacunarity: f64, gain: f64, octaves in 0..40_u32, ridged: bool,
        ) {
            prop_assume!(amplitude_m.abs() < 1e30);
            let wild = NoiseParams { seed: 3, amplitude_m, wavelength_m, octaves, lacunarity, gain, ridged };
            let all = heights(&wild, LevelKey::new(8, 7), SampleRect::at(100, 3, 4, 4));
            prop_assert!(all.iter().all(|h| h.is_finite()));
        }

        #[test]
        fn heights_stay_within_the_sum_of_amplitudes(seed: u64, x in 0..2000_i64, y in 0..1000_i64, ridged: bool) {
            let all = heights(&NoiseParams { seed, ridged, ..params() }, LevelKey::new(3, 2), SampleRect::at(x, y, 2, 2));
            prop_assert!(all.iter().all(|h| h.abs() <= 2000.0));
        }
    }
}
