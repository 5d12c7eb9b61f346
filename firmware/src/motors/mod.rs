//! A differential drive: two motors behind hobby speed controllers, or two continuous servos.
//!
//! A pulse every 20 ms says how fast a motor shall turn, and nothing says how fast it does. So the driver
//! tells what it sent, in whole microseconds, for whoever reckons by it. Prefer [`servo`](crate::servo) for
//! what turns to an angle.

mod model;

pub use model::{MotorConfig, MotorConfigError, MotorModel};

use certainty_control::{Side, Wheels};
use core::fmt;
use embedded_hal::pwm::SetDutyCycle;

/// Why the motors do not turn as they were told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MotorError {
    /// The microcontroller's PWM channel of the right motor refused.
    Right,
    /// That of the left one did.
    Left,
}

impl MotorError {
    const fn of(side: Side) -> Self {
        match side {
            Side::Right => Self::Right,
            Side::Left => Self::Left,
        }
    }
}

impl fmt::Display for MotorError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Right => "the right motor's PWM channel failed",
            Self::Left => "the left motor's PWM channel failed",
        })
    }
}

impl core::error::Error for MotorError {}

/// What the motors were told: by how many µs their pulses are longer than those that stand; ahead is above
/// zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MotorPulses {
    /// The right motor.
    pub right_us: i16,
    /// The left one.
    pub left_us: i16,
}

impl MotorPulses {
    /// Standing still.
    pub const NONE: Self = Self {
        right_us: 0,
        left_us: 0,
    };
}

/// The driver of two motors of one model on PWM channels with its period.
///
/// Where a motor turns the wrong way round, swap its wires.
#[derive(Debug)]
pub struct Motors<Pwm> {
    right: Pwm,
    left: Pwm,
    model: MotorModel,
}

impl<Pwm: SetDutyCycle> Motors<Pwm> {
    /// Creates the driver; the motors are told nothing yet.
    #[must_use]
    pub const fn new(right: Pwm, left: Pwm, model: MotorModel) -> Self {
        Self { right, left, model }
    }

    /// Returns the channels, right and left, whose pulses go on.
    #[must_use]
    pub fn release(self) -> (Pwm, Pwm) {
        (self.right, self.left)
    }

    /// Turns the wheels at these parts of full speed from the next pulse on, and says what that is in
    /// pulses.
    ///
    /// Range: beyond ±1 it is full speed. [`MotorPulses::NONE`] is exactly what [`Wheels::STOPPED`] sends.
    ///
    /// # Errors
    ///
    /// [`MotorError`] names the first motor that cannot be told. Then both are told to stand, as one that
    /// turns alone leads astray.
    pub fn drive(&mut self, wheels: Wheels) -> Result<MotorPulses, MotorError> {
        let thrust = MotorPulses {
            right_us: self.model.thrust_us(wheels.right),
            left_us: self.model.thrust_us(wheels.left),
        };
        let told = self
            .tell(Side::Right, thrust.right_us)
            .and_then(|()| self.tell(Side::Left, thrust.left_us));
        if let Err(error) = told {
            // Whichever still hears stands; what refused is what is told.
            let _deaf = self.tell(Side::Right, 0);
            let _deaf = self.tell(Side::Left, 0);
            return Err(error);
        }
        Ok(thrust)
    }

    fn tell(&mut self, side: Side, thrust_us: i16) -> Result<(), MotorError> {
        let pwm = match side {
            Side::Right => &mut self.right,
            Side::Left => &mut self.left,
        };
        let duty = self.model.duty(thrust_us, pwm.max_duty_cycle());
        pwm.set_duty_cycle(duty).map_err(|_| MotorError::of(side))
    }
}

#[cfg(test)]
mod tests;
