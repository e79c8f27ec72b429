//! Measurements on a real elevation model, against single places and formulas.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::Path;

use relievo_engine::analysis::{
    AnalysisError, ContourSettings, FloodSettings, MapBox, ProfileSettings, Sight, Task,
    ViewshedSettings,
};
use relievo_engine::planet::MapPoint;
use relievo_engine::project::{HeightLayer, Layer, LayerId, LayerKind, Project, Source};
use relievo_engine::raster::Cancel;
use relievo_engine::{Engine, EngineOptions, Questions};

/// The Wasatch mountains above Provo: from 1370 m on the lake to 3580 m.
fn wasatch() -> Questions {
    let mut project = Project::default();
    let kind = LayerKind::Height(HeightLayer::new(Source::new("wasatch-dem.tif")));
    project
        .layers
        .push(Layer::new(LayerId::from("ground"), "Ground", kind));
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../projects/data");
    let options = EngineOptions {
        threads: Some(1),
        cache_folder: None,
        ..EngineOptions::default()
    };
    let mut engine = Engine::new(project, &folder, options).unwrap();
    engine.wait_for_sources();
    assert!(engine.messages().is_empty(), "{:?}", engine.messages());
    engine.questions()
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
    // Provo Peak and a canyon below it.
    let share = |observer| {
        let found = questions.viewshed(observer, &settings, &task).unwrap();
        assert_eq!(found.at(observer), Sight::Visible);
        found.visible_m2 / found.area_m2
    };
    let (peak, canyon) = (share(at(-111.557, 40.244)), share(at(-111.6, 40.31)));
    assert!(
        peak > canyon && peak < 1.0 && canyon > 0.0,
        "{peak} {canyon}"
    );
}

#[test]
fn water_fills_a_valley_behind_what_holds_it_and_refuses_a_dry_place() {
    let (questions, cancel) = (wasatch(), Cancel::default());
    let task = Task::quiet(&cancel);
    let seed = at(-111.6, 40.31);
    let ground_m = questions.place(seed, &cancel).unwrap().height_m;
    let dry = questions.flood(seed, &FloodSettings::to(ground_m - 100.0), &task);
    assert!(
        matches!(dry, Err(AnalysisError::Refused(line)) if line.contains("below the water level"))
    );
    let settings = FloodSettings {
        level_m: ground_m + 30.0,
        max_samples: 1 << 22,
    };
    let wet = questions.flood(seed, &settings, &task).unwrap();
    assert!(
        wet.deepest_m >= 25.0 && wet.volume_m3 > 0.0 && wet.volume_m3 < wet.area_m2 * wet.deepest_m
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
