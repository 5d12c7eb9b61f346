//! A reader of binary PGM, independent of the writer under test.

/// Reads a binary graymap of 8 bits: width, height, pixels from the top left.
///
/// # Panics
/// If the bytes are not such a graymap.
#[must_use]
pub fn pgm(bytes: &[u8]) -> (usize, usize, &[u8]) {
    let mut fields = bytes.splitn(4, |byte| byte.is_ascii_whitespace());
    let mut field = || fields.next().expect("four header fields");
    assert_eq!(field(), b"P5");
    let number = |field: &[u8]| -> usize {
        let text = str::from_utf8(field).expect("a number");
        text.parse().expect("a number")
    };
    let (width, height) = (number(field()), number(field()));
    let (depth, pixels) = {
        let rest = field();
        let end = rest
            .iter()
            .position(u8::is_ascii_whitespace)
            .expect("pixels");
        rest.split_at(end)
    };
    assert_eq!(number(depth), 255);
    let pixels = &pixels[1..];
    assert_eq!(pixels.len(), width * height);
    (width, height, pixels)
}
