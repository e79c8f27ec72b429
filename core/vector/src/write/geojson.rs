//! GeoJSON (RFC 7946).

use std::io::Write;
use std::path::Path;

use geojson::{Feature as JsonFeature, GeometryValue, JsonObject, Position as JsonPosition};
use serde_json::Value as Json;

use super::{Feature, Geometry, Position, closed, cut, finite, io_fault, whole};
use crate::error::Fault;
use crate::{Value, VectorError};

/// The text of a GeoJSON file: a collection, a line for each feature.
///
/// # Errors
/// One line where a coordinate is not a number.
pub fn to_geojson(features: &[Feature]) -> Result<String, String> {
    text(features).map_err(|e| e.to_string())
}

/// Writes a GeoJSON file, replacing what has its name.
///
/// # Errors
/// [`VectorError`] where it cannot be written or a coordinate is not a number.
pub fn write_geojson(path: &Path, features: &[Feature]) -> Result<(), VectorError> {
    whole("GeoJSON", path, |file| {
        let text = text(features)?;
        file.write_all(text.as_bytes()).map_err(|e| io_fault(&e))
    })
}

fn text(features: &[Feature]) -> Result<String, Fault> {
    finite(features)?;
    let mut text = String::from("{\"type\":\"FeatureCollection\",\"features\":[");
    for (i, feature) in features.iter().enumerate() {
        text.push_str(if i == 0 { "\n" } else { ",\n" });
        text.push_str(&json(feature).to_string());
    }
    text.push_str("\n]}\n");
    Ok(text)
}

fn json(feature: &Feature) -> JsonFeature {
    let position = |p: &Position| match p.height_m {
        Some(height_m) => JsonPosition::from([p.lon_deg, p.lat_deg, height_m]),
        None => JsonPosition::from([p.lon_deg, p.lat_deg]),
    };
    let line = |line: &Vec<Position>| line.iter().map(position).collect::<Vec<_>>();
    let polygon = |rings: &Vec<Vec<Position>>| {
        let rings = rings.iter().enumerate();
        rings
            .map(|(i, ring)| line(&closed(ring, i > 0)))
            .collect::<Vec<_>>()
    };
    let value = match &*cut::within(&feature.geometry) {
        Geometry::Points(points) => match &points[..] {
            [only] => GeometryValue::Point {
                coordinates: position(only),
            },
            _ => GeometryValue::MultiPoint {
                coordinates: points.iter().map(position).collect(),
            },
        },
        Geometry::Lines(lines) => match &lines[..] {
            [only] => GeometryValue::LineString {
                coordinates: line(only),
            },
            _ => GeometryValue::MultiLineString {
                coordinates: lines.iter().map(line).collect(),
            },
        },
        Geometry::Polygons(polygons) => match &polygons[..] {
            [only] => GeometryValue::Polygon {
                coordinates: polygon(only),
            },
            _ => GeometryValue::MultiPolygon {
                coordinates: polygons.iter().map(polygon).collect(),
            },
        },
    };
    let mut properties = JsonObject::new();
    for (name, value) in &feature.properties {
        let value = match value {
            Value::Null => Json::Null,
            Value::Bool(v) => Json::from(*v),
            Value::Int(v) => Json::from(*v),
            // NaN and infinities become null.
            Value::Float(v) => Json::from(*v),
            Value::Text(v) => Json::from(&**v),
        };
        properties.insert(name.clone(), value);
    }
    JsonFeature {
        geometry: Some(value.into()),
        properties: Some(properties),
        ..JsonFeature::default()
    }
}
