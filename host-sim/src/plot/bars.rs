//! Groups compared: bars side by side, with their uncertainty.

use super::axis::{Axis, Scale};
use super::frame::{Bottom, Frame, Sign, Words, Y_TICKS, thin};
use super::palette::{INK, series};
use super::picture::Picture;
use crate::export::{ExportError, OutDir};
use std::path::PathBuf;

/// Bars in groups, one bar a series in each; they stand on 0, which the axis always shows.
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
    /// What is written below the groups.
    pub groups: Vec<String>,
    /// One bar in each group, from left to right.
    pub bars: Vec<BarSeries>,
}

/// The bars of one colour.
#[derive(Debug, Clone, PartialEq)]
pub struct BarSeries {
    /// What the legend calls it.
    pub name: String,
    /// The value in each group; `None` leaves the place empty.
    pub values: Vec<Option<f64>>,
    /// Half the length of each value's whisker: ± this.
    pub errors: Option<Vec<f64>>,
}

impl BarSeries {
    /// Value and whisker in `group`, as far as they are numbers.
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
    /// If `stem` is no plain file name or a file cannot be put in place.
    pub fn write(&self, out: &OutDir, stem: &str) -> Result<[PathBuf; 2], ExportError> {
        self.picture().write(out, stem)
    }

    pub(super) fn picture(&self) -> Picture {
        let groups = 0..self.groups.len();
        let shown = groups.flat_map(|group| self.bars.iter().map(move |bars| bars.in_group(group)));
        let ends: Vec<f64> = shown
            .flatten()
            .flat_map(|(value, error)| {
                let error = error.unwrap_or(0.0);
                [value - error, value + error]
            })
            .collect();
        let axis = self.y.clone().including(0.0);
        // Nothing to show has an axis from 0 upwards.
        let ends_or_one = ends.iter().copied().chain(ends.is_empty().then_some(1.0));
        let y = Scale::covering(&axis, ends_or_one, Y_TICKS);
        let signs = self.bars.iter().enumerate();
        let signs = signs.map(|(index, bars)| (bars.name.clone(), Sign::Area(series(index), 1.0)));
        let legend: Vec<_> = if self.bars.len() > 1 {
            signs.collect()
        } else {
            Vec::new()
        };
        let words = Words {
            title: &self.title,
            x: "",
            y: self.y.title(),
            legend: &legend,
            above: 0.0,
        };
        let mut frame = Frame::new(words, Bottom::Names(&self.groups), &y);
        // A group's bars fill three quarters of its place.
        let (count, bars) = (self.groups.len() as f64, self.bars.len() as f64);
        for group in 0..self.groups.len() {
            for (index, series_of) in self.bars.iter().enumerate() {
                let Some((value, error)) = series_of.in_group(group) else {
                    continue;
                };
                let from = (group as f64 + 0.125 + 0.75 * index as f64 / bars) / count;
                let to = from + 0.75 / bars / count;
                // A hair of paper between neighbours.
                let gap = (to - from) * 0.04;
                let (foot, head) = (y.part(0.0), y.part(value));
                let (a, b) = (frame.at(from + gap, foot), frame.at(to - gap, head));
                frame.picture.rectangle(a, b, series(index), 1.0);
                if let Some(error) = error {
                    let middle = f64::midpoint(from, to);
                    let ends = [value - error, value + error].map(|end| y.part(end));
                    let cap = (to - from) * 0.2;
                    let stroke = thin(INK, 2.5);
                    let whisker = ends.map(|end| frame.at(middle, end)).to_vec();
                    frame.picture.line(whisker, stroke);
                    for end in ends {
                        let cap = [middle - cap, middle + cap].map(|x| frame.at(x, end));
                        frame.picture.line(cap.to_vec(), stroke);
                    }
                }
            }
        }
        if y.low() < 0.0 {
            let zero = [0.0, 1.0].map(|x| frame.at(x, y.part(0.0))).to_vec();
            frame.picture.line(zero, thin(INK, 2.0));
        }
        if ends.is_empty() {
            frame.say_no_data();
        }
        frame.finished()
    }
}
