//! `relievo match`: an adjustment by which a layer looks like another, as an edit.

use std::path::{Path, PathBuf};

use relievo_engine::MatchTarget;
use relievo_engine::analysis::MapBox;
use relievo_engine::analysis::colour::{Difference, MatchMethod};
use relievo_engine::project::{Edit, LayerId, Project};

use super::measure::{deliver, measured};
use super::scenario::Scenario;
use super::{Context, Failure, project, units};

/// Match the colours of a layer to what lies below it or to another layer.
///
/// Compares about 65,000 places that both cover; clouds, shadows and what was built between two pictures are
/// left out as outliers. Prints the colour differences (CIEDE2000) before and after. The result is an
/// ordinary adjustment: change it as you like, or its strength.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The project.
    #[arg(value_name = "PROJECT")]
    project: PathBuf,
    /// The layer to adjust: its name or id.
    #[arg(long, value_name = "LAYER")]
    layer: String,
    /// What it is to look like: a layer's name or id, or what lies below it.
    #[arg(long, value_name = "below|LAYER", default_value = "below")]
    to: String,
    /// How: gain and offset of each channel, a tone curve of each channel, or a mix of channels.
    #[arg(long, value_enum, default_value_t = Method::Regression)]
    method: Method,
    /// How much of the adjustment is shown, 0 to 1.
    #[arg(long, value_name = "SHARE", default_value_t = 1.0, value_parser = units::share)]
    strength: f64,
    /// Compare only inside these edges, in degrees. Default: wherever both are.
    #[arg(long, value_name = "W,S,E,N", allow_hyphen_values = true, value_parser = units::bounds)]
    region: Option<[f64; 4]>,
    /// Where to write the edit for `relievo apply`. Default: only the differences are printed.
    #[arg(short, long, value_name = "EDITS.json")]
    output: Option<PathBuf>,
}

/// How colours are matched.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Method {
    /// Means and standard deviations of each channel agree.
    Mean,
    /// Histograms of each channel agree.
    Histogram,
    /// Colours agree place by place as well as a 3 × 4 matrix can.
    Regression,
}

pub(crate) fn run(arguments: &Arguments, context: &mut Context) -> Result<(), Failure> {
    let area = arguments.region.map(MapBox::from_degrees).transpose();
    let area = area.map_err(Failure::input)?;
    let engine = project::open_complete(&arguments.project, &Scenario::default(), context)?;
    let layer = layer_called(engine.project(), &arguments.layer)?;
    let target = match arguments.to.as_str() {
        "below" => MatchTarget::Below,
        name => MatchTarget::Layer(layer_called(engine.project(), name)?),
    };
    let method = match arguments.method {
        Method::Mean => MatchMethod::MeanAndSpread,
        Method::Histogram => MatchMethod::Histogram,
        Method::Regression => MatchMethod::Regression,
    };
    let questions = engine.questions();
    let found = measured("matching", &arguments.project, context, |task| {
        let how = (method, arguments.strength);
        questions.match_colours(&layer, &target, area.as_ref(), how, task)
    })?;
    let line = serde_json::json!({
        "layer": layer.0.as_str(),
        "places": found.fit.pairs,
        "same_ground": found.fit.same,
        "ciede2000_before": difference_json(&found.fit.before),
        "ciede2000_after": difference_json(&found.fit.after),
    });
    if let Some(file) = &arguments.output {
        let edit = Edit::SetAdjust {
            id: layer,
            adjust: found.adjust,
        };
        let text = Edit::list_to_json(&[edit]);
        deliver(
            text.as_bytes(),
            Some(file),
            &arguments.project,
            &engine,
            context,
        )?;
    }
    writeln!(context.out, "{line}")?;
    Ok(())
}

/// The differences of two layers, as `relievo compare --layers` prints them.
pub(super) fn compare_layers(
    file: &Path,
    layers: &[String],
    region: Option<&MapBox>,
    context: &mut Context,
) -> Result<(), Failure> {
    let [a, b] = layers else {
        let expected = "expected --layers A,B of two layers";
        return Err(Failure::Input(format!(
            "{expected}, found {}",
            layers.join(",")
        )));
    };
    let engine = project::open_complete(file, &Scenario::default(), context)?;
    let layer = layer_called(engine.project(), a)?;
    let target = MatchTarget::Layer(layer_called(engine.project(), b)?);
    let questions = engine.questions();
    let (difference, places) = measured("comparing", file, context, |task| {
        questions.colour_difference(&layer, &target, region, task)
    })?;
    let line = serde_json::json!({
        "layers": [a, b],
        "places": places,
        "ciede2000": difference_json(&difference),
    });
    writeln!(context.out, "{line}")?;
    Ok(())
}

pub(super) fn difference_json(difference: &Difference) -> serde_json::Value {
    serde_json::json!({
        "mean": difference.mean,
        "p95": difference.p95,
        "mean_of_same_ground": difference.mean_of_same,
    })
}

/// The layer of that id, or else the only one of that name.
pub(super) fn layer_called(project: &Project, name: &str) -> Result<LayerId, Failure> {
    if let Some(layer) = project.layers.iter().find(|l| l.id.0.as_str() == name) {
        return Ok(layer.id.clone());
    }
    let mut named = project.layers.iter().filter(|l| l.name == name);
    match (named.next(), named.next()) {
        (Some(layer), None) => Ok(layer.id.clone()),
        (Some(_), Some(_)) => Err(Failure::Input(format!(
            "expected a layer's id where several have the name, found {name:?}"
        ))),
        (None, _) => {
            let known: Vec<&str> = project.layers.iter().map(|l| l.id.0.as_str()).collect();
            let known = known.join(", ");
            Err(Failure::Input(format!(
                "expected a layer ({known}), found {name:?}"
            )))
        }
    }
}
