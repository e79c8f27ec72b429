//! The clipmaps' pictures against the reference, for windows, taps and rules of the focus.

use core::cell::RefCell;

use relievo_engine::planet::clipmap::FocusRule;
use relievo_engine::{Layout, ReferencePicture};
use relievo_gpu::{AdapterClass, Gpu, Quality, Still};

use crate::metric::{Lab, PictureError, Seen, ciede2000, from_rgba8};
use crate::scene::{Shot, open, shots, standard, still, truth, view};
use crate::timing::in_turns;
use crate::{
    Cell, Chart, Content, Context, Curve, Figure, Picture, Point, Report, Spread, Suite,
    SuiteError, Table, Work,
};

/// The suite.
pub const SUITE: Suite = Suite {
    name: "colour",
    sentence: "The picture of the clipmaps against the reference renderer: colour differences, noise and structure, by window, taps and where the focus lies.",
    run,
};

/// The colour difference that is white in a map of differences.
const MAP_DE: f64 = 10.0;

/// One way to draw.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Setting {
    window: u32,
    taps: u32,
    focus: FocusRule,
}

impl Setting {
    fn quality(self, gpu: &Gpu) -> Quality {
        Quality {
            layout: Layout {
                focus: self.focus,
                ..Layout::STANDARD
            },
            colour_window: self.window,
            max_taps: self.taps,
            ..standard(gpu)
        }
    }

    fn name(self) -> String {
        format!("N {}, {} taps", self.window, self.taps)
    }

    /// Whether the focus lies where it does by default.
    fn has_own_focus(self) -> bool {
        self.focus == Layout::STANDARD.focus
    }
}

/// One way to draw, measured.
#[derive(Clone, Copy, Debug)]
struct Measured {
    setting: Setting,
    error: PictureError,
    frame_ms: Spread,
}

fn settings(context: &Context, gpu: &Gpu) -> Vec<Setting> {
    let windows: &[u32] = match (context.quick, gpu.class) {
        (true, _) => &[256, 1024],
        (false, AdapterClass::Software) => &[256, 512, 1024],
        (false, AdapterClass::Integrated | AdapterClass::Discrete) => &[256, 512, 1024, 2048, 4096],
    };
    let taps: &[u32] = if context.quick {
        &[1, 8]
    } else {
        &[1, 4, 8, 16]
    };
    let of = |window: u32, taps: u32, focus: FocusRule| Setting {
        window,
        taps,
        focus,
    };
    let pairs = windows.iter().flat_map(|window| {
        let own = Layout::STANDARD.focus;
        taps.iter().map(move |taps| of(*window, *taps, own))
    });
    let others = FocusRule::ALL
        .into_iter()
        .filter(|focus| *focus != Layout::STANDARD.focus);
    let foci = others.flat_map(|focus| {
        let count = context.pick(1, FOCUS_WINDOWS.len());
        let compared = FOCUS_WINDOWS.iter().take(count);
        compared.map(move |window| of(*window, FOCUS_TAPS, focus))
    });
    // The last one's picture is shown.
    foci.chain(pairs).collect()
}

/// Taps with which rules of the focus are compared.
const FOCUS_TAPS: u32 = 8;

/// Windows with which they are compared.
const FOCUS_WINDOWS: [u32; 2] = [256, 1024];

fn focus_name(focus: FocusRule) -> &'static str {
    match focus {
        FocusRule::Nadir => "below the eye, [CH06]",
        FocusRule::Ahead => "ahead, at most three heights",
        FocusRule::Centre => "at the picture's middle",
    }
}

fn run(context: &Context) -> Result<Report, SuiteError> {
    let gpu = match context.gpu() {
        Ok(gpu) => gpu,
        Err(why) => return Ok(without("pictures of the clipmaps", why)),
    };
    let mut engine = open(context)?;
    let shots = shots(&engine, context)?;
    let settings = settings(context, gpu);
    let size_px = context.picture_px([96, 72], [480, 320]);
    let mut report = Report::default();
    let (mut rows, mut foci) = (Vec::new(), Vec::new());
    let (each, steps) = (settings.len() + 1, shots.len() * (settings.len() + 1));
    for (index, shot) in shots.iter().enumerate() {
        context.step(index * each, steps)?;
        let (reference, confirmed) = truth(&engine, shot.camera, size_px, context)?;
        let mut stills = Vec::new();
        for (done, setting) in settings.iter().enumerate() {
            context.step(index * each + done + 1, steps)?;
            let quality = setting.quality(gpu);
            let view = view(&engine, shot.camera, size_px, &quality);
            let drawn = still(&mut engine, gpu, view, quality, &context.cancel)?;
            stills.push(drawn);
        }
        let measured = measure(context, gpu, &settings, &mut stills, &reference)?;
        report.figures.push(trade(shot, index, &measured));
        report.figures.push(by_focus(shot, index, &measured));
        foci.extend(focus_rows(shot, &measured));
        let seen = pictures(shot, index, &reference, &settings, &stills)?;
        report.figures.push(seen);
        let means = measured.iter().map(|m| m.error.mean_de);
        report.summary.push(format!(
            "{}: the nearest picture differs from the truth by {:.2} of CIEDE2000 on average; halving the \
             truth's own spacing changes display values by {:.4} on average.",
            shot.name,
            means.fold(f64::INFINITY, f64::min),
            confirmed.mean
        ));
        let own = measured.iter().filter(|m| m.setting.has_own_focus());
        rows.extend(own.map(|m| row(shot, m, confirmed.mean)));
    }
    report.figures.push(table(rows));
    report.figures.push(focus_table(foci));
    Ok(report)
}

/// What is told where there is no adapter.
pub(super) fn without(what: &str, why: &str) -> Report {
    let table = Table {
        head: vec!["what".to_owned(), "why not".to_owned()],
        rows: vec![vec![what.into(), why.into()]],
    };
    let caption = "This needs a graphics adapter; a software one will do.";
    let missing = Figure::new("missing", "Not measured", caption, Content::Table(table));
    Report {
        summary: vec![format!("Nothing was measured: {why}.")],
        figures: vec![missing],
    }
}

fn measure(
    context: &Context,
    gpu: &Gpu,
    settings: &[Setting],
    stills: &mut [Still],
    reference: &ReferencePicture,
) -> Result<Vec<Measured>, SuiteError> {
    let truth = Seen {
        size_px: [reference.width as usize, reference.height as usize],
        pixels: &reference.pixels,
    };
    let mut errors = Vec::new();
    for still in stills.iter() {
        let pixels = shown(still)?;
        let seen = Seen {
            pixels: &pixels,
            ..truth
        };
        errors.push(PictureError::between(&truth, &seen));
    }
    let times = frame_times(context, gpu, stills)?;
    let measured = settings.iter().zip(errors).zip(times);
    Ok(measured
        .map(|((setting, error), frame_ms)| Measured {
            setting: *setting,
            error,
            frame_ms,
        })
        .collect())
}

/// Milliseconds a frame of each still, drawn again in turns.
pub(super) fn frame_times(
    context: &Context,
    gpu: &Gpu,
    stills: &mut [Still],
) -> Result<Vec<Spread>, SuiteError> {
    let failed = RefCell::new(None);
    let mut works: Vec<Work> = stills
        .iter_mut()
        .map(|still| {
            let failed = &failed;
            Work::new(1.0, move || {
                if let Err(error) = still.redraw(gpu) {
                    let error = SuiteError::System(error.to_string());
                    failed.borrow_mut().get_or_insert(error);
                }
            })
        })
        .collect();
    let times = in_turns(context, &mut works)?;
    drop(works);
    match failed.into_inner() {
        Some(error) => Err(error),
        None => Ok(times.into_iter().map(|ns| ns.times(1e-6)).collect()),
    }
}

/// Display values of a still.
pub(super) fn shown(still: &Still) -> Result<Vec<[f32; 3]>, SuiteError> {
    let picture = still.renderer.read_back();
    let picture = picture.map_err(|error| SuiteError::System(error.to_string()))?;
    Ok(from_rgba8(&picture.rgba))
}

fn trade(shot: &Shot, index: usize, measured: &[Measured]) -> Figure {
    let own = measured.iter().filter(|m| m.setting.has_own_focus());
    let points = own.map(|m| {
        let setting = format!("{} taps", m.setting.taps);
        let point = Point::timed(setting, m.frame_ms, m.error.mean_de);
        (format!("N {}", m.setting.window), point)
    });
    let curves = Curve::grouped(points);
    let chart = Chart::trade("ms per frame", "mean colour difference", "ΔE00", curves);
    Figure::new(
        format!("trade-{}", index + 1),
        format!("Colour difference against frame time: {}", shot.name),
        "Mean CIEDE2000 of the clipmaps' picture against the reference (4 × 4 rays a pixel, samples a \
         quarter of a pixel), for windows of N samples a side and taps along a footprint. A frame's time \
         includes waiting for the device.",
        Content::Chart(chart),
    )
}

/// Those with as many taps as rules of the focus are compared with.
fn compared(measured: &[Measured]) -> impl Iterator<Item = &Measured> {
    measured.iter().filter(|m| {
        let setting = m.setting;
        setting.taps == FOCUS_TAPS && FOCUS_WINDOWS.contains(&setting.window)
    })
}

fn by_focus(shot: &Shot, index: usize, measured: &[Measured]) -> Figure {
    let points = compared(measured).map(|m| {
        let setting = format!("N {}", m.setting.window);
        let point = Point::timed(setting, m.frame_ms, m.error.mean_de);
        (focus_name(m.setting.focus).to_owned(), point)
    });
    let curves = Curve::grouped(points);
    let chart = Chart::trade("ms per frame", "mean colour difference", "ΔE00", curves);
    Figure::new(
        format!("focus-{}", index + 1),
        format!("Where the focus of the clipmaps lies: {}", shot.name),
        format!(
            "Mean CIEDE2000 against the reference with {FOCUS_TAPS} taps, for windows of N samples a side."
        ),
        Content::Chart(chart),
    )
}

fn focus_rows(shot: &Shot, measured: &[Measured]) -> Vec<Vec<Cell>> {
    let row = |m: &Measured| -> Vec<Cell> {
        vec![
            shot.name.into(),
            focus_name(m.setting.focus).into(),
            f64::from(m.setting.window).into(),
            m.frame_ms.median.into(),
            m.error.mean_de.into(),
            m.error.p99_de.into(),
        ]
    };
    compared(measured).map(row).collect()
}

fn focus_table(rows: Vec<Vec<Cell>>) -> Figure {
    let head = [
        "view",
        "focus",
        "window N, samples",
        "frame, ms",
        "mean ΔE00",
        "p99 ΔE00",
    ];
    Figure::new(
        "focus-table",
        "Rules of the focus",
        format!("With {FOCUS_TAPS} taps."),
        Content::Table(Table {
            head: head.map(str::to_owned).to_vec(),
            rows,
        }),
    )
}

/// The truth, the last setting's picture and where they differ, side by side.
fn pictures(
    shot: &Shot,
    index: usize,
    reference: &ReferencePicture,
    settings: &[Setting],
    stills: &[Still],
) -> Result<Figure, SuiteError> {
    let (Some(setting), Some(still)) = (settings.last(), stills.last()) else {
        return Err(SuiteError::System("no setting was drawn".to_owned()));
    };
    let pixels = shown(still)?;
    let (width, height) = (reference.width as usize, reference.height as usize);
    let mut rgba = Vec::with_capacity(12 * width * height);
    let byte = |v: f32| (v.clamp(0.0, 1.0) * 255.0).round() as u8;
    for row in 0..height {
        let line = row * width..(row + 1) * width;
        for picture in [&reference.pixels, &pixels] {
            let bytes = picture[line.clone()].iter();
            rgba.extend(bytes.flat_map(|p| [byte(p[0]), byte(p[1]), byte(p[2]), 255]));
        }
        for (a, b) in reference.pixels[line.clone()].iter().zip(&pixels[line]) {
            let difference = ciede2000(Lab::from_srgb(*a), Lab::from_srgb(*b));
            let grey = byte((difference / MAP_DE) as f32);
            rgba.extend([grey, grey, grey, 255]);
        }
    }
    let described = format!(
        "Left the reference, in the middle the clipmaps with {}, right their colour difference from black \
         (none) to white ({MAP_DE} of CIEDE2000 or more)",
        setting.name()
    );
    let picture = Picture::from_rgba8(3 * reference.width, reference.height, &rgba, &described)?;
    Ok(Figure::new(
        format!("pictures-{}", index + 1),
        format!("Truth, clipmaps, difference: {}", shot.name),
        format!("{described}."),
        Content::Picture(picture),
    ))
}

fn row(shot: &Shot, m: &Measured, truth_mean: f64) -> Vec<Cell> {
    vec![
        shot.name.into(),
        f64::from(m.setting.window).into(),
        f64::from(m.setting.taps).into(),
        m.frame_ms.median.into(),
        m.error.psnr_db.into(),
        m.error.ssim.into(),
        m.error.mean_de.into(),
        m.error.p99_de.into(),
        m.error.max_de.into(),
        truth_mean.into(),
    ]
}

fn table(rows: Vec<Vec<Cell>>) -> Figure {
    let head = [
        "view",
        "window N, samples",
        "taps",
        "frame, ms",
        "PSNR, dB",
        "SSIM of L*",
        "mean ΔE00",
        "p99 ΔE00",
        "max ΔE00",
        "truth, halved spacing, mean of 1",
    ];
    Figure::new(
        "table",
        "All settings",
        "PSNR of display values; SSIM of lightness ([WBSS04]); CIEDE2000 ([SWD05]).",
        Content::Table(Table {
            head: head.map(str::to_owned).to_vec(),
            rows,
        }),
    )
}
