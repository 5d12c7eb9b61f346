//! How values are spread: how many fall into each interval.

use super::axis::{Axis, Scale};
use super::frame::{Bottom, Frame, Sign, Words, X_TICKS, Y_TICKS, thin};
use super::palette::series;
use super::picture::Picture;
use crate::export::{ExportError, OutDir};
use std::path::PathBuf;

/// How many values of each sample fall into each bin, as \[001\] Fig. 6 shows sensors' errors.
///
/// Bins are as wide as asked, and one has its middle at 0: an error of nothing is not torn apart.
/// Where that were more than [`Self::MOST_BINS`], bins are as many times wider. The samples' bars
/// stand side by side within a bin; where it is too narrow, they lie over each other, translucent.
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
    /// How wide a bin is, in the unit of x; 1 where it is not above 0.
    pub bin_width: f64,
    /// What is counted.
    pub samples: Vec<Sample>,
}

/// The narrowest bar that still is told from its neighbours, in pixels.
const NARROWEST_BAR: f64 = 5.0;

/// Values that are counted together.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// What the legend calls it.
    pub name: String,
    /// The values, in the unit of x; what is no number is not counted.
    pub values: Vec<f64>,
}

/// Bins of one width, from the first that has a value to the last.
#[derive(Debug, Clone, Copy)]
struct Bins {
    width: f64,
    first: f64,
    count: usize,
}

impl Bins {
    /// The bin of `value`; bin k reaches from (k − ½) · width, which belongs to it, to (k + ½).
    fn of(width: f64, value: f64) -> f64 {
        (value / width + 0.5).floor()
    }

    /// The middle of bin `number`, counted from the first.
    fn middle(&self, number: usize) -> f64 {
        (self.first + number as f64) * self.width
    }

    /// The lower end of bin `number`; the upper of the one before.
    fn edge(&self, number: usize) -> f64 {
        (self.first + number as f64 - 0.5) * self.width
    }
}

impl Histogram {
    /// The largest number of bins that are told apart.
    pub const MOST_BINS: usize = 400;

    /// Writes the chart as `STEM.png` and `STEM.svg`.
    ///
    /// # Errors
    /// If `stem` is no plain file name or a file cannot be put in place.
    pub fn write(&self, out: &OutDir, stem: &str) -> Result<[PathBuf; 2], ExportError> {
        self.picture().write(out, stem)
    }

    /// Returns, for each sample, the middle of each bin in the unit of x and how many values are in
    /// it; the same bins for all samples, none where there is no value.
    #[must_use]
    pub fn counts(&self) -> Vec<Vec<(f64, u64)>> {
        let Some(bins) = self.bins() else {
            return vec![Vec::new(); self.samples.len()];
        };
        let count = |sample: &Sample| {
            let mut counts = vec![0_u64; bins.count];
            for value in numbers(sample) {
                // Within the bins by their making; the cast saturates.
                let number = (Bins::of(bins.width, value) - bins.first) as usize;
                counts[number.min(bins.count - 1)] += 1;
            }
            let counts = counts.into_iter().enumerate();
            counts
                .map(|(number, count)| (bins.middle(number), count))
                .collect()
        };
        self.samples.iter().map(count).collect()
    }

    fn bins(&self) -> Option<Bins> {
        let values = || self.samples.iter().flat_map(numbers);
        let low = values().reduce(f64::min)?;
        let high = values().reduce(f64::max)?;
        let asked = if self.bin_width > 0.0 && self.bin_width.is_finite() {
            self.bin_width
        } else {
            1.0
        };
        // Narrower bins than this could not be counted off from 0 exactly.
        let width = asked.max(low.abs().max(high.abs()) * 1e-12);
        let times = ((high - low) / width / (Self::MOST_BINS - 1) as f64).ceil();
        let width = width * times.max(1.0);
        let first = Bins::of(width, low);
        // At most MOST_BINS by the width; the cast saturates.
        let count = (Bins::of(width, high) - first) as usize + 1;
        Some(Bins {
            width,
            first,
            count: count.min(Self::MOST_BINS),
        })
    }

    pub(super) fn picture(&self) -> Picture {
        let counts = self.counts();
        let bins = self.bins();
        let edges = bins.map_or_else(Vec::new, |bins| vec![bins.edge(0), bins.edge(bins.count)]);
        let x = Scale::covering(&self.x, edges.into_iter(), X_TICKS);
        let heights = counts.iter().flatten().map(|&(_, count)| count as f64);
        let axis = self.y.clone().from(0.0).including(0.0);
        // Ticks of less than one would count parts of values.
        let highest = heights.clone().fold(1.0, f64::max);
        let ticks = f64::from(Y_TICKS).min(highest) as u32;
        let y = Scale::covering(&axis, heights, ticks);
        let signs = self.samples.iter().enumerate();
        let signs =
            signs.map(|(index, sample)| (sample.name.clone(), Sign::Area(series(index), 1.0)));
        let legend: Vec<_> = if self.samples.len() > 1 {
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
        let mut frame = Frame::new(words, Bottom::Numbers(&x), &y);
        let Some(bins) = bins else {
            frame.say_no_data();
            return frame.finished();
        };
        let (left, _) = frame.at(x.part(bins.edge(0)), 0.0);
        let (right, _) = frame.at(x.part(bins.edge(1)), 0.0);
        let samples = counts.len() as f64;
        if counts.len() > 1 && (right - left) / samples >= NARROWEST_BAR {
            for (index, counts) in counts.iter().enumerate() {
                // A sixth of the bin stays free between it and the next.
                let part = |of: f64| 1.0 / 12.0 + 5.0 / 6.0 * of / samples;
                let (from, to) = (part(index as f64), part(index as f64 + 1.0));
                for (number, &(_, count)) in counts.iter().enumerate() {
                    let (low, high) = (bins.edge(number), bins.edge(number + 1));
                    let end = |part: f64| x.part(low + (high - low) * part);
                    let foot = frame.at(end(from), 0.0);
                    let head = frame.at(end(to), y.part(count as f64));
                    if count > 0 {
                        frame.picture.rectangle(foot, head, series(index), 1.0);
                    }
                }
            }
        } else {
            overlay(&mut frame, bins, &counts, &x, &y);
        }
        frame.finished()
    }
}

/// Draws the samples over each other, translucent, with their outline on top.
fn overlay(frame: &mut Frame, bins: Bins, counts: &[Vec<(f64, u64)>], x: &Scale, y: &Scale) {
    let outline = |counts: &Vec<(f64, u64)>| {
        // From its own first value to its last: nothing is drawn along the axis.
        let some = |bin: &(f64, u64)| bin.1 > 0;
        let from = counts.iter().position(some).unwrap_or(0);
        let to = counts.iter().rposition(some).map_or(0, |last| last + 1);
        let mut outline = vec![frame.at(x.part(bins.edge(from)), 0.0)];
        for (number, &(_, count)) in counts.iter().enumerate().take(to).skip(from) {
            let ends = [bins.edge(number), bins.edge(number + 1)];
            outline.extend(ends.map(|end| frame.at(x.part(end), y.part(count as f64))));
        }
        outline.push(frame.at(x.part(bins.edge(to)), 0.0));
        outline
    };
    let outlines: Vec<_> = counts.iter().map(outline).collect();
    for (index, outline) in outlines.iter().enumerate() {
        frame.picture.area(outline.clone(), series(index), 0.3);
    }
    for (index, outline) in outlines.into_iter().enumerate() {
        frame.picture.line(outline, thin(series(index), 4.0));
    }
}

fn numbers(sample: &Sample) -> impl Iterator<Item = f64> + '_ {
    // So that sums and differences of values and bins stay finite.
    let values = sample.values.iter().copied().filter(|v| v.is_finite());
    values.map(|value| value.clamp(-1e300, 1e300))
}
