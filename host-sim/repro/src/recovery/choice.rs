//! What \[001\] §6.3 leaves open, each choice with its name on the command line.

use core::str::FromStr;

/// Whose readings are counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Count {
    /// Each sensor's own: 200 rounds in which every sensor reads once, 600 readings of all.
    ///
    /// The text's own words: "*its* first 50 readings" are sensor 1's, and what Fig. 7 draws over
    /// one axis, 50, 30 and 200 readings, can only be of one kind.
    Each,
    /// Those of all sensors together: the fault spoils the 17 of sensor 1 among the first 50.
    All,
}

impl Count {
    /// Returns the name it has on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Each => "each",
            Self::All => "all",
        }
    }
}

impl FromStr for Count {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "each" => Ok(Self::Each),
            "all" => Ok(Self::All),
            _ => Err(format!("'{text}' counts nothing: write each or all")),
        }
    }
}

/// What the noise is added to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Noise {
    /// The output signal, whatever it says: *no object* counts as the farthest distance.
    ///
    /// The text's own words, "to the output signal", make no exception for *no object*.
    Output,
    /// Echoes alone: where there is no object there is nothing to be wrong about.
    Echo,
}

impl Noise {
    /// Returns the name it has on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Output => "output",
            Self::Echo => "echo",
        }
    }

    /// Returns the kind of fault that it is.
    #[must_use]
    pub const fn kind(self) -> &'static str {
        match self {
            Self::Output => "output-noise",
            Self::Echo => "noise",
        }
    }
}

impl FromStr for Noise {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "output" => Ok(Self::Output),
            "echo" => Ok(Self::Echo),
            _ => Err(format!("'{text}' is no noise: write output or echo")),
        }
    }
}
