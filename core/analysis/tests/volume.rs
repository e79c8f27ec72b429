//! Volumes against closed forms, with the observed order of convergence.

#![expect(
    clippy::unwrap_used,
    reason = "helpers of a test panic where it would fail"
)]

mod common;

use core::f64::consts::PI;

use common::{Impatient, on_map};
use glam::DVec2;
use relievo_analysis::{
    Amount, AnalysisError, Between, Ground, MapBox, Unwatched, VolumeSettings, Volumes, volumes,
};
use relievo_planet::map::wrap_longitude;
use relievo_planet::{MapPoint, Planet};

/// Where formulas of metres have their origin, in degrees.
const MIDDLE: (f64, f64) = (11.0, 47.0);

/// Metres east and north of a middle: along circles of latitude and meridians, so that areas are
/// the ellipsoid's (to 10⁻⁸ over 100 m).
fn metres(place: MapPoint, middle: (f64, f64)) -> DVec2 {
    let middle = MapPoint::from_degrees(middle.0, middle.1);
    let lon_rad = wrap_longitude(place.lon_rad - middle.lon_rad);
    DVec2::new(
        Planet::EARTH.metres_per_radian(place.colat_rad).x * lon_rad,
        Planet::EARTH.metres_per_radian(middle.colat_rad).y * (middle.colat_rad - place.colat_rad),
    )
}

/// A ground whose heights are a formula of metres around the middle.
fn flat(formula: impl Fn(DVec2) -> f64 + Sync) -> impl Ground {
    on_map(Planet::EARTH, 12, move |place| {
        formula(metres(place, MIDDLE))
    })
}

/// An area by metres west, south, east and north of the middle.
fn sides_m([west, south, east, north]: [f64; 4]) -> MapBox {
    let middle = MapPoint::from_degrees(MIDDLE.0, MIDDLE.1);
    let metres = Planet::EARTH.metres_per_radian(middle.colat_rad);
    MapBox {
        west_rad: middle.lon_rad + west / metres.x,
        east_rad: middle.lon_rad + east / metres.x,
        north_colat_rad: middle.colat_rad - north / metres.y,
        south_colat_rad: middle.colat_rad - south / metres.y,
    }
}

/// Not symmetric.
fn region(half_m: f64) -> MapBox {
    sides_m([-half_m, -half_m, half_m * 1.013, half_m * 1.013])
}

fn measure(
    before: &dyn Ground,
    after: &dyn Ground,
    half_m: f64,
    settings: VolumeSettings,
) -> Volumes {
    volumes(
        &Between { before, after },
        &region(half_m),
        &settings,
        &Unwatched,
    )
    .unwrap()
}

/// Without halving anything.
fn plain(spacing_m: f64) -> VolumeSettings {
    VolumeSettings {
        tolerance: f64::INFINITY,
        ..VolumeSettings::from_spacing(spacing_m)
    }
}

/// A line of the table in `docs/reports/volumes.md`; tests that pass keep it to themselves.
#[expect(clippy::print_stdout, reason = "it is asked for with --nocapture")]
fn tell(what: &str, found: &Volumes, amount: Amount, exact: f64) {
    println!(
        "| {what} | {:.3} m | {} | {:.3} m³ | {:.1e} | {:.1e} |",
        found.finest_m,
        found.samples,
        amount.value,
        (amount.value / exact - 1.0).abs(),
        amount.error / exact
    );
}

fn within(amount: Amount, exact: f64) {
    let off = (amount.value - exact).abs();
    assert!(
        off <= amount.error + 1e-6 * exact.abs(),
        "{amount:?}, exactly {exact}, off by {off}"
    );
}

/// How many times smaller errors become when the spacing is halved, as a power of 2.
fn order(errors: &[f64]) -> f64 {
    let steps = errors.len() as f64 - 1.0;
    libm::log2(errors[0] / errors[errors.len() - 1]) / steps
}

/// Height of a round platform of 30 m radius at 100 m, with side slopes of 1 in 2, on a cone that
/// falls by 0.1 from 104 m in its middle.
fn cone(p: DVec2) -> f64 {
    104.0 - 0.1 * p.length()
}

fn platform_on_cone(p: DVec2) -> f64 {
    let away = (p.length() - 30.0).max(0.0);
    cone(p).clamp(100.0 - 0.5 * away, 100.0 + 0.5 * away)
}

/// The same in closed form: the cone stands 1 m above the platform's rim; the batter rises by 0.5 and
/// meets the cone (0.1 falling) after 1 / 0.6 m.
fn cut_on_cone() -> f64 {
    let (r, rim, reach) = (30.0, 1.0, 1.0 / 0.6);
    // Above the platform: a cylinder of the rim's height and a cone of 3 m on it.
    let inside = PI * r * r * rim + PI * r * r * 3.0 / 3.0;
    // Around it: ∫ 2π (r + t)(1 − 0.6 t) dt over 0 ≤ t ≤ reach.
    let outside = 2.0
        * PI
        * (r * (reach - 0.3 * reach * reach) + reach * reach / 2.0 - 0.2 * reach * reach * reach);
    inside + outside
}

#[test]
fn a_platform_on_a_cone_has_its_volume_to_second_order() {
    let (before, after) = (flat(cone), flat(platform_on_cone));
    let exact = cut_on_cone();
    let mut errors = Vec::new();
    for spacing_m in [4.0, 2.0, 1.0, 0.5] {
        let found = measure(&before, &after, 40.0, plain(spacing_m));
        within(found.cut_m3, exact);
        tell("platform on a cone", &found, found.cut_m3, exact);
        errors.push((found.cut_m3.value - exact).abs());
    }
    println!("order {:.2}", order(&errors));
    assert!(order(&errors) > 1.5, "{errors:?}");
    let fine = measure(&before, &after, 40.0, VolumeSettings::from_spacing(2.0));
    tell("platform on a cone, halved", &fine, fine.cut_m3, exact);
    within(fine.cut_m3, exact);
    within(fine.net_m3, -exact);
    within(fine.fill_m3, 0.0);
    assert!(
        fine.cut_m3.error < 2e-3 * exact && fine.cut_m3.error > 0.0,
        "{fine:?}"
    );
    within(fine.plan_area_m2, PI * libm::pow(30.0 + 1.0 / 0.6, 2.0));
    within(fine.highest_cut_m, 4.0);
}

#[test]
fn a_square_platform_on_a_plane_has_cut_fill_and_batters_in_closed_form() {
    // The plane rises by s eastward through the middle of a platform of half side a at its height; cut
    // and fill batters of slope m all around. The envelope of cones is round at corners, so the closed
    // form is taken without corners: batters go only east and west of a strip, in a region that ends
    // with it.
    let (s, m, a) = (0.2, 0.5, 20.0);
    let before = flat(move |p: DVec2| 500.0 + s * p.x);
    let after = flat(move |p: DVec2| {
        let away = (p.x.abs() - a).max(0.0);
        (500.0 + s * p.x).clamp(500.0 - m * away, 500.0 + m * away)
    });
    let half_m = 30.0;
    let width_m = half_m * 2.013;
    // East: the plane stands s·a above the rim; a triangle inside, a triangle of the batter outside.
    let reach_m = s * a / (m - s);
    let section_m2 = 0.5 * s * a * a + 0.5 * s * a * reach_m;
    // The batters end beyond the region on neither side.
    assert!(a + reach_m < 40.0);
    let area = sides_m([-60.0, -half_m, 60.0, half_m * 1.013]);
    let change = Between {
        before: &before,
        after: &after,
    };
    let found = volumes(
        &change,
        &area,
        &VolumeSettings::from_spacing(1.5),
        &Unwatched,
    )
    .unwrap();
    let exact = section_m2 * width_m;
    tell("platform on a plane, halved", &found, found.cut_m3, exact);
    within(found.cut_m3, exact);
    within(found.fill_m3, exact);
    within(found.net_m3, 0.0);
    assert!(found.cut_m3.error < 2e-3 * exact, "{found:?}");
    within(found.highest_cut_m, s * a);
    within(found.highest_fill_m, s * a);
    within(found.plan_area_m2, 2.0 * (a + reach_m) * width_m);
    // On the batters the surface is longer than its plan by √(1 + m²).
    let stretch = libm::sqrt(1.0 + m * m);
    within(
        found.surface_area_m2,
        2.0 * (a + reach_m * stretch) * width_m,
    );
    let mean_deg = reach_m * libm::atan(m).to_degrees() / (a + reach_m);
    within(found.mean_slope_deg, mean_deg);
}

#[test]
fn a_dam_across_a_v_valley_has_its_volume_to_second_order() {
    // The valley's sides rise by v to both sides of the y axis; the dam's crest of width w lies at
    // height c, its faces fall by m. Fill: ∫∫ max(0, min(c, c − m (|y| − w/2)) − v |x|).
    let (v, c, m, w) = (0.5, 20.0, 0.4, 6.0);
    let before = flat(move |p: DVec2| v * p.x.abs());
    let after = flat(move |p: DVec2| {
        let face = c - m * (p.y.abs() - 0.5 * w).max(0.0);
        face.max(v * p.x.abs())
    });
    // Crest: triangle of the cross-section times w; faces: ∫ (c − m t)² / v dt over 0 ≤ t ≤ c / m, twice.
    let exact = c * c / v * w + 2.0 * c * c * c / (3.0 * m * v);
    let mut errors = Vec::new();
    for spacing_m in [6.0, 3.0, 1.5, 0.75] {
        let found = measure(&before, &after, 70.0, plain(spacing_m));
        within(found.fill_m3, exact);
        within(found.cut_m3, 0.0);
        tell("dam across a valley", &found, found.fill_m3, exact);
        errors.push((found.fill_m3.value - exact).abs());
    }
    println!("order {:.2}", order(&errors));
    assert!(order(&errors) > 1.7, "{errors:?}");
    let fine = measure(&before, &after, 70.0, VolumeSettings::from_spacing(3.0));
    tell("dam across a valley, halved", &fine, fine.fill_m3, exact);
    within(fine.fill_m3, exact);
    within(fine.highest_fill_m, c);
    assert!(fine.fill_m3.error < 2e-3 * exact, "{fine:?}");
}

#[test]
fn walls_converge_too_and_say_how_well() {
    // A box 10 m deep with vertical walls, askew.
    let before = flat(|_: DVec2| 50.0);
    let inside = |p: DVec2| {
        let turned = DVec2::from_angle(0.3).rotate(p);
        turned.x.abs() < 17.3 && turned.y.abs() < 9.1
    };
    let after = flat(move |p: DVec2| if inside(p) { 40.0 } else { 50.0 });
    let exact = 10.0 * 34.6 * 18.2;
    let found = measure(&before, &after, 30.0, VolumeSettings::from_spacing(1.0));
    tell("box with walls, askew, halved", &found, found.cut_m3, exact);
    within(found.cut_m3, exact);
    within(found.plan_area_m2, 34.6 * 18.2);
    assert!(found.cut_m3.error < 0.02 * exact, "{found:?}");
    assert!(
        found.finest_m < 0.5,
        "halved at the walls only: {}",
        found.finest_m
    );
}

#[test]
fn what_is_equal_costs_nothing_and_changes_nothing() {
    struct Same;
    impl relievo_analysis::Change for Same {
        fn planet(&self) -> Planet {
            Planet::EARTH
        }
        fn same(&self, _grid: &relievo_planet::Grid) -> bool {
            true
        }
        fn heights(
            &self,
            _grid: &relievo_planet::Grid,
        ) -> Result<(Vec<f64>, Vec<f64>), AnalysisError> {
            panic!("nothing is evaluated")
        }
    }
    let settings = VolumeSettings::from_spacing(1.0);
    let found = volumes(&Same, &region(1e5), &settings, &Unwatched).unwrap();
    assert_eq!(
        (found.cut_m3.value, found.net_m3.error, found.samples),
        (0.0, 0.0, 0)
    );
}

#[test]
fn the_number_of_threads_does_not_show() {
    let (before, after) = (flat(cone), flat(platform_on_cone));
    let with = |threads| {
        let settings = VolumeSettings {
            threads,
            tolerance: 1e-2,
            ..VolumeSettings::from_spacing(1.0)
        };
        measure(&before, &after, 40.0, settings)
    };
    assert_eq!(with(1), with(4));
}

/// Square metres of the ellipsoid between two circles of latitude per radian of longitude (the closed
/// form of the zone, Snyder 1987, eq. 3-12).
fn zone_m2(south_deg: f64, north_deg: f64) -> f64 {
    let e2 = Planet::EARTH.eccentricity_squared();
    let e = e2.sqrt();
    let q = |lat_deg: f64| {
        let sin = libm::sin(lat_deg.to_radians());
        (1.0 - e2) * (sin / (1.0 - e2 * sin * sin) + libm::atanh(e * sin) / e)
    };
    let a = Planet::EARTH.equatorial_radius_m;
    0.5 * a * a * (q(north_deg) - q(south_deg))
}

#[test]
fn a_metre_over_a_part_of_the_map_is_its_area_on_the_ellipsoid_and_nothing_beside_it() {
    let (before, after) = (
        on_map(Planet::EARTH, 12, |_| 0.0),
        on_map(Planet::EARTH, 12, |_| 1.0),
    );
    let change = Between {
        before: &before,
        after: &after,
    };
    for bounds in [
        [11.0, 46.3, 12.1, 47.0],
        [179.2, -0.4, -179.9, 0.3],
        [-180.0, 89.0, 180.0, 90.0],
        [20.0, -90.0, 140.0, -88.7],
    ] {
        let area = MapBox::from_degrees(bounds).unwrap();
        let found = volumes(&change, &area, &plain(4000.0), &Unwatched).unwrap();
        let exact = zone_m2(bounds[1], bounds[3]) * area.width_rad();
        assert!(
            (found.fill_m3.value / exact - 1.0).abs() < 1e-9,
            "{bounds:?}: {found:?}, {exact}"
        );
        assert!((found.plan_area_m2.value / exact - 1.0).abs() < 1e-9);
    }
}

#[test]
fn at_a_pole_and_across_the_antimeridian_volumes_are_those_of_elsewhere() {
    let exact = cut_on_cone();
    let settings = VolumeSettings {
        tolerance: 5e-3,
        ..VolumeSettings::from_spacing(2.0)
    };
    let cut = |area: &MapBox, at: &(dyn Fn(MapPoint) -> DVec2 + Sync)| {
        let before = on_map(Planet::EARTH, 12, |place| cone(at(place)));
        let after = on_map(Planet::EARTH, 12, |place| platform_on_cone(at(place)));
        let change = Between {
            before: &before,
            after: &after,
        };
        volumes(&change, area, &settings, &Unwatched).unwrap()
    };
    let pole = MapBox::around(MapPoint::from_degrees(0.0, 90.0), 45.0 / 6.3e6);
    let away = |place: MapPoint| DVec2::X * Planet::EARTH.metres_per_radian(place.colat_rad).x;
    let off_pole = MapPoint::from_degrees(30.0, 90.0 - 10.0 / 111_000.0);
    let over_pole = MapBox::around(off_pole, 60.0 / 6.3e6);
    let seam = MapBox::around(MapPoint::from_degrees(180.0, -47.0), 45.0 / 6.3e6);
    let beyond = |place: MapPoint| metres(place, (180.0, -47.0));
    for found in [
        cut(&pole, &away),
        cut(&over_pole, &away),
        cut(&seam, &beyond),
    ] {
        tell("platform on a cone at a pole", &found, found.cut_m3, exact);
        within(found.cut_m3, exact);
        within(found.plan_area_m2, PI * libm::pow(30.0 + 1.0 / 0.6, 2.0));
        assert!(found.cut_m3.error < 5e-3 * exact, "{found:?}");
    }
}

#[test]
fn senseless_and_endless_requests_are_refused() {
    let ground = flat(|_| 0.0);
    let change = Between {
        before: &ground,
        after: &ground,
    };
    let refuse = |region: &MapBox, settings: &VolumeSettings| {
        let text = volumes(&change, region, settings, &Unwatched)
            .unwrap_err()
            .to_string();
        assert!(
            text.starts_with("expected ") && !text.contains('\n'),
            "{text}"
        );
    };
    refuse(&region(1e6), &VolumeSettings::from_spacing(0.1));
    refuse(&region(-1.0), &VolumeSettings::from_spacing(1.0));
    refuse(&region(f64::NAN), &VolumeSettings::from_spacing(1.0));
    refuse(&region(10.0), &VolumeSettings::from_spacing(0.0));
    refuse(&region(10.0), &VolumeSettings::from_spacing(f64::NAN));
    let impatient = volumes(
        &change,
        &region(500.0),
        &VolumeSettings::from_spacing(1.0),
        &Impatient::default(),
    );
    assert!(matches!(impatient, Err(AnalysisError::Cancelled)));
}
