//! The font that comes with the program: how wide a text is, and the outlines of its characters.

use ab_glyph::{Font, FontRef, OutlineCurve, Point};
use std::sync::LazyLock;

/// The typeface named in [`FAMILY`], cut down to what charts write; see the README beside it.
const BYTES: &[u8] = include_bytes!("../../data/chart-font.ttf");

/// What an SVG asks for: the font itself, then those of the same widths.
pub(super) const FAMILY: &str = "DejaVu Sans, Verdana, sans-serif";

/// How far the middle of small letters lies above the line they stand on, in parts of the size.
pub(super) const HALF_X_HEIGHT: f64 = 0.2735;

static FONT: LazyLock<FontRef<'static>> =
    LazyLock::new(|| FontRef::try_from_slice(BYTES).expect("the shipped font is sound"));

/// Pixels a font unit at `size` pixels an em.
fn scale(size: f64) -> f64 {
    size / f64::from(FONT.units_per_em().unwrap_or(2048.0))
}

/// How wide `text` is, in pixels, at `size` pixels an em.
pub(super) fn width(text: &str, size: f64) -> f64 {
    let advance = |c| f64::from(FONT.h_advance_unscaled(FONT.glyph_id(c)));
    text.chars().map(advance).sum::<f64>() * scale(size)
}

/// What outlines are drawn with; y grows upwards from the line that the text stands on.
pub(super) trait Pen {
    fn move_to(&mut self, to: (f64, f64));
    fn line_to(&mut self, to: (f64, f64));
    fn quad_to(&mut self, by: (f64, f64), to: (f64, f64));
    fn cubic_to(&mut self, by: [(f64, f64); 2], to: (f64, f64));
    fn close(&mut self);
}

/// Draws the outlines of `text`, which begins at (0, 0), at `size` pixels an em.
pub(super) fn outline(text: &str, size: f64, pen: &mut dyn Pen) {
    let scale = scale(size);
    let mut left = 0.0;
    for c in text.chars() {
        let glyph = FONT.glyph_id(c);
        let place = |p: Point| (left + f64::from(p.x) * scale, f64::from(p.y) * scale);
        let mut last = None;
        for curve in FONT.outline(glyph).map_or(Vec::new(), |o| o.curves) {
            let (from, to) = match curve {
                OutlineCurve::Line(from, to)
                | OutlineCurve::Quad(from, _, to)
                | OutlineCurve::Cubic(from, _, _, to) => (from, to),
            };
            if last != Some(from) {
                if last.is_some() {
                    pen.close();
                }
                pen.move_to(place(from));
            }
            match curve {
                OutlineCurve::Line(..) => pen.line_to(place(to)),
                OutlineCurve::Quad(_, by, _) => pen.quad_to(place(by), place(to)),
                OutlineCurve::Cubic(_, a, b, _) => pen.cubic_to([place(a), place(b)], place(to)),
            }
            last = Some(to);
        }
        if last.is_some() {
            pen.close();
        }
        left += f64::from(FONT.h_advance_unscaled(glyph)) * scale;
    }
}

/// `text` shortened to `room` pixels at `size`, the rest being `…`; control characters are blanks.
pub(super) fn fitted(text: &str, size: f64, room: f64) -> String {
    let dots = width("…", size);
    let mut kept = String::new();
    // As much of it as leaves room for the dots.
    let mut short = 0;
    for c in text.chars() {
        kept.push(if c.is_control() { ' ' } else { c });
        let width = width(&kept, size);
        if width > room {
            kept.truncate(short);
            return kept.trim_end().to_owned() + "…";
        }
        if width + dots <= room {
            short = kept.len();
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_font_has_every_character_that_charts_write() {
        let missing = FONT.glyph_id('\u{4E00}');
        for c in ('!'..='~').chain("°±²³µ·×äöüßÄÖÜσμΔαβ–—…−≈≤≥→∞".chars())
        {
            assert_ne!(FONT.glyph_id(c), missing, "{c}");
        }
    }

    #[test]
    fn a_text_grows_with_its_size_and_its_length() {
        assert!((width("mm", 40.0) - 2.0 * width("mm", 20.0)).abs() < 1e-9);
        assert!((width("mm", 20.0) - 2.0 * width("m", 20.0)).abs() < 1e-9);
        assert!(width("", 20.0) == 0.0);
    }

    #[test]
    fn what_does_not_fit_ends_in_dots() {
        assert_eq!(fitted("short", 20.0, 500.0), "short");
        let long = fitted("a title that is longer than its room", 20.0, 150.0);
        assert!(long.starts_with("a title") && long.ends_with('…'), "{long}");
        assert!(width(&long, 20.0) <= 150.0, "{long}");
        assert_eq!(fitted("a\nb\u{1b}", 20.0, 500.0), "a b ");
        assert_eq!(fitted("m", 20.0, 1.0), "…");
    }
}
