//! Where an element can act at all: what it is made of, and how far that reaches.

use glam::DVec2;
use relievo_planet::MapPoint;

use crate::frame::{Frame, MapRect};
use crate::rings::Rings;
use crate::tree::{Bounds, Tree};

/// Lines of one frame.
#[derive(Clone, Debug)]
struct Lines {
    frame: Frame,
    all: Vec<(DVec2, DVec2)>,
    tree: Tree,
}

/// The places within a distance of lines, and those inside of rings.
#[derive(Clone, Debug, Default)]
pub(crate) struct Footprint {
    parts: Vec<Lines>,
    rings: Option<(Frame, Rings)>,
    reach_m: f64,
    boxes: Vec<MapRect>,
}

fn distance_to_line(p: DVec2, (a, b): (DVec2, DVec2)) -> f64 {
    let d = b - a;
    let t = ((p - a).dot(d) / d.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    (a + d * t - p).length()
}

impl Footprint {
    pub(crate) fn new(
        parts: Vec<(Frame, Vec<(DVec2, DVec2)>)>,
        rings: Option<(Frame, Rings)>,
        reach_m: f64,
    ) -> Self {
        let poles = |frame: &Frame| {
            let Some((of, rings)) = &rings else {
                return (false, false);
            };
            let inside = |colat| {
                // Only the nearer pole can be inside an area that a frame shows.
                let pole = MapPoint::new(0.0, colat);
                frame.origin().angle_to(pole) < 1.6 && rings.contains(of.from_map(pole))
            };
            (inside(0.0), inside(core::f64::consts::PI))
        };
        let mut boxes = Vec::new();
        for (frame, lines) in &parts {
            let mut longest: f64 = 0.0;
            let points = lines.iter().flat_map(|(a, b)| {
                let length = (*b - *a).length();
                let pieces = (length / 50.0).ceil().clamp(1.0, 16.0);
                longest = longest.max(length / pieces);
                (0..=pieces as usize)
                    .map(move |k| frame.to_map(*a + (*b - *a) * (k as f64 / pieces)))
            });
            let points: Vec<MapPoint> = points.collect();
            let margin = reach_m + longest / 2.0;
            boxes.extend(MapRect::around(
                frame,
                points.into_iter(),
                margin,
                poles(frame),
            ));
        }
        let parts = parts
            .into_iter()
            .map(|(frame, lines)| {
                let bounds: Vec<Bounds> = lines
                    .iter()
                    .map(|(a, b)| Bounds::flat(a.min(*b), a.max(*b)))
                    .collect();
                Lines {
                    frame,
                    all: lines,
                    tree: Tree::new(&bounds),
                }
            })
            .collect();
        Self {
            parts,
            rings,
            reach_m,
            boxes,
        }
    }

    /// Rectangles that hold all of it.
    pub(crate) fn boxes(&self) -> &[MapRect] {
        &self.boxes
    }

    /// Whether some place of a rectangle may be reached: true for all that are, and for few others.
    pub(crate) fn touches(&self, rect: &MapRect) -> bool {
        let mut near = false;
        for b in self.boxes.iter().filter(|b| b.overlaps(rect)) {
            if rect.contains(b) {
                return true;
            }
            near = true;
        }
        near && self.touches_within(rect, 4)
    }

    fn touches_within(&self, rect: &MapRect, depth: u32) -> bool {
        let (lon, colat) = (
            f64::midpoint(rect.west_rad, rect.east_rad),
            f64::midpoint(rect.north_rad, rect.south_rad),
        );
        // A frame's disc says little about half a planet.
        let large = rect.east_rad - rect.west_rad > 0.5 || rect.south_rad - rect.north_rad > 0.5;
        let mut near = large;
        if !large {
            let around: [MapPoint; 8] = [
                (rect.west_rad, rect.north_rad),
                (lon, rect.north_rad),
                (rect.east_rad, rect.north_rad),
                (rect.west_rad, colat),
                (rect.east_rad, colat),
                (rect.west_rad, rect.south_rad),
                (lon, rect.south_rad),
                (rect.east_rad, rect.south_rad),
            ]
            .map(|(lon, colat)| MapPoint::new(lon, colat));
            let disc = |frame: &Frame| {
                let centre = frame.from_map(MapPoint::new(lon, colat));
                let far = |r: f64, p: &MapPoint| r.max((frame.from_map(*p) - centre).length());
                (centre, around.iter().fold(0.0, far) * 1.01 + 1e-3)
            };
            if let Some((frame, rings)) = &self.rings
                && rings.contains(disc(frame).0)
            {
                return true;
            }
            for part in &self.parts {
                let (centre, radius) = disc(&part.frame);
                let distance = part.tree.least(
                    |b| b.distance(centre),
                    |i| distance_to_line(centre, part.all[i as usize]),
                );
                if distance <= self.reach_m {
                    return true;
                }
                near |= distance <= self.reach_m + radius;
            }
        }
        if !near || large || depth == 0 {
            return near;
        }
        let quarter = |west_rad, east_rad, north_rad, south_rad| MapRect {
            west_rad,
            east_rad,
            north_rad,
            south_rad,
        };
        [
            quarter(rect.west_rad, lon, rect.north_rad, colat),
            quarter(lon, rect.east_rad, rect.north_rad, colat),
            quarter(rect.west_rad, lon, colat, rect.south_rad),
            quarter(lon, rect.east_rad, colat, rect.south_rad),
        ]
        .iter()
        .any(|q| self.boxes.iter().any(|b| b.overlaps(q)) && self.touches_within(q, depth - 1))
    }
}
