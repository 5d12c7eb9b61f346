//! The errors of real GP2D02 sensors, Table 1 of \[001\], and sets of these sensors.

use core::fmt;
use core::str::FromStr;
use thiserror::Error;

/// The value of "< 1 %" in Table 1: half of that, an open choice.
const BELOW_ONE_PERCENT: f64 = 0.005;

/// The statistical errors of one sensor.
///
/// Possession proves that the probabilities are within 0..=1, that the accuracy is finite and not
/// negative, and that false distances come from a part of the range.
///
/// Table 1 gives three numbers a sensor, but defines neither *accuracy* nor the distance that is reported
/// where *no object* is missed. Both are open choices here; see the accessors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorModel {
    accuracy: f64,
    p_failed_inf: f64,
    p_false_inf: f64,
    false_distances: (f64, f64),
}

/// Why a sensor model was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum SensorModelError {
    /// The accuracy is negative or not finite.
    #[error("the accuracy must be a fraction of 0 or more")]
    Accuracy,
    /// A probability is outside 0..=1.
    #[error("a probability must be within 0..=1")]
    Probability,
    /// False distances must come from an ascending part of the range.
    #[error("false distances must come from a part of the range, 0 <= from <= to <= 1")]
    FalseDistances,
}

impl SensorModel {
    /// Sensor A: 6 %, 16 %, 4 %.
    pub const A: Self = Self::printed(0.06, 0.16, 0.04);
    /// Sensor B: 10 %, 18 %, 8 %.
    pub const B: Self = Self::printed(0.10, 0.18, 0.08);
    /// Sensor C: 7 %, < 1 %, < 1 %.
    pub const C: Self = Self::printed(0.07, BELOW_ONE_PERCENT, BELOW_ONE_PERCENT);
    /// Sensor D: 12 %, 18 %, 9 %.
    pub const D: Self = Self::printed(0.12, 0.18, 0.09);
    /// Sensor E: 3 %, < 1 %, < 1 %.
    pub const E: Self = Self::printed(0.03, BELOW_ONE_PERCENT, BELOW_ONE_PERCENT);

    /// The five sensors of Table 1, in its order, with their letters.
    pub const TABLE_1: [(char, Self); 5] = [
        ('A', Self::A),
        ('B', Self::B),
        ('C', Self::C),
        ('D', Self::D),
        ('E', Self::E),
    ];

    /// A sensor without statistical errors: only its curve and its byte limit it.
    pub const FLAWLESS: Self = Self::printed(0.0, 0.0, 0.0);

    /// A line of the table; false distances from the far half of the range.
    const fn printed(accuracy: f64, p_failed_inf: f64, p_false_inf: f64) -> Self {
        Self {
            accuracy,
            p_failed_inf,
            p_false_inf,
            false_distances: (0.5, 1.0),
        }
    }

    /// Creates a model from the three columns of Table 1, as fractions.
    ///
    /// # Errors
    ///
    /// [`SensorModelError`] names the number that is outside its range.
    pub fn try_new(
        accuracy: f64,
        p_failed_inf: f64,
        p_false_inf: f64,
    ) -> Result<Self, SensorModelError> {
        if !(accuracy.is_finite() && accuracy >= 0.0) {
            return Err(SensorModelError::Accuracy);
        }
        if ![p_failed_inf, p_false_inf]
            .iter()
            .all(|p| (0.0..=1.0).contains(p))
        {
            return Err(SensorModelError::Probability);
        }
        Ok(Self::printed(accuracy, p_failed_inf, p_false_inf))
    }

    /// Returns the model with false distances from another part of the range: `from` and `to` are
    /// fractions between the nearest and the farthest distance.
    ///
    /// # Errors
    ///
    /// [`SensorModelError::FalseDistances`] unless 0 ≤ `from` ≤ `to` ≤ 1.
    pub fn with_false_distances(self, from: f64, to: f64) -> Result<Self, SensorModelError> {
        if !(0.0 <= from && from <= to && to <= 1.0) {
            return Err(SensorModelError::FalseDistances);
        }
        Ok(Self {
            false_distances: (from, to),
            ..self
        })
    }

    /// Returns the model with its accuracy taken as `deviations` standard deviations; a bound of the error
    /// is about two.
    ///
    /// # Errors
    ///
    /// [`SensorModelError::Accuracy`] unless `deviations` is a number above 0.
    pub fn with_accuracy_of(self, deviations: f64) -> Result<Self, SensorModelError> {
        let accuracy = self.accuracy / deviations;
        if !(deviations > 0.0 && accuracy.is_finite()) {
            return Err(SensorModelError::Accuracy);
        }
        Ok(Self { accuracy, ..self })
    }

    /// Returns the standard deviation of the relative error of a distance, as a fraction.
    ///
    /// That Table 1 calls this accuracy is an open choice.
    #[must_use]
    pub const fn accuracy(&self) -> f64 {
        self.accuracy
    }

    /// Returns the probability of a distance where no object is in range.
    #[must_use]
    pub const fn p_failed_inf(&self) -> f64 {
        self.p_failed_inf
    }

    /// Returns the probability of *no object* where one is in range.
    #[must_use]
    pub const fn p_false_inf(&self) -> f64 {
        self.p_false_inf
    }

    /// Returns the part of the range from which false distances are drawn, uniformly.
    ///
    /// An open choice. The default is the far half, 0.5 to 1, where the curve is so flat that a few counts
    /// of noise look like a distance.
    #[must_use]
    pub const fn false_distances(&self) -> (f64, f64) {
        self.false_distances
    }
}

/// A sensor of the car: a letter of Table 1 and its errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CarSensor {
    /// Its letter in Table 1.
    pub letter: char,
    /// Its errors.
    pub model: SensorModel,
}

/// The car's pivoted sensors, in the order of their numbers, from right to left.
///
/// Possession proves that there are 1 to 15 of them. Written as letters of Table 1 (`ABC`, `CCE`) or as
/// a number from 3 to 7, which takes the letters in order and starts again at A after E.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorSet(Vec<CarSensor>);

/// A text that names no set of sensors.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error(
    "unknown sensors '{0}': expected 1 to 15 letters A to E, such as ABC, or a number from 3 to 7"
)]
pub struct SensorSetError(String);

impl SensorSet {
    /// Most sensors that fit on the bumper.
    pub const MOST: usize = 15;

    /// Returns the first `count` sensors of Table 1, starting again at A after E; 1 to [`Self::MOST`].
    #[must_use]
    pub fn of_table_1(count: usize) -> Self {
        let count = count.clamp(1, Self::MOST);
        let table = SensorModel::TABLE_1.iter().cycle().take(count);
        Self(
            table
                .map(|&(letter, model)| CarSensor { letter, model })
                .collect(),
        )
    }

    /// Returns the same sensors with their errors changed by `change`.
    #[must_use]
    pub fn with_models(self, change: impl Fn(SensorModel) -> SensorModel) -> Self {
        let members = self.0.into_iter();
        let changed = members.map(|member| CarSensor {
            model: change(member.model),
            ..member
        });
        Self(changed.collect())
    }

    /// Returns the sensors, the first being sensor 1.
    #[must_use]
    pub fn members(&self) -> &[CarSensor] {
        &self.0
    }

    /// Returns the sensors' names for the assignment of faults: all empty, as they have numbers only.
    #[must_use]
    pub fn names(&self) -> Vec<&'static str> {
        vec![""; self.0.len()]
    }

    /// Returns the number of sensors.
    #[must_use]
    pub fn count(&self) -> u8 {
        u8::try_from(self.0.len()).unwrap_or(u8::MAX)
    }
}

impl Default for SensorSet {
    /// A, B and C, the car's own.
    fn default() -> Self {
        Self::of_table_1(3)
    }
}

impl FromStr for SensorSet {
    type Err = SensorSetError;

    fn from_str(text: &str) -> Result<Self, SensorSetError> {
        let refused = || SensorSetError(text.chars().take(20).collect());
        if let Ok(count) = text.parse::<usize>() {
            return match count {
                3..=7 => Ok(Self::of_table_1(count)),
                _ => Err(refused()),
            };
        }
        let member = |letter: char| {
            let found = SensorModel::TABLE_1.iter().find(|row| row.0 == letter);
            found.map(|&(letter, model)| CarSensor { letter, model })
        };
        let members: Option<Vec<_>> = text.chars().take(Self::MOST + 1).map(member).collect();
        match members {
            Some(members) if (1..=Self::MOST).contains(&members.len()) => Ok(Self(members)),
            _ => Err(refused()),
        }
    }
}

impl fmt::Display for SensorSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0
            .iter()
            .try_for_each(|member| write!(f, "{}", member.letter))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_1_is_as_printed() {
        let rows = SensorModel::TABLE_1.map(|(letter, model)| {
            let percent = |p: f64| {
                if p < 0.01 {
                    "<1".to_owned()
                } else {
                    format!("{:.0}", p * 100.0)
                }
            };
            format!(
                "{letter} {} {} {}",
                percent(model.accuracy()),
                percent(model.p_failed_inf()),
                percent(model.p_false_inf())
            )
        });
        assert_eq!(
            rows,
            [
                "A 6 16 4",
                "B 10 18 8",
                "C 7 <1 <1",
                "D 12 18 9",
                "E 3 <1 <1"
            ]
        );
    }

    #[test]
    fn an_accuracy_of_two_deviations_halves_the_scatter() {
        let halved = SensorModel::A.with_accuracy_of(2.0).unwrap();
        assert_eq!(halved, SensorModel::try_new(0.03, 0.16, 0.04).unwrap());
        for deviations in [0.0, -1.0, f64::NAN] {
            let refused = SensorModel::A.with_accuracy_of(deviations);
            assert_eq!(refused, Err(SensorModelError::Accuracy), "{deviations}");
        }
    }

    #[test]
    fn values_outside_their_range_are_refused() {
        assert_eq!(
            SensorModel::try_new(-0.1, 0.0, 0.0),
            Err(SensorModelError::Accuracy)
        );
        assert_eq!(
            SensorModel::try_new(0.1, 1.1, 0.0),
            Err(SensorModelError::Probability)
        );
        assert_eq!(
            SensorModel::try_new(0.1, 0.0, f64::NAN),
            Err(SensorModelError::Probability)
        );
        assert_eq!(
            SensorModel::A.with_false_distances(0.6, 0.5),
            Err(SensorModelError::FalseDistances)
        );
        assert_eq!(SensorModel::try_new(0.06, 0.16, 0.04), Ok(SensorModel::A));
    }

    #[test]
    fn letters_and_numbers_name_sensors_of_table_1() {
        for (text, letters) in [("ABC", "ABC"), ("3", "ABC"), ("7", "ABCDEAB"), ("E", "E")] {
            assert_eq!(text.parse::<SensorSet>().unwrap().to_string(), letters);
        }
    }

    #[test]
    fn other_texts_name_no_sensors() {
        for text in [
            "",
            "2",
            "8",
            "-3",
            "F",
            "abc",
            "AB C",
            "AAAAAAAAAAAAAAAA",
            "é",
        ] {
            assert!(text.parse::<SensorSet>().is_err(), "{text}");
        }
    }
}
