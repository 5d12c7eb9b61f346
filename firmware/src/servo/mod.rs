//! A hobby servo on a PWM channel.
//!
//! A servo turns to where the length of its pulses says and tells nobody where it is. So the driver
//! remembers where it was sent, and says how long the way takes.

mod model;

pub use model::{ServoConfig, ServoConfigError, ServoModel};

use certainty_core::transducer::Missing;
use certainty_core::units::BinaryAngle;
use core::fmt;
use embedded_hal::pwm::SetDutyCycle;

/// Why a servo was not turned.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ServoError {
    /// The angle asks for a pulse beyond the servo's limits.
    OutOfReach,
    /// The microcontroller's PWM channel refused.
    Pwm,
}

impl ServoError {
    /// Returns what this makes of the reading for which the sensor was to be turned.
    #[must_use]
    pub const fn reason(self) -> Missing {
        match self {
            Self::OutOfReach | Self::Pwm => Missing::Bus,
        }
    }
}

impl fmt::Display for ServoError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::OutOfReach => "the angle is out of the servo's reach",
            Self::Pwm => "the PWM channel failed",
        })
    }
}

impl core::error::Error for ServoError {}

/// A servo that was told to turn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Aimed {
    /// How long it takes to get there, in ms; 0 where it is there.
    pub settle_ms: u32,
    /// The length of its pulses, in µs.
    pub pulse_us: u16,
}

/// The driver of a servo on a PWM channel with the model's period.
#[derive(Debug)]
pub struct Servo<Pwm> {
    pwm: Pwm,
    model: ServoModel,
    /// The pulse that it was last sent to; unknown at the start and after a fault.
    sent_to_us: Option<u16>,
}

impl<Pwm: SetDutyCycle> Servo<Pwm> {
    /// Creates the driver of a servo that may stand anywhere within its limits.
    #[must_use]
    pub const fn new(pwm: Pwm, model: ServoModel) -> Self {
        Self {
            pwm,
            model,
            sent_to_us: None,
        }
    }

    /// Returns the channel, whose pulses go on.
    #[must_use]
    pub fn release(self) -> Pwm {
        self.pwm
    }

    /// Returns what the servo does with its pulses.
    #[must_use]
    pub const fn model(&self) -> &ServoModel {
        &self.model
    }

    /// Turns to `angle`, counter-clockwise from straight ahead, and says how long it takes.
    ///
    /// The time counts from where the servo was last sent, which holds once *that* time has passed.
    /// At first and after a fault it is [`ServoModel::worst_settling_ms`].
    ///
    /// # Errors
    ///
    /// [`ServoError::OutOfReach`], and the servo stays where it is; [`ServoError::Pwm`].
    pub fn aim(&mut self, angle: BinaryAngle) -> Result<Aimed, ServoError> {
        let pulse_us = self.model.pulse_us(angle)?;
        let settle_ms = match self.sent_to_us.take() {
            Some(from_us) => self.model.settling_ms(from_us, pulse_us),
            None => self.model.worst_settling_ms(),
        };
        let duty = self.model.duty(pulse_us, self.pwm.max_duty_cycle());
        self.pwm.set_duty_cycle(duty).map_err(|_| ServoError::Pwm)?;
        self.sent_to_us = Some(pulse_us);
        Ok(Aimed {
            settle_ms,
            pulse_us,
        })
    }
}

#[cfg(test)]
mod tests;
