//! Features into blocks of samples.
//!
//! Everything is computed in f64, in the samples of one *cell* (256 × 256 samples whose indices
//! are multiples of 256), and covers 8 × 8 points of each sample. Because cells are the same whatever
//! block is asked for, a whole equals its parts bit for bit. Strokes are outlined here: in metres on
//! the ground, with the scale of their own latitude.

mod blot;
mod canvas;
mod hatch;
mod outline;
mod plane;
mod raster;
mod sheet;
mod stroke;
mod symbol;

use core::ops::ControlFlow;
use std::sync::Arc;

use glam::I64Vec2;
use parking_lot::Mutex;
use relievo_planet::{Grid, GridMemory, Lattice, Planet, SampleRect};
use relievo_raster::{Bands, Block, Cancel};

use crate::features::{Features, Hit, Part, Shape};
use crate::style::{Colour, Style};
use canvas::{CELL, Canvas};
use plane::{Plane, Window};
use sheet::Sheet;

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
    sheets: Vec<Sheet>,
    style: Style,
    planet: Planet,
    /// The style's own look, then those of its classes.
    looks: Vec<Look>,
    /// Name of everything but the features.
    name: [u8; 32],
    /// The drawing that this one differs from by a few features.
    base: Option<Arc<Self>>,
    /// Names of what shows in grids that were asked about; `None` where nothing does.
    known: Mutex<GridMemory<Option<[u8; 32]>>>,
}

/// Grids for which a drawing remembers what shows there: those of a few views.
const MOST_GRIDS: usize = 8192;

impl Drawing {
    /// Features in a style on a planet.
    pub fn new(features: Arc<Features>, style: Style, planet: Planet) -> Self {
        let own = Look {
            fill: style.fill,
            stroke: style.stroke,
        };
        let classes = style.by.iter().flat_map(|by| &by.classes);
        let looks = classes.map(|class| Look {
            fill: class.fill.or(own.fill),
            stroke: class.stroke.or(own.stroke),
        });
        let common = Style {
            by: None,
            ..style.clone()
        };
        let text = format!("{common:?} {planet:?}");
        Self {
            looks: core::iter::once(own).chain(looks).collect(),
            sheets: vec![Sheet::new(features, &style)],
            style,
            planet,
            name: *blake3::hash(text.as_bytes()).as_bytes(),
            base: None,
            known: Mutex::new(GridMemory::new(MOST_GRIDS)),
        }
    }

    /// The same drawing with other features instead of some of its own, which costs no more than
    /// those: equal, also in its names, to a drawing of all that are left. `replaced` are positions
    /// among [`Self::features`], rising. `None` for styles to which the order of features or their
    /// common middle matters (with symbols or a hatch), and for a drawing that is such a patch itself.
    pub fn patched(self: &Arc<Self>, replaced: Vec<usize>, by: Arc<Features>) -> Option<Self> {
        if !self.is_unordered() || self.base.is_some() {
            return None;
        }
        let mut base = self.sheets[0].clone();
        base.hidden = replaced;
        Some(Self {
            sheets: vec![base, Sheet::new(by, &self.style)],
            style: self.style.clone(),
            looks: self.looks.clone(),
            planet: self.planet,
            name: self.name,
            base: Some(Arc::clone(self)),
            known: Mutex::new(GridMemory::new(MOST_GRIDS)),
        })
    }

    /// Whether features of a look are one shape, in whatever order they come.
    fn is_unordered(&self) -> bool {
        self.style.symbol.is_none() && self.style.hatch.is_none()
    }

    /// The features that it was made of.
    pub fn features(&self) -> &Arc<Features> {
        &self.sheets[0].features
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
        self.shown(grid).is_some()
    }

    /// [`Self::reaches`] for a grid that is not asked about again.
    fn reaches_once(&self, grid: &Grid) -> bool {
        let mut any = false;
        self.reaching(grid, |_, _| {
            any = true;
            ControlFlow::Break(())
        });
        any
    }

    /// Number of features that may show in a grid.
    pub fn count(&self, grid: &Grid) -> usize {
        let mut count = 0;
        self.reaching(grid, |_, _| {
            count += 1;
            ControlFlow::Continue(())
        });
        count
    }

    /// Names what is drawn in a grid: the style, and the features that may show there. The grid
    /// itself is not part of the name.
    pub fn fingerprint(&self, grid: &Grid) -> [u8; 32] {
        self.shown(grid).unwrap_or(self.name)
    }

    /// Name of what shows in a grid, remembered; `None` where nothing does.
    fn shown(&self, grid: &Grid) -> Option<[u8; 32]> {
        if let Some(known) = self.known.lock().get(grid) {
            return *known;
        }
        let shown = match &self.base {
            Some(base) if !self.differs_in(grid) => base.shown(grid),
            _ => self.look_at(grid),
        };
        let mut known = self.known.lock();
        // Another thread may have been quicker.
        if known.get(grid).is_none() {
            known.insert(grid, shown);
        }
        shown
    }

    /// Whether a patch may show something else in a grid than what it is a patch of. `false` is
    /// certain.
    fn differs_in(&self, grid: &Grid) -> bool {
        let [base, added] = &self.sheets[..] else {
            return false;
        };
        let Some(windows) = self.windows(grid) else {
            return false;
        };
        windows.iter().any(|window| {
            let hidden = base.hidden.iter().map(|i| base.features.bounds_of(*i));
            let added = (0..added.features.len()).map(|i| added.features.bounds_of(i));
            hidden.chain(added).flatten().any(|b| {
                b.turns_onto(&window.reached)
                    .any(|turns| b.turned(turns).overlaps(&window.reached))
            })
        })
    }

    fn look_at(&self, grid: &Grid) -> Option<[u8; 32]> {
        let mut named = vec![false; self.looks.len()];
        let mut shown = Vec::new();
        self.reaching(grid, |sheet, feature| {
            let look = sheet.look(feature);
            named[look] = true;
            shown.push((look as u16, sheet.features.hash_of(feature)));
            ControlFlow::Continue(())
        });
        if shown.is_empty() {
            return None;
        }
        if self.is_unordered() {
            shown.sort_unstable();
        }
        let mut hasher = blake3::Hasher::new();
        hasher.update(&self.name);
        for (look, _) in self.looks.iter().zip(named).filter(|(_, named)| *named) {
            for colour in [look.fill, look.stroke] {
                hasher.update(&[u8::from(colour.is_some())]);
                for v in colour.unwrap_or_default() {
                    hasher.update(&v.to_bits().to_le_bytes());
                }
            }
        }
        let mut bytes = Vec::with_capacity(shown.len() * 18);
        for (look, hash) in shown {
            bytes.extend(look.to_le_bytes());
            bytes.extend(hash);
        }
        Some(*hasher.update(&bytes).finalize().as_bytes())
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
                if self.reaches_once(&grid.with_rect(wanted)) {
                    let canvas = canvas.get_or_insert_with(Canvas::new);
                    canvas.clear();
                    self.paint(&plane, whole, canvas, cancel)?;
                    canvas.copy_to(wanted.shift(-origin), wanted.shift(-rect.min), out);
                }
            }
        }
        Ok(())
    }

    /// What a grid shows, with what reaches into it; `None` where nothing is drawn at all.
    fn windows(&self, grid: &Grid) -> Option<Vec<Window>> {
        let plane = Plane::new(&grid.lattice, self.planet).ok()?;
        let is_drawn = !grid.rect.is_empty() && self.style.is_drawn_at(plane.sample_m);
        is_drawn.then(|| plane.windows(grid.rect, self.style.reach_m(plane.sample_m)))
    }

    /// Calls `found` with the features that may show in a grid.
    fn reaching(&self, grid: &Grid, mut found: impl FnMut(&Sheet, usize) -> ControlFlow<()>) {
        let Some(windows) = self.windows(grid) else {
            return;
        };
        let areas = self.style.hatch.is_some() || self.looks.iter().any(|l| l.fill.is_some());
        for sheet in &self.sheets {
            let mut last = None;
            for window in &windows {
                let mut ended = false;
                sheet.features.reaching(&window.reached, areas, |feature| {
                    // Two windows of one grid see a feature that lies over a pole.
                    if last == Some(feature) || sheet.hides(feature) {
                        return ControlFlow::Continue(());
                    }
                    last = Some(feature);
                    let flow = found(sheet, feature);
                    ended = flow.is_break();
                    flow
                });
                if ended {
                    return;
                }
            }
        }
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
        let windows = plane.windows(cell, reach_m);
        let mut by_look: Vec<Vec<Shown>> = vec![Vec::new(); self.looks.len()];
        for sheet in &self.sheets {
            for window in &windows {
                for hit in sheet.features.hits(&window.reached) {
                    let part = sheet.features.part(hit.part);
                    let feature = part.feature as usize;
                    if !sheet.hides(feature) {
                        by_look[sheet.look(feature)].push(Shown {
                            sheet,
                            window,
                            hit,
                            part,
                        });
                    }
                }
            }
        }
        let painter = Painter {
            drawing: self,
            plane,
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
        self.features().bounds().map_or(0.0, |b| b.centre().y)
    }
}

/// A part of a feature that a cell may show.
#[derive(Clone, Copy)]
struct Shown<'a> {
    sheet: &'a Sheet,
    window: &'a Window,
    hit: Hit,
    part: &'a Part,
}

/// Draws the parts of one cell into its mask.
struct Painter<'a> {
    drawing: &'a Drawing,
    plane: &'a Plane<'a>,
    cancel: &'a Cancel,
}

impl Painter<'_> {
    /// Calls `draw` with every part of the wanted kinds.
    fn each<'s>(
        &self,
        shown: &'s [Shown<'s>],
        wanted: impl Fn(Shape) -> bool,
        mut draw: impl FnMut(&'s Shown<'s>),
    ) -> Result<(), DrawError> {
        for (i, shown) in shown.iter().enumerate() {
            if i.is_multiple_of(256) && self.cancel.is_cancelled() {
                return Err(DrawError::Cancelled);
            }
            if wanted(shown.part.shape) {
                draw(shown);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
