//! Local sensor validation: what one sensor's own readings say about it (\[002\] Fig. 1).
//!
//! A [`Validator`] labels readings; what it cannot believe goes on as *missing*, so the sensor's
//! health hears of it and the map does not. It knows one sensor: a wrong distance that could be
//! right is found only by other sensors, which is what the robust grid is for.
//!
//! [`Fluctuation`] is for a sensor that may be asked again and again in one direction: it tells *no
//! object* from an echo by how much the answers differ (\[001\] §6.1).

use super::reading::{Missing, Reading};
use crate::narrow::wrapping_u16;
use crate::units::{BinaryAngle, Millimeters, Ticks};
use core::fmt;

/// What a [`Validator`] thinks of a reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Finding {
    /// Nothing speaks against it.
    Plausible,
    /// In the same direction something else was seen shortly before, and no motion explains the
    /// change. A label: the reading stays.
    Jump,
    /// An echo from where the sensor cannot see. The reading becomes *missing*, implausible.
    OutOfRange,
    /// The same raw word has claimed an echo in too many directions one after the other. The
    /// reading becomes *missing*, implausible.
    StuckAt,
    /// There was no reading; its reason stays.
    Missing,
}

impl Finding {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Plausible,
        Self::Jump,
        Self::OutOfRange,
        Self::StuckAt,
        Self::Missing,
    ];
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Plausible => "plausible",
            Self::Jump => "jump",
            Self::OutOfRange => "out of range",
            Self::StuckAt => "stuck",
            Self::Missing => "missing",
        })
    }
}

/// A reading with what was found; what the fusion level is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[must_use]
pub struct Validated {
    /// The reading as it goes on.
    pub reading: Reading,
    /// Why it does so.
    pub finding: Finding,
}

/// How often each finding was made; saturates at 65,535.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(transparent))]
pub struct FindingCounts([u16; Finding::ALL.len()]);

impl FindingCounts {
    /// None was made yet.
    const NONE: Self = Self([0; Finding::ALL.len()]);

    /// Returns how often `finding` was made.
    #[must_use]
    pub fn of(&self, finding: Finding) -> u16 {
        self.0.get(finding as usize).copied().unwrap_or_default()
    }

    /// Counts one more.
    fn record(&mut self, finding: Finding) {
        if let Some(count) = self.0.get_mut(finding as usize) {
            *count = count.saturating_add(1);
        }
    }
}

/// What a sensor's readings are held to, before it is checked.
///
/// No paper gives numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ValidationConfig {
    /// The shortest distance the sensor can tell.
    pub nearest: Millimeters,
    /// The longest.
    pub farthest: Millimeters,
    /// A change in one direction up to here is none: what noise alone can make of two readings.
    pub jump: Millimeters,
    /// How fast things come nearer or go away, robot included, in mm/s.
    pub speed_mm_s: u16,
    /// A reading is compared with one that is at most so many ms old. Longer than a sweep, or a
    /// swept sensor's never are.
    pub compare_within: u32,
    /// So many looks in new directions one after the other may give the same raw word.
    pub same_word: u16,
}

impl ValidationConfig {
    /// A swept infrared sensor that comes to the same direction again after `sweep_ms`.
    ///
    /// A jump is half of the range, as a unit that errs by 12 % (\[001\] Table 1, D) makes two
    /// readings of 80 cm differ by more than that once in a hundred times. A word is stuck after a
    /// whole sweep of `directions`: sound sensors see the same distance all the way round only from
    /// the middle of a circle, and a flat wall gives a GP2D02 the same byte over at most 40°.
    #[must_use]
    pub const fn sweeping(
        nearest: Millimeters,
        farthest: Millimeters,
        speed_mm_s: u16,
        directions: u16,
        sweep_ms: u32,
    ) -> Self {
        Self {
            nearest,
            farthest,
            jump: Millimeters::new(farthest.saturating_sub(nearest).get() / 2),
            speed_mm_s,
            compare_within: sweep_ms.saturating_add(sweep_ms / 2),
            same_word: directions,
        }
    }
}

/// The checked [`ValidationConfig`].
///
/// Possession proves that the range is not empty and fits 16 bits, that a jump is above zero, and
/// that at least one look may repeat a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ValidationRules(ValidationConfig);

/// Why a configuration was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ValidationError {
    /// The nearest distance is not below the farthest, or that is above 65,535 mm.
    Range,
    /// Every change would be a jump.
    Jump,
    /// Every echo would be stuck.
    SameWord,
}

impl fmt::Display for ValidationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Range => "the nearest distance must be below the farthest, that at most 65535 mm",
            Self::Jump => "a jump must be above 0 mm, or noise is one",
            Self::SameWord => "a word may be repeated at least once, or every echo is stuck",
        })
    }
}

impl core::error::Error for ValidationError {}

impl ValidationRules {
    /// Checks the configuration.
    ///
    /// # Errors
    ///
    /// [`ValidationError`] names what cannot be.
    pub const fn try_new(config: ValidationConfig) -> Result<Self, ValidationError> {
        let farthest = config.farthest.get();
        if config.nearest.get() >= farthest || farthest > u16::MAX as u32 {
            Err(ValidationError::Range)
        } else if config.jump.get() == 0 {
            Err(ValidationError::Jump)
        } else if config.same_word == 0 {
            Err(ValidationError::SameWord)
        } else {
            Ok(Self(config))
        }
    }

    /// Returns the configuration.
    #[must_use]
    pub const fn config(&self) -> &ValidationConfig {
        &self.0
    }

    /// The largest change that motion explains in so many milliseconds.
    fn explained(&self, age: u32) -> Millimeters {
        // 32 by 16 bits, and fewer than 2^32 mm in the end.
        let moved = u64::from(age).wrapping_mul(self.0.speed_mm_s.into()) / 1000;
        let moved = Millimeters::new(u32::try_from(moved).unwrap_or(u32::MAX));
        self.0.jump.saturating_add(moved)
    }
}

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
mod tests {
    use super::*;
    use crate::transducer::{Calibration, Sweep};
    use fixed::types::U8F8;
    use proptest::prelude::*;

    const fn mm(mm: u32) -> Millimeters {
        Millimeters::new(mm)
    }

    const DIRECTIONS: u16 = 37;
    const ROUND_MS: u32 = 250;
    const CONFIG: ValidationConfig =
        ValidationConfig::sweeping(mm(100), mm(800), 0, DIRECTIONS, 37 * ROUND_MS);
    const RULES: ValidationRules = match ValidationRules::try_new(CONFIG) {
        Ok(rules) => rules,
        Err(_) => panic!("no such rules"),
    };

    fn degrees(degrees: i32) -> BinaryAngle {
        BinaryAngle::from_millidegrees(degrees * 1000)
    }

    fn sweep() -> Sweep {
        Sweep::try_new(degrees(-90), degrees(90), DIRECTIONS).unwrap()
    }

    fn unit() -> Calibration {
        Calibration::try_new(13_000, mm(0), U8F8::lit("60"), mm(100), mm(800)).unwrap()
    }

    /// A sensor on its head, round after round, with its validator.
    struct Head {
        validator: Validator,
        rules: ValidationRules,
        round: u32,
    }

    impl Head {
        fn new() -> Self {
            Self::with(CONFIG)
        }

        fn with(config: ValidationConfig) -> Self {
            Self {
                validator: Validator::new(),
                rules: ValidationRules::try_new(config).unwrap(),
                round: 0,
            }
        }

        fn look(&mut self, reading: Reading, raw: Option<u8>) -> Validated {
            let bearing = sweep().direction(self.round, 0, 1);
            self.look_at(bearing, reading, raw)
        }

        fn look_at(
            &mut self,
            bearing: BinaryAngle,
            reading: Reading,
            raw: Option<u8>,
        ) -> Validated {
            let now = Ticks::new(self.round * ROUND_MS);
            self.round += 1;
            self.validator
                .validate(&self.rules, reading, raw, bearing, now)
        }

        fn hear(&mut self, raw: u8) -> Finding {
            self.look(unit().reading(raw), Some(raw)).finding
        }

        fn count(&self, finding: Finding) -> u16 {
            self.validator.counts().of(finding)
        }
    }

    #[test]
    fn a_validator_takes_24_bytes() {
        assert_eq!(size_of::<Validator>(), 24);
    }

    #[test]
    fn an_echo_outside_the_range_goes_on_as_missing() {
        for (distance, finding) in [
            (99, Finding::OutOfRange),
            (100, Finding::Plausible),
            (800, Finding::Plausible),
            (801, Finding::OutOfRange),
        ] {
            let mut head = Head::new();
            let validated = head.look(Reading::Echo(mm(distance)), None);
            assert_eq!(validated.finding, finding, "{distance} mm");
            let expected = match finding {
                Finding::OutOfRange => Reading::Missing(Missing::Implausible),
                _ => Reading::Echo(mm(distance)),
            };
            assert_eq!(validated.reading, expected);
        }
    }

    #[test]
    fn what_is_missing_keeps_its_reason() {
        let mut head = Head::new();
        for reason in [Missing::Timeout, Missing::Bus, Missing::Implausible] {
            let validated = head.look(Reading::Missing(reason), Some(0xFF));
            assert_eq!(validated.reading, Reading::Missing(reason));
            assert_eq!(validated.finding, Finding::Missing);
        }
        assert_eq!(head.count(Finding::Missing), 3);
    }

    #[test]
    fn a_word_that_claims_an_echo_in_every_direction_of_a_sweep_and_one_more_is_stuck() {
        let mut head = Head::new();
        for look in 1..=100 {
            let raw = 90;
            let validated = head.look(unit().reading(raw), Some(raw));
            let stuck = look > DIRECTIONS;
            assert_eq!(validated.finding == Finding::StuckAt, stuck, "look {look}");
            assert_eq!(matches!(validated.reading, Reading::Missing(_)), stuck);
        }
        // Another word and it is believed again.
        assert_eq!(head.hear(95), Finding::Plausible);
        assert_eq!(head.count(Finding::StuckAt), 100 - DIRECTIONS);
    }

    #[test]
    fn a_stuck_line_that_fails_now_and_then_is_still_stuck() {
        let mut head = Head::new();
        for _ in 0..DIRECTIONS {
            head.hear(90);
            let _ = head.look(Reading::Missing(Missing::Timeout), None);
        }
        assert_eq!(head.hear(90), Finding::StuckAt);
    }

    #[test]
    fn a_sound_sensor_that_sees_nothing_for_sweeps_is_not_stuck() {
        let mut head = Head::new();
        for _ in 0..10 * DIRECTIONS {
            assert_eq!(unit().reading(62), Reading::NoObject);
            assert_eq!(head.hear(62), Finding::Plausible);
        }
    }

    #[test]
    fn a_fixed_sensor_before_a_wall_is_not_stuck() {
        let mut head = Head::new();
        for _ in 0..1000 {
            let ahead = BinaryAngle::QUARTER;
            let validated = head.look_at(ahead, unit().reading(90), Some(90));
            assert_eq!(validated.finding, Finding::Plausible);
        }
    }

    #[test]
    fn a_ranger_without_raw_words_is_not_stuck() {
        let mut head = Head::new();
        for _ in 0..100 {
            let validated = head.look(Reading::Echo(mm(300)), None);
            assert_eq!(validated.finding, Finding::Plausible);
        }
    }

    /// The reason for a whole sweep. Without noise, which would only help.
    #[test]
    fn a_flat_wall_gives_the_same_byte_over_40_degrees_at_most() {
        let mut widest = 0;
        for wall in (100..800).map(f64::from) {
            let (mut same, mut last) = (0, 0);
            for millidegrees in (-89_000..89_000).step_by(250) {
                let distance = wall / (f64::from(millidegrees) / 1000.0).to_radians().cos();
                let raw = (13_000.0 / distance + 60.0).round() as u8;
                let steady = raw == last && distance <= 800.0;
                same = if steady { same + 250 } else { 0 };
                last = raw;
                widest = widest.max(same);
            }
        }
        assert!((35_000..=40_000).contains(&widest), "{widest}");
    }

    #[test]
    fn a_change_in_the_same_direction_beyond_what_motion_explains_is_a_jump() {
        // Two looks 250 ms apart at 400 mm/s: half of 700 mm and 100 mm.
        let judged = |distance: u32| {
            let mut head = Head::with(ValidationConfig {
                speed_mm_s: 400,
                ..CONFIG
            });
            let ahead = BinaryAngle::QUARTER;
            let _ = head.look_at(ahead, Reading::Echo(mm(200)), None);
            head.look_at(ahead, Reading::Echo(mm(distance)), None)
        };
        assert_eq!(judged(650).finding, Finding::Plausible);
        let jump = judged(651);
        assert_eq!(jump.finding, Finding::Jump);
        assert_eq!(jump.reading, Reading::Echo(mm(651)), "a label only");
    }

    #[test]
    fn no_object_and_too_near_jump_by_what_they_prove() {
        let judged = |before, after| {
            let mut head = Head::new();
            let ahead = BinaryAngle::QUARTER;
            let _ = head.look_at(ahead, before, None);
            head.look_at(ahead, after, None).finding == Finding::Jump
        };
        let echo = |distance| Reading::Echo(mm(distance));
        // The limit is 350 mm; 800 mm and beyond is no object, 100 mm and less is too near.
        for (before, after, jump) in [
            (echo(450), Reading::NoObject, false),
            (echo(449), Reading::NoObject, true),
            (echo(450), Reading::TooNear, false),
            (echo(451), Reading::TooNear, true),
            (Reading::NoObject, Reading::TooNear, true),
            (Reading::NoObject, Reading::NoObject, false),
            (Reading::TooNear, Reading::TooNear, false),
        ] {
            assert_eq!(judged(before, after), jump, "{before:?} to {after:?}");
            assert_eq!(judged(after, before), jump, "{after:?} to {before:?}");
        }
    }

    #[test]
    fn the_edges_of_objects_that_rest_are_no_jumps() {
        let mut head = Head::new();
        for _ in 0..5 * DIRECTIONS {
            let near = head.round % u32::from(DIRECTIONS) % 4 < 2;
            let distance = if near { 150 } else { 790 };
            let validated = head.look(Reading::Echo(mm(distance)), None);
            assert_eq!(validated.finding, Finding::Plausible);
        }
    }

    /// One direction is compared a sweep, and the next one the sweep after.
    #[test]
    fn a_jump_in_any_direction_of_a_sweep_is_found_in_time() {
        let directions = u32::from(DIRECTIONS);
        for restless in 0..directions {
            let mut head = Head::new();
            for _ in 0..(directions + 2) * directions {
                // In this direction every sweep sees something else.
                let (sweep, step) = (head.round / directions, head.round % directions);
                let near = step == restless && sweep % 2 == 0;
                let distance = if near { 150 } else { 700 };
                let finding = head.look(Reading::Echo(mm(distance)), None).finding;
                assert!(finding == Finding::Plausible || step == restless);
            }
            assert_eq!(head.count(Finding::Jump), 1, "direction {restless}");
        }
    }

    #[test]
    fn what_was_seen_too_long_ago_is_not_compared() {
        let judged = |later: u32| {
            let mut validator = Validator::new();
            let mut validate = |distance, now| {
                let reading = Reading::Echo(mm(distance));
                validator.validate(&RULES, reading, None, BinaryAngle::ZERO, Ticks::new(now))
            };
            let _ = validate(150, 0);
            validate(700, later).finding
        };
        assert_eq!(judged(CONFIG.compare_within), Finding::Jump);
        assert_eq!(judged(CONFIG.compare_within + 1), Finding::Plausible);
    }

    #[test]
    fn counts_saturate() {
        let mut head = Head::new();
        for _ in 0..70_000_u32 {
            let _ = head.look(Reading::Missing(Missing::Bus), None);
        }
        assert_eq!(head.count(Finding::Missing), u16::MAX);
        assert_eq!(head.count(Finding::Plausible), 0);
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let refused = |config| ValidationRules::try_new(config).unwrap_err();
        let (nearest, jump) = (mm(800), mm(0));
        assert_eq!(
            refused(ValidationConfig { nearest, ..CONFIG }),
            ValidationError::Range
        );
        let farthest = mm(65_536);
        assert_eq!(
            refused(ValidationConfig { farthest, ..CONFIG }),
            ValidationError::Range
        );
        assert_eq!(
            refused(ValidationConfig { jump, ..CONFIG }),
            ValidationError::Jump
        );
        let same_word = 0;
        assert_eq!(
            refused(ValidationConfig {
                same_word,
                ..CONFIG
            }),
            ValidationError::SameWord
        );
    }

    fn any_reading() -> impl Strategy<Value = Reading> {
        prop_oneof![
            6 => (0_u32..1000).prop_map(|d| Reading::Echo(mm(d))),
            1 => Just(Reading::NoObject),
            1 => Just(Reading::TooNear),
            1 => Just(Reading::Missing(Missing::Timeout)),
        ]
    }

    proptest! {
        /// Labels and counts, whatever comes: a reading changes exactly if its finding says so.
        #[test]
        fn nothing_is_dropped_silently(
            looks in proptest::collection::vec(
                (any_reading(), 88_u8..90, 0_i32..3, 0_u32..9000),
                0..300,
            ),
            same_word in 1_u16..6,
        ) {
            let rules = ValidationRules::try_new(ValidationConfig { same_word, ..CONFIG }).unwrap();
            let mut validator = Validator::new();
            let mut made = [0_u16; Finding::ALL.len()];
            let mut now = 0_u32;
            let mut run = Vec::new(); // of words that claim an echo, each with its direction
            for (reading, raw, bearing, later) in looks {
                now = now.wrapping_add(later);
                let Validated { reading: passed, finding } =
                    validator.validate(&rules, reading, Some(raw), degrees(bearing), Ticks::new(now));
                made[finding as usize] += 1;

                match reading {
                    Reading::Echo(_) => {
                        if run.last().is_some_and(|&(word, _)| word != raw) {
                            run.clear();
                        }
                        run.push((raw, bearing));
                        run.dedup();
                    }
                    Reading::NoObject | Reading::TooNear => run.clear(),
                    Reading::Missing(_) => {}
                }
                let in_range =
                    !matches!(reading, Reading::Echo(d) if !(100..=800).contains(&d.get()));
                let stuck = run.len() > usize::from(same_word)
                    && !matches!(reading, Reading::Missing(_));
                let changed = !in_range || stuck;
                let expected = if changed { Reading::Missing(Missing::Implausible) } else { reading };
                prop_assert_eq!(passed, expected);
                prop_assert_eq!(finding == Finding::OutOfRange, !in_range);
                prop_assert_eq!(finding == Finding::StuckAt, in_range && stuck);
                let missing = matches!(reading, Reading::Missing(_));
                prop_assert_eq!(finding == Finding::Missing, missing);
            }
            for finding in Finding::ALL {
                prop_assert_eq!(validator.counts().of(finding), made[finding as usize]);
            }
        }
    }
}
