//! All maps of a run in one picture, what is wrong in them in colour.

use super::panels::Mark;
use certainty_core::certainty::Certainty;
use certainty_core::fusion::Geometry;
use certainty_sim::export::{MapImage, write_colour_png};
use certainty_sim::simulation::Truth;
use core::num::NonZeroU32;
use std::io::{self, Write};

/// Pixels of a cell.
const ZOOM: NonZeroU32 = NonZeroU32::new(12).unwrap();

/// Draws `maps` from left to right with a column between, greys as they are, ghosts in red, missed
/// obstacles in purple.
pub(super) fn overview(
    geometry: &Geometry,
    maps: &[&[Certainty]],
    truth: &[Truth],
    out: &mut dyn Write,
) -> io::Result<()> {
    let (columns, rows) = (
        usize::from(geometry.columns()),
        usize::from(geometry.rows()),
    );
    let width = maps.len() * (columns + 1) - 1;
    // The picture as one wide map, and where it comes from: no cell at the gaps.
    let cell_at = |x: usize, y: usize| {
        let (map, column) = (x / (columns + 1), x % (columns + 1));
        (column < columns).then_some((map, y * columns + column))
    };
    let shown = |x, y| cell_at(x, y).map_or(Certainty::FREE, |(map, cell)| maps[map][cell]);
    let cells: Vec<_> = (0..rows)
        .flat_map(|y| (0..width).map(move |x| shown(x, y)))
        .collect();
    let side = |cells: usize| u32::try_from(cells).map_err(io::Error::other);
    let cell_mm = geometry.cell_size().get();
    let image = MapImage::try_new(
        side(width)?,
        side(rows)?,
        &cells,
        cell_mm,
        geometry.corner(),
    );
    let image = image.map_err(io::Error::other)?;
    write_colour_png(&image, ZOOM, out, |x, y, certainty| {
        let Some((_, cell)) = cell_at(x as usize, y as usize) else {
            return [255, 255, 255];
        };
        let grey = 255 - certainty.to_bits();
        match Mark::of(certainty, truth[cell]) {
            Mark::Ghost => [220, 50, 47],
            Mark::Missed => [150, 80, 200],
            Mark::Occupied | Mark::Free | Mark::Unknown => {
                // A light frame colour tells a free cell from the paper.
                [grey - grey / 24, grey - grey / 32, grey]
            }
        }
    })
}
