//! Charts of values: lines over an axis of numbers, bars of groups, and histograms.

use super::frame::{
    Area, Axis, Draw, Drawn, Frame, GREY, INK, Place, SPAN_ROW, Sign, Stroke, Texts, series, write,
};
use super::plan::finite;
use crate::export::{ExportError, OutDir};
use plotters::prelude::{Color, DrawingBackend};
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
    /// The intervals of x that are shaded; each has a labelled bar above the data.
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

    const fn stroke(&self, index: usize) -> Stroke {
        Stroke {
            colour: series(index),
            width: 8,
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
    /// The text at its bar.
    pub label: String,
}

/// The most rows of bars above the data; more would leave little of the chart.
const MOST_SPANS: usize = 8;

impl LineChart {
    /// Writes the chart as `STEM.png` and `STEM.svg`.
    ///
    /// # Errors
    /// If `stem` is not a plain file name or a file cannot be put in place.
    pub fn write(&self, out: &OutDir, stem: &str) -> Result<[PathBuf; 2], ExportError> {
        write(self, out, stem)
    }

    /// Shades the intervals; where they overlap the shade is darker. The first ones have a bar with
    /// their label in a row of their own above the data, the number of the others a row.
    fn shade<D: DrawingBackend>(&self, frame: &Frame<'_, D>, texts: &Texts<'_>) -> Drawn<D> {
        let [(start, top), (end, bottom)] = texts.corners();
        for (row, span) in self.spans().enumerate() {
            let ends = [span.from.min(span.to), span.from.max(span.to)];
            let [left, right] = ends.map(|x| frame.at((x, 0.0)).0);
            frame.rectangle([(left, top), (right, bottom)], GREY.mix(0.16))?;
            if row < MOST_SPANS {
                let above = top - texts.above + SPAN_ROW * row as i32;
                let corners = [(left, above), (right.max(left + 6), above + SPAN_ROW - 8)];
                frame.rectangle(corners, GREY.mix(0.35))?;
                let text = left.min(i32::midpoint(start, end)) + 16;
                frame.label(&span.label, (text, above + SPAN_ROW / 2 - 4), end - text)?;
            }
        }
        if let more @ 1.. = self.spans().count().saturating_sub(MOST_SPANS) {
            frame.label(
                &format!("and {more} more"),
                (start + 16, top - SPAN_ROW / 2),
                end - start,
            )?;
        }
        Ok(())
    }

    /// The intervals whose ends are numbers.
    fn spans(&self) -> impl Iterator<Item = &Span> {
        self.shaded
            .iter()
            .filter(|span| finite(&(span.from, span.to)))
    }
}

impl Draw for LineChart {
    fn draw<D: DrawingBackend>(&self, area: &Area<D>) -> Drawn<D> {
        let points = self.lines.iter().flat_map(|line| &line.points);
        let points: Vec<Place> = points.copied().filter(finite).collect();
        let spans = self.spans().flat_map(|span| [span.from, span.to]);
        let bands = self.lines.iter().flat_map(Line::band);
        let bands = bands.flat_map(|(_, low, high)| [low, high]);
        let across = points.iter().map(|point| point.0).chain(spans);
        let up = points.iter().map(|point| point.1).chain(bands);
        let signs = self.lines.iter().enumerate();
        let signs = signs.map(|(index, line)| (line.name.clone(), Sign::Line(line.stroke(index))));
        let texts = Texts {
            title: &self.title,
            x: self.x.title(),
            y: self.y.title(),
            legend: signs.filter(|_| self.lines.len() > 1).collect(),
            above: SPAN_ROW * self.spans().count().min(MOST_SPANS + 1) as i32,
            ..Texts::default()
        };
        let frame = Frame::new(area, &texts, [self.x.range(across), self.y.range(up)])?;
        self.shade(&frame, &texts)?;
        for (index, line) in self.lines.iter().enumerate() {
            let points: Vec<_> = line.band().collect();
            let numbers = |&(x, low, high): &(f64, f64, f64)| finite(&(x, low)) && high.is_finite();
            for run in points.split(|point| !numbers(point)) {
                let above = run.iter().map(|&(x, _, high)| (x, high));
                let below = run.iter().rev().map(|&(x, low, _)| (x, low));
                let outline: Vec<Place> = above.chain(below).collect();
                frame.fill(frame.all(&outline), series(index).mix(0.2))?;
            }
        }
        for (index, one) in self.lines.iter().enumerate() {
            for run in one.points.split(|point| !finite(point)) {
                frame.line(frame.all(run), one.stroke(index))?;
            }
        }
        if points.is_empty() {
            frame.no_data()?;
        }
        Ok(())
    }
}

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

/// Where bar `index` of `count` begins and ends within its group, of which they fill three quarters.
fn side_by_side(index: usize, count: usize) -> [f64; 2] {
    [index, index + 1].map(|bar| 0.125 + 0.75 * bar as f64 / count as f64)
}

/// The legend of bars; one series needs none.
fn bar_legend<'a>(names: impl ExactSizeIterator<Item = &'a String>) -> Vec<(String, Sign)> {
    let several = names.len() > 1;
    let names = names.enumerate().filter(|_| several);
    names
        .map(|(index, name)| (name.clone(), Sign::Area(series(index).mix(1.0))))
        .collect()
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
        let ends = shown.flatten().flat_map(|(value, error)| {
            let error = error.unwrap_or(0.0);
            [value - error, value + error]
        });
        let ends: Vec<f64> = ends.collect();
        // Without any value the axis goes from 0 to 1.
        let ends_or_one = ends.iter().copied().chain(ends.is_empty().then_some(1.0));
        let y = self.y.clone().including(0.0).range(ends_or_one);
        let x = 0.0..self.groups.len().max(1) as f64;
        let texts = Texts {
            title: &self.title,
            y: self.y.title(),
            legend: bar_legend(self.bars.iter().map(|bars| &bars.name)),
            groups: &self.groups,
            ..Texts::default()
        };
        let frame = Frame::new(area, &texts, [x.clone(), y])?;
        for group in 0..self.groups.len() {
            for (index, series_of) in self.bars.iter().enumerate() {
                let Some((value, error)) = series_of.in_group(group) else {
                    continue;
                };
                let ends = side_by_side(index, self.bars.len());
                let [from, to] = ends.map(|end| group as f64 + end);
                // A narrow gap between neighbours.
                let gap = (to - from) * 0.04;
                let corners = [(from + gap, 0.0), (to - gap, value)].map(|end| frame.at(end));
                frame.rectangle(corners, series(index).mix(1.0))?;
                if let Some(error) = error {
                    let (middle, half) = (f64::midpoint(from, to), (to - from) * 0.2);
                    let ends = [value - error, value + error];
                    let stem = ends.map(|end| (middle, end));
                    let caps = ends.map(|end| [middle - half, middle + half].map(|x| (x, end)));
                    for piece in [stem, caps[0], caps[1]] {
                        frame.line(frame.all(&piece), Stroke::solid(INK, 5))?;
                    }
                }
            }
        }
        let zero = [(x.start, 0.0), (x.end, 0.0)];
        frame.line(frame.all(&zero), Stroke::solid(GREY, 4))?;
        if ends.is_empty() {
            frame.no_data()?;
        }
        Ok(())
    }
}

/// How many values of each sample fall into each bin, as \[001\] Fig. 6 shows sensors' errors.
///
/// One bin has its middle at 0, so that small errors of either sign share a bin. If there were more
/// than [`Self::MOST_BINS`] of the given width, bins are wider by a whole factor. The samples' bars
/// stand side by side within a bin.
///
/// # Examples
/// ```
/// use certainty_sim::export::OutDir;
/// use certainty_sim::plot::{Axis, Histogram, Sample};
///
/// let histogram = Histogram {
///     title: "Error of the distance".into(),
///     x: Axis::new("error", "mm"),
///     y: Axis::counting("readings"),
///     bin_width: 10.0,
///     samples: vec![Sample { name: "A".into(), values: vec![-4.0, 4.9, 5.1, 12.0] }],
/// };
/// assert_eq!(histogram.counts(), [vec![(0.0, 2), (10.0, 2)]]);
/// let folder = tempfile::tempdir().unwrap();
/// histogram.write(&OutDir::create(folder.path())?, "errors")?;
/// # Ok::<(), certainty_sim::export::ExportError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Histogram {
    /// What the chart shows.
    pub title: String,
    /// The axis of the values.
    pub x: Axis,
    /// The axis of the counts; it begins at 0.
    pub y: Axis,
    /// Width of a bin, in the unit of x; 1 if it is not above 0.
    pub bin_width: f64,
    /// The samples that are counted.
    pub samples: Vec<Sample>,
}

/// Values that are counted together.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// Its name in the legend.
    pub name: String,
    /// The values, in the unit of x; values that are not finite are not counted.
    pub values: Vec<f64>,
}

impl Sample {
    /// The values that are counted; sums and differences of them and of bins stay finite.
    fn numbers(&self) -> impl Iterator<Item = f64> + '_ {
        let values = self
            .values
            .iter()
            .copied()
            .filter(|value| value.is_finite());
        values.map(|value| value.clamp(-1e300, 1e300))
    }
}

/// The bin of `value`; bin k reaches from (k − ½) · width, which belongs to it, to (k + ½).
fn bin_of(width: f64, value: f64) -> f64 {
    (value / width + 0.5).floor()
}

impl Histogram {
    /// The largest number of bins.
    pub const MOST_BINS: usize = 400;

    /// Writes the chart as `STEM.png` and `STEM.svg`.
    ///
    /// # Errors
    /// If `stem` is not a plain file name or a file cannot be put in place.
    pub fn write(&self, out: &OutDir, stem: &str) -> Result<[PathBuf; 2], ExportError> {
        write(self, out, stem)
    }

    /// Returns, for each sample, the middle of each bin in the unit of x and its number of values.
    ///
    /// All samples have the same bins; none if there is no value.
    #[must_use]
    pub fn counts(&self) -> Vec<Vec<(f64, u64)>> {
        let Some((width, first, bins)) = self.bins() else {
            return vec![Vec::new(); self.samples.len()];
        };
        let count = |sample: &Sample| {
            let middles = (0..bins).map(|number| (first + number as f64) * width);
            let mut counts: Vec<(f64, u64)> = middles.map(|middle| (middle, 0)).collect();
            for value in sample.numbers() {
                // The bins cover all values; the cast saturates.
                let number = (bin_of(width, value) - first) as usize;
                counts[number.min(bins - 1)].1 += 1;
            }
            counts
        };
        self.samples.iter().map(count).collect()
    }

    /// The width of the bins, the number of the first, and how many there are up to the last value.
    fn bins(&self) -> Option<(f64, f64, usize)> {
        let values = || self.samples.iter().flat_map(Sample::numbers);
        let low = values().reduce(f64::min)?;
        let high = values().reduce(f64::max)?;
        let width = if self.bin_width > 0.0 && self.bin_width.is_finite() {
            self.bin_width
        } else {
            1.0
        };
        // The multiples of a narrower width would not be exact.
        let width = width.max(low.abs().max(high.abs()) * 1e-12);
        let times = ((high - low) / width / (Self::MOST_BINS - 1) as f64).ceil();
        let width = width * times.max(1.0);
        let first = bin_of(width, low);
        // At most MOST_BINS by the width; the cast saturates.
        let count = (bin_of(width, high) - first) as usize + 1;
        Some((width, first, count.min(Self::MOST_BINS)))
    }
}

impl Draw for Histogram {
    fn draw<D: DrawingBackend>(&self, area: &Area<D>) -> Drawn<D> {
        let counts = self.counts();
        let width = self.bins().map_or(0.0, |(width, ..)| width);
        let middles = counts.iter().flatten().map(|bin| bin.0);
        let edges = middles.flat_map(|middle| [middle - width / 2.0, middle + width / 2.0]);
        let highest = counts.iter().flatten().map(|bin| bin.1).max();
        let heights = highest.map(|count| count as f64);
        let texts = Texts {
            title: &self.title,
            x: self.x.title(),
            y: self.y.title(),
            legend: bar_legend(self.samples.iter().map(|sample| &sample.name)),
            highest_count: Some(heights.unwrap_or(1.0)),
            ..Texts::default()
        };
        let y = self
            .y
            .clone()
            .from(0.0)
            .including(0.0)
            .range(heights.or(Some(1.0)).into_iter());
        let frame = Frame::new(area, &texts, [self.x.range(edges), y])?;
        for (index, counts_of) in counts.iter().enumerate() {
            let ends = side_by_side(index, counts.len());
            for &(middle, count) in counts_of.iter().filter(|bin| bin.1 > 0) {
                let [from, to] = ends.map(|end| middle + width * (end - 0.5));
                let corners = [(from, 0.0), (to, count as f64)].map(|end| frame.at(end));
                frame.rectangle(corners, series(index).mix(1.0))?;
            }
        }
        if highest.is_none() {
            frame.no_data()?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn histogram(bin_width: f64, samples: &[&[f64]]) -> Histogram {
        let sample = |values: &&[f64]| Sample {
            name: "a".into(),
            values: values.to_vec(),
        };
        Histogram {
            title: "errors".into(),
            x: Axis::new("error", "mm"),
            y: Axis::counting("readings"),
            bin_width,
            samples: samples.iter().map(sample).collect(),
        }
    }

    #[test]
    fn histogram_counts_every_number_once() {
        let values = [-5.0, -4.999, 4.999, 5.0, 14.9, f64::NAN, 100.0];
        let counts = histogram(10.0, &[&values, &[95.0]]).counts();
        let of = |sample: usize, middle: f64| {
            let mut bins = counts[sample].iter();
            bins.find(|bin| bin.0 == middle).unwrap().1
        };
        assert_eq!((of(0, 0.0), of(0, 10.0), of(0, 100.0)), (3, 2, 1));
        assert_eq!((of(1, 0.0), of(1, 100.0)), (0, 1));
        assert_eq!(counts[0].len(), 11);
    }

    #[test]
    fn bars_of_a_group_do_not_overlap() {
        for count in 1..9 {
            let ends: Vec<_> = (0..count).map(|index| side_by_side(index, count)).collect();
            assert!(ends.windows(2).all(|pair| pair[0][1] <= pair[1][0]));
            assert!(ends[0][0] > 0.0 && ends[count - 1][1] < 1.0);
        }
    }

    proptest! {
        #[test]
        fn any_values_fall_into_bins(
            values in prop::collection::vec(any::<f64>(), 0..6),
            bin_width in any::<f64>(),
        ) {
            let finite = values.iter().filter(|value| value.is_finite()).count() as u64;
            let counts = histogram(bin_width, &[&values]).counts();
            prop_assert_eq!(counts[0].iter().map(|bin| bin.1).sum::<u64>(), finite);
            prop_assert!(counts[0].len() <= Histogram::MOST_BINS);
        }
    }
}
