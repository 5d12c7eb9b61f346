//! Distinguishes *no object* from an echo by repeated samples.

use super::calibration::Calibration;
use super::reading::Reading;

/// Repeated samples of an infrared sensor in one direction (\[001\] §6.1).
///
/// The paper says that the byte of *no object* is hard to distinguish from a correct measurement, and
/// that an algorithm predicts the correct interpretation from the fluctuation of the measurements,
/// which works for some units and fails for others; it does not print the algorithm. *Assumed* here:
/// with an object in range the byte fluctuates by a count or two, without one by more, because the
/// unit then triangulates on noise. Measure whether a unit does so; one whose *no object* byte is
/// constant needs only its [`Calibration`].
///
/// Formula: the spread is the shortest span that holds all bytes but a quarter of them, rounded
/// down. If it is above the limit there is no object, else the echo is the median of all samples. So
/// with four or more samples a single outlier changes nothing, whatever its value.
///
/// `SAMPLES` is odd and at least 3, so that the median is a byte that was sampled; other numbers do
/// not build. More samples separate better: at a limit of 3, noise that is uniform over 13 counts
/// passes for an echo in 22 % of all cases with 5 samples and in 4 % with 9. They take time: a GP2D02
/// takes 70 ms a sample.
///
/// Memory: `SAMPLES` bytes and two words. Cost: some `SAMPLES`³ / 2 comparisons to evaluate, one store
/// to add a sample.
///
/// ```
/// use certainty_core::transducer::{Fluctuation, Steadiness};
///
/// let mut samples = Fluctuation::<5>::new(3);
/// for raw in [88, 89, 88, 160, 87] {
///     samples.push(raw); // one outlier
/// }
/// assert_eq!(samples.steadiness(), Some(Steadiness::Echo { raw: 88 }));
///
/// samples.clear();
/// for raw in [75, 83, 70, 78, 66] {
///     samples.push(raw);
/// }
/// assert_eq!(samples.steadiness(), Some(Steadiness::NoObject { spread: 12 }));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Fluctuation<const SAMPLES: usize> {
    samples: [u8; SAMPLES],
    /// Index of the next sample; `full` once all elements are set.
    next: usize,
    full: bool,
    limit: u8,
}

/// The result of repeated samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Steadiness {
    /// They agree on one byte.
    Echo {
        /// The median.
        raw: u8,
    },
    /// They fluctuate: there is no object in range.
    NoObject {
        /// By how many counts, outliers excluded.
        spread: u8,
    },
}

impl<const SAMPLES: usize> Fluctuation<SAMPLES> {
    /// Creates it without samples. Bytes that differ by more than `limit` counts, outliers excluded,
    /// mean *no object*.
    #[must_use]
    pub const fn new(limit: u8) -> Self {
        const {
            assert!(
                SAMPLES >= 3 && SAMPLES % 2 == 1,
                "SAMPLES must be odd, 3 or more"
            );
        };
        Self {
            samples: [0; SAMPLES],
            next: 0,
            full: false,
            limit,
        }
    }

    /// Adds a sample; it replaces the oldest once there are `SAMPLES`.
    pub fn push(&mut self, raw: u8) {
        if let Some(sample) = self.samples.get_mut(self.next) {
            *sample = raw;
        }
        self.next = self.next.wrapping_add(1);
        if self.next >= SAMPLES {
            self.next = 0;
            self.full = true;
        }
    }

    /// Removes all samples, before the sensor turns to the next direction.
    pub const fn clear(&mut self) {
        self.next = 0;
        self.full = false;
    }

    /// Returns the result; `None` before there are `SAMPLES`.
    #[must_use]
    pub fn steadiness(&self) -> Option<Steadiness> {
        if !self.full {
            return None;
        }
        let outliers = SAMPLES / 4;
        let others = SAMPLES.wrapping_sub(1).wrapping_sub(outliers);
        let spread = (0..=outliers)
            .filter_map(|lowest| {
                let highest = self.ranked(lowest.wrapping_add(others))?;
                Some(highest.saturating_sub(self.ranked(lowest)?)) // sorted: never below zero
            })
            .min()?;
        Some(if spread > self.limit {
            Steadiness::NoObject { spread }
        } else {
            let raw = self.ranked(SAMPLES / 2)?;
            Steadiness::Echo { raw }
        })
    }

    /// Returns the reading by this unit's calibration; `None` before there are `SAMPLES`.
    ///
    /// Steady samples still give *no object* if the calibration does so for their median.
    #[must_use]
    pub fn reading(&self, calibration: &Calibration) -> Option<Reading> {
        Some(match self.steadiness()? {
            Steadiness::Echo { raw } => calibration.reading(raw),
            Steadiness::NoObject { .. } => Reading::NoObject,
        })
    }

    /// The byte that would be at `rank`, from 0, if the samples were sorted.
    fn ranked(&self, rank: usize) -> Option<u8> {
        self.samples.iter().copied().find(|candidate| {
            let (below, upto) = self
                .samples
                .iter()
                .fold((0_usize, 0_usize), |(b, u), sample| {
                    (
                        b.wrapping_add(usize::from(sample < candidate)),
                        u.wrapping_add(usize::from(sample <= candidate)),
                    )
                });
            below <= rank && rank < upto
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transducer::Missing;
    use crate::units::Millimeters;
    use fixed::types::U8F8;
    use proptest::prelude::*;

    fn of<const SAMPLES: usize>(limit: u8, bytes: [u8; SAMPLES]) -> Steadiness {
        let mut samples = Fluctuation::<SAMPLES>::new(limit);
        for raw in bytes {
            assert_eq!(samples.steadiness(), None, "too few samples");
            samples.push(raw);
        }
        samples.steadiness().unwrap()
    }

    /// The same by sorting.
    fn naive<const SAMPLES: usize>(limit: u8, mut bytes: [u8; SAMPLES]) -> Steadiness {
        bytes.sort_unstable();
        let kept = bytes.windows(SAMPLES - SAMPLES / 4);
        let spread = kept.map(|w| w[w.len() - 1] - w[0]).min().unwrap();
        if spread > limit {
            Steadiness::NoObject { spread }
        } else {
            Steadiness::Echo {
                raw: bytes[SAMPLES / 2],
            }
        }
    }

    /// All sequences of five bytes out of `values` above 70; how many of them pass for an echo.
    fn echoes_of_all(values: u32) -> f64 {
        let all = values.pow(5);
        let mut echoes = 0;
        for mut code in 0..all {
            let bytes: [u8; 5] = core::array::from_fn(|_| {
                let digit = code % values;
                code /= values;
                70 + digit as u8
            });
            let steadiness = of(3, bytes);
            assert_eq!(steadiness, naive(3, bytes), "{bytes:?}");
            echoes += u32::from(matches!(steadiness, Steadiness::Echo { .. }));
        }
        f64::from(echoes) / f64::from(all)
    }

    #[test]
    fn bytes_within_two_counts_are_always_an_echo() {
        assert_eq!(echoes_of_all(3), 1.0);
    }

    /// The probability that some `kept` of `samples` uniform numbers lie within `width` of each other,
    /// a part of the whole: Naus' scan statistic for more than half of them.
    fn scan(samples: i32, kept: i32, width: f64) -> f64 {
        let choose =
            |of: i32, n: i32| (1..=n).fold(1.0, |p, i| p * f64::from(of - n + i) / f64::from(i));
        let exactly = |n: i32| choose(samples, n) * width.powi(n) * (1.0 - width).powi(samples - n);
        let at_least: f64 = (kept..=samples).map(exactly).sum();
        2.0 * at_least + (f64::from(kept) / width - f64::from(samples) - 1.0) * exactly(kept)
    }

    /// Counts of 0..=3 are steady: a span of 3.5 of the 13 that noise covers.
    #[test]
    fn noise_passes_as_often_as_scan_statistics_predict() {
        let five = echoes_of_all(13);
        let expected = scan(5, 4, 3.5 / 13.0);
        assert!((five - expected).abs() < 0.01, "{five} vs {expected}");
        assert!((0.21..0.23).contains(&five), "{five}");

        let mut state = 1_u32;
        let mut noise = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            70 + ((u64::from(state) * 13) >> 32) as u8
        };
        let cases = 100_000;
        let echoes = (0..cases)
            .filter(|_| {
                let bytes: [u8; 9] = core::array::from_fn(|_| noise());
                matches!(of(3, bytes), Steadiness::Echo { .. })
            })
            .count();
        let nine = echoes as f64 / f64::from(cases);
        let expected = scan(9, 7, 3.5 / 13.0);
        assert!((nine - expected).abs() < 0.01, "{nine} vs {expected}");
        assert!((0.035..0.045).contains(&nine), "{nine}");
    }

    #[test]
    fn one_outlier_of_five_changes_nothing() {
        for outlier in 0..=u8::MAX {
            let steadiness = of(3, [88, 89, outlier, 88, 87]);
            assert!(
                matches!(steadiness, Steadiness::Echo { raw: 87..=89 }),
                "{outlier}"
            );
        }
        assert_eq!(
            of(3, [60, 70, 80, 90, 80]),
            Steadiness::NoObject { spread: 20 }
        );
    }

    #[test]
    fn the_window_slides_and_is_cleared() {
        let mut samples = Fluctuation::<3>::new(2);
        for raw in [10, 200, 90, 91, 92] {
            samples.push(raw);
        }
        assert_eq!(samples.steadiness(), Some(Steadiness::Echo { raw: 91 }));
        samples.clear();
        assert_eq!(samples.steadiness(), None);
    }

    #[test]
    fn only_steady_samples_are_calibrated() {
        let mm = Millimeters::new;
        let floor = U8F8::lit("60");
        let unit = Calibration::try_new(13_000, mm(0), floor, mm(100), mm(800)).unwrap();
        let reading = |bytes: [u8; 3]| {
            let mut samples = Fluctuation::<3>::new(2);
            for raw in bytes {
                samples.push(raw);
            }
            samples
                .reading(&unit)
                .unwrap_or(Reading::Missing(Missing::Timeout))
        };
        assert_eq!(reading([86, 85, 87]), Reading::Echo(mm(500)));
        assert_eq!(reading([86, 81, 87]), Reading::NoObject);
        assert_eq!(reading([60, 60, 60]), Reading::NoObject);
    }

    proptest! {
        #[test]
        fn the_result_is_that_of_sorted_samples(bytes: [u8; 9], few: [u8; 3], limit: u8) {
            prop_assert_eq!(of(limit, bytes), naive(limit, bytes));
            prop_assert_eq!(of(limit, few), naive(limit, few));
        }
    }
}
