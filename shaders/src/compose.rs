//! Puts an entry file together: each `#import` once, constants substituted.
//!
//! Grammar: a line `#import lib/NAME` is replaced by that library the first time it is met and by
//! nothing afterwards; `{{NAME}}` anywhere is replaced by the constant of that name, which is
//! declared here or in the crate that owns it, never in WGSL. There is no conditional inclusion:
//! scenes are specialised through pipeline-overridable constants.

use relievo_planet::{clipmap::choose, transform};

use crate::layout;

/// A file with entry points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Entry {
    /// `displace`: lifts ring vertices to the terrain (compute).
    Displace,
    /// `terrain_vertex`, `terrain_fragment`: draws the ground.
    Terrain,
    /// `sky_vertex`, `sky_fragment`: draws what is beyond it.
    Sky,
    /// `mass_vertex`, `mass_fragment`: draws bodies that stand on the ground.
    Masses,
    /// `blit_vertex`, `blit_fragment`: copies the picture into another target.
    Blit,
    /// `measure`, `choose`: evaluate the map transform and the choice of levels (compute).
    Measure,
    /// `forms`: evaluates any form of the map transform (compute).
    Forms,
}

impl Entry {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Displace,
        Self::Terrain,
        Self::Sky,
        Self::Masses,
        Self::Blit,
        Self::Measure,
        Self::Forms,
    ];

    /// The file's stem, for labels.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Displace => "displace",
            Self::Terrain => "terrain",
            Self::Sky => "sky",
            Self::Masses => "masses",
            Self::Blit => "blit",
            Self::Measure => "measure",
            Self::Forms => "forms",
        }
    }

    const fn source(self) -> &'static str {
        match self {
            Self::Displace => include_str!("../wgsl/displace.wgsl"),
            Self::Terrain => include_str!("../wgsl/terrain.wgsl"),
            Self::Sky => include_str!("../wgsl/sky.wgsl"),
            Self::Masses => include_str!("../wgsl/masses.wgsl"),
            Self::Blit => include_str!("../wgsl/blit.wgsl"),
            Self::Measure => include_str!("../wgsl/measure.wgsl"),
            Self::Forms => include_str!("../wgsl/forms.wgsl"),
        }
    }
}

/// The libraries that `#import` knows.
const LIBRARIES: [(&str, &str); 6] = [
    ("lib/frame", include_str!("../wgsl/lib/frame.wgsl")),
    ("lib/transform", include_str!("../wgsl/lib/transform.wgsl")),
    ("lib/classic", include_str!("../wgsl/lib/classic.wgsl")),
    ("lib/clipmap", include_str!("../wgsl/lib/clipmap.wgsl")),
    ("lib/light", include_str!("../wgsl/lib/light.wgsl")),
    ("lib/sky", include_str!("../wgsl/lib/sky.wgsl")),
];

/// Why a source cannot be put together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ComposeError {
    /// `#import` of a library that does not exist.
    UnknownLibrary(String),
    /// `{{NAME}}` without such a constant, or without its closing braces.
    UnknownConstant(String),
}

impl core::fmt::Display for ComposeError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::UnknownLibrary(name) => write!(f, "shader imports an unknown library: {name}"),
            Self::UnknownConstant(name) => write!(f, "shader names an unknown constant: {name}"),
        }
    }
}

impl core::error::Error for ComposeError {}

/// The WGSL of an entry file with its libraries and constants.
///
/// # Panics
/// Never: that every entry file composes is tested.
pub fn compose(entry: Entry) -> String {
    compose_source(entry.source()).expect("every entry file composes: tested")
}

/// As [`compose`], for any source text.
///
/// # Errors
/// If it imports or names what does not exist.
pub fn compose_source(source: &str) -> Result<String, ComposeError> {
    let mut imported = Vec::new();
    let mut text = String::new();
    import(source, &mut imported, &mut text)?;
    substitute(&text)
}

fn import(source: &str, imported: &mut Vec<String>, out: &mut String) -> Result<(), ComposeError> {
    for line in source.lines() {
        let Some(name) = line.strip_prefix("#import ").map(str::trim) else {
            out.push_str(line);
            out.push('\n');
            continue;
        };
        if imported.iter().any(|seen| seen == name) {
            continue;
        }
        let (_, library) = LIBRARIES
            .iter()
            .find(|(known, _)| *known == name)
            .ok_or_else(|| ComposeError::UnknownLibrary(name.to_owned()))?;
        imported.push(name.to_owned());
        import(library, imported, out)?;
    }
    Ok(())
}

fn substitute(text: &str) -> Result<String, ComposeError> {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some((before, after)) = rest.split_once("{{") {
        out.push_str(before);
        let unknown = |name: &str| ComposeError::UnknownConstant(name.to_owned());
        let (name, after) = after.split_once("}}").ok_or_else(|| unknown(after))?;
        out.push_str(&constant(name).ok_or_else(|| unknown(name))?);
        rest = after;
    }
    out.push_str(rest);
    Ok(out)
}

/// Text of a constant, exact.
fn constant(name: &str) -> Option<String> {
    if let Some(power) = name.strip_prefix("ATAN_") {
        let coefficient = transform::ATAN_POLY.get(power.parse::<usize>().ok()?)?;
        return Some(number(*coefficient));
    }
    Some(match name {
        "LEVEL_SLOTS" => layout::LEVEL_SLOTS.to_string(),
        "COLOUR_SLOT" => layout::COLOUR_SLOT.to_string(),
        "NORMAL_SLOT" => layout::NORMAL_SLOT.to_string(),
        // The ratio minus 1 at which a level has faded in: 2 to the power of the octaves.
        "FOOTPRINT_BLEND_SPAN" => {
            let octaves = f64::from(choose::FOOTPRINT_BLEND_OCTAVES);
            number((octaves.exp2() - 1.0) as f32)
        }
        "MAX_ANISOTROPY" => number(choose::MAX_ANISOTROPY as f32),
        _ => return None,
    })
}

/// A WGSL literal of exactly this value.
fn number(value: f32) -> String {
    // f64's shortest decimal of an f32 converts back to the same f32.
    format!("{:?}", f64::from(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_library_is_imported_once() {
        let text = compose_source("#import lib/transform\n#import lib/transform\n").unwrap();
        assert_eq!(text.matches("fn atan_poly").count(), 1);
    }

    #[test]
    fn what_does_not_exist_is_named() {
        let library = compose_source("#import lib/nothing");
        assert_eq!(
            library,
            Err(ComposeError::UnknownLibrary("lib/nothing".to_owned()))
        );
        let constant = compose_source("let a = {{NOTHING}};");
        assert_eq!(
            constant,
            Err(ComposeError::UnknownConstant("NOTHING".to_owned()))
        );
        assert!(compose_source("let a = {{OPEN").is_err());
    }

    #[test]
    fn constants_keep_every_bit() {
        for coefficient in transform::ATAN_POLY {
            assert_eq!(number(coefficient).parse::<f32>().unwrap(), coefficient);
        }
    }

    #[test]
    fn every_entry_file_composes() {
        for entry in Entry::ALL {
            let text = compose(entry);
            assert!(
                !text.contains("#import") && !text.contains("{{"),
                "{entry:?}"
            );
        }
    }
}
