//! Scenarios of the campaign, and the TOML files that select them.
//!
//! ```toml
//! faults = ["none", "stuck-far", "stuck-near=250mm"] # kinds with their values
//! rates = [1, 4]                  # reports of a faulty sensor per report of another
//! sensors = [3, 4, 5, 7]
//! overlap = ["full", "partial"]
//! sweeps = [1, 4]
//! faulty = [1, 2, 3]              # as far as the fault hypothesis allows
//! methods = ["bayes", "robust", "trimmed", "median"]
//! ```
//!
//! Every key may be left out and then means all that is shown.

use certainty_sim::transducer::SensorSet;

use certainty_sim::fault::{Defect, Fault, FaultSpec, SpecError, Times};
use certainty_sim::fusion::Method;
use certainty_sim::simulation::SweepOverlap;
use certainty_sim::toml_file::{self, TomlError, TomlFile};
use core::fmt;
use core::str::FromStr;
use std::path::Path;
use toml::Spanned;

/// The fault of the faulty sensors: a kind with its value, without a sensor or a time.
///
/// Written as a fault without its sensor, such as `stuck-near=250mm` or `intermittent=stuck-far`; or
/// `none`. Chatter is no kind here: [`Scenario::rate`] sets it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaultKind(Option<Fault>);

/// The text is no kind of fault.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FaultKindError {
    /// Not a fault at all.
    #[error(transparent)]
    Spec(#[from] SpecError),
    /// It has a sensor, a time or a rate.
    #[error(
        "'{0}' has a sensor, a time or a rate: expected a kind and its value, such as stuck-near=250mm"
    )]
    TooMuch(String),
}

impl FaultKind {
    /// No fault.
    pub const NONE: Self = Self(None);

    /// Returns the fault; `None` without one.
    #[must_use]
    pub const fn fault(&self) -> Option<Fault> {
        self.0
    }
}

impl FromStr for FaultKind {
    type Err = FaultKindError;

    fn from_str(text: &str) -> Result<Self, FaultKindError> {
        if text == "none" {
            return Ok(Self::NONE);
        }
        if text.contains([':', '@']) {
            let shown = text.chars().take(40).collect();
            return Err(FaultKindError::TooMuch(shown));
        }
        let (kind, value) = match text.split_once('=') {
            Some((kind, value)) => (kind, format!("={value}")),
            None => (text, String::new()),
        };
        let spec: FaultSpec = format!("{kind}:1{value}").parse()?;
        if matches!(spec.fault.defect, Defect::Chatter(_)) {
            return Err(FaultKindError::TooMuch(text.to_owned()));
        }
        Ok(Self(Some(spec.fault)))
    }
}

impl fmt::Display for FaultKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            None => f.write_str("none"),
            Some(fault) => fault.fmt(f),
        }
    }
}

/// One set-up of the campaign.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scenario {
    /// The fault of the faulty sensors.
    pub fault: FaultKind,
    /// Reports of a faulty sensor per report of another.
    pub rate: u32,
    /// Number of sensors.
    pub sensors: u8,
    /// How much of the arc each sweeps.
    pub overlap: SweepOverlap,
    /// Number of sweeps of the map.
    pub sweeps: u32,
    /// Number of faulty sensors; each world draws which.
    pub faulty: u8,
}

/// The scenarios of a campaign: every combination of these values within the fault hypothesis.
#[derive(Debug, Clone, PartialEq)]
pub struct Selection {
    /// Kinds of fault.
    pub faults: Vec<FaultKind>,
    /// Rates of the faulty sensors; without a fault only 1.
    pub rates: Vec<u32>,
    /// Numbers of sensors.
    pub sensors: Vec<u8>,
    /// Overlaps.
    pub overlaps: Vec<SweepOverlap>,
    /// Numbers of sweeps.
    pub sweeps: Vec<u32>,
    /// Numbers of faulty sensors; those above ⌊(n − 1)/2⌋ of n sensors, the fault hypothesis of
    /// \[001\] §2.1, are left out.
    pub faulty: Vec<u8>,
    /// Methods to compare; the oracle is added to them.
    pub methods: Vec<Method>,
}

impl Default for Selection {
    /// Everything.
    fn default() -> Self {
        let kinds = [
            "none",
            "stuck-far",
            "stuck-near",
            "noise",
            "bias",
            "scale",
            "random",
            "dropout",
            "intermittent=stuck-far",
        ];
        Self {
            faults: kinds.iter().filter_map(|kind| kind.parse().ok()).collect(),
            rates: vec![1, 4],
            sensors: vec![3, 4, 5, 7],
            overlaps: vec![SweepOverlap::Full, SweepOverlap::Partial],
            sweeps: vec![1, 4],
            faulty: vec![1, 2, 3],
            methods: Method::ALL.to_vec(),
        }
    }
}

impl Selection {
    /// Returns the scenarios in a fixed order: the last of the fields above varies fastest.
    #[must_use]
    pub fn scenarios(&self) -> Vec<Scenario> {
        let mut scenarios = Vec::new();
        for &fault in &self.faults {
            let sound = fault == FaultKind::NONE;
            let rates = if sound { &[1][..] } else { &self.rates };
            let faulty = if sound { &[0][..] } else { &self.faulty };
            for &rate in rates {
                for &sensors in &self.sensors {
                    for &overlap in &self.overlaps {
                        for &sweeps in &self.sweeps {
                            let tolerable = (sensors.saturating_sub(1)) / 2;
                            let faulty = faulty.iter().filter(|&&faulty| faulty <= tolerable);
                            scenarios.extend(faulty.map(|&faulty| Scenario {
                                fault,
                                rate,
                                sensors,
                                overlap,
                                sweeps,
                                faulty,
                            }));
                        }
                    }
                }
            }
        }
        scenarios
    }
}

/// The file's name in errors.
const WHAT: &str = "scenario file";

/// Most sweeps of a map: a quarter of an hour of simulated time.
const MOST_SWEEPS: u32 = 256;

/// A list with the place of every entry in the file.
type List<T> = Option<Spanned<Vec<Spanned<T>>>>;

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct ScenarioFile {
    faults: List<String>,
    rates: List<u32>,
    sensors: List<u8>,
    overlap: List<String>,
    sweeps: List<u32>,
    faulty: List<u8>,
    methods: List<String>,
}

impl Selection {
    /// Reads the scenario file at `path`.
    ///
    /// # Errors
    ///
    /// [`TomlError`] with the line, the key and what was expected.
    pub fn load(path: &Path) -> Result<Self, TomlError> {
        Self::parse(&toml_file::read(path, WHAT)?, &path.display().to_string())
    }

    /// Reads the bytes of a scenario file; errors name it `file`.
    ///
    /// ```
    /// use certainty_repro::campaign::Selection;
    ///
    /// let text = b"faults = ['stuck-far']\nrates = [4]\nsensors = [3]\nsweeps = [4]";
    /// let selection = Selection::parse(text, "mine.toml")?;
    /// assert_eq!(selection.scenarios().len(), 2); // with full and with partial overlap
    ///
    /// let wrong = Selection::parse(b"rates = [1]\nsensors = [3, 99]", "mine.toml").unwrap_err();
    /// assert_eq!(wrong.to_string(), "mine.toml:2: sensors: 99 is out of range: expected 1..=15");
    /// # Ok::<(), certainty_sim::toml_file::TomlError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`TomlError::Invalid`] with the line, the key and what was expected.
    pub fn parse(bytes: &[u8], file: &str) -> Result<Self, TomlError> {
        let file = TomlFile {
            file,
            bytes,
            what: WHAT,
            sample: "rates = [1, 4] or faults = [\"stuck-far\"]",
        };
        let all = Self::default();
        let written: ScenarioFile = file.parse()?;
        let key = |name| Key { file, name };
        let most_faulty = (SensorSet::MOST as u32 - 1) / 2;
        let selection = Self {
            faults: key("faults").texts(written.faults, all.faults)?,
            rates: key("rates").numbers(written.rates, all.rates, 1, Times::MOST)?,
            sensors: key("sensors").numbers(
                written.sensors,
                all.sensors,
                1,
                SensorSet::MOST as u32,
            )?,
            overlaps: key("overlap").texts(written.overlap, all.overlaps)?,
            sweeps: key("sweeps").numbers(written.sweeps, all.sweeps, 1, MOST_SWEEPS)?,
            faulty: key("faulty").numbers(written.faulty, all.faulty, 1, most_faulty)?,
            methods: key("methods").texts(written.methods, all.methods)?,
        };
        if selection.scenarios().is_empty() {
            let problem = "sensors, faulty: no number of sensors tolerates that number of faulty \
                           ones: expected at most (n - 1) / 2 of n";
            return Err(file.invalid(0, problem.to_owned()));
        }
        Ok(selection)
    }
}

/// A key of the file.
struct Key<'a> {
    file: TomlFile<'a>,
    name: &'static str,
}

impl Key<'_> {
    /// The entries of `list`, each read by `read`; `all` where the key is left out.
    fn entries<T, U: PartialEq>(
        &self,
        list: List<T>,
        all: Vec<U>,
        read: impl Fn(T) -> Result<U, String>,
    ) -> Result<Vec<U>, TomlError> {
        let Some(list) = list else { return Ok(all) };
        let at = list.span().start;
        let invalid = |at: usize, problem| {
            let problem = format!("{}: {problem}", self.name);
            self.file.invalid(at, problem)
        };
        let mut entries = Vec::new();
        for entry in list.into_inner() {
            let at = entry.span().start;
            let value = read(entry.into_inner()).map_err(|problem| invalid(at, problem))?;
            if entries.contains(&value) {
                return Err(invalid(
                    at,
                    "the entry is repeated: expected it once".to_owned(),
                ));
            }
            entries.push(value);
        }
        if entries.is_empty() {
            let problem = "the list is empty: expected an entry, or no such key";
            return Err(invalid(at, problem.to_owned()));
        }
        Ok(entries)
    }

    fn texts<U>(&self, list: List<String>, all: Vec<U>) -> Result<Vec<U>, TomlError>
    where
        U: FromStr<Err: fmt::Display> + PartialEq,
    {
        self.entries(list, all, |text| {
            text.parse().map_err(|error: U::Err| error.to_string())
        })
    }

    fn numbers<U>(
        &self,
        list: List<U>,
        all: Vec<U>,
        least: u32,
        most: u32,
    ) -> Result<Vec<U>, TomlError>
    where
        U: Copy + PartialEq + Into<u32>,
    {
        self.entries(list, all, |number| {
            let value = number.into();
            if (least..=most).contains(&value) {
                Ok(number)
            } else {
                Err(format!(
                    "{value} is out of range: expected {least}..={most}"
                ))
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn all_combinations_within_the_fault_hypothesis() {
        let all = Selection::default().scenarios();
        // Without a fault 4 crews x 2 overlaps x 2 lengths; with one 8 kinds x 2 rates x 2 x 2 and
        // 1, 1, 2 and 3 numbers of faulty sensors.
        assert_eq!(all.len(), 4 * 2 * 2 + 8 * 2 * 2 * 2 * (1 + 1 + 2 + 3));
        assert!(all.iter().all(|s| 2 * s.faulty < s.sensors));
        assert!(
            all.iter()
                .all(|s| (s.faulty == 0) == (s.fault == FaultKind::NONE))
        );
    }

    #[test]
    fn kinds_parse_from_their_own_text() {
        for kind in Selection::default().faults {
            assert_eq!(kind.to_string().parse(), Ok(kind));
        }
        let full = |text: &str| text.parse::<FaultKind>().unwrap().to_string();
        assert_eq!(full("stuck-near"), "stuck-near=250mm");
        assert_eq!(full("intermittent=noise=30%"), "intermittent=noise=30%");
    }

    #[test]
    fn texts_that_are_no_kind_are_refused() {
        for text in [
            "",
            "stuck",
            "stuck-far:2",
            "stuck-far@3s",
            "chatter=4",
            "bias=8",
            "none=1",
        ] {
            assert!(text.parse::<FaultKind>().is_err(), "{text}");
        }
    }

    fn error(text: &str) -> String {
        Selection::parse(text.as_bytes(), "x.toml")
            .unwrap_err()
            .to_string()
    }

    #[test]
    fn an_empty_file_selects_everything() {
        assert_eq!(Selection::parse(b"", "x").unwrap(), Selection::default());
    }

    #[test]
    fn an_error_names_line_and_key() {
        assert_eq!(
            error("rates = [1]\nfaults = ['stuck']"),
            "x.toml:2: faults: unknown fault 'stuck': write stuck-far, stuck-near, noise, output-noise, \
             bias, scale, random, dropout, chatter or intermittent, for example stuck-far:2"
        );
        assert_eq!(
            error("\n\nsweeps = [1,\n 0]"),
            "x.toml:4: sweeps: 0 is out of range: expected 1..=256"
        );
        assert_eq!(
            error("rates = []"),
            "x.toml:1: rates: the list is empty: expected an entry, or no such key"
        );
        assert_eq!(
            error("rates = [4, 4]"),
            "x.toml:1: rates: the entry is repeated: expected it once"
        );
        assert_eq!(
            error("overlap = ['some']"),
            "x.toml:1: overlap: unknown overlap 'some': expected full or partial"
        );
        assert!(error("rate = [1]").starts_with("x.toml:1: unknown field `rate`"));
        assert!(error("rates = 'x'").starts_with("x.toml:1: "));
        assert!(
            error("faults = ['random']\nsensors = [3]\nfaulty = [2]")
                .starts_with("x.toml:1: sensors, faulty: no number of sensors")
        );
    }

    proptest! {
        #[test]
        fn no_file_causes_a_panic(text in "((faults|rates|sensors|overlap|sweeps|faulty|methods) = \\[[0-9',a-z=-]{0,12}\\]?\n){0,4}") {
            let _: Result<Selection, TomlError> = Selection::parse(text.as_bytes(), "x");
        }
    }
}
