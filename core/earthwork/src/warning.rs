//! What is odd about an element. It is drawn as well as can be all the same.

use core::fmt;

use relievo_planet::MapPoint;

/// What is odd, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Warning {
    /// What.
    pub kind: WarningKind,
    /// Where, if it has one place; the first of `count`.
    pub place: Option<MapPoint>,
    /// How many times.
    pub count: usize,
}

/// What can be odd about an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum WarningKind {
    /// Coordinates, heights or measures that are no numbers were left out or replaced by defaults.
    NotANumber,
    /// A vertex stands where the one before it does.
    DuplicateVertex,
    /// A boundary crosses or touches itself, or a hole touches another boundary.
    SelfCrossing,
    /// A hole lies outside of the outline or inside another hole and has no effect.
    HoleOutside,
    /// An area so narrow that it is hardly one, less than 1 mm wide on average.
    Sliver,
    /// Nothing is left to draw: too few different vertices.
    NoExtent,
    /// Breaklines or boundaries of a TIN meet at different heights; the mean is taken.
    HeightsDisagree,
    /// A breakline leaves the area.
    BreaklineOutside,
    /// A boundary rises more steeply than the side slopes: they end in walls there.
    SteeperThanSide,
    /// A side slope has not met the ground within its reach and ends in a wall.
    ReachWall,
    /// A measure was out of range and the nearest possible one was taken.
    OutOfRange,
    /// A stretch of triangles could not follow a breakline.
    BreaklineDropped,
    /// The element is too large for the spacing it needs; its ground was read more coarsely.
    CoarseGround,
    /// The ground has no height at some places that the element stands on; the mean of the others
    /// was taken.
    GroundMissing,
}

impl WarningKind {
    const fn text(self) -> &'static str {
        match self {
            Self::NotANumber => "values that are no numbers were left out",
            Self::DuplicateVertex => "vertices stand in the same place",
            Self::SelfCrossing => "boundaries cross or touch each other",
            Self::HoleOutside => "a hole outside of the outline or inside another has no effect",
            Self::Sliver => "the area is less than 1 mm wide",
            Self::NoExtent => "too few different vertices to draw anything",
            Self::HeightsDisagree => "lines meet at different heights; their mean is taken",
            Self::BreaklineOutside => "a breakline leaves the area",
            Self::SteeperThanSide => {
                "the boundary is steeper than the side slope, which ends in a wall"
            }
            Self::ReachWall => {
                "a side slope does not meet the ground within its reach and ends in a wall"
            }
            Self::OutOfRange => "a measure was out of range; the nearest possible is taken",
            Self::BreaklineDropped => "triangles could not follow a breakline everywhere",
            Self::CoarseGround => {
                "the element is so large that the ground below it is read more coarsely"
            }
            Self::GroundMissing => {
                "the ground has no height at places the element needs; the mean of others is taken"
            }
        }
    }
}

impl fmt::Display for Warning {
    /// One line without the element's name.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.kind.text())?;
        if self.count > 1 {
            write!(f, " ({} times)", self.count)?;
        }
        if let Some(place) = self.place {
            let (lon, lat) = place.to_degrees();
            write!(f, " at longitude {lon:.6}, latitude {lat:.6}")?;
        }
        Ok(())
    }
}

/// Collects warnings, one of a kind.
#[derive(Clone, Debug, Default)]
pub(crate) struct Warnings(Vec<Warning>);

impl Warnings {
    pub(crate) fn add(&mut self, kind: WarningKind, place: Option<MapPoint>) {
        if let Some(known) = self.0.iter_mut().find(|w| w.kind == kind) {
            known.count += 1;
        } else {
            self.0.push(Warning {
                kind,
                place,
                count: 1,
            });
        }
    }

    pub(crate) fn all(&self) -> &[Warning] {
        &self.0
    }
}
