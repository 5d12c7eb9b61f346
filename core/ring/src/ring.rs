//! Sonars around the robot, and which of them hear each other (\[003\] §2, §4).

use super::place::{FinePoint, sixteenths};
use certainty_core::narrow::{saturating_u16_of_u64, wrapping_u16, wrapping_u32};
use certainty_core::sensor::SensorId;
use certainty_core::units::{BinaryAngle, Direction, Millimeters};
use core::fmt;

/// How many neighbours on each side may hear a sonar's pulse (\[003\] §4).
pub const NEIGHBOURS: u8 = 3;

/// The orders of echo paths: direct, and across to each of the neighbours.
pub(super) const ORDERS: usize = NEIGHBOURS as usize + 1;

/// A ring of sonars, before it is checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RingConfig {
    /// How far the sonars sit from the robot's middle.
    pub radius: Millimeters,
    /// Where sonar 1 looks in the robot's frame; the others follow counter-clockwise.
    pub first: BinaryAngle,
    /// The full angle of the cone in which a sonar sends and hears, in thousandths of a degree.
    ///
    /// Not a [`BinaryAngle`]: which cones overlap must not hang on how an angle is rounded.
    pub opening_millidegrees: u32,
    /// The farthest distance that a sonar tells; no echo counts as this distance.
    pub range: Millimeters,
}

impl RingConfig {
    /// \[003\] §2, §4: cones of 60° and a range of 2 m. The radius of 0.3 m is that of the robot named
    /// there, and sonar 1 looks ahead; neither is in the text.
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

/// A ring of `SENSORS` sonars at equal angles around the robot, numbered from 1 counter-clockwise.
///
/// Possession proves that its lengths and angles are such that nothing computed from them overflows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ring<const SENSORS: usize>(RingConfig);

/// Why a ring was refused.
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

impl fmt::Display for RingConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Radius => "a ring's radius must be from 1mm to 1m",
            Self::Opening => "a sonar's opening must be above 0deg and at most 120deg",
            Self::Range => "a sonar's range must be from 1mm to 8m",
        })
    }
}

impl core::error::Error for RingConfigError {}

/// An echo path: from a sonar to itself, or across between it and one of its next neighbours.
///
/// A cross path is the same in both directions and is named by its clockwise end: `S₃/S₅` is sonar 3
/// with order 2.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Path {
    /// Place of the sonar in the ring, from 0.
    from: u8,
    order: u8,
}

impl Path {
    pub(super) const fn new(from: u8, order: u8) -> Self {
        Self { from, order }
    }

    /// Returns the path's sonar; of a cross path the clockwise one.
    #[must_use]
    pub const fn from(self) -> Option<SensorId> {
        SensorId::from_slot(self.from as usize)
    }

    /// Returns how many places on the other sonar is: 0 for the direct echo, up to [`NEIGHBOURS`].
    #[must_use]
    pub const fn order(self) -> u8 {
        self.order
    }

    pub(super) const fn slot(self) -> u8 {
        self.from
    }
}

/// A sonar of the ring: where it is, and the borders of its cone.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sonar {
    pub at: FinePoint,
    right: Direction,
    left: Direction,
}

impl Sonar {
    /// Whether the sonar sends to and hears from `place`.
    pub(super) const fn sees(&self, place: FinePoint) -> bool {
        let to = place.minus(self.at);
        // A cone of less than half a turn is what is left of the one border and right of the other.
        to.left_of(self.right) >= 0 && to.left_of(self.left) <= 0
    }
}

/// A turn in thousandths of a degree.
const TURN: u32 = 360_000;

impl<const SENSORS: usize> Ring<SENSORS> {
    /// Places on the ring, which must be more than a sonar with its neighbours takes.
    pub(super) const SLOTS: u8 = {
        assert!(SENSORS > 2 * NEIGHBOURS as usize && SENSORS <= 120);
        #[expect(clippy::cast_possible_truncation, reason = "at most 120")]
        let slots = SENSORS as u8;
        slots
    };

    /// Checks a ring of 7 to 120 sonars.
    ///
    /// # Errors
    ///
    /// [`RingConfigError`] names what cannot be.
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

    /// Returns every sonar's number.
    pub fn sensors(&self) -> impl Iterator<Item = SensorId> + use<SENSORS> {
        (0..SENSORS).filter_map(SensorId::from_slot)
    }

    /// Returns where a sonar looks, in the robot's frame.
    #[must_use]
    pub const fn bearing(&self, sensor: SensorId) -> BinaryAngle {
        let twice = (sensor.slot() as u64).wrapping_mul(2);
        self.0.first.wrapping_add(Self::halves(twice))
    }

    /// Returns every echo path: 24 direct ones and 72 across in the paper's ring.
    pub fn paths(&self) -> impl Iterator<Item = Path> + use<SENSORS> {
        let orders = 0..=self.most_order();
        orders.flat_map(|order| (0..Self::SLOTS).map(move |from| Path { from, order }))
    }

    /// Returns the middle of the cone that the path's sonars share, in the robot's frame.
    #[must_use]
    pub const fn middle(&self, path: Path) -> BinaryAngle {
        let twice = (path.from as u64).wrapping_mul(2);
        let halves = twice.wrapping_add(path.order as u64);
        self.0.first.wrapping_add(Self::halves(halves))
    }

    /// The angle of so many half spacings.
    const fn halves(halves: u64) -> BinaryAngle {
        let around = (Self::SLOTS as u64).wrapping_mul(2);
        let steps = (halves << 16).wrapping_add(Self::SLOTS as u64);
        let steps = match steps.checked_div(around) {
            Some(steps) => steps,
            None => 0,
        };
        // A turn is 2^16 steps, and turns do not matter.
        BinaryAngle::from_bits(wrapping_u16(wrapping_u32(steps.cast_signed())))
    }

    /// The largest order whose two cones overlap.
    pub(super) const fn most_order(&self) -> u8 {
        let mut order = 0;
        while order < NEIGHBOURS && self.shared(order.wrapping_add(1)) > 0 {
            order = order.wrapping_add(1);
        }
        order
    }

    /// The angle that the cones of two sonars share far away: 60°, 45°, 30° or 15° (\[003\] §4), times
    /// the number of sonars, in thousandths of a degree.
    ///
    /// Range: at most 120° of 120 sonars, 14.4 million.
    const fn shared(&self, order: u8) -> i32 {
        let opening = self.0.opening_millidegrees.cast_signed();
        let opening = opening.wrapping_mul(Self::SLOTS as i32);
        opening.wrapping_sub((order as i32).wrapping_mul(TURN.cast_signed()))
    }

    /// Half of the angle that the cones share far away, in steps of a [`BinaryAngle`], rounded up.
    pub(super) const fn half_width(&self, order: u8) -> u16 {
        let shared = self.shared(order);
        if shared <= 0 {
            return 0;
        }
        let turns = (Self::SLOTS as u64).wrapping_mul(TURN as u64);
        let turns = turns.wrapping_mul(2);
        match ((shared.unsigned_abs() as u64) << 16).checked_div(turns) {
            Some(steps) => saturating_u16_of_u64(steps.wrapping_add(1)),
            None => 0,
        }
    }

    /// Whether two paths' detection ranges overlap far away, touching not included (\[003\] §6).
    ///
    /// Their middles are less than the sum of their half widths apart: compared in thousandths of a
    /// degree times the number of sonars, exactly.
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

    /// Where a path's middle is, in half spacings from sonar 1.
    const fn half_spacings(path: Path) -> i32 {
        let twice = (path.from as i32).wrapping_mul(2);
        twice.wrapping_add(path.order as i32)
    }

    /// The place in the ring `places` on from `slot`, which may be less than none.
    pub(super) const fn on(slot: u8, places: i16) -> u8 {
        let place = (slot as i16).wrapping_add(places);
        match place.checked_rem_euclid(Self::SLOTS as i16) {
            Some(place) => {
                let [low, _] = place.to_le_bytes();
                low
            }
            None => slot,
        }
    }

    /// The path's two sonars, which are one if it is direct.
    pub(super) const fn ends(path: Path) -> [u8; 2] {
        [path.from, Self::on(path.from, path.order as i16)]
    }

    /// The path's two sonars with their cones.
    pub(super) const fn sonars(&self, path: Path) -> [Sonar; 2] {
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

    const fn sonar(&self, slot: u8) -> Sonar {
        let axis = self.middle(Path::new(slot, 0));
        let half = self.half_width(0);
        let half = BinaryAngle::from_bits(half);
        Sonar {
            at: FinePoint::polar(sixteenths(self.0.radius), axis.direction()),
            right: axis.wrapping_sub(half).direction(),
            left: axis.wrapping_add(half).direction(),
        }
    }

    /// How far the middle between two sonars is from the robot's middle, and half of how far they are
    /// apart, both in sixteenths of a millimetre.
    pub(super) const fn chord(&self, order: u8) -> (u64, u64) {
        let half = Self::halves(order as u64).direction();
        let radius = sixteenths(self.0.radius);
        let chord = FinePoint::polar(radius, half);
        (
            chord.x().unsigned_abs() as u64,
            chord.y().unsigned_abs() as u64,
        )
    }

    /// tan of half the opening, in steps of 2^-14: how steeply an arc may leave its circle around the
    /// robot.
    pub(super) const fn steepest(&self) -> u64 {
        let half = BinaryAngle::from_bits(self.half_width(0)).direction();
        let tangent = ((half.sin() as i64) << 14).checked_div(half.cos() as i64);
        match tangent {
            Some(tangent) => tangent.unsigned_abs().wrapping_add(1),
            None => 0,
        }
    }
}
