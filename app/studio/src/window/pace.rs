//! How finely the picture is drawn while it moves: on a slow adapter fewer pixels at a steady pace
//! beat all pixels at a few frames a second. At rest every pixel is drawn.

/// What a frame in motion may take on the adapter where nothing else is said, milliseconds.
const BUDGET_MS: f64 = 33.0;

/// Part of the budget that a finer picture must fit in before it is tried, so that the size does
/// not flutter.
const HEADROOM: f64 = 0.8;

/// Linear scales of the picture, finest first.
const SCALES: [f64; 5] = [1.0, 0.75, 0.5, 0.375, 0.25];

/// For so long after the last motion the picture stays as it is, seconds: a hand that pauses
/// between two pulls sees no change.
pub(crate) const REST_S: f64 = 0.25;

/// Weight of the newest frame in the running cost.
const NEWEST: f64 = 0.3;

/// Chooses the scale of the picture from what frames cost. Costs are taken to grow with the number
/// of pixels, which holds where fragments decide.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Pace {
    step: usize,
    ms_per_pixel: Option<f64>,
    moved_s: Option<f64>,
    rests: bool,
    allowed_ms: Option<f64>,
}

impl Pace {
    /// What a frame in motion may take from now on, milliseconds; `None`: as usual.
    pub(crate) fn allow(&mut self, budget_ms: Option<f64>) {
        self.allowed_ms = budget_ms;
    }

    /// What the latest drawn frame cost.
    pub(crate) fn measured(&mut self, gpu_ms: f64, pixels: f64) {
        if !(gpu_ms.is_finite() && gpu_ms > 0.0 && pixels >= 1.0) {
            return;
        }
        let new = gpu_ms / pixels;
        let old = self.ms_per_pixel.unwrap_or(new);
        self.ms_per_pixel = Some(old + (new - old) * NEWEST);
    }

    /// Size in pixels of the next frame, at least 1, for a view of `full_px`. `now_s` never goes
    /// back; `moving` while the camera or a slider moves.
    pub(crate) fn size_px(&mut self, full_px: [u32; 2], now_s: f64, moving: bool) -> [u32; 2] {
        if moving {
            self.moved_s = Some(now_s);
        }
        let rests = self.moved_s.is_none_or(|moved| now_s - moved >= REST_S);
        self.rests = rests;
        if rests {
            self.step = 0;
        } else if moving {
            self.step = self.step_for(full_px);
        }
        let scale = SCALES[self.step];
        full_px.map(|s| ((f64::from(s) * scale).round() as u32).max(1))
    }

    /// Whether the latest size was for a picture at rest.
    pub(crate) fn rests(&self) -> bool {
        self.rests
    }

    fn step_for(&self, full_px: [u32; 2]) -> usize {
        let Some(ms_per_pixel) = self.ms_per_pixel else {
            return self.step;
        };
        let full_ms = ms_per_pixel * full_px.iter().map(|s| f64::from(*s)).product::<f64>();
        let fits = |budget_ms: f64| {
            SCALES
                .iter()
                .position(|scale| full_ms * scale * scale <= budget_ms)
                .unwrap_or(SCALES.len() - 1)
        };
        // Coarser at once, finer only with room to spare.
        let budget_ms = self.allowed_ms.unwrap_or(BUDGET_MS);
        let needed = fits(budget_ms);
        if needed >= self.step {
            needed
        } else {
            fits(budget_ms * HEADROOM).min(self.step)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FULL: [u32; 2] = [1200, 900];

    /// Frames of an adapter that takes `full_ms` for a whole picture; sizes of the last ones.
    fn run(pace: &mut Pace, full_ms: f64, from_s: f64, frames: u32) -> Vec<[u32; 2]> {
        (0..frames)
            .map(|k| {
                let size = pace.size_px(FULL, from_s + f64::from(k) * 0.03, true);
                let pixels = f64::from(size[0]) * f64::from(size[1]);
                pace.measured(full_ms * pixels / 1_080_000.0, pixels);
                size
            })
            .collect()
    }

    #[test]
    fn a_fast_adapter_always_draws_every_pixel() {
        let sizes = run(&mut Pace::default(), 5.0, 0.0, 50);
        assert!(sizes.iter().all(|s| *s == FULL));
    }

    #[test]
    fn a_slow_adapter_moves_at_the_budget_and_rests_in_full() {
        let mut pace = Pace::default();
        let sizes = run(&mut pace, 120.0, 0.0, 50);
        assert_eq!(sizes[49], [600, 450]);
        assert!(!pace.rests());
        assert_eq!(pace.size_px(FULL, 1.6, false), [600, 450], "a pause");
        assert_eq!(pace.size_px(FULL, 1.5 + 0.3, false), FULL, "a rest");
    }

    #[test]
    fn more_is_drawn_where_more_time_is_allowed() {
        let mut pace = Pace::default();
        pace.allow(Some(200.0));
        let sizes = run(&mut pace, 120.0, 0.0, 50);
        assert_eq!(sizes[49], FULL);
        pace.allow(Some(10.0));
        let sizes = run(&mut pace, 120.0, 2.0, 50);
        assert_eq!(sizes[49], [300, 225]);
    }

    #[test]
    fn the_size_settles_whatever_the_cost() {
        for full_ms in [1.0, 33.0, 34.0, 41.0, 58.0, 60.0, 131.0, 132.5, 500.0, 1e6] {
            let mut pace = Pace::default();
            run(&mut pace, full_ms, 0.0, 30);
            let sizes = run(&mut pace, full_ms, 1.0, 30);
            assert!(sizes.iter().all(|s| *s == sizes[0]), "{full_ms}: {sizes:?}");
        }
    }

    #[test]
    fn what_is_no_cost_changes_nothing() {
        let mut pace = Pace::default();
        for (ms, pixels) in [(f64::NAN, 1e6), (0.0, 1e6), (-1.0, 1e6), (5.0, 0.0)] {
            pace.measured(ms, pixels);
        }
        assert_eq!(pace.size_px(FULL, 0.0, true), FULL);
        assert_eq!(pace.size_px([1, 0], 0.0, true), [1, 1]);
    }
}
