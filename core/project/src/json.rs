//! Projects and edits as text.

use std::path::Path;

use serde::de::{Deserialize, Deserializer, Error as _};
use serde::ser::{Serialize, Serializer};
use serde_json::Value;

use crate::stored::convert::Twin as _;
use crate::stored::edits::StoredEdit;
use crate::stored::fault::{At, Fault};
use crate::stored::value::{Stored as _, With, object};
use crate::stored::{migrate, parse, v1};
use crate::{Edit, OpenProjectError, Project};

/// Largest file that is read, in bytes (64 MiB).
pub const MOST_BYTES: usize = 64 << 20;

impl Project {
    /// Reads a project's text; `path` only names the file in errors.
    ///
    /// # Errors
    /// Where the text is not JSON, not a project, of a newer version, or a value does not fit; each
    /// with its place.
    pub fn from_json(text: &str, path: &Path) -> Result<Self, OpenProjectError> {
        let value = parse_within_limit(text, path)?;
        Self::from_value(value).map_err(|problem| match problem {
            Problem::Fault(fault) => OpenProjectError::invalid(text, fault, path),
            Problem::Newer { found } => OpenProjectError::NewerVersion {
                supported: v1::VERSION,
                found,
                path: path.to_owned(),
            },
        })
    }

    fn from_value(value: Value) -> Result<Self, Problem> {
        let members = object(value, &At::Root)?;
        let version = match members.get("version") {
            None => return Err(At::Root.fault("a member \"version\"", "none").into()),
            Some(value) => u32::read(value.clone(), &At::Member(&At::Root, "version"))?,
        };
        if version == 0 {
            return Err(At::Member(&At::Root, "version")
                .fault("1 or more", "0")
                .into());
        }
        if version > v1::VERSION {
            return Err(Problem::Newer { found: version });
        }
        let members = migrate::to_current(version, members);
        let stored = With::<v1::Project>::read(Value::Object(members), &At::Root)?;
        Ok(Self::from_stored(stored, &At::Root)?)
    }

    /// The canonical text: members in the order of the format, unknown ones behind them, two spaces
    /// of indent, shortest numbers that read back the same, defaults left out, LF, one at the end.
    ///
    /// Lists of more than 10 000 vertices, and the longest others where there are too many, are
    /// references to files that saving writes: see [`side_folder`](crate::side_folder).
    pub fn to_json(&self) -> String {
        self.apart().0.text()
    }

    /// The text of a project whose long lists are references already.
    pub(crate) fn text(&self) -> String {
        pretty(&self.to_stored().write())
    }
}

/// A value as canonical text.
fn pretty(value: &Value) -> String {
    let mut text = String::new();
    write_value(value, 0, false, &mut text);
    text.push('\n');
    text
}

/// Writes a value with two spaces of indent, one element a line; numbers of an array within an array
/// (a vertex) share a line.
fn write_value(value: &Value, depth: usize, in_array: bool, text: &mut String) {
    let line = |text: &mut String, depth: usize| {
        text.push('\n');
        text.extend(core::iter::repeat_n("  ", depth));
    };
    match value {
        Value::Array(items) if items.is_empty() => text.push_str("[]"),
        Value::Array(items) if in_array && items.iter().all(Value::is_number) => {
            text.push('[');
            for (i, item) in items.iter().enumerate() {
                text.push_str(if i == 0 { "" } else { ", " });
                write_value(item, depth, true, text);
            }
            text.push(']');
        }
        Value::Array(items) => {
            text.push('[');
            for (i, item) in items.iter().enumerate() {
                text.push_str(if i == 0 { "" } else { "," });
                line(text, depth + 1);
                write_value(item, depth + 1, true, text);
            }
            line(text, depth);
            text.push(']');
        }
        Value::Object(members) if members.is_empty() => text.push_str("{}"),
        Value::Object(members) => {
            text.push('{');
            for (i, (name, member)) in members.iter().enumerate() {
                text.push_str(if i == 0 { "" } else { "," });
                line(text, depth + 1);
                write_leaf(&Value::String(name.clone()), text);
                text.push_str(": ");
                write_value(member, depth + 1, false, text);
            }
            line(text, depth);
            text.push('}');
        }
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {
            write_leaf(value, text);
        }
    }
}

fn write_leaf(value: &Value, text: &mut String) {
    use core::fmt::Write as _;
    write!(text, "{value}").expect("a text takes what is written");
}

/// What can be wrong with a value that should be a project.
enum Problem {
    Fault(Fault),
    Newer { found: u32 },
}

impl From<Fault> for Problem {
    fn from(fault: Fault) -> Self {
        Self::Fault(fault)
    }
}

fn parse_within_limit(text: &str, path: &Path) -> Result<Value, OpenProjectError> {
    if text.len() > MOST_BYTES {
        return Err(OpenProjectError::TooLarge {
            most: MOST_BYTES,
            found: text.len() as u64,
            path: path.to_owned(),
        });
    }
    parse::parse(text).map_err(|error| OpenProjectError::syntax(&error, path))
}

impl Edit {
    /// Reads an array of edits, as `relievo apply` takes it; `path` only names the file in errors.
    ///
    /// # Errors
    /// Where the text is not JSON, not an array of edits, or a value does not fit.
    pub fn list_from_json(text: &str, path: &Path) -> Result<Vec<Self>, OpenProjectError> {
        let value = parse_within_limit(text, path)?;
        let read = |value| -> Result<Vec<Self>, Fault> {
            let stored = Vec::<StoredEdit>::read(value, &At::Root)?;
            let edits = stored.into_iter().enumerate();
            edits
                .map(|(i, edit)| Self::from_stored(edit, &At::Element(&At::Root, i)))
                .collect()
        };
        read(value).map_err(|fault| OpenProjectError::invalid(text, fault, path))
    }

    /// An array of edits as text that [`Edit::list_from_json`] reads.
    pub fn list_to_json(edits: &[Self]) -> String {
        pretty(&edits.iter().map(|edit| edit.to_stored().write()).collect())
    }
}

impl Serialize for Edit {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.to_stored().write().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Edit {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = Value::deserialize(deserializer)?;
        let stored = StoredEdit::read(value, &At::Root).map_err(D::Error::custom)?;
        Self::from_stored(stored, &At::Root).map_err(D::Error::custom)
    }
}

impl schemars::JsonSchema for Edit {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        StoredEdit::schema_name()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        StoredEdit::json_schema(generator)
    }
}

/// The JSON Schema (draft 2020-12) of the project file; `edits` under `$defs` is the array that
/// `relievo apply` takes.
pub fn schema() -> Value {
    let mut schema =
        schemars::SchemaGenerator::default().into_root_schema_for::<With<v1::Project>>();
    let mut edits = schemars::SchemaGenerator::default()
        .into_root_schema_for::<Vec<StoredEdit>>()
        .to_value();
    if let (Some(Value::Object(all)), Value::Object(edits)) = (schema.get_mut("$defs"), &mut edits)
    {
        if let Some(Value::Object(used)) = edits.shift_remove("$defs") {
            all.extend(used);
        }
        edits.shift_remove("$schema");
        edits.insert("title".to_owned(), "Edits for relievo apply".into());
        all.insert("edits".to_owned(), Value::Object(edits.clone()));
    }
    schema.to_value()
}

/// [`schema`] as text, as it is published.
pub fn schema_text() -> String {
    pretty(&schema())
}
