//! Maps as images: the map that is exported, the three states of its cells, its picture as PNG, and the
//! pixels of an image file.
//!
//! The top row of a picture is the highest y. The same map gives the same bytes. Memory: one row of the
//! picture, whatever the scale.

use super::files::one_line;
use certainty_core::certainty::Certainty;
use certainty_core::units::Point;
use core::num::NonZeroU32;
use image::codecs::{bmp::BmpDecoder, png::PngDecoder, pnm::PnmDecoder};
use image::{DynamicImage, ImageDecoder, ImageFormat, guess_format};
use png::{BitDepth, ColorType, Compression, Encoder, Filter};
use serde::Serialize;
use std::io::{self, Cursor, Write};

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

/// What is wrong with a map's image.
#[derive(Debug, thiserror::Error)]
pub enum PixelError {
    /// It is not a PGM, PNG or BMP.
    #[error("is not PGM (P5, P2), PNG or BMP; convert the image")]
    UnknownFormat,
    /// It has no pixels.
    #[error("has no pixels; save the map again")]
    Empty,
    /// It has more pixels than a map may have.
    #[error("is of {width} x {height} pixels, more than a map may have; cut it down")]
    TooLarge {
        /// Pixels a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// Its samples are wider than a byte.
    #[error("has the largest value {0} where 255 is supported; convert it to 8 bits")]
    Depth(u32),
    /// The header's size differs from the data's.
    #[error("announces {width} x {height} pixels but does not hold them; copy the file anew")]
    Size {
        /// Pixels a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// The decoder failed.
    #[error("is damaged ({}); save the map again", one_line(.0.to_string()))]
    Decode(#[from] image::ImageError),
}

/// The most cells that a map may have: a square of 1.6 km in cells of 10 cm.
const MOST_CELLS: u64 = 1 << 28;

/// How far deflate can pack, at most (zlib's technical notes: 1032 to 1), rounded up.
const DEFLATE_AT_MOST: u64 = 1100;

/// An image's size and its pixels, each as grey and alpha, from the top left.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pixels {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) pixels: Vec<(u8, u8)>,
}

impl Pixels {
    /// Decodes `bytes`.
    ///
    /// Greys of a PGM are scaled to 255; those above its largest value become 255. Colours become the mean of red, green and blue, rounded to
    /// the nearest. Before any memory is taken, the size in the header is checked against the length
    /// of the file.
    pub(super) fn decode(bytes: &[u8]) -> Result<Self, PixelError> {
        let mut reader = Cursor::new(bytes);
        let is_pgm = bytes.starts_with(b"P5") || bytes.starts_with(b"P2");
        match guess_format(bytes) {
            // A byte holds at least one pixel of these.
            Ok(ImageFormat::Pnm) if is_pgm => {
                let decoder = PnmDecoder::new(&mut reader)?;
                let largest = decoder.header().maximal_sample();
                if largest > 255 {
                    return Err(PixelError::Depth(largest));
                }
                let found = Self::read(decoder, bytes.len() as u64)?;
                // An image that is followed by more has another size than its header says.
                let behind = bytes.get(reader.position() as usize..);
                if behind.is_some_and(|rest| !rest.trim_ascii().is_empty()) {
                    let Self { width, height, .. } = found;
                    return Err(PixelError::Size { width, height });
                }
                Ok(found)
            }
            // At one bit a pixel.
            Ok(ImageFormat::Png) => {
                let most = bytes.len() as u64 * 8 * DEFLATE_AT_MOST;
                Self::read(PngDecoder::new(reader)?, most)
            }
            Ok(ImageFormat::Bmp) => Self::read(BmpDecoder::new(reader)?, bytes.len() as u64 * 8),
            _ => Err(PixelError::UnknownFormat),
        }
    }

    /// Reads an image that can have at most `most` pixels by the length of its file.
    fn read(decoder: impl ImageDecoder, most: u64) -> Result<Self, PixelError> {
        let (width, height) = decoder.dimensions();
        let count = u64::from(width) * u64::from(height);
        if count == 0 {
            return Err(PixelError::Empty);
        }
        if count > MOST_CELLS {
            return Err(PixelError::TooLarge { width, height });
        }
        if count > most {
            return Err(PixelError::Size { width, height });
        }
        let image = DynamicImage::from_decoder(decoder)?;
        let channels = usize::from(image.color().channel_count());
        let sample_bytes = usize::from(image.color().bytes_per_pixel()) / channels;
        let mut samples = Vec::with_capacity(channels);
        let mut pixels = Vec::with_capacity(count as usize);
        for pixel in image.as_bytes().chunks_exact(channels * sample_bytes) {
            samples.clear();
            samples.extend(
                pixel
                    .chunks_exact(sample_bytes)
                    .map(|sample| match *sample {
                        // Of 16 bits the higher byte.
                        [a, b] => u32::from(u16::from_ne_bytes([a, b]) >> 8),
                        [sample, ..] => u32::from(sample),
                        [] => 0,
                    }),
            );
            let (colours, alpha) = match samples[..] {
                [ref grey @ .., alpha] if channels % 2 == 0 => (grey, alpha as u8),
                ref colours => (colours, u8::MAX),
            };
            let count = colours.len() as u32;
            // A mean of bytes is a byte.
            let grey = (colours.iter().sum::<u32>() + count / 2) / count;
            pixels.push((grey as u8, alpha));
        }
        Ok(Self {
            width,
            height,
            pixels,
        })
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

    fn encoded(colours: ColorType, depth: BitDepth, size: (u32, u32), data: &[u8]) -> Vec<u8> {
        let mut file = Vec::new();
        let mut encoder = Encoder::new(&mut file, size.0, size.1);
        encoder.set_color(colours);
        encoder.set_depth(depth);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(data).unwrap();
        writer.finish().unwrap();
        file
    }

    fn grey_and_alpha(file: &[u8]) -> Vec<(u8, u8)> {
        Pixels::decode(file).unwrap().pixels
    }

    fn greys(file: &[u8]) -> Result<(u32, u32, Vec<u8>), PixelError> {
        let found = Pixels::decode(file)?;
        let greys = found.pixels.iter().map(|pixel| pixel.0).collect();
        Ok((found.width, found.height, greys))
    }

    #[test]
    fn pgm_of_both_kinds_reads_alike() {
        let expected = (3, 2, vec![0, 205, 254, 10, 35, 13]);
        // The binary pixels 10, 35 and 13 are a line feed, a '#' and a carriage return.
        let binary = b"P5 # kind\n# by map_saver\n3 2 # size\n#\n255\n\0\xCD\xFE\x0A#\x0D";
        assert_eq!(greys(binary).unwrap(), expected);
        let plain = b"P2\n# note 7\n3 2\n255\n0 205 254\n10 35\r\n13";
        assert_eq!(greys(plain).unwrap(), expected);
    }

    #[test]
    fn pgm_of_smaller_range_is_stretched() {
        let expected = (3, 1, vec![0, 128, 255]);
        assert_eq!(greys(b"P2 3 1 4 0 2 4").unwrap(), expected);
        assert_eq!(greys(b"P5 2 1 1\n\x00\x01").unwrap(), (2, 1, vec![0, 255]));
    }

    #[test]
    fn png_of_any_depth_becomes_bytes() {
        let eight = encoded(ColorType::Grayscale, BitDepth::Eight, (2, 1), &[205, 7]);
        assert_eq!(grey_and_alpha(&eight), [(205, 255), (7, 255)]);
        let colour = encoded(ColorType::Rgb, BitDepth::Eight, (1, 1), &[10, 20, 31]);
        assert_eq!(grey_and_alpha(&colour), [(20, 255)]);
        let clear = encoded(ColorType::Rgba, BitDepth::Eight, (1, 1), &[10, 20, 30, 4]);
        assert_eq!(grey_and_alpha(&clear), [(20, 4)]);
        let sixteen = encoded(ColorType::Grayscale, BitDepth::Sixteen, (1, 1), &[205, 9]);
        assert_eq!(grey_and_alpha(&sixteen), [(205, 255)]);
        let bits = encoded(ColorType::Grayscale, BitDepth::One, (2, 1), &[0b0100_0000]);
        assert_eq!(grey_and_alpha(&bits), [(0, 255), (255, 255)]);
    }

    #[test]
    fn bmp_is_read() {
        let mut file = Vec::new();
        let mut encoder = image::codecs::bmp::BmpEncoder::new(&mut file);
        encoder
            .encode(&[205, 0, 254], 3, 1, image::ExtendedColorType::L8)
            .unwrap();
        assert_eq!(greys(&file).unwrap(), (3, 1, vec![205, 0, 254]));
    }

    #[test]
    fn size_that_the_file_cannot_hold_is_refused() {
        let mut file = encoded(ColorType::Grayscale, BitDepth::Eight, (1, 1), &[0]);
        file[16..24].copy_from_slice(&[0, 0, 0x3F, 0, 0, 0, 0x3F, 0]);
        let checksum = {
            let mut crc = flate2::Crc::new();
            crc.update(&file[12..29]);
            crc.sum()
        };
        file[29..33].copy_from_slice(&checksum.to_be_bytes());
        for file in [
            &file[..],
            b"P5 9 9 255\n123",
            b"P2 30 1 255 1 2",
            b"P5 16384 16384 255\n",
            b"P5 1 1 255\n\0more",
        ] {
            let error = Pixels::decode(file).unwrap_err();
            assert!(matches!(error, PixelError::Size { .. }), "{error}");
        }
        for size in ["16385 16384", "4294967295 4294967295"] {
            let file = format!("P5 {size} 255\n");
            let error = Pixels::decode(file.as_bytes()).unwrap_err();
            assert!(matches!(error, PixelError::TooLarge { .. }), "{error}");
        }
    }

    #[test]
    fn every_cut_of_a_png_is_an_error() {
        let file = encoded(ColorType::Grayscale, BitDepth::Eight, (4, 3), &[9; 12]);
        // The last 12 bytes only mark the end of the image.
        for end in 4..file.len() - 16 {
            assert!(Pixels::decode(&file[..end]).is_err(), "cut at {end}");
        }
    }

    #[test]
    fn damage_of_a_pgm_is_named() {
        for bytes in [
            &b"P5"[..],
            b"P5 1",
            b"P5 1 1",
            b"P5 x 1 255\n",
            b"P2 1 1 255 x",
        ] {
            let error = Pixels::decode(bytes).unwrap_err();
            assert!(matches!(error, PixelError::Decode(_)), "{error}");
            assert_eq!(error.to_string().lines().count(), 1, "{error}");
        }
        let wide = Pixels::decode(b"P5 1 1 65535\n\0\0").unwrap_err();
        assert!(matches!(wide, PixelError::Depth(65535)), "{wide}");
        let empty = Pixels::decode(b"P5 0 2 255\n").unwrap_err();
        assert!(
            matches!(empty, PixelError::Empty | PixelError::Decode(_)),
            "{empty}"
        );
        for bytes in [&b"GIF89a"[..], b"P6 1 1 255\n\0\0\0", b""] {
            let error = Pixels::decode(bytes).unwrap_err();
            assert!(matches!(error, PixelError::UnknownFormat), "{error}");
        }
    }
}
