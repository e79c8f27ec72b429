//! Files that change, vanish, break and come back while they are shown.
//!
//! Looks are asked for here and modification times are set by hand, so that nothing depends on a
//! clock; one test has the looking thread do it.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, SystemTime};

use relievo_engine::planet::Camera;
use relievo_engine::project::{
    Edit, Layer, LayerId, LayerKind, Noise, NoiseLayer, NoiseMode, Project, SourceRole,
    layer_from_source,
};
use relievo_engine::raster::file::Georeference;
use relievo_engine::raster::write::{CogLayout, CogSamples, CogWork, write_cog};
use relievo_engine::raster::{Bands, Block, Cancel};
use relievo_engine::{ClipKind, Engine, EngineOptions, Frame, Severity, SourceState, View};

/// Longest wait of a test that hangs for a reason of its own; no test that passes comes near.
const GUARD: Duration = Duration::from_mins(2);

/// Modification time of the files as they are first opened, seconds.
const FIRST_TIME: u64 = 1_000_000;

/// A folder with two files of 20° by 20° side by side, and an engine that shows both over noise.
struct Scene {
    folder: tempfile::TempDir,
    engine: Engine,
    /// The latest modification time that was given, seconds.
    clock: u64,
}

impl Scene {
    fn new() -> Self {
        Self::watched(Some(Duration::MAX), None)
    }

    fn watched(watch: Option<Duration>, wake: Option<Arc<dyn Fn() + Send + Sync>>) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let (west, east) = (
            folder.path().join("west.tif"),
            folder.path().join("east.tif"),
        );
        write(&west, -20.0, [200, 40, 40]);
        write(&east, 0.0, [40, 40, 200]);
        set_time(&west, FIRST_TIME);
        set_time(&east, FIRST_TIME);
        let noise = Noise {
            mode: NoiseMode::Replace,
            octaves: 3,
            ..Noise::default()
        };
        let mut project = Project::default();
        let hills = LayerKind::Noise(NoiseLayer { noise });
        project
            .layers
            .push(Layer::new(LayerId::from("hills"), "Hills", hills));
        for name in ["west", "east"] {
            let file = folder.path().join(name).with_extension("tif");
            let layer = layer_from_source(
                LayerId::from(name),
                folder.path(),
                &file,
                SourceRole::Imagery,
            );
            project.layers.push(layer.unwrap());
        }
        let options = EngineOptions {
            threads: Some(2),
            log: true,
            cache_folder: None,
            watch,
            wake,
            ..EngineOptions::default()
        };
        let mut engine = Engine::new(project, folder.path(), options).unwrap();
        engine.set_view(view(0.0, 4.0e6));
        let mut scene = Self {
            folder,
            engine,
            clock: FIRST_TIME,
        };
        scene.engine.wait_for_sources();
        scene.converge();
        scene.log();
        scene
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Gives a file a modification time that no other content has.
    fn date(&mut self, name: &str) {
        self.clock += 1;
        set_time(&self.path(name), self.clock);
    }

    /// Writes another content in place.
    fn overwrite(&mut self, name: &str, bytes: &[u8]) {
        fs::write(self.path(name), bytes).unwrap();
        self.date(name);
    }

    /// A look at all files, and until what it leads to is done.
    fn look(&mut self) {
        self.engine.look_at_files();
        while self.engine.sources().opening() > 0 {
            self.engine.wait(Duration::from_millis(50));
        }
    }

    fn settle(&mut self) {
        self.look();
        self.look();
        self.converge();
    }

    /// Drains until the picture is done; gives every frame.
    fn converge(&mut self) -> Vec<Frame> {
        converge(&mut self.engine)
    }

    fn log(&mut self) -> Vec<relievo_engine::tiles::LogEntry> {
        self.engine.take_log()
    }

    fn failed(&self, id: &str) -> Option<String> {
        let layer = self.engine.project().layer(&LayerId::from(id)).unwrap();
        match self
            .engine
            .sources()
            .state(&layer.kind, self.engine.folder())
        {
            Some(SourceState::Failed(reason)) => Some(reason),
            Some(SourceState::Open(_) | SourceState::Features(_)) => None,
            Some(SourceState::Opening(_)) | None => panic!("{id} is neither open nor refused"),
        }
    }

    /// All of the picture's tiles, as a front-end that lost its device gets them.
    fn picture(&mut self) -> BTreeMap<String, Vec<u8>> {
        self.engine.forget_uploads();
        let frames = self.converge();
        frames.iter().flat_map(uploads).collect()
    }
}

fn converge(engine: &mut Engine) -> Vec<Frame> {
    let mut frames = Vec::new();
    for _ in 0..5000 {
        let frame = engine.drain(f32::INFINITY).unwrap();
        let done = frame.is_converged() && frame.uploads.is_empty();
        frames.push(frame);
        if done {
            return frames;
        }
        engine.wait(Duration::from_millis(50));
    }
    panic!("does not converge: {:?}", engine.stats());
}

/// Places in the textures, and what is copied there.
fn uploads(frame: &Frame) -> Vec<(String, Vec<u8>)> {
    let one = |u: &relievo_engine::Upload| {
        let place = (u.clipmap, u.layer, u.storage, u.source, u.size);
        let samples = u.tile.bytes().map_or_else(
            || format!("{:?}", u.tile.sample(0, 0)).into_bytes(),
            <[u8]>::to_vec,
        );
        (format!("{place:?}"), samples)
    };
    frame.uploads.iter().map(one).collect()
}

fn view(lon_deg: f64, altitude_m: f64) -> View {
    View {
        camera: Camera::from_degrees(lon_deg, 0.0, altitude_m, 0.0, -90.0, 60.0).unwrap(),
        viewport_px: [200, 160],
        layout: relievo_engine::Layout::STANDARD,
        colour_window: 256,
        colour_texel_px: 1.0,
        height_texel_px: 2.0,
        max_taps: 4,
    }
}

/// Writes a picture of 20° by 20° around the equator, west edge at `west`.
fn write(path: &Path, west: f64, colour: [u8; 3]) {
    fs::write(path, &*bytes(west, colour)).unwrap();
}

/// The file of a picture of one colour with a grain; each is made once.
fn bytes(west: f64, colour: [u8; 3]) -> Arc<Vec<u8>> {
    type Made = BTreeMap<(i32, [u8; 3]), Arc<Vec<u8>>>;
    static MADE: Mutex<Made> = Mutex::new(BTreeMap::new());
    let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
    let file = made
        .entry((west as i32, colour))
        .or_insert_with(|| Arc::new(make(west, colour)));
    Arc::clone(file)
}

fn make(west: f64, colour: [u8; 3]) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("made.tif");
    let layout = CogLayout {
        width: 1024,
        height: 1024,
        samples: CogSamples::Rgb8,
        tile: 256,
        georeference: Some(Georeference {
            crs: Arc::from("EPSG:4326"),
            plane_from_pixel: [west, 20.0 / 1024.0, 0.0, 10.0, 0.0, -20.0 / 1024.0],
        }),
        largest_classic_bytes: CogLayout::LARGEST_CLASSIC_BYTES,
    };
    let source = |rect: relievo_engine::raster::PixelRect| {
        let mut block = Block::new(Bands::Colour, rect.width as usize, rect.height as usize);
        let [red, green, blue, alpha] = block.planes_mut();
        for i in 0..red.len() {
            let grain = (i * 7 % 31) as f32 / 255.0;
            red[i] = f32::from(colour[0]) / 255.0 + grain;
            green[i] = f32::from(colour[1]) / 255.0 + grain;
            blue[i] = f32::from(colour[2]) / 255.0 + grain;
            alpha[i] = 1.0;
        }
        Ok(block)
    };
    let work = CogWork {
        threads: 1,
        resume: None,
        cancel: &Cancel::default(),
    };
    write_cog(&path, &layout, &source, &work, &mut |_| {}).unwrap();
    fs::read(path).unwrap()
}

fn set_time(path: &Path, seconds: u64) {
    let time = SystemTime::UNIX_EPOCH + Duration::from_secs(seconds);
    let file = File::options().write(true).open(path).unwrap();
    file.set_modified(time).unwrap();
}

#[test]
fn a_file_that_changes_on_disk_is_read_again_and_only_what_depends_on_it_is_made() {
    let mut scene = Scene::new();
    let before = scene.picture();
    scene.settle();
    assert_eq!(scene.log(), [], "what stays is left alone");
    let old = fs::read(scene.path("east.tif")).unwrap();
    scene.overwrite("east.tif", &bytes(0.0, [20, 220, 20]));
    scene.look();
    scene.converge();
    assert_eq!(scene.log(), [], "somebody may still be writing");
    scene.look();
    let frames = scene.converge();
    assert!(frames.iter().any(|f| !f.uploads.is_empty()));
    assert!(
        frames
            .iter()
            .flat_map(|f| &f.uploads)
            .all(|u| u.clipmap == ClipKind::Colour),
        "no height and no normal depends on it"
    );
    let made = scene.log();
    let kinds: BTreeSet<_> = made.iter().map(|e| e.kind).collect();
    assert_eq!(kinds.into_iter().collect::<Vec<_>>(), ["file", "overlay"]);
    let ids: BTreeSet<_> = made.iter().map(|e| e.id).collect();
    assert_eq!(ids.len(), made.len(), "each once");
    let read = made.iter().filter(|e| e.kind == "file");
    let nodes: BTreeSet<_> = read.map(|e| e.node).collect();
    assert_eq!(nodes.len(), 1, "the other file is not read again");
    assert!(scene.picture() != before);
    // The same bytes at the same time are the same content: all of it is there already.
    fs::write(scene.path("east.tif"), old).unwrap();
    set_time(&scene.path("east.tif"), FIRST_TIME);
    scene.settle();
    assert_eq!(scene.log(), []);
    assert!(scene.picture() == before);
    assert!(scene.engine.messages().is_empty());
}

#[test]
fn a_file_that_is_replaced_by_another_of_its_name_is_read_again() {
    let mut scene = Scene::new();
    let before = scene.picture();
    write(&scene.path("new.tif"), -20.0, [240, 240, 0]);
    scene.date("new.tif");
    fs::rename(scene.path("new.tif"), scene.path("west.tif")).unwrap();
    scene.settle();
    assert!(!scene.log().is_empty());
    assert!(scene.picture() != before);
    assert!(scene.engine.messages().is_empty());
}

#[test]
fn a_file_that_is_being_written_shows_no_errors_and_no_half_picture() {
    let mut scene = Scene::new();
    let before = scene.picture();
    let whole = bytes(0.0, [20, 220, 20]);
    for share in [1, 40, 300, 500, 900] {
        let part = whole.len() * share / 1000;
        scene.overwrite("east.tif", &whole[..part]);
        scene.look();
        // A tile that has to read the file now cannot, and waits.
        scene.engine.set_view(view(5.0, 3.0e5 + share as f64));
        for _ in 0..20 {
            let frame = scene.engine.drain(f32::INFINITY).unwrap();
            assert!(!shows_stand_in(&frame));
            scene.engine.wait(Duration::from_millis(5));
        }
        assert_eq!(scene.engine.messages(), []);
        assert_eq!(scene.failed("east"), None);
    }
    scene.overwrite("east.tif", &whole);
    scene.engine.set_view(view(0.0, 4.0e6));
    scene.settle();
    assert_eq!(scene.engine.messages(), []);
    let after = scene.picture();
    assert!(after != before);
    // The same as for somebody who never saw the halves.
    let mut fresh = Scene::new();
    fresh.overwrite("east.tif", &whole);
    fresh.settle();
    assert!(fresh.picture() == after);
}

#[test]
fn a_program_that_pauses_while_it_writes_gets_some_patience_and_then_a_line() {
    let mut scene = Scene::new();
    let whole = bytes(0.0, [20, 220, 20]);
    scene.overwrite("east.tif", &whole[..100]);
    for _ in 0..3 {
        scene.look();
        scene.engine.drain(f32::INFINITY);
        assert_eq!(
            (scene.failed("east"), scene.engine.messages().len()),
            (None, 0)
        );
    }
    scene.look();
    scene.converge();
    let reason = scene.failed("east").unwrap();
    assert!(reason.contains("east.tif"), "{reason}");
    assert_eq!(scene.engine.messages().len(), 1);
    scene.overwrite("east.tif", &whole);
    scene.settle();
    assert_eq!(
        (scene.failed("east"), scene.engine.messages().len()),
        (None, 0)
    );
}

#[test]
fn a_file_that_vanishes_is_told_once_and_heals_when_it_comes_back() {
    let mut scene = Scene::new();
    let before = scene.picture();
    let away = scene.path("elsewhere");
    fs::rename(scene.path("west.tif"), &away).unwrap();
    scene.settle();
    let reason = scene.failed("west").unwrap();
    assert!(
        reason.contains("found nothing there") && reason.contains("west.tif"),
        "{reason}"
    );
    assert_eq!(scene.failed("east"), None, "the rest lives");
    for _ in 0..3 {
        scene.settle();
        assert_eq!(scene.engine.messages().len(), 1, "told once");
        assert_eq!(scene.engine.messages()[0].severity, Severity::Error);
    }
    assert!(scene.picture() != before);
    assert_eq!(scene.engine.project().layers.len(), 3, "nothing is dropped");
    scene.log();
    fs::rename(&away, scene.path("west.tif")).unwrap();
    scene.settle();
    assert_eq!(
        (scene.failed("west"), scene.engine.messages().len()),
        (None, 0)
    );
    assert_eq!(
        scene.log(),
        [],
        "the same content as before: nothing is made"
    );
    assert!(scene.picture() == before);
}

#[test]
fn a_folder_that_is_unmounted_fails_by_itself_and_comes_back_whole() {
    let mut scene = Scene::new();
    let disk = scene.path("disk");
    fs::create_dir(&disk).unwrap();
    fs::rename(scene.path("east.tif"), disk.join("east.tif")).unwrap();
    let relink = Edit::SetPath {
        id: LayerId::from("east"),
        path: "disk/east.tif".to_owned(),
    };
    scene.engine.apply(relink).unwrap();
    scene.engine.wait_for_sources();
    let before = scene.picture();
    scene.log();
    fs::rename(&disk, scene.path("gone")).unwrap();
    scene.settle();
    let reason = scene.failed("east").unwrap();
    assert!(reason.contains("not even its folder"), "{reason}");
    fs::rename(scene.path("gone"), &disk).unwrap();
    scene.settle();
    assert_eq!(scene.failed("east"), None);
    assert_eq!(scene.log(), []);
    assert!(scene.picture() == before);
    assert!(
        scene.engine.undo().unwrap(),
        "relinking is an edit like any other"
    );
    scene.engine.wait_for_sources();
    assert!(scene.failed("east").is_some(), "its old place is empty");
}

#[test]
fn without_looks_a_file_cut_short_fails_its_tiles_with_one_line_until_it_is_tried_again() {
    let mut scene = Scene::watched(None, None);
    let whole = fs::read(scene.path("east.tif")).unwrap();
    scene.overwrite("east.tif", &whole[..whole.len() / 3]);
    scene.engine.set_view(view(5.0, 3.0e5));
    let frames = scene.converge();
    assert!(frames.iter().any(shows_stand_in));
    let texts: BTreeSet<_> = scene
        .engine
        .messages()
        .iter()
        .map(|m| m.text.clone())
        .collect();
    assert_eq!(texts.len(), scene.engine.messages().len(), "each line once");
    assert!(
        texts.iter().any(|t| t.contains("changed on disk")),
        "{texts:?}"
    );
    scene.engine.set_view(view(-15.0, 3.0e5));
    let frames = scene.converge();
    let mut uploads = frames.iter().flat_map(|f| &f.uploads);
    assert!(
        uploads.any(|u| u.clipmap == ClipKind::Colour && u.tile.bytes().is_some()),
        "the other file lives"
    );
    // Mended and tried again, the very same tiles are made.
    scene.overwrite("east.tif", &whole);
    scene.engine.set_view(view(5.0, 3.0e5));
    scene.converge();
    scene.look();
    scene.look();
    assert!(!scene.converge().iter().any(shows_stand_in));
    assert_eq!(scene.engine.messages(), []);
}

#[test]
fn the_looking_thread_notices_by_itself_and_ends_with_the_engine() {
    let (told, wakes) = std::sync::mpsc::sync_channel(1);
    // A wake that is not taken yet says all that another could.
    let wake = move || {
        let _told = told.try_send(());
    };
    let mut scene = Scene::watched(Some(Duration::from_millis(1)), Some(Arc::new(wake)));
    fs::remove_file(scene.path("west.tif")).unwrap();
    let gone = |scene: &mut Scene| scene.failed("west").is_some();
    while !gone(&mut scene) {
        wakes.recv_timeout(GUARD).unwrap();
    }
    scene.converge();
    assert_eq!(scene.engine.messages().len(), 1);
    let kept = scene.engine.stats().kept;
    assert_eq!(kept.files, 2);
}

/// Whether the colour of tiles that cannot be made is uploaded.
fn shows_stand_in(frame: &Frame) -> bool {
    use relievo_engine::raster::Sample;
    frame.uploads.iter().any(|u| {
        u.tile.bytes().is_none()
            && matches!(u.tile.sample(0, 0), Sample::Rgba8([206, 66, 125, 255]))
    })
}
