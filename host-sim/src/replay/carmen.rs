//! Logs of the CARMEN robot navigation toolkit.
//!
//! A message a line, its name first. Scans of the front laser (`FLASER`, `ROBOTLASER1`) become
//! beams; other known messages are counted and ignored. The pose is the laser's as logged, in a
//! *corrected* log the corrected one; the raw odometry in the same line is not used. Metres, radians,
//! seconds.

use super::recording::RecordedBeam;
use super::recording::{LineKind, SkipReason};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::{Missing, Reading};
use certainty_core::units::{BinaryAngle, Millimeters, Point, Ticks};
use core::f64::consts::{FRAC_PI_2, PI, TAU};
use core::num::NonZeroU8;

/// Messages without a number in their name.
const MESSAGES: [&str; 16] = [
    "FLASER",
    "RLASER",
    "ODOM",
    "PARAM",
    "SYNC",
    "NEFF",
    "TRUEPOS",
    "SONAR",
    "BUMPER",
    "IMU",
    "VECTORMOVE",
    "ROBOTVELOCITY",
    "FOLLOWTRAJECTORY",
    "BASEVELOCITY",
    "NMEAGGA",
    "NMEARMC",
];

/// Messages that end in a laser's number.
const NUMBERED: [&str; 3] = ["RAWLASER", "ROBOTLASER", "LASER"];

/// Whether `word` names a message of a CARMEN log.
pub(super) fn is_message(word: &str) -> bool {
    let stem = word.trim_end_matches(|digit: char| digit.is_ascii_digit());
    MESSAGES.contains(&word) || (stem != word && NUMBERED.contains(&stem))
}

/// Reads one log, line after line.
#[derive(Debug)]
pub(super) struct CarmenLog {
    sensors: NonZeroU8,
    max_range: Option<Millimeters>,
    first_s: Option<f64>,
    last_s: f64,
}

impl CarmenLog {
    /// Deals the beams of a scan to `sensors` virtual sensors; echoes at `max_range` or beyond are no
    /// object.
    pub(super) const fn new(sensors: NonZeroU8, max_range: Option<Millimeters>) -> Self {
        Self {
            sensors,
            max_range,
            first_s: None,
            last_s: f64::NEG_INFINITY,
        }
    }

    /// Appends the beams of `line`, if it is a scan.
    pub(super) fn line(
        &mut self,
        line: &str,
        beams: &mut Vec<RecordedBeam>,
    ) -> Result<LineKind, SkipReason> {
        match line.split_ascii_whitespace().next() {
            Some("FLASER") => self.take(flaser(line)?, beams),
            Some("ROBOTLASER1") => self.take(robotlaser(line)?, beams),
            None => Ok(LineKind::Nothing),
            Some(word) if word.starts_with('#') => Ok(LineKind::Nothing),
            Some(word) if is_message(word) => Ok(LineKind::Other),
            Some(_) => Err(SkipReason::UnknownMessage),
        }
    }

    fn take<'a>(
        &mut self,
        scan: Scan<impl Iterator<Item = &'a str>>,
        beams: &mut Vec<RecordedBeam>,
    ) -> Result<LineKind, SkipReason> {
        let time_s = scan.time_s;
        let first_s = self.first_s.unwrap_or(time_s);
        let at = ticks_since(first_s, time_s)?;
        scan.append(at, self.sensors, self.max_range, beams)?;
        self.first_s = Some(first_s);
        let backward = time_s < self.last_s;
        self.last_s = time_s;
        Ok(LineKind::Beams { backward })
    }
}

/// The instant `time_s` on a clock that starts at `first_s`; before the start it is the start.
///
/// Wraps after 49 days as [`Ticks`] do; a time too large for exact milliseconds is refused.
fn ticks_since(first_s: f64, time_s: f64) -> Result<Ticks, SkipReason> {
    const EXACT: f64 = 9_007_199_254_740_992.0; // 2^53
    let ms = ((time_s - first_s) * 1000.0).round();
    if ms.abs() < EXACT {
        Ok(Ticks::new((ms.max(0.0) as u64 & 0xFFFF_FFFF) as u32))
    } else {
        Err(SkipReason::BadTime)
    }
}

/// Parses `FLASER n r1..rn x y theta odom_x odom_y odom_theta timestamp host logger_timestamp`.
fn flaser(line: &str) -> Result<Scan<impl Iterator<Item = &str>>, SkipReason> {
    const HEAD: usize = 2;
    const TAIL: usize = 9;
    let tokens = line.split_ascii_whitespace();
    let total = tokens.clone().count();
    let readings = total
        .checked_sub(HEAD + TAIL)
        .ok_or(SkipReason::FieldCount)?;
    let announced = tokens.clone().nth(1).and_then(|n| n.parse::<usize>().ok());
    // The announced number is only compared with the number of fields.
    if announced.ok_or(SkipReason::NotANumber)? != readings {
        return Err(SkipReason::FieldCount);
    }
    let mut tail = tokens.clone().skip(HEAD + readings);
    let (x, y) = (
        finite(tail.next(), SkipReason::BadPose)?,
        finite(tail.next(), SkipReason::BadPose)?,
    );
    let heading_rad = finite(tail.next(), SkipReason::BadPose)?;
    let time_s = finite(tail.nth(3), SkipReason::BadTime)?;
    Ok(Scan {
        origin: point_from_metres(x, y)?,
        heading_rad,
        time_s,
        directions: flaser_directions(readings),
        max_range_m: None,
        readings: tokens.skip(HEAD).take(readings),
    })
}

/// The directions of the beams of an `FLASER` scan, which the message does not contain.
///
/// The scan covers the half plane ahead. An even number of beams (180, 360) leaves out the last
/// direction: −90° + i·180°/n. An odd number (181, 361) has beams at both ends:
/// −90° + i·180°/(n − 1). A single beam goes straight ahead.
fn flaser_directions(beams: usize) -> Directions {
    if beams == 1 {
        return Directions {
            start_rad: 0.0,
            step_rad: 0.0,
        };
    }
    let gaps = if beams.is_multiple_of(2) {
        beams
    } else {
        beams - 1
    };
    Directions {
        start_rad: -FRAC_PI_2,
        step_rad: PI / gaps as f64,
    }
}

/// Fields before the readings: name, type, start angle, field of view, resolution, maximum range,
/// accuracy, remission mode, number of readings.
const ROBOTLASER_HEAD: usize = 9;
/// Fields behind the remissions: two poses of three, five of motion and safety, two times and a
/// host.
const ROBOTLASER_TAIL: usize = 14;

/// Parses `ROBOTLASER1 laser_type start_angle field_of_view angular_resolution maximum_range
/// accuracy remission_mode num_readings [readings] num_remissions [remissions] laser_pose_x
/// laser_pose_y laser_pose_theta robot_pose_x robot_pose_y robot_pose_theta laser_tv laser_rv
/// forward_safety_dist side_safety_dist turn_axis timestamp host logger_timestamp`.
///
/// Beam i goes to `start_angle + i · angular_resolution`, from the laser's pose. Metres, radians.
fn robotlaser(line: &str) -> Result<Scan<impl Iterator<Item = &str>>, SkipReason> {
    let tokens = line.split_ascii_whitespace();
    let total = tokens.clone().count();
    let body = total
        .checked_sub(ROBOTLASER_HEAD + 1 + ROBOTLASER_TAIL)
        .ok_or(SkipReason::FieldCount)?;
    let mut head = tokens.clone().skip(2);
    let start_rad = finite(head.next(), SkipReason::BadPose)?;
    let step_rad = finite(head.nth(1), SkipReason::BadPose)?;
    // A range of zero or infinity means that it is not known: then there is no limit.
    let max_range_m: f64 = head
        .next()
        .and_then(|token| token.parse().ok())
        .ok_or(SkipReason::NotANumber)?;
    let readings = count(head.nth(2))?;
    // The body is readings and remissions; its length is checked before it is used.
    let remissions = body.checked_sub(readings).ok_or(SkipReason::FieldCount)?;
    let mut rest = tokens.clone().skip(ROBOTLASER_HEAD + readings);
    if count(rest.next())? != remissions {
        return Err(SkipReason::FieldCount);
    }
    let mut tail = rest.skip(remissions);
    let (x, y) = (
        finite(tail.next(), SkipReason::BadPose)?,
        finite(tail.next(), SkipReason::BadPose)?,
    );
    let heading_rad = finite(tail.next(), SkipReason::BadPose)?;
    let time_s = finite(tail.nth(8), SkipReason::BadTime)?;
    Ok(Scan {
        origin: point_from_metres(x, y)?,
        heading_rad,
        time_s,
        directions: Directions {
            start_rad,
            step_rad,
        },
        max_range_m: (max_range_m.is_finite() && max_range_m > 0.0).then_some(max_range_m),
        readings: tokens.skip(ROBOTLASER_HEAD).take(readings),
    })
}

/// Parses a field that counts others.
fn count(token: Option<&str>) -> Result<usize, SkipReason> {
    let token = token.ok_or(SkipReason::FieldCount)?;
    token.parse().map_err(|_| SkipReason::NotANumber)
}

/// One scan: the laser's pose, and the readings as text.
///
/// Possession proves that pose, time and directions are finite and that the pose is within
/// [`Point::LIMIT`]; the readings are unchecked.
#[derive(Debug, Clone)]
struct Scan<I> {
    origin: Point,
    heading_rad: f64,
    time_s: f64,
    directions: Directions,
    /// The laser's own value for *no echo* and beyond.
    max_range_m: Option<f64>,
    readings: I,
}

/// The directions of a scan's beams relative to the laser's heading: the first, and the step.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Directions {
    start_rad: f64,
    step_rad: f64,
}

impl<'a, I: Iterator<Item = &'a str>> Scan<I> {
    /// Appends the scan's beams, dealt to `sensors` virtual sensors in turn; all or none.
    fn append(
        self,
        at: Ticks,
        sensors: NonZeroU8,
        max_range: Option<Millimeters>,
        beams: &mut Vec<RecordedBeam>,
    ) -> Result<(), SkipReason> {
        let before = beams.len();
        let own_limit_mm = self.max_range_m.map_or(f64::INFINITY, |m| m * 1000.0);
        let limit_mm = max_range.map_or(own_limit_mm, |mm| f64::from(mm.get()).min(own_limit_mm));
        for (index, token) in self.readings.enumerate() {
            let Ok(metres) = token.parse::<f64>() else {
                beams.truncate(before);
                return Err(SkipReason::NotANumber);
            };
            let aside = self
                .directions
                .step_rad
                .mul_add(index as f64, self.directions.start_rad);
            // Below 255, so the slot exists.
            let slot = index % usize::from(sensors.get());
            let Some(sensor) = SensorId::from_slot(slot) else {
                continue;
            };
            beams.push(RecordedBeam {
                at,
                sensor,
                origin: self.origin,
                bearing: angle_from_radians(self.heading_rad + aside),
                reading: reading_from_metres(metres, limit_mm),
            });
        }
        if beams.len() == before {
            return Err(SkipReason::NoReadings);
        }
        Ok(())
    }
}

/// The reading of a laser's number in metres; `limit_mm` and more is *no object*.
///
/// Rounds to the nearest millimetre. A number that is negative, not finite, or below the limit but
/// beyond twice [`Point::LIMIT`], is implausible; one that rounds to 0 is too near.
fn reading_from_metres(metres: f64, limit_mm: f64) -> Reading {
    let mm = metres * 1000.0;
    if !metres.is_finite() || mm < 0.0 {
        Reading::Missing(Missing::Implausible)
    } else if mm >= limit_mm {
        Reading::NoObject
    } else if mm > 2.0 * f64::from(Point::LIMIT) {
        Reading::Missing(Missing::Implausible)
    } else if mm < 0.5 {
        Reading::TooNear
    } else {
        Reading::Echo(Millimeters::new(mm.round() as u32))
    }
}

/// The angle of `radians`, any finite number of turns; rounds to the nearest step, ties up.
fn angle_from_radians(radians: f64) -> BinaryAngle {
    let steps = (radians.rem_euclid(TAU) / TAU * 65536.0 + 0.5).floor();
    // At most 65536, which is the full turn and wraps to zero.
    BinaryAngle::from_bits((steps as u32 & 0xFFFF) as u16)
}

/// The place at (`x_m`, `y_m`), to the nearest millimetre, if it is within [`Point::LIMIT`].
fn point_from_metres(x_m: f64, y_m: f64) -> Result<Point, SkipReason> {
    if !(x_m.is_finite() && y_m.is_finite()) {
        return Err(SkipReason::BadPose);
    }
    let (x, y) = ((x_m * 1000.0).round(), (y_m * 1000.0).round());
    let limit = f64::from(Point::LIMIT);
    if x.abs() > limit || y.abs() > limit {
        return Err(SkipReason::OutOfReach);
    }
    Ok(Point::from_mm(x as i32, y as i32))
}

/// Parses a field that must be a finite number.
fn finite(token: Option<&str>, otherwise: SkipReason) -> Result<f64, SkipReason> {
    let number: f64 = token
        .ok_or(SkipReason::FieldCount)?
        .parse()
        .map_err(|_| SkipReason::NotANumber)?;
    if number.is_finite() {
        Ok(number)
    } else {
        Err(otherwise)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The beams of `lines`, and the result of each line.
    fn read(lines: &[&str]) -> (Vec<RecordedBeam>, Vec<Result<LineKind, SkipReason>>) {
        let mut log = CarmenLog::new(NonZeroU8::new(3).unwrap(), Some(Millimeters::new(8000)));
        let mut beams = Vec::new();
        let taken = lines
            .iter()
            .map(|line| log.line(line, &mut beams))
            .collect();
        (beams, taken)
    }

    const BEAMS: Result<LineKind, SkipReason> = Ok(LineKind::Beams { backward: false });

    #[test]
    fn flaser_scan_becomes_beams() {
        let line = "FLASER 5 1.5 8.0 nan 0 -1 2.0 -1.0 1.570796327 7 7 7 100.25 host 0.1";
        let (beams, taken) = read(&[line]);
        assert_eq!(taken, [BEAMS]);
        let readings: Vec<Reading> = beams.iter().map(|beam| beam.reading).collect();
        let implausible = Reading::Missing(Missing::Implausible);
        assert_eq!(
            readings,
            [
                Reading::Echo(Millimeters::new(1500)),
                Reading::NoObject,
                implausible,
                Reading::TooNear,
                implausible,
            ]
        );
        let bearings: Vec<u16> = beams.iter().map(|beam| beam.bearing.to_bits()).collect();
        assert_eq!(bearings, [0, 0x2000, 0x4000, 0x6000, 0x8000]);
        let sensors: Vec<u8> = beams.iter().map(|beam| beam.sensor.number()).collect();
        assert_eq!(sensors, [1, 2, 3, 1, 2]);
        assert!(
            beams
                .iter()
                .all(|beam| beam.origin == Point::from_mm(2000, -1000))
        );
        assert!(beams.iter().all(|beam| beam.at == Ticks::new(0)));
    }

    #[test]
    fn flaser_directions_depend_on_parity() {
        let last = |n: usize| {
            let directions = flaser_directions(n);
            (directions.start_rad + (n - 1) as f64 * directions.step_rad).to_degrees()
        };
        for (beams, degrees) in [
            (180, 89.0),
            (360, 89.5),
            (181, 90.0),
            (361, 90.0),
            (3, 90.0),
        ] {
            assert!(
                (last(beams) - degrees).abs() < 1e-9,
                "{beams}: {}",
                last(beams)
            );
            assert_eq!(flaser_directions(beams).start_rad, -FRAC_PI_2);
        }
        let single = read(&["FLASER 1 1.0 0 0 0 0 0 0 0 h 0"]).0;
        assert_eq!(single[0].bearing, BinaryAngle::ZERO);
    }

    #[test]
    fn every_cut_of_a_scan_is_skipped() {
        let line = "FLASER 3 1.0 2.0 3.0 0 0 0 0 0 0 5 host 5";
        let tokens: Vec<&str> = line.split_ascii_whitespace().collect();
        for end in 1..tokens.len() {
            let (beams, taken) = read(&[&tokens[..end].join(" ")]);
            assert_eq!(taken, [Err(SkipReason::FieldCount)]);
            assert!(beams.is_empty());
        }
        let (_, taken) = read(&["FLASER 1000000000 1.0 2.0 3.0 0 0 0 0 0 0 5 host 5"]);
        assert_eq!(taken, [Err(SkipReason::FieldCount)]);
    }

    #[test]
    fn damaged_scan_is_skipped_with_the_reason() {
        for (line, reason) in [
            (
                "FLASER 2 1.0 x 0 0 0 0 0 0 5 host 5",
                SkipReason::NotANumber,
            ),
            (
                "FLASER two 1.0 2 0 0 0 0 0 0 5 host 5",
                SkipReason::NotANumber,
            ),
            ("FLASER 2 1.0 2 nan 0 0 0 0 0 5 host 5", SkipReason::BadPose),
            ("FLASER 2 1.0 2 0 0 inf 0 0 0 5 host 5", SkipReason::BadPose),
            (
                "FLASER 2 1.0 2 0 3e5 0 0 0 0 5 host 5",
                SkipReason::OutOfReach,
            ),
            ("FLASER 2 1.0 2 0 0 0 0 0 0 nan host 5", SkipReason::BadTime),
            ("FLASER 0 0 0 0 0 0 0 5 host 5", SkipReason::NoReadings),
            ("FLASHER 2", SkipReason::UnknownMessage),
        ] {
            let (beams, taken) = read(&[line]);
            assert_eq!(taken, [Err(reason)], "{line}");
            assert!(beams.is_empty(), "{line}");
        }
    }

    #[test]
    fn other_messages_are_not_errors() {
        for line in [
            "ODOM 0 0 0 0 0 0 0.1 h 0.1",
            "PARAM robot_frontlaser_offset 0.0 nohost 0",
            "NEFF 3",
            "SYNC x",
            "TRUEPOS 1 2 3",
            "RLASER 2 1.0",
            "RAWLASER1 0",
            "ROBOTLASER2 0",
        ] {
            assert_eq!(read(&[line]).1, [Ok(LineKind::Other)], "{line}");
        }
        for line in ["", "  ", "# FLASER 2 1.0", "#"] {
            assert_eq!(read(&[line]).1, [Ok(LineKind::Nothing)], "{line:?}");
        }
    }

    #[test]
    fn clock_steps_back_never_before_the_start() {
        let scan = |time: &str| format!("FLASER 1 1.0 0 0 0 0 0 0 {time} h 0");
        let lines = [
            "976052890.5",
            "976052891.0",
            "976052890.9",
            "976052880.0",
            "976052892.0",
        ];
        let lines = lines.map(scan);
        let (beams, taken) = read(&lines.each_ref().map(String::as_str));
        let at: Vec<u32> = beams.iter().map(|beam| beam.at.get()).collect();
        assert_eq!(at, [0, 500, 400, 0, 1500]);
        let backward = Ok(LineKind::Beams { backward: true });
        assert_eq!(taken, [BEAMS, BEAMS, backward, backward, BEAMS]);
    }

    #[test]
    fn equal_times_are_accepted() {
        let (beams, taken) = read(&["FLASER 1 1.0 0 0 0 0 0 0 0 h 0"; 3]);
        assert_eq!(taken, [BEAMS; 3]);
        assert!(beams.iter().all(|beam| beam.at == Ticks::new(0)));
    }

    #[test]
    fn robotlaser_uses_the_nearer_range_limit() {
        let line = "ROBOTLASER1 4 0 3 1 5.0 0 0 3 4.9 5.0 8.0 0 0 0 0 0 0 0 0 0 0 0 0 1 h 1";
        let (beams, taken) = read(&[line]);
        assert_eq!(taken, [BEAMS]);
        let readings: Vec<Reading> = beams.iter().map(|beam| beam.reading).collect();
        let echo = Reading::Echo(Millimeters::new(4900));
        assert_eq!(readings, [echo, Reading::NoObject, Reading::NoObject]);
    }

    const ROBOTLASER: &str = "ROBOTLASER1 4 -1.5 3.0 1.5 20.0 0.01 1 3 1.0 20.0 3.0 2 100 200 \
                        0.5 -0.25 0.125 9 9 9 0.1 0.2 0.3 0.4 1e6 12.5 robot 0.7";

    #[test]
    fn robotlaser_fields_are_read() {
        let scan = robotlaser(ROBOTLASER).unwrap();
        assert_eq!(scan.origin, Point::from_mm(500, -250));
        assert_eq!(scan.heading_rad, 0.125);
        assert_eq!(scan.time_s, 12.5);
        let expected = Directions {
            start_rad: -1.5,
            step_rad: 1.5,
        };
        assert_eq!(scan.directions, expected);
        assert_eq!(scan.max_range_m, Some(20.0));
        assert_eq!(scan.readings.collect::<Vec<_>>(), ["1.0", "20.0", "3.0"]);
    }

    #[test]
    fn remissions_are_optional() {
        let line = ROBOTLASER.replace(" 2 100 200 ", " 0 ");
        assert_eq!(robotlaser(&line).unwrap().origin, Point::from_mm(500, -250));
    }

    #[test]
    fn every_cut_of_a_robotlaser_is_refused() {
        let tokens: Vec<&str> = ROBOTLASER.split_ascii_whitespace().collect();
        for end in 1..tokens.len() {
            let cut = tokens[..end].join(" ");
            assert_eq!(
                robotlaser(&cut).err(),
                Some(SkipReason::FieldCount),
                "{cut}"
            );
        }
    }

    #[test]
    fn announced_billion_is_refused() {
        for (from, to) in [
            (" 1 3 1.0", " 1 1000000000 1.0"),
            (" 2 100", " 18446744073709551615 100"),
        ] {
            let line = ROBOTLASER.replace(from, to);
            assert_ne!(line, ROBOTLASER);
            assert_eq!(robotlaser(&line).err(), Some(SkipReason::FieldCount));
        }
    }

    #[test]
    fn reading_at_the_limit_is_no_object() {
        assert_eq!(reading_from_metres(8.0, 8000.0), Reading::NoObject);
        assert_eq!(reading_from_metres(81.83, 8000.0), Reading::NoObject);
        assert_eq!(
            reading_from_metres(7.9994, 8000.0),
            Reading::Echo(Millimeters::new(7999))
        );
    }

    #[test]
    fn impossible_numbers_are_implausible() {
        let implausible = Reading::Missing(Missing::Implausible);
        for metres in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -0.001, -5.0] {
            assert_eq!(reading_from_metres(metres, 8000.0), implausible, "{metres}");
        }
        assert_eq!(reading_from_metres(1e300, f64::INFINITY), implausible);
        assert_eq!(reading_from_metres(1e300, 8000.0), Reading::NoObject);
    }

    #[test]
    fn zero_of_either_sign_is_too_near() {
        for metres in [0.0, -0.0, 0.0004] {
            assert_eq!(reading_from_metres(metres, 8000.0), Reading::TooNear);
        }
    }

    #[test]
    fn radians_round_to_nearest_step() {
        for steps in (0..=u16::MAX).step_by(7) {
            let radians = f64::from(steps) / 65536.0 * TAU;
            for turns in [-3.0, 0.0, 1.0, 1000.0] {
                let angle = angle_from_radians(turns * TAU + radians);
                assert_eq!(angle, BinaryAngle::from_bits(steps), "{steps} {turns}");
            }
        }
        assert_eq!(angle_from_radians(-1e-9), BinaryAngle::ZERO);
        // Any finite angle is accepted.
        let _ = angle_from_radians(f64::MAX);
        let _ = angle_from_radians(f64::MIN);
    }
}
