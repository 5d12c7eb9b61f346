//! Faults of a bench: of what a sensor measures, of the wires between it and the board, or of a motor.
//!
//! Written as [`crate::fault::FaultSpec`] is, with further kinds:
//!
//! | kind | meaning |
//! |---|---|
//! | `line-high` `line-low` | the sensor's line to the board is stuck |
//! | `line-floating` | it is connected to nothing |
//! | `unplugged` | the sensor is pulled off during a conversion |
//! | `cut-short` | its supply breaks down after the fourth bit |
//! | `mute` | it never gets done |
//! | `servo-jammed` | the head stays where it is |
//! | `servo-off` | the board's PWM channel fails; not on the emulated board, whose channels cannot |
//!
//! A sensor is read once a round, so that a window in readings is one in rounds here.
//!
//! In place of a sensor some are of a motor, `right` or `left`:
//!
//! | kind | value | default | meaning |
//! |---|---|---|---|
//! | `motor-dead` | – | – | it does not turn |
//! | `motor-weak` | a percentage of its speed | `95%` | it turns slower, by as much at any speed |
//! | `slip` | a percentage of its way | `20%` | its wheel loses up to so much, another part in each frame of 20 ms |
//! | `motor-off` | – | – | the board's PWM channel fails, and the motor goes on by the last pulse; not on the emulated board |

use super::{LineFault, MotorFault, motor_fault};
use crate::fault::{FaultSpec, Parts, SensorName, SpecError, Window};
use certainty_control::Side;
use core::fmt;
use core::str::FromStr;

/// What is wrong around a sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WireFault {
    /// With its line, or with itself as its line shows it.
    Line(LineFault),
    /// Its servo's shaft does not turn.
    ServoJammed,
    /// Its servo's pulses cannot be set.
    ServoOff,
}

/// A fault of the bench and the sensor it is of.
#[derive(Debug, Clone, PartialEq)]
pub enum BenchFault {
    /// Of what the sensor measures.
    Sensor(FaultSpec),
    /// Of what is around it.
    Wire {
        /// Which sensor: 1 to 3 are the pivoted ones, 4 and 5 the rangers.
        sensor: SensorName,
        /// What is wrong.
        fault: WireFault,
        /// When.
        window: Window,
    },
    /// Of a motor.
    Motor {
        /// Which.
        motor: Side,
        /// What is wrong.
        fault: MotorFault,
        /// When.
        window: Window,
    },
}

impl BenchFault {
    /// Its kind and the nearest kind that a chip's own channels can have, where it is a channel that refuses.
    #[must_use]
    pub const fn refused_channel(&self) -> Option<(&'static str, &'static str)> {
        match self {
            Self::Wire {
                fault: WireFault::ServoOff,
                ..
            } => Some(("servo-off", "servo-jammed")),
            Self::Motor {
                fault: MotorFault::Off,
                ..
            } => Some(("motor-off", "motor-dead")),
            _ => None,
        }
    }
}

/// Names the noise of a floating line; any would do.
const NOISE: u64 = 0x6770_3264_3032;

/// The kinds besides those of a sensor itself.
const KINDS: [(&str, WireFault); 8] = [
    ("line-high", WireFault::Line(LineFault::StuckHigh)),
    ("line-low", WireFault::Line(LineFault::StuckLow)),
    (
        "line-floating",
        WireFault::Line(LineFault::Floating { seed: NOISE }),
    ),
    (
        "unplugged",
        WireFault::Line(LineFault::UnpluggedMidConversion),
    ),
    ("cut-short", WireFault::Line(LineFault::CutShort)),
    ("mute", WireFault::Line(LineFault::Mute)),
    ("servo-jammed", WireFault::ServoJammed),
    ("servo-off", WireFault::ServoOff),
];

impl FromStr for BenchFault {
    type Err = SpecError;

    fn from_str(text: &str) -> Result<Self, SpecError> {
        let parts = Parts::split(text)?;
        if let Some(fault) = MotorFault::parse(parts.kind, parts.value) {
            return Ok(Self::Motor {
                motor: motor_fault::motor(&parts.sensor)?,
                fault: fault?,
                window: parts.window,
            });
        }
        match KINDS.iter().find(|(kind, _)| *kind == parts.kind) {
            None => text.parse().map(Self::Sensor).map_err(|error| match error {
                SpecError::UnknownKind { kind } => SpecError::UnknownWireKind { kind },
                other => other,
            }),
            Some(&(kind, fault)) => match parts.value {
                Some(value) => Err(SpecError::no_value(kind, value)),
                None => Ok(Self::Wire {
                    sensor: parts.sensor,
                    fault,
                    window: parts.window,
                }),
            },
        }
    }
}

impl fmt::Display for BenchFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sensor(spec) => spec.fmt(f),
            Self::Motor {
                motor,
                fault,
                window,
            } => {
                fault.write(f, *motor)?;
                window.fmt(f)
            }
            Self::Wire {
                sensor,
                fault,
                window,
            } => {
                let kind = KINDS.iter().find(|(_, known)| known == fault);
                let kind = kind.map_or("wire", |(kind, _)| kind);
                write!(f, "{kind}:{sensor}{window}")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_is_written_as_it_is_read() {
        for text in [
            "line-high:2",
            "line-low:1@3..8",
            "line-floating:3@3000ms..8000ms",
            "unplugged:1@2",
            "cut-short:1",
            "mute:4",
            "servo-jammed:3",
            "servo-off:3@1..2",
            "stuck-far:2",
            "stuck-near:2=250mm@3..8",
            "motor-dead:left@42",
            "motor-weak:left=95%",
            "slip:right=20%@3..8",
            "motor-off:right@3000ms..8000ms",
        ] {
            assert_eq!(text.parse::<BenchFault>().unwrap().to_string(), text);
        }
    }

    #[test]
    fn a_wrong_fault_is_refused_with_its_reason() {
        for (text, says) in [
            ("line-high", "names no sensor"),
            ("line-high:0", "is no sensor"),
            ("line-high:1=3", "takes no value"),
            ("line-high:1@5..2", "is empty"),
            ("line-hig:1", "line-floating"),
            ("stuck-near:1=5", "stuck-near"),
            (
                "motor-dead:middle",
                "no motor 'middle': write right or left",
            ),
            ("motor-dead:1", "no motor '1'"),
            ("motor-dead:left=3", "write motor-dead:left without '=3'"),
            ("motor-weak:left=95", "motor-weak:left=95%"),
            ("slip:right=120%", "slip:right=20%"),
            ("motor-dea:left", "motor-off"),
        ] {
            let error = text.parse::<BenchFault>().unwrap_err().to_string();
            assert!(error.contains(says), "{error}");
        }
    }
    #[test]
    fn a_value_that_was_left_out_is_the_default() {
        for (text, whole) in [
            ("motor-weak:left", "motor-weak:left=95%"),
            ("slip:right", "slip:right=20%"),
        ] {
            assert_eq!(text.parse::<BenchFault>().unwrap().to_string(), whole);
        }
    }
}
