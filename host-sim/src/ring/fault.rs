//! What can be wrong with a sonar of a ring, and how it is written: `[KIND:]SENSOR[=VALUE]`.
//!
//! | kind | value | default | meaning |
//! |---|---|---|---|
//! | `falsified` | a length | `500mm` | every distance to which the sonar contributes is off by that; *no echo* too |
//! | `blind` | – | – | neither sends nor hears |
//! | `stuck` | a length | `500mm` | whatever it listens to, it tells that distance |
//! | `crosstalk` | – | – | hears a foreign pulse at any time before its own echo |
//! | `misaligned` | an angle | `30deg` | looks that much to the left of where it should |
//!
//! A number alone is `falsified`, the fault of \[003\] §7, which does not say by how much. The defaults are
//! open choices: five times the paper's threshold, and a turn of two places.

use super::SONARS;
use crate::quantity::{self, Excerpt, QuantityError};
use certainty_core::sensor::SensorId;
use certainty_core::units::{BinaryAngle, Millimeters};
use core::fmt;
use core::str::FromStr;
use thiserror::Error;

/// A kind of fault with its value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RingDefect {
    /// Every distance is off by so much.
    Falsified(Millimeters),
    /// Nothing sent, nothing heard.
    Blind,
    /// Always the same distance.
    Stuck(Millimeters),
    /// Foreign pulses.
    Crosstalk,
    /// Looks elsewhere, so far to the left.
    Misaligned(BinaryAngle),
}

impl RingDefect {
    /// Each kind with its default, in the order of the table above.
    pub const ALL: [Self; 5] = [
        Self::Falsified(Millimeters::new(500)),
        Self::Blind,
        Self::Stuck(Millimeters::new(500)),
        Self::Crosstalk,
        Self::Misaligned(BinaryAngle::from_millidegrees(30_000)),
    ];

    /// Returns what the kind is called.
    #[must_use]
    pub const fn kind(self) -> &'static str {
        match self {
            Self::Falsified(_) => "falsified",
            Self::Blind => "blind",
            Self::Stuck(_) => "stuck",
            Self::Crosstalk => "crosstalk",
            Self::Misaligned(_) => "misaligned",
        }
    }

    fn with_value(self, text: &str) -> Result<Self, RingFaultError> {
        let kind = self.kind();
        let wrong = |source| RingFaultError::Quantity { kind, source };
        match self {
            Self::Falsified(_) => quantity::length(text).map(Self::Falsified).map_err(wrong),
            Self::Stuck(_) => quantity::length(text).map(Self::Stuck).map_err(wrong),
            Self::Misaligned(_) => quantity::angle(text).map(Self::Misaligned).map_err(wrong),
            Self::Blind | Self::Crosstalk => Err(RingFaultError::NoValue {
                kind,
                value: Excerpt::new(text),
            }),
        }
    }
}

/// A fault and the sonar it is of.
///
/// ```
/// use certainty_sim::ring::RingFault;
///
/// let fault: RingFault = "4".parse()?;
/// assert_eq!(fault.to_string(), "falsified:4=500mm");
/// let fault: RingFault = "misaligned:12=20deg".parse()?;
/// assert_eq!(fault.sensor.number(), 12);
/// assert_eq!(
///     "blind:25".parse::<RingFault>().unwrap_err().to_string(),
///     "'25' is no sonar: write a number from 1 to 24, for example falsified:4"
/// );
/// # Ok::<(), certainty_sim::ring::RingFaultError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RingFault {
    /// Which sonar has it.
    pub sensor: SensorId,
    /// What is wrong.
    pub defect: RingDefect,
}

/// Why a text is no fault of a ring; displays as one line with an example.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum RingFaultError {
    /// A kind that does not exist.
    #[error(
        "unknown fault '{0}': write falsified, blind, stuck, crosstalk or misaligned, for example \
         blind:4"
    )]
    UnknownKind(Excerpt),
    /// No sonar of the ring.
    #[error("'{0}' is no sonar: write a number from 1 to 24, for example falsified:4")]
    BadSensor(Excerpt),
    /// A value for a kind that has none.
    #[error("{kind} takes no value: write {kind}:4 without '={value}'")]
    NoValue {
        /// The kind.
        kind: &'static str,
        /// What was written.
        value: Excerpt,
    },
    /// A value that is no quantity of the kind.
    #[error("{kind}: {source}")]
    Quantity {
        /// The kind.
        kind: &'static str,
        /// What is wrong with the value.
        source: QuantityError,
    },
}

impl FromStr for RingFault {
    type Err = RingFaultError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (spec, value) = match text.split_once('=') {
            Some((spec, value)) => (spec, Some(value)),
            None => (text, None),
        };
        let (kind, sensor) = spec.split_once(':').unwrap_or(("falsified", spec));
        let defect: RingDefect = kind.parse()?;
        let number = sensor
            .parse::<u8>()
            .ok()
            .filter(|&n| usize::from(n) <= SONARS);
        let sensor = number
            .and_then(SensorId::try_new)
            .ok_or_else(|| RingFaultError::BadSensor(Excerpt::new(sensor)))?;
        let defect = value.map_or(Ok(defect), |value| defect.with_value(value))?;
        Ok(Self { sensor, defect })
    }
}

impl FromStr for RingDefect {
    type Err = RingFaultError;

    /// Reads a kind, with its default value.
    fn from_str(kind: &str) -> Result<Self, Self::Err> {
        let found = Self::ALL.into_iter().find(|defect| defect.kind() == kind);
        found.ok_or_else(|| RingFaultError::UnknownKind(Excerpt::new(kind)))
    }
}

impl fmt::Display for RingFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.defect.kind(), self.sensor)?;
        match self.defect {
            RingDefect::Falsified(by) | RingDefect::Stuck(by) => write!(f, "={by}"),
            RingDefect::Misaligned(by) => {
                let degrees = f64::from(by.to_bits().cast_signed()) * 360.0 / 65536.0;
                write!(f, "={}deg", (degrees * 100.0).round() / 100.0)
            }
            RingDefect::Blind | RingDefect::Crosstalk => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_again() {
        for text in [
            "falsified:4=500mm",
            "blind:1",
            "stuck:24=350mm",
            "crosstalk:7",
            "misaligned:12=-20deg",
        ] {
            let fault: RingFault = text.parse().unwrap();
            assert_eq!(fault.to_string(), text);
        }
    }

    #[test]
    fn what_is_wrong_is_said_in_one_line() {
        for (text, said) in [
            ("", "'' is no sonar"),
            ("0", "'0' is no sonar"),
            ("4:blind", "unknown fault '4'"),
            ("blind", "'blind' is no sonar"),
            ("blind:4=3m", "takes no value"),
            ("stuck:4=3", "has no unit"),
            ("misaligned:4=nandeg", "not a finite number"),
            ("stuck:4=", "is not a number"),
        ] {
            let error = text.parse::<RingFault>().unwrap_err().to_string();
            assert!(error.contains(said), "{text}: {error}");
            assert!(!error.contains('\n'));
        }
    }
}
