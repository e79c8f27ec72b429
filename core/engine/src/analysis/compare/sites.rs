//! Where something may change, and where that is narrow.

use relievo_analysis::MapBox;
use relievo_earthwork::{MapIndex, MapRect};

/// Samples across what is narrow, to begin with.
const ACROSS: f64 = 4.0;

/// Areas that hold all and share nothing: what is measured in one is not in another.
pub(super) fn apart(areas: impl IntoIterator<Item = MapBox>) -> Vec<MapBox> {
    let mut apart: Vec<MapBox> = Vec::new();
    for mut area in areas {
        while let Some(index) = apart.iter().position(|other| meet(&area, other)) {
            area = area.joined(&apart.swap_remove(index));
        }
        apart.push(area);
    }
    apart
}

pub(super) fn meet(one: &MapBox, other: &MapBox) -> bool {
    !one.shared(other).is_empty()
}

/// How wide elements are, anywhere.
pub(super) struct Widths {
    index: MapIndex,
    widths_m: Vec<f64>,
}

impl Widths {
    pub(super) fn new(areas: &[(MapBox, f64)]) -> Self {
        let rects: Vec<MapRect> = areas.iter().map(|(area, _)| rect(area)).collect();
        Self {
            index: MapIndex::new(rects.iter().map(core::slice::from_ref)),
            widths_m: areas.iter().map(|(_, width_m)| *width_m).collect(),
        }
    }

    /// How far apart samples may lie in an area so that nothing is missed, metres; infinite where no
    /// element is.
    pub(super) fn spacing_m(&self, area: &MapBox) -> f64 {
        let widths = self.index.touching(&rect(area)).into_iter();
        let widths = widths.map(|i| self.widths_m[i as usize]);
        widths.fold(f64::INFINITY, f64::min) / ACROSS
    }
}

fn rect(area: &MapBox) -> MapRect {
    MapRect {
        west_rad: area.west_rad,
        east_rad: area.east_rad,
        north_rad: area.north_colat_rad,
        south_rad: area.south_colat_rad,
    }
}
