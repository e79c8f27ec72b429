//! The map transform keeps its promised precision at every level and colatitude.

#[path = "../examples/support/transform_truth.rs"]
mod truth;

use truth::{COLATITUDES, Form, LEVELS, worst_error};

#[test]
fn in_single_precision_the_ground_error_stays_below_six_ten_millionths_of_the_ring() {
    for level in LEVELS {
        for colat_rad in COLATITUDES {
            let worst = worst_error(Form::Exact, level, colat_rad, 4000);
            let share = worst / truth::ring_radius_rad(level);
            assert!(
                share <= 6e-7,
                "level {level}, colatitude {colat_rad}: {share:e} of the ring"
            );
        }
    }
}

#[test]
fn the_printed_acos_form_would_not_keep_it() {
    let level = 16;
    let worst = worst_error(Form::Acos, level, 0.9, 600);
    assert!(worst / truth::ring_radius_rad(level) > 1e-4, "{worst:e}");
}

#[test]
fn the_printed_approximation_would_be_off_by_hundreds_of_metres_at_level_eight() {
    let worst = worst_error(Form::Empirical, 8, core::f64::consts::FRAC_PI_4, 600);
    let worst_m = worst * relievo_planet::Planet::EARTH.radius_m;
    assert!(worst_m > 100.0, "{worst_m} m");
}
