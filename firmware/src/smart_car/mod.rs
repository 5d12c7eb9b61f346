//! The Smart Car of \[001\] §6.1: its grid, its pivoted infrared sensors and their sweep.
//!
//! | item | is |
//! |---|---|
//! | [`SmartCar`] | the application: drivers, map and records, on any board |
//! | [`SCHEDULE`] | its round: who does what at which millisecond |
//! | [`UNITS`] | the calibrations of its three infrared sensors |
//! | [`look`], [`mounting`], [`SWEEP`] | where they sit and look |
//! | [`GOAL`], [`CONTROL`], [`CHASSIS`] | where it goes, how, and on what wheels |
//!
//! The papers give the grid and the sensors' range. Where the sensors sit and how finely they sweep
//! they do not say, nor that the car moves; the choices here are a model car's.

use crate::motors::MotorModel;
use crate::ranger::RangerLimits;
use crate::servo::ServoModel;
use certainty_core::fusion::{BeamConfig, BeamModel, Geometry, RobustGrid, Shape, owner_bytes};
use certainty_core::transducer::{Sweep, ValidationConfig, ValidationRules};
use certainty_core::units::{BinaryAngle, Millimeters, Point, Pose};
use fixed::types::U0F16;

mod application;
mod drive;
mod head;
mod round;
mod units;
mod wiring;

pub use application::{InitError, SmartCar};
pub use drive::{CHASSIS, CONTROL, Chassis, GOAL, LOOK_AROUND, Odometer};
pub use round::{SCHEDULE, SLOTS, STATIONS};
pub use units::{UNITS, Unit};
pub use wiring::remote_wiring;

/// Sensors that make the map: the pivoted GP2D02s.
pub const SENSORS: u8 = HEADS;

/// Pivoted heads on the car, a GP2D02 on each (\[001\] §6.1).
pub const HEADS: u8 = 3;

/// Fixed ultrasonic rangers that look straight ahead (\[001\] §6.1).
pub const RANGERS: u8 = 2;

/// Shortest distance a GP2D02 tells.
pub const NEAREST: Millimeters = Millimeters::new(100);

/// Longest distance a GP2D02 tells (\[001\] §6.1).
pub const FARTHEST: Millimeters = Millimeters::new(800);

/// What the heads' servos do with their pulses.
pub const SERVO: ServoModel = ServoModel::COMMON;

/// What the fixed rangers can tell.
pub const RANGER: RangerLimits = RangerLimits::SRF04;

/// What the drive motors do with their pulses.
pub const MOTOR: MotorModel = MotorModel::COMMON;

/// What a reading of a head is checked against: the range, the same word for a whole sweep, and a jump
/// from one sweep to the next in a world that stands still.
pub const VALIDATION: ValidationRules = ValidationRules::new(ValidationConfig::sweeping(
    NEAREST,
    FARTHEST,
    0,
    SWEEP.directions(),
    SWEEP_MS,
));

/// How long a sweep takes, in ms: a round a direction.
const SWEEP_MS: u32 = round::PERIOD_MS as u32 * SWEEP.directions() as u32;

/// The car's first pose in its grid: in the middle of the lower edge, looking up.
pub const POSE: Pose = Pose::new(Point::ORIGIN, BinaryAngle::QUARTER);

/// The car's grid: 17 by 11 cells of 10 cm in front of it (\[001\] §6.1).
///
/// A zero-sized [`Shape`]: its numbers are folded into the code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SmartCarShape;

impl Shape for SmartCarShape {
    #[inline]
    fn geometry(&self) -> Geometry {
        const { Geometry::new(17, 11, Millimeters::new(100), Point::from_mm(-850, 0)) }
    }
}

/// Cells of the car's grid.
pub const CELLS: usize = 187;

/// The car's robust grid: 234 bytes of cells and owners (\[001\] §7).
pub type SmartCarGrid = RobustGrid<SmartCarShape, [u8; CELLS], [u8; owner_bytes(CELLS, SENSORS)]>;

/// The sweep of every head: from 90° right to 90° left of straight ahead in 5° steps.
///
/// At the range of 80 cm neighbouring beams are 7 cm apart, so none misses a cell between them.
pub const SWEEP: Sweep = Sweep::new(
    BinaryAngle::from_millidegrees(-90_000),
    BinaryAngle::from_millidegrees(90_000),
    37,
);

/// Returns where head `slot` of `heads` sits on the bumper, looking straight ahead.
///
/// Evenly along 16 cm, the first on the right; a replicated sensor is always slightly offside
/// (\[001\] §2).
///
/// ```
/// use certainty_firmware::smart_car::mounting;
///
/// assert_eq!(mounting(0, 3).at.y_mm(), -80);
/// assert_eq!(mounting(1, 3).at.y_mm(), 0);
/// assert_eq!(mounting(2, 3).at.y_mm(), 80);
/// ```
#[must_use]
pub fn mounting(slot: u8, heads: u8) -> Pose {
    const BUMPER_MM: i32 = 160;
    let gaps = i32::from(heads.saturating_sub(1));
    let aside = match BUMPER_MM.saturating_mul(slot.into()).checked_div(gaps) {
        Some(mm) => mm.saturating_sub(BUMPER_MM / 2),
        None => 0, // a single head sits in the middle
    };
    Pose::new(Point::from_mm(0, aside), BinaryAngle::ZERO)
}

/// Returns where ranger `slot` sits on the bumper, looking straight ahead: 5 cm to each side, the
/// first on the right.
#[must_use]
pub fn ranger_mounting(slot: u8) -> Pose {
    let aside = if slot == 0 { -50 } else { 50 };
    Pose::new(Point::from_mm(0, aside), BinaryAngle::ZERO)
}

/// Returns what head `slot` of `heads` looks at in step `step` of its sweep: its beam's start and
/// direction in the map, of a car that has not moved.
#[must_use]
pub fn look(slot: u8, heads: u8, step: u32) -> Pose {
    look_from(POSE, slot, heads, step)
}

/// Returns the same of a car that is somewhere else.
#[must_use]
pub fn look_from(car: Pose, slot: u8, heads: u8, step: u32) -> Pose {
    let mut head = mounting(slot, heads);
    head.heading = SWEEP.direction(step, slot.into(), heads.into());
    car.compose(head)
}

/// Returns how a GP2D02 of this accuracy (\[001\] Table 1) is interpreted: a narrow beam up to
/// [`FARTHEST`].
///
/// The accuracy is the standard deviation of a distance, as a fraction of it. The occupied spread
/// reaches two of them to each side, where 95 % of the errors end: nearer than that a beam frees
/// nothing, or a reading too long by a tenth would erase the obstacle that it saw.
#[must_use]
pub const fn beam_model(accuracy: U0F16) -> BeamModel {
    const EXACT: BeamModel = BeamModel::new(BeamConfig::narrow(FARTHEST));
    let config = BeamConfig {
        accuracy: accuracy.saturating_add(accuracy),
        ..BeamConfig::narrow(FARTHEST)
    };
    match BeamModel::try_new(config) {
        Ok(model) => model,
        Err(_) => EXACT, // the accuracy is never what is refused
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_core::fusion::{CertaintyGrid, RobustRules};

    #[test]
    fn the_cells_and_owners_take_234_bytes_and_nothing_else_grows_with_the_grid() {
        let cells = [0; CELLS];
        let grid =
            SmartCarGrid::try_new(SmartCarShape, RobustRules::DEFAULT, SENSORS, cells, [0; 47]);
        assert_eq!(grid.unwrap().memory_bytes(), 187 + 47);
        // Rules, sensor count and owner width: 22 bytes.
        assert!(size_of::<SmartCarGrid>() <= 234 + 22);
        assert_eq!(size_of::<SmartCarShape>(), 0);
        assert_eq!(SmartCarShape.geometry().cells() as usize, CELLS);
    }

    #[test]
    fn heads_look_from_their_place_on_the_bumper_into_the_grid() {
        // Right head, first step: to the right, along +x, from 8 cm right of the middle.
        let right = look(0, 3, 0);
        assert_eq!(right, Pose::new(Point::from_mm(80, 0), BinaryAngle::ZERO));
        // Half a sweep later straight ahead.
        assert_eq!(look(0, 3, 18).heading, BinaryAngle::QUARTER);
        assert_eq!(look(2, 3, 0).at, Point::from_mm(-80, 0));
    }
}
