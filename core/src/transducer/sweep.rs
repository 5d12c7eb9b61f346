//! The directions a pivoted sensor looks in, one after the other.

use crate::units::BinaryAngle;
use core::fmt;

/// A sweep from one direction to another in equal steps, then from the start again.
///
/// All sensors that share a sweep turn at the same pace, each ahead of the next by a phase, so that
/// no two of them ever look the same way at once: infrared sensors would see each other's light
/// ([000] §3). That is why the head flies back at the end and does not sweep backwards: two heads
/// that swing to and fro must meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sweep {
    first: BinaryAngle,
    step: BinaryAngle,
    directions: u16,
}

/// Why a sweep was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SweepError {
    /// There is no direction to look in.
    NoDirection,
    /// The steps add up to a turn or more, so that two directions could be the same.
    OverATurn,
}

impl fmt::Display for SweepError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoDirection => "a sweep needs at least one direction",
            Self::OverATurn => "a sweep must stay under one turn",
        })
    }
}

impl core::error::Error for SweepError {}

impl Sweep {
    /// Creates a sweep of `directions` directions, the first at `first`, each `step` further.
    ///
    /// # Errors
    ///
    /// [`SweepError::NoDirection`] for no directions, [`SweepError::OverATurn`] if they would come
    /// round to the first.
    pub const fn try_new(
        first: BinaryAngle,
        step: BinaryAngle,
        directions: u16,
    ) -> Result<Self, SweepError> {
        if directions == 0 {
            return Err(SweepError::NoDirection);
        }
        if directions as u32 * step.to_bits() as u32 > 1 << 16 {
            return Err(SweepError::OverATurn);
        }
        Ok(Self {
            first,
            step,
            directions,
        })
    }

    /// Returns the number of directions.
    #[must_use]
    pub const fn directions(&self) -> u16 {
        self.directions
    }

    /// Returns the direction at `step` of a head that is `slot` of `heads` equally phased ones.
    ///
    /// ```
    /// use certainty_core::transducer::Sweep;
    /// use certainty_core::units::BinaryAngle;
    ///
    /// let degrees = |d: i32| BinaryAngle::from_millidegrees(d * 1000);
    /// let sweep = Sweep::try_new(degrees(-90), degrees(15), 12)?;
    /// assert_eq!(sweep.direction(0, 0, 3), degrees(-90));
    /// assert_eq!(sweep.direction(0, 1, 3), degrees(-30)); // a third of the way ahead
    /// # Ok::<(), certainty_core::transducer::SweepError>(())
    /// ```
    #[must_use]
    pub const fn direction(&self, step: u32, slot: u16, heads: u16) -> BinaryAngle {
        let directions = self.directions as u32;
        let heads = if heads == 0 { 1 } else { heads as u32 };
        let phase = slot as u32 * directions / heads;
        let index = (step % directions + phase % directions) % directions;
        // Below 2^16 because the whole sweep is.
        let turned = (index * self.step.to_bits() as u32) as u16;
        self.first.wrapping_add(BinaryAngle::from_bits(turned))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn degrees(degrees: i32) -> BinaryAngle {
        BinaryAngle::from_millidegrees(degrees * 1000)
    }

    #[test]
    fn no_two_heads_ever_look_the_same_way_at_once() {
        for (directions, heads) in [(13, 3), (13, 4), (13, 5), (37, 3), (37, 7), (7, 7)] {
            let sweep = Sweep::try_new(degrees(-90), degrees(5), directions).unwrap();
            for step in 0..u32::from(directions) {
                for a in 0..heads {
                    for b in 0..a {
                        let apart = sweep
                            .direction(step, a, heads)
                            .separation(sweep.direction(step, b, heads));
                        assert!(apart >= degrees(5), "{a} and {b} of {heads} at step {step}");
                    }
                }
            }
        }
    }

    #[test]
    fn every_head_looks_everywhere_once_a_sweep() {
        let sweep = Sweep::try_new(degrees(-90), degrees(15), 13).unwrap();
        for slot in 0..3 {
            let mut seen = [false; 13];
            for step in 0..13 {
                let turned = sweep
                    .direction(step, slot, 3)
                    .wrapping_sub(degrees(-90))
                    .to_bits();
                let index = usize::from(turned / degrees(15).to_bits());
                assert!(!seen[index]);
                seen[index] = true;
            }
            assert!(seen.iter().all(|&s| s));
        }
    }

    #[test]
    fn a_sweep_that_comes_round_is_refused() {
        assert_eq!(
            Sweep::try_new(degrees(0), degrees(30), 13),
            Err(SweepError::OverATurn)
        );
        assert_eq!(
            Sweep::try_new(degrees(0), degrees(30), 0),
            Err(SweepError::NoDirection)
        );
    }
}
