//! What changes over something: lines, bands around them, intervals set off.

use super::axis::{Axis, Scale};
use super::frame::{Bottom, Frame, Sign, Words, X_TICKS, Y_TICKS};
use super::palette::series;
use super::picture::{Picture, Place, Stroke};
use super::shading::Shading;
use crate::export::{ExportError, OutDir};
use std::path::PathBuf;

/// Lines over an axis of numbers.
///
/// The legend names the lines where there is more than one. A point that is no number interrupts
/// its line.
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
    /// The intervals of x that are set off.
    pub shaded: Vec<Span>,
}

/// One line.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// What the legend calls it.
    pub name: String,
    /// x and y of its points, in the axes' units.
    pub points: Vec<(f64, f64)>,
    /// Low and high for each point, such as the mean less and plus σ: drawn translucent.
    ///
    /// What there is more of than points is not drawn.
    pub band: Option<Vec<(f64, f64)>>,
    /// Whether it is dashed: what is expected rather than measured.
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
            dashes: self.dashed.then_some([14.0, 9.0]),
        }
    }
}

/// An interval of x that is set off, such as that of a fault.
#[derive(Debug, Clone, PartialEq)]
pub struct Span {
    /// Where it begins.
    pub from: f64,
    /// Where it ends.
    pub to: f64,
    /// What is written into it.
    pub label: String,
}

impl Span {
    pub(super) const fn low(&self) -> f64 {
        self.from.min(self.to)
    }

    pub(super) const fn high(&self) -> f64 {
        self.from.max(self.to)
    }
}

impl LineChart {
    /// Writes the chart as `STEM.png` and `STEM.svg`.
    ///
    /// # Errors
    /// If `stem` is no plain file name or a file cannot be put in place.
    pub fn write(&self, out: &OutDir, stem: &str) -> Result<[PathBuf; 2], ExportError> {
        self.picture().write(out, stem)
    }

    pub(super) fn picture(&self) -> Picture {
        let shown = |line: &&Line| line.points.iter().any(finite);
        let any = self.lines.iter().any(|line| shown(&line));
        let points = || self.lines.iter().flat_map(|line| &line.points);
        let spans = self.shaded.iter().flat_map(|span| [span.from, span.to]);
        let across = points()
            .filter(|point| finite(point))
            .map(|point| point.0)
            .chain(spans);
        let bands = self.lines.iter().flat_map(Line::band);
        let bands = bands.flat_map(|(_, low, high)| [low, high]);
        let up = points()
            .filter(|point| finite(point))
            .map(|point| point.1)
            .chain(bands);
        let x = Scale::covering(&self.x, across, X_TICKS);
        let y = Scale::covering(&self.y, up, Y_TICKS);
        let signs = self.lines.iter().enumerate();
        let signs = signs.map(|(index, line)| (line.name.clone(), Sign::Line(line.stroke(index))));
        let legend: Vec<_> = if self.lines.len() > 1 {
            signs.collect()
        } else {
            Vec::new()
        };
        let words = Words {
            title: &self.title,
            x: self.x.title(),
            y: self.y.title(),
            legend: &legend,
            above: 0.0,
        };
        let frame = Frame::new(words, Bottom::Numbers(&x), &y);
        let shading = Shading::of(&self.shaded, &frame, &x);
        let words = Words {
            above: shading.height(),
            ..words
        };
        let mut frame = Frame::new(words, Bottom::Numbers(&x), &y);
        shading.draw(&mut frame, &x);
        let place = |frame: &Frame, at: (f64, f64)| frame.at(x.part(at.0), y.part(at.1));
        for (index, line) in self.lines.iter().enumerate() {
            let points: Vec<_> = line.band().collect();
            let numbers = |&(x, low, high): &(f64, f64, f64)| (x + low + high).is_finite();
            for run in points.split(|point| !numbers(point)) {
                let above = run.iter().map(|&(x, _, high)| place(&frame, (x, high)));
                let below = run.iter().rev().map(|&(x, low, _)| place(&frame, (x, low)));
                let area = above.chain(below).collect();
                frame.picture.area(area, series(index), 0.2);
            }
        }
        for (index, line) in self.lines.iter().enumerate() {
            for run in line.points.split(|point| !finite(point)) {
                let run: Vec<Place> = run.iter().map(|&at| place(&frame, at)).collect();
                match run[..] {
                    [] => {}
                    [alone] => frame.picture.dot(alone, 7.0, series(index)),
                    _ => frame.picture.line(run, line.stroke(index)),
                }
            }
        }
        if !any {
            frame.say_no_data();
        }
        frame.finished()
    }
}

/// Whether a point is at a place.
fn finite(&(x, y): &(f64, f64)) -> bool {
    x.is_finite() && y.is_finite()
}
