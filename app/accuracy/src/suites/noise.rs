//! Fractal noise: how near its spectrum is to the power law that its parameters state.
//!
//! Octaves whose wavelengths shrink by the lacunarity and whose amplitudes shrink by the gain stand for a
//! surface whose heights grow as wavelength to the power of H = −ln gain / ln lacunarity; along any line its
//! power falls as frequency to the power of −(2 H + 1). Bands that lie far apart leave gaps in it; bands
//! that lie close cost more.

mod spectrum;

use core::f64::consts::FRAC_PI_2;
use core::hint::black_box;
use std::sync::Arc;

use glam::DVec2;
use relievo_engine::graph::nodes::noise::{Noise, NoiseParams};
use relievo_engine::graph::{ImageNode, Job};
use relievo_engine::planet::{Grid, GridCrs, Lattice, Planet, SampleRect};
use relievo_engine::raster::{Bands, Block, Cancel};

use crate::timing::in_turns;
use crate::{
    Axis, Chart, Content, Context, Curve, Figure, Point, Report, Spread, Suite, SuiteError, Table,
    Work,
};
use spectrum::{Band, Fit, bands, fit};

/// The suite.
pub const SUITE: Suite = Suite {
    name: "noise",
    sentence: "Fractal noise: how near the spectrum of its bands is to the power law that it states, against their cost.",
    run,
};

/// Metres of a sample.
const SPACING_M: f64 = 100.0;

/// Wavelength of the first octave, samples.
const LONGEST: f64 = 512.0;

/// Finest wavelength, samples: nothing finer can be shown.
const SHORTEST: f64 = 2.0;

/// Wavelengths between which the law is judged, samples: all octaves about them are whole.
const JUDGED: [f64; 2] = [8.0, 128.0];

/// Ratios of an octave's wavelength to the next one's.
const LACUNARITIES: [f64; 7] = [1.25, 1.5, 1.8, 2.0, 2.5, 3.0, 4.0];

/// A family of settings.
#[derive(Clone, Copy)]
struct Family {
    /// For file names.
    key: &'static str,
    name: &'static str,
    /// H.
    roughness: f64,
    ridged: bool,
}

const FAMILIES: [Family; 3] = [
    Family {
        key: "smooth",
        name: "smooth ground (H = 1)",
        roughness: 1.0,
        ridged: false,
    },
    Family {
        key: "rough",
        name: "rough ground (H = 0.5)",
        roughness: 0.5,
        ridged: false,
    },
    Family {
        key: "ridges",
        name: "ridges (H = 1)",
        roughness: 1.0,
        ridged: true,
    },
];

/// A setting with what was found of it.
struct Setting {
    family: Family,
    lacunarity: f64,
    octaves: u32,
    node: Noise,
    bands: Vec<Band>,
    fit: Fit,
}

fn run(context: &Context) -> Result<Report, SuiteError> {
    let mut settings = Vec::new();
    let all = FAMILIES.len() * LACUNARITIES.len();
    for family in FAMILIES {
        for lacunarity in LACUNARITIES {
            context.step(settings.len(), all + 4)?;
            settings.push(setting(context, family, lacunarity)?);
        }
    }
    let side = context.pick(64, 256);
    let tile = tile(side);
    let mut works: Vec<Work> = settings
        .iter()
        .map(|setting| {
            let mut out = Block::new(Bands::Height, side as usize, side as usize);
            let (node, tile) = (&setting.node, &tile);
            Work::new(tile.rect.area() as f64, move || {
                // Whether it works was seen before.
                let done = render(node, black_box(tile), &mut out);
                black_box((&done, &out));
            })
        })
        .collect();
    let times = in_turns(context, &mut works)?;
    drop(works);
    let of_families = settings.chunks(LACUNARITIES.len());
    let mut figures: Vec<Figure> = of_families
        .zip(times.chunks(LACUNARITIES.len()))
        .map(|(settings, times)| trade(settings, times))
        .collect();
    figures.extend([spectra(&settings), table(&settings)]);
    Ok(Report {
        summary: summary(&settings),
        figures,
    })
}

/// Error against time of the settings of a family.
fn trade(settings: &[Setting], times: &[Spread]) -> Figure {
    let family = settings[0].family;
    let points = settings.iter().zip(times).map(|(setting, time)| {
        let name = format!(
            "lacunarity {} ({} octaves)",
            setting.lacunarity, setting.octaves
        );
        Point::timed(name, *time, setting.fit.error_db)
    });
    let curve = Curve {
        name: family.name.to_owned(),
        points: points.collect(),
        joined: true,
    };
    let caption = "Octaves from 512 samples down to 2, gain = lacunarity to the power of −H. Error: root mean square deviation, in \
                   decibels, of the power in third-octave bands from 8 to 128 samples from the stated power law (its constant fitted, \
                   its slope not). Power: Hann-windowed periodograms of lines along the equator. One thread, a square of 256² samples (64² in a quick run).";
    let chart = Chart::trade(
        "ns per sample",
        "deviation from the power law",
        "dB",
        vec![curve],
    );
    Figure::new(
        family.key,
        format!("Spectral error against time, {}", family.name),
        caption,
        Content::Chart(chart),
    )
}

/// A setting and its spectrum.
fn setting(context: &Context, family: Family, lacunarity: f64) -> Result<Setting, SuiteError> {
    let span = LONGEST / SHORTEST;
    let octaves = libm::floor(libm::log(span) / libm::log(lacunarity) + 1e-9) as u32 + 1;
    let node = Noise::new(
        Planet::EARTH,
        &NoiseParams {
            seed: 7,
            amplitude_m: 100.0,
            wavelength_m: LONGEST * SPACING_M,
            octaves,
            lacunarity,
            gain: libm::pow(lacunarity, -family.roughness),
            ridged: family.ridged,
        },
    );
    let (length, lines) = context.pick((1024, 20), (4096, 128));
    let mut heights = Vec::new();
    for line in 0..lines {
        // Lines far apart, along the equator and nearly as long as it allows.
        let mut out = Block::new(Bands::Height, length, 1);
        render(&node, &row(line, length), &mut out)?;
        heights.push(out.samples().to_vec());
    }
    let bands = bands(&heights);
    let fit = fit(&bands, JUDGED, stated_slope(family));
    Ok(Setting {
        family,
        lacunarity,
        octaves,
        node,
        bands,
        fit,
    })
}

/// The power of frequency that power is in proportion to.
fn stated_slope(family: Family) -> f64 {
    -(2.0 * family.roughness + 1.0)
}

/// A lattice of square samples about the equator.
fn lattice() -> Arc<Lattice> {
    let step = SPACING_M / Planet::EARTH.radius_m;
    Arc::new(Lattice {
        crs: GridCrs::Map,
        origin: DVec2::new(0.0, FRAC_PI_2),
        step: DVec2::splat(step),
        columns_around: None,
    })
}

/// The samples of a line, no two of which lie within a wavelength of each other.
fn row(line: i64, length: usize) -> Grid {
    let apart = 2 * LONGEST as i64;
    let (column, row) = (line % 8 * (length as i64 + apart), (line / 8 - 4) * apart);
    Grid::new(lattice(), SampleRect::at(column, row, length as i64, 1))
}

fn tile(side: i64) -> Grid {
    Grid::new(lattice(), SampleRect::at(0, 0, side, side))
}

fn render(node: &Noise, grid: &Grid, out: &mut Block) -> Result<(), SuiteError> {
    let job = Job {
        grid,
        cancel: &Cancel::default(),
    };
    node.render(&job, &[], out)
        .map_err(|error| SuiteError::System(error.to_string()))
}

/// The spectra of one family beside the law.
fn spectra(settings: &[Setting]) -> Figure {
    let shown = |lacunarity: &f64| [1.5, 2.0, 4.0].contains(lacunarity);
    let first = settings
        .iter()
        .take(LACUNARITIES.len())
        .filter(|setting| shown(&setting.lacunarity));
    let mut curves: Vec<Curve> = first
        .clone()
        .map(|setting| {
            let points = setting.bands.iter().map(|band| {
                let name = format!("{:.1} samples", band.wavelength);
                // Beside the law at the same place: what is left is the deviation.
                Point::new(name, band.wavelength, setting.fit.deviation_db(band))
            });
            Curve {
                name: format!("lacunarity {}", setting.lacunarity),
                points: points.collect(),
                joined: true,
            }
        })
        .collect();
    let law = JUDGED.map(|wavelength| Point::new("", wavelength, 0.0));
    curves.push(Curve {
        name: "the power law, where it is judged".to_owned(),
        points: law.to_vec(),
        joined: true,
    });
    let chart = Chart {
        x: Axis::log("wavelength", "samples"),
        y: Axis::linear("power beside the power law", "dB"),
        curves,
        marks_front: false,
    };
    let caption = "Power in third-octave bands divided by the power law fitted to it. Octaves fade out from 4 to 2 samples, so that \
                   nothing is aliased; longer than the first octave there is nothing.";
    Figure::new(
        "spectra",
        "Spectra, smooth ground",
        caption,
        Content::Chart(chart),
    )
}

fn table(settings: &[Setting]) -> Figure {
    let head = [
        "ground",
        "lacunarity",
        "octaves",
        "stated slope",
        "fitted slope",
        "deviation from the law, dB",
        "worst band, dB",
    ];
    let rows = settings.iter().map(|setting| {
        vec![
            setting.family.name.into(),
            setting.lacunarity.into(),
            f64::from(setting.octaves).into(),
            stated_slope(setting.family).into(),
            setting.fit.slope.into(),
            setting.fit.error_db.into(),
            setting.fit.worst_db.into(),
        ]
    });
    let table = Table {
        head: head.map(str::to_owned).to_vec(),
        rows: rows.collect(),
    };
    let caption = "Slopes are exponents of frequency in the power along a line. The deviation includes what a finite number of lines \
                   leaves to chance: about 0.1 dB, 0.5 dB in a quick run.";
    Figure::new(
        "table",
        "Slopes and deviations",
        caption,
        Content::Table(table),
    )
}

fn summary(settings: &[Setting]) -> Vec<String> {
    let of = |lacunarity: f64| {
        settings
            .iter()
            .find(|setting| setting.lacunarity == lacunarity)
            .map_or(f64::NAN, |setting| setting.fit.error_db)
    };
    let text = crate::number::text;
    vec![format!(
        "With the usual lacunarity of 2 the spectrum of the noise stays within {} dB of its power law (root mean square over third-octave \
         bands). Bands at every factor of 1.5 bring that to {} dB; bands at every factor of 4 cost half as much, \
         and leave gaps: {} dB.",
        text(of(2.0)),
        text(of(1.5)),
        text(of(4.0)),
    )]
}
