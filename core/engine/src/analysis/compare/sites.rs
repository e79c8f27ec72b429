//! The areas in which something may change.

use relievo_analysis::MapBox;
use relievo_planet::Planet;

use crate::analysis::extent::Extent;

/// Where something may change.
#[derive(Clone, Copy, Debug)]
pub(in crate::analysis) struct Site {
    pub(in crate::analysis) area: MapBox,
    /// Smallest width in metres that decides a volume there.
    pub(super) width_m: f64,
}

impl Site {
    pub(super) fn of(extent: &Extent, planet: &Planet) -> Self {
        // The sphere's angle is up to 1/2 % off on the ellipsoid; extents are drawn 1 % too large.
        Self {
            area: MapBox::around(extent.centre, extent.radius_m / planet.radius_m),
            width_m: extent.width_m,
        }
    }

    /// One site that holds both.
    pub(super) fn joined(&self, other: &Self) -> Self {
        Self {
            area: self.area.joined(&other.area),
            width_m: self.width_m.min(other.width_m),
        }
    }

    pub(super) fn meets(&self, other: &Self) -> bool {
        !self.area.shared(&other.area).is_empty()
    }

    /// The parts of it that lie within bounds.
    pub(super) fn within(&self, bounds: Option<&MapBox>) -> Vec<Self> {
        let Some(bounds) = bounds else {
            return vec![*self];
        };
        let parts = bounds.shared(&self.area).into_iter();
        parts.map(|area| Self { area, ..*self }).collect()
    }
}

/// Sites that hold all and share nothing: what is measured in one is not in another.
pub(super) fn apart(sites: impl IntoIterator<Item = Site>) -> Vec<Site> {
    let mut apart: Vec<Site> = Vec::new();
    for mut site in sites {
        while let Some(index) = apart.iter().position(|other| site.meets(other)) {
            site = site.joined(&apart.swap_remove(index));
        }
        apart.push(site);
    }
    apart
}
