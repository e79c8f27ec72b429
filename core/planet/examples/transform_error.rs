//! Prints the error of the single-precision map transforms in metres on Earth, level by
//! colatitude: `cargo run -p relievo-planet --example transform_error`.

#![expect(
    clippy::print_stdout,
    reason = "printing the table is what this program is for"
)]

#[path = "support/transform_truth.rs"]
mod truth;

use relievo_planet::Planet;
use truth::{COLATITUDES, Form, LEVELS, ring_radius_rad, worst_error};

fn main() {
    for (form, title) in [
        (Form::Exact, "without cancellation"),
        (Form::Acos, "[CH06] acos(pz) - colatitude"),
        (Form::Empirical, "[CH06] eq. 11 and 14"),
    ] {
        println!("\nLargest error in metres on Earth, {title}; columns: colatitude in degrees");
        print!("level  ring_radius_m");
        for colat_rad in COLATITUDES {
            print!(" {:>9.5}", colat_rad.to_degrees());
        }
        println!("  share_of_ring");
        let mut overall = 0.0_f64;
        for level in LEVELS {
            print!(
                "{level:>5}  {:>13.3}",
                ring_radius_rad(level) * Planet::EARTH.radius_m
            );
            let mut largest = 0.0_f64;
            for colat_rad in COLATITUDES {
                let error = worst_error(form, level, colat_rad, 4000);
                largest = largest.max(error);
                print!(" {:>9.2e}", error * Planet::EARTH.radius_m);
            }
            let share = largest / ring_radius_rad(level);
            overall = overall.max(share);
            println!("  {share:>13.2e}");
        }
        println!("largest share of the ring's radius: {overall:.2e}");
    }
}
