//! What is seen or flooded as raster files: a GeoTIFF with values, or a picture with a world file.

use std::fs;
use std::path::{Path, PathBuf};

use relievo_analysis::{Flood, Sight, Viewshed};
use relievo_planet::{Planet, SampleRect};
use relievo_raster::file::Georeference;
use relievo_raster::write::{
    CogLayout, CogSamples, CogWork, Png, WriteError, write_cog, write_png,
};
use relievo_raster::{Bands, Block, Cancel, PixelRect};

/// Most samples of a picture.
const LARGEST_PICTURE: u64 = 1 << 26;

/// Ends of the names of a picture's world file and its coordinate system.
const WORLD: &str = "pgw";
const SYSTEM: &str = "prj";

/// A value for samples that have none.
const NODATA: f32 = -32767.0;

/// Writes what is seen: a GeoTIFF (`.tif`) with 1 for seen, 0 for hidden and none outside, or a picture
/// (`.png`; yellow and dark) with its world file (`.pgw`) and system (`.prj`) beside it. Both lie in the
/// azimuthal equidistant system around the observer.
///
/// # Errors
/// [`WriteError`].
pub fn write_viewshed(viewshed: &Viewshed, path: &Path, cancel: &Cancel) -> Result<(), WriteError> {
    let side = viewshed.side();
    let corner_m = (viewshed.reach as f64 + 0.5) * viewshed.spacing_m;
    let step_m = viewshed.spacing_m;
    let place = Place {
        crs: viewshed.frame.definition().to_owned(),
        wkt: around(viewshed),
        plane_from_pixel: [-corner_m, step_m, 0.0, corner_m, 0.0, -step_m],
        size: [side as u64; 2],
    };
    let sights = |rect: PixelRect| -> Vec<Sight> {
        let rows = rect.y as usize..(rect.y + rect.height) as usize;
        let columns = rect.x as usize..(rect.x + rect.width) as usize;
        rows.flat_map(|row| {
            viewshed.sights[row * side..][columns.clone()]
                .iter()
                .copied()
        })
        .collect()
    };
    place.write(
        path,
        cancel,
        &|rect| {
            let value = |sight: Sight| match sight {
                Sight::Visible => 1.0,
                Sight::Hidden => 0.0,
                Sight::Outside => f32::NAN,
            };
            sights(rect).into_iter().map(value).collect()
        },
        &|value| {
            if value.is_nan() {
                [0.0; 4]
            } else if value > 0.5 {
                [1.0, 0.85, 0.2, 1.0]
            } else {
                [0.1, 0.12, 0.2, 1.0]
            }
        },
    )
}

/// Writes where water stands: a GeoTIFF (`.tif`) of its depth in metres, or a picture (`.png`; deep water is
/// darker) with its world file (`.pgw`) and system (`.prj`) beside it. Both lie on the data's own samples in
/// longitude and latitude.
///
/// # Errors
/// [`WriteError`].
pub fn write_flood(
    flood: &Flood,
    planet: &Planet,
    path: &Path,
    cancel: &Cancel,
) -> Result<(), WriteError> {
    let water = &flood.water;
    let (lattice, size) = (water.lattice(), water.size());
    let step = lattice.step;
    let west_deg = lattice.origin.x.to_degrees();
    let turns = ((west_deg + 180.0) / 360.0).floor();
    let north_deg = 90.0 - lattice.origin.y.to_degrees();
    let place = Place {
        crs: if *planet == Planet::EARTH {
            "EPSG:4326".to_owned()
        } else {
            let polar_m = planet.equatorial_radius_m * (1.0 - planet.flattening);
            format!(
                "+proj=longlat +a={} +b={polar_m} +no_defs",
                planet.equatorial_radius_m
            )
        },
        wkt: geographic(planet),
        plane_from_pixel: [
            west_deg - 360.0 * turns,
            step.x.to_degrees(),
            0.0,
            north_deg,
            0.0,
            -step.y.to_degrees(),
        ],
        size: [size.x as u64, size.y as u64],
    };
    let deepest = flood.deepest_m.max(f64::MIN_POSITIVE) as f32;
    place.write(
        path,
        cancel,
        &|rect| {
            let rect = SampleRect::at(
                i64::from(rect.x),
                i64::from(rect.y),
                i64::from(rect.width),
                i64::from(rect.height),
            );
            water.depths(rect)
        },
        &|depth| {
            if depth.is_nan() {
                return [0.0; 4];
            }
            let share = (depth / deepest).clamp(0.0, 1.0);
            [
                0.45 - 0.4 * share,
                0.7 - 0.45 * share,
                0.9 - 0.3 * share,
                1.0,
            ]
        },
    )
}

/// Where a raster lies.
struct Place {
    /// The system as `relievo-raster` resolves it, and as Well-Known Text.
    crs: String,
    wkt: String,
    plane_from_pixel: [f64; 6],
    size: [u64; 2],
}

impl Place {
    fn write(
        &self,
        path: &Path,
        cancel: &Cancel,
        values: &(dyn Fn(PixelRect) -> Vec<f32> + Sync),
        colour: &dyn Fn(f32) -> [f32; 4],
    ) -> Result<(), WriteError> {
        let [width, height] = self.size;
        let unsupported = |reason: String| WriteError::Unsupported {
            reason,
            path: path.to_owned(),
        };
        let too_large = || unsupported(format!("expected fewer samples, found {width} × {height}"));
        let (Ok(columns), Ok(rows)) = (u32::try_from(width), u32::try_from(height)) else {
            return Err(too_large());
        };
        let is_picture = path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("png"));
        if is_picture {
            if width * height > LARGEST_PICTURE {
                return Err(too_large());
            }
            // A picture that is written again replaces what lies beside it; a new one takes nothing that is
            // another file's.
            let taken = [WORLD, SYSTEM].map(|e| path.with_extension(e));
            if let Some(other) = taken.iter().find(|other| !path.exists() && other.exists()) {
                return Err(unsupported(format!(
                    "expected no file of another's where its place is told, found {other:?}"
                )));
            }
            let whole = PixelRect {
                x: 0,
                y: 0,
                width: columns,
                height: rows,
            };
            let mut picture = Block::new(Bands::Colour, columns as usize, rows as usize);
            let [red, green, blue, alpha] = picture.planes_mut();
            for (i, value) in values(whole).into_iter().enumerate() {
                [red[i], green[i], blue[i], alpha[i]] = colour(value);
            }
            write_png(path, &picture, Png::Rgba8)?;
            return self.write_beside(path);
        }
        let layout = CogLayout {
            width: columns,
            height: rows,
            samples: CogSamples::Height { nodata: NODATA },
            tile: 512,
            georeference: Some(Georeference {
                crs: self.crs.as_str().into(),
                plane_from_pixel: self.plane_from_pixel,
            }),
            largest_classic_bytes: CogLayout::LARGEST_CLASSIC_BYTES,
        };
        let source = |rect: PixelRect| {
            let mut block = Block::new(Bands::Height, rect.width as usize, rect.height as usize);
            block.plane_mut(0).copy_from_slice(&values(rect));
            Ok(block)
        };
        let work = CogWork {
            threads: 1,
            resume: None,
            cancel,
        };
        write_cog(path, &layout, &source, &work, &mut |_| {})
    }

    /// The world file and the system of a picture.
    fn write_beside(&self, path: &Path) -> Result<(), WriteError> {
        let [x0, xc, xr, y0, yc, yr] = self.plane_from_pixel;
        // Steps along columns and rows, then the centre of the first pixel.
        let centre = [x0 + 0.5 * (xc + xr), y0 + 0.5 * (yc + yr)];
        let lines = [xc, yc, xr, yr, centre[0], centre[1]].map(|n| format!("{n:.12}\n"));
        let write = |extension: &str, text: String| {
            let beside: PathBuf = path.with_extension(extension);
            fs::write(&beside, text).map_err(|source| WriteError::Io {
                source,
                path: beside.clone(),
            })
        };
        write(WORLD, lines.concat())?;
        write(SYSTEM, format!("{}\n", self.wkt))
    }
}

/// A planet's longitude and latitude as ESRI's Well-Known Text.
fn geographic(planet: &Planet) -> String {
    let (a_m, inverse) = (
        planet.equatorial_radius_m,
        if planet.flattening > 0.0 {
            1.0 / planet.flattening
        } else {
            0.0
        },
    );
    let [system, datum, spheroid] = if *planet == Planet::EARTH {
        ["GCS_WGS_1984", "D_WGS_1984", "WGS_1984"]
    } else {
        ["GCS_unnamed", "D_unnamed", "unnamed"]
    };
    format!(
        r#"GEOGCS["{system}",DATUM["{datum}",SPHEROID["{spheroid}",{a_m:?},{inverse:?}]],PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]]"#
    )
}

/// The system around a viewshed's observer, likewise.
fn around(viewshed: &Viewshed) -> String {
    let (lon_deg, lat_deg) = viewshed.frame.centre.to_degrees();
    format!(
        r#"PROJCS["Around the observer",{},PROJECTION["Azimuthal_Equidistant"],PARAMETER["False_Easting",0.0],PARAMETER["False_Northing",0.0],PARAMETER["Central_Meridian",{lon_deg:?}],PARAMETER["Latitude_Of_Origin",{lat_deg:?}],UNIT["Meter",1.0]]"#,
        geographic(viewshed.frame.planet())
    )
}
