//! Colours of planning elements, drawn above all colour layers.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

use relievo_graph::ImageNode;
use relievo_graph::nodes::Vector;
use relievo_planet::Planet;
use relievo_project::{BrushTool, Element, ElementKind, SectionKind, Vertices};
use relievo_vector::style::Length;
use relievo_vector::{Builder, Drawing, Features, Style};

/// How a run of elements is painted.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Paint {
    /// Red, green, blue and alpha inside.
    fill: Option<[f32; 4]>,
    /// Along boundaries and axes, with its width in metres.
    stroke: Option<([f32; 4], f64)>,
    /// Lines as wide as this instead of areas.
    band_m: Option<f64>,
}

/// Elements that follow each other in the list and are painted alike.
pub(crate) struct Painted {
    paint: Paint,
    elements: Vec<Arc<Element>>,
}

/// Runs of visible elements that have colours, the first at the bottom.
pub(crate) fn painted(elements: &[Arc<Element>]) -> Vec<Painted> {
    let mut all: Vec<Painted> = Vec::new();
    for element in elements.iter().filter(|e| e.visible) {
        let Some(paint) = paint(element) else {
            continue;
        };
        match all.last_mut() {
            Some(last) if last.paint == paint => last.elements.push(Arc::clone(element)),
            _ => all.push(Painted {
                paint,
                elements: vec![Arc::clone(element)],
            }),
        }
    }
    all
}

fn paint(element: &Element) -> Option<Paint> {
    let style = &element.style;
    let colour = |rgb: [u8; 3], alpha: f64| {
        let [r, g, b] = rgb.map(relievo_raster::colour::from_u8);
        [r, g, b, alpha as f32]
    };
    let fill = style.fill.filter(|_| style.fill_opacity > 0.0);
    let stroke = style.stroke.filter(|_| style.stroke_width_m > 0.0);
    if fill.is_none() && stroke.is_none() {
        return None;
    }
    let band_m = match &element.kind {
        ElementKind::Polygon(_) => None,
        ElementKind::Corridor(corridor) => Some(match corridor.section.kind {
            SectionKind::Road { width_m, .. } => width_m,
            SectionKind::Dam { crest_width_m } => crest_width_m,
            SectionKind::Trench { bottom_width_m, .. } => bottom_width_m,
            SectionKind::Channel {
                bottom_width_m,
                depth_m,
                bank_slope,
            } => bottom_width_m + 2.0 * depth_m / bank_slope,
            SectionKind::Unknown { .. } => return None,
        }),
        // As wide as its widest stroke: colour says where somebody worked.
        ElementKind::Brush(brush) => brush
            .strokes
            .iter()
            .filter(|s| !matches!(s.tool, BrushTool::Unknown { .. }))
            .map(|s| 2.0 * s.radius_m)
            .reduce(f64::max),
        ElementKind::Unknown { .. } => return None,
    };
    Some(Paint {
        fill: fill.map(|rgb| colour(rgb, style.fill_opacity)),
        stroke: stroke.map(|rgb| (colour(rgb, 1.0), style.stroke_width_m)),
        band_m,
    })
}

impl Painted {
    /// A name that is the run's as long as its elements live.
    pub(crate) fn name(&self) -> String {
        let mut hasher = DefaultHasher::new();
        for element in &self.elements {
            Arc::as_ptr(element).addr().hash(&mut hasher);
        }
        format!(
            "elements {:x} {} {:?}",
            hasher.finish(),
            self.elements.len(),
            self.paint
        )
    }

    /// How the vector crate draws it.
    fn style(&self) -> Style {
        let Paint {
            fill,
            stroke,
            band_m,
        } = self.paint;
        let Some(band_m) = band_m else {
            return Style {
                fill,
                stroke: stroke.map(|(colour, _)| colour),
                stroke_width: stroke.map(|(_, width_m)| Length::Metres(width_m)),
                ..Style::default()
            };
        };
        match (fill, stroke) {
            // An axis on a band.
            (Some(fill), Some((colour, width_m))) => Style {
                stroke: Some(colour),
                stroke_width: Some(Length::Metres(width_m)),
                casing: Some((fill, Length::Metres(((band_m - width_m) / 2.0).max(0.0)))),
                ..Style::default()
            },
            (Some(colour), None) => Style {
                stroke: Some(colour),
                stroke_width: Some(Length::Metres(band_m)),
                ..Style::default()
            },
            (None, stroke) => Style {
                stroke: stroke.map(|(colour, _)| colour),
                stroke_width: stroke.map(|(_, width_m)| Length::Metres(width_m)),
                ..Style::default()
            },
        }
    }

    /// The node that draws it.
    ///
    /// # Errors
    /// One line that says what is wrong.
    pub(crate) fn node(&self, planet: Planet) -> Result<Arc<dyn ImageNode>, String> {
        let drawing = Drawing::new(Arc::new(self.features()?), self.style(), planet);
        Ok(Arc::new(Vector::new(Arc::new(drawing))))
    }

    /// Its elements as features. Vertices that are no places are left out.
    fn features(&self) -> Result<Features, String> {
        let mut all = Builder::degrees();
        for element in &self.elements {
            match &element.kind {
                ElementKind::Polygon(polygon) => {
                    all.ring(places(&polygon.outline), false)?;
                    for hole in &polygon.holes {
                        all.ring(places(hole), true)?;
                    }
                }
                ElementKind::Corridor(corridor) => all.line(places(&corridor.line))?,
                ElementKind::Brush(brush) => {
                    for stroke in &brush.strokes {
                        let mut points = places(&stroke.points);
                        // A dab is a line without length.
                        if let [only] = points[..] {
                            points.push([only[0], only[1] + 1e-9]);
                        }
                        all.line(points)?;
                    }
                }
                ElementKind::Unknown { .. } => {}
            }
            all.feature()?;
        }
        all.finish()
    }
}

fn places(list: &Vertices) -> Vec<[f64; 2]> {
    let good = |p: &[f64; 2]| p.iter().all(|v| v.is_finite()) && p[1].abs() <= 90.0;
    let vertices = list.as_slice().iter().map(|v| [v.lon_deg, v.lat_deg]);
    vertices.filter(good).collect()
}
