//! Where the car goes, and by which rules.

use super::odometer::CHASSIS;
use crate::smart_car::FARTHEST;
use certainty_core::certainty::Certainty;
use certainty_core::control::{
    Blame, Braitenberg, ControlConfig, ControlRules, Corner, CoverageConfig, HistogramConfig,
    Limits, Outlook, Ramp, Signal, Threshold, Weights,
};
use certainty_core::units::{Millimeters, Point};

/// Where the car goes: 0.9 m straight ahead of where it starts, in the last but one row of its grid.
///
/// Open choice: in the built-in scene it lies behind the block that stands in the middle, so that the way
/// there leads round it.
pub const GOAL: Point = Point::from_mm(0, 900);

/// A cell surer than this stops a beam through the map: half way from *uncertain* to *occupied*.
pub(super) const OBSTACLE: Certainty = Certainty::from_bits(192);

/// How far the car looks into its map: as far as its heads do.
pub(super) const SIGHT: Millimeters = FARTHEST;

/// What an obstacle's place in the map may be off by, in mm: half a cell.
const HALF_CELL_MM: u32 = 50;

/// The car's way to drive: [`ControlConfig::DEFAULT`] for a car a quarter as large and a tenth as fast.
///
/// - Distances shrink with the radius; the speed is zero where something is as near as half a cell beyond the
///   outline, so that what is straight ahead is never touched.
/// - Four of the six rangefinders of \[004\] are not there: only numbers 1 and 6, the two that look ahead, have
///   a weight and cover anything. So [`Blame::Own`]: what was never there is no reason to doubt the two that
///   are.
/// - The map covers four fifths of what lies ahead and each ranger a tenth. At least a half must be seen: one
///   head and both rangers may be gone, but not two heads of three, whose word would then be one against none.
/// - A wheel gets faster by all its speed in a second, one round's worth in each round.
pub const CONTROL: ControlRules = {
    let default = ControlConfig::DEFAULT;
    let ahead = Signal::lit("0.1");
    let none = Signal::ZERO;
    let config = ControlConfig {
        braitenberg: Braitenberg::new([Signal::lit("-0.5"), none, none]),
        rangefinder_default: Millimeters::new(400),
        outlook: Outlook::Level,
        histogram: HistogramConfig {
            default: Millimeters::new(600),
            safe: Millimeters::new(CHASSIS.radius_mm + HALF_CELL_MM),
        },
        threshold: Threshold::new(140),
        commitment: default.commitment,
        weights: Weights {
            braitenberg: ramp([(150, 16), (250, 12), (400, 6), (600, 0)]),
            histogram: ramp([(150, 16), (300, 20), (600, 16), (800, 8)]),
            azimuth: ramp([(150, 4), (250, 6), (400, 10), (600, 20)]),
            speed: ramp([
                (CHASSIS.radius_mm + HALF_CELL_MM, 0),
                (200, 6),
                (350, 12),
                (600, 16),
            ]),
        },
        blame: Blame::Own,
        coverage: CoverageConfig {
            rangefinders: [ahead, none, none, none, none, ahead],
            scanner: Signal::lit("0.8"),
            least: Signal::lit("0.5"),
        },
        limits: Limits {
            full_speed_mm_s: CHASSIS.full_speed_mm_s,
            faster_mm_s2: 100,
            slower_mm_s2: 1000,
        },
        goal_radius: Millimeters::new(100),
        stale_after: 400,
    };
    match ControlRules::try_new(config) {
        Ok(rules) => rules,
        Err(_) => panic!("no such rules"),
    }
};

/// A ramp through corners at so many mm, with heights in steps of 1/16.
const fn ramp(corners: [(u32, i32); 4]) -> Ramp {
    const fn corner((mm, height): (u32, i32)) -> Corner {
        Corner {
            at: Millimeters::new(mm),
            height: Signal::from_bits(height << (Signal::FRAC_NBITS - 4)),
        }
    }
    let [a, b, c, d] = corners;
    match Ramp::try_new([corner(a), corner(b), corner(c), corner(d)]) {
        Ok(ramp) => ramp,
        Err(_) => panic!("no such ramp"),
    }
}
