//! Features into blocks of samples.
//!
//! Everything is computed in f64, in the samples of one *cell* (256 × 256 samples whose indices
//! are multiples of 256), clipped to it, rounded to 1/256 sample and only then given to tiny-skia,
//! which fills it. tiny-skia's fills move with whole samples, but where it clips an edge its slope
//! changes in the last bit; because cells are the same whatever block is asked for, a whole equals
//! its parts bit for bit. Strokes are outlined here: in metres on the ground, with the scale of
//! their own latitude.

mod canvas;
mod hatch;
mod outline;
mod plane;
mod stroke;
mod symbol;

use core::ops::ControlFlow;
use std::sync::{Arc, OnceLock};

use glam::{DVec2, I64Vec2};
use relievo_planet::{Grid, Lattice, Planet, SampleRect};
use relievo_raster::{Bands, Block, Cancel};

use crate::features::{Features, Hit, Shape};
use crate::style::{Colour, Style};
use canvas::{CELL, Canvas};
use plane::{Plane, Window};

/// Why a block could not be drawn.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DrawError {
    /// Nobody wants it any more.
    #[error("cancelled")]
    Cancelled,
    /// The grid's coordinate system is not known.
    #[error("{0}")]
    Grid(String),
}

/// What a feature is drawn with, besides what all have in common.
#[derive(Clone, Copy, Debug)]
struct Look {
    fill: Option<Colour>,
    stroke: Option<Colour>,
}

/// Features with a style, ready to be drawn.
#[derive(Debug)]
pub struct Drawing {
    features: Arc<Features>,
    style: Style,
    planet: Planet,
    /// The style's own look, then those of its classes.
    looks: Vec<Look>,
    /// The look of each feature; empty: all have the first.
    look_of: Vec<u16>,
    /// Name of everything but the features.
    name: [u8; 32],
    /// Length of each line or ring from its first vertex to each of its vertices, metres; made when
    /// dashes are drawn first.
    lengths: OnceLock<Vec<f64>>,
}

impl Drawing {
    /// Features in a style on a planet.
    pub fn new(features: Arc<Features>, style: Style, planet: Planet) -> Self {
        let own = Look {
            fill: style.fill,
            stroke: style.stroke,
        };
        let mut looks = vec![own];
        let mut look_of = Vec::new();
        if let Some(by) = &style.by {
            looks.extend(by.classes.iter().map(|class| Look {
                fill: class.fill.or(own.fill),
                stroke: class.stroke.or(own.stroke),
            }));
            look_of = (0..features.len())
                .map(|feature| {
                    let value = features.property(feature, &by.property);
                    let class = by.classes.iter().position(|c| c.of.contains(value));
                    class.map_or(0, |c| u16::try_from(c + 1).unwrap_or(0))
                })
                .collect();
        }
        let common = Style {
            by: None,
            ..style.clone()
        };
        let text = format!("{common:?} {planet:?}");
        let name = *blake3::hash(text.as_bytes()).as_bytes();
        Self {
            features,
            style,
            planet,
            looks,
            look_of,
            name,
            lengths: OnceLock::new(),
        }
    }

    /// The features.
    pub fn features(&self) -> &Arc<Features> {
        &self.features
    }

    /// The style.
    pub fn style(&self) -> &Style {
        &self.style
    }

    /// Metres between rows of a lattice, which scale limits and pixel widths count by; `None` where
    /// its coordinate system is not known.
    pub fn sample_m(&self, lattice: &Lattice) -> Option<f64> {
        Plane::new(lattice, self.planet).ok().map(|p| p.sample_m)
    }

    /// Whether some feature may show in a grid. `false` is certain.
    pub fn reaches(&self, grid: &Grid) -> bool {
        let mut any = false;
        self.reaching(grid, |_| {
            any = true;
            ControlFlow::Break(())
        });
        any
    }

    /// Number of features that may show in a grid.
    pub fn count(&self, grid: &Grid) -> usize {
        let mut count = 0;
        self.reaching(grid, |_| {
            count += 1;
            ControlFlow::Continue(())
        });
        count
    }

    /// Names what is drawn in a grid: the style, and the features that may show there. The grid
    /// itself is not part of the name.
    pub fn fingerprint(&self, grid: &Grid) -> [u8; 32] {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&self.name);
        let mut named = vec![false; self.looks.len()];
        self.reaching(grid, |feature| {
            let look = self.look(feature);
            hasher.update(&self.features.hash_of(feature));
            hasher.update(&(look as u16).to_le_bytes());
            if !named[look] {
                named[look] = true;
                let Look { fill, stroke } = self.looks[look];
                for colour in [fill, stroke] {
                    hasher.update(&[u8::from(colour.is_some())]);
                    for v in colour.unwrap_or_default() {
                        hasher.update(&v.to_bits().to_le_bytes());
                    }
                }
            }
            ControlFlow::Continue(())
        });
        *hasher.finalize().as_bytes()
    }

    /// Draws `grid.rect` into `out`, which has its size: straight, display-referred colours and
    /// alpha, all 0 where nothing is drawn.
    ///
    /// # Errors
    /// When asked to stop, or where the grid's system is not known.
    ///
    /// # Panics
    /// If `out` has another size or is not of colours.
    pub fn render(&self, grid: &Grid, out: &mut Block, cancel: &Cancel) -> Result<(), DrawError> {
        let rect = grid.rect;
        let size = (out.width() as i64, out.height() as i64);
        assert_eq!(
            size,
            (rect.width(), rect.height()),
            "a sample for each place"
        );
        assert_eq!(out.bands(), Bands::Colour, "colours");
        out.samples_mut().fill(0.0);
        let plane = Plane::new(&grid.lattice, self.planet).map_err(DrawError::Grid)?;
        if rect.is_empty() || !self.style.is_drawn_at(plane.sample_m) {
            return Ok(());
        }
        let cell = I64Vec2::splat(CELL as i64);
        let first = rect.min.div_euclid(cell);
        let last = (rect.max - 1).div_euclid(cell);
        let mut canvas = None;
        for row in first.y..=last.y {
            for column in first.x..=last.x {
                let origin = I64Vec2::new(column, row) * CELL as i64;
                let whole = SampleRect::at(origin.x, origin.y, CELL as i64, CELL as i64);
                let wanted = whole.intersection(&rect);
                if self.reaches(&grid.with_rect(wanted)) {
                    let canvas = canvas.get_or_insert_with(Canvas::new);
                    canvas.clear();
                    self.paint(&plane, whole, canvas, cancel)?;
                    canvas.copy_to(wanted.shift(-origin), wanted.shift(-rect.min), out);
                }
            }
        }
        Ok(())
    }

    /// Calls `found` with the features that may show in a grid.
    fn reaching(&self, grid: &Grid, mut found: impl FnMut(usize) -> ControlFlow<()>) {
        let Ok(plane) = Plane::new(&grid.lattice, self.planet) else {
            return;
        };
        if grid.rect.is_empty() || !self.style.is_drawn_at(plane.sample_m) {
            return;
        }
        let reach_m = self.style.reach_m(plane.sample_m);
        let areas = self.style.hatch.is_some() || self.looks.iter().any(|l| l.fill.is_some());
        let mut last = None;
        for window in plane.windows(grid.rect) {
            let box_ = plane.grown(&window.bounds, reach_m);
            let mut ended = false;
            self.features.reaching(&box_, areas, |feature| {
                // Two windows of one grid see a feature that lies over a pole.
                if last == Some(feature) {
                    return ControlFlow::Continue(());
                }
                last = Some(feature);
                let flow = found(feature);
                ended = flow.is_break();
                flow
            });
            if ended {
                return;
            }
        }
    }

    fn look(&self, feature: usize) -> usize {
        self.look_of.get(feature).map_or(0, |l| usize::from(*l))
    }

    /// Draws a cell.
    fn paint(
        &self,
        plane: &Plane,
        cell: SampleRect,
        canvas: &mut Canvas,
        cancel: &Cancel,
    ) -> Result<(), DrawError> {
        let reach_m = self.style.reach_m(plane.sample_m);
        let windows = plane.windows(cell);
        let mut by_look: Vec<Vec<(usize, Hit)>> = vec![Vec::new(); self.looks.len()];
        for (w, window) in windows.iter().enumerate() {
            for hit in self.features.hits(&plane.grown(&window.bounds, reach_m)) {
                let feature = self.features.part(hit.part).feature as usize;
                by_look[self.look(feature)].push((w, hit));
            }
        }
        let painter = Painter {
            drawing: self,
            plane,
            windows: &windows,
            reach_m,
            cancel,
        };
        let looks = || {
            self.looks
                .iter()
                .zip(&by_look)
                .filter(|(_, h)| !h.is_empty())
        };
        for (look, hits) in looks() {
            if let Some(colour) = look.fill {
                painter.fill(hits, canvas)?;
                canvas.blend(colour, 1.0);
            }
        }
        if let Some(hatch) = &self.style.hatch {
            for (_, hits) in looks() {
                painter.fill(hits, canvas)?;
                let fade = hatch::pattern(hatch, plane, cell, self.middle_lat(), canvas);
                canvas.blend(hatch.colour, fade);
            }
        }
        let width_m = self.style.stroke_width.map(|w| w.metres(plane.sample_m));
        if let Some((colour, outside)) = self.style.casing {
            let width_m = width_m.unwrap_or(0.0) + 2.0 * outside.metres(plane.sample_m);
            for (_, hits) in looks() {
                let fade = painter.stroke(hits, width_m, false, canvas)?;
                canvas.blend(colour, fade);
            }
        }
        for (look, hits) in looks() {
            if let (Some(colour), Some(width_m)) = (look.stroke, width_m) {
                let fade = painter.stroke(hits, width_m, true, canvas)?;
                canvas.blend(colour, fade);
            }
        }
        if let Some(symbol) = self.style.symbol {
            for (look, hits) in looks() {
                if let Some(colour) = look.fill {
                    let fade = painter.symbols(hits, &symbol, canvas)?;
                    canvas.blend(colour, fade);
                }
                if let (Some(colour), Some(width_m)) = (look.stroke, width_m) {
                    let fade = painter.symbol_outlines(hits, &symbol, width_m, canvas)?;
                    canvas.blend(colour, fade);
                }
            }
        }
        Ok(())
    }

    /// Latitude at which hatches have their stated angle.
    fn middle_lat(&self) -> f64 {
        self.features.bounds().map_or(0.0, |b| b.centre().y)
    }

    /// Length from a part's first vertex to each vertex.
    fn lengths(&self) -> &[f64] {
        self.lengths.get_or_init(|| {
            let features = &self.features;
            let mut lengths = Vec::with_capacity(features.vertices());
            for feature in 0..features.len() {
                for outline in features.outlines(feature) {
                    let mut length_m = 0.0;
                    let mut before: Option<DVec2> = None;
                    for v in outline.lonlat_rad {
                        if let Some(b) = before {
                            let colat = core::f64::consts::FRAC_PI_2 - 0.5 * (b.y + v.y);
                            let d = (*v - b) * self.planet.metres_per_radian(colat);
                            length_m += libm::hypot(d.x, d.y);
                        }
                        lengths.push(length_m);
                        before = Some(*v);
                    }
                }
            }
            lengths
        })
    }
}

/// Draws the parts of one cell into its mask.
struct Painter<'a> {
    drawing: &'a Drawing,
    plane: &'a Plane<'a>,
    windows: &'a [Window],
    reach_m: f64,
    cancel: &'a Cancel,
}

impl Painter<'_> {
    /// Calls `draw` with every part of the wanted kinds.
    fn each(
        &self,
        hits: &[(usize, Hit)],
        wanted: impl Fn(Shape) -> bool,
        mut draw: impl FnMut(&Window, Hit),
    ) -> Result<(), DrawError> {
        for (i, (window, hit)) in hits.iter().enumerate() {
            if i.is_multiple_of(256) && self.cancel.is_cancelled() {
                return Err(DrawError::Cancelled);
            }
            if wanted(self.drawing.features.part(hit.part).shape) {
                draw(&self.windows[*window], *hit);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
