//! Faults of a bench: of what a sensor measures, or of the wires between it and the board.
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

use super::LineFault;
use crate::fault::{FaultSpec, Parts, SensorName, SpecError, Window};
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
        ] {
            let error = text.parse::<BenchFault>().unwrap_err().to_string();
            assert!(error.contains(says), "{error}");
        }
    }
}
