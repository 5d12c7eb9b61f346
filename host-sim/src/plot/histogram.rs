//! Histograms: how many values fall into each bin.

use super::axis::{Axis, Scale};
use super::canvas::{Area, Draw, Drawn, write};
use super::frame::{Frame, Place, Sign, Stroke, Texts, X_TICKS, Y_TICKS, series};
use crate::export::{ExportError, OutDir};
use plotters::prelude::DrawingBackend;
use std::path::PathBuf;

/// How many values of each sample fall into each bin, as \[001\] Fig. 6 shows sensors' errors.
///
/// One bin has its middle at 0, so that small errors of either sign share a bin. If there were more
/// than [`Self::MOST_BINS`] of the given width, bins are wider by a whole factor. The samples' bars
/// stand side by side within a bin; if it is too narrow, they lie over each other, translucent.
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

/// The narrowest bar that can be distinguished from its neighbours, in pixels.
const NARROWEST_BAR: f64 = 5.0;

/// Values that are counted together.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// Its name in the legend.
    pub name: String,
    /// The values, in the unit of x; values that are not finite are not counted.
    pub values: Vec<f64>,
}

/// Bins of one width, from the first with a value to the last.
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
        let Some(bins) = self.bins() else {
            return vec![Vec::new(); self.samples.len()];
        };
        let count = |sample: &Sample| {
            let mut counts = vec![0_u64; bins.count];
            for value in numbers(sample) {
                // `bins` covers all values; the cast saturates.
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
        let width = if self.bin_width > 0.0 && self.bin_width.is_finite() {
            self.bin_width
        } else {
            1.0
        };
        // The multiples of a narrower width would not be exact.
        let width = width.max(low.abs().max(high.abs()) * 1e-12);
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
}

impl Draw for Histogram {
    fn draw<D: DrawingBackend>(&self, area: &Area<D>) -> Drawn<D> {
        let counts = self.counts();
        let bins = self.bins();
        let edges = bins.map_or_else(Vec::new, |bins| vec![bins.edge(0), bins.edge(bins.count)]);
        let x = Scale::covering(&self.x, edges.into_iter(), X_TICKS);
        let heights = counts.iter().flatten().map(|&(_, count)| count as f64);
        let y_axis = self.y.clone().from(0.0).including(0.0);
        // Ticks less than 1 apart would not be counts.
        let highest = heights.clone().fold(1.0, f64::max);
        let y = Scale::covering(&y_axis, heights, f64::from(Y_TICKS).min(highest) as u32);
        let signs = self.samples.iter().enumerate();
        let signs = signs.map(|(index, sample)| (sample.name.clone(), Sign::Area(series(index))));
        let legend: Vec<_> = signs.filter(|_| self.samples.len() > 1).collect();
        let texts = Texts {
            title: &self.title,
            x: self.x.title(),
            y: self.y.title(),
            legend: &legend,
            above: 0.0,
        };
        let mut frame = Frame::new(area, texts, &x, &y)?;
        let Some(bins) = bins else {
            frame.no_data()?;
            return frame.finish();
        };
        let pixels = |edge: usize| frame.pixel((bins.edge(edge), 0.0)).0;
        let samples = counts.len() as f64;
        if counts.len() > 1 && (pixels(1) - pixels(0)) / samples >= NARROWEST_BAR {
            for (index, counts) in counts.iter().enumerate() {
                // A sixth of the bin stays free between it and the next.
                let part = |of: f64| 1.0 / 12.0 + 5.0 / 6.0 * of / samples;
                let (from, to) = (part(index as f64), part(index as f64 + 1.0));
                for (number, &(_, count)) in counts.iter().enumerate() {
                    let (low, high) = (bins.edge(number), bins.edge(number + 1));
                    let end = |part: f64| low + (high - low) * part;
                    let corners = [(end(from), 0.0), (end(to), count as f64)];
                    if count > 0 {
                        frame.rectangle(corners, series(index), 1.0)?;
                    }
                }
            }
        } else {
            let outlines = counts.iter().map(|counts| outline(bins, counts));
            let outlines: Vec<_> = outlines.collect();
            for (index, outline) in outlines.iter().enumerate() {
                frame.area(outline.clone(), series(index), 0.3)?;
            }
            for (index, outline) in outlines.into_iter().enumerate() {
                frame.line(outline, Stroke::solid(series(index), 4.0))?;
            }
        }
        frame.finish()
    }
}

/// The steps of a sample's counts, from its first value to its last.
fn outline(bins: Bins, counts: &[(f64, u64)]) -> Vec<Place> {
    let some = |bin: &(f64, u64)| bin.1 > 0;
    let from = counts.iter().position(some).unwrap_or(0);
    let to = counts.iter().rposition(some).map_or(0, |last| last + 1);
    let mut outline = vec![(bins.edge(from), 0.0)];
    for (number, &(_, count)) in counts.iter().enumerate().take(to).skip(from) {
        let ends = [bins.edge(number), bins.edge(number + 1)];
        outline.extend(ends.map(|end| (end, count as f64)));
    }
    outline.push((bins.edge(to), 0.0));
    outline
}

fn numbers(sample: &Sample) -> impl Iterator<Item = f64> + '_ {
    // Sums and differences of values and bins stay finite.
    let values = sample.values.iter().copied().filter(|v| v.is_finite());
    values.map(|value| value.clamp(-1e300, 1e300))
}
