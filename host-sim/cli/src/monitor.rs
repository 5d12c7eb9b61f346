//! `certainty monitor`: a board's telemetry, live.

use super::maps::{Mark, Panel, side_by_side};
use super::options::JsonOption;
use super::output::Failure;
use super::output::{self, Report};
use super::table::{HealthReport, counted, row, table};
use certainty_core::certainty::Certainty;
use certainty_core::fusion::Geometry;
use certainty_core::sensor::SensorId;
use certainty_core::transducer::{Finding, Missing, Reading};
use certainty_core::units::{BinaryAngle, Pose};
use certainty_firmware::telemetry::{
    self, Damage, Drive, DriveState, Frame, Hello, MapPart, MapState, Statistics, Tally,
};
use certainty_sim::monitor::{Arrival, Port, PortError, SensorState, Session};
use certainty_sim::quantity::signed_degrees;
use certainty_sim::simulation::Truth;
use clap::Args;
use core::num::{NonZeroU32, NonZeroU64};
use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;
use serde::Serialize;
use std::ffi::OsString;
use std::io::{self, IsTerminal};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::thread;
use std::time::Instant;

/// Time between two drawings of the screen, and between two checks for Ctrl-C.
const REFRESH: Duration = Duration::from_millis(100);

/// The options of `certainty monitor`.
#[derive(Debug, Args)]
#[command(mut_arg("json", |json| json
    .help("Print one JSON document at the end instead")
    .conflicts_with("plain")))]
pub(super) struct Arguments {
    /// Serial port, file, pipe, `-` for standard input, or tcp:HOST:PORT
    port: OsString,
    /// Baud rate of a serial port
    #[arg(long, value_name = "N", default_value = "115200")]
    baud: NonZeroU32,
    /// Number of reports after which to end [default: at the end of the input, or Ctrl-C]
    #[arg(long, value_name = "N")]
    frames: Option<NonZeroU64>,
    /// End when a serial port's board is unplugged, instead of waiting for it
    #[arg(long)]
    once: bool,
    /// Print a line per report, as without a terminal, instead of a live screen
    #[arg(long)]
    plain: bool,
    #[command(flatten)]
    json: JsonOption,
}

/// Why reception ended.
#[derive(Debug)]
enum Ended {
    /// End of the input.
    Input,
    /// Reading failed.
    Failed(io::Error),
    /// `--frames` reports were received.
    Frames,
    /// Ctrl-C, or a signal of the system.
    Interrupted,
    /// Stdout was closed.
    OutputClosed,
}

impl Ended {
    fn render(&self) -> String {
        match self {
            Self::Input => "end of input".into(),
            Self::Failed(error) => format!("reading failed ({error})"),
            Self::Frames => "enough frames".into(),
            Self::Interrupted => "interrupted".into(),
            Self::OutputClosed => "output closed".into(),
        }
    }
}

/// Output during reception.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Show {
    /// Nothing.
    Nothing,
    /// A line per report.
    Lines,
    /// A screen that is redrawn.
    Screen,
}

/// Receives until the end and reports.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let port = Port::from(arguments.port.clone());
    let show = if arguments.json.json {
        Show::Nothing
    } else if arguments.plain || !io::stdout().is_terminal() {
        Show::Lines
    } else {
        Show::Screen
    };
    let mut session = Session::new();
    let ended = listen(arguments, &port, show, &mut session)?;
    session.finish();
    if session.tally().frames == 0 {
        match ended {
            Ended::Input => return Err(Failure::Input(no_telemetry(&port, &session))),
            Ended::Failed(source) => {
                let port = port.to_string();
                return Err(Failure::input(&PortError::Read { port, source }));
            }
            Ended::Frames | Ended::Interrupted | Ended::OutputClosed => {}
        }
    }
    arguments.json.print(&Received {
        port,
        session,
        ended,
        show,
    })
}

/// Everything that was received until the end.
struct Received {
    port: Port,
    session: Session,
    ended: Ended,
    show: Show,
}

impl Report for Received {
    fn document(&self) -> impl Serialize {
        Document::new(&self.port, &self.session, &self.ended.render())
    }

    fn render(&self) -> String {
        let on_screen = self.show == Show::Screen;
        let start = if on_screen { HOME } else { "\n" };
        let screen = screen(&self.port, &self.session, on_screen && output::coloured());
        format!("{start}{screen}{}\n", self.ended.render())
    }
}

/// Moves the cursor to the upper left corner and clears the screen.
const HOME: &str = "\u{1b}[H\u{1b}[J";

fn listen(
    arguments: &Arguments,
    port: &Port,
    show: Show,
    session: &mut Session,
) -> Result<Ended, Failure> {
    let stop = Arc::new(AtomicBool::new(false));
    let interrupted = Arc::clone(&stop);
    ctrlc::set_handler(move || interrupted.store(true, Ordering::Relaxed))
        .map_err(|error| Failure::Internal(format!("cannot handle Ctrl-C: {error}")))?;
    let baud = arguments.baud.get();
    let (mut arrivals, is_serial) = port.listen(baud).map_err(|error| Failure::input(&error))?;
    let waits = is_serial && !arguments.once;
    let most = arguments.frames.map_or(u64::MAX, NonZeroU64::get);
    let mut drawn: Option<Instant> = None;
    loop {
        let ended = match arrivals.recv_timeout(REFRESH) {
            Ok(Arrival::Bytes(bytes)) => {
                let lines = take(&bytes, session, most, show == Show::Lines);
                if !lines.is_empty() && !output::offer(&lines)? {
                    return Ok(Ended::OutputClosed);
                }
                (session.tally().frames >= most).then_some(Ended::Frames)
            }
            Ok(Arrival::End(None)) | Err(RecvTimeoutError::Disconnected) => Some(Ended::Input),
            Ok(Arrival::End(Some(error))) => Some(Ended::Failed(error)),
            Err(RecvTimeoutError::Timeout) => None,
        };
        match ended {
            Some(Ended::Input | Ended::Failed(_)) if waits => {
                output::note(&format!("{port}: unplugged; waiting for it to come back"));
                match plugged_in(port, baud, &stop) {
                    Some(again) => arrivals = again,
                    None => return Ok(Ended::Interrupted),
                }
                output::note(&format!("{port}: back"));
            }
            Some(ended) => return Ok(ended),
            None => {}
        }
        if stop.load(Ordering::Relaxed) {
            return Ok(Ended::Interrupted);
        }
        if show == Show::Screen && drawn.is_none_or(|drawn| drawn.elapsed() >= REFRESH) {
            drawn = Some(Instant::now());
            let screen = screen(port, session, output::coloured());
            if !output::offer(&format!("{HOME}{screen}"))? {
                return Ok(Ended::OutputClosed);
            }
        }
    }
}

/// Waits until `port` can be opened again; `None` if `stop` is set meanwhile.
fn plugged_in(port: &Port, baud: u32, stop: &AtomicBool) -> Option<Receiver<Arrival>> {
    while !stop.load(Ordering::Relaxed) {
        thread::sleep(REFRESH);
        if let Ok((arrivals, _)) = port.listen(baud) {
            return Some(arrivals);
        }
    }
    None
}

/// Decodes bytes until there are `most` reports; returns a line for each report, and for each damaged frame
/// after the first report, if `wanted`.
///
/// Damage before the first report has no line, because the input may not be telemetry at all.
fn take(bytes: &[u8], session: &mut Session, most: u64, wanted: bool) -> String {
    let mut lines = String::new();
    for &byte in bytes {
        if session.tally().frames >= most {
            break;
        }
        if let Some(received) = session.take(byte)
            && wanted
            && session.tally().frames > 0
        {
            lines += &line(&received, session);
        }
    }
    lines
}

/// Returns the error of an input without any report.
fn no_telemetry(port: &Port, session: &Session) -> String {
    if let Some(version) = session.other_version() {
        let expected = telemetry::VERSION;
        return format!(
            "{port}: telemetry in version {version} of the format: expected version {expected}; use the \
             program of the firmware's release"
        );
    }
    match session.bytes() {
        0 => format!("{port}: no bytes received: expected the board's telemetry"),
        bytes => format!(
            "{port}: no complete frame in {bytes} bytes: expected the board's telemetry at the rate of \
             --baud"
        ),
    }
}

/// Everything that was received, as JSON; its fields are a contract.
#[derive(Debug, Serialize)]
struct Document {
    port: String,
    ended: String,
    bytes: u64,
    frames: u64,
    lost: u64,
    restarts: u64,
    crc_errors: u64,
    too_long: u64,
    undecodable: u64,
    truncated: u64,
    other_version: u64,
    version_heard: Option<u8>,
    round_ms: Option<u32>,
    map: Option<MapReport>,
    pose: Option<PoseReport>,
    drive: Option<DriveReport>,
    sensors: Vec<SensorReport>,
    rangers: Vec<RangerReport>,
    statistics: Option<StatisticsReport>,
}

#[derive(Debug, Serialize)]
struct MapReport {
    complete: bool,
    generation: Option<u16>,
    /// Reports since the map last matched its digest.
    frames_ago: Option<u64>,
    width: u16,
    height: u16,
    cell_mm: u32,
    x_mm: i32,
    y_mm: i32,
    /// Row after row from the lowest; empty if the map is too large.
    cells: Vec<u8>,
}

#[derive(Debug, Serialize)]
struct PoseReport {
    x_mm: i32,
    y_mm: i32,
    heading_deg: f64,
}

#[derive(Debug, Serialize)]
struct DriveReport {
    /// Of full speed, −1 to 1.
    right: f64,
    left: f64,
    conduct: String,
    to_goal_mm: u32,
}

#[derive(Debug, Serialize)]
struct SensorReport {
    id: u8,
    direction_deg: Option<f64>,
    reading: Option<ReadingReport>,
    health: Option<HealthReport>,
}

#[derive(Debug, Serialize)]
struct RangerReport {
    number: u8,
    reading: ReadingReport,
}

#[derive(Debug, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum ReadingReport {
    Echo { mm: u32 },
    NoObject,
    TooNear,
    Missing { why: &'static str },
}

#[derive(Debug, Serialize)]
struct StatisticsReport {
    round: u32,
    tick_ms: u32,
    overruns: u32,
    unsent: u32,
}

impl Document {
    fn new(port: &Port, session: &Session, ended: &str) -> Self {
        let tally = session.tally();
        let rangers = session.rangers().map(|(number, reading)| RangerReport {
            number,
            reading: reading.into(),
        });
        Self {
            port: port.to_string(),
            ended: ended.to_owned(),
            bytes: session.bytes(),
            frames: tally.frames,
            lost: tally.lost,
            restarts: tally.restarts,
            crc_errors: tally.checksum,
            too_long: tally.too_long,
            undecodable: tally.undecodable,
            truncated: tally.truncated,
            other_version: tally.other_version,
            version_heard: session.other_version(),
            round_ms: session.hello().map(|hello| hello.round_ms),
            map: MapReport::new(session),
            pose: session.pose().map(PoseReport::from),
            drive: session.drive().map(DriveReport::from),
            sensors: session.sensors().map(SensorReport::from).collect(),
            rangers: rangers.collect(),
            statistics: session.statistics().map(StatisticsReport::from),
        }
    }
}

impl MapReport {
    fn new(session: &Session) -> Option<Self> {
        let map = session.map();
        let geometry = map.geometry()?;
        let generation = match map.state() {
            MapState::Complete { generation } => Some(generation),
            MapState::Unknown | MapState::TooLarge | MapState::Incomplete => None,
        };
        Some(Self {
            complete: generation.is_some(),
            generation,
            frames_ago: session.frames_since_map(),
            width: geometry.columns(),
            height: geometry.rows(),
            cell_mm: geometry.cell_size().get(),
            x_mm: geometry.corner().x_mm(),
            y_mm: geometry.corner().y_mm(),
            cells: map.cells().map(Certainty::to_bits).collect(),
        })
    }
}

impl From<Pose> for PoseReport {
    fn from(pose: Pose) -> Self {
        Self {
            x_mm: pose.at.x_mm(),
            y_mm: pose.at.y_mm(),
            heading_deg: signed_degrees(pose.heading),
        }
    }
}

impl From<Drive> for DriveReport {
    fn from(drive: Drive) -> Self {
        Self {
            right: drive.wheels.right.to_num(),
            left: drive.wheels.left.to_num(),
            conduct: drive.state.to_string(),
            to_goal_mm: drive.to_goal.get(),
        }
    }
}

impl From<(SensorId, SensorState)> for SensorReport {
    fn from((sensor, state): (SensorId, SensorState)) -> Self {
        let direction = state.head.map(|head| head.direction);
        Self {
            id: sensor.number(),
            direction_deg: direction.map(signed_degrees),
            reading: state.head.map(|head| head.reading.into()),
            health: state.health.as_ref().map(HealthReport::from),
        }
    }
}

impl From<Reading> for ReadingReport {
    fn from(reading: Reading) -> Self {
        match reading {
            Reading::Echo(distance) => Self::Echo { mm: distance.get() },
            Reading::NoObject => Self::NoObject,
            Reading::TooNear => Self::TooNear,
            Reading::Missing(why) => Self::Missing { why: reason(why) },
        }
    }
}

impl From<Statistics> for StatisticsReport {
    fn from(statistics: Statistics) -> Self {
        Self {
            round: statistics.round,
            tick_ms: statistics.tick.get(),
            overruns: statistics.overruns,
            unsent: statistics.unsent,
        }
    }
}

/// Largest width and height of a map that is drawn, in cells.
const DRAWN: (u16, u16) = (160, 100);

/// Renders a frame in a line, after a line for frames lost before it.
fn line(received: &Result<Frame, Damage>, session: &Session) -> String {
    match received {
        Ok(frame) => {
            let lost = match frame.lost {
                0 => String::new(),
                lost => format!("      {} lost\n", counted(lost.into(), "frame")),
            };
            let report = report(&frame.report, session);
            format!("{lost}{:>5} {report}\n", frame.sequence)
        }
        Err(damage) => format!("      a damaged frame: {damage}\n"),
    }
}

fn report(report: &telemetry::Report, session: &Session) -> String {
    match report {
        telemetry::Report::Hello(hello) => format!("hello: {}", hello_text(hello)),
        telemetry::Report::Map(part) => map_part(part, session.map().state()),
        telemetry::Report::Pose(pose) => format!("pose: {}", place(pose)),
        telemetry::Report::Head(head) => format!(
            "sensor {} at {}: {}{}",
            head.sensor,
            degrees(head.direction),
            reading_text(head.reading),
            finding_text(head.finding)
        ),
        telemetry::Report::Health(health) => {
            let [confidence, confirmed, contradicted, missing, status] =
                HealthReport::from(health).cells();
            format!(
                "sensor {} is {status} ({confidence}): {confirmed} confirmed, \
                 {contradicted} contradicted, {missing} missing",
                health.sensor
            )
        }
        telemetry::Report::Ranger(ranger) => {
            format!("ranger {}: {}", ranger.number, reading_text(ranger.reading))
        }
        telemetry::Report::Statistics(statistics) => schedule(statistics),
        telemetry::Report::Drive(drive) => format!("drive: {}", drive_line(drive)),
    }
}

fn hello_text(hello: &Hello) -> String {
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

fn drive_line(drive: &Drive) -> String {
    let action = match drive.state {
        DriveState::Lost | DriveState::Restarted => ": start it by hand",
        _ => "",
    };
    format!(
        "{}, wheels {:.2} right, {:.2} left, {}{action}, {} to the goal",
        place(&drive.pose),
        drive.wheels.right,
        drive.wheels.left,
        drive.state,
        drive.to_goal
    )
}

/// Renders an angle from −180 to 180 degrees.
fn degrees(angle: BinaryAngle) -> String {
    format!("{:.1}deg", signed_degrees(angle))
}

fn reading_text(reading: Reading) -> String {
    match reading {
        Reading::Echo(distance) => distance.to_string(),
        Reading::NoObject => "no object".into(),
        Reading::TooNear => "too near".into(),
        Reading::Missing(why) => format!("missing, {why}"),
    }
}

/// Renders the validation's finding about a reading; empty for a plausible one.
fn finding_text(finding: Finding) -> String {
    match finding {
        Finding::Plausible | Finding::Missing => String::new(),
        Finding::Jump | Finding::OutOfRange | Finding::StuckAt => format!(" ({finding})"),
    }
}

/// Returns the reason of a missing reading in one word.
const fn reason(why: Missing) -> &'static str {
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

/// Renders everything that was received, the map first.
fn screen(port: &Port, session: &Session, coloured: bool) -> String {
    let mut text = match session.hello() {
        Some(hello) => format!("{port}: {}\n\n", hello_text(&hello)),
        None => format!("{port}: waiting for a hello\n\n"),
    };
    text += &map(session, coloured);
    if let Some(drive) = session.drive() {
        text += &format!("robot: {}\n", drive_line(&drive));
    } else if let Some(pose) = session.pose() {
        text += &format!("robot: {}\n", place(&pose));
    }
    text += &readings(session);
    text += &health(session);
    if let Some(statistics) = session.statistics() {
        text += &format!("{}\n", schedule(&statistics));
    }
    text += &tally_text(session.tally(), session.bytes());
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
        MapState::TooLarge => return "the map is too large to receive\n\n".into(),
    };
    if !is_drawn(&geometry) {
        return format!("{title}; it is too large to draw\n\n");
    }
    let marks = session.map().cells();
    let marks = marks.map(|cell| Mark::of(cell, Truth::Unseen)).collect();
    let panel = Panel { title, marks };
    side_by_side(&geometry, &[panel], coloured)
}

const fn is_drawn(geometry: &Geometry) -> bool {
    geometry.columns() <= DRAWN.0 && geometry.rows() <= DRAWN.1
}

fn readings(session: &Session) -> String {
    let mut rows = vec![row(["sensor", "direction", "reading"])];
    for (sensor, state) in session.sensors() {
        if let Some(head) = state.head {
            let direction = degrees(head.direction);
            rows.push(vec![
                sensor.to_string(),
                direction,
                reading_text(head.reading),
            ]);
        }
    }
    for (number, reading) in session.rangers() {
        rows.push(vec![
            format!("ranger {number}"),
            "-".into(),
            reading_text(reading),
        ]);
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

/// Renders a table and a blank line; empty if there are only headings.
fn filled(rows: &[Vec<String>]) -> String {
    if rows.len() > 1 {
        table(rows) + "\n"
    } else {
        String::new()
    }
}

fn tally_text(tally: &Tally, bytes: u64) -> String {
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

    /// A board that was unplugged was the end of the input.
    ///
    /// In this process: a child would inherit the board's end of the line and keep it open.
    #[cfg(unix)]
    #[test]
    fn an_unplugged_board_is_waited_for() {
        use certainty_core::units::Point;
        use certainty_firmware::telemetry::{Encoder, FRAME, Report};
        use serialport::{SerialPort, TTYPort};
        use std::io::Write;
        use std::os::unix::fs::symlink;

        let folder = tempfile::tempdir().unwrap();
        let name = folder.path().join("board");
        // The board's end of the line, and the program's as `board`.
        let plug = || {
            let (board, host) = TTYPort::pair().unwrap();
            let _ = std::fs::remove_file(&name); // there is none at first
            symlink(host.name().unwrap(), &name).unwrap();
            (board, host)
        };
        let mut frame = [0; FRAME];
        let pose = Report::Pose(Pose::new(Point::ORIGIN, BinaryAngle::ZERO));
        let bytes = Encoder::new().encode(&pose, &mut frame).unwrap();
        let arguments = Arguments {
            port: name.clone().into(),
            baud: NonZeroU32::new(115_200).unwrap(),
            frames: NonZeroU64::new(2),
            once: false,
            plain: false,
            json: JsonOption { json: true },
        };

        let (mut board, host) = plug();
        let port = Port::from(arguments.port.clone());
        let monitor = thread::spawn(move || {
            let mut session = Session::new();
            let ended = listen(&arguments, &port, Show::Nothing, &mut session);
            (ended.unwrap(), session.tally().frames)
        });
        thread::sleep(Duration::from_millis(300));
        board.write_all(bytes).unwrap();
        thread::sleep(Duration::from_millis(300));
        drop((board, host));
        thread::sleep(Duration::from_millis(300));
        assert!(!monitor.is_finished(), "it waits");
        let (mut board, _host) = plug();
        // What is sent before the port is open again may be lost.
        while !monitor.is_finished() {
            board.write_all(bytes).unwrap();
            thread::sleep(Duration::from_millis(50));
        }
        let (ended, frames) = monitor.join().unwrap();
        assert!(matches!(ended, Ended::Frames), "{ended:?}");
        assert_eq!(frames, 2);
    }

    #[test]
    fn angles_are_from_minus_180_to_180() {
        let text = |mdeg| degrees(BinaryAngle::from_millidegrees(mdeg));
        assert_eq!(text(-90_000), "-90.0deg");
        assert_eq!(text(45_000), "45.0deg");
        assert_eq!(text(350_000), "-10.0deg");
    }
}
