//! Which setting of the measured front draws the picture: the cheapest that is true enough, or the
//! truest that is fast enough on this adapter.
//!
//! How long a setting takes here is its cost on the machine that measured the front, times what frames
//! here took beside it. What one setting took against what was expected of it is remembered, so that a
//! setting that turned out too slow is not tried again while frames take what they took.

use std::collections::VecDeque;

use relievo_gpu::{FrameTime, Front, Setting};

/// Frames whose median counts.
const FRAMES: usize = 15;

/// Frames after which a setting is judged.
const ENOUGH: usize = 9;

/// Frames after a change that are not its own: measured before, or waiting for a pipeline.
const NOT_YET: u32 = 3;

/// A setting that takes so many times as long as it may is given up.
const OVER: f64 = 1.05;

/// A truer setting is taken when it may take so many times as long as it should.
const ROOM: f64 = 1.25;

/// A truer setting that is not the next one is taken only if it should take at most so many times as
/// long as the present one: the farther it is, the less is known of it.
const LEAP: f64 = 4.0;

/// Frames that take so many times as long, or as short, as when the setting was judged are of another
/// scene or another load: what was learned before says nothing of it.
const CHANGED: f64 = 1.5;

/// Most that one setting's time may differ from what the front says.
const MOST_LEARNED: f64 = 8.0;

/// What is wished for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Wish {
    /// What suits the adapter, with settings beside the front.
    Adapter,
    /// At most so many pixels of error.
    ErrorPx(f64),
    /// At most so many milliseconds a frame.
    FrameMs(f64),
}

/// When a setting may be changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Occasion {
    /// Something is being dragged: not now.
    Dragged,
    /// The picture moves: only to a cheaper one, which is quick to make and needed now.
    Moving,
    /// Nothing moves.
    Still,
}

/// Chooses settings.
#[derive(Clone, Debug)]
pub(crate) struct Governor {
    front: &'static Front,
    wish: Wish,
    /// The setting that draws; `None` beside the front.
    at: Option<usize>,
    /// What draws while it is beside the front is like this setting.
    like: usize,
    /// Milliseconds of the latest frames, as of a whole picture, and whether they were of one.
    times_ms: VecDeque<(f64, bool)>,
    latest: Option<FrameTime>,
    /// What it would have taken for a whole picture.
    latest_ms: Option<f64>,
    not_yet: u32,
    /// Milliseconds here for one of cost.
    scale: Option<f64>,
    /// How many times as long as by its cost each setting takes here.
    learned: Vec<f64>,
    /// The setting before the present one, and what the present one should take.
    expected: Option<(usize, f64)>,
    /// What it took when it was judged.
    judged_ms: Option<f64>,
}

impl Governor {
    /// One that has measured nothing.
    pub(crate) fn new(front: &'static Front) -> Self {
        Self {
            front,
            wish: Wish::Adapter,
            at: None,
            like: 0,
            times_ms: VecDeque::new(),
            latest: None,
            latest_ms: None,
            not_yet: 0,
            scale: None,
            learned: vec![1.0; front.points().len()],
            expected: None,
            judged_ms: None,
        }
    }

    /// The front it chooses from.
    pub(crate) fn front(&self) -> &'static Front {
        self.front
    }

    /// What is wished for.
    pub(crate) fn wish(&self) -> Wish {
        self.wish
    }

    /// The setting that draws; `None` where the adapter's own does.
    pub(crate) fn setting(&self) -> Option<&'static Setting> {
        self.at.map(|i| &self.front.points()[i].setting)
    }

    /// Index on the front of the setting that draws, or of the one that is like it.
    pub(crate) fn index(&self) -> usize {
        self.at.unwrap_or(self.like)
    }

    /// Whether the setting that draws is on the front.
    pub(crate) fn is_on_front(&self) -> bool {
        self.at.is_some()
    }

    /// What the latest frame took, or would have taken for all pixels, milliseconds.
    pub(crate) fn latest_ms(&self) -> Option<f64> {
        self.latest_ms
    }

    /// What a picture of all pixels took lately, milliseconds.
    pub(crate) fn measured_ms(&self) -> Option<f64> {
        // Few pixels say less: triangles take the same time for them.
        let whole = self.times_ms.iter().filter(|(_, whole)| *whole);
        if whole.clone().count() >= ENOUGH {
            median(whole)
        } else {
            median(self.times_ms.iter())
        }
    }

    /// What each setting should take here, milliseconds; `None` while no frame was measured.
    pub(crate) fn estimate_ms(&self, setting: usize) -> Option<f64> {
        Some(self.scale? * self.cost(setting))
    }

    /// What a frame may take before fewer pixels are drawn; `None` where nothing is said of it.
    pub(crate) fn budget_ms(&self) -> Option<f64> {
        match self.wish {
            // While there is a cheaper setting, that is the better answer.
            Wish::FrameMs(ms) if self.at.is_some_and(|at| at > 0) => Some(2.0 * ms),
            Wish::FrameMs(ms) => Some(ms),
            Wish::Adapter | Wish::ErrorPx(_) => None,
        }
    }

    /// Takes in the latest measured frame, if it is new; a whole picture has `whole_px` pixels.
    pub(crate) fn measured(&mut self, frame: FrameTime, whole_px: f64) {
        let is_new = self.latest.is_none_or(|l| l.number != frame.number);
        let pixels = frame.pixels as f64;
        let whole_ms = frame.gpu_ms * whole_px / pixels;
        if !(is_new && whole_ms.is_finite() && whole_ms > 0.0) {
            return;
        }
        self.latest = Some(frame);
        self.latest_ms = Some(whole_ms);
        if self.not_yet > 0 {
            self.not_yet -= 1;
            return;
        }
        let whole = (pixels / whole_px - 1.0).abs() < 0.01;
        if self.times_ms.len() == FRAMES {
            self.times_ms.pop_front();
        }
        self.times_ms.push_back((whole_ms, whole));
        self.judge();
    }

    /// Follows a wish; `like`: the setting that is like the adapter's own.
    pub(crate) fn follow(&mut self, wish: Wish, like: usize, occasion: Occasion) {
        if occasion == Occasion::Dragged {
            return;
        }
        self.like = like.min(self.learned.len() - 1);
        if wish != self.wish {
            self.wish = wish;
            self.learned.fill(1.0);
            self.expected = None;
            self.judge();
        }
        match wish {
            Wish::Adapter => self.turn_to(None),
            Wish::ErrorPx(error_px) => self.turn_to(Some(self.front.cheapest_within(error_px))),
            Wish::FrameMs(ms) => {
                let at = self.index();
                self.turn_to(Some(at));
                if let Some(better) = self.better(at, ms)
                    && (occasion == Occasion::Still || better < at)
                {
                    self.turn_to(Some(better));
                }
            }
        }
    }

    /// A setting that keeps to a time better than the present one, or uses it better.
    fn better(&self, at: usize, allowed_ms: f64) -> Option<usize> {
        let ms = self
            .measured_ms()
            .filter(|_| self.times_ms.len() >= ENOUGH)?;
        let expected_ms = |i: usize| ms * self.cost(i) / self.cost(at);
        if ms > allowed_ms * OVER {
            let cheaper = self
                .front
                .truest_that(|i| i < at && expected_ms(i) <= allowed_ms);
            return (cheaper < at).then_some(cheaper);
        }
        let truer = self.front.truest_that(|i| {
            let near = i == at + 1 || expected_ms(i) <= LEAP * ms;
            i > at && near && expected_ms(i) * ROOM <= allowed_ms
        });
        (truer > at).then_some(truer)
    }

    /// Takes in what the present setting takes.
    fn judge(&mut self) {
        let Some(ms) = self.measured_ms() else {
            return;
        };
        if self.times_ms.len() >= ENOUGH {
            self.learn(ms);
        }
        self.scale = Some(ms / self.cost(self.index()));
    }

    fn learn(&mut self, ms: f64) {
        if let (Some((before, expected_ms)), Some(at)) = (self.expected.take(), self.at) {
            // Settings still farther from the one before are beside the present one as they were.
            let beyond = if before < at {
                at..self.learned.len()
            } else {
                0..at + 1
            };
            for learned in &mut self.learned[beyond] {
                *learned = (*learned * ms / expected_ms).clamp(1.0 / MOST_LEARNED, MOST_LEARNED);
            }
            self.judged_ms = Some(ms);
        }
        let judged_ms = *self.judged_ms.get_or_insert(ms);
        if ms > judged_ms * CHANGED || ms * CHANGED < judged_ms {
            self.learned.fill(1.0);
            self.judged_ms = Some(ms);
        }
    }

    fn turn_to(&mut self, at: Option<usize>) {
        if at == self.at {
            return;
        }
        // What is beside the front is only like a setting of it.
        self.expected = self.at.zip(at).and_then(|(before, next)| {
            let expected_ms = self.estimate_ms(next)?;
            Some((before, expected_ms))
        });
        self.at = at;
        self.times_ms.clear();
        self.not_yet = NOT_YET;
        self.judged_ms = None;
    }

    fn cost(&self, setting: usize) -> f64 {
        self.front.points()[setting].frame_ms * self.learned[setting]
    }
}

fn median<'a>(times: impl Iterator<Item = &'a (f64, bool)>) -> Option<f64> {
    let mut sorted: Vec<f64> = times.map(|(ms, _)| *ms).collect();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use std::sync::LazyLock;

    use proptest::prelude::*;
    use relievo_gpu::quality::front::COLUMNS;

    use super::*;

    const PIXELS: u64 = 1_000_000;

    /// A front on which each setting costs 1.4 times as much as the one before.
    fn front() -> &'static Front {
        static FRONT: LazyLock<Front> = LazyLock::new(|| {
            let rows = (0..10).map(|k| {
                let (error_px, frame_ms) = (6.0 / 1.5_f64.powi(k), 5.0 * 1.4_f64.powi(k));
                format!("64,{},2,1,8,{error_px},{frame_ms}", 8 + k)
            });
            let text = COLUMNS.join(",") + "\n" + &rows.collect::<Vec<_>>().join("\n");
            Front::parse(&text).unwrap()
        });
        &FRONT
    }

    /// An adapter on which settings take other times than the front says.
    struct Adapter {
        factor: f64,
        /// Milliseconds that every setting takes.
        fixed_ms: f64,
        /// Share by which a frame may differ.
        noise: f64,
        frames: u64,
    }

    impl Adapter {
        fn ms(&self, setting: usize) -> f64 {
            self.fixed_ms + self.factor * front().points()[setting].frame_ms
        }

        /// Draws frames; the settings that drew them.
        fn run(&mut self, governor: &mut Governor, wish: Wish, frames: u32) -> Vec<usize> {
            (0..frames)
                .map(|_| {
                    governor.follow(wish, 0, Occasion::Still);
                    let at = governor.index();
                    let hash = self.frames.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40;
                    let even = hash as f64 / f64::from(1 << 24) * 2.0 - 1.0;
                    // One frame in fifty waits for something else.
                    let hiccup = if self.frames % 50 == 17 { 10.0 } else { 1.0 };
                    let frame = FrameTime {
                        gpu_ms: self.ms(at) * (1.0 + self.noise * even) * hiccup,
                        pixels: PIXELS,
                        number: self.frames,
                    };
                    self.frames += 1;
                    governor.measured(frame, PIXELS as f64);
                    at
                })
                .collect()
        }

        fn new(factor: f64, fixed_ms: f64, noise: f64) -> Self {
            Self {
                factor,
                fixed_ms,
                noise,
                frames: 0,
            }
        }
    }

    fn changes(settings: &[usize]) -> usize {
        settings.windows(2).filter(|w| w[0] != w[1]).count()
    }

    fn governor() -> Governor {
        Governor::new(front())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn whatever_the_adapter_and_the_wish_the_setting_settles_and_fits(
            factor in 0.01..10.0_f64, fixed_ms in 0.0..10.0_f64, wish_ms in 1.0..200.0_f64, noise in 0.0..0.2_f64,
        ) {
            let mut adapter = Adapter::new(factor, fixed_ms, noise);
            let mut governor = governor();
            let wish = Wish::FrameMs(wish_ms);
            adapter.run(&mut governor, wish, 400);
            let settled = adapter.run(&mut governor, wish, 1000);
            prop_assert!(changes(&settled) <= 1, "{} changes", changes(&settled));
            let at = governor.index();
            // It keeps to the wish as far as anything does, but for the noise of a median.
            prop_assert!(at == 0 || adapter.ms(at) <= wish_ms * OVER * 1.15, "{at}: {}", adapter.ms(at));
        }

        #[test]
        fn no_truer_setting_has_room_to_spare(factor in 0.01..10.0_f64, wish_ms in 1.0..200.0_f64) {
            let mut adapter = Adapter::new(factor, 0.0, 0.0);
            let mut governor = governor();
            adapter.run(&mut governor, Wish::FrameMs(wish_ms), 400);
            let at = governor.index();
            let last = front().points().len() - 1;
            prop_assert!(at == last || adapter.ms(at + 1) * ROOM > wish_ms * 0.999);
            prop_assert!(at == 0 || adapter.ms(at) <= wish_ms * OVER);
        }

        #[test]
        fn the_cheapest_that_is_true_enough_needs_no_frame_to_be_found(error_px in 1e-3..100.0_f64) {
            let mut governor = governor();
            governor.follow(Wish::ErrorPx(error_px), 0, Occasion::Still);
            prop_assert_eq!(governor.index(), front().cheapest_within(error_px));
            prop_assert!(governor.setting().is_some());
        }
    }

    #[test]
    fn a_sudden_slow_down_is_followed_and_forgotten() {
        let mut adapter = Adapter::new(0.3, 0.5, 0.1);
        let mut governor = governor();
        let wish = Wish::FrameMs(12.0);
        adapter.run(&mut governor, wish, 400);
        let before = governor.index();
        adapter.factor = 1.2;
        let slow = adapter.run(&mut governor, wish, 400);
        assert!(governor.index() < before);
        assert!(changes(&slow) <= 4, "{slow:?}");
        assert!(adapter.ms(governor.index()) <= 12.0 * OVER * 1.15 || governor.index() == 0);
        adapter.factor = 0.3;
        adapter.run(&mut governor, wish, 400);
        assert_eq!(governor.index(), before);
    }

    #[test]
    fn nothing_changes_under_a_dragging_hand_and_only_cheaper_settings_come_in_motion() {
        let mut governor = governor();
        governor.follow(Wish::ErrorPx(0.5), 0, Occasion::Dragged);
        assert!(!governor.is_on_front());
        let last = front().points().len() - 1;
        let frames = |governor: &mut Governor, gpu_ms: f64, from: u64| {
            for number in from..from + 20 {
                let frame = FrameTime {
                    gpu_ms,
                    pixels: PIXELS,
                    number,
                };
                governor.measured(frame, PIXELS as f64);
            }
        };
        // A start in the middle, on frames that take next to nothing.
        governor.follow(Wish::FrameMs(50.0), last / 2, Occasion::Still);
        frames(&mut governor, 0.01, 0);
        governor.follow(Wish::FrameMs(50.0), 0, Occasion::Moving);
        assert_eq!(governor.index(), last / 2);
        frames(&mut governor, 500.0, 100);
        governor.follow(Wish::FrameMs(50.0), 0, Occasion::Dragged);
        assert_eq!(governor.index(), last / 2);
        governor.follow(Wish::FrameMs(50.0), 0, Occasion::Moving);
        assert!(governor.index() < last / 2);
    }

    #[test]
    fn what_is_no_time_and_what_was_seen_before_counts_for_nothing() {
        let mut governor = governor();
        let frame = |gpu_ms, pixels, number| FrameTime {
            gpu_ms,
            pixels,
            number,
        };
        for (k, gpu_ms) in [f64::NAN, 0.0, -1.0, f64::INFINITY].into_iter().enumerate() {
            governor.measured(frame(gpu_ms, PIXELS, k as u64), PIXELS as f64);
        }
        governor.measured(frame(5.0, 0, 9), PIXELS as f64);
        assert_eq!(governor.measured_ms(), None);
        for _ in 0..20 {
            governor.measured(frame(5.0, PIXELS, 10), PIXELS as f64);
        }
        assert_eq!(
            (governor.measured_ms(), governor.times_ms.len()),
            (Some(5.0), 1)
        );
        for wish in [f64::NAN, 0.0, -1.0, f64::INFINITY] {
            governor.follow(Wish::FrameMs(wish), usize::MAX, Occasion::Still);
            governor.follow(Wish::ErrorPx(wish), usize::MAX, Occasion::Still);
            assert!(governor.index() < front().points().len());
        }
    }

    #[test]
    fn frames_of_fewer_pixels_count_until_there_are_whole_ones() {
        let mut governor = governor();
        for number in 0..10 {
            let frame = FrameTime {
                gpu_ms: 10.0,
                pixels: PIXELS / 4,
                number,
            };
            governor.measured(frame, PIXELS as f64);
        }
        assert_eq!(governor.measured_ms(), Some(40.0));
        for number in 10..10 + ENOUGH as u64 {
            let frame = FrameTime {
                gpu_ms: 25.0,
                pixels: PIXELS,
                number,
            };
            governor.measured(frame, PIXELS as f64);
        }
        assert_eq!(governor.measured_ms(), Some(25.0));
    }
}
