//! Lengths and areas of what is being drawn, along geodesics of the planet's ellipsoid.

use relievo_engine::Measure;
use relievo_engine::planet::MapPoint;

use super::{Tool, view};
use crate::window::status::{area, length};
use crate::window::studio::Studio;

impl Studio {
    /// What the draft of the measuring tool measures, as one line; `None` before there is a way.
    pub fn measured(&self) -> Option<String> {
        if self.tools.tool != Tool::Measure {
            return None;
        }
        let draft = self.tools.draft.iter().chain(&self.tools.next);
        let mut places: Vec<MapPoint> = draft.map(view::place).collect();
        places.dedup();
        let last = places.last_chunk::<2>()?;
        let measure = Measure::new(&self.document.project().planet.body.figure());
        let way_m = measure.length_m(&places);
        let mut text = length(way_m);
        if places.len() > 2 {
            let leg_m = measure.distance_m(last[0], last[1]);
            let ring = measure.area(&[places]);
            text = format!(
                "{text}, last {}, closed {}",
                length(leg_m),
                area(ring.area_m2)
            );
        }
        Some(text)
    }
}
