use super::over_seeds::percentile;
use super::*;

/// Sensor 1 as given in percent, the others at `others` percent; the fault lasts four points.
fn trace(first: &[u16], others: [u16; 2]) -> ConfidenceTrace {
    let percent = |percent: u16| Confidence::from_bits((u32::from(percent) * 65535 / 100) as u16);
    let steady = |value: u16| vec![percent(value); first.len()];
    let first = first.iter().map(|&value| percent(value)).collect();
    ConfidenceTrace {
        confidences: vec![first, steady(others[0]), steady(others[1])],
        faulty: 4,
    }
}

#[test]
fn a_sensor_that_never_fell_is_back_at_once() {
    let steady = trace(&[100, 99, 98, 97, 98, 99], [100, 100]);
    assert_eq!(steady.recovered_after(), Some(0));
    assert!(!steady.clearly_below());
}

#[test]
fn a_sensor_that_comes_back_is_counted_from_the_end_of_the_fault() {
    let back = trace(&[90, 80, 70, 60, 70, 80, 95, 100], [90, 100]);
    // 90 would do at the sixth reading, if it were reached: the mean is 95.
    assert_eq!(back.recovered_after(), Some(3));
    assert!(back.clearly_below());
    assert!((back.below_others().unwrap() - 0.35).abs() < 1e-4);
    assert!((back.lowest_in_fault() - 0.60).abs() < 1e-4);
}

#[test]
fn what_was_back_during_the_fault_does_not_count() {
    let late = trace(&[70, 100, 100, 60, 70, 99], [100, 100]);
    assert_eq!(late.recovered_after(), Some(2));
}

#[test]
fn the_first_return_counts_though_it_falls_again() {
    let again = trace(&[70, 70, 70, 60, 96, 50, 50, 96], [100, 100]);
    assert_eq!(again.recovered_after(), Some(1));
}

#[test]
fn a_sensor_that_stays_low_never_recovers() {
    let low = trace(&[90, 80, 70, 60, 61, 62, 63], [100, 100]);
    assert_eq!(low.recovered_after(), None);
}

#[test]
fn a_trace_that_ends_before_its_fault_tells_nothing() {
    let cut = trace(&[90, 80, 70], [100, 100]);
    assert_eq!(cut.recovered_after(), None);
    assert_eq!(cut.below_others(), None);
    assert!(!cut.clearly_below());
}

#[test]
fn the_margin_is_five_percent_of_full_confidence_not_of_the_others() {
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
fn percentiles_are_nearest_rank_and_what_never_came_is_last() {
    let values: Vec<_> = (1..=9).rev().map(Some).chain([None]).collect();
    assert_eq!(percentile(&values, 10), Some(1));
    assert_eq!(percentile(&values, 50), Some(5));
    assert_eq!(percentile(&values, 90), Some(9));
    assert_eq!(percentile(&values, 91), None);
    assert_eq!(percentile(&[], 50), None);
}

#[test]
fn runs_are_summed_up() {
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
fn twins_say_how_often_a_sensor_is_below_without_a_fault() {
    let (low, high) = (trace(&[60; 4], [100; 2]), trace(&[100; 4], [100; 2]));
    let runs = [low.clone(), low.clone(), high.clone()];
    let sum = OverSeeds::of(&runs, &[low, high.clone(), high.clone(), high]);
    assert!((sum.clearly_below - 2.0 / 3.0).abs() < 1e-12);
    assert!((sum.clearly_below_without_fault - 0.25).abs() < 1e-12);
}

#[test]
fn a_course_is_the_mean_and_the_tenths() {
    let runs: Vec<_> = (1..=10).map(|n| trace(&[100, 10 * n], [50; 2])).collect();
    let course = Course::of(&runs, 0);
    assert_eq!((course.mean.len(), course.band.len()), (2, 2));
    assert!((course.mean[1] - 0.55).abs() < 1e-4);
    let (low, high) = course.band[1];
    assert!((low - 0.1).abs() < 1e-4 && (high - 0.9).abs() < 1e-4);
    assert_eq!(course.band[0], (1.0, 1.0));
    assert_eq!(Course::of(&[], 0), Course::default());
}

#[test]
fn a_single_run_has_no_spread() {
    let one = Spread::of(&[0.7]);
    assert_eq!((one.mean, one.sd), (0.7, 0.0));
}

fn recovery(count: Count) -> Recovery {
    Recovery {
        count,
        noise: Noise::Output,
        crew: SensorSet::default(),
        fusion: FusionRules::default(),
    }
}

#[test]
fn the_fault_is_the_papers_for_either_count_and_noise() {
    for (count, noise, crew, spec) in [
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
        let crew = crew.parse().unwrap();
        let recovery = Recovery {
            noise,
            crew,
            ..recovery(count)
        };
        assert_eq!(recovery.fault().unwrap().to_string(), spec);
    }
}

/// What the fault did not spoil reads the same in the twin.
#[test]
fn a_twin_has_the_same_draws() {
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
    let (run, twin) = (readings(vec![recovery.fault().unwrap()]), readings(vec![]));
    assert_eq!(run.len(), twin.len());
    let mut differ = 0;
    for (taken, twin) in run.iter().zip(&twin) {
        assert!(taken.faulty || taken.beam == twin.beam);
        differ += usize::from(taken.beam != twin.beam);
    }
    assert!((20..=FAULTY).contains(&differ), "{differ}");
    let traces = (
        recovery.trace(Arc::clone(&world), 1).unwrap(),
        recovery.twin(Arc::clone(&world), 1).unwrap(),
    );
    assert_ne!(traces.0, traces.1);
}

/// Counted over all sensors, the fault spoils sensor 1's readings among the first 50, and no later.
#[test]
fn the_fault_ends_with_the_fiftieth_reading_for_either_count() {
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

/// The first 200 readings of all are the first 67 rounds: the counts draw the same run, as long as
/// the fault lasts in both.
#[test]
fn the_counts_draw_the_same_run_while_both_are_faulty() {
    let world = Arc::new(World::built_in());
    let each = recovery(Count::Each).trace(Arc::clone(&world), 3).unwrap();
    let all = recovery(Count::All).trace(world, 3).unwrap();
    for round in 0..17 {
        for (sensor, own) in all.confidences().iter().enumerate() {
            assert_eq!(own[3 * round + 2], each.confidences()[sensor][round]);
        }
    }
}

/// The rules given are the rules used.
#[test]
fn other_rules_draw_another_figure() {
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

#[test]
fn what_is_open_is_read_back() {
    for count in [Count::Each, Count::All] {
        assert_eq!(count.name().parse(), Ok(count));
    }
    for noise in [Noise::Output, Noise::Echo] {
        assert_eq!(noise.name().parse(), Ok(noise));
    }
}
