//! Planning elements.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::{Twin, layer_name, unless_default};
use crate::stored::colour::StoredColour;
use crate::stored::elements as stored;
use crate::stored::fault::{At, Fault, quote};
use crate::stored::range;
use crate::stored::value::With;
use crate::stored::vertices::StoredVertices;
use crate::{
    Brush, BrushTool, Corridor, Element, ElementId, ElementKind, ElementStyle, Polygon, Profile,
    ProfileKind, Section, SectionKind, SideSlopes, Stroke, Surface, SurfaceKind, Vertices,
};

/// A valid id.
pub(crate) fn element_id(id: String, at: &At<'_>) -> Result<ElementId, Fault> {
    if ElementId::is_valid(&id) {
        Ok(ElementId(id))
    } else {
        Err(at.fault("1 to 64 letters, digits, '-', '_' or '.'", quote(&id)))
    }
}

/// The base's elements.
pub(crate) fn all(
    stored: Option<Vec<stored::Element>>,
    at: &At<'_>,
) -> Result<Vec<Arc<Element>>, Fault> {
    let stored = stored.unwrap_or_default();
    at_most(stored.len(), range::MOST_ELEMENTS, "elements", at)?;
    let mut elements: Vec<Arc<Element>> = Vec::with_capacity(stored.len());
    let mut places = BTreeMap::new();
    for (i, element) in stored.into_iter().enumerate() {
        let place = At::Element(at, i);
        let element = Element::from_stored(element, &place)?;
        if let Some(first) = places.insert(element.id.clone(), i) {
            let found = format!("{:?} again, as in element {first}", element.id.0);
            return Err(At::Member(&place, "id").fault("an id of its own", found));
        }
        elements.push(Arc::new(element));
    }
    Ok(elements)
}

impl Twin for Element {
    type Stored = stored::Element;

    fn from_stored(element: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        let stored::Element { base, kind } = element;
        let id = element_id(base.id, &At::Member(at, "id"))?;
        let name = match base.name {
            Some(name) => layer_name(name, &At::Member(at, "name"))?,
            None => id.0.clone(),
        };
        let stored::ElementKind { kind, extra } = kind;
        let kind = match kind {
            stored::ElementKinds::Polygon(polygon) => {
                ElementKind::Polygon(Polygon::from_stored(polygon, at)?)
            }
            stored::ElementKinds::Corridor(corridor) => {
                ElementKind::Corridor(Corridor::from_stored(corridor, at)?)
            }
            stored::ElementKinds::Brush(brush) => {
                ElementKind::Brush(Brush::from_stored(brush, at)?)
            }
            stored::ElementKinds::Unknown(kind) => ElementKind::Unknown { kind },
        };
        Ok(Self {
            id,
            name,
            visible: base.visible.unwrap_or(true),
            locked: base.locked.unwrap_or(false),
            kind,
            style: super::optional(base.style, &At::Member(at, "style"))?,
            side: super::optional(base.side, &At::Member(at, "side"))?,
            extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        use stored::ElementKinds;
        stored::Element {
            base: stored::ElementBase {
                id: self.id.0.clone(),
                name: unless_default(self.name.clone(), &self.id.0),
                visible: unless_default(self.visible, &true),
                locked: unless_default(self.locked, &false),
                style: unless_default(&self.style, &&ElementStyle::default()).map(Twin::to_stored),
                side: unless_default(&self.side, &&SideSlopes::default()).map(Twin::to_stored),
            },
            kind: stored::ElementKind {
                kind: match &self.kind {
                    ElementKind::Polygon(polygon) => ElementKinds::Polygon(polygon.to_stored()),
                    ElementKind::Corridor(corridor) => ElementKinds::Corridor(corridor.to_stored()),
                    ElementKind::Brush(brush) => ElementKinds::Brush(brush.to_stored()),
                    ElementKind::Unknown { kind } => ElementKinds::Unknown(kind.clone()),
                },
                extra: self.extra.clone(),
            },
        }
    }
}

impl Twin for ElementStyle {
    type Stored = With<stored::ElementStyle>;

    fn from_stored(style: Self::Stored, _: &At<'_>) -> Result<Self, Fault> {
        let With { fields, extra } = style;
        let default = Self::default();
        Ok(Self {
            fill: fields.fill.map(|c| c.0),
            fill_opacity: fields.fill_opacity.unwrap_or(default.fill_opacity),
            stroke: fields.stroke.map(|c| c.0),
            stroke_width_m: fields.stroke_width_m.unwrap_or(default.stroke_width_m),
            extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        let default = Self::default();
        With {
            fields: stored::ElementStyle {
                fill: self.fill.map(StoredColour),
                fill_opacity: unless_default(self.fill_opacity, &default.fill_opacity),
                stroke: self.stroke.map(StoredColour),
                stroke_width_m: unless_default(self.stroke_width_m, &default.stroke_width_m),
            },
            extra: self.extra.clone(),
        }
    }
}

impl Twin for SideSlopes {
    type Stored = With<stored::SideSlopes>;

    fn from_stored(side: Self::Stored, _: &At<'_>) -> Result<Self, Fault> {
        let With { fields, extra } = side;
        let default = Self::default();
        Ok(Self {
            cut_slope: fields.cut_slope.unwrap_or(default.cut_slope),
            fill_slope: fields.fill_slope.unwrap_or(default.fill_slope),
            wall: fields.wall.unwrap_or(default.wall),
            max_reach_m: fields.max_reach_m.unwrap_or(default.max_reach_m),
            extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        let default = Self::default();
        With {
            fields: stored::SideSlopes {
                cut_slope: unless_default(self.cut_slope, &default.cut_slope),
                fill_slope: unless_default(self.fill_slope, &default.fill_slope),
                wall: unless_default(self.wall, &default.wall),
                max_reach_m: unless_default(self.max_reach_m, &default.max_reach_m),
            },
            extra: self.extra.clone(),
        }
    }
}

/// Lists of vertices from a member that may be missing.
fn lists(
    stored: Option<Vec<StoredVertices>>,
    name: &str,
    at: &At<'_>,
) -> Result<Vec<Vertices>, Fault> {
    let lists = stored.unwrap_or_default();
    at_most(
        lists.len(),
        range::MOST_LISTS,
        "lists",
        &At::Member(at, name),
    )?;
    Ok(lists.into_iter().map(|list| list.0).collect())
}

/// A fault where there are more things than a file may hold.
pub(crate) fn at_most(count: usize, most: usize, what: &str, at: &At<'_>) -> Result<(), Fault> {
    if count > most {
        return Err(at.fault(format!("at most {most} {what}"), count.to_string()));
    }
    Ok(())
}

fn stored_lists(lists: &[Vertices]) -> Option<Vec<StoredVertices>> {
    (!lists.is_empty()).then(|| lists.iter().cloned().map(StoredVertices).collect())
}

impl Twin for Polygon {
    type Stored = stored::Polygon;

    fn from_stored(polygon: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        Ok(Self {
            outline: polygon.outline.0,
            holes: lists(polygon.holes, "holes", at)?,
            breaklines: lists(polygon.breaklines, "breaklines", at)?,
            surface: Surface::from_stored(polygon.surface, &At::Member(at, "surface"))?,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        stored::Polygon {
            outline: StoredVertices(self.outline.clone()),
            holes: stored_lists(&self.holes),
            breaklines: stored_lists(&self.breaklines),
            surface: self.surface.to_stored(),
        }
    }
}

impl Twin for Surface {
    type Stored = stored::Surface;

    fn from_stored(surface: Self::Stored, _: &At<'_>) -> Result<Self, Fault> {
        use stored::Surfaces;
        let kind = match surface.kind {
            Surfaces::Platform(s) => SurfaceKind::Platform {
                height_m: s.height_m,
            },
            Surfaces::Plane(s) => SurfaceKind::Plane {
                height_m: s.height_m,
                slope_percent: s.slope_percent,
                aspect_deg: s.aspect_deg,
            },
            Surfaces::Tin(stored::Tin {}) => SurfaceKind::Tin,
            Surfaces::Offset(s) => SurfaceKind::Offset {
                offset_m: s.offset_m,
            },
            Surfaces::Smooth(stored::Smooth {}) => SurfaceKind::Smooth,
            Surfaces::Unknown(name) => SurfaceKind::Unknown { name },
        };
        Ok(Self {
            kind,
            extra: surface.extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        use stored::Surfaces;
        let kind = match &self.kind {
            SurfaceKind::Platform { height_m } => Surfaces::Platform(stored::Platform {
                height_m: *height_m,
            }),
            SurfaceKind::Plane {
                height_m,
                slope_percent,
                aspect_deg,
            } => Surfaces::Plane(stored::Plane {
                height_m: *height_m,
                slope_percent: *slope_percent,
                aspect_deg: *aspect_deg,
            }),
            SurfaceKind::Tin => Surfaces::Tin(stored::Tin {}),
            SurfaceKind::Offset { offset_m } => Surfaces::Offset(stored::Offset {
                offset_m: *offset_m,
            }),
            SurfaceKind::Smooth => Surfaces::Smooth(stored::Smooth {}),
            SurfaceKind::Unknown { name } => Surfaces::Unknown(name.clone()),
        };
        stored::Surface {
            kind,
            extra: self.extra.clone(),
        }
    }
}

impl Twin for Corridor {
    type Stored = stored::Corridor;

    fn from_stored(corridor: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        let profile = match corridor.profile {
            Some(profile) => Profile::from_stored(profile, &At::Member(at, "profile"))?,
            None => ProfileKind::Heights.into(),
        };
        Ok(Self {
            line: corridor.line.0,
            profile,
            section: Section::from_stored(corridor.section, &At::Member(at, "section"))?,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        let default = Profile::from(ProfileKind::Heights);
        stored::Corridor {
            line: StoredVertices(self.line.clone()),
            profile: unless_default(&self.profile, &&default).map(Twin::to_stored),
            section: self.section.to_stored(),
        }
    }
}

impl Twin for Profile {
    type Stored = stored::Profile;

    fn from_stored(profile: Self::Stored, _: &At<'_>) -> Result<Self, Fault> {
        use stored::Profiles;
        let kind = match profile.kind {
            Profiles::Heights(stored::Heights {}) => ProfileKind::Heights,
            Profiles::Follow(p) => ProfileKind::Follow {
                offset_m: p.offset_m.unwrap_or(0.0),
                smooth_m: p.smooth_m.unwrap_or(0.0),
            },
            Profiles::Unknown(name) => ProfileKind::Unknown { name },
        };
        Ok(Self {
            kind,
            extra: profile.extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        use stored::Profiles;
        let kind = match &self.kind {
            ProfileKind::Heights => Profiles::Heights(stored::Heights {}),
            ProfileKind::Follow { offset_m, smooth_m } => Profiles::Follow(stored::Follow {
                offset_m: unless_default(*offset_m, &0.0),
                smooth_m: unless_default(*smooth_m, &0.0),
            }),
            ProfileKind::Unknown { name } => Profiles::Unknown(name.clone()),
        };
        stored::Profile {
            kind,
            extra: self.extra.clone(),
        }
    }
}

impl Twin for Section {
    type Stored = stored::Section;

    fn from_stored(section: Self::Stored, _: &At<'_>) -> Result<Self, Fault> {
        use stored::Sections;
        let kind = match section.kind {
            Sections::Road(s) => SectionKind::Road {
                width_m: s.width_m,
                crossfall_percent: s.crossfall_percent.unwrap_or(0.0),
            },
            Sections::Dam(s) => SectionKind::Dam {
                crest_width_m: s.crest_width_m,
            },
            Sections::Trench(s) => SectionKind::Trench {
                bottom_width_m: s.bottom_width_m,
                depth_m: s.depth_m,
            },
            Sections::Channel(s) => SectionKind::Channel {
                bottom_width_m: s.bottom_width_m,
                depth_m: s.depth_m,
                bank_slope: s.bank_slope,
            },
            Sections::Unknown(name) => SectionKind::Unknown { name },
        };
        Ok(Self {
            kind,
            extra: section.extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        use stored::Sections;
        let kind = match &self.kind {
            SectionKind::Road {
                width_m,
                crossfall_percent,
            } => Sections::Road(stored::Road {
                width_m: *width_m,
                crossfall_percent: unless_default(*crossfall_percent, &0.0),
            }),
            SectionKind::Dam { crest_width_m } => Sections::Dam(stored::Dam {
                crest_width_m: *crest_width_m,
            }),
            SectionKind::Trench {
                bottom_width_m,
                depth_m,
            } => Sections::Trench(stored::Trench {
                bottom_width_m: *bottom_width_m,
                depth_m: *depth_m,
            }),
            SectionKind::Channel {
                bottom_width_m,
                depth_m,
                bank_slope,
            } => Sections::Channel(stored::Channel {
                bottom_width_m: *bottom_width_m,
                depth_m: *depth_m,
                bank_slope: *bank_slope,
            }),
            SectionKind::Unknown { name } => Sections::Unknown(name.clone()),
        };
        stored::Section {
            kind,
            extra: self.extra.clone(),
        }
    }
}

impl Twin for Brush {
    type Stored = stored::Brush;

    fn from_stored(brush: Self::Stored, at: &At<'_>) -> Result<Self, Fault> {
        let place = At::Member(at, "strokes");
        at_most(brush.strokes.len(), range::MOST_LISTS, "strokes", &place)?;
        let strokes = brush.strokes.into_iter().enumerate();
        let strokes =
            strokes.map(|(i, stroke)| Stroke::from_stored(stroke, &At::Element(&place, i)));
        Ok(Self {
            strokes: strokes.collect::<Result<_, _>>()?,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        stored::Brush {
            strokes: self.strokes.iter().map(Twin::to_stored).collect(),
        }
    }
}

/// Share of a brush's radius with full effect, where a stroke does not say.
const HARDNESS: f64 = 0.5;

impl Twin for Stroke {
    type Stored = stored::Stroke;

    fn from_stored(stroke: Self::Stored, _: &At<'_>) -> Result<Self, Fault> {
        use stored::StrokeTools;
        let stored::Stroke { base, kind } = stroke;
        let tool = match kind.kind {
            StrokeTools::Raise(t) => BrushTool::Raise {
                strength_m: t.strength_m,
            },
            StrokeTools::Lower(t) => BrushTool::Lower {
                strength_m: t.strength_m,
            },
            StrokeTools::SmoothOut(t) => BrushTool::Smooth {
                strength: t.strength,
            },
            StrokeTools::Flatten(t) => BrushTool::Flatten {
                height_m: t.height_m,
                strength: t.strength,
            },
            StrokeTools::Unknown(name) => BrushTool::Unknown { name },
        };
        Ok(Self {
            tool,
            radius_m: base.radius_m,
            hardness: base.hardness.unwrap_or(HARDNESS),
            points: base.points.0,
            extra: kind.extra,
        })
    }

    fn to_stored(&self) -> Self::Stored {
        use stored::StrokeTools;
        let kind = match &self.tool {
            BrushTool::Raise { strength_m } => StrokeTools::Raise(stored::Raise {
                strength_m: *strength_m,
            }),
            BrushTool::Lower { strength_m } => StrokeTools::Lower(stored::Lower {
                strength_m: *strength_m,
            }),
            BrushTool::Smooth { strength } => StrokeTools::SmoothOut(stored::SmoothOut {
                strength: *strength,
            }),
            BrushTool::Flatten { height_m, strength } => StrokeTools::Flatten(stored::Flatten {
                height_m: *height_m,
                strength: *strength,
            }),
            BrushTool::Unknown { name } => StrokeTools::Unknown(name.clone()),
        };
        stored::Stroke {
            base: stored::StrokeBase {
                radius_m: self.radius_m,
                hardness: unless_default(self.hardness, &HARDNESS),
                points: StoredVertices(self.points.clone()),
            },
            kind: stored::StrokeTool {
                kind,
                extra: self.extra.clone(),
            },
        }
    }
}

/// Checks what the detour through JSON without vertices does not: vertices, and names that claim to
/// be unknown.
pub(crate) fn check_element(element: &Element, at: &At<'_>) -> Result<(), Fault> {
    unknown_is_unknown(element, at)?;
    let check = |list: &Vertices, at: &At<'_>| crate::stored::vertices::check(list, at);
    match &element.kind {
        ElementKind::Polygon(polygon) => {
            check(&polygon.outline, &At::Member(at, "outline"))?;
            for (name, lists) in [
                ("holes", &polygon.holes),
                ("breaklines", &polygon.breaklines),
            ] {
                let place = At::Member(at, name);
                let mut lists = lists.iter().enumerate();
                lists.try_for_each(|(i, list)| check(list, &At::Element(&place, i)))?;
            }
            Ok(())
        }
        ElementKind::Corridor(corridor) => check(&corridor.line, &At::Member(at, "line")),
        ElementKind::Brush(brush) => {
            let place = At::Member(at, "strokes");
            let mut strokes = brush.strokes.iter().enumerate();
            strokes.try_for_each(|(i, stroke)| {
                check(
                    &stroke.points,
                    &At::Member(&At::Element(&place, i), "points"),
                )
            })
        }
        ElementKind::Unknown { .. } => Ok(()),
    }
}

/// Names that claim to be unknown but are known could not be read back as they are.
fn unknown_is_unknown(element: &Element, at: &At<'_>) -> Result<(), Fault> {
    let unknown = |name: &str, known: &[&str], member: &str| {
        if known.contains(&name) || name.is_empty() {
            return Err(At::Member(at, member).fault("a name that is not known", quote(name)));
        }
        Ok(())
    };
    match &element.kind {
        ElementKind::Unknown { kind } => unknown(kind, stored::ElementKind::KINDS, "kind"),
        ElementKind::Polygon(polygon) => match &polygon.surface.kind {
            SurfaceKind::Unknown { name } => unknown(name, stored::Surface::KINDS, "surface"),
            SurfaceKind::Platform { .. }
            | SurfaceKind::Plane { .. }
            | SurfaceKind::Tin
            | SurfaceKind::Offset { .. }
            | SurfaceKind::Smooth => Ok(()),
        },
        ElementKind::Corridor(corridor) => {
            if let ProfileKind::Unknown { name } = &corridor.profile.kind {
                unknown(name, stored::Profile::KINDS, "profile")?;
            }
            if let SectionKind::Unknown { name } = &corridor.section.kind {
                unknown(name, stored::Section::KINDS, "section")?;
            }
            Ok(())
        }
        ElementKind::Brush(brush) => brush.strokes.iter().try_for_each(|stroke| {
            if let BrushTool::Unknown { name } = &stroke.tool {
                unknown(name, stored::StrokeTool::KINDS, "strokes")?;
            }
            Ok(())
        }),
    }
}
