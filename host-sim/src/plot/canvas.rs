//! Where charts are drawn: a bitmap or an SVG document, and the text on them.
//!
//! Everything is drawn at [`FINE`] times the picture's size. The bitmap is then averaged down, so
//! that the edges of areas, which `plotters` does not smooth, are smooth; the SVG is scaled by its
//! view box.

use crate::export::{ExportError, OutDir};
use ab_glyph::{Font, FontRef, PxScale, point};
use plotters::coord::Shift;
use plotters::drawing::DrawingAreaErrorKind;
use plotters::prelude::{
    BitMapBackend, DrawingArea, DrawingBackend, IntoDrawingArea, SVGBackend, Text,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontDesc, FontFamily, FontStyle, FontTransform, RGBColor, TextStyle};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingErrorKind,
};
use png::{BitDepth, ColorType, Compression, Encoder};
use std::io;
use std::path::PathBuf;
use std::sync::LazyLock;

/// How many drawn pixels make one pixel of the picture, along each side.
pub(super) const FINE: u32 = 2;
/// Width of the drawing, in drawn pixels.
pub(super) const WIDTH: i32 = 1600 * FINE as i32;
/// Height of the drawing, in drawn pixels.
pub(super) const HEIGHT: i32 = 1000 * FINE as i32;

const SIZE: (u32, u32) = (WIDTH as u32, HEIGHT as u32);

/// A drawing in drawn pixels from the top left.
pub(super) type Area<D> = DrawingArea<D, Shift>;

/// What drawing on `D` comes to.
pub(super) type Drawn<D, T = ()> =
    Result<T, DrawingAreaErrorKind<<D as DrawingBackend>::ErrorType>>;

/// Something that is drawn on any backend.
pub(super) trait Draw {
    fn draw<D: DrawingBackend>(&self, area: &Area<D>) -> Drawn<D>;
}

/// Writes `chart` as `STEM.png` and `STEM.svg`.
pub(super) fn write(
    chart: &impl Draw,
    out: &OutDir,
    stem: &str,
) -> Result<[PathBuf; 2], ExportError> {
    let png = out.write(&format!("{stem}.png"), |file| {
        let (width, height) = (SIZE.0 / FINE, SIZE.1 / FINE);
        let mut encoder = Encoder::new(file, width, height);
        encoder.set_color(ColorType::Rgb);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_compression(Compression::Balanced);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&pixels(chart)?)?;
        writer.finish()?;
        Ok(())
    })?;
    let svg = out.write(&format!("{stem}.svg"), |file| {
        file.write_all(svg(chart)?.as_bytes())
    })?;
    Ok([png, svg])
}

/// The SVG document that shows `chart`; its texts stay texts.
pub(super) fn svg(chart: &impl Draw) -> io::Result<String> {
    let mut text = String::new();
    let area = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
    chart.draw(&area).map_err(io::Error::other)?;
    area.present().map_err(io::Error::other)?;
    drop(area);
    let size = |fine: u32| format!("width=\"{}\" height=\"{}\"", SIZE.0 / fine, SIZE.1 / fine);
    // The view box keeps the drawn size.
    Ok(text.replacen(&size(1), &size(FINE), 1))
}

/// The rows of `chart`'s picture from the top, three bytes a pixel.
pub(super) fn pixels(chart: &impl Draw) -> io::Result<Vec<u8>> {
    let mut drawn = vec![u8::MAX; SIZE.0 as usize * SIZE.1 as usize * 3];
    let area = Bitmap(BitMapBackend::with_buffer(&mut drawn, SIZE)).into_drawing_area();
    chart.draw(&area).map_err(io::Error::other)?;
    area.present().map_err(io::Error::other)?;
    drop(area);
    let (fine, row) = (FINE as usize, SIZE.0 as usize * 3);
    let rows = drawn.chunks_exact(row * fine);
    let halved = rows.flat_map(|rows| {
        (0..row / fine).map(move |at| {
            let (pixel, channel) = (at / 3 * fine, at % 3);
            let along = |y: usize| (0..fine).map(move |x| (y, x));
            let block = (0..fine).flat_map(along);
            let sum: u32 = block
                .map(|(y, x)| u32::from(rows[y * row + (pixel + x) * 3 + channel]))
                .sum();
            // A mean of bytes is a byte.
            ((sum + FINE * FINE / 2) / (FINE * FINE)) as u8
        })
    });
    Ok(halved.collect())
}

/// Pixels as `plotters` draws them, but for lines and texts.
///
/// `plotters` fills thick lines without smoothing and leaves holes where they cross themselves; its
/// own text renderer drops the space on the left of each letter.
struct Bitmap<'a>(BitMapBackend<'a>);

type Done<'a> = Result<(), DrawingErrorKind<<BitMapBackend<'a> as DrawingBackend>::ErrorType>>;

impl<'a> DrawingBackend for Bitmap<'a> {
    type ErrorType = <BitMapBackend<'a> as DrawingBackend>::ErrorType;

    fn get_size(&self) -> (u32, u32) {
        self.0.get_size()
    }

    fn ensure_prepared(&mut self) -> Done<'a> {
        self.0.ensure_prepared()
    }

    fn present(&mut self) -> Done<'a> {
        self.0.present()
    }

    fn draw_pixel(&mut self, at: BackendCoord, colour: BackendColor) -> Done<'a> {
        self.0.draw_pixel(at, colour)
    }

    fn draw_line<S: BackendStyle>(
        &mut self,
        from: BackendCoord,
        to: BackendCoord,
        style: &S,
    ) -> Done<'a> {
        self.0.draw_line(from, to, style)
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        upper_left: BackendCoord,
        lower_right: BackendCoord,
        style: &S,
        fill: bool,
    ) -> Done<'a> {
        self.0.draw_rect(upper_left, lower_right, style, fill)
    }

    /// Draws each piece as the pixels within half the width of it, with smooth edges.
    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Done<'a> {
        let points: Vec<BackendCoord> = path.into_iter().collect();
        let (colour, half) = (style.color(), f64::from(style.stroke_width()) / 2.0);
        let reach = half.ceil() as i32;
        for pair in points.windows(2) {
            let [(ax, ay), (bx, by)] = [pair[0], pair[1]];
            let (dx, dy) = (f64::from(bx - ax), f64::from(by - ay));
            let length = dx.hypot(dy);
            for y in ay.min(by) - reach..=ay.max(by) + reach {
                // The part of a slanted piece that lies near this row.
                let (mut from, mut to) = (ax.min(bx), ax.max(bx));
                if dy != 0.0 {
                    let middle = f64::from(ax) + f64::from(y - ay) * dx / dy;
                    let aside = (half + 1.0) * length / dy.abs();
                    from = from.max((middle - aside) as i32);
                    to = to.min((middle + aside) as i32);
                }
                for x in from - reach..=to + reach {
                    let (px, py) = (f64::from(x - ax), f64::from(y - ay));
                    let along = (px * dx + py * dy) / (length * length).max(1.0);
                    let along = along.clamp(0.0, 1.0);
                    let away = (px - along * dx).hypot(py - along * dy);
                    let covered = (half + 0.5 - away).clamp(0.0, 1.0);
                    if covered > 0.0 {
                        let alpha = colour.alpha * covered;
                        self.draw_pixel((x, y), BackendColor { alpha, ..colour })?;
                    }
                }
            }
        }
        Ok(())
    }

    /// Draws `text` where an SVG viewer puts it.
    fn draw_text<S: BackendTextStyle>(
        &mut self,
        text: &str,
        style: &S,
        (x, y): BackendCoord,
    ) -> Done<'a> {
        let em = style.size() / PLOTTERS_EM;
        let anchor = style.anchor();
        let before = match anchor.h_pos {
            HPos::Left => 0.0,
            HPos::Center => width(text, em) / 2.0,
            HPos::Right => width(text, em),
        };
        // As SVGBackend: 0.76em, 0.5ex and −0.5ex.
        let below = match anchor.v_pos {
            VPos::Top => 0.76,
            VPos::Center => HALF_X_HEIGHT,
            VPos::Bottom => -HALF_X_HEIGHT,
        };
        let colour = style.color();
        let mut left = -before;
        for c in text.chars() {
            let at = point(left as f32, (below * em) as f32);
            let glyph = FONT.glyph_id(c).with_scale_and_position(scale(em), at);
            if let Some(outline) = FONT.outline_glyph(glyph) {
                let corner = outline.px_bounds().min;
                let mut covered = Vec::new();
                outline.draw(|x, y, alpha| covered.push((x as i32, y as i32, alpha)));
                for (dx, dy, alpha) in covered {
                    let (dx, dy) = (corner.x as i32 + dx, corner.y as i32 + dy);
                    let (dx, dy) = style.transform().transform(dx, dy);
                    let alpha = colour.alpha * f64::from(alpha).clamp(0.0, 1.0);
                    self.draw_pixel((x + dx, y + dy), BackendColor { alpha, ..colour })?;
                }
            }
            left += advance(c, em);
        }
        Ok(())
    }
}

/// The font of all charts, reduced to the characters that they use; see the README beside it.
const FONT_FILE: &[u8] = include_bytes!("../../data/chart-font.ttf");

static FONT: LazyLock<FontRef<'static>> =
    LazyLock::new(|| FontRef::try_from_slice(FONT_FILE).expect("the font file is valid"));

/// What an SVG requests: the font itself, then those of the same widths.
const FAMILY: &str = "DejaVu Sans, Verdana, sans-serif";

/// `plotters` writes a font size into an SVG divided by this.
const PLOTTERS_EM: f64 = 1.24;

/// How far the middle of small letters lies above the base line, in em.
const HALF_X_HEIGHT: f64 = 0.2735;

fn units_per_em() -> f64 {
    FONT.units_per_em().map_or(2048.0, f64::from)
}

fn scale(em: f64) -> PxScale {
    PxScale::from((em * f64::from(FONT.height_unscaled()) / units_per_em()) as f32)
}

fn advance(c: char, em: f64) -> f64 {
    f64::from(FONT.h_advance_unscaled(FONT.glyph_id(c))) * em / units_per_em()
}

/// How wide `text` is, in drawn pixels, at `em` drawn pixels an em.
pub(super) fn width(text: &str, em: f64) -> f64 {
    text.chars().map(|c| advance(c, em)).sum()
}

/// `text` shortened to `room` drawn pixels at `em`, its end replaced by `…`.
///
/// Control characters become blanks; characters that XML forbids become U+FFFD.
pub(super) fn fitted(text: &str, em: f64, room: f64) -> String {
    let dots = width("…", em);
    let mut kept = String::new();
    // As much of it as leaves room for the dots.
    let mut short = 0;
    for c in text.chars() {
        kept.push(match c {
            c if c.is_control() => ' ',
            '\u{FFFE}' | '\u{FFFF}' => '\u{FFFD}',
            c => c,
        });
        let width = width(&kept, em);
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

/// Draws `text`, unless it is blank, with the point `at` of it that `anchor` names.
pub(super) fn text<D: DrawingBackend>(
    area: &Area<D>,
    text: &str,
    (em, colour): (f64, RGBColor),
    at: BackendCoord,
    anchor: (HPos, VPos),
    upwards: bool,
) -> Drawn<D> {
    if text.trim().is_empty() {
        return Ok(());
    }
    let family = FontFamily::Name(FAMILY);
    let font = FontDesc::new(family, em * PLOTTERS_EM, FontStyle::Normal);
    let font = if upwards {
        font.transform(FontTransform::Rotate270)
    } else {
        font
    };
    let style = TextStyle::from(font).color(&colour);
    area.draw(&Text::new(
        text,
        at,
        style.pos(Pos::new(anchor.0, anchor.1)),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn font_has_every_character_of_charts() {
        let missing = FONT.glyph_id('\u{4E00}');
        for c in ('!'..='~').chain("°±²³µ·×äöüßÄÖÜσμΔαβ–—…−≈≤≥→∞".chars())
        {
            assert_ne!(FONT.glyph_id(c), missing, "{c}");
        }
    }

    #[test]
    fn text_width_grows_with_size_and_length() {
        assert!((width("mm", 40.0) - 2.0 * width("mm", 20.0)).abs() < 1e-9);
        assert!((width("mm", 20.0) - 2.0 * width("m", 20.0)).abs() < 1e-9);
        assert!(width("", 20.0) == 0.0);
    }

    #[test]
    fn text_without_room_ends_in_dots() {
        assert_eq!(fitted("short", 20.0, 500.0), "short");
        let long = fitted("a title that is longer than its room", 20.0, 150.0);
        assert!(long.starts_with("a title") && long.ends_with('…'), "{long}");
        assert!(width(&long, 20.0) <= 150.0, "{long}");
        assert_eq!(fitted("a\nb\u{1b}\u{FFFF}", 20.0, 500.0), "a b \u{FFFD}");
        assert_eq!(fitted("m", 20.0, 1.0), "…");
    }
}
