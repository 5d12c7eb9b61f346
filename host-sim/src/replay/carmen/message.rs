//! The messages of a CARMEN log: their names and their fields.
//!
//! The fields behind a scan's readings are numbers, then the host's name, then the logger's time. The
//! name may have any number of words and the time behind it may be missing, since neither is used; the
//! numbers before them must be exactly as many as the message has. So a line that lost or gained a field
//! is refused, and no reading moves to another beam.

use super::super::recording::SkipReason;
use super::directions::Header;
use core::fmt;

/// Messages without a number in their name that have no readings.
const OTHERS: [&str; 20] = [
    "SYNC",
    "NEFF",
    "TRUEPOS",
    "BUMPER",
    "IMU",
    "VECTORMOVE",
    "ROBOTVELOCITY",
    "FOLLOWTRAJECTORY",
    "BASEVELOCITY",
    "NMEAGGA",
    "NMEARMC",
    "COMMENT",
    "GLOBALPOS",
    "SCANMARK",
    "POSITIONLASER",
    "ARM",
    "REMISSIONFLASER",
    "REMISSIONRLASER",
    "REMISSIONLASER3",
    "REMISSIONLASER4",
];

/// The name of a message, as far as it matters here.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Name {
    /// A scan with readings.
    Scan(ScanName),
    /// `ODOM`: the robot's pose by its wheels.
    Odometry,
    /// `PARAM`: a setting of the robot.
    Parameter,
    /// Any other message.
    Other,
}

/// The name of a message with readings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum ScanName {
    /// `FLASER`: the front laser with a pose.
    Front,
    /// `RLASER`: the rear laser with a pose.
    Rear,
    /// `ROBOTLASERn`: a laser with a pose, and its description.
    Robot(u8),
    /// `RAWLASERn`: a laser without a pose, and its description.
    Raw(u8),
    /// `LASERn`: a laser without a pose, of older versions; 0 without a number.
    Old(u8),
    /// `SONAR`: a ring of sonars.
    Sonar,
}

impl fmt::Display for ScanName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Front => f.write_str("FLASER"),
            Self::Rear => f.write_str("RLASER"),
            Self::Robot(number) => write!(f, "ROBOTLASER{number}"),
            Self::Raw(number) => write!(f, "RAWLASER{number}"),
            Self::Old(0) => f.write_str("LASER"),
            Self::Old(number) => write!(f, "LASER{number}"),
            Self::Sonar => f.write_str("SONAR"),
        }
    }
}

/// How good a source of beams is: the least is the best.
///
/// A log can have the same scan as `ROBOTLASER1` and as `RAWLASER1`, and lasers that look elsewhere than
/// ahead. So the beams of a log are those of its best source alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Rank {
    /// With a pose; the front laser before the others.
    Posed(u8),
    /// At the pose of the odometry; the front laser before the others.
    Raw(u8),
    Sonar,
}

impl ScanName {
    pub(super) fn rank(self) -> Rank {
        match self {
            Self::Front => Rank::Posed(1),
            Self::Rear => Rank::Posed(2),
            Self::Robot(number) => Rank::Posed(number.max(1)),
            Self::Raw(number) | Self::Old(number) => Rank::Raw(number.max(1)),
            Self::Sonar => Rank::Sonar,
        }
    }

    /// Whether it is the laser that looks back.
    pub(super) fn is_rear(self) -> bool {
        matches!(
            self,
            Self::Rear | Self::Robot(2) | Self::Raw(2) | Self::Old(2)
        )
    }
}

impl Name {
    /// The message of this name, if it is one of a CARMEN log.
    pub(super) fn of(word: &str) -> Option<Self> {
        let scan = |name| Some(Self::Scan(name));
        match word {
            "FLASER" => return scan(ScanName::Front),
            "RLASER" => return scan(ScanName::Rear),
            "LASER" => return scan(ScanName::Old(0)),
            "SONAR" => return scan(ScanName::Sonar),
            "ODOM" => return Some(Self::Odometry),
            "PARAM" => return Some(Self::Parameter),
            _ if OTHERS.contains(&word) => return Some(Self::Other),
            _ => {}
        }
        let stem = word.trim_end_matches(|digit: char| digit.is_ascii_digit());
        let digits = &word[stem.len()..];
        let numbered: fn(u8) -> ScanName = match stem {
            _ if digits.is_empty() => return None,
            "ROBOTLASER" => ScanName::Robot,
            "RAWLASER" => ScanName::Raw,
            "LASER" => ScanName::Old,
            _ => return None,
        };
        Some(
            digits
                .parse()
                .map_or(Self::Other, |number| Self::Scan(numbered(number))),
        )
    }
}

/// A pose as logged, in metres and radians; the numbers are finite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pose {
    pub(super) x_m: f64,
    pub(super) y_m: f64,
    pub(super) heading_rad: f64,
}

impl Pose {
    /// The pose of something at `place` on a robot that has this pose.
    pub(super) fn then(self, place: Self) -> Self {
        let (sin, cos) = self.heading_rad.sin_cos();
        Self {
            x_m: self.x_m + place.x_m * cos - place.y_m * sin,
            y_m: self.y_m + place.x_m * sin + place.y_m * cos,
            heading_rad: self.heading_rad + place.heading_rad,
        }
    }

    /// Parses three fields.
    pub(super) fn parse(words: &[&str]) -> Result<Self, SkipReason> {
        let [x, y, heading, ..] = words else {
            return Err(SkipReason::FieldCount);
        };
        Ok(Self {
            x_m: finite(x, SkipReason::BadPose)?,
            y_m: finite(y, SkipReason::BadPose)?,
            heading_rad: finite(heading, SkipReason::BadPose)?,
        })
    }
}

/// One scan; the readings are text, as many as the message announces.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Scan<'w> {
    /// The sensor's pose, or for sonars the robot's, if the message has one.
    pub(super) pose: Option<Pose>,
    /// A finite number of seconds.
    pub(super) time_s: f64,
    /// What the message has about its laser.
    pub(super) header: Option<Header>,
    /// The laser's own value for *no echo* and beyond, if it is known.
    pub(super) max_range_m: Option<f64>,
    pub(super) readings: &'w [&'w str],
    /// The place of each sonar on the robot, three fields each; may be empty.
    pub(super) places: &'w [&'w str],
}

/// Parses the scans of a log; learns from its first lines whether it counts remissions.
#[derive(Debug, Default)]
pub(super) struct ScanParser {
    /// Of `ROBOTLASERn` lines: whether a number of remissions follows the readings.
    robot_remissions: Option<bool>,
    /// The same of `RAWLASERn` lines.
    raw_remissions: Option<bool>,
}

impl ScanParser {
    /// Parses a line with readings; `words` are its fields, the name first.
    pub(super) fn parse<'w>(
        &mut self,
        name: ScanName,
        words: &'w [&'w str],
    ) -> Result<Scan<'w>, SkipReason> {
        match name {
            ScanName::Front | ScanName::Rear => posed(words),
            ScanName::Robot(_) => described(words, 11, &mut self.robot_remissions),
            ScanName::Raw(_) => described(words, 0, &mut self.raw_remissions),
            ScanName::Old(_) => old(words),
            ScanName::Sonar => sonar(words),
        }
    }
}

/// Parses `ODOM x y theta tv rv acceleration timestamp host logger_timestamp`.
pub(super) fn odometry(words: &[&str]) -> Result<Pose, SkipReason> {
    Pose::parse(tail_any_host(words.get(1..).unwrap_or_default(), 7)?)
}

/// Parses `FLASER n r1..rn x y theta odom_x odom_y odom_theta timestamp host logger_timestamp`.
fn posed<'w>(words: &'w [&'w str]) -> Result<Scan<'w>, SkipReason> {
    let (readings, behind) = readings(words, 2)?;
    let numbers = tail_any_host(behind, 7)?;
    Ok(Scan {
        pose: Some(Pose::parse(numbers)?),
        time_s: finite(numbers[6], SkipReason::BadTime)?,
        header: None,
        max_range_m: None,
        readings,
        places: &[],
    })
}

/// Parses `LASER3 n r1..rn timestamp host logger_timestamp`.
fn old<'w>(words: &'w [&'w str]) -> Result<Scan<'w>, SkipReason> {
    let (readings, behind) = readings(words, 2)?;
    let numbers = tail(behind, 1)?;
    Ok(Scan {
        pose: None,
        time_s: finite(numbers[0], SkipReason::BadTime)?,
        header: None,
        max_range_m: None,
        readings,
        places: &[],
    })
}

/// Parses `ROBOTLASER1 laser_type start_angle field_of_view angular_resolution maximum_range
/// accuracy remission_mode num_readings [readings] num_remissions [remissions] laser_pose_x
/// laser_pose_y laser_pose_theta robot_pose_x robot_pose_y robot_pose_theta laser_tv laser_rv
/// forward_safety_dist side_safety_dist turn_axis timestamp host logger_timestamp`, and `RAWLASER1`,
/// which has no number (`pose_fields` 0) between the remissions and the time.
///
/// Old versions write no number of remissions. A log does or does not: `counted` is what its lines
/// before have.
fn described<'w>(
    words: &'w [&'w str],
    pose_fields: usize,
    counted: &mut Option<bool>,
) -> Result<Scan<'w>, SkipReason> {
    const HEAD: usize = 9;
    let (readings, behind) = readings(words, HEAD)?;
    let numbers = pose_fields + 1;
    let with = with_remissions(behind, readings.len(), numbers);
    let without = tail(behind, numbers);
    // A line that lost a field has the number of remissions in the place of its last reading, or of what
    // comes behind it.
    let doubtful = [readings.last(), behind.first()].contains(&Some(&"0"));
    let (fields, has_count) = match counted {
        Some(true) => (with?, true),
        Some(false) => (without?, false),
        None => match (with, without) {
            (Ok(fields), _) => (fields, true),
            (Err(_), Ok(fields)) if !doubtful => (fields, false),
            (Err(reason), _) => return Err(reason),
        },
    };
    let number = |index: usize| finite(words[index], SkipReason::NotANumber);
    // A range of zero or infinity means that it is not known: then there is no limit.
    let max_range_m: f64 = words[5].parse().map_err(|_| SkipReason::NotANumber)?;
    let scan = Scan {
        pose: (pose_fields > 0).then(|| Pose::parse(fields)).transpose()?,
        time_s: finite(fields[pose_fields], SkipReason::BadTime)?,
        header: Some(Header {
            start_rad: number(2)?,
            fov_rad: number(3)?,
            step_rad: number(4)?,
        }),
        max_range_m: (max_range_m.is_finite() && max_range_m > 0.0).then_some(max_range_m),
        readings,
        places: &[],
    };
    *counted = Some(has_count);
    Ok(scan)
}

/// The numbers behind a count of remissions, none or one a reading, and the remissions.
fn with_remissions<'w>(
    behind: &'w [&'w str],
    readings: usize,
    numbers: usize,
) -> Result<&'w [&'w str], SkipReason> {
    let (first, rest) = behind.split_first().ok_or(SkipReason::FieldCount)?;
    let remissions = first.parse().map_err(|_| SkipReason::FieldCount)?;
    if remissions != 0 && remissions != readings {
        return Err(SkipReason::FieldCount);
    }
    tail_any_host(
        rest.get(remissions..).ok_or(SkipReason::FieldCount)?,
        numbers,
    )
}

/// Parses a line of sonars in one of its forms.
///
/// CARMEN writes `SONAR cone_angle n r1..rn [x y theta of each sonar] timestamp host logger_timestamp`,
/// with a cone angle that has a decimal point. Others write `SONAR n r1..rn`, then nothing, the robot's
/// pose, or that and the odometry's, and the same end.
fn sonar<'w>(words: &'w [&'w str]) -> Result<Scan<'w>, SkipReason> {
    let announced = words.get(1).ok_or(SkipReason::FieldCount)?;
    let (readings, places, pose, time) = if announced.parse::<usize>().is_ok() {
        let (readings, behind) = readings(words, 2)?;
        let fields = tail(behind, 1)
            .or_else(|_| tail(behind, 4))
            .or_else(|_| tail(behind, 7))?;
        let pose = (fields.len() > 1)
            .then(|| Pose::parse(fields))
            .transpose()?;
        (readings, &fields[..0], pose, fields[fields.len() - 1])
    } else {
        finite(announced, SkipReason::NotANumber)?;
        let (readings, behind) = readings(words, 3)?;
        let fields = tail(behind, readings.len().saturating_mul(3).saturating_add(1))?;
        let (places, time) = fields.split_at(fields.len() - 1);
        (readings, places, None, time[0])
    };
    Ok(Scan {
        pose,
        time_s: finite(time, SkipReason::BadTime)?,
        header: None,
        max_range_m: None,
        readings,
        places,
    })
}

/// The readings, whose number is the last of `head` fields, and the fields behind them.
///
/// The announced number is only compared with the number of fields.
fn readings<'w>(
    words: &'w [&'w str],
    head: usize,
) -> Result<(&'w [&'w str], &'w [&'w str]), SkipReason> {
    let announced = count(words.get(head - 1).ok_or(SkipReason::FieldCount)?)?;
    words[head..]
        .split_at_checked(announced)
        .ok_or(SkipReason::FieldCount)
}

/// The `numbers` fields before the host's name, which is not a number.
fn tail<'w>(words: &'w [&'w str], numbers: usize) -> Result<&'w [&'w str], SkipReason> {
    let is_number = |word: &&&str| word.parse::<f64>().is_ok();
    let run = words.iter().take_while(is_number).count();
    if run == numbers && words.len() > numbers {
        Ok(&words[..numbers])
    } else if run < numbers && words.len() == numbers.saturating_add(2) {
        Err(SkipReason::NotANumber)
    } else {
        Err(SkipReason::FieldCount)
    }
}

/// As [`tail`]; the name can be a number too if it is one word and the logger's time is behind it.
///
/// Only for messages in which no other form is as long.
fn tail_any_host<'w>(words: &'w [&'w str], numbers: usize) -> Result<&'w [&'w str], SkipReason> {
    let all = || words.iter().all(|word| word.parse::<f64>().is_ok());
    if words.len() == numbers.saturating_add(2) && all() {
        Ok(&words[..numbers])
    } else {
        tail(words, numbers)
    }
}

/// Parses a field that counts others.
fn count(word: &str) -> Result<usize, SkipReason> {
    word.parse().map_err(|_| SkipReason::NotANumber)
}

/// Parses a field that must be a finite number.
fn finite(word: &str, otherwise: SkipReason) -> Result<f64, SkipReason> {
    let number: f64 = word.parse().map_err(|_| SkipReason::NotANumber)?;
    if number.is_finite() {
        Ok(number)
    } else {
        Err(otherwise)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const FLASER: &str = "FLASER 3 1.0 2.0 3.0 0.5 0.25 0.125 0 0 0 5 host 5";
    const ROBOT: &str = "ROBOTLASER1 4 -1.5 3.0 1.5 20.0 0.01 1 3 1.0 20.0 3.0 3 100 200 300 \
                         0.5 0.25 0.125 9 9 9 0.1 0.2 0.3 0.4 1e6 5 host 0.7";
    const ROBOT_BARE: &str = "ROBOTLASER1 4 -1.5 3.0 1.5 20.0 0.01 1 3 1.0 20.0 3.0 0 \
                              0.5 0.25 0.125 9 9 9 0.1 0.2 0.3 0.4 1e6 5 host 0.7";
    const ROBOT_OLD: &str = "ROBOTLASER1 4 -1.5 3.0 1.5 20.0 0.01 1 3 1.0 20.0 3.0 \
                             0.5 0.25 0.125 9 9 9 0.1 0.2 0.3 0.4 1e6 5 host 0.7";
    const RAW: &str = "RAWLASER1 0 -1.5 3.0 1.5 20.0 0.01 0 3 1.0 20.0 3.0 0 5 host 0.7";
    const RAW_OLD: &str = "RAWLASER1 0 -1.5 3.0 1.5 20.0 0.01 0 3 1.0 20.0 3.0 5 host 0.7";
    const OLD: &str = "LASER3 3 1.0 2.0 3.0 5 host 0.7";
    const SONAR: &str = "SONAR 3 1.0 2.0 3.0 5 host 0.7";
    const SONAR_POSE: &str = "SONAR 3 1.0 2.0 3.0 0.5 0.25 0.125 5 host 0.7";
    const SONAR_POSES: &str = "SONAR 3 1.0 2.0 3.0 0.5 0.25 0.125 0 0 0 5 host 0.7";
    const SONAR_PLACES: &str =
        "SONAR 0.260000 3 1.0 2.0 3.0 0.1 0 0 0 0.1 1.57 -0.1 0 3.14 5 host 0.7";

    /// Every form, and where its readings begin.
    const LINES: [(&str, usize); 11] = [
        (FLASER, 2),
        (ROBOT, 9),
        (ROBOT_BARE, 9),
        (ROBOT_OLD, 9),
        (RAW, 9),
        (RAW_OLD, 9),
        (OLD, 2),
        (SONAR, 2),
        (SONAR_POSE, 2),
        (SONAR_POSES, 2),
        (SONAR_PLACES, 3),
    ];

    type Owned = (Option<Pose>, f64, Option<Header>, Option<f64>, Vec<String>);

    fn parse_with(parser: &mut ScanParser, line: &str) -> Result<Owned, SkipReason> {
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let Some(Name::Scan(name)) = Name::of(words[0]) else {
            panic!("{line}");
        };
        let scan = parser.parse(name, &words)?;
        let readings = scan.readings.iter().map(ToString::to_string).collect();
        Ok((
            scan.pose,
            scan.time_s,
            scan.header,
            scan.max_range_m,
            readings,
        ))
    }

    fn parse(line: &str) -> Result<Owned, SkipReason> {
        parse_with(&mut ScanParser::default(), line)
    }

    fn fields(line: &str) -> Vec<&str> {
        line.split_ascii_whitespace().collect()
    }

    #[test]
    fn fields_of_each_form_are_read() {
        let pose = Some(Pose {
            x_m: 0.5,
            y_m: 0.25,
            heading_rad: 0.125,
        });
        let header = Some(Header {
            start_rad: -1.5,
            fov_rad: 3.0,
            step_rad: 1.5,
        });
        for (line, _) in LINES {
            let (found, time_s, described, limit, readings) = parse(line).unwrap();
            let has_pose = line.contains(" 0.5 0.25 0.125 ");
            assert_eq!(found, pose.filter(|_| has_pose), "{line}");
            assert_eq!(time_s, 5.0, "{line}");
            let is_described = line.contains(" -1.5 3.0 1.5 ");
            assert_eq!(described, header.filter(|_| is_described), "{line}");
            assert_eq!(limit, is_described.then_some(20.0), "{line}");
            let middle = if is_described { "20.0" } else { "2.0" };
            assert_eq!(readings, ["1.0", middle, "3.0"], "{line}");
        }
        let words = fields(SONAR_PLACES);
        let scan = ScanParser::default()
            .parse(ScanName::Sonar, &words)
            .unwrap();
        assert_eq!(
            scan.places,
            ["0.1", "0", "0", "0", "0.1", "1.57", "-0.1", "0", "3.14"]
        );
    }

    #[test]
    fn host_and_logger_time_are_free() {
        for (line, _) in LINES {
            let whole = parse(line);
            let (before, _) = line.split_once(" host").unwrap();
            for host in [
                "host",
                "my old robot",
                "192.168.0.1",
                "r\u{fffd}bot",
                "r2 d2 0.7",
            ] {
                assert_eq!(parse(&format!("{before} {host}")), whole, "{host}");
            }
            assert_eq!(parse(&line.replace(' ', "\t")), whole, "{line}");
            let numeric = parse(&format!("{before} 7 0.7"));
            let one_length = [FLASER, ROBOT, ROBOT_BARE, RAW].contains(&line);
            assert_eq!(numeric.is_ok(), one_length, "{line}");
        }
    }

    #[test]
    fn every_cut_before_the_host_is_refused() {
        for (line, _) in LINES {
            let words = fields(line);
            for end in 1..words.len() - 2 {
                let cut = words[..end].join(" ");
                assert!(parse(&cut).is_err(), "{cut}");
            }
        }
    }

    #[test]
    fn lost_or_gained_reading_is_refused_at_every_place() {
        for (line, first) in LINES {
            for ending in [" host", " host 0.7", " my robot 0.7"] {
                let (before, _) = line.split_once(" host").unwrap();
                let line = format!("{before}{ending}");
                let words = fields(&line);
                for place in first..=first + 3 {
                    for gained in ["1.25", "inf", "nan", "0", "3", "-1", "x"] {
                        // A count of no remissions behind the readings moves none of them.
                        if gained == "0" && place == first + 3 && first == 9 {
                            continue;
                        }
                        let mut longer = words.clone();
                        longer.insert(place, gained);
                        assert!(parse(&longer.join(" ")).is_err(), "{longer:?}");
                    }
                }
                for place in first..first + 3 {
                    let mut shorter = words.clone();
                    shorter.remove(place);
                    assert!(parse(&shorter.join(" ")).is_err(), "{shorter:?}");
                    // Two that grew together.
                    if place == first + 2 {
                        continue;
                    }
                    let mut joined = words.clone();
                    let next = joined.remove(place + 1);
                    let both = format!("{}{next}", joined[place]);
                    joined[place] = &both;
                    assert!(parse(&joined.join(" ")).is_err(), "{joined:?}");
                }
            }
        }
    }

    #[test]
    fn lost_or_gained_pose_field_is_refused() {
        for (line, first) in LINES {
            let words = fields(line);
            let host = words.iter().position(|word| *word == "host").unwrap();
            for place in first + 3..host {
                let mut longer = words.clone();
                longer.insert(place, "1.25");
                assert!(parse(&longer.join(" ")).is_err(), "{longer:?}");
                // Without its count of no remissions a line is one of an older version.
                if words[place] != "0" || !line.contains("LASER1") {
                    let mut shorter = words.clone();
                    shorter.remove(place);
                    assert!(parse(&shorter.join(" ")).is_err(), "{shorter:?}");
                }
            }
        }
    }

    /// A line of each form with these readings, and where they begin.
    fn line_of(form: usize, readings: &[&str]) -> (String, usize) {
        let (count, all) = (readings.len(), readings.join(" "));
        let laser = format!("0 -1.5 3.0 1.5 20.0 0.01 0 {count} {all}");
        let pose = "0.5 0.25 0.125 9 0 3";
        let moved = "0 0 0.3 0.4 1e6";
        let places = "0.1 0 3.14 ".repeat(count);
        let remissions = "100 ".repeat(count);
        match form {
            0 => (format!("FLASER {count} {all} {pose} 5"), 2),
            1 => (
                format!("ROBOTLASER1 {laser} {count} {remissions}{pose} {moved} 5"),
                9,
            ),
            2 => (format!("ROBOTLASER1 {laser} 0 {pose} {moved} 5"), 9),
            3 => (format!("RAWLASER1 {laser} 0 5"), 9),
            4 => (format!("RAWLASER1 {laser} {count} {remissions}5"), 9),
            5 => (format!("LASER3 {count} {all} 5"), 2),
            6 => (format!("SONAR {count} {all} 5"), 2),
            7 => (format!("SONAR {count} {all} 0.5 0.25 0.125 5"), 2),
            8 => (format!("SONAR {count} {all} {pose} 5"), 2),
            9 => (format!("SONAR 0.26 {count} {all} {places}5"), 3),
            10 => (format!("ROBOTLASER1 {laser} {pose} {moved} 5"), 9),
            _ => (format!("RAWLASER1 {laser} 5"), 9),
        }
    }

    proptest! {
        #[test]
        fn no_reading_moves_to_another_beam(
            form in 0_usize..12,
            chosen in prop::collection::vec(
                prop::sample::select(vec!["1.25", "0", "2", "3", "1", "inf", "nan", "-1", "0.000", "7"]),
                2..9,
            ),
            last in prop::sample::select(vec!["4.5", "0.000", "inf"]),
            ending in prop::sample::select(vec![" host", " host 0.7", " my robot 0.7", " h 1 2"]),
            gained in prop::sample::select(vec!["1.5", "0", "2", "5", "inf", "host"]),
            place: prop::sample::Index,
        ) {
            // A plain 0 at the end of an old form can be a count of remissions.
            let mut chosen = chosen;
            if form >= 10 {
                chosen.push(last);
            }
            let (before, first) = line_of(form, &chosen);
            let line = before + ending;
            let whole = parse(&line).unwrap();
            prop_assert_eq!(&whole.4, &chosen);
            let words = fields(&line);
            let mut longer = words.clone();
            longer.insert(first + place.index(chosen.len() + 1), gained);
            if let Ok(found) = parse(&longer.join(" ")) {
                prop_assert_eq!(found, whole, "{:?}", longer);
            }
            let mut shorter = words.clone();
            shorter.remove(first + place.index(chosen.len()));
            prop_assert!(parse(&shorter.join(" ")).is_err(), "{:?}", shorter);
        }
    }

    #[test]
    fn log_counts_remissions_in_all_lines_or_none() {
        for (counted, old) in [(ROBOT_BARE, ROBOT_OLD), (RAW, RAW_OLD)] {
            let mut parser = ScanParser::default();
            assert!(parse_with(&mut parser, counted).is_ok());
            assert_eq!(
                parse_with(&mut parser, old).err(),
                Some(SkipReason::FieldCount)
            );
            assert!(parse_with(&mut parser, counted).is_ok());
            let mut parser = ScanParser::default();
            assert!(parse_with(&mut parser, old).is_ok());
            assert!(parse_with(&mut parser, counted).is_err());
            // Now the last reading can be a plain 0.
            assert!(parse_with(&mut parser, &old.replace("3.0 5 host", "0 5 host")).is_ok());
        }
    }

    #[test]
    fn announced_billion_is_refused() {
        for (line, from, to) in [
            (FLASER, " 3 1.0", " 1000000000 1.0"),
            (ROBOT, " 1 3 1.0", " 1 1000000000 1.0"),
            (ROBOT, " 3 100", " 18446744073709551615 100"),
            (SONAR, " 3 1.0", " 1000000000 1.0"),
            (SONAR_PLACES, " 3 1.0", " 18446744073709551615 1.0"),
        ] {
            let damaged = line.replace(from, to);
            assert_ne!(damaged, line);
            assert_eq!(
                parse(&damaged).err(),
                Some(SkipReason::FieldCount),
                "{damaged}"
            );
        }
    }

    #[test]
    fn odometry_is_whole_or_refused() {
        let line = "ODOM 1 2 3 0 0 0 5 host 5";
        let words = fields(line);
        let pose = Pose {
            x_m: 1.0,
            y_m: 2.0,
            heading_rad: 3.0,
        };
        assert_eq!(odometry(&words), Ok(pose));
        for place in 1..words.len() - 2 {
            let mut shorter = words.clone();
            shorter.remove(place);
            assert!(odometry(&shorter).is_err(), "{shorter:?}");
            assert!(odometry(&words[..place]).is_err(), "{place}");
        }
    }

    #[test]
    fn best_source_comes_first() {
        let order = [
            "FLASER",
            "RLASER",
            "ROBOTLASER3",
            "RAWLASER1",
            "RAWLASER2",
            "LASER4",
            "SONAR",
        ];
        let ranks = order.map(|word| match Name::of(word) {
            Some(Name::Scan(name)) => {
                assert_eq!(name.to_string(), word);
                name.rank()
            }
            other => panic!("{word}: {other:?}"),
        });
        assert!(ranks.is_sorted_by(|one, next| one < next), "{ranks:?}");
    }

    #[test]
    fn unknown_names_are_no_messages() {
        for word in [
            "",
            "FLASERS",
            "flaser",
            "LASER1x",
            "7",
            "ROBOTLASER",
            "Laser",
        ] {
            assert_eq!(Name::of(word), None, "{word}");
        }
        assert_eq!(Name::of("RAWLASER999"), Some(Name::Other));
    }
}
