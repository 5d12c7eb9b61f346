//! The image of a map: PGM, PNG or BMP.

use super::error::PixelError;
use image::codecs::{bmp::BmpDecoder, png::PngDecoder, pnm::PnmDecoder};
use image::{DynamicImage, ImageDecoder, ImageFormat, guess_format};
use std::io::Cursor;

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
    use png::{BitDepth, ColorType, Encoder};

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
