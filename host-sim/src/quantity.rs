//! Quantities as people write them: `100mm`, `15deg`, `3s`, `20%`.
//!
//! A number without a unit is refused, never guessed: a command line is no place to find out whether
//! 8 meant metres. Every function is a parser that `clap` takes as it is.

use certainty_core::units::{BinaryAngle, Millimeters, Point, Ticks};
use core::fmt;
use thiserror::Error;

/// A displacement along a line, in millimetres; either sign.
///
/// Units and range: within ±[`Point::LIMIT`] mm where [`signed_length`] made it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct SignedMillimeters(i32);

impl SignedMillimeters {
    /// Creates a displacement of `mm` millimetres.
    #[must_use]
    pub const fn new(mm: i32) -> Self {
        Self(mm)
    }

    /// Returns the number of millimetres.
    #[must_use]
    pub const fn get(self) -> i32 {
        self.0
    }
}

impl fmt::Display for SignedMillimeters {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}mm", self.0)
    }
}

/// A share of a whole, as a percentage.
///
/// Possession proves that it is a number from 0 % to 100 %. Kept as it was written, so that
/// printing and reading it again yields the same bits.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Default)]
pub struct Percentage(f64);

impl Percentage {
    /// Creates a percentage; `None` outside 0..=100 and for what is no number.
    #[must_use]
    pub fn try_new(percent: f64) -> Option<Self> {
        // Adding zero turns −0 into 0.
        (0.0..=100.0)
            .contains(&percent)
            .then_some(Self(percent + 0.0))
    }

    /// Returns the share, `0.0..=1.0`.
    #[must_use]
    pub fn fraction(self) -> f64 {
        self.0 / 100.0
    }
}

impl fmt::Display for Percentage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}%", self.0)
    }
}

/// Why a text is no quantity; displays as one line that says what is allowed.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum QuantityError {
    /// A number without its unit.
    #[error("'{text}' has no unit: write {example}")]
    MissingUnit {
        /// What was written.
        text: Excerpt,
        /// What could have been.
        example: &'static str,
    },
    /// A unit that this kind of quantity does not have.
    #[error("'{text}' has the unknown unit '{unit}': write {example}")]
    UnknownUnit {
        /// What was written.
        text: Excerpt,
        /// The part that is no unit.
        unit: Excerpt,
        /// What could have been.
        example: &'static str,
    },
    /// No number in front of the unit.
    #[error("'{text}' is not a number with a unit: write {example}")]
    NotANumber {
        /// What was written.
        text: Excerpt,
        /// What could have been.
        example: &'static str,
    },
    /// NaN or an infinity.
    #[error("'{text}' is not a finite number: write {example}")]
    NotFinite {
        /// What was written.
        text: Excerpt,
        /// What could have been.
        example: &'static str,
    },
    /// Beyond what the quantity can hold.
    #[error("'{text}' is too large: at most {most}")]
    TooLarge {
        /// What was written.
        text: Excerpt,
        /// The largest value.
        most: &'static str,
    },
    /// Below zero, where that has no meaning.
    #[error("'{text}' is negative: write {example}")]
    Negative {
        /// What was written.
        text: Excerpt,
        /// What could have been.
        example: &'static str,
    },
}

/// The start of a text somebody wrote, fit to be quoted in a line of an error message.
///
/// Possession proves that it is short and holds no control character, whatever was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Excerpt(String);

impl Excerpt {
    /// Longest excerpt, in characters before escaping.
    pub const MOST: usize = 40;

    /// Quotes the start of `text`.
    #[must_use]
    pub fn new(text: &str) -> Self {
        let mut quoted: String = text
            .chars()
            .take(Self::MOST)
            .flat_map(char::escape_debug)
            .collect();
        if text.chars().nth(Self::MOST).is_some() {
            quoted.push('…');
        }
        Self(quoted)
    }
}

impl fmt::Display for Excerpt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// A unit and how many base units it is.
type Unit = (&'static str, f64);

/// One kind of quantity: its units, the largest value, and how it is written.
struct Kind {
    units: &'static [Unit],
    /// Largest value in base units.
    most: f64,
    most_written: &'static str,
    example: &'static str,
    signed: bool,
}

const LENGTH: Kind = Kind {
    units: &[("mm", 1.0), ("cm", 10.0), ("m", 1000.0)],
    most: Point::LIMIT as f64,
    most_written: "268435456mm",
    example: "a length such as 100mm, 35cm or 8m",
    signed: false,
};

const SIGNED_LENGTH: Kind = Kind {
    example: "a length such as -200mm, 35cm or 8m",
    signed: true,
    ..LENGTH
};

const ANGLE: Kind = Kind {
    units: &[("deg", 1.0), ("rad", 180.0 / core::f64::consts::PI)],
    // Beyond a hundred turns either way it is a slip of the pen.
    most: 36_000.0,
    most_written: "36000deg either way",
    example: "an angle such as 15deg or 0.5rad",
    signed: true,
};

const OPENING: Kind = Kind {
    most: 179.99,
    most_written: "179.99deg",
    example: "an opening angle such as 15deg, 20deg or 0.5rad",
    signed: false,
    ..ANGLE
};

const DURATION: Kind = Kind {
    units: &[("ms", 1.0), ("s", 1000.0), ("min", 60_000.0)],
    most: u32::MAX as f64,
    most_written: "4294967295ms",
    example: "a time such as 250ms, 3s or 2min",
    signed: false,
};

const PERCENTAGE: Kind = Kind {
    units: &[("%", 1.0)],
    most: 100.0,
    most_written: "100%",
    example: "a percentage such as 20%",
    signed: false,
};

impl Kind {
    /// The value of `text` in base units: finite, within the limits of its kind.
    fn parse(&self, text: &str) -> Result<f64, QuantityError> {
        let example = self.example;
        let quoted = Excerpt::new(text);
        let whole = text.trim();
        let number = whole.trim_end_matches(|c: char| c.is_alphabetic() || c == '%');
        let unit = &whole[number.len()..];
        let number = number.trim_end();
        let Ok(value) = number.parse::<f64>() else {
            // `nan` and `inf` are letters, as units are.
            let of_letters = self
                .units
                .iter()
                .find_map(|(unit, _)| whole.strip_suffix(unit))
                .unwrap_or(whole)
                .parse::<f64>();
            return Err(if of_letters.is_ok() {
                QuantityError::NotFinite {
                    text: quoted,
                    example,
                }
            } else {
                QuantityError::NotANumber {
                    text: quoted,
                    example,
                }
            });
        };
        if unit.is_empty() {
            return Err(QuantityError::MissingUnit {
                text: quoted,
                example,
            });
        }
        let Some((_, scale)) = self.units.iter().find(|(name, _)| *name == unit) else {
            return Err(QuantityError::UnknownUnit {
                text: quoted,
                unit: Excerpt::new(unit),
                example,
            });
        };
        // A spelt-out infinity says so; digits that overflow are merely too large.
        if number.ends_with(char::is_alphabetic) {
            return Err(QuantityError::NotFinite {
                text: quoted,
                example,
            });
        }
        let value = value * scale;
        if value < 0.0 && !self.signed {
            return Err(QuantityError::Negative {
                text: quoted,
                example,
            });
        }
        if value.abs() > self.most {
            return Err(QuantityError::TooLarge {
                text: quoted,
                most: self.most_written,
            });
        }
        Ok(value)
    }
}

/// Reads a length, `0mm..=268435456mm` ([`Point::LIMIT`]), in `mm`, `cm` or `m`.
///
/// Rounds to the nearest millimetre, ties up.
///
/// ```
/// use certainty_core::units::Millimeters;
/// use certainty_sim::quantity::length;
///
/// assert_eq!(length("8m")?, Millimeters::new(8000));
/// assert_eq!(
///     length("8").unwrap_err().to_string(),
///     "'8' has no unit: write a length such as 100mm, 35cm or 8m"
/// );
/// # Ok::<(), certainty_sim::quantity::QuantityError>(())
/// ```
///
/// # Errors
///
/// [`QuantityError`] names what is wrong with the text.
pub fn length(text: &str) -> Result<Millimeters, QuantityError> {
    LENGTH
        .parse(text)
        .map(|mm| Millimeters::new(mm.round() as u32))
}

/// Reads a displacement, `-268435456mm..=268435456mm`, in `mm`, `cm` or `m`.
///
/// Rounds to the nearest millimetre, ties away from zero.
///
/// # Errors
///
/// [`QuantityError`] names what is wrong with the text.
pub fn signed_length(text: &str) -> Result<SignedMillimeters, QuantityError> {
    SIGNED_LENGTH
        .parse(text)
        .map(|mm| SignedMillimeters::new(mm.round() as i32))
}

/// Reads an angle of either sign in `deg` or `rad`, up to a hundred turns.
///
/// Rounds to the nearest thousandth of a degree, then to the nearest step of a [`BinaryAngle`].
///
/// # Errors
///
/// [`QuantityError`] names what is wrong with the text.
pub fn angle(text: &str) -> Result<BinaryAngle, QuantityError> {
    ANGLE
        .parse(text)
        .map(|degrees| BinaryAngle::from_millidegrees((degrees * 1000.0).round() as i32))
}

/// Reads the opening angle of a beam in `deg` or `rad`: 0 to less than half a turn.
///
/// Rounds as [`angle`] does.
///
/// # Errors
///
/// [`QuantityError`] names what is wrong with the text.
pub fn opening(text: &str) -> Result<BinaryAngle, QuantityError> {
    OPENING
        .parse(text)
        .map(|degrees| BinaryAngle::from_millidegrees((degrees * 1000.0).round() as i32))
}

/// Reads a time since the clock's start, `0ms..=4294967295ms`, in `ms`, `s` or `min`.
///
/// Rounds to the nearest tick, ties up.
///
/// # Errors
///
/// [`QuantityError`] names what is wrong with the text.
pub fn duration(text: &str) -> Result<Ticks, QuantityError> {
    DURATION.parse(text).map(|ms| Ticks::new(ms.round() as u32))
}

/// Reads a percentage, `0%..=100%`.
///
/// # Errors
///
/// [`QuantityError`] names what is wrong with the text.
pub fn percentage(text: &str) -> Result<Percentage, QuantityError> {
    // In range already, and 0 has no other sign here.
    PERCENTAGE
        .parse(text)
        .map(|percent| Percentage(percent + 0.0))
}

/// Reads a percentage, `0%..=100%`, as a fraction `0.0..=1.0`.
///
/// # Errors
///
/// [`QuantityError`] names what is wrong with the text.
pub fn fraction(text: &str) -> Result<f64, QuantityError> {
    percentage(text).map(Percentage::fraction)
}

#[cfg(test)]
mod tests;
