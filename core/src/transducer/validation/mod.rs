//! Local sensor validation: what one sensor's own readings say about it (\[002\] Fig. 1).
//!
//! A [`Validator`] labels readings; what it cannot believe goes on as *missing*, so the sensor's
//! health hears of it and the map does not. It knows one sensor: a wrong distance that could be
//! right is found only by other sensors, which is what the robust grid is for.
//!
//! [`Fluctuation`] is for a sensor that may be asked again and again in one direction: it tells *no
//! object* from an echo by how much the answers differ (\[001\] §6.1).

mod finding;
mod fluctuation;
mod rules;

pub use finding::{Finding, FindingCounts, Validated};
pub use fluctuation::{Fluctuation, Steadiness};
pub use rules::{ValidationConfig, ValidationError, ValidationRules};

use crate::narrow::wrapping_u16;
use crate::transducer::{Missing, Reading};
use crate::units::{BinaryAngle, Millimeters, Ticks};

/// Watches one sensor.
///
/// - **Out of range**: an echo nearer than the sensor's nearest or farther than its farthest
///   distance. It becomes *missing*.
/// - **Stuck**: the same raw word claims an echo in more than [`ValidationConfig::same_word`]
///   directions one after the other. It becomes *missing*, until another word comes. A word that
///   claims no echo is never stuck: a sound unit that sees nothing gives the same byte for a whole
///   sweep. Nor is a fixed sensor, which may look at a wall for hours, or one without raw words.
/// - **Jump**: one look is remembered until the sensor looks the same way again, then the next one
///   is. So a swept sensor has one direction compared in each sweep, all of them over time, and a
///   fixed sensor every reading. Neighbouring directions are not compared: at the edge of an object
///   they differ by any distance. A label only, as something may have walked into the beam. *No
///   object* and *too near* are compared by what they prove: beyond the farthest and before the
///   nearest distance.
///
/// Memory: 24 bytes. Cost: comparisons and one multiplication of 64 bits a reading.
///
/// ```
/// use certainty_core::transducer::{
///     Finding, Missing, Reading, ValidationConfig, ValidationRules, Validator,
/// };
/// use certainty_core::units::{BinaryAngle, Millimeters, Ticks};
///
/// let mm = Millimeters::new;
/// let config = ValidationConfig::sweeping(mm(100), mm(800), 500, 37, 9250);
/// let rules = ValidationRules::try_new(config)?;
/// let mut validator = Validator::new();
///
/// let ahead = BinaryAngle::QUARTER;
/// let far = validator.validate(&rules, Reading::Echo(mm(900)), None, ahead, Ticks::new(0));
/// assert_eq!(far.finding, Finding::OutOfRange);
/// assert_eq!(far.reading, Reading::Missing(Missing::Implausible));
/// assert_eq!(validator.counts().of(Finding::OutOfRange), 1);
/// # Ok::<(), certainty_core::transducer::ValidationError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Validator {
    remembered_at: Ticks,
    remembered_bearing: BinaryAngle,
    /// In mm; of an echo only.
    remembered_distance: u16,
    counts: FindingCounts,
    bearing: BinaryAngle,
    /// Looks in new directions that gave `word`.
    same: u16,
    word: u8,
    remembered: Remembered,
}

/// What kind of reading is remembered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum Remembered {
    Nothing,
    Echo,
    NoObject,
    TooNear,
}

impl Validator {
    /// Creates the watch of a sensor that has said nothing yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            remembered_at: Ticks::new(0),
            remembered_bearing: BinaryAngle::ZERO,
            remembered_distance: 0,
            counts: FindingCounts::NONE,
            bearing: BinaryAngle::ZERO,
            same: 0,
            word: 0,
            remembered: Remembered::Nothing,
        }
    }

    /// Judges a reading, and says what goes on instead of one that cannot be believed.
    ///
    /// `raw` is the word that the reading was made from, if the sensor has one; `bearing` is where
    /// the sensor looked, in the frame in which the scene rests: the map's where the robot turns.
    /// The same direction must be the same angle to the bit, as those of a
    /// [`Sweep`](crate::transducer::Sweep) are.
    ///
    /// Out of range comes before stuck, and that before a jump.
    pub fn validate(
        &mut self,
        rules: &ValidationRules,
        reading: Reading,
        raw: Option<u8>,
        bearing: BinaryAngle,
        now: Ticks,
    ) -> Validated {
        let config = rules.config();
        let finding = match reading {
            // Nothing was seen: what was remembered stays.
            Reading::Missing(_) => Finding::Missing,
            Reading::Echo(_) | Reading::NoObject | Reading::TooNear => {
                let stuck = self.repeats(reading, raw, bearing) > config.same_word;
                let finding = match reading {
                    Reading::Echo(at) if at < config.nearest || at > config.farthest => {
                        Finding::OutOfRange
                    }
                    _ if stuck => Finding::StuckAt,
                    _ if self.jumps(rules, reading, bearing, now) => Finding::Jump,
                    _ => Finding::Plausible,
                };
                self.bearing = bearing;
                finding
            }
        };
        self.counts.record(finding);
        Validated {
            reading: match finding {
                Finding::OutOfRange | Finding::StuckAt => Reading::Missing(Missing::Implausible),
                Finding::Plausible | Finding::Jump | Finding::Missing => reading,
            },
            finding,
        }
    }

    /// Returns how often each finding was made.
    #[must_use]
    pub const fn counts(&self) -> FindingCounts {
        self.counts
    }

    /// In how many directions one after the other the word has claimed an echo, this one included.
    fn repeats(&mut self, reading: Reading, raw: Option<u8>, bearing: BinaryAngle) -> u16 {
        self.same = match (reading, raw) {
            (Reading::Echo(_), Some(word)) if self.same > 0 && word == self.word => {
                // Asked again in the same direction, a sound sensor may say the same.
                if bearing == self.bearing {
                    self.same
                } else {
                    self.same.saturating_add(1)
                }
            }
            (Reading::Echo(_), Some(word)) => {
                self.word = word;
                1
            }
            _ => 0,
        };
        self.same
    }

    /// Whether the reading differs too much from the remembered one of this direction; remembers it
    /// where that is due.
    fn jumps(
        &mut self,
        rules: &ValidationRules,
        reading: Reading,
        bearing: BinaryAngle,
        now: Ticks,
    ) -> bool {
        let age = now.since(self.remembered_at);
        let config = rules.config();
        let known = self.recall().filter(|_| age <= config.compare_within);
        match known {
            Some(before) if bearing == self.remembered_bearing => {
                if bearing == self.bearing {
                    self.remember(reading, bearing, now); // a fixed sensor: compare with the latest
                } else {
                    self.remembered = Remembered::Nothing; // a swept one: the next direction's turn
                }
                least_change(before, reading, config) > rules.explained(age)
            }
            Some(_) => false,
            None => {
                self.remember(reading, bearing, now);
                false
            }
        }
    }

    fn remember(&mut self, reading: Reading, bearing: BinaryAngle, now: Ticks) {
        self.remembered_at = now;
        self.remembered_bearing = bearing;
        self.remembered = match reading {
            Reading::Echo(distance) => {
                // In range, and that fits 16 bits.
                self.remembered_distance = wrapping_u16(distance.get());
                Remembered::Echo
            }
            Reading::NoObject => Remembered::NoObject,
            Reading::TooNear => Remembered::TooNear,
            Reading::Missing(_) => Remembered::Nothing,
        };
    }

    fn recall(&self) -> Option<Reading> {
        match self.remembered {
            Remembered::Nothing => None,
            Remembered::Echo => Some(Reading::Echo(Millimeters::new(
                self.remembered_distance.into(),
            ))),
            Remembered::NoObject => Some(Reading::NoObject),
            Remembered::TooNear => Some(Reading::TooNear),
        }
    }
}

impl Default for Validator {
    fn default() -> Self {
        Self::new()
    }
}

/// The least by which what was seen has changed.
fn least_change(before: Reading, after: Reading, config: &ValidationConfig) -> Millimeters {
    // From where to where the object may be.
    let span = |reading| match reading {
        Reading::Echo(distance) => (distance, distance),
        Reading::TooNear => (Millimeters::ZERO, config.nearest),
        Reading::NoObject => (config.farthest, Millimeters::new(u32::MAX)),
        Reading::Missing(_) => (Millimeters::ZERO, Millimeters::new(u32::MAX)),
    };
    let ((from, to), (nearest, farthest)) = (span(before), span(after));
    nearest
        .saturating_sub(to)
        .max(from.saturating_sub(farthest))
}

#[cfg(test)]
mod tests;
