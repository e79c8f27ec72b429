//! What is wrong with a value, and where.

use core::fmt;
use std::borrow::Cow;

use serde_json::Value;

/// A place in a document, as a chain towards the root. Becomes a JSON pointer (RFC 6901) when shown.
#[derive(Clone, Copy)]
pub(crate) enum At<'a> {
    /// The whole document.
    Root,
    /// A member of an object.
    Member(&'a At<'a>, &'a str),
    /// An element of an array.
    Element(&'a At<'a>, usize),
}

impl At<'_> {
    /// A fault here.
    pub(crate) fn fault(&self, expected: impl Into<String>, found: impl Into<String>) -> Fault {
        Fault {
            pointer: self.to_string(),
            expected: expected.into(),
            found: found.into(),
        }
    }
}

impl fmt::Display for At<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Root => Ok(()),
            Self::Member(parent, name) => {
                write!(f, "{parent}/{}", name.replace('~', "~0").replace('/', "~1"))
            }
            Self::Element(parent, index) => write!(f, "{parent}/{index}"),
        }
    }
}

/// Characters of a pointer that a message shows.
const LONGEST_POINTER: usize = 200;

/// A value that does not fit: where it is, what was expected there and what was found.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct Fault {
    /// JSON pointer (RFC 6901); empty for the whole document.
    pub pointer: String,
    /// What fits there.
    pub expected: String,
    /// What is there.
    pub found: String,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = match self.pointer.char_indices().nth(LONGEST_POINTER) {
            None if self.pointer.is_empty() => Cow::Borrowed("the top"),
            None => Cow::Borrowed(self.pointer.as_str()),
            Some((end, _)) => Cow::Owned(format!("{}…", &self.pointer[..end])),
        };
        // Names of members may hold line breaks and worse.
        let place = place.replace(char::is_control, "?");
        write!(
            f,
            "at {place}: expected {}, found {}",
            self.expected, self.found
        )
    }
}

/// A value in one short line for a message.
pub(crate) fn describe(value: &Value) -> String {
    match value {
        Value::Array(items) => format!("an array of {}", items.len()),
        Value::Object(_) => "an object".to_owned(),
        Value::String(text) => quote(text),
        Value::Null | Value::Bool(_) | Value::Number(_) => value.to_string(),
    }
}

/// A text in quotes, escaped, and shortened to 60 characters.
pub fn quote(text: &str) -> String {
    const LONGEST: usize = 60;
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{:?}…", &text[..end]),
        None => format!("{text:?}"),
    }
}
