//! One choice at a time.

use super::{Candidate, Family, means};
use crate::table2::{Alternative, CHOICES, Choices, Figures, factor};

/// The primary set-up, or one that departs from it in a single choice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Neighbour {
    /// What departs, and to what; nothing in the primary set-up.
    pub departure: Option<(&'static str, Alternative)>,
    /// What it comes to.
    pub figures: Figures,
    /// The figure that moves most from the primary set-up's, as a place in [`Figures::NAMES`], and its
    /// ratio to it.
    pub moved_most: Option<(usize, f64)>,
}

/// Every set-up of [`neighbours`]: the primary one first.
fn departures() -> Vec<(Option<(&'static str, Alternative)>, Choices)> {
    let mut all = vec![(None, Choices::PRIMARY)];
    for choice in CHOICES {
        all.extend((1..choice.alternatives).map(|place| {
            let departure = Some((choice.name, choice.alternative(place)));
            (departure, choice.choose(Choices::PRIMARY, place))
        }));
    }
    all
}

/// Returns how often [`neighbours`] reports a step.
#[must_use]
pub fn neighbours_steps(worlds: u32) -> u64 {
    departures().len() as u64 * u64::from(worlds)
}

/// Returns the primary set-up and all that depart from it in one choice, each in `worlds` worlds;
/// `done` hears of each.
pub fn neighbours(seed: u64, worlds: u32, done: impl Fn() + Sync) -> Vec<Neighbour> {
    let departures = departures();
    let alone = |&(_, choices): &(_, Choices)| Family {
        members: vec![choices],
    };
    let families: Vec<_> = departures.iter().map(alone).collect();
    let candidates = means(&families, seed, 0..worlds, &done);
    let Some(&Candidate {
        figures: primary, ..
    }) = candidates.first()
    else {
        return Vec::new();
    };
    let told = departures.into_iter().zip(candidates);
    let told = told.map(|((departure, _), candidate)| {
        let ratios = candidate.figures.over(&primary).into_iter().enumerate();
        let most = ratios.max_by(|a, b| factor(a.1).total_cmp(&factor(b.1)));
        Neighbour {
            departure,
            figures: candidate.figures,
            moved_most: departure.and(most),
        }
    });
    told.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hard_evidence_moves_bayes_and_nothing_else() {
        let all = neighbours(1, 2, || {});
        let primary = all[0].figures.values();
        let hard = all.iter().find(|each| {
            each.departure
                .is_some_and(|(choice, to)| (choice, to.name) == ("evidence", "hard"))
        });
        let hard = hard.unwrap();
        assert_eq!(hard.figures.values()[2..], primary[2..]);
        let (figure, ratio) = hard.moved_most.unwrap();
        assert!(figure < 2);
        assert_eq!(ratio, hard.figures.values()[figure] / primary[figure]);
        assert_eq!(all[0].moved_most, None);
    }
}
