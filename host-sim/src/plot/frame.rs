//! What every chart has around its data: title, legend, axes, grid.

use super::axis::Scale;
use super::canvas::{Area, Drawn, FINE, HEIGHT, WIDTH, fitted, text, width};
use plotters::chart::ChartContext;
use plotters::coord::cartesian::Cartesian2d;
use plotters::element::{Circle, DashedPathElement, PathElement, Polygon, Rectangle};
use plotters::prelude::{ChartBuilder, DrawingBackend};
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{Color, RGBColor, ShapeStyle};

/// Behind everything.
pub(super) const PAPER: RGBColor = RGBColor(255, 255, 255);
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

/// About how many ticks the x axis has.
pub(super) const X_TICKS: u32 = 10;
/// About how many ticks the y axis has.
pub(super) const Y_TICKS: u32 = 7;

// All in pixels of the picture.
const MARGIN: f64 = 36.0;
const TITLE: f64 = 34.0;
const AXIS_TITLE: f64 = 26.0;
/// Size of a label, in pixels an em.
pub(super) const LABEL: f64 = 24.0;
const LEGEND_ROW: f64 = 38.0;
/// More rows would leave little of the chart.
const MOST_LEGEND_ROWS: usize = 6;
const SIGN_WIDTH: f64 = 48.0;
/// What is left of a label of the y axis, and of an upright one of the x axis.
const LONGEST_LABEL: f64 = 280.0;

/// A place in the data, in the axes' units.
pub(super) type Place = (f64, f64);

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stroke {
    pub colour: RGBColor,
    /// In pixels.
    pub width: f64,
    pub dashed: bool,
}

impl Stroke {
    /// A stroke without dashes.
    pub(super) const fn solid(colour: RGBColor, width: f64) -> Self {
        Self {
            colour,
            width,
            dashed: false,
        }
    }

    fn style(self) -> ShapeStyle {
        self.colour.stroke_width(drawn(self.width).unsigned_abs())
    }
}

/// How a legend shows what it names.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Sign {
    Line(Stroke),
    Area(RGBColor),
    /// A dot with a radius in pixels.
    Dot(RGBColor, f64),
}

/// The texts around the data.
#[derive(Debug, Clone, Copy)]
pub(super) struct Texts<'a> {
    pub title: &'a str,
    pub x: &'a str,
    pub y: &'a str,
    pub legend: &'a [(String, Sign)],
    /// How many pixels are left free above the data.
    pub above: f64,
}

/// Where the data begin on the left, in pixels.
pub(super) const LEFT: f64 = 160.0;
/// Where the data end on the right, in pixels.
pub(super) const RIGHT: f64 = 1544.0;

/// Where the data are drawn from top to bottom, in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Layout {
    pub top: f64,
    pub bottom: f64,
    /// Whether the labels of the x axis run upwards.
    upright: bool,
}

impl Layout {
    /// The layout that leaves room for all texts, and for the labels of the x axis.
    pub(super) fn new(texts: Texts<'_>, x: &Scale) -> Self {
        let labels = x.ticks.iter().map(|tick| width(&tick.text, LABEL));
        let widest = labels.fold(0.0, f64::max).min(LONGEST_LABEL);
        // Names that are too wide for their part of the axis run upwards.
        let room = (RIGHT - LEFT) / x.ticks.len().max(1) as f64;
        let upright = x.is_of_names() && widest > room * 0.94;
        let below = if upright { widest + 12.0 } else { LABEL * 1.6 };
        let title = if texts.x.is_empty() {
            0.0
        } else {
            AXIS_TITLE * 1.5
        };
        let rows = legend(texts.legend)
            .last()
            .map_or(0.0, |entry| entry.row + 1.0);
        Self {
            top: LEGEND_TOP + rows * LEGEND_ROW + 16.0 + texts.above,
            bottom: f64::from(HEIGHT / FINE as i32) - MARGIN - below - title,
            upright,
        }
    }
}

/// Where the legend begins, below the title.
const LEGEND_TOP: f64 = MARGIN + TITLE * 1.3;

/// A name in the legend, its place, and its sign.
struct Entry {
    name: String,
    sign: Option<Sign>,
    left: f64,
    row: f64,
}

/// Arranges signs and names in rows.
fn legend(entries: &[(String, Sign)]) -> Vec<Entry> {
    let (mut at, mut row) = (LEFT, 0);
    let mut placed = Vec::new();
    for (number, (name, sign)) in entries.iter().enumerate() {
        let name = fitted(name, LABEL, 480.0);
        let needed = SIGN_WIDTH + 12.0 + width(&name, LABEL);
        if at > LEFT && at + needed > RIGHT {
            (at, row) = (LEFT, row + 1);
        }
        let full = row + 1 == MOST_LEGEND_ROWS && number + 1 < entries.len();
        placed.push(Entry {
            name: if full {
                format!("and {} more", entries.len() - number)
            } else {
                name
            },
            sign: (!full).then_some(*sign),
            left: at,
            row: row as f64,
        });
        if full {
            break;
        }
        at += needed + 36.0;
    }
    placed
}

/// Pixels as drawn pixels.
pub(super) fn drawn(pixels: f64) -> i32 {
    (pixels * f64::from(FINE)).round() as i32
}

/// A chart with all but the data.
pub(super) struct Frame<'a, D: DrawingBackend> {
    area: &'a Area<D>,
    chart: ChartContext<'a, D, Cartesian2d<Scale, Scale>>,
    pub layout: Layout,
}

impl<'a, D: DrawingBackend> Frame<'a, D> {
    /// Draws the texts around the data, and the grid.
    pub(super) fn new(area: &'a Area<D>, texts: Texts<'_>, x: &Scale, y: &Scale) -> Drawn<D, Self> {
        let layout = Layout::new(texts, x);
        area.fill(&PAPER)?;
        let mut builder = ChartBuilder::on(area);
        builder.margin_left(drawn(LEFT));
        builder.margin_right(WIDTH - drawn(RIGHT));
        builder.margin_top(drawn(layout.top));
        builder.margin_bottom(HEIGHT - drawn(layout.bottom));
        let mut frame = Self {
            area,
            chart: builder.build_cartesian_2d(x.clone(), y.clone())?,
            layout,
        };
        let title = fitted(texts.title, TITLE, RIGHT - LEFT);
        let base = (LEFT, MARGIN + TITLE * 0.8);
        frame.text(&title, TITLE, INK, base, HPos::Left)?;
        frame.legend(texts.legend)?;
        frame.grid(x, y)?;
        frame.axis_titles(texts)?;
        Ok(frame)
    }

    /// Draws the two axes over the data.
    pub(super) fn finish(mut self) -> Drawn<D> {
        let axes = [(0.0, 1.0), (0.0, 0.0), (1.0, 0.0)];
        let axes = axes.map(|(x, y)| self.corner(x, y)).to_vec();
        self.pixel_line(axes, Stroke::solid(GREY, 2.0))
    }

    /// The pixel at these parts of the two axes.
    pub(super) fn corner(&self, x: f64, y: f64) -> Place {
        let Layout { top, bottom, .. } = self.layout;
        (LEFT + (RIGHT - LEFT) * x, bottom - (bottom - top) * y)
    }

    /// The pixel that shows a place of the data.
    pub(super) fn pixel(&self, place: Place) -> Place {
        let (x, y) = self.chart.backend_coord(&place);
        (
            f64::from(x) / f64::from(FINE),
            f64::from(y) / f64::from(FINE),
        )
    }

    /// Draws a line through places; a single one is a dot.
    pub(super) fn line(&mut self, places: Vec<Place>, stroke: Stroke) -> Drawn<D> {
        let style = stroke.style();
        match places[..] {
            [] => Ok(()),
            [alone] => self.dot(alone, 7.0, stroke.colour),
            _ if stroke.dashed => {
                let (dash, gap) = (drawn(14.0), drawn(9.0));
                let line = DashedPathElement::new(places, dash, gap, style);
                self.chart.draw_series([line]).map(drop)
            }
            _ => self
                .chart
                .draw_series([PathElement::new(places, style)])
                .map(drop),
        }
    }

    /// Fills the area within places; opaque at 1.
    pub(super) fn area(&mut self, places: Vec<Place>, colour: RGBColor, opacity: f64) -> Drawn<D> {
        if places.len() < 3 {
            return Ok(());
        }
        let area = Polygon::new(places, colour.mix(opacity));
        self.chart.draw_series([area]).map(drop)
    }

    /// Fills the rectangle between two opposite corners; opaque at 1.
    pub(super) fn rectangle(
        &mut self,
        corners: [Place; 2],
        colour: RGBColor,
        opacity: f64,
    ) -> Drawn<D> {
        let style = colour.mix(opacity).filled();
        self.chart
            .draw_series([Rectangle::new(corners, style)])
            .map(drop)
    }

    /// Draws a filled circle with a radius in pixels.
    pub(super) fn dot(&mut self, place: Place, radius: f64, colour: RGBColor) -> Drawn<D> {
        let dot = Circle::new(place, drawn(radius), colour.filled());
        self.chart.draw_series([dot]).map(drop)
    }

    /// Fills the rectangle between two opposite corners, in pixels of the picture.
    pub(super) fn pixel_rectangle(
        &self,
        [a, b]: [Place; 2],
        colour: RGBColor,
        opacity: f64,
    ) -> Drawn<D> {
        let corners = [a, b].map(|(x, y)| (drawn(x), drawn(y)));
        self.area
            .draw(&Rectangle::new(corners, colour.mix(opacity).filled()))
    }

    /// Writes a label at a pixel, shortened to `room` pixels.
    pub(super) fn label(&self, label: &str, at: Place, room: f64) -> Drawn<D> {
        self.text(&fitted(label, LABEL, room), LABEL, INK, at, HPos::Left)
    }

    /// Writes that there is nothing to show.
    pub(super) fn no_data(&self) -> Drawn<D> {
        self.text("no data", TITLE, GREY, self.corner(0.5, 0.5), HPos::Center)
    }

    fn pixel_line(&mut self, pixels: Vec<Place>, stroke: Stroke) -> Drawn<D> {
        let pixels: Vec<_> = pixels
            .into_iter()
            .map(|(x, y)| (drawn(x), drawn(y)))
            .collect();
        let style = stroke.style();
        if stroke.dashed {
            self.area.draw(&DashedPathElement::new(
                pixels,
                drawn(14.0),
                drawn(9.0),
                style,
            ))
        } else {
            self.area.draw(&PathElement::new(pixels, style))
        }
    }

    /// Writes a text on its base line.
    fn text(
        &self,
        content: &str,
        em: f64,
        colour: RGBColor,
        (x, base): Place,
        anchor: HPos,
    ) -> Drawn<D> {
        // The anchor at the top lies 0.76 em above the base line.
        let at = (drawn(x), drawn(base - em * 0.76));
        let font = (em * f64::from(FINE), colour);
        text(self.area, content, font, at, (anchor, VPos::Top), false)
    }

    fn legend(&mut self, entries: &[(String, Sign)]) -> Drawn<D> {
        for entry in legend(entries) {
            let (left, middle) = (entry.left, LEGEND_TOP + LEGEND_ROW * (entry.row + 0.5));
            let (right, base) = (left + SIGN_WIDTH, middle + LABEL * 0.2735);
            match entry.sign {
                None => {
                    self.label(&entry.name, (left, base), f64::MAX)?;
                    continue;
                }
                Some(Sign::Line(stroke)) => {
                    self.pixel_line(vec![(left, middle), (right, middle)], stroke)?;
                }
                Some(Sign::Dot(colour, radius)) => {
                    let at = (drawn(f64::midpoint(left, right)), drawn(middle));
                    self.area
                        .draw(&Circle::new(at, drawn(radius), colour.filled()))?;
                }
                Some(Sign::Area(colour)) => {
                    let corners = [(left, middle - 11.0), (right, middle + 11.0)];
                    self.pixel_rectangle(corners, colour, 1.0)?;
                }
            }
            self.label(&entry.name, (right + 12.0, base), f64::MAX)?;
        }
        Ok(())
    }

    fn grid(&mut self, x: &Scale, y: &Scale) -> Drawn<D> {
        let stroke = Stroke::solid(GRID, 1.5);
        for tick in &y.ticks {
            let (left, height) = self.corner(0.0, y.part(tick.value));
            self.pixel_line(vec![(left, height), (RIGHT, height)], stroke)?;
            let base = (left - 12.0, height + LABEL * 0.36);
            let label = fitted(&tick.text, LABEL, LEFT - MARGIN - AXIS_TITLE * 1.2 - 12.0);
            self.text(&label, LABEL, INK, base, HPos::Right)?;
        }
        let bottom = self.layout.bottom;
        let mut taken = f64::NEG_INFINITY;
        for tick in &x.ticks {
            let (at, _) = self.corner(x.part(tick.value), 0.0);
            if !x.is_of_names() {
                self.pixel_line(vec![(at, bottom), (at, self.layout.top)], stroke)?;
            }
            let upright = self.layout.upright;
            let room = if upright { LONGEST_LABEL } else { f64::MAX };
            let label = fitted(&tick.text, LABEL, room);
            // How much of the axis the label covers; a label without room is left out.
            let half = if upright {
                LABEL * 0.5
            } else {
                width(&label, LABEL) / 2.0
            };
            // The last label of numbers with many digits ends at the picture's edge.
            let at = at.min(f64::from(WIDTH / FINE as i32) - half - 4.0);
            if at - half < taken {
                continue;
            }
            taken = at + half + 4.0;
            if upright {
                let font = (LABEL * f64::from(FINE), INK);
                let at = (drawn(at), drawn(bottom + 12.0));
                text(
                    self.area,
                    &label,
                    font,
                    at,
                    (HPos::Right, VPos::Center),
                    true,
                )?;
            } else {
                let base = (at, bottom + LABEL * 1.4);
                self.text(&label, LABEL, INK, base, HPos::Center)?;
            }
        }
        Ok(())
    }

    fn axis_titles(&self, texts: Texts<'_>) -> Drawn<D> {
        let Layout { top, bottom, .. } = self.layout;
        let along = fitted(texts.x, AXIS_TITLE, RIGHT - LEFT);
        let height = f64::from(HEIGHT / FINE as i32);
        let base = (
            f64::midpoint(LEFT, RIGHT),
            height - MARGIN + AXIS_TITLE * 0.2,
        );
        self.text(&along, AXIS_TITLE, INK, base, HPos::Center)?;
        let up = fitted(texts.y, AXIS_TITLE, bottom - top);
        let at = (drawn(MARGIN), drawn(f64::midpoint(top, bottom)));
        let font = (AXIS_TITLE * f64::from(FINE), INK);
        text(self.area, &up, font, at, (HPos::Center, VPos::Top), true)
    }
}
