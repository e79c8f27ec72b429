//! Hostile input that once found a fault, and the seeds of the fuzz targets, on the stable compiler.
//!
//! `fuzz/` holds the targets, their seeds and, in `regressions/`, what libfuzzer found, minimised:
//! each file there was a panic, a hang, or a broken promise, and is none now.

#[path = "../../../fuzz/targets.rs"]
mod targets;

use std::path::Path;
use std::time::Duration;

use relievo_engine::planet::{Camera, MapPoint};
use relievo_engine::project::Project;
use relievo_engine::raster::Cancel;
use relievo_engine::{Engine, EngineOptions, View};

/// Runs every file of a folder of `fuzz/` through its target; returns how many there were.
fn replay(folder: &Path, target: targets::Target) -> usize {
    let (name, run) = target;
    let Ok(entries) = std::fs::read_dir(folder.join(name)) else {
        return 0;
    };
    let mut files: Vec<_> = entries.flatten().map(|e| e.path()).collect();
    files.sort();
    for file in &files {
        let bytes = std::fs::read(file).expect("a file of the checkout can be read");
        // A failure names the file, which is what one needs to debug it.
        eprintln!("{}", file.display());
        run(&bytes);
    }
    files.len()
}

fn fuzz() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz")
}

#[test]
fn seeds_of_all_targets_pass_them() {
    for target in targets::ALL {
        let count = replay(&fuzz().join("seeds"), *target);
        let shared = matches!(target.0, "geotiff" | "raster");
        assert!(count > 0 || shared, "{} has no seeds", target.0);
    }
}

#[test]
fn fixtures_of_the_readers_pass_their_targets() {
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../raster/tests/fixtures");
    let mut count = 0;
    for entry in std::fs::read_dir(fixtures)
        .expect("fixtures exist")
        .flatten()
    {
        let path = entry.path();
        if path.is_file() {
            let bytes = std::fs::read(&path).expect("a file of the checkout can be read");
            println!("{}", path.display());
            targets::geotiff(&bytes);
            targets::raster(&bytes);
            count += 1;
        }
    }
    assert!(count > 10, "found {count} fixtures");
}

#[test]
fn what_fuzzing_found_stays_mended() {
    let folder = fuzz().join("regressions");
    let known: Vec<&str> = targets::ALL.iter().map(|(name, _)| *name).collect();
    for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let named = name.to_string_lossy();
        assert!(
            !entry.path().is_dir() || known.contains(&&*named),
            "a folder of no target: {named}"
        );
    }
    for target in targets::ALL {
        replay(&folder, *target);
    }
}

#[test]
fn a_file_that_shrinks_while_it_is_shown_fails_its_tiles_and_nothing_else() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let fixture =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../raster/tests/fixtures/deflate-3-float.tif");
    let path = folder.path().join("shrinks.tif");
    std::fs::copy(fixture, &path).expect("a fixture can be copied");
    let text = r#"{"version": 1, "layers": [{"id": "a", "kind": "height", "path": "shrinks.tif",
        "georeference": {"crs": "EPSG:4326", "west": 10, "south": 40, "east": 12, "north": 42}}]}"#;
    let project = Project::from_json(text, Path::new("p.relievo")).expect("a project");
    let options = EngineOptions {
        threads: Some(1),
        cache_folder: None,
        ..EngineOptions::default()
    };
    let mut engine = Engine::new(project, folder.path(), options).expect("threads can start");
    engine.wait_for_sources();
    let shrunk = std::fs::File::options().write(true).open(&path);
    shrunk
        .and_then(|file| file.set_len(9))
        .expect("the copy can be cut");

    let inside = MapPoint::from_degrees(11.0, 41.0);
    let refused = engine.questions().place(inside, &Cancel::default());
    let line = refused.expect_err("nothing is left to read").to_string();
    assert!(
        line.contains("shrinks.tif") && line.lines().count() == 1,
        "{line}"
    );

    engine.set_view(View {
        camera: Camera::from_degrees(11.0, 41.0, 1e5, 0.0, -90.0, 60.0).expect("a camera"),
        viewport_px: [160, 120],
        layout: relievo_engine::Layout::STANDARD,
        colour_window: 256,
        colour_texel_px: 1.0,
        height_texel_px: 2.0,
        max_taps: 4,
    });
    let converged = (0..10_000).any(|_| {
        let frame = engine.drain(f32::INFINITY).expect("a view was set");
        let done = frame.is_converged() && frame.uploads.is_empty();
        if !done {
            engine.wait(Duration::from_millis(20));
        }
        done
    });
    assert!(converged, "a failed tile counts as ready");
    assert!(
        engine.stats().tiles.failed > 0,
        "{:?}",
        engine.stats().tiles
    );
    assert!(
        engine
            .messages()
            .iter()
            .any(|m| m.text.contains("shrinks.tif")),
        "{:?}",
        engine.messages()
    );
    let outside = MapPoint::from_degrees(-100.0, -30.0);
    let answer = engine.questions().place(outside, &Cancel::default());
    assert!(answer.is_ok(), "{answer:?}");
}
