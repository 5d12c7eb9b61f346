//! Whether a sensor is broken for good.

use super::{Choices, Open};
use certainty_sim::fault::FaultSpec;

/// What is wrong with sensor 2 from the first measurement to the last, beyond Table 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Permanent {
    /// Nothing.
    None,
    /// It always says *no object*.
    StuckFar,
    /// It always says 250 mm.
    StuckNear,
    /// It says any distance of its range.
    Random,
}

impl Permanent {
    /// Returns the fault as a run takes it.
    pub(in crate::table2) fn faults(self) -> Vec<FaultSpec> {
        let spec = match self {
            Self::None => return Vec::new(),
            Self::StuckFar => "stuck-far:2",
            Self::StuckNear => "stuck-near:2=250mm",
            Self::Random => "random:2",
        };
        spec.parse().into_iter().collect()
    }
}

impl Open for Permanent {
    const NAME: &'static str = "fault";
    const ALL: &'static [Self] = &[Self::None, Self::StuckFar, Self::StuckNear, Self::Random];

    fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::StuckFar => "stuck far",
            Self::StuckNear => "stuck near",
            Self::Random => "random",
        }
    }

    fn reason(self) -> &'static str {
        match self {
            Self::None => "§6.2 mentions none beyond Table 1",
            Self::StuckFar => "[000] §3: a sensor that always reports \"no object nearby\"",
            Self::StuckNear => "§2.1: a permanent failure, as it may be a stained lens",
            Self::Random => "§2.1: wrong measurements, as they may be of a broken sensor",
        }
    }

    fn of(choices: &mut Choices) -> &mut Self {
        &mut choices.fault
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_fault_is_one_of_sensor_2_and_none_is_none() {
        let faults = Permanent::ALL.iter().map(|fault| fault.faults());
        let told: Vec<Vec<String>> = faults
            .map(|specs| specs.iter().map(ToString::to_string).collect())
            .collect();
        assert_eq!(told[0], [""; 0]);
        assert_eq!(
            told[1..],
            [["stuck-far:2"], ["stuck-near:2=250mm"], ["random:2"]]
        );
    }
}
