//! A sensor with faults, which is a sensor again.

use super::defect::{Defect, Fault, Times};
use crate::quantity::Percentage;
use crate::random::{Purpose, stream};
use crate::transducer::{Look, Sensor};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::{Missing, Reading};
use certainty_core::units::{Millimeters, Ticks};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// A sensor, simulated or recorded, with faults.
///
/// - Several faults act one after the other, in the order given.
/// - Noise, bias and scale act on echoes. Beyond the range the result reads *no object*, nearer than it *too
///   near*.
/// - Output noise acts on *no object* too, which counts as the farthest distance.
/// - Stuck and random sensors replace every reading but a missing one, which stays missing.
/// - The sensor inside measures every time, and every fault draws the same random numbers for every
///   reading, active or not. So the healthy twin of a faulty run has the same readings, and one more
///   fault does not change the others.
/// - The readings of a window are those of this sensor, counted from 0.
///
/// Order and cost: one draw of two numbers a fault and a reading.
#[derive(Debug, Clone)]
pub struct Faulty<S> {
    sensor: S,
    faults: Vec<Instance>,
    readings: u64,
    last_was_faulty: bool,
}

/// Readings of the sensor that an intermittent fault lasts, and that the gap after it lasts, on average.
///
/// Both are geometrically distributed: at every reading the fault changes over with the same probability.
/// The length is an open choice: more readings than a sweep has of one obstacle, fewer than a confidence
/// needs to fall.
const MEAN_BURST: f64 = 10.0;

/// One fault of one sensor, with its random numbers.
#[derive(Debug, Clone)]
struct Instance {
    fault: Fault,
    rng: ChaCha8Rng,
    /// Whether an intermittent fault is active; drawn at the first reading.
    on: Option<bool>,
}

impl<S: Sensor> Faulty<S> {
    /// Creates sensor number `number` with `faults`, in the run that `seed` names.
    ///
    /// ```
    /// use certainty_core::sensor::SensorId;
    /// use certainty_core::transducer::Reading;
    /// use certainty_core::units::{BinaryAngle, Millimeters, Point, Ticks};
    /// use certainty_sim::fault::{FaultSpec, Faulty};
    /// use certainty_sim::transducer::{Look, PerfectSensor, Sensor};
    /// use certainty_sim::world::World;
    /// use std::sync::Arc;
    ///
    /// let (near, far) = (Millimeters::new(100), Millimeters::new(800));
    /// let sound = PerfectSensor::new(Arc::new(World::built_in()), near, far);
    /// let spec: FaultSpec = "stuck-near:1=300mm@1".parse()?;
    /// let mut sensor = Faulty::new(sound, SensorId::try_new(1).unwrap(), vec![spec.fault], 7);
    ///
    /// let look = Look { origin: Point::ORIGIN, bearing: BinaryAngle::QUARTER, at: Ticks::new(0) };
    /// assert_eq!(sensor.sense(&look), Reading::Echo(Millimeters::new(550)));
    /// assert_eq!(sensor.sense(&look), Reading::Echo(Millimeters::new(300)));
    /// # Ok::<(), certainty_sim::fault::SpecError>(())
    /// ```
    #[must_use]
    pub fn new(sensor: S, number: SensorId, faults: Vec<Fault>, seed: u64) -> Self {
        let faults = (0..)
            .zip(faults)
            .map(|(place, fault)| Instance {
                fault,
                rng: stream(seed, Purpose::Fault, number.number(), place),
                on: None,
            })
            .collect();
        Self {
            sensor,
            faults,
            readings: 0,
            last_was_faulty: false,
        }
    }

    /// Returns the sensor inside, to set what it measures next.
    pub const fn inner_mut(&mut self) -> &mut S {
        &mut self.sensor
    }

    /// Returns how many readings were taken.
    #[must_use]
    pub const fn readings(&self) -> u64 {
        self.readings
    }

    /// Returns whether a fault was active at the last reading, and so may have changed it.
    ///
    /// Chatter does not count: it repeats readings without changing them.
    #[must_use]
    pub const fn last_was_faulty(&self) -> bool {
        self.last_was_faulty
    }
}

impl<S: Sensor> Sensor for Faulty<S> {
    fn sense(&mut self, look: &Look) -> Reading {
        let mut reading = self.sensor.sense(look);
        let range = self.sensor.range();
        self.last_was_faulty = false;
        for instance in &mut self.faults {
            let (change, chance): (f64, f64) = instance.rng.random();
            instance.step(change);
            if instance.is_active(self.readings, look.at) {
                let defect = instance.fault.defect;
                reading = apply(reading, defect, chance, range);
                self.last_was_faulty |= !matches!(defect, Defect::Chatter(_));
            }
        }
        self.readings += 1;
        reading
    }

    fn range(&self) -> (Millimeters, Millimeters) {
        self.sensor.range()
    }

    /// The sensor's own, times every active chatter, [`Times::MOST`] together; an intermittent one by
    /// its last burst.
    fn reports_per_turn(&self, at: Ticks) -> u32 {
        self.faults
            .iter()
            .filter(|instance| instance.is_active(self.readings, at))
            .fold(
                self.sensor.reports_per_turn(at),
                |reports, instance| match instance.fault.defect {
                    Defect::Chatter(times) => reports.saturating_mul(times.get()).min(Times::MOST),
                    _ => reports,
                },
            )
    }
}

impl Instance {
    /// Starts, continues or ends a burst; `change` is uniform in 0..1.
    fn step(&mut self, change: f64) {
        self.on = Some(match self.on {
            // Bursts and gaps are equally long.
            None => change < 0.5,
            Some(on) => on != (change < 1.0 / MEAN_BURST),
        });
    }

    /// Whether the fault is active at reading number `reading`.
    fn is_active(&self, reading: u64, at: Ticks) -> bool {
        (!self.fault.intermittent || self.on.unwrap_or(false))
            && self.fault.window.contains(reading, at)
    }
}

/// Returns `reading` with the defect; `chance` is uniform in 0..1.
fn apply(
    reading: Reading,
    defect: Defect,
    chance: f64,
    (nearest, farthest): (Millimeters, Millimeters),
) -> Reading {
    let measured = |mm: f64| {
        // Below zero saturates to zero, which is too near.
        let mm = Millimeters::new(mm.round() as u32);
        if mm < nearest {
            Reading::TooNear
        } else if mm > farthest {
            Reading::NoObject
        } else {
            Reading::Echo(mm)
        }
    };
    let moved = |by: &dyn Fn(f64) -> f64| match reading {
        Reading::Echo(distance) => measured(by(f64::from(distance.get()))),
        Reading::NoObject | Reading::TooNear | Reading::Missing(_) => reading,
    };
    let error = |share: Percentage| {
        let amplitude = share.fraction() * f64::from(farthest.get());
        amplitude * (2.0 * chance - 1.0)
    };
    match defect {
        Defect::Dropout(share) if chance < share.fraction() => Reading::Missing(Missing::Timeout),
        Defect::Dropout(_) | Defect::Chatter(_) => reading,
        _ if matches!(reading, Reading::Missing(_)) => reading,
        Defect::StuckFar => Reading::NoObject,
        Defect::StuckNear(distance) => measured(f64::from(distance.get())),
        Defect::Random => {
            let choices = f64::from(farthest.saturating_sub(nearest).get()) + 1.0;
            measured(f64::from(nearest.get()) + (chance * choices).floor())
        }
        Defect::Noise(share) => moved(&|mm| mm + error(share)),
        Defect::OutputNoise(share) => match reading {
            Reading::NoObject => measured(f64::from(farthest.get()) + error(share)),
            _ => moved(&|mm| mm + error(share)),
        },
        Defect::Bias(by) => moved(&|mm| mm + f64::from(by.get())),
        Defect::Scale(factor) => moved(&|mm| mm * factor.get()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fault::FaultSpec;
    use certainty_core::units::{BinaryAngle, Point};
    use core::ops::RangeInclusive;

    const NEAR: Millimeters = Millimeters::new(100);
    const FAR: Millimeters = Millimeters::new(800);

    /// Repeats its readings, and counts the calls.
    #[derive(Debug, Clone)]
    struct Repeating {
        readings: Vec<Reading>,
        calls: usize,
    }

    impl Sensor for Repeating {
        fn sense(&mut self, _: &Look) -> Reading {
            let reading = self.readings[self.calls % self.readings.len()];
            self.calls += 1;
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

    fn faulty(readings: &[Reading], specs: &[&str], seed: u64) -> Faulty<Repeating> {
        let faults = specs
            .iter()
            .map(|text| text.parse::<FaultSpec>().unwrap().fault)
            .collect();
        let inner = Repeating {
            readings: readings.to_vec(),
            calls: 0,
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
    fn without_faults_readings_are_unchanged() {
        assert_eq!(after(&ALL, &[]), ALL);
    }

    #[test]
    fn stuck_far_always_reads_no_object() {
        let none = Reading::NoObject;
        assert_eq!(
            after(&ALL, &["stuck-far:1"]),
            [none, none, none, MISSING, none]
        );
    }

    #[test]
    fn stuck_near_always_reads_its_distance() {
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
    fn bias_moves_echoes_within_the_range() {
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
    fn noise_changes_echoes_only() {
        let others = [Reading::NoObject, Reading::TooNear, MISSING];
        let read = run(&mut faulty(&others, &["noise:1=100%"], 5), 300);
        assert_eq!(read, others.repeat(100));
    }

    #[test]
    fn output_noise_makes_echoes_of_half_of_no_object() {
        let noise = ["output-noise:1=20%"];
        let read = run(&mut faulty(&[Reading::NoObject], &noise, 1), 20_000);
        let (echoes, others): (Vec<_>, Vec<_>) =
            read.into_iter().partition(|r| *r != Reading::NoObject);
        let share = echoes.len() as f64 / 20_000.0;
        assert!((share - 0.5).abs() < 0.015, "{share}");
        assert!(others.iter().all(|r| *r == Reading::NoObject));
        // From 160 mm below the farthest distance up to it, uniformly.
        let echoes = distances(&echoes);
        assert_spans(&echoes, 640.0..=641.0, 799.0..=800.0);
        assert!((mean(&echoes) - 720.0).abs() < 2.0, "{}", mean(&echoes));
    }

    #[test]
    fn output_noise_equals_noise_on_echoes() {
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
    fn output_noise_shifts_no_random_number() {
        let of = |specs: &[&str]| run(&mut faulty(&ALL, specs, 1), 200);
        let noise = of(&["output-noise:1=20%"]);
        assert_eq!(noise, of(&["output-noise:1=20%", "dropout:1=0%"]));
        assert_eq!(noise[100..], of(&["output-noise:1=20%@100"])[100..]);
        assert_eq!(of(&[]), of(&["output-noise:1=20%@200"]));
    }

    #[test]
    fn random_distances_are_uniform() {
        let all = [echo(400), Reading::NoObject, Reading::TooNear];
        let read = distances(&run(&mut faulty(&all, &["random:1"], 1), 20_000));
        assert_spans(&read, 100.0..=101.0, 799.0..=800.0);
        let lower = read.iter().filter(|&&d| d < 450.0).count() as f64 / 20_000.0;
        assert!((lower - 350.0 / 701.0).abs() < 0.015, "{lower}");
    }

    #[test]
    fn dropout_loses_its_part_of_the_readings() {
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
    fn chatter_multiplies_the_reports_only() {
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
    fn a_window_of_readings_is_half_open() {
        let read = run(&mut faulty(&[echo(400)], &["stuck-far:1@2..5"], 1), 8);
        let changed: Vec<_> = (0..8).filter(|&n| read[n] != echo(400)).collect();
        assert_eq!(changed, [2, 3, 4]);
        let read = run(&mut faulty(&[echo(400)], &["stuck-far:1@6"], 1), 8);
        assert_eq!(read.iter().filter(|r| **r == echo(400)).count(), 6);
    }

    #[test]
    fn a_window_of_times_is_half_open() {
        let read = run(
            &mut faulty(&[echo(400)], &["stuck-far:1@200ms..500ms"], 1),
            8,
        );
        let changed: Vec<_> = (0..8).filter(|&n| read[n] != echo(400)).collect();
        assert_eq!(changed, [2, 3, 4]);
    }

    /// Lengths of the runs of faulty (`true`) or sound readings, without the first and the last, which are cut off.
    fn runs(read: &[Reading], faulty_runs: bool) -> Vec<f64> {
        let chunks: Vec<_> = read
            .chunk_by(|a, b| (*a == echo(400)) == (*b == echo(400)))
            .collect();
        chunks[1..chunks.len() - 1]
            .iter()
            .filter(|run| (run[0] != echo(400)) == faulty_runs)
            .map(|run| run.len() as f64)
            .collect()
    }

    fn mean(values: &[f64]) -> f64 {
        values.iter().sum::<f64>() / values.len() as f64
    }

    #[test]
    fn intermittent_faults_come_in_geometric_bursts() {
        let read = run(
            &mut faulty(&[echo(400)], &["intermittent:1=stuck-far"], 1),
            100_000,
        );
        for faulty_runs in [true, false] {
            let lengths = runs(&read, faulty_runs);
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
    fn only_the_seed_changes_random_numbers() {
        let of = |specs: &[&str], seed| run(&mut faulty(&[echo(400)], specs, seed), 200);
        let noise = ["noise:1=20%"];
        assert_eq!(of(&noise, 1), of(&noise, 1));
        assert_ne!(of(&noise, 1), of(&noise, 2));
        // Another fault after it, without an effect here, draws from a stream of its own.
        assert_eq!(of(&noise, 1), of(&["noise:1=20%", "dropout:1=0%"], 1));
        // A window shifts no random number.
        assert_eq!(of(&noise, 1)[100..], of(&["noise:1=20%@100"], 1)[100..]);
    }

    #[test]
    fn the_sensor_inside_measures_once_a_reading() {
        let mut sensor = faulty(&ALL, &["stuck-far:1", "dropout:1=100%", "chatter:1"], 1);
        run(&mut sensor, 37);
        assert_eq!(sensor.sensor.calls, 37);
        assert_eq!(sensor.readings(), 37);
    }

    #[test]
    fn faulty_sensors_in_boxes_are_sensors() {
        let boxed: Box<dyn Sensor + Send> = Box::new(faulty(&[echo(400)], &["bias:1=100mm"], 1));
        let again = vec!["scale:1=0.5".parse::<FaultSpec>().unwrap().fault];
        let mut twice = Faulty::new(boxed, SensorId::try_new(1).unwrap(), again, 1);
        assert!(!twice.last_was_faulty());
        assert_eq!(twice.sense(&look(0)), echo(250));
        assert!(twice.last_was_faulty());
        assert_eq!(twice.range(), (NEAR, FAR));
        assert_eq!(twice.reports_per_turn(Ticks::new(0)), 2);
    }

    #[test]
    fn readings_are_marked_while_a_fault_is_active() {
        let marks = |spec: &str| {
            let mut sensor = faulty(&[echo(400)], &[spec], 1);
            let mut marks = Vec::new();
            for n in 0..4 {
                sensor.sense(&look(n * 100));
                marks.push(sensor.last_was_faulty());
            }
            marks
        };
        assert_eq!(marks("stuck-far:1@1..3"), [false, true, true, false]);
        assert_eq!(marks("chatter:1=4"), [false; 4]);
    }
}
