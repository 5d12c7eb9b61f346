//! A generated room through the diagnosis of a sonar ring (\[003\]).
//!
//! The scan, the echoes and their noise are generated in integers, so every machine must compute the same
//! polygon, vectors and verdicts, bit for bit; the digest compares them.

use crate::fusion_run::{InitError, Random};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::Reading;
use certainty_core::units::{BinaryAngle, Direction, Millimeters, Point, Pose};
use certainty_firmware::digest::Digest;
use certainty_ring::{
    Distances, Echoes, Folded, Monitor, NEIGHBOURS, Path, Polygon, PolygonRules, Ring, RingConfig,
    RingRules, Scan, Scanner, TooManyBeams,
};

/// Sonars of the ring.
const SONARS: usize = 24;

/// Beams of both scanners.
const BEAMS: usize = 722;

/// The most elements of the polygon.
pub const ELEMENTS: usize = 64;

/// The sonar whose distances are falsified in the second assessment, as in \[003\] §7.
pub const FALSIFIED: u8 = 4;

/// The result of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Outcome {
    /// FNV-1a of polygon, distances, vectors and verdicts.
    pub digest: u32,
    /// Elements of the polygon.
    pub elements: u32,
    /// The sonars declared faulty in the second assessment: bit n is sonar n + 1.
    pub faulty: u32,
    /// The clock's ticks for the parts of the first assessment.
    pub ticks: Ticks,
}

/// The clock's ticks for the parts of one assessment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Ticks {
    /// From points to a polygon.
    pub polygon: u32,
    /// From the polygon to what each path should give.
    pub simulation: u32,
    /// From echoes to a distance a path.
    pub fold: u32,
    /// From the distances to the vectors and verdicts.
    pub vectors: u32,
}

/// A wall at a constant x or y: its position, and where it starts and ends.
#[derive(Clone, Copy)]
enum Wall {
    AcrossX(i64, i64, i64),
    AcrossY(i64, i64, i64),
}

/// A room of 4.2 m by 3.4 m with a cupboard in a corner and a pillar, in the robot's frame.
const ROOM: [Wall; 12] = [
    Wall::AcrossX(2400, -1500, 1900),
    Wall::AcrossX(-1800, -1500, 1900),
    Wall::AcrossY(1900, -1800, 2400),
    Wall::AcrossY(-1500, -1800, 2400),
    // The cupboard.
    Wall::AcrossX(-900, 1300, 1900),
    Wall::AcrossY(1300, -1800, -900),
    // The pillar.
    Wall::AcrossX(1100, 500, 850),
    Wall::AcrossX(1450, 500, 850),
    Wall::AcrossY(500, 1100, 1450),
    Wall::AcrossY(850, 1100, 1450),
    // A cabinet that hides a part of the room from the right scanner.
    Wall::AcrossX(500, -1500, -1000),
    Wall::AcrossY(-1000, 500, 2400),
];

/// Returns the distance from a point to the nearest wall in a direction, in millimetres.
fn range(from: Point, direction: Direction) -> u32 {
    const FAR: i64 = 8000;
    let (x, y) = (i64::from(from.x_mm()), i64::from(from.y_mm()));
    let (cos, sin) = (i64::from(direction.cos()), i64::from(direction.sin()));
    let hits = ROOM.iter().filter_map(|&wall| {
        let (at, start, end, from, beside, along, across) = match wall {
            Wall::AcrossX(at, start, end) => (at, start, end, x, y, cos, sin),
            Wall::AcrossY(at, start, end) => (at, start, end, y, x, sin, cos),
        };
        let away = (at.wrapping_sub(from) << Direction::FRACTION_BITS).checked_div(along)?;
        let hit = beside.wrapping_add(away.wrapping_mul(across) >> Direction::FRACTION_BITS);
        (away > 0 && away < FAR && hit >= start && hit <= end).then_some(away)
    });
    let nearest = hits.min().unwrap_or(FAR);
    u32::try_from(nearest).unwrap_or(0)
}

/// Adds both scanners' beams, with noise of up to 15 mm.
fn fill(scan: &mut Scan<BEAMS>, random: &mut Random) -> Result<(), InitError> {
    let behind = BinaryAngle::HALF.wrapping_add(BinaryAngle::QUARTER);
    for heading in [BinaryAngle::QUARTER, behind] {
        let mount = Pose::new(Point::ORIGIN, heading);
        let scanner = Scanner::try_new(mount, Millimeters::new(8000)).map_err(|_| InitError)?;
        for beam in 0..361_i32 {
            let millidegrees = beam.wrapping_mul(500).wrapping_sub(90_000);
            let bearing = BinaryAngle::from_millidegrees(millidegrees);
            let direction = heading.wrapping_add(bearing).direction();
            let noise = random.next() % 31;
            let range = range(mount.at, direction).saturating_add(noise);
            let reading = Reading::Echo(Millimeters::new(range.saturating_sub(15)));
            let added: Result<(), TooManyBeams> = scan.add(&scanner, bearing, reading);
            added.map_err(|_| InitError)?;
        }
    }
    Ok(())
}

/// Scans the room and computes its polygon; returns the ticks for the polygon.
///
/// Not inlined, so that the scan is not on the stack afterwards.
#[inline(never)]
fn look(
    polygon: &mut Polygon<ELEMENTS>,
    random: &mut Random,
    clock: &mut impl FnMut() -> u32,
) -> Result<u32, InitError> {
    let mut scan = Scan::new();
    fill(&mut scan, random)?;
    let begin = clock();
    let made = polygon.rebuild(&scan, &PolygonRules::DEFAULT);
    made.map_err(|_| InitError)?;
    Ok(clock().wrapping_sub(begin))
}

/// The distance of two sonars in millimetres, by the places between them: 600 · sin(7.5° · places).
const APART: [u32; NEIGHBOURS as usize + 1] = [0, 78, 155, 230];

/// Returns the expected echoes with noise of up to 20 mm of path; those of the sonar `falsified` are off by
/// 1 m.
fn echoes(
    ring: &Ring<SONARS>,
    expected: &Distances<SONARS>,
    random: &mut Random,
    falsified: Option<SensorId>,
) -> Result<Echoes<SONARS>, InitError> {
    let mut echoes = Echoes::unknown();
    for path in ring.paths() {
        let Folded::Distance(distance) = expected.get(path) else {
            continue;
        };
        let [from, to] = ends(path).ok_or(InitError)?;
        for (transmitter, receiver) in [(from, to), (to, from)] {
            let apart = APART.get(usize::from(path.order())).ok_or(InitError)?;
            let ahead = distance.get().saturating_mul(2);
            let squares = ahead
                .saturating_mul(ahead)
                .saturating_add(apart.saturating_mul(*apart));
            let noise = random.next() % 41;
            let length = squares.isqrt().saturating_add(noise).saturating_sub(20);
            let wrong = falsified.is_some_and(|wrong| wrong == from || wrong == to);
            let length = match (wrong, length > 2500) {
                (false, _) => length,
                (true, true) => length.saturating_sub(1000),
                (true, false) => length.saturating_add(1000),
            };
            let reading = Reading::Echo(Millimeters::new(length));
            echoes
                .set(transmitter, receiver, reading)
                .map_err(|_| InitError)?;
        }
    }
    Ok(echoes)
}

/// Returns a path's two sonars.
fn ends(path: Path) -> Option<[SensorId; 2]> {
    let from = path.from()?;
    let to = from.slot().wrapping_add(path.order().into());
    let to = to.checked_rem(SONARS)?;
    Some([from, SensorId::from_slot(to)?])
}

/// Runs two assessments, the first without a fault and the second with a falsified sonar.
///
/// `clock` counts up at any rate and wraps; it times the parts of the first assessment.
///
/// Memory: the polygon and the scan, then the polygon and what is made of it: below 8 KB of stack.
///
/// # Errors
///
/// [`InitError`], which would be a defect: there is no input.
pub fn run(mut clock: impl FnMut() -> u32) -> Result<Outcome, InitError> {
    let mut random = Random::new(3);
    let mut polygon = Polygon::empty();
    let ticks = look(&mut polygon, &mut random, &mut clock)?;
    let outcome = assess(&polygon, &mut random, &mut clock)?;
    Ok(Outcome {
        ticks: Ticks {
            polygon: ticks,
            ..outcome.ticks
        },
        ..outcome
    })
}

/// Assesses the ring without a fault and with a falsified sonar.
#[inline(never)]
fn assess(
    polygon: &Polygon<ELEMENTS>,
    random: &mut Random,
    clock: &mut impl FnMut() -> u32,
) -> Result<Outcome, InitError> {
    let ring = Ring::try_new(RingConfig::DEFAULT).map_err(|_| InitError)?;
    let rules = RingRules::DEFAULT;
    let mut monitor = Monitor::<SONARS>::new(rules);
    let mut digest = Digest::NEW;

    let begin = clock();
    let expected = Distances::simulated(&ring, polygon);
    let simulated = clock();
    let sound = echoes(&ring, &expected, random, None)?;
    let measured = clock();
    let folded_echoes = Distances::fold(&ring, &sound, &rules);
    let folded = clock();
    let assessment = monitor.assess(&ring, Some(&expected), &folded_echoes);
    let done = clock();
    let ticks = Ticks {
        polygon: 0,
        simulation: simulated.wrapping_sub(begin),
        fold: folded.wrapping_sub(measured),
        vectors: done.wrapping_sub(folded),
    };

    let mut elements = 0_u32;
    for element in polygon.elements() {
        elements = elements.saturating_add(1);
        let normal = element.line().normal();
        digest.word(element.start().x().cast_unsigned());
        digest.word(element.start().y().cast_unsigned());
        digest.word(normal.cos().cast_unsigned());
        digest.word(normal.sin().cast_unsigned());
        digest.word(element.line().distance().get());
        digest.word(u32::from(element.kind() as u8) << 8 | u32::from(element.joint() as u8));
    }
    let wrong = SensorId::try_new(FALSIFIED);
    let falsified = echoes(&ring, &expected, random, wrong)?;
    let falsified = Distances::fold(&ring, &falsified, &rules);
    let second = monitor.assess(&ring, Some(&expected), &falsified);
    for path in ring.paths() {
        for distances in [&expected, &folded_echoes, &falsified] {
            digest.word(match distances.get(path) {
                Folded::Distance(distance) => distance.get(),
                Folded::Inconsistent => u32::MAX,
                Folded::Unknown => u32::MAX - 1,
            });
        }
    }
    let mut faulty = 0_u32;
    for assessment in [&assessment, &second] {
        for vector in [
            assessment.simulation_based(),
            assessment.intersection_based(),
        ] {
            for &confidence in vector {
                digest.word(confidence.into());
            }
        }
        faulty = assessment.faulty().fold(0, |bits, sensor| {
            let place = u32::from(sensor.number()).wrapping_sub(1);
            bits | 1_u32.checked_shl(place).unwrap_or(0)
        });
        digest.word(faulty);
    }
    Ok(Outcome {
        digest: digest.value(),
        elements,
        faulty,
        ticks,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_reproducible_and_finds_the_falsified_sonar() {
        let mut time = 0;
        let mut clock = || {
            time += 10;
            time
        };
        let outcome = run(&mut clock).unwrap();
        assert_eq!(outcome.faulty, 1 << (FALSIFIED - 1));
        // The walls, the cupboard, the cabinet and the pillar, and gaps where one hides another.
        assert!((10..=20).contains(&outcome.elements), "{outcome:?}");
        assert_eq!(outcome.ticks.polygon, 10);
        let again = run(|| 0).unwrap();
        assert_eq!(again.digest, outcome.digest);
        assert_eq!(again.ticks, Ticks::default());
    }
}
