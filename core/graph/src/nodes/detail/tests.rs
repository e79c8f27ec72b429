use core::f64::consts::TAU;

use relievo_planet::{LevelKey, SampleRect};
use relievo_raster::{Cancel, SampleType};

use super::*;
use crate::graph::{Graph, GraphBuilder, NodeIndex};
use crate::roughness::Surface;

/// Samples of the data: 305.4 m apart on the equator.
const DATA: LevelKey = LevelKey { n: 8, m: 9 };

/// How many samples of data that lie [`Data::apart`] make one.
const APART: f64 = 0.8;

/// Metres between them.
fn spacing_m() -> f64 {
    DATA.step_rad().y * Planet::EARTH.radius_m
}

/// Data by column and row of [`DATA`], bilinear between them as files are.
struct Data {
    rect: SampleRect,
    samples: Vec<f32>,
    /// Samples of the data to one of [`DATA`], from the middle of the rectangle on.
    scale: f64,
}

impl Data {
    fn new(rect: SampleRect, height_m: impl Fn(i64, i64) -> f32) -> Self {
        let width = rect.width();
        let at = |i: i64| height_m(rect.min.x + i % width, rect.min.y + i / width);
        Self {
            rect,
            samples: (0..rect.area()).map(at).collect(),
            scale: 1.0,
        }
    }

    /// The same, their samples laid wider than those of any level and nowhere on them, as files are.
    fn apart(self) -> Self {
        Self {
            scale: APART,
            ..self
        }
    }

    fn at(&self, sample: I64Vec2) -> f32 {
        let size = DATA.samples();
        let row = sample.y.clamp(0, size.y - 1);
        let column = self.rect.min.x + (sample.x - self.rect.min.x).rem_euclid(size.x);
        let at = I64Vec2::new(column, row);
        if !self.rect.contains(at) {
            return f32::NAN;
        }
        let local = at - self.rect.min;
        self.samples[(local.y * self.rect.width() + local.x) as usize]
    }
}

impl ImageNode for Data {
    fn kind(&self) -> &'static str {
        "data"
    }

    fn output(&self) -> Bands {
        Bands::Height
    }

    fn is_pointwise(&self) -> bool {
        true
    }

    fn identify(&self, grid: &Grid, id: &mut IdHasher) {
        id.grid(grid);
    }

    fn render(&self, job: &Job, _inputs: &[&Block], out: &mut Block) -> Result<(), RenderError> {
        let Grid { lattice, rect } = job.grid;
        let ground = Ground::new(lattice, "data")?;
        let width = rect.width();
        for (i, h) in out.plane_mut(0).iter_mut().enumerate() {
            let sample = rect.min + I64Vec2::new(i as i64 % width, i as i64 / width);
            let place = ground.point(sample.as_dvec2() + 0.5).unwrap();
            let middle = (self.rect.min + self.rect.max).as_dvec2() * 0.5;
            let at = (DATA.sample_from_map(place) - 0.5 - middle) * self.scale + middle;
            let (corner, share) = (at.floor(), at - at.floor());
            let value =
                |x: i64, y: i64| f64::from(self.at(corner.as_i64vec2() + I64Vec2::new(x, y)));
            let mix = |a: f64, b: f64, t: f64| if t == 0.0 { a } else { a + (b - a) * t };
            let north = mix(value(0, 0), value(1, 0), share.x);
            let south = mix(value(0, 1), value(1, 1), share.x);
            *h = mix(north, south, share.y) as f32;
        }
        Ok(())
    }
}

fn params() -> DetailParams {
    DetailParams {
        seed: 4,
        strength: 1.0,
        method: DetailMethod::Simplex,
        slope: 0.5,
        heights_m: [f64::NEG_INFINITY, f64::INFINITY],
        fade_m: 0.0,
        shortest_m: 1.0,
        spacing_m: spacing_m(),
    }
}

/// The data alone, and with detail.
fn graph(data: Data, params: &DetailParams) -> (Graph, [NodeIndex; 3]) {
    let mut builder = GraphBuilder::default();
    let data = builder.add(Arc::new(data), &[]);
    builder.cut(data, SampleType::Height);
    let node = Detail::new(Planet::EARTH, params);
    let amount = builder.add(Arc::new(node.clone().amount()), &[data]);
    let detail = builder.add(Arc::new(node), &[data]);
    builder.cut(detail, SampleType::Height);
    (builder.build(), [data, detail, amount])
}

fn evaluate(graph: &Graph, node: NodeIndex, level: LevelKey, rect: SampleRect) -> Vec<f32> {
    let grid = Grid::new(Arc::new(level.lattice()), rect);
    let block = graph.evaluate(node, &grid, &Cancel::default()).unwrap();
    block.samples().to_vec()
}

/// Waves of a power law.
const WAVES: u32 = 600;

/// Waves of random directions as high as their lengths (in samples of the data) to the power of an
/// exponent, of all lengths from a quarter of a sample to a thousand; means over samples.
fn power_law(exponent: f64) -> impl Fn(i64, i64) -> f32 {
    let mut state = 77_u32;
    let mut random = move || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        f64::from(state) / f64::from(u32::MAX)
    };
    // Of each wave the cosine and the sine along columns, and both times its height along rows.
    let side = middle().width();
    let (mut columns, mut rows) = (Vec::new(), Vec::new());
    for i in 0..WAVES {
        let length = libm::exp2(-2.0 + 12.0 * (f64::from(i) + random()) / f64::from(WAVES));
        let (sin, cos) = libm::sincos(TAU * random());
        let turns = [cos / length, sin / length];
        // A mean over a square weakens a wave by sinc in either direction.
        let sinc = |t: f64| libm::sin(0.5 * TAU * t) / (0.5 * TAU * t);
        let height = 2.0 * libm::pow(length, exponent) * sinc(turns[0]) * sinc(turns[1]);
        let phase = random();
        let along = |turns: f64, phase: f64, height: f64| -> Vec<[f64; 2]> {
            let at = |k: i64| libm::sincos(TAU * (turns * k as f64 + phase));
            let both = |(sin, cos): (f64, f64)| [height * cos, height * sin];
            (0..side).map(|k| both(at(k))).collect()
        };
        columns.push(along(turns[0], 0.0, 1.0));
        rows.push(along(turns[1], phase, height));
    }
    move |x, y| {
        let at = I64Vec2::new(x, y) - middle().min;
        let (x, y) = (at.x as usize, at.y as usize);
        let waves = columns.iter().zip(&rows);
        let height =
            |(c, r): (&Vec<[f64; 2]>, &Vec<[f64; 2]>)| c[x][0] * r[y][0] - c[x][1] * r[y][1];
        waves.map(height).sum::<f64>() as f32
    }
}

/// The law of those waves: the mean squared second difference at a lag in samples.
fn law_m2(exponent: f64, lag: f64) -> f64 {
    let per_octave = f64::from(WAVES) / 12.0;
    let n = 8000;
    let sum: f64 = (0..n)
        .map(|i| {
            let length = libm::exp2(-12.0 + 26.0 * (f64::from(i) + 0.5) / f64::from(n));
            let height = 2.0 * libm::pow(length, exponent);
            let t = TAU * lag / length;
            0.5 * height * height * (6.0 - 8.0 * libm::j0(t) + 2.0 * libm::j0(2.0 * t))
        })
        .sum();
    sum * per_octave * 26.0 / f64::from(n)
}

/// A square around the equator, some patches large.
fn middle() -> SampleRect {
    let size = DATA.samples();
    SampleRect::at(size.x / 2 - 256, size.y / 2 - 256, 640, 640)
}

/// The sample of a finer level at one of the square, by its column and row.
fn at_level(sample: i64, finer: u8) -> I64Vec2 {
    (middle().min + sample) * (1 << finer)
}

fn bits(heights: &[f32]) -> Vec<u32> {
    heights.iter().map(|h| h.to_bits()).collect()
}

/// Energies of a square of `side` samples of a level whose samples are `finer` times those of the data, at
/// lags in samples of data that lie [`Data::apart`].
fn energies(graph: &Graph, node: NodeIndex, finer: u8, lags: &[f64]) -> Vec<f64> {
    const SIDE: i64 = 768;
    let level = LevelKey::new(DATA.m + finer, DATA.n + finer);
    let at = at_level(200, finer);
    let heights = evaluate(graph, node, level, SampleRect::at(at.x, at.y, SIDE, SIDE));
    let surface = Surface::new(&heights, SIDE as usize, 1.0, |_| 1.0);
    let side = 0..SIDE as usize;
    let found = lags.iter().map(|lag| {
        let lag = (lag * f64::from(1 << finer) / APART).round() as usize;
        surface
            .energy(lag, side.clone(), side.clone())
            .mean_m2()
            .unwrap()
    });
    found.collect()
}

#[test]
fn the_law_of_the_data_goes_on_below_their_resolution_without_a_step() {
    for (exponent, method) in [
        (0.6, DetailMethod::Simplex),
        (0.9, DetailMethod::Simplex),
        (0.75, DetailMethod::Spectral),
    ] {
        let data = Data::new(middle(), power_law(exponent)).apart();
        let continued = DetailParams {
            slope: 0.0,
            method,
            spacing_m: spacing_m() / APART,
            ..params()
        };
        let (graph, [data, detail, _]) = graph(data, &continued);
        // From the eighth of a sample, where all is made up, to 8 samples, where all was measured.
        let mut before: Option<f64> = None;
        let of_levels = [
            (5, &[0.125, 0.25, 0.5][..]),
            (3, &[1.0, 2.0, 4.0]),
            (2, &[8.0]),
        ];
        for (finer, lags) in of_levels {
            let found = energies(&graph, detail, finer, lags);
            let bare = energies(&graph, data, finer, lags);
            for ((lag, found), bare) in lags.iter().zip(found).zip(bare) {
                let off_db = 10.0 * libm::log10(found / law_m2(exponent, *lag));
                let bare_db = 10.0 * libm::log10(bare / law_m2(exponent, *lag));
                assert!(
                    off_db.abs() < 1.5,
                    "{exponent} {method:?} {lag}: {off_db} dB"
                );
                if let Some(before) = before {
                    assert!(
                        (off_db - before).abs() < 0.8,
                        "{lag}: {before} to {off_db} dB"
                    );
                }
                before = Some(off_db);
                assert!(
                    *lag > 0.6 || bare_db < -7.0,
                    "{lag}: the data have {bare_db} dB"
                );
            }
        }
    }
}

#[test]
fn a_whole_equals_its_parts_across_patches_the_antimeridian_and_a_pole() {
    let all = DATA.extent();
    let rough = |x: i64, y: i64| {
        let (u, v) = (x as f64 / DATA.samples().x as f64 * TAU, y as f64 * 0.4);
        (60.0 * libm::sin(90.0 * u) + 40.0 * libm::sin(v + 30.0 * u)) as f32
    };
    let near_pole = SampleRect::at(all.min.x, 0, all.width(), 90);
    let (graph, [_, detail, _]) = graph(Data::new(near_pole, rough), &params());
    let level = LevelKey::new(7, 12);
    let size = level.samples();
    // Rows beyond the pole, columns beyond the antimeridian.
    let rect = SampleRect::at(size.x - 40, -20, 80, 60);
    let whole = evaluate(&graph, detail, level, rect);
    assert!(whole.iter().all(|h| h.is_finite()));
    for part in [
        SampleRect::at(rect.min.x, rect.min.y, 33, 25),
        SampleRect::at(-7, 0, 12, 40),
        SampleRect::at(size.x - 1, -1, 2, 2),
    ] {
        let found = evaluate(&graph, detail, level, part);
        for (i, h) in found.iter().enumerate() {
            let at = part.min + I64Vec2::new(i as i64 % part.width(), i as i64 / part.width());
            let column = (at.x - rect.min.x).rem_euclid(size.x);
            let of_whole = whole[((at.y - rect.min.y) * rect.width() + column) as usize];
            assert_eq!(h.to_bits(), of_whole.to_bits(), "{at}");
        }
    }
}

#[test]
fn detail_is_continuous_where_patches_meet() {
    let (graph, [data, detail, _]) = graph(Data::new(middle(), power_law(0.8)), &params());
    // Along a row across the border of two patches, in samples of a 64th of the data's.
    let level = LevelKey::new(DATA.m + 6, DATA.n + 6);
    let border = (middle().min.x + 256) << 6;
    let row = (middle().min.y + 300) << 6;
    let rect = SampleRect::at(border - 512, row, 1024, 1);
    let added: Vec<f32> = evaluate(&graph, detail, level, rect)
        .iter()
        .zip(evaluate(&graph, data, level, rect))
        .map(|(h, d)| h - d)
        .collect();
    let steps: Vec<f32> = added.windows(2).map(|w| (w[1] - w[0]).abs()).collect();
    let largest = steps.iter().copied().fold(0.0, f32::max);
    assert!(
        largest > 0.0 && steps[511] < 0.8 * largest,
        "{} {largest}",
        steps[511]
    );
}

#[test]
fn level_water_stays_level_and_holes_stay_holes() {
    let hills = power_law(0.7);
    let (left, top) = (middle().min.x, middle().min.y);
    let water = SampleRect::at(left + 280, top + 280, 40, 40);
    let hole = SampleRect::at(left + 380, top + 280, 30, 30);
    let data = Data::new(middle(), |x, y| {
        let at = I64Vec2::new(x, y);
        if water.contains(at) {
            100.0
        } else if hole.contains(at) {
            f32::NAN
        } else {
            200.0 + hills(x, y)
        }
    });
    let (graph, [data, detail, amount]) = graph(data, &params());
    let level = LevelKey::new(DATA.m + 2, DATA.n + 2);
    let rect = SampleRect::at((left + 270) << 2, (top + 275) << 2, 600, 200);
    let [data, detail, amount] = [data, detail, amount].map(|n| evaluate(&graph, n, level, rect));
    let mut changed = 0;
    for ((d, h), a) in data.iter().zip(&detail).zip(&amount) {
        assert_eq!(d.is_nan(), h.is_nan());
        assert_eq!(d.is_nan(), a.is_nan());
        if *d == 100.0 {
            assert_eq!(h, d);
        }
        changed += usize::from(h != d && !d.is_nan() && *a > 0.0);
    }
    assert!(data.iter().filter(|h| **h == 100.0).count() > 10_000);
    assert!(data.iter().any(|h| h.is_nan()));
    assert!(changed > 60_000, "{changed}");
}

#[test]
fn steeper_ground_is_rougher_and_a_region_keeps_its_energy() {
    // Ridges and plains side by side, rough by the same law.
    let hills = power_law(0.8);
    let shape = |x: i64, y: i64| {
        let across = (x.rem_euclid(64) - 32).abs() as f32;
        0.2 * hills(x, y) + 60.0 * (across - 12.0).max(0.0)
    };
    let of = |slope: f64| {
        let with = DetailParams { slope, ..params() };
        let (graph, [_, _, amount]) = graph(Data::new(middle(), shape), &with);
        let level = LevelKey::new(DATA.m + 2, DATA.n + 2);
        let at = at_level(256, 2);
        let amounts = evaluate(&graph, amount, level, SampleRect::at(at.x, at.y, 512, 256));
        let mean = |steep: bool| {
            let of_kind = amounts.iter().enumerate().filter(|(i, _)| {
                let x = (at.x + *i as i64 % 512) >> 2;
                let across = (x.rem_euclid(64) - 32).abs();
                if steep { across > 20 } else { across < 5 }
            });
            let squares: Vec<f64> = of_kind.map(|(_, a)| f64::from(*a).powi(2)).collect();
            squares.iter().sum::<f64>() / squares.len() as f64
        };
        let whole = amounts.iter().map(|a| f64::from(*a).powi(2)).sum::<f64>();
        (mean(true) / mean(false), whole / amounts.len() as f64)
    };
    let (even, shaped) = (of(0.0), of(1.0));
    assert!((0.8..1.25).contains(&even.0), "{even:?}");
    assert!(shaped.0 > 2.0, "{shaped:?}");
    assert!(
        (0.6..1.6).contains(&(shaped.1 / even.1)),
        "{even:?} {shaped:?}"
    );
}

#[test]
fn ground_outside_of_the_range_of_heights_is_as_the_data_say() {
    let hills = power_law(0.8);
    let ramp = |x: i64, y: i64| 0.01 * hills(x, y) + 2.0 * (x - middle().min.x - 310) as f32;
    let ranged = DetailParams {
        heights_m: [0.0, 200.0],
        fade_m: 20.0,
        ..params()
    };
    let (graph, nodes) = graph(Data::new(middle(), ramp), &ranged);
    let level = LevelKey::new(DATA.m + 3, DATA.n + 3);
    let at = at_level(290, 3);
    let rect = SampleRect::at(at.x, at.y, 400, 400);
    let [data, detail, _] = nodes.map(|node| evaluate(&graph, node, level, rect));
    let pairs = || data.iter().zip(&detail);
    assert!(pairs().all(|(d, h)| d == h || (*d > 0.0 && *d < 200.0)));
    assert!(pairs().any(|(d, h)| d != h) && pairs().any(|(d, _)| *d <= 0.0));
}

#[test]
fn a_grid_too_coarse_to_show_detail_shares_the_name_of_the_data() {
    let (graph, [data, detail, _]) = graph(Data::new(middle(), power_law(0.8)), &params());
    let name = |node, level: LevelKey| {
        let size = level.samples();
        let rect = SampleRect::at(size.x / 2, size.y / 2, 16, 16);
        graph.evaluation_id(node, &Grid::new(Arc::new(level.lattice()), rect))
    };
    let coarse = LevelKey::new(DATA.m - 3, DATA.n - 3);
    assert_eq!(name(data, coarse), name(detail, coarse));
    let fine = LevelKey::new(DATA.m, DATA.n);
    assert_ne!(name(data, fine), name(detail, fine));
}

#[test]
fn a_projected_grid_has_the_same_detail() {
    let (graph, [data, detail, _]) = graph(Data::new(middle(), power_law(0.8)), &params());
    // Plate carrée in metres, laid exactly on the samples of a level.
    let level = LevelKey::new(DATA.m + 2, DATA.n + 2);
    let at = at_level(250, 2);
    let rect = SampleRect::at(at.x, at.y, 40, 30);
    let on_map = evaluate(&graph, detail, level, rect);
    let radius_m = 6_378_137.0;
    let step_m = level.step_rad() * radius_m;
    let corner = level.lattice().origin + at.as_dvec2() * level.step_rad();
    let crs = "+proj=eqc +lat_ts=0 +lat_0=0 +lon_0=0 +x_0=0 +y_0=0 +R=6378137 +units=m +no_defs";
    let lattice = relievo_planet::Lattice {
        crs: GridCrs::Projected(crs.into()),
        origin: glam::DVec2::new(corner.x, core::f64::consts::FRAC_PI_2 - corner.y) * radius_m,
        step: glam::DVec2::new(step_m.x, -step_m.y),
        columns_around: None,
    };
    let grid = Grid::new(
        Arc::new(lattice),
        SampleRect::at(0, 0, rect.width(), rect.height()),
    );
    let [data, detail] = [data, detail].map(|node| {
        let block = graph.evaluate(node, &grid, &Cancel::default()).unwrap();
        block.samples().to_vec()
    });
    for (on_map, projected) in on_map.iter().zip(&detail) {
        // The longer side of a sample is one of the ellipsoid's there, and fades the shortest octave.
        assert!((on_map - projected).abs() < 0.3, "{on_map} {projected}");
    }
    assert!(data.iter().zip(&detail).any(|(d, h)| (d - h).abs() > 1.0));
}

#[test]
fn wild_parameters_are_tamed() {
    for v in [f64::NAN, f64::INFINITY, -1e300, 0.0] {
        let wild = DetailParams {
            strength: v,
            slope: v,
            heights_m: [v, v],
            fade_m: v,
            shortest_m: v,
            spacing_m: v,
            ..params()
        };
        let node = Detail::new(Planet::EARTH, &wild);
        assert!(node.octaves.len() <= 40 && node.params.spacing_m > 0.0);
    }
    let nothing = DetailParams {
        strength: 0.0,
        ..params()
    };
    assert_eq!(
        Detail::new(Planet::EARTH, &nothing).synthesised_below_m(),
        None
    );
}

#[test]
fn same_data_same_bits_whatever_is_asked_first() {
    let [first, second] = [false, true].map(|early| {
        let (graph, [_, detail, _]) = graph(Data::new(middle(), power_law(0.7)), &params());
        let level = LevelKey::new(DATA.m + 1, DATA.n + 1);
        let at = at_level(250, 1);
        if early {
            evaluate(
                &graph,
                detail,
                level,
                SampleRect::at(at.x - 200, at.y, 9, 400),
            );
        }
        bits(&evaluate(
            &graph,
            detail,
            level,
            SampleRect::at(at.x, at.y, 64, 64),
        ))
    });
    assert_eq!(first, second);
}
