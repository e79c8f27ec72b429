//! Rectangles of images that are cut into cells: which cells hold which part.

use crate::file::{OverviewInfo, PixelRect};

/// The part of a wanted rectangle that one cell holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Part {
    /// Column of the cell.
    pub(crate) column: u32,
    /// Row of the cell.
    pub(crate) row: u32,
    /// Where the part begins within the cell.
    pub(crate) in_cell: (usize, usize),
    /// Where the part begins within the wanted rectangle.
    pub(crate) in_rect: (usize, usize),
    /// Columns and rows of the part.
    pub(crate) size: (usize, usize),
}

/// The parts of a rectangle in cells of so many columns and rows, row by row; none if it is empty.
pub(crate) fn parts(rect: PixelRect, cell: (u32, u32)) -> impl Iterator<Item = Part> {
    let columns = spans(rect.x, rect.width, cell.0);
    let rows = spans(rect.y, rect.height, cell.1);
    rows.flat_map(move |row| {
        columns.clone().map(move |column| Part {
            column: column.cell,
            row: row.cell,
            in_cell: (column.in_cell, row.in_cell),
            in_rect: (column.in_rect, row.in_rect),
            size: (column.length, row.length),
        })
    })
}

/// A part along one axis.
#[derive(Clone, Copy)]
struct Span {
    cell: u32,
    in_cell: usize,
    in_rect: usize,
    length: usize,
}

fn spans(start: u32, length: u32, cell: u32) -> impl Iterator<Item = Span> + Clone {
    let (start, end, cell) = (
        u64::from(start),
        u64::from(start) + u64::from(length),
        u64::from(cell),
    );
    let cells = if length == 0 {
        0..0
    } else {
        start / cell..end.div_ceil(cell)
    };
    cells.map(move |n| {
        let (from, to) = (start.max(n * cell), end.min((n + 1) * cell));
        Span {
            cell: n as u32,
            in_cell: (from - n * cell) as usize,
            in_rect: (from - start) as usize,
            length: (to - from) as usize,
        }
    })
}

/// Checks what every reader demands of its caller.
///
/// # Panics
/// If the rectangle does not lie inside the level.
pub(crate) fn assert_inside(rect: PixelRect, size: OverviewInfo) {
    let within = |start: u32, length: u32, side: u32| {
        start.checked_add(length).is_some_and(|end| end <= side)
    };
    assert!(
        within(rect.x, rect.width, size.width) && within(rect.y, rect.height, size.height),
        "the rectangle {rect:?} lies inside the overview {size:?}"
    );
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn every_pixel_of_a_rectangle_lies_in_one_part(
            x in 0u32..50, y in 0u32..50, width in 0u32..40, height in 0u32..40, cell in (1u32..17, 1u32..17),
        ) {
            let mut seen = vec![0u8; (width * height) as usize];
            for part in parts(PixelRect { x, y, width, height }, cell) {
                prop_assert!(part.size.0 > 0 && part.size.1 > 0);
                for j in 0..part.size.1 {
                    for i in 0..part.size.0 {
                        let (u, v) = (part.in_rect.0 + i, part.in_rect.1 + j);
                        seen[v * width as usize + u] += 1;
                        let column = part.column * cell.0 + (part.in_cell.0 + i) as u32;
                        let row = part.row * cell.1 + (part.in_cell.1 + j) as u32;
                        prop_assert_eq!((column, row), (x + u as u32, y + v as u32));
                    }
                }
            }
            prop_assert!(seen.iter().all(|n| *n == 1));
        }
    }
}
