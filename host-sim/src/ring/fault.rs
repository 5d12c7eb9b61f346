//! Faults of a ring's sonars, and their notation: `[KIND:]SENSOR[=VALUE]`.
//!
//! | kind | value | default | meaning |
//! |---|---|---|---|
//! | `falsified` | a length | `500mm` | every distance on the sonar's paths is off by that, *no echo* too |
//! | `blind` | – | – | neither sends nor receives |
//! | `stuck` | a length | `500mm` | reports that distance for every pulse it receives |
//! | `crosstalk` | – | – | receives a foreign pulse at a random time before its own echo |
//! | `misaligned` | an angle | `30deg` | is turned to the left by that |
//!
//! A number alone is `falsified`, the fault of \[003\] §7, which gives no value. The defaults are our
//! choices: five times the paper's threshold, and a turn of two slots.

use super::acoustics::SONARS;
use crate::quantity::{self, Excerpt, QuantityError};
use certainty_core::sensor::SensorId;
use certainty_core::units::{BinaryAngle, Millimeters};
use core::fmt;
use core::str::FromStr;
use thiserror::Error;

/// A kind of fault with its value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RingDefect {
    /// Every distance is off by this much.
    Falsified(Millimeters),
    /// Sends and receives nothing.
    Blind,
    /// Reports always this distance.
    Stuck(Millimeters),
    /// Receives foreign pulses.
    Crosstalk,
    /// Is turned to the left by this angle.
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

    /// Returns the name of the kind.
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

/// A fault of one sonar.
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
///     "unknown sonar '25': expected a number from 1 to 24, such as falsified:4"
/// );
/// # Ok::<(), certainty_sim::ring::RingFaultError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RingFault {
    /// The faulty sonar.
    pub sensor: SensorId,
    /// Its fault.
    pub defect: RingDefect,
}

/// Why a text is not a fault of a ring; displays as one line with an example.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum RingFaultError {
    /// An unknown kind.
    #[error(
        "unknown fault '{0}': expected falsified, blind, stuck, crosstalk or misaligned, such as \
         blind:4"
    )]
    UnknownKind(Excerpt),
    /// Not a sonar of the ring.
    #[error("unknown sonar '{0}': expected a number from 1 to 24, such as falsified:4")]
    UnknownSensor(Excerpt),
    /// A value for a kind that takes none.
    #[error("{kind} takes no value: remove '={value}'")]
    NoValue {
        /// The kind.
        kind: &'static str,
        /// The value.
        value: Excerpt,
    },
    /// A value that is not a quantity of the kind.
    #[error("{kind}: {source}")]
    Quantity {
        /// The kind.
        kind: &'static str,
        /// Why.
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
            .ok_or_else(|| RingFaultError::UnknownSensor(Excerpt::new(sensor)))?;
        let defect = value.map_or(Ok(defect), |value| defect.with_value(value))?;
        Ok(Self { sensor, defect })
    }
}

impl FromStr for RingDefect {
    type Err = RingFaultError;

    /// Parses a kind; it gets its default value.
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
                let degrees = quantity::signed_degrees(by);
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
    fn a_displayed_fault_parses_to_itself() {
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
    fn errors_are_one_line_and_name_the_text() {
        for (text, expected) in [
            ("", "unknown sonar ''"),
            ("0", "unknown sonar '0'"),
            ("4:blind", "unknown fault '4'"),
            ("blind", "unknown sonar 'blind'"),
            ("blind:4=3m", "takes no value"),
            ("stuck:4=3", "has no unit"),
            ("misaligned:4=nandeg", "not a finite number"),
            ("stuck:4=", "is not a number"),
        ] {
            let error = text.parse::<RingFault>().unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error}");
            assert!(!error.contains('\n'));
        }
    }
}
