//! Results of measurements over all colours.

use std::sync::Arc;

use relievo_graph::NodeIndex;
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
            below = Some(self.lay_over_shown(below, top));
        }
        below
    }
}
