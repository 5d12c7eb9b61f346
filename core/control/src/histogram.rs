//! The histogram behaviour on the scanner: \[004\] eq. 6 to 9 and 11.

use crate::motion::{Effort, Side};
use crate::sensors::{BEAMS, HALF_TURN_BEAMS, ScanGeometry, distance};
use certainty_core::transducer::Reading;
use certainty_core::units::{BinaryAngle, Millimeters};

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
            // At most 57.3 times 2^16.
            Some(ratio) => {
                let [a, b, c, d, ..] = ratio.to_le_bytes();
                u32::from_le_bytes([a, b, c, d])
            }
            None => u32::MAX,
        };
        rest = others;
        degrees = degrees.wrapping_add(1);
    }
    tangents
};

/// The parameters of the histogram that \[004\] leaves open.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HistogramConfig {
    /// `D_def`: objects at this distance or beyond count as 0. Above zero.
    pub default: Millimeters,
    /// `W_safe`: the radius of the safe region around the robot.
    pub safe: Millimeters,
}

/// How near obstacles are in each direction, widened by the robot's size: **H** of \[004\] eq. 8.
///
/// Memory: a byte per beam.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PolarHistogram<const B: usize = BEAMS>([u8; B]);

impl<const B: usize> PolarHistogram<B> {
    /// Creates the histogram of a scan; \[004\] eq. 6 to 8.
    ///
    /// Formula: `s' = 1 − (D − W_safe) / D_def` within 0..=1, rounded up to steps of 1/255; *too near* is
    /// 1, *no object* and *missing* are 0. Each obstacle occupies the beams within
    /// `a = atan(W_safe / (D − W_safe))`, rounded up to whole beams, which is never less than the robot
    /// needs: `asin(W_safe / D)`.
    ///
    /// Differs from \[004\], whose eq. 8 as printed holds for every pair of beams (∨ where ∧ is meant) and gives
    /// the maximum of the set around beam i to beam j. Its eq. 6 grows with the distance, with the bars of eq. 7
    /// too; here it falls as eq. 5 does. In eq. 7 `W_safe` is a part of `D_def`, as its divisor is.
    ///
    /// Cost: seven products per beam, and a comparison for every beam that an obstacle occupies.
    #[must_use]
    pub fn of(scan: &[Reading; B], config: &HistogramConfig) -> Self {
        let mut widened = [0; B];
        for (reading, index) in scan.iter().zip(0..B) {
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
            let width = reach.saturating_add(reach).saturating_add(1);
            // Part of the width lies to the right of beam 0.
            let outside = reach.saturating_sub(index);
            let width = width.saturating_sub(outside);
            for beam in widened.iter_mut().skip(first).take(width) {
                *beam = height.max(*beam);
            }
        }
        Self(widened)
    }

    /// Returns how near obstacles are in each direction: 0 far, 255 within the safe region.
    #[must_use]
    pub const fn heights(&self) -> &[u8; B] {
        &self.0
    }
}

/// `s'` of \[004\] eq. 6 in steps of 1/255, rounded up.
fn height(away: Millimeters, default: Millimeters) -> u8 {
    let near = u64::from(default.saturating_sub(away).get());
    let steps = near.saturating_mul(255);
    let default = u64::from(default.get());
    let rounded_up = steps.saturating_add(default.saturating_sub(1));
    u8::try_from(rounded_up.checked_div(default).unwrap_or(0)).unwrap_or(u8::MAX)
}

/// `a` of \[004\] eq. 7 in beams, rounded up.
fn reach(away: Millimeters, safe: Millimeters) -> u8 {
    let (away, safe) = (u64::from(away.get()), u64::from(safe.get()));
    // tan(a) · away < safe: 32 bits times 24.
    let wanted = safe << FRACTION;
    let below = TANGENTS.partition_point(|&tangent| away.saturating_mul(tangent.into()) < wanted);
    u8::try_from(below).unwrap_or(u8::MAX)
}

/// An opening: neighbouring beams that are not blocked.
///
/// Possession proves that the first is not left of the last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Valley {
    first: u8,
    last: u8,
    /// The beam that looks straight ahead.
    middle: u8,
}

impl Valley {
    /// Returns the rightmost free beam.
    #[must_use]
    pub const fn first(self) -> u8 {
        self.first
    }

    /// Returns the leftmost free beam.
    #[must_use]
    pub const fn last(self) -> u8 {
        self.last
    }

    /// How far left of straight ahead its centre is, in half beams.
    ///
    /// Differs from \[004\] eq. 9 to 11: the centre is the mean of the ends, printed as half their
    /// difference, which is half the width. Both ends are free beams: with the blocked one that eq. 9
    /// begins at, every centre would be half a beam too far right.
    const fn centre_halves(self) -> i32 {
        let twice = (self.first as i32).wrapping_add(self.last as i32);
        twice.wrapping_sub((self.middle as i32).wrapping_mul(2))
    }

    /// Returns `v_1R` of \[004\] eq. 11: β₁ times the centre; `v_1L` is its opposite.
    ///
    /// Range: β₁ is 0.01 per beam, counted from straight ahead, so ±0.5 for 101 beams. Rounds towards 0.
    #[must_use]
    pub const fn turn(self) -> Effort {
        // At most 180 · 2^16.
        let wide = self.centre_halves().wrapping_mul(1 << Effort::FRAC_NBITS);
        Effort::from_bits(match wide.checked_div(200) {
            Some(bits) => bits,
            None => 0,
        })
    }

    /// Returns the side its centre is on; `None` straight ahead.
    #[must_use]
    pub const fn side(self) -> Option<Side> {
        match self.centre_halves() {
            0 => None,
            1.. => Some(Side::Left),
            _ => Some(Side::Right),
        }
    }

    /// How far its centre is from `goal`, in steps of 2^-17 of a beam; a goal exactly behind is on the side
    /// `kept`.
    fn away_from(self, goal: BinaryAngle, kept: Side) -> u32 {
        // In 2^-15 of half a turn, to either side; a beam is 1/180 of it.
        let goal = match (goal, kept) {
            (BinaryAngle::HALF, Side::Left) => 1 << 15,
            _ => i64::from(goal.to_bits().cast_signed()),
        };
        let goal = goal.saturating_mul(2 * HALF_TURN_BEAMS * 2);
        let centre = i64::from(self.centre_halves()) << 16;
        let away = centre.saturating_sub(goal).unsigned_abs();
        u32::try_from(away).unwrap_or(u32::MAX)
    }
}

/// The height from which a direction is blocked: `D_th` of \[004\] §3 b.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Threshold(u8);

impl Threshold {
    /// The threshold that a [`Controller`](crate::Controller) uses, 140/255: \[004\] does not give `D_th`.
    pub const DEFAULT: Self = Self::new(140);

    /// Creates a threshold: a direction with a histogram above `height`/255 is blocked, and one of 255
    /// whatever the threshold.
    #[must_use]
    pub const fn new(height: u8) -> Self {
        Self(height)
    }

    /// Returns the valleys of `histogram`, from the right to the left.
    ///
    /// Directions outside the field count as blocked, so that an opening at its end is found: \[004\] eq. 9
    /// as printed finds only those between two obstacles.
    pub fn valleys<const B: usize>(
        self,
        histogram: &PolarHistogram<B>,
    ) -> impl Iterator<Item = Valley> + '_ {
        let beyond = core::iter::once(u8::MAX);
        let ended = histogram.heights().iter().copied().chain(beyond);
        let mut open: Option<u8> = None;
        // Below 255, so that the height of `beyond` is blocked.
        let limit = self.0.min(u8::MAX.saturating_sub(1));
        ended.zip(0_u8..=u8::MAX).filter_map(move |(height, beam)| {
            if height <= limit {
                open = open.or(Some(beam));
                return None;
            }
            open.take().map(|first| Valley {
                first,
                last: beam.saturating_sub(1),
                middle: ScanGeometry::<B>::MIDDLE,
            })
        })
    }

    /// Returns the valley whose centre is nearest to the direction of the goal, `goal` from straight
    /// ahead; `None` if every direction is blocked.
    ///
    /// A valley on the `kept` side or straight ahead may be `commitment` beams farther from the goal than the
    /// best one: otherwise a robot before an obstacle as wide to the left as to the right could change sides
    /// at every step. \[004\] has no such term; 0 is \[004\]. Of two that are equally far, `kept` decides, and
    /// on the same side the one that is less to the side. A goal exactly behind is on the side `kept`.
    #[must_use]
    pub fn choose<const B: usize>(
        self,
        histogram: &PolarHistogram<B>,
        goal: BinaryAngle,
        kept: Side,
        commitment: u8,
    ) -> Option<Valley> {
        let handicap = u32::from(commitment) << 17;
        self.valleys(histogram).min_by_key(|valley| {
            let other_side = valley.side() == Some(kept.other());
            let away = valley.away_from(goal, kept);
            let away = away.saturating_add(if other_side { handicap } else { 0 });
            (away, other_side, valley.centre_halves().unsigned_abs())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::PerBeam;
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
    fn where_two_obstacles_overlap_the_nearer_counts() {
        // 750 mm: D − W = 250, s' = 0.875 → 223.125, up to 224; atan(2) = 63.4°, up to 64.
        let heights = histogram(&[(0, 750), (100, 1500)]);
        assert_eq!(heights[64], 224);
        assert_eq!(heights[65], 0);
        assert_eq!(heights[73], 128);
        assert_eq!(heights[72], 0);
    }

    #[test]
    fn inside_the_safe_region_a_quarter_turn_is_blocked() {
        let heights = histogram(&[(5, 500)]);
        assert_eq!((heights[0], heights[95], heights[96]), (255, 255, 0));
        let mut scan = [Reading::Missing(Missing::Timeout); BEAMS];
        assert_eq!(PolarHistogram::of(&scan, &CONFIG).0, [0; BEAMS]);
        scan[50] = Reading::TooNear;
        assert_eq!(PolarHistogram::of(&scan, &CONFIG).0, [255; BEAMS]);
    }

    #[test]
    fn objects_beyond_the_default_distance_count_as_zero() {
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

    /// Blocks directions with an object nearer than 1 m; the robot has no size.
    const SIZELESS: HistogramConfig = HistogramConfig {
        default: Millimeters::new(2000),
        safe: Millimeters::ZERO,
    };
    const HALF: Threshold = Threshold::new(127);

    fn blocked(beams: impl IntoIterator<Item = usize>) -> PolarHistogram {
        let mut scan = [Reading::NoObject; BEAMS];
        for beam in beams {
            scan[beam] = Reading::Echo(Millimeters::new(500));
        }
        PolarHistogram::of(&scan, &SIZELESS)
    }

    fn ends(histogram: &PolarHistogram) -> Vec<(u8, u8)> {
        let valleys = HALF.valleys(histogram);
        valleys.map(|v| (v.first(), v.last())).collect()
    }

    fn degrees(degrees: i32) -> BinaryAngle {
        BinaryAngle::from_millidegrees(degrees * 1000)
    }

    #[test]
    fn eq_9_finds_openings_between_obstacles_and_at_the_ends() {
        assert_eq!(ends(&blocked([])), [(0, 100)]);
        assert_eq!(ends(&blocked(30..=40)), [(0, 29), (41, 100)]);
        assert_eq!(ends(&blocked((0..20).chain(60..101))), [(20, 59)]);
        assert_eq!(ends(&blocked(0..101)), []);
    }

    #[test]
    fn eq_11_steers_to_the_mean_of_the_ends() {
        // (41 + 100) / 2 = 70.5, less 50, times 0.01.
        let valley = |first, last| Valley {
            first,
            last,
            middle: 50,
        };
        let bits = (0.205 * 65536.0) as i32;
        assert_eq!(valley(41, 100).turn().to_bits(), bits);
        assert_eq!(valley(0, 59).turn(), -valley(41, 100).turn());
        assert_eq!(valley(0, 100).turn(), Effort::ZERO);
        assert_eq!(valley(100, 100).turn(), Effort::HALF);
    }

    #[test]
    fn the_valley_nearest_to_the_goal_is_taken() {
        // Centres at 14.5 and 80.5: −35.5° and 30.5°.
        let histogram = blocked(30..=60);
        let chosen = |goal| {
            HALF.choose(&histogram, degrees(goal), Side::Right, 0)
                .unwrap()
        };
        assert_eq!(chosen(0).first(), 61);
        assert_eq!(chosen(-3).last(), 29);
        assert_eq!(chosen(-2).first(), 61);
        assert_eq!(chosen(120).first(), 61);
        assert_eq!(chosen(-170).first(), 0);
    }

    #[test]
    fn the_kept_side_decides_ties_within_the_commitment() {
        let histogram = blocked(40..=60);
        let chosen = |goal, kept, beams| {
            HALF.choose(&histogram, degrees(goal), kept, beams)
                .unwrap()
                .side()
        };
        assert_eq!(chosen(0, Side::Left, 0), Some(Side::Left));
        assert_eq!(chosen(0, Side::Right, 0), Some(Side::Right));
        assert_eq!(chosen(1, Side::Right, 0), Some(Side::Left));
        // At 4° the left centre, 30.5 away, is 8 beams nearer than the right one.
        assert_eq!(chosen(4, Side::Right, 9), Some(Side::Right));
        assert_eq!(chosen(4, Side::Right, 7), Some(Side::Left));
        assert_eq!(
            HALF.choose(&blocked(0..101), degrees(0), Side::Left, 9),
            None
        );
    }

    proptest! {
        #[test]
        fn every_obstacle_is_widened_by_the_robots_size(mm in 501_u32..2499) {
            let heights = histogram(&[(50, mm)]);
            let occupied = heights.iter().filter(|&&height| height > 0).count() / 2;
            let needed = (500.0 / f64::from(mm)).asin().to_degrees();
            prop_assert!(occupied as f64 >= needed.min(50.0) - 0.01, "{occupied} {needed}");
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
