//! The cells that a straight line crosses, in order, in integers.

use super::{Cell, Geometry};
use crate::narrow::wrapping_u32;
use crate::units::Point;
use core::num::Wrapping;

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
/// Cost: three divisions a ray, one comparison and three additions of 64 bits a cell.
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
    /// The next cell, or `None` when the line has left the grid or ended.
    next: Option<Cell>,
    /// Column and row borders still to be crossed inside the grid.
    columns_left: u32,
    rows_left: u32,
    /// What crossing a column or row border adds to the index.
    column_step: u32,
    row_step: u32,
    /// Below zero while a column border comes next, above while a row border does.
    race: Wrapping<i64>,
    /// A cell's side times the line's extent along x and y.
    by_dx: Wrapping<i64>,
    by_dy: Wrapping<i64>,
    /// How far the cell's centre is along the line; see [`Ray::along`].
    along: Wrapping<i64>,
}

/// One axis of a line: its start, extent and cells, in half millimetres from the grid's corner.
struct Axis {
    start: i64,
    extent: i64,
    cells: i64,
    /// The cell of the start, which may lie outside.
    cell: i64,
    /// From the start to the first border ahead.
    first_border: i64,
    /// Borders between start and end.
    borders: i64,
    /// Borders before the grid is entered; `None` if it lies behind or aside.
    borders_to_enter: Option<i64>,
}

impl Axis {
    fn new(
        start: i64,
        end: i64,
        cell_at_start: i64,
        cell_at_end: i64,
        cells: u16,
        side: i64,
    ) -> Self {
        let extent = end.wrapping_sub(start);
        let cells = i64::from(cells);
        let below = start.wrapping_sub(cell_at_start.wrapping_mul(side));
        let (first_border, to_enter) = if extent < 0 {
            (below, cell_at_start.wrapping_sub(cells).wrapping_add(1))
        } else {
            (side.wrapping_sub(below), cell_at_start.wrapping_neg())
        };
        let borders = cell_at_end.abs_diff(cell_at_start).cast_signed();
        // Ahead of the grid it is entered after so many borders; inside, or beyond, after none.
        let inside = (0..cells).contains(&cell_at_start);
        let borders_to_enter = match to_enter {
            _ if inside => Some(0),
            n if n > 0 && n <= borders => Some(n),
            _ => None,
        };
        Self {
            start,
            extent: extent.saturating_abs(),
            cells,
            cell: cell_at_start,
            first_border,
            borders,
            borders_to_enter,
        }
    }

    /// From the start to border `number`, counted from 1.
    fn border(&self, number: i64, side: i64) -> i64 {
        self.first_border
            .wrapping_add(number.wrapping_sub(1).wrapping_mul(side))
    }

    /// Borders crossed up to and including the moment at which `other` crosses its border `number`.
    fn crossed_with(&self, other: &Self, number: i64, side: i64) -> i64 {
        // Times are distances over extents: border k is crossed by then if
        // (first + (k − 1) · side) · other.extent ≤ other.border · extent.
        let spare = (other.border(number, side).wrapping_mul(self.extent))
            .wrapping_sub(self.first_border.wrapping_mul(other.extent));
        let period = side.wrapping_mul(other.extent);
        if spare < 0 {
            0
        } else {
            spare.checked_div(period).unwrap_or(0).wrapping_add(1)
        }
    }

    /// Borders that can be crossed from cell `at` before the line ends or leaves the grid.
    fn borders_left(&self, at: i64, crossed: i64, backward: bool) -> i64 {
        let until_outside = if backward {
            at
        } else {
            self.cells.wrapping_sub(at).wrapping_sub(1)
        };
        self.borders.wrapping_sub(crossed).min(until_outside)
    }
}

impl Ray {
    /// Creates the walk from `from` to `to`, both included where they are inside the grid.
    #[must_use]
    pub fn new(geometry: &Geometry, from: Point, to: Point) -> Self {
        let corner = geometry.corner();
        let side = i64::from(geometry.cell_size().get()).wrapping_mul(2);
        let halves = |mm: i32, corner: i32| {
            i64::from(mm)
                .wrapping_sub(i64::from(corner))
                .wrapping_mul(2)
                .wrapping_add(1)
        };
        let (start, end) = (geometry.address(from), geometry.address(to));
        let x = Axis::new(
            halves(from.x_mm(), corner.x_mm()),
            halves(to.x_mm(), corner.x_mm()),
            start.0,
            end.0,
            geometry.columns(),
            side,
        );
        let y = Axis::new(
            halves(from.y_mm(), corner.y_mm()),
            halves(to.y_mm(), corner.y_mm()),
            start.1,
            end.1,
            geometry.rows(),
            side,
        );
        let (leftward, downward) = (to.x_mm() < from.x_mm(), to.y_mm() < from.y_mm());
        Self::enter(geometry, &x, &y, leftward, downward, side)
    }

    /// The walk from where the line enters the grid on.
    fn enter(
        geometry: &Geometry,
        x: &Axis,
        y: &Axis,
        leftward: bool,
        downward: bool,
        side: i64,
    ) -> Self {
        // Whichever border of the grid is crossed last is the entry; the other axis has crossed
        // some borders of its own by then.
        let (by_column, by_row) = match (x.borders_to_enter, y.borders_to_enter) {
            (Some(0), Some(0)) => (0, 0),
            (Some(columns), Some(rows)) => {
                let rows_by_then = if columns > 0 {
                    y.crossed_with(x, columns, side)
                } else {
                    0
                };
                if columns > 0 && rows_by_then >= rows {
                    (columns, rows_by_then)
                } else {
                    (x.crossed_with(y, rows, side), rows)
                }
            }
            _ => return Self::nowhere(),
        };
        let ahead = |cell: i64, borders: i64, backward: bool| {
            if backward {
                cell.wrapping_sub(borders)
            } else {
                cell.wrapping_add(borders)
            }
        };
        let column = ahead(x.cell, by_column, leftward);
        let row = ahead(y.cell, by_row, downward);
        if !(0..x.cells).contains(&column) || !(0..y.cells).contains(&row) {
            return Self::nowhere(); // the line passes the grid by
        }
        let (dx, dy) = (Wrapping(x.extent), Wrapping(y.extent));
        // A cell's centre is half a side, so `side / 2` half millimetres, from its border.
        let to_center = |axis: &Axis, cell: i64, backward: bool| {
            let center = cell.wrapping_mul(side).wrapping_add(side / 2);
            let offset = center.wrapping_sub(axis.start);
            Wrapping(if backward {
                offset.wrapping_neg()
            } else {
                offset
            })
        };
        Self {
            next: Some(geometry.cell_inside(wrapping_u32(column), wrapping_u32(row))),
            columns_left: wrapping_u32(x.borders_left(column, by_column, leftward)),
            rows_left: wrapping_u32(y.borders_left(row, by_row, downward)),
            column_step: if leftward { 1_u32.wrapping_neg() } else { 1 },
            row_step: if downward {
                u32::from(geometry.columns()).wrapping_neg()
            } else {
                u32::from(geometry.columns())
            },
            race: Wrapping(x.border(by_column.wrapping_add(1), side)) * dy
                - Wrapping(y.border(by_row.wrapping_add(1), side)) * dx,
            by_dx: Wrapping(side) * dx,
            by_dy: Wrapping(side) * dy,
            along: to_center(x, column, leftward) * dx + to_center(y, row, downward) * dy,
        }
    }

    /// The walk that visits no cell.
    const fn nowhere() -> Self {
        const NONE: Wrapping<i64> = Wrapping(0);
        Self {
            next: None,
            columns_left: 0,
            rows_left: 0,
            column_step: 0,
            row_step: 0,
            race: NONE,
            by_dx: NONE,
            by_dy: NONE,
            along: NONE,
        }
    }

    /// Returns how far the centre of the next cell is along the line, times four times the line's
    /// length: in 4 mm², so that no root has to be taken.
    #[must_use]
    pub(super) const fn along(&self) -> i64 {
        self.along.0
    }
}

impl Iterator for Ray {
    type Item = Cell;

    #[inline]
    fn next(&mut self) -> Option<Cell> {
        let current = self.next?;
        let race = self.race.0;
        // A tie crosses both borders at once, at their corner.
        let (column, row) = (race <= 0, race >= 0);
        if (column && self.columns_left == 0) || (row && self.rows_left == 0) {
            self.next = None;
            return Some(current);
        }
        let mut ahead = current.number();
        if column {
            self.columns_left = self.columns_left.wrapping_sub(1);
            ahead = ahead.wrapping_add(self.column_step);
            self.race += self.by_dy;
            self.along += self.by_dx;
        }
        if row {
            self.rows_left = self.rows_left.wrapping_sub(1);
            ahead = ahead.wrapping_add(self.row_step);
            self.race -= self.by_dx;
            self.along += self.by_dy;
        }
        self.next = Some(Cell::from_index(ahead));
        Some(current)
    }
}

impl core::iter::FusedIterator for Ray {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Millimeters;
    use proptest::prelude::*;

    fn grid(columns: u16, rows: u16, cell: u32, corner: (i32, i32)) -> Geometry {
        let corner = Point::from_mm(corner.0, corner.1);
        Geometry::try_new(columns, rows, Millimeters::new(cell), corner).unwrap()
    }

    fn walk(geometry: &Geometry, from: Point, to: Point) -> Vec<(u16, u16)> {
        Ray::new(geometry, from, to)
            .map(|cell| geometry.column_and_row(cell))
            .collect()
    }

    /// The naive twin: cuts the line at every border in f64 and asks which cell holds the middle of
    /// each piece. Ties, where two cuts fall together, leave no piece between them.
    fn naive(geometry: &Geometry, from: Point, to: Point) -> Vec<(u16, u16)> {
        let side = f64::from(geometry.cell_size().get());
        let relative = |mm: i32, corner: i32| (f64::from(mm) + 0.5 - f64::from(corner)) / side;
        let corner = geometry.corner();
        let (x0, y0) = (
            relative(from.x_mm(), corner.x_mm()),
            relative(from.y_mm(), corner.y_mm()),
        );
        let (x1, y1) = (
            relative(to.x_mm(), corner.x_mm()),
            relative(to.y_mm(), corner.y_mm()),
        );
        let mut cuts = vec![0.0, 1.0];
        for (start, end) in [(x0, x1), (y0, y1)] {
            let (low, high) = (start.min(end).ceil() as i64, start.max(end).floor() as i64);
            cuts.extend((low..=high).map(|border| (border as f64 - start) / (end - start)));
        }
        cuts.sort_by(f64::total_cmp);
        let mut cells = Vec::new();
        for pair in cuts.windows(2) {
            if pair[1] - pair[0] < 1e-12 && cuts.len() > 2 {
                continue;
            }
            let middle = (pair[0] + pair[1]) / 2.0;
            let (x, y) = (x0 + (x1 - x0) * middle, y0 + (y1 - y0) * middle);
            let inside = 0.0 <= x && x < f64::from(geometry.columns()) && 0.0 <= y;
            if inside && y < f64::from(geometry.rows()) {
                cells.push((x as u16, y as u16));
            }
        }
        cells
    }

    #[test]
    fn a_drawn_ray_crosses_the_cells_one_sees_it_cross() {
        let geometry = grid(5, 3, 10, (0, 0));
        let mut picture = [['.'; 5]; 3];
        for (order, (column, row)) in walk(&geometry, Point::from_mm(2, 2), Point::from_mm(47, 28))
            .into_iter()
            .enumerate()
        {
            picture[2 - usize::from(row)][usize::from(column)] = (b'0' + order as u8) as char;
        }
        let drawn: Vec<String> = picture.iter().map(|row| row.iter().collect()).collect();
        // y = 2.5 + (x − 2.5) · 26/45 meets the row borders at x = 15.5 and 32.8.
        assert_eq!(drawn, ["...56", ".234.", "01..."]);
    }

    #[test]
    fn a_line_through_a_corner_goes_to_the_opposite_cell() {
        // From the middle of a cell to the middle of its diagonal neighbour, in all four directions.
        let geometry = grid(3, 3, 11, (0, 0));
        let middle = Point::from_mm(16, 16);
        for (x, y) in [(5, 5), (5, 27), (27, 5), (27, 27)] {
            assert_eq!(walk(&geometry, middle, Point::from_mm(x, y)).len(), 2);
        }
    }

    #[test]
    fn a_ray_that_misses_the_grid_visits_nothing() {
        let geometry = grid(17, 11, 100, (-850, 0));
        for (from, to) in [
            ((-5000, -1), (5000, -1)),   // below
            ((-5000, 500), (-851, 500)), // ends just before
            ((900, 0), (2000, 1100)),    // beside
            ((-2000, 0), (0, 2000)),     // past the upper left corner
        ] {
            let (from, to) = (Point::from_mm(from.0, from.1), Point::from_mm(to.0, to.1));
            assert_eq!(walk(&geometry, from, to), [], "{from:?} to {to:?}");
            assert_eq!(walk(&geometry, to, from), [], "{to:?} to {from:?}");
        }
    }

    #[test]
    fn the_longest_rays_do_not_overflow() {
        let far = Point::LIMIT;
        let whole = grid(2, 2, Geometry::MAX_SPAN / 2, (-far, -far));
        let ends = [(far, far), (-far, far), (far, -far), (-far, -far)];
        for (a, b) in ends.into_iter().flat_map(|a| ends.map(|b| (a, b))) {
            let (from, to) = (Point::from_mm(a.0, a.1), Point::from_mm(b.0, b.1));
            let fine = grid(100, 100, 10, (-500, -500));
            let crossed = walk(&fine, from, to).len();
            // x = y runs through the corners of the cells; x + y = 1 crosses 99 borders each way.
            let expected = match (a.0 == b.0 || a.1 == b.1, a.0 == a.1) {
                (true, _) => 0,
                (false, true) => 100,
                (false, false) => 199,
            };
            assert_eq!(crossed, expected, "{a:?} to {b:?}");
            assert!(walk(&whole, from, to).len() <= 3);
        }
    }

    /// PEERS: a beam that left a grid on the negative side wrapped into a huge loop (nav2).
    #[test]
    fn a_beam_leaving_on_the_negative_side_ends_there() {
        let geometry = grid(4, 4, 100, (0, 0));
        let inside = Point::from_mm(150, 150);
        assert_eq!(
            walk(&geometry, inside, Point::from_mm(i32::MIN, 150)),
            [(1, 1), (0, 1)]
        );
        assert_eq!(
            walk(&geometry, inside, Point::from_mm(150, i32::MIN)),
            [(1, 1), (1, 0)]
        );
    }

    fn places() -> impl Strategy<Value = (i32, i32)> {
        (-300..500_i32, -300..500_i32)
    }

    proptest! {
        #[test]
        fn rays_agree_with_the_naive_twin(
            a in places(), b in places(),
            columns in 1..9_u16, rows in 1..9_u16, cell in 1..60_u32,
        ) {
            let geometry = grid(columns, rows, cell, (3, -7));
            let (from, to) = (Point::from_mm(a.0, a.1), Point::from_mm(b.0, b.1));
            prop_assert_eq!(walk(&geometry, from, to), naive(&geometry, from, to));
        }

        #[test]
        fn rays_at_any_angle_and_length_visit_no_cell_twice_and_leave_no_gap(
            x in -1_000_000..1_000_000_i32, y in -1_000_000..1_000_000_i32,
        ) {
            let geometry = grid(40, 30, 50, (-1000, -700));
            let cells = walk(&geometry, Point::from_mm(x, y), Point::from_mm(-y, x));
            for pair in cells.windows(2) {
                let gap = (pair[0].0.abs_diff(pair[1].0), pair[0].1.abs_diff(pair[1].1));
                prop_assert!(matches!(gap, (1, 0) | (0, 1) | (1, 1)));
            }
        }

        #[test]
        fn all_eight_octants_are_mirror_images(a in places(), b in places(), cell in 1..40_u32) {
            // A grid that is its own mirror image about both axes and the diagonal: square
            // millimetre x mirrors to −1 − x.
            let half = 5 * cell as i32;
            let geometry = grid(10, 10, cell, (-half, -half));
            let flip = |mm: i32| -1 - mm;
            let at = |(x, y): (i32, i32)| Point::from_mm(x, y);
            let plain = walk(&geometry, at(a), at(b));
            let mirrored = walk(&geometry, at((flip(a.0), a.1)), at((flip(b.0), b.1)));
            let upside = walk(&geometry, at((a.0, flip(a.1))), at((b.0, flip(b.1))));
            let swapped = walk(&geometry, at((a.1, a.0)), at((b.1, b.0)));
            let backward = walk(&geometry, at(b), at(a));
            prop_assert_eq!(&mirrored, &plain.iter().map(|&(c, r)| (9 - c, r)).collect::<Vec<_>>());
            prop_assert_eq!(&upside, &plain.iter().map(|&(c, r)| (c, 9 - r)).collect::<Vec<_>>());
            prop_assert_eq!(&swapped, &plain.iter().map(|&(c, r)| (r, c)).collect::<Vec<_>>());
            prop_assert_eq!(&backward, &plain.iter().rev().copied().collect::<Vec<_>>());
        }
    }
}
