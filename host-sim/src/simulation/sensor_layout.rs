//! The placement and sweeps of the sensors, and how their beams are spread over cells.

use certainty_core::certainty::Certainty;
use certainty_core::fusion::{BeamConfig, BeamModel, Behind};
use certainty_core::transducer::Sweep;
use certainty_core::units::{BinaryAngle, Pose};
use certainty_firmware::smart_car;
use core::fmt;
use core::str::FromStr;
use fixed::types::U0F16;

/// The places of the pivoted heads on the car.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum HeadPlacement {
    /// Evenly along the bumper: [`smart_car::mounting`].
    Bumper,
    /// All at the car's origin; heads do not hide the view of others.
    OnePoint,
}

/// The part of the arc that every head covers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SweepOverlap {
    /// Each sweeps the whole arc: every sensor sees every cell in range that no obstacle hides.
    Full,
    /// Each sweeps two thirds of it, the first from its right end, the last to its left end, those
    /// between evenly: the three detection areas of \[001\] Fig. 1(a), which overlap in part.
    Partial,
}

impl fmt::Display for SweepOverlap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Full => "full",
            Self::Partial => "partial",
        })
    }
}

/// A text that names no overlap.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("unknown overlap '{0}': expected full or partial")]
pub struct SweepOverlapError(String);

impl FromStr for SweepOverlap {
    type Err = SweepOverlapError;

    fn from_str(text: &str) -> Result<Self, SweepOverlapError> {
        let both = [Self::Full, Self::Partial];
        let found = both.into_iter().find(|overlap| overlap.to_string() == text);
        found.ok_or_else(|| SweepOverlapError(text.chars().take(40).collect()))
    }
}

/// The placement of the heads and their sweeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SensorLayout {
    placement: HeadPlacement,
    overlap: SweepOverlap,
    directions: u16,
}

/// A number of directions outside 2..=1000.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a sweep has 2 to {} directions", SensorLayout::MOST_DIRECTIONS)]
pub struct SensorLayoutError;

impl SensorLayout {
    /// Most directions of a sweep.
    pub const MOST_DIRECTIONS: u16 = 1000;

    /// The Smart Car as it is shipped.
    pub const SMART_CAR: Self = Self {
        placement: HeadPlacement::Bumper,
        overlap: SweepOverlap::Full,
        directions: smart_car::SWEEP.directions(),
    };

    /// Creates a layout with `directions` directions a sweep.
    ///
    /// # Errors
    ///
    /// [`SensorLayoutError`] outside 2..=1000.
    pub const fn try_new(
        placement: HeadPlacement,
        overlap: SweepOverlap,
        directions: u16,
    ) -> Result<Self, SensorLayoutError> {
        if directions < 2 || directions > Self::MOST_DIRECTIONS {
            return Err(SensorLayoutError);
        }
        Ok(Self {
            placement,
            overlap,
            directions,
        })
    }

    /// Returns the directions of a sweep.
    #[must_use]
    pub const fn directions(&self) -> u16 {
        self.directions
    }

    /// Returns the beam of head `slot` of `heads` in step `step`: its start and direction in the map.
    #[must_use]
    pub fn look(&self, slot: u8, heads: u8, step: u32) -> Pose {
        let mut head = match self.placement {
            HeadPlacement::Bumper => smart_car::mounting(slot, heads),
            HeadPlacement::OnePoint => smart_car::mounting(0, 1),
        };
        let sweep = self.sweep(slot, heads);
        head.heading = sweep.direction(step, slot.into(), heads.into());
        smart_car::POSE.compose(head)
    }

    /// The sweep of one head.
    fn sweep(&self, slot: u8, heads: u8) -> Sweep {
        let arc = smart_car::SWEEP;
        let first = arc.direction(0, 0, 1);
        let last = arc.direction(u32::from(arc.directions()) - 1, 0, 1);
        let span = u32::from(last.wrapping_sub(first).to_bits());
        let (skipped, width) = match self.overlap {
            SweepOverlap::Full => (0, span),
            SweepOverlap::Partial => {
                let gaps = u32::from(heads.saturating_sub(1)).max(1);
                (span / 3 * u32::from(slot) / gaps, span / 3 * 2)
            }
        };
        let turned = |by: u32| first.wrapping_add(BinaryAngle::from_bits(by as u16));
        Sweep::try_new(turned(skipped), turned(skipped + width), self.directions)
            .unwrap_or(smart_car::SWEEP) // a third of half a turn has room for all directions
    }
}

/// How a reading is spread over the cells of its beam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Profile {
    /// The occupied spread to each side, in standard deviations of a distance.
    pub spread: f64,
    /// The certainty of cells behind an echo.
    pub behind: Behind,
    /// The certainty of cells in a beam without an object.
    pub no_object: Certainty,
}

impl Default for Profile {
    /// As in [`smart_car::beam_model`].
    fn default() -> Self {
        Self {
            spread: 2.0,
            behind: Behind::Uncertain,
            no_object: Certainty::FREE,
        }
    }
}

impl Profile {
    /// Returns the beam model of a sensor with this accuracy, a fraction.
    #[must_use]
    pub fn model(&self, accuracy: f64) -> BeamModel {
        let exact = smart_car::beam_model(U0F16::ZERO);
        let config = BeamConfig {
            accuracy: U0F16::saturating_from_num(accuracy * self.spread),
            behind: self.behind,
            no_object: self.no_object.min(Certainty::UNCERTAIN),
            ..*exact.config()
        };
        BeamModel::try_new(config).unwrap_or(exact) // these fields are never refused
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity;
    use crate::transducer::SensorModel;

    #[test]
    fn the_defaults_are_those_of_the_shipped_car() {
        for (slot, step) in (0..3).flat_map(|slot| (0..80).map(move |step| (slot, step))) {
            let looks = SensorLayout::SMART_CAR.look(slot, 3, step);
            assert_eq!(looks, smart_car::look(slot, 3, step));
        }
        for (_, sensor) in SensorModel::TABLE_1 {
            let shipped = smart_car::beam_model(U0F16::from_num(sensor.accuracy()));
            let ours = Profile::default().model(sensor.accuracy());
            assert_eq!(ours.config().behind, shipped.config().behind);
            // Twice a rounded number is the rounded double to within a step.
            let steps = |model: &BeamModel| model.config().accuracy.to_bits();
            assert!(steps(&ours).abs_diff(steps(&shipped)) <= 1);
        }
    }

    #[test]
    fn partial_views_reach_both_ends() {
        let layout =
            SensorLayout::try_new(HeadPlacement::OnePoint, SweepOverlap::Partial, 37).unwrap();
        let seen = |slot: u8| {
            let headings = (0..37).map(|step| layout.look(slot, 3, step).heading.to_bits());
            let (least, most) = (headings.clone().min(), headings.max());
            (least.unwrap(), most.unwrap())
        };
        // The map's angles: 0 is to the right, half a turn to the left.
        let degrees = |bits| quantity::degrees(BinaryAngle::from_bits(bits)).round() as i32;
        let arcs = [0, 1, 2].map(|slot| {
            let (least, most) = seen(slot);
            (degrees(least), degrees(most))
        });
        assert_eq!(arcs, [(0, 120), (30, 150), (60, 180)]);
    }

    #[test]
    fn a_sweep_needs_two_directions() {
        for directions in [0, 1, 1001] {
            let refused =
                SensorLayout::try_new(HeadPlacement::Bumper, SweepOverlap::Full, directions);
            assert_eq!(refused, Err(SensorLayoutError));
        }
    }
}
