//! The six figures of Table 2 and their comparison with the printed ones.

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

    /// The names of the figures, in their order.
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

    /// Creates the figures from the scores of [`PRINTED_METHODS`].
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

    /// Returns which figures are reproduced: within [`Self::NEAR`] of the printed ones.
    #[must_use]
    pub fn near(&self) -> [bool; 6] {
        self.ratios().map(|ratio| (ratio - 1.0).abs() <= Self::NEAR)
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

/// Returns a ratio or its inverse, whichever is 1 or more.
pub(super) fn factor(ratio: f64) -> f64 {
    ratio.max(1.0 / ratio)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_printed_figures_are_near_and_in_order() {
        let printed = Figures::PRINTED;
        assert_eq!(printed.near(), [true; 6]);
        assert!(printed.in_the_papers_order());
    }

    #[test]
    fn a_factor_is_1_or_more_either_way() {
        assert_eq!([factor(0.25), factor(3.0), factor(1.0)], [4.0, 3.0, 1.0]);
        assert_eq!(factor(0.0), f64::INFINITY);
        let mut off = Figures::PRINTED;
        off.0[3] = 0.003; // a quarter
        off.0[0] = 0.303; // three times
        assert_eq!(off.near(), [false, true, true, false, true, true]);
    }

    #[test]
    fn near_is_a_quarter_more_or_less() {
        let scaled = |by: f64| Figures(Figures::PRINTED.0.map(|figure| figure * by)).near();
        assert_eq!([scaled(0.76), scaled(1.24)], [[true; 6]; 2]);
        assert_eq!([scaled(0.74), scaled(1.26)], [[false; 6]; 2]);
    }

    #[test]
    fn the_order_holds_by_mae_and_mse() {
        let mut mixed = Figures::PRINTED;
        mixed.0[5] = 0.013; // the median's MSE above the robust grid's
        assert!(!mixed.in_the_papers_order());
    }
}
