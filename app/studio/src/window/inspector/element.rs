//! The settings of a planning element: surface, section, side slopes, colours, vertices.

mod vertices;

use std::sync::Arc;

use eframe::egui::{self, CollapsingHeader, RichText, TextEdit, Ui};
use relievo_engine::project::{
    BrushTool, Corridor, Edit, Element, ElementId, ElementKind, ElementStyle, Polygon, ProfileKind,
    ScenarioId, SectionKind, SideSlopes, SurfaceKind,
};

use super::vector::colour;
use crate::window::action::Action;
use crate::window::controls::{self, Number};
use crate::window::tools::Spot;

const HEIGHT: Number = Number::new(
    "Height",
    "Height above the datum",
    -12_000.0..=12_000.0,
    0.0,
)
.unit(" m", 2);
const SLOPE: Number =
    Number::new("Slope", "How much the plane falls", 0.0..=200.0, 2.0).unit(" %", 2);
const ASPECT: Number = Number::new(
    "Falls towards",
    "Direction in which the plane falls, clockwise from north",
    0.0..=360.0,
    180.0,
)
.unit("°", 1);
const OFFSET: Number = Number::new(
    "Offset",
    "Above the ground, negative below it",
    -500.0..=500.0,
    0.0,
)
.unit(" m", 2);
const SMOOTH: Number = Number::new(
    "Smoothed over",
    "Length over which the ground along the line is smoothed",
    0.0..=10_000.0,
    100.0,
)
.unit(" m", 0)
.logarithmic();
const WIDTH: Number = Number::new("Width", "Width of the roadway", 0.01..=1000.0, 8.0)
    .unit(" m", 2)
    .logarithmic();
const CROSSFALL: Number = Number::new(
    "Crossfall",
    "Fall from the axis to both sides",
    -20.0..=20.0,
    0.0,
)
.unit(" %", 2);
const CREST: Number = Number::new("Crest", "Width of the crest", 0.01..=1000.0, 6.0)
    .unit(" m", 2)
    .logarithmic();
const BOTTOM: Number = Number::new("Bottom", "Width of the bottom", 0.01..=1000.0, 4.0)
    .unit(" m", 2)
    .logarithmic();
const DEPTH: Number =
    Number::new("Depth", "Depth below the profile", 0.0..=500.0, 2.0).unit(" m", 2);
const BANK: Number = Number::new(
    "Bank slope",
    "Rise over run of the banks",
    0.01..=100.0,
    0.5,
)
.logarithmic();
const CUT: Number = Number::new(
    "Cut slope",
    "Rise over run where ground is taken away",
    0.01..=100.0,
    0.5,
)
.logarithmic();
const FILL: Number = Number::new(
    "Fill slope",
    "Rise over run where ground is filled up",
    0.01..=100.0,
    0.5,
)
.logarithmic();
const REACH: Number = Number::new(
    "Reach",
    "Farthest that a side slope goes; it ends in a wall there",
    0.0..=10_000.0,
    200.0,
)
.unit(" m", 0)
.logarithmic();
const OPACITY: Number = Number::new("Opacity", "How much the fill covers", 0.0..=1.0, 1.0);
const STROKE_WIDTH: Number = Number::new(
    "Line width",
    "Width of the line on the ground",
    0.0..=1000.0,
    1.0,
)
.unit(" m", 2)
.logarithmic();
const STRENGTH: Number = Number::new(
    "Strength",
    "Metres at the centre of the stroke",
    0.0..=1000.0,
    20.0,
)
.unit(" m", 2);
const SHARE: Number = Number::new("Strength", "How much of the way", 0.0..=1.0, 1.0);
const RADIUS: Number = Number::new(
    "Radius",
    "Radius of the last stroke on the ground",
    0.01..=100_000.0,
    100.0,
)
.unit(" m", 1)
.logarithmic();
const HARDNESS: Number = Number::new(
    "Hardness",
    "Share of the radius with full effect",
    0.0..=1.0,
    0.5,
);

/// Surfaces to choose from.
#[derive(Clone, Copy, PartialEq)]
enum SurfaceName {
    Platform,
    Plane,
    Tin,
    Offset,
    Smooth,
    Other,
}

const SURFACES: [(SurfaceName, &str); 5] = [
    (SurfaceName::Platform, "Platform"),
    (SurfaceName::Plane, "Plane"),
    (SurfaceName::Tin, "Through vertices"),
    (SurfaceName::Offset, "Ground, shifted"),
    (SurfaceName::Smooth, "Smooth infill"),
];

#[derive(Clone, Copy, PartialEq)]
enum SectionName {
    Road,
    Dam,
    Trench,
    Channel,
    Other,
}

const SECTIONS: [(SectionName, &str); 4] = [
    (SectionName::Road, "Road"),
    (SectionName::Dam, "Dam"),
    (SectionName::Trench, "Trench"),
    (SectionName::Channel, "Channel"),
];

#[derive(Clone, Copy, PartialEq)]
enum ProfileName {
    Heights,
    Follow,
    Other,
}

const PROFILES: [(ProfileName, &str); 2] = [
    (ProfileName::Heights, "Vertex heights"),
    (ProfileName::Follow, "Follow ground"),
];

/// What the inspector remembers of elements from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct ElementForm {
    /// The name that is being typed.
    name: Option<(ElementId, String)>,
}

/// What is shown.
pub(crate) struct Shown<'a> {
    pub(crate) scenario: Option<ScenarioId>,
    pub(crate) element: &'a Element,
    /// The vertex that is chosen on the terrain.
    pub(crate) vertex: Option<Spot>,
}

impl ElementForm {
    /// Draws it; the vertex that was chosen in it, if one was.
    pub(crate) fn show(&mut self, ui: &mut Ui, shown: &Shown<'_>, actions: &mut Vec<Action>) {
        let element = shown.element;
        ui.push_id(&element.id.0, |ui| {
            ui.add_enabled_ui(!element.locked, |ui| {
                self.name(ui, shown, actions);
                match &element.kind {
                    ElementKind::Polygon(polygon) => surface(ui, shown, polygon, actions),
                    ElementKind::Corridor(corridor) => self::corridor(ui, shown, corridor, actions),
                    ElementKind::Brush(_) => brush(ui, shown, actions),
                    ElementKind::Unknown { kind } => {
                        ui.weak(format!(
                            "An element of kind {kind}, made by a newer Relievo. It is kept as it is."
                        ));
                    }
                }
                if matches!(element.kind, ElementKind::Polygon(_) | ElementKind::Corridor(_)) {
                    section(ui, "Side slopes", |ui| side(ui, shown, actions));
                }
                section(ui, "Colours", |ui| style(ui, shown, actions));
                if !matches!(element.kind, ElementKind::Brush(_)) {
                    section(ui, "Vertices", |ui| vertices::show(ui, shown, actions));
                }
            });
            ui.add_space(6.0);
            let mut locked = element.locked;
            let hint = "A locked element cannot be changed in the window";
            if ui.checkbox(&mut locked, "Locked").on_hover_text(hint).changed() {
                actions.push(Action::Edit(Edit::SetElementLocked {
                    scenario: shown.scenario.clone(),
                    id: element.id.clone(),
                    locked,
                }));
            }
        });
    }

    fn name(&mut self, ui: &mut Ui, shown: &Shown<'_>, actions: &mut Vec<Action>) {
        let element = shown.element;
        if self.name.as_ref().is_none_or(|(id, _)| *id != element.id) {
            self.name = Some((element.id.clone(), element.name.clone()));
        }
        let Some((_, text)) = &mut self.name else {
            return;
        };
        ui.horizontal(|ui| {
            let label = controls::name(ui, "Name", false);
            let field = TextEdit::singleline(text)
                .desired_width(f32::INFINITY)
                .char_limit(250)
                .hint_text(element.id.0.as_str());
            let response = ui.add(field).labelled_by(label.id);
            let response = response.on_hover_text("What the list calls the element");
            if response.lost_focus() && *text != element.name {
                if ui.input(|i| i.key_pressed(egui::Key::Escape)) {
                    text.clone_from(&element.name);
                } else {
                    actions.push(Action::Edit(Edit::SetElementName {
                        scenario: shown.scenario.clone(),
                        id: element.id.clone(),
                        name: text.trim().to_owned(),
                    }));
                }
            } else if !response.has_focus() && *text != element.name {
                text.clone_from(&element.name);
            }
        });
    }
}

/// The edit that puts the element, changed, in its own place.
fn replace(shown: &Shown<'_>, change: impl FnOnce(&mut Element)) -> Edit {
    let mut element = shown.element.clone();
    change(&mut element);
    Edit::ReplaceElement {
        scenario: shown.scenario.clone(),
        element: Arc::new(element),
    }
}

fn with_polygon(shown: &Shown<'_>, change: impl FnOnce(&mut Polygon)) -> Edit {
    replace(shown, |element| {
        if let ElementKind::Polygon(polygon) = &mut element.kind {
            change(polygon);
        }
    })
}

fn with_corridor(shown: &Shown<'_>, change: impl FnOnce(&mut Corridor)) -> Edit {
    replace(shown, |element| {
        if let ElementKind::Corridor(corridor) = &mut element.kind {
            change(corridor);
        }
    })
}

fn surface(ui: &mut Ui, shown: &Shown<'_>, polygon: &Polygon, actions: &mut Vec<Action>) {
    let kind = &polygon.surface.kind;
    let (now, height_m) = match kind {
        SurfaceKind::Platform { height_m } => (SurfaceName::Platform, *height_m),
        SurfaceKind::Plane { height_m, .. } => (SurfaceName::Plane, *height_m),
        SurfaceKind::Tin => (SurfaceName::Tin, 0.0),
        SurfaceKind::Offset { .. } => (SurfaceName::Offset, 0.0),
        SurfaceKind::Smooth => (SurfaceName::Smooth, 0.0),
        SurfaceKind::Unknown { .. } => (SurfaceName::Other, 0.0),
    };
    let hint = "How the heights inside are made";
    controls::choice(ui, "Surface", hint, &SURFACES, now, actions, |chosen| {
        let new = match chosen {
            SurfaceName::Platform => SurfaceKind::Platform { height_m },
            SurfaceName::Plane => SurfaceKind::Plane {
                height_m,
                slope_percent: 2.0,
                aspect_deg: 180.0,
            },
            SurfaceName::Tin => SurfaceKind::Tin,
            SurfaceName::Offset => SurfaceKind::Offset { offset_m: 0.0 },
            SurfaceName::Smooth => SurfaceKind::Smooth,
            SurfaceName::Other => kind.clone(),
        };
        with_polygon(shown, |p| p.surface.kind = new)
    });
    let set = |kind: SurfaceKind| with_polygon(shown, |p| p.surface.kind = kind);
    match *kind {
        SurfaceKind::Platform { height_m } => {
            controls::number(ui, &HEIGHT, height_m, actions, |height_m| {
                set(SurfaceKind::Platform { height_m })
            });
        }
        SurfaceKind::Plane {
            height_m,
            slope_percent,
            aspect_deg,
        } => {
            let plane = |height_m, slope_percent, aspect_deg| {
                set(SurfaceKind::Plane {
                    height_m,
                    slope_percent,
                    aspect_deg,
                })
            };
            controls::number(ui, &HEIGHT, height_m, actions, |v| {
                plane(v, slope_percent, aspect_deg)
            });
            controls::number(ui, &SLOPE, slope_percent, actions, |v| {
                plane(height_m, v, aspect_deg)
            });
            let aspect = aspect_deg.rem_euclid(360.0);
            controls::number(ui, &ASPECT, aspect, actions, |v| {
                plane(height_m, slope_percent, v)
            });
        }
        SurfaceKind::Offset { offset_m } => {
            controls::number(ui, &OFFSET, offset_m, actions, |offset_m| {
                set(SurfaceKind::Offset { offset_m })
            });
        }
        SurfaceKind::Tin | SurfaceKind::Smooth | SurfaceKind::Unknown { .. } => {}
    }
}

fn corridor(ui: &mut Ui, shown: &Shown<'_>, corridor: &Corridor, actions: &mut Vec<Action>) {
    let now = match &corridor.profile.kind {
        ProfileKind::Heights => ProfileName::Heights,
        ProfileKind::Follow { .. } => ProfileName::Follow,
        ProfileKind::Unknown { .. } => ProfileName::Other,
    };
    let profile = |kind: ProfileKind| with_corridor(shown, |c| c.profile.kind = kind);
    let hint = "How heights along the line are made";
    controls::choice(ui, "Profile", hint, &PROFILES, now, actions, |chosen| {
        profile(match chosen {
            ProfileName::Heights => ProfileKind::Heights,
            ProfileName::Follow => ProfileKind::Follow {
                offset_m: 0.0,
                smooth_m: 100.0,
            },
            ProfileName::Other => corridor.profile.kind.clone(),
        })
    });
    if let ProfileKind::Follow { offset_m, smooth_m } = corridor.profile.kind {
        controls::number(ui, &OFFSET, offset_m, actions, |offset_m| {
            profile(ProfileKind::Follow { offset_m, smooth_m })
        });
        controls::number(ui, &SMOOTH, smooth_m, actions, |smooth_m| {
            profile(ProfileKind::Follow { offset_m, smooth_m })
        });
    }
    cross_section(ui, shown, &corridor.section.kind, actions);
}

fn cross_section(ui: &mut Ui, shown: &Shown<'_>, kind: &SectionKind, actions: &mut Vec<Action>) {
    let set = |kind: SectionKind| with_corridor(shown, |c| c.section.kind = kind);
    let now = match kind {
        SectionKind::Road { .. } => SectionName::Road,
        SectionKind::Dam { .. } => SectionName::Dam,
        SectionKind::Trench { .. } => SectionName::Trench,
        SectionKind::Channel { .. } => SectionName::Channel,
        SectionKind::Unknown { .. } => SectionName::Other,
    };
    let hint = "Shape across the line";
    controls::choice(ui, "Section", hint, &SECTIONS, now, actions, |chosen| {
        set(match chosen {
            SectionName::Road => SectionKind::Road {
                width_m: 8.0,
                crossfall_percent: 0.0,
            },
            SectionName::Dam => SectionKind::Dam { crest_width_m: 6.0 },
            SectionName::Trench => SectionKind::Trench {
                bottom_width_m: 4.0,
                depth_m: 2.0,
            },
            SectionName::Channel => SectionKind::Channel {
                bottom_width_m: 4.0,
                depth_m: 2.0,
                bank_slope: 0.5,
            },
            SectionName::Other => kind.clone(),
        })
    });
    match *kind {
        SectionKind::Road {
            width_m,
            crossfall_percent,
        } => {
            let road = |width_m, crossfall_percent| {
                set(SectionKind::Road {
                    width_m,
                    crossfall_percent,
                })
            };
            controls::number(ui, &WIDTH, width_m, actions, |v| road(v, crossfall_percent));
            controls::number(ui, &CROSSFALL, crossfall_percent, actions, |v| {
                road(width_m, v)
            });
        }
        SectionKind::Dam { crest_width_m } => {
            controls::number(ui, &CREST, crest_width_m, actions, |crest_width_m| {
                set(SectionKind::Dam { crest_width_m })
            });
        }
        SectionKind::Trench {
            bottom_width_m,
            depth_m,
        } => {
            let trench = |bottom_width_m, depth_m| {
                set(SectionKind::Trench {
                    bottom_width_m,
                    depth_m,
                })
            };
            controls::number(ui, &BOTTOM, bottom_width_m, actions, |v| trench(v, depth_m));
            controls::number(ui, &DEPTH, depth_m, actions, |v| trench(bottom_width_m, v));
        }
        SectionKind::Channel {
            bottom_width_m,
            depth_m,
            bank_slope,
        } => {
            let channel = |bottom_width_m, depth_m, bank_slope| {
                set(SectionKind::Channel {
                    bottom_width_m,
                    depth_m,
                    bank_slope,
                })
            };
            controls::number(ui, &BOTTOM, bottom_width_m, actions, |v| {
                channel(v, depth_m, bank_slope)
            });
            controls::number(ui, &DEPTH, depth_m, actions, |v| {
                channel(bottom_width_m, v, bank_slope)
            });
            controls::number(ui, &BANK, bank_slope, actions, |v| {
                channel(bottom_width_m, depth_m, v)
            });
        }
        SectionKind::Unknown { .. } => {}
    }
}

/// The last stroke's settings.
fn brush(ui: &mut Ui, shown: &Shown<'_>, actions: &mut Vec<Action>) {
    let ElementKind::Brush(brush) = &shown.element.kind else {
        return;
    };
    ui.weak(format!(
        "{} strokes; the settings are those of the last one",
        brush.strokes.len()
    ));
    let Some(stroke) = brush.strokes.last() else {
        return;
    };
    let set = |change: &dyn Fn(&mut relievo_engine::project::Stroke)| {
        replace(shown, |element| {
            if let ElementKind::Brush(brush) = &mut element.kind
                && let Some(stroke) = brush.strokes.last_mut()
            {
                change(stroke);
            }
        })
    };
    controls::number(ui, &RADIUS, stroke.radius_m, actions, |v| {
        set(&|s| s.radius_m = v)
    });
    controls::number(ui, &HARDNESS, stroke.hardness, actions, |v| {
        set(&|s| s.hardness = v)
    });
    match stroke.tool {
        BrushTool::Raise { strength_m } => {
            controls::number(ui, &STRENGTH, strength_m, actions, |strength_m| {
                set(&|s| s.tool = BrushTool::Raise { strength_m })
            });
        }
        BrushTool::Lower { strength_m } => {
            controls::number(ui, &STRENGTH, strength_m, actions, |strength_m| {
                set(&|s| s.tool = BrushTool::Lower { strength_m })
            });
        }
        BrushTool::Smooth { strength } => {
            controls::number(ui, &SHARE, strength, actions, |strength| {
                set(&|s| s.tool = BrushTool::Smooth { strength })
            });
        }
        BrushTool::Flatten { height_m, strength } => {
            controls::number(ui, &HEIGHT, height_m, actions, |height_m| {
                set(&|s| s.tool = BrushTool::Flatten { height_m, strength })
            });
            controls::number(ui, &SHARE, strength, actions, |strength| {
                set(&|s| s.tool = BrushTool::Flatten { height_m, strength })
            });
        }
        BrushTool::Unknown { .. } => {}
    }
}

fn side(ui: &mut Ui, shown: &Shown<'_>, actions: &mut Vec<Action>) {
    let side = &shown.element.side;
    let set = |change: &dyn Fn(&mut SideSlopes)| replace(shown, |e| change(&mut e.side));
    let mut wall = side.wall;
    let hint = "Vertical at the boundary, without slopes beside it";
    if ui
        .checkbox(&mut wall, "Walls")
        .on_hover_text(hint)
        .changed()
    {
        actions.push(Action::Edit(set(&|s| s.wall = wall)));
    }
    ui.add_enabled_ui(!side.wall, |ui| {
        controls::number(ui, &CUT, side.cut_slope, actions, |v| {
            set(&|s| s.cut_slope = v)
        });
        controls::number(ui, &FILL, side.fill_slope, actions, |v| {
            set(&|s| s.fill_slope = v)
        });
        controls::number(ui, &REACH, side.max_reach_m, actions, |v| {
            set(&|s| s.max_reach_m = v)
        });
    });
}

fn style(ui: &mut Ui, shown: &Shown<'_>, actions: &mut Vec<Action>) {
    let style = &shown.element.style;
    let set = |change: &dyn Fn(&mut ElementStyle)| {
        let mut style = style.clone();
        change(&mut style);
        Edit::SetElementStyle {
            scenario: shown.scenario.clone(),
            id: shown.element.id.clone(),
            style,
        }
    };
    if let Some(fill) = colour(ui, "Fill", style.fill) {
        actions.push(Action::Edit(set(&|s| s.fill = fill)));
    }
    if style.fill.is_some() {
        controls::number(ui, &OPACITY, style.fill_opacity, actions, |v| {
            set(&|s| s.fill_opacity = v)
        });
    }
    if let Some(stroke) = colour(ui, "Line", style.stroke) {
        actions.push(Action::Edit(set(&|s| s.stroke = stroke)));
    }
    if style.stroke.is_some() {
        controls::number(ui, &STROKE_WIDTH, style.stroke_width_m, actions, |v| {
            set(&|s| s.stroke_width_m = v)
        });
    }
}

fn section(ui: &mut Ui, title: &str, content: impl FnOnce(&mut Ui)) {
    ui.add_space(4.0);
    CollapsingHeader::new(RichText::new(title).strong())
        .default_open(true)
        .show_unindented(ui, content);
}
