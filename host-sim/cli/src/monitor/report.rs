//! What a monitor reports as JSON; its fields are a contract.

use super::super::health::HealthReport;
use super::words::{reason, signed_degrees};
use certainty_core::certainty::Certainty;
use certainty_core::sensor::SensorId;
use certainty_core::transducer::Reading;
use certainty_core::units::Pose;
use certainty_firmware::telemetry::{Drive, MapState, Statistics};
use certainty_sim::monitor::{Port, SensorState, Session};
use serde::Serialize;

/// Everything that was heard, and what was not.
#[derive(Debug, Serialize)]
pub(super) struct Document {
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
    /// Reports since the map last agreed with its digest.
    frames_ago: Option<u64>,
    width: u16,
    height: u16,
    cell_mm: u32,
    x_mm: i32,
    y_mm: i32,
    /// Row after row from the lowest; none if the map is too large.
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
    /// Parts of full speed.
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
    pub(super) fn new(port: &Port, session: &Session, ended: &str) -> Self {
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
            conduct: drive.conduct.to_string(),
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
