//! The parameters of the control level, and their check.

use crate::behaviours::Braitenberg;
use crate::failures::CoverageConfig;
use crate::histogram::HistogramConfig;
use crate::motion::{Effort, Limits};
use crate::sensors::RANGEFINDERS;
use certainty_core::units::Millimeters;
use core::fmt;

/// A corner of a [`Ramp`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Corner {
    /// The distance.
    pub at: Millimeters,
    /// The ramp's height there.
    pub height: Effort,
}

/// A weight α of \[004\] eq. 1 and Fig. 5: a function of the distance to the nearest obstacle, of straight
/// pieces between four corners, level before the first and behind the last.
///
/// Possession proves that the corners ascend and that each height is within 0..=16.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ramp([Corner; 4]);

/// A ramp's corners do not ascend, or a height is below 0 or above 16.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RampError;

impl fmt::Display for RampError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            "corners of a ramp do not fit: expected ascending distances and heights from 0 to 16",
        )
    }
}

impl core::error::Error for RampError {}

impl Ramp {
    /// Creates a ramp from its corners, for constants.
    ///
    /// # Panics
    ///
    /// Where [`Self::try_new`] returns an error; in a constant this does not compile.
    #[must_use]
    #[expect(clippy::panic, reason = "documented; `try_new` is the other way")]
    pub const fn new(corners: [Corner; 4]) -> Self {
        match Self::try_new(corners) {
            Ok(ramp) => ramp,
            Err(RampError) => panic!("corners of a ramp do not fit"),
        }
    }

    /// Checks the corners.
    ///
    /// # Errors
    ///
    /// [`RampError`] if a corner is not beyond the one before it, or a height is not within 0..=16.
    pub const fn try_new(corners: [Corner; 4]) -> Result<Self, RampError> {
        let [a, b, c, d] = corners;
        let ascending =
            a.at.get() < b.at.get() && b.at.get() < c.at.get() && c.at.get() < d.at.get();
        if ascending && a.is_bounded() && b.is_bounded() && c.is_bounded() && d.is_bounded() {
            Ok(Self(corners))
        } else {
            Err(RampError)
        }
    }

    /// Returns the height at `distance`; rounds towards the corner before it.
    ///
    /// ```
    /// use certainty_control::{Corner, Ramp, Effort};
    /// use certainty_core::units::Millimeters;
    ///
    /// let corner = |mm, height| Corner { at: Millimeters::new(mm), height: Effort::from_num(height) };
    /// let ramp = Ramp::try_new([corner(500, 1.0), corner(1000, 0.5), corner(2000, 0.5), corner(3000, 0.0)])?;
    /// assert_eq!(ramp.at(Millimeters::new(750)), Effort::lit("0.75"));
    /// assert_eq!(ramp.at(Millimeters::new(9000)), Effort::ZERO);
    /// # Ok::<(), certainty_control::RampError>(())
    /// ```
    #[must_use]
    pub fn at(&self, distance: Millimeters) -> Effort {
        let [first, ..] = self.0;
        let mut before = first;
        for corner in self.0 {
            if distance <= corner.at {
                return before.to(corner, distance);
            }
            before = corner;
        }
        before.height
    }
}

impl Corner {
    const fn is_bounded(&self) -> bool {
        let bits = self.height.to_bits();
        0 <= bits && bits <= 16 << Effort::FRAC_NBITS
    }

    /// The height at `distance`, between this corner and `next`.
    fn to(self, next: Self, distance: Millimeters) -> Effort {
        let rise = i64::from(next.height.to_bits()).saturating_sub(self.height.to_bits().into());
        let run = i64::from(next.at.saturating_sub(self.at).get());
        let gone = i64::from(distance.saturating_sub(self.at).get());
        // 21 bits times 32; without a run, before the first corner, there is no rise.
        let risen = rise.saturating_mul(gone).checked_div(run).unwrap_or(0);
        self.height + Effort::from_bits(i32::try_from(risen).unwrap_or(0))
    }
}

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

/// How far a failed rangefinder lowers the credibility of the others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FailureSharing {
    /// As \[004\] eq. 14: it lowers μ₀, which applies to all of them; 0.39 for one of six.
    Shared,
    /// Not at all: each reading counts by its own trust, and μ₀ stays 1.
    ///
    /// [`Failures`](crate::Failures) name the sensors that have failed, so the others can count in full; \[004\]
    /// does not say whether a failed rangefinder's reading still counts.
    Own,
}

/// The parameters of a [`Controller`](crate::Controller) for `R` rangefinders, before they are checked.
///
/// \[004\] gives β₁, β₂, c₁, c₂, both accelerations and the radius of the goal; the rest it draws without
/// numbers (Fig. 5) or leaves open.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ControlConfig<const R: usize = RANGEFINDERS> {
    /// The weights of eq. 2.
    pub braitenberg: Braitenberg<R>,
    /// `D_idef` of the rangefinders, eq. 5.
    pub rangefinder_default: Millimeters,
    /// `D_idef` of the scanner's beams and `W_safe`, eq. 6 and 7.
    pub histogram: HistogramConfig,
    /// α, Fig. 5.
    pub weights: Weights,
    /// How far a failed rangefinder lowers the credibility of the others.
    pub sharing: FailureSharing,
    /// What part of what lies ahead each sensor sees, and how much must be seen.
    pub coverage: CoverageConfig<R>,
    /// Full speed and both `a_th`, eq. 16.
    pub limits: Limits,
    /// The distance from the goal at which it counts as reached; 0.5 m in §4.
    pub goal_radius: Millimeters,
    /// Readings older than this many ticks count as missing; 1 to 2^30.
    pub stale_after: u32,
}

/// A ramp through four distances in mm, with heights in steps of 1/16.
const fn ramp(corners: [(u32, i32); 4]) -> Ramp {
    const fn corner(corner: (u32, i32)) -> Corner {
        Corner {
            at: Millimeters::new(corner.0),
            height: Effort::from_bits(corner.1.wrapping_mul(1 << (Effort::FRAC_NBITS - 4))),
        }
    }
    let [a, b, c, d] = corners;
    Ramp::new([corner(a), corner(b), corner(c), corner(d)])
}

impl ControlConfig {
    /// \[004\]'s six rangefinders on a robot of 0.9 m by 0.6 m that goes 1 m/s and sees 4 m.
    ///
    /// Near obstacles the avoiding behaviours dominate, far from them speed and goal, as \[004\] §3 asks.
    pub const DEFAULT: Self = {
        const EIGHTH: Effort = Effort::lit("0.125");
        Self {
            braitenberg: Braitenberg::new([
                Effort::lit("-0.5"),
                Effort::lit("-0.4"),
                Effort::lit("-0.3"),
            ]),
            rangefinder_default: Millimeters::new(1500),
            histogram: HistogramConfig {
                default: Millimeters::new(3000),
                safe: Millimeters::new(550),
            },
            weights: Weights {
                braitenberg: ramp([(300, 16), (800, 12), (1500, 6), (2500, 0)]),
                histogram: ramp([(300, 16), (1000, 20), (2500, 16), (3500, 8)]),
                azimuth: ramp([(300, 4), (800, 6), (1500, 10), (2500, 20)]),
                speed: ramp([(300, 3), (600, 6), (1200, 12), (2000, 16)]),
            },
            sharing: FailureSharing::Shared,
            coverage: CoverageConfig {
                // Half of full speed without the scanner, and none if a corner is not seen at all.
                rangefinders: [EIGHTH, EIGHTH, Effort::ZERO, Effort::ZERO, EIGHTH, EIGHTH],
                scanner: Effort::ONE,
                least: Effort::lit("0.3"),
            },
            limits: Limits::DEFAULT,
            goal_radius: Millimeters::new(500),
            stale_after: 300,
        }
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
pub struct ControlRules<const R: usize = RANGEFINDERS>(ControlConfig<R>);

/// Why a [`ControlConfig`] is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ControlConfigError {
    /// A default distance is zero.
    Default,
    /// Full speed or an acceleration is zero.
    Limits,
    /// A part of the coverage is outside 0..=1, or the least coverage is 0.
    Coverage,
    /// `stale_after` is 0 or above 2^30.
    Stale,
}

impl fmt::Display for ControlConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Default => "a default distance is zero: expected above zero",
            Self::Limits => "full speed or an acceleration is zero: expected above zero",
            Self::Coverage => {
                "coverage does not fit: expected parts from 0 to 1, the least above 0"
            }
            Self::Stale => "stale_after does not fit: expected 1 to 2^30 ticks",
        })
    }
}

impl core::error::Error for ControlConfigError {}

impl ControlRules {
    /// The rules of [`ControlConfig::DEFAULT`].
    pub const DEFAULT: Self = Self(ControlConfig::DEFAULT);
}

impl<const R: usize> ControlRules<R> {
    /// Checks the configuration.
    ///
    /// # Errors
    ///
    /// [`ControlConfigError`] names the parameter that does not fit.
    pub const fn try_new(config: ControlConfig<R>) -> Result<Self, ControlConfigError> {
        const fn is_part(effort: Effort) -> bool {
            0 <= effort.to_bits() && effort.to_bits() <= Effort::ONE.to_bits()
        }
        let coverage = &config.coverage;
        let mut rest: &[Effort] = &coverage.rangefinders;
        let mut all_parts = is_part(coverage.scanner) && is_part(coverage.least);
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
    pub const fn config(&self) -> &ControlConfig<R> {
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

    const fn corner(mm: u32, height: Effort) -> Corner {
        Corner {
            at: Millimeters::new(mm),
            height,
        }
    }

    fn ramp() -> Ramp {
        let heights = [2.0, 1.0, 1.0, 0.25].map(Effort::from_num);
        let [a, b, c, d] = heights;
        Ramp::try_new([
            corner(100, a),
            corner(300, b),
            corner(500, c),
            corner(1500, d),
        ])
        .unwrap()
    }

    #[test]
    fn pieces_are_straight_and_ends_are_level() {
        for (mm, expected) in [
            (0, 2.0),
            (100, 2.0),
            (150, 1.75),
            (300, 1.0),
            (400, 1.0),
            (1000, 0.625),
            (1500, 0.25),
            (u32::MAX, 0.25),
        ] {
            assert_eq!(
                ramp().at(Millimeters::new(mm)),
                Effort::from_num(expected),
                "{mm}"
            );
        }
    }

    #[test]
    fn corners_that_do_not_ascend_are_refused() {
        let one = Effort::ONE;
        let same_place = [
            corner(0, one),
            corner(1, one),
            corner(1, one),
            corner(3, one),
        ];
        assert_eq!(Ramp::try_new(same_place), Err(RampError));
        for height in [Effort::NEG_ONE, Effort::lit("16.1")] {
            let corners = [
                corner(0, one),
                corner(1, one),
                corner(2, one),
                corner(3, height),
            ];
            assert_eq!(Ramp::try_new(corners), Err(RampError));
        }
    }

    #[test]
    fn the_default_passes_its_own_check() {
        assert_eq!(
            ControlRules::try_new(ControlConfig::DEFAULT),
            Ok(ControlRules::DEFAULT)
        );
    }

    #[test]
    fn parameters_that_do_not_fit_are_refused() {
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
