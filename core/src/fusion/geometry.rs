//! A grid's columns, rows, cell size and corner, and the cell that contains a point.

use crate::narrow::{wrapping_u16, wrapping_u32};
use crate::units::{Millimeters, Point};
use core::fmt;

/// One cell of a grid.
///
/// Possession proves that the cell lies inside the grid whose [`Geometry`] made it: there is no other
/// way to get one. In another grid the same cell may lie outside; there it reads as *uncertain* and is
/// never written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Cell(u32);

impl Cell {
    /// Returns the cell's index in storage: rows from the lowest to the highest, each from the left.
    #[must_use]
    pub const fn index(self) -> usize {
        self.0 as usize
    }

    /// The index as 32 bits.
    pub(super) const fn number(self) -> u32 {
        self.0
    }

    /// Creates the cell at `index`, which must be inside the grid.
    pub(crate) const fn from_index(index: u32) -> Self {
        Self(index)
    }
}

/// A grid's columns, rows, cell size and corner, without its contents.
///
/// Possession proves that there is at least one cell, that a side is at most [`Geometry::MAX_SPAN`],
/// and that the whole grid lies within [`Point::LIMIT`], so that no coordinate inside it saturates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Geometry {
    columns: u16,
    rows: u16,
    cell: u32,
    corner: Point,
}

/// Why a geometry is invalid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum GeometryError {
    /// There is no column, no row, or the cells have no size.
    Empty,
    /// A side is longer than [`Geometry::MAX_SPAN`].
    TooLarge,
    /// The grid reaches beyond [`Point::LIMIT`].
    TooFar,
}

impl GeometryError {
    const fn message(self) -> &'static str {
        match self {
            Self::Empty => "a grid needs at least one column, one row and a cell size above 0 mm",
            Self::TooLarge => "a grid's side must be at most 2^28 mm (268 km)",
            Self::TooFar => "a grid must end at most 2^28 mm (268 km) from the origin",
        }
    }
}

impl fmt::Display for GeometryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.message())
    }
}

impl core::error::Error for GeometryError {}

impl Geometry {
    /// Longest side, in millimetres: 2^28.
    pub const MAX_SPAN: u32 = 1 << 28;

    /// Creates the geometry of a constant: [`Self::try_new`] that refuses at compile time.
    ///
    /// # Panics
    ///
    /// With the message of the [`GeometryError`]; in a constant that is a compile error.
    ///
    /// # Examples
    ///
    /// The grid of \[001\] §6.1:
    ///
    /// ```
    /// use certainty_core::fusion::Geometry;
    /// use certainty_core::units::{Millimeters, Point};
    ///
    /// const SMART_CAR: Geometry =
    ///     Geometry::new(17, 11, Millimeters::new(100), Point::from_mm(-850, 0));
    /// assert_eq!(SMART_CAR.cells(), 187);
    /// ```
    ///
    /// Without a column it does not compile:
    ///
    /// ```compile_fail
    /// # use certainty_core::fusion::Geometry;
    /// # use certainty_core::units::{Millimeters, Point};
    /// const EMPTY: Geometry = Geometry::new(0, 11, Millimeters::new(100), Point::ORIGIN);
    /// # let _ = EMPTY;
    /// ```
    #[must_use]
    #[expect(clippy::panic, reason = "for constants, where it is a compile error")]
    pub const fn new(columns: u16, rows: u16, cell: Millimeters, corner: Point) -> Self {
        match Self::try_new(columns, rows, cell, corner) {
            Ok(geometry) => geometry,
            Err(error) => panic!("{}", error.message()),
        }
    }

    /// Creates the geometry of `columns` by `rows` cells of side `cell`, whose lower left corner is
    /// the lower left corner of the square millimetre `corner`.
    ///
    /// # Errors
    ///
    /// [`GeometryError`] names the limit that is exceeded.
    pub const fn try_new(
        columns: u16,
        rows: u16,
        cell: Millimeters,
        corner: Point,
    ) -> Result<Self, GeometryError> {
        if columns == 0 || rows == 0 || cell.get() == 0 {
            return Err(GeometryError::Empty);
        }
        let longest = if columns > rows { columns } else { rows };
        match cell.get().checked_mul(longest as u32) {
            Some(span) if span <= Self::MAX_SPAN => {}
            _ => return Err(GeometryError::TooLarge),
        }
        // Neither product overflows: both sides are within the span.
        let right = corner
            .x_mm()
            .saturating_add_unsigned(cell.get().wrapping_mul(columns as u32));
        let upper = corner
            .y_mm()
            .saturating_add_unsigned(cell.get().wrapping_mul(rows as u32));
        if right > Point::LIMIT || upper > Point::LIMIT {
            return Err(GeometryError::TooFar);
        }
        Ok(Self {
            columns,
            rows,
            cell: cell.get(),
            corner,
        })
    }

    /// Returns the number of columns.
    #[must_use]
    pub const fn columns(&self) -> u16 {
        self.columns
    }

    /// Returns the number of rows.
    #[must_use]
    pub const fn rows(&self) -> u16 {
        self.rows
    }

    /// Returns the number of cells.
    #[must_use]
    pub const fn cells(&self) -> u32 {
        (self.columns as u32).wrapping_mul(self.rows as u32)
    }

    /// Returns the side of a cell.
    #[must_use]
    pub const fn cell_size(&self) -> Millimeters {
        Millimeters::new(self.cell)
    }

    /// Returns the lower left corner of the grid.
    #[must_use]
    pub const fn corner(&self) -> Point {
        self.corner
    }

    /// Returns the cell in `column`, counted from the left, and `row`, counted from the lowest.
    #[must_use]
    pub const fn cell(&self, column: u16, row: u16) -> Option<Cell> {
        if column < self.columns && row < self.rows {
            Some(self.cell_inside(column as u32, row as u32))
        } else {
            None
        }
    }

    /// Returns the cell that contains `place`; `None` outside the grid.
    ///
    /// ```
    /// # use certainty_core::fusion::Geometry;
    /// # use certainty_core::units::{Millimeters, Point};
    /// # let grid = Geometry::new(17, 11, Millimeters::new(100), Point::from_mm(-850, 0));
    /// assert_eq!(grid.cell_at(Point::from_mm(-850, 0)), grid.cell(0, 0));
    /// assert_eq!(grid.cell_at(Point::from_mm(-851, 0)), None); // 1 mm left of it: no wrap
    /// ```
    #[must_use]
    pub const fn cell_at(&self, place: Point) -> Option<Cell> {
        let (column, row) = self.address(place);
        if 0 <= column && column < self.columns as i64 && 0 <= row && row < self.rows as i64 {
            Some(self.cell_inside(wrapping_u32(column), wrapping_u32(row)))
        } else {
            None
        }
    }

    /// Returns the column and row of `cell`, counted from the lower left.
    #[must_use]
    pub const fn column_and_row(&self, cell: Cell) -> (u16, u16) {
        let columns = self.columns as u32;
        match (cell.0.checked_rem(columns), cell.0.checked_div(columns)) {
            (Some(column), Some(row)) => (wrapping_u16(column), wrapping_u16(row)),
            _ => (0, 0), // there is a column
        }
    }

    /// Returns the square millimetre in the middle of `cell`; the upper right one of the middle four where
    /// the cell size is even.
    #[must_use]
    pub const fn center(&self, cell: Cell) -> Point {
        let (column, row) = self.column_and_row(cell);
        let half = self.cell / 2;
        let x = (column as u32).wrapping_mul(self.cell).wrapping_add(half);
        let y = (row as u32).wrapping_mul(self.cell).wrapping_add(half);
        Point::from_mm(
            self.corner.x_mm().saturating_add_unsigned(x),
            self.corner.y_mm().saturating_add_unsigned(y),
        )
    }

    /// Returns every cell: rows from the lowest to the highest, each from the left.
    #[must_use]
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Cell> + DoubleEndedIterator + use<> {
        IndexRange(0..self.cells())
    }

    /// The column and row of a point, which may lie outside.
    pub(crate) const fn address(&self, place: Point) -> (i64, i64) {
        let x = (place.x_mm() as i64).wrapping_sub(self.corner.x_mm() as i64);
        let y = (place.y_mm() as i64).wrapping_sub(self.corner.y_mm() as i64);
        (self.border_before(x), self.border_before(y))
    }

    /// The number of whole cells below an offset from the corner.
    pub(crate) const fn border_before(&self, offset: i64) -> i64 {
        // The cell size is above zero and no offset is i64::MIN.
        match offset.checked_div_euclid(self.cell as i64) {
            Some(cells) => cells,
            None => 0,
        }
    }

    /// The cell of a column and row that are inside.
    pub(crate) const fn cell_inside(&self, column: u32, row: u32) -> Cell {
        Cell(row.wrapping_mul(self.columns as u32).wrapping_add(column))
    }
}

/// The indices of a grid's cells as cells.
struct IndexRange(core::ops::Range<u32>);

impl Iterator for IndexRange {
    type Item = Cell;

    fn next(&mut self) -> Option<Cell> {
        self.0.next().map(Cell)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = self.0.end.saturating_sub(self.0.start) as usize;
        (left, Some(left))
    }
}

impl DoubleEndedIterator for IndexRange {
    fn next_back(&mut self) -> Option<Cell> {
        self.0.next_back().map(Cell)
    }
}

impl ExactSizeIterator for IndexRange {}

#[cfg(test)]
mod tests {
    use super::*;

    fn paper_grid() -> Geometry {
        Geometry::try_new(17, 11, Millimeters::new(100), Point::from_mm(-850, 0)).unwrap()
    }

    #[test]
    fn the_cell_at_a_center_is_its_cell() {
        let grid = paper_grid();
        assert_eq!(grid.iter().len(), 187);
        for (index, cell) in grid.iter().enumerate() {
            assert_eq!(cell.index(), index);
            assert_eq!(grid.cell_at(grid.center(cell)), Some(cell));
            let (column, row) = grid.column_and_row(cell);
            assert_eq!(grid.cell(column, row), Some(cell));
        }
    }

    #[test]
    fn no_cell_exists_outside() {
        let grid = paper_grid();
        assert_eq!(grid.cell(17, 0), None);
        assert_eq!(grid.cell(0, 11), None);
        for (x, y) in [
            (850, 0),
            (-851, 0),
            (0, -1),
            (0, 1100),
            (i32::MIN, i32::MAX),
        ] {
            assert_eq!(grid.cell_at(Point::from_mm(x, y)), None, "({x}, {y})");
        }
    }

    #[test]
    fn invalid_geometries_are_refused() {
        let at = |columns, rows, cell| {
            Geometry::try_new(columns, rows, Millimeters::new(cell), Point::ORIGIN)
        };
        assert_eq!(at(0, 1, 1), Err(GeometryError::Empty));
        assert_eq!(at(1, 0, 1), Err(GeometryError::Empty));
        assert_eq!(at(1, 1, 0), Err(GeometryError::Empty));
        assert_eq!(
            at(5, 1, Geometry::MAX_SPAN / 4),
            Err(GeometryError::TooLarge)
        );
        assert_eq!(at(u16::MAX, 1, u32::MAX), Err(GeometryError::TooLarge));
        assert!(at(u16::MAX, u16::MAX, 4096).is_ok());
        let corner = Point::from_mm(Point::LIMIT - 999, 0);
        let outside = Geometry::try_new(10, 1, Millimeters::new(100), corner);
        assert_eq!(outside, Err(GeometryError::TooFar));
    }
}
