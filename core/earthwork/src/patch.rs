//! Places in which heights are wanted, a few at a time.

use core::f64::consts::TAU;
use core::ops::Range;

use glam::DVec2;
use relievo_planet::MapPoint;

use crate::frame::{Frame, MapRect};

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

/// Some columns and rows of a patch; of places in any order there is one row.
#[derive(Clone, Debug)]
pub(crate) struct Window {
    pub(crate) columns: Range<usize>,
    pub(crate) rows: Range<usize>,
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

    /// All of it.
    pub(crate) fn whole(&self) -> Window {
        let (columns, rows) = match self {
            Self::Map { lon_rad, colat_rad } => (lon_rad.len(), colat_rad.len()),
            Self::Places(places) => (places.len(), 1),
        };
        Window {
            columns: 0..columns,
            rows: 0..rows,
        }
    }

    /// A window that holds all places within some rectangles of the map; places in any order are not
    /// told apart.
    pub(crate) fn window(&self, rects: impl Iterator<Item = MapRect>) -> Window {
        let Self::Map { lon_rad, colat_rad } = self else {
            return self.whole();
        };
        let (mut columns, mut rows) = (None, None);
        for rect in rects {
            let in_columns = |lon: &f64| {
                [-TAU, 0.0, TAU]
                    .iter()
                    .any(|turn| (rect.west_rad..=rect.east_rad).contains(&(lon + turn)))
            };
            let in_rows = |colat: &f64| (rect.north_rad..=rect.south_rad).contains(colat);
            let (c, r) = (span(lon_rad, in_columns), span(colat_rad, in_rows));
            if let (Some(c), Some(r)) = (c, r) {
                columns = Some(union(columns, c));
                rows = Some(union(rows, r));
            }
        }
        Window {
            columns: columns.unwrap_or(0..0),
            rows: rows.unwrap_or(0..0),
        }
    }

    /// What lies in a window of it.
    pub(crate) fn part(&self, window: &Window) -> Self {
        match self {
            Self::Map { lon_rad, colat_rad } => Self::Map {
                lon_rad: &lon_rad[window.columns.clone()],
                colat_rad: &colat_rad[window.rows.clone()],
            },
            Self::Places(places) => Self::Places(&places[window.columns.clone()]),
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

/// From the first to the last that is in.
fn span(all: &[f64], is_in: impl Fn(&f64) -> bool) -> Option<Range<usize>> {
    let first = all.iter().position(&is_in)?;
    let last = all.iter().rposition(&is_in)?;
    Some(first..last + 1)
}

fn union(a: Option<Range<usize>>, b: Range<usize>) -> Range<usize> {
    a.map_or(b.clone(), |a| a.start.min(b.start)..a.end.max(b.end))
}

impl Positions {
    /// A disc that holds all points.
    pub(crate) fn disc(&self) -> (DVec2, f64) {
        let centre = (self.min + self.max) * 0.5;
        let far = |r: f64, p: &DVec2| r.max((*p - centre).length_squared());
        (centre, self.points.iter().fold(0.0, far).sqrt())
    }
}
