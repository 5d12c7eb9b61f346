//! Means, standard deviations, confidence intervals and waiting times of samples.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// A mean and the standard deviation of one sample; both 0 without samples.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// The mean.
    pub mean: f64,
    /// The standard deviation, of *n* − 1 degrees of freedom; 0 for a single sample.
    pub sd: f64,
}

impl Spread {
    /// Returns the spread of `samples`.
    #[must_use]
    pub fn of(samples: &[f64]) -> Self {
        let count = samples.len().max(1) as f64;
        let mean = samples.iter().sum::<f64>() / count;
        let squares: f64 = samples.iter().map(|x| (x - mean) * (x - mean)).sum();
        let sd = (squares / (count - 1.0).max(1.0)).sqrt();
        Self { mean, sd }
    }
}

/// A mean with its confidence interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Estimate {
    /// The mean of the samples.
    pub(crate) mean: f64,
    /// Half the width of the interval that holds the true mean with 95 %, by Student's t; `None` for
    /// a single sample, which has no spread.
    pub(crate) half_width: Option<f64>,
}

impl Estimate {
    /// Estimates the mean of the distribution of `samples`; `None` without samples.
    pub(crate) fn of(samples: &[f64]) -> Option<Self> {
        let mean = mean(samples)?;
        let count = samples.len() as f64;
        let half_width = standard_deviation(samples).and_then(|deviation| {
            let student = StudentsT::new(0.0, 1.0, count - 1.0).ok()?;
            Some(student.inverse_cdf(0.975) * deviation / count.sqrt())
        });
        Some(Self { mean, half_width })
    }
}

/// Returns the mean of `samples`; `None` without any.
#[must_use]
pub fn mean(samples: &[f64]) -> Option<f64> {
    (!samples.is_empty()).then(|| Spread::of(samples).mean)
}

/// Returns the standard deviation of the distribution of `samples` (n − 1); `None` for fewer than two.
#[must_use]
pub fn standard_deviation(samples: &[f64]) -> Option<f64> {
    (samples.len() >= 2).then(|| Spread::of(samples).sd)
}

/// Waiting times until an event, of observations that may end before it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Waits(Vec<Option<u64>>);

impl Waits {
    /// Adds an observation: the wait, or `None` if the event did not happen.
    pub fn add(&mut self, wait: Option<u64>) {
        self.0.push(wait);
    }

    /// Returns the waits in the order they were added.
    pub fn iter(&self) -> impl Iterator<Item = Option<u64>> + '_ {
        self.0.iter().copied()
    }

    /// Returns the share of the observations with the event; `None` without observations.
    #[must_use]
    pub fn share(&self) -> Option<f64> {
        let happened = self.0.iter().flatten().count();
        (!self.0.is_empty()).then(|| happened as f64 / self.0.len() as f64)
    }

    /// Returns the nearest-rank percentile: the shortest time within which the event happened in `percent`
    /// of a hundred observations; `None` if it happened in fewer.
    ///
    /// An observation without the event counts as longer than every wait, so the median exists if half of
    /// them have the event.
    #[must_use]
    pub fn percentile(&self, percent: usize) -> Option<u64> {
        let mut waits = self.0.clone();
        waits.sort_unstable_by_key(|wait| wait.unwrap_or(u64::MAX));
        let rank = (waits.len() * percent).div_ceil(100).max(1);
        waits.get(rank - 1).copied().flatten()
    }

    /// Returns the median; see [`Self::percentile`].
    #[must_use]
    pub fn median(&self) -> Option<u64> {
        self.percentile(50)
    }
}

impl FromIterator<Option<u64>> for Waits {
    fn from_iter<I: IntoIterator<Item = Option<u64>>>(waits: I) -> Self {
        Self(waits.into_iter().collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_sample_has_no_spread() {
        let one = Spread::of(&[0.7]);
        assert_eq!((one.mean, one.sd), (0.7, 0.0));
        assert_eq!(standard_deviation(&[0.7]), None);
    }

    /// Student's t for 95 %, two-sided, as printed in tables.
    #[test]
    fn the_interval_is_students() {
        for (count, t) in [(2, 12.706), (3, 4.303), (20, 2.093), (200, 1.972)] {
            let samples: Vec<f64> = (0..count).map(f64::from).collect();
            let deviation = standard_deviation(&samples).unwrap();
            let estimate = Estimate::of(&samples).unwrap();
            let t_of_ours = estimate.half_width.unwrap() / deviation * f64::from(count).sqrt();
            assert!((t_of_ours - t).abs() < 1e-3, "{count}: {t_of_ours}");
            assert_eq!(estimate.mean, f64::from(count - 1) / 2.0);
        }
        assert_eq!(Estimate::of(&[]), None);
        assert_eq!(Estimate::of(&[3.0]).unwrap().half_width, None);
    }

    #[test]
    fn a_wait_without_event_is_longest() {
        let waits: Waits = [Some(5), None, Some(3), None].into_iter().collect();
        assert_eq!(waits.share(), Some(0.5));
        assert_eq!(waits.median(), Some(5));
        assert_eq!(waits.percentile(90), None);
        assert_eq!(waits.percentile(0), Some(3));
        let twenty: Waits = (1..=20).map(Some).collect();
        assert_eq!(
            [10, 50, 90].map(|part| twenty.percentile(part)),
            [2, 10, 18].map(Some)
        );
        assert_eq!(Waits::default().median(), None);
        assert_eq!(Waits::default().share(), None);
    }
}
