//! PNG pictures of maps.
//!
//! The top row of the picture is the highest y. The same map gives the same bytes. Memory: one row
//! of the picture, whatever the scale.

use super::map_image::MapImage;
use certainty_core::certainty::Certainty;
use core::num::NonZeroU32;
use png::{BitDepth, ColorType, Compression, Encoder, Filter};
use std::io::{self, Write};

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
    use certainty_core::units::Point;

    fn decoded(file: &[u8]) -> (u32, u32, Vec<u8>) {
        let mut reader = png::Decoder::new(io::Cursor::new(file))
            .read_info()
            .unwrap();
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
