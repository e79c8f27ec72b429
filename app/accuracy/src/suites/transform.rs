//! The map transform of ring vertices: the forms that \[CH06\] prints, and the one without cancellation.
//!
//! Errors are computed by `relievo_planet::transform::forms`, on the CPU and on the device alike; a
//! test there holds the truth against numbers of 40 digits.

mod device;

use core::hint::black_box;

use glam::Vec2;
use relievo_engine::planet::Planet;
use relievo_engine::planet::transform::classic::{APPROXIMATE_FROM_POLE_RAD, ClassicFocus};
use relievo_engine::planet::transform::forms::{
    COLATITUDES, Form, LEVELS, ground_error_rad, ring_radius_rad, ring_vertices,
};

use crate::timing::in_turns;
use crate::{
    Axis, Chart, Content, Context, Curve, Figure, Point, Report, Spread, Suite, SuiteError, Table,
    Work,
};

/// The suite.
pub const SUITE: Suite = Suite {
    name: "transform",
    sentence: "From a ring's vertex to its place on the map: five forms in single precision, by level and colatitude.",
    run,
};

/// Where forms are compared: within what they are all meant for, and everywhere.
struct Domain {
    /// For file names.
    name: &'static str,
    title: &'static str,
    /// Coarsest level.
    from_level: u32,
    /// Whether places nearer than π/48 to a pole, where \[CH06\] does not approximate, count.
    poles: bool,
    /// The level whose ring is timed.
    timed_level: u32,
}

impl Domain {
    fn holds(&self, error: &Error) -> bool {
        error.level >= self.from_level && (self.poles || error.is_away_from_poles())
    }
}

const DOMAINS: [Domain; 2] = [
    Domain {
        name: "",
        title: "levels 10 and finer, away from the poles",
        from_level: FINE,
        poles: false,
        timed_level: 17,
    },
    Domain {
        name: "-all",
        title: "all levels and colatitudes",
        from_level: 1,
        poles: true,
        timed_level: 5,
    },
];

/// The first level at which \[CH06\] approximates.
const FINE: u32 = 10;

/// Samples of the colour window whose texels count.
const WINDOW: f64 = 1024.0;

/// Colatitude at which forms are timed.
const TIMED_COLAT_RAD: f64 = 0.9;

/// Where a form is evaluated.
trait Evaluator {
    /// (Δφ, Δθ) of stored vertices.
    fn deltas(
        &self,
        form: Form,
        vertices: &[[f32; 3]],
        colat_rad: f64,
    ) -> Result<Vec<Vec2>, SuiteError>;
}

/// On this processor.
struct Cpu;

impl Evaluator for Cpu {
    fn deltas(
        &self,
        form: Form,
        vertices: &[[f32; 3]],
        colat_rad: f64,
    ) -> Result<Vec<Vec2>, SuiteError> {
        let mut deltas = vec![Vec2::ZERO; vertices.len()];
        form.map_deltas(vertices, &ClassicFocus::new(colat_rad), &mut deltas);
        Ok(deltas)
    }
}

/// The largest error of a form on a ring.
#[derive(Clone, Copy, Debug)]
struct Error {
    form: Form,
    level: u32,
    colat_rad: f64,
    worst_rad: f64,
}

impl Error {
    fn metres(&self) -> f64 {
        self.worst_rad * Planet::EARTH.radius_m
    }

    fn texels(&self) -> f64 {
        self.worst_rad / texel_rad(self.level)
    }

    fn parts(&self) -> f64 {
        self.worst_rad / ring_radius_rad(self.level)
    }

    /// Whether \[CH06\] would approximate at this colatitude.
    fn is_away_from_poles(&self) -> bool {
        let from_pole = self.colat_rad.min(core::f64::consts::PI - self.colat_rad);
        from_pole >= f64::from(APPROXIMATE_FROM_POLE_RAD)
    }
}

/// A texel of a level's colour window: its samples span twice the half turn, halved once a level.
fn texel_rad(level: u32) -> f64 {
    2.0 * core::f64::consts::PI / f64::from(1_u32 << level) / WINDOW
}

fn run(context: &Context) -> Result<Report, SuiteError> {
    let cpu = errors(context, &Cpu, 0.0)?;
    let times = cpu_times(context)?;
    let mut report = Report {
        summary: summary(&cpu),
        figures: trades("cpu", "On the processor", &cpu, &times),
    };
    report.figures.extend([
        by_level(
            "level-metres",
            "By level, on the ground",
            "m",
            &cpu,
            Error::metres,
        ),
        by_level(
            "level-parts",
            "By level, for the ring's size",
            "parts of the ring's radius",
            &cpu,
            Error::parts,
        ),
        by_colatitude(&cpu),
        table("table", "All levels, on the processor", &cpu),
    ]);
    match device::measure(context)? {
        Ok((errors, times)) => {
            let place = "On the graphics device";
            report
                .figures
                .extend(trades("device", place, &errors, &times));
            report
                .figures
                .push(table("device-table", "All levels, on the device", &errors));
            report.summary.push(device::summary(&errors));
        }
        Err(why) => report
            .summary
            .push(format!("Nothing was measured on a graphics device: {why}.")),
    }
    Ok(report)
}

/// Errors of all forms on rings of all levels and colatitudes; shows progress from `done` on.
fn errors(
    context: &Context,
    evaluator: &dyn Evaluator,
    done: f64,
) -> Result<Vec<Error>, SuiteError> {
    let count = context.pick(200, 4000);
    let mut errors = Vec::new();
    for level in LEVELS.step_by(context.pick(3, 1)) {
        context.go_on()?;
        (context.progress)(done + 0.4 * f64::from(level) / 24.0);
        for colat_rad in COLATITUDES {
            let vertices = ring_vertices(level, colat_rad, count);
            for form in Form::ALL {
                let deltas = evaluator.deltas(form, &vertices, colat_rad)?;
                let each = vertices.iter().zip(deltas);
                let worst = each.map(|(vertex, delta)| ground_error_rad(*vertex, colat_rad, delta));
                errors.push(Error {
                    form,
                    level,
                    colat_rad,
                    worst_rad: worst.fold(0.0, f64::max),
                });
            }
        }
    }
    Ok(errors)
}

/// Nanoseconds a vertex of each form in each domain, form by form.
fn cpu_times(context: &Context) -> Result<Vec<Spread>, SuiteError> {
    let focus = ClassicFocus::new(TIMED_COLAT_RAD);
    let focus = &focus;
    let mut works = Vec::new();
    for form in Form::ALL {
        for domain in DOMAINS {
            let vertices = ring_vertices(domain.timed_level, TIMED_COLAT_RAD, 4096);
            let mut deltas = vec![Vec2::ZERO; vertices.len()];
            works.push(Work::new(vertices.len() as f64, move || {
                form.map_deltas(black_box(&vertices), focus, &mut deltas);
                black_box(&deltas);
            }));
        }
    }
    in_turns(context, &mut works)
}

/// The largest of some errors in some measure.
fn worst(errors: impl Iterator<Item = Error>, measure: fn(&Error) -> f64) -> f64 {
    errors.map(|error| measure(&error)).fold(0.0, f64::max)
}

/// Error against time in each domain: a point for each form.
fn trades(name: &str, place: &str, errors: &[Error], times: &[Spread]) -> Vec<Figure> {
    let trade = |(d, domain): (usize, &Domain)| {
        let curves = Form::ALL.iter().zip(times.chunks(DOMAINS.len()));
        let curves = curves.map(|(form, times)| {
            let here = errors.iter().copied();
            let here = here.filter(|error| error.form == *form && domain.holds(error));
            Curve {
                name: form.name().to_owned(),
                points: vec![Point::timed("", times[d], worst(here, Error::parts))],
                joined: false,
            }
        });
        let chart = Chart::trade(
            "ns per vertex",
            "largest error on the ground",
            "parts of the ring's radius",
            curves.collect(),
        );
        let caption = format!(
            "Largest error in parts of the radius of the ring that the vertices lie on, over {}; timed at level {}. \
             Truth: the stored vertex turned by the focus' axes in double precision, which is itself right to \
             4·10⁻¹⁶ radians (held against 192 bits by a test).{}",
            domain.title,
            domain.timed_level,
            if domain.poles {
                " What is not drawn is not a number at a pole."
            } else {
                " Nearer to a pole than 3.75°, [CH06] does not approximate."
            }
        );
        Figure::new(
            format!("{name}{}", domain.name),
            format!("{place}: {}", domain.title),
            caption,
            Content::Chart(chart),
        )
    };
    DOMAINS.iter().enumerate().map(trade).collect()
}

/// Error against level.
fn by_level(
    name: &str,
    title: &str,
    unit: &str,
    errors: &[Error],
    measure: fn(&Error) -> f64,
) -> Figure {
    let levels: Vec<u32> = distinct(errors.iter().map(|error| error.level));
    let curve = |form: Form| {
        let point = |level: &u32| {
            let of_level = errors.iter().copied().filter(|error| {
                error.form == form && error.level == *level && error.is_away_from_poles()
            });
            Point::new(
                format!("level {level}"),
                f64::from(*level),
                worst(of_level, measure),
            )
        };
        Curve {
            name: form.name().to_owned(),
            points: levels.iter().map(point).collect(),
            joined: true,
        }
    };
    let mut curves: Vec<Curve> = Form::ALL.map(curve).to_vec();
    if unit == "m" {
        let texel = |level: &u32| {
            let metres = texel_rad(*level) * Planet::EARTH.radius_m;
            Point::new(format!("level {level}"), f64::from(*level), metres)
        };
        curves.push(Curve {
            name: "one texel of the level (N = 1024)".to_owned(),
            points: levels.iter().map(texel).collect(),
            joined: true,
        });
    }
    let chart = Chart {
        x: Axis::linear("level", ""),
        y: Axis::log("largest error on the ground", unit),
        curves,
        marks_front: false,
    };
    let caption = "On the processor; worst of all colatitudes further than 3.75° from a pole, on Earth. An error above \
                   a texel moves detail to a wrong place.";
    Figure::new(name, title, caption, Content::Chart(chart))
}

/// Error against colatitude.
fn by_colatitude(errors: &[Error]) -> Figure {
    let curve = |form: Form| {
        let point = |colat_rad: &f64| {
            let here = errors.iter().copied().filter(|error| {
                error.form == form && error.colat_rad == *colat_rad && error.level >= FINE
            });
            let degrees = colat_rad.to_degrees();
            let setting = format!("colatitude {degrees:.7}°");
            Point::new(setting, degrees, worst(here, Error::metres))
        };
        Curve {
            name: form.name().to_owned(),
            points: COLATITUDES.iter().map(point).collect(),
            joined: true,
        }
    };
    let chart = Chart {
        x: Axis::linear("colatitude of the focus", "degrees"),
        y: Axis::log("largest error on the ground", "m"),
        curves: Form::ALL.map(curve).to_vec(),
        marks_front: false,
    };
    let caption = "On the processor, levels 10 and finer, on Earth, both poles included. What is not drawn is not a \
                   number: the approximation divides by zero at a pole.";
    Figure::new(
        "colatitude",
        "By colatitude",
        caption,
        Content::Chart(chart),
    )
}

/// The worst of all, pole or not, level by level.
fn table(name: &str, title: &str, errors: &[Error]) -> Figure {
    let head = [
        "form",
        "level",
        "worst, m",
        "at colatitude, °",
        "worst, texels (N = 1024)",
        "worst, parts of the ring's radius",
        "worst away from poles, m",
    ];
    let mut rows = Vec::new();
    for form in Form::ALL {
        for level in distinct(errors.iter().map(|error| error.level)) {
            let all = || {
                let here = errors.iter().copied();
                here.filter(move |error| error.form == form && error.level == level)
            };
            let Some(most) = all().max_by(|a, b| a.worst_rad.total_cmp(&b.worst_rad)) else {
                continue;
            };
            let away = worst(all().filter(Error::is_away_from_poles), Error::metres);
            rows.push(vec![
                form.name().into(),
                f64::from(level).into(),
                most.metres().into(),
                most.colat_rad.to_degrees().into(),
                most.texels().into(),
                most.parts().into(),
                away.into(),
            ]);
        }
    }
    let table = Table {
        head: head.map(str::to_owned).to_vec(),
        rows,
    };
    let caption = "Largest error over all measured colatitudes, the poles and their closest neighbourhoods included, on Earth.";
    Figure::new(name, title, caption, Content::Table(table))
}

fn distinct(all: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut all: Vec<u32> = all.collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// What was found on the processor.
fn summary(errors: &[Error]) -> Vec<String> {
    use crate::number::text;
    let of = |form: Form, measure: fn(&Error) -> f64, keep: fn(&Error) -> bool| {
        let chosen = errors.iter().copied();
        worst(chosen.filter(|e| e.form == form && keep(e)), measure)
    };
    let fine: fn(&Error) -> bool = |e| e.level >= FINE && e.is_away_from_poles();
    vec![
        format!(
            "The form that Relievo draws with keeps {} of the ring's radius at every level and colatitude, the poles \
             included: on Earth {} m at level 10 and finer, always below {} of a texel.",
            text(of(Form::CancellationFreePoly, Error::parts, |_| true)),
            text(of(Form::CancellationFreePoly, Error::metres, |e| e.level
                >= FINE)),
            text(of(Form::CancellationFreePoly, Error::texels, |_| true)),
        ),
        format!(
            "As printed in [CH06], the transform is off by {} m at fine levels whatever their size ({} texels at the \
             finest), because a colatitude is subtracted from one of like size. The approximation that the paper mends \
             it with is off by {} m at levels 10 and finer, and the blend of both by {} m.",
            text(of(Form::Printed, Error::metres, fine)),
            text(of(Form::Printed, Error::texels, fine)),
            text(of(Form::Approximate, Error::metres, fine)),
            text(of(Form::Blended, Error::metres, fine)),
        ),
    ]
}
