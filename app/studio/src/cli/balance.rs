//! `relievo balance`: adjustments by which several layers look alike, as edits.

use std::path::PathBuf;

use relievo_engine::analysis::MapBox;
use relievo_engine::project::{Edit, LayerId};

use super::matching::{difference_json, layer_called};
use super::measure::{deliver, measured};
use super::scenario::Scenario;
use super::{Context, Failure, project, units};

/// Balance the colours of several overlapping layers at once.
///
/// Finds a gain and an offset of each channel of each layer, so that all overlaps agree as well as they can
/// together; clouds, shadows and what was built between two pictures are left out. Prints the colour
/// differences (CIEDE2000) of each overlap before and after. The result are ordinary adjustments.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The project.
    #[arg(value_name = "PROJECT")]
    project: PathBuf,
    /// The layers: names or ids.
    #[arg(long, value_name = "A,B,...", value_delimiter = ',', required = true)]
    layers: Vec<String>,
    /// The one of them that keeps its look. Default: none, all meet in the middle.
    #[arg(long, value_name = "LAYER")]
    hold: Option<String>,
    /// Compare only inside these edges, in degrees. Default: wherever they overlap.
    #[arg(long, value_name = "W,S,E,N", allow_hyphen_values = true, value_parser = units::bounds)]
    region: Option<[f64; 4]>,
    /// Where to write the edits for `relievo apply`. Default: only the differences are printed.
    #[arg(short, long, value_name = "EDITS.json")]
    output: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments, context: &mut Context) -> Result<(), Failure> {
    let area = arguments.region.map(MapBox::from_degrees).transpose();
    let area = area.map_err(Failure::input)?;
    let engine = project::open_complete(&arguments.project, &Scenario::default(), context)?;
    let called = |name: &String| layer_called(engine.project(), name);
    let layers: Vec<LayerId> = arguments
        .layers
        .iter()
        .map(called)
        .collect::<Result<_, _>>()?;
    let held = arguments.hold.as_ref().map(called).transpose()?;
    let questions = engine.questions();
    let found = measured("balancing", &arguments.project, context, |task| {
        questions.balance_colours(&layers, held.as_ref(), area.as_ref(), task)
    })?;
    let overlaps: Vec<_> = found
        .overlaps
        .iter()
        .map(|overlap| {
            serde_json::json!({
                "layers": overlap.layers.each_ref().map(|l| l.0.as_str()),
                "places": overlap.places,
                "ciede2000_before": difference_json(&overlap.before),
                "ciede2000_after": difference_json(&overlap.after),
            })
        })
        .collect();
    if let Some(file) = &arguments.output {
        let edits: Vec<Edit> = found
            .layers
            .into_iter()
            .map(|balanced| Edit::SetAdjust {
                id: balanced.layer,
                adjust: balanced.adjust,
            })
            .collect();
        let text = Edit::list_to_json(&edits);
        deliver(
            text.as_bytes(),
            Some(file),
            &arguments.project,
            &engine,
            context,
        )?;
    }
    writeln!(
        context.out,
        "{}",
        serde_json::json!({ "overlaps": overlaps })
    )?;
    Ok(())
}
