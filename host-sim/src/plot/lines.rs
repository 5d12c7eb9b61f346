//! Line charts: lines over an axis of numbers, bands around them, shaded intervals.

use super::axis::{Axis, Scale};
use super::canvas::{Area, Draw, Drawn, width, write};
use super::frame::{
    Frame, LABEL, LEFT, Place, RIGHT, Sign, Stroke, Texts, X_TICKS, Y_TICKS, series,
};
use crate::export::{ExportError, OutDir};
use plotters::prelude::DrawingBackend;
use plotters::style::RGBColor;
use std::path::PathBuf;

/// Lines over an axis of numbers.
///
/// A legend names the lines if there are several. A point that is not finite interrupts its line.
///
/// # Examples
/// ```
/// use certainty_sim::export::OutDir;
/// use certainty_sim::plot::{Axis, Line, LineChart, Span};
///
/// let chart = LineChart {
///     title: "Error of the map".into(),
///     x: Axis::new("time", "s"),
///     y: Axis::counting("mean absolute error").from(0.0),
///     lines: vec![
///         Line::new("bayes", vec![(0.0, 0.5), (10.0, 0.12), (20.0, 0.3)]),
///         Line::new("robust", vec![(0.0, 0.5), (10.0, 0.1), (20.0, 0.08)]),
///     ],
///     shaded: vec![Span { from: 10.0, to: 20.0, label: "fault of sensor 1".into() }],
/// };
/// let folder = tempfile::tempdir().unwrap();
/// let [png, svg] = chart.write(&OutDir::create(folder.path())?, "error")?;
/// assert!(png.ends_with("error.png") && svg.ends_with("error.svg"));
/// # Ok::<(), certainty_sim::export::ExportError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct LineChart {
    /// What the chart shows.
    pub title: String,
    /// The axis to the right.
    pub x: Axis,
    /// The axis upwards.
    pub y: Axis,
    /// The lines, the first lowest.
    pub lines: Vec<Line>,
    /// The intervals of x that are shaded.
    pub shaded: Vec<Span>,
}

/// One line.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Its name in the legend.
    pub name: String,
    /// x and y of its points, in the axes' units.
    pub points: Vec<(f64, f64)>,
    /// Low and high for each point, such as mean − σ and mean + σ: drawn translucent.
    ///
    /// Pairs without a point are not drawn.
    pub band: Option<Vec<(f64, f64)>>,
    /// Whether it is dashed, as expected rather than measured values are.
    pub dashed: bool,
}

impl Line {
    /// Creates a line without a band that is not dashed.
    #[must_use]
    pub fn new(name: &str, points: Vec<(f64, f64)>) -> Self {
        Self {
            name: name.to_owned(),
            points,
            band: None,
            dashed: false,
        }
    }

    /// Adds a band: low and high for each point.
    #[must_use]
    pub fn with_band(self, band: Vec<(f64, f64)>) -> Self {
        Self {
            band: Some(band),
            ..self
        }
    }

    /// Dashes the line.
    #[must_use]
    pub fn dashed(self) -> Self {
        Self {
            dashed: true,
            ..self
        }
    }

    /// The points that have a band: x, low, high.
    fn band(&self) -> impl Iterator<Item = (f64, f64, f64)> + '_ {
        let band = self.band.iter().flatten();
        let points = self.points.iter().zip(band);
        points.map(|(&(x, _), &(low, high))| (x, low, high))
    }

    pub(super) fn stroke(&self, index: usize) -> Stroke {
        Stroke {
            colour: series(index),
            width: 4.0,
            dashed: self.dashed,
        }
    }
}

/// A shaded interval of x, such as that of a fault.
#[derive(Debug, Clone, PartialEq)]
pub struct Span {
    /// Where it begins.
    pub from: f64,
    /// Where it ends.
    pub to: f64,
    /// The text in it.
    pub label: String,
}

impl Span {
    const fn low(&self) -> f64 {
        self.from.min(self.to)
    }

    const fn high(&self) -> f64 {
        self.from.max(self.to)
    }
}

impl LineChart {
    /// Writes the chart as `STEM.png` and `STEM.svg`.
    ///
    /// # Errors
    /// If `stem` is not a plain file name or a file cannot be put in place.
    pub fn write(&self, out: &OutDir, stem: &str) -> Result<[PathBuf; 2], ExportError> {
        write(self, out, stem)
    }
}

impl Draw for LineChart {
    fn draw<D: DrawingBackend>(&self, area: &Area<D>) -> Drawn<D> {
        let points = self.lines.iter().flat_map(|line| &line.points);
        let points: Vec<Place> = points.copied().filter(finite).collect();
        let spans = self.shaded.iter().flat_map(|span| [span.from, span.to]);
        let bands = self.lines.iter().flat_map(Line::band);
        let bands = bands.flat_map(|(_, low, high)| [low, high]);
        let across = points.iter().map(|point| point.0).chain(spans);
        let up = points.iter().map(|point| point.1).chain(bands);
        let x = Scale::covering(&self.x, across, X_TICKS);
        let y = Scale::covering(&self.y, up, Y_TICKS);
        let signs = self.lines.iter().enumerate();
        let signs = signs.map(|(index, line)| (line.name.clone(), Sign::Line(line.stroke(index))));
        let legend: Vec<_> = signs.filter(|_| self.lines.len() > 1).collect();
        let texts = Texts {
            title: &self.title,
            x: self.x.title(),
            y: self.y.title(),
            legend: &legend,
            above: 0.0,
        };
        let shading = Shading::new(&self.shaded, &x);
        let above = shading.height();
        let mut frame = Frame::new(area, Texts { above, ..texts }, &x, &y)?;
        shading.draw(&mut frame, &x)?;
        for (index, line) in self.lines.iter().enumerate() {
            let points: Vec<_> = line.band().collect();
            let numbers = |&(x, low, high): &(f64, f64, f64)| (x + low + high).is_finite();
            for run in points.split(|point| !numbers(point)) {
                let above = run.iter().map(|&(x, _, high)| (x, high));
                let below = run.iter().rev().map(|&(x, low, _)| (x, low));
                frame.area(above.chain(below).collect(), series(index), 0.2)?;
            }
        }
        for (index, line) in self.lines.iter().enumerate() {
            for run in line.points.split(|point| !finite(point)) {
                frame.line(run.to_vec(), line.stroke(index))?;
            }
        }
        if points.is_empty() {
            frame.no_data()?;
        }
        frame.finish()
    }
}

/// Whether both coordinates of a place are numbers.
pub(super) fn finite(&(x, y): &Place) -> bool {
    x.is_finite() && y.is_finite()
}

/// The most rows of bars; more would leave little of the chart.
const MOST_ROWS: usize = 8;
/// From a row to the next, in pixels.
const ROW: f64 = 31.0;
/// The colour of shaded intervals.
const SHADE: RGBColor = RGBColor(120, 120, 120);

/// Where intervals and their labels go: a single one has its label in it, several have bars above the
/// data.
#[derive(Debug)]
struct Shading<'a> {
    /// By their beginnings.
    spans: Vec<&'a Span>,
    bars: Vec<Bar<'a>>,
    rows: usize,
    /// How many have no row.
    left_out: usize,
}

/// One interval's bar, in pixels from the left.
#[derive(Debug, Clone, Copy)]
struct Bar<'a> {
    label: &'a str,
    row: usize,
    left: f64,
    right: f64,
    /// Where its label begins, and how much room that has.
    text: f64,
    room: f64,
}

impl<'a> Shading<'a> {
    /// Arranges `spans` along the axis `x`: each in the first row with room for it and its label.
    fn new(spans: &'a [Span], x: &Scale) -> Self {
        let finite = |span: &&Span| (span.to - span.from).is_finite();
        let mut spans: Vec<&Span> = spans.iter().filter(finite).collect();
        spans.sort_by(|a, b| a.low().total_cmp(&b.low()));
        let across = |part: f64| LEFT + (RIGHT - LEFT) * part;
        // Up to where each row is taken.
        let mut rows: Vec<f64> = Vec::new();
        let mut bars = Vec::new();
        for span in &spans {
            let [left, right] = [span.low(), span.high()].map(|at| across(x.part(at)));
            let wanted = width(&span.label, LABEL) + 4.0;
            let text = (left + 8.0).min(RIGHT - wanted).max(LEFT + 8.0);
            let room = wanted.min(RIGHT - text);
            let free = rows.iter().position(|&taken| taken < text.min(left));
            let row = free.unwrap_or(rows.len());
            if row == MOST_ROWS {
                continue;
            }
            let taken = right.max(text + room) + 8.0;
            match rows.get_mut(row) {
                Some(row) => *row = taken,
                None => rows.push(taken),
            }
            bars.push(Bar {
                label: &span.label,
                row,
                left,
                right,
                text,
                room,
            });
        }
        Self {
            rows: rows.len(),
            left_out: spans.len() - bars.len(),
            spans,
            bars,
        }
    }

    /// How much room the bars need above the data, in pixels.
    fn height(&self) -> f64 {
        let rows = self.rows + usize::from(self.left_out > 0);
        if self.spans.len() > 1 {
            rows as f64 * ROW
        } else {
            0.0
        }
    }

    /// Draws the shades, which do not add up, and the labels.
    fn draw<D: DrawingBackend>(&self, frame: &mut Frame<'_, D>, x: &Scale) -> Drawn<D> {
        let several = self.spans.len() > 1;
        let (start, top) = frame.corner(0.0, 1.0);
        let (end, bottom) = frame.corner(1.0, 0.0);
        let across = |value: f64| start + (end - start) * x.part(value);
        let mut shaded = f64::NEG_INFINITY;
        for span in &self.spans {
            let from = span.low().max(shaded);
            shaded = shaded.max(span.high());
            if from < shaded || !several {
                let corners = [(across(from), top), (across(shaded), bottom)];
                frame.pixel_rectangle(corners, SHADE, 0.16)?;
            }
        }
        let top = top - self.height();
        for bar in &self.bars {
            let top = top + ROW * bar.row as f64;
            let base = if several {
                let right = bar.right.max(bar.left + 3.0);
                let corners = [(bar.left, top), (right, top + ROW - 4.0)];
                frame.pixel_rectangle(corners, SHADE, 0.35)?;
                top + LABEL * 0.9
            } else {
                top + 30.0
            };
            frame.label(bar.label, (bar.text, base), bar.room)?;
        }
        if self.left_out > 0 {
            let more = format!("and {} more", self.left_out);
            let base = top + ROW * self.rows as f64 + LABEL * 0.9;
            frame.label(&more, (start + 8.0, base), end - start)?;
        }
        Ok(())
    }
}
