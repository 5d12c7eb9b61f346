//! Where the car goes, and by which rules.

use super::odometer::CHASSIS;
use crate::smart_car::FARTHEST;
use certainty_control::{
    ControlConfig, ControlRules, Corner, CoverageConfig, Effort, FailureSharing, HistogramConfig,
    Limits, Ramp, Weights,
};
use certainty_core::certainty::Certainty;
use certainty_core::units::{Millimeters, Point};

/// Where the car goes: 0.76 m ahead to the left of where it starts, within its grid.
///
/// Open choice. In the built-in scene it lies behind the gap of 27 cm between the block in the middle and the
/// long box on the left, and the straight way there would touch the block's corner. Right behind the block
/// there is no goal for a car whose cells are 10 cm: it would have to turn round the corner at arm's length,
/// and tried so it touched the block in half of the runs.
pub const GOAL: Point = Point::from_mm(-300, 700);

/// A cell surer than this stops a beam through the map: half way from *uncertain* to *occupied*.
pub(super) const OBSTACLE: Certainty = Certainty::from_bits(192);

/// How far the car looks into its map: as far as its heads do.
pub(super) const SIGHT: Millimeters = FARTHEST;

/// Which way rangefinders 2 and 3 of \[004\] look, in degrees to the left; 5 and 4 are their mirror images.
pub(super) const SIDES_DEG: [i32; 2] = [60, 90];

/// What an obstacle's place in the map may be off by, in mm: half a cell.
const HALF_CELL_MM: u32 = 50;

/// The car's way to drive: [`ControlConfig::DEFAULT`] for a car a quarter as large and a tenth as fast.
///
/// - Distances shrink with the radius. The safe region is the outline itself, as eq. 7 widens an obstacle by
///   more than the outline takes: at 200 mm by 110 mm. The speed is zero where something is as near as half a
///   cell beyond the outline.
/// - Four of the six rangefinders of \[004\] are not there and are looked up in the map
///   (at 60° and 90°), so that the car does not turn into what it is passing. They cover nothing that the
///   map does not, and fail with it. So [`FailureSharing::Own`]: no sense is a reason to doubt the others.
/// - The map covers four fifths of what lies ahead and each ranger a tenth. At least three fifths must be seen:
///   one head or both rangers may be gone, but not two heads of three, whose word would then be one against
///   none. So the car stands as soon as the map is believed by less than a half, from where on the
///   [`Controller`](certainty_control::Controller) would not brake for what it shows.
/// - A wheel gets faster by all its speed in a second, by four fifths of it in a round.
pub static CONTROL: ControlRules = {
    let default = ControlConfig::DEFAULT;
    let ahead = Effort::lit("0.1");
    let none = Effort::ZERO;
    let config = ControlConfig {
        braitenberg: default.braitenberg,
        rangefinder_default: Millimeters::new(300),
        histogram: HistogramConfig {
            default: Millimeters::new(600),
            safe: Millimeters::new(CHASSIS.radius_mm),
        },
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
        sharing: FailureSharing::Own,
        coverage: CoverageConfig {
            rangefinders: [ahead, none, none, none, none, ahead],
            scanner: Effort::lit("0.8"),
            least: Effort::lit("0.601"),
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
#[expect(clippy::panic, reason = "a constant that panics does not build")]
const fn ramp(corners: [(u32, i32); 4]) -> Ramp {
    const fn corner((mm, height): (u32, i32)) -> Corner {
        Corner {
            at: Millimeters::new(mm),
            height: Effort::from_bits(height << (Effort::FRAC_NBITS - 4)),
        }
    }
    let [a, b, c, d] = corners;
    match Ramp::try_new([corner(a), corner(b), corner(c), corner(d)]) {
        Ok(ramp) => ramp,
        Err(_) => panic!("no such ramp"),
    }
}
