//! Whether any set-up that the text allows comes near all six printed figures.

use super::{Candidate, Family, means};
use crate::table2::{CHOICES, Choice, Choices, Figures};

/// How much the search may compute.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effort {
    /// Worlds of each set-up of the screen; with none, the finalists are the first that are listed.
    pub screen_worlds: u32,
    /// How many set-ups of the screen with each alternative are run again.
    pub finalists: usize,
    /// Worlds of each of those, none of them one of the screen's.
    pub final_worlds: u32,
}

/// The best set-up found with one alternative.
#[derive(Debug, Clone, Copy)]
pub struct BestGiven {
    /// The choice.
    pub choice: Choice,
    /// The alternative, as a place in its list.
    pub place: usize,
    /// The best set-up, which but for this alternative the text allows.
    pub best: Candidate,
    /// The share of such set-ups that come in the paper's order, in the screen's few worlds.
    pub in_order: f64,
}

/// What the search found.
#[derive(Debug, Clone)]
pub struct Search {
    /// How many set-ups were screened.
    pub screened: usize,
    /// How many of them the text allows.
    pub allowed: usize,
    /// How many of those come in the paper's order, in the screen's few worlds.
    pub in_order: usize,
    /// How many of all were run again.
    pub finalists: usize,
    /// The best set-up that the text allows.
    pub best: Candidate,
    /// The best one with each alternative of each choice.
    pub given: Vec<BestGiven>,
}

/// The alternatives of every choice that are combined with all others.
type Factors = Vec<(Choice, Vec<usize>)>;

/// Everything the text allows, and what it speaks against where that costs no reading.
fn factors() -> Factors {
    let allowed = |choice: &Choice, place: usize| choice.alternative(place).against.is_none();
    let places = CHOICES.map(|choice| {
        let places = (0..choice.alternatives).filter(|&n| choice.after || allowed(&choice, n));
        (choice, places.collect())
    });
    places.into()
}

/// Every combination of the alternatives, starting from `from`.
fn combined<'a>(
    factors: impl Iterator<Item = &'a (Choice, Vec<usize>)>,
    from: Choices,
) -> Vec<Choices> {
    factors.fold(vec![from], |before, (choice, places)| {
        let with = |&choices: &Choices| places.iter().map(move |&n| choice.choose(choices, n));
        before.iter().flat_map(with).collect()
    })
}

/// The full factorial, by shared readings.
fn families(factors: &Factors) -> Vec<Family> {
    let of = |after| {
        factors
            .iter()
            .filter(move |(choice, _)| choice.after == after)
    };
    let bases = combined(of(false), Choices::PRIMARY).into_iter();
    let family = |base| Family {
        members: combined(of(true), base),
    };
    bases.map(family).collect()
}

impl Search {
    /// Screens the full factorial of the choices, then runs the best set-ups of each alternative
    /// again; `steps` hears how many steps there are yet to go, `done` of each that is done.
    ///
    /// The best is the one whose farthest figure is nearest: the smallest
    /// [`Figures::worst_factor`]. What the screen chose is judged in other worlds, so that luck in the
    /// screen does not count.
    ///
    /// # Panics
    ///
    /// Never: the primary set-up is among those that are screened.
    pub fn run(seed: u64, effort: &Effort, steps: impl Fn(u64), done: impl Fn() + Sync) -> Self {
        Self::among(&factors(), seed, effort, steps, done)
    }

    fn among(
        factors: &Factors,
        seed: u64,
        effort: &Effort,
        steps: impl Fn(u64),
        done: impl Fn() + Sync,
    ) -> Self {
        let families = families(factors);
        steps(families.len() as u64 * u64::from(effort.screen_worlds));
        let mut screened = means(&families, seed, 0..effort.screen_worlds, &done);
        screened.sort_by(nearer);
        let allowed = screened
            .iter()
            .filter(|each| !each.choices.contradicts_the_text());
        let orders = allowed.map(|each| each.figures.in_the_papers_order());
        let orders: Vec<_> = orders.collect();

        let mut again: Vec<Choices> = Vec::new();
        for (choice, place) in alternatives(factors) {
            let eligible = screened
                .iter()
                .filter(|each| may_stand_for(each, &choice, place));
            for candidate in eligible.take(effort.finalists) {
                if !again.contains(&candidate.choices) {
                    again.push(candidate.choices);
                }
            }
        }
        let alone = |&choices: &Choices| Family {
            members: vec![choices],
        };
        let finalists: Vec<_> = again.iter().map(alone).collect();
        steps(finalists.len() as u64 * u64::from(effort.final_worlds));
        let fresh = effort.screen_worlds..effort.screen_worlds + effort.final_worlds;
        let mut judged = means(&finalists, seed, fresh, &done);
        judged.sort_by(nearer);

        let given = alternatives(factors).filter_map(|(choice, place)| {
            let mut eligible = judged
                .iter()
                .filter(|each| may_stand_for(each, &choice, place));
            let &best = eligible.next()?;
            let with = screened
                .iter()
                .filter(|each| may_stand_for(each, &choice, place));
            let orders = with.map(|each| each.figures.in_the_papers_order());
            let (held, all) = orders.fold((0_u32, 0_u32), |(held, all), holds| {
                (held + u32::from(holds), all + 1)
            });
            Some(BestGiven {
                choice,
                place,
                best,
                in_order: f64::from(held) / f64::from(all.max(1)),
            })
        });
        let given = given.collect();
        let mut allowed = judged
            .iter()
            .filter(|each| !each.choices.contradicts_the_text());
        Self {
            screened: screened.len(),
            allowed: orders.len(),
            in_order: orders.into_iter().filter(|&in_order| in_order).count(),
            finalists: judged.len(),
            best: *allowed.next().expect("the text allows some set-up"),
            given,
        }
    }

    /// Returns whether all six figures of the best set-up are near the printed ones.
    #[must_use]
    pub fn reproduces(&self) -> bool {
        self.best.figures.near() == [true; 6]
    }

    /// Returns every choice with how much it decides, the most first: the worst factor of the best
    /// set-up given its worst alternative, over that given its best.
    ///
    /// Alternatives that the text speaks against do not count.
    #[must_use]
    pub fn deciding(&self) -> Vec<(Choice, f64)> {
        let factors_of = |choice: &Choice| {
            let of_choice = self
                .given
                .iter()
                .filter(|given| given.choice.name == choice.name);
            let allowed =
                of_choice.filter(|given| given.choice.alternative(given.place).against.is_none());
            let factors = allowed.map(|given| given.best.figures.worst_factor());
            factors.fold((f64::INFINITY, 1.0_f64), |(least, most), factor| {
                (least.min(factor), most.max(factor))
            })
        };
        let mut decided: Vec<_> = CHOICES
            .into_iter()
            .filter(|choice| {
                self.given
                    .iter()
                    .any(|given| given.choice.name == choice.name)
            })
            .map(|choice| {
                let (least, most) = factors_of(&choice);
                (choice, most / least)
            })
            .collect();
        decided.sort_by(|a, b| b.1.total_cmp(&a.1));
        decided
    }
}

/// Every alternative that is combined.
fn alternatives(factors: &Factors) -> impl Iterator<Item = (Choice, usize)> {
    let each = |(choice, places): &(Choice, Vec<usize>)| {
        let choice = *choice;
        places.clone().into_iter().map(move |place| (choice, place))
    };
    factors.iter().flat_map(each)
}

/// Whether a set-up has the alternative, and no other that the text speaks against.
fn may_stand_for(candidate: &Candidate, choice: &Choice, place: usize) -> bool {
    let without = choice.choose(candidate.choices, 0);
    choice.chosen(&candidate.choices) == place && !without.contradicts_the_text()
}

/// Which of two set-ups comes nearer to the printed figures.
fn nearer(a: &Candidate, b: &Candidate) -> core::cmp::Ordering {
    let off = |candidate: &Candidate| Figures::worst_factor(&candidate.figures);
    off(a).total_cmp(&off(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_sim::fusion::Own;

    const EFFORT: Effort = Effort {
        screen_worlds: 1,
        finalists: 2,
        final_worlds: 2,
    };

    /// The factorial of these choices alone.
    fn only(names: &[&str]) -> Factors {
        let mut factors = factors();
        for (choice, places) in &mut factors {
            if !names.contains(&choice.name) {
                places.truncate(1);
            }
        }
        factors
    }

    #[test]
    fn the_factorial_has_every_combination_that_the_text_allows_once() {
        let families = families(&factors());
        let members: Vec<_> = families.iter().flat_map(|family| &family.members).collect();
        // Without partial coverage; the scored cells are combined though the text is against some.
        let counts = factors()
            .iter()
            .map(|(_, places)| places.len())
            .product::<usize>();
        assert_eq!(members.len(), counts);
        assert_eq!(counts, 5 * 3 * 2 * 4 * 2 * 2 * 3 * 2 * 3 * 2 * 2 * 2 * 2);
        let allowed = members
            .iter()
            .filter(|member| !member.contradicts_the_text());
        assert_eq!(allowed.count(), counts / 2);
        assert!(
            members
                .iter()
                .all(|member| member.departures().iter().all(|d| d.0 != "coverage"))
        );
    }

    #[test]
    fn the_search_finds_the_nearest_and_lists_every_alternative() {
        let found = Search::among(
            &only(&["evidence", "own", "scored"]),
            2,
            &EFFORT,
            |_| {},
            || {},
        );
        assert_eq!((found.screened, found.allowed), (3 * 2 * 2, 3 * 2));
        assert!(found.in_order <= found.allowed);
        assert!(!found.best.choices.contradicts_the_text());
        let names = |choice: &str| {
            let of = found
                .given
                .iter()
                .filter(|given| given.choice.name == choice);
            of.map(|given| given.choice.alternative(given.place).name)
                .collect::<Vec<_>>()
        };
        assert_eq!(names("evidence"), ["0.9", "0.98", "hard"]);
        assert_eq!(names("own"), ["accumulated", "latest"]);
        assert_eq!(names("scored"), ["all", "known"]);
        assert_eq!(names("mounting"), ["bumper"]);
        for given in &found.given {
            assert_eq!(given.choice.chosen(&given.best.choices), given.place);
            if given.choice.name == "mounting" {
                // The only alternative of this search: its set-ups are all that the text allows.
                assert_eq!(given.in_order, found.in_order as f64 / found.allowed as f64);
            }
            if given.choice.alternative(given.place).against.is_none() {
                let (best, here) = (found.best.figures, given.best.figures);
                assert!(best.worst_factor() <= here.worst_factor());
                assert!(!given.best.choices.contradicts_the_text());
            }
        }
        // A choice of one alternative decides nothing.
        let mounting = found
            .deciding()
            .into_iter()
            .find(|(choice, _)| choice.name == "mounting");
        assert_eq!(mounting.unwrap().1, 1.0);
    }

    #[test]
    fn every_step_is_announced_and_done() {
        use core::sync::atomic::{AtomicU64, Ordering::Relaxed};
        let (announced, did) = (AtomicU64::new(0), AtomicU64::new(0));
        let announce = |steps| {
            announced.fetch_add(steps, Relaxed);
        };
        let done = || {
            did.fetch_add(1, Relaxed);
        };
        let found = Search::among(&only(&["own"]), 2, &EFFORT, announce, done);
        assert_eq!(announced.load(Relaxed), did.load(Relaxed));
        assert_eq!(did.load(Relaxed), 1 + 2 * found.finalists as u64);
        assert_eq!(
            found.best.choices.own == Own::Latest,
            found.best.choices.departures().len() == 1
        );
    }
}
