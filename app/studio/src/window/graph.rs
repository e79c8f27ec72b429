//! The nodes that make the picture, what they made, and what was left out and why. Read only.

use eframe::egui::{
    Color32, FontId, Pos2, Rect, RichText, Role, Scene, Sense, Shape, Stroke, StrokeKind, Ui,
    WidgetInfo, epaint::CubicBezierShape, pos2, vec2,
};
use relievo_engine::project::{LayerId, Project};
use relievo_engine::raster::SampleType;
use relievo_engine::{ClipKind, Engine, NodeReport};

use super::layers;

/// Size of a node in points, before zooming.
const NODE: [f32; 2] = [158.0, 58.0];

/// Space between nodes.
const GAP: [f32; 2] = [46.0, 14.0];

/// The part of the graph that is seen.
pub(crate) struct GraphView {
    seen: Rect,
    /// What was laid out last: another graph is seen whole at first.
    nodes: usize,
}

impl Default for GraphView {
    fn default() -> Self {
        Self {
            seen: Rect::ZERO,
            nodes: 0,
        }
    }
}

impl GraphView {
    /// Draws the graph of the shown picture.
    pub(crate) fn show(&mut self, ui: &mut Ui, engine: &Engine) {
        let nodes = engine.nodes();
        if std::mem::replace(&mut self.nodes, nodes.len()) != nodes.len() {
            self.seen = Rect::ZERO;
        }
        left_out(ui, engine);
        let places = places(&nodes);
        Scene::new()
            .zoom_range(0.1..=1.5)
            .show(ui, &mut self.seen, |ui| {
                for (node, rect) in nodes.iter().zip(&places) {
                    for input in &node.inputs {
                        arrow(ui, places[*input], *rect);
                    }
                }
                for (node, rect) in nodes.iter().zip(&places) {
                    draw(ui, engine.project(), node, *rect);
                }
            });
    }
}

/// What takes no part, and why.
fn left_out(ui: &mut Ui, engine: &Engine) {
    let unseen = engine.unseen();
    let mut left_out = engine.left_out().iter().chain(&unseen).peekable();
    if left_out.peek().is_none() {
        return;
    }
    ui.horizontal_wrapped(|ui| {
        ui.weak("Left out:");
        for (id, reason) in left_out {
            let name = name_of(engine.project(), id);
            ui.label(RichText::new(format!("{name} ({reason})")).small());
        }
    });
}

/// Where nodes lie: in columns after the longest way to them, in each in their order.
fn places(nodes: &[NodeReport]) -> Vec<Rect> {
    let mut columns: Vec<usize> = Vec::with_capacity(nodes.len());
    let mut rows: Vec<usize> = Vec::new();
    let mut places = Vec::with_capacity(nodes.len());
    for node in nodes {
        let after = node.inputs.iter().filter_map(|i| columns.get(*i));
        let column = after.max().map_or(0, |c| c + 1);
        if rows.len() <= column {
            rows.resize(column + 1, 0);
        }
        let at = pos2(
            column as f32 * (NODE[0] + GAP[0]),
            rows[column] as f32 * (NODE[1] + GAP[1]),
        );
        rows[column] += 1;
        columns.push(column);
        places.push(Rect::from_min_size(at, NODE.into()));
    }
    places
}

fn arrow(ui: &Ui, from: Rect, to: Rect) {
    let (a, b) = (from.right_center(), to.left_center());
    let bend = vec2((b.x - a.x).abs().max(40.0) * 0.5, 0.0);
    let stroke = Stroke::new(1.5, ui.visuals().weak_text_color());
    let curve = CubicBezierShape::from_points_stroke(
        [a, a + bend, b - bend, b],
        false,
        Color32::TRANSPARENT,
        stroke,
    );
    ui.painter().add(curve);
    let head: Vec<Pos2> = vec![b, b + vec2(-6.0, -3.5), b + vec2(-6.0, 3.5)];
    ui.painter()
        .add(Shape::convex_polygon(head, stroke.color, Stroke::NONE));
}

fn draw(ui: &mut Ui, project: &Project, node: &NodeReport, rect: Rect) {
    let response = ui.allocate_rect(rect, Sense::hover());
    let layer = node.layer.as_ref().map(|id| name_of(project, id));
    let made = what_it_made(node);
    let spoken = [Some(node.kind), layer.as_deref(), Some(made.as_str())];
    let spoken: Vec<&str> = spoken.into_iter().flatten().collect();
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, spoken.join(", ")));
    let visuals = ui.visuals();
    let (fill, stroke) = if node.shows.is_some() {
        let accent = visuals.selection.bg_fill;
        (accent.gamma_multiply(0.45), Stroke::new(1.5, accent))
    } else if node.stored.is_some() {
        (
            visuals.widgets.inactive.bg_fill,
            visuals.widgets.inactive.fg_stroke,
        )
    } else {
        (
            visuals.extreme_bg_color,
            visuals.widgets.noninteractive.bg_stroke,
        )
    };
    let painter = ui.painter();
    painter.rect(rect, 6, fill, stroke, StrokeKind::Inside);
    let line = |y: f32, text: &str, size: f32, colour: Color32| {
        let galley = painter.layout_no_wrap(text.to_owned(), FontId::proportional(size), colour);
        let inside = rect.shrink2(vec2(8.0, 4.0));
        painter
            .with_clip_rect(inside.intersect(painter.clip_rect()))
            .galley(inside.min + vec2(0.0, y), galley, colour);
    };
    line(0.0, node.kind, 13.0, visuals.strong_text_color());
    line(
        18.0,
        layer.as_deref().unwrap_or("the whole project"),
        11.0,
        visuals.text_color(),
    );
    line(34.0, &made, 11.0, visuals.weak_text_color());
    response.on_hover_text(explain(node));
}

fn what_it_made(node: &NodeReport) -> String {
    let made = node.made;
    match (node.stored, made.tiles, made.failed) {
        (None, ..) => "made on the way".to_owned(),
        (Some(_), 0, 0) => "no tiles yet".to_owned(),
        (Some(_), tiles, failed) => {
            let ms = made.time.as_secs_f64() * 1e3;
            let failed = if failed > 0 {
                format!(", {failed} failed")
            } else {
                String::new()
            };
            format!("{tiles} tiles, {ms:.0} ms{failed}")
        }
    }
}

fn explain(node: &NodeReport) -> String {
    let shows = match node.shows {
        Some(ClipKind::Height) => "The heights of the picture. ",
        Some(ClipKind::Colour) => "The colours of the picture. ",
        Some(ClipKind::Normal) => "The slopes of the picture, for its light. ",
        None => "",
    };
    let stored = match node.stored {
        Some(kind) => format!("Its tiles are kept as {}.", samples_of(kind)),
        None => "It is made together with what reads it; nothing of it is kept.".to_owned(),
    };
    format!("{shows}{stored}")
}

fn samples_of(kind: SampleType) -> &'static str {
    match kind {
        SampleType::Height => "heights of 32 bits",
        SampleType::Rgba8 => "colours of 8 bits",
        SampleType::Rgba16F => "colours of 16 bits",
        SampleType::Rgba32F => "colours of 32 bits, exactly as they were made",
        SampleType::Mask => "weights of 8 bits",
        SampleType::Mask32F => "weights, exact",
        SampleType::Normal => "normals of 16 bits",
    }
}

fn name_of(project: &Project, id: &LayerId) -> String {
    project
        .layer(id)
        .map_or_else(|| id.0.clone(), layers::name_of)
}

#[cfg(test)]
mod tests {
    use relievo_engine::Made;

    use super::*;

    fn node(inputs: &[usize]) -> NodeReport {
        NodeReport {
            kind: "node",
            layer: None,
            inputs: inputs.to_vec(),
            stored: None,
            shows: None,
            made: Made::default(),
        }
    }

    #[test]
    fn nodes_lie_right_of_what_they_read_and_never_on_each_other() {
        let nodes = [
            node(&[]),
            node(&[]),
            node(&[0, 1]),
            node(&[0]),
            node(&[2, 3]),
        ];
        let places = places(&nodes);
        for (node, place) in nodes.iter().zip(&places) {
            for input in &node.inputs {
                assert!(places[*input].right() < place.left());
            }
        }
        for (i, a) in places.iter().enumerate() {
            assert!(places[i + 1..].iter().all(|b| !a.intersects(*b)));
        }
    }
}
