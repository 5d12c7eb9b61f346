//! What many runs have in common.

use super::{ConfidenceTrace, share};
use serde::Serialize;

/// A mean and the standard deviation of one sample, both 0 for none.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// The mean.
    pub mean: f64,
    /// The standard deviation, of *n* − 1 degrees of freedom; 0 for a single one.
    pub sd: f64,
}

impl Spread {
    /// Returns the spread of `samples`.
    #[must_use]
    pub fn of(samples: &[f64]) -> Self {
        let count = samples.len().max(1) as f64;
        let mean = samples.iter().sum::<f64>() / count;
        let squares: f64 = samples.iter().map(|sample| (sample - mean).powi(2)).sum();
        let sd = (squares / (count - 1.0).max(1.0)).sqrt();
        Self { mean, sd }
    }
}

/// What many runs have in common; its fields are a contract.
///
/// Percentiles are nearest-rank: the smallest value that so many of the runs do not exceed. A run
/// that never recovered counts as an infinite value, and an infinite percentile is `None`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct OverSeeds {
    /// How many runs.
    pub seeds: usize,
    /// In how many of them sensor 1 was back before the end.
    pub recovered: usize,
    /// The median of [`ConfidenceTrace::recovered_after`].
    pub median: Option<usize>,
    /// Its 10th percentile.
    pub p10: Option<usize>,
    /// Its 90th percentile.
    pub p90: Option<usize>,
    /// [`ConfidenceTrace::lowest_in_fault`].
    pub lowest_confidence: Spread,
    /// [`ConfidenceTrace::below_others`].
    pub below_others: Spread,
    /// Share of the runs with [`ConfidenceTrace::clearly_below`].
    pub clearly_below: f64,
    /// The same share where the same runs have no fault.
    ///
    /// A sensor can be below the others by its own errors, or by the part of the scene that was
    /// swept last; what is low here too is no effect of the fault.
    pub clearly_below_without_fault: f64,
    /// The median among those alone: a sensor that never fell is back at once and says nothing of
    /// recovery. `None` also where there are none.
    pub median_of_clearly_below: Option<usize>,
}

impl OverSeeds {
    /// Sums up `traces`, beside their `twins` without the fault.
    #[must_use]
    pub fn of(traces: &[ConfidenceTrace], twins: &[ConfidenceTrace]) -> Self {
        let all: Vec<_> = traces
            .iter()
            .map(ConfidenceTrace::recovered_after)
            .collect();
        let fell = |trace: &&ConfidenceTrace| trace.clearly_below();
        let share = |count: usize, of: usize| count as f64 / of.max(1) as f64;
        let fallen = traces.iter().filter(fell);
        let of_fallen: Vec<_> = fallen.map(ConfidenceTrace::recovered_after).collect();
        let lowest = traces.iter().map(ConfidenceTrace::lowest_in_fault);
        let below = traces.iter().filter_map(ConfidenceTrace::below_others);
        Self {
            seeds: traces.len(),
            recovered: all.iter().flatten().count(),
            median: percentile(&all, 50),
            p10: percentile(&all, 10),
            p90: percentile(&all, 90),
            lowest_confidence: Spread::of(&lowest.collect::<Vec<_>>()),
            below_others: Spread::of(&below.collect::<Vec<_>>()),
            clearly_below: share(of_fallen.len(), traces.len()),
            clearly_below_without_fault: share(twins.iter().filter(fell).count(), twins.len()),
            median_of_clearly_below: percentile(&of_fallen, 50),
        }
    }
}

/// One sensor's confidence at every reading over many runs, each of full confidence, 0 to 1.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Course {
    /// The mean.
    pub mean: Vec<f64>,
    /// The 10th and the 90th percentile, nearest-rank.
    pub band: Vec<(f64, f64)>,
}

impl Course {
    /// Returns the course of the sensor at `slot`, as long as the shortest of `traces`.
    ///
    /// # Panics
    ///
    /// If a trace has no such sensor.
    #[must_use]
    pub fn of(traces: &[ConfidenceTrace], slot: usize) -> Self {
        let lengths = traces.iter().map(ConfidenceTrace::length);
        let mut course = Self::default();
        for at in 0..lengths.min().unwrap_or(0) {
            let own = traces.iter().map(|trace| trace.confidences()[slot][at]);
            let mut own: Vec<f64> = own.map(share).collect();
            own.sort_by(f64::total_cmp);
            let ranked = |percent: usize| own[(own.len() * percent).div_ceil(100).max(1) - 1];
            course.mean.push(Spread::of(&own).mean);
            course.band.push((ranked(10), ranked(90)));
        }
        course
    }
}

/// The nearest-rank percentile of values of which `None` is infinite.
pub(super) fn percentile(values: &[Option<usize>], percent: usize) -> Option<usize> {
    let mut sorted = values.to_vec();
    sorted.sort_by_key(|value| value.unwrap_or(usize::MAX));
    let rank = (values.len() * percent).div_ceil(100).max(1);
    sorted.get(rank - 1).copied().flatten()
}
