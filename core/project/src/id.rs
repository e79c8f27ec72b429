//! Names of things that live as long as the project.

use core::fmt;

/// Declares a type of id: 1 to 64 ASCII letters, digits, `-`, `_` and `.`.
macro_rules! id {
    ($(#[$meta:meta])* $name:ident) => {
        $(#[$meta])*
        #[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub struct $name(pub String);

        impl $name {
            /// Longest id in bytes.
            pub const MAX_BYTES: usize = 64;

            /// Whether the text is a valid id.
            pub fn is_valid(text: &str) -> bool {
                (1..=Self::MAX_BYTES).contains(&text.len())
                    && text
                        .bytes()
                        .all(|b| b.is_ascii_alphanumeric() || matches!(b, b'-' | b'_' | b'.'))
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(&self.0)
            }
        }

        impl From<&str> for $name {
            fn from(text: &str) -> Self {
                Self(text.to_owned())
            }
        }
    };
}

id! {
    /// Names a layer for as long as the project lives: 1 to 64 ASCII letters, digits, `-`, `_` and `.`.
    LayerId
}

id! {
    /// Names a planning element, in the base and in every scenario: 1 to 64 ASCII letters, digits,
    /// `-`, `_` and `.`. What has the same id in two scenarios is the same element, compared there.
    ElementId
}

id! {
    /// Names a scenario: 1 to 64 ASCII letters, digits, `-`, `_` and `.`.
    ScenarioId
}
