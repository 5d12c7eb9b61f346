//! Local sensor validation: checks a sensor's readings against its own limits and earlier readings
//! (\[002\] Fig. 1).
//!
//! A [`Validator`] labels readings. An implausible one is passed on as *missing*, so it counts in the
//! sensor's health and changes nothing in the map. A validator reads one sensor only: a wrong distance
//! that is plausible is found by comparing sensors, as [`RobustGrid`](crate::fusion::RobustGrid) does.
//!
//! For a sensor that can be sampled repeatedly in one direction,
//! [`Fluctuation`](super::Fluctuation) distinguishes *no object* from an echo (\[001\] §6.1).

use super::reading::{Missing, Reading};
use crate::units::{BinaryAngle, Millimeters, Ticks};
use core::fmt;

/// The label that a [`Validator`] gives a reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Finding {
    /// No rule is broken.
    Plausible,
    /// It differs from a recent reading in the same direction by more than motion explains. The
    /// reading is unchanged.
    Jump,
    /// An echo outside the sensor's range. The reading becomes *missing*, implausible.
    OutOfRange,
    /// The same raw value gave an echo, or *too near*, in too many successive directions. The reading becomes
    /// *missing*, implausible.
    StuckAt,
    /// There was no reading. Its reason is unchanged.
    Missing,
}

impl Finding {
    /// All findings.
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

/// A reading for the fusion level, and its finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[must_use]
pub struct Validated {
    /// The reading to fuse: *missing* if the finding says so, else the original.
    pub reading: Reading,
    /// The finding.
    pub finding: Finding,
}

/// How often each finding was made; saturates at 65,535.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(transparent))]
pub struct FindingCounts([u16; Finding::ALL.len()]);

impl FindingCounts {
    /// No findings.
    const NONE: Self = Self([0; Finding::ALL.len()]);

    /// Returns how often `finding` was made.
    #[must_use]
    pub fn of(&self, finding: Finding) -> u16 {
        self.0.get(finding as usize).copied().unwrap_or_default()
    }

    /// Adds one to the count of `finding`.
    fn record(&mut self, finding: Finding) {
        if let Some(count) = self.0.get_mut(finding as usize) {
            *count = count.saturating_add(1);
        }
    }
}

/// The limits for a sensor's readings; [`ValidationRules`] checks them.
///
/// The papers give no numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ValidationConfig {
    /// The shortest distance that the sensor can measure.
    pub nearest: Millimeters,
    /// The longest distance that the sensor can measure.
    pub farthest: Millimeters,
    /// The largest change in one direction that noise alone can cause; a larger one is a jump unless
    /// motion explains it.
    pub jump: Millimeters,
    /// The highest speed at which objects approach or recede, the robot's own included, in mm/s.
    pub speed_mm_s: u32,
    /// The greatest age of a reading to compare with, in ms. For a swept sensor longer than a sweep,
    /// or no reading is ever compared.
    pub compare_within: u32,
    /// The greatest number of successive directions with an echo of the same raw value, or with *too near*.
    pub max_repeats: u16,
    /// The difference of raw values that noise alone causes: values as near as this to the first are the same.
    pub repeat_noise: u16,
}

impl ValidationConfig {
    /// The limits of a swept infrared sensor that returns to the same direction after `sweep_ms`.
    ///
    /// The jump is half of the range: of the pairs of readings at 80 cm by a unit with an error of 12 %
    /// (\[001\] Table 1, D), one in a hundred differs by more. A raw value may repeat for a whole sweep
    /// of `directions`: correct sensors measure the same distance in all directions only at the centre of
    /// a circle, and a flat wall gives a GP2D02 the same byte over at most 40°.
    #[must_use]
    pub const fn sweeping(
        nearest: Millimeters,
        farthest: Millimeters,
        speed_mm_s: u32,
        directions: u16,
        sweep_ms: u32,
    ) -> Self {
        Self {
            nearest,
            farthest,
            jump: Millimeters::new(farthest.saturating_sub(nearest).get() / 2),
            speed_mm_s,
            compare_within: sweep_ms.saturating_add(sweep_ms / 2),
            max_repeats: directions,
            repeat_noise: 0,
        }
    }
}

/// A checked [`ValidationConfig`].
///
/// Invariant: the range is not empty and fits 16 bits, and the jump and the number of repeats are
/// above zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ValidationRules(ValidationConfig);

/// Why a configuration was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ValidationError {
    /// The nearest distance is not below the farthest, or the farthest is above 65,535 mm.
    Range,
    /// The jump is zero, so that every change would be one.
    Jump,
    /// The number of repeats is zero, so that every echo would be stuck.
    Repeats,
}

impl ValidationError {
    const fn message(self) -> &'static str {
        match self {
            Self::Range => {
                "the nearest distance must be below the farthest, the farthest at most 65535 mm"
            }
            Self::Jump => "the jump must be above 0 mm",
            Self::Repeats => "the number of repeats must be above 0",
        }
    }
}

impl fmt::Display for ValidationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.message())
    }
}

impl core::error::Error for ValidationError {}

impl ValidationRules {
    /// Checks the configuration, for constants.
    ///
    /// # Panics
    ///
    /// For a configuration that [`Self::try_new`] refuses: a constant then does not build. Use that
    /// at run time.
    #[expect(clippy::panic, reason = "refuses a constant at compile time")]
    #[must_use]
    pub const fn new(config: ValidationConfig) -> Self {
        match Self::try_new(config) {
            Ok(rules) => rules,
            Err(error) => panic!("{}", error.message()),
        }
    }

    /// Checks the configuration.
    ///
    /// # Errors
    ///
    /// [`ValidationError`] names the limit that is out of range.
    pub const fn try_new(config: ValidationConfig) -> Result<Self, ValidationError> {
        let farthest = config.farthest.get();
        if config.nearest.get() >= farthest || farthest > u16::MAX as u32 {
            Err(ValidationError::Range)
        } else if config.jump.get() == 0 {
            Err(ValidationError::Jump)
        } else if config.max_repeats == 0 {
            Err(ValidationError::Repeats)
        } else {
            Ok(Self(config))
        }
    }

    /// Returns the configuration.
    #[must_use]
    pub const fn config(&self) -> &ValidationConfig {
        &self.0
    }

    /// The largest change that noise and `age` milliseconds of motion explain.
    fn explained(&self, age: u32) -> Millimeters {
        let moved = u64::from(age).wrapping_mul(self.0.speed_mm_s.into()) / 1000;
        self.0.jump + Millimeters::from_saturating(moved)
    }
}

/// Validates the readings of one sensor.
///
/// - **Out of range**: an echo nearer than the sensor's nearest or farther than its farthest
///   distance. It becomes *missing*.
/// - **Stuck**: the same raw value, but for [`ValidationConfig::repeat_noise`], gives an echo in more than
///   [`ValidationConfig::max_repeats`] successive directions, or every reading is *too near*. It becomes
///   *missing*, until another one comes. *No object* is never stuck: a correct unit without an object in range
///   gives the same value for a whole sweep. A fixed sensor, which may face a wall for hours, is never stuck;
///   of one without raw values only *too near* is.
/// - **Jump**: one reading is remembered until the sensor returns to its direction, then the next one
///   is. So a swept sensor has one direction compared in each sweep, and all of them over time; a
///   fixed sensor has every reading compared. Neighbouring directions are not compared: at the edge
///   of an object they differ by any distance. The reading is unchanged, because an object may have
///   moved into the beam. *No object* counts as the farthest distance or more, *too near* as the
///   nearest or less.
///
/// Memory: 28 bytes. Cost: comparisons and one multiplication of 64 bits a reading.
///
/// ```
/// use certainty_core::transducer::{
///     Finding, Missing, Reading, ValidationConfig, ValidationRules, Validator,
/// };
/// use certainty_core::units::{BinaryAngle, Millimeters, Ticks};
///
/// let mm = Millimeters::new;
/// let config = ValidationConfig::sweeping(mm(100), mm(800), 500, 37, 9250);
/// let rules = ValidationRules::new(config);
/// let mut validator = Validator::new();
///
/// let ahead = BinaryAngle::QUARTER;
/// let far = validator.validate(&rules, Reading::Echo(mm(900)), None, ahead, Ticks::new(0));
/// assert_eq!(far.finding, Finding::OutOfRange);
/// assert_eq!(far.reading, Reading::Missing(Missing::Implausible));
/// assert_eq!(validator.counts().of(Finding::OutOfRange), 1);
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
    /// Successive directions with what is `repeated`.
    repeats: u16,
    repeated: Repeated,
    remembered: Remembered,
}

/// The kind of the remembered reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum Remembered {
    Nothing,
    Echo,
    NoObject,
    TooNear,
}

/// What repeats in successive directions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum Repeated {
    /// The first of nearly equal raw values with an echo.
    Raw(u16),
    /// *Too near*, whatever its raw value.
    Near,
}

impl Repeated {
    /// Whether `other` is the same but for `noise`.
    const fn is(self, other: Self, noise: u16) -> bool {
        match (self, other) {
            (Self::Raw(one), Self::Raw(other)) => one.abs_diff(other) <= noise,
            (Self::Near, Self::Near) => true,
            (Self::Raw(_), Self::Near) | (Self::Near, Self::Raw(_)) => false,
        }
    }
}

impl Validator {
    /// Creates the validator of a sensor without readings yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            remembered_at: Ticks::new(0),
            remembered_bearing: BinaryAngle::ZERO,
            remembered_distance: 0,
            counts: FindingCounts::NONE,
            bearing: BinaryAngle::ZERO,
            repeats: 0,
            repeated: Repeated::Near,
            remembered: Remembered::Nothing,
        }
    }

    /// Labels a reading and replaces an implausible one by *missing*.
    ///
    /// `raw` is the number that the reading was converted from, if the sensor has one; `bearing` is the
    /// direction of the beam in the frame in which the surroundings rest: the map's if the robot turns.
    /// The same direction must be the same angle to the bit, as those of a
    /// [`Sweep`](super::Sweep) are.
    ///
    /// The first rule that is broken gives the label: out of range, stuck, jump.
    pub fn validate(
        &mut self,
        rules: &ValidationRules,
        reading: Reading,
        raw: Option<u16>,
        bearing: BinaryAngle,
        now: Ticks,
    ) -> Validated {
        let config = rules.config();
        let finding = match reading {
            // Nothing was measured: the remembered reading stays.
            Reading::Missing(_) => Finding::Missing,
            Reading::Echo(_) | Reading::NoObject | Reading::TooNear => {
                let repeats = self.count_repeats(reading, raw, config.repeat_noise, bearing);
                let stuck = repeats > config.max_repeats;
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

    /// Returns the number of readings with each finding.
    #[must_use]
    pub const fn counts(&self) -> FindingCounts {
        self.counts
    }

    /// Returns in how many successive directions, this one included, the sensor gave the same value.
    fn count_repeats(
        &mut self,
        reading: Reading,
        raw: Option<u16>,
        noise: u16,
        bearing: BinaryAngle,
    ) -> u16 {
        let value = match reading {
            Reading::Echo(_) => raw.map(Repeated::Raw),
            Reading::TooNear => Some(Repeated::Near),
            Reading::NoObject | Reading::Missing(_) => None,
        };
        self.repeats = match value {
            Some(value) if self.repeats > 0 && value.is(self.repeated, noise) => {
                // Another measurement in the same direction may well give the same value.
                let turned = bearing != self.bearing;
                self.repeats.saturating_add(turned.into())
            }
            Some(value) => {
                self.repeated = value;
                1
            }
            None => 0,
        };
        self.repeats
    }

    /// Returns whether the reading differs too much from the remembered one of this direction.
    /// Remembers it if the memory is empty or too old, or if the sensor is fixed.
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
                    self.remember(reading, bearing, now); // a fixed sensor: compare each with the last
                } else {
                    self.remembered = Remembered::Nothing; // a swept one: remember the next direction
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
                // An echo in range fits 16 bits.
                self.remembered_distance = u16::try_from(distance.get()).unwrap_or(u16::MAX);
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

/// The smallest change of distance that explains both readings.
fn least_change(before: Reading, after: Reading, config: &ValidationConfig) -> Millimeters {
    // The interval that the object is in.
    let interval = |reading| match reading {
        Reading::Echo(distance) => (distance, distance),
        Reading::TooNear => (Millimeters::ZERO, config.nearest),
        Reading::NoObject => (config.farthest, Millimeters::MAX),
        Reading::Missing(_) => (Millimeters::ZERO, Millimeters::MAX),
    };
    let ((from, to), (nearest, farthest)) = (interval(before), interval(after));
    (nearest - to).max(from - farthest)
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
    const RULES: ValidationRules = ValidationRules::new(CONFIG);

    fn degrees(degrees: i32) -> BinaryAngle {
        BinaryAngle::from_millidegrees(degrees * 1000)
    }

    fn sweep() -> Sweep {
        Sweep::try_new(degrees(-90), degrees(90), DIRECTIONS).unwrap()
    }

    fn unit() -> Calibration {
        Calibration::try_new(13_000, mm(0), U8F8::lit("60"), mm(100), mm(800)).unwrap()
    }

    /// A sensor on a pivoted head, round after round, with its validator.
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

        fn validate(&mut self, reading: Reading, raw: Option<u16>) -> Validated {
            let bearing = sweep().direction(self.round, 0, 1);
            self.validate_at(bearing, reading, raw)
        }

        fn validate_at(
            &mut self,
            bearing: BinaryAngle,
            reading: Reading,
            raw: Option<u16>,
        ) -> Validated {
            let now = Ticks::new(self.round * ROUND_MS);
            self.round += 1;
            self.validator
                .validate(&self.rules, reading, raw, bearing, now)
        }

        fn measure(&mut self, raw: u8) -> Finding {
            self.validate(unit().reading(raw), Some(raw.into())).finding
        }

        fn count(&self, finding: Finding) -> u16 {
            self.validator.counts().of(finding)
        }
    }

    #[test]
    fn a_validator_takes_28_bytes() {
        assert_eq!(size_of::<Validator>(), 28);
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
            let validated = head.validate(Reading::Echo(mm(distance)), None);
            assert_eq!(validated.finding, finding, "{distance} mm");
            let expected = match finding {
                Finding::OutOfRange => Reading::Missing(Missing::Implausible),
                _ => Reading::Echo(mm(distance)),
            };
            assert_eq!(validated.reading, expected);
        }
    }

    #[test]
    fn a_missing_reading_keeps_its_reason() {
        let mut head = Head::new();
        for reason in [Missing::Timeout, Missing::Bus, Missing::Implausible] {
            let validated = head.validate(Reading::Missing(reason), Some(0xFF));
            assert_eq!(validated.reading, Reading::Missing(reason));
            assert_eq!(validated.finding, Finding::Missing);
        }
        assert_eq!(head.count(Finding::Missing), 3);
    }

    #[test]
    fn the_same_byte_for_more_than_a_sweep_is_stuck() {
        let mut head = Head::new();
        for number in 1..=100 {
            let raw = 90;
            let validated = head.validate(unit().reading(raw), Some(raw.into()));
            let stuck = number > DIRECTIONS;
            assert_eq!(
                validated.finding == Finding::StuckAt,
                stuck,
                "reading {number}"
            );
            assert_eq!(matches!(validated.reading, Reading::Missing(_)), stuck);
        }
        // Another byte ends it.
        assert_eq!(head.measure(95), Finding::Plausible);
        assert_eq!(head.count(Finding::StuckAt), 100 - DIRECTIONS);
    }

    /// 250 mm with 1 % of noise is within two bytes of a GP2D02.
    #[test]
    fn a_stuck_sensor_with_noise_is_stuck() {
        let mut head = Head::with(ValidationConfig {
            repeat_noise: 2,
            ..CONFIG
        });
        let bytes = [112, 111, 113, 112, 114, 110].into_iter().cycle();
        let found = bytes.map(|raw| head.measure(raw)).take(100);
        let stuck = found.filter(|&finding| finding == Finding::StuckAt);
        assert_eq!(stuck.count(), 100 - usize::from(DIRECTIONS));
    }

    /// An object nearer than the range in every direction is no surroundings but a fault.
    #[test]
    fn too_near_for_more_than_a_sweep_is_stuck() {
        let mut head = Head::new();
        for number in 1..=100 {
            let raw = 230 + number % 20;
            let finding = head.validate(Reading::TooNear, Some(raw)).finding;
            assert_eq!(finding == Finding::StuckAt, number > DIRECTIONS, "{number}");
        }
        let mut without_raw = Head::new();
        let found = (0..100).map(|_| without_raw.validate(Reading::TooNear, None).finding);
        assert!(
            found
                .skip(DIRECTIONS.into())
                .all(|finding| finding == Finding::StuckAt)
        );
    }

    #[test]
    fn no_raw_value_passes_for_too_near() {
        let mut head = Head::with(ValidationConfig {
            repeat_noise: u16::MAX,
            ..CONFIG
        });
        for number in 0..100 {
            let reading = if number % 2 == 0 {
                Reading::TooNear
            } else {
                Reading::Echo(mm(300))
            };
            let finding = head.validate(reading, Some(u16::MAX)).finding;
            assert_ne!(finding, Finding::StuckAt);
        }
    }

    #[test]
    fn missing_readings_do_not_end_being_stuck() {
        let mut head = Head::new();
        for _ in 0..DIRECTIONS {
            head.measure(90);
            let _ = head.validate(Reading::Missing(Missing::Timeout), None);
        }
        assert_eq!(head.measure(90), Finding::StuckAt);
    }

    #[test]
    fn no_object_for_ten_sweeps_is_not_stuck() {
        let mut head = Head::new();
        for _ in 0..10 * DIRECTIONS {
            assert_eq!(unit().reading(62), Reading::NoObject);
            assert_eq!(head.measure(62), Finding::Plausible);
        }
    }

    #[test]
    fn a_fixed_sensor_at_a_wall_is_not_stuck() {
        let mut head = Head::new();
        for _ in 0..1000 {
            let ahead = BinaryAngle::QUARTER;
            let validated = head.validate_at(ahead, unit().reading(90), Some(90));
            assert_eq!(validated.finding, Finding::Plausible);
        }
    }

    #[test]
    fn a_sensor_without_raw_bytes_is_not_stuck() {
        let mut head = Head::new();
        for _ in 0..100 {
            let validated = head.validate(Reading::Echo(mm(300)), None);
            assert_eq!(validated.finding, Finding::Plausible);
        }
    }

    /// The reason for allowing a whole sweep; without noise, which would shorten the repeats.
    #[test]
    fn a_wall_gives_the_same_byte_over_at_most_40_degrees() {
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
    fn a_change_that_motion_cannot_explain_is_a_jump() {
        // Two readings 250 ms apart at 400 mm/s: half of 700 mm and 100 mm.
        let validated = |distance: u32| {
            let mut head = Head::with(ValidationConfig {
                speed_mm_s: 400,
                ..CONFIG
            });
            let ahead = BinaryAngle::QUARTER;
            let _ = head.validate_at(ahead, Reading::Echo(mm(200)), None);
            head.validate_at(ahead, Reading::Echo(mm(distance)), None)
        };
        assert_eq!(validated(650).finding, Finding::Plausible);
        let jump = validated(651);
        assert_eq!(jump.finding, Finding::Jump);
        assert_eq!(jump.reading, Reading::Echo(mm(651)), "unchanged");
    }

    #[test]
    fn no_object_and_too_near_jump_as_intervals() {
        let jumps = |before, after| {
            let mut head = Head::new();
            let ahead = BinaryAngle::QUARTER;
            let _ = head.validate_at(ahead, before, None);
            head.validate_at(ahead, after, None).finding == Finding::Jump
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
            assert_eq!(jumps(before, after), jump, "{before:?} to {after:?}");
            assert_eq!(jumps(after, before), jump, "{after:?} to {before:?}");
        }
    }

    #[test]
    fn the_edges_of_resting_objects_are_no_jumps() {
        let mut head = Head::new();
        for _ in 0..5 * DIRECTIONS {
            let near = head.round % u32::from(DIRECTIONS) % 4 < 2;
            let distance = if near { 150 } else { 790 };
            let validated = head.validate(Reading::Echo(mm(distance)), None);
            assert_eq!(validated.finding, Finding::Plausible);
        }
    }

    /// One direction is compared a sweep, and the next one the sweep after.
    #[test]
    fn a_jump_in_any_direction_is_found_in_time() {
        let directions = u32::from(DIRECTIONS);
        for restless in 0..directions {
            let mut head = Head::new();
            for _ in 0..(directions + 2) * directions {
                // In this direction every sweep measures another distance.
                let (sweep, step) = (head.round / directions, head.round % directions);
                let near = step == restless && sweep % 2 == 0;
                let distance = if near { 150 } else { 700 };
                let finding = head.validate(Reading::Echo(mm(distance)), None).finding;
                assert!(finding == Finding::Plausible || step == restless);
            }
            assert_eq!(head.count(Finding::Jump), 1, "direction {restless}");
        }
    }

    #[test]
    fn an_old_reading_is_not_compared() {
        let validated = |later: u32| {
            let mut validator = Validator::new();
            let mut validate = |distance, now| {
                let reading = Reading::Echo(mm(distance));
                validator.validate(&RULES, reading, None, BinaryAngle::ZERO, Ticks::new(now))
            };
            let _ = validate(150, 0);
            validate(700, later).finding
        };
        assert_eq!(validated(CONFIG.compare_within), Finding::Jump);
        assert_eq!(validated(CONFIG.compare_within + 1), Finding::Plausible);
    }

    #[test]
    fn counts_saturate() {
        let mut head = Head::new();
        for _ in 0..70_000_u32 {
            let _ = head.validate(Reading::Missing(Missing::Bus), None);
        }
        assert_eq!(head.count(Finding::Missing), u16::MAX);
        assert_eq!(head.count(Finding::Plausible), 0);
    }

    #[test]
    fn bad_limits_are_refused() {
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
        let max_repeats = 0;
        assert_eq!(
            refused(ValidationConfig {
                max_repeats,
                ..CONFIG
            }),
            ValidationError::Repeats
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
        /// For any readings: one changes exactly if its finding says so, and every finding is counted.
        #[test]
        fn findings_agree_with_the_definitions(
            readings in proptest::collection::vec(
                (any_reading(), 88_u16..90, 0_i32..3, 0_u32..9000),
                0..300,
            ),
            max_repeats in 1_u16..6,
        ) {
            let rules = ValidationRules::try_new(ValidationConfig { max_repeats, ..CONFIG }).unwrap();
            let mut validator = Validator::new();
            let mut expected_counts = [0_u16; Finding::ALL.len()];
            let mut now = 0_u32;
            let mut run = Vec::new(); // of equal values, each with its direction
            for (reading, raw, bearing, later) in readings {
                now = now.wrapping_add(later);
                let Validated { reading: passed, finding } =
                    validator.validate(&rules, reading, Some(raw), degrees(bearing), Ticks::new(now));
                expected_counts[finding as usize] += 1;

                let value = if reading == Reading::TooNear { u16::MAX } else { raw };
                match reading {
                    Reading::Echo(_) | Reading::TooNear => {
                        if run.last().is_some_and(|&(before, _)| before != value) {
                            run.clear();
                        }
                        run.push((value, bearing));
                        run.dedup();
                    }
                    Reading::NoObject => run.clear(),
                    Reading::Missing(_) => {}
                }
                let in_range =
                    !matches!(reading, Reading::Echo(d) if !(100..=800).contains(&d.get()));
                let stuck = run.len() > usize::from(max_repeats)
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
                prop_assert_eq!(validator.counts().of(finding), expected_counts[finding as usize]);
            }
        }
    }
}
