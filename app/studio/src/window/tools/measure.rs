//! Lengths and areas of what is being drawn, along geodesics of the planet's ellipsoid.

use relievo_engine::Measure;
use relievo_engine::planet::MapPoint;

use super::{Tool, view};
use crate::window::status::length;
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

/// An area for people: square metres below a square kilometre.
fn area(square_m: f64) -> String {
    match square_m {
        a if a < 1e4 => format!("{a:.1} m²"),
        a if a < 1e6 => format!("{:.2} ha", a / 1e4),
        a if a < 1e9 => format!("{:.2} km²", a / 1e6),
        a => format!("{:.0} km²", a / 1e6),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_take_the_unit_that_reads_best() {
        assert_eq!(area(12.34), "12.3 m²");
        assert_eq!(area(25_000.0), "2.50 ha");
        assert_eq!(area(3_456_000.0), "3.46 km²");
        assert_eq!(area(5.1e14), "510000000 km²");
    }
}
