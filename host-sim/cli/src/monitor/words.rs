//! Telemetry in words: a line a report, and all of it on a screen.

use super::super::health::HealthReport;
use super::super::panels::{Mark, Panel, side_by_side};
use super::super::table::{row, table};
use certainty_core::fusion::Geometry;
use certainty_core::transducer::{Finding, Missing, Reading};
use certainty_core::units::{BinaryAngle, Pose};
use certainty_firmware::telemetry::{
    Damage, Drive, DriveState, Frame, Hello, MapPart, MapState, Report, Statistics, Tally,
};
use certainty_sim::monitor::{Port, Session};
use certainty_sim::simulation::Truth;

/// The widest and the highest map that is drawn, in cells.
const DRAWN: (u16, u16) = (160, 100);

/// What was heard, in a line; one more before it where frames were lost.
pub(super) fn line(heard: &Result<Frame, Damage>, session: &Session) -> String {
    match heard {
        Ok(frame) => {
            let lost = match frame.lost {
                0 => String::new(),
                1 => "      1 frame lost\n".into(),
                lost => format!("      {lost} frames lost\n"),
            };
            let report = report(&frame.report, session);
            format!("{lost}{:>5} {report}\n", frame.sequence)
        }
        Err(damage) => format!("      a frame is {damage}\n"),
    }
}

fn report(report: &Report, session: &Session) -> String {
    match report {
        Report::Hello(hello) => format!("hello: {}", announced(hello)),
        Report::Map(part) => map_part(part, session.map().state()),
        Report::Pose(pose) => format!("pose: {}", place(pose)),
        Report::Head(head) => format!(
            "sensor {} at {}: {}{}",
            head.sensor,
            degrees(head.direction),
            said(head.reading),
            found(head.finding)
        ),
        Report::Health(health) => {
            let [confidence, confirmed, contradicted, missing, status] =
                HealthReport::from(health).cells();
            format!(
                "sensor {} is {status} ({confidence}): {confirmed} confirmed, \
                 {contradicted} contradicted, {missing} missing",
                health.sensor
            )
        }
        Report::Ranger(ranger) => format!("ranger {}: {}", ranger.number, said(ranger.reading)),
        Report::Statistics(statistics) => schedule(statistics),
        Report::Drive(drive) => format!("drive: {}", driven(drive)),
    }
}

fn announced(hello: &Hello) -> String {
    let geometry = &hello.geometry;
    format!(
        "{} x {} cells of {}, {} sensors, {} rangers, a round of {} ms",
        geometry.columns(),
        geometry.rows(),
        geometry.cell_size(),
        hello.sensors,
        hello.rangers,
        hello.round_ms
    )
}

fn map_part(part: &MapPart, state: MapState) -> String {
    let first = usize::from(part.start);
    let cells = match part.cells.len() {
        0 => "nothing changed".to_owned(),
        1 => format!("cell {first}"),
        count => format!("cells {first} to {}", first + count - 1),
    };
    let whole = match (part.end, state) {
        (None, _) => "",
        (Some(_), MapState::Complete { .. }) => ", complete",
        (Some(_), _) => ", incomplete",
    };
    format!("map {}: {cells}{whole}", part.generation)
}

fn place(pose: &Pose) -> String {
    let (x, y) = (pose.at.x_mm(), pose.at.y_mm());
    format!("x {x}mm, y {y}mm, {}", degrees(pose.heading))
}

fn driven(drive: &Drive) -> String {
    let asks = match drive.conduct {
        DriveState::Lost | DriveState::Restarted => ": start it by hand",
        _ => "",
    };
    format!(
        "{}, wheels {:.2} right, {:.2} left, {}{asks}, {} to the goal",
        place(&drive.pose),
        drive.wheels.right,
        drive.wheels.left,
        drive.conduct,
        drive.to_goal
    )
}

/// An angle from −180 to 180 degrees.
fn degrees(angle: BinaryAngle) -> String {
    format!("{:.1}deg", signed_degrees(angle))
}

/// An angle in degrees, from −180 to less than 180.
pub(super) fn signed_degrees(angle: BinaryAngle) -> f64 {
    f64::from(angle.to_bits().cast_signed()) * 360.0 / 65536.0
}

fn said(reading: Reading) -> String {
    match reading {
        Reading::Echo(distance) => distance.to_string(),
        Reading::NoObject => "no object".into(),
        Reading::TooNear => "too near".into(),
        Reading::Missing(why) => format!("missing, {why}"),
    }
}

/// What the validation has to say about a reading that came; nothing about a plausible one.
fn found(finding: Finding) -> String {
    match finding {
        Finding::Plausible | Finding::Missing => String::new(),
        Finding::Jump | Finding::OutOfRange | Finding::StuckAt => format!(" ({finding})"),
    }
}

/// Why a reading is missing, in one word.
pub(super) const fn reason(why: Missing) -> &'static str {
    match why {
        Missing::Timeout => "timeout",
        Missing::Bus => "bus",
        Missing::Implausible => "implausible",
        Missing::Late => "late",
    }
}

fn schedule(statistics: &Statistics) -> String {
    format!(
        "round {} at {:.1} s: {} slots overrun, {} frames unsent",
        statistics.round,
        f64::from(statistics.tick.get()) / 1e3,
        statistics.overruns,
        statistics.unsent
    )
}

/// Everything that is known, the map first.
pub(super) fn screen(port: &Port, session: &Session, coloured: bool) -> String {
    let mut text = match session.hello() {
        Some(hello) => format!("{port}: {}\n\n", announced(&hello)),
        None => format!("{port}: waiting for a hello\n\n"),
    };
    text += &map(session, coloured);
    if let Some(drive) = session.drive() {
        text += &format!("robot: {}\n", driven(&drive));
    } else if let Some(pose) = session.pose() {
        text += &format!("robot: {}\n", place(&pose));
    }
    text += &looks(session);
    text += &health(session);
    if let Some(statistics) = session.statistics() {
        text += &format!("{}\n", schedule(&statistics));
    }
    text += &heard(session.tally(), session.bytes());
    text
}

fn map(session: &Session, coloured: bool) -> String {
    let Some(geometry) = session.map().geometry() else {
        return String::new();
    };
    let title = match session.map().state() {
        MapState::Complete { generation } => format!("map {generation}, complete"),
        MapState::Incomplete => "map incomplete: cells may be missing or old".into(),
        MapState::Unknown => return String::new(),
        MapState::TooLarge => return "the map is too large to be received\n\n".into(),
    };
    if !is_drawn(&geometry) {
        return format!("{title}; it is too large to be drawn\n\n");
    }
    let marks = session.map().cells();
    let marks = marks.map(|cell| Mark::of(cell, Truth::Unseen)).collect();
    let panel = Panel { title, marks };
    side_by_side(&geometry, &[panel], coloured)
}

const fn is_drawn(geometry: &Geometry) -> bool {
    geometry.columns() <= DRAWN.0 && geometry.rows() <= DRAWN.1
}

fn looks(session: &Session) -> String {
    let mut rows = vec![row(["sensor", "looks", "said"])];
    for (sensor, state) in session.sensors() {
        if let Some(head) = state.head {
            let looks = degrees(head.direction);
            rows.push(vec![sensor.to_string(), looks, said(head.reading)]);
        }
    }
    for (number, reading) in session.rangers() {
        rows.push(vec![format!("ranger {number}"), "-".into(), said(reading)]);
    }
    filled(&rows)
}

fn health(session: &Session) -> String {
    let mut rows = vec![[row(["sensor"]), row(HealthReport::COLUMNS)].concat()];
    for (sensor, state) in session.sensors() {
        if let Some(health) = state.health {
            let mut cells = vec![sensor.to_string()];
            cells.extend(HealthReport::from(&health).cells());
            rows.push(cells);
        }
    }
    filled(&rows)
}

/// A table and a blank line, unless it has only heads.
fn filled(rows: &[Vec<String>]) -> String {
    if rows.len() > 1 {
        table(rows) + "\n"
    } else {
        String::new()
    }
}

fn heard(tally: &Tally, bytes: u64) -> String {
    let mut text = format!(
        "{} frames in {bytes} bytes; {} lost, {} damaged",
        tally.frames, tally.lost, tally.checksum
    );
    let rare = [
        (tally.too_long, "too long"),
        (tally.undecodable, "not a report"),
        (tally.other_version, "in another version"),
        (tally.truncated, "cut off"),
        (tally.restarts, "restarts"),
    ];
    for (count, what) in rare {
        if count > 0 {
            text += &format!(", {count} {what}");
        }
    }
    text + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_told_the_short_way_round() {
        let told = |mdeg| degrees(BinaryAngle::from_millidegrees(mdeg));
        assert_eq!(told(-90_000), "-90.0deg");
        assert_eq!(told(45_000), "45.0deg");
        assert_eq!(told(350_000), "-10.0deg");
    }
}
