//! Scenario files: TOML that selects a part of the campaign.
//!
//! ```toml
//! faults = ["none", "stuck-far", "stuck-near=250mm"] # kinds with their values
//! rates = [1, 4]                  # how many times as often a faulty sensor reports
//! sensors = [3, 4, 5, 7]
//! overlap = ["full", "partial"]
//! sweeps = [1, 4]
//! faulty = [1, 2, 3]              # as far as the fault hypothesis allows
//! methods = ["bayes", "robust", "trimmed", "median"]
//! ```
//!
//! Every key may be left out and then means all that is shown.

use super::Selection;
use certainty_sim::fault::Times;
use certainty_sim::toml_file::{self, TomlError, TomlFile};
use certainty_sim::transducer::SensorSet;
use core::fmt::Display;
use core::str::FromStr;
use std::path::Path;
use toml::Spanned;

/// What the file is called in errors.
const WHAT: &str = "scenario file";

/// Most sweeps of a map: a quarter of an hour of the car's time.
const MOST_SWEEPS: u32 = 256;

/// A list as it is written, every entry with its place.
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
    /// [`TomlError`] names the line, the key and what to do.
    pub fn load(path: &Path) -> Result<Self, TomlError> {
        Self::parse(&toml_file::read(path, WHAT)?, &path.display().to_string())
    }

    /// Reads the bytes of a scenario file, which errors call `file`.
    ///
    /// ```
    /// use certainty_repro::campaign::Selection;
    ///
    /// let text = b"faults = ['stuck-far']\nrates = [4]\nsensors = [3]\nsweeps = [4]";
    /// let selection = Selection::parse(text, "mine.toml")?;
    /// assert_eq!(selection.scenarios().len(), 2); // with full and with partial overlap
    ///
    /// let wrong = Selection::parse(b"rates = [1]\nsensors = [3, 99]", "mine.toml").unwrap_err();
    /// assert_eq!(wrong.to_string(), "mine.toml:2: sensors: 99 is outside 1..=15");
    /// # Ok::<(), certainty_sim::toml_file::TomlError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`TomlError::Invalid`] names the line, the key and what to do.
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
            let problem = "sensors, faulty: no number of sensors tolerates so many faulty \
                           ones; at most (n - 1) / 2 of n may be";
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
        let complaint = |at: usize, problem| {
            let problem = format!("{}: {problem}", self.name);
            self.file.invalid(at, problem)
        };
        let mut entries = Vec::new();
        for entry in list.into_inner() {
            let at = entry.span().start;
            let value = read(entry.into_inner()).map_err(|problem| complaint(at, problem))?;
            if entries.contains(&value) {
                return Err(complaint(at, "listed twice; leave one out".to_owned()));
            }
            entries.push(value);
        }
        if entries.is_empty() {
            let problem = "the list is empty; name an entry or leave the key out";
            return Err(complaint(at, problem.to_owned()));
        }
        Ok(entries)
    }

    fn texts<U>(&self, list: List<String>, all: Vec<U>) -> Result<Vec<U>, TomlError>
    where
        U: FromStr<Err: Display> + PartialEq,
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
                Err(format!("{value} is outside {least}..={most}"))
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn complaint(text: &str) -> String {
        Selection::parse(text.as_bytes(), "x.toml")
            .unwrap_err()
            .to_string()
    }

    #[test]
    fn an_empty_file_selects_everything() {
        assert_eq!(Selection::parse(b"", "x").unwrap(), Selection::default());
    }

    #[test]
    fn a_complaint_names_line_and_key() {
        assert_eq!(
            complaint("rates = [1]\nfaults = ['stuck']"),
            "x.toml:2: faults: unknown fault 'stuck': write stuck-far, stuck-near, noise, output-noise, \
             bias, scale, random, dropout, chatter or intermittent, for example stuck-far:2"
        );
        assert_eq!(
            complaint("\n\nsweeps = [1,\n 0]"),
            "x.toml:4: sweeps: 0 is outside 1..=256"
        );
        assert_eq!(
            complaint("rates = []"),
            "x.toml:1: rates: the list is empty; name an entry or leave the key out"
        );
        assert_eq!(
            complaint("rates = [4, 4]"),
            "x.toml:1: rates: listed twice; leave one out"
        );
        assert_eq!(
            complaint("overlap = ['some']"),
            "x.toml:1: overlap: unknown overlap 'some': expected full or partial"
        );
        assert!(complaint("rate = [1]").starts_with("x.toml:1: unknown field `rate`"));
        assert!(complaint("rates = 'x'").starts_with("x.toml:1: "));
        assert!(
            complaint("faults = ['random']\nsensors = [3]\nfaulty = [2]")
                .starts_with("x.toml:1: sensors, faulty: no number of sensors")
        );
    }

    proptest! {
        #[test]
        fn no_file_panics(text in "((faults|rates|sensors|overlap|sweeps|faulty|methods) = \\[[0-9',a-z=-]{0,12}\\]?\n){0,4}") {
            let _: Result<Selection, TomlError> = Selection::parse(text.as_bytes(), "x");
        }
    }
}
