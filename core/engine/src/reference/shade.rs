//! Light along a ray: ground, its light and the air before it, or the sky.

use glam::DVec3;
use relievo_graph::RenderError;
use relievo_planet::MapPoint;

use super::air::Air;
use super::field::Field;
use super::light::{lit, steepened};
use super::march::{Ground, Hit, Ray};
use super::patches::Reader;
use crate::frame::Sun;

/// Most samples along the major axis of a ray's footprint.
const MOST_TAPS: f64 = 64.0;

/// Sun, air and ground of one picture.
pub(super) struct Light {
    pub(super) ground: Ground,
    pub(super) air: Air,
    pub(super) sun: Sun,
    /// Size of a ray's footprint at right angles to it, per metre of distance.
    pub(super) footprint: f64,
}

impl Light {
    /// Linear light along a ray that meets the ground at `hit`.
    pub(super) fn along<F: Field>(
        &self,
        ray: &Ray,
        hit: Option<Hit>,
        reader: &mut Reader<'_, F>,
    ) -> Result<DVec3, RenderError> {
        let Some(hit) = hit else {
            return Ok(self.air.sky(ray.direction));
        };
        let position = ray.eye + ray.direction * hit.distance_m;
        let radius_m = position.length();
        let up = position / radius_m;
        let (_, normal) = self.ground_at(up, hit.n, reader)?;
        let ground = self.mean(ray, &hit, position, normal.unwrap_or(up), reader)?;
        let veil = self
            .air
            .before(radius_m - self.ground.radius_m, up, ray.direction);
        Ok(ground * veil.transmitted + veil.scattered)
    }

    /// Mean light of the ground over the footprint, whose major axis lies along the ray on the ground.
    fn mean<F: Field>(
        &self,
        ray: &Ray,
        hit: &Hit,
        position: DVec3,
        normal: DVec3,
        reader: &mut Reader<'_, F>,
    ) -> Result<DVec3, RenderError> {
        let across = ray.direction.dot(normal);
        let along = (ray.direction - normal * across).normalize_or_zero();
        let width_m = hit.distance_m * self.footprint;
        let spacing_m = self.ground.levels.spacing_m(hit.n);
        let length_m = (width_m / across.abs().max(1e-6)).min(MOST_TAPS * width_m);
        let taps = (length_m / spacing_m).ceil().clamp(1.0, MOST_TAPS);
        let mut sum = DVec3::ZERO;
        for tap in 0..taps as u32 {
            let share = (f64::from(tap) + 0.5) / taps - 0.5;
            let up = (position + along * (share * length_m)).normalize_or(normal);
            let (colour, normal) = self.ground_at(up, hit.n, reader)?;
            sum += normal.map_or(colour, |normal| colour * lit(normal, up, &self.sun));
        }
        Ok(sum / taps)
    }

    /// Colour and unit normal of the ground below a direction, at a level.
    fn ground_at<F: Field>(
        &self,
        up: DVec3,
        n: u8,
        reader: &mut Reader<'_, F>,
    ) -> Result<(DVec3, Option<DVec3>), RenderError> {
        let point = MapPoint::from_direction(up).normalised();
        let spot = self.ground.levels.spot(n, point);
        let look = reader.look(spot.key)?;
        let steep = |normal| steepened(normal, up, self.ground.exaggeration);
        Ok((look.colour(&spot), look.normal(&spot).map(steep)))
    }
}
