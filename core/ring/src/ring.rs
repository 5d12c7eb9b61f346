//! The ring: its sonars, the echo paths between them, and the limits within which echoes agree
//! (\[003\] §2, §4).

use super::geometry::{FinePoint, sixteenths};
use certainty_core::health::{Confidence, FaultAttribution, Learning, StepRule};
use certainty_core::sensor::SensorId;
use certainty_core::units::{BinaryAngle, Direction, Millimeters};
use core::fmt;
use fixed::types::U0F16;

/// The number of neighbours on each side that receive a sonar's pulse (\[003\] §4).
pub const NEIGHBOURS: u8 = 3;

/// The number of orders of echo paths: direct, and across to each of the neighbours on one side.
pub(super) const ORDERS: usize = NEIGHBOURS as usize + 1;

/// The dimensions of a ring of sonars; [`Ring`] checks them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RingConfig {
    /// Distance of the sonars from the robot's centre.
    pub radius: Millimeters,
    /// Bearing of sonar 1 in the robot's frame; the others follow counter-clockwise.
    pub first: BinaryAngle,
    /// Full opening angle of a sonar's cone, both sending and receiving, in thousandths of a degree.
    ///
    /// Not a [`BinaryAngle`]: which cones overlap must not depend on rounding.
    pub opening_millidegrees: u32,
    /// Range of the sonars; a path without an echo counts as this distance.
    pub range: Millimeters,
}

impl RingConfig {
    /// \[003\] §2, §4: cones of 60° and a range of 2 m. Not in the text: the radius of 0.3 m, which is that
    /// of the robot named there, and that sonar 1 faces ahead.
    pub const DEFAULT: Self = Self {
        radius: Millimeters::new(300),
        first: BinaryAngle::ZERO,
        opening_millidegrees: 60_000,
        range: Millimeters::new(2000),
    };
}

impl Default for RingConfig {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// A ring of `SENSORS` sonars, 7 to 120, at equal angles around the robot, numbered from 1
/// counter-clockwise.
///
/// Possession proves that nothing computed from its lengths and angles overflows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ring<const SENSORS: usize>(RingConfig);

/// The dimension of a ring that is out of range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RingConfigError {
    /// The radius is zero or above a metre.
    Radius,
    /// The opening is zero or above 120°.
    Opening,
    /// The range is zero or above 8 m.
    Range,
}

impl RingConfigError {
    const fn message(self) -> &'static str {
        match self {
            Self::Radius => "a ring's radius must be from 1mm to 1m",
            Self::Opening => "a sonar's opening must be above 0deg and at most 120deg",
            Self::Range => "a sonar's range must be from 1mm to 8m",
        }
    }
}

impl fmt::Display for RingConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.message())
    }
}

impl core::error::Error for RingConfigError {}

/// An echo path: from a sonar back to itself, or across between two neighbours.
///
/// A cross path is the same in both directions. It is named by its clockwise end: `S₃/S₅` is sonar 3 with
/// order 2.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Path {
    /// Slot of the sonar in the ring, from 0.
    from: u8,
    order: u8,
}

impl Path {
    pub(super) const fn new(from: u8, order: u8) -> Self {
        Self { from, order }
    }

    /// Returns the path's sonar; for a cross path, the clockwise one.
    #[must_use]
    pub const fn from(self) -> Option<SensorId> {
        SensorId::from_slot(self.from as usize)
    }

    /// Returns the number of slots from one sonar to the other: 0 for the direct echo, up to
    /// [`NEIGHBOURS`].
    #[must_use]
    pub const fn order(self) -> u8 {
        self.order
    }

    pub(super) const fn slot(self) -> u8 {
        self.from
    }
}

/// A sonar of the ring: its position, and the borders of its cone.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sonar {
    pub at: FinePoint,
    right: Direction,
    left: Direction,
}

impl Sonar {
    /// Whether `point` is within the sonar's cone.
    pub(super) const fn covers(&self, point: FinePoint) -> bool {
        let to = point.minus(self.at);
        // A cone of less than half a turn is left of the one border and right of the other.
        to.left_of(self.right) >= 0 && to.left_of(self.left) <= 0
    }
}

/// A full turn in thousandths of a degree.
const TURN: u32 = 360_000;

impl<const SENSORS: usize> Ring<SENSORS> {
    /// Number of slots; more than a sonar and its neighbours take.
    pub(super) const SLOTS: u8 = {
        assert!(SENSORS > 2 * NEIGHBOURS as usize && SENSORS <= 120);
        #[expect(clippy::cast_possible_truncation, reason = "at most 120")]
        let slots = SENSORS as u8;
        slots
    };

    /// Creates a ring, for constants.
    ///
    /// ```
    /// use certainty_ring::{Ring, RingConfig};
    ///
    /// const RING: Ring<24> = Ring::new(RingConfig::DEFAULT);
    /// assert_eq!(RING.paths().count(), 96);
    /// ```
    ///
    /// # Panics
    ///
    /// For dimensions that [`Self::try_new`] refuses: a constant then does not build. Use that at run
    /// time.
    #[expect(clippy::panic, reason = "refuses a constant at compile time")]
    #[must_use]
    pub const fn new(config: RingConfig) -> Self {
        match Self::try_new(config) {
            Ok(ring) => ring,
            Err(error) => panic!("{}", error.message()),
        }
    }

    /// Creates a ring.
    ///
    /// # Errors
    ///
    /// [`RingConfigError`] names the dimension that is out of range.
    pub const fn try_new(config: RingConfig) -> Result<Self, RingConfigError> {
        let opening = config.opening_millidegrees;
        if config.radius.get() == 0 || config.radius.get() > 1000 {
            Err(RingConfigError::Radius)
        } else if opening == 0 || opening > 120_000 {
            Err(RingConfigError::Opening)
        } else if config.range.get() == 0 || config.range.get() > 8000 {
            Err(RingConfigError::Range)
        } else {
            Ok(Self(config))
        }
    }

    /// Returns the configuration.
    #[must_use]
    pub const fn config(&self) -> &RingConfig {
        &self.0
    }

    /// Returns the numbers of all sonars.
    pub fn sensors(&self) -> impl Iterator<Item = SensorId> + use<SENSORS> {
        (0..SENSORS).filter_map(SensorId::from_slot)
    }

    /// Returns the bearing of a sonar in the robot's frame.
    #[must_use]
    pub const fn bearing(&self, sensor: SensorId) -> BinaryAngle {
        let twice = (sensor.slot() as u64).wrapping_mul(2);
        self.0.first.wrapping_add(Self::halves(twice))
    }

    /// Returns all echo paths: 24 direct and 72 cross paths in the paper's ring.
    pub fn paths(&self) -> impl Iterator<Item = Path> + use<SENSORS> {
        let orders = 0..=self.most_order();
        orders.flat_map(|order| (0..Self::SLOTS).map(move |from| Path { from, order }))
    }

    /// Returns the axis of the cone that the path's sonars share, in the robot's frame.
    #[must_use]
    pub const fn middle(&self, path: Path) -> BinaryAngle {
        let twice = (path.from as u64).wrapping_mul(2);
        let halves = twice.wrapping_add(path.order as u64);
        self.0.first.wrapping_add(Self::halves(halves))
    }

    /// The angle of a number of half spacings, rounded to nearest.
    const fn halves(halves: u64) -> BinaryAngle {
        let around = (Self::SLOTS as u64).wrapping_mul(2);
        let steps = (halves << 16).wrapping_add(Self::SLOTS as u64);
        let steps = match steps.checked_div(around) {
            Some(steps) => steps,
            None => 0,
        };
        // A full turn is 2^16 steps: the low 16 bits are the angle.
        let [low, high, ..] = steps.to_le_bytes();
        BinaryAngle::from_bits(u16::from_le_bytes([low, high]))
    }

    /// The largest order at which two cones overlap.
    pub(super) const fn most_order(&self) -> u8 {
        let mut order = 0;
        while order < NEIGHBOURS && self.shared(order.wrapping_add(1)) > 0 {
            order = order.wrapping_add(1);
        }
        order
    }

    /// The angle shared by the cones of two sonars at infinity, 60°, 45°, 30° or 15° (\[003\] §4), times the
    /// number of sonars, in thousandths of a degree.
    ///
    /// Range: at most 120° of 120 sonars, 14.4 million.
    const fn shared(&self, order: u8) -> i32 {
        let opening = self.0.opening_millidegrees.cast_signed();
        let opening = opening.wrapping_mul(Self::SLOTS as i32);
        opening.wrapping_sub((order as i32).wrapping_mul(TURN.cast_signed()))
    }

    /// Half of the angle shared by the cones at infinity, in steps of a [`BinaryAngle`], rounded up.
    pub(super) fn half_width(&self, order: u8) -> u16 {
        let shared = self.shared(order);
        if shared <= 0 {
            return 0;
        }
        let turns = (Self::SLOTS as u64).wrapping_mul(TURN as u64);
        let turns = turns.wrapping_mul(2);
        let steps = (u64::from(shared.unsigned_abs()) << 16).checked_div(turns);
        // At most 60°, which fits.
        steps.map_or(0, |steps| {
            u16::try_from(steps.wrapping_add(1)).unwrap_or(u16::MAX)
        })
    }

    /// Whether the detection ranges of two paths overlap at infinity, touching not included (\[003\] §6).
    ///
    /// They do if their axes are less than the sum of their half widths apart, compared exactly, in
    /// thousandths of a degree times the number of sonars.
    pub(super) const fn overlap(&self, one: Path, other: Path) -> bool {
        let (a, b) = (self.shared(one.order), self.shared(other.order));
        let apart = Self::half_spacings(one).wrapping_sub(Self::half_spacings(other));
        let around = (Self::SLOTS as i32).wrapping_mul(2);
        let Some(apart) = apart.checked_rem_euclid(around) else {
            return false;
        };
        let back = around.wrapping_sub(apart);
        let apart = if back < apart { back } else { apart };
        // Both sides doubled: half a spacing is TURN / 2, half a width `shared` / 2.
        a > 0 && b > 0 && apart.wrapping_mul(TURN.cast_signed()) < a.wrapping_add(b)
    }

    /// The axis of a path, in half spacings from sonar 1.
    const fn half_spacings(path: Path) -> i32 {
        let twice = (path.from as i32).wrapping_mul(2);
        twice.wrapping_add(path.order as i32)
    }

    /// The slot `places` after `slot`; `places` may be negative.
    pub(super) const fn slot_after(slot: u8, places: i16) -> u8 {
        let place = (slot as i16).wrapping_add(places);
        match place.checked_rem_euclid(Self::SLOTS as i16) {
            Some(place) => {
                let [low, _] = place.to_le_bytes();
                low
            }
            None => slot,
        }
    }

    /// The slots of the path's two sonars, which are equal if it is direct.
    pub(super) const fn ends(path: Path) -> [u8; 2] {
        [path.from, Self::slot_after(path.from, path.order as i16)]
    }

    /// The path's two sonars with their cones.
    pub(super) fn sonars(&self, path: Path) -> [Sonar; 2] {
        let [from, to] = Self::ends(path);
        let from = self.sonar(from);
        [
            from,
            if path.order == 0 {
                from
            } else {
                self.sonar(to)
            },
        ]
    }

    fn sonar(&self, slot: u8) -> Sonar {
        let axis = self.middle(Path::new(slot, 0));
        let half = self.half_width(0);
        let half = BinaryAngle::from_bits(half);
        Sonar {
            at: FinePoint::polar(sixteenths(self.0.radius), axis.direction()),
            right: axis.wrapping_sub(half).direction(),
            left: axis.wrapping_add(half).direction(),
        }
    }

    /// The distance of the chord between two sonars from the robot's centre, and half its length, both in
    /// sixteenths of a millimetre.
    pub(super) const fn chord(&self, order: u8) -> (u64, u64) {
        let half = Self::halves(order as u64).direction();
        let radius = sixteenths(self.0.radius);
        let chord = FinePoint::polar(radius, half);
        (
            chord.x().unsigned_abs() as u64,
            chord.y().unsigned_abs() as u64,
        )
    }

    /// tan of half the opening, in steps of 2^-14: the largest slope of an arc against the circle around
    /// the robot.
    pub(super) fn steepest(&self) -> u64 {
        let half = BinaryAngle::from_bits(self.half_width(0)).direction();
        let tangent = (i64::from(half.sin()) << 14).checked_div(half.cos().into());
        tangent.map_or(0, |tangent| tangent.unsigned_abs().wrapping_add(1))
    }
}

/// The limits within which echoes agree; [`RingRules`] checks them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RingRulesConfig {
    /// The two directions of a cross path contradict each other if their distances differ by this or more.
    pub consistent: Millimeters,
    /// A simulated and a measured distance agree if they differ by less than this.
    pub uncertainty: Millimeters,
    /// Two arcs intersect if they come this close to each other, or closer.
    pub touch: Millimeters,
    /// A sonar with fewer confirmations than this is declared faulty.
    pub least: u8,
    /// How much an assessment that confirms a sonar raises its confidence.
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub raise: U0F16,
    /// How much an assessment that does not confirm a sonar lowers its confidence.
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub lower: U0F16,
}

impl RingRulesConfig {
    /// \[003\] §5, §7: an uncertainty of 0.1 m, and one confirmation is enough.
    ///
    /// The paper leaves the rest open. The two directions of a path may differ by 0.1 m too; arcs intersect
    /// within a millimetre, the resolution of an echo. One assessment against a sonar makes it *suspect*, a
    /// second one *failed*, and six that confirm it make it *healthy*: confidence falls faster than it rises
    /// (\[002\] §4).
    pub const DEFAULT: Self = Self {
        consistent: Millimeters::new(100),
        uncertainty: Millimeters::new(100),
        touch: Millimeters::new(1),
        least: 1,
        raise: U0F16::lit("0.084"),
        lower: U0F16::lit("0.8"),
    };

    /// Differs from \[003\] §7: a sonar needs three confirmations, so that one or two accidental ones do not
    /// clear a faulty sonar. Use it only in rooms where every sound sonar has as many: in the paper's example
    /// two sound sonars have one and two, and would be declared faulty.
    pub const WARY: Self = Self {
        least: 3,
        ..Self::DEFAULT
    };
}

impl Default for RingRulesConfig {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The checked [`RingRulesConfig`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RingRules(RingRulesConfig);

/// The limit that is out of range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RingRulesError {
    /// `consistent` or `uncertainty` is zero: no two distances differ by less.
    Difference,
    /// `touch` is a metre or more.
    Touch,
    /// `raise` or `lower` is zero.
    Step,
    /// `least` is zero: no sonar would ever be declared faulty.
    Least,
}

impl RingRulesError {
    const fn message(self) -> &'static str {
        match self {
            Self::Difference => "the difference of agreeing distances must be at least 1mm",
            Self::Touch => "the distance of intersecting arcs must be below 1m",
            Self::Step => "the steps of a confidence must be above zero",
            Self::Least => "a sonar must need at least one confirmation",
        }
    }
}

impl fmt::Display for RingRulesError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.message())
    }
}

impl core::error::Error for RingRulesError {}

impl RingRules {
    /// The rules of [`RingRulesConfig::DEFAULT`].
    pub const DEFAULT: Self = Self::new(RingRulesConfig::DEFAULT);

    /// The rules of [`RingRulesConfig::WARY`].
    pub const WARY: Self = Self::new(RingRulesConfig::WARY);

    /// Creates rules, for constants.
    ///
    /// # Panics
    ///
    /// For limits that [`Self::try_new`] refuses: a constant then does not build. Use that at run
    /// time.
    #[expect(clippy::panic, reason = "refuses a constant at compile time")]
    #[must_use]
    pub const fn new(config: RingRulesConfig) -> Self {
        match Self::try_new(config) {
            Ok(rules) => rules,
            Err(error) => panic!("{}", error.message()),
        }
    }

    /// Creates rules.
    ///
    /// # Errors
    ///
    /// [`RingRulesError`] names the limit that is out of range.
    pub const fn try_new(config: RingRulesConfig) -> Result<Self, RingRulesError> {
        if config.consistent.get() == 0 || config.uncertainty.get() == 0 {
            Err(RingRulesError::Difference)
        } else if config.touch.get() >= 1000 {
            Err(RingRulesError::Touch)
        } else if config.raise.to_bits() == 0 || config.lower.to_bits() == 0 {
            Err(RingRulesError::Step)
        } else if config.least == 0 {
            Err(RingRulesError::Least)
        } else {
            Ok(Self(config))
        }
    }

    /// Returns the configuration.
    #[must_use]
    pub const fn config(&self) -> &RingRulesConfig {
        &self.0
    }

    /// How a verdict changes a sonar's confidence: by fixed steps, the same for every claim.
    pub(super) const fn learning(&self) -> Learning {
        Learning {
            raise: self.0.raise,
            raise_free: self.0.raise,
            lower: self.0.lower,
            step_rule: StepRule::Fixed,
            attribution: FaultAttribution::Alike,
            floor: Confidence::NONE,
            ceiling: Confidence::FULL,
        }
    }
}

impl Default for RingRules {
    fn default() -> Self {
        Self::DEFAULT
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dimensions_out_of_range_are_refused() {
        let base = RingConfig::DEFAULT;
        let mm = Millimeters::new;
        for (config, error) in [
            (
                RingConfig {
                    radius: mm(0),
                    ..base
                },
                RingConfigError::Radius,
            ),
            (
                RingConfig {
                    radius: mm(1001),
                    ..base
                },
                RingConfigError::Radius,
            ),
            (
                RingConfig {
                    opening_millidegrees: 0,
                    ..base
                },
                RingConfigError::Opening,
            ),
            (
                RingConfig {
                    opening_millidegrees: 120_001,
                    ..base
                },
                RingConfigError::Opening,
            ),
            (
                RingConfig {
                    range: mm(0),
                    ..base
                },
                RingConfigError::Range,
            ),
            (
                RingConfig {
                    range: mm(8001),
                    ..base
                },
                RingConfigError::Range,
            ),
        ] {
            assert_eq!(Ring::<24>::try_new(config), Err(error));
        }
        assert_eq!(Ring::<24>::try_new(base), Ok(Ring::new(base)));
    }

    #[test]
    fn rules_out_of_range_are_refused() {
        let base = RingRulesConfig::DEFAULT;
        let zero = Millimeters::ZERO;
        let zeroes = [
            RingRulesConfig {
                consistent: zero,
                ..base
            },
            RingRulesConfig {
                uncertainty: zero,
                ..base
            },
        ];
        for config in zeroes {
            assert_eq!(RingRules::try_new(config), Err(RingRulesError::Difference));
        }
        let touch = RingRulesConfig {
            touch: Millimeters::new(1000),
            ..base
        };
        assert_eq!(RingRules::try_new(touch), Err(RingRulesError::Touch));
        let step = RingRulesConfig {
            lower: U0F16::ZERO,
            ..base
        };
        assert_eq!(RingRules::try_new(step), Err(RingRulesError::Step));
        let none = RingRulesConfig { least: 0, ..base };
        assert_eq!(RingRules::try_new(none), Err(RingRulesError::Least));
        assert_eq!(RingRules::try_new(base), Ok(RingRules::DEFAULT));
    }
}
