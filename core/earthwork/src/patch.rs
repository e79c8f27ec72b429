//! Places in which heights are wanted, a few at a time.

use glam::DVec2;
use relievo_planet::MapPoint;

use crate::frame::Frame;

/// A small piece of what is asked for.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Patch<'a> {
    /// Every row crossed with every column.
    Map {
        lon_rad: &'a [f64],
        colat_rad: &'a [f64],
    },
    /// Places of any order.
    Places(&'a [MapPoint]),
}

/// A patch in a frame.
#[derive(Clone, Debug, Default)]
pub(crate) struct Positions {
    pub(crate) points: Vec<DVec2>,
    pub(crate) min: DVec2,
    pub(crate) max: DVec2,
}

impl Patch<'_> {
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Map { lon_rad, colat_rad } => lon_rad.len() * colat_rad.len(),
            Self::Places(places) => places.len(),
        }
    }

    /// All places in a frame, row by row.
    pub(crate) fn positions(&self, frame: &Frame, out: &mut Positions) {
        out.points.clear();
        match self {
            Self::Map { lon_rad, colat_rad } => {
                let columns: Vec<_> = lon_rad.iter().map(|lon| frame.column(*lon)).collect();
                for colat in *colat_rad {
                    let row = frame.row(*colat);
                    out.points.extend(columns.iter().map(|c| frame.at(&row, c)));
                }
            }
            Self::Places(places) => out.points.extend(places.iter().map(|p| frame.from_map(*p))),
        }
        out.min = DVec2::INFINITY;
        out.max = DVec2::NEG_INFINITY;
        for p in &out.points {
            out.min = out.min.min(*p);
            out.max = out.max.max(*p);
        }
    }
}

impl Positions {
    /// A disc that holds all points.
    pub(crate) fn disc(&self) -> (DVec2, f64) {
        let centre = (self.min + self.max) * 0.5;
        let far = |r: f64, p: &DVec2| r.max((*p - centre).length_squared());
        (centre, self.points.iter().fold(0.0, far).sqrt())
    }
}
