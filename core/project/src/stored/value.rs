//! Reading and writing JSON values with a place in hand.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde_json::{Number, Value};

use super::fault::{At, Fault, describe};
use super::range::Range;
use crate::Extra;

/// A type that a JSON value stands for.
pub(crate) trait Stored: Sized {
    /// From a value that is there.
    fn read(value: Value, at: &At<'_>) -> Result<Self, Fault>;

    /// As a value; what is not valid (a NaN) becomes a value that cannot be read.
    fn write(&self) -> Value;

    /// From a member that may be missing; `at` is the object.
    fn read_member(member: Option<Value>, name: &str, at: &At<'_>) -> Result<Self, Fault> {
        match member {
            Some(value) => Self::read(value, &At::Member(at, name)),
            None => Err(at.fault(format!("a member {name:?}"), "none")),
        }
    }

    /// As a member; `None` leaves it out.
    fn write_member(&self) -> Option<Value> {
        Some(self.write())
    }
}

/// Named fields of a JSON object.
pub(crate) trait Fields: Sized {
    /// The names.
    const NAMES: &'static [&'static str];
    /// Takes the fields out of a map.
    fn take(map: &mut Extra, at: &At<'_>) -> Result<Self, Fault>;
    /// Puts the fields at the end of a map.
    fn put(&self, map: &mut Extra);
}

/// Declares a struct of named fields: `= RANGE` limits a number, `=> RANGE` each element of an array.
macro_rules! fields {
    ($(#[$meta:meta])* $name:ident {
        $($(#[$doc:meta])* $field:ident : $ty:ty $(= $range:expr)? $(=> $each:expr)? ,)*
    }) => {
        #[derive(Clone, Debug, PartialEq, schemars::JsonSchema)]
        $(#[$meta])*
        pub(crate) struct $name {
            $(
                $(#[$doc])*
                $(#[schemars(range(min = $range.min, max = $range.max))])?
                $(#[schemars(inner(range(min = $each.min, max = $each.max)))])?
                pub(crate) $field: $ty,
            )*
        }

        impl $crate::stored::value::Fields for $name {
            const NAMES: &'static [&'static str] = &[$(stringify!($field)),*];

            #[allow(unused_variables, reason = "a struct may have no field")]
            fn take(
                map: &mut $crate::Extra,
                at: &$crate::stored::fault::At<'_>,
            ) -> Result<Self, $crate::stored::fault::Fault> {
                #[allow(unused_imports, reason = "a struct may have no field")]
                use $crate::stored::value::Stored as _;
                Ok(Self {
                    $($field: {
                        let name = stringify!($field);
                        let value = <$ty>::read_member(map.shift_remove(name), name, at)?;
                        $($crate::stored::value::InRange::check(
                            &value, &$range, &$crate::stored::fault::At::Member(at, name),
                        )?;)?
                        $($crate::stored::value::InRange::check(
                            &value, &$each, &$crate::stored::fault::At::Member(at, name),
                        )?;)?
                        value
                    },)*
                })
            }

            #[allow(unused_variables, reason = "a struct may have no field")]
            fn put(&self, map: &mut $crate::Extra) {
                #[allow(unused_imports, reason = "a struct may have no field")]
                use $crate::stored::value::Stored as _;
                $(if let Some(value) = self.$field.write_member() {
                    map.insert(stringify!($field).to_owned(), value);
                })*
            }
        }
    };
}

/// Declares the names that stand for the values of a runtime enum.
macro_rules! names {
    ($(#[$meta:meta])* $name:ident for $runtime:ty { $($(#[$doc:meta])* $variant:ident = $text:literal,)* }) => {
        #[derive(Clone, Copy, Debug, PartialEq, Eq, schemars::JsonSchema)]
        $(#[$meta])*
        pub(crate) enum $name {
            $($(#[$doc])* #[schemars(rename = $text)] $variant,)*
        }

        impl $crate::stored::value::Stored for $name {
            fn read(
                value: serde_json::Value,
                at: &$crate::stored::fault::At<'_>,
            ) -> Result<Self, $crate::stored::fault::Fault> {
                match value.as_str() {
                    $(Some($text) => Ok(Self::$variant),)*
                    _ => Err(at.fault(
                        concat!("one of" $(, " ", $text)*),
                        $crate::stored::fault::describe(&value),
                    )),
                }
            }

            fn write(&self) -> serde_json::Value {
                match self { $(Self::$variant => $text.into(),)* }
            }
        }

        impl From<$name> for $runtime {
            fn from(name: $name) -> Self {
                match name { $($name::$variant => Self::$variant,)* }
            }
        }

        impl From<$runtime> for $name {
            fn from(value: $runtime) -> Self {
                match value { $(<$runtime>::$variant => Self::$variant,)* }
            }
        }
    };
}

/// Declares an object whose member `$tag` names which fields it has besides; objects of other names
/// are kept whole.
macro_rules! tagged {
    ($(#[$meta:meta])* $name:ident of $kinds:ident by $tag:literal, $description:literal {
        $($(#[$doc:meta])* $variant:ident($fields:ident) = $text:literal { $($body:tt)* })*
    }) => {
        $(fields! { $(#[$doc])* $fields { $($body)* } })*

        #[derive(Clone, Debug, PartialEq)]
        $(#[$meta])*
        pub(crate) enum $kinds {
            $($(#[$doc])* $variant($fields),)*
            /// Any other: everything is among the unknown members.
            Unknown(String),
        }

        #[derive(Clone, Debug, PartialEq)]
        $(#[$meta])*
        pub(crate) struct $name {
            /// Which, with its fields.
            pub(crate) kind: $kinds,
            /// The rest.
            pub(crate) extra: $crate::Extra,
        }

        impl $name {
            /// The names that this version knows.
            pub(crate) const KINDS: &'static [&'static str] = &[$($text),*];

            /// From an object's members, all of which are taken.
            pub(crate) fn take(
                mut map: $crate::Extra,
                at: &$crate::stored::fault::At<'_>,
            ) -> Result<Self, $crate::stored::fault::Fault> {
                use $crate::stored::value::{Fields as _, Stored as _};
                let name = String::read_member(map.shift_remove($tag), $tag, at)?;
                let kind = match name.as_str() {
                    $($text => $kinds::$variant($fields::take(&mut map, at)?),)*
                    "" => {
                        return Err($crate::stored::fault::At::Member(at, $tag)
                            .fault(concat!("one of" $(, " ", $text)*), "\"\""));
                    }
                    _ => $kinds::Unknown(name),
                };
                Ok(Self { kind, extra: map })
            }

            /// Puts tag and fields at the end of a map, and the unknown members behind them that
            /// none of `known` names.
            pub(crate) fn put(&self, known: &[&str], map: &mut $crate::Extra) {
                use $crate::stored::value::Fields as _;
                let own: &[&str] = match &self.kind {
                    $($kinds::$variant(fields) => {
                        map.insert($tag.to_owned(), $text.into());
                        fields.put(map);
                        $fields::NAMES
                    })*
                    $kinds::Unknown(name) => {
                        map.insert($tag.to_owned(), name.as_str().into());
                        &[]
                    }
                };
                $crate::stored::value::put_extra(&self.extra, &[known, own, &[$tag]], map);
            }
        }

        impl $crate::stored::value::Stored for $name {
            fn read(
                value: serde_json::Value,
                at: &$crate::stored::fault::At<'_>,
            ) -> Result<Self, $crate::stored::fault::Fault> {
                Self::take($crate::stored::value::object(value, at)?, at)
            }

            fn write(&self) -> serde_json::Value {
                let mut map = $crate::Extra::new();
                self.put(&[], &mut map);
                serde_json::Value::Object(map)
            }
        }

        impl schemars::JsonSchema for $name {
            fn schema_name() -> std::borrow::Cow<'static, str> {
                stringify!($name).into()
            }

            fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
                let kinds = vec![$(($text, generator.subschema_for::<$fields>())),*];
                $crate::stored::value::tagged_schema($tag, $description, kinds)
            }
        }
    };
}

/// The schema of an object whose member `tag` names which fields it has besides.
pub(crate) fn tagged_schema(
    tag: &str,
    description: &str,
    kinds: Vec<(&'static str, Schema)>,
) -> Schema {
    let cases: Vec<Value> = kinds
        .into_iter()
        .map(|(kind, fields)| {
            serde_json::json!({
                "if": { "properties": { tag: { "const": kind } }, "required": [tag] },
                "then": fields,
            })
        })
        .collect();
    schemars::json_schema!({
        "description": description,
        "type": "object",
        "properties": { tag: { "type": "string", "minLength": 1 } },
        "required": [tag],
        "allOf": cases,
    })
}

/// Named fields and whatever else the object holds.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct With<T> {
    /// What this version knows.
    pub(crate) fields: T,
    /// The rest, in its order.
    pub(crate) extra: Extra,
}

impl<T: Fields> Stored for With<T> {
    fn read(value: Value, at: &At<'_>) -> Result<Self, Fault> {
        let mut extra = object(value, at)?;
        let fields = T::take(&mut extra, at)?;
        Ok(Self { fields, extra })
    }

    fn write(&self) -> Value {
        let mut map = Extra::new();
        self.fields.put(&mut map);
        put_extra(&self.extra, &[T::NAMES], &mut map);
        Value::Object(map)
    }
}

impl<T: JsonSchema> JsonSchema for With<T> {
    fn schema_name() -> Cow<'static, str> {
        T::schema_name()
    }

    fn schema_id() -> Cow<'static, str> {
        T::schema_id()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        T::json_schema(generator)
    }
}

/// The members of an object.
pub(crate) fn object(value: Value, at: &At<'_>) -> Result<Extra, Fault> {
    match value {
        Value::Object(map) => Ok(map),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) | Value::Array(_) => {
            Err(at.fault("an object", describe(&value)))
        }
    }
}

/// Copies unknown members behind the known ones. A name that this version knows never counts as
/// unknown: it would change a field that was left out for being the default.
pub(crate) fn put_extra(extra: &Extra, known: &[&[&str]], map: &mut Extra) {
    for (name, value) in extra {
        if !known.iter().any(|names| names.contains(&name.as_str())) {
            map.insert(name.clone(), value.clone());
        }
    }
}

impl Stored for f64 {
    fn read(value: Value, at: &At<'_>) -> Result<Self, Fault> {
        value
            .as_f64()
            .filter(|x| x.is_finite())
            .ok_or_else(|| at.fault("a number", describe(&value)))
    }

    fn write(&self) -> Value {
        Number::from_f64(*self).map_or_else(|| Value::String(self.to_string()), Value::Number)
    }
}

impl Stored for u32 {
    fn read(value: Value, at: &At<'_>) -> Result<Self, Fault> {
        let whole = value
            .as_f64()
            .filter(|x| x.fract() == 0.0 && (0.0..=f64::from(Self::MAX)).contains(x));
        whole
            .map(|x| x as Self)
            .ok_or_else(|| at.fault("a whole number from 0 to 4294967295", describe(&value)))
    }

    fn write(&self) -> Value {
        (*self).into()
    }
}

impl Stored for bool {
    fn read(value: Value, at: &At<'_>) -> Result<Self, Fault> {
        value
            .as_bool()
            .ok_or_else(|| at.fault("true or false", describe(&value)))
    }

    fn write(&self) -> Value {
        (*self).into()
    }
}

impl Stored for String {
    fn read(value: Value, at: &At<'_>) -> Result<Self, Fault> {
        if let Value::String(text) = value {
            Ok(text)
        } else {
            Err(at.fault("a text", describe(&value)))
        }
    }

    fn write(&self) -> Value {
        self.as_str().into()
    }
}

/// `null` and a missing member are the same.
impl<T: Stored> Stored for Option<T> {
    fn read(value: Value, at: &At<'_>) -> Result<Self, Fault> {
        if value.is_null() {
            Ok(None)
        } else {
            T::read(value, at).map(Some)
        }
    }

    fn write(&self) -> Value {
        self.as_ref().map_or(Value::Null, Stored::write)
    }

    fn read_member(member: Option<Value>, name: &str, at: &At<'_>) -> Result<Self, Fault> {
        member.map_or(Ok(None), |value| Self::read(value, &At::Member(at, name)))
    }

    fn write_member(&self) -> Option<Value> {
        self.as_ref().map(Stored::write)
    }
}

impl<T: Stored> Stored for Vec<T> {
    fn read(value: Value, at: &At<'_>) -> Result<Self, Fault> {
        let Value::Array(items) = value else {
            return Err(at.fault("an array", describe(&value)));
        };
        items
            .into_iter()
            .enumerate()
            .map(|(i, item)| T::read(item, &At::Element(at, i)))
            .collect()
    }

    fn write(&self) -> Value {
        self.iter().map(Stored::write).collect()
    }
}

impl Stored for [f64; 3] {
    fn read(value: Value, at: &At<'_>) -> Result<Self, Fault> {
        let found = describe(&value);
        let items = Vec::<f64>::read(value, at)?;
        items
            .try_into()
            .map_err(|_wrong_length: Vec<f64>| at.fault("an array of 3 numbers", found))
    }

    fn write(&self) -> Value {
        self.iter().map(Stored::write).collect()
    }
}

/// Numbers that can be compared with a range.
pub(crate) trait InRange<T> {
    /// A fault where a number lies outside.
    fn check(&self, range: &Range<T>, at: &At<'_>) -> Result<(), Fault>;
}

impl InRange<f64> for f64 {
    fn check(&self, range: &Range<f64>, at: &At<'_>) -> Result<(), Fault> {
        if (range.min..=range.max).contains(self) {
            Ok(())
        } else {
            Err(at.fault(format!("{} to {}", range.min, range.max), self.to_string()))
        }
    }
}

impl InRange<u32> for u32 {
    fn check(&self, range: &Range<u32>, at: &At<'_>) -> Result<(), Fault> {
        if (range.min..=range.max).contains(self) {
            Ok(())
        } else {
            Err(at.fault(format!("{} to {}", range.min, range.max), self.to_string()))
        }
    }
}

impl<N, T: InRange<N>> InRange<N> for Option<T> {
    fn check(&self, range: &Range<N>, at: &At<'_>) -> Result<(), Fault> {
        self.as_ref().map_or(Ok(()), |value| value.check(range, at))
    }
}

impl<N, T: InRange<N>> InRange<N> for Vec<T> {
    fn check(&self, range: &Range<N>, at: &At<'_>) -> Result<(), Fault> {
        self.iter()
            .enumerate()
            .try_for_each(|(i, value)| value.check(range, &At::Element(at, i)))
    }
}

impl<N, T: InRange<N>> InRange<N> for [T; 3] {
    fn check(&self, range: &Range<N>, at: &At<'_>) -> Result<(), Fault> {
        self.iter()
            .enumerate()
            .try_for_each(|(i, value)| value.check(range, &At::Element(at, i)))
    }
}
