//! The picture, and what every chart has around its data: title, legend, axes, grid.
//!
//! Everything is drawn at [`FINE`] times the picture's size. The bitmap is then averaged down, so
//! that all edges are smooth; the SVG is scaled by its view box. Lengths here are in drawn pixels.

use crate::export::{ExportError, OutDir};
use core::ops::Range;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder, RgbImage, imageops};
use plotters::chart::ChartContext;
use plotters::coord::Shift;
use plotters::coord::cartesian::Cartesian2d;
use plotters::coord::types::RangedCoordf64;
use plotters::drawing::DrawingAreaErrorKind;
use plotters::element::{Circle, DashedPathElement, PathElement, Polygon, Rectangle, Text};
use plotters::prelude::{
    BitMapBackend, ChartBuilder, DrawingArea, DrawingBackend, IntoDrawingArea, SVGBackend,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{
    Color, FontDesc, FontFamily, FontStyle, FontTransform, RGBAColor, RGBColor, ShapeStyle,
    TextStyle, register_font,
};
use plotters_backend::{BackendColor, BackendCoord, BackendTextStyle, DrawingErrorKind};
use std::io;
use std::path::PathBuf;
use std::sync::Once;

/// How many drawn pixels make one pixel of the picture, along each side.
const FINE: u32 = 2;
const WIDTH: i32 = 1600 * FINE as i32;
const HEIGHT: i32 = 1000 * FINE as i32;
pub(super) const SIZE: (u32, u32) = (WIDTH as u32, HEIGHT as u32);

const MARGIN: i32 = 72;
/// Where the data begin on the left and end on the right.
const LEFT: i32 = 340;
const RIGHT: i32 = 3088;
/// Sizes of letters, in pixels an em.
const TITLE: i32 = 68;
const AXIS_TITLE: i32 = 52;
const LABEL: i32 = 48;
/// From a row of the legend, or of the shaded intervals, to the next.
const LEGEND_ROW: i32 = 76;
pub(super) const SPAN_ROW: i32 = 62;
const SIGN_WIDTH: i32 = 96;
/// More entries would leave little of the chart.
const MOST_LEGEND_ENTRIES: usize = 18;
/// Where the legend begins, below the title.
const LEGEND_TOP: i32 = MARGIN + TITLE * 13 / 10;
/// What is left of a number at the y axis.
const LONGEST_TICK: i32 = LEFT - MARGIN - AXIS_TITLE - 24;
/// What is left of a name on the x axis that runs upwards.
const LONGEST_NAME: i32 = 680;
/// About how many ticks each axis has.
const TICKS: [usize; 2] = [11, 7];

const PAPER: RGBColor = RGBColor(255, 255, 255);
/// Text.
pub(super) const INK: RGBColor = RGBColor(34, 34, 34);
/// Axes, and what is not data.
pub(super) const GREY: RGBColor = RGBColor(110, 110, 110);
/// Lines behind the data.
const GRID: RGBColor = RGBColor(226, 226, 226);

/// Okabe and Ito's, the strongest first and without their yellow, which is too pale on white.
const SERIES: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(0, 0, 0),
];

/// The colour of a series, counted from 0; after seven they repeat.
pub(super) const fn series(index: usize) -> RGBColor {
    SERIES[index % SERIES.len()]
}

/// A drawing in drawn pixels from the top left.
pub(super) type Area<D> = DrawingArea<D, Shift>;

/// What drawing on `D` comes to.
pub(super) type Drawn<D, T = ()> =
    Result<T, DrawingAreaErrorKind<<D as DrawingBackend>::ErrorType>>;

/// A place in the data, in the axes' units.
pub(super) type Place = (f64, f64);

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
        let pixels = pixels(chart)?;
        PngEncoder::new_with_quality(file, CompressionType::Default, FilterType::Adaptive)
            .write_image(
                &pixels,
                pixels.width(),
                pixels.height(),
                ExtendedColorType::Rgb8,
            )
            .map_err(io::Error::other)
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

/// The picture of `chart`.
pub(super) fn pixels(chart: &impl Draw) -> io::Result<RgbImage> {
    let mut drawn = RgbImage::new(SIZE.0, SIZE.1);
    let area = Bitmap(BitMapBackend::with_buffer(&mut drawn, SIZE)).into_drawing_area();
    chart.draw(&area).map_err(io::Error::other)?;
    area.present().map_err(io::Error::other)?;
    drop(area);
    Ok(imageops::thumbnail(&drawn, SIZE.0 / FINE, SIZE.1 / FINE))
}

/// The bitmap of `plotters`, with lines in single pieces and texts where an SVG viewer puts them.
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

    /// Draws each piece of a thick line apart, with round joints: `plotters` fills the outline of the
    /// whole line, which leaves holes where it meets itself.
    fn draw_path<S: plotters_backend::BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Done<'a> {
        let points: Vec<BackendCoord> = path.into_iter().collect();
        for piece in points.windows(2) {
            self.0.draw_path(piece.iter().copied(), style)?;
        }
        if style.stroke_width() > FINE && points.len() > 2 {
            for &joint in &points[1..points.len() - 1] {
                self.0
                    .draw_circle(joint, style.stroke_width() / 2, style, true)?;
            }
        }
        Ok(())
    }

    /// Draws `text` lower than `plotters` does, by the difference of its base line from an SVG's.
    fn draw_text<S: BackendTextStyle>(
        &mut self,
        text: &str,
        style: &S,
        (x, y): BackendCoord,
    ) -> Done<'a> {
        let (dx, dy) = style.transform().transform(0, (style.size() * 0.15) as i32);
        self.0.draw_text(text, style, (x + dx, y + dy))
    }
}

/// The font of all charts, reduced to the characters that they use; see the README beside it.
const FONT_FILE: &[u8] = include_bytes!("../../data/chart-font.ttf");

/// What an SVG requests: the font itself, then those of the same widths.
const FAMILY: &str = "DejaVu Sans, Verdana, sans-serif";

/// `plotters` writes a font size into an SVG divided by this.
const PLOTTERS_EM: f64 = 1.24;

/// The font at `em` drawn pixels an em.
fn font(em: i32) -> FontDesc<'static> {
    static REGISTERED: Once = Once::new();
    REGISTERED.call_once(|| {
        let registered = register_font(FAMILY, FontStyle::Normal, FONT_FILE);
        assert!(registered.is_ok(), "the font file is valid");
    });
    FontDesc::new(
        FontFamily::Name(FAMILY),
        f64::from(em) * PLOTTERS_EM,
        FontStyle::Normal,
    )
}

/// The style of a text of which the point that is named is placed.
fn style(em: i32, horizontal: HPos, vertical: VPos) -> TextStyle<'static> {
    font(em).color(&INK).pos(Pos::new(horizontal, vertical))
}

/// How wide `text` is, in drawn pixels, at `em` drawn pixels an em.
pub(super) fn width(text: &str, em: i32) -> i32 {
    font(em).box_size(text).map_or(0, |(width, _)| width as i32)
}

/// `text` shortened to `room` drawn pixels at `em`, its end replaced by `…`.
///
/// Control characters become blanks; characters that XML forbids become U+FFFD.
fn fitted(text: &str, em: i32, room: i32) -> String {
    let drawn = text.chars().map(|c| match c {
        c if c.is_control() => ' ',
        '\u{FFFE}' | '\u{FFFF}' => '\u{FFFD}',
        c => c,
    });
    // No room holds more characters.
    let mut kept: String = drawn.take(300).collect();
    if width(&kept, em) <= room {
        return kept;
    }
    while !kept.is_empty() && width(&kept, em) + width("…", em) > room {
        kept.pop();
    }
    kept.trim_end().to_owned() + "…"
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stroke {
    pub colour: RGBColor,
    pub width: u32,
    pub dashed: bool,
}

impl Stroke {
    /// A stroke without dashes.
    pub(super) const fn solid(colour: RGBColor, width: u32) -> Self {
        Self {
            colour,
            width,
            dashed: false,
        }
    }
}

/// What an axis shows, its unit, and how far it reaches.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    title: String,
    from: Option<f64>,
    to: Option<f64>,
    /// A value that the axis reaches in any case.
    including: Option<f64>,
}

/// The largest value that is drawn; its labels are still short.
pub(super) const LARGEST: f64 = 1e12;

impl Axis {
    /// Creates an axis of `quantity` in `unit`: "error", "mm" is written *error (mm)*.
    #[must_use]
    pub fn new(quantity: &str, unit: &str) -> Self {
        Self::counting(&format!("{quantity} ({unit})"))
    }

    /// Creates an axis of counts of `things`, or of numbers without unit.
    ///
    /// It does not always begin at 0; see [`Self::including`].
    #[must_use]
    pub fn counting(things: &str) -> Self {
        Self {
            title: things.to_owned(),
            from: None,
            to: None,
            including: None,
        }
    }

    /// Begins the axis at `value` whatever the data; smaller values are drawn at its beginning.
    #[must_use]
    pub fn from(self, value: f64) -> Self {
        Self {
            from: Some(value),
            ..self
        }
    }

    /// Ends the axis at `value` whatever the data; larger values are drawn at its end.
    #[must_use]
    pub fn to(self, value: f64) -> Self {
        Self {
            to: Some(value),
            ..self
        }
    }

    /// Extends the axis to `value`, such as 0, if the data do not reach it.
    #[must_use]
    pub fn including(self, value: f64) -> Self {
        Self {
            including: Some(value),
            ..self
        }
    }

    /// The text at the axis.
    pub(super) fn title(&self) -> &str {
        &self.title
    }

    /// The range that shows `values` within ±1e12: 5 % wider than they are at an end that is neither
    /// set nor 0; from 0 to 1 without any value.
    pub(super) fn range(&self, values: impl Iterator<Item = f64>) -> Range<f64> {
        let bounded = |value: f64| value.clamp(-LARGEST, LARGEST);
        let values = values
            .chain(self.including)
            .filter(|value| value.is_finite());
        let ends = values
            .map(bounded)
            .fold(None, |ends: Option<Place>, value| {
                let (low, high) = ends.unwrap_or((value, value));
                Some((low.min(value), high.max(value)))
            });
        let set = [self.from, self.to].map(|end| end.filter(|end| end.is_finite()).map(bounded));
        let (low, high) = ends.unwrap_or_else(|| {
            let low = set[0].or(set[1].map(|to| to - 1.0)).unwrap_or(0.0);
            (low, low + 1.0)
        });
        let [low, high] = [set[0].unwrap_or(low), set[1].unwrap_or(high)];
        let (low, high) = (low.min(high), low.max(high));
        let size = low.abs().max(high.abs());
        // Ticks closer than a millionth of their value would have long labels.
        if high - low <= (size * 1e-6).max(1e-6) {
            let margin = (size / 10.0).max(0.5);
            return low - margin..high + margin;
        }
        let margin = (high - low) * 0.05;
        let wider = |end: f64, set: Option<f64>, margin: f64| {
            if set.is_some() || end == 0.0 {
                end
            } else {
                end + margin
            }
        };
        wider(low, set[0], -margin)..wider(high, set[1], margin)
    }
}

/// A number at an axis that is `span` long; numbers that would be long have an exponent.
fn tick(value: f64, span: f64) -> String {
    // The difference of key points from the multiple of a power of ten.
    let value = if value.abs() < span * 1e-6 {
        0.0
    } else {
        value
    };
    let text = if value != 0.0 && (value.abs() >= 1e6 || span < 0.01) {
        let rounded = format!("{value:.7e}").parse().unwrap_or(value);
        format!("{rounded:e}")
    } else {
        let text = format!("{value:.4}");
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    };
    text.replace('-', "−")
}

/// How a legend shows what it names.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Sign {
    Line(Stroke),
    Area(RGBAColor),
    /// A dot with a radius.
    Dot(RGBColor, i32),
}

/// The texts around the data.
#[derive(Debug, Clone, Default)]
pub(super) struct Texts<'a> {
    pub title: &'a str,
    pub x: &'a str,
    pub y: &'a str,
    pub legend: Vec<(String, Sign)>,
    /// Names of the equal parts of the x axis, in place of numbers.
    pub groups: &'a [String],
    /// How many pixels are left free above the data.
    pub above: i32,
    /// The highest count on the y axis: ticks less than 1 apart would not be counts.
    pub highest_count: Option<f64>,
}

impl Texts<'_> {
    /// Whether the names of the groups run upwards, and the height of the widest.
    fn upright(&self) -> Option<i32> {
        let widest = self.groups.iter().map(|name| width(name, LABEL)).max()?;
        let room = (RIGHT - LEFT) / self.groups.len() as i32;
        (widest > room * 94 / 100).then(|| widest.min(LONGEST_NAME))
    }

    /// Where the data are drawn: the pixels of the upper left and the lower right corner.
    pub(super) fn corners(&self) -> [BackendCoord; 2] {
        let legend = placed(&self.legend);
        let rows = legend
            .last()
            .map_or(0, |entry| entry.1.1 - LEGEND_TOP + LEGEND_ROW / 2);
        let below = self.upright().map_or(LABEL * 16 / 10, |height| height + 24);
        let title = if self.x.is_empty() {
            0
        } else {
            AXIS_TITLE * 15 / 10
        };
        let top = LEGEND_TOP + rows + 32 + self.above;
        [(LEFT, top), (RIGHT, HEIGHT - MARGIN - below - title)]
    }
}

/// A name in the legend, the middle of its sign's left side, and the sign.
type Entry = (String, BackendCoord, Option<Sign>);

/// Arranges signs and names in rows.
fn placed(entries: &[(String, Sign)]) -> Vec<Entry> {
    let more = entries.len().saturating_sub(MOST_LEGEND_ENTRIES);
    let shown = entries[..entries.len() - more].iter();
    let shown = shown.map(|(name, sign)| (fitted(name, LABEL, 960), Some(*sign)));
    let more = (more > 0).then(|| (format!("and {more} more"), None));
    let (mut left, mut middle) = (LEFT, LEGEND_TOP + LEGEND_ROW / 2);
    let place = |(name, sign): (String, Option<Sign>)| {
        let needed = SIGN_WIDTH + 24 + width(&name, LABEL);
        if left > LEFT && left + needed > RIGHT {
            (left, middle) = (LEFT, middle + LEGEND_ROW);
        }
        let at = (left, middle);
        left += needed + 72;
        (name, at, sign)
    };
    shown.chain(more).map(place).collect()
}

/// A chart with all but the data.
pub(super) struct Frame<'a, D: DrawingBackend> {
    area: &'a Area<D>,
    chart: ChartContext<'a, D, Cartesian2d<RangedCoordf64, RangedCoordf64>>,
}

impl<'a, D: DrawingBackend> Frame<'a, D> {
    /// Draws the texts around the data, the axes and the grid.
    pub(super) fn new(
        area: &'a Area<D>,
        texts: &Texts<'_>,
        [x, y]: [Range<f64>; 2],
    ) -> Drawn<D, Self> {
        let [(_, top), (_, bottom)] = texts.corners();
        let [wide, high] = [x.end - x.start, y.end - y.start];
        area.fill(&PAPER)?;
        let mut chart = ChartBuilder::on(area)
            .margin_left(MARGIN)
            .margin_right(WIDTH - RIGHT)
            .margin_top(top)
            .margin_bottom(MARGIN)
            .x_label_area_size(HEIGHT - MARGIN - bottom)
            .y_label_area_size(LEFT - MARGIN)
            .build_cartesian_2d(x, y)?;
        let along = fitted(texts.x, AXIS_TITLE, RIGHT - LEFT);
        let upwards = fitted(texts.y, AXIS_TITLE, bottom - top);
        let named = !texts.groups.is_empty();
        let most = texts
            .highest_count
            .map_or(usize::MAX, |highest| highest as usize + 1);
        let x_label = |value: &f64| tick(*value, wide);
        let y_label = |value: &f64| fitted(&tick(*value, high), LABEL, LONGEST_TICK);
        let mut mesh = chart.configure_mesh();
        mesh.axis_style(GREY.stroke_width(4))
            .bold_line_style(GRID.stroke_width(3))
            .light_line_style(PAPER.mix(0.0))
            .label_style(font(LABEL).color(&INK))
            .axis_desc_style(font(AXIS_TITLE).color(&INK))
            .set_all_tick_mark_size(12)
            .x_labels(if named { 0 } else { TICKS[0] })
            .y_labels(TICKS[1].min(most))
            .x_label_formatter(&x_label)
            .y_label_formatter(&y_label);
        if !along.trim().is_empty() {
            mesh.x_desc(along);
        }
        if !upwards.trim().is_empty() {
            mesh.y_desc(upwards);
        }
        mesh.draw()?;
        let frame = Self { area, chart };
        let title = fitted(texts.title, TITLE, RIGHT - LEFT);
        frame.text(&title, (LEFT, MARGIN), style(TITLE, HPos::Left, VPos::Top))?;
        frame.legend(&texts.legend)?;
        frame.groups(texts, bottom)?;
        Ok(frame)
    }

    /// The pixel that shows a place of the data; places beyond the axes are at their ends.
    pub(super) fn at(&self, (x, y): Place) -> BackendCoord {
        let within = |value: f64, axis: Range<f64>| value.clamp(axis.start, axis.end);
        let place = (
            within(x, self.chart.x_range()),
            within(y, self.chart.y_range()),
        );
        self.chart.backend_coord(&place)
    }

    /// The pixels that show places of the data.
    pub(super) fn all(&self, places: &[Place]) -> Vec<BackendCoord> {
        places.iter().map(|&place| self.at(place)).collect()
    }

    /// Writes that there is nothing to show.
    pub(super) fn no_data(&self) -> Drawn<D> {
        let (x, y) = self.chart.plotting_area().get_pixel_range();
        let middle = (i32::midpoint(x.start, x.end), i32::midpoint(y.start, y.end));
        self.text("no data", middle, style(TITLE, HPos::Center, VPos::Center))
    }

    /// Writes `content`, unless it is blank, at the place that the style's anchor names.
    fn text(&self, content: &str, at: BackendCoord, style: TextStyle<'_>) -> Drawn<D> {
        if content.trim().is_empty() {
            return Ok(());
        }
        self.area.draw(&Text::new(content, at, style))
    }

    /// Writes a label from `at` to the right, in its middle's height, shortened to `room`.
    pub(super) fn label(&self, content: &str, at: BackendCoord, room: i32) -> Drawn<D> {
        let style = style(LABEL, HPos::Left, VPos::Center);
        self.text(&fitted(content, LABEL, room), at, style)
    }

    /// Draws a line through pixels; a single one is a dot.
    pub(super) fn line(&self, pixels: Vec<BackendCoord>, stroke: Stroke) -> Drawn<D> {
        let style: ShapeStyle = stroke.colour.stroke_width(stroke.width);
        match pixels[..] {
            [] => Ok(()),
            [alone] => self.dot(alone, 14, stroke.colour),
            _ if stroke.dashed => self
                .area
                .draw(&DashedPathElement::new(pixels, 28, 18, style)),
            _ => self.area.draw(&PathElement::new(pixels, style)),
        }
    }

    /// Draws a filled circle.
    pub(super) fn dot(&self, at: BackendCoord, radius: i32, colour: RGBColor) -> Drawn<D> {
        self.area.draw(&Circle::new(at, radius, colour.filled()))
    }

    /// Fills the area within pixels.
    pub(super) fn fill(&self, pixels: Vec<BackendCoord>, colour: RGBAColor) -> Drawn<D> {
        if pixels.len() < 3 {
            return Ok(());
        }
        self.area.draw(&Polygon::new(pixels, colour))
    }

    /// Fills the rectangle between two opposite corners.
    pub(super) fn rectangle(&self, corners: [BackendCoord; 2], colour: RGBAColor) -> Drawn<D> {
        self.area.draw(&Rectangle::new(corners, colour.filled()))
    }

    fn legend(&self, entries: &[(String, Sign)]) -> Drawn<D> {
        for (name, (left, middle), sign) in placed(entries) {
            let right = left + SIGN_WIDTH;
            match sign {
                None => {}
                Some(Sign::Line(stroke)) => {
                    self.line(vec![(left, middle), (right, middle)], stroke)?;
                }
                Some(Sign::Dot(colour, radius)) => {
                    self.dot((i32::midpoint(left, right), middle), radius, colour)?;
                }
                Some(Sign::Area(colour)) => {
                    self.rectangle([(left, middle - 22), (right, middle + 22)], colour)?;
                }
            }
            self.label(&name, (right + 24, middle), i32::MAX)?;
        }
        Ok(())
    }

    /// Writes the names below the groups, as many as there is room for.
    fn groups(&self, texts: &Texts<'_>, bottom: i32) -> Drawn<D> {
        let (room, style) = match texts.upright() {
            Some(height) => (
                height,
                style(LABEL, HPos::Right, VPos::Center).transform(FontTransform::Rotate270),
            ),
            None => (RIGHT, style(LABEL, HPos::Center, VPos::Top)),
        };
        let step = (LABEL as usize * texts.groups.len()).div_ceil((RIGHT - LEFT) as usize);
        for (number, name) in texts.groups.iter().enumerate().step_by(step.max(1)) {
            let at = (self.at((number as f64 + 0.5, 0.0)).0, bottom + 24);
            self.text(&fitted(name, LABEL, room), at, style.clone())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn font_has_every_character_of_charts() {
        let shape = |c: char| {
            let mut pixels = Vec::new();
            let draw = |x, y, alpha: f32| {
                pixels.push((x, y, alpha.to_bits()));
                Ok::<(), ()>(())
            };
            font(LABEL)
                .draw(&c.to_string(), (0, 0), draw)
                .unwrap()
                .unwrap();
            pixels
        };
        let missing = shape('\u{4E00}');
        for c in ('!'..='~').chain("°±²³µ·×äöüßÄÖÜσμΔαβ–—…−≈≤≥→∞".chars())
        {
            assert_ne!(shape(c), missing, "{c}");
        }
    }

    #[test]
    fn text_without_room_ends_in_dots() {
        assert_eq!(fitted("short", 40, 500), "short");
        let long = fitted("a title that is longer than its room", 40, 300);
        assert!(long.starts_with("a title") && long.ends_with('…'), "{long}");
        assert!(width(&long, 40) <= 300, "{long}");
        assert_eq!(fitted("a\nb\u{1b}\u{FFFF}", 40, 500), "a b \u{FFFD}");
        assert_eq!(fitted("m", 40, 1), "…");
    }

    #[test]
    fn ticks_have_as_few_digits_as_they_need() {
        for (value, span, text) in [
            (0.0, 1.0, "0"),
            (-1e-17, 1.0, "0"),
            (0.1 + 0.2, 1.0, "0.3"),
            (-20.0, 50.0, "−20"),
            (250_000.0, 1e6, "250000"),
            (1_200_000_000.000_000_2, 1e9, "1.2e9"),
            (2e-7, 1e-6, "2e−7"),
        ] {
            assert_eq!(tick(value, span), text);
        }
    }

    #[test]
    fn axis_is_wider_than_its_values() {
        let axis = Axis::new("share", "%");
        let range = |axis: &Axis, values: &[f64]| axis.range(values.iter().copied());
        assert_eq!(axis.title(), "share (%)");
        assert_eq!(range(&axis, &[10.0, 30.0]), 9.0..31.0);
        assert_eq!(range(&axis.clone().including(0.0), &[40.0]), 0.0..42.0);
        assert_eq!(
            range(&axis.clone().from(0.0).to(90.0), &[40.0, 400.0]),
            0.0..90.0
        );
        assert_eq!(range(&axis, &[5.0]), 4.5..5.5);
        assert_eq!(range(&axis, &[f64::NAN]), 0.0..1.05);
    }

    proptest! {
        #[test]
        fn any_values_have_an_axis(
            values in prop::collection::vec(any::<f64>(), 0..4),
            from in prop::option::of(any::<f64>()),
            to in prop::option::of(any::<f64>()),
        ) {
            let axis = Axis { from, to, ..Axis::counting("x") };
            let range = axis.range(values.iter().copied());
            let size = range.start.abs().max(range.end.abs());
            prop_assert!(range.end - range.start > size * 1e-7, "{range:?}");
            if from.is_none() && to.is_none() {
                let finite = values.into_iter().filter(|value| value.is_finite());
                let mut shown = finite.map(|value| value.clamp(-LARGEST, LARGEST));
                prop_assert!(shown.all(|value| range.contains(&value) || range.end == value));
            }
        }
    }
}
