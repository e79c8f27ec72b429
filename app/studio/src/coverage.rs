//! Which part of the planet files cover, and from where it is seen whole.

use relievo_engine::planet::camera::DEFAULT_FOV_Y_RAD;
use relievo_engine::planet::map::wrap_longitude;
use relievo_engine::planet::{Camera, Planet};
use relievo_engine::raster::RasterInfo;
use relievo_engine::raster::crs::Crs;
use relievo_engine::vector::Features;

/// Longitudes and latitudes that sources cover, degrees.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coverage {
    /// Western edge.
    west: f64,
    /// Southern edge.
    south: f64,
    /// Eastern edge.
    east: f64,
    /// Northern edge.
    north: f64,
}

impl Coverage {
    /// From points along the edges of a file; points without a place on the planet do not count.
    pub(crate) fn of(crs: &Crs, plane_from_pixel: &[f64; 6], info: &RasterInfo) -> Self {
        const STEPS: u32 = 8;
        let [x0, xx, xy, y0, yx, yy] = *plane_from_pixel;
        let (width, height) = (
            f64::from(info.overviews[0].width),
            f64::from(info.overviews[0].height),
        );
        let nothing = Self {
            west: f64::INFINITY,
            south: f64::INFINITY,
            east: f64::NEG_INFINITY,
            north: f64::NEG_INFINITY,
        };
        let mut frame = nothing;
        for i in 0..=STEPS {
            for j in 0..=STEPS {
                let (column, row) = (
                    width * f64::from(i) / f64::from(STEPS),
                    height * f64::from(j) / f64::from(STEPS),
                );
                let at = crs.to_lonlat(x0 + xx * column + xy * row, y0 + yx * column + yy * row);
                if let Ok((lon, lat)) = at {
                    let (lon, lat) = (lon.to_degrees(), lat.to_degrees());
                    frame = frame.union(Self {
                        west: lon,
                        east: lon,
                        south: lat,
                        north: lat,
                    });
                }
            }
        }
        if frame.west > frame.east {
            return Self {
                west: -180.0,
                south: -90.0,
                east: 180.0,
                north: 90.0,
            };
        }
        frame
    }

    /// The box around features; `None` without any.
    pub(crate) fn of_features(features: &Features) -> Option<Self> {
        let bounds = features.bounds()?;
        Some(Self {
            west: bounds.min.x.to_degrees(),
            south: bounds.min.y.to_degrees(),
            east: bounds.max.x.to_degrees(),
            north: bounds.max.y.to_degrees(),
        })
    }

    /// What both cover.
    #[must_use]
    pub(crate) fn union(self, other: Self) -> Self {
        Self {
            west: self.west.min(other.west),
            south: self.south.min(other.south),
            east: self.east.max(other.east),
            north: self.north.max(other.north),
        }
    }

    /// A camera above the middle that sees it all, or half of the planet. Its altitude counts from the
    /// ground there.
    pub(crate) fn camera(&self, planet: &Planet) -> Camera {
        let lon_deg = f64::midpoint(self.west, self.east);
        let lat_deg = f64::midpoint(self.south, self.north).clamp(-90.0, 90.0);
        let span_deg = (self.north - self.south)
            .max((self.east - self.west) * lat_deg.to_radians().cos().abs());
        // Half the span over tan(30°), the half of the default field of view, and room around it.
        let local_m = span_deg.to_radians() * planet.radius_m * 0.5 / 0.577 * 1.2;
        let altitude_m = local_m.clamp(50.0, planet.radius_m * 1.8);
        Camera {
            lon_rad: wrap_longitude(lon_deg.to_radians()),
            lat_rad: lat_deg.to_radians(),
            altitude_m,
            heading_rad: 0.0,
            pitch_rad: -core::f64::consts::FRAC_PI_2,
            fov_y_rad: DEFAULT_FOV_Y_RAD,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_region_is_seen_whole_and_the_whole_planet_from_space() {
        let region = Coverage {
            west: 10.0,
            south: 45.0,
            east: 11.0,
            north: 46.0,
        };
        let camera = region.camera(&Planet::EARTH);
        assert!((camera.lon_rad.to_degrees() - 10.5).abs() < 1e-9);
        assert!(
            (100e3..200e3).contains(&camera.altitude_m),
            "{}",
            camera.altitude_m
        );
        let world = Coverage {
            west: -180.0,
            south: -90.0,
            east: 180.0,
            north: 90.0,
        };
        assert!(world.union(region).camera(&Planet::EARTH).altitude_m > 1e7);
    }
}
