//! How many faulty sonars are found, over many places and every kind of fault.

use certainty_core::sensor::SensorId;
use certainty_core::units::{BinaryAngle, Point, Pose};
use certainty_ring::{Distances, Folded, TooManyElements};
use certainty_sim::ring::SONARS;
use certainty_sim::ring::{RingDefect, RingFault};
use certainty_sim::ring::{Situation, Vectors};
use certainty_sim::transducer::stream::{Purpose, stream};
use certainty_sim::world::World;
use rand::RngExt;
use rayon::prelude::*;
use serde::Serialize;
use thiserror::Error;

/// Many places in a world, each with every fault.
#[derive(Debug, Clone, Copy)]
pub struct Sweep<'a> {
    /// The world, the ring and the lasers.
    pub situation: &'a Situation<'a>,
    /// The fault of the main result; the rows have all kinds.
    pub defect: RingDefect,
    /// How many places.
    pub poses: u32,
    /// Names the run.
    pub seed: u64,
}

/// Why there is no sweep; displays as one line.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum SweepError {
    /// No place far enough from every obstacle.
    #[error(
        "the world '{0}' has no room for a robot of 0.4 m about its middle: make it larger or move \
         obstacles apart"
    )]
    NoRoom(String),
    /// A polygon that does not fit.
    #[error("at {x_mm}mm, {y_mm}mm: {source}: use a world with fewer obstacles")]
    TooManyElements {
        /// Where.
        x_mm: i32,
        /// Where.
        y_mm: i32,
        /// What the core says.
        source: TooManyElements,
    },
}

/// One place: without a fault, and with one faulty sonar.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PoseResult {
    /// Where: x, in millimetres.
    pub x_mm: i32,
    /// Where: y, in millimetres.
    pub y_mm: i32,
    /// Which way the robot looks, in degrees.
    pub heading_deg: f64,
    /// The faulty sonar.
    pub sensor: u8,
    /// Whether it was found.
    pub found: bool,
    /// The vectors without the fault.
    pub without_fault: Vectors,
    /// The vectors with it.
    pub with_fault: Vectors,
}

/// One kind of fault, of one or two sonars at once, over all places.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct KindRow {
    /// What is wrong.
    pub kind: &'static str,
    /// How many sonars have it at once.
    pub faulty_sensors: u8,
    /// How many faults there were in all.
    pub faults: u32,
    /// How many of them changed no distance of their sonar by the paper's 0.1 m: nobody could tell.
    pub without_effect: u32,
    /// How many were found.
    pub found: u32,
    /// Found of all.
    pub detection_rate: f64,
    /// Found of those with an effect.
    pub detection_rate_with_effect: f64,
    /// How many sound sonars were declared faulty.
    pub false_alarms: u32,
    /// Of all sound sonars.
    pub false_alarm_rate: f64,
}

/// How far the middle of the robot stays from obstacles, in millimetres: the ring, and 0.1 m.
const CLEARANCE: f64 = 400.0;

/// One place with everything tried there.
struct Tried {
    result: PoseResult,
    /// Sound sonars declared faulty where there is no fault.
    false_alarms: u32,
    rows: Vec<Counts>,
}

#[derive(Debug, Clone, Copy, Default)]
struct Counts {
    faults: u32,
    without_effect: u32,
    found: u32,
    false_alarms: u32,
}

/// What came out.
#[derive(Debug, Clone, PartialEq)]
pub struct Swept {
    /// Each place.
    pub poses: Vec<PoseResult>,
    /// How many sound sonars were declared faulty, all places without a fault together.
    pub false_alarms: u32,
    /// Kind after kind, one sonar faulty and two.
    pub rows: Vec<KindRow>,
}

impl Sweep<'_> {
    /// Runs the sweep, in parallel where rayon has threads; the result is the same with any number.
    ///
    /// # Errors
    ///
    /// [`SweepError`] says what is wrong with the world.
    pub fn run(&self) -> Result<Swept, SweepError> {
        let poses = self.places()?;
        let tried: Result<Vec<Tried>, SweepError> = (0..self.poses)
            .into_par_iter()
            .zip(&poses)
            .map(|(part, &pose)| self.at(pose, part))
            .collect();
        let tried = tried?;
        let sound = |faulty: u32| (SONARS as u32 - faulty) * self.poses;
        let cases = cases();
        let rows = cases.iter().enumerate().map(|(number, &(defect, faulty))| {
            let counts = tried.iter().map(|tried| tried.rows[number]);
            let sum = counts.fold(Counts::default(), |sum, one| Counts {
                faults: sum.faults + one.faults,
                without_effect: sum.without_effect + one.without_effect,
                found: sum.found + one.found,
                false_alarms: sum.false_alarms + one.false_alarms,
            });
            let rate = |part: u32, of: u32| f64::from(part) / f64::from(of.max(1));
            KindRow {
                kind: defect.kind(),
                faulty_sensors: faulty as u8,
                faults: sum.faults,
                without_effect: sum.without_effect,
                found: sum.found,
                detection_rate: rate(sum.found, sum.faults),
                detection_rate_with_effect: rate(sum.found, sum.faults - sum.without_effect),
                false_alarms: sum.false_alarms,
                false_alarm_rate: rate(sum.false_alarms, sound(faulty as u32)),
            }
        });
        Ok(Swept {
            rows: rows.collect(),
            false_alarms: tried.iter().map(|tried| tried.false_alarms).sum(),
            poses: tried.into_iter().map(|tried| tried.result).collect(),
        })
    }

    /// The places, at random where the robot fits.
    pub(super) fn places(&self) -> Result<Vec<Pose>, SweepError> {
        const TRIES: u32 = 10_000;
        let world = self.situation.world();
        let no_room = || SweepError::NoRoom(world.name().to_owned());
        let bounds = world.bounds().ok_or_else(no_room)?;
        let mut dice = stream(self.seed, Purpose::Choice, 0, 0);
        let (low, high) = (bounds.lower_left, bounds.upper_right);
        let mut places = Vec::new();
        for _ in 0..self.poses {
            let mut tries = (0..TRIES).map(|_| {
                let x = dice.random_range(low.x_mm()..=high.x_mm());
                let y = dice.random_range(low.y_mm()..=high.y_mm());
                let heading = BinaryAngle::from_bits(dice.random());
                Pose::new(Point::from_mm(x, y), heading)
            });
            let place = tries.find(|pose| fits(world, pose.at));
            places.push(place.ok_or_else(no_room)?);
        }
        Ok(places)
    }

    fn at(&self, pose: Pose, part: u32) -> Result<Tried, SweepError> {
        let situation = self.situation;
        let full = |source| SweepError::TooManyElements {
            x_mm: pose.at.x_mm(),
            y_mm: pose.at.y_mm(),
            source,
        };
        let observed = situation
            .observe(pose, &[], self.seed, part)
            .map_err(full)?;
        let sound = situation.judge(&observed);
        let sensors = self.pair(part);
        let spoilt = |defect: RingDefect, faulty: usize| {
            let faults: Vec<RingFault> = sensors[..faulty]
                .iter()
                .map(|&sensor| RingFault { sensor, defect })
                .collect();
            let mut observed = observed.clone();
            observed.echoes = situation.echoes(pose, &faults, self.seed, part);
            situation.judge(&observed)
        };
        let rows = cases().into_iter().map(|(defect, faulty)| {
            let judged = spoilt(defect, faulty);
            let mut counts = Counts::default();
            for sensor in situation.ring.sensors() {
                let declared = judged.assessment.faulty().any(|found| found == sensor);
                if sensors[..faulty].contains(&sensor) {
                    counts.faults += 1;
                    counts.found += u32::from(declared);
                    let effect = differs(situation, sensor, &sound.heard, &judged.heard);
                    counts.without_effect += u32::from(!effect);
                } else {
                    counts.false_alarms += u32::from(declared);
                }
            }
            counts
        });
        let rows = rows.collect();
        let judged = spoilt(self.defect, 1);
        Ok(Tried {
            result: PoseResult {
                x_mm: pose.at.x_mm(),
                y_mm: pose.at.y_mm(),
                heading_deg: f64::from(pose.heading.to_bits()) * 360.0 / 65536.0,
                sensor: sensors[0].number(),
                found: judged.assessment.faulty().any(|found| found == sensors[0]),
                without_fault: Vectors::of(&sound),
                with_fault: Vectors::of(&judged),
            },
            false_alarms: sound.assessment.faulty().count() as u32,
            rows,
        })
    }

    /// Two sonars, drawn for each place.
    fn pair(&self, part: u32) -> [SensorId; 2] {
        let mut dice = stream(self.seed, Purpose::Choice, 1, part);
        let first = dice.random_range(0..SONARS);
        let second = (first + dice.random_range(1..SONARS)) % SONARS;
        [first, second].map(|slot| SensorId::from_slot(slot).expect("a slot of 24 has a number"))
    }
}

/// Every kind of fault, of one sonar and of two.
fn cases() -> Vec<(RingDefect, usize)> {
    let kinds = RingDefect::ALL.into_iter();
    kinds
        .flat_map(|defect| [(defect, 1), (defect, 2)])
        .collect()
}

/// Whether the robot fits.
fn fits(world: &World, at: Point) -> bool {
    world
        .obstacles()
        .iter()
        .all(|obstacle| obstacle.clearance(at) >= CLEARANCE)
}

/// Whether a fault made a difference to any path of `sensor`.
fn differs(
    situation: &Situation<'_>,
    sensor: SensorId,
    before: &Distances<SONARS>,
    after: &Distances<SONARS>,
) -> bool {
    let limit = situation.rules.config().uncertainty.get();
    let paths = situation.ring.paths().filter(|path| {
        let from = path.from().map(SensorId::slot);
        let to = from.map(|from| (from + usize::from(path.order())) % SONARS);
        from == Some(sensor.slot()) || to == Some(sensor.slot())
    });
    paths
        .into_iter()
        .any(|path| match (before.get(path), after.get(path)) {
            (Folded::Distance(a), Folded::Distance(b)) => a.get().abs_diff(b.get()) >= limit,
            (a, b) => a != b,
        })
}
