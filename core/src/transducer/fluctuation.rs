//! Telling *no object* from an echo by repeated looks.

use super::calibration::Calibration;
use super::reading::Reading;

/// Repeated looks of an infrared sensor in one direction (\[001\] §6.1).
///
/// The paper says that the byte of *no object* is hard to tell from a correct measurement, and that
/// an algorithm predicts the correct interpretation from how measurements fluctuate, which works
/// for particular units and fails for others; it does not print the algorithm. What is *assumed*
/// here: with an object in range the byte fluctuates by a count or two, without one by more,
/// because the unit then triangulates on noise. Whether a unit does so must be measured; one whose
/// silent byte is constant needs its [`Calibration`] and not this.
///
/// Formula: the spread is the shortest span that holds all bytes but a quarter of them, rounded
/// down; if it is above the limit there is no object, else there is one at the median of all. So of
/// four or more looks a single outlier changes nothing, wherever it lies.
///
/// `LOOKS` is odd and at least 3, so that the median is a byte that was seen; other numbers do not
/// build. It pays to take many: at a limit of 3, noise that is uniform over 13 counts passes for an
/// echo in 22 % of all cases with 5 looks and in 4 % with 9. The price is time: a GP2D02 takes
/// 70 ms a look.
///
/// Memory: `LOOKS` bytes and two words. Cost: some `LOOKS`³ / 2 comparisons to judge, one store to
/// take a look.
///
/// ```
/// use certainty_core::transducer::{Fluctuation, Steadiness};
///
/// let mut looks = Fluctuation::<5>::new(3);
/// for raw in [88, 89, 88, 160, 87] {
///     looks.push(raw); // one outlier
/// }
/// assert_eq!(looks.steadiness(), Some(Steadiness::Echo { raw: 88 }));
///
/// looks.clear();
/// for raw in [75, 83, 70, 78, 66] {
///     looks.push(raw);
/// }
/// assert_eq!(looks.steadiness(), Some(Steadiness::NoObject { spread: 12 }));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Fluctuation<const LOOKS: usize> {
    looks: [u8; LOOKS],
    /// Where the next look goes; `full` once all places are taken.
    next: usize,
    full: bool,
    limit: u8,
}

/// What repeated looks come to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Steadiness {
    /// They agree on this byte.
    Echo {
        /// The median.
        raw: u8,
    },
    /// They fluctuate: there is no object in range.
    NoObject {
        /// By how many counts, outliers apart.
        spread: u8,
    },
}

impl<const LOOKS: usize> Fluctuation<LOOKS> {
    /// Creates it without looks. Bytes that differ by more than `limit` counts, outliers apart, are
    /// no object.
    #[must_use]
    pub const fn new(limit: u8) -> Self {
        const { assert!(LOOKS >= 3 && LOOKS % 2 == 1, "LOOKS must be odd, 3 or more") };
        Self {
            looks: [0; LOOKS],
            next: 0,
            full: false,
            limit,
        }
    }

    /// Takes the byte of one look; when there are `LOOKS` already, in place of the oldest.
    pub fn push(&mut self, raw: u8) {
        if let Some(look) = self.looks.get_mut(self.next) {
            *look = raw;
        }
        self.next = self.next.wrapping_add(1);
        if self.next >= LOOKS {
            self.next = 0;
            self.full = true;
        }
    }

    /// Forgets all looks: for the next direction.
    pub const fn clear(&mut self) {
        self.next = 0;
        self.full = false;
    }

    /// Returns what the looks come to; `None` before there are `LOOKS`.
    #[must_use]
    pub fn steadiness(&self) -> Option<Steadiness> {
        if !self.full {
            return None;
        }
        let outliers = LOOKS / 4;
        let others = LOOKS.wrapping_sub(1).wrapping_sub(outliers);
        let spread = (0..=outliers)
            .filter_map(|lowest| {
                let highest = self.ranked(lowest.wrapping_add(others))?;
                Some(highest.saturating_sub(self.ranked(lowest)?)) // sorted: never below zero
            })
            .min()?;
        Some(if spread > self.limit {
            Steadiness::NoObject { spread }
        } else {
            let raw = self.ranked(LOOKS / 2)?;
            Steadiness::Echo { raw }
        })
    }

    /// Returns what the looks say by this unit's calibration; `None` before there are `LOOKS`.
    ///
    /// Steady looks can still be no object: if the calibration says so of their median.
    #[must_use]
    pub fn reading(&self, calibration: &Calibration) -> Option<Reading> {
        Some(match self.steadiness()? {
            Steadiness::Echo { raw } => calibration.reading(raw),
            Steadiness::NoObject { .. } => Reading::NoObject,
        })
    }

    /// The byte that would be at `rank`, from 0, if the looks were sorted.
    fn ranked(&self, rank: usize) -> Option<u8> {
        self.looks.iter().copied().find(|candidate| {
            let (below, upto) = self.looks.iter().fold((0_usize, 0_usize), |(b, u), look| {
                (
                    b.wrapping_add(usize::from(look < candidate)),
                    u.wrapping_add(usize::from(look <= candidate)),
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

    fn of<const LOOKS: usize>(limit: u8, bytes: [u8; LOOKS]) -> Steadiness {
        let mut looks = Fluctuation::<LOOKS>::new(limit);
        for raw in bytes {
            assert_eq!(looks.steadiness(), None, "too few to say");
            looks.push(raw);
        }
        looks.steadiness().unwrap()
    }

    /// Sorts.
    fn naive<const LOOKS: usize>(limit: u8, mut bytes: [u8; LOOKS]) -> Steadiness {
        bytes.sort_unstable();
        let kept = bytes.windows(LOOKS - LOOKS / 4);
        let spread = kept.map(|w| w[w.len() - 1] - w[0]).min().unwrap();
        if spread > limit {
            Steadiness::NoObject { spread }
        } else {
            Steadiness::Echo {
                raw: bytes[LOOKS / 2],
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
            let verdict = of(3, bytes);
            assert_eq!(verdict, naive(3, bytes), "{bytes:?}");
            echoes += u32::from(matches!(verdict, Steadiness::Echo { .. }));
        }
        f64::from(echoes) / f64::from(all)
    }

    #[test]
    fn an_object_that_moves_the_byte_by_one_either_way_is_always_seen() {
        assert_eq!(echoes_of_all(3), 1.0);
    }

    /// How likely `looks` uniform numbers have some `kept` of them within `width` of each other,
    /// as a part of the whole: Naus' scan statistic for more than half of them.
    fn scan(looks: i32, kept: i32, width: f64) -> f64 {
        let choose =
            |of: i32, n: i32| (1..=n).fold(1.0, |p, i| p * f64::from(of - n + i) / f64::from(i));
        let exactly = |n: i32| choose(looks, n) * width.powi(n) * (1.0 - width).powi(looks - n);
        let at_least: f64 = (kept..=looks).map(exactly).sum();
        2.0 * at_least + (f64::from(kept) / width - f64::from(looks) - 1.0) * exactly(kept)
    }

    /// Counts of 0..=3 are steady: a span of 3.5 of the 13 that noise covers.
    #[test]
    fn noise_passes_for_an_object_as_often_as_scan_statistics_say() {
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
    fn one_outlier_of_five_hides_no_object_and_makes_none() {
        for outlier in 0..=u8::MAX {
            let verdict = of(3, [88, 89, outlier, 88, 87]);
            assert!(
                matches!(verdict, Steadiness::Echo { raw: 87..=89 }),
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
        let mut looks = Fluctuation::<3>::new(2);
        for raw in [10, 200, 90, 91, 92] {
            looks.push(raw);
        }
        assert_eq!(looks.steadiness(), Some(Steadiness::Echo { raw: 91 }));
        looks.clear();
        assert_eq!(looks.steadiness(), None);
    }

    #[test]
    fn steady_looks_are_read_by_the_calibration_and_others_are_no_object() {
        let mm = Millimeters::new;
        let floor = U8F8::lit("60");
        let unit = Calibration::try_new(13_000, mm(0), floor, mm(100), mm(800)).unwrap();
        let reading = |bytes: [u8; 3]| {
            let mut looks = Fluctuation::<3>::new(2);
            for raw in bytes {
                looks.push(raw);
            }
            looks
                .reading(&unit)
                .unwrap_or(Reading::Missing(Missing::Timeout))
        };
        assert_eq!(reading([86, 85, 87]), Reading::Echo(mm(500)));
        assert_eq!(reading([86, 81, 87]), Reading::NoObject);
        assert_eq!(reading([60, 60, 60]), Reading::NoObject);
    }

    proptest! {
        #[test]
        fn the_ranks_are_those_of_sorted_looks(bytes: [u8; 9], few: [u8; 3], limit: u8) {
            prop_assert_eq!(of(limit, bytes), naive(limit, bytes));
            prop_assert_eq!(of(limit, few), naive(limit, few));
        }
    }
}
