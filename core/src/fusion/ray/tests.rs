//! Rays against drawings, a naive twin, and their own mirror images.

use super::*;
use proptest::prelude::*;

fn grid(columns: u16, rows: u16, cell: u32, corner: (i32, i32)) -> Geometry {
    let corner = Point::from_mm(corner.0, corner.1);
    Geometry::try_new(columns, rows, Millimeters::new(cell), corner).unwrap()
}

fn walk(geometry: &Geometry, from: Point, to: Point) -> Vec<(u16, u16)> {
    let ray = Ray::new(geometry, from, to);
    let mut one_by_one = Vec::new();
    for cell in ray.clone() {
        one_by_one.push(geometry.column_and_row(cell));
    }
    // Folding, which has a loop of its own, must visit the same cells.
    let mut folded = Vec::new();
    ray.for_each(|cell| folded.push(geometry.column_and_row(cell)));
    assert_eq!(folded, one_by_one);
    folded
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
