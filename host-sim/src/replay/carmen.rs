//! Logs of the CARMEN robot navigation toolkit.
//!
//! A message a line, its name first. Scans of the front laser (`FLASER`, `ROBOTLASER1`) become
//! beams; the other messages that such logs are known to hold are counted and left alone. The pose
//! used is the laser's as logged, which in a *corrected* log is the corrected one; the raw odometry
//! behind it is not used. Metres, radians, seconds.

use super::RecordedBeam;
use super::load::LoadOptions;
use super::robotlaser;
use super::scan::{Directions, Scan, finite, point_from_metres};
use super::skipped::SkipReason;
use certainty_core::units::Ticks;
use core::f64::consts::{FRAC_PI_2, PI};

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

/// Whether a line was a scan, and if so whether it was older than the scan before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Taken {
    /// Beams were appended.
    Beams { backward: bool },
    /// A message without beams.
    Other,
    /// A comment or nothing.
    Nothing,
}

/// Reads one log, line after line.
#[derive(Debug)]
pub(super) struct CarmenLog {
    options: LoadOptions,
    first_s: Option<f64>,
    last_s: f64,
}

impl CarmenLog {
    pub(super) const fn new(options: LoadOptions) -> Self {
        Self {
            options,
            first_s: None,
            last_s: f64::NEG_INFINITY,
        }
    }

    /// Appends the beams of `line`, if it is a scan.
    pub(super) fn line(
        &mut self,
        line: &str,
        beams: &mut Vec<RecordedBeam>,
    ) -> Result<Taken, SkipReason> {
        match line.split_ascii_whitespace().next() {
            Some("FLASER") => self.take(flaser(line)?, beams),
            Some("ROBOTLASER1") => self.take(robotlaser::parse(line)?, beams),
            None => Ok(Taken::Nothing),
            Some(word) if word.starts_with('#') => Ok(Taken::Nothing),
            Some(word) if is_message(word) => Ok(Taken::Other),
            Some(_) => Err(SkipReason::UnknownMessage),
        }
    }

    fn take<'a>(
        &mut self,
        scan: Scan<impl Iterator<Item = &'a str>>,
        beams: &mut Vec<RecordedBeam>,
    ) -> Result<Taken, SkipReason> {
        let time_s = scan.time_s;
        let first_s = self.first_s.unwrap_or(time_s);
        let at = ticks_since(first_s, time_s)?;
        scan.append(at, self.options.sensors, self.options.max_range, beams)?;
        self.first_s = Some(first_s);
        let backward = time_s < self.last_s;
        self.last_s = time_s;
        Ok(Taken::Beams { backward })
    }
}

/// The instant `time_s` on a clock that starts at `first_s`; before the start it is the start.
///
/// Wraps after 49 days as [`Ticks`] do; a time of which milliseconds cannot be told is refused.
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
    // What is announced is compared with what is there and never used by itself.
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

/// Where the beams of an `FLASER` scan go, which the message leaves open.
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

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_core::transducer::{Missing, Reading};
    use certainty_core::units::{BinaryAngle, Millimeters, Point};
    use core::num::NonZeroU8;

    fn options(sensors: u8) -> LoadOptions {
        LoadOptions {
            max_range: Some(Millimeters::new(8000)),
            sensors: NonZeroU8::new(sensors).unwrap(),
            ..LoadOptions::default()
        }
    }

    /// The beams of `lines`, and what became of each line.
    fn read(lines: &[&str]) -> (Vec<RecordedBeam>, Vec<Result<Taken, SkipReason>>) {
        let mut log = CarmenLog::new(options(3));
        let mut beams = Vec::new();
        let taken = lines
            .iter()
            .map(|line| log.line(line, &mut beams))
            .collect();
        (beams, taken)
    }

    const BEAMS: Result<Taken, SkipReason> = Ok(Taken::Beams { backward: false });

    #[test]
    fn a_scan_becomes_beams_from_the_laser_pose() {
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
    fn an_even_scan_leaves_out_its_last_direction_and_an_odd_one_has_both_ends() {
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
    fn every_cut_of_a_scan_is_skipped_whole() {
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
    fn damage_within_a_scan_skips_all_of_it_with_the_reason() {
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
            assert_eq!(read(&[line]).1, [Ok(Taken::Other)], "{line}");
        }
        for line in ["", "  ", "# FLASER 2 1.0", "#"] {
            assert_eq!(read(&[line]).1, [Ok(Taken::Nothing)], "{line:?}");
        }
    }

    #[test]
    fn a_clock_set_back_is_noticed_and_never_before_the_start() {
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
        let backward = Ok(Taken::Beams { backward: true });
        assert_eq!(taken, [BEAMS, BEAMS, backward, backward, BEAMS]);
    }

    #[test]
    fn a_clock_that_stands_still_is_fine() {
        let (beams, taken) = read(&["FLASER 1 1.0 0 0 0 0 0 0 0 h 0"; 3]);
        assert_eq!(taken, [BEAMS; 3]);
        assert!(beams.iter().all(|beam| beam.at == Ticks::new(0)));
    }

    #[test]
    fn a_newer_scan_keeps_to_the_nearer_of_both_range_limits() {
        let line = "ROBOTLASER1 4 0 3 1 5.0 0 0 3 4.9 5.0 8.0 0 0 0 0 0 0 0 0 0 0 0 0 1 h 1";
        let (beams, taken) = read(&[line]);
        assert_eq!(taken, [BEAMS]);
        let readings: Vec<Reading> = beams.iter().map(|beam| beam.reading).collect();
        let echo = Reading::Echo(Millimeters::new(4900));
        assert_eq!(readings, [echo, Reading::NoObject, Reading::NoObject]);
    }
}
