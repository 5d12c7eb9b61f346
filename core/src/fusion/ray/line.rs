//! A line as the borders of columns and rows that it crosses, counted without walking it.

use crate::fusion::Geometry;
use crate::units::Point;

/// A line across a grid, as the borders it crosses.
pub(super) struct Line {
    pub(super) x: Axis,
    pub(super) y: Axis,
    /// The side of a cell in half millimetres.
    pub(super) side: i64,
}

/// One axis of a line: its start, extent and cells, in half millimetres from the grid's corner.
pub(super) struct Axis {
    /// The line's extent and whether it runs backward.
    pub(super) extent: i64,
    pub(super) backward: bool,
    /// The cell of the start, which may lie outside, and how many cells there are.
    cell: i64,
    pub(super) cells: i64,
    /// From the start to the first border ahead.
    first_border: i64,
    /// Borders between start and end.
    pub(super) borders: i64,
    /// Borders before the grid is entered; `None` if it lies behind or aside.
    borders_to_enter: Option<i64>,
}

impl Axis {
    /// The axis of a line from `start` to `end`, millimetres from the grid's corner.
    fn new(geometry: &Geometry, start: i64, end: i64, cells: u16) -> Self {
        let (cell, last) = (geometry.border_before(start), geometry.border_before(end));
        let side = double(geometry);
        let backward = end < start;
        let start = start.wrapping_mul(2).wrapping_add(1);
        let below = start.wrapping_sub(cell.wrapping_mul(side));
        let cells = i64::from(cells);
        let (first_border, to_enter) = if backward {
            (below, cell.wrapping_sub(cells).wrapping_add(1))
        } else {
            (side.wrapping_sub(below), cell.wrapping_neg())
        };
        let borders = last.abs_diff(cell).cast_signed();
        let borders_to_enter = match to_enter {
            _ if (0..cells).contains(&cell) => Some(0),
            n if n > 0 && n <= borders => Some(n),
            _ => None,
        };
        Self {
            extent: end
                .wrapping_mul(2)
                .wrapping_add(1)
                .wrapping_sub(start)
                .saturating_abs(),
            backward,
            cell,
            cells,
            first_border,
            borders,
            borders_to_enter,
        }
    }

    /// From the start to border `number`, counted from 1.
    pub(super) fn border(&self, number: i64, side: i64) -> i64 {
        self.first_border
            .wrapping_add(number.wrapping_sub(1).wrapping_mul(side))
    }

    /// Borders crossed up to and including the moment `part` / `whole` of the line.
    pub(super) fn crossed_by(&self, part: i64, whole: i64, side: i64) -> i64 {
        // Border k is crossed by then if (first + (k − 1) · side) · whole ≤ extent · part.
        let spare =
            (self.extent.wrapping_mul(part)).wrapping_sub(self.first_border.wrapping_mul(whole));
        if spare < 0 {
            return 0;
        }
        let period = side.wrapping_mul(whole);
        spare.checked_div(period).unwrap_or(0).wrapping_add(1)
    }

    /// Borders crossed up to and including the moment `other` crosses its border `number`.
    fn crossed_with(&self, other: &Self, number: i64, side: i64) -> i64 {
        self.crossed_by(other.border(number, side), other.extent, side)
    }

    /// Borders crossed before the moment `other` crosses its border `number`.
    fn crossed_strictly_before(&self, other: &Self, number: i64, side: i64) -> i64 {
        // (first + (k − 1) · side) · whole < extent · part, in integers: one less on the right.
        let spare = (self.extent.wrapping_mul(other.border(number, side)))
            .wrapping_sub(self.first_border.wrapping_mul(other.extent))
            .wrapping_sub(1);
        if spare < 0 {
            return 0;
        }
        let period = side.wrapping_mul(other.extent);
        spare.checked_div(period).unwrap_or(0).wrapping_add(1)
    }

    /// The cell after so many borders.
    pub(super) fn cell_after(&self, borders: i64) -> i64 {
        if self.backward {
            self.cell.wrapping_sub(borders)
        } else {
            self.cell.wrapping_add(borders)
        }
    }

    /// Borders up to the one that leaves the grid, if the line gets that far.
    fn borders_to_leave(&self) -> Option<i64> {
        let number = if self.backward {
            self.cell.wrapping_add(1)
        } else {
            self.cells.wrapping_sub(self.cell)
        };
        (number <= self.borders).then_some(number)
    }
}

/// The side of a cell in half millimetres.
fn double(geometry: &Geometry) -> i64 {
    i64::from(geometry.cell_size().get()).wrapping_mul(2)
}

impl Line {
    pub(super) fn new(geometry: &Geometry, from: Point, to: Point) -> Self {
        let corner = geometry.corner();
        let offset = |mm: i32, corner: i32| i64::from(mm).wrapping_sub(i64::from(corner));
        let (start, end) = (
            offset(from.x_mm(), corner.x_mm()),
            offset(to.x_mm(), corner.x_mm()),
        );
        let x = Axis::new(geometry, start, end, geometry.columns());
        let (start, end) = (
            offset(from.y_mm(), corner.y_mm()),
            offset(to.y_mm(), corner.y_mm()),
        );
        let y = Axis::new(geometry, start, end, geometry.rows());
        let side = double(geometry);
        Self { x, y, side }
    }

    /// Column and row borders crossed before the first cell inside the grid.
    pub(super) fn entry(&self) -> Option<(i64, i64)> {
        // Whichever edge of the grid is crossed last is the entry; the other axis has crossed some
        // borders of its own by then.
        match (self.x.borders_to_enter?, self.y.borders_to_enter?) {
            (0, 0) => Some((0, 0)),
            (columns, rows) => {
                let rows_by_then = match columns {
                    0 => -1, // no column border comes first
                    _ => self.y.crossed_with(&self.x, columns, self.side),
                };
                Some(if rows_by_then >= rows {
                    (columns, rows_by_then)
                } else {
                    (self.x.crossed_with(&self.y, rows, self.side), rows)
                })
            }
        }
    }

    /// Borders of both kinds crossed before the line ends or leaves the grid.
    pub(super) fn crossings_inside(&self) -> i64 {
        // An edge is crossed at border `number` of its axis. What the other axis crosses in the same
        // moment is crossed on the way out.
        let before = |leaving: &Axis, number: i64, other: &Axis| {
            let last_inside = number.wrapping_sub(1);
            let on_the_way = other.crossed_strictly_before(leaving, number, self.side);
            last_inside.wrapping_add(on_the_way)
        };
        let whole = self.x.borders.wrapping_add(self.y.borders);
        let by_column = self
            .x
            .borders_to_leave()
            .map(|n| before(&self.x, n, &self.y));
        let by_row = self
            .y
            .borders_to_leave()
            .map(|n| before(&self.y, n, &self.x));
        whole
            .min(by_column.unwrap_or(whole))
            .min(by_row.unwrap_or(whole))
    }
}
