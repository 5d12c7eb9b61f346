//! How near a reading is: \[004\] eq. 3 and 5.

use super::Effort;
use certainty_core::narrow::low_u32;
use certainty_core::transducer::Reading;
use certainty_core::units::Millimeters;

/// What a rangefinder reads where nothing is wrong, and so what differs from it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Mounting {
    /// It looks straight ahead: only what is nearer than the default counts, \[004\] eq. 5.
    Level,
    /// It looks down, and the default is where it meets flat ground: what is farther is a hole, and
    /// counts as what is nearer does, \[004\] eq. 3.
    Tilted,
}

/// Returns how much a rangefinder is in the way of: `s_RF` of \[004\] eq. 3 and 5; `None` for what is
/// missing.
///
/// Formula: level, `1 − D / D_def` where D < `D_def`, else 0; tilted, `|D_def − D| / D_def`, at most 1.
/// Rounds down. *Too near* is 1; *no object* 0 level, and a bottomless hole, 1, tilted. `default` above
/// zero, else all is 0.
///
/// Differs from \[004\] eq. 3: printed without the bars that eq. 7 has, it gives `D / D_def`, nothing for
/// what touches the robot, against eq. 5. With them both agree. Its modulo lets a hole of twice the
/// default count for nothing; here what is deeper is no better.
///
/// ```
/// use certainty_control::{Mounting, Effort, nearness};
/// use certainty_core::transducer::Reading;
/// use certainty_core::units::Millimeters;
///
/// let default = Millimeters::new(2000);
/// let echo = |mm| Reading::Echo(Millimeters::new(mm));
/// assert_eq!(nearness(echo(500), default, Mounting::Level), Some(Effort::lit("0.75")));
/// assert_eq!(nearness(echo(3000), default, Mounting::Level), Some(Effort::ZERO));
/// assert_eq!(nearness(echo(3000), default, Mounting::Tilted), Some(Effort::lit("0.5")));
/// ```
#[must_use]
pub const fn nearness(reading: Reading, default: Millimeters, outlook: Mounting) -> Option<Effort> {
    let Some(off) = off(reading, default, outlook) else {
        return None;
    };
    // At most one, by 32 and 16 bits.
    let wide = (off.get() as u64) << Effort::FRAC_NBITS;
    Some(match wide.checked_div(default.get() as u64) {
        Some(part) => Effort::from_bits(low_u32(part).cast_signed()),
        None => Effort::ZERO,
    })
}

/// By how much a reading is off what a rangefinder reads where nothing is wrong, at most by that.
const fn off(reading: Reading, default: Millimeters, outlook: Mounting) -> Option<Millimeters> {
    let tilted = matches!(outlook, Mounting::Tilted);
    let most = default.get();
    let off = match reading {
        Reading::Missing(_) => return None,
        Reading::TooNear => most,
        Reading::NoObject if tilted => most,
        Reading::NoObject => 0,
        Reading::Echo(distance) if distance.get() <= most || tilted => {
            let off = distance.get().abs_diff(most);
            if off < most { off } else { most }
        }
        Reading::Echo(_) => 0,
    };
    Some(Millimeters::new(off))
}

/// Returns how far away what a rangefinder tells of is, as far as that is in the way; `None` where nothing is.
///
/// Tilted, a hole is as near as the step that it is off the ground by: one without a bottom is here.
pub(super) fn in_the_way(
    reading: Reading,
    default: Millimeters,
    outlook: Mounting,
) -> Option<Millimeters> {
    match outlook {
        Mounting::Level => distance(reading),
        Mounting::Tilted => {
            let off = off(reading, default, outlook)?;
            (off > Millimeters::ZERO).then(|| default.saturating_sub(off))
        }
    }
}

/// Returns how far away the nearest object may be that a reading tells of; `None` where it tells of
/// none.
pub(super) const fn distance(reading: Reading) -> Option<Millimeters> {
    match reading {
        Reading::Echo(distance) => Some(distance),
        Reading::TooNear => Some(Millimeters::ZERO),
        Reading::NoObject | Reading::Missing(_) => None,
    }
}

/// The one of two that tells of the nearer object; the first where neither tells of any.
pub(super) fn nearer(one: Reading, other: Reading) -> Reading {
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

    const DEFAULT: Millimeters = Millimeters::new(1600);

    fn of(reading: Reading, outlook: Mounting) -> Option<f64> {
        nearness(reading, DEFAULT, outlook).map(Effort::to_num)
    }

    const fn echo(mm: u32) -> Reading {
        Reading::Echo(Millimeters::new(mm))
    }

    #[test]
    fn the_nearer_of_two_is_the_one_that_must_be_avoided() {
        let silent = Reading::Missing(Missing::Timeout);
        assert_eq!(nearer(echo(5), echo(7)), echo(5));
        assert_eq!(nearer(echo(7), echo(5)), echo(5));
        assert_eq!(nearer(echo(7), Reading::TooNear), Reading::TooNear);
        for nothing in [Reading::NoObject, silent] {
            assert_eq!(nearer(nothing, echo(5)), echo(5));
            assert_eq!(nearer(echo(5), nothing), echo(5));
        }
        assert_eq!(nearer(silent, Reading::NoObject), silent);
    }

    #[test]
    fn eq_5_by_hand() {
        for (mm, expected) in [
            (0, 1.0),
            (400, 0.75),
            (1200, 0.25),
            (1600, 0.0),
            (9000, 0.0),
        ] {
            assert_eq!(of(echo(mm), Mounting::Level), Some(expected), "{mm}");
        }
        assert_eq!(of(Reading::NoObject, Mounting::Level), Some(0.0));
        assert_eq!(of(Reading::TooNear, Mounting::Level), Some(1.0));
    }

    #[test]
    fn eq_3_counts_holes_as_it_counts_steps() {
        for (mm, expected) in [
            (400, 0.75),
            (1600, 0.0),
            (2000, 0.25),
            (3200, 1.0),
            (9000, 1.0),
        ] {
            assert_eq!(of(echo(mm), Mounting::Tilted), Some(expected), "{mm}");
        }
        assert_eq!(of(Reading::NoObject, Mounting::Tilted), Some(1.0));
    }

    #[test]
    fn what_is_missing_says_nothing() {
        let missing = Reading::Missing(Missing::Timeout);
        assert_eq!(of(missing, Mounting::Level), None);
        assert_eq!(of(missing, Mounting::Tilted), None);
        assert_eq!(
            nearness(echo(3), Millimeters::ZERO, Mounting::Level),
            Some(Effort::ZERO)
        );
    }
}
