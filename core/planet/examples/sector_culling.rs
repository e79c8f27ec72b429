//! Prints how many triangles culling leaves over, and how many tiles are wanted, for the three views
//! of \[CH06\] 5.2: on the ground, from an aircraft, from space, all near Lake Garda.
#![expect(clippy::print_stdout, reason = "an example that prints")]

use std::time::Instant;

use relievo_planet::clipmap::{HeightRange, PlanInput, Planner, Quality, RingMesh};
use relievo_planet::{Camera, Planet};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mesh = RingMesh::new(512, 20)?;
    let (ring, disc) = (mesh.ring_indices(), mesh.disc_indices());
    println!("view       rings  triangles     drawn  ratio  selected  wanted  in windows  plan µs");
    for (name, altitude_m, pitch_deg) in [
        ("ground", 752.0, -2.0),
        ("aircraft", 10_000.0, -30.0),
        ("space", 1_000_000.0, -60.0_f64),
    ] {
        for size in [256, 1024, 2048] {
            let input = PlanInput {
                camera: Camera {
                    lon_rad: 10.65_f64.to_radians(),
                    lat_rad: 45.6_f64.to_radians(),
                    altitude_m,
                    heading_rad: -0.6,
                    pitch_rad: pitch_deg.to_radians(),
                    fov_y_rad: 60.0_f64.to_radians(),
                },
                planet: Planet::EARTH,
                viewport_px: [1280, 960],
                ground_m: 750.0,
                terrain: &HeightRange {
                    min_m: 60.0,
                    max_m: 4_800.0,
                },
                exaggeration: 1.0,
                quality: Quality {
                    colour_samples: size,
                    height_texel_px: 1.0,
                    ..Quality::default()
                },
            };
            let mut planner = Planner::new();
            let plan = planner.plan(&input);
            // The least of many: what else the machine does only adds.
            let micros = (0..100)
                .map(|_| {
                    let start = Instant::now();
                    planner.plan(&input);
                    start.elapsed().as_micros()
                })
                .min()
                .unwrap_or_default();
            let rings = plan.rings.clone().count();
            let all = rings * ring.indices.len() / 3 + disc.indices.len() / 3;
            let drawn = plan
                .sectors
                .iter()
                .map(|s| s.visible.count_ones() as usize)
                .sum::<usize>()
                * ring.indices.len()
                / 48
                + plan.disc_sectors.count_ones() as usize * disc.indices.len() / 48;
            let wanted: usize = plan.colours.iter().map(|l| l.wanted_tiles().len()).sum();
            let selected: usize = plan.colours.iter().map(|l| l.selected.len()).sum();
            let held: usize = plan.colours.iter().map(|l| l.window.tiles().count()).sum();
            println!(
                "{name:10} {rings:5} {all:10} {drawn:9} {:6.1}  {selected:8}  {wanted:6}  {held:10}  {micros:7}  N = {size}",
                all as f64 / drawn as f64
            );
        }
    }
    Ok(())
}
