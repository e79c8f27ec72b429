//! `relievo new`: a project from files.

use std::path::{Path, PathBuf};

use relievo_engine::planet::{MapPoint, Planet};
use relievo_engine::project::{
    self as project_kinds, Body, Edit, LayerKind, PlanetSettings, Project, Replace, SourceRole,
    layer_from_source,
};
use relievo_engine::raster::crs::Crs;
use relievo_engine::raster::open::{self, OpenOptions, open};
use relievo_engine::raster::{Bands, RasterInfo};
use relievo_engine::vector;
use relievo_engine::{Engine, engine::folder_of};

use super::cache::engine_options;
use super::{Context, Failure, project};
use crate::coverage::Coverage;

/// Make a project from raster files and files of vectors.
///
/// The first file is the bottom layer. Rasters with one band of data become heights, others imagery;
/// the planet is that of the first file's coordinate system.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The project to write; it must not exist.
    #[arg(value_name = "OUT.relievo")]
    output: PathBuf,
    /// A raster file with a georeference (GeoTIFF, JPEG, PNG, WebP, OpenEXR, SRTM, ASCII grid) or a
    /// set of tiles (a folder zoom/column/row.png, MBTiles, PMTiles), or vectors (GeoJSON, Shapefile,
    /// GeoPackage, FlatGeobuf); may be repeated or hold several.
    #[arg(long, required = true, num_args = 1.., value_name = "FILE|FOLDER")]
    source: Vec<PathBuf>,
    /// How colours of tiles mean heights, for all sets of tiles; by default as their metadata say,
    /// and where they say nothing, tiles are imagery.
    #[arg(long, value_enum, value_name = "NAME")]
    encoding: Option<Encoding>,
    /// From where rows of tiles count, for all sets of tiles: xyz from north, tms from south; by
    /// default as their metadata say, else from south in MBTiles and from north in others.
    #[arg(long, value_enum, value_name = "SCHEME")]
    tile_rows: Option<Rows>,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Encoding {
    TerrainRgb,
    Terrarium,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Rows {
    Xyz,
    Tms,
}

pub(crate) fn run(arguments: &Arguments, context: &mut Context) -> Result<(), Failure> {
    let output = project::absolute(&arguments.output)?;
    let folder = folder_of(&output).to_owned();
    let mut edits = Vec::new();
    let mut frame: Option<Coverage> = None;
    let mut named = Project::default();
    for source in &arguments.source {
        let tiles = open::is_tile_set(source);
        if vector::is_vector(source) {
            let (seen, planet) = look_at_vector(source, context)?;
            if frame.is_none() {
                edits.extend(planet);
            }
            frame = match (frame, seen) {
                (Some(frame), Some(seen)) => Some(frame.union(seen)),
                (frame, seen) => frame.or(seen),
            };
            edits.push(add(
                &mut named,
                &folder,
                source,
                SourceRole::Vector,
                |_| {},
            )?);
            continue;
        }
        let (role, info) = look_at(source, tiles, arguments, context)?;
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
        edits.push(add(&mut named, &folder, source, role, |kind| {
            if tiles {
                say_how_tiles_are_read(kind, arguments);
            }
        })?);
    }
    if (arguments.encoding.is_some() || arguments.tile_rows.is_some())
        && !arguments.source.iter().any(|s| open::is_tile_set(s))
    {
        return Err(Failure::Input(format!(
            "expected a set of tiles for --encoding or --tile-rows, found none: {:?}",
            arguments.source[0]
        )));
    }
    let options = engine_options(context.threads, &context.cache);
    let mut engine = Engine::new(Project::default(), &folder, options).map_err(Failure::system)?;
    let label = String::new();
    engine
        .apply(Edit::Batch { label, edits })
        .map_err(Failure::input)?;
    if let Some(frame) = frame {
        let figure = engine.project().planet.body.figure();
        let mut camera = frame.camera(&figure);
        camera.altitude_m += ground_m(&mut engine, camera.map_point(), context);
        let camera = engine.project().camera.with_camera(&camera);
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

/// Height of the ground at a place, metres; 0 where no file has any. What cannot be read is told when
/// the project is opened.
fn ground_m(engine: &mut Engine, at: MapPoint, context: &Context) -> f64 {
    let layers = &engine.project().layers;
    if !layers
        .iter()
        .any(|l| matches!(l.kind, LayerKind::Height(_)))
    {
        return 0.0;
    }
    engine.wait_for_sources();
    let place = engine.questions().place(at, context.cancel);
    place.map_or(0.0, |p| p.height_m)
}

/// The edit that adds a layer for a file, with an id that none in `named` has.
fn add(
    named: &mut Project,
    folder: &Path,
    source: &Path,
    role: SourceRole,
    change: impl FnOnce(&mut LayerKind),
) -> Result<Edit, Failure> {
    let file = project::absolute(source)?;
    let stem = file
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    let id = named.fresh_layer_id(&stem, |_| false);
    let mut layer = layer_from_source(id, folder, &file, role).map_err(Failure::input)?;
    change(&mut layer.kind);
    named.layers.push(layer.clone());
    Ok(Edit::AddLayer {
        index: None,
        layer: Box::new(layer),
    })
}

/// What a file of vectors covers, and the edit that sets its planet.
fn look_at_vector(
    source: &Path,
    context: &Context,
) -> Result<(Option<Coverage>, Option<Edit>), Failure> {
    let options = vector::OpenOptions {
        cancel: context.cancel.clone(),
        ..vector::OpenOptions::default()
    };
    let (features, summary) = vector::open(source, &options).map_err(Failure::input)?;
    let planet = Crs::parse(&summary.crs).ok().and_then(|c| planet_of(&c));
    Ok((Coverage::of_features(&features), planet))
}

/// What a file holds.
fn look_at(
    source: &Path,
    tiles: bool,
    arguments: &Arguments,
    context: &Context,
) -> Result<(SourceRole, RasterInfo), Failure> {
    let mut options = OpenOptions {
        make_pyramid: false,
        cancel: context.cancel.clone(),
        ..OpenOptions::default()
    };
    if tiles {
        options.encoding = arguments.encoding.map(|e| match e {
            Encoding::TerrainRgb => open::HeightEncoding::TerrainRgb,
            Encoding::Terrarium => open::HeightEncoding::Terrarium,
        });
        options.tile_rows = arguments.tile_rows.map(|r| match r {
            Rows::Xyz => open::TileRows::FromNorth,
            Rows::Tms => open::TileRows::FromSouth,
        });
    }
    let file = open(source, &options).map_err(Failure::input)?;
    let info = file.info().clone();
    let role = if info.bands == Bands::Height {
        SourceRole::Height
    } else {
        SourceRole::Imagery
    };
    Ok((role, info))
}

/// Puts what the arguments say of tiles into a layer; nothing where metadata suffice.
fn say_how_tiles_are_read(kind: &mut LayerKind, arguments: &Arguments) {
    let rows = arguments.tile_rows.map(|r| match r {
        Rows::Xyz => project_kinds::TileRows::Xyz,
        Rows::Tms => project_kinds::TileRows::Tms,
    });
    match kind {
        LayerKind::Height(height) => {
            height.source.tile_rows = rows;
            height.source.encoding = arguments.encoding.map(|e| match e {
                Encoding::TerrainRgb => project_kinds::HeightEncoding::TerrainRgb,
                Encoding::Terrarium => project_kinds::HeightEncoding::Terrarium,
            });
        }
        LayerKind::Imagery(imagery) => imagery.source.tile_rows = rows,
        LayerKind::Noise(_)
        | LayerKind::Detail(_)
        | LayerKind::Tint(_)
        | LayerKind::Slope(_)
        | LayerKind::Contours(_)
        | LayerKind::Vector(_)
        | LayerKind::Unknown { .. } => {}
    }
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
