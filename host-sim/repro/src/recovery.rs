//! A sensor's confidence in and after a fault: \[001\] §6.3, Fig. 7.
//!
//! Three sensors at full confidence; sensor 1 has a noise of 20 % of its range during its first 50
//! readings, of about 200. \[001\] leaves open whose readings these are ([`Count`]), what the noise does
//! where there is no object ([`Noise`]), which sensors these are, and how finely the heads sweep: here in 13
//! directions, as in its Table 2, whose 1560 readings are 13 for each of 3 + 4 + 5 sensors in ten layouts.
//! So the fault and the time after it both last longer than a sweep by either count, and both cover the
//! whole scene.

use crate::statistics::{Spread, Waits, mean};
use certainty_core::health::Confidence;
use certainty_sim::fault::{FaultSpec, SpecError};
use certainty_sim::fusion::{FusionRules, Method};
use certainty_sim::quantity::share;
use certainty_sim::simulation::{
    HeadPlacement, Length, SensorLayout, Setup, SetupError, SweepOverlap,
};
use certainty_sim::transducer::SensorSet;
use certainty_sim::world::World;
use serde::Serialize;
use std::sync::Arc;

/// Readings of a run; "about 200" in \[001\] §6.3.
pub const READINGS: usize = 200;

/// Readings, from the first on, during which sensor 1 is faulty.
pub const FAULTY: usize = 50;

/// The difference between confidences that counts as one: 5 % of the full one.
pub const MARGIN: Confidence = Confidence::from_bits(u16::MAX / 20);

/// The heads of the Smart Car, in 13 directions.
const RIG: SensorLayout = match SensorLayout::try_new(HeadPlacement::Bumper, SweepOverlap::Full, 13)
{
    Ok(rig) => rig,
    Err(_) => panic!("13 directions are not supported"),
};

/// Whose readings are counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Count {
    /// Each sensor's own: 200 rounds in which every sensor reads once, 600 readings of all.
    ///
    /// The text has "*its* first 50 readings", which are sensor 1's; and Fig. 7 draws 50, 30 and 200
    /// readings over one axis, which must be of one kind.
    Each,
    /// Those of all sensors together: the fault affects the 17 of sensor 1 among the first 50.
    All,
}

impl Count {
    /// Both, the default first.
    pub const ALL: [Self; 2] = [Self::Each, Self::All];

    /// Returns the name it has on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Each => "each",
            Self::All => "all",
        }
    }
}

/// The signal that the noise is added to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Noise {
    /// The output signal; *no object* counts as the farthest distance.
    ///
    /// The text has "to the output signal", without an exception for *no object*.
    Output,
    /// Echoes alone; *no object* stays as it is.
    Echo,
}

impl Noise {
    /// Both, the default first.
    pub const ALL: [Self; 2] = [Self::Output, Self::Echo];

    /// Returns the name it has on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Output => "output",
            Self::Echo => "echo",
        }
    }

    /// Returns the fault's kind, as the command line writes it.
    #[must_use]
    pub const fn kind(self) -> &'static str {
        match self {
            Self::Output => "output-noise",
            Self::Echo => "noise",
        }
    }
}

/// The simulation of \[001\] §6.3.
#[derive(Debug, Clone, PartialEq)]
pub struct Recovery {
    /// Whose readings are counted.
    pub count: Count,
    /// The signal that sensor 1's noise is added to.
    pub noise: Noise,
    /// The sensors, at least one; \[001\] has three.
    pub sensors: SensorSet,
    /// The rules of `AddToGrid`.
    pub fusion: FusionRules,
}

impl Recovery {
    /// Returns the fault of sensor 1.
    ///
    /// # Errors
    ///
    /// [`SpecError`] if it cannot be parsed; a test parses every one.
    pub fn fault(&self) -> Result<FaultSpec, SpecError> {
        // A fault's window counts its sensor's own readings.
        let own = match self.count {
            Count::Each => FAULTY,
            Count::All => FAULTY.div_ceil(self.sensors.members().len()),
        };
        format!("{}:1=20%@0..{own}", self.noise.kind()).parse()
    }

    /// Runs the simulation in `world` and records every confidence at every reading that counts.
    ///
    /// # Errors
    ///
    /// [`SetupError`] if there is no sensor 1; a [`SensorSet`] always has one.
    pub fn trace(&self, world: Arc<World>, seed: u64) -> Result<ConfidenceTrace, SetupError> {
        let faults = vec![self.fault()?];
        self.trace_with(faults, world, seed)
    }

    /// Does the same as [`Self::trace`] in the same run without the fault.
    ///
    /// # Errors
    ///
    /// As [`Self::trace`].
    pub fn control(&self, world: Arc<World>, seed: u64) -> Result<ConfidenceTrace, SetupError> {
        self.trace_with(Vec::new(), world, seed)
    }

    fn trace_with(
        &self,
        faults: Vec<FaultSpec>,
        world: Arc<World>,
        seed: u64,
    ) -> Result<ConfidenceTrace, SetupError> {
        let sensors = self.sensors.members().len();
        let length = match self.count {
            Count::Each => Length::Steps(READINGS as u32),
            Count::All => Length::Readings(READINGS as u32),
        };
        let setup = Setup {
            layout: RIG,
            faults,
            fusion: self.fusion,
            ..Setup::smart_car(world, self.sensors.clone(), length, seed)
        };
        let mut confidences = vec![Vec::with_capacity(READINGS); sensors];
        setup.run()?.fuse_watching(Method::Robust, |taken, map| {
            let counts = match self.count {
                Count::Each => taken.beam.sensor.slot() + 1 == sensors,
                Count::All => true,
            };
            if counts {
                for (id, health) in map.health() {
                    confidences[id.slot()].push(health.confidence());
                }
            }
        });
        Ok(ConfidenceTrace {
            confidences,
            faulty: FAULTY,
        })
    }
}

/// Confidences over time; sensor 1 was faulty at first, except in a control run.
///
/// Point *n* is taken after *n* + 1 readings.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ConfidenceTrace {
    confidences: Vec<Vec<Confidence>>,
    faulty: usize,
}

impl ConfidenceTrace {
    /// Returns each sensor's confidences, sensor 1 first.
    #[must_use]
    pub fn confidences(&self) -> &[Vec<Confidence>] {
        &self.confidences
    }

    /// Returns the number of readings from the fault's end until sensor 1 recovered: its confidence was
    /// first at least the mean of the others' less [`MARGIN`].
    ///
    /// Units: readings as [`Count`] counts them. 0 if it was as close when the fault ended, also if it
    /// never fell; a later fall is ignored. `None` if it did not recover before the trace ended, or the
    /// trace ended before the fault.
    #[must_use]
    pub fn recovered_after(&self) -> Option<usize> {
        let mut points = self.faulty.checked_sub(1)?..self.length();
        points.position(|at| {
            let (sum, others) = self
                .others(at)
                .fold((0, 0), |(s, n), other| (s + bits(other), n + 1));
            sum <= others * (bits(self.of_sensor_1(at)) + bits(MARGIN))
        })
    }

    /// Returns the mean of the others less sensor 1's confidence when the fault ended; negative if it was
    /// above them.
    ///
    /// Units: of full confidence, −1 to 1. `None` if the trace ended before the fault.
    #[must_use]
    pub fn below_others(&self) -> Option<f64> {
        let at = self.end_of_fault()?;
        let others: Vec<f64> = self.others(at).map(share).collect();
        Some(mean(&others)? - share(self.of_sensor_1(at)))
    }

    /// Returns whether sensor 1 was more than [`MARGIN`] below *every* other when the fault ended.
    #[must_use]
    pub fn clearly_below(&self) -> bool {
        let below = |at: usize| {
            let limit = bits(self.of_sensor_1(at)) + bits(MARGIN);
            self.others(at).all(|other| bits(other) > limit)
        };
        self.end_of_fault().is_some_and(below)
    }

    /// Returns the lowest confidence of sensor 1 during the fault; of full confidence, 0 to 1.
    #[must_use]
    pub fn lowest_in_fault(&self) -> f64 {
        let during = 0..self.faulty.min(self.length());
        let lowest = during.map(|at| self.of_sensor_1(at)).min();
        lowest.map_or(1.0, share)
    }

    /// Points of the trace.
    fn length(&self) -> usize {
        self.confidences.iter().map(Vec::len).min().unwrap_or(0)
    }

    /// The last point of the fault.
    fn end_of_fault(&self) -> Option<usize> {
        let last = self.faulty.checked_sub(1)?;
        (last < self.length()).then_some(last)
    }

    fn of_sensor_1(&self, at: usize) -> Confidence {
        self.confidences[0][at]
    }

    fn others(&self, at: usize) -> impl Iterator<Item = Confidence> {
        self.confidences[1..].iter().map(move |own| own[at])
    }
}

/// A confidence in steps, for exact sums.
fn bits(confidence: Confidence) -> u32 {
    confidence.to_bits().into()
}

/// Statistics over many runs; its fields are a contract.
///
/// Percentiles are nearest-rank: the smallest value that this percentage of the runs does not exceed. A run
/// that never recovered counts as an infinite value, and an infinite percentile is `None`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct OverSeeds {
    /// Number of runs.
    pub seeds: usize,
    /// Number of runs in which sensor 1 recovered before the end.
    pub recovered: usize,
    /// The median of [`ConfidenceTrace::recovered_after`].
    pub median: Option<u64>,
    /// Its 10th percentile.
    pub p10: Option<u64>,
    /// Its 90th percentile.
    pub p90: Option<u64>,
    /// [`ConfidenceTrace::lowest_in_fault`].
    pub lowest_confidence: Spread,
    /// [`ConfidenceTrace::below_others`].
    pub below_others: Spread,
    /// Share of the runs with [`ConfidenceTrace::clearly_below`].
    pub clearly_below: f64,
    /// The same share of the control runs, which have no fault.
    ///
    /// A sensor can be below the others by its own errors, or by the part of the scene that was
    /// swept last; a fall that occurs here too is no effect of the fault.
    pub clearly_below_without_fault: f64,
    /// The median of the runs with [`ConfidenceTrace::clearly_below`] alone: a sensor that never fell
    /// recovers at once, which measures nothing. `None` also if there are no such runs.
    pub median_of_clearly_below: Option<u64>,
}

impl OverSeeds {
    /// Computes the statistics of `traces` and of their `controls` without the fault.
    #[must_use]
    pub fn of(traces: &[ConfidenceTrace], controls: &[ConfidenceTrace]) -> Self {
        let wait = |trace: &ConfidenceTrace| trace.recovered_after().map(|after| after as u64);
        let all: Waits = traces.iter().map(wait).collect();
        let fell = |trace: &&ConfidenceTrace| trace.clearly_below();
        let part = |count: usize, of: usize| count as f64 / of.max(1) as f64;
        let of_fallen: Waits = traces.iter().filter(fell).map(wait).collect();
        let lowest = traces.iter().map(ConfidenceTrace::lowest_in_fault);
        let below = traces.iter().filter_map(ConfidenceTrace::below_others);
        Self {
            seeds: traces.len(),
            recovered: all.iter().flatten().count(),
            median: all.median(),
            p10: all.percentile(10),
            p90: all.percentile(90),
            lowest_confidence: Spread::of(&lowest.collect::<Vec<_>>()),
            below_others: Spread::of(&below.collect::<Vec<_>>()),
            clearly_below: part(of_fallen.iter().count(), traces.len()),
            clearly_below_without_fault: part(controls.iter().filter(fell).count(), controls.len()),
            median_of_clearly_below: of_fallen.median(),
        }
    }
}

/// One sensor's confidence at every reading over many runs; of full confidence, 0 to 1.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ConfidenceBand {
    /// The mean.
    pub mean: Vec<f64>,
    /// The 10th and the 90th percentile, nearest-rank.
    pub band: Vec<(f64, f64)>,
}

impl ConfidenceBand {
    /// Returns the band of the sensor at `slot`, as long as the shortest of `traces`.
    ///
    /// # Panics
    ///
    /// If a trace has no such sensor.
    #[must_use]
    pub fn of(traces: &[ConfidenceTrace], slot: usize) -> Self {
        let lengths = traces.iter().map(ConfidenceTrace::length);
        let mut band = Self::default();
        for at in 0..lengths.min().unwrap_or(0) {
            let own = traces.iter().map(|trace| trace.confidences()[slot][at]);
            let mut own: Vec<f64> = own.map(share).collect();
            own.sort_by(f64::total_cmp);
            let ranked = |percent: usize| own[(own.len() * percent).div_ceil(100).max(1) - 1];
            band.mean.push(Spread::of(&own).mean);
            band.band.push((ranked(10), ranked(90)));
        }
        band
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sensor 1 as given in percent, the others at `others` percent; the fault lasts four points.
    fn trace(first: &[u16], others: [u16; 2]) -> ConfidenceTrace {
        let percent =
            |percent: u16| Confidence::from_bits((u32::from(percent) * 65535 / 100) as u16);
        let steady = |value: u16| vec![percent(value); first.len()];
        let first = first.iter().map(|&value| percent(value)).collect();
        ConfidenceTrace {
            confidences: vec![first, steady(others[0]), steady(others[1])],
            faulty: 4,
        }
    }

    #[test]
    fn a_sensor_that_never_fell_recovers_at_once() {
        let steady = trace(&[100, 99, 98, 97, 98, 99], [100, 100]);
        assert_eq!(steady.recovered_after(), Some(0));
        assert!(!steady.clearly_below());
    }

    #[test]
    fn recovery_is_counted_from_the_end_of_the_fault() {
        let back = trace(&[90, 80, 70, 60, 70, 80, 95, 100], [90, 100]);
        // 90 would do at the sixth reading, if it were reached: the mean is 95.
        assert_eq!(back.recovered_after(), Some(3));
        assert!(back.clearly_below());
        assert!((back.below_others().unwrap() - 0.35).abs() < 1e-4);
        assert!((back.lowest_in_fault() - 0.60).abs() < 1e-4);
    }

    #[test]
    fn a_return_during_the_fault_does_not_count() {
        let late = trace(&[70, 100, 100, 60, 70, 99], [100, 100]);
        assert_eq!(late.recovered_after(), Some(2));
    }

    #[test]
    fn the_first_return_after_the_fault_counts() {
        let again = trace(&[70, 70, 70, 60, 96, 50, 50, 96], [100, 100]);
        assert_eq!(again.recovered_after(), Some(1));
    }

    #[test]
    fn a_sensor_that_stays_low_never_recovers() {
        let low = trace(&[90, 80, 70, 60, 61, 62, 63], [100, 100]);
        assert_eq!(low.recovered_after(), None);
    }

    #[test]
    fn a_trace_that_ends_before_its_fault_has_no_result() {
        let cut = trace(&[90, 80, 70], [100, 100]);
        assert_eq!(cut.recovered_after(), None);
        assert_eq!(cut.below_others(), None);
        assert!(!cut.clearly_below());
    }

    #[test]
    fn the_margin_is_five_percent_of_full_confidence() {
        let one_step = |bits: u16| ConfidenceTrace {
            confidences: vec![
                vec![Confidence::from_bits(bits)],
                vec![Confidence::from_bits(20_000)],
                vec![Confidence::from_bits(20_000)],
            ],
            faulty: 1,
        };
        let edge = 20_000 - 3276;
        assert_eq!(one_step(edge).recovered_after(), Some(0));
        assert!(!one_step(edge).clearly_below());
        assert_eq!(one_step(edge - 1).recovered_after(), None);
        assert!(one_step(edge - 1).clearly_below());
    }

    #[test]
    fn clearly_below_means_below_both_others() {
        assert!(!trace(&[50, 50, 50, 50], [100, 52]).clearly_below());
        assert!(trace(&[50, 50, 50, 50], [100, 56]).clearly_below());
    }

    #[test]
    fn statistics_are_over_all_runs() {
        let fell = trace(&[90, 80, 70, 60, 99], [100, 100]);
        let never = trace(&[100; 5], [100, 100]);
        let lost = trace(&[90, 80, 70, 60, 60], [100, 100]);
        let sum = OverSeeds::of(&[fell.clone(), never.clone(), never, lost], &[]);
        assert_eq!((sum.seeds, sum.recovered), (4, 3));
        assert_eq!((sum.p10, sum.median, sum.p90), (Some(0), Some(0), None));
        assert!((sum.clearly_below - 0.5).abs() < 1e-12);
        assert_eq!(sum.median_of_clearly_below, Some(1));
        // 0.4, 0, 0, 0.4: mean 0.2, and four squares of 0.2 over three.
        assert!((sum.below_others.mean - 0.2).abs() < 1e-4);
        assert!((sum.below_others.sd - (0.16_f64 / 3.0).sqrt()).abs() < 1e-4);
        assert!((sum.lowest_confidence.mean - 0.8).abs() < 1e-4);
    }

    #[test]
    fn controls_give_the_share_below_without_a_fault() {
        let (low, high) = (trace(&[60; 4], [100; 2]), trace(&[100; 4], [100; 2]));
        let runs = [low.clone(), low.clone(), high.clone()];
        let sum = OverSeeds::of(&runs, &[low, high.clone(), high.clone(), high]);
        assert!((sum.clearly_below - 2.0 / 3.0).abs() < 1e-12);
        assert!((sum.clearly_below_without_fault - 0.25).abs() < 1e-12);
    }

    #[test]
    fn a_band_is_the_mean_and_the_tenths() {
        let runs: Vec<_> = (1..=10).map(|n| trace(&[100, 10 * n], [50; 2])).collect();
        let band = ConfidenceBand::of(&runs, 0);
        assert_eq!((band.mean.len(), band.band.len()), (2, 2));
        assert!((band.mean[1] - 0.55).abs() < 1e-4);
        let (low, high) = band.band[1];
        assert!((low - 0.1).abs() < 1e-4 && (high - 0.9).abs() < 1e-4);
        assert_eq!(band.band[0], (1.0, 1.0));
        assert_eq!(ConfidenceBand::of(&[], 0), ConfidenceBand::default());
    }

    fn recovery(count: Count) -> Recovery {
        Recovery {
            count,
            noise: Noise::Output,
            sensors: SensorSet::default(),
            fusion: FusionRules::default(),
        }
    }

    #[test]
    fn the_fault_is_the_papers_by_count_and_noise() {
        for (count, noise, sensors, spec) in [
            (
                Count::Each,
                Noise::Output,
                "ABC",
                "output-noise:1=20%@0..50",
            ),
            (Count::All, Noise::Output, "CCC", "output-noise:1=20%@0..17"),
            (Count::Each, Noise::Echo, "ABC", "noise:1=20%@0..50"),
            (Count::All, Noise::Echo, "5", "noise:1=20%@0..10"),
        ] {
            let sensors = sensors.parse().unwrap();
            let recovery = Recovery {
                noise,
                sensors,
                ..recovery(count)
            };
            assert_eq!(recovery.fault().unwrap().to_string(), spec);
        }
    }

    /// Readings outside the fault are the same in the control run.
    #[test]
    fn a_control_has_the_same_random_numbers() {
        let world = Arc::new(World::built_in());
        let recovery = recovery(Count::Each);
        let readings = |faults| {
            let world = Arc::clone(&world);
            let setup = Setup {
                layout: RIG,
                faults,
                ..Setup::smart_car(world, SensorSet::default(), Length::Readings(600), 1)
            };
            setup.run().unwrap().readings
        };
        let (run, control) = (readings(vec![recovery.fault().unwrap()]), readings(vec![]));
        assert_eq!(run.len(), control.len());
        let mut differ = 0;
        for (taken, control) in run.iter().zip(&control) {
            assert!(taken.faulty || taken.beam == control.beam);
            differ += usize::from(taken.beam != control.beam);
        }
        assert!((20..=FAULTY).contains(&differ), "{differ}");
        let traces = (
            recovery.trace(Arc::clone(&world), 1).unwrap(),
            recovery.control(Arc::clone(&world), 1).unwrap(),
        );
        assert_ne!(traces.0, traces.1);
    }

    /// By the count of all sensors, the fault affects sensor 1's readings among the first 50 and none later.
    #[test]
    fn the_fault_ends_with_the_fiftieth_reading() {
        for (count, stride) in [(Count::Each, 3), (Count::All, 1)] {
            let recovery = recovery(count);
            let world = Arc::new(World::built_in());
            let length = Length::Readings(600);
            let setup = Setup {
                layout: RIG,
                faults: vec![recovery.fault().unwrap()],
                ..Setup::smart_car(world, SensorSet::default(), length, 1)
            };
            let run = setup.run().unwrap();
            for (place, taken) in run.readings.iter().enumerate() {
                let faulty = taken.beam.sensor.number() == 1 && place / stride < FAULTY;
                assert_eq!(taken.faulty, faulty, "reading {place}");
            }
        }
    }

    #[test]
    fn every_sensor_has_200_points_for_either_count() {
        for count in [Count::Each, Count::All] {
            let trace = recovery(count).trace(Arc::new(World::built_in()), 1);
            let trace = trace.unwrap();
            let lengths: Vec<_> = trace.confidences().iter().map(Vec::len).collect();
            assert_eq!(lengths, [200; 3]);
        }
    }

    /// The first 200 readings of all are the first 67 rounds: both counts have the same run while the fault
    /// lasts in both.
    #[test]
    fn both_counts_have_the_same_run_during_the_fault() {
        let world = Arc::new(World::built_in());
        let each = recovery(Count::Each).trace(Arc::clone(&world), 3).unwrap();
        let all = recovery(Count::All).trace(world, 3).unwrap();
        for round in 0..17 {
            for (sensor, own) in all.confidences().iter().enumerate() {
                assert_eq!(own[3 * round + 2], each.confidences()[sensor][round]);
            }
        }
    }

    #[test]
    fn the_given_rules_are_used() {
        use certainty_core::fusion::{RobustConfig, RobustRules};
        use certainty_core::health::Learning;
        use fixed::types::U0F16;
        let config = RobustConfig {
            learning: Learning {
                lower: U0F16::from_bits(1 << 12),
                ..RobustConfig::DEFAULT.learning
            },
            ..RobustConfig::DEFAULT
        };
        let fusion = FusionRules {
            robust: RobustRules::try_new(config).unwrap(),
            ..FusionRules::default()
        };
        let coarse = Recovery {
            fusion,
            ..recovery(Count::Each)
        };
        let world = Arc::new(World::built_in());
        let coarse = coarse.trace(Arc::clone(&world), 1).unwrap();
        let shipped = recovery(Count::Each).trace(world, 1).unwrap();
        assert!(coarse.lowest_in_fault() < shipped.lowest_in_fault());
    }
}
