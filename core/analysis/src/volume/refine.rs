//! Patches over an area, halved where their errors are largest.

use glam::DVec2;

use super::patch::{CELLS, Patch, Place, Sums};
use super::{Amount, Change, VolumeSettings, Volumes};
use crate::ground::{AnalysisError, Watch, go_on};
use crate::map_box::MapBox;
use crate::parallel;

/// Spacing in metres below which nothing is halved: heights are not known as finely.
const FINEST_M: f64 = 1e-3;

/// Patches that are always allowed to begin with.
const LEAST: u64 = 4;

/// Measures an area as finely as the settings ask for.
pub(super) fn refined(
    change: &dyn Change,
    area: &MapBox,
    settings: &VolumeSettings,
    watch: &dyn Watch,
) -> Result<Volumes, AnalysisError> {
    let mut work = Work {
        change,
        settings,
        watch,
        samples: 0,
        patches: Vec::new(),
    };
    let places = work.first_places(area)?;
    work.evaluate(&places)?;
    while let Some(chosen) = work.worst() {
        let planet = change.planet();
        let parts = |index: &usize| work.patches[*index].place.parts(&planet);
        let places: Vec<Place> = chosen.iter().flat_map(parts).collect();
        let (mut chosen, mut index) = (chosen.into_iter().peekable(), 0);
        work.patches.retain(|_| {
            index += 1;
            chosen.next_if_eq(&(index - 1)).is_none()
        });
        work.evaluate(&places)?;
    }
    Ok(work.total())
}

struct Work<'a> {
    change: &'a dyn Change,
    settings: &'a VolumeSettings,
    watch: &'a dyn Watch,
    samples: u64,
    patches: Vec<Patch>,
}

impl Work<'_> {
    /// Patches of the first spacings that may have changed; together they fill the area.
    fn first_places(&self, area: &MapBox) -> Result<Vec<Place>, AnalysisError> {
        let planet = self.change.planet();
        let spacing_m = self.settings.spacing_m.max(FINEST_M);
        // The rest is for where errors turn out to be large.
        let first = (self.settings.max_samples / 4).max(LEAST * Place::SAMPLES);
        let most = (first / Place::SAMPLES) as usize;
        let corner = DVec2::new(area.west_rad, area.north_colat_rad);
        let size = DVec2::new(area.width_rad(), area.south_colat_rad - corner.y);
        let mut places = vec![Place::new(&planet, corner, size / CELLS as f64)];
        let mut found = Vec::new();
        while !places.is_empty() {
            let mut coarse = Vec::new();
            for place in places {
                go_on(self.watch)?;
                if self.change.same(&place.grid()) {
                    continue;
                }
                let side_m = place.spacing_m.max_element();
                let narrow_m = || self.change.spacing_m(&place.area()).max(FINEST_M);
                if side_m <= spacing_m && side_m <= narrow_m() {
                    found.push(place);
                } else {
                    coarse.push(place);
                }
            }
            if found.len() + coarse.len() > most {
                return Err(AnalysisError::Refused(format!(
                    "expected an area of at most {first} samples to begin with at {spacing_m} m or less, found at least {}",
                    (found.len() + coarse.len()) as u64 * Place::SAMPLES
                )));
            }
            places = coarse.iter().flat_map(|p| p.parts(&planet)).collect();
        }
        Ok(found)
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
            &|index| Patch::evaluate(self.change, places[index], self.settings.differs_m),
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
            .filter(|(_, p)| p.place.spacing_m.max_element() > FINEST_M)
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
            finest_m = finest_m.min(patch.place.spacing_m.max_element());
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
