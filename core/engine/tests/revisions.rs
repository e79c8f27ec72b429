//! Revisions on the engine's log: what an edit makes again, and what is never made twice.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use relievo_engine::planet::clipmap::LevelPlan;
use relievo_engine::planet::{Camera, Planet};
use relievo_engine::project::{
    Adjust, Blend, Body, Edit, Layer, LayerId, LayerKind, Noise, NoiseLayer, NoiseMode, Project,
    Tint, TintInterpolation, TintLayer, TintStop,
};
use relievo_engine::tiles::LogEntry;
use relievo_engine::{Engine, EngineOptions, Frame, View};

fn layer(id: &str, kind: LayerKind) -> Layer {
    Layer::new(LayerId::from(id), id, kind)
}

fn tint(id: &str, low: [u8; 3], high: [u8; 3]) -> Layer {
    let stops = vec![TintStop::new(-2000.0, low), TintStop::new(2000.0, high)];
    let tint = Tint {
        stops,
        interpolation: TintInterpolation::Smooth,
    };
    layer(
        id,
        LayerKind::Tint(TintLayer {
            tint,
            blend: Blend::Normal,
            adjust: Adjust::default(),
        }),
    )
}

fn project() -> Project {
    let noise = Noise {
        mode: NoiseMode::Replace,
        octaves: 6,
        ..Noise::default()
    };
    Project {
        layers: vec![
            layer("hills", LayerKind::Noise(NoiseLayer { noise })),
            tint("below", [20, 60, 20], [200, 200, 180]),
            tint("above", [90, 20, 20], [250, 220, 180]),
        ],
        ..Project::default()
    }
}

fn engine(threads: usize) -> Engine {
    let options = EngineOptions {
        threads: Some(threads),
        log: true,
        cache_folder: None,
        ..EngineOptions::default()
    };
    let mut engine = Engine::new(project(), std::path::Path::new("."), options).unwrap();
    set_opacity(&mut engine, "above", 0.5);
    engine.set_view(view(10.0));
    engine
}

fn view(lon_deg: f64) -> View {
    let mut camera = Camera::from_degrees(lon_deg, 45.0, 2.0e5, 0.0, -60.0, 60.0).unwrap();
    camera.fov_y_rad = 1.0;
    View {
        camera,
        viewport_px: [320, 240],
        layout: relievo_engine::Layout::STANDARD,
        colour_window: 256,
        colour_texel_px: 1.0,
        height_texel_px: 2.0,
        max_taps: 4,
    }
}

fn set_opacity(engine: &mut Engine, id: &str, opacity: f64) {
    engine
        .apply(Edit::SetOpacity {
            id: LayerId::from(id),
            opacity,
        })
        .unwrap();
}

fn adjust(engine: &mut Engine, id: &str, contrast: f64) {
    let adjust = Adjust {
        contrast,
        ..Adjust::default()
    };
    engine
        .apply(Edit::SetAdjust {
            id: LayerId::from(id),
            adjust,
        })
        .unwrap();
}

/// Drains until the picture is done; gives every frame.
fn converge(engine: &mut Engine) -> Vec<Frame> {
    let mut frames = Vec::new();
    for _ in 0..2000 {
        let frame = engine.drain(f32::INFINITY).unwrap();
        let done = frame.is_converged();
        frames.push(frame);
        if done {
            return frames;
        }
        engine.wait(Duration::from_millis(50));
    }
    panic!("does not converge: {:?}", engine.stats());
}

/// Waits for prefetched tiles, too, so that the log holds all that was started.
fn log(engine: &mut Engine) -> Vec<LogEntry> {
    let mut quiet = 0;
    while quiet < 3 {
        let idle = engine.wait(Duration::from_millis(50));
        let uploads = engine.drain(f32::INFINITY).map_or(0, |f| f.uploads.len());
        quiet = if idle && uploads == 0 { quiet + 1 } else { 0 };
    }
    engine.take_log()
}

#[test]
fn a_slider_makes_again_only_what_depends_on_its_layer() {
    let mut engine = engine(2);
    converge(&mut engine);
    log(&mut engine);
    adjust(&mut engine, "above", 1.3);
    converge(&mut engine);
    let made = log(&mut engine);
    assert!(!made.is_empty());
    let kinds: BTreeSet<_> = made.iter().map(|e| e.kind).collect();
    assert_eq!(
        kinds.into_iter().collect::<Vec<_>>(),
        ["overlay"],
        "no height, no normal, no noise"
    );
}

#[test]
fn a_revision_waits_for_the_tiles_that_the_picture_reads_and_for_no_others() {
    let mut engine = engine(1);
    // A look aslant over the grid of tiles.
    let wide = View {
        camera: Camera::from_degrees(10.65, 45.6, 1.0e6, 325.6, -60.0, 60.0).unwrap(),
        colour_window: 1024,
        viewport_px: [1280, 960],
        ..view(10.0)
    };
    engine.set_view(wide);
    let frames = converge(&mut engine);
    let before = frames.last().unwrap().revision;
    let plan = Arc::clone(&frames.last().unwrap().plan);
    log(&mut engine);
    let selected: BTreeSet<_> = plan
        .colours
        .iter()
        .flat_map(LevelPlan::selected_tiles)
        .collect();
    let wanted: usize = plan.colours.iter().map(|l| l.wanted_tiles().len()).sum();
    assert!(selected.len() < wanted, "the box holds more than the wedge");
    adjust(&mut engine, "above", 1.3);
    let mut made: Vec<_> = Vec::new();
    loop {
        made.extend(engine.take_log().into_iter().map(|e| e.key));
        let ready = selected.iter().all(|key| made.contains(key));
        let published = engine.drain(f32::INFINITY).unwrap().revision != before;
        assert!(published || !ready, "a revision that waits for nothing");
        if published {
            break;
        }
        engine.wait(Duration::from_millis(1));
    }
    made.extend(engine.take_log().into_iter().map(|e| e.key));
    // One worker makes tiles one by one: none comes before those that the picture reads but the
    // one that it may have begun when they were asked for.
    let last = made.iter().rposition(|key| selected.contains(key)).unwrap();
    let others = made[..last]
        .iter()
        .filter(|k| !selected.contains(k))
        .count();
    assert!(others <= 1, "{others} tiles that nothing waits for");
    assert!(selected.iter().all(|key| made.contains(key)));
    converge(&mut engine);
    let all = log(&mut engine).len() + made.len();
    assert!(all >= wanted, "the others follow");
}

#[test]
fn undo_makes_nothing_and_restores_the_same_tiles() {
    let mut engine = engine(2);
    converge(&mut engine);
    log(&mut engine);
    adjust(&mut engine, "above", 1.3);
    converge(&mut engine);
    log(&mut engine);
    assert!(engine.undo().unwrap());
    let frames = converge(&mut engine);
    assert!(
        frames.iter().any(|f| !f.uploads.is_empty()),
        "the old colours come back"
    );
    assert_eq!(log(&mut engine), []);
}

#[test]
fn a_camera_that_comes_back_makes_nothing() {
    let mut engine = engine(2);
    converge(&mut engine);
    log(&mut engine);
    engine.set_view(view(50.0));
    converge(&mut engine);
    let moved = log(&mut engine);
    assert!(!moved.is_empty());
    let ids: std::collections::HashSet<_> = moved.iter().map(|e| e.id).collect();
    assert_eq!(ids.len(), moved.len(), "nothing twice");
    engine.set_view(view(10.0));
    converge(&mut engine);
    assert_eq!(log(&mut engine), []);
}

#[test]
fn layers_without_effect_change_the_name_of_no_tile() {
    let mut engine = engine(2);
    converge(&mut engine);
    log(&mut engine);
    for n in 0..10 {
        let mut inert = tint(&format!("inert-{n}"), [0; 3], [255; 3]);
        inert.visible = n % 2 == 0;
        inert.opacity = if inert.visible { 0.0 } else { 1.0 };
        engine
            .apply(Edit::AddLayer {
                index: Some(n % 3),
                layer: Box::new(inert),
            })
            .unwrap();
    }
    let uploads: usize = converge(&mut engine).iter().map(|f| f.uploads.len()).sum();
    let made: Vec<_> = log(&mut engine)
        .iter()
        .map(|e| format!("{} {}", e.kind, e.key))
        .collect();
    assert_eq!((made, uploads), (vec![], 0));
    assert_eq!(engine.left_out().len(), 10);
}

#[test]
fn the_same_uploads_whatever_the_number_of_threads() {
    let bytes = |threads| {
        let mut engine = engine(threads);
        let mut all: Vec<_> = converge(&mut engine)
            .into_iter()
            .flat_map(|f| f.uploads)
            .map(|u| {
                (
                    u.clipmap,
                    u.layer,
                    u.storage,
                    u.source,
                    u.size,
                    u.tile.bytes().map(<[u8]>::to_vec),
                )
            })
            .collect();
        all.sort();
        all.dedup();
        all
    };
    let one = bytes(1);
    let three = bytes(3);
    // Prefetched tiles may or may not have come in time; what both have must agree.
    let places: std::collections::BTreeMap<_, _> = one
        .iter()
        .map(|u| ((u.0, u.1, u.2, u.3, u.4), &u.5))
        .collect();
    let mut both = 0;
    for u in &three {
        if let Some(same) = places.get(&(u.0, u.1, u.2, u.3, u.4)) {
            assert_eq!(*same, &u.5);
            both += 1;
        }
    }
    assert!(both > 10);
}

#[test]
fn a_drag_finishes_the_revision_in_the_making_and_then_shows_the_latest() {
    let mut engine = engine(2);
    let before = converge(&mut engine).pop().unwrap().revision;
    engine.begin_drag();
    adjust(&mut engine, "above", 1.1);
    assert_eq!(
        engine.drain(0.016).unwrap().revision,
        before,
        "nothing is shown before it is whole"
    );
    adjust(&mut engine, "above", 1.2);
    adjust(&mut engine, "above", 1.3);
    engine.end_drag();
    let mut shown: Vec<u64> = converge(&mut engine)
        .into_iter()
        .map(|f| f.revision)
        .collect();
    shown.dedup();
    shown.retain(|r| *r != before);
    assert_eq!(
        shown,
        [before + 1, before + 2],
        "the first edit is not starved, the second is skipped"
    );
    assert!(engine.undo().unwrap());
    let contrast = |e: &Engine| {
        let LayerKind::Tint(tint) = &e.project().layers[2].kind else {
            return 0.0;
        };
        tint.adjust.contrast
    };
    assert_eq!(contrast(&engine), 1.0, "the whole drag is one step");
}

#[test]
fn an_exaggeration_that_the_planet_cannot_bear_is_refused_or_drawn_with_its_limit() {
    let on_a_small_planet = |vertical_exaggeration| {
        let mut project = project();
        project.planet.body = Body::Custom(Planet::sphere(20_000.0));
        project.planet.vertical_exaggeration = vertical_exaggeration;
        if let LayerKind::Noise(hills) = &mut project.layers[0].kind {
            hills.noise.offset_m = -2000.0;
        }
        let options = EngineOptions {
            threads: Some(2),
            cache_folder: None,
            ..EngineOptions::default()
        };
        let mut engine = Engine::new(project, std::path::Path::new("."), options).unwrap();
        engine.set_view(view(10.0));
        converge(&mut engine);
        engine
    };
    let says_so = |engine: &Engine| {
        let mut texts = engine.messages().iter().map(|m| m.text.as_str());
        texts.any(|t| t.contains("a tenth of the radius"))
    };
    let mut engine = on_a_small_planet(1.0);
    assert_eq!(engine.exaggeration(), 1.0);
    assert!(!says_so(&engine));
    let of = |vertical_exaggeration| Edit::SetExaggeration {
        vertical_exaggeration,
    };
    let refused = engine.apply(of(100.0)).unwrap_err().to_string();
    assert!(
        refused.contains("at most") && refused.contains("found 100"),
        "{refused}"
    );
    assert_eq!(engine.project().planet.vertical_exaggeration, 1.0);
    engine.apply(of(0.0)).unwrap();
    assert_eq!(engine.exaggeration(), 0.0);

    let mut opened = on_a_small_planet(100.0);
    let drawn = opened.exaggeration();
    assert!(drawn > 1.0 && drawn < 100.0 && says_so(&opened), "{drawn}");
    assert_eq!(converge(&mut opened).pop().unwrap().exaggeration, drawn);
    opened.apply(of(0.9 * drawn)).unwrap();
    converge(&mut opened);
    assert!(!says_so(&opened));
}
