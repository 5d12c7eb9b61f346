//! What \[001\] §6.2 leaves open, one choice a file, each alternative with its name and reason.
//!
//! The first alternative of every choice is the primary set-up's. It is what the text suggests, and
//! the reason says where; no figure of the evaluation had a say in it.

mod accuracy;
mod behind;
mod coverage;
mod evidence;
mod false_distances;
mod middle;
mod mounting;
mod obstacles;
mod own;
mod permanent;
mod scored;
mod spread;
mod standard;
mod sweeps;

pub use accuracy::Accuracy;
pub use evidence::Evidence;
pub use false_distances::FalseDistances;
pub use obstacles::Obstacles;
pub use permanent::Permanent;
pub use spread::Spread;
pub use standard::Standard;
pub use sweeps::Sweeps;

use certainty_core::fusion::{Behind, Middle};
use certainty_sim::fusion::{FusionRules, Own};
use certainty_sim::simulation::{
    HeadPlacement, Length, Profile, ScoredCells, SensorLayout, Setup, SweepOverlap,
};
use certainty_sim::transducer::SensorSet;
use certainty_sim::world::World;
use std::collections::BTreeMap;
use std::sync::Arc;

/// One thing that the text leaves open.
///
/// An implementation is the type of its answers.
pub trait Open: Copy + PartialEq + 'static {
    /// What it is called in reports.
    const NAME: &'static str;
    /// Every alternative, the primary set-up's first.
    const ALL: &'static [Self];
    /// Whether it decides only what is done with readings that are taken and interpreted.
    const AFTER: bool = false;

    /// Returns the alternative's name.
    fn name(self) -> &'static str;

    /// Returns why the text may mean it.
    fn reason(self) -> &'static str;

    /// Returns what the text says against it, if anything.
    fn against(self) -> Option<&'static str> {
        None
    }

    /// Returns where `choices` keeps it.
    fn of(choices: &mut Choices) -> &mut Self;
}

/// An answer to everything that the text leaves open: one set-up of the evaluation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Choices {
    /// How the 1560 measurements are divided.
    pub sweeps: Sweeps,
    /// What stands around the car.
    pub obstacles: Obstacles,
    /// Where the sensors sit.
    pub mounting: HeadPlacement,
    /// How much of the arc every sensor sweeps.
    pub coverage: SweepOverlap,
    /// Whether a sensor is broken for good.
    pub fault: Permanent,
    /// What Table 1 calls accuracy.
    pub accuracy: Accuracy,
    /// What a sensor says that fails to see that there is no object.
    pub false_distances: FalseDistances,
    /// How far around an echo cells are occupied.
    pub spread: Spread,
    /// What cells behind a hit receive.
    pub behind: Behind,
    /// How sure one measurement is to eq. 1.
    pub evidence: Evidence,
    /// How each sensor's own grid is kept.
    pub own: Own,
    /// What the median is of an even number of sensors.
    pub middle: Middle,
    /// What a map is compared with.
    pub reference: Standard,
    /// Which cells are compared.
    pub scored: ScoredCells,
}

impl Choices {
    /// The primary set-up: of every choice the alternative that the text suggests.
    pub const PRIMARY: Self = Self {
        sweeps: Sweeps::D13S1L10,
        obstacles: Obstacles::Scattered,
        mounting: HeadPlacement::Bumper,
        coverage: SweepOverlap::Full,
        fault: Permanent::None,
        accuracy: Accuracy::Deviation,
        false_distances: FalseDistances::FarHalf,
        spread: Spread::None,
        behind: Behind::Uncertain,
        evidence: Evidence::Nine,
        own: Own::Accumulated,
        middle: Middle::Mean,
        reference: Standard::Landmarks,
        scored: ScoredCells::All,
    };

    /// Returns one run of the evaluation: a crew in a world.
    #[must_use]
    pub fn setup(&self, world: Arc<World>, crew: SensorSet, seed: u64) -> Setup {
        let (from, to) = self.false_distances.part();
        let crew = crew.with_models(|printed| {
            let read = printed.with_accuracy_of(self.accuracy.deviations());
            let read = read.and_then(|model| model.with_false_distances(from, to));
            read.unwrap_or(printed) // neither is ever what is refused
        });
        let directions = self.sweeps.directions();
        let rig = SensorLayout::try_new(self.mounting, self.coverage, directions);
        let steps = Length::Steps(u32::from(directions) * self.sweeps.sweeps());
        Setup {
            layout: rig.unwrap_or(SensorLayout::SMART_CAR), // so few directions are never refused
            profile: Profile {
                spread: self.spread.deviations(),
                behind: self.behind,
            },
            faults: self.fault.faults(),
            ..Setup::smart_car(world, crew, steps, seed)
        }
    }

    /// Returns how the methods fuse.
    #[must_use]
    pub fn rules(&self) -> FusionRules {
        let mut rules = FusionRules {
            own: self.own,
            middle: self.middle,
            ..FusionRules::default()
        };
        self.evidence.set(&mut rules);
        rules
    }

    /// Returns every choice with the alternative that is chosen, by name.
    #[must_use]
    pub fn names(&self) -> BTreeMap<&'static str, &'static str> {
        let named = CHOICES.iter().map(|choice| {
            let chosen = choice.alternative(choice.chosen(self));
            (choice.name, chosen.name)
        });
        named.collect()
    }

    /// Returns the choices in which this set-up is not the primary one, with what they are.
    #[must_use]
    pub fn departures(&self) -> Vec<(&'static str, &'static str)> {
        let departed = CHOICES.iter().filter(|choice| choice.chosen(self) != 0);
        let named =
            departed.map(|choice| (choice.name, choice.alternative(choice.chosen(self)).name));
        named.collect()
    }

    /// Returns whether the text says something against an alternative that is chosen.
    #[must_use]
    pub fn contradicts_the_text(&self) -> bool {
        let mut chosen = CHOICES
            .iter()
            .map(|choice| choice.alternative(choice.chosen(self)));
        chosen.any(|alternative| alternative.against.is_some())
    }
}

/// An alternative of a [`Choice`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Alternative {
    /// What it is called.
    pub name: &'static str,
    /// Why the text may mean it.
    pub reason: &'static str,
    /// What the text says against it.
    pub against: Option<&'static str>,
}

/// An [`Open`] choice whose alternatives are told apart by their places in [`Open::ALL`].
#[derive(Debug, Clone, Copy)]
pub struct Choice {
    /// What it is called.
    pub name: &'static str,
    /// How many alternatives there are.
    pub alternatives: usize,
    /// Whether it decides only what is done with readings that are taken and interpreted.
    pub after: bool,
    alternative: fn(usize) -> Alternative,
    chosen: fn(&Choices) -> usize,
    choose: fn(&mut Choices, usize),
}

impl Choice {
    const fn of<T: Open>() -> Self {
        Self {
            name: T::NAME,
            alternatives: T::ALL.len(),
            after: T::AFTER,
            alternative: |place| Alternative {
                name: T::ALL[place].name(),
                reason: T::ALL[place].reason(),
                against: T::ALL[place].against(),
            },
            chosen: |choices| {
                let chosen = *T::of(&mut choices.clone());
                let place = T::ALL.iter().position(|&alternative| alternative == chosen);
                place.unwrap_or(0) // every answer is listed
            },
            choose: |choices, place| *T::of(choices) = T::ALL[place],
        }
    }

    /// Returns the alternative at `place`, 0 being the primary set-up's.
    ///
    /// # Panics
    ///
    /// If there are no more than `place`.
    #[must_use]
    pub fn alternative(&self, place: usize) -> Alternative {
        (self.alternative)(place)
    }

    /// Returns the place of what is chosen.
    #[must_use]
    pub fn chosen(&self, choices: &Choices) -> usize {
        (self.chosen)(choices)
    }

    /// Returns `choices` with the alternative at `place`.
    ///
    /// # Panics
    ///
    /// If there are no more than `place`.
    #[must_use]
    pub fn choose(&self, mut choices: Choices, place: usize) -> Choices {
        (self.choose)(&mut choices, place);
        choices
    }
}

/// Everything that the text leaves open, in the order in which reports list it.
pub const CHOICES: [Choice; 14] = [
    Choice::of::<Sweeps>(),
    Choice::of::<Obstacles>(),
    Choice::of::<HeadPlacement>(),
    Choice::of::<SweepOverlap>(),
    Choice::of::<Permanent>(),
    Choice::of::<Accuracy>(),
    Choice::of::<FalseDistances>(),
    Choice::of::<Spread>(),
    Choice::of::<Behind>(),
    Choice::of::<Evidence>(),
    Choice::of::<Own>(),
    Choice::of::<Middle>(),
    Choice::of::<Standard>(),
    Choice::of::<ScoredCells>(),
];

#[cfg(test)]
mod tests;
