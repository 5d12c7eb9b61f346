//! One set-up of the campaign, and all of them.

use certainty_sim::fault::{Defect, Fault, FaultSpec, SpecError};
use certainty_sim::fusion::Method;
use certainty_sim::simulation::SweepOverlap;
use core::fmt;
use core::str::FromStr;

/// What is wrong with the faulty sensors: a kind with its value, without a sensor or a time.
///
/// Written as a fault without its sensor, such as `stuck-near=250mm` or `intermittent=stuck-far`; or
/// `none`. A chattering sensor is no kind of its own: its rate is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaultKind(Option<Fault>);

/// The text names no fault.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FaultKindError {
    /// Not a fault at all.
    #[error(transparent)]
    Spec(#[from] SpecError),
    /// It says which sensor or when, or how often it reports.
    #[error(
        "'{0}': a scenario's fault is a kind and its value, such as stuck-near=250mm; sensors, times \
         and rates are the campaign's"
    )]
    TooMuch(String),
}

impl FaultKind {
    /// No fault.
    pub const NONE: Self = Self(None);

    /// Returns the fault; `None` where nothing is wrong.
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
    /// What is wrong.
    pub fault: FaultKind,
    /// How many times as often as the others a faulty sensor reports.
    pub rate: u32,
    /// How many sensors there are.
    pub sensors: u8,
    /// How much of the arc each sees.
    pub overlap: SweepOverlap,
    /// How many sweeps the map is made of.
    pub sweeps: u32,
    /// How many sensors are faulty; which, is drawn anew in every world.
    pub faulty: u8,
}

/// Which set-ups a campaign has: every combination of these that makes sense.
#[derive(Debug, Clone, PartialEq)]
pub struct Selection {
    /// Kinds of fault.
    pub faults: Vec<FaultKind>,
    /// Rates of the faulty sensors; without a fault there is only 1.
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
    /// Methods to compare; the oracle comes in addition.
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
    /// Returns the set-ups in a fixed order: the last of the fields above varies fastest.
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

#[cfg(test)]
mod tests {
    use super::*;

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
    fn kinds_are_read_back() {
        for kind in Selection::default().faults {
            assert_eq!(kind.to_string().parse(), Ok(kind));
        }
        let full = |text: &str| text.parse::<FaultKind>().unwrap().to_string();
        assert_eq!(full("stuck-near"), "stuck-near=250mm");
        assert_eq!(full("intermittent=noise=30%"), "intermittent=noise=30%");
    }

    #[test]
    fn what_is_no_kind_is_refused() {
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
}
