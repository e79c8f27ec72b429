//! Lines as GeoJSON (RFC 7946), cut at the antimeridian.

use core::f64::consts::{PI, TAU};

use relievo_engine::analysis::ContourLine;
use relievo_engine::planet::MapPoint;
use serde_json::{Value, json};

/// Lines as features of a collection, each with the properties that `of` gives it.
pub(super) fn collection(lines: &[ContourLine], of: impl Fn(&ContourLine) -> Value) -> Value {
    let features: Vec<Value> = lines
        .iter()
        .map(|line| {
            let mut parts = cut(line);
            let geometry = if parts.len() == 1 {
                json!({ "type": "LineString", "coordinates": parts.pop() })
            } else {
                json!({ "type": "MultiLineString", "coordinates": parts })
            };
            json!({ "type": "Feature", "properties": of(line), "geometry": geometry })
        })
        .collect();
    json!({ "type": "FeatureCollection", "features": features })
}

/// The parts of a line on each side of the antimeridian, in degrees; a ring ends where it begins.
fn cut(line: &ContourLine) -> Vec<Vec<[f64; 2]>> {
    let mut points: Vec<MapPoint> = line.points.clone();
    if let (true, Some(first), Some(last)) = (line.closed, line.points.first(), line.points.last())
    {
        let turns = ((last.lon_rad - first.lon_rad) / TAU).round();
        points.push(MapPoint::new(first.lon_rad + turns * TAU, first.colat_rad));
    }
    let mut parts = Vec::new();
    let mut part: Vec<[f64; 2]> = Vec::new();
    // The turn that the part lies in.
    let turn_of = |lon_rad: f64| ((lon_rad + PI) / TAU).floor();
    let mut turn = f64::NAN;
    let degrees = |lon_rad: f64, colat_rad: f64, turn: f64| {
        let lon_deg = (lon_rad - turn * TAU).to_degrees().clamp(-180.0, 180.0);
        [round(lon_deg), round(90.0 - colat_rad.to_degrees())]
    };
    let mut before: Option<MapPoint> = None;
    for point in points {
        let next = turn_of(point.lon_rad);
        if let Some(from) = before
            && next != turn
        {
            let edge_rad = next.max(turn) * TAU - PI;
            let share = (edge_rad - from.lon_rad) / (point.lon_rad - from.lon_rad);
            let colat_rad = from.colat_rad + (point.colat_rad - from.colat_rad) * share;
            part.push(degrees(edge_rad, colat_rad, turn));
            parts.push(std::mem::take(&mut part));
            part.push(degrees(edge_rad, colat_rad, next));
        }
        turn = next;
        part.push(degrees(point.lon_rad, point.colat_rad, turn));
        before = Some(point);
    }
    if part.len() > 1 || parts.is_empty() {
        parts.push(part);
    }
    parts
}

/// To 10⁻⁹ degrees, 0.1 mm on the Earth.
fn round(degrees: f64) -> f64 {
    (degrees * 1e9).round() / 1e9
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(points: &[[f64; 2]], closed: bool) -> ContourLine {
        ContourLine {
            height_m: 5.0,
            points: points
                .iter()
                .map(|p| MapPoint::from_degrees(p[0], p[1]))
                .collect(),
            closed,
        }
    }

    #[test]
    fn a_line_across_the_antimeridian_is_cut_there() {
        let parts = cut(&line(&[[179.0, 0.0], [181.0, 2.0]], false));
        assert_eq!(
            parts,
            [[[179.0, 0.0], [180.0, 1.0]], [[-180.0, 1.0], [-179.0, 2.0]]]
        );
    }

    #[test]
    fn a_ring_ends_where_it_begins_and_one_around_a_pole_once_around() {
        let ring = cut(&line(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], true));
        assert_eq!(ring, [[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]]);
        let around = cut(&line(
            &[[-90.0, 80.0], [0.0, 80.0], [90.0, 80.0], [180.0, 80.0]],
            true,
        ));
        let lengths: Vec<_> = around.iter().map(Vec::len).collect();
        assert_eq!(lengths.len(), 2);
        assert_eq!(around[0][0], [-90.0, 80.0]);
        assert_eq!(*around[1].last().unwrap(), [-90.0, 80.0]);
    }
}
