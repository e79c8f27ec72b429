//! Colours of planning elements, drawn above all colour layers.

use std::sync::Arc;

use parking_lot::Mutex;
use relievo_planet::{Grid, Planet};
use relievo_project::{BrushTool, Element, ElementKind, SectionKind, Vertices};
use relievo_vector::style::Length;
use relievo_vector::{Builder, Drawing, Features, Style};

/// Elements that are patched into a drawing before it is made anew.
const MOST_CHANGED: usize = 64;

/// Compilations for which a drawing that nobody uses any more is kept: for undo, and for scenarios that
/// are compared.
const KEPT_FOR: u64 = 16;

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

/// Drawings of runs, from revision to revision: a drag draws the one element anew that it changes.
#[derive(Default)]
pub(crate) struct PaintedCache {
    kept: Mutex<Vec<Kept>>,
}

/// A run that was made into features.
struct Kept {
    run: Painted,
    planet: Planet,
    drawing: Arc<Drawing>,
    unused: u64,
}

impl PaintedCache {
    /// Drawings of runs; one line that says what is wrong where one has none.
    pub(crate) fn drawings(
        &self,
        runs: Vec<Painted>,
        planet: Planet,
    ) -> Vec<Result<Arc<Drawing>, String>> {
        let mut kept = self.kept.lock();
        kept.iter_mut().for_each(|k| k.unused += 1);
        let drawings = runs.into_iter().map(|run| {
            let alike = kept
                .iter_mut()
                .filter(|k| k.planet == planet && k.run.paint == run.paint);
            for base in alike {
                if let Some(drawing) = base.patched(&run)? {
                    base.unused = 0;
                    return Ok(drawing);
                }
            }
            let drawing = Arc::new(Drawing::new(run.features()?, run.style(), planet));
            kept.push(Kept {
                run,
                planet,
                drawing: Arc::clone(&drawing),
                unused: 0,
            });
            Ok(drawing)
        });
        let drawings = drawings.collect();
        kept.retain(|k| k.unused < KEPT_FOR);
        drawings
    }

    /// Number of drawings that are kept.
    pub(crate) fn len(&self) -> usize {
        self.kept.lock().len()
    }
}

impl Kept {
    /// The drawing with those elements of a run that differ; `None` where too many do.
    fn patched(&self, run: &Painted) -> Result<Option<Arc<Drawing>>, String> {
        let (old, new) = (&self.run.elements, &run.elements);
        let differs = |i: &usize| match (old.get(*i), new.get(*i)) {
            (Some(a), Some(b)) => !Arc::ptr_eq(a, b),
            _ => true,
        };
        let all = (0..old.len().max(new.len())).filter(differs);
        let changed: Vec<usize> = all.take(MOST_CHANGED + 1).collect();
        if changed.is_empty() {
            return Ok(Some(Arc::clone(&self.drawing)));
        }
        if changed.len() > MOST_CHANGED {
            return Ok(None);
        }
        let added = changed.iter().filter_map(|i| new.get(*i)).cloned();
        let added = Painted {
            paint: run.paint,
            elements: added.collect(),
        };
        let replaced = changed.into_iter().filter(|i| *i < old.len());
        let patched = self.drawing.patched(replaced.collect(), added.features()?);
        Ok(patched.map(Arc::new))
    }
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

/// Whether an element's colours show in a grid.
pub(crate) fn shows(element: &Arc<Element>, planet: Planet, grid: &Grid) -> bool {
    let runs = painted(core::slice::from_ref(element));
    let drawing = |run: &Painted| Some(Drawing::new(run.features().ok()?, run.style(), planet));
    runs.iter().filter_map(drawing).any(|d| d.reaches(grid))
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

    /// Its elements as features, one each. Vertices that are no places are left out.
    fn features(&self) -> Result<Arc<Features>, String> {
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
        all.finish().map(Arc::new)
    }
}

fn places(list: &Vertices) -> Vec<[f64; 2]> {
    let good = |p: &[f64; 2]| p.iter().all(|v| v.is_finite()) && p[1].abs() <= 90.0;
    let vertices = list.as_slice().iter().map(|v| [v.lon_deg, v.lat_deg]);
    vertices.filter(good).collect()
}
