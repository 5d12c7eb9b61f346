//! The polar histogram on 101 beams: \[004\] eq. 6 to 8.

use super::nearness::distance;
use certainty_core::narrow::{low_u32, saturating_u8};
use certainty_core::transducer::Reading;
use certainty_core::units::{BinaryAngle, Millimeters};

/// Beams of the scanner, one a degree (\[004\] §3).
pub const BEAMS: usize = 101;

/// The beam that looks straight ahead.
pub const MIDDLE_BEAM: u8 = 50;

/// One value a beam, from the rightmost, 50° right of straight ahead, to the leftmost.
pub type PerBeam<T> = [T; BEAMS];

/// Returns which way beam `index` looks, from straight ahead.
#[must_use]
pub const fn beam_bearing(index: u8) -> BinaryAngle {
    let degrees = (index as i32).wrapping_sub(MIDDLE_BEAM as i32);
    BinaryAngle::from_millidegrees(degrees.wrapping_mul(1000))
}

/// Fraction bits of [`TANGENTS`].
const FRACTION: u32 = 16;

/// tan of 0° to 89°, in steps of 2^-16, of angles in whole steps of a turn's 2^-16.
const TANGENTS: [u32; 90] = {
    let mut tangents = [0; 90];
    let mut rest: &mut [u32] = &mut tangents;
    let mut degrees = 0_i32;
    while let [tangent, others @ ..] = rest {
        let direction = BinaryAngle::from_millidegrees(degrees.wrapping_mul(1000)).direction();
        let sine = (direction.sin().cast_unsigned() as u64) << FRACTION;
        *tangent = match sine.checked_div(direction.cos().cast_unsigned() as u64) {
            Some(ratio) => low_u32(ratio),
            None => u32::MAX,
        };
        rest = others;
        degrees = degrees.wrapping_add(1);
    }
    tangents
};

/// What the histogram leaves open.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HistogramConfig {
    /// `D_def`: what is so far away, and more, counts for nothing. Above zero.
    pub default: Millimeters,
    /// `W_safe`: the radius of the safe region around the robot.
    pub safe: Millimeters,
}

/// How near obstacles are in each direction, widened by the robot's size: **H** of \[004\] eq. 8.
///
/// Memory: a byte a beam.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PolarHistogram(PerBeam<u8>);

impl PolarHistogram {
    /// Creates the histogram of what each beam reads; \[004\] eq. 6 to 8.
    ///
    /// Formula: `s' = 1 − (D − W_safe) / D_def` within 0..=1, rounded up to steps of 1/255; *too near* is
    /// 1, *no object* and *missing* are 0. Each obstacle takes the beams within
    /// `a = atan(W_safe / (D − W_safe))`, rounded up to whole beams, which is never less than the robot
    /// takes: `asin(W_safe / D)`.
    ///
    /// Differs from \[004\], whose eq. 8 as printed holds for every pair of beams (∨ where ∧ is meant)
    /// and widens by the angle of the beam that looks rather than of the one that sees. Eq. 6 is read as
    /// eq. 3 is; in eq. 7 `W_safe` is a part of `D_def`, as what it is divided by is.
    ///
    /// Cost: 101 times seven products, and a comparison for every beam that an obstacle takes.
    #[must_use]
    pub fn of(scan: &PerBeam<Reading>, config: &HistogramConfig) -> Self {
        let mut widened = [0; BEAMS];
        for (reading, index) in scan.iter().zip(0..BEAMS) {
            let Some(away) = distance(*reading) else {
                continue;
            };
            let away = away.saturating_sub(config.safe);
            let height = height(away, config.default);
            if height == 0 {
                continue;
            }
            let reach = usize::from(reach(away, config.safe));
            let first = index.saturating_sub(reach);
            let taken = reach.saturating_add(reach).saturating_add(1);
            // To the left of beam 0 there is nothing to take.
            let outside = reach.saturating_sub(index);
            let taken = taken.saturating_sub(outside);
            for beam in widened.iter_mut().skip(first).take(taken) {
                *beam = height.max(*beam);
            }
        }
        Self(widened)
    }

    /// Returns how near obstacles are in each direction: 0 far, 255 within the safe region.
    #[must_use]
    pub const fn heights(&self) -> &PerBeam<u8> {
        &self.0
    }
}

/// `s'` of \[004\] eq. 6 in steps of 1/255, rounded up.
fn height(away: Millimeters, default: Millimeters) -> u8 {
    let near = u64::from(default.saturating_sub(away).get());
    let steps = near.saturating_mul(255);
    let default = u64::from(default.get());
    let rounded_up = steps.saturating_add(default.saturating_sub(1));
    saturating_u8(rounded_up.checked_div(default).unwrap_or(0))
}

/// `a` of \[004\] eq. 7 in beams, rounded up.
fn reach(away: Millimeters, safe: Millimeters) -> u8 {
    let (away, safe) = (u64::from(away.get()), u64::from(safe.get()));
    // tan(a) · away < safe: 32 bits times 24.
    let wanted = safe << FRACTION;
    let below = TANGENTS.partition_point(|&tangent| away.saturating_mul(tangent.into()) < wanted);
    saturating_u8(u64::try_from(below).unwrap_or(u64::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_core::transducer::Missing;
    use proptest::prelude::*;

    const CONFIG: HistogramConfig = HistogramConfig {
        default: Millimeters::new(2000),
        safe: Millimeters::new(500),
    };

    fn histogram(seen: &[(usize, u32)]) -> PerBeam<u8> {
        let mut scan = [Reading::NoObject; BEAMS];
        for &(beam, mm) in seen {
            scan[beam] = Reading::Echo(Millimeters::new(mm));
        }
        *PolarHistogram::of(&scan, &CONFIG).heights()
    }

    #[test]
    fn eq_6_to_8_by_hand() {
        // D − W = 1000: s' = 1/2, in 255 steps 127.5, up to 128; atan(500 / 1000) = 26.57°, up to 27.
        let heights = histogram(&[(50, 1500)]);
        for (beam, &height) in heights.iter().enumerate() {
            let expected = if beam.abs_diff(50) <= 27 { 128 } else { 0 };
            assert_eq!(height, expected, "beam {beam}");
        }
    }

    #[test]
    fn the_nearer_obstacle_wins_where_two_overlap() {
        // 750 mm: D − W = 250, s' = 0.875 → 223.125, up to 224; atan(2) = 63.4°, up to 64.
        let heights = histogram(&[(0, 750), (100, 1500)]);
        assert_eq!(heights[64], 224);
        assert_eq!(heights[65], 0);
        assert_eq!(heights[73], 128);
        assert_eq!(heights[72], 0);
    }

    #[test]
    fn what_is_within_the_safe_region_blocks_a_quarter_turn_to_each_side() {
        let heights = histogram(&[(5, 500)]);
        assert_eq!((heights[0], heights[95], heights[96]), (255, 255, 0));
        let mut scan = [Reading::Missing(Missing::Timeout); BEAMS];
        assert_eq!(PolarHistogram::of(&scan, &CONFIG).0, [0; BEAMS]);
        scan[50] = Reading::TooNear;
        assert_eq!(PolarHistogram::of(&scan, &CONFIG).0, [255; BEAMS]);
    }

    #[test]
    fn what_is_as_far_as_the_default_counts_for_nothing() {
        assert_eq!(histogram(&[(50, 2500)]), [0; BEAMS]);
        assert_eq!(histogram(&[(50, 2499)])[50], 1);
    }

    #[test]
    fn tangents_are_tangents() {
        for (degrees, &tangent) in TANGENTS.iter().enumerate() {
            let exact = (degrees as f64).to_radians().tan() * 65536.0;
            let error = exact - f64::from(tangent);
            // The angle itself is rounded to 1/65536 of a turn.
            assert!(error.abs() < 2.0 + exact * 0.004, "{degrees}: {error}");
        }
    }

    proptest! {
        #[test]
        fn no_obstacle_is_widened_by_less_than_the_robot_takes(mm in 501_u32..2499) {
            let heights = histogram(&[(50, mm)]);
            let taken = heights.iter().filter(|&&height| height > 0).count() / 2;
            let needed = (500.0 / f64::from(mm)).asin().to_degrees();
            prop_assert!(taken as f64 >= needed.min(50.0) - 0.01, "{taken} {needed}");
        }

        #[test]
        fn a_mirrored_scan_has_a_mirrored_histogram(seen in prop::collection::vec((0..BEAMS, 0_u32..3000), 0..30)) {
            let mirrored: Vec<_> = seen.iter().map(|&(beam, mm)| (BEAMS - 1 - beam, mm)).collect();
            // Where two echoes share a beam the last counts in both.
            let mut heights = histogram(&seen);
            heights.reverse();
            prop_assert_eq!(heights, histogram(&mirrored));
        }
    }
}
