//! What can be wrong with a fault as it is written.

use crate::quantity::{Excerpt, QuantityError};
use thiserror::Error;

/// The kinds, as errors list them.
const KINDS: &str = "stuck-far, stuck-near, noise, output-noise, bias, scale, random, dropout, \
                     chatter or intermittent";

/// The kinds that a bench has besides.
const WIRE_KINDS: &str = "line-high, line-low, line-floating, unplugged, cut-short, mute, \
                          servo-jammed, servo-off, motor-dead, motor-weak, slip or motor-off";

/// Why a text is no fault; displays as one line with an example.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum SpecError {
    /// No colon between kind and sensor.
    #[error(
        "'{text}' names no sensor: write KIND:SENSOR[=VALUE][@FROM[..TO]], for example stuck-far:2"
    )]
    NoSensor {
        /// What was written.
        text: Excerpt,
    },
    /// A kind that does not exist.
    #[error("unknown fault '{kind}': write {KINDS}, for example stuck-far:2")]
    UnknownKind {
        /// What was written.
        kind: Excerpt,
    },
    /// A kind that neither a sensor nor its wires have.
    #[error("unknown fault '{kind}': write {KINDS}, {WIRE_KINDS}, for example stuck-far:2")]
    UnknownWireKind {
        /// What was written.
        kind: Excerpt,
    },
    /// Neither a number from 1 to 255 nor a name.
    #[error(
        "'{sensor}' is no sensor: write a number from 1 to 255 or a name, for example stuck-far:2"
    )]
    BadSensor {
        /// What was written.
        sensor: Excerpt,
    },
    /// A sensor that is not there.
    #[error("no sensor '{sensor}': {there_are}")]
    NoSuchSensor {
        /// What was written.
        sensor: Excerpt,
        /// The sensors there are.
        there_are: String,
    },
    /// A motor that is not there.
    #[error("no motor '{motor}': write right or left, for example motor-dead:left")]
    NoSuchMotor {
        /// What was written.
        motor: Excerpt,
    },
    /// A value for a kind that has none.
    #[error("{kind} takes no value: write {kind}:{of} without '={value}'")]
    NoValue {
        /// The kind.
        kind: &'static str,
        /// Whom it could be of.
        of: &'static str,
        /// What was written.
        value: Excerpt,
    },
    /// A value that is no quantity of the kind.
    #[error("{kind}: {source}, for example {example}")]
    Quantity {
        /// The kind.
        kind: &'static str,
        /// What is wrong with the value.
        source: QuantityError,
        /// A fault that would do.
        example: &'static str,
    },
    /// A number that is out of what the kind takes.
    #[error("{kind}: '{value}' is not {allowed}, for example {example}")]
    BadValue {
        /// The kind.
        kind: &'static str,
        /// What was written.
        value: Excerpt,
        /// What could have been.
        allowed: &'static str,
        /// A fault that would do.
        example: &'static str,
    },
    /// An intermittent fault that does not say which, or is intermittent twice.
    #[error("intermittent needs another kind as its value, for example intermittent:1=stuck-far")]
    IntermittentWhat,
    /// A window that is neither readings nor times.
    #[error(
        "'@{window}' is no window: write two readings or two times, for example @0..50 or @3s..8s"
    )]
    BadWindow {
        /// What was written.
        window: Excerpt,
    },
    /// A window that ends before it starts, or at its start.
    #[error(
        "'@{window}' is empty: its end is not within, so it must be above its start, for example @0..50"
    )]
    EmptyWindow {
        /// What was written.
        window: Excerpt,
    },
}

impl SpecError {
    /// The refusal of a value for a kind that takes none.
    pub(crate) fn no_value(kind: &'static str, value: &str) -> Self {
        Self::no_value_of(kind, "2", value)
    }

    /// The same of a kind that is not of a sensor.
    pub(crate) fn no_value_of(kind: &'static str, of: &'static str, value: &str) -> Self {
        Self::NoValue {
            kind,
            of,
            value: Excerpt::new(value),
        }
    }
}
