//! Polygons: outlines as drawn become areas with boundaries that have heights.

mod outline;

use glam::DVec2;
use relievo_planet::{MapPoint, Planet};

use crate::check;
use crate::element::{Polygon, Side, Surface};
use crate::envelope::{Envelope, Segment};
use crate::footprint::Footprint;
use crate::frame::Frame;
use crate::infill;
use crate::prepared::GroundNeed;
use crate::rings::Rings;
use crate::solid::{AreaHeights, Interior, Part, Solid};
use crate::tin::{Corner, Tin, triangulate};
use crate::warning::{WarningKind, Warnings};
use outline::Outline;

/// A polygon that waits for heights of the ground.
#[derive(Clone, Debug)]
pub(crate) struct Draft {
    frame: Frame,
    outline: Outline,
    surface: Surface,
    side: Side,
    /// Corners whose heights come from the ground, in the order of the need.
    from_ground: Vec<u32>,
    spacing_m: f64,
}

/// Corners of a boundary that follows the ground, at most.
const MOST_CORNERS: f64 = 8_000.0;

impl Draft {
    /// Checks a polygon; `None` if there is nothing to draw.
    pub(crate) fn new(
        planet: Planet,
        polygon: &Polygon,
        side: &Side,
        warnings: &mut Warnings,
    ) -> Option<Self> {
        let mut usable = |ring: &[crate::Vertex]| -> Vec<(MapPoint, Option<f64>)> {
            ring.iter()
                .filter(|v| check::place(v.place, warnings))
                .map(|v| (v.place.normalised(), v.height_m))
                .collect()
        };
        let rings: Vec<_> = core::iter::once(&polygon.outline)
            .chain(&polygon.holes)
            .map(|r| usable(r))
            .collect();
        let is_tin = polygon.surface == Surface::Tin;
        let lines: Vec<_> = if is_tin {
            polygon.breaklines.iter().map(|l| usable(l)).collect()
        } else {
            Vec::new()
        };
        let Some(frame) = check::frame_amid(planet, rings[0].iter().map(|v| v.0)) else {
            warnings.add(WarningKind::NoExtent, None);
            return None;
        };
        let side = check::side(side, warnings);
        let mut outline = Outline::new(&frame, &rings, &lines, is_tin, warnings)?;
        let surface = checked(&polygon.surface, warnings);
        let mut spacing_m = 0.0;
        if matches!(surface, Surface::Offset { .. } | Surface::Smooth) {
            let (width, length) = outline.size_m();
            spacing_m = (f64::max(width, length) / 150.0)
                .max(outline.boundary_m() / MOST_CORNERS)
                .max(0.05);
            outline.refine(spacing_m);
        }
        let from_ground: Vec<u32> = match surface {
            Surface::Platform { .. } | Surface::Plane { .. } => Vec::new(),
            Surface::Offset { .. } | Surface::Smooth => (0..outline.corners.len() as u32).collect(),
            Surface::Tin => (0..outline.corners.len() as u32)
                .filter(|i| outline.corners[*i as usize].height_m.is_nan())
                .collect(),
        };
        if is_tin {
            let (width, length) = outline.size_m();
            spacing_m = (f64::max(width, length) / 150.0).max(0.05);
        }
        Some(Self {
            frame,
            outline,
            surface,
            side,
            from_ground,
            spacing_m,
        })
    }

    pub(crate) fn footprint(&self) -> Footprint {
        let lines = self
            .outline
            .boundary
            .iter()
            .map(|[a, b]| {
                (
                    self.outline.corners[*a as usize].at,
                    self.outline.corners[*b as usize].at,
                )
            })
            .collect();
        Footprint::new(
            vec![(self.frame, lines)],
            Some((self.frame, self.rings())),
            self.reach_m(),
        )
    }

    /// Area within the reach, about.
    pub(crate) fn area_m2(&self) -> f64 {
        let (width, length) = self.outline.size_m();
        (width + 2.0 * self.reach_m()) * (length + 2.0 * self.reach_m())
    }

    fn rings(&self) -> Rings {
        Rings::new(&self.outline.rings[0], &self.outline.rings[1..])
    }

    fn reach_m(&self) -> f64 {
        if self.side.wall || self.surface == Surface::Smooth {
            0.0
        } else {
            self.side.max_reach_m
        }
    }

    /// Heights of the ground that decide it.
    pub(crate) fn need(&self) -> Option<GroundNeed> {
        if self.from_ground.is_empty() {
            return None;
        }
        let place = |i: &u32| self.frame.to_map(self.outline.corners[*i as usize].at);
        Some(GroundNeed {
            places: self.from_ground.iter().map(place).collect(),
            spacing_m: self.spacing_m,
        })
    }

    /// The area with its heights; `ground_m` are those that [`Self::need`] asks for, all finite.
    pub(crate) fn shape(&self, ground_m: &[f64], warnings: &mut Warnings) -> Solid {
        let mut corners = self.outline.corners.clone();
        for (i, h) in self.from_ground.iter().zip(ground_m) {
            corners[*i as usize].height_m = *h;
        }
        let heights = match self.surface {
            Surface::Platform { height_m } => {
                for c in &mut corners {
                    c.height_m = height_m;
                }
                AreaHeights::Level(height_m)
            }
            Surface::Plane {
                height_m,
                slope_percent,
                aspect_deg,
            } => {
                let (sin, cos) = libm::sincos(aspect_deg.to_radians());
                let gradient = DVec2::new(sin, cos) * (-slope_percent / 100.0);
                let at = self.outline.first;
                for c in &mut corners {
                    c.height_m = height_m + gradient.dot(c.at - at);
                }
                AreaHeights::Plane {
                    at,
                    height_m,
                    gradient,
                }
            }
            Surface::Offset { offset_m } => {
                for c in &mut corners {
                    c.height_m += offset_m;
                }
                AreaHeights::Level(offset_m)
            }
            Surface::Tin => self.triangles(&corners, warnings),
            Surface::Smooth => {
                match infill::membrane(
                    &corners,
                    &self.outline.boundary,
                    &self.rings(),
                    self.spacing_m,
                ) {
                    Some(tin) => AreaHeights::Tin(tin),
                    None => self.triangles(&corners, warnings),
                }
            }
        };
        let segments: Vec<Segment> = self
            .outline
            .boundary
            .iter()
            .map(|[a, b]| {
                let (a, b) = (corners[*a as usize], corners[*b as usize]);
                Segment {
                    from: a.at,
                    to: b.at,
                    from_m: a.height_m,
                    to_m: b.height_m,
                }
            })
            .collect();
        let slopes = (!self.side.wall && self.surface != Surface::Smooth)
            .then_some((self.side.cut_slope, self.side.fill_slope));
        if let Some((cut, fill)) = slopes {
            for s in segments.iter().filter(|s| s.grade() >= cut.min(fill)) {
                warnings.add(
                    WarningKind::SteeperThanSide,
                    Some(self.frame.to_map((s.from + s.to) * 0.5)),
                );
            }
        }
        let (width_m, length_m) = self.outline.size_m();
        Solid {
            parts: vec![Part {
                frame: self.frame,
                interior: Interior::Area {
                    rings: self.rings(),
                    heights,
                },
                envelope: Envelope::new(&segments, slopes),
            }],
            slopes,
            reach_m: self.reach_m(),
            raises: true,
            lowers: true,
            on_ground: matches!(self.surface, Surface::Offset { .. }),
            width_m,
            length_m,
            mean_above_edge_m: 0.0,
        }
    }

    fn triangles(&self, corners: &[Corner], warnings: &mut Warnings) -> AreaHeights {
        let at: Vec<DVec2> = corners.iter().map(|c| c.at).collect();
        let lines: Vec<[usize; 2]> = self
            .outline
            .boundary
            .iter()
            .chain(&self.outline.breaks)
            .map(|line| line.map(|k| k as usize))
            .collect();
        match triangulate(&at, &lines) {
            Some((triangles, dropped)) => {
                for _ in 0..dropped {
                    warnings.add(WarningKind::BreaklineDropped, None);
                }
                AreaHeights::Tin(Tin::new(corners, &triangles))
            }
            None => AreaHeights::Level(corners.first().map_or(0.0, |c| c.height_m)),
        }
    }
}

fn checked(surface: &Surface, warnings: &mut Warnings) -> Surface {
    let mut height = |h| check::number(h, &check::HEIGHTS_M, 0.0, warnings);
    match *surface {
        Surface::Platform { height_m } => Surface::Platform {
            height_m: height(height_m),
        },
        Surface::Plane {
            height_m,
            slope_percent,
            aspect_deg,
        } => Surface::Plane {
            height_m: height(height_m),
            slope_percent: check::number(slope_percent, &(0.0..=10_000.0), 0.0, warnings),
            aspect_deg: check::number(aspect_deg, &(-1e6..=1e6), 0.0, warnings),
        },
        Surface::Offset { offset_m } => Surface::Offset {
            offset_m: height(offset_m),
        },
        Surface::Tin => Surface::Tin,
        Surface::Smooth => Surface::Smooth,
    }
}
