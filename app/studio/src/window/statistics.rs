//! What the program is doing and did.

use eframe::egui::{Grid, ScrollArea, Ui};
use relievo_engine::Engine;
use relievo_gpu::FrameStats;

use super::status::Status;

/// A name, what it means, and the figure.
type Row = (&'static str, &'static str, String);

/// Draws figures of the engine and of the latest frame.
pub(crate) fn show(ui: &mut Ui, engine: &Engine, frame: Option<&FrameStats>, status: &Status) {
    let rows = ScrollArea::vertical().auto_shrink([false, false]);
    rows.show(ui, |ui| {
        ui.columns(2, |columns| {
            table(&mut columns[0], "engine", &of_engine(engine));
            table(&mut columns[1], "frame", &of_frame(engine, frame, status));
        });
    });
}

/// What was made so far.
fn of_engine(engine: &Engine) -> Vec<Row> {
    let stats = engine.stats();
    let tiles = stats.tiles;
    let mut left: Vec<Row> = vec![
        (
            "Tiles made",
            "Inputs of others included",
            tiles.made.to_string(),
        ),
        (
            "from disk",
            "Read from the cache folder instead",
            tiles.loaded.to_string(),
        ),
        (
            "written",
            "Written to the cache folder",
            tiles.stored.to_string(),
        ),
        ("failed", "Could not be made", tiles.failed.to_string()),
        (
            "in vain",
            "Nobody wanted them any more when they were done",
            tiles.in_vain.to_string(),
        ),
        (
            "evicted",
            "Removed from memory to make room",
            tiles.evicted.to_string(),
        ),
        (
            "waiting",
            "Tasks that wait or run",
            tiles.pending.to_string(),
        ),
        (
            "Time",
            "What all threads together spent making tiles",
            format!("{:.2} s", stats.busy_ns as f64 / 1e9),
        ),
    ];
    if tiles.made > 0 {
        let each = stats.busy_ns as f64 / 1e6 / tiles.made as f64;
        left.push((
            "a tile",
            "Time for a tile on average",
            format!("{each:.2} ms"),
        ));
    }
    left
}

/// What is kept, and what the latest frame took.
fn of_frame(engine: &Engine, frame: Option<&FrameStats>, status: &Status) -> Vec<Row> {
    let stats = engine.stats();
    let tiles = stats.tiles;
    let kept = stats.kept;
    let mut right: Vec<Row> = vec![
        (
            "Cache",
            "Finished tiles in memory",
            format!("{:.1} MiB", tiles.cache_bytes as f64 / f64::from(1 << 20)),
        ),
        (
            "Shown",
            "Tiles in the windows of the picture",
            kept.resident.to_string(),
        ),
        ("Files", "Files that are open", kept.files.to_string()),
        (
            "Visible to come",
            "Visible tiles that are still being made",
            stats.pending.to_string(),
        ),
        (
            "Frame",
            "What this program did for the latest frame",
            format!("{:.1} ms", status.frame_ms),
        ),
        (
            "Undo",
            "Memory of all steps of the history",
            format!("{:.1} KiB", engine.history().bytes() as f64 / 1024.0),
        ),
    ];
    if let Some(frame) = frame {
        if let Some(measured) = frame.measured {
            right.push((
                "Device",
                "What the graphics device did for it",
                format!("{:.1} ms", measured.gpu_ms),
            ));
        }
        right.push((
            "Triangles",
            "Triangles of the latest frame",
            frame.triangles.to_string(),
        ));
        let parts: Vec<&str> = frame.left_out().iter().map(|(part, _)| *part).collect();
        right.push((
            "Left out",
            "Parts of the drawing that the scene does not use; layers are named in the graph",
            if parts.is_empty() {
                "nothing".to_owned()
            } else {
                parts.join(", ")
            },
        ));
    }
    right
}

fn table(ui: &mut Ui, name: &str, rows: &[Row]) {
    Grid::new(name)
        .num_columns(2)
        .spacing([12.0, 2.0])
        .show(ui, |ui| {
            for (title, hint, value) in rows {
                ui.weak(*title).on_hover_text(*hint);
                ui.monospace(value).on_hover_text(*hint);
                ui.end_row();
            }
        });
}
