//! Draws a map as text, for the examples.

use certainty_core::fusion::{CertaintyGrid, Environment};

/// Returns the map with the highest row first: `#` occupied, `+` rather occupied, `.` free, `,` rather
/// free, `?` uncertain.
pub(crate) fn drawn<G: CertaintyGrid>(map: &Environment<'_, G>) -> String {
    let geometry = map.geometry();
    let mut picture = String::new();
    for row in (0..geometry.rows()).rev() {
        let cells = (0..geometry.columns()).filter_map(|column| geometry.cell(column, row));
        picture.extend(cells.map(|cell| match map.certainty(cell).to_bits() {
            0..=25 => '.',
            26..=127 => ',',
            128 => '?',
            129..=229 => '+',
            230..=255 => '#',
        }));
        picture.push('\n');
    }
    picture
}
