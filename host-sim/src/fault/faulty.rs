//! A sensor with faults is a sensor.

use super::{Defect, Fault, Times};
use crate::quantity::Percentage;
use crate::transducer::stream::{Purpose, stream};
use crate::transducer::{Look, Sensor};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::{Missing, Reading};
use certainty_core::units::{Millimeters, Ticks};
use core::fmt;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// A sensor, simulated or recorded, that some faults have befallen.
///
/// - Several faults act one after the other, in the order given.
/// - Noise, bias and scale act on echoes. What they move beyond the range reads *no object*, nearer
///   than it *too near*; what says no distance has none to be wrong.
/// - Output noise acts on *no object* too, which counts as the farthest distance.
/// - Stuck and random sensors say what they say whatever is there, as long as they answer: a
///   missing reading stays missing, since no fault here makes a sensor answer.
/// - The sensor inside is asked every time, and every fault draws the same number of times for
///   every reading, active or not. So the healthy twin of a faulty run sees the same readings, and
///   a fault more changes nothing for the others.
/// - The readings of a window are those of this sensor, counted from 0 over its life.
///
/// Order and cost: one draw of two numbers a fault and a reading.
#[derive(Debug, Clone)]
pub struct Faulty<S> {
    sensor: S,
    faults: Vec<Instance>,
    readings: u64,
    spoilt: bool,
    bursts: Bursts,
}

/// How long an intermittent fault is there and how long it is gone, in readings of the sensor.
///
/// Possession proves that both are at least one reading. Lengths are geometrically distributed: at
/// every reading the fault changes over with the same probability.
///
/// The defaults, 10 on average each, are an open choice: longer than one sweep's glimpse of an
/// obstacle, shorter than a confidence takes to fall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bursts {
    mean_on: f64,
    mean_off: f64,
}

/// Why burst lengths were refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BurstsError;

impl fmt::Display for BurstsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("bursts and the gaps between them must last a reading or more on average")
    }
}

impl core::error::Error for BurstsError {}

impl Default for Bursts {
    fn default() -> Self {
        Self {
            mean_on: 10.0,
            mean_off: 10.0,
        }
    }
}

impl Bursts {
    /// Creates bursts of `mean_on` readings with gaps of `mean_off` readings, on average.
    ///
    /// # Errors
    ///
    /// [`BurstsError`] for less than one reading, and for what is no finite number.
    pub fn try_new(mean_on: f64, mean_off: f64) -> Result<Self, BurstsError> {
        let lasts = |mean: f64| mean.is_finite() && mean >= 1.0;
        if lasts(mean_on) && lasts(mean_off) {
            Ok(Self { mean_on, mean_off })
        } else {
            Err(BurstsError)
        }
    }

    /// The part of the time a fault is there.
    fn share(self) -> f64 {
        self.mean_on / (self.mean_on + self.mean_off)
    }

    /// The probability that a burst, or a gap, ends with this reading.
    fn ends(self, on: bool) -> f64 {
        1.0 / if on { self.mean_on } else { self.mean_off }
    }
}

/// One fault of one sensor, with its own whims.
#[derive(Debug, Clone)]
struct Instance {
    fault: Fault,
    rng: ChaCha8Rng,
    /// Whether a burst is on; the first is drawn at the first reading.
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
            spoilt: false,
            bursts: Bursts::default(),
        }
    }

    /// Returns the sensor with other bursts of its intermittent faults; they start anew.
    #[must_use]
    pub fn with_bursts(mut self, bursts: Bursts) -> Self {
        self.bursts = bursts;
        for instance in &mut self.faults {
            instance.on = None;
        }
        self
    }

    /// Returns the sensor inside.
    #[must_use]
    pub const fn inner(&self) -> &S {
        &self.sensor
    }

    /// Returns the sensor inside, to be told what it measures next.
    pub const fn inner_mut(&mut self) -> &mut S {
        &mut self.sensor
    }

    /// Returns how many readings were taken.
    #[must_use]
    pub const fn readings(&self) -> u64 {
        self.readings
    }

    /// Tells whether a fault spoiled, or may have spoiled, the last reading.
    ///
    /// Chatter does not: it repeats what is measured.
    #[must_use]
    pub const fn spoilt_last(&self) -> bool {
        self.spoilt
    }
}

impl<S: Sensor> Sensor for Faulty<S> {
    fn sense(&mut self, look: &Look) -> Reading {
        let mut reading = self.sensor.sense(look);
        let range = self.sensor.range();
        self.spoilt = false;
        for instance in &mut self.faults {
            let (change, chance): (f64, f64) = instance.rng.random();
            instance.step(change, self.bursts);
            if instance.is_active(self.readings, look.at) {
                let defect = instance.fault.defect;
                reading = spoilt(reading, defect, chance, range);
                self.spoilt |= !matches!(defect, Defect::Chatter(_));
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
    /// Starts, goes on with or ends a burst.
    fn step(&mut self, change: f64, bursts: Bursts) {
        self.on = Some(match self.on {
            None => change < bursts.share(),
            Some(on) => on != (change < bursts.ends(on)),
        });
    }

    /// Whether the fault spoils reading number `reading`.
    fn is_active(&self, reading: u64, at: Ticks) -> bool {
        (!self.fault.intermittent || self.on.unwrap_or(false))
            && self.fault.window.contains(reading, at)
    }
}

/// What becomes of `reading`; `chance` is uniform in 0..1.
fn spoilt(
    reading: Reading,
    defect: Defect,
    chance: f64,
    (nearest, farthest): (Millimeters, Millimeters),
) -> Reading {
    let told = |mm: f64| {
        // Below zero saturates to zero, which is too near.
        let distance = Millimeters::new(mm.round() as u32);
        if distance < nearest {
            Reading::TooNear
        } else if distance > farthest {
            Reading::NoObject
        } else {
            Reading::Echo(distance)
        }
    };
    let moved = |by: &dyn Fn(f64) -> f64| match reading {
        Reading::Echo(distance) => told(by(f64::from(distance.get()))),
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
        Defect::StuckNear(distance) => told(f64::from(distance.get())),
        Defect::Random => {
            let choices = f64::from(farthest.saturating_sub(nearest).get()) + 1.0;
            told(f64::from(nearest.get()) + (chance * choices).floor())
        }
        Defect::Noise(share) => moved(&|mm| mm + error(share)),
        Defect::OutputNoise(share) => match reading {
            Reading::NoObject => told(f64::from(farthest.get()) + error(share)),
            _ => moved(&|mm| mm + error(share)),
        },
        Defect::Bias(by) => moved(&|mm| mm + f64::from(by.get())),
        Defect::Scale(factor) => moved(&|mm| mm * factor.get()),
    }
}

#[cfg(test)]
mod tests;
