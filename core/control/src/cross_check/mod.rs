//! Consistency-based fault diagnosis from readings of the same places.
//!
//! Compares rangefinders, scanner and map pairwise and returns a failure estimate per sensor.

mod compare;

use crate::expected_scan::ExpectedScan;
use crate::failures::{Failure, Failures, SensorFlags};
use crate::motion::Effort;
use crate::sensors::RANGEFINDERS;
use certainty_core::transducer::Reading;
use core::fmt;

pub use compare::{CrossCheckConfig, Verdict, Verdicts};

/// Why a [`CrossCheckConfig`] is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CrossCheckConfigError {
    /// The weight of a contradiction, of an agreement or of a failure is zero.
    Weightless,
    /// The highest suspicion is too low for a failure to be certain.
    NeverCertain,
}

impl fmt::Display for CrossCheckConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Weightless => {
                "a contradiction, an agreement or a failure weighs nothing: expected above zero"
            }
            Self::NeverCertain => {
                "the highest suspicion is too low: expected at least twice the cost of a failure"
            }
        })
    }
}

impl core::error::Error for CrossCheckConfigError {}

/// How often sensors contradicted each other and the map lately: above 0 more often than they agreed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Suspicions<const R: usize> {
    /// `x_i`: each rangefinder and the scanner.
    pairs: [i16; R],
    /// `y_i`: each rangefinder and the map.
    rangefinders: [i16; R],
    /// `z`: the scanner and the map.
    scanner: i16,
}

impl<const R: usize> Suspicions<R> {
    const NONE: Self = Self {
        pairs: [0; R],
        rangefinders: [0; R],
        scanner: 0,
    };
}

/// Compares sensors that look at the same places, and estimates which of them have failed.
///
/// A contradiction within a pair of a rangefinder and the scanner means that one of them has failed, but not
/// which. The other pairs decide: a failed rangefinder contradicts the scanner alone, a failed scanner
/// contradicts every rangefinder that sees an object. So one failure that explains most is preferred to
/// several (consistency-based diagnosis); a single pair leaves both at one half. A failure that is already
/// assumed costs less than a new one: so a failed sensor stays failed while the others see nothing that could
/// confirm the scanner.
///
/// A map is compared with each sensor alone: it separates two failed rangefinders from a failed
/// scanner, and covers rangefinders that look where the scanner does not. An object that a rangefinder reports
/// where the map is surely free counts as a contradiction to the scanner, which drew most of the map.
///
/// Unlike a grid's comparison of cells this compares whole readings, so agreement on free cells, which even a
/// blind sensor reaches, does not outweigh a contradiction. Prefer the grid's
/// [`Health`](certainty_core::health::Health) for sensors that look where others have been.
///
/// Cost: per rangefinder, a product of vectors per beam of the scanner. Memory: 36 bytes for six rangefinders,
/// and the configuration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CrossCheck<const R: usize = RANGEFINDERS> {
    config: CrossCheckConfig<R>,
    suspicions: Suspicions<R>,
    /// The failures that are already assumed.
    assumed: SensorFlags<R>,
}

impl<const R: usize> CrossCheck<R> {
    /// Creates a check without any suspicion.
    ///
    /// # Errors
    ///
    /// [`CrossCheckConfigError`] names the parameter that does not fit.
    pub const fn try_new(config: CrossCheckConfig<R>) -> Result<Self, CrossCheckConfigError> {
        if config.contradiction == 0 || config.agreement == 0 || config.failure_cost == 0 {
            Err(CrossCheckConfigError::Weightless)
        } else if config.max_suspicion >> 1 < config.failure_cost {
            Err(CrossCheckConfigError::NeverCertain)
        } else {
            Ok(Self {
                config,
                suspicions: Suspicions::NONE,
                assumed: SensorFlags::NONE,
            })
        }
    }

    /// Returns the configuration.
    #[must_use]
    pub const fn config(&self) -> &CrossCheckConfig<R> {
        &self.config
    }

    /// Compares the readings of one time with each other, and with what the map shows, if `expected` is given;
    /// updates the suspicions and returns the results of this step.
    ///
    /// `expected` must be from the map before these readings are drawn into it, and readings that contradict
    /// it should not be drawn: a scanner that goes blind would erase in one scan what contradicts it, and a
    /// rangefinder's phantom would become an obstacle.
    ///
    /// The world is assumed to stand still: an object is accepted as gone if most of what the scanner sees is
    /// still there, and as new if two sensors see it.
    pub fn observe<const B: usize>(
        &mut self,
        rangefinders: &[Reading; R],
        scan: &[Reading; B],
        expected: Option<&ExpectedScan<R, B>>,
    ) -> Verdicts<R> {
        let pairs = self.config.compare_pairs(rangefinders, scan);
        let verdicts = match expected {
            Some(expected) => (self.config).compare_with_map(rangefinders, scan, pairs, expected),
            None => Verdicts {
                pairs,
                rangefinders: [Verdict::Silence; R],
                scanner: Verdict::Silence,
            },
        };
        self.update_pairs(rangefinders, &verdicts);
        self.update_from_map(&verdicts);
        self.update_assumed();
        verdicts
    }

    fn update_pairs(&mut self, rangefinders: &[Reading; R], verdicts: &Verdicts<R>) {
        let CrossCheckConfig {
            contradiction,
            agreement,
            max_suspicion,
            max_credit,
            ..
        } = self.config;
        let with_map = verdicts.pairs.iter().zip(&verdicts.rangefinders);
        let all = with_map.zip(rangefinders);
        for (suspicion, ((verdict, by_map), reading)) in self.suspicions.pairs.iter_mut().zip(all) {
            let by = match verdict {
                Verdict::Agreement => i16::from(agreement).saturating_neg(),
                Verdict::Contradiction => contradiction.into(),
                // The object is new to the map, or the scanner, which drew most of it, has failed.
                _ if *by_map == Verdict::Phantom => contradiction.into(),
                // A missing reading decays the pair's suspicion by one per step. Otherwise a stopped robot
                // would keep its last suspicion and never restart.
                _ if matches!(reading, Reading::Missing(_)) => suspicion.signum().saturating_neg(),
                // Credit decays.
                _ => i16::from(*suspicion < 0),
            };
            *suspicion = moved(*suspicion, by, max_credit, max_suspicion);
        }
    }

    fn update_from_map(&mut self, verdicts: &Verdicts<R>) {
        let CrossCheckConfig {
            max_suspicion,
            max_credit,
            ..
        } = self.config;
        let (agreement, contradiction) = (
            self.config.agreement.into(),
            self.config.contradiction.into(),
        );
        // Where the map shows nothing to compare with, the suspicion decays.
        let by = |verdict, agreement: i16, suspicion: i16| match verdict {
            Verdict::Agreement => agreement.saturating_neg(),
            Verdict::Contradiction => contradiction,
            Verdict::Phantom | Verdict::Past | Verdict::Silence => {
                suspicion.signum().saturating_neg()
            }
        };
        let all = self.suspicions.rangefinders.iter_mut();
        for (suspicion, &verdict) in all.zip(&verdicts.rangefinders) {
            let by = by(verdict, agreement, *suspicion);
            *suspicion = moved(*suspicion, by, max_credit, max_suspicion);
        }
        // Dozens of beams do not agree by chance, so an agreement weighs as much as a contradiction.
        let suspicion = &mut self.suspicions.scanner;
        let by = by(verdicts.scanner, contradiction, *suspicion);
        *suspicion = moved(*suspicion, by, max_suspicion, max_suspicion);
    }

    /// Hysteresis: latches a sensor as failed at ≥ 0.75, releases it below 0.25.
    fn update_assumed(&mut self) {
        const QUARTER: Effort = Effort::lit("0.25");
        let failures = self.failures();
        for (is_assumed, failure) in self.assumed.iter_mut().zip(failures.iter()) {
            *is_assumed = if *is_assumed {
                failure.part() >= QUARTER
            } else {
                failure.trust() <= QUARTER
            };
        }
    }

    /// Returns the failures that explain the suspicions.
    ///
    /// Formula: with `x_i` the suspicion of pair i, `y_i` and `z` those of rangefinder i and the scanner against
    /// the map, and λ the cost of a failure, half of that if it is already assumed: a failed scanner explains
    /// `S = Σ x_i + z − λ_s` and leaves `B = Σ max(0, y_i − λ_i)` to failed rangefinders, which by
    /// themselves explain `R = Σ max(0, x_i + y_i − λ_i)`. The scanner's share of the blame is
    /// `½ + (S + B − R) / 2λ` within 0..=1; its failure is that share of `S / λ`, rangefinder i's that share
    /// of `(y_i − λ_i) / λ` and the rest's of `(x_i + y_i − λ_i) / λ`, each within 0..=1.
    #[must_use]
    pub fn failures(&self) -> Failures<R> {
        let cost = i32::from(self.config.failure_cost);
        let cost_of = |is_assumed: bool| if is_assumed { cost >> 1 } else { cost };
        let sum = |values: &[i32; R]| {
            let values = values.iter();
            values.fold(0_i32, |sum, &value| sum.saturating_add(value))
        };
        let excess = |suspicions: &[i32; R]| {
            let mut excess = *suspicions;
            for (excess, is_assumed) in excess.iter_mut().zip(self.assumed.rangefinders) {
                *excess = excess.saturating_sub(cost_of(is_assumed)).max(0);
            }
            excess
        };
        let pairs = self.suspicions.pairs.map(i32::from);
        let alone = self.suspicions.rangefinders.map(i32::from);
        let mut both = pairs;
        for (both, &alone) in both.iter_mut().zip(&alone) {
            *both = both.saturating_add(alone);
        }
        let (besides, instead) = (excess(&alone), excess(&both));
        let scanner = sum(&pairs)
            .saturating_add(self.suspicions.scanner.into())
            .saturating_sub(cost_of(self.assumed.scanner));
        let lead = scanner
            .saturating_add(sum(&besides))
            .saturating_sub(sum(&instead));
        let blame = Effort::fraction(lead.saturating_add(cost), cost.saturating_mul(2));
        let rest = Effort::ONE - blame;
        let mut failures = Failures::NONE;
        failures.scanner = Failure::new_saturating(blame * Effort::fraction(scanner, cost));
        let over = besides.into_iter().zip(instead);
        for (failure, (besides, instead)) in failures.rangefinders.iter_mut().zip(over) {
            *failure = Failure::new_saturating(
                blame * Effort::fraction(besides, cost) + rest * Effort::fraction(instead, cost),
            );
        }
        failures
    }
}

/// A suspicion after a step, from −`credit` to `most`.
///
/// Not `clamp`, which panics for bounds in the wrong order.
fn moved(suspicion: i16, by: i16, credit: u8, most: u8) -> i16 {
    let (least, most) = (i16::from(credit).saturating_neg(), i16::from(most));
    suspicion.saturating_add(by).max(least).min(most)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expected_scan::RayFan;
    use crate::sensors::{BEAMS, Mountings, PerBeam, PerRangefinder, distance};
    use certainty_core::transducer::Missing;
    use certainty_core::units::{BinaryAngle, Millimeters, Point, Pose};
    use proptest::prelude::*;

    const fn mm(mm: u32) -> Millimeters {
        Millimeters::new(mm)
    }

    fn looks(x: i32, y: i32, degrees: i32) -> Pose {
        let heading = BinaryAngle::from_millidegrees(degrees * 1000);
        Pose::new(Point::from_mm(x, y), heading)
    }

    /// Four rangefinders look into the scanner's field, two behind.
    fn config() -> CrossCheckConfig {
        CrossCheckConfig::new(Mountings {
            rangefinders: [
                looks(400, 200, 15),
                looks(300, 250, 40),
                looks(-400, 200, 130),
                looks(-400, -200, -130),
                looks(300, -250, -40),
                looks(400, -200, -15),
            ],
            scanner: looks(450, 0, 0),
            rangefinder_range: mm(4000),
            scanner_range: mm(4000),
        })
    }

    fn check() -> CrossCheck {
        CrossCheck::try_new(config()).unwrap()
    }

    /// A wall across the way, 2 m ahead of the scanner.
    fn wall() -> PerBeam<Reading> {
        let mut scan = [Reading::NoObject; BEAMS];
        for (beam, reading) in scan.iter_mut().enumerate() {
            let angle = (beam as f64 - 50.0).to_radians();
            *reading = Reading::Echo(mm((2000.0 / angle.cos()).round() as u32));
        }
        scan
    }

    /// The rangefinders' readings of the same wall: x = 2450.
    fn of_wall() -> PerRangefinder<Reading> {
        let away = |x: f64, degrees: f64| {
            Reading::Echo(mm(
                ((2450.0 - x) / degrees.to_radians().cos()).round() as u32
            ))
        };
        let (ahead, aside) = (away(400.0, 15.0), away(300.0, 40.0));
        let none = Reading::NoObject;
        [ahead, aside, none, none, aside, ahead]
    }

    fn verdicts(rangefinders: &PerRangefinder<Reading>, scan: &PerBeam<Reading>) -> Vec<Verdict> {
        config().compare_pairs(rangefinders, scan).to_vec()
    }

    fn failures(
        readings: usize,
        rangefinders: &PerRangefinder<Reading>,
        scan: &PerBeam<Reading>,
    ) -> Vec<f64> {
        let mut check = check();
        for _ in 0..readings {
            check.observe(rangefinders, scan, None);
        }
        let failures = check.failures();
        let all = failures.rangefinders.into_iter().chain([failures.scanner]);
        all.map(|failure| failure.part().to_num()).collect()
    }

    use Verdict::{Agreement, Contradiction, Past, Phantom, Silence};

    #[test]
    fn sensors_that_see_the_same_wall_agree() {
        let expected = [Agreement, Agreement, Silence, Silence, Agreement, Agreement];
        assert_eq!(verdicts(&of_wall(), &wall()), expected);
        assert_eq!(failures(100, &of_wall(), &wall()), [0.0; 7]);
    }

    #[test]
    fn a_blind_rangefinder_is_found_and_no_other() {
        let mut rangefinders = of_wall();
        rangefinders[0] = Reading::NoObject;
        assert_eq!(verdicts(&rangefinders, &wall())[0], Contradiction);
        // 4 per reading, λ = 12: nothing until the fourth, all at the sixth.
        assert_eq!(failures(3, &rangefinders, &wall()), [0.0; 7]);
        assert_eq!(
            failures(6, &rangefinders, &wall()),
            [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
        );
    }

    #[test]
    fn a_blind_scanner_is_found_and_no_rangefinder() {
        let blind = [Reading::NoObject; BEAMS];
        let all = failures(6, &of_wall(), &blind);
        assert_eq!(all, [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    }

    #[test]
    fn two_rangefinders_that_lie_are_outvoted_by_two() {
        let mut rangefinders = of_wall();
        rangefinders[0] = Reading::Echo(mm(1200));
        rangefinders[1] = Reading::Echo(mm(2300));
        let all = failures(10, &rangefinders, &wall());
        assert_eq!(all, [1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn a_single_pair_leaves_both_at_one_half() {
        let mut rangefinders = [Reading::NoObject; RANGEFINDERS];
        rangefinders[5] = Reading::Echo(mm(1500));
        let all = failures(10, &rangefinders, &[Reading::NoObject; BEAMS]);
        assert_eq!(all, [0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.5]);
    }

    /// By hand: when the others see nothing `x` is 48 and the rest 0, so S = 48 − 12 and R = 48 − 6 for the failure
    /// that is assumed: the lead is 36 − 42 + 12 = 6 of 24, a quarter of the blame.
    #[test]
    fn a_failed_sensor_stays_failed_while_others_see_nothing() {
        let mut check = check();
        let mut stuck = of_wall();
        stuck[0] = Reading::Echo(mm(1000));
        for _ in 0..20 {
            check.observe(&stuck, &wall(), None);
        }
        let mut alone = [Reading::NoObject; RANGEFINDERS];
        alone[0] = Reading::Echo(mm(1000));
        for _ in 0..200 {
            check.observe(&alone, &[Reading::NoObject; BEAMS], None);
        }
        let failures = check.failures();
        let parts = (failures.rangefinders[0].part(), failures.scanner.part());
        assert_eq!(parts, (Effort::lit("0.75"), Effort::lit("0.25")));
    }

    #[test]
    fn a_scanner_that_fails_after_a_rangefinder_is_found() {
        let mut check = check();
        let mut stuck = of_wall();
        stuck[0] = Reading::Echo(mm(1000));
        for _ in 0..20 {
            check.observe(&stuck, &wall(), None);
        }
        for _ in 0..30 {
            check.observe(&stuck, &[Reading::NoObject; BEAMS], None);
        }
        assert_eq!(check.failures().scanner, Failure::TOTAL);
    }

    /// From 48 by 1 per reading.
    #[test]
    fn suspicion_decays_while_readings_are_missing() {
        let mut check = check();
        for _ in 0..20 {
            check.observe(&of_wall(), &[Reading::NoObject; BEAMS], None);
        }
        let missing = [Reading::Missing(Missing::Implausible); RANGEFINDERS];
        for _ in 0..47 {
            check.observe(&missing, &wall(), None);
        }
        assert_ne!(check.suspicions.pairs, [0; RANGEFINDERS]);
        check.observe(&missing, &wall(), None);
        assert_eq!(check.suspicions.pairs, [0; RANGEFINDERS]);
        assert_eq!(check.failures(), Failures::NONE);
    }

    #[test]
    fn a_sensor_that_agrees_again_is_trusted_again() {
        let mut check = check();
        let mut stuck = of_wall();
        stuck[0] = Reading::Echo(mm(1000));
        for _ in 0..100 {
            check.observe(&stuck, &wall(), None);
        }
        assert_eq!(check.failures().rangefinders[0], Failure::TOTAL);
        // From 48 by 2 per reading: at 10 the rest, (10 − 6) / 12, is still above a quarter; at 8 it is not, so it
        // is released, and 8 is below λ.
        for _ in 0..19 {
            check.observe(&of_wall(), &wall(), None);
            assert_ne!(check.failures(), Failures::NONE);
        }
        check.observe(&of_wall(), &wall(), None);
        assert_eq!(check.failures(), Failures::NONE);
    }

    #[test]
    fn readings_of_different_places_are_not_compared() {
        let nothing = [Reading::NoObject; BEAMS];
        let missing = [Reading::Missing(Missing::Timeout); RANGEFINDERS];
        assert_eq!(verdicts(&missing, &wall()), [Silence; 6]);
        // No object at all, and echoes where the scanner does not look.
        let mut behind = [Reading::NoObject; RANGEFINDERS];
        behind[2] = Reading::Echo(mm(500));
        behind[3] = Reading::TooNear;
        assert_eq!(verdicts(&behind, &nothing), [Silence; 6]);
        // A corner: the scanner's wall ends before the rangefinder's beam.
        let mut corner = wall();
        corner[..65].fill(Reading::NoObject);
        let open = [Reading::NoObject; RANGEFINDERS];
        assert_eq!(verdicts(&open, &corner)[5], Silence);
    }

    #[test]
    fn an_echo_hidden_from_the_scanner_is_no_contradiction() {
        // The scanner is blocked at 300 mm on all beams around the rangefinder's echo, which passes the
        // obstacle from its own place.
        let mut scan = [Reading::NoObject; BEAMS];
        scan[60..80].fill(Reading::Echo(mm(300)));
        let mut rangefinders = [Reading::NoObject; RANGEFINDERS];
        rangefinders[0] = Reading::Echo(mm(3000));
        assert_eq!(verdicts(&rangefinders, &scan)[0], Silence);
    }

    /// Everything before the wall is surely free, and a metre where there is none.
    fn clear(reading: Reading) -> Millimeters {
        distance(reading).unwrap_or(mm(1000))
    }

    /// The expectation from a map with the wall; the rays of a fan are all of the same length here.
    fn map_of_wall() -> ExpectedScan {
        ExpectedScan {
            fans: of_wall().map(|reading| RayFan::new([reading; 11], clear(reading))),
            scan: wall(),
            clear: wall().map(clear),
        }
    }

    const BLIND: PerRangefinder<Reading> = [Reading::NoObject; RANGEFINDERS];

    /// The failures after this many observations.
    fn with_map(
        times: usize,
        rangefinders: &PerRangefinder<Reading>,
        scan: &PerBeam<Reading>,
        expected: &ExpectedScan,
    ) -> Vec<f64> {
        let mut check = check();
        for _ in 0..times {
            check.observe(rangefinders, scan, Some(expected));
        }
        let failures = check.failures();
        let all = failures.rangefinders.into_iter().chain([failures.scanner]);
        all.map(|failure| failure.part().to_num()).collect()
    }

    #[test]
    fn readings_that_match_the_map_raise_no_suspicion() {
        let mut check = check();
        let verdicts = check.observe(&of_wall(), &wall(), Some(&map_of_wall()));
        let expected = [Agreement, Agreement, Silence, Silence, Agreement, Agreement];
        assert_eq!(verdicts.rangefinders, expected);
        assert_eq!(verdicts.scanner, Agreement);
        assert_eq!(with_map(100, &of_wall(), &wall(), &map_of_wall()), [0.0; 7]);
        // Nor do objects that are new to the map.
        let verdicts = check.observe(&of_wall(), &wall(), Some(&ExpectedScan::EMPTY));
        assert_eq!(verdicts.rangefinders, [Silence; RANGEFINDERS]);
        assert_eq!(verdicts.scanner, Silence);
    }

    /// By hand: a rangefinder's `x` and `y` are 48, so it explains 96 − 12; the scanner 2 · 48 − 48 − 12 and
    /// leaves 2 · 36, in all less than the two rangefinders' 168 by far more than λ.
    #[test]
    fn the_map_tells_two_liars_from_a_failed_scanner() {
        let mut rangefinders = of_wall();
        (rangefinders[1], rangefinders[4]) = (Reading::NoObject, Reading::NoObject);
        // Only these two see the wall, and the scanner.
        (rangefinders[0], rangefinders[5]) = (
            Reading::Missing(Missing::Timeout),
            Reading::Missing(Missing::Timeout),
        );
        let found = [0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0];
        assert_eq!(with_map(20, &rangefinders, &wall(), &map_of_wall()), found);
        // Without the map the one failure that explains both is preferred.
        let blamed = failures(20, &rangefinders, &wall());
        assert!(blamed[6] > blamed[1], "{blamed:?}");
    }

    #[test]
    fn a_scanner_and_a_rangefinder_gone_blind_are_found() {
        let blind = [Reading::NoObject; BEAMS];
        let mut rangefinders = of_wall();
        rangefinders[0] = Reading::NoObject;
        let found = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        assert_eq!(with_map(20, &rangefinders, &blind, &map_of_wall()), found);
        // Without the map nothing contradicts the rangefinder.
        assert_eq!(failures(20, &rangefinders, &blind)[0], 0.0);
    }

    #[test]
    fn a_scan_is_compared_by_most_of_its_beams() {
        let verdict = |scan: &PerBeam<Reading>| {
            let mut check = check();
            check.observe(&BLIND, scan, Some(&map_of_wall())).scanner
        };
        // All 101 beams see the wall, which is within reach of them all: 2000 / cos 50° + 150 + 194.
        let mut scan = wall();
        assert_eq!(verdict(&scan), Agreement);
        scan[..33].fill(Reading::NoObject);
        assert_eq!(verdict(&scan), Agreement);
        scan[..34].fill(Reading::Echo(mm(3900)));
        assert_eq!(verdict(&scan), Silence);
        scan[..50].fill(Reading::Echo(mm(100)));
        assert_eq!(verdict(&scan), Silence);
        scan[..51].fill(Reading::TooNear);
        assert_eq!(verdict(&scan), Contradiction);
        // Four beams are too few; missing beams do not count.
        let missing = Reading::Missing(Missing::Timeout);
        scan = [missing; BEAMS];
        scan[..4].fill(Reading::NoObject);
        assert_eq!(verdict(&scan), Silence);
        scan[4] = Reading::NoObject;
        assert_eq!(verdict(&scan), Contradiction);
    }

    #[test]
    fn an_edge_in_the_map_contradicts_no_rangefinder() {
        let verdict_of = |rays: [Reading; 11], reading: Reading| {
            let mut expected = ExpectedScan::EMPTY;
            expected.fans[0] = RayFan::new(rays, Millimeters::ZERO);
            let mut rangefinders = BLIND;
            rangefinders[0] = reading;
            let mut check = check();
            check
                .observe(&rangefinders, &[Reading::NoObject; BEAMS], Some(&expected))
                .rangefinders[0]
        };
        let echo = |distance| Reading::Echo(mm(distance));
        let mut rays = [echo(1000); 11];
        assert_eq!(verdict_of(rays, Reading::NoObject), Contradiction);
        // 150 and a sixteenth of 1000 either way.
        assert_eq!(verdict_of(rays, echo(1212)), Agreement);
        assert_eq!(verdict_of(rays, echo(1213)), Contradiction);
        assert_eq!(verdict_of(rays, echo(788)), Agreement);
        assert_eq!(verdict_of(rays, echo(787)), Contradiction);
        assert_eq!(verdict_of(rays, Reading::TooNear), Contradiction);
        // 150 and a sixteenth of 160 reach down to zero.
        assert_eq!(verdict_of([echo(160); 11], Reading::TooNear), Agreement);
        assert_eq!(verdict_of([echo(161); 11], Reading::TooNear), Contradiction);
        assert_eq!(
            verdict_of(rays, Reading::Missing(Missing::Timeout)),
            Silence
        );
        for beside in [Reading::NoObject, echo(1501)] {
            rays[6] = beside;
            assert_eq!(verdict_of(rays, Reading::NoObject), Past);
            assert_eq!(verdict_of(rays, echo(1213)), Past);
            assert_eq!(verdict_of(rays, echo(1212)), Silence);
            assert_eq!(
                verdict_of(rays, Reading::Missing(Missing::Timeout)),
                Silence
            );
        }
        // Nearly out of reach: 3623 + 150 + 226 is within 4000, one more is not.
        assert_eq!(
            verdict_of([echo(3623); 11], Reading::NoObject),
            Contradiction
        );
        assert_eq!(verdict_of([echo(3624); 11], Reading::NoObject), Silence);
    }

    /// A map that is surely free for 2 m in every direction.
    fn map_of_free() -> ExpectedScan {
        ExpectedScan {
            fans: [RayFan::new([Reading::NoObject; 11], mm(2000)); RANGEFINDERS],
            clear: [mm(2000); BEAMS],
            ..ExpectedScan::EMPTY
        }
    }

    /// A wall at 1.5 m where the map is free, seen by one sensor or by two.
    #[test]
    fn an_object_seen_by_one_is_a_phantom_by_two_is_new() {
        let open = [Reading::NoObject; BEAMS];
        let verdict_of = |rangefinders: &PerRangefinder<Reading>, scan: &PerBeam<Reading>| {
            check().observe(rangefinders, scan, Some(&map_of_free()))
        };
        let echo = |distance| Reading::Echo(mm(distance));
        let mut alone = BLIND;
        // 150 and a sixteenth of 1741 before the end of what is free.
        (alone[2], alone[3]) = (echo(1741), echo(1742));
        alone[5] = Reading::TooNear;
        let verdicts = verdict_of(&alone, &open);
        let expected = [Silence, Silence, Phantom, Silence, Silence, Phantom];
        assert_eq!(verdicts.rangefinders, expected);
        assert_eq!(verdicts.scanner, Silence);
        let near_wall = wall().map(|reading| match reading {
            Reading::Echo(distance) => echo(distance.get() / 2),
            other => other,
        });
        assert_eq!(verdict_of(&BLIND, &near_wall).scanner, Contradiction);
        // The same wall by rangefinder 1: 450 + 1000 − 400 ahead, at 15°.
        let mut both = BLIND;
        both[0] = echo((1050.0 / 15_f64.to_radians().cos()) as u32);
        let verdicts = verdict_of(&both, &near_wall);
        assert_eq!(verdicts.pairs[0], Agreement);
        assert_eq!(verdicts.rangefinders[0], Silence);
        assert_eq!(verdicts.scanner, Silence);
    }

    /// Only the map contradicts a rangefinder beside the scanner's field.
    #[test]
    fn a_phantom_beside_the_scanners_field_is_found() {
        let open = [Reading::NoObject; BEAMS];
        let mut stuck = BLIND;
        stuck[2] = Reading::Echo(mm(250));
        let found = with_map(20, &stuck, &open, &map_of_free());
        // A single pair leaves both at one half, as the scanner drew the map.
        assert_eq!(found, [0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.5]);
        // If the scanner agrees with the map the rangefinder has failed.
        let expected = ExpectedScan {
            scan: wall(),
            ..map_of_free()
        };
        let mut stuck = of_wall();
        stuck[2] = Reading::Echo(mm(250));
        let found = with_map(20, &stuck, &wall(), &expected);
        assert_eq!(found, [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(failures(20, &stuck, &wall()), [0.0; 7]);
    }

    /// From 48 by 1 per step.
    #[test]
    fn suspicion_decays_where_the_map_is_empty() {
        let mut check = check();
        for _ in 0..20 {
            check.observe(&BLIND, &[Reading::NoObject; BEAMS], Some(&map_of_wall()));
        }
        assert_eq!(check.failures().scanner, Failure::TOTAL);
        for _ in 0..47 {
            check.observe(
                &BLIND,
                &[Reading::NoObject; BEAMS],
                Some(&ExpectedScan::EMPTY),
            );
        }
        assert_ne!(check.suspicions, Suspicions::NONE);
        check.observe(
            &BLIND,
            &[Reading::NoObject; BEAMS],
            Some(&ExpectedScan::EMPTY),
        );
        assert_eq!(check.suspicions, Suspicions::NONE);
        assert_eq!(check.failures(), Failures::NONE);
    }

    #[test]
    fn weights_that_cannot_find_a_failure_are_refused() {
        let base = config();
        let refused = |config| CrossCheck::try_new(config).unwrap_err();
        for weightless in [
            CrossCheckConfig {
                contradiction: 0,
                ..base
            },
            CrossCheckConfig {
                agreement: 0,
                ..base
            },
            CrossCheckConfig {
                failure_cost: 0,
                ..base
            },
        ] {
            assert_eq!(refused(weightless), CrossCheckConfigError::Weightless);
        }
        let most = |max_suspicion| CrossCheckConfig {
            max_suspicion,
            ..base
        };
        assert_eq!(refused(most(23)), CrossCheckConfigError::NeverCertain);
        assert!(CrossCheck::try_new(most(24)).is_ok());
    }

    #[test]
    fn it_takes_the_memory_that_is_documented() {
        assert_eq!(size_of::<CrossCheck>() - size_of::<CrossCheckConfig>(), 36);
    }

    /// An echo of rangefinder 1 and the five beams around it: `a`like, `p`ast it, or missing (`n`).
    #[test]
    fn two_of_five_beams_confirm_an_echo() {
        let mut rangefinders = BLIND;
        rangefinders[0] = Reading::Echo(mm(1500));
        // 400 + 1500 cos 15° = 1849 and 200 + 1500 sin 15° = 588: from the scanner 1517 away at 22.8°.
        let verdict = |five: &str| {
            let mut scan = [Reading::TooNear; BEAMS];
            for (reading, seen) in scan[71..=75].iter_mut().zip(five.chars()) {
                *reading = match seen {
                    'a' => Reading::Echo(mm(1517)),
                    'p' => Reading::NoObject,
                    _ => Reading::Missing(Missing::Timeout),
                };
            }
            verdicts(&rangefinders, &scan)[0]
        };
        for (five, expected) in [
            ("aapppp", Agreement),
            ("nannan", Agreement),
            ("ppppp", Contradiction),
            ("ppapp", Contradiction),
            ("npapp", Contradiction),
            ("pppnp", Silence),
            ("nnapp", Silence),
            ("nnnnn", Silence),
        ] {
            assert_eq!(verdict(five), expected, "{five}");
        }
    }

    /// At the field's ends there are only three of the five beams.
    #[test]
    fn at_the_fields_ends_left_is_compared_as_right() {
        for distance in (1000..3900).step_by(50) {
            let mut rangefinders = BLIND;
            rangefinders[1] = Reading::Echo(mm(distance));
            let open = [Reading::NoObject; BEAMS];
            let left = verdicts(&rangefinders, &open)[1];
            rangefinders.reverse();
            assert_eq!(verdicts(&rangefinders, &open)[4], left, "{distance}");
        }
    }

    fn reading() -> impl Strategy<Value = Reading> {
        prop_oneof![
            6 => (30_u32..4000).prop_map(|far| Reading::Echo(mm(far))),
            3 => Just(Reading::NoObject),
            1 => Just(Reading::TooNear),
            1 => Just(Reading::Missing(Missing::Timeout)),
        ]
    }

    prop_compose! {
        /// Walls that lean, before a background.
        fn scan()(
            background in reading(),
            walls in prop::collection::vec((0..BEAMS, 1_usize..40, 300_i32..4000, -20_i32..20), 0..5),
        ) -> PerBeam<Reading> {
            let mut scan = [background; BEAMS];
            for (first, width, far, lean) in walls {
                for (reading, step) in scan[first..BEAMS.min(first + width)].iter_mut().zip(0..) {
                    *reading = Reading::Echo(mm((far + lean * step).max(30).unsigned_abs()));
                }
            }
            scan
        }
    }

    prop_compose! {
        fn expectations()(
            rays in prop::array::uniform6(prop::array::uniform11(reading())),
            walls in prop::array::uniform6(prop::option::of(reading())),
            scan in scan(),
            clear in prop::array::uniform7((0_u32..5000).prop_map(mm)),
        ) -> [ExpectedScan; 2] {
            let mut fans = rays;
            for (rays, wall) in fans.iter_mut().zip(walls) {
                if let Some(wall) = wall {
                    rays.fill(wall);
                }
            }
            let [ahead @ .., beams] = clear;
            let mut numbered = fans.into_iter().zip(ahead);
            let fans = [(); RANGEFINDERS].map(|()| numbered.next().unwrap());
            let ours = ExpectedScan {
                fans: fans.map(|(rays, clear)| RayFan::new(rays, clear)),
                scan,
                clear: [beams; BEAMS],
            };
            let mirrored = ExpectedScan {
                fans: reversed(fans).map(|(rays, clear)| RayFan::new(reversed(rays), clear)),
                scan: reversed(scan),
                ..ours
            };
            [ours, mirrored]
        }
    }

    fn reversed<T: Copy, const N: usize>(mut of: [T; N]) -> [T; N] {
        of.reverse();
        of
    }

    proptest! {
        #[test]
        fn mirrored_readings_are_diagnosed_alike(
            steps in prop::collection::vec(
                (prop::array::uniform6(reading()), scan(), 1_usize..6), 1..4,
            ),
            [expected, mirrored] in expectations(),
        ) {
            let (mut ours, mut theirs) = (check(), check());
            for (rangefinders, scan, times) in steps {
                let (opposite, from_left) = (reversed(rangefinders), reversed(scan));
                for _ in 0..times {
                    let verdicts = ours.observe(&rangefinders, &scan, Some(&expected));
                    let mirror = theirs.observe(&opposite, &from_left, Some(&mirrored));
                    prop_assert_eq!(verdicts.pairs, reversed(mirror.pairs));
                    prop_assert_eq!(verdicts.rangefinders, reversed(mirror.rangefinders));
                    prop_assert_eq!(verdicts.scanner, mirror.scanner);
                }
                let (failures, mirror) = (ours.failures(), theirs.failures());
                prop_assert_eq!(failures.rangefinders, reversed(mirror.rangefinders));
                prop_assert_eq!(failures.scanner, mirror.scanner);
                let completed = expected.complete(&rangefinders, &scan, &failures);
                let mirror = mirrored.complete(&opposite, &from_left, &mirror);
                // Of two objects equally near it reports either: an echo at 0 or too near.
                let away = completed.rangefinders.map(distance);
                prop_assert_eq!(away, reversed(mirror.rangefinders.map(distance)));
                prop_assert_eq!(completed.failures.rangefinders, reversed(mirror.failures.rangefinders));
                prop_assert_eq!(completed.failures.scanner, mirror.failures.scanner);
            }
        }
    }
}
