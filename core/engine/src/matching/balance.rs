//! Several overlapping layers brought to one look at once.

use std::convert::identity;

use relievo_analysis::MapBox;
use relievo_analysis::colour::{
    Balance, BalanceError, CommonGround, Difference, MOST_PICTURES, Overlap, balance,
};
use relievo_project::{Adjust, LayerId};

use super::{refused, shown_by};
use crate::analysis::{AnalysisError, Task};
use crate::query::Questions;
use crate::sampling::Stage;

/// Several layers brought to one look.
#[derive(Clone, Debug, PartialEq)]
pub struct ColourBalance {
    /// What to set; without the held layer.
    pub layers: Vec<Balanced>,
    /// All overlaps of two layers that count.
    pub overlaps: Vec<OverlapDifference>,
}

/// A layer's part of a balance.
#[derive(Clone, Debug, PartialEq)]
pub struct Balanced {
    /// The layer.
    pub layer: LayerId,
    /// Its adjustment.
    pub adjust: Adjust,
}

/// How far two layers are apart where they overlap.
#[derive(Clone, Debug, PartialEq)]
pub struct OverlapDifference {
    /// The two layers.
    pub layers: [LayerId; 2],
    /// Places that were compared.
    pub places: usize,
    /// Before.
    pub before: Difference,
    /// After.
    pub after: Difference,
}

/// What is known of an overlap of two pictures.
struct Common {
    pictures: [usize; 2],
    ground: CommonGround,
}

impl Questions {
    /// Adjustments by which layers' own colours (before any adjustment) agree in all their overlaps at once,
    /// in the least squares of means and spreads. `held` (one of them, as it is shown) keeps its look; without
    /// it the common look is the mean one.
    ///
    /// - `area`: where to compare; anywhere when `None`.
    ///
    /// # Errors
    /// [`AnalysisError::Refused`] for fewer than two layers, more than 256, one without colours or that is
    /// named twice, and where none of them overlap; when a source cannot be read, or work was cancelled.
    pub fn balance_colours(
        &self,
        layers: &[LayerId],
        held: Option<&LayerId>,
        area: Option<&MapBox>,
        task: &Task,
    ) -> Result<ColourBalance, AnalysisError> {
        if layers.len() < 2 {
            let found = layers.len();
            return Err(refused(format!(
                "expected at least two layers, found {found}"
            )));
        }
        if layers.len() > MOST_PICTURES {
            // Before any of them is looked at.
            let (most, found) = (MOST_PICTURES, layers.len());
            return Err(refused(BalanceError::TooMany { most, found }.to_string()));
        }
        for (i, layer) in layers.iter().enumerate() {
            if layers[..i].contains(layer) {
                let found = layer.0.as_str();
                return Err(refused(format!(
                    "expected each layer once, found {found:?} twice"
                )));
            }
        }
        let held = held.map(|held| {
            layers.iter().position(|l| l == held).ok_or_else(|| {
                let found = held.0.as_str();
                refused(format!(
                    "expected to hold one of the layers, found {found:?}"
                ))
            })
        });
        let held = held.transpose()?;
        // What is made up is not balanced.
        let common = self.without_detail().overlaps(layers, held, area, task)?;
        let overlaps: Vec<Overlap> = common
            .iter()
            .map(|c| c.ground.overlap(c.pictures[0], c.pictures[1]))
            .collect();
        let found = balance(layers.len(), &overlaps, held).map_err(|e| refused(e.to_string()))?;
        let others = found.iter().zip(layers).enumerate();
        let others = others.filter(|(i, _)| Some(*i) != held);
        Ok(ColourBalance {
            layers: others
                .map(|(_, (balance, layer))| Balanced {
                    layer: layer.clone(),
                    adjust: adjust(balance),
                })
                .collect(),
            overlaps: common
                .iter()
                .map(|c| difference(c, layers, &found, held))
                .collect(),
        })
    }

    /// Places that two layers have in common, for all pairs of layers that have enough.
    fn overlaps(
        &self,
        layers: &[LayerId],
        held: Option<usize>,
        area: Option<&MapBox>,
        task: &Task,
    ) -> Result<Vec<Common>, AnalysisError> {
        let nodes: Result<Vec<_>, _> = layers
            .iter()
            .enumerate()
            .map(|(i, layer)| {
                let stage = if Some(i) == held {
                    Stage::Adjusted
                } else {
                    Stage::Source
                };
                self.coloured(layer, stage)
            })
            .collect();
        let nodes = nodes?;
        let mut common = Vec::new();
        let count = layers.len() * (layers.len() - 1) / 2;
        let mut done = 0;
        for second in 1..layers.len() {
            for first in 0..second {
                let part = Task {
                    cancel: task.cancel,
                    progress: &|share| (task.progress)((f64::from(done) + share) / count as f64),
                };
                let pairs = self.colour_pairs([nodes[first], nodes[second]], area, &part)?;
                done += 1;
                // Corners that touch say nothing of either.
                if let Ok(ground) = CommonGround::of(&pairs) {
                    common.push(Common {
                        pictures: [first, second],
                        ground,
                    });
                }
            }
        }
        if common.is_empty() {
            let line = "expected layers that overlap, found none that do";
            return Err(refused(line.to_owned()));
        }
        Ok(common)
    }
}

fn difference(
    common: &Common,
    layers: &[LayerId],
    found: &[Balance],
    held: Option<usize>,
) -> OverlapDifference {
    // The held one is compared as it is shown.
    let [first, second] = common.pictures.map(|i| {
        shown_by(&if Some(i) == held {
            Adjust::default()
        } else {
            adjust(&found[i])
        })
    });
    OverlapDifference {
        layers: common.pictures.map(|i| layers[i].clone()),
        places: common.ground.places(),
        before: common.ground.difference(identity, identity),
        after: common.ground.difference(first, second),
    }
}

fn adjust(balance: &Balance) -> Adjust {
    Adjust {
        gain: balance.gain.map(|v| v.clamp(0.0, super::MOST)),
        offset: balance.offset.map(|v| v.clamp(-super::MOST, super::MOST)),
        ..Adjust::default()
    }
}
