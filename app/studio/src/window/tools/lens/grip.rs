//! What of a lens the pointer takes.

use eframe::egui::{CursorIcon, Pos2};
use glam::DVec2;
use relievo_engine::planet::{MapPoint, Planet};
use relievo_engine::project::{Lens, LensShape};

use super::shape;
use crate::window::tools::snap;
use crate::window::tools::view::Projector;

/// Edges shorter than this on the screen have no handle in their middle, points: the corners' would hide it.
const SHORTEST: f32 = 32.0;

/// A press so many times as far from the centre as the farthest corner brings the lens to the pointer.
const FAR: f64 = 1.5;

/// What a press takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Grip {
    /// A corner of a polygon.
    Corner(usize),
    /// The middle of the edge after a corner: a press makes a corner there.
    Middle(usize),
    /// All of it, at this place of its plane, metres.
    Whole(DVec2),
    /// All of it: its centre comes to the pointer.
    Centre,
}

impl Grip {
    /// What the pointer looks like over it.
    pub(super) fn cursor(self, is_held: bool) -> CursorIcon {
        match self {
            Self::Corner(_) if is_held => CursorIcon::Grabbing,
            Self::Corner(_) => CursorIcon::Grab,
            Self::Middle(_) => CursorIcon::Copy,
            Self::Whole(_) => CursorIcon::Move,
            Self::Centre if is_held => CursorIcon::Move,
            Self::Centre => CursorIcon::Crosshair,
        }
    }
}

/// The handles of a polygon, seen or not, and where: corners, then the middles of edges.
pub(super) fn handles(
    projector: &Projector<'_>,
    planet: Planet,
    lens: &Lens,
) -> Vec<(Grip, MapPoint)> {
    let Some(corners_m) = shape::corners(lens) else {
        return Vec::new();
    };
    let frame = shape::frame(planet, lens);
    let corners = corners_m
        .iter()
        .map(|c| frame.to_map(DVec2::from_array(*c)));
    let corners: Vec<MapPoint> = corners.collect();
    let ends: Vec<Option<Pos2>> = corners.iter().map(|c| projector.screen(*c)).collect();
    let has_room = corners_m.len() < LensShape::MOST_CORNERS;
    let middles = (0..corners_m.len()).filter(|_| has_room).filter_map(|i| {
        let long = match (ends[i], ends[(i + 1) % ends.len()]) {
            (Some(a), Some(b)) => a.distance(b) >= SHORTEST,
            _ => true,
        };
        let middle = shape::middle_m(corners_m, i).filter(|_| long)?;
        Some((Grip::Middle(i), frame.to_map(middle)))
    });
    let corners = corners.iter().enumerate();
    let corners = corners.map(|(i, place)| (Grip::Corner(i), *place));
    corners.chain(middles).collect()
}

/// What a press at a point of the screen takes, over a place of the ground.
pub(super) fn grip(
    projector: &Projector<'_>,
    planet: Planet,
    lens: Option<&Lens>,
    at: Pos2,
    place: Option<MapPoint>,
) -> Option<Grip> {
    let polygon = lens.and_then(|lens| Some((lens, shape::corners(lens)?)));
    let Some((lens, corners_m)) = polygon else {
        return place.map(|_| Grip::Centre);
    };
    let near = handles(projector, planet, lens)
        .into_iter()
        .filter_map(|(grip, place)| {
            let distance = projector.screen(place)?.distance(at);
            let hit = distance <= snap::REACH && projector.visible(place).is_some();
            hit.then_some((grip, distance))
        });
    // Corners come before middles, and the nearer before the farther.
    let rank = |grip: &Grip| matches!(grip, Grip::Middle(_));
    let nearest = near.min_by(|a, b| rank(&a.0).cmp(&rank(&b.0)).then(a.1.total_cmp(&b.1)));
    if let Some((handle, _)) = nearest {
        return Some(handle);
    }
    let taken_m = shape::frame(planet, lens).from_map(place?);
    let is_near = taken_m.length() <= FAR * shape::reach_m(corners_m);
    Some(if is_near || shape::contains(corners_m, taken_m) {
        Grip::Whole(taken_m)
    } else {
        Grip::Centre
    })
}
