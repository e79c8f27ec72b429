//! Lists of vertices as JSON: an array of `[longitude, latitude]` or `[longitude, latitude, height]`,
//! or a reference to a file beside the project.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::{Value, json};

use super::fault::{At, Fault, describe};
use super::range;
use super::value::{Fields as _, InRange as _, Stored, object};
use crate::{ContentHash, SideFile, Vertex, Vertices};

fields! {
    /// A list of vertices that lies in a file beside the project.
    InFile {
        /// BLAKE3 hash of the file, which is also its name.
        file: String,
        /// How many vertices it holds.
        vertices: u32 = MOST,
    }
}

const MOST: range::Range<u32> = range::Range {
    min: 0,
    max: range::MOST_VERTICES as u32,
};

/// A list of vertices as it is stored.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct StoredVertices(pub(crate) Vertices);

impl Stored for StoredVertices {
    fn read(value: Value, at: &At<'_>) -> Result<Self, Fault> {
        let items = match value {
            Value::Array(items) => items,
            Value::Object(_) => return in_file(value, at),
            Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {
                return Err(at.fault("an array of vertices or a file", describe(&value)));
            }
        };
        if items.len() > range::MOST_VERTICES {
            let most = format!("at most {} vertices", range::MOST_VERTICES);
            return Err(at.fault(most, items.len().to_string()));
        }
        let vertices = items.iter().enumerate();
        let vertices: Vec<Vertex> = vertices
            .map(|(i, item)| vertex(item, &At::Element(at, i)))
            .collect::<Result<_, _>>()?;
        Ok(Self(Vertices::from(vertices)))
    }

    fn write(&self) -> Value {
        if let Some(side_file) = self.0.missing() {
            return json!({
                "file": side_file.hash.to_string(),
                "vertices": side_file.vertices,
            });
        }
        let write = |vertex: &Vertex| -> Value {
            let place = [vertex.lon_deg, vertex.lat_deg];
            place
                .iter()
                .chain(&vertex.height_m)
                .map(Stored::write)
                .collect()
        };
        self.0.iter().map(write).collect()
    }
}

fn in_file(value: Value, at: &At<'_>) -> Result<StoredVertices, Fault> {
    let mut map = object(value, at)?;
    let fields = InFile::take(&mut map, at)?;
    if let Some(name) = map.keys().next() {
        return Err(At::Member(at, name).fault("\"file\" and \"vertices\" alone", "another member"));
    }
    let hash = ContentHash::from_hex(&fields.file).ok_or_else(|| {
        let expected = "64 lower-case hexadecimal digits";
        At::Member(at, "file").fault(expected, super::fault::quote(&fields.file))
    })?;
    Ok(StoredVertices(Vertices::elsewhere(SideFile {
        hash,
        vertices: fields.vertices,
    })))
}

fn vertex(item: &Value, at: &At<'_>) -> Result<Vertex, Fault> {
    const EXPECTED: &str = "[longitude, latitude] in degrees, or with a height in metres";
    let numbers = match item.as_array().map(Vec::as_slice) {
        Some([lon, lat] | [lon, lat, Value::Null]) => (lon.as_f64(), lat.as_f64(), Some(None)),
        Some([lon, lat, height]) => (lon.as_f64(), lat.as_f64(), height.as_f64().map(Some)),
        _ => return Err(at.fault(EXPECTED, describe(item))),
    };
    let (Some(lon_deg), Some(lat_deg), Some(height_m)) = numbers else {
        return Err(at.fault(EXPECTED, item.to_string()));
    };
    let vertex = Vertex {
        lon_deg,
        lat_deg,
        height_m,
    };
    check_vertex(&vertex, at)?;
    Ok(vertex)
}

fn check_vertex(vertex: &Vertex, at: &At<'_>) -> Result<(), Fault> {
    vertex
        .lon_deg
        .check(&range::TURN_DEG, &At::Element(at, 0))?;
    vertex
        .lat_deg
        .check(&range::LATITUDE_DEG, &At::Element(at, 1))?;
    vertex.height_m.check(&range::HEIGHT_M, &At::Element(at, 2))
}

/// Checks a list by the reader's rules, without the detour through JSON that long lists would pay for.
pub(crate) fn check(vertices: &Vertices, at: &At<'_>) -> Result<(), Fault> {
    let length = vertices.len();
    if length > range::MOST_VERTICES {
        let most = format!("at most {} vertices", range::MOST_VERTICES);
        return Err(at.fault(most, length.to_string()));
    }
    let mut vertices = vertices.iter().enumerate();
    vertices.try_for_each(|(i, vertex)| check_vertex(vertex, &At::Element(at, i)))
}

impl JsonSchema for StoredVertices {
    fn schema_name() -> Cow<'static, str> {
        "Vertices".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let number = |range: range::Range<f64>| json!({ "type": "number", "minimum": range.min, "maximum": range.max });
        let mut height = number(range::HEIGHT_M);
        height["type"] = json!(["number", "null"]);
        let file = generator.subschema_for::<InFile>();
        json_schema!({
            "description": "Vertices: longitude and latitude in degrees, and a height in metres above the datum where there is one.",
            "anyOf": [
                {
                    "type": "array",
                    "items": {
                        "type": "array",
                        "prefixItems": [number(range::TURN_DEG), number(range::LATITUDE_DEG), height],
                        "minItems": 2,
                        "maxItems": 3,
                    },
                },
                file,
            ],
        })
    }
}
