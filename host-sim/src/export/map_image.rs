//! The map that is exported, and the three states of its cells.

use certainty_core::certainty::Certainty;
use certainty_core::units::Point;
use serde::Serialize;

/// A map's certainties with their cell size and origin; row 0 has the lowest y.
///
/// Possession proves that there are exactly width × height cells and at least one, and that the cell
/// size is above 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MapImage<'a> {
    width: u32,
    height: u32,
    cells: &'a [Certainty],
    cell_mm: u32,
    origin: Point,
}

/// Why cells and sizes do not make a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum ImageError {
    /// A side or the cell size is 0.
    #[error("a map of {width} x {height} cells of {cell_mm} mm has no area")]
    Empty {
        /// Cells along x.
        width: u32,
        /// Cells along y.
        height: u32,
        /// Side of a cell in millimetres.
        cell_mm: u32,
    },
    /// The number of cells is not width times height.
    #[error("a map of {width} x {height} cells was given {cells} cells")]
    CellCount {
        /// Cells along x.
        width: u32,
        /// Cells along y.
        height: u32,
        /// Cells given.
        cells: usize,
    },
}

impl<'a> MapImage<'a> {
    /// Creates the map of `width` × `height` cells, each `cell_mm` wide, with the lower left corner
    /// at `origin`.
    ///
    /// # Errors
    /// If a size is 0 or the number of `cells` is not width × height.
    ///
    /// # Examples
    /// ```
    /// use certainty_core::{certainty::Certainty, units::Point};
    /// use certainty_sim::export::MapImage;
    ///
    /// let cells = [Certainty::FREE, Certainty::OCCUPIED];
    /// let map = MapImage::try_new(2, 1, &cells, 100, Point::ORIGIN)?;
    /// assert_eq!(map.row(0)[1], Certainty::OCCUPIED);
    /// assert!(MapImage::try_new(2, 2, &cells, 100, Point::ORIGIN).is_err());
    /// # Ok::<(), certainty_sim::export::ImageError>(())
    /// ```
    pub fn try_new(
        width: u32,
        height: u32,
        cells: &'a [Certainty],
        cell_mm: u32,
        origin: Point,
    ) -> Result<Self, ImageError> {
        if width == 0 || height == 0 || cell_mm == 0 {
            return Err(ImageError::Empty {
                width,
                height,
                cell_mm,
            });
        }
        if u64::from(width) * u64::from(height) != cells.len() as u64 {
            return Err(ImageError::CellCount {
                width,
                height,
                cells: cells.len(),
            });
        }
        Ok(Self {
            width,
            height,
            cells,
            cell_mm,
            origin,
        })
    }

    /// Returns the number of cells along x.
    #[must_use]
    pub const fn width(&self) -> u32 {
        self.width
    }

    /// Returns the number of cells along y.
    #[must_use]
    pub const fn height(&self) -> u32 {
        self.height
    }

    /// Returns the cells, row by row from the lowest y, each from the lowest x.
    #[must_use]
    pub const fn cells(&self) -> &'a [Certainty] {
        self.cells
    }

    /// Returns the side of a cell in millimetres.
    #[must_use]
    pub const fn cell_mm(&self) -> u32 {
        self.cell_mm
    }

    /// Returns the lower left corner of the lowest and leftmost cell.
    #[must_use]
    pub const fn origin(&self) -> Point {
        self.origin
    }

    /// Returns row `y`, counted from the lowest.
    ///
    /// # Panics
    /// If `y` is not below the height.
    #[must_use]
    pub fn row(&self, y: u32) -> &'a [Certainty] {
        let width = self.width as usize;
        let start = y as usize * width;
        &self.cells[start..start + width]
    }
}

/// A cell as free, unknown or occupied.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CellState {
    /// No obstacle.
    Free,
    /// Neither free nor occupied.
    Unknown,
    /// An obstacle.
    Occupied,
}

impl CellState {
    /// From this probability up, in thousandths, a cell is occupied.
    pub const OCCUPIED_FROM: u32 = 650;
    /// Up to this probability, in thousandths, a cell is free.
    ///
    /// It is below 0.19608, the probability of the pixel 205, which means *unknown* in ROS maps.
    pub const FREE_UP_TO: u32 = 196;

    /// Classifies a certainty; the probability is its byte in steps of 1/256.
    ///
    /// A byte of 167 (0.652) or more is occupied, one of 50 (0.195) or less is free.
    ///
    /// ```
    /// use certainty_core::certainty::Certainty;
    /// use certainty_sim::export::CellState;
    ///
    /// assert_eq!(CellState::of(Certainty::UNCERTAIN), CellState::Unknown);
    /// assert_eq!(CellState::of(Certainty::from_bits(167)), CellState::Occupied);
    /// assert_eq!(CellState::of(Certainty::from_bits(50)), CellState::Free);
    /// ```
    #[must_use]
    pub const fn of(certainty: Certainty) -> Self {
        let thousand_256ths = certainty.to_bits() as u32 * 1000;
        if thousand_256ths >= Self::OCCUPIED_FROM * 256 {
            Self::Occupied
        } else if thousand_256ths <= Self::FREE_UP_TO * 256 {
            Self::Free
        } else {
            Self::Unknown
        }
    }

    /// Whether the cell is free or occupied.
    #[must_use]
    pub const fn is_known(self) -> bool {
        !matches!(self, Self::Unknown)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_has_the_state_of_its_probability() {
        for bits in 0..=u8::MAX {
            let probability = f64::from(bits) / 256.0;
            let expected = if probability >= 0.65 {
                CellState::Occupied
            } else if probability <= 0.196 {
                CellState::Free
            } else {
                CellState::Unknown
            };
            assert_eq!(
                CellState::of(Certainty::from_bits(bits)),
                expected,
                "{bits}"
            );
        }
    }
}
