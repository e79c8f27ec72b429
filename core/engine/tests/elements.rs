//! Planning elements in a project: their heights, what an edit makes again, what is odd.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use relievo_engine::earthwork::Ending;
use relievo_engine::planet::{Camera, MapPoint};
use relievo_engine::project::{
    Change, ChangeKind, Corridor, Edit, Element, ElementId, ElementKind, Layer, LayerId, LayerKind,
    Noise, NoiseLayer, NoiseMode, Polygon, ProfileKind, Project, Scenario, ScenarioId, SectionKind,
    SurfaceKind, Vertex,
};
use relievo_engine::raster::Cancel;
use relievo_engine::{ClipKind, Engine, EngineOptions, HeightDifference, Upload, View};

const LON: f64 = 10.0;
const LAT: f64 = 45.0;

fn project() -> Project {
    let noise = Noise {
        mode: NoiseMode::Replace,
        amplitude_m: 20.0,
        wavelength_m: 3000.0,
        octaves: 3,
        ..Noise::default()
    };
    let layer = Layer::new(
        LayerId::from("hills"),
        "hills",
        LayerKind::Noise(NoiseLayer { noise }),
    );
    Project {
        layers: vec![layer],
        ..Project::default()
    }
}

/// A square about `2 · half_m` metres wide.
fn pad(id: &str, lon_deg: f64, lat_deg: f64, half_m: f64, surface: SurfaceKind) -> Arc<Element> {
    let (dx, dy) = (half_m / 78_850.0, half_m / 111_130.0);
    let corners = [(-dx, -dy), (dx, -dy), (dx, dy), (-dx, dy)]
        .map(|(x, y)| Vertex::new(lon_deg + x, lat_deg + y));
    let polygon = Polygon::new(corners.to_vec(), surface);
    Arc::new(Element::new(
        ElementId::from(id),
        id,
        ElementKind::Polygon(polygon),
    ))
}

fn platform(id: &str, height_m: f64) -> Arc<Element> {
    pad(id, LON, LAT, 50.0, SurfaceKind::Platform { height_m })
}

fn engine() -> Engine {
    let options = EngineOptions {
        threads: Some(2),
        log: true,
        cache_folder: None,
        ..EngineOptions::default()
    };
    Engine::new(project(), Path::new("."), options).unwrap()
}

fn add(engine: &mut Engine, element: Arc<Element>) {
    engine
        .apply(Edit::AddElement {
            scenario: None,
            index: None,
            element,
        })
        .unwrap();
}

fn height_m(engine: &Engine, lon_deg: f64, lat_deg: f64) -> f64 {
    let place = MapPoint::from_degrees(lon_deg, lat_deg);
    let answer = engine.questions().place(place, &Cancel::default()).unwrap();
    answer.height_m
}

fn from_above() -> View {
    View {
        camera: Camera::from_degrees(LON, LAT, 1500.0, 0.0, -90.0, 60.0).unwrap(),
        viewport_px: [320, 240],
        layout: relievo_engine::Layout::STANDARD,
        colour_window: 256,
        colour_texel_px: 1.0,
        height_texel_px: 2.0,
        max_taps: 4,
    }
}

/// Drains until nothing is missing and nothing is being made; what there was to upload.
fn settle(engine: &mut Engine) -> Vec<Upload> {
    let mut uploads = Vec::new();
    for _ in 0..2000 {
        let frame = engine.drain(f32::INFINITY).unwrap();
        let is_converged = frame.is_converged();
        uploads.extend(frame.uploads);
        if engine.wait(Duration::from_millis(50)) && is_converged {
            return uploads;
        }
    }
    panic!("does not converge: {:?}", engine.stats());
}

#[test]
fn an_element_changes_heights_in_its_reach_and_undo_takes_it_back() {
    let mut engine = engine();
    let before = height_m(&engine, LON, LAT);
    let far = height_m(&engine, LON + 0.02, LAT);
    add(&mut engine, platform("pad", before + 6.0));
    assert!((height_m(&engine, LON, LAT) - (before + 6.0)).abs() < 1e-3);
    assert_eq!(height_m(&engine, LON + 0.02, LAT), far);
    let made_by = engine
        .questions()
        .place(MapPoint::from_degrees(LON, LAT), &Cancel::default())
        .unwrap()
        .height_made_by;
    assert!(made_by.iter().any(|m| m.node == "earthwork"), "{made_by:?}");
    engine.undo().unwrap();
    assert_eq!(height_m(&engine, LON, LAT), before);
}

#[test]
fn a_drag_makes_again_only_tiles_in_reach_and_prepares_one_element() {
    let mut engine = engine();
    for k in 0..200 {
        let (x, y) = (f64::from(k % 20), f64::from(k / 20));
        let surface = SurfaceKind::Platform { height_m: 5.0 };
        let id = format!("p{k}");
        add(
            &mut engine,
            pad(&id, LON + x * 0.004, LAT + y * 0.004, 40.0, surface),
        );
    }
    add(&mut engine, platform("dragged", 12.0));
    engine.set_view(from_above());
    settle(&mut engine);
    engine.take_log();
    let kept = engine.stats().kept.nodes;
    engine
        .apply(Edit::ReplaceElement {
            scenario: None,
            element: platform("dragged", 13.0),
        })
        .unwrap();
    settle(&mut engine);
    let made = engine.take_log();
    assert!(!made.is_empty());
    assert!(
        made.iter()
            .all(|e| e.kind == "earthwork" || e.kind == "normals"),
        "the ground stays: {made:?}"
    );
    // 200 m of reach around 100 m, in tiles of all levels: a handful each.
    assert!(made.len() < 120, "{}", made.len());
    assert!(engine.stats().kept.nodes <= kept + 1);
}

/// A scenario in which the platform lies at 70 m.
fn add_higher(engine: &mut Engine) {
    let mut scenario = Scenario::new(ScenarioId::from("higher"), "higher", None);
    let replace = ChangeKind::Replace {
        element: platform("pad", 70.0),
        index: None,
    };
    scenario.changes.push(Change::from(replace));
    let add = Edit::AddScenario {
        index: None,
        scenario: Box::new(scenario),
    };
    engine.apply(add).unwrap();
}

fn show(id: Option<&str>) -> Edit {
    Edit::ShowScenario {
        id: id.map(ScenarioId::from),
    }
}

#[test]
fn the_shown_scenario_decides_and_nobody_else() {
    let mut engine = engine();
    let ground = height_m(&engine, LON, LAT);
    add(&mut engine, platform("pad", 50.0));
    add_higher(&mut engine);
    assert_eq!(height_m(&engine, LON, LAT), 50.0);
    engine.apply(show(Some("higher"))).unwrap();
    assert_eq!(height_m(&engine, LON, LAT), 70.0);
    let base = engine.questions_in(None);
    let place = MapPoint::from_degrees(LON, LAT);
    let in_base = base.place(place, &Cancel::default()).unwrap();
    assert_eq!(
        in_base.height_m, 50.0,
        "the base can be asked while another is shown"
    );
    engine.apply(show(None)).unwrap();
    assert_eq!(height_m(&engine, LON, LAT), 50.0);
    assert_ne!(ground, 50.0);
}

#[test]
fn what_is_odd_about_an_element_is_said_and_it_is_drawn_all_the_same() {
    let mut engine = engine();
    let (dx, dy) = (5e-4, 4e-4);
    let tie =
        [(-dx, -dy), (dx, dy), (dx, -dy), (-dx, dy)].map(|(x, y)| Vertex::new(LON + x, LAT + y));
    let polygon = Polygon::new(tie.to_vec(), SurfaceKind::Platform { height_m: 44.0 });
    let element = Element::new(
        ElementId::from("tie"),
        "bow tie",
        ElementKind::Polygon(polygon),
    );
    add(&mut engine, Arc::new(element));
    engine.wait_for_sources();
    let message = engine
        .messages()
        .iter()
        .find(|m| m.element == Some(ElementId::from("tie")))
        .unwrap();
    assert!(
        message.text.contains("bow tie") && message.text.contains("cross"),
        "{message:?}"
    );
    assert_eq!(height_m(&engine, LON - 3e-4, LAT), 44.0);
    assert_eq!(height_m(&engine, LON + 3e-4, LAT), 44.0);
}

#[test]
fn an_element_says_where_its_work_ends() {
    let mut engine = engine();
    let ground = height_m(&engine, LON, LAT);
    let mut tower = Element::clone(&platform("tower", ground + 30.0));
    tower.side.max_reach_m = 20.0;
    add(&mut engine, Arc::new(tower));
    let line = [Vertex::new(LON + 0.01, LAT), Vertex::new(LON + 0.02, LAT)];
    let road = Corridor::new(
        line.to_vec(),
        ProfileKind::Follow {
            offset_m: 1.0,
            smooth_m: 300.0,
        },
        SectionKind::Road {
            width_m: 8.0,
            crossfall_percent: 2.0,
        },
    );
    add(
        &mut engine,
        Arc::new(Element::new(
            ElementId::from("road"),
            "road",
            ElementKind::Corridor(road),
        )),
    );
    let questions = engine.questions();
    let cancel = Cancel::default();
    let ask = |id: &str| {
        questions
            .element(&ElementId::from(id), 1.0, &cancel)
            .unwrap()
    };
    let tower = ask("tower").unwrap();
    assert!(tower.daylight.iter().all(|l| l.ending == Ending::ReachWall));
    assert!(
        tower.warnings.iter().any(|w| w.contains("reach")),
        "{tower:?}"
    );
    let road = ask("road").unwrap();
    let places: usize = road.daylight.iter().map(|l| l.places.len()).sum();
    assert!(places > 500 && road.daylight.iter().any(|l| l.ending == Ending::Meets));
    assert!(ask("nothing").is_none());
}

#[test]
fn an_elements_colours_lie_above_the_layers_where_it_is() {
    let mut engine = engine();
    let mut pad = Element::clone(&platform("pad", 5.0));
    pad.style.fill = Some([200, 40, 10]);
    add(&mut engine, Arc::new(pad));
    let colour = |engine: &Engine, lon: f64| {
        let place = MapPoint::from_degrees(lon, LAT);
        engine
            .questions()
            .place(place, &Cancel::default())
            .unwrap()
            .colour
    };
    assert_eq!(colour(&engine, LON), Some([200, 40, 10, 255]));
    assert_eq!(colour(&engine, LON + 0.002), Some([0; 4]));
}

/// How many uploaded pixels are much redder than blue, and the other way round.
fn reds_and_blues(uploads: &[Upload]) -> (usize, usize) {
    let colours = uploads.iter().filter(|u| u.clipmap == ClipKind::Colour);
    let pixels = colours
        .filter_map(|u| u.tile.bytes())
        .flat_map(|b| b.chunks_exact(4));
    pixels.fold((0, 0), |(reds, blues), p| {
        let (red, blue) = (i32::from(p[0]), i32::from(p[2]));
        (
            reds + usize::from(red > blue + 60),
            blues + usize::from(blue > red + 60),
        )
    })
}

#[test]
fn a_difference_is_red_where_the_shown_ground_is_higher_and_costs_only_its_own_tiles() {
    let mut engine = engine();
    add(&mut engine, platform("pad", 50.0));
    let surface = SurfaceKind::Platform { height_m: 9.0 };
    add(&mut engine, pad("same", LON + 0.004, LAT, 40.0, surface));
    add_higher(&mut engine);
    engine.apply(show(Some("higher"))).unwrap();
    engine.set_view(from_above());
    let plain = settle(&mut engine);
    assert_eq!(reds_and_blues(&plain), (0, 0));
    engine.take_log();

    let by = HeightDifference::that_shows(20.0);
    engine.show_difference(Some((None, by)));
    let (reds, blues) = reds_and_blues(&settle(&mut engine));
    assert!(reds > 1000 && blues == 0, "{reds} red, {blues} blue");
    let made = engine.take_log();
    let colours = made.iter().filter(|e| e.kind == "overlay").count();
    assert!(colours > 0);
    for entry in &made {
        assert!(
            ["overlay", "earthwork"].contains(&entry.kind),
            "{}",
            entry.kind
        );
    }

    engine.apply(show(None)).unwrap();
    engine.show_difference(Some((Some(ScenarioId::from("higher")), by)));
    let (reds, blues) = reds_and_blues(&settle(&mut engine));
    assert!(reds == 0 && blues > 1000, "{reds} red, {blues} blue");

    engine.take_log();
    engine.apply(show(Some("higher"))).unwrap();
    engine.show_difference(None);
    settle(&mut engine);
    assert_eq!(engine.take_log().len(), 0, "everything was there before");
}

#[test]
fn what_is_odd_about_an_element_on_its_ground_is_said_once_the_picture_is_whole() {
    let mut engine = engine();
    let ground = height_m(&engine, LON, LAT);
    let mut tower = Element::clone(&platform("tower", ground + 30.0));
    tower.side.max_reach_m = 20.0;
    add(&mut engine, Arc::new(tower));
    engine.set_view(from_above());
    let told = |engine: &mut Engine, wanted: bool| {
        for _ in 0..1000 {
            settle(engine);
            let mut messages = engine.messages().iter();
            let id = Some(ElementId::from("tower"));
            if messages.any(|m| m.element == id && m.text.contains("reach")) == wanted {
                return true;
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        false
    };
    assert!(told(&mut engine, true), "{:?}", engine.messages());
    let element = platform("tower", ground + 30.0);
    let scenario = None;
    engine
        .apply(Edit::ReplaceElement { scenario, element })
        .unwrap();
    assert!(told(&mut engine, false), "{:?}", engine.messages());
}

#[test]
fn a_place_names_the_element_that_decides_its_height_and_its_colour() {
    let mut engine = engine();
    let ground = height_m(&engine, LON, LAT);
    let mut lower = Element::clone(&platform("lower", ground + 8.0));
    lower.style.fill = Some([200, 40, 10]);
    add(&mut engine, Arc::new(lower));
    // Inside the other one, higher, without a colour of its own.
    let height_m = ground + 9.0;
    let upper = pad("upper", LON, LAT, 10.0, SurfaceKind::Platform { height_m });
    add(&mut engine, upper);
    let decided = |east_m: f64| {
        let place = MapPoint::from_degrees(LON + east_m / 78_850.0, LAT);
        let answer = engine.questions().place(place, &Cancel::default()).unwrap();
        let height = answer
            .height_made_by
            .into_iter()
            .find_map(|m| Some((m.element?, m.part?)));
        let colour = answer.colour_made_by.into_iter().find_map(|m| m.element);
        (height, colour)
    };
    let named = |id: &str, part| Some((id.to_owned(), part));
    assert_eq!(
        decided(0.0),
        (named("upper", "interior"), Some("lower".into()))
    );
    assert_eq!(
        decided(30.0),
        (named("lower", "interior"), Some("lower".into()))
    );
    assert_eq!(decided(53.0), (named("lower", "fill"), None));
    assert_eq!(decided(400.0), (None, None));
}
