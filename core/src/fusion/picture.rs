//! Grids drawn as text, for tests: `#` occupied, `.` free, `?` uncertain, the highest row first.

use super::{Beam, BeamModel, Cell, CertaintyGrid, Geometry};
use crate::certainty::Certainty;

/// A certainty as a character: surely so, or leaning that way (`+` and `,`).
pub(super) fn mark(certainty: Certainty) -> char {
    match certainty.to_bits() {
        0..=25 => '.',
        26..=127 => ',',
        128 => '?',
        129..=229 => '+',
        230..=255 => '#',
    }
}

/// Draws each cell as `paint` says.
pub(super) fn draw(geometry: &Geometry, paint: impl Fn(Cell) -> char) -> Vec<String> {
    let row = |row| (0..geometry.columns()).filter_map(move |column| geometry.cell(column, row));
    let rows = (0..geometry.rows()).rev();
    rows.map(|number| row(number).map(&paint).collect())
        .collect()
}

/// Draws what a grid says.
pub(super) fn draw_grid(grid: &impl CertaintyGrid) -> Vec<String> {
    draw(&grid.geometry(), |cell| mark(grid.certainty(cell)))
}

/// Draws what one beam says, cells that it does not mention as spaces.
pub(super) fn draw_beam(geometry: &Geometry, beam: &Beam, model: &BeamModel) -> Vec<String> {
    let mut told = vec![None; geometry.cells() as usize];
    beam.interpret(geometry, model, &mut |cell: Cell, certainty: Certainty| {
        assert_eq!(told[cell.index()], None, "a cell is told once");
        told[cell.index()] = Some(certainty);
    });
    draw(geometry, |cell| told[cell.index()].map_or(' ', mark))
}
