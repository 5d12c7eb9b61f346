//! Faults of a bench: of a sensor's measurement, of the wires between it and the board, or of a motor.
//!
//! Written as [`crate::fault::FaultSpec`] is, with further kinds:
//!
//! | kind | meaning |
//! |---|---|
//! | `line-high` `line-low` | the sensor's line to the board is stuck |
//! | `line-floating` | it is connected to nothing |
//! | `unplugged` | the sensor is unplugged during a conversion |
//! | `cut-short` | its supply breaks down after the fourth bit |
//! | `mute` | it never answers |
//! | `servo-jammed` | the head stays where it is |
//! | `servo-off` | the board's PWM channel fails; not on the emulated board, whose channels cannot |
//!
//! A sensor is read once a round, so a window in readings is one in rounds here.
//!
//! Further kinds have a motor, `right` or `left`, in place of the sensor:
//!
//! | kind | value | default | meaning |
//! |---|---|---|---|
//! | `motor-dead` | – | – | it does not turn |
//! | `motor-weak` | a percentage of its speed | `95%` | it turns slower, by the same part at any speed |
//! | `slip` | a percentage of its way | `20%` | its wheel loses up to this part, another in each frame of 20 ms |
//! | `motor-off` | – | – | the board's PWM channel fails, and the motor keeps the last pulse; not on the emulated board |

use crate::fault::{FaultSpec, Parts, SensorName, SpecError, Window};
use crate::quantity::{self, Excerpt, Percentage};
use certainty_control::Side;
use core::fmt;
use core::str::FromStr;

/// Nanoseconds in a microsecond.
pub(crate) const MICROSECOND: u64 = 1_000;

/// Nanoseconds in a millisecond.
pub(crate) const MILLISECOND: u64 = 1_000_000;

/// A fault of the line from a sensor to the microcontroller, or of the sensor at its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineFault {
    /// The line is high, whatever the sensor does.
    StuckHigh,
    /// The line is low, whatever the sensor does.
    StuckLow,
    /// The line is connected to nothing and picks up noise: another random level each 10 µs.
    Floating {
        /// The seed of the noise.
        seed: u64,
    },
    /// The sensor is unplugged during a conversion and stays so; the line's pull-down holds it low.
    UnpluggedMidConversion,
    /// The sensor's supply breaks down after each fourth bit; it restarts a little later.
    CutShort,
    /// The sensor never answers.
    NoAnswer,
}

impl LineFault {
    /// How long noise holds a level.
    const NOISE_NS: u64 = 10 * MICROSECOND;

    /// Returns the level that the fault forces; `None` where the sensor determines the level.
    pub(super) fn level(self, now_ns: u64) -> Option<bool> {
        match self {
            Self::StuckHigh => Some(true),
            Self::StuckLow => Some(false),
            Self::Floating { seed } => {
                let word = scrambled(seed ^ scrambled(now_ns / Self::NOISE_NS));
                Some(word & 1 == 1)
            }
            Self::UnpluggedMidConversion | Self::CutShort | Self::NoAnswer => None,
        }
    }
}

/// A fault between a motor's channel and the ground under its wheel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MotorFault {
    /// It does not turn.
    Dead,
    /// It turns at this part of the commanded speed.
    Weak(Percentage),
    /// Its wheel loses up to this part of its way, another in each frame of 20 ms.
    Slip(Percentage),
    /// Its pulses cannot be set: it keeps the last.
    Off,
}

/// The name of a motor.
const fn name(side: Side) -> &'static str {
    match side {
        Side::Right => "right",
        Side::Left => "left",
    }
}

/// The motor called `written`.
fn motor(written: &SensorName) -> Result<Side, SpecError> {
    let written = written.to_string();
    let mut sides = [Side::Right, Side::Left].into_iter();
    sides
        .find(|&side| name(side) == written)
        .ok_or_else(|| SpecError::NoSuchMotor {
            motor: Excerpt::new(&written),
        })
}

impl MotorFault {
    /// Parses a kind and its value; `None` for a kind that motors do not have.
    fn parse(kind: &str, value: Option<&str>) -> Option<Result<Self, SpecError>> {
        let valueless = |kind, fault| match value {
            Some(value) => Err(SpecError::no_value_of(kind, "left", value)),
            None => Ok(fault),
        };
        let part = |kind, default: f64, example| match value {
            None => Ok(Percentage::try_new(default).unwrap_or_default()),
            Some(value) => quantity::percentage(value).map_err(|source| SpecError::Quantity {
                kind,
                source,
                example,
            }),
        };
        Some(match kind {
            "motor-dead" => valueless("motor-dead", Self::Dead),
            "motor-off" => valueless("motor-off", Self::Off),
            "motor-weak" => part("motor-weak", 95.0, "motor-weak:left=95%").map(Self::Weak),
            "slip" => part("slip", 20.0, "slip:right=20%").map(Self::Slip),
            _ => return None,
        })
    }

    /// Writes the fault of `side` as it is parsed.
    fn write(self, f: &mut fmt::Formatter<'_>, side: Side) -> fmt::Result {
        let side = name(side);
        match self {
            Self::Dead => write!(f, "motor-dead:{side}"),
            Self::Weak(part) => write!(f, "motor-weak:{side}={part}"),
            Self::Slip(part) => write!(f, "slip:{side}={part}"),
            Self::Off => write!(f, "motor-off:{side}"),
        }
    }

    /// Returns the part of the commanded way that the wheel of `side` goes in a frame.
    ///
    /// Depends on the frame's number, not on the calls before: the slip is the same on all backends.
    pub(super) fn part(self, seed: u64, frame: u64, side: Side) -> f64 {
        match self {
            Self::Dead => 0.0,
            Self::Weak(part) => part.fraction(),
            Self::Slip(most) => {
                let named = scrambled(seed ^ scrambled(frame << 1 | u64::from(side == Side::Left)));
                let lost = (named >> 11) as f64 / (1_u64 << 53) as f64;
                1.0 - most.fraction() * lost
            }
            Self::Off => 1.0,
        }
    }
}

/// A fault of a sensor's wires or servo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WireFault {
    /// Of its line, or of the sensor as its line shows it.
    Line(LineFault),
    /// The servo's shaft does not turn.
    ServoJammed,
    /// The servo's pulses cannot be set.
    ServoOff,
}

/// A fault of the bench, and of which sensor or motor.
#[derive(Debug, Clone, PartialEq)]
pub enum BenchFault {
    /// Of a sensor's measurement.
    Sensor(FaultSpec),
    /// Of a sensor's wires or servo.
    Wire {
        /// Which sensor: 1 to 3 are the pivoted ones, 4 and 5 the rangers.
        sensor: SensorName,
        /// The fault.
        fault: WireFault,
        /// When.
        window: Window,
    },
    /// Of a motor.
    Motor {
        /// Which.
        motor: Side,
        /// The fault.
        fault: MotorFault,
        /// When.
        window: Window,
    },
}

impl BenchFault {
    /// For a fault that refuses pulses: its kind, and the nearest kind that a chip's own channels can have.
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

/// The seed of a floating line's noise; its value does not matter.
const NOISE: u64 = 0x6770_3264_3032;

/// The kinds of faults of wires and servos.
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
    ("mute", WireFault::Line(LineFault::NoAnswer)),
    ("servo-jammed", WireFault::ServoJammed),
    ("servo-off", WireFault::ServoOff),
];

impl FromStr for BenchFault {
    type Err = SpecError;

    fn from_str(text: &str) -> Result<Self, SpecError> {
        let parts = Parts::split(text)?;
        if let Some(fault) = MotorFault::parse(parts.kind, parts.value) {
            return Ok(Self::Motor {
                motor: motor(&parts.sensor)?,
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

/// The finalizer of `SplitMix64`: every bit of the input moves about half of the output's.
const fn scrambled(word: u64) -> u64 {
    let word = word.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let word = (word ^ word >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let word = (word ^ word >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    word ^ word >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_is_written_as_it_is_parsed() {
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
    fn a_wrong_fault_is_refused_with_the_reason() {
        for (text, part) in [
            ("line-high", "names no sensor"),
            ("line-high:65536", "is no sensor"),
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
            assert!(error.contains(part), "{error}");
        }
    }

    #[test]
    fn an_omitted_value_is_the_default() {
        for (text, whole) in [
            ("motor-weak:left", "motor-weak:left=95%"),
            ("slip:right", "slip:right=20%"),
        ] {
            assert_eq!(text.parse::<BenchFault>().unwrap().to_string(), whole);
        }
    }
}
