//! Orders of eviction and of prefetch, compared over recorded camera paths.
//!
//! `cargo bench -p relievo-tiles --bench scheduling`: a simulation with a 60 Hz clock that stumbles as
//! real ones do, one worker, and fixed costs (4 ms a height tile, 2.5 ms a colour tile, each
//! 256 KiB), so that the table is the same on every machine. Frames at 1280×960, colour windows of
//! 1024. A frame is at full detail if all tiles that it can show are in the cache; a tile is in vain if
//! no frame showed it between its making and its eviction (or the end).

#![expect(clippy::print_stdout, reason = "a bench says what it found")]

use std::collections::HashSet;
use std::sync::Arc;
use std::time::Duration;

use relievo_graph::ContentId;
use relievo_planet::camera::PathAhead;
use relievo_planet::clipmap::{ClipKind, HeightRange, PlanInput, Planner, Quality};
use relievo_planet::{Camera, Planet, TileKey};
use relievo_raster::{Bands, Block, SampleType, Tile};
use relievo_tiles::TileState;
use relievo_tiles::cache::{Cache, Eviction, Focus};

const FLAT: HeightRange = HeightRange {
    min_m: 0.0,
    max_m: 500.0,
};
const FRAME_MS: f64 = 1000.0 / 60.0;
const AHEAD_S: [f64; 2] = [0.2, 0.6];
const PREFETCH: usize = 384;
const TILE_BYTES: usize = 256 * 256 * 4;

/// Seconds, longitude, latitude, altitude in metres, heading, pitch.
type Key = [f64; 6];

/// An approach from space to a valley.
const FLY_IN: &[Key] = &[
    [0.0, -100.0, 30.0, 1e7, 0.0, -90.0],
    [4.0, -111.0, 39.0, 8e5, 0.0, -85.0],
    [8.0, -111.9, 40.2, 4e4, 20.0, -60.0],
    [12.0, -111.9, 40.3, 1e3, 45.0, -30.0],
    [13.0, -111.9, 40.3, 1e3, 45.0, -30.0],
];
/// Along a coast at one altitude, two altitudes a second.
const PAN: &[Key] = &[
    [0.0, 8.0, 44.0, 5e3, 60.0, -50.0],
    [0.5, 8.0, 44.0, 5e3, 60.0, -50.0],
    [5.5, 8.5, 44.25, 5e3, 60.0, -50.0],
    [6.5, 8.5, 44.25, 5e3, 60.0, -50.0],
    [11.5, 8.0, 44.0, 5e3, 60.0, -50.0],
];
/// Twice around a mountain.
const ORBIT: &[Key] = &[
    [0.0, 7.55, 45.98, 1.2e4, 90.0, -35.0],
    [3.0, 7.66, 46.06, 1.2e4, 180.0, -35.0],
    [6.0, 7.77, 45.98, 1.2e4, 270.0, -35.0],
    [9.0, 7.66, 45.90, 1.2e4, 360.0, -35.0],
    [12.0, 7.55, 45.98, 1.2e4, 450.0, -35.0],
    [15.0, 7.66, 46.06, 1.2e4, 540.0, -35.0],
    [18.0, 7.77, 45.98, 1.2e4, 630.0, -35.0],
    [21.0, 7.66, 45.90, 1.2e4, 720.0, -35.0],
    [24.0, 7.55, 45.98, 1.2e4, 810.0, -35.0],
];
/// A look at the surroundings, and back to work; twice.
const ZOOM: &[Key] = &[
    [0.0, 11.4, 47.26, 2e3, 0.0, -70.0],
    [1.0, 11.4, 47.26, 2e3, 0.0, -70.0],
    [4.0, 11.4, 47.26, 4e5, 0.0, -85.0],
    [5.0, 11.4, 47.26, 4e5, 0.0, -85.0],
    [8.0, 11.4, 47.26, 2e3, 0.0, -70.0],
    [9.0, 11.4, 47.26, 2e3, 0.0, -70.0],
    [12.0, 11.4, 47.26, 4e5, 0.0, -85.0],
    [15.0, 11.4, 47.26, 2e3, 0.0, -70.0],
];
/// Between bookmarks; some come again. Keys of equal time are cuts.
const JUMPS: &[Key] = &[
    [0.0, 11.4, 47.26, 2e3, 0.0, -70.0],
    [2.0, 11.4, 47.26, 2e3, 0.0, -70.0],
    [2.0, -70.0, -33.0, 8e3, 120.0, -40.0],
    [4.0, -70.0, -33.0, 8e3, 120.0, -40.0],
    [4.0, 86.9, 27.9, 9e3, 0.0, -20.0],
    [6.0, 86.9, 27.9, 9e3, 0.0, -20.0],
    [6.0, 11.4, 47.26, 2e3, 0.0, -70.0],
    [8.0, 11.4, 47.26, 2e3, 0.0, -70.0],
    [8.0, 138.7, 35.3, 3e4, 0.0, -90.0],
    [10.0, 138.7, 35.3, 3e4, 0.0, -90.0],
    [10.0, -70.0, -33.0, 8e3, 120.0, -40.0],
    [12.0, -70.0, -33.0, 8e3, 120.0, -40.0],
];

const PATHS: [(&str, &[Key]); 5] = [
    ("fly in, 10 000 km to 1 km", FLY_IN),
    ("pan and back, 2 altitudes/s", PAN),
    ("orbit, two turns", ORBIT),
    ("zoom out and back, twice", ZOOM),
    ("jumps between bookmarks", JUMPS),
];

fn camera_at(keys: &[Key], time_s: f64) -> Camera {
    let after = keys.partition_point(|k| k[0] <= time_s).min(keys.len() - 1);
    let (a, b) = (keys[after.saturating_sub(1)], keys[after]);
    let f = ((time_s - a[0]) / (b[0] - a[0]).max(1e-9)).clamp(0.0, 1.0);
    let mix = |i: usize| a[i] + f * (b[i] - a[i]);
    Camera {
        lon_rad: mix(1).to_radians(),
        lat_rad: mix(2).to_radians(),
        altitude_m: a[3] * (b[3] / a[3]).powf(f),
        heading_rad: mix(4).to_radians(),
        pitch_rad: mix(5).to_radians(),
        fov_y_rad: 1.0,
    }
}

/// A tile with its name.
type Named = (ContentId, ClipKind, TileKey);

/// What one frame wants.
struct Frame {
    ms: f64,
    visible: Vec<Named>,
    /// Along the path.
    ahead: Vec<Named>,
    /// In the windows.
    window: Vec<Named>,
    focus: Focus,
}

fn named((kind, key): (ClipKind, TileKey)) -> Named {
    let hash = blake3::hash(format!("{kind:?} {key}").as_bytes());
    (ContentId(*hash.as_bytes()), kind, key)
}

/// Frames along a path, on a clock with jitter and a stall now and then.
fn record(keys: &[Key]) -> Vec<Frame> {
    let input = |camera| PlanInput {
        camera,
        planet: Planet::EARTH,
        viewport_px: [1280, 960],
        ground_m: 0.0,
        terrain: &FLAT,
        exaggeration: 1.0,
        quality: Quality {
            finest_height_level: 14,
            finest_colour_level: 18,
            ..Quality::default()
        },
    };
    let mut planner = Planner::new();
    let mut path = PathAhead::default();
    let mut frames = Vec::new();
    let mut time_s = 0.0;
    let mut random = 7_u32;
    while time_s < keys[keys.len() - 1][0] {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let late = [0.0, 0.0, 0.0, 0.0, 1.0, 0.3, 0.0, 4.0][(random >> 29) as usize];
        let stall = if (random >> 8).is_multiple_of(97) {
            9.0
        } else {
            0.0
        };
        let ms = FRAME_MS * (1.0 + 0.25 * late + stall);
        let camera = camera_at(keys, time_s);
        let plan = planner.plan(&input(camera));
        path.observe(time_s, &camera, 0.0, Planet::EARTH.radius_m);
        let finest =
            |plan: &relievo_planet::clipmap::Plan| plan.colours.last().map_or(0, |l| l.level.n);
        let mut focus = Focus::from(plan.focus);
        focus.finest = finest(&plan);
        let mut ahead = Vec::new();
        for seconds in AHEAD_S {
            if let Some(camera) = path.after(seconds) {
                let there = Planner::new().plan(&input(camera));
                focus.ahead = there.focus;
                focus.finest = focus.finest.max(finest(&there));
                ahead.extend(there.wanted_tiles().into_iter().map(named));
            }
        }
        frames.push(Frame {
            ms,
            visible: plan.wanted_tiles().into_iter().map(named).collect(),
            ahead,
            window: plan.prefetch_tiles().into_iter().map(named).collect(),
            focus,
        });
        time_s += ms / 1000.0;
    }
    frames
}

/// What is prefetched, in this order.
#[derive(Clone, Copy)]
enum Prefetch {
    Nothing,
    Window,
    /// What the program does.
    Ahead,
    AheadThenWindow,
}

#[derive(Default)]
struct Outcome {
    frames: usize,
    full: usize,
    made: usize,
    in_vain: usize,
    twice: usize,
}

fn cost_ms(kind: ClipKind) -> f64 {
    match kind {
        ClipKind::Heights => 4.0,
        ClipKind::Colours => 2.5,
    }
}

fn play(frames: &[Frame], bytes: usize, eviction: Eviction, prefetch: Prefetch) -> Outcome {
    let mut block = Block::new(Bands::Height, 256, 256);
    block.samples_mut()[0] = 1.0;
    let tile = Arc::new(Tile::from_block(&block, SampleType::Height));
    let mut cache = Cache::new(bytes).with_eviction(eviction);
    let mut made: HashSet<ContentId> = HashSet::new();
    // Tiles that no frame has shown since they were made.
    let mut unseen: HashSet<ContentId> = HashSet::new();
    let mut out = Outcome::default();
    // More would push itself out of the cache again.
    let most = PREFETCH.min(bytes / 4 / TILE_BYTES);
    // What the worker is at: tile and milliseconds that are left.
    let mut at: Option<(Named, f64)> = None;
    for frame in frames {
        let visible: HashSet<ContentId> = frame.visible.iter().map(|t| t.0).collect();
        cache.set_wanted(|id| visible.contains(&id), frame.focus);
        for (id, ..) in &frame.visible {
            if cache.contains(*id) {
                unseen.remove(id);
            }
        }
        out.frames += 1;
        out.full += usize::from(frame.visible.iter().all(|t| cache.contains(t.0)));
        let more: Vec<&Named> = match prefetch {
            Prefetch::Nothing => Vec::new(),
            Prefetch::Window => frame.window.iter().take(most).collect(),
            Prefetch::Ahead => frame.ahead.iter().take(most).collect(),
            Prefetch::AheadThenWindow => {
                frame.ahead.iter().chain(&frame.window).take(most).collect()
            }
        };
        let mut queue = frame.visible.iter().chain(more);
        let mut left_ms = frame.ms;
        while left_ms > 0.0 {
            let (job, rest_ms) = match at.take() {
                Some(running) => running,
                None => match queue.find(|t| !cache.contains(t.0)) {
                    Some(next) => (*next, cost_ms(next.1)),
                    None => break,
                },
            };
            if rest_ms > left_ms {
                at = Some((job, rest_ms - left_ms));
                break;
            }
            left_ms -= rest_ms;
            let (id, kind, key) = job;
            let cost = Duration::from_secs_f64(cost_ms(kind) / 1e3);
            let state = TileState::Ready(Arc::clone(&tile));
            cache.insert(id, key, state, cost.into(), visible.contains(&id));
            out.made += 1;
            out.twice += usize::from(!made.insert(id));
            out.in_vain += usize::from(!unseen.insert(id));
        }
    }
    out.in_vain += unseen.len();
    out
}

fn main() {
    let variants = [
        ("first in, first out", Eviction::Fifo, Prefetch::Window),
        (
            "distance (\\[CH07\\])",
            Eviction::Distance,
            Prefetch::Window,
        ),
        ("worth", Eviction::Worth, Prefetch::Window),
        ("worth", Eviction::Worth, Prefetch::Nothing),
        ("worth", Eviction::Worth, Prefetch::Ahead),
        ("worth", Eviction::Worth, Prefetch::AheadThenWindow),
    ];
    let recorded: Vec<_> = PATHS.iter().map(|(_, keys)| record(keys)).collect();
    for mib in [80, 256] {
        println!(
            "\nCache of {mib} MiB: full detail in % of frames / tiles made / in vain / made again\n"
        );
        print!("| evicted | prefetched |");
        for (name, _) in PATHS {
            print!(" {name} |");
        }
        println!(" all |\n|---|---|{}---|", "---|".repeat(PATHS.len()));
        for (name, eviction, prefetch) in variants {
            let what = match prefetch {
                Prefetch::Nothing => "nothing",
                Prefetch::Window => "window",
                Prefetch::Ahead => "path",
                Prefetch::AheadThenWindow => "path, window",
            };
            print!("| {name} | {what} |");
            let mut sum = Outcome::default();
            for frames in &recorded {
                let o = play(frames, mib << 20, eviction, prefetch);
                tell(&o);
                sum.frames += o.frames;
                sum.full += o.full;
                sum.made += o.made;
                sum.in_vain += o.in_vain;
                sum.twice += o.twice;
            }
            tell(&sum);
            println!();
        }
    }
}

fn tell(o: &Outcome) {
    let full = 100.0 * o.full as f64 / o.frames.max(1) as f64;
    print!(" {full:.0} / {} / {} / {} |", o.made, o.in_vain, o.twice);
}
