//! Marching squares over rows of samples.

use std::collections::BTreeMap;

use crate::contours::join::{Chain, Segment, join};
use crate::ground::AnalysisError;

/// Segments of contours, by the index of their height.
///
/// Node (column, row) counts from the rectangle's first sample; edge `2 · node` runs from a node to
/// its eastern neighbour, `2 · node + 1` to its southern one.
pub(crate) struct Segments {
    width: i64,
    /// Whether the last column's eastern neighbour is the first one.
    around: bool,
    interval_m: f64,
    base_m: f64,
    most: usize,
    count: usize,
    by_level: BTreeMap<i64, Vec<Segment>>,
}

/// Corners of a cell clockwise from the north-west, and their offsets.
const CORNERS: [(i64, i64); 4] = [(0, 0), (1, 0), (1, 1), (0, 1)];

impl Segments {
    pub(crate) fn new(width: i64, around: bool, interval_m: f64, base_m: f64, most: usize) -> Self {
        Self {
            width,
            around,
            interval_m,
            base_m,
            most,
            count: 0,
            by_level: BTreeMap::new(),
        }
    }

    /// Adds the cells between two rows of samples; `row` is the northern one's.
    pub(crate) fn row(
        &mut self,
        row: i64,
        north: &[f32],
        south: &[f32],
    ) -> Result<(), AnalysisError> {
        let width = self.width as usize;
        let cells = if self.around { width } else { width - 1 };
        for column in 0..cells {
            let east = (column + 1) % width;
            let corners = [north[column], north[east], south[east], south[column]].map(f64::from);
            self.cell(column as i64, row, corners)?;
        }
        Ok(())
    }

    /// Adds the cell whose north-western node is (column, row).
    pub(crate) fn cell(
        &mut self,
        column: i64,
        row: i64,
        corners: [f64; 4],
    ) -> Result<(), AnalysisError> {
        let low = corners.iter().copied().fold(f64::INFINITY, f64::min);
        let high = corners.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if corners.iter().any(|h| !h.is_finite()) {
            return Ok(());
        }
        // Heights h with low < h ≤ high cross the cell: a corner at h counts as above.
        let index = |h: f64| libm::floor((h - self.base_m) / self.interval_m);
        let (first, last) = (index(low), index(high));
        if last - first > self.most as f64 || last.abs().max(first.abs()) > 1e15 {
            return Err(self.too_many());
        }
        for level in first as i64..=last as i64 {
            let at_m = self.base_m + level as f64 * self.interval_m;
            if low < at_m && at_m <= high {
                self.cross(column, row, corners, level, at_m)?;
            }
        }
        Ok(())
    }

    fn too_many(&self) -> AnalysisError {
        AnalysisError::Refused(format!(
            "expected contours of at most {} segments, found more: take a larger interval than {} m or a smaller area",
            self.most, self.interval_m
        ))
    }

    fn cross(
        &mut self,
        column: i64,
        row: i64,
        corners: [f64; 4],
        level: i64,
        at_m: f64,
    ) -> Result<(), AnalysisError> {
        let above = corners.map(|h| h >= at_m);
        // Edges clockwise: i runs from corner i to corner i + 1.
        let (mut rising, mut falling) = ([0; 2], [0; 2]);
        let (mut rises, mut falls) = (0, 0);
        for i in 0..4 {
            match (above[i], above[(i + 1) % 4]) {
                (false, true) => {
                    rising[rises] = i;
                    rises += 1;
                }
                (true, false) => {
                    falling[falls] = i;
                    falls += 1;
                }
                (true, true) | (false, false) => {}
            }
        }
        // A segment from the edge where the boundary rises to one where it falls has the high
        // ground to its left.
        let pairs = if rises == 1 {
            vec![(rising[0], falling[0])]
        } else {
            let joined = corners.iter().sum::<f64>() / 4.0 >= at_m;
            // Around a low corner the falling edge comes just before the rising one.
            rising[..rises]
                .iter()
                .map(|rise| {
                    let wanted = if joined {
                        (rise + 3) % 4
                    } else {
                        (rise + 1) % 4
                    };
                    (*rise, wanted)
                })
                .collect()
        };
        for (rise, fall) in pairs {
            if self.count >= self.most {
                return Err(self.too_many());
            }
            self.count += 1;
            let (from, from_share) = self.edge(column, row, rise, &corners, at_m);
            let (to, to_share) = self.edge(column, row, fall, &corners, at_m);
            self.by_level.entry(level).or_default().push(Segment {
                from,
                to,
                from_share,
                to_share,
            });
        }
        Ok(())
    }

    /// Name of a cell's edge, and where along it, from its western or northern node, a height lies.
    fn edge(
        &self,
        column: i64,
        row: i64,
        edge: usize,
        corners: &[f64; 4],
        at_m: f64,
    ) -> (u64, f64) {
        // The node at which the edge begins, and the one at which it ends.
        let (a, b) = match edge {
            0 => (0, 1),
            1 => (1, 2),
            2 => (3, 2),
            _ => (0, 3),
        };
        let (dx, dy) = CORNERS[a];
        let mut node_column = column + dx;
        if self.around {
            node_column %= self.width;
        }
        let node = (row + dy) * self.width + node_column;
        let vertical = u64::from(edge % 2 == 1);
        let share = (at_m - corners[a]) / (corners[b] - corners[a]);
        (2 * node as u64 + vertical, share.clamp(0.0, 1.0))
    }

    /// The contours of each height: indices of heights, lowest first.
    pub(crate) fn chains(self) -> impl Iterator<Item = (i64, Vec<Chain>)> {
        let width = self.width as u64;
        self.by_level
            .into_iter()
            .map(move |(level, segments)| (level, join(&segments, width)))
    }
}
