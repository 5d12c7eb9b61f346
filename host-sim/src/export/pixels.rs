//! The pixels of a map's image: PGM, PPM, PBM, PAM, PNG, BMP, JPEG and GIF.
//!
//! Before any memory is taken, the size in the header is checked against the length of the file.

use image::codecs::{
    bmp::BmpDecoder, gif::GifDecoder, jpeg::JpegDecoder, png::PngDecoder, pnm::PnmDecoder,
};
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, Limits, guess_format};
use std::io::{self, Cursor};

/// What is wrong with a map's image.
#[derive(Debug, thiserror::Error)]
pub enum PixelError {
    /// It is of no format that is read.
    #[error("is not PGM, PPM, PBM, PNG, BMP, JPEG or GIF; convert the image")]
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
    /// The file holds fewer pixels than its header announces.
    #[error("announces {width} x {height} pixels but does not hold them; copy the file anew")]
    Size {
        /// Pixels a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// It is of a variant of its format that is not read.
    #[error("is a {0} of a variant that is not read; convert it to a plain PNG or PGM")]
    Variant(&'static str),
    /// The decoder failed.
    #[error("is a damaged {name}; save the map again")]
    Damaged {
        /// The format.
        name: &'static str,
        /// The decoder's error.
        source: ImageError,
    },
}

/// The pixel of trinary maps that means *unknown*.
pub(super) const UNKNOWN_PIXEL: u8 = 205;

/// The most cells that a map may have: a square of 1.6 km in cells of 10 cm.
const MOST_CELLS: u64 = 1 << 28;

/// The most bytes of decoded samples.
const MOST_BYTES: u64 = 1 << 30;

/// How far deflate can pack, at most (zlib's technical notes: 1032 to 1), rounded up. JPEG and GIF stay
/// below eight times that in pixels a byte: a block of 64 pixels takes at least 2 bits, a code of 12 bits
/// stands for at most 4,096 pixels.
const DEFLATE_AT_MOST: u64 = 1100;

/// Returns whether `bytes` begin as an image that [`Pixels::decode`] reads.
pub(super) fn is_image(bytes: &[u8]) -> bool {
    match format(bytes) {
        // These begin with letters, as a text may.
        Some(ImageFormat::Pnm) => bytes.get(2).is_some_and(u8::is_ascii_whitespace),
        Some(ImageFormat::Bmp) => str::from_utf8(bytes).is_err(),
        found => found.is_some(),
    }
}

fn format(bytes: &[u8]) -> Option<ImageFormat> {
    use ImageFormat::{Bmp, Gif, Jpeg, Png, Pnm};
    let format = guess_format(bytes).ok()?;
    matches!(format, Bmp | Gif | Jpeg | Png | Pnm).then_some(format)
}

/// An image's size and its pixels, each as grey and alpha, from the top left.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pixels {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) pixels: Vec<(u8, u8)>,
    /// The grey of [`UNKNOWN_PIXEL`], which differs where the largest value is not 255.
    pub(super) unknown_grey: u8,
    /// What a user should know about it, a line each.
    pub(super) notes: Vec<String>,
}

impl Pixels {
    /// Decodes `bytes`.
    ///
    /// Samples of another range than 0..=255 are scaled to it and rounded; those above the largest value
    /// become 255. Colours become the mean of red, green and blue, rounded to the nearest. The first
    /// picture of an animation is read.
    pub(super) fn decode(bytes: &[u8]) -> Result<Self, PixelError> {
        let mut reader = Cursor::new(bytes);
        let length = bytes.len() as u64;
        let packed = length * 8 * DEFLATE_AT_MOST;
        match format(bytes).ok_or(PixelError::UnknownFormat)? {
            ImageFormat::Pnm => {
                let name = "PGM, PPM or PBM";
                let decoder = PnmDecoder::new(&mut reader).map_err(|error| failed(name, error))?;
                let largest = decoder.header().maximal_sample();
                // A bit is a sample of a binary PBM alone; a byte of others holds one at most.
                let most = if bytes.starts_with(b"P4") {
                    length * 8
                } else {
                    length
                };
                if decoder.total_bytes() > most {
                    let (width, height) = decoder.dimensions();
                    check_size(width, height, u64::MAX)?;
                    return Err(PixelError::Size { width, height });
                }
                let mut found = Self::read(name, decoder, most)?;
                let unknown = u32::from(UNKNOWN_PIXEL);
                if (unknown..255).contains(&largest) {
                    found.unknown_grey = ((unknown * 255 + largest / 2) / largest) as u8;
                }
                let behind = bytes.get(reader.position() as usize..).unwrap_or(&[]);
                if !behind.trim_ascii().is_empty() {
                    let behind = behind.len();
                    found.notes.push(format!(
                        "{behind} bytes follow the pixels that the header announces; they are not read"
                    ));
                }
                Ok(found)
            }
            ImageFormat::Png => {
                let decoder = PngDecoder::with_limits(reader, limits())
                    .map_err(|error| failed("PNG", error))?;
                Self::read("PNG", decoder, packed)
            }
            ImageFormat::Bmp => {
                let decoder = BmpDecoder::new(reader).map_err(|error| failed("BMP", error))?;
                // A run of 255 pixels takes 2 bytes.
                Self::read("BMP", decoder, length * 128)
            }
            ImageFormat::Gif => {
                let decoder = GifDecoder::new(reader).map_err(|error| failed("GIF", error))?;
                Self::read("GIF", decoder, packed)
            }
            ImageFormat::Jpeg => {
                let decoder = JpegDecoder::new(reader).map_err(|error| failed("JPEG", error))?;
                let mut found = Self::read("JPEG", decoder, packed)?;
                found.notes.push(
                    "JPEG blurs edges, which makes cells beside them unknown; PNG and PGM do not"
                        .into(),
                );
                Ok(found)
            }
            _ => Err(PixelError::UnknownFormat),
        }
    }

    /// Reads an image that can have at most `most` pixels by the length of its file.
    fn read(
        name: &'static str,
        mut decoder: impl ImageDecoder,
        most: u64,
    ) -> Result<Self, PixelError> {
        let (width, height) = decoder.dimensions();
        let count = check_size(width, height, most)?;
        if decoder.total_bytes() > MOST_BYTES {
            return Err(PixelError::TooLarge { width, height });
        }
        let limited = decoder.set_limits(limits());
        limited.map_err(|error| failed(name, error))?;
        let image = DynamicImage::from_decoder(decoder).map_err(|error| match error {
            ImageError::IoError(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
                PixelError::Size { width, height }
            }
            error => failed(name, error),
        })?;
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
                        // Of 16 bits the higher byte: 205 for both 205 · 256 and 205 · 257.
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
            unknown_grey: UNKNOWN_PIXEL,
            notes: Vec::new(),
        })
    }
}

/// The memory that a decoder may take, for its picture and for what else the file holds.
fn limits() -> Limits {
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(MOST_BYTES);
    limits
}

/// Returns the number of pixels, of which there can be at most `most`.
fn check_size(width: u32, height: u32, most: u64) -> Result<u64, PixelError> {
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
    Ok(count)
}

/// The failure of a decoder.
fn failed(name: &'static str, source: ImageError) -> PixelError {
    match source {
        ImageError::Unsupported(_) => PixelError::Variant(name),
        source => PixelError::Damaged { name, source },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::ExtendedColorType;
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
    fn greys_of_every_format_are_read() {
        let (pixels, size) = ([205, 0, 254], (3, 1));
        let mut bmp = Vec::new();
        let mut encoder = image::codecs::bmp::BmpEncoder::new(&mut bmp);
        encoder
            .encode(&pixels, 3, 1, ExtendedColorType::L8)
            .unwrap();
        assert_eq!(greys(&bmp).unwrap(), (3, 1, pixels.to_vec()));
        let mut gif = Vec::new();
        let mut encoder = image::codecs::gif::GifEncoder::new(&mut gif);
        let rgb = pixels.map(|grey| [grey; 3]).concat();
        encoder
            .encode(&rgb, size.0, size.1, ExtendedColorType::Rgb8)
            .unwrap();
        drop(encoder);
        assert_eq!(greys(&gif).unwrap(), (3, 1, pixels.to_vec()));
        let mut jpeg = Vec::new();
        let encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut jpeg, 100);
        let area = [205; 64];
        image::ImageEncoder::write_image(encoder, &area, 8, 8, ExtendedColorType::L8).unwrap();
        let found = Pixels::decode(&jpeg).unwrap();
        assert!(found.pixels.iter().all(|pixel| pixel.0.abs_diff(205) <= 1));
        assert!(found.notes[0].starts_with("JPEG blurs edges"));
    }

    #[test]
    fn ppm_pbm_and_pam_are_read() {
        let expected = (2, 1, vec![0, 254]);
        assert_eq!(greys(b"P6 2 1 255\n\0\0\0\xFE\xFE\xFE").unwrap(), expected);
        assert_eq!(greys(b"P3 2 1 255 0 0 0 254 254 254").unwrap(), expected);
        // A bit of 1 is black.
        let expected = (2, 1, vec![0, 255]);
        assert_eq!(greys(b"P4 2 1\n\x80").unwrap(), expected);
        assert_eq!(greys(b"P1 2 1 1 0").unwrap(), expected);
        let pam = b"P7\nWIDTH 2\nHEIGHT 1\nDEPTH 2\nMAXVAL 255\nTUPLTYPE GRAYSCALE_ALPHA\nENDHDR\n\xFE\xFF\xFE\0";
        assert_eq!(grey_and_alpha(pam), [(254, 255), (254, 0)]);
    }

    #[test]
    fn pgm_of_16_bits_is_scaled() {
        let file = b"P5 4 1 65535\n\0\0\xCD\xCD\xFE\xFE\xFF\xFF";
        assert_eq!(greys(file).unwrap(), (4, 1, vec![0, 205, 254, 255]));
        let file = b"P5 3 1 1023\n\0\0\x02\0\x03\xFF";
        assert_eq!(greys(file).unwrap(), (3, 1, vec![0, 128, 255]));
        let file = b"P2 3 1 65535 52480 52685 65535";
        assert_eq!(greys(file).unwrap(), (3, 1, vec![205, 205, 255]));
    }

    #[test]
    fn unknown_grey_follows_the_largest_value() {
        let found = Pixels::decode(b"P5 3 1 254\n\0\xCD\xFE").unwrap();
        assert_eq!((found.pixels[1].0, found.unknown_grey), (206, 206));
        for file in [
            &b"P5 1 1 255\n\0"[..],
            b"P5 1 1 100\n\0",
            b"P5 1 1 65535\n\0\0",
        ] {
            assert_eq!(Pixels::decode(file).unwrap().unknown_grey, 205);
        }
    }

    #[test]
    fn bytes_behind_the_pixels_are_noted() {
        for (file, expected) in [
            (&b"P5 1 1 255\n\0more"[..], Some("4 bytes follow")),
            (b"P2 1 1 255 0 7 7", Some("3 bytes follow")),
            (b"P5 1 1 255\n\0\n", None),
        ] {
            let found = Pixels::decode(file).unwrap();
            assert_eq!((found.width, found.pixels[0].0), (1, 0));
            match expected {
                Some(text) => assert!(found.notes[0].starts_with(text), "{:?}", found.notes),
                None => assert!(found.notes.is_empty()),
            }
        }
    }

    #[test]
    fn images_are_told_from_text() {
        for image in [
            &b"P5\n"[..],
            b"P2 ",
            b"\x89PNG\r\n\x1a\n",
            b"GIF89a",
            b"BM\xff\xff",
        ] {
            assert!(is_image(image), "{image:?}");
        }
        for text in [&b"P5x: 1"[..], b"BMW: 2", b"image: map.pgm", b""] {
            assert!(!is_image(text), "{text:?}");
        }
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
            b"P5 2 1 255\n\0",
            b"P2 30 1 255 1 2",
            b"P5 16384 16384 255\n",
            b"P5 3 1 65535\n\0\0\0\0",
            b"P6 3 1 255\n\0\0\0\0\0\0",
        ] {
            let error = Pixels::decode(file).unwrap_err();
            assert!(matches!(error, PixelError::Size { .. }), "{error}");
        }
        for size in ["16385 16384", "4294967295 4294967295"] {
            for kind in ["P5", "P6"] {
                let file = format!("{kind} {size} 255\n");
                let error = Pixels::decode(file.as_bytes()).unwrap_err();
                let error = error.to_string();
                assert_eq!(error.lines().count(), 1);
                assert!(error.contains("more than a map may have") || error.contains("variant"));
            }
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
    fn damage_is_named_in_our_words() {
        for bytes in [
            &b"P5"[..],
            b"P5 1",
            b"P5 1 1",
            b"P5 x 1 255\n",
            b"P2 1 1 255 x",
            b"P5 1 1 0\n\0",
        ] {
            let error = Pixels::decode(bytes).unwrap_err();
            let expected = "is a damaged PGM, PPM or PBM; save the map again";
            assert_eq!(error.to_string(), expected, "{bytes:?}");
        }
        let empty = Pixels::decode(b"P5 0 2 255\n").unwrap_err();
        assert!(matches!(empty, PixelError::Empty), "{empty}");
        for bytes in [
            &b"RIFF\0\0\0\0WEBP"[..],
            b"P8 1 1 255\n\0\0\0",
            b"image: x",
            b"",
        ] {
            let error = Pixels::decode(bytes).unwrap_err();
            assert!(matches!(error, PixelError::UnknownFormat), "{error}");
        }
    }
}
