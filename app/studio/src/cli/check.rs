//! `relievo check`: every problem of a project, with where it is and how to mend it.

mod elsewhere;
mod planning;
mod references;

use std::path::PathBuf;

use relievo_engine::Engine;
use relievo_engine::project::{Extrude, Layer, LayerId, LayerKind, Project, quote};
use relievo_engine::raster::RasterInfo;
use relievo_engine::raster::crs::Crs;
use relievo_engine::{OpenFeatures, SourceState};
use serde::Serialize;
use serde_json::Value;

use self::elsewhere::Elsewhere;
use super::{Context, Failure, project};

/// Part by which the radii of a source and of the planet may differ.
const RADIUS_TOLERANCE: f64 = 0.01;

/// Find every problem of a project.
///
/// Each is told with where it is and how to mend it. Errors end with exit code 2; warnings do not.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The project.
    #[arg(value_name = "PROJECT")]
    project: PathBuf,
    /// Print a JSON array instead of lines.
    #[arg(long)]
    json: bool,
    /// Look for missing files here and in the folders below, 8 deep; may be given several times.
    /// The project's own folder is always looked into.
    #[arg(long, value_name = "FOLDER")]
    search: Vec<PathBuf>,
}

/// How bad a problem is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum Severity {
    Warning,
    Error,
}

/// One problem.
#[derive(Debug, Serialize)]
struct Problem {
    severity: Severity,
    /// JSON pointer into the project file.
    place: String,
    /// The layer's id, where it is about one.
    #[serde(skip_serializing_if = "Option::is_none")]
    layer: Option<LayerIdText>,
    /// What was expected and what was found.
    what: String,
    /// How to mend it.
    mend: String,
    /// Edits that may mend it, the likeliest first, as `relievo apply` takes them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    edits: Vec<Value>,
}

#[derive(Debug, Serialize)]
#[serde(transparent)]
struct LayerIdText(String);

pub(crate) fn run(arguments: &Arguments, context: &mut Context) -> Result<(), Failure> {
    let mut engine = project::open(&arguments.project, context)?;
    project::wait_for_sources(&mut engine, context)?;
    let elsewhere = Elsewhere::search(&engine, &arguments.search, context)?;
    let mut problems = problems(&engine, &elsewhere);
    planning::problems(engine.project(), &arguments.project, &mut problems);
    if arguments.json {
        let text = serde_json::to_string_pretty(&problems).map_err(Failure::system)?;
        writeln!(context.out, "{text}")?;
    } else {
        for p in &problems {
            let severity = if p.severity == Severity::Error {
                "error"
            } else {
                "warning"
            };
            writeln!(
                context.out,
                "{severity} at {}: {}\n  to mend it: {}",
                p.place, p.what, p.mend
            )?;
        }
        if problems.is_empty() {
            writeln!(
                context.out,
                "no problems in {}",
                arguments.project.display()
            )?;
        }
    }
    match problems
        .iter()
        .filter(|p| p.severity == Severity::Error)
        .count()
    {
        0 => Ok(()),
        1 => Err(Failure::Input(format!(
            "expected a project without errors, found 1: {:?}",
            arguments.project
        ))),
        n => Err(Failure::Input(format!(
            "expected a project without errors, found {n}: {:?}",
            arguments.project
        ))),
    }
}

/// All problems, by place.
fn problems(engine: &Engine, elsewhere: &Elsewhere) -> Vec<Problem> {
    let project = engine.project();
    let mut found = Vec::new();
    unknown_fields("", project.extra.keys(), None, &mut found);
    unknown_fields("/planet", project.planet.extra.keys(), None, &mut found);
    unknown_fields("/camera", project.camera.extra.keys(), None, &mut found);
    unknown_fields("/quality", project.quality.extra.keys(), None, &mut found);
    unknown_fields("/sun", project.sun.extra.keys(), None, &mut found);
    for (index, layer) in project.layers.iter().enumerate() {
        of_layer(engine, elsewhere, index, layer, &mut found);
    }
    references::problems(project, &mut found);
    heights_for_tints(project, &mut found);
    found
}

fn of_layer(
    engine: &Engine,
    elsewhere: &Elsewhere,
    index: usize,
    layer: &Layer,
    found: &mut Vec<Problem>,
) {
    let place = format!("/layers/{index}");
    let mut tell = |severity, place: String, what: String, mend: &str, edits: Vec<Value>| {
        found.push(Problem {
            severity,
            place,
            layer: Some(text_of(&layer.id)),
            what,
            mend: mend.to_owned(),
            edits,
        });
    };
    if let LayerKind::Unknown { kind } = &layer.kind {
        tell(
            Severity::Warning,
            format!("{place}/kind"),
            format!(
                "expected imagery, height, noise, detail, tint, slope, contours or vector, found {}: the layer has no effect",
                quote(kind)
            ),
            "open the project with a newer Relievo, or remove the layer",
            Vec::new(),
        );
        return;
    }
    match engine.sources().state(&layer.kind, engine.folder()) {
        Some(SourceState::Failed(reason)) => {
            let place = format!("{place}/path");
            let (mend, edits) = if let Some(offer) = elsewhere.offer(engine, layer) {
                offer
            } else if reason.contains("the encoding of heights") {
                let mend = "add an encoding, terrain-rgb or terrarium, to the layer";
                (mend.to_owned(), Vec::new())
            } else if reason.contains("georeference") || reason.contains("a given extent") {
                let mend = "add a georeference with crs and extent to the layer";
                (mend.to_owned(), Vec::new())
            } else {
                let mend = "correct the layer's path, restore the file, or remove the layer";
                (mend.to_owned(), Vec::new())
            };
            tell(Severity::Error, place, reason, &mend, edits);
        }
        Some(SourceState::Open(file)) => {
            if let Some(what) = other_planet(engine.project(), file.info()) {
                tell(
                    Severity::Warning,
                    format!("{place}/path"),
                    what,
                    "set the planet to the one of the data, or take another file",
                    Vec::new(),
                );
            }
        }
        Some(SourceState::Features(open)) => {
            if let Some(what) = vector_trouble(layer, &open) {
                tell(
                    Severity::Warning,
                    format!("{place}/style"),
                    what,
                    "name a property that the file has",
                    Vec::new(),
                );
            }
        }
        Some(SourceState::Opening(_)) | None => {}
    }
    unknown_fields(&place, layer.extra.keys(), Some(&layer.id), found);
}

/// What is odd about a style: it asks for a property that no feature has.
fn vector_trouble(layer: &Layer, open: &OpenFeatures) -> Option<String> {
    let LayerKind::Vector(vector) = &layer.kind else {
        return None;
    };
    let style = &vector.style;
    let by = style.by.as_ref().map(|by| &by.property);
    let label = style.label.as_ref().map(|label| &label.property);
    let height = match &style.extrude {
        Some(Extrude::Property(name)) => Some(name),
        Some(Extrude::HeightM(_)) | None => None,
    };
    let known = |name: &&String| open.features.columns().iter().any(|c| **c == ***name);
    let mut asked = by.into_iter().chain(label).chain(height);
    let missing = asked.find(|name| !known(name))?;
    let columns: Vec<&str> = open.features.columns().iter().map(|c| &**c).collect();
    Some(format!(
        "expected a property of the features, found {missing:?}; there are {}",
        columns.join(", ")
    ))
}

/// What is odd about a source whose coordinate system belongs to another planet.
fn other_planet(project: &Project, info: &RasterInfo) -> Option<String> {
    let (source_m, _) = Crs::parse(&info.georeference.as_ref()?.crs).ok()?.radii_m();
    let planet_m = project.planet.body.figure().equatorial_radius_m;
    ((source_m / planet_m - 1.0).abs() > RADIUS_TOLERANCE).then(|| {
        format!(
            "expected data on a planet of {planet_m} m, found a radius of {source_m} m: {:?}",
            info.path
        )
    })
}

fn heights_for_tints(project: &Project, found: &mut Vec<Problem>) {
    let gives_heights =
        |l: &Layer| matches!(l.kind, LayerKind::Height(_) | LayerKind::Noise(_)) && l.visible;
    if project.layers.iter().any(gives_heights) || !project.elements.is_empty() {
        return;
    }
    for (index, layer) in project.layers.iter().enumerate() {
        let wants_heights = matches!(
            layer.kind,
            LayerKind::Tint(_) | LayerKind::Slope(_) | LayerKind::Contours(_)
        );
        if wants_heights && layer.visible {
            found.push(Problem {
                severity: Severity::Warning,
                place: format!("/layers/{index}"),
                layer: Some(text_of(&layer.id)),
                what: format!(
                    "expected visible heights for a layer of kind {}, found none: the ground is level",
                    layer.kind.name()
                ),
                mend: "add a height or noise layer, or show one".to_owned(),
                edits: Vec::new(),
            });
        }
    }
}

fn unknown_fields<'a>(
    place: &str,
    names: impl Iterator<Item = &'a String>,
    layer: Option<&LayerId>,
    found: &mut Vec<Problem>,
) {
    for name in names {
        found.push(Problem {
            severity: Severity::Warning,
            place: format!("{place}/{name}"),
            layer: layer.map(text_of),
            what: format!(
                "expected a field of this version, found {name:?}: it is kept but has no effect"
            ),
            mend: "correct the spelling, remove it, or use a newer Relievo".to_owned(),
            edits: Vec::new(),
        });
    }
}

fn text_of(id: &LayerId) -> LayerIdText {
    LayerIdText(id.0.clone())
}
