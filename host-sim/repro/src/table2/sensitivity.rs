//! Which factors decide Table 2: the primary set-up with one level changed at a time.

use super::factors::{EvaluationSetup, FACTORS, Level};
use super::figures::{Figures, PRINTED_METHODS, factor};
use super::repetition::{Estimator, Metric, Oracles, Repetition};
use rayon::iter::{IntoParallelIterator, ParallelIterator};

/// The primary set-up, or one that differs from it in a single level.
#[derive(Debug, Clone, Copy)]
pub struct Variation {
    /// The factor's name and its level; none for the primary set-up.
    pub change: Option<(&'static str, &'static Level)>,
    /// The mean figures over the worlds.
    pub figures: Figures,
    /// The figure with the largest ratio to the primary set-up's, as an index of [`Figures::NAMES`], and
    /// that ratio.
    pub moved_most: Option<(usize, f64)>,
}

/// Every changed level, after none for the primary set-up.
fn changes() -> impl Iterator<Item = Option<(&'static str, &'static Level)>> {
    let of_factors = FACTORS.iter().flat_map(|factor| {
        let levels = factor.levels[1..].iter();
        levels.map(|level| Some((factor.name, level)))
    });
    core::iter::once(None).chain(of_factors)
}

/// Returns how many steps [`variations`] reports.
#[must_use]
pub fn variations_steps(worlds: u32) -> u64 {
    changes().count() as u64 * u64::from(worlds)
}

/// Returns the primary set-up and all that differ from it in one level, each in `worlds` worlds; calls
/// `done` after each world of each.
pub fn variations(seed: u64, worlds: u32, done: impl Fn() + Sync) -> Vec<Variation> {
    let figures = changes().map(|change| {
        let setup = match change {
            Some((_, level)) => EvaluationSetup::PRIMARY.with(level),
            None => EvaluationSetup::PRIMARY,
        };
        (change, mean_figures(&setup, seed, worlds, &done))
    });
    let mut variations: Vec<Variation> = Vec::new();
    for (change, figures) in figures {
        let moved_most = variations.first().and_then(|primary| {
            let ratios = figures.over(&primary.figures).into_iter().enumerate();
            ratios.max_by(|a, b| factor(a.1).total_cmp(&factor(b.1)))
        });
        variations.push(Variation {
            change,
            figures,
            moved_most,
        });
    }
    variations
}

/// The printed methods' mean figures of a set-up, summed in the order of the worlds.
fn mean_figures(
    setup: &EvaluationSetup,
    seed: u64,
    worlds: u32,
    done: &(impl Fn() + Sync),
) -> Figures {
    let estimators = PRINTED_METHODS.map(Estimator::Method);
    let metrics = [Metric::of(setup)];
    let oracles = Oracles::default(); // no estimator needs one
    let each = (0..worlds).into_par_iter().map(|number| {
        let scores = Repetition::run(setup, &oracles, &estimators, &metrics, seed, number).scores;
        done();
        Figures::of([0, 1, 2].map(|place| &scores[place]))
    });
    let each: Vec<Figures> = each.collect();
    let sum = each
        .iter()
        .fold(Figures::ZERO, |sum, world| sum.plus(world));
    sum.divided(worlds.max(1))
}

#[cfg(test)]
mod tests {
    use super::super::evaluation::Evaluation;
    use super::*;

    #[test]
    fn a_variation_has_the_figures_of_its_setup() {
        let all = variations(4, 3, || {});
        for variation in all.iter().filter(|each| {
            let name = each.change.map(|(_, level)| level.name);
            name.is_none_or(|name| name == "hard")
        }) {
            let setup = match variation.change {
                Some((_, level)) => EvaluationSetup::PRIMARY.with(level),
                None => EvaluationSetup::PRIMARY,
            };
            let alone = Evaluation::run(setup, 4, 3, || {});
            assert_eq!(variation.figures, alone.figures());
        }
    }

    #[test]
    fn hard_evidence_moves_bayes_and_nothing_else() {
        let all = variations(1, 2, || {});
        let primary = all[0].figures.values();
        let hard = all.iter().find(|each| {
            each.change
                .is_some_and(|(factor, level)| (factor, level.name) == ("evidence", "hard"))
        });
        let hard = hard.unwrap();
        assert_eq!(hard.figures.values()[2..], primary[2..]);
        let (figure, ratio) = hard.moved_most.unwrap();
        assert!(figure < 2);
        assert_eq!(ratio, hard.figures.values()[figure] / primary[figure]);
        assert_eq!(all[0].moved_most, None);
    }

    #[test]
    fn every_world_of_every_variation_is_one_step() {
        use core::sync::atomic::{AtomicU64, Ordering::Relaxed};
        let done = AtomicU64::new(0);
        let count = || {
            done.fetch_add(1, Relaxed);
        };
        let all = variations(2, 1, count);
        assert_eq!(done.load(Relaxed), variations_steps(1));
        assert_eq!(all.len() as u64, variations_steps(1));
    }
}
