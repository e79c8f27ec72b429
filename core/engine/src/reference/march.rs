//! Where a ray meets the ground: cell by cell, over space that pyramids of maxima show to be empty.
//!
//! The surface: at a place that is seen from a distance, the heights of the level that is fine enough
//! for that distance, bilinear between sample centres, times the exaggeration, on the sphere. Blocks of
//! cells that the ray passes above are left at their exact sides: two meridian planes and two cones. In
//! a cell that it does not, its height above the ground is a square function of the way but for the
//! bend of the map within a cell: three places tell whether and where it meets the ground.

use glam::DVec3;
use relievo_graph::RenderError;
use relievo_planet::{MapPoint, ellipsoid::ray_sphere};

use super::field::{Field, Levels, Spot};
use super::patches::{Heights, Reader, STEPS};

/// Longest way in one cell, of its rows' distance: a steep ray goes deep below a cell before it leaves.
const LONGEST_IN_CELL: f64 = 2.0;

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

/// A place along a ray.
struct Place {
    distance_m: f64,
    position: DVec3,
    radius_m: f64,
    spot: Spot,
    n: u8,
    /// Signed height above the ground, metres with exaggeration.
    clear_m: f64,
}

/// What a ray does next.
enum Next {
    /// Nothing is in its way for so many metres.
    Empty(f64),
    /// It goes so many metres within a cell whose ground may rise to it.
    Cell(f64),
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
        let mut here = self.place(ray, enter, reader)?;
        if here.clear_m <= 0.0 {
            return Ok(Some(self.hit_at(ray, enter)));
        }
        while here.distance_m <= leave {
            let heights = reader.heights(here.spot.key)?;
            let ahead = match self.next(ray, &here, heights) {
                Next::Empty(step_m) => {
                    let ahead = self.place(ray, here.distance_m + step_m, reader)?;
                    if ahead.clear_m <= 0.0 {
                        return self.meet(ray, &here, &ahead, reader).map(Some);
                    }
                    ahead
                }
                Next::Cell(step_m) => {
                    let middle = self.place(ray, here.distance_m + 0.5 * step_m, reader)?;
                    if middle.clear_m <= 0.0 {
                        return self.meet(ray, &here, &middle, reader).map(Some);
                    }
                    let ahead = self.place(ray, here.distance_m + step_m, reader)?;
                    if ahead.clear_m <= 0.0 {
                        return self.meet(ray, &middle, &ahead, reader).map(Some);
                    }
                    let values = [here.clear_m, middle.clear_m, ahead.clear_m];
                    if let Some(share) = dip(values) {
                        let dip = self.place(ray, here.distance_m + share * step_m, reader)?;
                        if dip.clear_m <= 0.0 {
                            return self.meet(ray, &here, &dip, reader).map(Some);
                        }
                    }
                    ahead
                }
            };
            here = ahead;
        }
        Ok(None)
    }

    fn hit_at(&self, ray: &Ray, distance_m: f64) -> Hit {
        Hit {
            distance_m,
            n: self.levels.fine_enough(distance_m * ray.spread),
        }
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

    fn place<F: Field>(
        &self,
        ray: &Ray,
        distance_m: f64,
        reader: &mut Reader<'_, F>,
    ) -> Result<Place, RenderError> {
        let position = ray.at(distance_m);
        let n = self.levels.fine_enough(distance_m * ray.spread);
        let spot = self
            .levels
            .spot(n, MapPoint::from_direction(position).normalised());
        let ground_m = reader.heights(spot.key)?.at(&spot) * self.exaggeration;
        let radius_m = position.length();
        Ok(Place {
            distance_m,
            position,
            radius_m,
            spot,
            n,
            clear_m: radius_m - self.radius_m - ground_m,
        })
    }

    /// Signed height of a place of the ray above the ground.
    pub(super) fn clearance<F: Field>(
        &self,
        ray: &Ray,
        distance_m: f64,
        reader: &mut Reader<'_, F>,
    ) -> Result<f64, RenderError> {
        Ok(self.place(ray, distance_m, reader)?.clear_m)
    }

    /// The crossing between a place above the ground and one that is not: false position, which takes
    /// turns at the ends (Dowell and Jarratt 1971: the Illinois form) and closes in from both sides.
    fn meet<F: Field>(
        &self,
        ray: &Ray,
        above: &Place,
        below: &Place,
        reader: &mut Reader<'_, F>,
    ) -> Result<Hit, RenderError> {
        let (mut above, mut above_m) = (above.distance_m, above.clear_m);
        let (mut below, mut below_m) = (below.distance_m, below.clear_m);
        let exact = 1e-5 * self.step * ray.spread;
        let mut last_was_above = None;
        for _ in 0..60 {
            let (wide, least) = (below - above, exact * below);
            if wide <= least {
                break;
            }
            let guess = above + wide * (above_m / (above_m - below_m));
            // Half of what is asked for beyond the guess: the other end comes there next.
            let t = guess.clamp(above + 0.5 * least, below - 0.5 * least);
            let clear_m = self.clearance(ray, t, reader)?;
            let is_above = clear_m > 0.0;
            let again = last_was_above == Some(is_above);
            last_was_above = Some(is_above);
            if is_above {
                (above, above_m) = (t, clear_m);
                if again {
                    below_m *= 0.5;
                }
            } else {
                (below, below_m) = (t, clear_m);
                if again {
                    above_m *= 0.5;
                }
            }
        }
        Ok(self.hit_at(ray, below))
    }

    /// How far the ray may go on without meeting the ground, by the block of cells that lets it go
    /// farthest; or through its cell.
    fn next(&self, ray: &Ray, here: &Place, heights: &Heights) -> Next {
        let spacing_m = self.levels.spacing_m(here.n);
        let (least, beyond) = (self.step * spacing_m, 1e-3 * spacing_m);
        // The level that counts becomes coarser on the way.
        let change = if here.n == 0 {
            f64::INFINITY
        } else {
            self.levels.spacing_m(here.n - 1) / ray.spread - here.distance_m
        };
        let height_m = here.radius_m - self.radius_m;
        let last = super::field::CELLS - 1;
        let cell = |at: f64| (at as i64).clamp(0, last) as usize;
        let at = [cell(here.spot.u), cell(here.spot.v)];
        let mut farthest = 0.0_f64;
        for k in (0..STEPS).rev() {
            let maximum_m = heights.maximum(k, at[0], at[1]) * self.exaggeration;
            if height_m <= maximum_m {
                continue;
            }
            let out = leaving(ray, here, heights, k, at);
            if out <= farthest {
                break;
            }
            let down = descent(ray, here, self.radius_m + maximum_m);
            farthest = farthest.max(down.min(out));
            if down >= out {
                break;
            }
        }
        if farthest >= least {
            return Next::Empty((farthest + beyond).min(change.max(least)));
        }
        let through = leaving(ray, here, heights, 0, at) + beyond;
        let longest = change.min(LONGEST_IN_CELL * spacing_m);
        Next::Cell(through.min(longest).max(least))
    }
}

/// Where, of the way, a square function with these values at its start, middle and end is below zero
/// and least; none where it is not.
fn dip([start, middle, end]: [f64; 3]) -> Option<f64> {
    let bend = start - 2.0 * middle + end;
    let slope = 4.0 * middle - 3.0 * start - end;
    let share = -slope / (4.0 * bend);
    // start + slope · s + 2 · bend · s².
    let least = start + 0.5 * slope * share;
    (bend > 0.0 && share > 0.0 && share < 1.0 && least < 0.0).then_some(share)
}

/// Distance until a descending ray is as low as a sphere that it is outside of; infinite when it
/// never is.
fn descent(ray: &Ray, place: &Place, sphere_m: f64) -> f64 {
    let along = place.position.dot(ray.direction);
    let product = (place.radius_m - sphere_m) * (place.radius_m + sphere_m);
    let squared = along * along - product;
    if along >= 0.0 || squared < 0.0 {
        return f64::INFINITY;
    }
    product / (squared.sqrt() - along)
}

/// Distance until a ray leaves a block of 2^k cells, at most: mirror images of its sides count too.
fn leaving(ray: &Ray, place: &Place, heights: &Heights, k: usize, [x, y]: [usize; 2]) -> f64 {
    let (p, d) = (place.position, ray.direction);
    let (meridians, cones) = heights.sides(k, x, y);
    let mut least = f64::INFINITY;
    let mut crosses = |t: f64| {
        if t > 0.0 && t < least {
            least = t;
        }
    };
    for [sin, cos] in meridians {
        // A NaN or infinity, for a ray along the meridian, crosses nothing.
        crosses((sin * p.x - cos * p.y) / (cos * d.y - sin * d.x));
    }
    let squared_m = place.radius_m * place.radius_m;
    for cos in cones {
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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_dip_between_three_places_above_the_ground_is_found_where_it_is_deepest(
            deepest in 0.01..0.99_f64, depth in 0.001..10.0_f64, bend in 0.1..1e4_f64,
        ) {
            let value = |s: f64| bend * (s - deepest) * (s - deepest) - depth;
            let values = [value(0.0), value(0.5), value(1.0)];
            prop_assume!(values.iter().all(|v| *v > 0.0));
            let found = dip(values).expect("it is below zero");
            prop_assert!((found - deepest).abs() < 1e-6, "{found} {deepest}");
            prop_assert_eq!(dip(values.map(|v| v + 1.001 * depth)), None);
        }
    }
}
