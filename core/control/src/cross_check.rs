//! Who lies, told by rangefinders, a scanner and a map that look at the same places.

mod suspicions;
mod verdict;

use super::histogram::PerBeam;
use super::{ExpectedScan, Failures, PerRangefinder, RANGEFINDERS, Views};
use certainty_core::transducer::Reading;
use certainty_core::units::Millimeters;
use core::fmt;
use suspicions::{Standing, Suspicions};

pub use verdict::{Verdict, Verdicts};

/// What a cross-check leaves open, before it is checked ([`CrossCheck::try_new`]).
///
/// The weights are steps of a logarithm of odds: a sound pair contradicts itself at edges, about once in
/// twenty readings, a broken one nearly always, and agrees by chance alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CrossCheckConfig {
    /// Where the sensors look.
    pub views: Views,
    /// How far two sensors that see the same may differ, besides a sixteenth of the distance.
    pub tolerance: Millimeters,
    /// What a contradiction adds to the suspicion of a pair; above zero.
    pub contradiction: u8,
    /// What an agreement takes; above zero.
    pub agreement: u8,
    /// The most that contradictions add up to; at least twice what a failure costs.
    pub most: u8,
    /// The most that agreements add up to. It is forgotten step by step while they see nothing alike, so
    /// that only those who agree now speak against those who contradict.
    pub credit: u8,
    /// How much suspicion makes a failure likelier than chance: what a failure costs; above zero.
    pub unlikely: u8,
}

/// Why a configuration was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CrossCheckConfigError {
    /// A contradiction, an agreement or a failure weighs nothing.
    Weightless,
    /// No suspicion can grow so large that somebody is found broken for certain.
    NeverFound,
}

impl fmt::Display for CrossCheckConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Weightless => "a contradiction, an agreement and a failure must weigh something",
            Self::NeverFound => "contradictions must add up to twice what a failure costs",
        })
    }
}

impl core::error::Error for CrossCheckConfigError {}

/// Suspicion of each pair of a rangefinder and the scanner, and who of the two it falls on.
///
/// A pair that contradicts itself has a broken member, and does not say which. Who it is the other pairs
/// say: a broken rangefinder contradicts the scanner alone, a broken scanner every rangefinder that sees
/// something. So the one failure that explains most is preferred to several (consistency-based
/// diagnosis); one pair alone leaves both in doubt by half. An explanation that stands already is
/// cheaper than a new one: a sensor that was found broken stays what is wrong while the others see
/// nothing that could speak for the scanner.
///
/// A map that remembers is a further witness, of each alone: it tells two rangefinders that lie from the
/// scanner that they contradict, and sees those that look where the scanner does not. What a rangefinder sees
/// where the map is surely free counts as a contradiction to the scanner, which drew most of the map.
///
/// Unlike a grid's comparison of cells this takes whole readings: it does not drown in the free cells
/// that even a blind sensor agrees on. Prefer the grid's [`Health`](certainty_core::health::Health) for sensors
/// that look where others have been.
///
/// Cost: 101 products of vectors a rangefinder. Memory: 36 bytes and the configuration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CrossCheck {
    config: CrossCheckConfig,
    suspicions: Suspicions,
    /// Who is found broken, and stands for it.
    standing: Standing,
}

impl CrossCheck {
    /// Creates a check that suspects nobody.
    ///
    /// # Errors
    ///
    /// [`CrossCheckConfigError`] names what cannot be.
    pub const fn try_new(config: CrossCheckConfig) -> Result<Self, CrossCheckConfigError> {
        if config.contradiction == 0 || config.agreement == 0 || config.unlikely == 0 {
            Err(CrossCheckConfigError::Weightless)
        } else if config.most >> 1 < config.unlikely {
            Err(CrossCheckConfigError::NeverFound)
        } else {
            Ok(Self {
                config,
                suspicions: Suspicions::NONE,
                standing: Standing::NOBODY,
            })
        }
    }

    /// Takes in what all sensors say at the same time, and where there is a `memory` what the map says of that;
    /// returns who contradicts whom now.
    ///
    /// The map must be of before what they say is drawn into it, and what a sensor says that contradicts
    /// it is best not drawn: a scanner that goes blind would wipe out in one scan what speaks against it, and a
    /// rangefinder's phantom would become an obstacle.
    /// The world is taken to stand still: what goes away is believed gone when most of what the scanner
    /// sees is still there, and what appears is believed when two sensors see it.
    pub fn observe(
        &mut self,
        rangefinders: &PerRangefinder<Reading>,
        scan: &PerBeam<Reading>,
        memory: Option<&ExpectedScan>,
    ) -> Verdicts {
        let pairs = self.config.between(rangefinders, scan);
        let verdicts = match memory {
            Some(memory) => self.config.against(rangefinders, scan, pairs, memory),
            None => Verdicts {
                pairs,
                rangefinders: [Verdict::Silence; RANGEFINDERS],
                scanner: Verdict::Silence,
            },
        };
        self.suspect_pairs(rangefinders, &verdicts);
        self.suspect_by_map(&verdicts);
        let failures = self.failures();
        self.standing.settle(&failures);
        verdicts
    }

    fn suspect_pairs(&mut self, rangefinders: &PerRangefinder<Reading>, verdicts: &Verdicts) {
        let CrossCheckConfig {
            contradiction,
            agreement,
            most,
            credit,
            ..
        } = self.config;
        let of_map = verdicts.pairs.iter().zip(&verdicts.rangefinders);
        let all = of_map.zip(rangefinders);
        for (suspicion, ((verdict, by_map), reading)) in
            self.suspicions.of_pairs.iter_mut().zip(all)
        {
            let by = match verdict {
                Verdict::Agreement => i16::from(agreement).saturating_neg(),
                Verdict::Contradiction => contradiction.into(),
                // It sees what was not there, or who drew the map did not: the scanner, as a rule.
                _ if *by_map == Verdict::Phantom => contradiction.into(),
                // Who is not heard accuses nobody: a robot that stands, blinded by what a sensor said
                // before it was taken out, would stand for ever.
                _ if matches!(reading, Reading::Missing(_)) => suspicion.signum().saturating_neg(),
                // What they agreed on before does not speak for them for ever.
                _ => i16::from(*suspicion < 0),
            };
            *suspicion = moved(*suspicion, by, credit, most);
        }
    }

    fn suspect_by_map(&mut self, verdicts: &Verdicts) {
        let CrossCheckConfig { most, credit, .. } = self.config;
        let (agreement, contradiction) = (
            self.config.agreement.into(),
            self.config.contradiction.into(),
        );
        // Nothing remembered there: what was found is forgotten step by step.
        let by = |verdict, agreement: i16, suspicion: i16| match verdict {
            Verdict::Agreement => agreement.saturating_neg(),
            Verdict::Contradiction => contradiction,
            Verdict::Phantom | Verdict::Past | Verdict::Silence => {
                suspicion.signum().saturating_neg()
            }
        };
        let all = self.suspicions.of_rangefinders.iter_mut();
        for (suspicion, &verdict) in all.zip(&verdicts.rangefinders) {
            let by = by(verdict, agreement, *suspicion);
            *suspicion = moved(*suspicion, by, credit, most);
        }
        // Dozens of beams that agree are no accident: they weigh as much as those that contradict.
        let suspicion = &mut self.suspicions.of_scanner;
        let by = by(verdicts.scanner, contradiction, *suspicion);
        *suspicion = moved(*suspicion, by, most, most);
    }

    /// Returns the failures that explain what was observed.
    ///
    /// Formula: with `x_i` the suspicion of pair i, `y_i` and `z` of rangefinder i and the scanner against
    /// the map, and λ what a failure costs, half of that where it stands already: a broken scanner explains
    /// `S = Σ x_i + z − λ_s` and leaves `B = Σ max(0, y_i − λ_i)` to broken rangefinders, which by
    /// themselves explain `R = Σ max(0, x_i + y_i − λ_i)`. The scanner's share of the blame is
    /// `½ + (S + B − R) / 2λ` within 0..=1; its failure is that share of `S / λ`, rangefinder i's that share
    /// of `(y_i − λ_i) / λ` and the rest's of `(x_i + y_i − λ_i) / λ`, each within 0..=1.
    #[must_use]
    pub fn failures(&self) -> Failures {
        self.suspicions
            .explained(&self.standing, self.config.unlikely)
    }
}

/// A suspicion after a step, from −`credit` to `most`.
///
/// Not `clamp`, which has a panic for bounds the wrong way round.
fn moved(suspicion: i16, by: i16, credit: u8, most: u8) -> i16 {
    let (least, most) = (i16::from(credit).saturating_neg(), i16::from(most));
    let sum = suspicion.saturating_add(by);
    if sum > most { most } else { sum.max(least) }
}

#[cfg(test)]
mod tests;
