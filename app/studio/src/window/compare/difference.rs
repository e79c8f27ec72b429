//! How much higher or lower the ground of one scenario is than that of another: the range that the
//! colours need, and their legend. The engine draws them into the ground's own colours.

use eframe::egui::{
    Align2, Color32, CornerRadius, FontId, Rect, Role, Sense, Ui, WidgetInfo, pos2, vec2,
};
use relievo_engine::analysis::Task;
use relievo_engine::planet::Camera;
use relievo_engine::raster::Cancel;
use relievo_engine::{HeightDifference, Questions};

use crate::window::latest::Latest;
use crate::window::theme;

/// What a difference is of.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Wanted {
    pub(super) revision: u64,
    pub(super) camera: Camera,
    pub(super) aspect: f64,
}

/// How much the ground differs in view, and how that is coloured.
pub(super) struct Differences {
    latest: Latest<Wanted, Option<f32>>,
    /// The colours that are shown, and for which state of the document they were chosen.
    colours: Option<(u64, HeightDifference)>,
    /// Largest difference in view without its sign, metres.
    most_m: Option<f32>,
}

impl Differences {
    pub(super) fn new(latest: Latest<Wanted, Option<f32>>) -> Self {
        Self {
            latest,
            colours: None,
            most_m: None,
        }
    }

    /// Asks for the largest difference of two revisions as a camera sees them.
    pub(super) fn ask(&mut self, wanted: &Wanted, both: impl FnOnce() -> (Questions, Questions)) {
        let key = wanted.clone();
        self.latest.ask(key.clone(), || {
            let (own, other) = both();
            move |task: &Task| most_m(&own, &other, &key, task.cancel)
        });
    }

    /// Takes the answer. While only the camera moves the range of the colours never shrinks, so that
    /// they do not flicker between two.
    pub(super) fn update(&mut self, wanted: &Wanted) {
        let Some(most_m) = self.latest.answer(wanted).flatten() else {
            return;
        };
        self.most_m = Some(most_m);
        let found = HeightDifference::that_shows(most_m);
        let grows = match self.colours {
            Some((revision, shown)) => {
                revision != wanted.revision || found.range_m() > shown.range_m()
            }
            None => true,
        };
        if grows {
            self.colours = Some((wanted.revision, found));
        }
    }

    /// The colours, once they are known.
    pub(super) fn colours(&self) -> Option<HeightDifference> {
        self.colours.map(|(_, colours)| colours)
    }

    /// The scale of the colours at the lower edge of the picture.
    pub(super) fn legend(&self, ui: &mut Ui, rect: Rect, own: &str, other: &str) {
        legend(
            ui,
            rect,
            &format!("Height of {own} less {other}"),
            self.most_m,
            self.colours(),
        );
    }
}

/// The largest difference in view without its sign, metres.
fn most_m(own: &Questions, other: &Questions, of: &Wanted, cancel: &Cancel) -> Option<f32> {
    let own = own.seen_heights(&of.camera, of.aspect, cancel).ok()??;
    let other = other.seen_heights(&of.camera, of.aspect, cancel).ok()??;
    let pairs = own.heights_m.iter().zip(&other.heights_m);
    let metres = pairs.map(|(a, b)| (a - b).abs()).filter(|m| m.is_finite());
    Some(metres.fold(0.0, f32::max))
}

/// A colour of the scale, for a share of the range, −1 to 1.
fn colour(share: f32) -> Color32 {
    let [r, g, b, _] = HeightDifference::colour(share).map(|c| (c * 255.0).round() as u8);
    Color32::from_rgb(r, g, b)
}

fn legend(
    ui: &mut Ui,
    rect: Rect,
    title: &str,
    most_m: Option<f32>,
    colours: Option<HeightDifference>,
) {
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
    text(
        area.center_top() + vec2(0.0, 4.0),
        Align2::CENTER_TOP,
        title,
    );
    let bar = Rect::from_min_size(area.min + vec2(14.0, 22.0), vec2(size.x - 28.0, 14.0));
    for i in 0..64_u8 {
        let share = f32::from(i) / 63.0;
        let left = bar.left() + bar.width() * f32::from(i) / 64.0;
        let cell = Rect::from_min_size(
            pos2(left, bar.top()),
            vec2(bar.width() / 64.0 + 0.5, bar.height()),
        );
        painter.rect_filled(cell, CornerRadius::ZERO, colour(2.0 * share - 1.0));
    }
    let range = colours.map_or_else(|| "…".to_owned(), |c| format!("{} m", c.range_m()));
    let below = bar.bottom() + 3.0;
    text(
        pos2(bar.left(), below),
        Align2::LEFT_TOP,
        &format!("lower by {range}"),
    );
    text(
        pos2(bar.right(), below),
        Align2::RIGHT_TOP,
        &format!("higher by {range}"),
    );
    let response = ui.interact(area, ui.scope_id().with("legend"), Sense::hover());
    let most = most_m.map_or_else(|| "…".to_owned(), |m| format!("{m:.1} m"));
    let spoken = format!("{title}: up to {most}");
    let hint = format!("In view the heights differ by up to {most}");
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, &spoken));
    response.on_hover_text(hint);
}
