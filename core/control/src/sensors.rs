//! The robot's range sensors: how many there are, where they sit, what they read.
//!
//! Two kinds: `R` single-beam rangefinders, and one scanner of `B` beams, one a degree. The numbers are
//! const generics everywhere; the defaults and the aliases are those of \[004\]'s robot, 6 and 101.

use certainty_core::transducer::Reading;
use certainty_core::units::{BinaryAngle, Direction, Millimeters, Point, Pose};

/// Rangefinders of \[004\]'s robot.
pub const RANGEFINDERS: usize = 6;

/// Beams of the scanner of \[004\]'s robot, one a degree (\[004\] §3).
pub const BEAMS: usize = 101;

/// One value per rangefinder, number 1 first.
///
/// The first half look to the left, and number *i* is the mirror image of number *R* + 1 − *i*. With six,
/// 1 and 6 look ahead, 2 and 5 aside, 3 and 4 behind. \[004\] Fig. 1 numbers them so that eq. 4 can hold.
pub type PerRangefinder<T> = [T; RANGEFINDERS];

/// One value per beam, from the rightmost, 50° right of straight ahead, to the leftmost.
pub type PerBeam<T> = [T; BEAMS];

/// Where each sensor sits and looks, in the robot's frame (x ahead, y to the left), and how far.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Mountings<const R: usize = RANGEFINDERS> {
    /// The rangefinders.
    pub rangefinders: [Pose; R],
    /// The scanner.
    pub scanner: Pose,
    /// The longest distance that a rangefinder measures.
    pub rangefinder_range: Millimeters,
    /// The longest distance that the scanner measures.
    pub scanner_range: Millimeters,
}

impl Mountings {
    /// The sensors of \[004\]'s robot.
    ///
    /// Open choice: Fig. 2 shows them without numbers, all around and most of them ahead. The front and the oblique
    /// rangefinders look into the scanner's field, so that they and the scanner can be compared.
    pub const IBIS: Self = Self {
        rangefinders: [
            mounting(390, 170, 15),
            mounting(310, 240, 45),
            mounting(0, 280, 95),
            mounting(0, -280, -95),
            mounting(310, -240, -45),
            mounting(390, -170, -15),
        ],
        scanner: mounting(420, 0, 0),
        rangefinder_range: Millimeters::new(4000),
        scanner_range: Millimeters::new(4000),
    };
}

/// A place in mm and a direction in degrees.
const fn mounting(x_mm: i32, y_mm: i32, degrees: i32) -> Pose {
    let heading = BinaryAngle::from_millidegrees(degrees.wrapping_mul(1000));
    Pose::new(Point::from_mm(x_mm, y_mm), heading)
}

/// One reading of every sensor, all taken at the same time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SensorReadings<const R: usize = RANGEFINDERS, const B: usize = BEAMS> {
    /// The rangefinders' readings.
    pub rangefinders: [Reading; R],
    /// The scanner's readings, from the right to the left.
    pub scan: [Reading; B],
}

/// The directions of a scanner's `B` beams: one a degree, as many to the left of straight ahead as to the
/// right.
///
/// `B` is odd and at most 181, else the program does not compile.
#[derive(Debug, Clone, Copy)]
pub struct ScanGeometry<const B: usize>;

impl<const B: usize> ScanGeometry<B> {
    /// The beam that looks straight ahead.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "the assertion leaves at most 90"
    )]
    pub const MIDDLE: u8 = {
        assert!(
            B % 2 == 1 && B <= 181,
            "a scanner needs an odd number of beams, at most 181"
        );
        (B / 2) as u8
    };

    /// The directions of all beams from straight ahead.
    pub(crate) const DIRECTIONS: [Direction; B] = {
        let mut directions = [BinaryAngle::ZERO.direction(); B];
        let mut rest: &mut [Direction] = &mut directions;
        let mut index = 0_u8;
        while let [direction, others @ ..] = rest {
            *direction = Self::bearing(index).direction();
            rest = others;
            index = index.wrapping_add(1);
        }
        directions
    };

    /// Returns the direction of beam `index` from straight ahead; beam 0 is the rightmost.
    #[must_use]
    pub const fn bearing(index: u8) -> BinaryAngle {
        let degrees = (index as i32).wrapping_sub(Self::MIDDLE as i32);
        BinaryAngle::from_millidegrees(degrees.wrapping_mul(1000))
    }

    /// Returns the beam nearest to a direction from straight ahead; `None` outside the field.
    ///
    /// Rounds the magnitude, so that left and right are rounded alike.
    #[must_use]
    pub fn beam_towards(from_ahead: BinaryAngle) -> Option<u8> {
        let steps = i64::from(from_ahead.to_bits().cast_signed());
        let magnitude = steps
            .saturating_abs()
            .saturating_mul(HALF_TURN_BEAMS)
            .saturating_add(1 << 14)
            >> 15;
        let beams = if steps < 0 {
            magnitude.wrapping_neg()
        } else {
            magnitude
        };
        let index = u8::try_from(beams.saturating_add(i64::from(Self::MIDDLE))).ok()?;
        (usize::from(index) < B).then_some(index)
    }
}

/// Beams, one a degree, in half a turn.
pub(crate) const HALF_TURN_BEAMS: i64 = 180;

/// Returns the direction of beam `index` of [`BEAMS`] from straight ahead; beam 0 is the rightmost.
#[must_use]
pub const fn beam_bearing(index: u8) -> BinaryAngle {
    ScanGeometry::<BEAMS>::bearing(index)
}

/// Returns the distance to the object that a reading reports, 0 for *too near*; `None` if it reports none.
pub(crate) const fn distance(reading: Reading) -> Option<Millimeters> {
    match reading {
        Reading::Echo(distance) => Some(distance),
        Reading::TooNear => Some(Millimeters::ZERO),
        Reading::NoObject | Reading::Missing(_) => None,
    }
}

/// Returns the reading with the nearer object; the first if neither reports an object.
pub(crate) fn nearer(one: Reading, other: Reading) -> Reading {
    match (distance(one), distance(other)) {
        (Some(near), Some(far)) if near <= far => one,
        (_, Some(_)) => other,
        (_, None) => one,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_core::transducer::Missing;

    const fn echo(mm: u32) -> Reading {
        Reading::Echo(Millimeters::new(mm))
    }

    #[test]
    fn the_nearer_of_two_objects_is_kept() {
        let missing = Reading::Missing(Missing::Timeout);
        assert_eq!(nearer(echo(5), echo(7)), echo(5));
        assert_eq!(nearer(echo(7), echo(5)), echo(5));
        assert_eq!(nearer(echo(7), Reading::TooNear), Reading::TooNear);
        for nothing in [Reading::NoObject, missing] {
            assert_eq!(nearer(nothing, echo(5)), echo(5));
            assert_eq!(nearer(echo(5), nothing), echo(5));
        }
        assert_eq!(nearer(missing, Reading::NoObject), missing);
    }

    #[test]
    fn a_direction_has_its_nearest_beam() {
        type Field = ScanGeometry<BEAMS>;
        let degrees = |degrees: i32| BinaryAngle::from_millidegrees(degrees * 1000);
        for (millidegrees, beam) in [
            (0, 50),
            (495, 50),
            (505, 51),
            (-505, 49),
            (50_000, 100),
            (-50_000, 0),
        ] {
            let angle = BinaryAngle::from_millidegrees(millidegrees);
            assert_eq!(Field::beam_towards(angle), Some(beam), "{millidegrees}");
        }
        assert_eq!(Field::beam_towards(degrees(51)), None);
        assert_eq!(Field::beam_towards(degrees(180)), None);
    }

    #[test]
    fn every_field_is_symmetric_about_its_middle_beam() {
        fn check<const B: usize>() {
            for index in 0..B as u8 {
                let bearing = ScanGeometry::<B>::bearing(index);
                let mirror = ScanGeometry::<B>::bearing(B as u8 - 1 - index);
                assert_eq!(bearing, -mirror);
                assert_eq!(ScanGeometry::<B>::beam_towards(bearing), Some(index));
            }
            let middle = ScanGeometry::<B>::MIDDLE;
            assert_eq!(ScanGeometry::<B>::bearing(middle), BinaryAngle::ZERO);
        }
        check::<1>();
        check::<61>();
        check::<BEAMS>();
        check::<181>();
    }
}
