//! Images in the PNG format.

use super::MOST_CELLS;
use super::error::PixelError;
use png::{ColorType, Decoder, Transformations};
use std::io::Cursor;

/// The first bytes of every PNG.
pub(super) const MAGIC: [u8; 4] = *b"\x89PNG";

/// How far deflate can pack, at most (zlib's technical notes: 1032 to 1), rounded up.
const PACKED_AT_MOST: u64 = 1100;

/// Decodes `bytes`, telling `pixel` each grey and its alpha from the top left on; returns width and
/// height. Colours become the mean of red, green and blue, rounded to the nearest.
///
/// Memory: one row.
pub(super) fn decode(
    bytes: &[u8],
    pixel: &mut dyn FnMut(u8, u8),
) -> Result<(u32, u32), PixelError> {
    let mut decoder = Decoder::new(Cursor::new(bytes));
    // Palettes become colours, and 1 to 4 and 16 bits become 8.
    decoder.set_transformations(Transformations::EXPAND | Transformations::STRIP_16);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let info = decoder.read_header_info()?;
    let (width, height, interlaced) = (info.width, info.height, info.interlaced);
    let count = u64::from(width) * u64::from(height);
    if count > MOST_CELLS {
        return Err(PixelError::TooLarge { width, height });
    }
    // Even the flattest image, at one bit a pixel, needs this much.
    if count / 8 > bytes.len() as u64 * PACKED_AT_MOST {
        return Err(PixelError::Size { width, height });
    }
    if interlaced {
        return Err(PixelError::Interlaced);
    }
    let mut reader = decoder.read_info()?;
    let channels = match reader.output_color_type().0 {
        ColorType::Grayscale => 1,
        ColorType::GrayscaleAlpha => 2,
        ColorType::Rgb => 3,
        ColorType::Rgba => 4,
        ColorType::Indexed => return Err(PixelError::UnknownFormat),
    };
    let mut rows = 0;
    while let Some(row) = reader.next_row()? {
        for sample in row.data().chunks_exact(channels) {
            let (colours, alpha) = match *sample {
                [ref grey @ .., alpha] if channels % 2 == 0 => (grey, alpha),
                ref colours => (colours, u8::MAX),
            };
            let sum: u32 = colours.iter().map(|&colour| u32::from(colour)).sum();
            let count = colours.len() as u32;
            // A mean of bytes is one.
            pixel(((sum + count / 2) / count) as u8, alpha);
        }
        rows += 1;
    }
    if rows != height {
        return Err(PixelError::Size { width, height });
    }
    Ok((width, height))
}

#[cfg(test)]
mod tests {
    use super::*;
    use png::{BitDepth, Encoder};

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

    fn decoded(file: &[u8]) -> Vec<(u8, u8)> {
        let mut pixels = Vec::new();
        decode(file, &mut |grey, alpha| pixels.push((grey, alpha))).unwrap();
        pixels
    }

    #[test]
    fn greys_and_colours_of_any_depth_become_bytes() {
        let eight = encoded(ColorType::Grayscale, BitDepth::Eight, (2, 1), &[205, 7]);
        assert_eq!(decoded(&eight), [(205, 255), (7, 255)]);
        let colour = encoded(ColorType::Rgb, BitDepth::Eight, (1, 1), &[10, 20, 31]);
        assert_eq!(decoded(&colour), [(20, 255)]);
        let clear = encoded(ColorType::Rgba, BitDepth::Eight, (1, 1), &[10, 20, 30, 4]);
        assert_eq!(decoded(&clear), [(20, 4)]);
        let sixteen = encoded(ColorType::Grayscale, BitDepth::Sixteen, (1, 1), &[205, 9]);
        assert_eq!(decoded(&sixteen), [(205, 255)]);
        let bits = encoded(ColorType::Grayscale, BitDepth::One, (2, 1), &[0b0100_0000]);
        assert_eq!(decoded(&bits), [(0, 255), (255, 255)]);
    }

    #[test]
    fn an_announced_size_that_cannot_be_there_is_refused() {
        let mut file = encoded(ColorType::Grayscale, BitDepth::Eight, (1, 1), &[0]);
        file[16..24].copy_from_slice(&[0, 0, 0x3F, 0, 0, 0, 0x3F, 0]);
        let checksum = {
            let mut crc = flate2::Crc::new();
            crc.update(&file[12..29]);
            crc.sum()
        };
        file[29..33].copy_from_slice(&checksum.to_be_bytes());
        let error = decode(&file, &mut |_, _| ()).unwrap_err();
        assert!(matches!(error, PixelError::Size { .. }), "{error}");
    }

    #[test]
    fn every_cut_is_an_error() {
        let file = encoded(ColorType::Grayscale, BitDepth::Eight, (4, 3), &[9; 12]);
        // The last 12 bytes only say that the image is over.
        for end in MAGIC.len()..file.len() - 16 {
            assert!(
                decode(&file[..end], &mut |_, _| ()).is_err(),
                "cut at {end}"
            );
        }
    }
}
