//! What the map remembers where the sensors look, and how it makes up for them.

use super::histogram::{BEAMS, PerBeam, beam_bearing};
use super::map_scan::RayHit;
use super::motion::HALF;
use super::nearness::nearer;
use super::{Effort, Failure, Failures, PerRangefinder, RANGEFINDERS, RayFan, Views};
use certainty_core::certainty::Certainty;
use certainty_core::fusion::{CertaintyGrid, Environment};
use certainty_core::transducer::Reading;
use certainty_core::units::{Millimeters, Pose};

/// What the map shows where the sensors look.
///
/// A map of what was seen by sensors that are believed remembers what none of them sees now: what is
/// beside the robot, what a sensor that broke saw before, what others saw in its place. \[004\] drives by
/// the readings of the moment alone.
///
/// Memory: 1,764 bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ExpectedScan {
    /// Around each rangefinder.
    pub sectors: PerRangefinder<RayFan>,
    /// Where the scanner looks.
    pub scan: PerBeam<Reading>,
    /// How far the map surely shows nothing there.
    pub clear: PerBeam<Millimeters>,
}

/// What a robot that remembers goes by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Completed<'a> {
    /// In the place of the rangefinders' readings.
    pub rangefinders: PerRangefinder<Reading>,
    /// In the place of the scanner's.
    pub scan: &'a PerBeam<Reading>,
    /// How far each of them is to be doubted.
    pub failures: Failures,
}

impl ExpectedScan {
    /// Nothing is remembered anywhere.
    pub const NOTHING: Self = Self {
        sectors: [RayFan::EMPTY; RANGEFINDERS],
        scan: [Reading::NoObject; BEAMS],
        clear: [Millimeters::ZERO; BEAMS],
    };

    /// Returns what a robot at `robot` would see in the map: cells surer than `obstacle`.
    ///
    /// Cost: the cells on 167 lines.
    #[must_use]
    pub fn of_map<G: CertaintyGrid>(
        map: &Environment<'_, G>,
        robot: Pose,
        views: &Views,
        obstacle: Certainty,
    ) -> Self {
        let sector = |mounting| {
            let from = robot.compose(mounting);
            RayFan::of_map(map, from, views.rangefinders_see, obstacle)
        };
        let mut seen = Self {
            sectors: views.rangefinders.map(sector),
            ..Self::NOTHING
        };
        let scanner = robot.compose(views.scanner);
        let beams = seen.scan.iter_mut().zip(&mut seen.clear);
        for ((reading, clear), index) in beams.zip(0..=u8::MAX) {
            let heading = scanner.heading.wrapping_add(beam_bearing(index));
            let along = Pose::new(scanner.at, heading);
            let sight = RayHit::in_map(map, along, views.scanner_sees, obstacle);
            (*reading, *clear) = (sight.met, sight.clear);
        }
        seen
    }

    /// Returns what the robot goes by where its sensors say `rangefinders` and `scan` and are believed to
    /// have failed as `failures` say.
    ///
    /// - A rangefinder that is believed tells the nearer of what it says and what is remembered around it.
    /// - Who says nothing has failed for now ([`Failures::or_silent`]).
    /// - For one that is not, by half at least, the memory speaks alone; so for the scanner.
    /// - Who is spoken for is doubted by 1 less the memory's worth. It is worth as much as the scanner is
    ///   believed, which draws nearly all of it; without the scanner as much as the rangefinders are in the
    ///   mean, at most a half. So where all have failed it is worth nothing, and the robot stands.
    #[must_use]
    pub fn complete<'a>(
        &'a self,
        rangefinders: &PerRangefinder<Reading>,
        scan: &'a PerBeam<Reading>,
        failures: &Failures,
    ) -> Completed<'a> {
        let failures = failures.or_silent(rangefinders, Some(scan));
        let forgotten = Failure::new_saturating(Effort::ONE.saturating_sub(worth(&failures)));
        let mut completed = Completed {
            rangefinders: *rangefinders,
            scan,
            failures,
        };
        let doubts = completed.failures.rangefinders.iter_mut();
        let each = completed.rangefinders.iter_mut().zip(doubts);
        for ((reading, doubt), sector) in each.zip(&self.sectors) {
            if doubt.is_broken() {
                *reading = sector.nearest();
                *doubt = forgotten.min(*doubt);
            } else {
                *reading = nearer(*reading, sector.nearest());
            }
        }
        if failures.scanner.is_broken() {
            completed.scan = &self.scan;
            completed.failures.scanner = forgotten.min(failures.scanner);
        }
        completed
    }
}

/// How far a memory can be believed that such sensors draw.
fn worth(failures: &Failures) -> Effort {
    let each = failures.rangefinders.iter();
    let (sum, count) = each.fold((Effort::ZERO, 0_i32), |(sum, count), failure| {
        let sum = sum.saturating_add(failure.left());
        (sum, count.wrapping_add(1))
    });
    let mean = Effort::from_bits(sum.to_bits().checked_div(count).unwrap_or(0));
    failures.scanner.left().max(mean.min(HALF))
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_core::transducer::Missing;

    const NOTHING: PerBeam<Reading> = [Reading::NoObject; BEAMS];

    const fn echo(mm: u32) -> Reading {
        Reading::Echo(Millimeters::new(mm))
    }

    /// Something a metre away everywhere.
    fn memory() -> ExpectedScan {
        ExpectedScan {
            sectors: [RayFan::of_rays([echo(1000); 11], Millimeters::new(1000)); RANGEFINDERS],
            scan: [echo(1000); BEAMS],
            clear: [Millimeters::new(1000); BEAMS],
        }
    }

    fn failed(rangefinders: usize, scanner: bool) -> Failures {
        let mut failures = Failures::NONE;
        failures.rangefinders[..rangefinders].fill(Failure::TOTAL);
        if scanner {
            failures.scanner = Failure::TOTAL;
        }
        failures
    }

    #[test]
    fn it_takes_the_memory_that_is_written_down() {
        assert_eq!(size_of::<ExpectedScan>(), 1764);
        assert_eq!(size_of::<RayFan>(), 92);
    }

    #[test]
    fn who_is_believed_tells_the_nearer_of_sight_and_memory() {
        let mut readings = [Reading::NoObject; RANGEFINDERS];
        readings[0] = echo(400);
        readings[1] = echo(1400);
        readings[2] = Reading::Missing(Missing::Timeout);
        let memory = memory();
        let completed = memory.complete(&readings, &NOTHING, &Failures::NONE);
        let (near, far) = (echo(400), echo(1000));
        assert_eq!(completed.rangefinders, [near, far, far, far, far, far]);
        // The scanner is believed, and needs no memory.
        assert_eq!(completed.scan, &NOTHING);
        assert_eq!(completed.failures, Failures::NONE);
    }

    /// Nobody is found broken yet, and nobody is heard: the memory is worth nothing.
    #[test]
    fn what_is_remembered_by_the_silent_alone_moves_no_robot() {
        let memory = memory();
        let silent = [Reading::Missing(Missing::Timeout); RANGEFINDERS];
        let completed = memory.complete(&silent, &NOTHING, &failed(0, true));
        assert_eq!(completed.failures, Failures::ALL);
        let unheard = [Reading::Missing(Missing::Timeout); BEAMS];
        let completed = memory.complete(&silent, &unheard, &Failures::NONE);
        assert_eq!(completed.failures, Failures::ALL);
    }

    #[test]
    fn for_who_is_not_believed_the_memory_speaks_alone() {
        let memory = memory();
        let close = [echo(100); RANGEFINDERS];
        let completed = memory.complete(&close, &NOTHING, &failed(1, false));
        assert_eq!(completed.rangefinders[0], echo(1000));
        assert_eq!(completed.rangefinders[1..], [echo(100); 5]);
        assert_eq!(completed.failures, Failures::NONE);
        let completed = memory.complete(&close, &NOTHING, &failed(0, true));
        assert_eq!(completed.scan, &memory.scan);
    }

    /// By hand: without the scanner (6 − n) / 6 of the memory is left where n rangefinders have failed, at
    /// most a half.
    #[test]
    fn what_nobody_draws_is_worth_nothing() {
        let memory = memory();
        let doubt = |failures: &Failures| {
            let readings = [Reading::NoObject; RANGEFINDERS];
            let completed = memory.complete(&readings, &NOTHING, failures).failures;
            let [first, ..] = completed.rangefinders;
            let parts = [first, completed.scanner].map(|failure| failure.part().to_num::<f64>());
            (parts[0], parts[1])
        };
        assert_eq!(doubt(&failed(6, false)), (0.0, 0.0));
        assert_eq!(doubt(&failed(0, true)), (0.0, 0.5));
        assert_eq!(doubt(&failed(2, true)), (0.5, 0.5));
        let left = 1.0 / 3.0;
        let (rangefinder, scanner) = doubt(&failed(4, true));
        assert!((rangefinder - (1.0 - left)).abs() < 1e-4 && rangefinder == scanner);
        assert_eq!(
            memory
                .complete(&[echo(9); 6], &NOTHING, &Failures::ALL)
                .failures,
            Failures::ALL
        );
        // Nobody is doubted more for being spoken for.
        let mut half = failed(0, true);
        half.rangefinders = [Failure::TOTAL; RANGEFINDERS];
        half.rangefinders[0] = Failure::new_saturating(HALF);
        half.rangefinders[1] = Failure::NONE;
        // A quarter is left in the mean.
        assert_eq!(doubt(&half), (0.5, 0.75));
    }
}
