//! Claims about sensors with faults.

use super::*;
use crate::fault::FaultSpec;
use certainty_core::units::{BinaryAngle, Point};
use core::ops::RangeInclusive;

const NEAR: Millimeters = Millimeters::new(100);
const FAR: Millimeters = Millimeters::new(800);

/// Says what it was told, over and over, and counts how often it was asked.
#[derive(Debug, Clone)]
struct Recited {
    readings: Vec<Reading>,
    asked: usize,
}

impl Sensor for Recited {
    fn sense(&mut self, _: &Look) -> Reading {
        let reading = self.readings[self.asked % self.readings.len()];
        self.asked += 1;
        reading
    }

    fn range(&self) -> (Millimeters, Millimeters) {
        (NEAR, FAR)
    }

    fn reports_per_turn(&self, _: Ticks) -> u32 {
        2
    }
}

const fn echo(mm: u32) -> Reading {
    Reading::Echo(Millimeters::new(mm))
}

const MISSING: Reading = Reading::Missing(Missing::Bus);

const fn look(ms: u32) -> Look {
    Look {
        origin: Point::ORIGIN,
        bearing: BinaryAngle::ZERO,
        at: Ticks::new(ms),
    }
}

fn faulty(readings: &[Reading], specs: &[&str], seed: u64) -> Faulty<Recited> {
    let faults = specs
        .iter()
        .map(|text| text.parse::<FaultSpec>().unwrap().fault)
        .collect();
    let inner = Recited {
        readings: readings.to_vec(),
        asked: 0,
    };
    Faulty::new(inner, SensorId::try_new(1).unwrap(), faults, seed)
}

/// `count` readings, a tenth of a second apart.
fn run(sensor: &mut impl Sensor, count: u32) -> Vec<Reading> {
    (0..count).map(|n| sensor.sense(&look(n * 100))).collect()
}

fn after(readings: &[Reading], specs: &[&str]) -> Vec<Reading> {
    run(&mut faulty(readings, specs, 5), readings.len() as u32)
}

fn distances(readings: &[Reading]) -> Vec<f64> {
    readings
        .iter()
        .map(|reading| match reading {
            Reading::Echo(distance) => f64::from(distance.get()),
            other => panic!("{other:?} is no echo"),
        })
        .collect()
}

fn assert_spans(values: &[f64], low: RangeInclusive<f64>, high: RangeInclusive<f64>) {
    let least = values.iter().copied().fold(f64::MAX, f64::min);
    let most = values.iter().copied().fold(f64::MIN, f64::max);
    assert!(
        low.contains(&least) && high.contains(&most),
        "{least} to {most}"
    );
}

const ALL: [Reading; 5] = [
    echo(400),
    Reading::NoObject,
    Reading::TooNear,
    MISSING,
    echo(800),
];

#[test]
fn a_sensor_without_faults_is_as_it_was() {
    assert_eq!(after(&ALL, &[]), ALL);
}

#[test]
fn stuck_far_says_no_object_whatever_is_there() {
    let none = Reading::NoObject;
    assert_eq!(
        after(&ALL, &["stuck-far:1"]),
        [none, none, none, MISSING, none]
    );
}

#[test]
fn stuck_near_says_its_distance_whatever_is_there() {
    let stuck = echo(300);
    assert_eq!(
        after(&ALL, &["stuck-near:1=300mm"]),
        [stuck, stuck, stuck, MISSING, stuck]
    );
    assert_eq!(
        after(&[echo(400)], &["stuck-near:1=5cm"]),
        [Reading::TooNear]
    );
}

#[test]
fn bias_moves_echoes_and_the_ends_of_the_range_hold() {
    assert_eq!(
        after(&ALL, &["bias:1=200mm"]),
        [
            echo(600),
            Reading::NoObject,
            Reading::TooNear,
            MISSING,
            Reading::NoObject
        ]
    );
    assert_eq!(
        after(
            &[echo(400), echo(300), echo(299), echo(100)],
            &["bias:1=-200mm"]
        ),
        [echo(200), echo(100), Reading::TooNear, Reading::TooNear]
    );
}

#[test]
fn scale_multiplies_echoes() {
    assert_eq!(
        after(&ALL, &["scale:1=0.6"]),
        [
            echo(240),
            Reading::NoObject,
            Reading::TooNear,
            MISSING,
            echo(480)
        ]
    );
    assert_eq!(after(&[echo(400)], &["scale:1=0"]), [Reading::TooNear]);
}

#[test]
fn noise_is_uniform_within_its_part_of_the_range() {
    let read = distances(&run(&mut faulty(&[echo(450)], &["noise:1=20%"], 1), 20_000));
    assert_spans(&read, 290.0..=291.0, 609.0..=610.0);
    let mean = read.iter().sum::<f64>() / 20_000.0;
    let variance = read.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / 20_000.0;
    assert!((mean - 450.0).abs() < 3.0, "{mean}");
    // A uniform error of ±160 mm has a standard deviation of 160/√3.
    assert!((variance.sqrt() / (160.0 / 3.0_f64.sqrt()) - 1.0).abs() < 0.02);
}

#[test]
fn noise_leaves_alone_what_says_no_distance() {
    let silent = [Reading::NoObject, Reading::TooNear, MISSING];
    let read = run(&mut faulty(&silent, &["noise:1=100%"], 5), 300);
    assert_eq!(read, silent.repeat(100));
}

#[test]
fn output_noise_makes_echoes_of_half_of_no_object() {
    let noise = ["output-noise:1=20%"];
    let read = run(&mut faulty(&[Reading::NoObject], &noise, 1), 20_000);
    let (echoes, silent): (Vec<_>, Vec<_>) =
        read.into_iter().partition(|r| *r != Reading::NoObject);
    let share = echoes.len() as f64 / 20_000.0;
    assert!((share - 0.5).abs() < 0.015, "{share}");
    assert!(silent.iter().all(|r| *r == Reading::NoObject));
    // From 160 mm below the farthest distance up to it, uniformly.
    let echoes = distances(&echoes);
    assert_spans(&echoes, 640.0..=641.0, 799.0..=800.0);
    assert!((mean(&echoes) - 720.0).abs() < 2.0, "{}", mean(&echoes));
}

#[test]
fn output_noise_errs_on_echoes_as_noise_does_and_leaves_other_readings() {
    let of = |readings: &[Reading], spec| run(&mut faulty(readings, &[spec], 5), 200);
    let echoes = [echo(400), echo(800), echo(100)];
    assert_eq!(
        of(&echoes, "output-noise:1=20%"),
        of(&echoes, "noise:1=20%")
    );
    let others = [Reading::TooNear, MISSING];
    assert_eq!(of(&others, "output-noise:1=100%"), others.repeat(100));
}

#[test]
fn output_noise_shifts_no_draw() {
    let of = |specs: &[&str]| run(&mut faulty(&ALL, specs, 1), 200);
    let noise = of(&["output-noise:1=20%"]);
    assert_eq!(noise, of(&["output-noise:1=20%", "dropout:1=0%"]));
    assert_eq!(noise[100..], of(&["output-noise:1=20%@100"])[100..]);
    assert_eq!(of(&[]), of(&["output-noise:1=20%@200"]));
}

#[test]
fn random_says_every_distance_of_the_range_equally_often() {
    let all = [echo(400), Reading::NoObject, Reading::TooNear];
    let read = distances(&run(&mut faulty(&all, &["random:1"], 1), 20_000));
    assert_spans(&read, 100.0..=101.0, 799.0..=800.0);
    let lower = read.iter().filter(|&&d| d < 450.0).count() as f64 / 20_000.0;
    assert!((lower - 350.0 / 701.0).abs() < 0.015, "{lower}");
}

#[test]
fn dropout_is_silent_as_often_as_it_says() {
    let read = run(&mut faulty(&[echo(400)], &["dropout:1=30%"], 1), 20_000);
    let lost = read
        .iter()
        .filter(|r| **r == Reading::Missing(Missing::Timeout))
        .count();
    let share = lost as f64 / 20_000.0;
    assert!((share - 0.3).abs() < 0.013, "{share}");
    assert_eq!(
        read.iter().filter(|r| **r == echo(400)).count(),
        20_000 - lost
    );
    for (text, expected) in [
        ("dropout:1=100%", Reading::Missing(Missing::Timeout)),
        ("dropout:1=0%", echo(400)),
    ] {
        let read = run(&mut faulty(&[echo(400)], &[text], 1), 1000);
        assert!(read.iter().all(|r| *r == expected), "{text}");
    }
}

#[test]
fn chatter_multiplies_the_reports_and_leaves_the_readings() {
    let mut sensor = faulty(&ALL, &["chatter:1=4@2..4"], 1);
    let mut reports = Vec::new();
    for reading in ALL {
        reports.push(sensor.reports_per_turn(Ticks::new(0)));
        assert_eq!(sensor.sense(&look(0)), reading);
    }
    assert_eq!(reports, [2, 2, 8, 8, 2]);
    let all_day = faulty(&ALL, &["chatter:1=1000"; 5], 1);
    assert_eq!(all_day.reports_per_turn(Ticks::new(0)), Times::MOST);
}

#[test]
fn faults_act_in_the_order_given() {
    assert_eq!(
        after(&[echo(400)], &["bias:1=100mm", "scale:1=0.5"]),
        [echo(250)]
    );
    assert_eq!(
        after(&[echo(400)], &["scale:1=0.5", "bias:1=100mm"]),
        [echo(300)]
    );
}

#[test]
fn a_window_of_readings_is_half_open_and_counts_the_sensors_own() {
    let read = run(&mut faulty(&[echo(400)], &["stuck-far:1@2..5"], 1), 8);
    let spoilt: Vec<_> = (0..8).filter(|&n| read[n] != echo(400)).collect();
    assert_eq!(spoilt, [2, 3, 4]);
    let read = run(&mut faulty(&[echo(400)], &["stuck-far:1@6"], 1), 8);
    assert_eq!(read.iter().filter(|r| **r == echo(400)).count(), 6);
}

#[test]
fn a_window_of_times_is_half_open() {
    let read = run(
        &mut faulty(&[echo(400)], &["stuck-far:1@200ms..500ms"], 1),
        8,
    );
    let spoilt: Vec<_> = (0..8).filter(|&n| read[n] != echo(400)).collect();
    assert_eq!(spoilt, [2, 3, 4]);
}

/// Lengths of the runs of spoilt (`true`) or sound readings, the cut-off first and last left out.
fn runs(read: &[Reading], spoilt: bool) -> Vec<f64> {
    let chunks: Vec<_> = read
        .chunk_by(|a, b| (*a == echo(400)) == (*b == echo(400)))
        .collect();
    chunks[1..chunks.len() - 1]
        .iter()
        .filter(|run| (run[0] != echo(400)) == spoilt)
        .map(|run| run.len() as f64)
        .collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[test]
fn an_intermittent_fault_comes_and_goes_in_geometric_bursts() {
    let read = run(
        &mut faulty(&[echo(400)], &["intermittent:1=stuck-far"], 1),
        100_000,
    );
    for spoilt in [true, false] {
        let lengths = runs(&read, spoilt);
        assert!((mean(&lengths) - 10.0).abs() < 0.6, "{}", mean(&lengths));
        // One in ten lasts a single reading; 0.9^20 = 12 % more than twenty.
        let share = |wanted: fn(&f64) -> bool| {
            lengths.iter().filter(|l| wanted(l)).count() as f64 / lengths.len() as f64
        };
        assert!((share(|l| *l < 1.5) - 0.100).abs() < 0.02);
        assert!((share(|l| *l > 20.5) - 0.122).abs() < 0.02);
    }
}

#[test]
fn bursts_last_as_long_as_they_are_told() {
    let mut sensor = faulty(&[echo(400)], &["intermittent:1=stuck-far"], 1)
        .with_bursts(Bursts::try_new(3.0, 30.0).unwrap());
    let read = run(&mut sensor, 100_000);
    assert!((mean(&runs(&read, true)) - 3.0).abs() < 0.2);
    assert!((mean(&runs(&read, false)) - 30.0).abs() < 2.5);
    assert_eq!(Bursts::try_new(0.5, 3.0), Err(BurstsError));
    assert_eq!(Bursts::try_new(3.0, f64::INFINITY), Err(BurstsError));
}

#[test]
fn the_seed_decides_and_nothing_else() {
    let of = |specs: &[&str], seed| run(&mut faulty(&[echo(400)], specs, seed), 200);
    let noise = ["noise:1=20%"];
    assert_eq!(of(&noise, 1), of(&noise, 1));
    assert_ne!(of(&noise, 1), of(&noise, 2));
    // Another fault after it, which does nothing here, draws from a stream of its own.
    assert_eq!(of(&noise, 1), of(&["noise:1=20%", "dropout:1=0%"], 1));
    // A window hides readings and shifts none.
    assert_eq!(of(&noise, 1)[100..], of(&["noise:1=20%@100"], 1)[100..]);
}

#[test]
fn the_sensor_inside_is_asked_once_a_reading_whatever_is_wrong() {
    let mut sensor = faulty(&ALL, &["stuck-far:1", "dropout:1=100%", "chatter:1"], 1);
    run(&mut sensor, 37);
    assert_eq!(sensor.inner().asked, 37);
    assert_eq!(sensor.readings(), 37);
}

#[test]
fn faulty_sensors_in_boxes_are_sensors() {
    let boxed: Box<dyn Sensor + Send> = Box::new(faulty(&[echo(400)], &["bias:1=100mm"], 1));
    let again = vec!["scale:1=0.5".parse::<FaultSpec>().unwrap().fault];
    let mut twice = Faulty::new(boxed, SensorId::try_new(1).unwrap(), again, 1);
    assert!(!twice.spoilt_last());
    assert_eq!(twice.sense(&look(0)), echo(250));
    assert!(twice.spoilt_last());
    assert_eq!(twice.range(), (NEAR, FAR));
    assert_eq!(twice.reports_per_turn(Ticks::new(0)), 2);
}

#[test]
fn a_reading_is_spoilt_while_a_fault_is_active_and_by_chatter_never() {
    let spoils = |spec: &str| {
        let mut sensor = faulty(&[echo(400)], &[spec], 1);
        let mut told = Vec::new();
        for n in 0..4 {
            sensor.sense(&look(n * 100));
            told.push(sensor.spoilt_last());
        }
        told
    };
    assert_eq!(spoils("stuck-far:1@1..3"), [false, true, true, false]);
    assert_eq!(spoils("chatter:1=4"), [false; 4]);
}
