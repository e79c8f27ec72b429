//! Where a source's pixels lie on the globe.

use glam::{DAffine2, DMat2, DVec2};

use super::WarpError;
use crate::crs::Crs;
use crate::file::RasterInfo;

/// Longitude and latitude in radians of a point of a system's plane; `None` beyond its reach.
pub(crate) fn lonlat_from_plane(crs: &Crs, plane: DVec2) -> Option<DVec2> {
    if crs.is_geographic() {
        return Some(DVec2::new(plane.x.to_radians(), plane.y.to_radians()));
    }
    let (lon, lat) = crs.to_lonlat(plane.x, plane.y).ok()?;
    Some(DVec2::new(lon, lat)).filter(|p| p.is_finite())
}

/// Plane coordinates (degrees in geographic systems, which take any longitude) of a longitude and
/// latitude in radians; `None` beyond the system's reach.
pub(crate) fn plane_from_lonlat(crs: &Crs, lonlat: DVec2) -> Option<DVec2> {
    if crs.is_geographic() {
        return Some(DVec2::new(lonlat.x.to_degrees(), lonlat.y.to_degrees()));
    }
    let (x, y) = crs.from_lonlat(lonlat.x, lonlat.y).ok()?;
    Some(DVec2::new(x, y)).filter(|p| p.is_finite())
}

pub(crate) fn parse_crs(definition: &str) -> Result<Crs, WarpError> {
    Crs::parse(definition).map_err(|e| WarpError::Crs {
        crs: definition.to_owned(),
        reason: e.to_string(),
    })
}

/// A source image on its plane.
#[derive(Clone)]
pub(crate) struct SourcePlane {
    pub(crate) crs: Crs,
    pub(crate) pixel_from_plane: DAffine2,
    pub(crate) plane_from_pixel: DAffine2,
    /// Columns and rows of the full image.
    pub(crate) size: DVec2,
    /// Whether the columns run once around the globe, and how many do.
    pub(crate) columns_around: Option<i64>,
    /// Whether row 0 begins and the last row ends at a pole, so that rows reflect.
    pub(crate) reflects: [bool; 2],
}

impl SourcePlane {
    pub(crate) fn new(info: &RasterInfo) -> Result<Self, WarpError> {
        let Some(georeference) = &info.georeference else {
            return Err(WarpError::NoGeoreference {
                path: info.path.clone(),
            });
        };
        let crs = parse_crs(&georeference.crs)?;
        let [x0, xc, xr, y0, yc, yr] = georeference.plane_from_pixel;
        let plane_from_pixel = DAffine2 {
            matrix2: DMat2::from_cols(DVec2::new(xc, yc), DVec2::new(xr, yr)),
            translation: DVec2::new(x0, y0),
        };
        let pixel_from_plane = plane_from_pixel.inverse();
        let full = info
            .overviews
            .first()
            .filter(|o| o.width > 0 && o.height > 0);
        let Some(full) =
            full.filter(|_| plane_from_pixel.is_finite() && pixel_from_plane.is_finite())
        else {
            return Err(WarpError::Degenerate {
                path: info.path.clone(),
            });
        };
        let size = DVec2::new(f64::from(full.width), f64::from(full.height));
        let upright = crs.is_geographic() && xr == 0.0 && yc == 0.0;
        let around = (360.0 / xc.abs()).round();
        let columns_around = (upright && around >= 1.0 && around <= size.x + 0.5)
            .then_some(around.min(size.x) as i64);
        let touches = |row: f64| {
            columns_around.is_some() && ((y0 + row * yr).abs() - 90.0).abs() < 0.5 * yr.abs()
        };
        let reflects = [touches(0.0), touches(size.y)];
        Ok(Self {
            crs,
            pixel_from_plane,
            plane_from_pixel,
            size,
            columns_around,
            reflects,
        })
    }

    /// Whether columns run along parallels and rows along meridians.
    pub(crate) fn is_upright_geographic(&self) -> bool {
        let m = self.plane_from_pixel.matrix2;
        self.crs.is_geographic() && m.x_axis.y == 0.0 && m.y_axis.x == 0.0
    }

    /// Plane coordinates of the middle.
    pub(crate) fn centre(&self) -> DVec2 {
        self.plane_from_pixel.transform_point2(self.size * 0.5)
    }
}
