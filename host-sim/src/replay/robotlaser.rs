//! The later CARMEN laser message, which brings its own geometry.

use super::scan::{Directions, Scan, finite, point_from_metres};
use super::skipped::SkipReason;

/// Fields before the readings: name, type, start angle, field of view, resolution, maximum range,
/// accuracy, remission mode, number of readings.
const HEAD: usize = 9;
/// Fields behind the remissions: two poses of three, five of motion and safety, two times and a
/// host.
const TAIL: usize = 14;

/// Parses `ROBOTLASER1 laser_type start_angle field_of_view angular_resolution maximum_range
/// accuracy remission_mode num_readings [readings] num_remissions [remissions] laser_pose_x
/// laser_pose_y laser_pose_theta robot_pose_x robot_pose_y robot_pose_theta laser_tv laser_rv
/// forward_safety_dist side_safety_dist turn_axis timestamp host logger_timestamp`.
///
/// Beam i goes to `start_angle + i · angular_resolution`, from the laser's pose. Metres, radians.
pub(super) fn parse(line: &str) -> Result<Scan<impl Iterator<Item = &str>>, SkipReason> {
    let tokens = line.split_ascii_whitespace();
    let total = tokens.clone().count();
    let body = total
        .checked_sub(HEAD + 1 + TAIL)
        .ok_or(SkipReason::FieldCount)?;
    let mut head = tokens.clone().skip(2);
    let start_rad = finite(head.next(), SkipReason::BadPose)?;
    let step_rad = finite(head.nth(1), SkipReason::BadPose)?;
    // A laser that does not know its range says zero or infinity: then it sets no limit.
    let max_range_m: f64 = head
        .next()
        .and_then(|token| token.parse().ok())
        .ok_or(SkipReason::NotANumber)?;
    let readings = count(head.nth(2))?;
    // The body is readings and remissions; it is compared before anything is skipped to.
    let remissions = body.checked_sub(readings).ok_or(SkipReason::FieldCount)?;
    let mut rest = tokens.clone().skip(HEAD + readings);
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
        readings: tokens.skip(HEAD).take(readings),
    })
}

/// Parses a field that counts others.
fn count(token: Option<&str>) -> Result<usize, SkipReason> {
    let token = token.ok_or(SkipReason::FieldCount)?;
    token.parse().map_err(|_| SkipReason::NotANumber)
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_core::units::Point;

    const LINE: &str = "ROBOTLASER1 4 -1.5 3.0 1.5 20.0 0.01 1 3 1.0 20.0 3.0 2 100 200 \
                        0.5 -0.25 0.125 9 9 9 0.1 0.2 0.3 0.4 1e6 12.5 robot 0.7";

    #[test]
    fn geometry_range_pose_and_time_come_from_the_message() {
        let scan = parse(LINE).unwrap();
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
        let line = LINE.replace(" 2 100 200 ", " 0 ");
        assert_eq!(parse(&line).unwrap().origin, Point::from_mm(500, -250));
    }

    #[test]
    fn every_cut_of_the_line_is_refused() {
        let tokens: Vec<&str> = LINE.split_ascii_whitespace().collect();
        for end in 1..tokens.len() {
            let cut = tokens[..end].join(" ");
            assert_eq!(parse(&cut).err(), Some(SkipReason::FieldCount), "{cut}");
        }
    }

    #[test]
    fn an_announced_billion_is_refused_by_counting() {
        for (from, to) in [
            (" 1 3 1.0", " 1 1000000000 1.0"),
            (" 2 100", " 18446744073709551615 100"),
        ] {
            let line = LINE.replace(from, to);
            assert_ne!(line, LINE);
            assert_eq!(parse(&line).err(), Some(SkipReason::FieldCount));
        }
    }
}
