//! `relievo info`: what a file says of itself.

use std::path::{Path, PathBuf};

use relievo_engine::project::{self, Layer, Project};
use relievo_engine::raster::crs::Crs;
use relievo_engine::raster::open::{OpenOptions, open};
use relievo_engine::raster::{Bands, RasterFile};
use relievo_engine::vector::{self, Features, Shape, Summary, is_vector};
use serde::Serialize;
use serde_json::{Value, json};

use super::{Context, Failure};

/// Print what a raster file, a file of vectors or a project holds.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// A raster file (GeoTIFF, JPEG, PNG, WebP, OpenEXR, SRTM, ASCII grid), a set of tiles (a folder,
    /// MBTiles, PMTiles), vectors (GeoJSON, Shapefile, GeoPackage, FlatGeobuf), or a project.
    #[arg(value_name = "FILE|PROJECT")]
    file: PathBuf,
    /// Print JSON instead of lines.
    #[arg(long)]
    json: bool,
}

/// What is told of a raster file.
#[derive(Serialize)]
struct Raster<'a> {
    file: &'a Path,
    format: &'a str,
    width: u32,
    height: u32,
    bands: u16,
    read_as: &'static str,
    sample_type: &'a str,
    compression: &'a str,
    crs: Option<&'a str>,
    /// Outer edges in units of the system.
    extent: Option<Extent>,
    /// Size of a pixel in units of the system.
    pixel_size: Option<[f64; 2]>,
    unit: Option<&'static str>,
    nodata: Option<f64>,
    /// Sizes of the file's own overviews, fine to coarse.
    overviews: Vec<[u32; 2]>,
    /// What to know of how the file was understood.
    remarks: &'a [String],
}

/// The smallest upright rectangle that holds all pixels.
#[derive(Clone, Copy, Serialize)]
struct Extent {
    west: f64,
    south: f64,
    east: f64,
    north: f64,
}

pub(crate) fn run(arguments: &Arguments, context: &mut Context) -> Result<(), Failure> {
    if arguments
        .file
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("relievo"))
    {
        let (project, _stamp) = project::open(&arguments.file).map_err(Failure::input)?;
        return of_project(arguments, &project, context);
    }
    if is_vector(&arguments.file) {
        return of_vector(arguments, context);
    }
    let options = OpenOptions {
        make_pyramid: false,
        cancel: context.cancel.clone(),
        ..OpenOptions::default()
    };
    let file = open(&arguments.file, &options).map_err(Failure::input)?;
    of_raster(arguments, &*file, context)
}

fn of_raster(
    arguments: &Arguments,
    file: &dyn RasterFile,
    context: &mut Context,
) -> Result<(), Failure> {
    let info = file.info();
    let size = info.overviews[0];
    let place = info.georeference.as_ref();
    let geographic = place.map(|g| Crs::parse(&g.crs).is_ok_and(|crs| crs.is_geographic()));
    let raster = Raster {
        file: &arguments.file,
        format: info.format,
        width: size.width,
        height: size.height,
        bands: info.band_count,
        read_as: if info.bands == Bands::Height {
            "heights"
        } else {
            "colours"
        },
        sample_type: &info.sample_type,
        compression: &info.compression,
        crs: place.map(|g| &*g.crs),
        extent: place.map(|g| extent(&g.plane_from_pixel, size.width, size.height)),
        pixel_size: place.map(|g| {
            let [_, xx, xy, _, yx, yy] = g.plane_from_pixel;
            [xx.hypot(yx), xy.hypot(yy)]
        }),
        unit: geographic.map(|degrees| {
            if degrees {
                "degree"
            } else {
                "unit of the system"
            }
        }),
        nodata: info.nodata,
        overviews: info.overviews[1..]
            .iter()
            .map(|o| [o.width, o.height])
            .collect(),
        remarks: file.remarks(),
    };
    if arguments.json {
        return print_json(&raster, context);
    }
    let out = &mut context.out;
    writeln!(out, "{}", arguments.file.display())?;
    writeln!(
        out,
        "format       {}, compression {}",
        raster.format, raster.compression
    )?;
    writeln!(
        out,
        "size         {} × {} pixels",
        raster.width, raster.height
    )?;
    writeln!(
        out,
        "bands        {} of {}, read as {}",
        raster.bands, raster.sample_type, raster.read_as
    )?;
    writeln!(
        out,
        "crs          {}",
        raster.crs.unwrap_or("none: give the layer a georeference")
    )?;
    if let (Some(e), Some([x, y])) = (raster.extent, raster.pixel_size) {
        writeln!(
            out,
            "extent       west {} south {} east {} north {}",
            e.west, e.south, e.east, e.north
        )?;
        writeln!(out, "pixel size   {x} × {y}")?;
    }
    if let Some(nodata) = raster.nodata {
        writeln!(out, "nodata       {nodata}")?;
    }
    for remark in raster.remarks {
        writeln!(out, "remark       {remark}")?;
    }
    let overviews: Vec<String> = raster
        .overviews
        .iter()
        .map(|[w, h]| format!("{w} × {h}"))
        .collect();
    let overviews = if overviews.is_empty() {
        "none".to_owned()
    } else {
        overviews.join(", ")
    };
    Ok(writeln!(out, "overviews    {overviews}")?)
}

/// Prints what a file of vectors holds.
fn of_vector(arguments: &Arguments, context: &mut Context) -> Result<(), Failure> {
    let options = vector::OpenOptions {
        cancel: context.cancel.clone(),
        ..vector::OpenOptions::default()
    };
    let (features, summary) = vector::open(&arguments.file, &options).map_err(Failure::input)?;
    let Summary {
        format,
        crs,
        layers,
        mut remarks,
    } = summary;
    if features.lost_vertices() > 0 {
        remarks.push(format!(
            "{} vertices lie nowhere on the planet and are left out",
            features.lost_vertices()
        ));
    }
    let shapes = shapes(&features);
    let degrees = |v: f64| v.to_degrees();
    let bounds = features
        .bounds()
        .map(|b| [b.min.x, b.min.y, b.max.x, b.max.y].map(degrees));
    let columns: Vec<&str> = features.columns().iter().map(|c| &**c).collect();
    if arguments.json {
        let value = json!({
            "file": arguments.file,
            "format": format,
            "crs": &*crs,
            "layers": layers,
            "features": features.len(),
            "vertices": features.vertices(),
            "points": shapes[0],
            "lines": shapes[1],
            "polygons": shapes[2],
            "bounds_deg": bounds,
            "properties": columns,
            "remarks": remarks,
        });
        return print_json(&value, context);
    }
    let out = &mut context.out;
    writeln!(out, "{}", arguments.file.display())?;
    writeln!(out, "format       {format}")?;
    if !layers.is_empty() {
        writeln!(out, "tables       {}", layers.join(", "))?;
    }
    writeln!(out, "crs          {crs}")?;
    writeln!(
        out,
        "features     {}: {} points, {} lines, {} polygons, {} vertices",
        features.len(),
        shapes[0],
        shapes[1],
        shapes[2],
        features.vertices()
    )?;
    if let Some([west, south, east, north]) = bounds {
        writeln!(
            out,
            "extent       west {west} south {south} east {east} north {north} degrees"
        )?;
    }
    writeln!(out, "properties   {}", columns.join(", "))?;
    for remark in remarks {
        writeln!(out, "remark       {remark}")?;
    }
    Ok(())
}

/// Numbers of points, lines and polygons.
fn shapes(features: &Features) -> [usize; 3] {
    let mut counts = [0; 3];
    for outline in (0..features.len()).flat_map(|f| features.outlines(f)) {
        match outline.shape {
            Shape::Points => counts[0] += outline.lonlat_rad.len(),
            Shape::Line => counts[1] += 1,
            Shape::Outer => counts[2] += 1,
            Shape::Hole => {}
        }
    }
    counts
}

fn extent(plane_from_pixel: &[f64; 6], width: u32, height: u32) -> Extent {
    let [x0, xx, xy, y0, yx, yy] = *plane_from_pixel;
    let (w, h) = (f64::from(width), f64::from(height));
    let corners = [(0.0, 0.0), (w, 0.0), (0.0, h), (w, h)];
    let x = corners.map(|(column, row)| x0 + xx * column + xy * row);
    let y = corners.map(|(column, row)| y0 + yx * column + yy * row);
    let least = |v: [f64; 4]| v.into_iter().fold(f64::INFINITY, f64::min);
    let most = |v: [f64; 4]| v.into_iter().fold(f64::NEG_INFINITY, f64::max);
    Extent {
        west: least(x),
        south: least(y),
        east: most(x),
        north: most(y),
    }
}

fn of_project(
    arguments: &Arguments,
    project: &Project,
    context: &mut Context,
) -> Result<(), Failure> {
    let figure = project.planet.body.figure();
    let camera = &project.camera;
    if arguments.json {
        let value = json!({
            "file": arguments.file,
            "format": "Relievo project",
            "planet": {
                "radius_m": figure.radius_m,
                "equatorial_radius_m": figure.equatorial_radius_m,
                "flattening": figure.flattening,
                "vertical_exaggeration": project.planet.vertical_exaggeration,
            },
            "camera": {
                "lon_deg": camera.lon_deg, "lat_deg": camera.lat_deg, "altitude_m": camera.altitude_m,
                "heading_deg": camera.heading_deg, "pitch_deg": camera.pitch_deg, "fov_deg": camera.fov_deg,
            },
            "layers": project.layers.iter().map(layer_json).collect::<Vec<_>>(),
        });
        return print_json(&value, context);
    }
    let out = &mut context.out;
    writeln!(out, "{}", arguments.file.display())?;
    writeln!(out, "format       Relievo project")?;
    let exaggeration = project.planet.vertical_exaggeration;
    writeln!(
        out,
        "planet       radius {} m, heights × {exaggeration}",
        figure.radius_m
    )?;
    writeln!(
        out,
        "camera       {}° east, {}° north, {} m up, heading {}°, pitch {}°",
        camera.lon_deg, camera.lat_deg, camera.altitude_m, camera.heading_deg, camera.pitch_deg
    )?;
    writeln!(out, "layers       {}, top first", project.layers.len())?;
    for layer in project.layers.iter().rev() {
        let hidden = if layer.visible { "" } else { ", hidden" };
        let source = layer
            .path()
            .map(|path| format!(", {path}"))
            .unwrap_or_default();
        writeln!(
            out,
            "  {} ({}): {}{source}{hidden}",
            layer.id,
            layer.name,
            layer.kind.name()
        )?;
    }
    Ok(())
}

fn layer_json(layer: &Layer) -> Value {
    json!({
        "id": layer.id.0,
        "name": layer.name,
        "kind": layer.kind.name(),
        "visible": layer.visible,
        "opacity": layer.opacity,
        "path": layer.path(),
    })
}

fn print_json(value: &impl Serialize, context: &mut Context) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(value).map_err(Failure::system)?;
    Ok(writeln!(context.out, "{text}")?)
}
