//! Where the pixels of a GeoTIFF lie.

use std::sync::Arc;

use super::control_points::{ControlPoint, fit};
use super::fault::{Fault, damaged, unsupported};
use super::geokeys::GeoKeys;
use super::ifd::{Ifd, TiffBytes, tag};
use crate::file::Georeference;

/// Control points may lie so many pixels off the affine map through them: beyond, the image is bent
/// and must be warped.
const WORST_CONTROL_POINT_PX: f64 = 2.0;

/// Plane coordinates from pixels, and the system they are in as far as the file says.
#[derive(Debug, Default)]
pub(crate) struct Placement {
    /// See [`Georeference::plane_from_pixel`].
    pub(crate) plane_from_pixel: Option<[f64; 6]>,
    /// The system.
    pub(crate) crs: Option<String>,
    /// What a user should know of it.
    pub(crate) remark: Option<String>,
}

impl Placement {
    /// Reads tags and geo keys.
    pub(crate) fn read(file: &TiffBytes, ifd: &Ifd, keys: &GeoKeys) -> Result<Self, Fault> {
        let (mut affine, remark) = match affine(file, ifd)? {
            Some(found) => (Some(found), None),
            None => fitted(file, ifd)?,
        };
        if let Some(affine) = &mut affine {
            if keys.pixel_is_point() {
                affine[0] -= 0.5 * (affine[1] + affine[2]);
                affine[3] -= 0.5 * (affine[4] + affine[5]);
            }
            let degrees = keys.degrees_per_unit();
            for v in affine.iter_mut() {
                *v *= degrees;
            }
            check_affine(affine).map_err(Fault::Damaged)?;
        }
        Ok(Self {
            plane_from_pixel: affine,
            crs: keys.crs()?,
            remark,
        })
    }

    /// Both together, if both are known.
    pub(crate) fn georeference(self) -> Option<Georeference> {
        match (self.crs, self.plane_from_pixel) {
            (Some(crs), Some(plane_from_pixel)) => Some(Georeference {
                crs: Arc::from(crs),
                plane_from_pixel,
            }),
            _ => None,
        }
    }
}

/// Says what is wrong with a map from pixels: numbers that are not finite, pixels without area.
pub(crate) fn check_affine(affine: &[f64; 6]) -> Result<(), String> {
    if !affine.iter().all(|v| v.is_finite() && v.abs() < 1e15) {
        return Err(format!(
            "expected finite positions of pixels, found {affine:?}"
        ));
    }
    let area = affine[1] * affine[5] - affine[2] * affine[4];
    if area == 0.0 || !area.is_normal() {
        return Err(format!("expected pixels with an area, found {affine:?}"));
    }
    Ok(())
}

fn affine(file: &TiffBytes, ifd: &Ifd) -> Result<Option<[f64; 6]>, Fault> {
    let matrix = file.f64_vec(ifd, tag::MODEL_TRANSFORMATION, 16)?;
    if !matrix.is_empty() {
        let &[a, b, _, x0, c, d, _, y0, ..] = matrix.as_slice() else {
            return damaged(format!(
                "expected 16 numbers in the model transformation, found {}",
                matrix.len()
            ));
        };
        return Ok(Some([x0, a, b, y0, c, d]));
    }
    let scale = file.f64_vec(ifd, tag::MODEL_PIXEL_SCALE, 16)?;
    let tiepoints = file.f64_vec(ifd, tag::MODEL_TIEPOINT, 1 << 16)?;
    match (scale.as_slice(), tiepoints.as_slice()) {
        (&[dx, dy, ..], &[column, row, _, x, y, _, ..]) => {
            // Files with a negative second scale are north up all the same: some programs got the
            // sign wrong, and GDAL reads them so (GTIFF_HONOUR_NEGATIVE_SCALEY). South-up files that
            // are meant have a transformation.
            let dy = -dy.abs();
            Ok(Some([x - column * dx, dx, 0.0, y - row * dy, 0.0, dy]))
        }
        // Neither; a single tiepoint without a scale or a scale without a tiepoint, which place
        // nothing; many tiepoints, which are control points.
        _ => Ok(None),
    }
}

/// The map that fits a file's control points, with a remark on how well; `None` without such points.
fn fitted(file: &TiffBytes, ifd: &Ifd) -> Result<(Option<[f64; 6]>, Option<String>), Fault> {
    let numbers = file.f64_vec(ifd, tag::MODEL_TIEPOINT, 1 << 16)?;
    let points: Vec<ControlPoint> = numbers
        .as_chunks::<6>()
        .0
        .iter()
        .map(|&[column, row, _, x, y, _]| ControlPoint {
            pixel: (column, row),
            plane: (x, y),
        })
        .collect();
    let count = points.len();
    if count < 2 {
        return Ok((None, None));
    }
    match fit(&points) {
        Some(fit) if fit.worst_px <= WORST_CONTROL_POINT_PX => Ok((
            Some(fit.plane_from_pixel),
            Some(format!(
                "placed by {count} ground control points, which lie up to {:.2} pixels off",
                fit.worst_px
            )),
        )),
        Some(fit) => unsupported(format!(
            "expected ground control points within {WORST_CONTROL_POINT_PX} pixels of a common affine map, found {count} up to {:.1} pixels off: warp the image first",
            fit.worst_px
        )),
        None => unsupported(format!(
            "expected ground control points that span an area, found {count} on one line"
        )),
    }
}
