//! The cells that a straight line crosses, in order, in integers.

mod line;

use super::{Cell, Geometry};
use crate::narrow::wrapping_u32;
use crate::units::{Millimeters, Point};
use core::num::Wrapping;
use line::Line;

/// The cells between two places, each once, in the order in which the line crosses them.
///
/// Exact: a cell is visited if and only if the line between the centres of the two square
/// millimetres runs through its inside. Where the line passes through the very corner of four
/// cells it goes from one to the opposite one. Mirrored lines visit mirrored cells. Outside the grid
/// nothing is walked: entry and exit are computed, whatever the distance.
///
/// Method: Amanatides and Woo's traversal, its two border distances kept as one 64-bit product, in
/// half millimetres from the grid's corner. In these units the ends are odd and the borders even, so
/// no end lies on a border.
///
/// Cost: four to ten divisions a ray, one comparison and two additions of 64 bits a cell.
///
/// ```
/// use certainty_core::fusion::{Geometry, Ray};
/// use certainty_core::units::{Millimeters, Point};
///
/// let grid = Geometry::try_new(3, 2, Millimeters::new(100), Point::ORIGIN)?;
/// let ray = Ray::new(&grid, Point::from_mm(-500, 50), Point::from_mm(250, 50));
/// let cells: Vec<_> = ray.map(|cell| cell.index()).collect();
/// assert_eq!(cells, [0, 1, 2]);
/// # Ok::<(), certainty_core::fusion::GeometryError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Ray {
    /// Whether there is a cell to visit.
    under_way: bool,
    /// The index of that cell.
    index: u32,
    /// Borders of columns and rows still to be crossed inside the grid.
    crossings: u32,
    /// Borders crossed before the grid was entered.
    skipped: u32,
    /// What crossing a column or row border adds to the index.
    column_step: u32,
    row_step: u32,
    /// Below zero while a column border comes next, above while a row border does.
    race: Wrapping<i64>,
    /// A cell's side times the line's extent along x and y.
    by_dx: Wrapping<i64>,
    by_dy: Wrapping<i64>,
}

impl Ray {
    /// Creates the walk from `from` to `to`, both included where they are inside the grid.
    #[must_use]
    pub fn new(geometry: &Geometry, from: Point, to: Point) -> Self {
        let line = Line::new(geometry, from, to);
        Self::along(geometry, &line).unwrap_or(Self::NOWHERE)
    }

    /// Creates the walk from `from` to `to`, and the number of borders that it crosses, inside the
    /// grid, on the first `part` / `whole` of the way.
    pub(super) fn with_part(
        geometry: &Geometry,
        from: Point,
        to: Point,
        part: Millimeters,
        whole: Millimeters,
    ) -> (Self, u32) {
        let line = Line::new(geometry, from, to);
        let ray = Self::along(geometry, &line).unwrap_or(Self::NOWHERE);
        // At most 2^30 half millimetres times 2^28 mm.
        let (part, whole) = (i64::from(part.get()), i64::from(whole.get()));
        let columns = line
            .x
            .crossed_by(part, whole, line.side)
            .min(line.x.borders);
        let rows = line
            .y
            .crossed_by(part, whole, line.side)
            .min(line.y.borders);
        let crossings = wrapping_u32(columns.wrapping_add(rows)).saturating_sub(ray.skipped);
        (ray, crossings)
    }

    /// The walk along `line` from where it enters the grid, if it does.
    fn along(geometry: &Geometry, line: &Line) -> Option<Self> {
        let Line { x, y, side } = line;
        let (columns, rows) = line.entry()?;
        let (column, row) = (x.cell_after(columns), y.cell_after(rows));
        if !(0..x.cells).contains(&column) || !(0..y.cells).contains(&row) {
            return None; // the line passes the grid by
        }
        let (dx, dy) = (Wrapping(x.extent), Wrapping(y.extent));
        let skipped = columns.wrapping_add(rows);
        let signed = |step: u32, backward: bool| if backward { step.wrapping_neg() } else { step };
        let cell = geometry.cell_inside(wrapping_u32(column), wrapping_u32(row));
        Some(Self {
            under_way: true,
            index: cell.number(),
            crossings: wrapping_u32(line.crossings_inside().wrapping_sub(skipped)),
            skipped: wrapping_u32(skipped),
            column_step: signed(1, x.backward),
            row_step: signed(geometry.columns().into(), y.backward),
            race: Wrapping(x.border(columns.wrapping_add(1), *side)) * dy
                - Wrapping(y.border(rows.wrapping_add(1), *side)) * dx,
            by_dx: Wrapping(*side) * dx,
            by_dy: Wrapping(*side) * dy,
        })
    }

    /// The walk that visits no cell.
    const NOWHERE: Self = Self {
        under_way: false,
        index: 0,
        crossings: 0,
        skipped: 0,
        column_step: 0,
        row_step: 0,
        race: Wrapping(0),
        by_dx: Wrapping(0),
        by_dy: Wrapping(0),
    };

    /// Returns how many borders are still to be crossed inside the grid.
    pub(super) const fn crossings_left(&self) -> u32 {
        self.crossings
    }

    /// Visits the cells that the line leaves by its next `crossings` borders.
    pub(super) const fn run(&mut self, crossings: u32) -> Run<'_> {
        Run {
            last: self.crossings.saturating_sub(crossings),
            ray: self,
        }
    }

    /// Crosses the next border, or two at once at their corner; there must be one left.
    #[inline]
    fn cross(&mut self) {
        if self.race.0 == 0 {
            // A tie: through the corner to the opposite cell.
            self.crossings = self.crossings.saturating_sub(2);
            self.index = (self.index)
                .wrapping_add(self.column_step)
                .wrapping_add(self.row_step);
            self.race += self.by_dy - self.by_dx;
            return;
        }
        // All ones where a column border comes next. No branch: on a slanted line no processor could
        // guess it.
        let column = self.race >> 63;
        let narrow = wrapping_u32(column.0);
        self.crossings = self.crossings.wrapping_sub(1);
        let either = self.column_step.wrapping_sub(self.row_step);
        self.index = (self.index)
            .wrapping_add(self.row_step)
            .wrapping_add(either & narrow);
        self.race += ((self.by_dx + self.by_dy) & column) - self.by_dx;
    }
}

impl Iterator for Ray {
    type Item = Cell;

    #[inline]
    fn next(&mut self) -> Option<Cell> {
        self.under_way.then(|| {
            let cell = Cell::from_index(self.index);
            self.under_way = self.crossings > 0;
            if self.under_way {
                self.cross();
            }
            cell
        })
    }

    #[inline]
    fn fold<B, F: FnMut(B, Cell) -> B>(mut self, init: B, mut visit: F) -> B {
        if !self.under_way {
            return init;
        }
        // All but the last cell without asking more than once whether there is another.
        let all = self.crossings;
        let folded = self.run(all).fold(init, &mut visit);
        visit(folded, Cell::from_index(self.index))
    }
}

impl core::iter::FusedIterator for Ray {}

/// The next cells of a [`Ray`], which goes on behind them.
#[derive(Debug)]
pub(super) struct Run<'a> {
    ray: &'a mut Ray,
    last: u32,
}

impl Iterator for Run<'_> {
    type Item = Cell;

    #[inline]
    fn next(&mut self) -> Option<Cell> {
        (self.ray.crossings > self.last).then(|| {
            let cell = Cell::from_index(self.ray.index);
            self.ray.cross();
            cell
        })
    }

    #[inline]
    fn fold<B, F: FnMut(B, Cell) -> B>(self, init: B, mut visit: F) -> B {
        // On a copy, which no store of the visitor can reach: its state stays in registers.
        let mut ray = self.ray.clone();
        let mut folded = init;
        while ray.crossings > self.last {
            folded = visit(folded, Cell::from_index(ray.index));
            ray.cross();
        }
        *self.ray = ray;
        folded
    }
}

#[cfg(test)]
mod tests;
