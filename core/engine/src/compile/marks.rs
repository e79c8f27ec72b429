//! Results of measurements over all colours.

use std::sync::Arc;

use relievo_graph::NodeIndex;
use relievo_graph::nodes::{BlendMode, Constant, Overlay};
use relievo_raster::SampleType;

use super::Compiler;
use crate::marks::Mark;
use crate::scene::Detail;

impl Compiler<'_> {
    /// Marks over everything else, the first at the bottom.
    pub(super) fn marks(
        &mut self,
        marks: &[Mark],
        mut below: Option<NodeIndex>,
    ) -> Option<NodeIndex> {
        for mark in marks {
            let top = self.builder.add(Arc::clone(&mark.node), &[]);
            self.builder.cut(top, SampleType::Rgba8);
            self.details.push(Detail::everywhere(top, mark.finest));
            let base = match below {
                Some(below) => {
                    // So that a tile that no mark touches is the one that is shown without.
                    self.builder.cut(below, SampleType::Rgba8);
                    below
                }
                None => self.builder.add(Arc::new(Constant::colour([0.0; 4])), &[]),
            };
            let overlay = Overlay::new(BlendMode::Normal, 1.0, false);
            below = Some(self.builder.add(Arc::new(overlay), &[base, top]));
        }
        below
    }
}
