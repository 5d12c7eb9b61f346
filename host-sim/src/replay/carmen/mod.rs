//! Logs of the CARMEN robot navigation toolkit.
//!
//! A message a line, its name first. Metres, radians, seconds. Messages with readings become beams:
//! `FLASER`, `RLASER` and `ROBOTLASERn` at the pose that they have (in a *corrected* log the corrected
//! one), `RAWLASERn`, `LASERn` and `SONAR` at that of the `ODOM` before them. A log uses its best source
//! alone, so that no scan counts twice; other messages are counted and ignored.
//!
//! What a log leaves open and is assumed is a note.

mod directions;
mod message;

use super::recording::{LineKind, RecordedBeam, SkipReason, ZeroMeans};
use crate::quantity::FieldOfView;
use certainty_core::sensor::SensorId;
use certainty_core::transducer::{Missing, Reading};
use certainty_core::units::{BinaryAngle, Millimeters, Point, Ticks};
use core::f64::consts::{PI, TAU};
use core::num::NonZeroU8;
use directions::{Basis, Directions, Overrides, Parameters};
use message::{Name, Pose, Scan, ScanName, ScanParser};
use std::collections::{BTreeMap, HashMap};

/// Whether `word` names a message of a CARMEN log.
pub(super) fn is_message(word: &str) -> bool {
    Name::of(word).is_some()
}

/// How to turn scans into beams.
#[derive(Debug, Clone, Copy)]
pub(super) struct ScanOptions {
    /// The number of virtual sensors that a laser's beams are dealt to.
    pub(super) sensors: NonZeroU8,
    /// Echoes at this distance or beyond are no object.
    pub(super) max_range: Option<Millimeters>,
    /// The meaning of a reading of 0.
    pub(super) zero: ZeroMeans,
    /// The field of view, whatever the log has.
    pub(super) fov: Option<FieldOfView>,
    /// The direction of the first beam, whatever the log has.
    pub(super) start_angle: Option<BinaryAngle>,
}

/// Reads one log, line after line.
#[derive(Debug)]
pub(super) struct CarmenLog {
    options: ScanOptions,
    parser: ScanParser,
    /// The pose of the last `ODOM` line.
    odometry: Option<Pose>,
    front: Mounted,
    rear: Mounted,
    used: Used,
    /// Lines with readings that are not used, by their names.
    unused: BTreeMap<ScanName, u64>,
    /// Lines whose beams a better source replaced.
    replaced: u64,
}

/// What `PARAM` lines give of one laser: its beams, and its place on the robot.
#[derive(Debug, Clone, Copy, Default)]
struct Mounted {
    parameters: Parameters,
    ahead_m: f64,
    left_m: f64,
    turned_rad: Option<f64>,
}

/// The lines of the best source.
#[derive(Debug, Default)]
struct Used {
    /// By their names; empty if there is none yet.
    lines: BTreeMap<ScanName, u64>,
    first_s: Option<f64>,
    last_s: Option<f64>,
    /// The message that was first at each time, by the bits of its seconds.
    times: HashMap<u64, ScanName>,
    backward: u64,
    zeros: u64,
    /// The directions of the beams, by the message and the number of beams.
    directions: BTreeMap<(ScanName, usize, Basis), Directions>,
    /// More kinds of directions than are kept.
    more_directions: bool,
    at_odometry: bool,
    highest_sensor: u8,
}

/// What the reader of a log counted.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Summary {
    /// The number of sensors of the beams that were kept.
    pub(super) sensors: u8,
    /// How often a line that was kept has an earlier time than the one before.
    pub(super) backward: u64,
    /// Lines that had beams when they were read, and were replaced by a better source.
    pub(super) replaced: u64,
    /// Whether the beams that were kept have their poses from odometry.
    pub(super) at_odometry: bool,
    /// What was assumed, one line each.
    pub(super) notes: Vec<String>,
}

/// The most kinds of directions that are noted.
const NOTED: usize = 8;

impl CarmenLog {
    /// Creates the reader of a log.
    pub(super) fn new(options: ScanOptions) -> Self {
        Self {
            options,
            parser: ScanParser::default(),
            odometry: None,
            front: Mounted::default(),
            rear: Mounted::default(),
            used: Used::default(),
            unused: BTreeMap::new(),
            replaced: 0,
        }
    }

    /// Appends the beams of `line`, if it is a scan of the best source; the first scan of a better source
    /// replaces all beams.
    pub(super) fn line(
        &mut self,
        line: &str,
        beams: &mut Vec<RecordedBeam>,
    ) -> Result<LineKind, SkipReason> {
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let Some(&word) = words.first() else {
            return Ok(LineKind::Nothing);
        };
        if word.starts_with('#') {
            return Ok(LineKind::Nothing);
        }
        match Name::of(word) {
            Some(Name::Scan(name)) => self.scan(name, &words, beams),
            Some(Name::Odometry) => {
                // A damaged line leaves no pose, because an older one is of another place.
                self.odometry = message::odometry(&words).ok();
                Ok(LineKind::Other)
            }
            Some(Name::Parameter) => {
                self.parameter(&words);
                Ok(LineKind::Other)
            }
            Some(Name::Other) => Ok(LineKind::Other),
            None if line.contains(char::REPLACEMENT_CHARACTER) => Err(SkipReason::NotText),
            None => Err(SkipReason::UnknownMessage),
        }
    }

    /// Takes a line with readings.
    fn scan(
        &mut self,
        name: ScanName,
        words: &[&str],
        beams: &mut Vec<RecordedBeam>,
    ) -> Result<LineKind, SkipReason> {
        let best = self.used.lines.keys().map(|name| name.rank()).next();
        if best.is_some_and(|best| best < name.rank()) {
            return Ok(self.leave_out(name));
        }
        let scan = self.parser.parse(name, words)?;
        let robot = scan.pose.or(self.odometry).ok_or(SkipReason::NoPose)?;
        let pose = match (name, scan.pose) {
            (ScanName::Raw(_) | ScanName::Old(_), None) => robot.then(self.place(name)),
            _ => robot,
        };
        // The same scan as two messages, whose poses can differ.
        let time_bits = (scan.time_s + 0.0).to_bits();
        let first = self.used.times.get(&time_bits);
        let repeats = first.is_some_and(|&first| first != name);
        let better = best.is_some_and(|best| name.rank() < best);
        if !better && repeats {
            return Ok(self.leave_out(name));
        }
        let beams_of_scan = scan.readings.len();
        let radians = |header: directions::Header| header.is_radians(beams_of_scan);
        if self.options.fov.is_none() && !scan.header.is_none_or(radians) {
            return Err(SkipReason::BadAngle);
        }
        let (directions, basis) = self.directions(name, &scan);
        let first_s = match self.used.first_s {
            Some(first_s) if !better => first_s,
            _ => scan.time_s,
        };
        let at = ticks_since(first_s, scan.time_s)?;
        let before = beams.len();
        let zeros = self.append(name, &scan, pose, directions, at, beams)?;
        if better {
            beams.drain(..before);
            for (name, lines) in core::mem::take(&mut self.used).lines {
                *self.unused.entry(name).or_default() += lines;
                self.replaced += lines;
            }
        }
        let used = &mut self.used;
        *used.lines.entry(name).or_default() += 1;
        let backward = used.last_s.is_some_and(|last_s| scan.time_s < last_s);
        used.backward += u64::from(backward);
        used.first_s = Some(first_s);
        used.last_s = Some(scan.time_s);
        used.times.entry(time_bits).or_insert(name);
        used.zeros += zeros;
        used.at_odometry |= scan.pose.is_none();
        used.highest_sensor = used.highest_sensor.max(match name {
            // Checked when the beams were appended.
            ScanName::Sonar => scan.readings.len() as u8,
            _ => self.options.sensors.get(),
        });
        let kind = (name, scan.readings.len(), basis);
        if used.directions.len() < NOTED || used.directions.contains_key(&kind) {
            used.directions.entry(kind).or_insert(directions);
        } else {
            used.more_directions = true;
        }
        Ok(LineKind::Beams { backward })
    }

    fn leave_out(&mut self, name: ScanName) -> LineKind {
        *self.unused.entry(name).or_default() += 1;
        LineKind::Other
    }

    /// The laser's place on the robot.
    fn place(&self, name: ScanName) -> Pose {
        let (mounted, usual_rad) = match name {
            ScanName::Raw(0 | 1) | ScanName::Old(0 | 1) => (self.front, 0.0),
            name if name.is_rear() => (self.rear, PI),
            _ => (Mounted::default(), 0.0),
        };
        Pose {
            x_m: mounted.ahead_m,
            y_m: mounted.left_m,
            heading_rad: mounted.turned_rad.unwrap_or(usual_rad),
        }
    }

    fn directions(&self, name: ScanName, scan: &Scan<'_>) -> (Directions, Basis) {
        let overrides = Overrides {
            fov: self.options.fov,
            start: self.options.start_angle,
        };
        let beams = scan.readings.len();
        if name == ScanName::Sonar {
            let (directions, basis) = directions::of_sonars(beams, overrides);
            let logged = !scan.places.is_empty();
            return (directions, if logged { Basis::Message } else { basis });
        }
        let parameters = match name {
            ScanName::Raw(3..) | ScanName::Old(3..) | ScanName::Robot(3..) => Parameters::default(),
            name if name.is_rear() => self.rear.parameters,
            _ => self.front.parameters,
        };
        directions::of_laser(beams, scan.header, parameters, overrides)
    }

    /// Takes a `PARAM name value` line if it describes a laser.
    fn parameter(&mut self, words: &[&str]) {
        let [_, name, value, ..] = words else {
            return;
        };
        let Some(value) = value.parse::<f64>().ok().filter(|value| value.is_finite()) else {
            return;
        };
        let name = name
            .trim_start_matches("laser_")
            .trim_start_matches("robot_");
        let (mounted, name) = if let Some(name) = name.strip_prefix("front") {
            (&mut self.front, name)
        } else if let Some(name) = name.strip_prefix("rear") {
            (&mut self.rear, name)
        } else {
            return;
        };
        let angle_rad = (value > 0.0 && value <= 360.0).then(|| value.to_radians());
        // Both spellings occur: `laser_front_laser_resolution` and `laser_frontlaser_resolution`.
        match name.trim_start_matches('_') {
            "laser_fov" => mounted.parameters.fov_rad = angle_rad,
            "laser_resolution" => mounted.parameters.step_rad = angle_rad,
            "laser_offset" => mounted.ahead_m = value,
            "laser_side_offset" => mounted.left_m = value,
            // Radians; more than a turn of them is degrees.
            "laser_angular_offset" if value.abs() <= TAU => mounted.turned_rad = Some(value),
            "laser_angular_offset" => mounted.turned_rad = Some(value.to_radians()),
            _ => {}
        }
    }

    /// Appends the scan's beams, all or none; returns how many readings are 0.
    fn append(
        &self,
        name: ScanName,
        scan: &Scan<'_>,
        pose: Pose,
        directions: Directions,
        at: Ticks,
        beams: &mut Vec<RecordedBeam>,
    ) -> Result<u64, SkipReason> {
        let sonar = name == ScanName::Sonar;
        if scan.readings.is_empty() {
            return Err(SkipReason::NoReadings);
        }
        if sonar && scan.readings.len() > usize::from(u8::MAX) {
            return Err(SkipReason::BadSensor);
        }
        let before = beams.len();
        let own_limit_mm = scan.max_range_m.map_or(f64::INFINITY, |m| m * 1000.0);
        let limit_mm = self
            .options
            .max_range
            .map_or(own_limit_mm, |mm| f64::from(mm.get()).min(own_limit_mm));
        let mut zeros = 0;
        let mut beam = |index: usize, word: &str| {
            let metres = word.parse::<f64>().map_err(|_| SkipReason::NotANumber)?;
            let from = match scan.places.get(index * 3..) {
                Some(place) if !place.is_empty() => pose.then(Pose::parse(place)?),
                _ => Pose {
                    heading_rad: directions
                        .step_rad
                        .mul_add(index as f64, directions.start_rad)
                        + pose.heading_rad,
                    ..pose
                },
            };
            let slot = if sonar {
                index
            } else {
                index % usize::from(self.options.sensors.get())
            };
            let (reading, zero) = reading_from_metres(metres, limit_mm, self.options.zero);
            zeros += u64::from(zero);
            Ok(RecordedBeam {
                at,
                // Below 255, so the slot exists.
                sensor: SensorId::from_slot(slot).ok_or(SkipReason::BadSensor)?,
                origin: point_from_metres(from.x_m, from.y_m)?,
                bearing: angle_from_radians(from.heading_rad),
                reading,
            })
        };
        for (index, word) in scan.readings.iter().enumerate() {
            match beam(index, word) {
                Ok(beam) => beams.push(beam),
                Err(reason) => {
                    beams.truncate(before);
                    return Err(reason);
                }
            }
        }
        Ok(zeros)
    }

    /// Returns how many lines had beams that those of a better source have replaced.
    pub(super) const fn replaced(&self) -> u64 {
        self.replaced
    }

    /// What was counted and assumed, once all lines are read.
    pub(super) fn finish(self) -> Summary {
        let Self { used, unused, .. } = &self;
        let names = |lines: &BTreeMap<ScanName, u64>| {
            let names: Vec<String> = lines.keys().map(ToString::to_string).collect();
            names.join(", ")
        };
        let mut notes = Vec::new();
        for ((name, beams, basis), directions) in &used.directions {
            notes.extend(direction_note(
                *name,
                *beams,
                *basis,
                *directions,
                &self.options,
            ));
        }
        if used.more_directions {
            notes.push(format!(
                "more than {NOTED} kinds of scans: the directions of the others are found alike"
            ));
        }
        if used.at_odometry {
            notes.push(format!(
                "{}: at the pose of the ODOM line before, which drifts; a corrected log has better ones",
                names(&used.lines)
            ));
        }
        if used
            .lines
            .keys()
            .any(|name| matches!(name, ScanName::Raw(2) | ScanName::Old(2)))
            && self.rear.turned_rad.is_none()
        {
            notes.push("rear laser: assumed to look straight back".to_owned());
        }
        if used.zeros > 0 {
            notes.push(format!(
                "{} readings of 0 taken as {}",
                used.zeros, self.options.zero
            ));
        }
        let left_out: u64 = unused.values().sum();
        if left_out > 0 {
            let lines = if left_out == 1 { "line" } else { "lines" };
            notes.push(format!(
                "{left_out} {lines} of {} not used: the beams are those of {}",
                names(unused),
                names(&used.lines)
            ));
        }
        Summary {
            sensors: used.highest_sensor,
            backward: used.backward,
            replaced: self.replaced,
            at_odometry: used.at_odometry,
            notes,
        }
    }
}

/// The note on the directions of one kind of scan, unless they are logged or set.
fn direction_note(
    name: ScanName,
    beams: usize,
    basis: Basis,
    directions: Directions,
    options: &ScanOptions,
) -> Option<String> {
    if matches!(basis, Basis::Message | Basis::Options) {
        return None;
    }
    let start = directions.start_rad.to_degrees();
    let start = if start > 180.0 { start - 360.0 } else { start };
    let thousandths = |degrees: f64| (degrees * 1000.0).round() / 1000.0 + 0.0;
    let option = match options.start_angle {
        None => "--fov and --start-angle set others",
        Some(_) => "--fov sets others",
    };
    Some(format!(
        "{name} of {beams} readings: from {}deg in steps of {}deg, {basis}; {option}",
        thousandths(start),
        thousandths(directions.step_rad.to_degrees()),
    ))
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

/// The reading of a number in metres, and whether it is 0; `limit_mm` and more is *no object*.
///
/// Rounds to the nearest millimetre. Infinity is no object and minus infinity too near (REP 117). A number
/// that is negative, not a number, or below the limit but beyond twice [`Point::LIMIT`], is implausible.
fn reading_from_metres(metres: f64, limit_mm: f64, zero: ZeroMeans) -> (Reading, bool) {
    let mm = metres * 1000.0;
    let reading = if metres == f64::NEG_INFINITY {
        Reading::TooNear
    } else if metres.is_nan() || mm < 0.0 {
        Reading::Missing(Missing::Implausible)
    } else if metres == f64::INFINITY || mm >= limit_mm {
        Reading::NoObject
    } else if mm > 2.0 * f64::from(Point::LIMIT) {
        Reading::Missing(Missing::Implausible)
    } else if mm < 0.5 {
        return (zero.reading(), true);
    } else {
        Reading::Echo(Millimeters::new(mm.round() as u32))
    };
    (reading, false)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::field_of_view;

    const OPTIONS: ScanOptions = ScanOptions {
        sensors: NonZeroU8::new(3).unwrap(),
        max_range: Some(Millimeters::new(8000)),
        zero: ZeroMeans::NoObject,
        fov: None,
        start_angle: None,
    };

    type Taken = Vec<Result<LineKind, SkipReason>>;

    /// The beams of `lines`, the result of each line, and the summary.
    fn read_with(options: ScanOptions, lines: &[&str]) -> (Vec<RecordedBeam>, Taken, Summary) {
        let mut log = CarmenLog::new(options);
        let mut beams = Vec::new();
        let taken = lines
            .iter()
            .map(|line| log.line(line, &mut beams))
            .collect();
        (beams, taken, log.finish())
    }

    fn read(lines: &[&str]) -> (Vec<RecordedBeam>, Taken) {
        let (beams, taken, _) = read_with(OPTIONS, lines);
        (beams, taken)
    }

    fn notes(lines: &[&str]) -> Vec<String> {
        read_with(OPTIONS, lines).2.notes
    }

    fn readings(beams: &[RecordedBeam]) -> Vec<Reading> {
        beams.iter().map(|beam| beam.reading).collect()
    }

    fn bearings(beams: &[RecordedBeam]) -> Vec<u16> {
        beams.iter().map(|beam| beam.bearing.to_bits()).collect()
    }

    fn sensors(beams: &[RecordedBeam]) -> Vec<u8> {
        beams.iter().map(|beam| beam.sensor.number()).collect()
    }

    const BEAMS: Result<LineKind, SkipReason> = Ok(LineKind::Beams { backward: false });
    const OTHER: Result<LineKind, SkipReason> = Ok(LineKind::Other);
    const IMPLAUSIBLE: Reading = Reading::Missing(Missing::Implausible);

    const fn echo(mm: u32) -> Reading {
        Reading::Echo(Millimeters::new(mm))
    }

    #[test]
    fn flaser_scan_becomes_beams() {
        let line = "FLASER 5 1.5 8.0 nan 0 -1 2.0 -1.0 1.570796327 7 7 7 100.25 host 0.1";
        let (beams, taken) = read(&[line]);
        assert_eq!(taken, [BEAMS]);
        let none = Reading::NoObject;
        assert_eq!(
            readings(&beams),
            [echo(1500), none, IMPLAUSIBLE, none, IMPLAUSIBLE]
        );
        assert_eq!(bearings(&beams), [0, 0x2000, 0x4000, 0x6000, 0x8000]);
        assert_eq!(sensors(&beams), [1, 2, 3, 1, 2]);
        let origin = Point::from_mm(2000, -1000);
        assert!(beams.iter().all(|beam| beam.origin == origin));
        assert!(beams.iter().all(|beam| beam.at == Ticks::new(0)));
    }

    #[test]
    fn infinity_is_no_object_and_minus_infinity_too_near() {
        for limit_mm in [8000.0, f64::INFINITY] {
            for (word, reading) in [
                ("inf", Reading::NoObject),
                ("+inf", Reading::NoObject),
                ("Infinity", Reading::NoObject),
                ("-inf", Reading::TooNear),
                ("nan", IMPLAUSIBLE),
                ("-nan", IMPLAUSIBLE),
                ("-0.001", IMPLAUSIBLE),
                ("-5", IMPLAUSIBLE),
                ("7.9994", echo(7999)),
                ("7.9995", echo(8000)),
            ] {
                let metres = word.parse().unwrap();
                let found = reading_from_metres(metres, limit_mm, ZeroMeans::NoObject);
                assert_eq!(found, (reading, false), "{word}");
            }
        }
        let far = |metres, limit_mm| reading_from_metres(metres, limit_mm, ZeroMeans::NoObject).0;
        assert_eq!(far(8.0, 8000.0), Reading::NoObject);
        assert_eq!(far(1e300, 8000.0), Reading::NoObject);
        assert_eq!(far(1e300, f64::INFINITY), IMPLAUSIBLE);
    }

    #[test]
    fn zero_is_no_object_or_too_near_as_set() {
        for metres in [0.0, -0.0, 0.0004] {
            for (zero, reading) in [
                (ZeroMeans::NoObject, Reading::NoObject),
                (ZeroMeans::TooNear, Reading::TooNear),
            ] {
                let found = reading_from_metres(metres, 8000.0, zero);
                assert_eq!(found, (reading, true), "{metres}");
            }
        }
        let line = "FLASER 3 0 0.000 1 0 0 0 0 0 0 5 host 5";
        let note = notes(&[line, line])[1].clone();
        assert_eq!(
            note,
            "4 readings of 0 taken as no object; --zero near takes them as too near"
        );
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
            (
                "FLASER 2 1.0 2 0 0 y 0 0 0 5 host 5",
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
            (
                "RAWLASER1 0 -1.5 3 1 9 0 0 1 1.0 0 5 host 5",
                SkipReason::NoPose,
            ),
            ("SONAR 1 1.0 5 host 5", SkipReason::NoPose),
            ("LASER3 1 1.0 5 host 5", SkipReason::NoPose),
            ("FLASHER 2", SkipReason::UnknownMessage),
            ("\u{fffd} 2", SkipReason::NotText),
        ] {
            let (beams, taken) = read(&[line]);
            assert_eq!(taken, [Err(reason)], "{line}");
            assert!(beams.is_empty(), "{line}");
        }
        let crowd = format!("SONAR 256 {}0 0 0 5 host 5", "1 ".repeat(256));
        assert_eq!(read(&[&crowd]).1, [Err(SkipReason::BadSensor)]);
    }

    #[test]
    fn other_messages_are_not_errors() {
        for line in [
            "ODOM 0 0 0 0 0 0 0.1 h 0.1",
            "ODOM cut",
            "PARAM robot_frontlaser_offset 0.0 nohost 0",
            "PARAM",
            "NEFF 3",
            "SYNC x",
            "TRUEPOS 1 2 3",
            "RAWLASER1000 0",
        ] {
            assert_eq!(read(&[line]).1, [OTHER], "{line}");
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
        let (beams, taken, summary) = read_with(OPTIONS, &lines.each_ref().map(String::as_str));
        let at: Vec<u32> = beams.iter().map(|beam| beam.at.get()).collect();
        assert_eq!(at, [0, 500, 400, 0, 1500]);
        let backward = Ok(LineKind::Beams { backward: true });
        assert_eq!(taken, [BEAMS, BEAMS, backward, backward, BEAMS]);
        assert_eq!(summary.backward, 2);
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
        let none = Reading::NoObject;
        assert_eq!(readings(&beams), [echo(4900), none, none]);
    }

    #[test]
    fn rear_laser_has_its_own_pose() {
        let (beams, taken) = read(&["RLASER 3 1 1 1 2 3 1.570796327 0 0 0 5 host 5"]);
        assert_eq!(taken, [BEAMS]);
        assert_eq!(beams[0].origin, Point::from_mm(2000, 3000));
        assert_eq!(bearings(&beams), [0, 0x4000, 0x8000]);
    }

    #[test]
    fn raw_laser_is_at_the_odometry_and_its_place() {
        let odometry = "ODOM 1 2 1.570796327 0 0 0 5 host 5";
        let front = "RAWLASER1 0 -1.570796327 3.14159265 1.570796327 80 0 0 3 1 1 1 0 5 host 5";
        let rear = front.replace("LASER1", "LASER2");
        let offset = "PARAM robot_frontlaser_offset 0.5 0 nohost 0";
        let (beams, taken, summary) = read_with(OPTIONS, &[odometry, front]);
        assert_eq!(taken, [OTHER, BEAMS]);
        assert_eq!(beams[0].origin, Point::from_mm(1000, 2000));
        assert_eq!(bearings(&beams), [0, 0x4000, 0x8000]);
        assert_eq!(summary.notes.len(), 1);
        assert!(summary.notes[0].starts_with("RAWLASER1: at the pose of the ODOM line before"));
        let (beams, _) = read(&[offset, odometry, front]);
        assert_eq!(beams[0].origin, Point::from_mm(1000, 2500));
        let (beams, _, summary) = read_with(OPTIONS, &[odometry, &rear]);
        assert_eq!(bearings(&beams), [0x8000, 0xC000, 0]);
        assert_eq!(
            summary.notes[1],
            "rear laser: assumed to look straight back"
        );
        for (turned, first) in [("0", 0), ("180", 0x8000), ("3.14159265", 0x8000)] {
            let turned = format!("PARAM robot_rearlaser_angular_offset {turned} 0 nohost 0");
            let (beams, _, summary) = read_with(OPTIONS, &[&turned, odometry, &rear]);
            assert_eq!(beams[0].bearing.to_bits(), first, "{turned}");
            assert_eq!(summary.notes.len(), 1);
        }
        // A damaged line of odometry leaves no pose.
        let (_, taken) = read(&[odometry, front, "ODOM 1 2", front, odometry, front]);
        let expected = [OTHER, BEAMS, OTHER, Err(SkipReason::NoPose), OTHER, BEAMS];
        assert_eq!(taken, expected);
    }

    #[test]
    fn sonars_are_sensors_of_their_own() {
        let odometry = "ODOM 1 2 1.570796327 0 0 0 5 host 5";
        let at_odometry = "SONAR 4 1 0 inf 2 5 host 5";
        let own_pose = "SONAR 4 1 0 inf 2 1 2 1.570796327 5 host 5";
        let expected = [echo(1000), Reading::NoObject, Reading::NoObject, echo(2000)];
        let (beams, taken, summary) = read_with(OPTIONS, &[odometry, at_odometry]);
        assert_eq!(taken, [OTHER, BEAMS]);
        assert_eq!(readings(&beams), expected);
        assert_eq!(sensors(&beams), [1, 2, 3, 4]);
        assert_eq!(bearings(&beams), [0x4000, 0x8000, 0xC000, 0]);
        assert_eq!(beams[0].origin, Point::from_mm(1000, 2000));
        assert_eq!(summary.sensors, 4);
        assert_eq!(
            summary.notes[0],
            "SONAR of 4 readings: from 0deg in steps of 90deg, assumed evenly around, \
             counter-clockwise from straight ahead; --fov and --start-angle set others"
        );
        assert_eq!(summary.notes.len(), 3);
        assert_eq!(read(&[own_pose]).0, beams);
        let halved = ScanOptions {
            fov: Some(field_of_view("180deg").unwrap()),
            start_angle: Some(BinaryAngle::ZERO),
            ..OPTIONS
        };
        let (beams, _, summary) = read_with(halved, &[own_pose]);
        assert_eq!(bearings(&beams), [0x4000, 0x6000, 0x8000, 0xA000]);
        assert_eq!(summary.notes.len(), 1);
    }

    #[test]
    fn sonars_with_places_need_no_directions() {
        let odometry = "ODOM 1 2 1.570796327 0 0 0 5 host 5";
        let line =
            "SONAR 0.260000 2 1.00 2.00 0.100 0.000 0.000000 0.000 -0.200 -1.570796 5 host 5";
        let (beams, taken, summary) = read_with(OPTIONS, &[odometry, line]);
        assert_eq!(taken, [OTHER, BEAMS]);
        let origins: Vec<Point> = beams.iter().map(|beam| beam.origin).collect();
        assert_eq!(
            origins,
            [Point::from_mm(1000, 2100), Point::from_mm(1200, 2000)]
        );
        assert_eq!(bearings(&beams), [0x4000, 0]);
        assert_eq!(summary.notes.len(), 1, "{:?}", summary.notes);
    }

    const SOURCES: [&str; 4] = [
        "SONAR 3 4 4 4 5.5 host 5",
        "RAWLASER1 0 -1 2 1 80 0 0 3 3 3 3 0 5.4 host 5",
        "RLASER 3 2 2 2 0 0 0 0 0 0 5.3 host 5",
        "FLASER 3 1 1 1 0 0 0 0 0 0 5.2 host 5",
    ];

    #[test]
    fn best_source_alone_is_used_in_any_order() {
        let odometry = "ODOM 0 0 0 0 0 0 5 host 5";
        let [sonar, raw, rear, front] = SOURCES;
        let orders = [
            [sonar, raw, rear, front],
            [front, rear, raw, sonar],
            [raw, front, sonar, rear],
        ];
        for order in orders {
            let lines = [&[odometry][..], &order, &[sonar, front]].concat();
            let (beams, taken, summary) = read_with(OPTIONS, &lines);
            assert!(taken.iter().all(Result::is_ok));
            assert_eq!(readings(&beams), [echo(1000); 6]);
            assert!(beams.iter().all(|beam| beam.at == Ticks::new(0)));
            assert_eq!(summary.sensors, 3);
            let last = summary.notes.last().unwrap();
            assert_eq!(
                last,
                "4 lines of RLASER, RAWLASER1, SONAR not used: the beams are those of FLASER"
            );
            assert_eq!(summary.notes.len(), 2);
        }
        let (beams, _, summary) = read_with(OPTIONS, &[odometry, sonar, raw, raw]);
        assert_eq!(readings(&beams), [echo(3000); 6]);
        assert_eq!(summary.replaced, 1);
    }

    #[test]
    fn damaged_better_source_replaces_nothing() {
        let (beams, taken) = read(&[SOURCES[2], "FLASER 3 1 1 x 0 0 0 0 0 0 5 host 5"]);
        assert_eq!(taken, [BEAMS, Err(SkipReason::NotANumber)]);
        assert_eq!(readings(&beams), [echo(2000); 3]);
    }

    #[test]
    fn same_scan_as_two_messages_counts_once() {
        let flaser = "FLASER 3 1 1 1 0.5 0 0 0 0 0 5 host 5";
        let robot = "ROBOTLASER1 0 -1 2 1 80 0 0 3 1 1 1 0 0.5 0 0 0 0 0 0 0 0 0 0 5 host 5";
        for lines in [[flaser, robot], [robot, flaser]] {
            let (beams, taken, summary) = read_with(OPTIONS, &lines);
            assert_eq!((beams.len(), taken), (3, vec![BEAMS, OTHER]));
            assert!(summary.notes.last().unwrap().starts_with("1 line of "));
        }
        // Corrected poses are in one of them alone, and all of one can be behind all of the other.
        let posed = robot.replace("1 0 0.5 0", "1 0 0.75 0");
        let later = flaser.replace(" 5 host", " 6 host");
        let (beams, taken) = read(&[flaser, &posed]);
        assert_eq!((beams.len(), taken), (3, vec![BEAMS, OTHER]));
        let (beams, taken) = read(&[flaser, &later, &posed]);
        assert_eq!((beams.len(), taken), (6, vec![BEAMS, BEAMS, OTHER]));
        let (beams, _) = read(&[flaser, &robot.replace(" 5 host", " 6 host")]);
        assert_eq!(beams.len(), 6);
    }

    #[test]
    fn angles_in_degrees_are_refused() {
        let line = |angles: &str| {
            format!("ROBOTLASER1 0 {angles} 80 0 0 3 1 1 1 0 0 0 0 0 0 0 0 0 0 0 0 5 host 5")
        };
        for (angles, taken) in [
            ("-90 180 90", Err(SkipReason::BadAngle)),
            ("0 180 90", Err(SkipReason::BadAngle)),
            ("0 180 0", Err(SkipReason::BadAngle)),
            ("0 3.1416 90", Err(SkipReason::BadAngle)),
            ("1e300 3.1416 0.01", Err(SkipReason::BadAngle)),
            ("0 3.1416 5", Err(SkipReason::BadAngle)),
            ("-3.1416 6.2832 3.1416", BEAMS),
            ("6.2832 -6.2832 -3.1416", BEAMS),
        ] {
            assert_eq!(read(&[&line(angles)]).1, [taken], "{angles}");
        }
        let set = ScanOptions {
            fov: Some(field_of_view("180deg").unwrap()),
            ..OPTIONS
        };
        let (beams, _, _) = read_with(set, &[&line("-90 180 90")]);
        assert_eq!(bearings(&beams), [0xC000, 0, 0x4000]);
    }

    #[test]
    fn assumed_directions_are_noted_once_a_kind() {
        let scan =
            |beams: usize| format!("FLASER {beams} {}0 0 0 0 0 0 5 host 5", "1 ".repeat(beams));
        let (known, other) = (scan(181), scan(7));
        assert_eq!(
            notes(&[&known, &other, &known, &other]),
            [
                "FLASER of 7 readings: from -90deg in steps of 30deg, assumed, since the log does not \
                 give it; --fov and --start-angle set others",
                "FLASER of 181 readings: from -90deg in steps of 1deg, assumed, as lasers with this \
                 number of beams have it; --fov and --start-angle set others",
            ]
        );
        let resolution = "PARAM laser_front_laser_resolution 0.5 nohost 0";
        assert_eq!(
            notes(&[resolution, &known]),
            [
                "FLASER of 181 readings: from -45deg in steps of 0.5deg, by the log's PARAM lines; \
              --fov and --start-angle set others"
            ]
        );
        let many: Vec<String> = (1..40).map(scan).collect();
        let many: Vec<&str> = many.iter().map(String::as_str).collect();
        assert_eq!(notes(&many).len(), NOTED + 1);
    }

    #[test]
    fn parameters_are_of_their_own_laser() {
        let scan = |name: &str| format!("{name} 3 1 1 1 0 0 0 0 0 0 5 host 5");
        let fov = |name: &str| format!("PARAM {name} 90.0 nohost 0");
        for (name, parameter, first) in [
            ("FLASER", "laser_front_laser_fov", 0xE000),
            ("FLASER", "laser_frontlaser_fov", 0xE000),
            ("FLASER", "laser_rear_laser_fov", 0xC000),
            ("RLASER", "laser_rear_laser_fov", 0xE000),
            ("RLASER", "laser_front_laser_fov", 0xC000),
        ] {
            let (beams, _) = read(&[&fov(parameter), &scan(name)]);
            assert_eq!(beams[0].bearing.to_bits(), first, "{name} {parameter}");
        }
        for value in ["0", "-1", "nan", "inf", "1e9", "on"] {
            let parameter = format!("PARAM laser_front_laser_fov {value} nohost 0");
            let (beams, _) = read(&[&parameter, &scan("FLASER")]);
            assert_eq!(beams[0].bearing.to_bits(), 0xC000, "{value}");
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
