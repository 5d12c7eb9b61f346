//! The state of a board, from its telemetry.

use certainty_core::sensor::SensorId;
use certainty_core::transducer::Reading;
use certainty_core::units::Pose;
use certainty_firmware::telemetry::{
    Damage, Decoder, Drive, Frame, Head, Hello, MapState, MapView, Report, SensorHealth,
    Statistics, Tally,
};
use std::collections::BTreeMap;

/// The most cells of a map that can be reported: a part numbers its first cell in 16 bits.
const MOST_CELLS: usize = u16::MAX as usize;

/// The last reports about a sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SensorState {
    /// Its last look and reading.
    pub head: Option<Head>,
    /// Its last health report.
    pub health: Option<SensorHealth>,
}

/// Decodes the bytes of a telemetry stream, and keeps the last report of each kind.
///
/// Memory: 128 KB for the largest map, for any input.
#[derive(Debug, Clone)]
pub struct Session {
    decoder: Decoder,
    map: MapView<Vec<u8>>,
    bytes: u64,
    other_version: Option<u8>,
    agreed_at: Option<u64>,
    hello: Option<Hello>,
    pose: Option<Pose>,
    drive: Option<Drive>,
    sensors: BTreeMap<SensorId, SensorState>,
    rangers: BTreeMap<u8, Reading>,
    statistics: Option<Statistics>,
}

impl Session {
    /// Creates a session without reports.
    #[must_use]
    pub fn new() -> Self {
        Self {
            decoder: Decoder::new(),
            map: MapView::new(vec![0; MOST_CELLS], vec![0; MOST_CELLS]),
            bytes: 0,
            other_version: None,
            agreed_at: None,
            hello: None,
            pose: None,
            drive: None,
            sensors: BTreeMap::new(),
            rangers: BTreeMap::new(),
            statistics: None,
        }
    }

    /// Decodes a byte; returns the frame that it completes, or the damage of that frame.
    pub fn take(&mut self, byte: u8) -> Option<Result<Frame, Damage>> {
        self.bytes += 1;
        let frame = self.decoder.push(byte)?;
        match &frame {
            Ok(frame) => self.keep(&frame.report),
            Err(Damage::OtherVersion(version)) => self.other_version = Some(*version),
            Err(_) => {}
        }
        Some(frame)
    }

    /// Ends the stream: a frame that is not complete counts as damaged.
    pub fn finish(&mut self) {
        self.decoder.finish();
    }

    fn keep(&mut self, report: &Report) {
        self.map.take(report);
        match *report {
            Report::Hello(hello) => {
                if self.hello.is_some_and(|known| known != hello) {
                    // Another board, or another program on it.
                    self.pose = None;
                    self.drive = None;
                    self.sensors.clear();
                    self.rangers.clear();
                    self.statistics = None;
                }
                self.hello = Some(hello);
            }
            Report::Map(ref part) => {
                if part.end.is_some() && matches!(self.map.state(), MapState::Complete { .. }) {
                    self.agreed_at = Some(self.tally().frames);
                }
            }
            Report::Pose(pose) => self.pose = Some(pose),
            Report::Drive(drive) => {
                self.pose = Some(drive.pose);
                self.drive = Some(drive);
            }
            Report::Head(head) => self.sensors.entry(head.sensor).or_default().head = Some(head),
            Report::Health(health) => {
                self.sensors.entry(health.sensor).or_default().health = Some(health);
            }
            Report::Ranger(ranger) => _ = self.rangers.insert(ranger.number, ranger.reading),
            Report::Statistics(statistics) => self.statistics = Some(statistics),
        }
    }

    /// Returns the counts of received and damaged frames.
    #[must_use]
    pub const fn tally(&self) -> &Tally {
        self.decoder.tally()
    }

    /// Returns the number of bytes.
    #[must_use]
    pub const fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Returns the last unsupported version of the wire format.
    #[must_use]
    pub const fn other_version(&self) -> Option<u8> {
        self.other_version
    }

    /// Returns the map.
    #[must_use]
    pub const fn map(&self) -> &MapView<Vec<u8>> {
        &self.map
    }

    /// Returns the number of frames since the map last agreed with its digest.
    #[must_use]
    pub fn frames_since_map(&self) -> Option<u64> {
        let agreed = self.agreed_at?;
        Some(self.tally().frames - agreed)
    }

    /// Returns the board's introduction.
    #[must_use]
    pub const fn hello(&self) -> Option<Hello> {
        self.hello
    }

    /// Returns the robot's pose.
    #[must_use]
    pub const fn pose(&self) -> Option<Pose> {
        self.pose
    }

    /// Returns the last drive report.
    #[must_use]
    pub const fn drive(&self) -> Option<Drive> {
        self.drive
    }

    /// Returns every reported sensor, in the order of their numbers.
    pub fn sensors(&self) -> impl Iterator<Item = (SensorId, SensorState)> + '_ {
        self.sensors.iter().map(|(&sensor, &state)| (sensor, state))
    }

    /// Returns every ranger's last reading, in the order of their numbers.
    pub fn rangers(&self) -> impl Iterator<Item = (u8, Reading)> + '_ {
        self.rangers
            .iter()
            .map(|(&number, &reading)| (number, reading))
    }

    /// Returns the last statistics of the schedule.
    #[must_use]
    pub const fn statistics(&self) -> Option<Statistics> {
        self.statistics
    }
}

impl Default for Session {
    fn default() -> Self {
        Self::new()
    }
}
