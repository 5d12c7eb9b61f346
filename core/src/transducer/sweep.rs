//! The sequence of directions of a pivoted sensor.

use crate::narrow::wrapping_u16;
use crate::units::BinaryAngle;
use core::fmt;

/// A sweep from one direction to another in equal steps, then from the start again.
///
/// Sensors that share a sweep turn at the same pace, each ahead of the next by a phase, so that no two
/// of them take the same direction at once, as long as there are no more heads than directions: infrared
/// sensors would detect each other's light (\[000\] §3). For the same reason the head returns to the start
/// in one move at the end and does not sweep backwards: two heads that sweep to and fro would meet. How far
/// apart the heads must look is for the [`Schedule`](crate::schedule::Schedule) to check.
///
/// Invariant: all directions of one sweep differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sweep {
    first: BinaryAngle,
    /// From the first to the last direction, in steps of the angle.
    span: u32,
    /// The number of steps that the span is divided into; at least one.
    steps: u16,
    directions: u16,
}

/// Why a sweep was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SweepError {
    /// The number of directions is zero.
    NoDirection,
    /// Two of the directions would be the same.
    TooDense,
}

impl SweepError {
    const fn message(self) -> &'static str {
        match self {
            Self::NoDirection => "a sweep needs at least one direction",
            Self::TooDense => "the directions of a sweep must be at least 1/65536 of a turn apart",
        }
    }
}

impl fmt::Display for SweepError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.message())
    }
}

impl core::error::Error for SweepError {}

impl Sweep {
    /// Creates a sweep of `directions` directions from `first` counter-clockwise to `last`, both
    /// included, for constants.
    ///
    /// # Panics
    ///
    /// For parameters that [`Self::try_new`] refuses: a constant then does not build. Use that at
    /// run time.
    #[expect(clippy::panic, reason = "refuses a constant at compile time")]
    #[must_use]
    pub const fn new(first: BinaryAngle, last: BinaryAngle, directions: u16) -> Self {
        match Self::try_new(first, last, directions) {
            Ok(sweep) => sweep,
            Err(error) => panic!("{}", error.message()),
        }
    }

    /// Creates a sweep of `directions` directions from `first` counter-clockwise to `last`, both
    /// included.
    ///
    /// # Errors
    ///
    /// [`SweepError::NoDirection`] if `directions` is zero, [`SweepError::TooDense`] if two of them
    /// would be the same.
    pub const fn try_new(
        first: BinaryAngle,
        last: BinaryAngle,
        directions: u16,
    ) -> Result<Self, SweepError> {
        let span = last.wrapping_sub(first);
        match directions.checked_sub(1) {
            None => Err(SweepError::NoDirection),
            Some(steps) if steps > span.to_bits() => Err(SweepError::TooDense),
            Some(steps) => Ok(Self {
                first,
                span: span.to_bits() as u32,
                steps: if steps == 0 { 1 } else { steps },
                directions,
            }),
        }
    }

    /// Creates a sweep of `directions` equal steps from `first` counter-clockwise around the whole turn.
    ///
    /// The direction before `first` is a step away from it, so none is taken twice.
    ///
    /// # Errors
    ///
    /// [`SweepError::NoDirection`] if `directions` is zero.
    ///
    /// ```
    /// use certainty_core::transducer::Sweep;
    /// use certainty_core::units::BinaryAngle;
    ///
    /// let radar = Sweep::full_turn(BinaryAngle::ZERO, 4)?;
    /// let directions = [0, 1, 2, 3, 4].map(|step| radar.direction(step, 0, 1).to_bits());
    /// assert_eq!(directions, [0, 0x4000, 0x8000, 0xC000, 0]);
    /// # Ok::<(), certainty_core::transducer::SweepError>(())
    /// ```
    pub const fn full_turn(first: BinaryAngle, directions: u16) -> Result<Self, SweepError> {
        if directions == 0 {
            return Err(SweepError::NoDirection);
        }
        Ok(Self {
            first,
            span: 1 << u16::BITS,
            steps: directions,
            directions,
        })
    }

    /// Returns the number of directions.
    #[must_use]
    pub const fn directions(&self) -> u16 {
        self.directions
    }

    /// Returns the direction at `step` of head `slot`, from 0, of `heads` equally phased ones.
    ///
    /// Rounds to the nearest step of the angle, ties up.
    ///
    /// ```
    /// use certainty_core::transducer::Sweep;
    /// use certainty_core::units::BinaryAngle;
    ///
    /// let degrees = |d: i32| BinaryAngle::from_millidegrees(d * 1000);
    /// let sweep = Sweep::new(degrees(-90), degrees(90), 13);
    /// assert_eq!(sweep.direction(0, 0, 3), degrees(-90));
    /// assert_eq!(sweep.direction(2, 1, 3), degrees(0)); // four directions ahead of the first
    /// ```
    #[must_use]
    pub const fn direction(&self, step: u32, slot: u16, heads: u16) -> BinaryAngle {
        let directions = self.directions as u32;
        let heads = if heads == 0 { 1 } else { heads as u32 };
        let steps = self.steps as u32;
        // At most 65534 · 65536 + 65535 / 2, which fits 32 bits. No divisor is zero.
        let phase = quotient((slot as u32).wrapping_mul(directions), heads);
        let index = remainder(
            remainder(step, directions).wrapping_add(remainder(phase, directions)),
            directions,
        );
        let turned = index.wrapping_mul(self.span).wrapping_add(steps / 2);
        let turned = wrapping_u16(quotient(turned, steps));
        self.first.wrapping_add(BinaryAngle::from_bits(turned))
    }
}

/// `a / b`, or 0 if `b` is zero.
const fn quotient(a: u32, b: u32) -> u32 {
    match a.checked_div(b) {
        Some(quotient) => quotient,
        None => 0,
    }
}

/// `a % b`, or 0 if `b` is zero.
const fn remainder(a: u32, b: u32) -> u32 {
    match a.checked_rem(b) {
        Some(remainder) => remainder,
        None => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    const fn degrees(degrees: i32) -> BinaryAngle {
        BinaryAngle::from_millidegrees(degrees * 1000)
    }

    #[test]
    fn no_two_heads_share_a_direction_at_once() {
        for (directions, heads) in [(13, 3), (13, 4), (13, 5), (37, 3), (37, 7), (7, 7)] {
            let sweep = Sweep::try_new(degrees(-90), degrees(90), directions).unwrap();
            let pace = 180_000 / i32::from(directions - 1);
            let least = BinaryAngle::from_millidegrees(pace - 10);
            for step in 0..u32::from(directions) {
                for a in 0..heads {
                    for b in 0..a {
                        let apart = sweep
                            .direction(step, a, heads)
                            .separation(sweep.direction(step, b, heads));
                        assert!(apart >= least, "{a} and {b} of {heads} at step {step}");
                    }
                }
            }
        }
    }

    #[test]
    fn every_head_takes_each_direction_once_a_sweep() {
        let sweep = Sweep::try_new(degrees(-90), degrees(90), 13).unwrap();
        for slot in 0..3 {
            let mut seen = [false; 13];
            for step in 0..13 {
                let direction = sweep.direction(step, slot, 3);
                let index = (0..13)
                    .position(|i| direction == degrees(15 * i - 90))
                    .unwrap();
                assert!(!seen[index]);
                seen[index] = true;
            }
            assert!(seen.iter().all(|&s| s));
        }
    }

    #[test]
    fn bad_sweeps_are_refused() {
        assert_eq!(
            Sweep::try_new(degrees(0), degrees(30), 0),
            Err(SweepError::NoDirection)
        );
        assert_eq!(
            Sweep::try_new(degrees(9), degrees(9), 2),
            Err(SweepError::TooDense)
        );
        assert!(Sweep::try_new(degrees(9), degrees(9), 1).is_ok());
    }

    #[test]
    fn a_full_turn_takes_every_direction_once() {
        for directions in [1, 2, 3, 7, 360, u16::MAX] {
            let sweep = Sweep::full_turn(degrees(-90), directions).unwrap();
            let mut bits: Vec<u16> = (0..directions)
                .map(|step| sweep.direction(step.into(), 0, 1).to_bits())
                .collect();
            bits.sort_unstable();
            bits.dedup();
            assert_eq!(bits.len(), usize::from(directions));
            assert_eq!(sweep.direction(directions.into(), 0, 1), degrees(-90));
        }
        let none = Sweep::full_turn(BinaryAngle::ZERO, 0);
        assert_eq!(none, Err(SweepError::NoDirection));
    }

    #[test]
    fn the_densest_and_widest_sweep_does_not_overflow() {
        let widest = BinaryAngle::from_bits(u16::MAX);
        let sweep = Sweep::try_new(BinaryAngle::ZERO, widest, u16::MAX).unwrap();
        assert_eq!(sweep.direction(u32::from(u16::MAX) - 1, 0, 1), widest);
    }
}
