//! A colour as JSON: `#rrggbb`.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::Value;

use super::fault::{At, Fault, describe};
use super::value::Stored;

/// sRGB red, green, blue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StoredColour(pub(crate) [u8; 3]);

impl StoredColour {
    /// From `#rrggbb`.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let digits = text
            .strip_prefix('#')
            .filter(|d| d.len() == 6 && d.bytes().all(|b| b.is_ascii_hexdigit()))?;
        let [_, red, green, blue] = u32::from_str_radix(digits, 16).ok()?.to_be_bytes();
        Some(Self([red, green, blue]))
    }
}

impl Stored for StoredColour {
    fn read(value: Value, at: &At<'_>) -> Result<Self, Fault> {
        let colour = value.as_str().and_then(Self::parse);
        colour.ok_or_else(|| at.fault("a colour \"#rrggbb\"", describe(&value)))
    }

    fn write(&self) -> Value {
        let [red, green, blue] = self.0;
        format!("#{red:02x}{green:02x}{blue:02x}").into()
    }
}

impl JsonSchema for StoredColour {
    fn schema_name() -> Cow<'static, str> {
        "Colour".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "sRGB red, green, blue.",
            "type": "string",
            "pattern": "^#[0-9A-Fa-f]{6}$",
        })
    }
}
