//! Prints the map transform's largest error on this device, as a part of the ring's radius, by
//! ring and by colatitude of the focus. The design allows 5e-7 everywhere.

#![expect(clippy::print_stdout, reason = "a program whose output is a table")]

use core::f64::consts::PI;
use std::error::Error;

use relievo_gpu::Gpu;
use relievo_gpu::measure::TransformMeter;

fn main() -> Result<(), Box<dyn Error>> {
    let gpu = Gpu::headless()?;
    println!(
        "adapter: {} ({:?}, {})",
        gpu.info.name, gpu.info.backend, gpu.info.driver_info
    );
    let meter = TransformMeter::new(&gpu.device);
    let colats_deg = [
        0.0, 1e-4, 0.01, 1.0, 10.0, 30.0, 45.0, 60.0, 89.0, 90.0, 120.0, 150.0, 179.0, 180.0,
    ];
    println!(
        "largest error / ring radius, in units of 1e-7; rows: ring, columns: colatitude in degrees"
    );
    print!("ring");
    for colat in colats_deg {
        print!("{colat:>8}");
    }
    println!();
    let mut worst = 0.0_f64;
    for ring in 1..=24 {
        print!("{ring:>4}");
        for colat in colats_deg {
            let error = meter.worst_error(&gpu, (colat / 180.0) * PI, ring, 512, 16)?;
            worst = worst.max(error);
            print!("{:>8.2}", error * 1e7);
        }
        println!();
    }
    println!("largest: {worst:.2e} of the ring's radius");
    Ok(())
}
