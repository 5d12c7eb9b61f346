//! Which sensors the car carries: letters of \[001\] Table 1.

use crate::transducer::SensorModel;
use core::fmt;
use core::str::FromStr;
use thiserror::Error;

/// One sensor of the crew: a letter of Table 1 and its errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CarSensor {
    /// The letter in Table 1.
    pub letter: char,
    /// The errors that the table gives it.
    pub model: SensorModel,
}

/// The car's pivoted sensors, in the order of their numbers, from right to left.
///
/// Possession proves that there are 1 to 15 of them. Written as letters of Table 1 (`ABC`, `CCE`) or as
/// a number from 3 to 7, which takes the letters in order and starts again at A after E.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorSet(Vec<CarSensor>);

/// The text names no crew.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error(
    "'{0}' is no set of sensors: write 1 to 15 letters A to E, such as ABC, or a number from 3 to 7"
)]
pub struct SensorSetError(String);

impl SensorSet {
    /// Most sensors that fit on the bumper.
    pub const MOST: usize = 15;

    /// Returns the first `count` sensors of Table 1, round and round; 1 to [`Self::MOST`] of them.
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

    /// Returns the same sensors with what `change` makes of their errors.
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

    /// Returns the sensors' names, for faults to be resolved against: they have numbers only.
    #[must_use]
    pub fn names(&self) -> Vec<&'static str> {
        vec![""; self.0.len()]
    }

    /// Returns how many sensors there are.
    #[must_use]
    pub fn count(&self) -> u8 {
        u8::try_from(self.0.len()).unwrap_or(u8::MAX)
    }
}

impl Default for SensorSet {
    /// A, B and C: the three that the car has.
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
    fn letters_and_numbers_name_sensors_of_table_1() {
        for (text, letters) in [("ABC", "ABC"), ("3", "ABC"), ("7", "ABCDEAB"), ("E", "E")] {
            assert_eq!(text.parse::<SensorSet>().unwrap().to_string(), letters);
        }
    }

    #[test]
    fn what_names_no_sensor_is_refused() {
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
