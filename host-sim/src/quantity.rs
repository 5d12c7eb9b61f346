//! Quantities with units: `100mm`, `15deg`, `3s`, `20%`.
//!
//! A number without a unit is an error. Every parser can be a value parser of `clap`. [`degrees`],
//! [`signed_degrees`] and [`share`] are the numbers that reports have.

use certainty_core::health::Confidence;
use certainty_core::units::{BinaryAngle, Millimeters, Point, Ticks};
use core::fmt;
use core::num::NonZeroU32;
use thiserror::Error;

/// A displacement along a line, in millimetres, of either sign.
///
/// Units and range: within ±[`Point::LIMIT`] mm if [`signed_length`] parsed it.
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
/// Possession proves that it is a number from 0 % to 100 %. The percentage itself is stored, so that
/// printing and parsing it yields the same bits.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Default)]
pub struct Percentage(f64);

impl Percentage {
    /// Creates a percentage; `None` outside 0..=100 and for NaN.
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

/// The field of view of a sensor that looks in several directions.
///
/// Units and range: 1 to 360,000 thousandths of a degree; possession proves that it is not 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FieldOfView(NonZeroU32);

impl FieldOfView {
    /// A full turn.
    const TURN: u32 = 360_000;

    /// Creates a field of view; more than a full turn is a full turn, and 0 is `None`.
    #[must_use]
    pub const fn try_new(millidegrees: u32) -> Option<Self> {
        let within = if millidegrees < Self::TURN {
            millidegrees
        } else {
            Self::TURN
        };
        match NonZeroU32::new(within) {
            Some(millidegrees) => Some(Self(millidegrees)),
            None => None,
        }
    }

    /// Returns the field of view in degrees, at most 360.
    #[must_use]
    pub fn degrees(self) -> f64 {
        f64::from(self.0.get()) / 1000.0
    }
}

impl fmt::Display for FieldOfView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}deg", self.degrees())
    }
}

/// Why a text is not a quantity; displays as one line with what is allowed.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("'{text}' {problem}")]
pub struct QuantityError {
    text: Excerpt,
    problem: String,
}

/// The start of a text, for quoting in a line of an error message.
///
/// Possession proves that it is short and has no control character.
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

/// One kind of quantity: its units, its largest value, and an example.
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
    // More than a hundred turns either way is a mistake.
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

const FIELD_OF_VIEW: Kind = Kind {
    most_written: "36000deg",
    example: "a field of view such as 180deg, 270deg or 6.3rad",
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
        let whole = text.trim();
        let number = whole.trim_end_matches(|c: char| c.is_alphabetic() || c == '%');
        let unit = &whole[number.len()..];
        let number = number.trim_end();
        let scale = self.units.iter().find(|(name, _)| *name == unit);
        let value = number.parse::<f64>();
        // The letters of `nan` and `inf` look like units.
        let of_letters = self
            .units
            .iter()
            .find_map(|(unit, _)| whole.strip_suffix(unit));
        let not_finite = of_letters.unwrap_or(whole).parse::<f64>();
        let problem = match (value, scale) {
            (Err(_), _) if not_finite.is_ok() => "is not a finite number".to_owned(),
            (Err(_), _) => "is not a number with a unit".to_owned(),
            (Ok(_), None) if unit.is_empty() => "has no unit".to_owned(),
            (Ok(_), None) => format!("has the unknown unit '{}'", Excerpt::new(unit)),
            (Ok(_), Some(_)) if number.ends_with(char::is_alphabetic) => {
                "is not a finite number".to_owned()
            }
            (Ok(value), Some((_, scale))) => {
                let value = value * scale;
                if value < 0.0 && !self.signed {
                    "is negative".to_owned()
                } else if value.abs() <= self.most {
                    return Ok(value);
                } else {
                    let problem = format!("is too large: at most {}", self.most_written);
                    let text = Excerpt::new(text);
                    return Err(QuantityError { text, problem });
                }
            }
        };
        Err(QuantityError {
            text: Excerpt::new(text),
            problem: format!("{problem}: write {}", self.example),
        })
    }
}

/// Parses a length, `0mm..=268435456mm` ([`Point::LIMIT`]), in `mm`, `cm` or `m`.
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
/// [`QuantityError`] if the text is not such a quantity.
pub fn length(text: &str) -> Result<Millimeters, QuantityError> {
    LENGTH
        .parse(text)
        .map(|mm| Millimeters::new(mm.round() as u32))
}

/// Parses a displacement, `-268435456mm..=268435456mm`, in `mm`, `cm` or `m`.
///
/// Rounds to the nearest millimetre, ties away from zero.
///
/// # Errors
/// [`QuantityError`] if the text is not such a quantity.
pub fn signed_length(text: &str) -> Result<SignedMillimeters, QuantityError> {
    SIGNED_LENGTH
        .parse(text)
        .map(|mm| SignedMillimeters::new(mm.round() as i32))
}

/// Parses an angle of either sign in `deg` or `rad`, up to a hundred turns.
///
/// Rounds to the nearest thousandth of a degree, then to the nearest step of a [`BinaryAngle`].
///
/// # Errors
/// [`QuantityError`] if the text is not such a quantity.
pub fn angle(text: &str) -> Result<BinaryAngle, QuantityError> {
    ANGLE
        .parse(text)
        .map(|degrees| BinaryAngle::from_millidegrees((degrees * 1000.0).round() as i32))
}

/// Parses the opening angle of a beam in `deg` or `rad`: 0 to less than half a turn.
///
/// Rounds as [`angle`] does.
///
/// # Errors
/// [`QuantityError`] if the text is not such a quantity.
pub fn opening(text: &str) -> Result<BinaryAngle, QuantityError> {
    OPENING
        .parse(text)
        .map(|degrees| BinaryAngle::from_millidegrees((degrees * 1000.0).round() as i32))
}

/// Parses a field of view in `deg` or `rad`; a full turn or more is a full turn.
///
/// Rounds to the nearest thousandth of a degree, ties up; 0 is refused.
///
/// # Errors
/// [`QuantityError`] if the text is not such a quantity.
pub fn field_of_view(text: &str) -> Result<FieldOfView, QuantityError> {
    let degrees = FIELD_OF_VIEW.parse(text)?;
    FieldOfView::try_new((degrees * 1000.0).round() as u32).ok_or_else(|| QuantityError {
        text: Excerpt::new(text),
        problem: format!("is 0: write {}", FIELD_OF_VIEW.example),
    })
}

/// Parses a time since the clock's start, `0ms..=4294967295ms`, in `ms`, `s` or `min`.
///
/// Rounds to the nearest tick, ties up.
///
/// # Errors
/// [`QuantityError`] if the text is not such a quantity.
pub fn duration(text: &str) -> Result<Ticks, QuantityError> {
    DURATION.parse(text).map(|ms| Ticks::new(ms.round() as u32))
}

/// Parses a percentage, `0%..=100%`.
///
/// # Errors
/// [`QuantityError`] if the text is not such a quantity.
pub fn percentage(text: &str) -> Result<Percentage, QuantityError> {
    // In range already; adding zero turns −0 into 0.
    PERCENTAGE
        .parse(text)
        .map(|percent| Percentage(percent + 0.0))
}

/// Parses a percentage, `0%..=100%`, as a fraction `0.0..=1.0`.
///
/// # Errors
/// [`QuantityError`] if the text is not such a quantity.
pub fn fraction(text: &str) -> Result<f64, QuantityError> {
    percentage(text).map(Percentage::fraction)
}

/// Returns an angle in degrees, 0 to less than 360: exact.
#[must_use]
pub fn degrees(angle: BinaryAngle) -> f64 {
    f64::from(angle.to_bits()) * 360.0 / 65536.0
}

/// Returns an angle in degrees, −180 to less than 180: exact.
#[must_use]
pub fn signed_degrees(angle: BinaryAngle) -> f64 {
    f64::from(angle.to_bits().cast_signed()) * 360.0 / 65536.0
}

/// Returns a confidence as a share of the full one, `0.0..=1.0`.
#[must_use]
pub fn share(confidence: Confidence) -> f64 {
    f64::from(confidence.to_bits()) / f64::from(Confidence::FULL.to_bits())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn lengths_have_three_units() {
        for (text, mm) in [
            ("100mm", 100),
            ("35cm", 350),
            ("8m", 8000),
            ("0.25m", 250),
            (" 1e3 mm ", 1000),
            ("0mm", 0),
            ("-0m", 0),
            ("0.5mm", 1),
            ("0.49mm", 0),
            ("268435456mm", 1 << 28),
        ] {
            assert_eq!(length(text), Ok(Millimeters::new(mm)), "{text}");
        }
        assert_eq!(signed_length("-200mm"), Ok(SignedMillimeters::new(-200)));
        assert_eq!(signed_length("+2cm"), Ok(SignedMillimeters::new(20)));
    }

    #[test]
    fn angles_times_and_shares_have_their_units() {
        assert_eq!(angle("90deg"), Ok(BinaryAngle::QUARTER));
        assert_eq!(angle("-270deg"), Ok(BinaryAngle::QUARTER));
        assert_eq!(angle("3.14159265rad"), Ok(BinaryAngle::HALF));
        assert_eq!(duration("3s"), Ok(Ticks::new(3000)));
        assert_eq!(duration("250ms"), Ok(Ticks::new(250)));
        assert_eq!(duration("2min"), Ok(Ticks::new(120_000)));
        for (text, degrees) in [("270deg", 270.0), ("360deg", 360.0), ("7rad", 360.0)] {
            assert_eq!(field_of_view(text).unwrap().degrees(), degrees, "{text}");
        }
        assert_eq!(fraction("20%"), Ok(0.2));
        assert_eq!(fraction("100%"), Ok(1.0));
    }

    #[test]
    fn degrees_are_those_of_a_turn() {
        for (text, unsigned, signed) in [
            ("0deg", 0.0, 0.0),
            ("90deg", 90.0, 90.0),
            ("180deg", 180.0, -180.0),
            ("-45deg", 315.0, -45.0),
        ] {
            let angle = angle(text).unwrap();
            let both = (degrees(angle), signed_degrees(angle));
            assert_eq!(both, (unsigned, signed), "{text}");
        }
        assert_eq!(
            degrees(BinaryAngle::from_bits(u16::MAX)),
            359.994_506_835_937_5
        );
        let shares = [Confidence::FULL, Confidence::from_bits(0)].map(share);
        assert_eq!(shares, [1.0, 0.0]);
    }

    #[test]
    fn each_error_is_one_line_with_an_example() {
        let example = "a length such as 100mm, 35cm or 8m";
        for (text, problem) in [
            ("100", "has no unit"),
            ("3furlongs", "has the unknown unit 'furlongs'"),
            ("nanmm", "is not a finite number"),
            ("-inf m", "is not a finite number"),
            ("269km", "has the unknown unit 'km'"),
            ("-1mm", "is negative"),
            ("mm", "is not a number with a unit"),
            ("", "is not a number with a unit"),
        ] {
            let line = format!("'{text}' {problem}: write {example}");
            assert_eq!(length(text).unwrap_err().to_string(), line);
        }
        for (line, error) in [
            (
                "'1e400mm' is too large: at most 268435456mm",
                length("1e400mm").err(),
            ),
            (
                "'300000m' is too large: at most 268435456mm",
                length("300000m").err(),
            ),
            (
                "'0deg' is 0: write a field of view such as 180deg, 270deg or 6.3rad",
                field_of_view("0deg").err(),
            ),
            (
                "'101%' is too large: at most 100%",
                percentage("101%").err(),
            ),
            (
                "'1e9deg' is too large: at most 36000deg either way",
                angle("1e9deg").err(),
            ),
        ] {
            assert_eq!(error.unwrap().to_string(), line);
        }
    }

    #[test]
    fn long_text_is_quoted_as_one_short_line() {
        let line = length(&"7\n".repeat(10_000)).unwrap_err().to_string();
        assert!(!line.contains('\n') && line.len() < 200, "{line}");
    }

    proptest! {
        #[test]
        fn any_text_is_read_or_refused_in_one_line(text in any::<String>(), unit in "(mm|deg|s|%)?") {
            let text = text + &unit;
            let errors = [
                length(&text).err(),
                signed_length(&text).err(),
                angle(&text).err(),
                field_of_view(&text).err(),
                duration(&text).err(),
                percentage(&text).err(),
            ];
            for error in errors.into_iter().flatten() {
                prop_assert_eq!(error.to_string().lines().count(), 1);
            }
        }

        #[test]
        fn millimetres_are_read_back(mm in 0..=1_u32 << 28) {
            prop_assert_eq!(length(&Millimeters::new(mm).to_string()), Ok(Millimeters::new(mm)));
        }

        #[test]
        fn percentage_is_read_back_to_the_bit(percent in 0.0..=100.0_f64) {
            let written = Percentage::try_new(percent).unwrap();
            prop_assert_eq!(percentage(&written.to_string()), Ok(written));
        }
    }
}
