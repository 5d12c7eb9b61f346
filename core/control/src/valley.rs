//! Valleys of the histogram and the one to take: \[004\] eq. 9 and 11.

use super::{Effort, MIDDLE_BEAM, PolarHistogram, Side};
use certainty_core::narrow::{saturating_i32, saturating_u8};
use certainty_core::units::BinaryAngle;

/// Neighbouring beams that are free: an opening.
///
/// Possession proves that the first is not left of the last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Valley {
    first: u8,
    last: u8,
}

/// 180° by one beam's degree.
const HALF_TURN_BEAMS: i64 = 180;

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

    /// How far left of straight ahead its centre is, in half beams: −100 to 100.
    ///
    /// Differs from \[004\] eq. 9 to 11: the centre is the mean of the ends, printed as half their
    /// difference, which is half the width. Both ends are free beams: with the blocked one that eq. 9
    /// begins at, every centre would be half a beam too far right.
    const fn centre_halves(self) -> i32 {
        let twice = (self.first as i32).wrapping_add(self.last as i32);
        twice.wrapping_sub((MIDDLE_BEAM as i32).wrapping_mul(2))
    }

    /// Returns `v_1R` of \[004\] eq. 11: β₁ times the centre; `v_1L` is its opposite.
    ///
    /// Range: β₁ is 0.01 a beam, counted from straight ahead, so ±0.5.
    #[must_use]
    pub const fn turn(self) -> Effort {
        // At most 100 · 2^16; towards zero on both sides.
        let wide = self.centre_halves().wrapping_mul(1 << Effort::FRAC_NBITS);
        Effort::from_bits(match wide.checked_div(200) {
            Some(bits) => bits,
            None => 0,
        })
    }

    /// The side it is on, if on one.
    pub(super) const fn side(self) -> Option<Side> {
        match self.centre_halves() {
            0 => None,
            1.. => Some(Side::Left),
            _ => Some(Side::Right),
        }
    }

    /// How far its centre is from `goal`, in steps of 2^-17 of a beam; exactly behind is on the side `kept`.
    fn away_from(self, goal: BinaryAngle, kept: Side) -> u32 {
        // In 2^-15 of half a turn, to either side; a beam is 1/180 of it.
        let goal = match (goal, kept) {
            (BinaryAngle::HALF, Side::Left) => 1 << 15,
            _ => i64::from(goal.to_bits().cast_signed()),
        };
        let goal = goal.saturating_mul(2 * HALF_TURN_BEAMS * 2);
        let centre = i64::from(self.centre_halves()) << 16;
        saturating_i32(centre.saturating_sub(goal)).unsigned_abs()
    }
}

/// Which directions are blocked, and what is open between them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Threshold(u8);

impl Threshold {
    /// Creates the threshold `D_th`: a direction with a higher histogram than `height`/255 is blocked
    /// (\[004\] §3 b), and one of 255 whatever the threshold.
    #[must_use]
    pub const fn new(height: u8) -> Self {
        Self(height)
    }

    /// Returns the valleys of `histogram`, from the right to the left.
    ///
    /// What lies beyond the field counts as blocked, so that an opening at its end is one: \[004\] eq. 9
    /// as printed finds only those between two obstacles.
    pub fn valleys(self, histogram: &PolarHistogram) -> impl Iterator<Item = Valley> + '_ {
        let beyond = core::iter::once(u8::MAX);
        let ended = histogram.heights().iter().copied().chain(beyond);
        let mut open: Option<u8> = None;
        // No threshold is above 255, but that one must block what is beyond.
        let limit = self.0.min(u8::MAX.saturating_sub(1));
        ended.zip(0_u8..=u8::MAX).filter_map(move |(height, beam)| {
            if height <= limit {
                open = open.or(Some(beam));
                return None;
            }
            open.take().map(|first| Valley {
                first,
                last: beam.saturating_sub(1),
            })
        })
    }

    /// Returns the valley whose centre is nearest to the direction of the goal, `goal` from straight
    /// ahead; `None` where nothing is open.
    ///
    /// One that is on the `kept` side or straight ahead may be `commitment` beams farther away: a robot
    /// before an obstacle as wide to the left as to the right must not change its mind at every step.
    /// \[004\] has no such term; 0 is \[004\]. Of two that are equally far `kept` decides, and on the same side
    /// that which is less to the side. A goal exactly behind is on the side `kept`.
    #[must_use]
    pub fn choose(
        self,
        histogram: &PolarHistogram,
        goal: BinaryAngle,
        kept: Side,
        commitment: u8,
    ) -> Option<Valley> {
        let handicap = u32::from(commitment) << 17;
        self.valleys(histogram).min_by_key(|valley| {
            let lost = valley.side() == Some(kept.other());
            let away = valley.away_from(goal, kept);
            let away = away.saturating_add(if lost { handicap } else { 0 });
            (away, lost, valley.centre_halves().unsigned_abs())
        })
    }
}

/// A direction's beam, where the scanner looks that way; rounds to the nearest beam.
pub(super) fn beam_towards(from_ahead: BinaryAngle) -> Option<u8> {
    let steps = i64::from(from_ahead.to_bits().cast_signed());
    // Of the magnitude, so that left and right are rounded alike.
    let beams = steps
        .saturating_abs()
        .saturating_mul(HALF_TURN_BEAMS)
        .saturating_add(1 << 14)
        >> 15;
    let beams = if steps < 0 {
        beams.wrapping_neg()
    } else {
        beams
    };
    let index = beams.saturating_add(i64::from(MIDDLE_BEAM));
    let index = saturating_u8(u64::try_from(index).ok()?);
    (usize::from(index) < super::BEAMS).then_some(index)
}

#[cfg(test)]
mod tests {
    use super::super::{BEAMS, HistogramConfig};
    use super::*;
    use certainty_core::transducer::Reading;
    use certainty_core::units::Millimeters;

    /// Blocked is what is nearer than 1 m beyond a safe region that has no size.
    const CONFIG: HistogramConfig = HistogramConfig {
        default: Millimeters::new(2000),
        safe: Millimeters::ZERO,
    };
    const HALF: Threshold = Threshold::new(127);

    fn blocked(beams: impl IntoIterator<Item = usize>) -> PolarHistogram {
        let mut scan = [Reading::NoObject; BEAMS];
        for beam in beams {
            scan[beam] = Reading::Echo(Millimeters::new(500));
        }
        PolarHistogram::of(&scan, &CONFIG)
    }

    fn ends(histogram: &PolarHistogram) -> Vec<(u8, u8)> {
        let valleys = HALF.valleys(histogram);
        valleys.map(|v| (v.first(), v.last())).collect()
    }

    fn degrees(degrees: i32) -> BinaryAngle {
        BinaryAngle::from_millidegrees(degrees * 1000)
    }

    #[test]
    fn eq_9_finds_what_is_between_obstacles_and_at_the_ends() {
        assert_eq!(ends(&blocked([])), [(0, 100)]);
        assert_eq!(ends(&blocked(30..=40)), [(0, 29), (41, 100)]);
        assert_eq!(ends(&blocked((0..20).chain(60..101))), [(20, 59)]);
        assert_eq!(ends(&blocked(0..101)), []);
    }

    #[test]
    fn eq_11_steers_to_the_mean_of_the_ends() {
        // (41 + 100) / 2 = 70.5, less 50, times 0.01.
        let valley = Valley {
            first: 41,
            last: 100,
        };
        assert_eq!(valley.turn().to_bits(), (0.205 * 65536.0) as i32);
        let mirrored = Valley { first: 0, last: 59 };
        assert_eq!(mirrored.turn(), -valley.turn());
        assert_eq!(
            Valley {
                first: 0,
                last: 100
            }
            .turn(),
            Effort::ZERO
        );
        assert_eq!(
            Valley {
                first: 100,
                last: 100
            }
            .turn(),
            Effort::lit("0.5")
        );
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
    fn the_side_decides_ties_and_holds_on_for_so_many_beams() {
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

    #[test]
    fn a_direction_has_its_nearest_beam() {
        for (millidegrees, beam) in [
            (0, 50),
            (495, 50),
            (505, 51),
            (-505, 49),
            (50_000, 100),
            (-50_000, 0),
        ] {
            let angle = BinaryAngle::from_millidegrees(millidegrees);
            assert_eq!(beam_towards(angle), Some(beam), "{millidegrees}");
        }
        assert_eq!(beam_towards(degrees(51)), None);
        assert_eq!(beam_towards(degrees(180)), None);
    }
}
