//! Which clip level a vertex or a fragment reads: the CPU twins of the shader's selection.
//!
//! Maths in f32 and in the order of the shader, from the same uniform values. Law: no choice ever
//! reads a texel outside a level's valid rectangle (`tests/clipmap_laws.rs`). Absent: how the valid
//! rectangles come about (`valid.rs`).

use glam::Vec2;

/// What a shader knows of one clip level in one frame. Levels are given coarse to fine.
///
/// Rectangles are in samples **relative to the focus**: a map offset `delta` (Δφ, Δθ in radians from
/// the focus) lies at `delta * samples_per_rad`. They bound *continuous* positions that can be
/// filtered with a reach of `filter_margin` samples (see `valid::ValidRect::inner`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelView {
    /// Continuous position of the focus in the window's storage, texels, reduced by its period:
    /// the centre of texel i is at i + ½.
    pub focus_in_storage: Vec2,
    /// Samples per radian of longitude and of colatitude.
    pub samples_per_rad: Vec2,
    /// Smallest offset from the focus that may be read, samples; −[`UNBOUNDED`] where columns close
    /// the circle. Larger than `valid_max` when nothing is valid.
    pub valid_min: Vec2,
    /// Largest offset from the focus that may be read, samples.
    pub valid_max: Vec2,
    /// The part of the valid rectangle that has finished fading in: smallest offset, samples.
    pub settled_min: Vec2,
    /// The part of the valid rectangle that has finished fading in: largest offset, samples.
    pub settled_max: Vec2,
    /// Weight of what is valid but not settled, 0 to 1.
    pub fade: f32,
    /// Filter taps are clamped to these row offsets (centres of the first and last row that may be
    /// read), so that a tap beyond a pole reads the pole's row: see `valid.rs`.
    pub tap_rows: Vec2,
    /// Width in samples of the band inside a rectangle's sides in which the level gives way to the
    /// next coarser one; positive.
    pub edge_band: f32,
    /// Size of a sample in radians of colatitude.
    pub texel_rad: f32,
}

/// Stands for "no bound" in a [`LevelView`]: larger than any offset, and finite in f32.
pub const UNBOUNDED: f32 = 1.0e9;

/// Width, in octaves of the footprint, of the zone in which a colour level fades in (a factor √2).
pub const FOOTPRINT_BLEND_OCTAVES: f32 = 0.5;

/// Longest footprint, in widths of it, that is filtered along its whole length; longer ones, seen at
/// less than a degree, count as this long.
pub const MAX_ANISOTROPY: f64 = 64.0;

/// Two levels to read and how to mix them: `(1 − coarse_weight) · fine + coarse_weight · coarse`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelChoice {
    /// Index of the finer level.
    pub fine: usize,
    /// Index of the coarser level; equal to `fine` when `coarse_weight` is 0.
    pub coarse: usize,
    /// Weight of the coarser level, 0 to 1. At exactly 0 or 1 only one level is to be read.
    pub coarse_weight: f32,
}

impl LevelView {
    /// Position of a map offset in samples relative to the focus.
    pub fn offset_of(&self, delta_rad: Vec2) -> Vec2 {
        delta_rad * self.samples_per_rad
    }

    /// Whether filtered reads at this offset stay inside the valid rectangle.
    pub fn contains(&self, offset: Vec2) -> bool {
        offset.cmpge(self.valid_min).all() && offset.cmple(self.valid_max).all()
    }

    /// Weight of this level at an offset, 0 to 1: 0 from the valid rectangle's sides outward,
    /// rising over `edge_band` samples to `fade`, and to 1 inside the settled rectangle.
    pub fn weight(&self, offset: Vec2) -> f32 {
        let valid = rise(offset, self.valid_min, self.valid_max, self.edge_band);
        let settled = rise(offset, self.settled_min, self.settled_max, self.edge_band);
        (valid * self.fade).max(settled.min(valid))
    }
}

/// 0 outside a rectangle, rising linearly to 1 over `band` inside its sides.
fn rise(offset: Vec2, min: Vec2, max: Vec2, band: f32) -> f32 {
    let inside = (offset - min).min(max - offset);
    (inside.x.min(inside.y) / band).clamp(0.0, 1.0)
}

/// Finest level no finer than `start` that may be read at `delta_rad`.
fn finest_readable(levels: &[LevelView], start: usize, delta_rad: Vec2) -> Option<usize> {
    (0..=start.min(levels.len().checked_sub(1)?))
        .rev()
        .find(|&i| levels[i].contains(levels[i].offset_of(delta_rad)))
}

/// Mixes `fine` with the finest coarser level that may be read at `delta_rad`.
fn with_coarser(
    levels: &[LevelView],
    fine: usize,
    delta_rad: Vec2,
    own_weight: f32,
) -> LevelChoice {
    let coarser = match fine.checked_sub(1) {
        Some(below) if own_weight < 1.0 => finest_readable(levels, below, delta_rad),
        _ => None,
    };
    match coarser {
        Some(coarse) => LevelChoice {
            fine,
            coarse,
            coarse_weight: 1.0 - own_weight,
        },
        None => LevelChoice {
            fine,
            coarse: fine,
            coarse_weight: 0.0,
        },
    }
}

/// The height levels that a vertex reads.
///
/// - `level`: index of the level of the vertex's ring.
/// - `rim`: the vertex's blend weight in its ring, 0 inside to exactly 1 at the outer rim
///   (`RingMesh`), where the next coarser level takes over.
/// - `delta_rad`: Δφ, Δθ of the vertex from the focus.
/// - Returns `None` where no level is valid: the height is then 0.
///
/// A vertex that two rings share gets the same choice from both: `rim` = 1 in one ring is `rim` = 0
/// at the next coarser level in the other, so there is no crack.
///
/// Source: \[CH06\] 5.2 blends between levels likewise.
pub fn height_level_for(
    levels: &[LevelView],
    level: usize,
    rim: f32,
    delta_rad: Vec2,
) -> Option<LevelChoice> {
    let (start, rim) = if rim >= 1.0 {
        (level.saturating_sub(1), 0.0)
    } else {
        (level, rim)
    };
    let fine = finest_readable(levels, start, delta_rad)?;
    let mut own = levels[fine].weight(levels[fine].offset_of(delta_rad));
    if fine == start {
        own = own.min(1.0 - rim);
    }
    Some(with_coarser(levels, fine, delta_rad, own))
}

/// Index of the finest level whose texel is not smaller than a footprint; 0 if none is.
///
/// Texels halve exactly from level to level, so the exponent of the ratio counts the levels.
fn by_footprint(levels: &[LevelView], footprint_rad: f32) -> usize {
    let ratio = levels.first().map_or(0.0, |l| l.texel_rad) / footprint_rad;
    if ratio >= 1.0 {
        let octaves = (ratio.to_bits() >> 23) as usize - 127;
        octaves.min(levels.len() - 1)
    } else {
        0
    }
}

/// The colour (or normal) levels that a fragment reads. `levels` are consecutive: each texel is half
/// the one before.
///
/// - `footprint_rad`: the minor axis of the fragment's footprint as an angle at the planet's centre:
///   view depth × angle of a pixel / radius. Positive.
/// - `delta_rad`: Δφ, Δθ of the fragment from the focus.
/// - Returns `None` where no level is valid.
///
/// The finest level that contains the fragment and is valid there, but whose texel is not smaller
/// than the footprint; where texel and footprint are nearly equal it fades in over
/// [`FOOTPRINT_BLEND_OCTAVES`]. The coarsest level is never ruled out by the footprint.
///
/// Source: \[CH07\] future work 2; explicit level as in \[Cra07\].
pub fn colour_level_for(
    levels: &[LevelView],
    footprint_rad: f32,
    delta_rad: Vec2,
) -> Option<LevelChoice> {
    let by_footprint = by_footprint(levels, footprint_rad);
    let fine = finest_readable(levels, by_footprint, delta_rad)?;
    let mut own = levels[fine].weight(levels[fine].offset_of(delta_rad));
    if fine == by_footprint {
        own = own.min(footprint_weight(levels[fine].texel_rad, footprint_rad));
    }
    Some(with_coarser(levels, fine, delta_rad, own))
}

/// 0 where a level's texel equals the footprint, 1 from [`FOOTPRINT_BLEND_OCTAVES`] octaves on.
///
/// Linear in the ratio, not in its logarithm, so that no platform's `log2` decides a weight.
fn footprint_weight(texel_rad: f32, footprint_rad: f32) -> f32 {
    let full = core::f32::consts::SQRT_2;
    ((texel_rad / footprint_rad - 1.0) / (full - 1.0)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(texel_rad: f32, half: f32) -> LevelView {
        LevelView {
            focus_in_storage: Vec2::splat(128.0),
            samples_per_rad: Vec2::splat(1.0 / texel_rad),
            valid_min: Vec2::splat(-half),
            valid_max: Vec2::splat(half),
            settled_min: Vec2::splat(-half),
            settled_max: Vec2::splat(half),
            fade: 1.0,
            tap_rows: Vec2::new(-half, half),
            edge_band: 16.0,
            texel_rad,
        }
    }

    #[test]
    fn a_shared_vertex_gets_the_same_choice_from_both_rings() {
        let levels = [level(4e-3, 120.0), level(2e-3, 120.0), level(1e-3, 120.0)];
        for x in 0..100 {
            let delta = Vec2::new(x as f32 * 1e-3, 0.03);
            let outer = height_level_for(&levels, 1, 0.0, delta);
            let inner = height_level_for(&levels, 2, 1.0, delta);
            assert_eq!(outer, inner);
        }
    }

    #[test]
    fn a_colour_changes_continuously_with_its_footprint() {
        let levels = [level(4e-3, 500.0), level(2e-3, 500.0), level(1e-3, 500.0)];
        // The mean level read, fine = 2: a jump in it would be a visible line.
        let mean = |f: f32| {
            let c = colour_level_for(&levels, f, Vec2::ZERO).unwrap();
            c.fine as f32 + (c.coarse as f32 - c.fine as f32) * c.coarse_weight
        };
        let mut before = mean(1e-4);
        let mut f = 1e-4_f32;
        while f < 1e-2 {
            f *= 1.001;
            let now = mean(f);
            assert!(
                (now - before).abs() < 0.01,
                "jump at footprint {f}: {before} to {now}"
            );
            assert!(
                now <= before + 1e-6,
                "a larger footprint never reads a finer level"
            );
            before = now;
        }
    }

    #[test]
    fn the_finest_level_that_is_coarse_enough_is_found_whatever_the_footprint() {
        let levels: Vec<_> = (0..20)
            .map(|n| level(4e-3 / (1 << n) as f32, 500.0))
            .collect();
        for exponent in -400..100 {
            let footprint = libm::exp2f(exponent as f32 / 16.0);
            for f in [footprint, footprint.next_up(), footprint.next_down()] {
                let searched = levels.iter().rposition(|l| l.texel_rad >= f).unwrap_or(0);
                assert_eq!(by_footprint(&levels, f), searched, "{f}");
            }
        }
        for l in &levels {
            assert_eq!(levels[by_footprint(&levels, l.texel_rad)], *l);
        }
        assert_eq!(by_footprint(&levels, f32::NAN), 0);
        assert_eq!(by_footprint(&levels, f32::INFINITY), 0);
        assert_eq!(by_footprint(&levels, 0.0), 19);
        assert_eq!(by_footprint(&[], 1.0), 0);
    }

    #[test]
    fn nothing_valid_means_nothing_read() {
        let mut l = level(1e-3, 100.0);
        (l.valid_min, l.valid_max) = (Vec2::splat(1.0), Vec2::splat(-1.0));
        assert_eq!(colour_level_for(&[l], 1e-3, Vec2::ZERO), None);
        assert_eq!(height_level_for(&[l], 0, 0.0, Vec2::ZERO), None);
        assert_eq!(height_level_for(&[], 0, 0.0, Vec2::ZERO), None);
    }
}
