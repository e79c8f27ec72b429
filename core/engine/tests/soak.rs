//! Long use: thousands of camera jumps and edits within a small bound of memory.
//!
//! The short form runs always, the long one when asked for:
//! `cargo test -p relievo-engine --test soak -- --ignored --nocapture`.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "common/screen.rs"]
mod screen;

use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use relievo_engine::planet::Camera;
use relievo_engine::project::{
    Adjust, Blend, Edit, Layer, LayerId, LayerKind, Noise, NoiseLayer, NoiseMode, Project,
    SourceRole, Tint, TintInterpolation, TintLayer, TintStop, layer_from_source,
};
use relievo_engine::raster::file::Georeference;
use relievo_engine::raster::write::{CogLayout, CogSamples, CogWork, write_cog};
use relievo_engine::raster::{Bands, Block, Cancel, PixelRect};
use relievo_engine::{Engine, EngineOptions, View};
use screen::picture;

/// Bound of the tile cache, less than what two views need.
const MEMORY: usize = 40 << 20;

/// Threads are counted, so one form runs at a time.
static ALONE: Mutex<()> = Mutex::new(());

/// SplitMix64 (Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// From `low` up to `high`.
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// One of so many.
    fn below(&mut self, count: u64) -> u64 {
        self.next() % count
    }
}

fn write_file(path: &Path) {
    let layout = CogLayout {
        width: 700,
        height: 500,
        samples: CogSamples::Rgba8,
        tile: 256,
        georeference: Some(Georeference {
            crs: Arc::from("EPSG:4326"),
            plane_from_pixel: [-40.0, 0.1, 0.0, 60.0, 0.0, -0.1],
        }),
        largest_classic_bytes: CogLayout::LARGEST_CLASSIC_BYTES,
    };
    let source = |rect: PixelRect| {
        let mut block = Block::new(Bands::Colour, rect.width as usize, rect.height as usize);
        for (plane, samples) in block.planes_mut::<4>().into_iter().enumerate() {
            for (i, sample) in samples.iter_mut().enumerate() {
                let (x, y) = (
                    rect.x as usize + i % rect.width as usize,
                    rect.y as usize + i / rect.width as usize,
                );
                *sample = if plane == 3 {
                    1.0
                } else {
                    ((x * (plane + 2) + y * 3) % 256) as f32 / 255.0
                };
            }
        }
        Ok(block)
    };
    let work = CogWork {
        threads: 1,
        resume: None,
        cancel: &Cancel::default(),
    };
    write_cog(path, &layout, &source, &work, &mut |_| {}).unwrap();
}

fn project(folder: &Path) -> Project {
    let file = folder.join("picture.tif");
    write_file(&file);
    let noise = Noise {
        mode: NoiseMode::Replace,
        octaves: 5,
        ..Noise::default()
    };
    let stops = vec![
        TintStop::new(-900.0, [20, 60, 20]),
        TintStop::new(900.0, [220, 220, 200]),
    ];
    let tint = TintLayer {
        tint: Tint {
            stops,
            interpolation: TintInterpolation::Smooth,
        },
        blend: Blend::Normal,
        adjust: Adjust::default(),
    };
    let picture = layer_from_source(LayerId::from("picture"), folder, &file, SourceRole::Imagery);
    let hills = LayerKind::Noise(NoiseLayer { noise });
    Project {
        layers: vec![
            Layer::new(LayerId::from("hills"), "Hills", hills),
            Layer::new(LayerId::from("tint"), "Tint", LayerKind::Tint(tint)),
            picture.unwrap(),
        ],
        ..Project::default()
    }
}

fn options() -> EngineOptions {
    EngineOptions {
        threads: Some(2),
        memory: MEMORY,
        cache_folder: None,
        watch: Some(Duration::from_millis(100)),
        ..EngineOptions::default()
    }
}

fn view(random: &mut Random) -> View {
    let altitude_m = 10_f64.powf(random.between(3.3, 7.2));
    let camera = Camera::from_degrees(
        random.between(-180.0, 180.0),
        random.between(-89.9, 89.9),
        altitude_m,
        random.between(0.0, 360.0),
        random.between(-90.0, -20.0),
        60.0,
    );
    View {
        camera: camera.unwrap(),
        viewport_px: [240, 180],
        layout: relievo_engine::Layout::STANDARD,
        colour_window: 256,
        colour_texel_px: 1.0,
        height_texel_px: 2.0,
        max_taps: 4,
    }
}

/// One thing that a hand does.
fn act(engine: &mut Engine, random: &mut Random) {
    let id = LayerId::from(["tint", "picture"][random.below(2) as usize]);
    match random.below(20) {
        0..12 => engine.set_view(view(random)),
        12..17 => {
            // A slider: some moves, one undo step.
            engine.begin_drag();
            for _ in 0..=random.below(3) {
                let adjust = Adjust {
                    contrast: random.between(0.5, 2.0),
                    hue_deg: random.between(-180.0, 180.0),
                    ..Adjust::default()
                };
                engine
                    .apply(Edit::SetAdjust {
                        id: id.clone(),
                        adjust,
                    })
                    .unwrap();
                engine.drain(0.016);
            }
            if random.below(4) == 0 {
                engine.cancel_drag();
            } else {
                engine.end_drag();
            }
        }
        17 => {
            let opacity = random.between(0.0, 1.0);
            engine.apply(Edit::SetOpacity { id, opacity }).unwrap();
        }
        18 => {
            let visible = random.below(3) > 0;
            engine.apply(Edit::SetVisible { id, visible }).unwrap();
        }
        _ => {
            if random.below(2) == 0 {
                engine.undo().unwrap();
            } else {
                engine.redo().unwrap();
            }
        }
    }
}

/// Names of this program's threads that the engine started.
#[cfg(target_os = "linux")]
fn engine_threads() -> Vec<String> {
    let tasks = std::fs::read_dir("/proc/self/task").unwrap();
    let names = tasks.filter_map(|t| std::fs::read_to_string(t.unwrap().path().join("comm")).ok());
    names.filter(|n| n.starts_with("relievo")).collect()
}

/// Peak of the memory that the system counts for this program, MiB.
#[cfg(target_os = "linux")]
fn peak_rss_mib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|l| l.starts_with("VmHWM:")).unwrap();
    let kib: u64 = line.split_whitespace().nth(1).unwrap().parse().unwrap();
    kib >> 10
}

fn soak(steps: u32, seed: u64) {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random(seed);
    let mut engine = Engine::new(project(folder.path()), folder.path(), options()).unwrap();
    engine.set_view(view(&mut random));
    engine.wait_for_sources();
    let mut peak = 0;
    let mut most = engine.stats().kept;
    for step in 0..steps {
        act(&mut engine, &mut random);
        for _ in 0..=random.below(3) {
            engine.drain(0.016);
            engine.wait(Duration::from_millis(20));
        }
        let stats = engine.stats();
        let bytes = stats.tiles.cache_bytes;
        peak = peak.max(bytes);
        assert!(bytes <= MEMORY, "step {step}: {bytes} of {MEMORY} bytes");
        let kept = stats.kept;
        most.resident = most.resident.max(kept.resident);
        most.arrived = most.arrived.max(kept.arrived);
        most.asked = most.asked.max(kept.asked);
        most.names = most.names.max(kept.names);
        // Three stacks of at most 25 levels, each of which holds parts of 3 by 3 tiles at most.
        assert!(kept.resident <= 3 * 25 * 9, "step {step}: {kept:?}");
        assert!(kept.arrived <= kept.asked, "step {step}: {kept:?}");
        assert!(kept.asked <= 3 * 25 * 9, "step {step}: {kept:?}");
        assert!(kept.names <= 2 * 60_000, "step {step}: {kept:?}");
        // As the file lies before and after an edit, its node and geometry; besides the datum, how heights
        // lie over it, and the normals, which are kept to be the same in the next revision.
        assert!(kept.nodes <= 4 + 3, "step {step}: {kept:?}");
        assert_eq!((kept.files, kept.messages), (1, 0), "step {step}");
    }
    let last = view(&mut random);
    engine.set_view(last);
    let made = engine.stats().tiles.made;
    let after = picture(&mut engine);
    let project = engine.project().clone();
    eprintln!(
        "{steps} steps: {made} tiles made, {} evicted, cache peak {} MiB of {}, {most:?}",
        engine.stats().tiles.evicted,
        peak >> 20,
        MEMORY >> 20
    );
    drop(engine);
    #[cfg(target_os = "linux")]
    {
        eprintln!("peak of the program: {} MiB", peak_rss_mib());
        assert_eq!(engine_threads(), Vec::<String>::new(), "no thread is left");
    }
    let mut fresh = Engine::new(project, folder.path(), options()).unwrap();
    fresh.set_view(last);
    fresh.wait_for_sources();
    assert!(!after.is_empty());
    assert!(
        picture(&mut fresh) == after,
        "the same as for a fresh engine"
    );
}

#[test]
fn a_few_hundred_jumps_and_edits_stay_within_the_bounds() {
    soak(300, 1);
}

#[test]
#[ignore = "some minutes"]
fn ten_thousand_jumps_and_edits_stay_within_the_bounds() {
    soak(10_000, 2);
}
