//! GeoJSON (RFC 7946, and the older form with a `crs` member).

use std::path::Path;

use core::fmt;

use geojson::{Geometry, GeometryValue, Position};
use serde::Deserialize;
use serde::de::{DeserializeSeed, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde_json::Value as Json;

use crate::error::{Fault, damaged, unsupported};
use crate::features::{Builder, Features, Shape};
use crate::open::{OpenOptions, Summary, system};
use crate::value::Value;

/// What decides how the rest is read.
#[derive(Deserialize)]
struct Head {
    r#type: Option<String>,
    crs: Option<Json>,
}

/// One feature. The crate's own type collects foreign members, which costs most of the time.
#[derive(Deserialize)]
struct Feature {
    geometry: Option<Geometry>,
    properties: Option<serde_json::Map<String, Json>>,
    id: Option<Json>,
}

pub(crate) fn read(path: &Path, options: &OpenOptions) -> Result<(Features, Summary), Fault> {
    let bytes = std::fs::read(path)?;
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(&bytes);
    let head: Head = serde_json::from_slice(text).map_err(|e| json(&e))?;
    let mut remarks = Vec::new();
    let own = match &head.crs {
        None | Some(Json::Null) => Some("EPSG:4326".to_owned()),
        Some(crs) => Some(named(crs)?),
    };
    let (crs, name) = system(options, own, &mut remarks)?;
    let mut builder = Builder::new(crs, options.limits, options.cancel.clone());
    match head.r#type.as_deref() {
        Some("FeatureCollection") => {
            let mut fault = None;
            let seed = Collection {
                builder: &mut builder,
                fault: &mut fault,
            };
            let mut json_text = serde_json::Deserializer::from_slice(text);
            let read = seed.deserialize(&mut json_text);
            if let Some(fault) = fault {
                return Err(fault);
            }
            read.map_err(|e| json(&e))?;
        }
        Some("Feature") => {
            let feature: Feature = serde_json::from_slice(text).map_err(|e| json(&e))?;
            add_feature(&mut builder, &feature)?;
        }
        Some(
            "Point" | "MultiPoint" | "LineString" | "MultiLineString" | "Polygon" | "MultiPolygon"
            | "GeometryCollection",
        ) => {
            let geometry: Geometry = serde_json::from_slice(text).map_err(|e| json(&e))?;
            add_geometry(&mut builder, &geometry)?;
            builder.end_feature()?;
        }
        Some(other) => {
            return unsupported(format!(
                "expected a FeatureCollection, a Feature or a geometry, found type {other:?}"
            ));
        }
        None => return unsupported("expected a member \"type\" of GeoJSON, found none"),
    }
    let summary = Summary {
        format: "GeoJSON",
        crs: name,
        layers: Vec::new(),
        remarks,
    };
    Ok((builder.end()?, summary))
}

fn json(error: &serde_json::Error) -> Fault {
    Fault::Damaged(error.to_string())
}

/// The system that a `crs` member names.
fn named(crs: &Json) -> Result<String, Fault> {
    let name = crs.pointer("/properties/name").and_then(Json::as_str);
    let Some(name) = name else {
        return unsupported("expected a coordinate system by name, found a crs member without one");
    };
    if name.ends_with("CRS84") || name.ends_with("CRS83") || name.ends_with("CRS84h") {
        return Ok("EPSG:4326".to_owned());
    }
    // urn:ogc:def:crs:EPSG::26912, EPSG:26912, http://www.opengis.net/def/crs/EPSG/0/26912
    let mut words = name.split([':', '/']).filter(|w| !w.is_empty());
    let authority = words.find(|w| matches!(*w, "EPSG" | "ESRI" | "epsg" | "esri"));
    let code = words.next_back();
    match (authority, code) {
        (Some(authority), Some(code)) => Ok(format!("{}:{code}", authority.to_uppercase())),
        _ => Ok(name.to_owned()),
    }
}

/// Reads the features of a collection one after the other.
struct Collection<'a> {
    builder: &'a mut Builder,
    /// Why reading stopped, where it was not the text.
    fault: &'a mut Option<Fault>,
}

impl<'de> DeserializeSeed<'de> for Collection<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for Collection<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a FeatureCollection")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        while let Some(key) = map.next_key::<String>()? {
            if key == "features" {
                map.next_value_seed(List {
                    builder: self.builder,
                    fault: self.fault,
                })?;
            } else {
                map.next_value::<IgnoredAny>()?;
            }
        }
        Ok(())
    }
}

struct List<'a> {
    builder: &'a mut Builder,
    fault: &'a mut Option<Fault>,
}

impl<'de> DeserializeSeed<'de> for List<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for List<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a list of features")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<(), A::Error> {
        while let Some(feature) = list.next_element::<Feature>()? {
            if let Err(fault) = add_feature(self.builder, &feature) {
                let text = fault.to_string();
                *self.fault = Some(fault);
                return Err(serde::de::Error::custom(text));
            }
        }
        Ok(())
    }
}

fn add_feature(builder: &mut Builder, feature: &Feature) -> Result<(), Fault> {
    if let Some(geometry) = &feature.geometry {
        add_geometry(builder, geometry)?;
    }
    if let Some(id) = &feature.id {
        builder.add_property("id", value(id))?;
    }
    for (name, property) in feature.properties.iter().flatten() {
        // A property of that name wins over the member beside it.
        if name == "id" && feature.id.is_some() {
            continue;
        }
        builder.add_property(name, value(property))?;
    }
    builder.end_feature()
}

fn value(json: &Json) -> Value {
    match json {
        Json::Null => Value::Null,
        Json::Bool(v) => Value::Bool(*v),
        Json::Number(v) => match (v.as_i64(), v.as_f64()) {
            (Some(v), _) => Value::Int(v),
            (None, Some(v)) => Value::Float(v),
            (None, None) => Value::Null,
        },
        Json::String(v) => Value::from(v.as_str()),
        Json::Array(_) | Json::Object(_) => Value::from(json.to_string().as_str()),
    }
}

fn add_geometry(builder: &mut Builder, geometry: &Geometry) -> Result<(), Fault> {
    match &geometry.value {
        GeometryValue::Point { coordinates } => {
            builder.add(Shape::Points, positions(std::slice::from_ref(coordinates))?)
        }
        GeometryValue::MultiPoint { coordinates } => {
            builder.add(Shape::Points, positions(coordinates)?)
        }
        GeometryValue::LineString { coordinates } => {
            builder.add(Shape::Line, positions(coordinates)?)
        }
        GeometryValue::MultiLineString { coordinates } => coordinates
            .iter()
            .try_for_each(|line| builder.add(Shape::Line, positions(line)?)),
        GeometryValue::Polygon { coordinates } => polygon(builder, coordinates),
        GeometryValue::MultiPolygon { coordinates } => {
            coordinates.iter().try_for_each(|p| polygon(builder, p))
        }
        GeometryValue::GeometryCollection { geometries } => {
            geometries.iter().try_for_each(|g| add_geometry(builder, g))
        }
    }
}

fn polygon(builder: &mut Builder, rings: &[Vec<Position>]) -> Result<(), Fault> {
    for (i, ring) in rings.iter().enumerate() {
        let shape = if i == 0 { Shape::Outer } else { Shape::Hole };
        builder.add(shape, positions(ring)?)?;
    }
    Ok(())
}

/// First and second coordinates.
fn positions(list: &[Position]) -> Result<impl Iterator<Item = [f64; 2]>, Fault> {
    if let Some(short) = list.iter().find(|p| p.as_slice().len() < 2) {
        return damaged(format!(
            "expected positions of two or three numbers, found {}",
            short.as_slice().len()
        ));
    }
    Ok(list.iter().map(|p| [p.as_slice()[0], p.as_slice()[1]]))
}
