//! How much contrast the coarse colours have, halving by halving, and the power law by which it goes on.
//!
//! What samples 2ʲ⁻¹ coarse spacings apart show above the smooth refinement of those 2ʲ apart is exactly
//! what a step of refinement adds, so its mean square at j = 1, 2, … is continued at j = 0, −1, … without
//! any conversion. It is taken relative to the local light: dark ground has the same pattern, fainter.
//! Colours whose spectrum falls with the frequency to the power of −(2 + η) have energies that fall by
//! 2^η from halving to halving.

use relievo_planet::SampleRect;

use super::field::{Field, above_smooth};

/// Halvings that are measured.
const HALVINGS: usize = 4;

/// Samples along a side of the window whose law is found, as a power of two.
const WIDE: u32 = 5;

/// Samples along a side of the window that says how rough a place is itself, as a power of two.
const NARROW: u32 = 2;

/// Coarse samples around a place that decide how rough it is: half a wide window, and around its samples
/// a coarse one of the last halving and its neighbour.
pub(super) const MARGIN: i64 = 40;

/// η that a fit can give: detail never gets stronger as it gets finer, or colours would have no limit.
const FALLOFFS: [f64; 2] = [0.0, 1.5];

/// What a fit tends to where there is little to measure, as aerial and satellite imagery has it.
const USUAL_FALLOFF: f64 = 0.3;

/// How much the usual falloff counts: little beside halvings that were measured well, of which each counts
/// about 0.5.
const USUAL_WEIGHT: f64 = 0.1;

/// Independent differences from which on a halving counts half.
const HALF_COUNT: f64 = 2.0;

/// By how much a place's own energy can be off from the law of its surroundings for that it is put right.
const MOST_RIGHTED: [f64; 2] = [0.5, 4.0];

/// Largest contrast of a halving, as a root of the mean square relative to the light.
const MOST_CONTRAST: f64 = 0.5;

/// Light below this counts as this: black has no contrast.
const LEAST_LIGHT: f32 = 1e-3;

/// E(v^¼)⁴ / E(v) for the mean v of the squares of three independent normal variables, which is what a
/// halving of noise gives.
const OF_QUARTER: f64 = 0.771_2;

/// How much of a steady pattern's energy is left after the least of nine windows is taken.
const OF_LEAST: f64 = 0.55;

/// Weights of red, green and blue light (Rec. 709).
const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// How the light varies below the coarse colours.
#[derive(Default)]
pub(super) struct Contrast {
    rect: SampleRect,
    /// The contrast of the first halving and the factor from halving to halving, row by row.
    laws: Vec<[f32; 2]>,
}

/// A value for every sample of a rectangle; NaN where there is none.
struct Plane {
    width: usize,
    values: Vec<f32>,
}

/// Sums over windows, and of how many values.
struct Windows {
    sums: Plane,
    counts: Plane,
}

impl Contrast {
    /// Bytes of one over so many samples.
    pub(super) fn bytes(samples: usize) -> usize {
        samples * size_of::<[f32; 2]>()
    }

    /// Measures colours for all samples that are [`MARGIN`] samples inside.
    ///
    /// - `there`: which samples count.
    /// - `finest`: the first halving that tells how rough a place is: 1, or 2 where the samples lie
    ///   nearer together than those of the imagery. It and coarser ones tell the level, only coarser ones
    ///   the falloff, as imagery is often resampled.
    pub(super) fn new(light: &Field, there: &[bool], finest: usize) -> Self {
        let width = light.rect().width() as usize;
        let luminance = (0..light.len()).map(|at| {
            let [r, g, b] = light.get(at);
            let sum = r * LUMINANCE[0] + g * LUMINANCE[1] + b * LUMINANCE[2];
            if there[at] { sum } else { f32::NAN }
        });
        let mut children = Plane {
            width,
            values: luminance.collect(),
        };
        let mut wide = Vec::with_capacity(HALVINGS);
        let mut own = None;
        for halving in 1..=HALVINGS {
            let parents = children.means(1 << (halving - 1));
            let roots = roots(&parents, &children, halving);
            if halving == finest {
                own = Some(least(&roots, halving));
            }
            wide.push(Windows::new(&roots, WIDE));
            children = parents;
        }
        let rect = light.rect().grow(-MARGIN);
        let own = own.expect("the finest is one of those that are measured");
        let mut laws = Vec::with_capacity(rect.area() as usize);
        for y in MARGIN as usize..MARGIN as usize + rect.height() as usize {
            for x in MARGIN as usize..MARGIN as usize + rect.width() as usize {
                laws.push(law(&wide, own.get(x, y), finest, (x, y)));
            }
        }
        Self { rect, laws }
    }

    /// The contrast that is added to each of some samples when they are refined, after so many doublings.
    ///
    /// Between coarse samples the first halving's contrast and the factor are linear. The samples lie in
    /// coarse ones that are one sample or more inside.
    pub(super) fn of(&self, parents: &SampleRect, doublings: u32) -> Vec<f32> {
        let scale = libm::ldexp(1.0, -(doublings as i32));
        let between = |sample: i64, min: i64| {
            let from_centre = (sample as f64 + 0.5) * scale - 0.5;
            let first = libm::floor(from_centre);
            ((first as i64 - min) as usize, (from_centre - first) as f32)
        };
        let columns: Vec<_> = (parents.min.x..parents.max.x)
            .map(|x| between(x, self.rect.min.x))
            .collect();
        let stride = self.rect.width() as usize;
        let mut all = Vec::with_capacity(parents.area() as usize);
        for y in parents.min.y..parents.max.y {
            let (row, south) = between(y, self.rect.min.y);
            let north = &self.laws[row * stride..];
            let next = &north[stride..];
            for (column, east) in &columns {
                let [contrast, factor] = core::array::from_fn(|k| {
                    let along = |row: &[[f32; 2]]| {
                        row[*column][k] + east * (row[column + 1][k] - row[*column][k])
                    };
                    let north = along(north);
                    north + south * (along(next) - north)
                });
                let mut contrast: f32 = contrast;
                for _ in 0..doublings {
                    contrast *= factor;
                }
                all.push(contrast);
            }
        }
        all
    }
}

/// The law of a place: the contrast of the first halving below the coarse samples, and the factor from
/// halving to halving.
///
/// - `own`: the energy of halving `finest` at the place itself.
fn law(wide: &[Windows], own: f32, finest: usize, place: (usize, usize)) -> [f32; 2] {
    let energy = |halving: usize| {
        let (mean, count) = wide[halving - 1].at(place, halving, WIDE)?;
        let square = f64::from(mean) * f64::from(mean);
        let energy = square * square / OF_QUARTER;
        (energy > 0.0).then_some((energy, f64::from(count)))
    };
    let (mut weights, mut mean_x, mut mean_y) = (0.0, 0.0, 0.0);
    let mut points = [(0.0, 0.0, 0.0); HALVINGS];
    for halving in finest + 1..=HALVINGS {
        let Some((energy, count)) = energy(halving) else {
            continue;
        };
        let independent = libm::ldexp(count, -2 * halving as i32);
        let weight = independent / (independent + HALF_COUNT);
        let (x, y) = (halving as f64, libm::log2(energy));
        points[halving - 1] = (x, y, weight);
        weights += weight;
        mean_x += weight * x;
        mean_y += weight * y;
    }
    let own = f64::from(own);
    if own.is_nan() || own <= 0.0 {
        return [0.0, 1.0];
    }
    let (mut across, mut square) = (USUAL_WEIGHT * USUAL_FALLOFF, USUAL_WEIGHT);
    let mut righted = 1.0;
    let mut falloff = USUAL_FALLOFF;
    if weights > 0.0 {
        (mean_x, mean_y) = (mean_x / weights, mean_y / weights);
        for (x, y, weight) in points {
            across += weight * (x - mean_x) * (y - mean_y);
            square += weight * (x - mean_x) * (x - mean_x);
        }
        falloff = (across / square).clamp(FALLOFFS[0], FALLOFFS[1]);
        if let Some((found, _)) = energy(finest) {
            let said = libm::exp2(mean_y + falloff * (finest as f64 - mean_x));
            righted = (said / found).clamp(MOST_RIGHTED[0], MOST_RIGHTED[1]);
        }
    }
    let factor = libm::exp2(-0.5 * falloff);
    let mut contrast = (own * righted).sqrt();
    for _ in 0..finest {
        contrast *= factor;
    }
    [contrast.min(MOST_CONTRAST) as f32, factor as f32]
}

/// The fourth root of the mean square, relative to the light, of what `children` are above the smooth
/// refinement of `parents`, for every parent by its first child.
///
/// Of such roots a mean does not heed the few large ones along borders, which noise could not continue.
fn roots(parents: &Plane, children: &Plane, halving: usize) -> Plane {
    let (side, half) = (1 << halving, 1 << (halving - 1));
    let (width, height) = (parents.width, parents.height());
    let mut out = Plane {
        width,
        values: vec![f32::NAN; parents.values.len()],
    };
    let from = &parents.values;
    for y in side..height.saturating_sub(side) {
        for x in side..width.saturating_sub(side) {
            let at = y * width + x;
            let row = |at: usize| [from[at - side], from[at], from[at + side]];
            let around = [row(at - side * width), row(at), row(at + side * width)];
            let child = |at: usize| children.values[at];
            let south = at + half * width;
            let quad = [
                child(at),
                child(at + half),
                child(south),
                child(south + half),
            ];
            let [nw, ne, sw, se] = above_smooth(quad, &around).map(|v| v * v);
            let light = from[at].max(LEAST_LIGHT);
            let mean = ((nw + ne) + (sw + se)) * 0.25;
            out.values[at] = (mean / (light * light)).sqrt().sqrt();
        }
    }
    out
}

/// How rough places are by narrow windows: of those that hold a place in different parts the least, so
/// that a border does not make rough what lies beside it; a little smoothed.
fn least(roots: &Plane, halving: usize) -> Plane {
    /// From window to window in samples.
    const APART: usize = 1 << (NARROW - 1);
    let windows = Windows::new(roots, NARROW);
    let (width, height) = (roots.width, roots.height());
    let energy = |x: usize, y: usize| {
        let (mean, _) = windows.at((x, y), halving, NARROW)?;
        let square = mean * mean;
        Some(square * square * ((1.0 / (OF_QUARTER * OF_LEAST)) as f32))
    };
    let whole = Plane::from_fn(width, height, |x, y| energy(x, y).unwrap_or(f32::NAN));
    let least = Plane::from_fn(width, height, |x, y| {
        let mut least = f32::NAN;
        for y in [y.wrapping_sub(APART), y, y + APART] {
            for x in [x.wrapping_sub(APART), x, x + APART] {
                if x < width && y < height {
                    least = least.min(whole.get(x, y));
                }
            }
        }
        least
    });
    Plane::from_fn(width, height, |x, y| {
        let (mut sum, mut weights) = (0.0, 0.0);
        for (y, down) in [(y.wrapping_sub(1), 1.0), (y, 2.0), (y + 1, 1.0)] {
            for (x, across) in [(x.wrapping_sub(1), 1.0), (x, 2.0), (x + 1, 1.0)] {
                if x < width && y < height && !least.get(x, y).is_nan() {
                    sum += down * across * least.get(x, y);
                    weights += down * across;
                }
            }
        }
        sum / weights
    })
}

impl Plane {
    fn from_fn(width: usize, height: usize, value: impl Fn(usize, usize) -> f32) -> Self {
        let mut values = Vec::with_capacity(width * height);
        for y in 0..height {
            values.extend((0..width).map(|x| value(x, y)));
        }
        Self { width, values }
    }

    fn height(&self) -> usize {
        self.values.len() / self.width.max(1)
    }

    fn get(&self, x: usize, y: usize) -> f32 {
        self.values[y * self.width + x]
    }

    /// Sums of each sample and those `apart` to its east, south and south-east: the same bits wherever the
    /// rectangle begins. `beyond` is what lies outside.
    fn sums(&self, apart: usize, beyond: f32) -> Self {
        let height = self.height();
        let mut along = self.values.clone();
        for row in along.chunks_exact_mut(self.width.max(1)) {
            for x in 0..self.width {
                row[x] += row.get(x + apart).copied().unwrap_or(beyond);
            }
        }
        for y in 0..height {
            let (here, below) = along.split_at_mut((y + 1) * self.width);
            let here = &mut here[y * self.width..];
            let below = below.get((apart - 1) * self.width..apart * self.width);
            for (x, v) in here.iter_mut().enumerate() {
                *v += below.map_or(2.0 * beyond, |below| below[x]);
            }
        }
        Self {
            width: self.width,
            values: along,
        }
    }

    /// Means of boxes of 2 · `apart` samples by their first one, where this holds those of `apart`.
    fn means(&self, apart: usize) -> Self {
        let mut sums = self.sums(apart, f32::NAN);
        for v in &mut sums.values {
            *v *= 0.25;
        }
        sums
    }
}

impl Windows {
    /// Windows of 2^`side` samples along a side, by their first one.
    fn new(values: &Plane, side: u32) -> Self {
        let of = |value: fn(f32) -> f32| {
            let mut sums = Plane {
                width: values.width,
                values: values.values.iter().map(|v| value(*v)).collect(),
            };
            for doubling in 0..side {
                sums = sums.sums(1 << doubling, 0.0);
            }
            sums
        };
        Self {
            sums: of(|v| if v.is_nan() { 0.0 } else { v }),
            counts: of(|v| if v.is_nan() { 0.0 } else { 1.0 }),
        }
    }

    /// The mean of values of parents around a sample, and how many there are.
    fn at(&self, (x, y): (usize, usize), halving: usize, side: u32) -> Option<(f32, f32)> {
        // From the first child of the first parent: half a parent and half a window less half a sample.
        let back = (1 << (halving - 1)) + (1 << (side - 1)) - 1;
        let (x, y) = (x.checked_sub(back)?, y.checked_sub(back)?);
        let count = self.counts.get(x, y);
        (count > 0.0).then(|| (self.sums.get(x, y) / count, count))
    }
}
