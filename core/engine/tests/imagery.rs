//! Imagery beyond its file: detail below its resolution, colours for its holes.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use relievo_engine::planet::{Camera, Grid, LevelKey, MapPoint, SampleRect};
use relievo_engine::project::{
    Adjust, ColourDetail, DetailBy, Edit, ImageryLayer, Layer, LayerId, LayerKind, Noise,
    NoiseLayer, Project, Source, VectorLayer,
};
use relievo_engine::raster::colour::linear_from_srgb;
use relievo_engine::raster::{Block, Cancel};
use relievo_engine::{Bake, Engine, EngineOptions, Output, Questions, Stage, View};

/// The sample's aerial of Provo, 539 × 232 pixels of 2 m, and a place in it.
const AERIAL: &str = "../../projects/data/provo-aerial.tif";
const EDGES: [f64; 4] = [444_848.0, 4_448_731.0, 445_926.0, 4_449_195.0];
const PLACE: (f64, f64) = (-111.6415, 40.1893);

/// Metres from sample to sample of the coarse picture.
const COARSE_M: f64 = 16.0;

fn layer(id: &str, path: &Path, change: impl FnOnce(&mut ImageryLayer)) -> Layer {
    let mut imagery = ImageryLayer::new(Source::new(path.to_str().unwrap()));
    change(&mut imagery);
    Layer::new(LayerId::from(id), id, LayerKind::Imagery(imagery))
}

fn engine(layers: Vec<Layer>) -> Engine {
    let project = Project {
        layers,
        ..Project::default()
    };
    let options = EngineOptions {
        threads: Some(2),
        log: true,
        cache_folder: None,
        ..EngineOptions::default()
    };
    let mut engine = Engine::new(project, Path::new("."), options).unwrap();
    engine.wait_for_sources();
    engine
}

/// Drains until the picture is whole and nothing is being made.
fn converge(engine: &mut Engine) {
    for _ in 0..4000 {
        let whole = engine.drain(f32::INFINITY).unwrap().is_converged();
        if engine.wait(Duration::from_millis(50)) && whole {
            return;
        }
    }
    panic!("does not converge: {:?}", engine.stats());
}

fn aerial() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(AERIAL)
}

/// The aerial with fewer samples, `grown` metres beyond its edges.
fn thinned(folder: &Path, resolution: f64, grown: f64) -> PathBuf {
    let to = folder.join(format!("thinned-{resolution}-{grown}.tif"));
    let [w, s, e, n] = EDGES;
    let bake = Bake {
        output: Output::Colour,
        bounds: [w - grown, s - grown, e + grown, n + grown],
        resolution,
        crs: "EPSG:26912".into(),
    };
    let questions = engine(vec![layer("aerial", &aerial(), |_| ())]).questions();
    let cancel = Cancel::default();
    questions.bake(&bake, &to, 1, &mut |_| {}, &cancel).unwrap();
    to
}

fn after_the_aerial() -> ColourDetail {
    ColourDetail::new(DetailBy::Examples {
        layers: vec![LayerId::from("fine")],
        tolerance: 0.5,
    })
}

/// A coarse picture that goes on after the aerial, which is hidden.
fn continued(coarse: &Path, detail: Vec<ColourDetail>) -> Vec<Layer> {
    let mut fine = layer("fine", &aerial(), |_| ());
    fine.visible = false;
    vec![layer("coarse", coarse, |i| i.detail = detail), fine]
}

/// Samples of a level with rows `spacing_m` apart or less about the place.
fn grid(halvings: u8, side: i64) -> Grid {
    // 19.1 m apart at 20 levels, at the place.
    let level = LevelKey::new(14 + halvings, 13 + halvings);
    let at = level.sample_from_map(MapPoint::from_degrees(PLACE.0, PLACE.1));
    let at = (at / side as f64).floor().as_i64vec2() * side;
    Grid::new(
        Arc::new(level.lattice()),
        SampleRect::at(at.x, at.y, side, side),
    )
}

fn shown(questions: &Questions, grid: &Grid) -> Block {
    let id = LayerId::from("coarse");
    let found = questions.layer_samples(&id, Stage::Over, grid, &Cancel::default());
    found.unwrap().expect("colours")
}

/// Mean square of steps from sample to sample of the green channel.
fn roughness(block: &Block) -> f64 {
    let (width, green) = (block.width(), block.plane(1));
    let rows = green.chunks(width);
    let steps = rows.flat_map(|row| row.windows(2).map(|w| f64::from(w[1] - w[0]).powi(2)));
    steps.sum::<f64>() / green.len() as f64
}

#[test]
fn imagery_that_goes_on_after_examples_is_the_imagery_when_it_is_reduced() {
    goes_on(after_the_aerial());
}

#[test]
fn imagery_that_goes_on_by_noise_is_the_imagery_when_it_is_reduced() {
    goes_on(ColourDetail::new(DetailBy::Noise));
}

fn goes_on(detail: ColourDetail) {
    let folder = tempfile::tempdir().unwrap();
    let coarse = thinned(folder.path(), COARSE_M, 0.0);
    let with = engine(continued(&coarse, vec![detail])).questions();
    let without = engine(continued(&coarse, vec![])).questions();
    // Rows of 9.5 m are the finest that keep all of the coarse picture.
    let (near, far) = (grid(3, 64), grid(0, 8));
    let (detailed, plain) = (shown(&with, &near), shown(&without, &near));
    assert!(
        roughness(&detailed) > 4.0 * roughness(&plain),
        "{} {}",
        roughness(&detailed),
        roughness(&plain)
    );
    assert_eq!(
        shown(&with, &far).samples(),
        shown(&without, &far).samples()
    );
    let means = shown(&without, &far);
    for y in 0..8 {
        for x in 0..8 {
            let quad = (0..64).map(|i| (8 * y + i / 8) * 64 + 8 * x + i % 8);
            let light = quad.map(|at| linear_from_srgb(detailed.plane(1)[at]));
            let (mean, whole) = (
                light.sum::<f32>() / 64.0,
                linear_from_srgb(means.plane(1)[8 * y + x]),
            );
            assert!((mean - whole).abs() < 0.006, "{mean} {whole}");
        }
    }
}

#[test]
fn a_place_says_that_its_colour_is_made_up_and_measures_see_the_file_alone() {
    let folder = tempfile::tempdir().unwrap();
    let coarse = thinned(folder.path(), COARSE_M, 0.0);
    let with = engine(continued(&coarse, vec![after_the_aerial()])).questions();
    let place = MapPoint::from_degrees(PLACE.0, PLACE.1);
    let answer = with.place(place, &Cancel::default()).unwrap();
    let below_m = answer.colour_synthesised_below_m.unwrap();
    assert!((10.0..40.0).contains(&below_m), "{below_m}");
    assert_ne!(answer.data_colour, answer.colour);
    let makes = answer
        .colour_made_by
        .iter()
        .any(|m| m.node == "colour detail");
    assert!(makes, "{:?}", answer.colour_made_by);
    let bare = with.without_detail().place(place, &Cancel::default());
    let bare = bare.unwrap();
    assert_eq!(bare.colour, answer.data_colour);
    assert_eq!(bare.colour_synthesised_below_m, None);
    assert!(with.left_out_of_measures().is_some());
}

#[test]
fn detail_is_in_the_areas_of_a_vector_layer_alone() {
    let folder = tempfile::tempdir().unwrap();
    let coarse = thinned(folder.path(), COARSE_M, 0.0);
    let (w, s) = (PLACE.0 - 0.1, PLACE.1 - 0.1);
    let (e, n) = (PLACE.0, PLACE.1 + 0.1);
    let areas = format!(
        r#"{{"type":"Feature","properties":{{}},"geometry":{{"type":"Polygon",
        "coordinates":[[[{w},{s}],[{e},{s}],[{e},{n}],[{w},{n}],[{w},{s}]]]}}}}"#
    );
    let file = folder.path().join("west.geojson");
    std::fs::write(&file, areas).unwrap();
    let vector = VectorLayer::new(file.to_str().unwrap());
    let mut west = Layer::new(
        LayerId::from("west"),
        "west",
        LayerKind::Vector(Box::new(vector)),
    );
    west.visible = false;
    let mut detail = after_the_aerial();
    detail.areas = Some(LayerId::from("west"));
    let mut layers = continued(&coarse, vec![detail]);
    layers.push(west);
    let with = engine(layers).questions();
    let without = engine(continued(&coarse, vec![])).questions();
    let grid = {
        let mut grid = grid(3, 64);
        let level = LevelKey::new(17, 16);
        let at = level.sample_from_map(MapPoint::from_degrees(PLACE.0, PLACE.1));
        let at = at.floor().as_i64vec2();
        grid.rect = SampleRect::at(at.x - 32, at.y - 32, 64, 64);
        grid
    };
    let (detailed, plain) = (shown(&with, &grid), shown(&without, &grid));
    let differs = |x: usize, y: usize| detailed.plane(1)[64 * y + x] != plain.plane(1)[64 * y + x];
    let (mut west, mut east) = (0, 0);
    for y in 0..64 {
        west += (0..30).filter(|x| differs(*x, y)).count();
        east += (34..64).filter(|x| differs(*x, y)).count();
    }
    assert!(west > 1000 && east == 0, "{west} {east}");
}

#[test]
fn what_is_no_example_is_named_and_the_picture_is_the_files() {
    let folder = tempfile::tempdir().unwrap();
    let coarse = thinned(folder.path(), COARSE_M, 0.0);
    let detail = ColourDetail::new(DetailBy::Examples {
        layers: ["coarse", "gone", "fine"].map(LayerId::from).to_vec(),
        tolerance: 0.5,
    });
    let mut studio = engine(continued(&coarse, vec![detail]));
    let said: Vec<String> = studio.messages().iter().map(|m| m.text.clone()).collect();
    let expected = [
        "expected an imagery layer \"coarse\" as an example, found the layer itself",
        "expected an imagery layer \"gone\" as an example, found none",
    ];
    assert_eq!(said, expected);
    // The third is one.
    let fine = grid(3, 64);
    let with = shown(&studio.questions(), &fine);
    let id = LayerId::from("coarse");
    let detail = vec![];
    studio.apply(Edit::SetColourDetail { id, detail }).unwrap();
    let without = shown(&studio.questions(), &fine);
    assert_ne!(with.samples(), without.samples());
    studio.undo().unwrap();
    assert_eq!(shown(&studio.questions(), &fine).samples(), with.samples());
}

#[test]
fn a_slider_makes_no_detail_again() {
    let folder = tempfile::tempdir().unwrap();
    let coarse = thinned(folder.path(), COARSE_M, 0.0);
    let mut engine = engine(continued(&coarse, vec![after_the_aerial()]));
    engine.set_view(View {
        camera: Camera::from_degrees(PLACE.0, PLACE.1, 300.0, 0.0, -90.0, 60.0).unwrap(),
        viewport_px: [320, 240],
        layout: relievo_engine::Layout::STANDARD,
        colour_window: 256,
        colour_texel_px: 1.0,
        height_texel_px: 2.0,
        max_taps: 4,
    });
    let gamma = |gamma: f64| Edit::SetAdjust {
        id: LayerId::from("coarse"),
        adjust: Adjust {
            gamma,
            ..Adjust::default()
        },
    };
    engine.apply(gamma(1.2)).unwrap();
    converge(&mut engine);
    let kinds =
        |engine: &Engine| -> Vec<&str> { engine.take_log().iter().map(|e| e.kind).collect() };
    let first = kinds(&engine);
    assert!(first.contains(&"colour detail"), "{first:?}");
    engine.apply(gamma(1.5)).unwrap();
    converge(&mut engine);
    let again = kinds(&engine);
    assert!(
        !again.is_empty() && !again.contains(&"colour detail"),
        "{again:?}"
    );
}

#[test]
fn holes_take_the_colour_they_are_given_and_what_is_outside_does_not() {
    let folder = tempfile::tempdir().unwrap();
    let holed = thinned(folder.path(), 4.0, 400.0);
    let red = Some([255, 0, 0]);
    for edge_fade_m in [0.0, 20.0] {
        let filled = layer("coarse", &holed, |i| {
            i.missing = red;
            i.source.edge_fade_m = edge_fade_m;
        });
        hole_is_red(&engine(vec![filled]).questions());
    }
}

fn hole_is_red(questions: &Questions) {
    let at = |lon: f64, lat: f64| {
        let place = MapPoint::from_degrees(lon, lat);
        let answer = questions.place(place, &Cancel::default()).unwrap();
        answer.colour.unwrap()
    };
    let [r, g, b, a] = at(PLACE.0, PLACE.1);
    assert!(a == 255 && [r, g, b] != [255, 0, 0]);
    // 200 m north of the aerial, within the frame; 800 m, outside.
    assert_eq!(at(PLACE.0, 40.1932), [255, 0, 0, 255]);
    assert_eq!(at(PLACE.0, 40.1990)[3], 0);
}

#[test]
fn along_the_edge_of_its_data_a_picture_bends_to_what_lies_below_and_nowhere_else() {
    let folder = tempfile::tempdir().unwrap();
    let below = thinned(folder.path(), COARSE_M, 0.0);
    let small = {
        let to = folder.path().join("small.tif");
        let [w, s, e, n] = EDGES;
        let bake = Bake {
            output: Output::Colour,
            bounds: [w + 200.0, s + 100.0, e - 200.0, n - 100.0],
            resolution: 2.0,
            crs: "EPSG:26912".into(),
        };
        let brighter = layer("aerial", &aerial(), |i| i.adjust.brightness = 0.2);
        let questions = engine(vec![brighter]).questions();
        let cancel = Cancel::default();
        questions.bake(&bake, &to, 1, &mut |_| {}, &cancel).unwrap();
        to
    };
    let layers = |seam_blend_m: f64| {
        vec![
            layer("below", &below, |_| ()),
            layer("coarse", &small, |i| i.seam_blend_m = seam_blend_m),
        ]
    };
    let bent_by = engine(layers(100.0)).questions();
    let plain = engine(layers(0.0)).questions();
    // 340 m around the middle, which has both long sides in it.
    let level = LevelKey::new(17, 16);
    let at = level.sample_from_map(MapPoint::from_degrees(PLACE.0, PLACE.1));
    let at = at.floor().as_i64vec2();
    let rect = SampleRect::at(at.x - 8, at.y - 144, 16, 288);
    let grid = Grid::new(Arc::new(level.lattice()), rect);
    let ground = bent_by
        .layer_samples(
            &LayerId::from("coarse"),
            Stage::Below,
            &grid,
            &Cancel::default(),
        )
        .unwrap()
        .unwrap();
    let (bent, plain) = (shown(&bent_by, &grid), shown(&plain, &grid));
    assert_eq!(bent.plane(3), plain.plane(3), "as opaque as before");
    let inside: Vec<usize> = (0..288)
        .filter(|y| plain.plane(3)[16 * y + 8] > 0.99)
        .collect();
    assert!((180..250).contains(&inside.len()), "{}", inside.len());
    let step = |block: &Block, rows: &[usize]| {
        let at = rows.iter().flat_map(|y| (0..16).map(move |x| 16 * y + x));
        let off = at.map(|i| f64::from(block.plane(1)[i] - ground.plane(1)[i]));
        (off.sum::<f64>() / (16 * rows.len()) as f64).abs()
    };
    for edge in [&inside[..5], &inside[inside.len() - 5..]] {
        let (before, after) = (step(&plain, edge), step(&bent, edge));
        assert!(before > 0.1 && after < 0.35 * before, "{before} {after}");
    }
    // What is matched and compared is the picture's own colours.
    let id = LayerId::from("coarse");
    let own = bent_by.layer_samples(&id, Stage::Adjusted, &grid, &Cancel::default());
    assert_eq!(own.unwrap().unwrap().plane(1), plain.plane(1));
    // Over nothing there is no seam to blend.
    let alone = engine(vec![layer("coarse", &small, |i| i.seam_blend_m = 100.0)]).questions();
    let place = alone.place(MapPoint::from_degrees(PLACE.0, PLACE.1), &Cancel::default());
    let makers = place.unwrap().colour_made_by;
    assert!(makers.iter().all(|m| m.node != "seam blend"), "{makers:?}");
    // 100 m are 84 rows.
    let middle = &inside[inside.len() / 2 - 10..inside.len() / 2 + 10];
    for y in middle {
        let row = 16 * y..16 * y + 16;
        assert_eq!(bent.plane(1)[row.clone()], plain.plane(1)[row]);
    }
}

#[test]
fn made_up_colours_make_no_place_finer_and_change_no_height() {
    let folder = tempfile::tempdir().unwrap();
    let coarse = thinned(folder.path(), COARSE_M, 0.0);
    let noise = vec![ColourDetail::new(DetailBy::Noise)];
    let place = MapPoint::from_degrees(PLACE.0, PLACE.1);
    let ask = |detail| {
        let mut layers = continued(&coarse, detail);
        let heights = LayerKind::Noise(NoiseLayer {
            noise: Noise {
                wavelength_m: 4000.0,
                octaves: 3,
                ..Noise::default()
            },
        });
        layers.insert(0, Layer::new(LayerId::from("hills"), "hills", heights));
        let questions = engine(layers).questions();
        questions.place(place, &Cancel::default()).unwrap()
    };
    let (plain, detailed) = (ask(vec![]), ask(noise));
    assert_ne!(plain.colour, detailed.colour);
    assert_eq!(plain.spacing_m, detailed.spacing_m);
    assert_eq!(
        (plain.height_m, plain.slope_deg),
        (detailed.height_m, detailed.slope_deg)
    );
}
