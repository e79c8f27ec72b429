//! How much higher or lower the ground of one scenario is than that of another, as colours over the
//! picture: blue where it is lower, red where it is higher.

use eframe::egui::epaint::{Mesh, Vertex as MeshVertex};
use eframe::egui::{
    Align2, Color32, ColorImage, CornerRadius, FontId, Rect, Role, Sense, Shape, TextureHandle,
    TextureOptions, Ui, WidgetInfo, pos2, vec2,
};
use relievo_engine::Questions;
use relievo_engine::planet::{Camera, Grid};
use relievo_engine::raster::Cancel;

use crate::window::latest::Latest;
use crate::window::theme;
use crate::window::tools::view::Projector;

/// Samples of the grid between two vertices of the mesh that carries the colours.
const STRIDE: i64 = 8;

/// Differences below this are none, metres.
const LEAST_M: f32 = 0.01;

/// What a difference is of.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Wanted {
    pub(super) revision: u64,
    pub(super) camera: Camera,
    pub(super) aspect: f64,
}

/// Differences on a grid.
#[derive(Clone, Debug)]
pub(super) struct Difference {
    grid: Grid,
    /// Shown scenario less the other, metres.
    metres: Vec<f32>,
    /// Largest of them without its sign, metres.
    most_m: f32,
}

/// The latest difference and what draws it.
pub(super) struct Differences {
    latest: Latest<Wanted, Option<Difference>>,
    /// The colours of the difference for a question.
    texture: Option<(Wanted, Difference, TextureHandle)>,
}

impl Differences {
    pub(super) fn new(latest: Latest<Wanted, Option<Difference>>) -> Self {
        Self {
            latest,
            texture: None,
        }
    }

    /// Asks for the difference of two revisions as a camera sees them.
    pub(super) fn ask(&mut self, wanted: &Wanted, both: impl FnOnce() -> (Questions, Questions)) {
        let key = wanted.clone();
        self.latest.ask(key.clone(), || {
            let (own, other) = both();
            move |cancel: &Cancel| difference(&own, &other, &key, cancel)
        });
    }

    /// Draws the latest difference over the picture; its largest value in metres.
    pub(super) fn paint(
        &mut self,
        ui: &Ui,
        rect: Rect,
        wanted: &Wanted,
        projector: &Projector<'_>,
    ) -> Option<f32> {
        if let Some(found) = self.latest.answer(wanted)
            && self.texture.as_ref().is_none_or(|(of, ..)| of != wanted)
        {
            self.texture = found.map(|found| {
                let image = image(&found);
                let name = "difference of heights";
                let texture = ui.ctx().load_texture(name, image, TextureOptions::LINEAR);
                (wanted.clone(), found, texture)
            });
        }
        let (_, found, texture) = self.texture.as_ref()?;
        let mesh = mesh(found, texture, projector);
        ui.painter().with_clip_rect(rect).add(Shape::mesh(mesh));
        Some(found.most_m)
    }
}

fn difference(
    own: &Questions,
    other: &Questions,
    of: &Wanted,
    cancel: &Cancel,
) -> Option<Difference> {
    let own = own.seen_heights(&of.camera, of.aspect, cancel).ok()??;
    let other = other.seen_heights(&of.camera, of.aspect, cancel).ok()??;
    let pairs = own.heights_m.iter().zip(&other.heights_m);
    let metres: Vec<f32> = pairs.map(|(a, b)| a - b).collect();
    let most_m = metres
        .iter()
        .filter(|m| m.is_finite())
        .fold(0.0, |most: f32, m| most.max(m.abs()));
    Some(Difference {
        grid: own.grid,
        metres,
        most_m,
    })
}

/// The colour of a difference, as a share of the largest one, −1 to 1: white is none.
fn colour(share: f32) -> Color32 {
    let share = share.clamp(-1.0, 1.0);
    // Faint differences are seen, too.
    let strength = share.abs().sqrt();
    let [r, g, b] = if share > 0.0 {
        [178.0, 24.0, 43.0]
    } else {
        [33.0, 102.0, 172.0]
    };
    let mix = |c: f32| (245.0 + (c - 245.0) * strength) as u8;
    Color32::from_rgb(mix(r), mix(g), mix(b)).gamma_multiply(0.35 + 0.5 * strength)
}

fn image(found: &Difference) -> ColorImage {
    let (width, height) = (
        found.grid.rect.width() as usize,
        found.grid.rect.height() as usize,
    );
    let pixel = |m: &f32| {
        if m.is_finite() && m.abs() >= LEAST_M {
            colour(m / found.most_m.max(LEAST_M))
        } else {
            Color32::TRANSPARENT
        }
    };
    ColorImage::new([width, height], found.metres.iter().map(pixel).collect())
}

/// The grid as a mesh over the ground; what is behind the planet is left out.
fn mesh(found: &Difference, texture: &TextureHandle, projector: &Projector<'_>) -> Mesh {
    let size = [found.grid.rect.width(), found.grid.rect.height()];
    let [columns, rows] = size.map(|s| s / STRIDE);
    let mut mesh = Mesh::with_texture(texture.id());
    let mut index = Vec::new();
    for row in 0..=rows {
        for column in 0..=columns {
            let at = glam::DVec2::new((column * STRIDE) as f64, (row * STRIDE) as f64);
            let plane = found.grid.lattice.origin + at * found.grid.lattice.step;
            let point = relievo_engine::planet::MapPoint::new(plane.x, plane.y).normalised();
            let Some(pos) = projector.screen(point) else {
                index.push(None);
                continue;
            };
            index.push(Some(mesh.vertices.len() as u32));
            mesh.vertices.push(MeshVertex {
                pos,
                uv: pos2(at.x as f32 / size[0] as f32, at.y as f32 / size[1] as f32),
                color: Color32::WHITE,
            });
        }
    }
    let at = |column: i64, row: i64| index[(row * (columns + 1) + column) as usize];
    for row in 0..rows {
        for column in 0..columns {
            let corners = [
                at(column, row),
                at(column + 1, row),
                at(column, row + 1),
                at(column + 1, row + 1),
            ];
            if let [Some(a), Some(b), Some(c), Some(d)] = corners {
                mesh.add_triangle(a, b, c);
                mesh.add_triangle(b, d, c);
            }
        }
    }
    mesh
}

/// The scale of colours at the lower edge of the picture.
pub(super) fn legend(ui: &mut Ui, rect: Rect, own: &str, other: &str, most_m: Option<f32>) {
    let size = vec2(300.0, 62.0);
    if rect.width() < size.x || rect.height() < 2.0 * size.y {
        return;
    }
    let area = Align2::CENTER_BOTTOM.align_size_within_rect(size, rect.shrink(10.0));
    let painter = ui.painter_at(rect);
    painter.rect_filled(area, CornerRadius::same(6), theme::OVERLAY);
    let text = |at, align, text: &str| {
        painter.text(at, align, text, FontId::proportional(12.0), Color32::WHITE);
    };
    let title = format!("Height of {own} less {other}");
    text(
        area.center_top() + vec2(0.0, 4.0),
        Align2::CENTER_TOP,
        &title,
    );
    let bar = Rect::from_min_size(area.min + vec2(14.0, 22.0), vec2(size.x - 28.0, 14.0));
    for i in 0..64_u8 {
        let share = f32::from(i) / 63.0;
        let left = bar.left() + bar.width() * f32::from(i) / 64.0;
        let cell = Rect::from_min_size(
            pos2(left, bar.top()),
            vec2(bar.width() / 64.0 + 0.5, bar.height()),
        );
        painter.rect_filled(
            cell,
            CornerRadius::ZERO,
            colour(2.0 * share - 1.0).to_opaque(),
        );
    }
    let most = most_m.map_or_else(|| "…".to_owned(), |m| format!("{m:.1} m"));
    let below = bar.bottom() + 3.0;
    text(
        pos2(bar.left(), below),
        Align2::LEFT_TOP,
        &format!("lower by {most}"),
    );
    text(
        pos2(bar.right(), below),
        Align2::RIGHT_TOP,
        &format!("higher by {most}"),
    );
    let response = ui.interact(area, ui.scope_id().with("legend"), Sense::hover());
    let spoken = format!("{title}: up to {most}");
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, &spoken));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_diverge_from_nothing() {
        let (low, none, high) = (colour(-1.0), colour(0.0), colour(1.0));
        assert!(high.r() > high.b() && low.b() > low.r());
        assert!(none.a() < low.a() && none.a() < high.a());
        assert_eq!(colour(7.0), high);
    }
}
