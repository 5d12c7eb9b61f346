//! Which failures explain what is suspected.

use super::super::failures::Failure;
use super::super::motion::{scaled, share};
use super::super::{Effort, Failures, PerRangefinder, RANGEFINDERS};

/// How often sensors contradicted each other and the map, lately: above 0 more than they agreed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Suspicions {
    /// `x_i`: each rangefinder and the scanner.
    pub(super) of_pairs: PerRangefinder<i16>,
    /// `y_i`: each rangefinder and the map.
    pub(super) of_rangefinders: PerRangefinder<i16>,
    /// `z`: the scanner and the map.
    pub(super) of_scanner: i16,
}

/// Which failures explain what was observed so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Standing {
    rangefinders: PerRangefinder<bool>,
    scanner: bool,
}

impl Standing {
    pub(super) const NOBODY: Self = Self {
        rangefinders: [false; RANGEFINDERS],
        scanner: false,
    };

    /// Takes in who has failed by three quarters, and lets go of who has by less than a quarter.
    pub(super) fn settle(&mut self, failures: &Failures) {
        const QUARTER: Effort = Effort::lit("0.25");
        let own = self.rangefinders.iter_mut().chain([&mut self.scanner]);
        let all = failures.rangefinders.iter().chain([&failures.scanner]);
        for (stands, failure) in own.zip(all) {
            *stands = if *stands {
                failure.part() >= QUARTER
            } else {
                failure.left() <= QUARTER
            };
        }
    }
}

impl Suspicions {
    pub(super) const NONE: Self = Self {
        of_pairs: [0; RANGEFINDERS],
        of_rangefinders: [0; RANGEFINDERS],
        of_scanner: 0,
    };

    /// The formula of [`CrossCheck::failures`](super::CrossCheck::failures).
    pub(super) fn explained(&self, standing: &Standing, unlikely: u8) -> Failures {
        let cost = i32::from(unlikely);
        let of_new_or_old = |stands: bool| if stands { cost >> 1 } else { cost };
        let sum = |values: &PerRangefinder<i32>| {
            let values = values.iter();
            values.fold(0_i32, |sum, &value| sum.saturating_add(value))
        };
        let excess = |suspicions: &PerRangefinder<i32>| {
            let mut excess = *suspicions;
            for (excess, stands) in excess.iter_mut().zip(standing.rangefinders) {
                *excess = excess.saturating_sub(of_new_or_old(stands)).max(0);
            }
            excess
        };
        let alone = self.of_rangefinders.map(i32::from);
        let mut both = self.of_pairs.map(i32::from);
        for (both, &alone) in both.iter_mut().zip(&alone) {
            *both = both.saturating_add(alone);
        }
        let (besides, instead) = (excess(&alone), excess(&both));
        let scanner = sum(&self.of_pairs.map(i32::from))
            .saturating_add(self.of_scanner.into())
            .saturating_sub(of_new_or_old(standing.scanner));
        let lead = scanner
            .saturating_add(sum(&besides))
            .saturating_sub(sum(&instead));
        let blame = share(lead.saturating_add(cost), cost.saturating_mul(2));
        let rest = Effort::ONE.saturating_sub(blame);
        let mut failures = Failures {
            scanner: Failure::new_saturating(scaled(blame, share(scanner, cost))),
            ..Failures::NONE
        };
        let over = besides.into_iter().zip(instead);
        for (failure, (besides, instead)) in failures.rangefinders.iter_mut().zip(over) {
            let with = scaled(blame, share(besides, cost));
            let without = scaled(rest, share(instead, cost));
            *failure = Failure::new_saturating(with.saturating_add(without));
        }
        failures
    }
}
