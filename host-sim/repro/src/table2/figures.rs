//! The six figures of Table 2, and how far others are from them.

use super::Choices;
use certainty_sim::fusion::Method;
use certainty_sim::simulation::Score;

/// The methods of \[001\] Table 2, in its order.
pub const PRINTED_METHODS: [Method; 3] = [Method::Bayes, Method::Robust, Method::Median];

/// MAE and MSE of Bayesian fusion, the robust and the fault-tolerant (median) certainty grid.
///
/// Units: certainties of 0 to 1, as in [`Score`]; the paper prints thousandths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figures([f64; 6]);

impl Figures {
    /// What Table 2 of \[001\] prints.
    pub const PRINTED: Self = Self([0.101, 0.069, 0.022, 0.012, 0.009, 0.006]);

    /// What the figures are called, in their order.
    pub const NAMES: [&'static str; 6] = [
        "bayes MAE",
        "bayes MSE",
        "robust MAE",
        "robust MSE",
        "median MAE",
        "median MSE",
    ];

    /// How near a figure must be to count as reproduced: within a quarter of the printed one.
    pub const NEAR: f64 = 0.25;

    pub(super) const ZERO: Self = Self([0.0; 6]);

    /// Takes them from the scores of [`PRINTED_METHODS`].
    #[must_use]
    pub fn of(scores: [&Score; 3]) -> Self {
        let [bayes, robust, median] = scores;
        Self([
            bayes.mae, bayes.mse, robust.mae, robust.mse, median.mae, median.mse,
        ])
    }

    /// Returns them in the order of [`Self::NAMES`].
    #[must_use]
    pub const fn values(&self) -> [f64; 6] {
        self.0
    }

    /// Returns each divided by the printed one.
    #[must_use]
    pub fn ratios(&self) -> [f64; 6] {
        self.over(&Self::PRINTED)
    }

    /// Returns each divided by that of `other`.
    #[must_use]
    pub fn over(&self, other: &Self) -> [f64; 6] {
        core::array::from_fn(|n| self.0[n] / other.0[n])
    }

    /// Returns which are reproduced.
    #[must_use]
    pub fn near(&self) -> [bool; 6] {
        self.ratios().map(|ratio| (ratio - 1.0).abs() <= Self::NEAR)
    }

    /// Returns the factor, 1 or more, that the farthest of them is off the printed one.
    ///
    /// Formula: exp(max |ln(ours/printed)|); ∞ where a figure is 0.
    #[must_use]
    pub fn worst_factor(&self) -> f64 {
        self.ratios().map(factor).into_iter().fold(1.0, f64::max)
    }

    /// Returns whether they are in the paper's order, by MAE and by MSE: median below robust below
    /// Bayes.
    #[must_use]
    pub fn in_the_papers_order(&self) -> bool {
        let [bayes, robust, median] = [0, 2, 4].map(|n| (self.0[n], self.0[n + 1]));
        let below = |a: (f64, f64), b: (f64, f64)| a.0 < b.0 && a.1 < b.1;
        below(median, robust) && below(robust, bayes)
    }

    pub(super) fn plus(&self, other: &Self) -> Self {
        Self(core::array::from_fn(|n| self.0[n] + other.0[n]))
    }

    pub(super) fn divided(&self, count: u32) -> Self {
        Self(self.0.map(|sum| sum / f64::from(count)))
    }
}

/// A ratio as a factor of 1 or more, whichever way it points.
#[must_use]
pub fn factor(ratio: f64) -> f64 {
    ratio.max(1.0 / ratio)
}

/// A set-up with its figures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// The set-up.
    pub choices: Choices,
    /// What it comes to.
    pub figures: Figures,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_printed_figures_are_near_themselves_and_in_order() {
        let printed = Figures::PRINTED;
        assert_eq!(printed.worst_factor(), 1.0);
        assert_eq!(printed.near(), [true; 6]);
        assert!(printed.in_the_papers_order());
    }

    #[test]
    fn the_farthest_figure_counts_whichever_way_it_is_off() {
        let mut off = Figures::PRINTED;
        off.0[3] = 0.003; // a quarter
        off.0[0] = 0.303; // three times
        assert!((off.worst_factor() - 4.0).abs() < 1e-12);
        assert_eq!(off.near(), [false, true, true, false, true, true]);
        off.0[3] = 0.0;
        assert_eq!(off.worst_factor(), f64::INFINITY);
    }

    #[test]
    fn near_is_a_quarter_more_or_less() {
        let scaled = |by: f64| Figures(Figures::PRINTED.0.map(|figure| figure * by)).near();
        assert_eq!([scaled(0.76), scaled(1.24)], [[true; 6]; 2]);
        assert_eq!([scaled(0.74), scaled(1.26)], [[false; 6]; 2]);
    }

    #[test]
    fn the_order_must_hold_by_both_figures() {
        let mut mixed = Figures::PRINTED;
        mixed.0[5] = 0.013; // the median's MSE above the robust grid's
        assert!(!mixed.in_the_papers_order());
    }
}
