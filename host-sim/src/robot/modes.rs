//! Who tells the robot what has failed, what it sees obstacles in, and who remembers; by their names.

use crate::fusion::{Method, UnknownMethod};
use core::fmt;
use core::str::FromStr;

/// Who tells the control level what has failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum HealthMode {
    /// An oracle, as in \[004\]: at once, and right.
    Given,
    /// The fusion level's health, and the cross-check.
    Diagnosed,
    /// Nobody: **F** is zero.
    Ignored,
}

impl HealthMode {
    /// All of them, in the order of reports.
    pub const ALL: [Self; 3] = [Self::Given, Self::Diagnosed, Self::Ignored];

    /// Returns its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Given => "given",
            Self::Diagnosed => "diagnosed",
            Self::Ignored => "ignored",
        }
    }
}

impl fmt::Display for HealthMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The name is none of a health mode's.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' is no way to know health; use given, diagnosed or ignored")]
pub struct UnknownHealthMode(pub String);

impl FromStr for HealthMode {
    type Err = UnknownHealthMode;

    fn from_str(name: &str) -> Result<Self, UnknownHealthMode> {
        let found = Self::ALL.into_iter().find(|mode| mode.name() == name);
        found.ok_or_else(|| UnknownHealthMode(name.to_owned()))
    }
}

/// Who remembers what the map shows, and lets it make up for what the sensors do not see.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Memory {
    /// Nobody, as in \[004\].
    Nobody,
    /// Who finds out by itself what has failed, and has a map for that.
    Diagnosed,
    /// Everyone, so that what memory is worth can be told from what diagnosis is.
    Everyone,
}

impl Memory {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Nobody, Self::Diagnosed, Self::Everyone];

    /// Returns its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Nobody => "nobody",
            Self::Diagnosed => "diagnosed",
            Self::Everyone => "everyone",
        }
    }

    /// Returns whether a robot in this mode remembers.
    #[must_use]
    pub fn serves(self, mode: HealthMode) -> bool {
        match self {
            Self::Nobody => false,
            Self::Diagnosed => mode == HealthMode::Diagnosed,
            Self::Everyone => true,
        }
    }
}

/// The name says of nobody that it remembers.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' does not say who remembers; use nobody, diagnosed or everyone")]
pub struct UnknownMemory(pub String);

impl FromStr for Memory {
    type Err = UnknownMemory;

    fn from_str(name: &str) -> Result<Self, UnknownMemory> {
        let found = Self::ALL.into_iter().find(|memory| memory.name() == name);
        found.ok_or_else(|| UnknownMemory(name.to_owned()))
    }
}

/// What the histogram is made from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MapSource {
    /// The scanner's last beams, as in \[004\].
    Beams,
    /// A certainty grid of all sensors' readings, as in the first vector field histogram.
    Map(Method),
}

impl fmt::Display for MapSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Beams => f.write_str("beams"),
            Self::Map(method) => method.fmt(f),
        }
    }
}

/// The name is neither beams nor a fusion method's.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' is nothing to see obstacles in; use beams, bayes, robust, trimmed or median")]
pub struct UnknownMapSource(pub String);

impl FromStr for MapSource {
    type Err = UnknownMapSource;

    fn from_str(name: &str) -> Result<Self, UnknownMapSource> {
        if name == "beams" {
            return Ok(Self::Beams);
        }
        let method: Result<Method, UnknownMethod> = name.parse();
        method
            .map(Self::Map)
            .map_err(|UnknownMethod(name)| UnknownMapSource(name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back_and_others_refused() {
        for mode in HealthMode::ALL {
            assert_eq!(mode.name().parse(), Ok(mode));
        }
        assert!("Given".parse::<HealthMode>().is_err());
        for memory in Memory::ALL {
            assert_eq!(memory.name().parse(), Ok(memory));
        }
        assert!("".parse::<Memory>().is_err());
        for name in ["beams", "bayes", "robust", "trimmed", "median"] {
            let source: MapSource = name.parse().unwrap();
            assert_eq!(source.to_string(), name);
        }
        assert!("".parse::<MapSource>().is_err());
    }

    #[test]
    fn memory_serves_whom_it_says() {
        let served = |memory: Memory| HealthMode::ALL.map(|mode| memory.serves(mode));
        assert_eq!(served(Memory::Nobody), [false; 3]);
        assert_eq!(served(Memory::Diagnosed), [false, true, false]);
        assert_eq!(served(Memory::Everyone), [true; 3]);
    }
}
