//! Where a ray meets the ground: marching with bisection, over space that pyramids of maxima show to
//! be empty.
//!
//! The surface: at a place that is seen from a distance, the heights of the level that is fine enough
//! for that distance, bilinear between sample centres, times the exaggeration, on the sphere. Blocks of
//! cells that the ray passes above are left at their exact sides: two meridian planes and two cones.

use glam::DVec3;
use relievo_graph::RenderError;
use relievo_planet::{MapPoint, ellipsoid::ray_sphere};

use super::field::{Field, Levels, Spot};
use super::patches::{Heights, Reader, STEPS};

/// A ray from the eye.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    /// World position of the eye, metres.
    pub(super) eye: DVec3,
    /// Unit vector.
    pub(super) direction: DVec3,
    /// Largest spacing of samples per metre of distance.
    pub(super) spread: f64,
}

/// Where a ray meets the ground.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    /// Distance from the eye in metres.
    pub(super) distance_m: f64,
    /// Level whose heights were met.
    pub(super) n: u8,
}

/// The ground that rays are sent to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ground {
    pub(super) radius_m: f64,
    /// Factor on heights, not negative.
    pub(super) exaggeration: f64,
    pub(super) levels: Levels,
    /// No ground is higher, metres with exaggeration.
    pub(super) top_m: f64,
    /// Part of a sample's spacing by which rays march near the ground.
    pub(super) step: f64,
}

/// A place along a ray, with the patch of heights below it.
struct Place {
    position: DVec3,
    radius_m: f64,
    spot: Spot,
    n: u8,
}

impl Ray {
    fn at(&self, distance_m: f64) -> DVec3 {
        self.eye + self.direction * distance_m
    }
}

impl Ground {
    /// Where a ray first meets the ground; `None` for the sky.
    pub(super) fn hit<F: Field>(
        &self,
        ray: &Ray,
        reader: &mut Reader<'_, F>,
    ) -> Result<Option<Hit>, RenderError> {
        let Some((enter, leave)) = self.shell(ray) else {
            return Ok(None);
        };
        let (mut above, mut t) = (enter, enter);
        while t <= leave {
            let place = self.place(ray, t);
            let heights = reader.heights(place.spot.key)?;
            let height_m = place.radius_m - self.radius_m;
            if height_m <= heights.at(&place.spot) * self.exaggeration {
                return self.bisect(ray, above, t, reader).map(Some);
            }
            above = t;
            t += self.empty(ray, t, &place, heights);
        }
        Ok(None)
    }

    /// Distances between which a ray is no higher than the highest ground.
    fn shell(&self, ray: &Ray) -> Option<(f64, f64)> {
        let top = self.radius_m + self.top_m;
        let first = ray_sphere(ray.eye, ray.direction, top)?;
        if ray.eye.length() <= top {
            return Some((0.0, first));
        }
        // Both crossings lie equally far from the closest approach.
        let closest = -ray.eye.dot(ray.direction);
        Some((first, 2.0 * closest - first))
    }

    fn place(&self, ray: &Ray, distance_m: f64) -> Place {
        let position = ray.at(distance_m);
        let n = self.levels.fine_enough(distance_m * ray.spread);
        Place {
            position,
            radius_m: position.length(),
            spot: Levels::spot(n, MapPoint::from_direction(position).normalised()),
            n,
        }
    }

    /// Signed height of a place of the ray above the ground.
    pub(super) fn clearance<F: Field>(
        &self,
        ray: &Ray,
        distance_m: f64,
        reader: &mut Reader<'_, F>,
    ) -> Result<f64, RenderError> {
        let place = self.place(ray, distance_m);
        let heights = reader.heights(place.spot.key)?;
        let ground_m = heights.at(&place.spot) * self.exaggeration;
        Ok(place.radius_m - self.radius_m - ground_m)
    }

    /// The crossing between a distance above the ground and one that is not.
    fn bisect<F: Field>(
        &self,
        ray: &Ray,
        mut above: f64,
        mut below: f64,
        reader: &mut Reader<'_, F>,
    ) -> Result<Hit, RenderError> {
        let exact = 1e-5 * self.step * ray.spread;
        for _ in 0..60 {
            if below - above <= exact * below {
                break;
            }
            let middle = 0.5 * (above + below);
            if self.clearance(ray, middle, reader)? > 0.0 {
                above = middle;
            } else {
                below = middle;
            }
        }
        Ok(Hit {
            distance_m: below,
            n: self.levels.fine_enough(below * ray.spread),
        })
    }

    /// How far the ray may go on without meeting the ground: out of the largest block of cells that
    /// it is above, or a part of a sample where there is none.
    fn empty(&self, ray: &Ray, t: f64, place: &Place, heights: &Heights) -> f64 {
        let spacing_m = self.levels.spacing_m(place.n);
        let (least, beyond) = (self.step * spacing_m, 1e-3 * spacing_m);
        let height_m = place.radius_m - self.radius_m;
        let last = super::field::CELLS - 1;
        let cell = |at: f64| (at as i64).clamp(0, last) as usize;
        let (x, y) = (cell(place.spot.u), cell(place.spot.v));
        for k in (0..STEPS).rev() {
            let maximum_m = heights.maximum(k, x, y) * self.exaggeration;
            if height_m <= maximum_m {
                continue;
            }
            let down = descent(ray, place, self.radius_m + maximum_m);
            let out = leaving(ray, place, k, [x, y]);
            let step = down.min(out);
            if step > beyond {
                // The level that counts becomes coarser on the way.
                let change = if place.n == 0 {
                    f64::INFINITY
                } else {
                    self.levels.spacing_m(place.n - 1) / ray.spread - t
                };
                return (step + beyond).min(change.max(least));
            }
        }
        least
    }
}

/// Distance until a descending ray is as low as a sphere that it is outside of; infinite when it
/// never is.
fn descent(ray: &Ray, place: &Place, sphere_m: f64) -> f64 {
    ray_sphere(place.position, ray.direction, sphere_m).unwrap_or(f64::INFINITY)
}

/// Distance until a ray leaves a block of 2^k cells, at most: mirror images of its sides count too.
fn leaving(ray: &Ray, place: &Place, k: usize, [x, y]: [usize; 2]) -> f64 {
    let (p, d) = (place.position, ray.direction);
    let first = |cell: usize| ((cell >> k) << k) as f64;
    let last = |cell: usize| (((cell >> k) + 1) << k) as f64;
    let north_west = place.spot.key.map_point(first(x), first(y));
    let south_east = place.spot.key.map_point(last(x), last(y));
    let mut least = f64::INFINITY;
    let mut crosses = |t: f64| {
        if t > 0.0 && t < least {
            least = t;
        }
    };
    for lon_rad in [north_west.lon_rad, south_east.lon_rad] {
        let (sin, cos) = libm::sincos(lon_rad);
        // A NaN or infinity, for a ray along the meridian, crosses nothing.
        crosses((sin * p.x - cos * p.y) / (cos * d.y - sin * d.x));
    }
    let squared_m = place.radius_m * place.radius_m;
    for colat_rad in [north_west.colat_rad, south_east.colat_rad] {
        let cos = libm::cos(colat_rad);
        let (a, half_b, c) = (
            d.z * d.z - cos * cos,
            p.z * d.z - cos * cos * p.dot(d),
            p.z * p.z - cos * cos * squared_m,
        );
        let discriminant = half_b * half_b - a * c;
        if discriminant >= 0.0 {
            // The two roots without a difference of equals.
            let q = -half_b - discriminant.sqrt().copysign(half_b);
            crosses(q / a);
            crosses(c / q);
        }
    }
    least
}
