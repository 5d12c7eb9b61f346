//! Grey images in the portable graymap format, binary (P5) and plain (P2).

use super::MOST_CELLS;
use super::error::PixelError;

/// Decodes `bytes`, telling `pixel` each grey (scaled to 255) and its alpha from the top left on;
/// returns width and height.
///
/// Nothing is told before the announced size is known to be there.
pub(super) fn decode(
    bytes: &[u8],
    pixel: &mut dyn FnMut(u8, u8),
) -> Result<(u32, u32), PixelError> {
    let plain = match bytes.get(..2) {
        Some(b"P5") => false,
        Some(b"P2") => true,
        _ => return Err(PixelError::UnknownFormat),
    };
    let mut rest = &bytes[2..];
    let width = header_number(&mut rest)?;
    let height = header_number(&mut rest)?;
    let largest = header_number(&mut rest)?;
    if width == 0 || height == 0 {
        return Err(PixelError::Empty);
    }
    if largest == 0 || largest > 255 {
        return Err(PixelError::Depth(largest));
    }
    let count = u64::from(width) * u64::from(height);
    if count > MOST_CELLS {
        return Err(PixelError::TooLarge { width, height });
    }
    // Exactly one white space ends the header; in a plain file more do no harm.
    rest = match rest.split_first() {
        Some((byte, rest)) if byte.is_ascii_whitespace() => rest,
        _ => return Err(PixelError::Header),
    };
    let wrong_size = PixelError::Size { width, height };
    let mut give = |value: u32| {
        // Rounds to the nearest; 255 leaves every value as it is.
        let grey = (value * 255 + largest / 2) / largest;
        u8::try_from(grey).map_or(Err(PixelError::Sample), |grey| {
            pixel(grey, u8::MAX);
            Ok(())
        })
    };
    if plain {
        let words = || {
            let lines = rest.split(|&byte| byte == b'\n');
            let bare = lines.filter_map(|line| line.split(|&byte| byte == b'#').next());
            let words = bare.flat_map(|line| line.split(u8::is_ascii_whitespace));
            words.filter(|word| !word.is_empty())
        };
        if words().count() as u64 != count {
            return Err(wrong_size);
        }
        for word in words() {
            let value: Option<u32> = str::from_utf8(word).ok().and_then(|w| w.parse().ok());
            give(value.filter(|&v| v <= largest).ok_or(PixelError::Sample)?)?;
        }
    } else {
        let held = rest.len() as u64;
        let Some((pixels, behind)) = (held >= count).then(|| rest.split_at(count as usize)) else {
            return Err(wrong_size);
        };
        if !behind.trim_ascii().is_empty() {
            return Err(wrong_size);
        }
        for &value in pixels {
            if u32::from(value) > largest {
                return Err(PixelError::Sample);
            }
            give(u32::from(value))?;
        }
    }
    Ok((width, height))
}

/// Takes a number of the header off `rest`, with the white space and comments before it.
fn header_number(rest: &mut &[u8]) -> Result<u32, PixelError> {
    let before = *rest;
    loop {
        *rest = rest.trim_ascii_start();
        if rest.first() != Some(&b'#') {
            break;
        }
        let end = rest.iter().position(|&byte| byte == b'\n');
        *rest = &rest[end.ok_or(PixelError::Header)?..];
    }
    let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
    if before.len() == rest.len() || digits == 0 {
        return Err(PixelError::Header);
    }
    let (number, behind) = rest.split_at(digits);
    *rest = behind;
    let number = str::from_utf8(number).map_err(|_| PixelError::Header)?;
    number.parse().map_err(|_| PixelError::Header)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(bytes: &[u8]) -> Result<(u32, u32, Vec<u8>), String> {
        let mut pixels = Vec::new();
        match decode(bytes, &mut |grey, _| pixels.push(grey)) {
            Ok((width, height)) => Ok((width, height, pixels)),
            Err(error) => Err(error.to_string()),
        }
    }

    #[test]
    fn both_kinds_read_alike_with_comments_anywhere_in_the_header() {
        let expected = Ok((3, 2, vec![0, 205, 254, 10, 35, 13]));
        // The binary pixels 10, 35 and 13 are a line feed, a '#' and a carriage return.
        let binary = b"P5 # kind\n# by map_saver\n3 2 # size\n#\n255\n\0\xCD\xFE\x0A#\x0D";
        assert_eq!(decoded(binary), expected);
        let plain = b"P2\n3 2\n255\n0 205 254 # top\n# note 7\n10 35\r\n13";
        assert_eq!(decoded(plain), expected);
    }

    #[test]
    fn a_smaller_range_is_stretched() {
        assert_eq!(decoded(b"P2 3 1 4 0 2 4"), Ok((3, 1, vec![0, 128, 255])));
        assert_eq!(decoded(b"P5 2 1 1\n\x00\x01"), Ok((2, 1, vec![0, 255])));
    }

    #[test]
    fn a_size_that_is_not_there_is_refused_before_anything_is_told() {
        let mut told = 0;
        for bytes in [
            &b"P5 60000 4000 255\nabc"[..],
            b"P5 2 2 255\nabc",
            b"P5 2 2 255\nabcde",
            b"P2 2 2 255\n1 2 3",
            b"P2 2 2 255\n1 2 3 4 5",
        ] {
            let error = decode(bytes, &mut |_, _| told += 1).unwrap_err();
            assert!(matches!(error, PixelError::Size { .. }), "{error}");
        }
        let huge = decode(b"P5 4294967295 4294967295 255\n", &mut |_, _| told += 1);
        assert!(matches!(huge, Err(PixelError::TooLarge { .. })));
        assert_eq!(told, 0);
    }

    #[test]
    fn damaged_headers_and_samples_are_refused() {
        for bytes in [
            &b"P5"[..],
            b"P5 2",
            b"P5 2 2 255",
            b"P52 2 255\nabcd",
            b"P5 -2 2 255\nabcd",
            b"P5 2 2 # no end",
            b"P5 2 99999999999 255\n",
        ] {
            assert!(matches!(
                decode(bytes, &mut |_, _| ()),
                Err(PixelError::Header)
            ));
        }
        assert!(matches!(
            decode(b"P5 0 2 255\n", &mut |_, _| ()),
            Err(PixelError::Empty)
        ));
        let wide = decode(b"P5 1 1 65535\n\0\0", &mut |_, _| ());
        assert!(matches!(wide, Err(PixelError::Depth(65535))));
        for bytes in [
            &b"P2 1 1 255 x"[..],
            b"P2 1 1 9 10",
            b"P2 1 1 9 -1",
            b"P5 1 1 9\n\x0A",
        ] {
            assert!(matches!(
                decode(bytes, &mut |_, _| ()),
                Err(PixelError::Sample)
            ));
        }
        assert!(matches!(
            decode(b"GIF89a", &mut |_, _| ()),
            Err(PixelError::UnknownFormat)
        ));
    }
}
