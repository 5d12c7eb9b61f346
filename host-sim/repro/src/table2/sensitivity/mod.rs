//! Which of the open choices decide Table 2.
//!
//! [`neighbours`] departs from the primary set-up in one choice at a time; [`Search`] asks whether any
//! set-up that the text allows comes near all six printed figures.

mod neighbours;
mod search;

pub use neighbours::{Neighbour, neighbours, neighbours_steps};
pub use search::{BestGiven, Effort, Search};

use super::{Candidate, Choices, Figures, Measure, PRINTED_METHODS, Teller, repetition};
use core::ops::Range;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

/// Set-ups that differ only in what is done with readings that are taken and interpreted.
///
/// They share those readings, and the maps that they make alike.
#[derive(Debug, Clone, PartialEq)]
struct Family {
    members: Vec<Choices>,
}

impl Family {
    /// The figures of every member in the world `number`.
    fn figures(&self, seed: u64, number: u32) -> Vec<Figures> {
        let Some(first) = self.members.first() else {
            return Vec::new();
        };
        let mut tellers = Vec::new();
        let mut measures = Vec::new();
        let places: Vec<_> = (self.members.iter())
            .map(|member| {
                let told = PRINTED_METHODS
                    .map(|method| place_of(Teller::new(method, member), &mut tellers));
                (told, place_of(Measure::of(member), &mut measures))
            })
            .collect();
        let scores = repetition(first, &tellers, &measures, seed, number).scores;
        let figures = places.into_iter().map(|(told, measure)| {
            Figures::of(told.map(|teller| &scores[teller * measures.len() + measure]))
        });
        figures.collect()
    }
}

/// Where `wanted` is listed, now if not before.
fn place_of<T: PartialEq>(wanted: T, listed: &mut Vec<T>) -> usize {
    let place = listed.iter().position(|each| *each == wanted);
    place.unwrap_or_else(|| {
        listed.push(wanted);
        listed.len() - 1
    })
}

/// Every member of every family with its mean over the `worlds`, in order.
///
/// `done` hears of each family and world.
fn means(
    families: &[Family],
    seed: u64,
    worlds: Range<u32>,
    done: &(impl Fn() + Sync),
) -> Vec<Candidate> {
    let summed = (0..families.len()).into_par_iter().map(|place| {
        let family = &families[place];
        let each = worlds.clone().into_par_iter().map(|number| {
            let figures = family.figures(seed, number);
            done();
            figures
        });
        let each: Vec<_> = each.collect();
        let members = family.members.iter().enumerate();
        let means = members.map(|(place, &choices)| {
            let sum = each
                .iter()
                .fold(Figures::ZERO, |sum, world| sum.plus(&world[place]));
            Candidate {
                choices,
                figures: sum.divided(worlds.end.saturating_sub(worlds.start).max(1)),
            }
        });
        means.collect::<Vec<_>>()
    });
    summed.collect::<Vec<_>>().concat()
}

#[cfg(test)]
mod tests {
    use super::super::{Evaluation, Evidence};
    use super::*;

    #[test]
    fn a_family_comes_to_what_its_members_come_to_alone() {
        let hard = Choices {
            evidence: Evidence::Hard,
            ..Choices::PRIMARY
        };
        let family = Family {
            members: vec![Choices::PRIMARY, hard],
        };
        for candidate in means(&[family], 4, 0..3, &|| {}) {
            let alone = Evaluation::run(candidate.choices, 4, 3, || {});
            assert_eq!(candidate.figures, alone.figures());
        }
    }
}
