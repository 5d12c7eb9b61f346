//! The Smart Car's numbers: its grid, its devices, where they sit and how they sweep.

use crate::motors::MotorModel;
use crate::ranger::RangerLimits;
use crate::servo::ServoModel;
use certainty_core::fusion::{BeamConfig, BeamModel, Geometry, RobustGrid, Shape, owner_bytes};
use certainty_core::transducer::{Calibration, Sweep, ValidationConfig, ValidationRules};
use certainty_core::units::{BinaryAngle, Millimeters, Point, Pose};
use fixed::types::{U0F16, U8F8};

/// Sensors whose readings are fused into the map: the pivoted GP2D02s.
pub const SENSORS: u8 = HEADS;

/// Pivoted heads on the car, each with a GP2D02 (\[001\] §6.1).
pub const HEADS: u8 = 3;

/// Fixed ultrasonic rangers that look straight ahead (\[001\] §6.1).
pub const RANGERS: u8 = 2;

/// The shortest distance that a GP2D02 measures.
pub const NEAREST: Millimeters = Millimeters::new(100);

/// The longest distance that a GP2D02 measures (\[001\] §6.1).
pub const FARTHEST: Millimeters = Millimeters::new(800);

/// The heads' servos.
pub const SERVO: ServoModel = ServoModel::COMMON;

/// The range of the fixed rangers.
pub const RANGER: RangerLimits = RangerLimits::SRF04;

/// The drive motors.
pub const MOTOR: MotorModel = MotorModel::COMMON;

/// The checks of a head's reading: the same byte or *too near* for a whole sweep, and a jump from one sweep to
/// the next.
///
/// Two counts of noise are the same byte. A jump is compared while the car keeps its heading; a car that drives
/// can cause one itself, which only labels the reading.
pub const VALIDATION: ValidationRules = ValidationRules::new(ValidationConfig {
    repeat_noise: 2,
    ..ValidationConfig::sweeping(NEAREST, FARTHEST, 0, SWEEP.directions(), SWEEP_MS)
});

/// The checks of a ranger's reading: *too near* in sixteen successive headings, and a jump from one round to the
/// next.
///
/// Equal distances are no fault of an ultrasonic ranger: its wide beam measures the same to a wall while the
/// car turns.
pub(super) const RANGER_VALIDATION: ValidationRules =
    ValidationRules::new(ValidationConfig::sweeping(
        RANGER.nearest(),
        RANGER.farthest(),
        CHASSIS.full_speed_mm_s,
        16,
        PERIOD_MS as u32,
    ));

/// The duration of a round, in ms.
pub(super) const PERIOD_MS: u16 = 800;

/// The duration of a sweep, in ms: a round a direction.
const SWEEP_MS: u32 = PERIOD_MS as u32 * SWEEP.directions() as u32;

/// The car's start pose in its grid: in the middle of the lower edge, heading up.
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
/// At the range of 80 cm neighbouring beams are 7 cm apart, so no cell lies between them.
pub const SWEEP: Sweep = Sweep::new(
    BinaryAngle::from_millidegrees(-90_000),
    BinaryAngle::from_millidegrees(90_000),
    37,
);

/// Returns the pose of head `slot` of `heads` on the bumper, facing straight ahead.
///
/// The heads are spaced evenly along 16 cm, the first on the right; replicated sensors always sit slightly
/// apart (\[001\] §2).
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

/// Returns the pose of ranger `slot` on the bumper, facing straight ahead: 5 cm to each side, the first on
/// the right.
#[must_use]
pub fn ranger_mounting(slot: u8) -> Pose {
    let aside = if slot == 0 { -50 } else { 50 };
    Pose::new(Point::from_mm(0, aside), BinaryAngle::ZERO)
}

/// Returns the origin and direction, in the map, of the beam of head `slot` of `heads` in step `step` of its
/// sweep, for a car at [`POSE`].
#[must_use]
pub fn look(slot: u8, heads: u8, step: u32) -> Pose {
    look_from(POSE, slot, heads, step)
}

/// Returns the same as [`look`] for a car at the pose `car`.
#[must_use]
pub fn look_from(car: Pose, slot: u8, heads: u8, step: u32) -> Pose {
    let mut head = mounting(slot, heads);
    head.heading = SWEEP.direction(step, slot.into(), heads.into());
    car.compose(head)
}

/// Returns the beam model of a GP2D02 with this accuracy (\[001\] Table 1): a narrow beam up to
/// [`FARTHEST`]. *Too near* is an obstacle between the sensor and [`NEAREST`].
///
/// The accuracy is the standard deviation of a distance, as a fraction of it. The occupied spread is two
/// standard deviations to each side, which covers 95 % of the errors. Cells within it are not marked as
/// free; otherwise a reading too long by a tenth would erase the obstacle that it measured.
#[must_use]
#[inline]
pub const fn beam_model(accuracy: U0F16) -> BeamModel {
    const BEAM: BeamConfig = BeamConfig {
        nearest: NEAREST,
        ..BeamConfig::narrow(FARTHEST)
    };
    const EXACT: BeamModel = BeamModel::new(BEAM);
    let config = BeamConfig {
        accuracy: accuracy.saturating_add(accuracy),
        ..BEAM
    };
    match BeamModel::try_new(config) {
        Ok(model) => model,
        Err(_) => EXACT, // unreachable: every accuracy is valid
    }
}

/// The mechanics of the car: its wheels and its size.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Chassis {
    /// The speed of a wheel at full speed, in mm/s.
    pub full_speed_mm_s: u32,
    /// The distance between the wheels, in mm.
    pub track_mm: u32,
    /// The radius of the car's outline about its middle, in mm.
    pub radius_mm: u32,
}

/// The Smart Car's chassis.
///
/// At 10 cm/s it moves less than a cell in a round. Its wheels are as far apart as its outer heads, and its
/// outline is a disc about the middle of its bumper, about which it turns.
/// Open choice: the papers give no numbers.
pub const CHASSIS: Chassis = Chassis {
    full_speed_mm_s: 100,
    track_mm: 160,
    radius_mm: 80,
};

/// Calibration and accuracy of one GP2D02.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Unit {
    /// Converts its bytes to millimetres.
    pub calibration: Calibration,
    /// The standard deviation of its distances, as a fraction of them (\[001\] Table 1).
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub accuracy: U0F16,
}

const fn unit(slope: u32, offset_mm: u32, floor: U8F8, accuracy: U0F16) -> Unit {
    let offset = Millimeters::new(offset_mm);
    Unit {
        calibration: Calibration::new(slope, offset, floor, NEAREST, FARTHEST),
        accuracy,
    }
}

/// The sensors from right to left: units `A0_0` to `A0_2` of the simulator's table with the accuracies
/// of A, B and C of \[001\] Table 1.
///
/// Replace them by the output of `certainty calibrate` for your sensors.
pub static UNITS: [Unit; HEADS as usize] = [
    unit(16_866, 14, U8F8::from_bits(17_422), U0F16::lit("0.06")),
    unit(16_572, 16, U8F8::from_bits(18_456), U0F16::lit("0.10")),
    unit(16_573, 12, U8F8::from_bits(19_161), U0F16::lit("0.07")),
];

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_core::fusion::{CertaintyGrid, RobustRules};

    #[test]
    fn cells_and_owners_take_234_bytes() {
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
    fn heads_face_from_the_bumper_into_the_grid() {
        // Right head, first step: along +x, from 8 cm right of the middle.
        let right = look(0, 3, 0);
        assert_eq!(right, Pose::new(Point::from_mm(80, 0), BinaryAngle::ZERO));
        // Half a sweep later straight ahead.
        assert_eq!(look(0, 3, 18).heading, BinaryAngle::QUARTER);
        assert_eq!(look(2, 3, 0).at, Point::from_mm(-80, 0));
    }
}
