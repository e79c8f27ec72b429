//! Features of a drawing, and what is known of each.

use std::sync::{Arc, OnceLock};

use glam::DVec2;
use relievo_planet::Planet;

use crate::features::Features;
use crate::style::Style;

/// Features of a drawing, without some of them.
#[derive(Clone, Debug)]
pub(super) struct Sheet {
    pub(super) features: Arc<Features>,
    /// Those that are left out, rising.
    pub(super) hidden: Vec<usize>,
    /// The look of each feature; empty: all have the first.
    look_of: Arc<[u16]>,
    /// Length of each line or ring from its first vertex to each of its vertices, metres; made when
    /// dashes are drawn first.
    lengths: Arc<OnceLock<Vec<f64>>>,
}

impl Sheet {
    pub(super) fn new(features: Arc<Features>, style: &Style) -> Self {
        let look_of = style.by.iter().flat_map(|by| {
            (0..features.len()).map(|feature| {
                let value = features.property(feature, &by.property);
                let class = by.classes.iter().position(|c| c.of.contains(value));
                class.map_or(0, |c| u16::try_from(c + 1).unwrap_or(0))
            })
        });
        Self {
            look_of: look_of.collect(),
            hidden: Vec::new(),
            lengths: Arc::default(),
            features,
        }
    }

    pub(super) fn look(&self, feature: usize) -> usize {
        self.look_of.get(feature).map_or(0, |l| usize::from(*l))
    }

    pub(super) fn hides(&self, feature: usize) -> bool {
        self.hidden.binary_search(&feature).is_ok()
    }

    /// Length from a part's first vertex to each vertex.
    pub(super) fn lengths(&self, planet: &Planet) -> &[f64] {
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
                            let d = (*v - b) * planet.metres_per_radian(colat);
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
