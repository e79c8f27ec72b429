//! A layer's colours matched to what lies below it, or to another layer; several layers balanced at once.

mod balance;

use std::convert::identity;
use std::sync::Arc;

use glam::{DVec2, I64Vec2};
use relievo_analysis::MapBox;
use relievo_analysis::colour::{
    ColourChange, ColourFit, ColourPair, CommonGround, Difference, MatchMethod,
};
use relievo_graph::NodeIndex;
use relievo_graph::nodes::Adjust as AdjustNode;
use relievo_planet::{Grid, GridCrs, Lattice, SampleRect};
use relievo_project::{Adjust, CurvePoint, Extra, LayerId, ToneCurves};
use relievo_raster::Bands;

use crate::analysis::{AnalysisError, Task, failed};
use crate::compile::adjustment;
use crate::query::Questions;
use crate::sampling::Stage;

pub use balance::{Balanced, ColourBalance, OverlapDifference};

/// Columns and rows of the places that are compared.
const PLACES: I64Vec2 = I64Vec2::new(256, 256);
/// Rows that are evaluated at once.
const BAND: i64 = 16;
/// Cells along a side by which the common area is closed in on.
const CELLS: i64 = 8;
/// Most that gains and offsets of a project can be.
const MOST: f64 = 16.0;
/// Below this a place is not covered.
const COVERED: f32 = 0.99;

/// All of the map.
const WHOLE: MapBox = MapBox {
    west_rad: -core::f64::consts::PI,
    east_rad: core::f64::consts::PI,
    north_colat_rad: 0.0,
    south_colat_rad: core::f64::consts::PI,
};

/// What a layer is to look like.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MatchTarget {
    /// What lies below it.
    Below,
    /// Another layer, as it is shown.
    Layer(LayerId),
}

/// A match: editable parameters of the layer's adjustment, and how good they are.
#[derive(Clone, Debug, PartialEq)]
pub struct ColourMatch {
    /// What to set.
    pub adjust: Adjust,
    /// How good that is.
    pub fit: ColourFit,
}

impl Questions {
    /// The adjustment by which a layer's own colours (before any adjustment) look like the target's, from
    /// about 65,000 places evenly spread over the part of `area` (anywhere when `None`) that both cover.
    ///
    /// - `strength`: of the adjustment, 0 to 1.
    ///
    /// # Errors
    /// [`AnalysisError::Refused`] for a layer without colours or with nothing below, and for too few common
    /// places; when a source cannot be read, or work was cancelled.
    pub fn match_colours(
        &self,
        layer: &LayerId,
        target: &MatchTarget,
        area: Option<&MapBox>,
        (method, strength): (MatchMethod, f64),
        task: &Task,
    ) -> Result<ColourMatch, AnalysisError> {
        // What is made up is neither matched nor compared.
        let data = self.without_detail();
        let from = data.coloured(layer, Stage::Source)?;
        let to = data.target(layer, target)?;
        let pairs = data.colour_pairs([from, to], area, task)?;
        let ground = CommonGround::of(&pairs).map_err(|few| refused(few.to_string()))?;
        let adjust = adjust(&ground.change(method), method, strength);
        let fit = ground.fit(shown_by(&adjust));
        Ok(ColourMatch { adjust, fit })
    }

    /// How far a layer as it is shown is from a target, over the part of `area` that both cover; and the
    /// number of places that were compared.
    ///
    /// # Errors
    /// [`AnalysisError::Refused`] for a layer without colours or with nothing below, and for too few common
    /// places; when a source cannot be read, or work was cancelled.
    pub fn colour_difference(
        &self,
        layer: &LayerId,
        target: &MatchTarget,
        area: Option<&MapBox>,
        task: &Task,
    ) -> Result<(Difference, usize), AnalysisError> {
        let data = self.without_detail();
        let from = data.coloured(layer, Stage::Adjusted)?;
        let to = data.target(layer, target)?;
        let pairs = data.colour_pairs([from, to], area, task)?;
        let ground = CommonGround::of(&pairs).map_err(|few| refused(few.to_string()))?;
        Ok((ground.difference(identity, identity), pairs.len()))
    }

    fn target(&self, layer: &LayerId, target: &MatchTarget) -> Result<NodeIndex, AnalysisError> {
        match target {
            MatchTarget::Layer(other) => self.coloured(other, Stage::Adjusted),
            MatchTarget::Below => {
                let below = self.stage_of(layer, Stage::Below);
                let shows = |node: &NodeIndex| {
                    let known = self.scene.graph.known(*node, &grid(&WHOLE, PLACES));
                    self.has_colours(*node) && !known.is_absent(Bands::Colour)
                };
                below.filter(shows).ok_or_else(|| {
                    let found = layer.0.as_str();
                    refused(format!(
                        "expected a layer above others, found {found:?} with nothing below"
                    ))
                })
            }
        }
    }

    fn coloured(&self, layer: &LayerId, stage: Stage) -> Result<NodeIndex, AnalysisError> {
        self.stage_of(layer, stage)
            .filter(|node| self.has_colours(*node))
            .ok_or_else(|| {
                let found = layer.0.as_str();
                refused(format!(
                    "expected a shown layer with colours, found {found:?}"
                ))
            })
    }

    fn has_colours(&self, node: NodeIndex) -> bool {
        self.scene.graph.node(node).output() == Bands::Colour
    }

    /// Colours of two nodes at the same places, where both cover.
    fn colour_pairs(
        &self,
        nodes: [NodeIndex; 2],
        area: Option<&MapBox>,
        task: &Task,
    ) -> Result<Vec<ColourPair>, AnalysisError> {
        let Some(area) = self.common(nodes, area.unwrap_or(&WHOLE)) else {
            return Ok(Vec::new());
        };
        let grid = grid(&area, PLACES);
        let mut pairs = Vec::new();
        for row in (0..PLACES.y).step_by(BAND as usize) {
            let rect = SampleRect::at(0, row, PLACES.x, BAND.min(PLACES.y - row));
            let band = grid.with_rect(rect);
            let [from, to] = nodes.map(|node| self.scene.graph.evaluate(node, &band, task.cancel));
            let (from, to) = (from.map_err(failed)?, to.map_err(failed)?);
            for i in 0..from.width() * from.height() {
                let at = |block: &relievo_raster::Block| {
                    let [r, g, b, a] = [0, 1, 2, 3].map(|plane| block.plane(plane)[i]);
                    (a >= COVERED).then_some([r, g, b])
                };
                if let (Some(from), Some(to)) = (at(&from), at(&to)) {
                    pairs.push(ColourPair { from, to });
                }
            }
            (task.progress)((row + BAND).min(PLACES.y) as f64 / PLACES.y as f64);
        }
        Ok(pairs)
    }

    /// The part of an area that both nodes may cover, closed in on by their outlines; `None` where they have
    /// nothing in common.
    fn common(&self, nodes: [NodeIndex; 2], area: &MapBox) -> Option<MapBox> {
        let mut area = *area;
        for _ in 0..24 {
            let cells = grid(&area, I64Vec2::splat(CELLS));
            let (mut low, mut high) = (I64Vec2::MAX, I64Vec2::MIN);
            for y in 0..CELLS {
                for x in 0..CELLS {
                    // A cell as a picture of 16 × 16 samples.
                    let cell = cell(&cells, I64Vec2::new(x, y));
                    let absent = |node: &NodeIndex| {
                        self.scene
                            .graph
                            .known(*node, &cell)
                            .is_absent(Bands::Colour)
                    };
                    if !nodes.iter().any(absent) {
                        low = low.min(I64Vec2::new(x, y));
                        high = high.max(I64Vec2::new(x + 1, y + 1));
                    }
                }
            }
            if low == I64Vec2::MAX {
                return None;
            }
            if (high - low).min_element() * 10 > CELLS * 9 {
                break;
            }
            let step = cells.lattice.step;
            let first = cells.lattice.origin + low.as_dvec2() * step;
            let last = cells.lattice.origin + high.as_dvec2() * step;
            let closer = MapBox {
                west_rad: first.x,
                east_rad: last.x,
                north_colat_rad: first.y,
                south_colat_rad: last.y,
            };
            if closer == area {
                break;
            }
            area = closer;
        }
        Some(area)
    }
}

fn refused(line: String) -> AnalysisError {
    AnalysisError::Refused(line)
}

/// An even grid over an area.
fn grid(area: &MapBox, places: I64Vec2) -> Grid {
    let origin = DVec2::new(area.west_rad, area.north_colat_rad);
    let last = DVec2::new(area.east_rad, area.south_colat_rad);
    let lattice = Lattice {
        crs: GridCrs::Map,
        origin,
        step: ((last - origin) / places.as_dvec2()).max(DVec2::splat(1e-12)),
        columns_around: None,
    };
    Grid::new(Arc::new(lattice), SampleRect::new(I64Vec2::ZERO, places))
}

/// A sample of a grid as a grid of its own.
fn cell(cells: &Grid, at: I64Vec2) -> Grid {
    const SIDE: i64 = 16;
    let step = cells.lattice.step;
    let lattice = Lattice {
        origin: cells.lattice.origin + at.as_dvec2() * step,
        step: step / SIDE as f64,
        ..(*cells.lattice).clone()
    };
    Grid::new(Arc::new(lattice), SampleRect::at(0, 0, SIDE, SIDE))
}

/// Colours as the picture has them with an adjustment: the node itself makes them, so that what is foretold is
/// what is seen.
fn shown_by(adjust: &Adjust) -> impl Fn([f32; 3]) -> [f32; 3] + use<> {
    let node = AdjustNode::new(&adjustment(adjust));
    move |[r, g, b]| {
        let [r, g, b, _] = node.colour([r, g, b, 1.0]);
        [r, g, b]
    }
}

/// A change as parameters that a user can go on with, within their ranges.
fn adjust(change: &ColourChange, method: MatchMethod, strength: f64) -> Adjust {
    let rows = change.map.matrix.transpose().to_cols_array_2d();
    let mut adjust = Adjust {
        offset: change.map.offset.to_array().map(|v| v.clamp(-MOST, MOST)),
        strength: strength.clamp(0.0, 1.0),
        ..Adjust::default()
    };
    match method {
        MatchMethod::MeanAndSpread => {
            adjust.gain = [0, 1, 2].map(|c: usize| rows[c][c].clamp(0.0, MOST));
        }
        MatchMethod::Regression => {
            adjust.mix = rows.map(|row| row.map(|v| v.clamp(-MOST, MOST)));
        }
        MatchMethod::Histogram => {
            let point = |[input, output]: &[f64; 2]| CurvePoint {
                input: *input,
                output: *output,
                extra: Extra::new(),
            };
            adjust.curves = ToneCurves {
                channels: change
                    .curves
                    .each_ref()
                    .map(|curve| curve.iter().map(point).collect()),
                ..ToneCurves::default()
            };
        }
    }
    adjust
}
