//! `relievo new`: a project from files.

use std::path::{Path, PathBuf};

use relievo_engine::planet::Planet;
use relievo_engine::project::{
    Body, Edit, PlanetSettings, Project, Replace, SourceRole, layer_from_source,
};
use relievo_engine::raster::crs::Crs;
use relievo_engine::raster::open::{OpenOptions, open};
use relievo_engine::raster::{Bands, RasterInfo};
use relievo_engine::{Engine, engine::folder_of};

use super::cache::engine_options;
use super::{Context, Failure, project};
use crate::coverage::Coverage;

/// Make a project from raster files.
///
/// The first file is the bottom layer. Files with one band of data become heights, others imagery;
/// the planet is that of the first file's coordinate system.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The project to write; it must not exist.
    #[arg(value_name = "OUT.relievo")]
    output: PathBuf,
    /// A GeoTIFF, JPEG or PNG with a georeference; may be repeated or hold several files.
    #[arg(long, required = true, num_args = 1.., value_name = "FILE")]
    source: Vec<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments, context: &mut Context) -> Result<(), Failure> {
    let output = project::absolute(&arguments.output)?;
    let folder = folder_of(&output).to_owned();
    let mut edits = Vec::new();
    let mut frame: Option<Coverage> = None;
    let mut named = Project::default();
    for source in &arguments.source {
        let (role, info) = look_at(source, context)?;
        let place = info.georeference.as_ref().map(|g| (Crs::parse(&g.crs), g));
        let Some((crs, georeference)) = place else {
            return Err(Failure::Input(format!(
                "expected a place on the planet, found no georeference; add a world file or make a GeoTIFF: {source:?}"
            )));
        };
        let crs = crs.map_err(|e| Failure::Input(format!("{e}: {source:?}")))?;
        if frame.is_none() {
            edits.extend(planet_of(&crs));
        }
        let seen = Coverage::of(&crs, &georeference.plane_from_pixel, &info);
        frame = Some(frame.map_or(seen, |f| f.union(seen)));
        let file = project::absolute(source)?;
        let stem = file
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let id = named.fresh_layer_id(&stem, |_| false);
        let layer = layer_from_source(id, &folder, &file, role).map_err(Failure::input)?;
        named.layers.push(layer.clone());
        edits.push(Edit::AddLayer {
            index: None,
            layer: Box::new(layer),
        });
    }
    let options = engine_options(context.threads, &context.cache);
    let mut engine = Engine::new(Project::default(), &folder, options).map_err(Failure::system)?;
    let label = String::new();
    engine
        .apply(Edit::Batch { label, edits })
        .map_err(Failure::input)?;
    if let Some(frame) = frame {
        let figure = engine.project().planet.body.figure();
        let camera = engine.project().camera.with_camera(&frame.camera(&figure));
        engine
            .apply(Edit::SetCamera { camera })
            .map_err(Failure::input)?;
    }
    if context.cancel.is_cancelled() {
        return Err(Failure::Cancelled);
    }
    engine
        .save(&output, Replace::Never)
        .map_err(Failure::input)?;
    Ok(())
}

/// What a file holds.
fn look_at(source: &Path, context: &Context) -> Result<(SourceRole, RasterInfo), Failure> {
    let options = OpenOptions {
        make_pyramid: false,
        cancel: context.cancel.clone(),
        ..OpenOptions::default()
    };
    let file = open(source, &options).map_err(Failure::input)?;
    let info = file.info().clone();
    let role = if info.bands == Bands::Height {
        SourceRole::Height
    } else {
        SourceRole::Imagery
    };
    Ok((role, info))
}

/// The edit that sets the planet whose radius a coordinate system has; none for Earth.
fn planet_of(crs: &Crs) -> Option<Edit> {
    let (a_m, b_m) = crs.radii_m();
    let is = |body: &Body| (body.figure().equatorial_radius_m / a_m - 1.0).abs() < 0.01;
    let body = match [Body::Earth, Body::Mars, Body::Moon].into_iter().find(is) {
        Some(Body::Earth) => return None,
        Some(known) => known,
        None => Body::Custom(Planet {
            radius_m: (2.0 * a_m + b_m) / 3.0,
            equatorial_radius_m: a_m,
            flattening: ((a_m - b_m) / a_m).clamp(0.0, 0.5),
        }),
    };
    Some(Edit::SetPlanet {
        planet: PlanetSettings {
            body,
            ..PlanetSettings::default()
        },
    })
}
