//! Windows of heights and the width of their blend.

use relievo_engine::{Engine, Layout};

use super::paths::Path;
use super::swimming;
use super::{Bench, Errors, Setting};
use crate::suites::colour::frame_times;
use crate::{Chart, Content, Curve, Figure, Point, SuiteError, Table};

fn layouts(bench: &Bench) -> Vec<Layout> {
    let windows: &[u32] = bench.context.pick(&[256], &[256, 512, 1024]);
    let blends: &[u32] = bench.context.pick(&[10, 50], &[10, 25, 50, 100]);
    let of = |height_window: &u32| {
        let height_window = *height_window;
        blends.iter().map(move |blend_percent| Layout {
            height_window,
            blend_percent: *blend_percent,
            ..Layout::STANDARD
        })
    };
    windows.iter().flat_map(of).collect()
}

/// Screen-space error against frame time, and all that was measured, at a path's first place.
pub(super) fn figures(
    bench: &Bench,
    engine: &mut Engine,
    path: &Path,
) -> Result<[Figure; 2], SuiteError> {
    let Some(camera) = path.cameras(-30.0).first().copied() else {
        return Err(SuiteError::System("a path has no place".to_owned()));
    };
    let layouts = layouts(bench);
    let (mut stills, mut measured) = (Vec::new(), Vec::new());
    for layout in &layouts {
        bench.context.go_on()?;
        let setting = Setting {
            layout: *layout,
            ..Setting::STANDARD
        };
        let moved = swimming::moved(bench, engine, camera, setting)?;
        let swims = Errors::of(moved.px.into_iter());
        let errors = Errors::of(moved.offsets.iter().map(|o| o.screen_px));
        let selected =
            |level: &relievo_engine::planet::clipmap::LevelPlan| level.selected_tiles().len();
        let tiles: usize = moved.still.frame.plan.heights.iter().map(selected).sum();
        measured.push((errors, swims, tiles, moved.still.drawn.triangles));
        stills.push(moved.still);
    }
    let times = frame_times(bench.context, bench.gpu, &mut stills)?;
    let all = || layouts.iter().zip(&measured).zip(&times);
    let curves = Curve::grouped(all().map(|((layout, (errors, ..)), time)| {
        let blend = format!("blend {} %", layout.blend_percent);
        let point = Point::timed(blend, *time, errors.mean);
        (format!("N {}", layout.height_window), point)
    }));
    let rows = all().map(|((layout, (errors, swims, tiles, triangles)), time)| {
        vec![
            f64::from(layout.height_window).into(),
            f64::from(layout.blend_percent).into(),
            time.median.into(),
            (*tiles as f64).into(),
            (*triangles as f64).into(),
            errors.mean.into(),
            errors.p99.into(),
            errors.max.into(),
            swims.mean.into(),
            swims.p99.into(),
            swims.max.into(),
        ]
    });
    let head = [
        "window N of heights, samples",
        "blend, % of a ring",
        "frame, ms",
        "height tiles that are read",
        "triangles drawn",
        "mean error, px",
        "p99 error, px",
        "max error, px",
        "mean swimming, px",
        "p99 swimming, px",
        "max swimming, px",
    ];
    let caption = "One place, looking 30° down, the default mesh of a graphics processor. The blend into the next coarser level of \
                   heights ends at a ring's rim. A wider window has a ring fewer: the same mesh has fewer and larger triangles.";
    Ok([
        Figure::new(
            format!("layout-{}", path.name),
            format!("Windows of heights and blends: {} ground", path.name),
            caption,
            Content::Chart(Chart::trade(
                "ms per frame",
                "mean screen-space error",
                "px",
                curves,
            )),
        ),
        Figure::new(
            format!("layout-table-{}", path.name),
            format!(
                "Windows of heights and blends, all figures: {} ground",
                path.name
            ),
            caption,
            Content::Table(Table {
                head: head.map(str::to_owned).to_vec(),
                rows: rows.collect(),
            }),
        ),
    ])
}
