//! A pivoted infrared sensor: servo, GP2D02, calibration and validation.

use super::{VALIDATION, beam_model};
use crate::board::{Board, HeadWires};
use crate::gp2d02::Gp2d02;
use crate::servo::Servo;
use certainty_core::fusion::BeamModel;
use certainty_core::transducer::{Calibration, Finding, Missing, Reading, Validator};
use certainty_core::units::{BinaryAngle, Ticks};
use embedded_hal::delay::DelayNs;

/// One of the car's pivoted sensors in one round after the other: aimed, started, read.
///
/// What goes wrong on the way to a reading is kept, so that the reading says it.
pub(super) struct Head<B: Board> {
    servo: Servo<B::Pwm>,
    sensor: Gp2d02<B::Vin, B::Vout>,
    calibration: &'static Calibration,
    model: BeamModel,
    validator: Validator,
    direction: BinaryAngle,
    trouble: Option<Missing>,
    reading: Reading,
    finding: Finding,
}

impl<B: Board> Head<B> {
    /// Creates the head of a unit with this calibration and accuracy.
    pub(super) fn new(wires: HeadWires<B>, unit: &'static super::Unit) -> Self {
        Self {
            servo: Servo::new(wires.pwm, super::SERVO),
            sensor: Gp2d02::new(wires.vin, wires.vout),
            calibration: &unit.calibration,
            model: beam_model(unit.accuracy),
            validator: Validator::new(),
            direction: BinaryAngle::ZERO,
            trouble: Some(Missing::Late),
            reading: Reading::Missing(Missing::Late),
            finding: Finding::Missing,
        }
    }

    /// Turns to `direction`, as seen from its place on the car.
    pub(super) fn aim(&mut self, direction: BinaryAngle) {
        self.direction = direction;
        // A head that may look anywhere says nothing of where it should have looked.
        self.trouble = self.servo.aim(direction).err().map(|error| error.reason());
    }

    /// Starts a conversion.
    pub(super) fn start(&mut self, delay: &mut impl DelayNs) {
        if self.trouble.is_none() {
            self.trouble = self.sensor.start(delay).err().map(|fault| fault.reason());
        }
    }

    /// Reads the conversion's result, and checks it.
    // Not inlined: the stack of the main loop is under that of the deepest slot.
    #[inline(never)]
    pub(super) fn read(&mut self, delay: &mut impl DelayNs, now: Ticks) {
        let answer = match self.trouble {
            None => self.sensor.read(delay).map_err(|fault| fault.reason()),
            Some(trouble) => Err(trouble),
        };
        let reading = match answer {
            Ok(raw) => self.calibration.reading(raw),
            Err(why) => Reading::Missing(why),
        };
        let validated =
            self.validator
                .validate(&VALIDATION, reading, answer.ok(), self.direction, now);
        self.reading = validated.reading;
        self.finding = validated.finding;
    }

    /// Is told that a slot of its turn was skipped.
    pub(super) fn miss(&mut self) {
        self.trouble = Some(Missing::Late);
        self.reading = Reading::Missing(Missing::Late);
        self.finding = Finding::Missing;
    }

    /// Returns where it looks, as seen from its place on the car.
    pub(super) const fn direction(&self) -> BinaryAngle {
        self.direction
    }

    /// Returns the last reading.
    pub(super) const fn reading(&self) -> Reading {
        self.reading
    }

    /// Returns what the validation found.
    pub(super) const fn finding(&self) -> Finding {
        self.finding
    }

    /// Returns how the readings are interpreted.
    pub(super) const fn model(&self) -> &BeamModel {
        &self.model
    }
}
