//! A map as everything here takes it.

use certainty_core::certainty::Certainty;
use certainty_core::units::Point;

/// A map's certainties, with the frame that says where they are; row 0 has the lowest y.
///
/// Possession proves that there are exactly width × height cells, at least one, and that a cell has
/// a size.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MapImage<'a> {
    width: u32,
    height: u32,
    cells: &'a [Certainty],
    cell_mm: u32,
    origin: Point,
}

/// Why cells and sizes are no map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum ImageError {
    /// A side or the cell has no size.
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
    /// Creates the map of `width` × `height` cells, each `cell_mm` wide, the corner of the lowest
    /// and leftmost at `origin`.
    ///
    /// # Errors
    /// If a size is 0 or `cells` are not as many as the sizes say.
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
