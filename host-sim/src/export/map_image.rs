//! Maps as images: the map that is exported, the three states of its cells, and its picture as PNG.
//!
//! The top row of a picture is the highest y. The same map gives the same bytes. Memory: one row of the
//! picture, whatever the scale.

use certainty_core::certainty::Certainty;
use certainty_core::units::Point;
use core::num::NonZeroU32;
use png::{BitDepth, ColorType, Compression, Encoder, Filter};
use serde::Serialize;
use std::io::{self, Write};

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

/// The longest side that is drawn, in pixels: common viewers open it, and a row fits memory.
const LONGEST_SIDE: u32 = u16::MAX as u32;

/// Draws `map` in greys: free white, occupied black, uncertain between; a cell is `scale` pixels
/// wide.
///
/// Formula: a pixel is 255 less the certainty's byte.
///
/// # Errors
/// If `out` fails or a side of the picture is longer than 65,535 pixels.
pub fn write_grey_png(map: &MapImage<'_>, scale: NonZeroU32, out: impl Write) -> io::Result<()> {
    write_png(map, scale, ColorType::Grayscale, out, |_, _, certainty| {
        [grey(certainty)]
    })
}

/// Draws `map` in the colours (red, green, blue) that `colour` gives for a cell's x, its y, counted
/// from the lowest, and its certainty; a cell is `scale` pixels wide.
///
/// It shows properties that greys cannot, such as the owner of a cell.
///
/// # Errors
/// As [`write_grey_png`].
pub fn write_colour_png(
    map: &MapImage<'_>,
    scale: NonZeroU32,
    out: impl Write,
    colour: impl Fn(u32, u32, Certainty) -> [u8; 3],
) -> io::Result<()> {
    write_png(map, scale, ColorType::Rgb, out, colour)
}

/// The grey of a certainty.
const fn grey(certainty: Certainty) -> u8 {
    u8::MAX - certainty.to_bits()
}

fn write_png<const CHANNELS: usize>(
    map: &MapImage<'_>,
    scale: NonZeroU32,
    colours: ColorType,
    out: impl Write,
    pixel: impl Fn(u32, u32, Certainty) -> [u8; CHANNELS],
) -> io::Result<()> {
    let side = |cells: u32| {
        let pixels = cells.checked_mul(scale.get());
        pixels
            .filter(|&pixels| pixels <= LONGEST_SIDE)
            .ok_or_else(|| {
                let message =
                    format!("{cells} cells at {scale} pixels a cell are too many; scale down");
                io::Error::new(io::ErrorKind::InvalidInput, message)
            })
    };
    let mut encoder = Encoder::new(out, side(map.width())?, side(map.height())?);
    encoder.set_color(colours);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Balanced);
    // Maps have large equal areas, which pack better without a filter.
    encoder.set_filter(Filter::NoFilter);
    let mut writer = encoder.write_header()?;
    let mut stream = writer.stream_writer()?;
    let mut line = Vec::new();
    for y in (0..map.height()).rev() {
        line.clear();
        for (x, &certainty) in (0..).zip(map.row(y)) {
            let colour = pixel(x, y, certainty);
            for _ in 0..scale.get() {
                line.extend_from_slice(&colour);
            }
        }
        for _ in 0..scale.get() {
            stream.write_all(&line)?;
        }
    }
    stream.finish()?;
    writer.finish()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

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

    fn decoded(file: &[u8]) -> (u32, u32, Vec<u8>) {
        let mut reader = png::Decoder::new(Cursor::new(file)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        (info.width, info.height, pixels)
    }

    const SCALE: fn(u32) -> NonZeroU32 = |scale| NonZeroU32::new(scale).unwrap();

    #[test]
    fn highest_row_is_on_top_and_occupied_is_black() {
        let cells = [0, 128, 255, 50, 60, 70].map(Certainty::from_bits);
        let map = MapImage::try_new(3, 2, &cells, 100, Point::ORIGIN).unwrap();
        let mut file = Vec::new();
        write_grey_png(&map, SCALE(1), &mut file).unwrap();
        assert_eq!(decoded(&file), (3, 2, vec![205, 195, 185, 255, 127, 0]));
    }

    #[test]
    fn scaled_cell_is_a_square_of_pixels() {
        let cells = [255, 0].map(Certainty::from_bits);
        let map = MapImage::try_new(2, 1, &cells, 100, Point::ORIGIN).unwrap();
        let mut file = Vec::new();
        write_grey_png(&map, SCALE(2), &mut file).unwrap();
        assert_eq!(decoded(&file), (4, 2, vec![0, 0, 255, 255, 0, 0, 255, 255]));
        let mut again = Vec::new();
        write_grey_png(&map, SCALE(2), &mut again).unwrap();
        assert_eq!(file, again);
    }

    #[test]
    fn colours_are_by_cell() {
        let cells = [Certainty::FREE; 4];
        let map = MapImage::try_new(2, 2, &cells, 100, Point::ORIGIN).unwrap();
        let mut file = Vec::new();
        write_colour_png(&map, SCALE(1), &mut file, |x, y, certainty| {
            [x as u8, y as u8, certainty.to_bits() + 9]
        })
        .unwrap();
        let expected = vec![0, 1, 9, 1, 1, 9, 0, 0, 9, 1, 0, 9];
        assert_eq!(decoded(&file), (2, 2, expected));
    }

    #[test]
    fn too_large_a_picture_is_refused() {
        let cells = [Certainty::FREE; 4];
        let map = MapImage::try_new(4, 1, &cells, 100, Point::ORIGIN).unwrap();
        for scale in [u32::MAX, 16_384] {
            let error = write_grey_png(&map, SCALE(scale), io::sink()).unwrap_err();
            assert_eq!(error.kind(), io::ErrorKind::InvalidInput);
        }
    }
}
