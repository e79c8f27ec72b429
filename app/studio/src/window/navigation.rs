//! How pointer and keys move the camera.
//!
//! Invariant: what is grabbed stays under the pointer, and the eye stays above the ground.

use glam::{DVec2, DVec3};
use relievo_engine::planet::camera::{Fly, FlyInput, GoTo};
use relievo_engine::planet::{Camera, MapPoint, Planet};

/// Turn for a pointer that crosses the height of the viewport, radians.
const TURN_PER_HEIGHT_RAD: f64 = 3.0;

/// Wheel steps that a double click comes nearer: a quarter of the distance is left.
const DOUBLE_CLICK_STEPS: f64 = 6.2;

/// A place of the ground that a pointer shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Its direction from the planet's centre, of unit length.
    pub direction: DVec3,
    /// Its height above the datum as drawn, metres.
    pub ground_m: f64,
}

/// What a pressed button does.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Held {
    #[default]
    Nothing,
    /// Keeps a ground point under the pointer.
    Pan(Hit),
    /// Turns around a ground point.
    Orbit(Hit),
    /// Turns in place: the sky was grabbed.
    Look,
}

/// On the way to a view.
#[derive(Clone, Copy, Debug)]
struct Journey {
    path: GoTo,
    time_s: f64,
    from: Camera,
    from_ground_m: f64,
    to: Camera,
    /// Height of the ground below the end, as it was known last.
    to_ground_m: f64,
    /// How high above that ground it ends, where that matters more than the height above the datum.
    above_m: Option<f64>,
}

/// The viewer and its motion.
#[derive(Clone, Copy, Debug)]
pub struct Navigation {
    camera: Camera,
    fly: Fly,
    journey: Option<Journey>,
    held: Held,
}

impl Navigation {
    /// At rest at a camera.
    pub fn new(camera: Camera) -> Self {
        Self {
            camera,
            fly: Fly::new(),
            journey: None,
            held: Held::Nothing,
        }
    }

    /// Where the viewer is.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Whether the camera moves without further input.
    pub fn is_moving(&self) -> bool {
        self.journey.is_some() || self.fly.is_moving()
    }

    /// A button goes down: over ground (`hit`) it pans or, with `orbit`, turns around it.
    pub fn grab(&mut self, hit: Option<Hit>, orbit: bool) {
        self.stop();
        self.held = match hit {
            Some(hit) if orbit => Held::Orbit(hit),
            Some(hit) => Held::Pan(hit),
            None => Held::Look,
        };
    }

    /// The button goes up.
    pub fn release(&mut self) {
        self.held = Held::Nothing;
    }

    /// The pointer moves with the button held.
    ///
    /// - `ndc`: where it is now, −1 to 1, right and up.
    /// - `moved`: by how much of the viewport's height, right and down.
    pub fn drag(&mut self, planet: &Planet, ndc: DVec2, aspect: f64, moved: DVec2) {
        let turn = moved * TURN_PER_HEIGHT_RAD;
        self.camera = match self.held {
            Held::Nothing => return,
            Held::Pan(hit) => self
                .camera
                .panned(planet, hit.ground_m, hit.direction, ndc, aspect),
            Held::Orbit(hit) => {
                self.camera
                    .orbited(planet, hit.ground_m, hit.direction, -turn.x, turn.y)
            }
            Held::Look => self.camera.turned(
                -moved.x * self.camera.fov_y_rad,
                moved.y * self.camera.fov_y_rad,
            ),
        };
    }

    /// The wheel turns by `steps`, towards the ground if positive.
    pub fn zoom(&mut self, planet: &Planet, ground_m: f64, ndc: DVec2, aspect: f64, steps: f64) {
        self.stop();
        self.camera = self.camera.zoomed(planet, ground_m, ndc, aspect, steps);
    }

    /// Flies towards a place of the ground, into the middle of the picture.
    pub fn approach(&mut self, planet: &Planet, here_m: f64, hit: Hit, ndc: DVec2, aspect: f64) {
        let near = self
            .camera
            .zoomed(planet, hit.ground_m, ndc, aspect, DOUBLE_CLICK_STEPS);
        let to = near.panned(planet, hit.ground_m, hit.direction, DVec2::ZERO, aspect);
        self.fly_to(planet, here_m, to, hit.ground_m);
    }

    /// Turns north up around the place in the middle of the picture.
    pub fn north_up(&mut self, planet: &Planet, here_m: f64, middle: Option<Hit>) {
        let turn = -relievo_engine::planet::map::wrap_longitude(self.camera.heading_rad);
        let to = match middle {
            Some(hit) => self
                .camera
                .orbited(planet, hit.ground_m, hit.direction, turn, 0.0),
            None => self.camera.turned(turn, 0.0),
        };
        // Around a far point a turn of the eye is not quite one of the heading.
        self.fly_to(
            planet,
            here_m,
            Camera {
                heading_rad: 0.0,
                ..to
            },
            here_m,
        );
    }

    /// Flies to a camera over ground `there_m` above the datum.
    pub fn fly_to(&mut self, planet: &Planet, here_m: f64, to: Camera, there_m: f64) {
        self.depart(planet, here_m, to, there_m, None);
    }

    /// Flies to a camera whose altitude counts from the ground below it. That ground is `there_m`
    /// above the datum as far as is known now; tell what becomes known on the way by [`Self::aim`].
    pub fn fly_above(&mut self, planet: &Planet, here_m: f64, to: Camera, there_m: f64) {
        self.depart(planet, here_m, to, there_m, Some(to.altitude_m));
    }

    fn depart(
        &mut self,
        planet: &Planet,
        from_ground_m: f64,
        to: Camera,
        to_ground_m: f64,
        above_m: Option<f64>,
    ) {
        self.stop();
        let from = self.camera;
        self.journey = Some(Journey {
            path: GoTo::new(planet, from, from_ground_m, from, from_ground_m),
            time_s: 0.0,
            from,
            from_ground_m,
            to,
            to_ground_m: f64::NAN,
            above_m,
        });
        self.aim(planet, to_ground_m);
    }

    /// Where the camera is flying to.
    pub fn destination(&self) -> Option<MapPoint> {
        self.journey.map(|journey| journey.to.map_point())
    }

    /// Says how high the ground below the end of the way is, metres above the datum.
    pub fn aim(&mut self, planet: &Planet, there_m: f64) {
        let Some(journey) = &mut self.journey else {
            return;
        };
        if journey.to_ground_m == there_m {
            return;
        }
        journey.to_ground_m = there_m;
        if let Some(above_m) = journey.above_m {
            journey.to.altitude_m = there_m + above_m;
        }
        journey.path = GoTo::new(
            planet,
            journey.from,
            journey.from_ground_m,
            journey.to.above_ground(there_m),
            there_m,
        );
    }

    /// Is at a camera at once.
    pub fn jump_to(&mut self, camera: Camera) {
        *self = Self::new(camera);
    }

    /// Time passes with keys held.
    ///
    /// - `here_m`: height of the drawn ground below the eye.
    pub fn advance(&mut self, planet: &Planet, here_m: f64, input: &FlyInput, dt_s: f64) {
        if let Some(journey) = &mut self.journey {
            journey.time_s += dt_s;
            self.camera = journey.path.at(journey.time_s);
            if journey.path.is_over(journey.time_s) {
                self.journey = None;
            }
        }
        let wanted = input.right != 0.0 || input.forward != 0.0 || input.up != 0.0;
        if wanted {
            self.journey = None;
        }
        if wanted || self.fly.is_moving() {
            self.camera = self.fly.advance(&self.camera, planet, here_m, input, dt_s);
        }
    }

    /// Keeps the eye above ground `here_m` above the datum.
    pub fn stay_above(&mut self, here_m: f64) {
        self.camera = self.camera.above_ground(here_m);
    }

    fn stop(&mut self) {
        self.journey = None;
        self.fly.stop();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EARTH: Planet = Planet::EARTH;
    const ASPECT: f64 = 1.5;

    fn start() -> Navigation {
        Navigation::new(Camera::from_degrees(10.0, 45.0, 20_000.0, 30.0, -40.0, 60.0).unwrap())
    }

    fn hit(navigation: &Navigation, ndc: DVec2) -> Hit {
        let ground_m = 700.0;
        let direction = navigation
            .camera()
            .ground_at(&EARTH, ground_m, ndc, ASPECT)
            .unwrap();
        Hit {
            direction,
            ground_m,
        }
    }

    #[test]
    fn the_grabbed_ground_stays_under_the_pointer() {
        let mut navigation = start();
        let grabbed = hit(&navigation, DVec2::new(0.2, -0.3));
        navigation.grab(Some(grabbed), false);
        let to = DVec2::new(-0.4, -0.5);
        navigation.drag(&EARTH, to, ASPECT, DVec2::ZERO);
        assert!(hit(&navigation, to).direction.distance(grabbed.direction) < 1e-9);
        navigation.release();
        let before = *navigation.camera();
        navigation.drag(&EARTH, DVec2::ZERO, ASPECT, DVec2::ONE);
        assert_eq!(*navigation.camera(), before, "nothing is held any more");
    }

    #[test]
    fn north_up_ends_with_heading_zero_over_the_same_place() {
        let mut navigation = start();
        let middle = hit(&navigation, DVec2::ZERO);
        navigation.north_up(&EARTH, 700.0, Some(middle));
        for _ in 0..200 {
            navigation.advance(&EARTH, 700.0, &FlyInput::default(), 0.1);
        }
        assert!(!navigation.is_moving());
        assert!(navigation.camera().heading_rad.abs() < 1e-9);
        let seen = hit(&navigation, DVec2::ZERO);
        let off_m = seen.direction.distance(middle.direction) * EARTH.radius_m;
        assert!(off_m < 1_000.0, "{off_m} m");
    }

    #[test]
    fn a_double_click_comes_nearer_and_centres_the_place() {
        let mut navigation = start();
        let at = DVec2::new(0.5, 0.1);
        let clicked = hit(&navigation, at);
        navigation.approach(&EARTH, 700.0, clicked, at, ASPECT);
        for _ in 0..200 {
            navigation.advance(&EARTH, 700.0, &FlyInput::default(), 0.1);
        }
        assert!(navigation.camera().altitude_m < 8_000.0);
        let off_m = hit(&navigation, DVec2::ZERO)
            .direction
            .distance(clicked.direction)
            * EARTH.radius_m;
        assert!(off_m < 1.0, "{off_m} m");
    }

    #[test]
    fn a_journey_ends_above_the_ground_that_became_known_on_the_way() {
        let mut navigation = start();
        let to = Camera::from_degrees(-111.6, 40.2, 900.0, 0.0, -90.0, 60.0).unwrap();
        // Nothing is known of the ground there, and then more and more.
        navigation.fly_above(&EARTH, 700.0, to, 0.0);
        for step in 0..200 {
            if navigation.destination().is_some() {
                navigation.aim(&EARTH, f64::from(step.min(20)) * 100.0);
            }
            navigation.advance(&EARTH, 700.0, &FlyInput::default(), 0.1);
        }
        assert!(!navigation.is_moving());
        assert!((navigation.camera().altitude_m - 2900.0).abs() < 1e-6);
        // An altitude above the datum stays what it is.
        navigation.fly_to(&EARTH, 2000.0, to, 0.0);
        navigation.aim(&EARTH, 500.0);
        navigation.advance(&EARTH, 2000.0, &FlyInput::default(), 60.0);
        assert!((navigation.camera().altitude_m - 900.0).abs() < 1e-6);
    }

    #[test]
    fn keys_end_a_journey_and_the_eye_stays_above_the_ground() {
        let mut navigation = start();
        navigation.fly_to(
            &EARTH,
            0.0,
            Camera::from_degrees(0.0, 0.0, 1e6, 0.0, -90.0, 60.0).unwrap(),
            0.0,
        );
        let down = FlyInput {
            up: -1.0,
            ..FlyInput::default()
        };
        for _ in 0..400 {
            navigation.advance(&EARTH, 700.0, &down, 0.1);
            navigation.stay_above(700.0);
        }
        assert!(
            (700.5..710.0).contains(&navigation.camera().altitude_m),
            "{}",
            navigation.camera().altitude_m
        );
    }
}
