//! Maps in the terminal, in pictures and in plans of tracks.

use super::output::Failure;
use anstyle::{AnsiColor, Style};
use certainty_core::certainty::Certainty;
use certainty_core::fusion::Geometry;
use certainty_core::units::Point;
use certainty_sim::export::{CellState, MapImage, write_colour_png};
use certainty_sim::plot::{Ink, Layer, Plan};
use certainty_sim::simulation::Truth;
use certainty_sim::world::World;
use core::num::NonZeroU32;
use std::io::{self, Write};

/// Returns a map's cells with the size and place of its grid.
pub(super) fn map_image<'a>(
    geometry: &Geometry,
    cells: &'a [Certainty],
) -> Result<MapImage<'a>, Failure> {
    let (width, height) = (geometry.columns().into(), geometry.rows().into());
    let cell_mm = geometry.cell_size().get();
    MapImage::try_new(width, height, cells, cell_mm, geometry.corner())
        .map_err(|error| Failure::Internal(error.to_string()))
}

/// One cell of a map, compared with the truth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mark {
    /// Occupied in the map; occupied or unseen in truth.
    Occupied,
    /// Free in the map; free or unseen in truth.
    Free,
    /// Uncertain in the map, and no obstacle in truth.
    Unknown,
    /// Occupied in the map, free in truth.
    Ghost,
    /// Not occupied in the map, an obstacle in truth.
    Missed,
}

impl Mark {
    /// The legend of the characters.
    pub(super) const LEGEND: &str =
        "# occupied   . free   ? uncertain   X ghost, free in truth   o obstacle missed";

    /// Returns the mark of a map's cell.
    pub(super) fn of(shown: Certainty, truth: Truth) -> Self {
        match (CellState::of(shown), truth) {
            (CellState::Occupied, Truth::Free) => Self::Ghost,
            (CellState::Occupied, _) => Self::Occupied,
            (_, Truth::Occupied) => Self::Missed,
            (CellState::Free, _) => Self::Free,
            (CellState::Unknown, _) => Self::Unknown,
        }
    }

    const fn character(self) -> char {
        match self {
            Self::Occupied => '#',
            Self::Free => '.',
            Self::Unknown => '?',
            Self::Ghost => 'X',
            Self::Missed => 'o',
        }
    }

    fn style(self) -> Style {
        match self {
            Self::Occupied => Style::new().bold(),
            Self::Free | Self::Unknown => Style::new().dimmed(),
            Self::Ghost => AnsiColor::Red.on_default().bold(),
            Self::Missed => AnsiColor::Magenta.on_default().bold(),
        }
    }
}

/// A map with its title.
pub(super) struct Panel {
    pub(super) title: String,
    /// Row after row from the lowest.
    pub(super) marks: Vec<Mark>,
}

/// Renders panels of the same size side by side, at most 80 columns wide, the rest below.
pub(super) fn side_by_side(geometry: &Geometry, panels: &[Panel], coloured: bool) -> String {
    const GAP: usize = 4;
    let columns = usize::from(geometry.columns());
    let widest = panels.iter().map(|panel| panel.title.chars().count()).max();
    let width = columns.max(widest.unwrap_or(0));
    let fitting = ((80 + GAP) / (width + GAP)).max(1);
    let mut text = String::new();
    for line in panels.chunks(fitting) {
        let mut rows = vec![String::new()];
        for (place, panel) in line.iter().enumerate() {
            let gap = if place == 0 { 0 } else { GAP };
            rows[0] += &format!("{:gap$}{:<width$}", "", panel.title);
            for (number, row) in panel.marks.chunks(columns).rev().enumerate() {
                if rows.len() == number + 1 {
                    rows.push(String::new());
                }
                rows[number + 1] += &" ".repeat(gap);
                rows[number + 1] += &drawn(row, coloured);
                rows[number + 1] += &" ".repeat(width - columns);
            }
        }
        for row in rows {
            text += row.trim_end();
            text.push('\n');
        }
        text.push('\n');
    }
    text
}

/// Renders a row of marks; each run of equal marks is styled once.
fn drawn(row: &[Mark], coloured: bool) -> String {
    let mut text = String::new();
    for run in row.chunk_by(|a, b| a == b) {
        let characters = run.iter().map(|mark| mark.character());
        if coloured {
            let style = run[0].style();
            text += &format!("{style}{}{style:#}", characters.collect::<String>());
        } else {
            text.extend(characters);
        }
    }
    text
}

/// Pixels of a cell.
const ZOOM: NonZeroU32 = NonZeroU32::new(12).unwrap();

/// Draws `maps` from left to right with a column between: certainties in grey, ghosts in red, missed
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
    // The picture is one wide map; the columns between have no cell.
    let cell_at = |x: usize, y: usize| {
        let (map, column) = (x / (columns + 1), x % (columns + 1));
        (column < columns).then_some((map, y * columns + column))
    };
    let drawn = |x, y| cell_at(x, y).map_or(Certainty::FREE, |(map, cell)| maps[map][cell]);
    let cells: Vec<_> = (0..rows)
        .flat_map(|y| (0..width).map(move |x| drawn(x, y)))
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
                // Slightly yellow, so that a free cell differs from the white between the maps.
                [grey - grey / 24, grey - grey / 32, grey]
            }
        }
    })
}

/// Returns a place in metres, as a plan draws it.
pub(super) fn metres_of(point: Point) -> (f64, f64) {
    metres((f64::from(point.x_mm()), f64::from(point.y_mm())))
}

fn metres((x, y): (f64, f64)) -> (f64, f64) {
    (x / 1000.0, y / 1000.0)
}

/// Returns the plan of a run: the obstacles, the map's occupied cells if there is a map, the tracks, the
/// start, and the goal as the circle of radius `goal.1`, in millimetres, within which it is reached.
pub(super) fn track_plan(
    title: String,
    world: &World,
    map: Option<&(Geometry, Vec<Certainty>)>,
    tracks: impl IntoIterator<Item = Layer>,
    start: Point,
    goal: (Point, u32),
) -> Plan {
    let cells = map.map(|(geometry, cells)| outlines_of_map(geometry, cells));
    let cells = cells.map(|cells| Layer::new("occupied in the map", Ink::Cells, cells));
    let ((x, y), radius) = (metres_of(goal.0), f64::from(goal.1) / 1000.0);
    let angles = (0..=64).map(|part| f64::from(part) / 64.0 * core::f64::consts::TAU);
    let circle = angles.map(|angle| (x + radius * angle.cos(), y + radius * angle.sin()));
    let goal = format!("goal (within {radius} m)");
    let mut layers = vec![Layer::new(
        "obstacle",
        Ink::Obstacle,
        outlines_of_world(world),
    )];
    layers.extend(cells);
    layers.extend(tracks);
    layers.push(Layer::new(
        "start",
        Ink::Marks,
        vec![vec![metres_of(start)]],
    ));
    layers.push(Layer::new(&goal, Ink::Solid, vec![circle.collect()]));
    Plan { title, layers }
}

/// Returns the obstacles' outlines in metres.
fn outlines_of_world(world: &World) -> Vec<Vec<(f64, f64)>> {
    let outlines = world.obstacles().iter().map(|obstacle| {
        let outline = obstacle.outline();
        outline.into_iter().map(metres).collect()
    });
    outlines.collect()
}

/// Returns the outlines in metres of the cells above the middle between *uncertain* and *occupied*.
fn outlines_of_map(geometry: &Geometry, cells: &[Certainty]) -> Vec<Vec<(f64, f64)>> {
    let half = f64::from(geometry.cell_size().get()) / 2000.0;
    let corners = [(-half, -half), (half, -half), (half, half), (-half, half)];
    let known = geometry.iter().zip(cells);
    let occupied = known.filter(|&(_, &certainty)| certainty > Certainty::from_bits(192));
    let outlines = occupied.map(|(cell, _)| {
        let (x, y) = metres_of(geometry.center(cell));
        corners.map(|(dx, dy)| (x + dx, y + dy)).to_vec()
    });
    outlines.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_core::units::{Millimeters, Point};

    fn geometry() -> Geometry {
        Geometry::try_new(2, 2, Millimeters::new(100), Point::ORIGIN).unwrap()
    }

    fn panel(title: &str) -> Panel {
        let marks = vec![Mark::Free, Mark::Occupied, Mark::Missed, Mark::Unknown];
        Panel {
            title: title.into(),
            marks,
        }
    }

    #[test]
    fn panels_are_side_by_side_highest_row_first() {
        let drawn = side_by_side(&geometry(), &[panel("one"), panel("two")], false);
        assert_eq!(drawn, "one    two\no?     o?\n.#     .#\n\n");
    }

    #[test]
    fn lines_have_at_most_80_columns() {
        let geometry = Geometry::try_new(17, 1, Millimeters::new(100), Point::ORIGIN).unwrap();
        let panels: Vec<_> = (0..6)
            .map(|_| Panel {
                title: "perfect sensors".into(),
                marks: vec![Mark::Ghost; 17],
            })
            .collect();
        let plain = side_by_side(&geometry, &panels, false);
        assert!(plain.lines().all(|line| line.chars().count() <= 80));
        assert!(!plain.contains('\u{1b}'));
        assert!(side_by_side(&geometry, &panels, true).contains('\u{1b}'));
    }
}
