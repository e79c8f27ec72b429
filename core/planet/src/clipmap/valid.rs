//! Which part of a window may be read: the valid rectangle made of resident tiles.
//!
//! **Poles.** Rows end at a pole; samples beyond it are the same rows from the other side, which a
//! vertex or fragment there finds by its own longitude. So a valid rectangle that reaches a pole's
//! row is not shrunk at that side, and filter taps beyond it are clamped to the pole's row
//! ([`LevelView::tap_rows`]). **Whole circle.** Columns that close the circle have no sides: taps wrap
//! in storage.

use glam::{I64Vec2, Vec2};

use super::choose::{LevelView, UNBOUNDED};
use super::levels::texel_rad;
use super::plan::LevelPlan;
use crate::{SampleRect, TILE_SAMPLES, TileKey};

/// Samples that a bilinear read of heights can reach beyond its position, with room for rounding.
pub const HEIGHT_FILTER_MARGIN: f64 = 1.0;

/// Samples that eight bilinear taps along a footprint's major axis (at most one sample apart) can
/// reach beyond its position, with room for rounding.
pub const COLOUR_FILTER_MARGIN: f64 = 5.0;

/// Width of the band in which a level gives way to the next coarser one, samples.
pub const EDGE_BAND: f64 = 16.0;

/// The readable part of a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ValidRect {
    /// Samples of resident tiles, inside the window's rows, in unwrapped indices near the focus
    /// (for a whole-circle window they may differ from the window's own by whole turns). Empty when
    /// nothing is resident.
    pub rect: SampleRect,
    /// Whether its columns close the circle.
    pub whole_circle: bool,
}

/// The largest rectangle of resident tiles inside a level's window.
///
/// `resident` says whether a tile's samples are in the window's texture. Among all rectangles the
/// one that holds most of the selected tiles wins, then the one with most samples of the window.
/// At most 17 × 17 tiles are looked at.
pub fn valid_rect(plan: &LevelPlan, resident: impl Fn(TileKey) -> bool) -> ValidRect {
    let window = plan.window.rect;
    let whole = plan.window.is_whole_circle();
    let around = window.width();
    // Columns of a whole circle are looked at from half a turn west of the focus to half a turn
    // east, so that a rectangle around the focus is one piece whatever column 0 is.
    let seen = if whole {
        let first = libm::floor(plan.focus_in_sample.x) as i64 - around / 2;
        SampleRect::at(first, window.min.y, around, window.height())
    } else {
        window
    };
    let first = seen.min.div_euclid(I64Vec2::splat(TILE_SAMPLES));
    let last = (seen.max + (TILE_SAMPLES - 1)).div_euclid(I64Vec2::splat(TILE_SAMPLES));
    let columns = (last.x - first.x) as usize;
    let tiles: Vec<TileState> = plan
        .level
        .tiles_touching(&seen)
        .map(|(key, rect)| TileState {
            resident: resident(key),
            selected: plan.selects(key),
            area: rect.intersection(&seen).area(),
        })
        .collect();
    let best = best_rectangle(&tiles, columns);
    let Some(best) = best else {
        return ValidRect {
            rect: SampleRect::default(),
            whole_circle: false,
        };
    };
    let rect = best.shift(first);
    let rect = SampleRect::new(rect.min * TILE_SAMPLES, rect.max * TILE_SAMPLES);
    if whole {
        let rows = SampleRect::at(rect.min.x, window.min.y, rect.width(), window.height());
        let closes = rect.width() >= around;
        ValidRect {
            rect: rect.intersection(&rows),
            whole_circle: closes,
        }
    } else {
        ValidRect {
            rect: rect.intersection(&window),
            whole_circle: false,
        }
    }
}

/// What counts of a tile.
struct TileState {
    resident: bool,
    selected: bool,
    area: i64,
}

/// Best rectangle (in tiles) of resident tiles in a grid given row by row.
fn best_rectangle(tiles: &[TileState], columns: usize) -> Option<SampleRect> {
    if columns == 0 {
        return None;
    }
    let rows = tiles.len() / columns;
    let mut best = None;
    let mut best_score = (0, 0);
    for top in 0..rows {
        let mut open = vec![true; columns];
        // Sums of each column from `top` down.
        let mut selected = vec![0_i64; columns];
        let mut area = vec![0_i64; columns];
        for bottom in top..rows {
            for (c, tile) in tiles[bottom * columns..][..columns].iter().enumerate() {
                open[c] &= tile.resident;
                selected[c] += i64::from(tile.selected);
                area[c] += tile.area;
            }
            let mut from = 0;
            while from < columns {
                let to = from + open[from..].iter().take_while(|&&o| o).count();
                let score = (selected[from..to].iter().sum(), area[from..to].iter().sum());
                if to > from && score > best_score {
                    best_score = score;
                    best = Some(SampleRect::new(
                        I64Vec2::new(from as i64, top as i64),
                        I64Vec2::new(to as i64, bottom as i64 + 1),
                    ));
                }
                from = to.max(from + 1);
            }
        }
    }
    best
}

impl ValidRect {
    /// Smallest and largest continuous position, in samples relative to the focus, from which reads
    /// with a reach of `filter_margin` samples stay inside; unbounded (±[`UNBOUNDED`]) towards a
    /// pole whose row is inside and along columns that close the circle. Empty (min above max) when
    /// nothing can be read.
    pub fn inner(&self, plan: &LevelPlan, filter_margin: f64) -> (Vec2, Vec2) {
        if self.rect.is_empty() {
            return (Vec2::splat(UNBOUNDED), Vec2::splat(-UNBOUNDED));
        }
        // The rectangle may have been found for another turn around the planet.
        let around = plan.level.samples().x as f64;
        let centre = 0.5 * (self.rect.min.x + self.rect.max.x) as f64;
        let turns = libm::round((plan.focus_in_sample.x - centre) / around);
        let mut focus = plan.focus_in_sample;
        focus.x -= turns * around;
        let mut min = (self.rect.min.as_dvec2() + filter_margin - focus).as_vec2();
        let mut max = (self.rect.max.as_dvec2() - filter_margin - focus).as_vec2();
        if self.whole_circle {
            (min.x, max.x) = (-UNBOUNDED, UNBOUNDED);
        }
        if self.rect.min.y == 0 {
            min.y = -UNBOUNDED;
        }
        if self.rect.max.y == plan.level.samples().y {
            max.y = UNBOUNDED;
        }
        (min, max)
    }
}

impl LevelView {
    /// What a shader is told of a level.
    ///
    /// - `valid`: what is readable now, from [`valid_rect`] of the same plan.
    /// - `settled`: the valid rectangle that has finished fading in, of the same level key; `None`
    ///   for none. It may stem from an earlier plan.
    /// - `fade`: weight of what is valid but not settled, 0 to 1.
    /// - `filter_margin`: [`HEIGHT_FILTER_MARGIN`] or [`COLOUR_FILTER_MARGIN`].
    pub fn new(
        plan: &LevelPlan,
        valid: &ValidRect,
        settled: Option<&ValidRect>,
        fade: f32,
        filter_margin: f64,
    ) -> Self {
        let (valid_min, valid_max) = valid.inner(plan, filter_margin);
        let nothing = ValidRect {
            rect: SampleRect::default(),
            whole_circle: false,
        };
        let (settled_min, settled_max) = settled.unwrap_or(&nothing).inner(plan, filter_margin);
        let period = plan.window.period().as_dvec2();
        let focus = plan.focus_in_sample;
        Self {
            focus_in_storage: focus.rem_euclid(period).as_vec2(),
            samples_per_rad: (1.0 / plan.level.step_rad()).as_vec2(),
            valid_min,
            valid_max,
            settled_min,
            settled_max,
            fade,
            tap_rows: Vec2::new(
                (valid.rect.min.y as f64 + 0.5 - focus.y) as f32,
                (valid.rect.max.y as f64 - 0.5 - focus.y) as f32,
            ),
            edge_band: EDGE_BAND as f32,
            texel_rad: texel_rad(plan.level.n) as f32,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clipmap::{TileSet, Window};
    use crate::{LevelKey, MapPoint};

    fn plan(level: LevelKey, focus: MapPoint, size: u32) -> LevelPlan {
        let window = Window::place(level, focus, size);
        let focus_in_sample = window.sample_of(focus);
        LevelPlan {
            level,
            window,
            selected: TileSet::none_of(&window),
            wanted: SampleRect::default(),
            focus_in_sample,
            centre_in_sample: focus_in_sample,
        }
    }

    #[test]
    fn everything_resident_makes_the_whole_window_valid() {
        let p = plan(
            LevelKey::new(8, 7),
            MapPoint::from_degrees(10.0, 20.0),
            1024,
        );
        let v = valid_rect(&p, |_| true);
        assert_eq!(
            v,
            ValidRect {
                rect: p.window.rect,
                whole_circle: false
            }
        );
    }

    #[test]
    fn a_missing_tile_costs_the_smaller_side() {
        let p = plan(
            LevelKey::new(8, 7),
            MapPoint::from_degrees(10.0, 20.0),
            1024,
        );
        let missing = p.window.tiles().next().unwrap().0;
        let v = valid_rect(&p, |k| k != missing);
        assert!(v.rect.area() * 4 >= p.window.rect.area() * 3, "{v:?}");
        assert!(!v.rect.overlaps(&p.window.tile_rect(missing).unwrap()));
    }

    #[test]
    fn selected_tiles_count_more_than_size() {
        let mut p = plan(
            LevelKey::new(8, 7),
            MapPoint::from_degrees(10.0, 20.0),
            1024,
        );
        let (wanted, rect) = p.window.tiles().next().unwrap();
        p.selected.insert(&rect);
        // A full column through the wanted tile's neighbour is missing: the corner stands alone.
        let east = wanted.neighbour(1, 0);
        let v = valid_rect(&p, |k| k.column != east.column);
        assert!(v.rect.overlaps(&rect));
    }

    #[test]
    fn a_whole_circle_is_valid_all_around_and_to_both_poles() {
        let p = plan(
            LevelKey::new(2, 2),
            MapPoint::from_degrees(179.0, 80.0),
            1024,
        );
        let v = valid_rect(&p, |_| true);
        assert!(v.whole_circle);
        let (min, max) = v.inner(&p, 5.0);
        assert_eq!(
            (min, max),
            (Vec2::splat(-UNBOUNDED), Vec2::splat(UNBOUNDED))
        );
    }

    #[test]
    fn nothing_resident_can_be_read_nowhere() {
        let p = plan(
            LevelKey::new(8, 7),
            MapPoint::from_degrees(10.0, 20.0),
            1024,
        );
        let v = valid_rect(&p, |_| false);
        let view = LevelView::new(&p, &v, None, 1.0, 1.0);
        assert!(!view.contains(Vec2::ZERO));
    }
}
