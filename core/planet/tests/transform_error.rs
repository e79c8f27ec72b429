//! The map transform keeps its promised precision at every level and colatitude.

use core::f64::consts::FRAC_PI_4;

use relievo_planet::Planet;
use relievo_planet::transform::forms::{
    COLATITUDES, Form, LEVELS, ring_radius_rad, worst_error_rad,
};

#[test]
fn in_single_precision_the_ground_error_stays_below_six_ten_millionths_of_the_ring() {
    for level in LEVELS {
        for colat_rad in COLATITUDES {
            for form in [Form::CancellationFree, Form::CancellationFreePoly] {
                let share = worst_error_rad(form, level, colat_rad, 4000) / ring_radius_rad(level);
                assert!(
                    share <= 6e-7,
                    "{form:?}, level {level}, colatitude {colat_rad}: {share:e} of the ring"
                );
            }
        }
    }
}

#[test]
fn the_printed_form_loses_half_a_metre_at_any_level_and_more_at_the_poles() {
    for form in [Form::Printed, Form::PrintedPoly] {
        let at = |level, colat_rad| {
            worst_error_rad(form, level, colat_rad, 600) * Planet::EARTH.radius_m
        };
        for level in [12, 16, 24] {
            assert!((0.2..3.0).contains(&at(level, 0.9)), "{form:?}");
        }
    }
    let at_pole = worst_error_rad(Form::Printed, 16, 1e-3, 600) * Planet::EARTH.radius_m;
    assert!(at_pole > 50.0, "{at_pole} m");
}

#[test]
fn the_printed_approximation_would_be_off_by_hundreds_of_metres_at_level_eight() {
    let worst = worst_error_rad(Form::Approximate, 8, FRAC_PI_4, 600);
    assert!(worst * Planet::EARTH.radius_m > 100.0, "{worst:e}");
    // Where it is meant to be used it keeps a thousandth of the ring.
    let share = worst_error_rad(Form::Approximate, 12, FRAC_PI_4, 600) / ring_radius_rad(12);
    assert!((1e-4..1.2e-3).contains(&share), "{share:e}");
}

#[test]
fn blending_takes_the_printed_form_far_out_and_the_approximation_near_the_focus() {
    for colat_rad in [0.3, FRAC_PI_4, 2.2] {
        let worst = |form, level| worst_error_rad(form, level, colat_rad, 600);
        assert_eq!(worst(Form::Blended, 4), worst(Form::Printed, 4));
        assert_eq!(worst(Form::Blended, 14), worst(Form::Approximate, 14));
    }
    // Near a pole there is nothing to approximate with.
    assert_eq!(
        worst_error_rad(Form::Blended, 14, 0.05, 600),
        worst_error_rad(Form::Printed, 14, 0.05, 600)
    );
}
