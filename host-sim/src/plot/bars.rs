//! Bar charts: values of groups side by side, with their uncertainty.

use super::axis::{Axis, Scale};
use super::canvas::{Area, Draw, Drawn, write};
use super::frame::{Frame, INK, Sign, Stroke, Texts, Y_TICKS, series};
use crate::export::{ExportError, OutDir};
use plotters::prelude::DrawingBackend;
use std::path::PathBuf;

/// Bars in groups, one bar a series in each. They begin at 0, which the axis always shows.
///
/// # Examples
/// ```
/// use certainty_sim::export::OutDir;
/// use certainty_sim::plot::{Axis, BarChart, BarSeries};
///
/// let chart = BarChart {
///     title: "Error by method".into(),
///     y: Axis::counting("mean absolute error"),
///     groups: ["bayes", "robust"].map(String::from).to_vec(),
///     bars: vec![BarSeries {
///         name: "one sensor stuck".into(),
///         values: vec![Some(0.101), Some(0.022)],
///         errors: Some(vec![0.010, 0.004]),
///     }],
/// };
/// let folder = tempfile::tempdir().unwrap();
/// chart.write(&OutDir::create(folder.path())?, "methods")?;
/// # Ok::<(), certainty_sim::export::ExportError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct BarChart {
    /// What the chart shows.
    pub title: String,
    /// The axis upwards.
    pub y: Axis,
    /// The names below the groups.
    pub groups: Vec<String>,
    /// One bar in each group, from left to right.
    pub bars: Vec<BarSeries>,
}

/// The bars of one colour.
#[derive(Debug, Clone, PartialEq)]
pub struct BarSeries {
    /// Its name in the legend.
    pub name: String,
    /// The value in each group; `None` leaves the place empty.
    pub values: Vec<Option<f64>>,
    /// Half the length of each value's whisker: ± this.
    pub errors: Option<Vec<f64>>,
}

impl BarSeries {
    /// Value and whisker in `group`, if they are numbers.
    fn in_group(&self, group: usize) -> Option<(f64, Option<f64>)> {
        let value = self.values.get(group).copied().flatten();
        let error = self.errors.as_ref().and_then(|errors| errors.get(group));
        let error = error.copied().filter(|error| error.is_finite());
        value
            .filter(|value| value.is_finite())
            .map(|value| (value, error.map(f64::abs)))
    }
}

impl BarChart {
    /// Writes the chart as `STEM.png` and `STEM.svg`.
    ///
    /// # Errors
    /// If `stem` is not a plain file name or a file cannot be put in place.
    pub fn write(&self, out: &OutDir, stem: &str) -> Result<[PathBuf; 2], ExportError> {
        write(self, out, stem)
    }
}

impl Draw for BarChart {
    fn draw<D: DrawingBackend>(&self, area: &Area<D>) -> Drawn<D> {
        let groups = 0..self.groups.len();
        let shown = groups.flat_map(|group| self.bars.iter().map(move |bars| bars.in_group(group)));
        let ends: Vec<f64> = shown
            .flatten()
            .flat_map(|(value, error)| {
                let error = error.unwrap_or(0.0);
                [value - error, value + error]
            })
            .collect();
        // Without any value the axis goes from 0 to 1.
        let ends_or_one = ends.iter().copied().chain(ends.is_empty().then_some(1.0));
        let y = Scale::covering(&self.y.clone().including(0.0), ends_or_one, Y_TICKS);
        let x = Scale::of_names(&self.groups);
        let signs = self.bars.iter().enumerate();
        let signs = signs.map(|(index, bars)| (bars.name.clone(), Sign::Area(series(index))));
        let legend: Vec<_> = signs.filter(|_| self.bars.len() > 1).collect();
        let texts = Texts {
            title: &self.title,
            x: "",
            y: self.y.title(),
            legend: &legend,
            above: 0.0,
        };
        let mut frame = Frame::new(area, texts, &x, &y)?;
        let bars = self.bars.len() as f64;
        for group in 0..self.groups.len() {
            for (index, series_of) in self.bars.iter().enumerate() {
                let Some((value, error)) = series_of.in_group(group) else {
                    continue;
                };
                // A group's bars fill three quarters of its part of the axis.
                let from = group as f64 + 0.125 + 0.75 * index as f64 / bars;
                let to = from + 0.75 / bars;
                // A narrow gap between neighbours.
                let gap = (to - from) * 0.04;
                let corners = [(from + gap, 0.0), (to - gap, value)];
                frame.rectangle(corners, series(index), 1.0)?;
                if let Some(error) = error {
                    let (middle, half) = (f64::midpoint(from, to), (to - from) * 0.2);
                    let stroke = Stroke::solid(INK, 2.5);
                    let ends = [value - error, value + error];
                    frame.line(ends.map(|end| (middle, end)).to_vec(), stroke)?;
                    for end in ends {
                        let cap = [middle - half, middle + half].map(|x| (x, end));
                        frame.line(cap.to_vec(), stroke)?;
                    }
                }
            }
        }
        if y.low() < 0.0 {
            let zero = vec![(0.0, 0.0), (self.groups.len() as f64, 0.0)];
            frame.line(zero, Stroke::solid(INK, 2.0))?;
        }
        if ends.is_empty() {
            frame.no_data()?;
        }
        frame.finish()
    }
}
