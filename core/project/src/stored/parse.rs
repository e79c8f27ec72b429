//! Text to a JSON value, strictly, and places in the text.

use core::cell::Cell;
use core::fmt;

use serde::de::{DeserializeSeed, Deserializer, MapAccess, SeqAccess, Visitor};
use serde_json::Value;

use crate::Extra;

/// Values of a file at most, so that a file of brackets cannot take fifty times its length in memory.
/// A layer has about twenty, a vertex four.
const MOST_VALUES: usize = 4_000_000;

/// What an object takes in memory, in values.
const OBJECT: usize = 10;

/// A JSON value without repeated members: of two members of one name one would be lost on saving.
#[derive(Clone, Copy)]
struct Strict<'a> {
    /// Values that may still come.
    left: &'a Cell<usize>,
}

impl Strict<'_> {
    fn take<E: serde::de::Error>(self, values: usize) -> Result<(), E> {
        let left = self.left.get().checked_sub(values).ok_or_else(|| {
            let limit = "values, an object counted as";
            E::custom(format!("more than {MOST_VALUES} {limit} {OBJECT}"))
        })?;
        self.left.set(left);
        Ok(())
    }
}

impl<'de> DeserializeSeed<'de> for Strict<'_> {
    type Value = Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value, D::Error> {
        self.take(1)?;
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Strict<'_> {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a JSON value")
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_bool<E>(self, value: bool) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_i64<E>(self, value: i64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_u64<E>(self, value: u64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_f64<E>(self, value: f64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_str<E>(self, value: &str) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Value, A::Error> {
        let mut array = Vec::new();
        while let Some(item) = items.next_element_seed(self)? {
            array.push(item);
        }
        Ok(Value::Array(array))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut members: A) -> Result<Value, A::Error> {
        self.take(OBJECT - 1)?;
        let mut map = Extra::new();
        while let Some(name) = members.next_key::<String>()? {
            let value = members.next_value_seed(self)?;
            if map.contains_key(&name) {
                let message = format!("member {} twice in one object", super::fault::quote(&name));
                return Err(serde::de::Error::custom(message));
            }
            map.insert(name, value);
        }
        Ok(Value::Object(map))
    }
}

/// The value of a JSON text. Nesting beyond 127 levels, repeated members and more than
/// [`MOST_VALUES`] values, an object counted as [`OBJECT`], are errors.
pub(crate) fn parse(text: &str) -> Result<Value, serde_json::Error> {
    // Editors on some systems begin a file with a byte order mark.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut deserializer = serde_json::Deserializer::from_str(text);
    let left = Cell::new(MOST_VALUES);
    let value = Strict { left: &left }.deserialize(&mut deserializer)?;
    deserializer.end()?;
    Ok(value)
}

/// Line (from 1) of the value that a JSON pointer names in a text that parses; of the innermost
/// container that exists where the value does not.
pub(crate) fn line_of(text: &str, pointer: &str) -> usize {
    let mut scanner = Scanner {
        bytes: text.as_bytes(),
        position: 0,
    };
    if text.starts_with('\u{feff}') {
        scanner.position = '\u{feff}'.len_utf8();
    }
    scanner.skip_space();
    let mut place = scanner.position;
    for step in pointer.split('/').skip(1) {
        let step = step.replace("~1", "/").replace("~0", "~");
        if scanner.enter(&step).is_none() {
            break;
        }
        place = scanner.position;
    }
    1 + text.get(..place).unwrap_or(text).matches('\n').count()
}

/// Walks over a text that is known to be JSON; on anything else it stops early.
struct Scanner<'a> {
    bytes: &'a [u8],
    position: usize,
}

impl Scanner<'_> {
    fn peek(&self) -> Option<u8> {
        self.bytes.get(self.position).copied()
    }

    fn skip_space(&mut self) {
        while matches!(self.peek(), Some(b' ' | b'\t' | b'\n' | b'\r')) {
            self.position += 1;
        }
    }

    /// Moves from the start of a container to the start of one of its values.
    fn enter(&mut self, step: &str) -> Option<()> {
        let is_object = match self.peek()? {
            b'{' => true,
            b'[' => false,
            _ => return None,
        };
        self.position += 1;
        for index in 0.. {
            self.skip_space();
            let is_here = if is_object {
                let start = self.position;
                self.skip_string()?;
                let name: String =
                    serde_json::from_slice(&self.bytes[start..self.position]).ok()?;
                self.skip_space();
                self.position += 1;
                self.skip_space();
                name == step
            } else {
                step.parse() == Ok(index)
            };
            if is_here {
                return Some(());
            }
            self.skip_value()?;
            self.skip_space();
            if self.peek()? != b',' {
                return None;
            }
            self.position += 1;
        }
        None
    }

    fn skip_string(&mut self) -> Option<()> {
        if self.peek()? != b'"' {
            return None;
        }
        self.position += 1;
        loop {
            match self.peek()? {
                b'"' => break,
                b'\\' => self.position += 2,
                _ => self.position += 1,
            }
        }
        self.position += 1;
        Some(())
    }

    fn skip_value(&mut self) -> Option<()> {
        let mut depth = 0_usize;
        loop {
            match self.peek()? {
                b'"' => self.skip_string()?,
                b'{' | b'[' => {
                    depth += 1;
                    self.position += 1;
                }
                b'}' | b']' | b',' if depth == 0 => return Some(()),
                b'}' | b']' => {
                    depth -= 1;
                    self.position += 1;
                }
                _ => self.position += 1,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pointer_leads_to_its_line() {
        let text = "{\n \"a\": [1,\n  {\"x/y\":\n   2}],\n \"b\\\"\": {\"}\": 3},\n \"c\": 4\n}";
        for (pointer, line) in [
            ("", 1),
            ("/a", 2),
            ("/a/1", 3),
            ("/a/1/x~1y", 4),
            ("/c", 6),
            ("/a/9/z", 2),
        ] {
            assert_eq!(line_of(text, pointer), line, "{pointer}");
        }
        assert_eq!(line_of(text, "/b\"/}"), 5);
    }

    #[test]
    fn a_repeated_member_is_an_error_with_its_line() {
        let error = parse("{\"a\": 1,\n\"a\": 2}").unwrap_err();
        assert!(error.to_string().contains("twice"), "{error}");
        assert_eq!(error.line(), 2);
    }

    #[test]
    fn nesting_without_end_is_an_error_not_an_overflow() {
        assert!(parse(&"[".repeat(1_000_000)).is_err());
    }

    #[test]
    fn values_without_end_are_an_error_before_they_fill_the_memory() {
        let zeros = |n: usize| format!("[{}0]", "0,".repeat(n - 1));
        assert!(
            parse(&zeros(MOST_VALUES - 1)).is_ok(),
            "the array counts too"
        );
        let error = parse(&zeros(MOST_VALUES)).unwrap_err().to_string();
        assert!(error.contains("more than 4000000 values"), "{error}");
    }

    #[test]
    fn what_follows_the_value_is_an_error() {
        assert!(parse("{} {}").is_err());
        assert!(parse("{} \n").is_ok());
    }
}
