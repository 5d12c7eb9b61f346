//! Maps side by side in the terminal.

use anstyle::{AnsiColor, Style};
use certainty_core::certainty::Certainty;
use certainty_core::fusion::Geometry;
use certainty_sim::export::CellState;
use certainty_sim::simulation::Truth;

/// What one character of a map says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mark {
    /// Occupied, and truly so or nobody knows.
    Occupied,
    /// Free, and truly so or nobody knows.
    Free,
    /// Uncertain where there is no obstacle.
    Unknown,
    /// Shown occupied where it is free.
    Ghost,
    /// Not shown occupied where an obstacle is.
    Missed,
}

impl Mark {
    /// What the legend says.
    pub(super) const LEGEND: &str =
        "# occupied   . free   ? uncertain   X ghost, free in truth   o obstacle missed";

    /// What a map's cell says, given the truth.
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

/// Draws panels of the same size side by side, as many as fit in 80 columns, the rest below.
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

/// A row of marks, each run of equal marks styled once.
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
    fn panels_stand_side_by_side_with_the_highest_row_first() {
        let drawn = side_by_side(&geometry(), &[panel("one"), panel("two")], false);
        assert_eq!(drawn, "one    two\no?     o?\n.#     .#\n\n");
    }

    #[test]
    fn no_line_is_wider_than_80_columns_and_plain_means_plain() {
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
