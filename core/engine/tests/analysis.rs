//! Measurements on a real elevation model, against single places and formulas.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::Path;

use relievo_engine::analysis::{
    AnalysisError, ContourSettings, FloodSettings, MapBox, ProfileSettings, Sight, Task, Version,
    ViewshedSettings, VolumeSettings,
};
use relievo_engine::planet::MapPoint;
use relievo_engine::project::{
    HeightLayer, Layer, LayerId, LayerKind, LayerOverride, Project, Scenario, ScenarioId, Source,
};
use relievo_engine::raster::Cancel;
use relievo_engine::{Engine, EngineOptions, Questions};

/// A layer with the Wasatch mountains above Provo: from 1370 m on the lake to 3580 m.
fn mountains(id: &str, offset_m: f64) -> Layer {
    let mut height = HeightLayer::new(Source::new("wasatch-dem.tif"));
    height.offset_m = offset_m;
    Layer::new(LayerId::from(id), id, LayerKind::Height(height))
}

fn wasatch() -> Questions {
    let mut project = Project::default();
    project.layers.push(mountains("ground", 0.0));
    engine(project).questions()
}

fn engine(project: Project) -> Engine {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../projects/data");
    let options = EngineOptions {
        threads: Some(1),
        cache_folder: None,
        ..EngineOptions::default()
    };
    let mut engine = Engine::new(project, &folder, options).unwrap();
    engine.wait_for_sources();
    assert!(engine.messages().is_empty(), "{:?}", engine.messages());
    engine
}

fn at(lon_deg: f64, lat_deg: f64) -> MapPoint {
    MapPoint::from_degrees(lon_deg, lat_deg)
}

#[test]
fn a_profile_has_the_heights_of_its_places_at_the_spacing_of_the_data() {
    let (questions, cancel) = (wasatch(), Cancel::default());
    let line = [at(-111.65, 40.25), at(-111.6, 40.3)];
    let settings = ProfileSettings::default();
    let found = questions
        .profile(&line, &settings, &Task::quiet(&cancel))
        .unwrap();
    let spacing_m = found.length_m / (found.points.len() - 1) as f64;
    let place = questions.place(line[0], &cancel).unwrap();
    assert!(spacing_m <= place.spacing_m * 1.01 && spacing_m > 0.5 * place.spacing_m);
    for point in found.points.iter().step_by(found.points.len() / 12) {
        let exact = questions.place(point.place, &cancel).unwrap().height_m;
        assert!(
            (point.height_m - exact).abs() < 15.0,
            "{} {exact}",
            point.height_m
        );
    }
    assert!((found.length_m - questions.measure().distance_m(line[0], line[1])).abs() < 1e-6);
    assert!(found.surface_length_m > found.length_m && found.climb_m > 100.0);
    let rise_m = found.points.last().unwrap().height_m - found.points[0].height_m;
    assert!((found.climb_m - found.descent_m - rise_m).abs() < 1e-6);
}

#[test]
fn contours_lie_where_places_have_their_height() {
    let (questions, cancel) = (wasatch(), Cancel::default());
    let area = MapBox::from_degrees([-111.62, 40.27, -111.6, 40.285]).unwrap();
    let settings = ContourSettings::every(100.0);
    let lines = questions
        .contours(&area, &settings, &Task::quiet(&cancel))
        .unwrap();
    assert!(lines.len() >= 3);
    for line in &lines {
        let point = line.points[line.points.len() / 2];
        let found = questions.place(point, &cancel).unwrap().height_m;
        assert!(
            (found - line.height_m).abs() < 15.0,
            "{found} {}",
            line.height_m
        );
    }
}

#[test]
fn from_a_summit_one_sees_more_than_from_the_valley() {
    let (questions, cancel) = (wasatch(), Cancel::default());
    let settings = ViewshedSettings {
        spacing_m: Some(90.0),
        threads: 2,
        ..ViewshedSettings::within(6000.0)
    };
    let task = Task::quiet(&cancel);
    // Mount Timpanogos and Little Cottonwood Canyon.
    let share = |observer| {
        let found = questions.viewshed(observer, &settings, &task).unwrap();
        assert_eq!(found.at(observer), Sight::Visible);
        found.visible_m2 / found.area_m2
    };
    let (peak, canyon) = (share(at(-111.645, 40.3899)), share(at(-111.7526, 40.5695)));
    assert!(
        peak > canyon && peak < 1.0 && canyon > 0.0,
        "{peak} {canyon}"
    );
}

#[test]
fn water_fills_a_valley_behind_what_holds_it_and_refuses_a_dry_place() {
    let (questions, cancel) = (wasatch(), Cancel::default());
    let task = Task::quiet(&cancel);
    // A hollow without an outlet in this model; it would run over at 2074 m.
    let seed = at(-111.7212, 40.7267);
    let ground_m = questions.place(seed, &cancel).unwrap().height_m;
    let dry = questions.flood(seed, &FloodSettings::to(ground_m - 100.0), &task);
    assert!(
        matches!(dry, Err(AnalysisError::Refused(line)) if line.contains("below the water level"))
    );
    let settings = FloodSettings {
        level_m: ground_m + 10.0,
        max_samples: 1 << 22,
    };
    let wet = questions.flood(seed, &settings, &task).unwrap();
    assert!(
        wet.deepest_m >= 10.0 && wet.volume_m3 > 0.0 && wet.volume_m3 < wet.area_m2 * wet.deepest_m
    );
}

#[test]
fn a_measurement_stops_when_it_is_asked_to() {
    let (questions, cancel) = (wasatch(), Cancel::default());
    cancel.cancel();
    let line = [at(-111.65, 40.25), at(-111.6, 40.3)];
    let stopped = questions.profile(&line, &ProfileSettings::default(), &Task::quiet(&cancel));
    assert!(matches!(stopped, Err(AnalysisError::Cancelled)));
}

#[test]
fn a_scenario_whose_ground_is_five_metres_higher_is_five_metres_of_fill() {
    let mut project = Project::default();
    project.layers.push(mountains("ground", 0.0));
    let mut raised = mountains("raised", 5.0);
    raised.visible = false;
    project.layers.push(raised);
    let mut scenario = Scenario::new(ScenarioId::from("s"), "Raised", None);
    scenario.layers.push(LayerOverride {
        id: LayerId::from("raised"),
        visible: Some(true),
        opacity: None,
        extra: serde_json::Map::new(),
    });
    project.scenarios.push(scenario);
    let engine = engine(project);
    let raised = Version::called(engine.project(), "Raised").unwrap();
    assert_eq!(Version::called(engine.project(), "s"), Some(raised.clone()));
    assert_eq!(Version::called(engine.project(), "t"), None);
    let bounds = MapBox::from_degrees([-111.605, 40.28, -111.6, 40.285]).unwrap();
    let compare = |a: &Version, b: &Version| {
        let cancel = Cancel::default();
        let comparison = engine.comparison(a, b, Some(&bounds)).unwrap();
        let settings = VolumeSettings::from_spacing(1e9);
        let task = Task::quiet(&cancel);
        let report = comparison.measure(&settings, &task).unwrap();
        let pictures = comparison.pictures(0, 64, &task).unwrap().unwrap();
        (report, pictures)
    };
    let (report, pictures) = compare(&Version::Base, &raised);
    assert!(report.elements.is_empty() && !report.notes.is_empty());
    let total = report.total;
    let mean_m = total.fill_m3.value / total.plan_area_m2.value;
    assert!(
        (mean_m - 5.0).abs() < 1e-3 && total.plan_area_m2.value > 1e5,
        "{total:?}"
    );
    assert_eq!(total.cut_m3.value, 0.0);
    assert!((total.highest_fill_m.value - 5.0).abs() < 1e-3);
    assert!(
        total.mean_slope_deg.value > 1.0 && total.surface_area_m2.value > total.plan_area_m2.value
    );
    assert_eq!(
        (pictures.range_m, pictures.a.width, pictures.b.rgb.len()),
        (5.0, 64, 64 * 84 * 3),
        "as tall as the bounds"
    );
    assert_eq!(pictures.a, pictures.b, "the same relief, without colour");
    let (back, _) = compare(&raised, &Version::Base);
    assert_eq!(back.total.cut_m3.value, total.fill_m3.value);
    let (same, _) = compare(&raised, &raised);
    assert_eq!((same.total.samples, same.total.net_m3.value), (0, 0.0));
}
