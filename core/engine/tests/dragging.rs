//! A layer that is dragged under others: what is made again from moment to moment, and what is seen.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "common/screen.rs"]
mod screen;

use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use relievo_engine::planet::Camera;
use relievo_engine::project::{
    Adjust, Blend, Detail, DetailLayer, Edit, Element, ElementId, ElementKind, Extra, Layer,
    LayerId, LayerKind, Mask, MaskRange, Noise, NoiseLayer, NoiseMode, Polygon, Project,
    SurfaceKind, Tint, TintInterpolation, TintLayer, TintStop, Vertex,
};
use relievo_engine::{ClipKind, Engine, EngineOptions, View};
use screen::{Part, picture};

/// Height colours, adjusted, seen through.
fn tint(id: &str, blend: Blend, low: [u8; 3], high: [u8; 3]) -> Layer {
    let stops = vec![TintStop::new(-2000.0, low), TintStop::new(2000.0, high)];
    let tint = TintLayer {
        tint: Tint {
            stops,
            interpolation: TintInterpolation::Smooth,
        },
        blend,
        adjust: Adjust {
            contrast: 1.2,
            saturation: 0.7,
            gamma: 1.3,
            ..Adjust::default()
        },
    };
    let mut layer = Layer::new(LayerId::from(id), id, LayerKind::Tint(tint));
    layer.opacity = 0.6;
    layer
}

/// Colours under four others, one of which shows only on hills.
fn project(blends: [Blend; 4]) -> Project {
    let noise = Noise {
        mode: NoiseMode::Replace,
        octaves: 8,
        ..Noise::default()
    };
    let hills = LayerKind::Noise(NoiseLayer { noise });
    let mut layers = vec![
        Layer::new(LayerId::from("hills"), "hills", hills),
        tint("lowest", Blend::Normal, [20, 60, 20], [240, 220, 180]),
        tint("dragged", Blend::Normal, [70, 90, 160], [255, 250, 240]),
    ];
    for (k, blend) in blends.into_iter().enumerate() {
        let k = k as u8;
        let low = [40 * k, 20, 255 - 60 * k];
        layers.push(tint(&format!("above-{k}"), blend, low, [250, 60 * k, 90]));
    }
    layers[4].mask = Some(Mask {
        heights: Some(MaskRange {
            from: 0.0,
            to: 10_000.0,
            fade: 300.0,
            extra: Extra::new(),
        }),
        ..Mask::default()
    });
    Project {
        layers,
        ..Project::default()
    }
}

fn engine(blends: [Blend; 4]) -> Engine {
    let options = EngineOptions {
        threads: Some(2),
        log: true,
        cache_folder: None,
        ..EngineOptions::default()
    };
    let mut engine = Engine::new(project(blends), Path::new("."), options).unwrap();
    engine.set_view(View {
        camera: Camera::from_degrees(10.0, 45.0, 2.0e5, 0.0, -60.0, 60.0).unwrap(),
        viewport_px: [320, 240],
        layout: relievo_engine::Layout::STANDARD,
        colour_window: 256,
        colour_texel_px: 1.0,
        height_texel_px: 2.0,
        max_taps: 4,
    });
    engine
}

fn set_gamma(engine: &mut Engine, gamma: f64) {
    let adjust = Adjust {
        gamma,
        ..Adjust::default()
    };
    let id = LayerId::from("dragged");
    engine.apply(Edit::SetAdjust { id, adjust }).unwrap();
}

/// Drains until the picture is whole and nothing is made: how many tiles of colours went into windows since,
/// and how many were made.
fn settle(engine: &mut Engine) -> (usize, usize) {
    let mut tiles = HashSet::new();
    for _ in 0..4000 {
        let frame = engine.drain(f32::INFINITY).unwrap();
        let colours = frame.uploads.iter();
        let colours = colours.filter(|upload| upload.clipmap == ClipKind::Colour);
        tiles.extend(colours.map(|upload| Arc::as_ptr(&upload.tile)));
        let idle = engine.wait(Duration::from_millis(50));
        if idle && frame.is_converged() && frame.uploads.is_empty() {
            return (tiles.len(), engine.take_log().len());
        }
    }
    panic!("does not converge: {:?}", engine.stats());
}

/// The colours of all tiles of the picture.
fn colours(engine: &mut Engine) -> Vec<Part> {
    let tiles = picture(engine).into_iter();
    let colours = tiles.filter(|((kind, _), _)| *kind == ClipKind::Colour);
    colours.map(|(_, part)| part).collect()
}

/// Bytes in the cache after some steps of a drag.
fn bytes_after(engine: &mut Engine, steps: core::ops::Range<u32>) -> usize {
    for k in steps {
        set_gamma(engine, 1.1 + 0.01 * f64::from(k));
        settle(engine);
    }
    engine.stats().tiles.cache_bytes
}

const MIXED: [Blend; 4] = [Blend::Normal; 4];
const LOOKING_DOWN: [Blend; 4] = [Blend::Normal, Blend::Multiply, Blend::Normal, Blend::Normal];

#[test]
fn what_lies_around_a_dragged_layer_is_made_for_the_first_change_and_not_again() {
    for blends in [MIXED, LOOKING_DOWN] {
        let mut engine = engine(blends);
        settle(&mut engine);
        engine.begin_drag();
        set_gamma(&mut engine, 1.1);
        let (shown, made) = settle(&mut engine);
        assert!(made > shown, "what is kept, too: {made} for {shown}");
        set_gamma(&mut engine, 1.2);
        let (shown, made) = settle(&mut engine);
        assert!(shown > 0);
        assert_eq!(made, shown, "one tile where one is shown");
    }
}

#[test]
fn a_drag_shows_what_is_right_to_a_255th_and_let_go_to_the_bit() {
    for blends in [MIXED, LOOKING_DOWN] {
        let mut typed = engine(blends);
        set_gamma(&mut typed, 1.4);
        let exact = colours(&mut typed);
        let mut engine = engine(blends);
        settle(&mut engine);
        engine.begin_drag();
        for gamma in [1.2, 1.4] {
            set_gamma(&mut engine, gamma);
            settle(&mut engine);
        }
        let dragged = colours(&mut engine);
        assert_eq!(dragged.len(), exact.len());
        let (mut off, mut values) = (0, 0);
        for (exact, dragged) in exact.iter().zip(&dragged) {
            assert_eq!(exact.rect, dragged.rect);
            let both = exact
                .texels
                .as_flattened()
                .iter()
                .zip(dragged.texels.as_flattened());
            for (a, b) in both {
                assert!(a.abs_diff(*b) <= 1, "{a} {b}");
                off += usize::from(a != b);
                values += 1;
            }
        }
        assert!(off > 0, "another graph");
        assert!(off * 1000 < values, "{off} of {values} values differ");
        engine.end_drag();
        assert!(colours(&mut engine) == exact, "to the bit");
    }
}

#[test]
fn a_drag_with_nothing_above_ends_without_another_revision() {
    let mut engine = engine(MIXED);
    for k in 0..4 {
        let id = LayerId(format!("above-{k}"));
        let visible = false;
        engine.apply(Edit::SetVisible { id, visible }).unwrap();
    }
    settle(&mut engine);
    engine.begin_drag();
    set_gamma(&mut engine, 1.2);
    settle(&mut engine);
    let before = engine.drain(f32::INFINITY).unwrap().revision;
    engine.end_drag();
    let (shown, made) = settle(&mut engine);
    assert_eq!((shown, made), (0, 0));
    assert_eq!(engine.drain(f32::INFINITY).unwrap().revision, before);
}

#[test]
fn moments_of_a_drag_leave_nothing_behind_and_what_was_before_it_stays() {
    let mut engine = engine(MIXED);
    settle(&mut engine);
    engine.begin_drag();
    let few = bytes_after(&mut engine, 0..3);
    let many = bytes_after(&mut engine, 3..20);
    assert_eq!(many, few);
    engine.end_drag();
    settle(&mut engine);
    for back in [Engine::undo, Engine::redo] {
        assert!(back(&mut engine).unwrap());
        let (shown, made) = settle(&mut engine);
        assert!(shown > 0);
        assert_eq!(made, 0, "what was before the drag, and where it ended");
    }
}

#[test]
fn what_only_a_moment_reads_is_forgotten_with_it() {
    // What an overlay of synthesised ground lies on is stored for itself, and changes with every moment.
    let mut engine = engine(MIXED);
    let detail = LayerKind::Detail(DetailLayer {
        detail: Detail::default(),
    });
    let layer = Box::new(Layer::new(LayerId::from("detail"), "detail", detail));
    let index = Some(1);
    engine.apply(Edit::AddLayer { index, layer }).unwrap();
    engine.show_synthesised(true);
    settle(&mut engine);
    engine.begin_drag();
    let few = bytes_after(&mut engine, 0..3);
    let many = bytes_after(&mut engine, 3..12);
    assert_eq!(many, few);
}

#[test]
fn a_drag_of_a_planning_element_after_a_slider_makes_no_colours_again_elsewhere() {
    let mut engine = engine(MIXED);
    settle(&mut engine);
    set_gamma(&mut engine, 1.2);
    settle(&mut engine);
    engine.begin_drag();
    // A place that is not in view.
    for k in 0..3 {
        let west = -80.0 + 0.001 * f64::from(k);
        let corners = [(west, 10.0), (west + 0.01, 10.0), (west, 10.01)];
        let corners = corners.map(|(lon, lat)| Vertex::new(lon, lat)).to_vec();
        let platform = SurfaceKind::Platform { height_m: 40.0 };
        let kind = ElementKind::Polygon(Polygon::new(corners, platform));
        let element = Arc::new(Element::new(ElementId::from("pad"), "pad", kind));
        let edit = if k == 0 {
            Edit::AddElement {
                scenario: None,
                index: None,
                element,
            }
        } else {
            Edit::ReplaceElement {
                scenario: None,
                element,
            }
        };
        engine.apply(edit).unwrap();
        assert_eq!(settle(&mut engine), (0, 0), "step {k}");
    }
    engine.end_drag();
    assert_eq!(settle(&mut engine), (0, 0));
}

#[test]
fn two_layers_that_are_dragged_together_are_pinned_around_both() {
    let both = |engine: &mut Engine, opacity: f64| {
        let set = |id: &str| Edit::SetOpacity {
            id: LayerId::from(id),
            opacity,
        };
        let edits = vec![set("dragged"), set("above-1")];
        let label = "Both".to_owned();
        engine.apply(Edit::Batch { label, edits }).unwrap();
    };
    let mut engine = engine(MIXED);
    settle(&mut engine);
    engine.begin_drag();
    both(&mut engine, 0.5);
    settle(&mut engine);
    both(&mut engine, 0.55);
    let (shown, made) = settle(&mut engine);
    assert!(shown > 0);
    assert_eq!(made, shown, "nothing around them is made again");
}
