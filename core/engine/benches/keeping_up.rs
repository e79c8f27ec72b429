//! Keeping up: how many of its altitudes a camera may fly in a second while every frame of a 60 Hz
//! clock has its finest level complete, as in Table 1 of \[CH07\] (0.8 altitudes per second there).
//!
//! `cargo bench -p relievo-engine --bench keeping_up [-- files|noise|sharp] [ALTITUDE ...]`. Nothing is drawn. The
//! clock is simulated: a frame lasts until the workers have had a sixtieth of a second of the
//! processor each, or have nothing to do, so that other load on the machine does not count. The
//! camera stays at its altitude above the ground, whose slopes do not depend on how finely it is laid.

#![expect(clippy::print_stdout, reason = "a bench says what it found")]
#![expect(clippy::unwrap_used, reason = "a bench that cannot go on has failed")]

#[path = "support/processor.rs"]
mod processor;

use std::path::Path;
use std::time::Duration;

use processor::{own_ns, worker_ns};
use relievo_engine::planet::{Camera, MapPoint};
use relievo_engine::raster::Cancel;
use relievo_engine::{Bake, Engine, EngineOptions, Output, View};

/// Altitude in metres and finest level of \[CH07\] Table 1.
const TABLE: [(f64, u8); 9] = [
    (800e3, 5),
    (80e3, 9),
    (50e3, 10),
    (20e3, 11),
    (6000.0, 13),
    (2000.0, 14),
    (800.0, 16),
    (200.0, 17),
    (50.0, 20),
];

const RADIUS_M: f64 = 6_371_008.8;
const FRAMES: u32 = 60;
/// Frames at the start that do not count: a standing start is not keeping up.
const STARTING: u32 = 20;
const FRAME_S: f64 = 1.0 / 60.0;
const FOV_DEG: f64 = 60.0;

/// Size of a sample of level n on the ground in metres.
fn texel_m(n: u8) -> f64 {
    core::f64::consts::PI * RADIUS_M / (256.0 * f64::from(n).exp2())
}

fn pixel_m(altitude_m: f64) -> f64 {
    altitude_m * 2.0 * (FOV_DEG.to_radians() / 2.0).tan() / 960.0
}

fn noise_layer(amplitude_m: f64, wavelength_m: f64, octaves: u32) -> String {
    format!(
        r##"{{"id": "hills", "name": "hills", "kind": "noise", "amplitude_m": {amplitude_m},
            "wavelength_m": {wavelength_m}, "octaves": {octaves}, "mode": "replace"}},
          {{"id": "tint", "name": "tint", "kind": "tint", "stops": [
            {{"height_m": {}, "colour": "#305070"}}, {{"height_m": 0, "colour": "#a0a060"}},
            {{"height_m": {amplitude_m}, "colour": "#f0f0f0"}}]}}"##,
        -amplitude_m
    )
}

fn write(folder: &Path, name: &str, layers: &str) -> std::path::PathBuf {
    let path = folder.join(name);
    let text =
        format!(r#"{{"version": 1, "planet": {{"preset": "earth"}}, "layers": [{layers}]}}"#);
    std::fs::write(&path, text).unwrap();
    path
}

fn open(path: &Path, threads: usize) -> Engine {
    let options = EngineOptions {
        threads: Some(threads),
        cache_folder: None,
        ..EngineOptions::default()
    };
    let (mut engine, _) = Engine::open(path, options).unwrap();
    engine.wait_for_sources();
    assert!(engine.messages().is_empty(), "{:?}", engine.messages());
    engine
}

/// Colours and heights to fly over, in files with overviews.
fn bake_files(folder: &Path) {
    let project = write(folder, "baking.relievo", &noise_layer(2000.0, 4e5, 6));
    let engine = open(&project, 1);
    let questions = engine.questions();
    for (output, name, resolution) in [
        (Output::Colour, "colour.tif", 0.002),
        (Output::Height, "height.tif", 0.004),
    ] {
        let bake = Bake {
            output,
            bounds: [0.0, -1.28, 32.768, 1.28],
            resolution,
            crs: "EPSG:4326".to_owned(),
        };
        let path = folder.join(name);
        questions
            .bake(&bake, &path, 2, &mut |_| {}, &Cancel::default())
            .unwrap();
    }
}

/// The files, laid so that a sample of the colours is one of level n and the flight starts well
/// inside them.
fn files_project(folder: &Path, n: u8) -> std::path::PathBuf {
    let degrees = (texel_m(n) / RADIUS_M).to_degrees();
    let (west, east) = (-1024.0 * degrees, 15_360.0 * degrees);
    // As the ground shrinks so do its heights, or its slopes would become cliffs.
    let scale = (degrees / 0.002).min(1.0);
    let north = (640.0 * degrees).min(80.0);
    let place = format!(
        r#""georeference": {{"crs": "EPSG:4326", "west": {west}, "south": {}, "east": {east}, "north": {north}}}"#,
        -north
    );
    let layers = format!(
        r#"{{"id": "h", "name": "h", "kind": "height", "path": "height.tif",
             "vertical_scale": {scale}, {place}}},
           {{"id": "c", "name": "c", "kind": "imagery", "path": "colour.tif", {place}}}"#
    );
    write(folder, &format!("files-{n}.relievo"), &layers)
}

fn noise_project(folder: &Path, n: u8) -> std::path::PathBuf {
    let octaves = (2e6 / (4.0 * texel_m(n))).log2().ceil() as u32 + 1;
    write(
        folder,
        &format!("noise-{n}.relievo"),
        &noise_layer(3000.0, 2e6, octaves),
    )
}

struct Result {
    /// Frames whose finest level was complete.
    complete: f64,
    /// Share of one processor that each worker used.
    busy: f64,
    drain_us: f64,
    finest: u8,
}

/// A second of cameras that fly eastwards at `rate` altitudes a second and as high above the ground.
fn path_of(engine: &Engine, altitude_m: f64, rate: f64) -> Vec<Camera> {
    let questions = engine.questions();
    let camera = |frame: u32| {
        let lon_rad = f64::from(frame) * FRAME_S * rate * altitude_m / RADIUS_M;
        let below = questions
            .place(
                MapPoint::from_degrees(lon_rad.to_degrees(), 0.0),
                &Cancel::default(),
            )
            .unwrap();
        let eye_m = below.height_m + altitude_m;
        Camera::from_degrees(lon_rad.to_degrees(), 0.0, eye_m, 90.0, -90.0, FOV_DEG).unwrap()
    };
    (0..=FRAMES).map(camera).collect()
}

/// Flies a second eastwards at `rate` altitudes a second.
fn fly(path: &Path, altitude_m: f64, rate: f64, view: View, threads: usize) -> Result {
    let cameras = path_of(&open(path, threads), altitude_m, rate);
    let mut engine = open(path, threads);
    let at = |frame: u32| View {
        camera: cameras[frame as usize],
        ..view
    };
    engine.set_view(at(0));
    // Prefetched tiles come, too, as they would have on the way there.
    for _ in 0..4000 {
        let done = engine.drain(1.0).unwrap().is_converged();
        if engine.wait(Duration::from_millis(50)) && done {
            break;
        }
    }
    let start_ns = worker_ns();
    let mut idle_ns = 0.0;
    let mut complete = 0;
    let mut drains_ns = 0;
    let mut finest = 0;
    for frame in 1..=FRAMES {
        let drained = own_ns();
        engine.set_view(at(frame));
        let shown = engine.drain(FRAME_S as f32).unwrap();
        drains_ns += own_ns() - drained;
        complete += u32::from(frame > STARTING && engine.stats().pending == 0);
        finest = shown.colours.last().map_or(0, |l| l.window.level.n);
        let until = f64::from(frame) * FRAME_S * 1e9 * threads as f64;
        loop {
            let had = (worker_ns() - start_ns) as f64 + idle_ns;
            if had >= until {
                break;
            }
            if engine.stats().tiles.pending == 0 {
                idle_ns += until - had;
                break;
            }
            std::thread::sleep(Duration::from_micros(300));
        }
    }
    let used = (worker_ns() - start_ns) as f64;
    Result {
        complete: f64::from(complete) / f64::from(FRAMES - STARTING),
        busy: used / (f64::from(FRAMES) * FRAME_S * 1e9 * threads as f64),
        drain_us: drains_ns as f64 / 1e3 / f64::from(FRAMES),
        finest,
    }
}

fn main() {
    let which: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with('-'))
        .collect();
    let altitudes: Vec<f64> = which.iter().filter_map(|w| w.parse().ok()).collect();
    let names: Vec<&String> = which.iter().filter(|w| w.parse::<f64>().is_err()).collect();
    let asked = |name: &str| names.is_empty() || names.iter().any(|w| *w == name);
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    bake_files(folder);
    println!(
        "one worker; share of frames with the finest level complete, and of its processor that"
    );
    println!("the worker used; processor time of set_view and drain together, mean of all frames");
    println!();
    println!("| run | altitude m | finest level | altitudes/s | complete | busy | frame µs |");
    println!("|---|---|---|---|---|---|---|");
    for (name, rates, sharp, noise) in [
        ("files", [16.0, 8.0], false, false),
        ("noise", [8.0, 4.0], false, true),
        ("sharp", [4.0, 2.0], true, false),
    ] {
        if !asked(name) {
            continue;
        }
        for (altitude_m, paper) in TABLE {
            if !altitudes.is_empty() && !altitudes.contains(&altitude_m) {
                continue;
            }
            let pixel = pixel_m(altitude_m);
            let (window, texel_px, n) = if sharp {
                let n = (texel_m(0) / pixel).log2().floor() as u8;
                (1024, 1.0, n)
            } else {
                (256, 0.999 * texel_m(paper) / pixel, paper)
            };
            let project = if noise {
                noise_project(folder, n)
            } else {
                files_project(folder, n)
            };
            let view = View {
                camera: Camera::from_degrees(0.0, 0.0, altitude_m, 0.0, -90.0, FOV_DEG).unwrap(),
                viewport_px: [1280, 960],
                layout: relievo_engine::Layout::STANDARD,
                colour_window: window,
                colour_texel_px: texel_px,
                height_texel_px: if sharp { 2.0 } else { 2.0 * texel_px },
                max_taps: 4,
            };
            for rate in rates {
                let r = fly(&project, altitude_m, rate, view, 1);
                println!(
                    "| {name} | {altitude_m} | {} | {rate} | {:.0} % | {:.0} % | {:.0} |",
                    r.finest,
                    100.0 * r.complete,
                    100.0 * r.busy,
                    r.drain_us
                );
                if r.complete >= 0.99 {
                    break;
                }
            }
        }
    }
}
