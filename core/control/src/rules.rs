//! What the control level leaves open, and the check of it.

use super::coverage::CoverageConfig;
use super::histogram::HistogramConfig;
use super::{Braitenberg, Corner, Effort, Limits, Mounting, Ramp, Threshold};
use certainty_core::units::Millimeters;
use core::fmt;

/// α of \[004\] eq. 1: the weight of each behaviour, by the distance to the nearest obstacle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Weights {
    /// α₀: the Braitenberg behaviour.
    pub braitenberg: Ramp,
    /// α₁: the histogram's.
    pub histogram: Ramp,
    /// α₂: turning to the goal.
    pub azimuth: Ramp,
    /// α₃: going ahead.
    pub speed: Ramp,
}

/// What a failed rangefinder does to the others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Blame {
    /// It lowers the credibility of them all: μ₀ of \[004\] eq. 14, 0.39 for one of six.
    Shared,
    /// Nothing: each counts as far as it is believed itself, and μ₀ stays 1.
    ///
    /// [`Failures`](super::Failures) say who has failed, so the others need not be doubted; \[004\] does not
    /// say whether a failed rangefinder's reading still counts.
    Own,
}

/// The parameters of a [`Controller`](super::Controller), before they are checked.
///
/// \[004\] gives β₁, β₂, c₁, c₂, both accelerations and the radius of the goal; the rest it draws without
/// numbers (Fig. 5) or leaves open.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ControlConfig {
    /// The weights of eq. 2.
    pub braitenberg: Braitenberg,
    /// `D_idef` of the rangefinders, eq. 3 and 5.
    pub rangefinder_default: Millimeters,
    /// What farther than that means, eq. 3 or 5.
    pub outlook: Mounting,
    /// `D_idef` of the scanner's beams and `W_safe`, eq. 6 and 7.
    pub histogram: HistogramConfig,
    /// `D_th`, §3 b.
    pub threshold: Threshold,
    /// How many beams nearer a valley on the other side must be to be taken.
    pub commitment: u8,
    /// α, Fig. 5.
    pub weights: Weights,
    /// What a failed rangefinder does to the others.
    pub blame: Blame,
    /// What must be seen to go how fast.
    pub coverage: CoverageConfig,
    /// Full speed and both `a_th`, eq. 16.
    pub limits: Limits,
    /// The goal is reached so far from it; 0.5 m in §4.
    pub goal_radius: Millimeters,
    /// Readings older than so many ticks count as missing; 1 to 2^30.
    pub stale_after: u32,
}

/// A ramp whose corners are known to ascend.
const fn ramp(corners: [(u32, i32); 4]) -> Ramp {
    /// A height in steps of 1/16.
    const fn corner(corner: (u32, i32)) -> Corner {
        Corner {
            at: Millimeters::new(corner.0),
            height: Effort::from_bits(corner.1.wrapping_mul(1 << (Effort::FRAC_NBITS - 4))),
        }
    }
    let [a, b, c, d] = corners;
    match Ramp::try_new([corner(a), corner(b), corner(c), corner(d)]) {
        Ok(ramp) => ramp,
        Err(_) => LEVEL,
    }
}

/// Nothing, everywhere.
const LEVEL: Ramp = {
    const fn corner(mm: u32) -> Corner {
        Corner {
            at: Millimeters::new(mm),
            height: Effort::ZERO,
        }
    }
    match Ramp::try_new([corner(0), corner(1), corner(2), corner(3)]) {
        Ok(ramp) => ramp,
        Err(_) => panic!("no such ramp"),
    }
};

/// One eighth.
const EIGHTH: Effort = Effort::lit("0.125");

impl ControlConfig {
    /// A robot of 0.9 m by 0.6 m that goes 1 m/s and sees 4 m.
    ///
    /// Near obstacles the avoiding behaviours dominate, far from them speed and goal, as \[004\] §3 asks.
    pub const DEFAULT: Self = Self {
        braitenberg: Braitenberg::new([
            Effort::lit("-0.5"),
            Effort::lit("-0.4"),
            Effort::lit("-0.3"),
        ]),
        rangefinder_default: Millimeters::new(1500),
        outlook: Mounting::Level,
        histogram: HistogramConfig {
            default: Millimeters::new(3000),
            safe: Millimeters::new(550),
        },
        threshold: Threshold::new(140),
        commitment: 10,
        weights: Weights {
            braitenberg: ramp([(300, 16), (800, 12), (1500, 6), (2500, 0)]),
            histogram: ramp([(300, 16), (1000, 20), (2500, 16), (3500, 8)]),
            azimuth: ramp([(300, 4), (800, 6), (1500, 10), (2500, 20)]),
            speed: ramp([(300, 3), (600, 6), (1200, 12), (2000, 16)]),
        },
        blame: Blame::Shared,
        coverage: CoverageConfig {
            // Without the scanner half of full speed, and none once a corner is seen by nobody.
            rangefinders: [EIGHTH, EIGHTH, Effort::ZERO, Effort::ZERO, EIGHTH, EIGHTH],
            scanner: Effort::ONE,
            least: Effort::lit("0.3"),
        },
        limits: Limits::DEFAULT,
        goal_radius: Millimeters::new(500),
        stale_after: 300,
    };
}

impl Default for ControlConfig {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The checked [`ControlConfig`].
///
/// Possession proves that nothing divides by zero, that both accelerations are above zero, and that
/// every part of the coverage is within 0..=1, the least above 0: with every sensor failed, the robot
/// stands still.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ControlRules(ControlConfig);

/// Why a configuration was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ControlConfigError {
    /// A default distance is zero.
    Default,
    /// Full speed or an acceleration is zero.
    Limits,
    /// A part of the coverage is outside 0..=1, or none at all is enough.
    Coverage,
    /// Readings are never fresh, or for ever.
    Stale,
}

impl fmt::Display for ControlConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Default => "default distances must be above zero",
            Self::Limits => "full speed and both accelerations must be above zero",
            Self::Coverage => "coverage must be within 0 and 1, the least above 0",
            Self::Stale => "readings must count for at least a tick and at most 2^30",
        })
    }
}

impl core::error::Error for ControlConfigError {}

impl ControlRules {
    /// The rules of [`ControlConfig::DEFAULT`].
    pub const DEFAULT: Self = Self(ControlConfig::DEFAULT);

    /// Checks the configuration.
    ///
    /// # Errors
    ///
    /// [`ControlConfigError`] names what cannot be.
    pub const fn try_new(config: ControlConfig) -> Result<Self, ControlConfigError> {
        const fn is_part(signal: Effort) -> bool {
            0 <= signal.to_bits() && signal.to_bits() <= Effort::ONE.to_bits()
        }
        let coverage = &config.coverage;
        let [a, b, c, d, e, f] = coverage.rangefinders;
        let parts = [a, b, c, d, e, f, coverage.scanner, coverage.least];
        let mut rest: &[Effort] = &parts;
        let mut all_parts = true;
        while let [part, others @ ..] = rest {
            all_parts &= is_part(*part);
            rest = others;
        }
        let limits = &config.limits;
        let distances = [config.rangefinder_default, config.histogram.default];
        if matches!(distances, [Millimeters::ZERO, _] | [_, Millimeters::ZERO]) {
            Err(ControlConfigError::Default)
        } else if limits.full_speed_mm_s == 0
            || limits.faster_mm_s2 == 0
            || limits.slower_mm_s2 == 0
        {
            Err(ControlConfigError::Limits)
        } else if !all_parts || coverage.least.to_bits() == 0 {
            Err(ControlConfigError::Coverage)
        } else if config.stale_after == 0 || config.stale_after > 1 << 30 {
            Err(ControlConfigError::Stale)
        } else {
            Ok(Self(config))
        }
    }

    /// Returns the configuration.
    #[must_use]
    pub const fn config(&self) -> &ControlConfig {
        &self.0
    }
}

impl Default for ControlRules {
    fn default() -> Self {
        Self::DEFAULT
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_passes_its_own_check() {
        assert_eq!(
            ControlRules::try_new(ControlConfig::DEFAULT),
            Ok(ControlRules::DEFAULT)
        );
        for weight in [
            ControlConfig::DEFAULT.weights.speed,
            ControlConfig::DEFAULT.weights.azimuth,
        ] {
            assert_ne!(weight, LEVEL);
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let base = ControlConfig::DEFAULT;
        let refused = |config| ControlRules::try_new(config).unwrap_err();
        let no_default = ControlConfig {
            rangefinder_default: Millimeters::ZERO,
            ..base
        };
        assert_eq!(refused(no_default), ControlConfigError::Default);
        let stuck = ControlConfig {
            limits: Limits {
                slower_mm_s2: 0,
                ..base.limits
            },
            ..base
        };
        assert_eq!(refused(stuck), ControlConfigError::Limits);
        let blind = CoverageConfig {
            least: Effort::ZERO,
            ..base.coverage
        };
        assert_eq!(
            refused(ControlConfig {
                coverage: blind,
                ..base
            }),
            ControlConfigError::Coverage
        );
        assert_eq!(
            refused(ControlConfig {
                stale_after: 0,
                ..base
            }),
            ControlConfigError::Stale
        );
    }
}
