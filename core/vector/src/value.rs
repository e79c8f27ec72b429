//! Values of properties.

use core::fmt;
use std::sync::Arc;

/// One property of a feature.
#[derive(Clone, Debug, PartialEq, Default)]
pub enum Value {
    /// None.
    #[default]
    Null,
    /// Yes or no.
    Bool(bool),
    /// A whole number.
    Int(i64),
    /// A number.
    Float(f64),
    /// Text; of values that have no other form here (lists, dates) what the file says.
    Text(Arc<str>),
}

impl Value {
    /// The number, where it is one or is text that reads as one.
    pub fn as_number(&self) -> Option<f64> {
        match self {
            Self::Int(v) => Some(*v as f64),
            Self::Float(v) => Some(*v),
            Self::Text(text) => text.trim().parse().ok(),
            Self::Null | Self::Bool(_) => None,
        }
        .filter(|v: &f64| v.is_finite())
    }

    /// Whether both mean the same: numbers by value (2 is 2.0), text and numbers by how they are
    /// written, so that a code that one file stores as text and another as number matches both.
    pub fn means(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Null, Self::Null) => true,
            (Self::Bool(a), Self::Bool(b)) => a == b,
            (Self::Text(a), Self::Text(b)) => a == b,
            (Self::Int(_) | Self::Float(_), Self::Int(_) | Self::Float(_)) => {
                self.as_number() == other.as_number()
            }
            (Self::Text(text), number @ (Self::Int(_) | Self::Float(_)))
            | (number @ (Self::Int(_) | Self::Float(_)), Self::Text(text)) => {
                **text == number.to_string()
            }
            _ => false,
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Null => Ok(()),
            Self::Bool(v) => v.fmt(f),
            Self::Int(v) => v.fmt(f),
            Self::Float(v) => v.fmt(f),
            Self::Text(v) => f.write_str(v),
        }
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Self::Text(text.into())
    }
}

impl From<f64> for Value {
    fn from(v: f64) -> Self {
        Self::Float(v)
    }
}

impl From<i64> for Value {
    fn from(v: i64) -> Self {
        Self::Int(v)
    }
}

impl From<bool> for Value {
    fn from(v: bool) -> Self {
        Self::Bool(v)
    }
}
