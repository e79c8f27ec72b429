//! The height profile and the cross-section of a line.

use eframe::egui::Ui;
use relievo_engine::project::{Corridor, Edit, ElementKind, ProfileKind, SectionKind};

use super::{OFFSET, Shown, replace};
use crate::window::action::Action;
use crate::window::controls::{self, Number};

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

fn with_corridor(shown: &Shown<'_>, change: impl FnOnce(&mut Corridor)) -> Edit {
    replace(shown, |element| {
        if let ElementKind::Corridor(corridor) = &mut element.kind {
            change(corridor);
        }
    })
}

/// Draws them.
pub(super) fn show(ui: &mut Ui, shown: &Shown<'_>, corridor: &Corridor, actions: &mut Vec<Action>) {
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
