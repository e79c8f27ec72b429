//! Days as they lie in version 1 of the file.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::Value;

use super::fault::{At, Fault, describe};
use super::range;
use super::value::Stored;
use crate::{Date, parse_date};

/// A day.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StoredDate(pub(crate) Date);

impl Stored for StoredDate {
    fn read(value: Value, at: &At<'_>) -> Result<Self, Fault> {
        let date = value.as_str().and_then(parse_date);
        date.map(Self)
            .ok_or_else(|| at.fault("a day as \"2015-09-26\"", describe(&value)))
    }

    fn write(&self) -> Value {
        self.0.to_string().into()
    }
}

impl JsonSchema for StoredDate {
    fn schema_name() -> Cow<'static, str> {
        "Date".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "string", "format": "date", "pattern": r"^\d{4}-\d{2}-\d{2}$" })
    }
}

fields! {
    /// A layer's place in a series of pictures of one ground at different times, of which one is shown.
    Dated {
        /// What layers of one series have in common.
        #[schemars(length(min = 1, max = range::LONGEST_NAME))]
        series: String,
        /// The day that the layer shows.
        date: StoredDate,
    }
}
