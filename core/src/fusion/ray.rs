//! The cells that a straight line crosses, in order, in integers.
//!
//! [`Ray`] walks them one by one. What it starts from, the borders of columns and rows that the line crosses
//! before it enters and before it leaves the grid, is computed without walking.

use super::geometry::{Cell, Geometry};
use crate::narrow::wrapping_u32;
use crate::units::{Millimeters, Point};
use core::num::Wrapping;

/// The cells between two places, each once, in the order in which the line crosses them.
///
/// Exact: a cell is visited if and only if the line between the centres of the two square
/// millimetres runs through its inside. Where the line passes exactly through the corner of four
/// cells it goes from one to the opposite one. Mirrored lines visit mirrored cells. Outside the grid
/// nothing is walked: entry and exit are computed, at any distance.
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
/// let grid = Geometry::new(3, 2, Millimeters::new(100), Point::ORIGIN);
/// let ray = Ray::new(&grid, Point::from_mm(-500, 50), Point::from_mm(250, 50));
/// let cells: Vec<_> = ray.map(|cell| cell.index()).collect();
/// assert_eq!(cells, [0, 1, 2]);
/// ```
#[derive(Debug, Clone)]
pub struct Ray {
    /// Whether there is a cell left to visit.
    active: bool,
    /// The index of that cell.
    index: u32,
    /// Borders of columns and rows still to be crossed inside the grid.
    crossings: u32,
    /// Borders crossed before the grid was entered.
    skipped: u32,
    /// Added to the index at a column or row border.
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
            active: true,
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
        active: false,
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
        // All ones where a column border comes next. No branch: on a slanted line it would be
        // mispredicted.
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
        self.active.then(|| {
            let cell = Cell::from_index(self.index);
            self.active = self.crossings > 0;
            if self.active {
                self.cross();
            }
            cell
        })
    }

    #[inline]
    fn fold<B, F: FnMut(B, Cell) -> B>(mut self, init: B, mut visit: F) -> B {
        if !self.active {
            return init;
        }
        // All but the last cell, with one check a cell.
        let all = self.crossings;
        let folded = self.run(all).fold(init, &mut visit);
        visit(folded, Cell::from_index(self.index))
    }
}

impl core::iter::FusedIterator for Ray {}

/// The next cells of a [`Ray`], which goes on after them.
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
        // On a copy, which the visitor's stores cannot alias: its state stays in registers.
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

/// A line as the borders of columns and rows that it crosses, counted without walking it.
struct Line {
    x: Axis,
    y: Axis,
    /// The side of a cell in half millimetres.
    side: i64,
}

/// One axis of a line: its start, extent and cells, in half millimetres from the grid's corner.
struct Axis {
    /// The line's extent and whether it runs backward.
    extent: i64,
    backward: bool,
    /// The cell of the start, which may lie outside, and how many cells there are.
    cell: i64,
    cells: i64,
    /// From the start to the first border ahead.
    first_border: i64,
    /// Borders between start and end.
    borders: i64,
    /// Borders before the grid is entered; `None` if the line does not reach its columns or rows.
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
    fn border(&self, number: i64, side: i64) -> i64 {
        self.first_border
            .wrapping_add(number.wrapping_sub(1).wrapping_mul(side))
    }

    /// Borders crossed up to and including the moment `part` / `whole` of the line.
    fn crossed_by(&self, part: i64, whole: i64, side: i64) -> i64 {
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

    /// The cell after `borders` borders.
    fn cell_after(&self, borders: i64) -> i64 {
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
    fn new(geometry: &Geometry, from: Point, to: Point) -> Self {
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
    fn entry(&self) -> Option<(i64, i64)> {
        // The edge of the grid that is crossed last is the entry; the other axis has crossed some
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
    fn crossings_inside(&self) -> i64 {
        // An edge is crossed at border `number` of its axis. A border that the other axis crosses at the
        // same moment is outside.
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

#[cfg(test)]
mod tests {

    use super::*;
    use proptest::prelude::*;

    fn grid(columns: u16, rows: u16, cell: u32, corner: (i32, i32)) -> Geometry {
        let corner = Point::from_mm(corner.0, corner.1);
        Geometry::new(columns, rows, Millimeters::new(cell), corner)
    }

    fn walk(geometry: &Geometry, from: Point, to: Point) -> Vec<(u16, u16)> {
        let ray = Ray::new(geometry, from, to);
        let mut one_by_one = Vec::new();
        for cell in ray.clone() {
            one_by_one.push(geometry.column_and_row(cell));
        }
        // `fold` has a loop of its own and must visit the same cells.
        let mut folded = Vec::new();
        ray.for_each(|cell| folded.push(geometry.column_and_row(cell)));
        assert_eq!(folded, one_by_one);
        folded
    }

    /// The naive twin: cuts the line at every border in f64 and takes the cell of each piece's middle.
    /// Ties, where two cuts coincide, leave no piece between them.
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
    fn a_ray_crosses_the_cells_of_the_drawing() {
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
            // x = y passes the corners of the cells; x + y = 1 crosses 99 borders in x and 99 in y.
            let expected = match (a.0 == b.0 || a.1 == b.1, a.0 == a.1) {
                (true, _) => 0,
                (false, true) => 100,
                (false, false) => 199,
            };
            assert_eq!(crossed, expected, "{a:?} to {b:?}");
            assert!(walk(&whole, from, to).len() <= 3);
        }
    }

    /// A defect of nav2: a beam that left a grid on the negative side wrapped into a huge loop.
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
        fn rays_visit_no_cell_twice_and_leave_no_gap(
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
