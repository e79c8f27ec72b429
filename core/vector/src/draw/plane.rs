//! Between longitude and latitude and the samples of a lattice.

use core::f64::consts::{FRAC_PI_2, PI};

use glam::DVec2;
use relievo_planet::{GridCrs, Lattice, Planet, SampleRect};
use relievo_raster::crs::Crs;

use crate::features::Bounds;

/// Steps along each side of a rectangle at which a projected grid is looked at.
const LOOKS: i64 = 16;

/// A lattice on the planet.
pub(super) struct Plane<'a> {
    lattice: &'a Lattice,
    crs: Option<Crs>,
    pub(super) planet: Planet,
    /// Metres between rows.
    pub(super) sample_m: f64,
}

/// The places that a rectangle of samples shows in one way: a rectangle beyond a pole shows those on
/// the other side of it, mirrored.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    /// What it shows.
    pub(super) bounds: Bounds,
    /// That and what reaches into it.
    pub(super) reached: Bounds,
    /// First sample of the rectangle.
    origin: DVec2,
    /// Colatitude on the lattice = offset + sign · colatitude of the place.
    colat_offset: f64,
    colat_sign: f64,
    /// Longitude on the lattice = longitude of the place + this.
    lon_offset: f64,
}

impl Window {
    /// First sample of its rectangle.
    pub(super) fn origin(&self) -> DVec2 {
        self.origin
    }
}

impl<'a> Plane<'a> {
    pub(super) fn new(lattice: &'a Lattice, planet: Planet) -> Result<Self, String> {
        let (crs, sample_m) = match &lattice.crs {
            GridCrs::Map => (None, planet.radius_m * lattice.step.y.abs()),
            GridCrs::Projected(name) => {
                let crs = Crs::parse(name).map_err(|e| e.to_string())?;
                let unit_m = if crs.is_geographic() {
                    planet.radius_m.to_radians()
                } else {
                    crs.metres_per_unit()
                };
                (Some(crs), unit_m * lattice.step.y.abs())
            }
        };
        Ok(Self {
            lattice,
            crs,
            planet,
            sample_m,
        })
    }

    /// Whether vertices only have to be scaled and moved.
    pub(super) fn is_map(&self) -> bool {
        self.crs.is_none()
    }

    pub(super) fn lattice(&self) -> &Lattice {
        self.lattice
    }

    /// What a rectangle shows, and what is within some metres of it.
    pub(super) fn windows(&self, rect: SampleRect, reach_m: f64) -> Vec<Window> {
        let origin = rect.min.as_dvec2();
        let corner = |x: i64, y: i64| {
            self.lattice.origin + DVec2::new(x as f64, y as f64) * self.lattice.step
        };
        if let Some(crs) = &self.crs {
            let bounds = projected_bounds(crs, rect, corner);
            let window = |bounds| Window {
                bounds,
                reached: self.grown(&bounds, reach_m),
                origin,
                colat_offset: 0.0,
                colat_sign: 1.0,
                lon_offset: 0.0,
            };
            return bounds.map(window).into_iter().collect();
        }
        let (a, b) = (
            corner(rect.min.x, rect.min.y),
            corner(rect.max.x, rect.max.y),
        );
        let (low, high) = (a.min(b), a.max(b));
        // As they are, over the north pole, over the south pole.
        let ways = [(0.0, 1.0, 0.0), (0.0, -1.0, PI), (2.0 * PI, -1.0, PI)];
        ways.into_iter()
            .filter_map(|(colat_offset, colat_sign, lon_offset)| {
                let place = |colat: f64| colat_sign * (colat - colat_offset);
                let (c, d) = (place(low.y), place(high.y));
                let (top, bottom) = (c.min(d).max(0.0), c.max(d).min(PI));
                let bounds = Bounds {
                    min: DVec2::new(low.x - lon_offset, FRAC_PI_2 - bottom),
                    max: DVec2::new(high.x - lon_offset, FRAC_PI_2 - top),
                };
                (top < bottom).then(|| Window {
                    bounds,
                    reached: self.grown(&bounds, reach_m),
                    origin,
                    colat_offset,
                    colat_sign,
                    lon_offset,
                })
            })
            .collect()
    }

    /// A box with everything within some metres of it.
    pub(super) fn grown(&self, bounds: &Bounds, by_m: f64) -> Bounds {
        let lat = by_m / self.planet.meridian_radius_m(0.0).min(self.planet.radius_m) * 1.01;
        let highest = bounds.min.y.abs().max(bounds.max.y.abs()) + lat;
        let across = if highest >= FRAC_PI_2 {
            0.0
        } else {
            self.planet.metres_per_radian(FRAC_PI_2 - highest).x
        };
        let lon = if across * PI <= by_m {
            PI
        } else {
            by_m / across
        };
        bounds.grow(DVec2::new(lon, lat))
    }

    /// Where a place lies in the window, in samples; `None` where the plane does not show it.
    pub(super) fn sample(&self, window: &Window, lonlat: DVec2) -> Option<DVec2> {
        let plane = match &self.crs {
            None => DVec2::new(
                lonlat.x + window.lon_offset,
                window.colat_offset + window.colat_sign * (FRAC_PI_2 - lonlat.y),
            ),
            Some(crs) => {
                let (x, y) = crs.from_lonlat(lonlat.x, lonlat.y).ok()?;
                DVec2::new(x, y)
            }
        };
        Some((plane - self.lattice.origin) / self.lattice.step - window.origin)
    }

    /// Samples to a metre along columns and rows at a place.
    pub(super) fn samples_per_m(&self, lonlat: DVec2) -> DVec2 {
        let step = self.lattice.step.abs();
        if self.crs.is_none() {
            let metres = self.planet.metres_per_radian(FRAC_PI_2 - lonlat.y) * step;
            // At a pole a metre is any number of turns.
            return DVec2::new(1.0 / metres.x.max(metres.y * 1e-4), 1.0 / metres.y);
        }
        self.projected_scale(lonlat)
            .unwrap_or(DVec2::splat(1.0 / self.sample_m))
    }

    /// The same on a projected plane, from its own derivatives: the plane is taken as conformal, or
    /// stretched along its axes.
    fn projected_scale(&self, lonlat: DVec2) -> Option<DVec2> {
        let crs = self.crs.as_ref()?;
        let (x, y) = crs.from_lonlat(lonlat.x, lonlat.y).ok()?;
        let step = self.lattice.step;
        let place = |x: f64, y: f64| {
            let (lon, lat) = crs.to_lonlat(x, y).ok()?;
            Some(relievo_planet::MapPoint::new(lon, FRAC_PI_2 - lat))
        };
        let here = place(x, y)?;
        let east = self.planet.offset_m(here, place(x + step.x, y)?).length();
        let north = self.planet.offset_m(here, place(x, y + step.y)?).length();
        (east > 0.0 && north > 0.0).then(|| DVec2::new(1.0 / east, 1.0 / north))
    }
}

/// The box around the places that a projected rectangle shows.
fn projected_bounds(
    crs: &Crs,
    rect: SampleRect,
    corner: impl Fn(i64, i64) -> DVec2,
) -> Option<Bounds> {
    let (a, b) = (
        corner(rect.min.x, rect.min.y),
        corner(rect.max.x, rect.max.y),
    );
    let (low, high) = (a.min(b), a.max(b));
    let mut bounds: Option<Bounds> = None;
    let mut missing = false;
    let mut middle: Option<f64> = None;
    for row in 0..=LOOKS {
        for column in 0..=LOOKS {
            let share = DVec2::new(column as f64, row as f64) / LOOKS as f64;
            let p = low + (high - low) * share;
            let Ok((lon, lat)) = crs.to_lonlat(p.x, p.y) else {
                missing = true;
                continue;
            };
            // Continuous across the antimeridian, as long as the rectangle is narrower than the globe.
            let centre = *middle.get_or_insert(lon);
            let lon = centre + relievo_planet::map::wrap_longitude(lon - centre);
            let place = DVec2::new(lon, lat);
            let point = Bounds {
                min: place,
                max: place,
            };
            bounds = Some(bounds.map_or(point, |b| b.union(&point)));
        }
    }
    let mut bounds = bounds?;
    for pole in [FRAC_PI_2, -FRAC_PI_2] {
        let shows = crs.from_lonlat(0.0, pole).is_ok_and(|(x, y)| {
            let p = DVec2::new(x, y);
            p.cmpge(low).all() && p.cmple(high).all()
        });
        if shows {
            bounds.min.y = bounds.min.y.min(pole);
            bounds.max.y = bounds.max.y.max(pole);
            missing = true;
        }
    }
    // What bulges between the places that were looked at.
    let size = bounds.size();
    if missing || size.x > PI {
        bounds.min.x = bounds.centre().x - PI;
        bounds.max.x = bounds.min.x + 2.0 * PI;
    }
    Some(bounds.grow(size * 0.1 + 1e-9))
}
