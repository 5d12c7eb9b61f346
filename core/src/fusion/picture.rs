//! Grids drawn as text, for tests: `#` occupied, `.` free, `?` uncertain, the highest row first.

use super::geometry::{Cell, Geometry};
use super::grid::CertaintyGrid;
use crate::certainty::Certainty;

/// A certainty as a character; `+` and `,` are between *uncertain* and the ends.
pub(super) fn mark(certainty: Certainty) -> char {
    match certainty.to_bits() {
        0..=25 => '.',
        26..=127 => ',',
        128 => '?',
        129..=229 => '+',
        230..=255 => '#',
    }
}

/// Draws each cell as the character that `paint` returns.
pub(super) fn draw(geometry: &Geometry, paint: impl Fn(Cell) -> char) -> Vec<String> {
    let row = |row| (0..geometry.columns()).filter_map(move |column| geometry.cell(column, row));
    let rows = (0..geometry.rows()).rev();
    rows.map(|number| row(number).map(&paint).collect())
        .collect()
}

/// Draws the certainties of a grid.
pub(super) fn draw_grid(grid: &impl CertaintyGrid) -> Vec<String> {
    draw(&grid.geometry(), |cell| mark(grid.certainty(cell)))
}
