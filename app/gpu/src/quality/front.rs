//! The measured front: settings of which none is both cheaper and truer than another.
//!
//! `front.csv` beside this file is a figure of `relievo report --suite quality`, as it was written.

use std::sync::LazyLock;

use relievo_engine::planet::clipmap::rings::RingMesh;

use super::Quality;

/// The figure, with the machine and the commit that made it in its notes.
const MEASURED: &str = include_str!("front.csv");

/// Heads of the columns, in their order.
pub const COLUMNS: [&str; 7] = [
    "azimuth_steps",
    "radial_steps",
    "height_texel_px",
    "colour_texel_px",
    "max_taps",
    "error_px",
    "frame_ms",
];

/// What a setting of the front decides; the rest of a [`Quality`] is the adapter's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// Vertices around a ring.
    pub azimuth_steps: u32,
    /// Rows of quads in a ring.
    pub radial_steps: u32,
    /// Smallest size of a height sample on the screen in pixels, 0.25 to 32.
    pub height_texel_px: f64,
    /// Smallest size of a colour sample on the screen in pixels, 0.25 to 16.
    pub colour_texel_px: f64,
    /// Most taps along a fragment's footprint, 1 to 16.
    pub max_taps: u32,
}

impl Setting {
    /// A quality with this setting's mesh and filter.
    #[must_use]
    pub fn on(&self, quality: Quality) -> Quality {
        Quality {
            azimuth_steps: self.azimuth_steps,
            radial_steps: self.radial_steps,
            max_taps: self.max_taps,
            ..quality
        }
    }

    fn is_valid(&self) -> bool {
        RingMesh::new(self.azimuth_steps, self.radial_steps).is_ok()
            && (0.25..=32.0).contains(&self.height_texel_px)
            && (0.25..=16.0).contains(&self.colour_texel_px)
            && (1..=16).contains(&self.max_taps)
    }
}

/// A setting with what was measured of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrontPoint {
    /// The setting.
    pub setting: Setting,
    /// Error on the screen in pixels: 9 in 10 pixels of ground have less.
    pub error_px: f64,
    /// Milliseconds a frame on the machine that measured: a cost to be compared with others', not a
    /// time on another machine.
    pub frame_ms: f64,
}

/// Settings from the cheapest to the truest, at least one: cost rises and error falls from each to the
/// next.
#[derive(Clone, Debug, PartialEq)]
pub struct Front(Vec<FrontPoint>);

/// Why a text is no front.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line} of the front: expected {expected}, found {found}")]
pub struct FrontError {
    /// Its line, from 1.
    pub line: usize,
    /// What was expected.
    pub expected: &'static str,
    /// What was found.
    pub found: String,
}

impl Front {
    /// The front that comes with the program.
    pub fn measured() -> &'static Self {
        static FRONT: LazyLock<Front> = LazyLock::new(|| match Front::parse(MEASURED) {
            Ok(front) => front,
            // A test reads the file, so that no program has another.
            Err(error) => unreachable!("{error}"),
        });
        &FRONT
    }

    /// Reads a table of comma-separated values with [`COLUMNS`]; lines that begin with `#` are notes.
    ///
    /// # Errors
    /// [`FrontError`] where a number is missing, out of its range, or not beyond that of the line before.
    pub fn parse(text: &str) -> Result<Self, FrontError> {
        let mut points: Vec<FrontPoint> = Vec::new();
        let lines = text.lines().enumerate().map(|(i, line)| (i + 1, line));
        let mut rows = lines.filter(|(_, line)| !line.starts_with('#'));
        let fault = |line: usize, expected, found: &str| FrontError {
            line,
            expected,
            found: found.to_owned(),
        };
        match rows.next() {
            Some((_, head)) if head.split(',').eq(COLUMNS) => {}
            Some((line, head)) => return Err(fault(line, "the heads of the columns", head)),
            None => return Err(fault(1, "the heads of the columns", "nothing")),
        }
        for (line, row) in rows {
            let numbers: Vec<f64> = row.split(',').map_while(|cell| cell.parse().ok()).collect();
            let [
                azimuth_steps,
                radial_steps,
                height_texel_px,
                colour_texel_px,
                max_taps,
                error_px,
                frame_ms,
            ] = numbers[..]
            else {
                return Err(fault(line, "seven numbers", row));
            };
            let whole = |number: f64| Some(number as u32).filter(|n| f64::from(*n) == number);
            let setting = whole(azimuth_steps)
                .zip(whole(radial_steps))
                .zip(whole(max_taps))
                .map(|((azimuth_steps, radial_steps), max_taps)| Setting {
                    azimuth_steps,
                    radial_steps,
                    height_texel_px,
                    colour_texel_px,
                    max_taps,
                });
            let Some(setting) = setting.filter(Setting::is_valid) else {
                return Err(fault(line, "a mesh, sizes and taps that can be drawn", row));
            };
            let measured = |value: f64| value.is_finite() && value > 0.0;
            if !(measured(error_px) && measured(frame_ms)) {
                return Err(fault(line, "an error and a time above 0", row));
            }
            let after = |last: &FrontPoint| frame_ms > last.frame_ms && error_px < last.error_px;
            if !points.last().is_none_or(after) {
                return Err(fault(line, "more time and less error than before", row));
            }
            points.push(FrontPoint {
                setting,
                error_px,
                frame_ms,
            });
        }
        if points.is_empty() {
            let found = "none";
            return Err(fault(text.lines().count(), "at least one setting", found));
        }
        Ok(Self(points))
    }

    /// All settings, the cheapest first.
    pub fn points(&self) -> &[FrontPoint] {
        &self.0
    }

    /// Index of the cheapest setting whose error is at most `error_px`; of the truest where none has so
    /// little, or where `error_px` is no number.
    pub fn cheapest_within(&self, error_px: f64) -> usize {
        let within = |p: &FrontPoint| p.error_px <= error_px;
        self.0.iter().position(within).unwrap_or(self.0.len() - 1)
    }

    /// Index of the truest setting for which `fits` holds; of the cheapest where there is none.
    pub fn truest_that(&self, fits: impl Fn(usize) -> bool) -> usize {
        (0..self.0.len()).rposition(fits).unwrap_or(0)
    }

    /// Index of the truest setting with no more triangles and taps than a quality has; of the cheapest
    /// where all have more.
    pub fn like(&self, quality: &Quality) -> usize {
        let quads = |azimuth: u32, radial: u32| u64::from(azimuth) * u64::from(radial);
        let most = quads(quality.azimuth_steps, quality.radial_steps);
        self.truest_that(|i| {
            let setting = &self.0[i].setting;
            quads(setting.azimuth_steps, setting.radial_steps) <= most
                && setting.max_taps <= quality.max_taps
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::AdapterClass;

    fn front(rows: &str) -> Result<Front, FrontError> {
        Front::parse(&format!("# a note\n{}\n{rows}", COLUMNS.join(",")))
    }

    const TWO: &str = "64.0,8.0,4.0,2.0,1.0,3.5,5.0\n512.0,40.0,2.0,1.0,8.0,0.5,40.0\n";

    #[test]
    fn the_front_that_comes_with_the_program_is_one_and_says_who_measured_it() {
        let front = Front::parse(MEASURED).unwrap();
        assert_eq!(&front, Front::measured());
        assert!(front.points().len() >= 5, "a choice");
        let notes = MEASURED.lines().take_while(|l| l.starts_with('#'));
        assert!(notes.last().unwrap().contains(" at commit "));
        let (first, last) = (front.points()[0], front.points()[front.points().len() - 1]);
        assert!(first.error_px > 4.0 * last.error_px && last.frame_ms > 2.0 * first.frame_ms);
    }

    #[test]
    fn settings_that_cannot_be_drawn_or_are_beaten_are_refused_by_line() {
        assert_eq!(front(TWO).unwrap().points().len(), 2);
        for (rows, expected) in [
            ("", "at least one"),
            ("64,8,4,2,1,3.5\n", "seven numbers"),
            ("64,8,4,2,1,3.5,5,6\n", "seven numbers"),
            ("64,8,4,two,1,3.5,5\n", "seven numbers"),
            ("65,8,4,2,1,3.5,5\n", "can be drawn"),
            ("64,0,4,2,1,3.5,5\n", "can be drawn"),
            ("64,8.5,4,2,1,3.5,5\n", "can be drawn"),
            ("64,8,4,2,0,3.5,5\n", "can be drawn"),
            ("64,8,NaN,2,1,3.5,5\n", "can be drawn"),
            ("64,8,4,2,1,0,5\n", "above 0"),
            ("64,8,4,2,1,inf,5\n", "above 0"),
        ] {
            let error = front(rows).unwrap_err();
            assert!(error.to_string().contains(expected), "{rows}: {error}");
        }
        let beaten = front(&format!("{TWO}512,40,2,1,8,0.6,50\n")).unwrap_err();
        assert_eq!(
            (beaten.line, beaten.expected),
            (5, "more time and less error than before")
        );
        assert!(
            Front::parse("")
                .unwrap_err()
                .to_string()
                .contains("nothing")
        );
        assert!(
            Front::parse("a,b\n")
                .unwrap_err()
                .to_string()
                .contains("a,b")
        );
    }

    #[test]
    fn every_adapter_has_a_setting_like_its_own() {
        let front = Front::measured();
        let classes = [
            AdapterClass::Software,
            AdapterClass::Integrated,
            AdapterClass::Discrete,
        ];
        let like = classes.map(|class| front.like(&Quality::for_adapter(class)));
        assert!(like.is_sorted(), "{like:?}");
        assert!(like[2] > 0);
    }

    #[test]
    fn wishes_that_are_no_numbers_get_the_truest_setting() {
        let front = Front::measured();
        let last = front.points().len() - 1;
        for wish in [f64::NAN, 0.0, -1.0, f64::NEG_INFINITY, 1e-300] {
            assert_eq!(front.cheapest_within(wish), last, "{wish}");
        }
        assert_eq!(front.cheapest_within(f64::INFINITY), 0);
        assert_eq!(front.truest_that(|_| false), 0);
    }

    proptest! {
        #[test]
        fn who_allows_more_error_never_pays_more_and_gets_what_was_allowed(
            wishes in (1e-3..100.0_f64, 1e-3..100.0_f64),
        ) {
            let front = Front::measured();
            let (low, high) = (wishes.0.min(wishes.1), wishes.0.max(wishes.1));
            let (strict, lax) = (front.cheapest_within(low), front.cheapest_within(high));
            prop_assert!(lax <= strict);
            let chosen = &front.points()[strict];
            prop_assert!(chosen.error_px <= low || strict == front.points().len() - 1);
            if strict > 0 {
                prop_assert!(front.points()[strict - 1].error_px > low, "nothing cheaper would do");
            }
            prop_assert!(chosen.setting.is_valid());
        }
    }
}
