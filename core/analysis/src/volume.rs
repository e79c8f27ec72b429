//! Volumes and areas between two surfaces, each with its discretisation error.

mod patch;

use glam::DVec2;
use relievo_planet::{Grid, Planet};

use crate::frame::LocalFrame;
use crate::ground::{AnalysisError, Ground, Watch};
use crate::parallel;

use patch::{CELLS, Patch, Place, Sums};

/// Two grounds of one planet, before and after.
pub trait Change: Sync {
    /// The planet's figure.
    fn planet(&self) -> Planet;

    /// Whether both are known, without evaluating them, to be equal on all samples of a grid.
    fn same(&self, grid: &Grid) -> bool;

    /// Heights before and after in metres, each in the order of [`Ground::heights`], NaN where there
    /// are none.
    ///
    /// # Errors
    /// As [`Ground::heights`].
    fn heights(&self, grid: &Grid) -> Result<(Vec<f64>, Vec<f64>), AnalysisError>;
}

/// Two grounds that know nothing of each other.
#[derive(Clone, Copy)]
pub struct Between<'a> {
    /// The ground before.
    pub before: &'a dyn Ground,
    /// The ground after.
    pub after: &'a dyn Ground,
}

impl Change for Between<'_> {
    fn planet(&self) -> Planet {
        self.before.planet()
    }

    fn same(&self, _grid: &Grid) -> bool {
        false
    }

    fn heights(&self, grid: &Grid) -> Result<(Vec<f64>, Vec<f64>), AnalysisError> {
        let exact = |heights: Vec<f32>| heights.into_iter().map(f64::from).collect();
        Ok((
            exact(self.before.heights(grid)?),
            exact(self.after.heights(grid)?),
        ))
    }
}

/// The rectangle of a local frame in which a change is measured.
#[derive(Clone, Debug)]
pub struct Region {
    /// The frame; near the rectangle, at best at its centre.
    pub frame: LocalFrame,
    /// South-western corner in metres of the frame.
    pub min_m: DVec2,
    /// North-eastern corner in metres of the frame.
    pub max_m: DVec2,
}

/// How finely a change is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeSettings {
    /// Metres between samples to begin with, positive: the spacing of the data, or less where
    /// elements are narrower.
    pub spacing_m: f64,
    /// Share of cut and fill, and of the area, that their errors should not exceed; spacings are
    /// halved where they are largest until then. 0 halves until `max_samples`.
    pub tolerance: f64,
    /// Most samples that are evaluated.
    pub max_samples: u64,
    /// A place counts as changed where heights differ by more than so many metres.
    pub differs_m: f64,
    /// Threads to work on.
    pub threads: usize,
}

impl VolumeSettings {
    /// From a spacing on: within a thousandth, at most 2²³ samples, changes above 1 mm, one thread.
    pub fn from_spacing(spacing_m: f64) -> Self {
        Self {
            spacing_m,
            tolerance: 1e-3,
            max_samples: 1 << 23,
            differs_m: 1e-3,
            threads: 1,
        }
    }
}

/// A measured quantity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Amount {
    /// Its value.
    pub value: f64,
    /// What discretisation may have cost: the true value lies within so much of it as soon as halving
    /// the spacing at least halves the error.
    pub error: f64,
}

/// What a change comes to. Areas and volumes are those on the ellipsoid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Volumes {
    /// Ground taken away in cubic metres, positive.
    pub cut_m3: Amount,
    /// Ground put on in cubic metres, positive.
    pub fill_m3: Amount,
    /// Fill minus cut in cubic metres.
    pub net_m3: Amount,
    /// Area that changes, seen from above, in square metres.
    pub plan_area_m2: Amount,
    /// Area of the surface after, where it changes, in square metres.
    pub surface_area_m2: Amount,
    /// Deepest cut in metres, positive.
    pub highest_cut_m: Amount,
    /// Highest fill in metres.
    pub highest_fill_m: Amount,
    /// Mean angle of the surface after against the horizontal, where it changes, in degrees.
    pub mean_slope_deg: Amount,
    /// Samples that were evaluated.
    pub samples: u64,
    /// Finest spacing of samples in metres.
    pub finest_m: f64,
}

impl Amount {
    fn and(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            error: self.error + other.error,
        }
    }

    /// The larger one, as large as either may be.
    fn or(self, other: Self) -> Self {
        let value = self.value.max(other.value);
        let bound = (self.value + self.error).max(other.value + other.error);
        Self {
            value,
            error: bound - value,
        }
    }
}

impl Volumes {
    /// What two changes of disjoint regions come to together.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        let plan_area_m2 = self.plan_area_m2.and(other.plan_area_m2);
        let weighted = |amount: fn(&Self) -> f64| {
            let sum =
                amount(self) * self.plan_area_m2.value + amount(other) * other.plan_area_m2.value;
            if plan_area_m2.value > 0.0 {
                sum / plan_area_m2.value
            } else {
                0.0
            }
        };
        Self {
            cut_m3: self.cut_m3.and(other.cut_m3),
            fill_m3: self.fill_m3.and(other.fill_m3),
            net_m3: self.net_m3.and(other.net_m3),
            plan_area_m2,
            surface_area_m2: self.surface_area_m2.and(other.surface_area_m2),
            highest_cut_m: self.highest_cut_m.or(other.highest_cut_m),
            highest_fill_m: self.highest_fill_m.or(other.highest_fill_m),
            mean_slope_deg: Amount {
                value: weighted(|v| v.mean_slope_deg.value),
                error: weighted(|v| v.mean_slope_deg.error),
            },
            samples: self.samples + other.samples,
            finest_m: if self.samples == 0 {
                other.finest_m
            } else {
                self.finest_m.min(other.finest_m)
            },
        }
    }
}

/// Measures what changes between two grounds inside a region.
///
/// The region is tiled by patches of 32² cells; those that are known to be equal cost nothing. In
/// a cell both surfaces are four triangles around its centre, over which cut and fill are integrated
/// exactly, so where surfaces are continuous errors fall with the square of the spacing, at walls with
/// the spacing. Each patch is summed at its spacing and at twice as much. The stated error is the sum of
/// the differences' magnitudes over all patches (Richardson's estimate without dividing by 2ᵖ − 1, so that
/// it holds for p = 1 too), plus what cells leave open that have changed in part, through which the edge
/// of the change runs somewhere (half their area, a quarter of their volume), plus the rounding of
/// single-precision heights. Patches with the largest errors are halved until the tolerance is met or
/// the samples are spent. What is smaller than the first spacing and lies between its samples is not
/// found.
///
/// The same for any number of threads.
///
/// # Errors
/// [`AnalysisError`]; `Refused` for an empty region, settings out of range, or a region that needs more
/// samples than allowed at the spacing to begin with.
pub fn volumes(
    change: &dyn Change,
    region: &Region,
    settings: &VolumeSettings,
    watch: &dyn Watch,
) -> Result<Volumes, AnalysisError> {
    check(region, settings)?;
    let mut work = Work {
        change,
        region,
        settings,
        watch,
        samples: 0,
        patches: Vec::new(),
    };
    let places = work.first_places()?;
    work.evaluate(&places)?;
    while let Some(chosen) = work.worst() {
        let places: Vec<Place> = chosen
            .iter()
            .flat_map(|index| work.patches[*index].place.quarters())
            .collect();
        // From the back, so that indices stay right.
        for index in chosen.iter().rev() {
            work.patches.remove(*index);
        }
        work.evaluate(&places)?;
    }
    watch.progress(1.0);
    Ok(work.total())
}

fn check(region: &Region, settings: &VolumeSettings) -> Result<(), AnalysisError> {
    let refused = |text: String| Err(AnalysisError::Refused(text));
    let size_m = region.max_m - region.min_m;
    if !(size_m.is_finite() && size_m.cmpgt(DVec2::ZERO).all() && region.min_m.is_finite()) {
        return refused(format!(
            "expected a region with a finite extent, found {} × {} m",
            size_m.x, size_m.y
        ));
    }
    let positive = |value: f64| value.is_finite() && value > 0.0;
    if !positive(settings.spacing_m)
        || settings.tolerance.is_nan()
        || settings.tolerance < 0.0
        || settings.differs_m.is_nan()
        || settings.differs_m < 0.0
    {
        return refused(format!(
            "expected a positive spacing in metres and a tolerance of at least 0, found {} and {}",
            settings.spacing_m, settings.tolerance
        ));
    }
    Ok(())
}

struct Work<'a> {
    change: &'a dyn Change,
    region: &'a Region,
    settings: &'a VolumeSettings,
    watch: &'a dyn Watch,
    samples: u64,
    patches: Vec<Patch>,
}

impl Work<'_> {
    /// Patches of the first spacing that may have changed.
    fn first_places(&self) -> Result<Vec<Place>, AnalysisError> {
        let size_m = (self.region.max_m - self.region.min_m).max_element();
        let patch_m = self.settings.spacing_m * CELLS as f64;
        let doublings = libm::ceil(libm::log2((size_m / patch_m).max(1.0))).clamp(0.0, 40.0);
        let most = (self.settings.max_samples / Place::SAMPLES).max(1) as usize;
        let too_many = |found: usize| {
            AnalysisError::Refused(format!(
                "expected an area of at most {} samples {} m apart, found at least {}",
                self.settings.max_samples,
                self.settings.spacing_m,
                found as u64 * Place::SAMPLES
            ))
        };
        let corner_m = DVec2::new(self.region.min_m.x, self.region.max_m.y);
        let mut places = vec![Place::new(
            corner_m,
            self.settings.spacing_m * libm::exp2(doublings),
        )];
        for _ in 0..=doublings as u32 {
            let mut kept = Vec::new();
            for place in places {
                crate::ground::go_on(self.watch)?;
                let grid = place.grid(&self.region.frame);
                if place.overlaps(self.region.min_m, self.region.max_m) && !self.change.same(&grid)
                {
                    kept.push(place);
                }
            }
            if kept.len() > most {
                return Err(too_many(kept.len()));
            }
            if kept
                .first()
                .is_none_or(|p| p.spacing_m <= self.settings.spacing_m * 1.000_001)
            {
                return Ok(kept);
            }
            places = kept.iter().flat_map(Place::quarters).collect();
        }
        Ok(places)
    }

    fn evaluate(&mut self, places: &[Place]) -> Result<(), AnalysisError> {
        let before = self.samples;
        let most = self.settings.max_samples.max(1) as f64;
        let done = |finished: usize| {
            let samples = before + finished as u64 * Place::SAMPLES;
            self.watch.progress((samples as f64 / most).min(0.99));
        };
        let patches = parallel::map(
            places.len(),
            self.settings.threads,
            self.watch,
            &done,
            &|index| {
                Patch::evaluate(
                    self.change,
                    self.region,
                    places[index],
                    self.settings.differs_m,
                )
            },
        )?;
        self.samples += places.len() as u64 * Place::SAMPLES;
        self.patches.extend(patches);
        Ok(())
    }

    /// Indices, rising, of the patches that are halved next; `None` when it is enough.
    fn worst(&self) -> Option<Vec<usize>> {
        let mut sums = Sums::default();
        let mut errors = Sums::default();
        for patch in &self.patches {
            sums.add(&patch.fine);
            errors.add(&patch.error);
        }
        let volume_m3 = (sums.cut_m3 + sums.fill_m3).max(f64::MIN_POSITIVE);
        let area_m2 = sums.plan_m2.max(f64::MIN_POSITIVE);
        let share = |e: &Sums| (e.cut_m3 + e.fill_m3) / volume_m3 + e.plan_m2 / area_m2;
        let total = share(&errors);
        let enough = (errors.cut_m3 + errors.fill_m3) <= self.settings.tolerance * volume_m3
            && errors.plan_m2 <= self.settings.tolerance * area_m2;
        let affordable =
            (self.settings.max_samples.saturating_sub(self.samples)) / (4 * Place::SAMPLES);
        if enough || total == 0.0 || affordable == 0 {
            return None;
        }
        let mut order: Vec<(f64, usize)> = self
            .patches
            .iter()
            .enumerate()
            .filter(|(_, p)| p.place.spacing_m > FINEST_M)
            .map(|(i, p)| (share(&p.error), i))
            .filter(|(error, _)| *error > 0.0)
            .collect();
        order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        // Those that hold half of the error.
        let mut chosen = Vec::new();
        let mut covered = 0.0;
        for (error, index) in order {
            if covered > 0.5 * total || chosen.len() as u64 >= affordable {
                break;
            }
            covered += error;
            chosen.push(index);
        }
        chosen.sort_unstable();
        (!chosen.is_empty()).then_some(chosen)
    }

    fn total(&self) -> Volumes {
        let mut sums = Sums::default();
        let mut errors = Sums::default();
        let mut highest = [Amount::default(); 2];
        let (mut bounds, mut rounding_m3) = ([0.0_f64; 2], 0.0);
        let mut finest_m = self.settings.spacing_m;
        for patch in &self.patches {
            sums.add(&patch.fine);
            errors.add(&patch.error);
            rounding_m3 += patch.rounding_m * patch.fine.plan_m2;
            for side in 0..2 {
                highest[side].value = highest[side].value.max(patch.highest_m[side]);
                bounds[side] = bounds[side].max(patch.highest_bound_m[side]);
            }
            finest_m = finest_m.min(patch.place.spacing_m);
        }
        for side in 0..2 {
            highest[side].error = bounds[side] - highest[side].value;
        }
        let amount = |value: f64, error: f64| Amount { value, error };
        let mean_rad = if sums.plan_m2 > 0.0 {
            sums.slope_rad_m2 / sums.plan_m2
        } else {
            0.0
        };
        let mean_error_rad = if sums.plan_m2 > 0.0 {
            (errors.slope_rad_m2 + mean_rad * errors.plan_m2) / sums.plan_m2
        } else {
            0.0
        };
        Volumes {
            cut_m3: amount(sums.cut_m3, errors.cut_m3 + rounding_m3),
            fill_m3: amount(sums.fill_m3, errors.fill_m3 + rounding_m3),
            net_m3: amount(sums.fill_m3 - sums.cut_m3, errors.net_m3 + rounding_m3),
            plan_area_m2: amount(sums.plan_m2, errors.plan_m2),
            surface_area_m2: amount(sums.surface_m2, errors.surface_m2),
            highest_cut_m: highest[0],
            highest_fill_m: highest[1],
            mean_slope_deg: amount(mean_rad.to_degrees(), mean_error_rad.to_degrees()),
            samples: self.samples,
            finest_m,
        }
    }
}

/// Spacing in metres below which nothing is halved: heights are not known as finely.
const FINEST_M: f64 = 1e-3;
