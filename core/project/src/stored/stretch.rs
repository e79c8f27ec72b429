//! How stored numbers of an image become colours, as JSON: a name, or what is shown as black and white.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::{Value, json};

use super::fault::{At, Fault, describe};
use super::value::Stored;
use crate::Stretch;

const EXPECTED: &str = "\"auto\", \"full\", \"min_max\", {\"percentile\": [low, high]} from 0 to 100, or \
                        {\"range\": [black, white]}";

/// A stretch as it is stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StoredStretch(pub(crate) Stretch);

impl Stored for StoredStretch {
    fn read(value: Value, at: &At<'_>) -> Result<Self, Fault> {
        let named = match value.as_str() {
            Some("auto") => Some(Stretch::Auto),
            Some("full") => Some(Stretch::Full),
            Some("min_max") => Some(Stretch::MinMax),
            _ => None,
        };
        let two = |name: &str| -> Option<(f64, f64)> {
            let object = value.as_object().filter(|o| o.len() == 1)?;
            let [low, high] = object.get(name)?.as_array()?.as_slice() else {
                return None;
            };
            Some((low.as_f64()?, high.as_f64()?))
        };
        let percentile = || {
            two("percentile")
                .filter(|(low, high)| *low >= 0.0 && low < high && *high <= 100.0)
                .map(|(low, high)| Stretch::Percentile { low, high })
        };
        let range = || {
            two("range")
                .filter(|(black, white)| black != white)
                .map(|(black, white)| Stretch::Range { black, white })
        };
        named
            .or_else(percentile)
            .or_else(range)
            .map(Self)
            .ok_or_else(|| at.fault(EXPECTED, describe(&value)))
    }

    fn write(&self) -> Value {
        match self.0 {
            Stretch::Auto => "auto".into(),
            Stretch::Full => "full".into(),
            Stretch::MinMax => "min_max".into(),
            Stretch::Percentile { low, high } => json!({ "percentile": [low, high] }),
            Stretch::Range { black, white } => json!({ "range": [black, white] }),
        }
    }
}

impl JsonSchema for StoredStretch {
    fn schema_name() -> Cow<'static, str> {
        "Stretch".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let two = |name: &str, item: Value| {
            json!({
                "type": "object",
                "properties": { name: { "type": "array", "items": item, "minItems": 2, "maxItems": 2 } },
                "required": [name],
                "additionalProperties": false,
            })
        };
        json_schema!({
            "description": "How stored numbers become colours: auto (8-bit ones as they are, others between their 2nd and 98th percentile), the full range of their type, from the lowest to the highest, between two percentiles, or between the stored values shown as black and white.",
            "anyOf": [
                { "enum": ["auto", "full", "min_max"] },
                two("percentile", json!({ "type": "number", "minimum": 0.0, "maximum": 100.0 })),
                two("range", json!({ "type": "number" })),
            ],
        })
    }
}
