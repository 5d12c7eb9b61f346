//! The outcome of a run: the car's reports, what the backend measured, or an error.

use crate::bench::GroundTruth;
use certainty_core::certainty::Certainty;
use certainty_core::fusion::Geometry;
use certainty_core::transducer::{Missing, Reading};
use certainty_firmware::digest::Digest;
use certainty_firmware::smart_car::{CELLS, HEADS, STATIONS};
use certainty_firmware::telemetry::{
    Decoder, Drive, MapState, MapView, Report, SensorHealth, Statistics, Tally,
};
use serde::Serialize;
use std::path::PathBuf;
use thiserror::Error;

/// The reports that a board sent on its serial line: map, sensors, drive and schedule.
///
/// Contains nothing that a receiver of the real car's telemetry would not have.
#[derive(Debug, Clone)]
pub struct Received {
    decoder: Decoder,
    map: MapView<[u8; CELLS]>,
    sensors: [ReceivedSensor; STATIONS],
    drives: Vec<Drive>,
    statistics: Statistics,
}

/// The reports about one sensor.
#[derive(Debug, Clone, Copy, Default)]
pub struct ReceivedSensor {
    /// Its last health report.
    pub health: Option<SensorHealth>,
    /// Its last reading.
    pub reading: Option<Reading>,
    /// Missing readings by reason.
    pub missing: MissingCounts,
}

/// Numbers of missing readings by reason.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct MissingCounts {
    /// The sensor did not answer in time.
    pub timeout: u32,
    /// Its line, or its servo's, failed.
    pub bus: u32,
    /// Its answer was implausible.
    pub implausible: u32,
    /// Its slot came too late.
    pub late: u32,
}

impl MissingCounts {
    const fn take(&mut self, why: Missing) {
        let count = match why {
            Missing::Timeout => &mut self.timeout,
            Missing::Bus => &mut self.bus,
            Missing::Implausible => &mut self.implausible,
            Missing::Late => &mut self.late,
        };
        *count = count.saturating_add(1);
    }
}

impl ReceivedSensor {
    fn take(&mut self, reading: Reading) {
        self.reading = Some(reading);
        if let Reading::Missing(why) = reading {
            self.missing.take(why);
        }
    }
}

impl Default for Received {
    fn default() -> Self {
        Self {
            decoder: Decoder::new(),
            map: MapView::new([0; CELLS], [0; CELLS]),
            sensors: [ReceivedSensor::default(); STATIONS],
            drives: Vec::new(),
            statistics: Statistics::default(),
        }
    }
}

impl Received {
    /// Decodes bytes of the serial line, in portions of any size.
    pub fn take(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            if let Some(Ok(frame)) = self.decoder.push(byte) {
                self.take_report(&frame.report);
            }
        }
    }

    fn take_report(&mut self, report: &Report) {
        self.map.take(report);
        match report {
            Report::Head(head) => self.reading(head.sensor.slot(), head.reading),
            Report::Ranger(ranger) => {
                let slot = usize::from(HEADS) + usize::from(ranger.number).saturating_sub(1);
                self.reading(slot, ranger.reading);
            }
            Report::Health(health) => {
                if let Some(sensor) = self.sensors.get_mut(health.sensor.slot()) {
                    sensor.health = Some(*health);
                }
            }
            Report::Statistics(statistics) => self.statistics = *statistics,
            Report::Drive(drive) => self.drives.push(*drive),
            Report::Hello(_) | Report::Map(_) | Report::Pose(_) => {}
        }
    }

    fn reading(&mut self, slot: usize, reading: Reading) {
        if let Some(sensor) = self.sensors.get_mut(slot) {
            sensor.take(reading);
        }
    }

    /// Returns the last statistics of the schedule.
    #[must_use]
    pub const fn statistics(&self) -> Statistics {
        self.statistics
    }

    /// Returns the reports about each sensor, in the order of their numbers.
    #[must_use]
    pub const fn sensors(&self) -> &[ReceivedSensor; STATIONS] {
        &self.sensors
    }

    /// Returns the drive report of each round.
    #[must_use]
    pub fn drives(&self) -> &[Drive] {
        &self.drives
    }

    /// Returns the counts of received and damaged frames.
    #[must_use]
    pub const fn tally(&self) -> &Tally {
        self.decoder.tally()
    }

    /// Returns the map's geometry and cells, row after row from the lowest; `None` unless its digest
    /// agrees.
    #[must_use]
    pub fn map(&self) -> Option<(Geometry, Vec<Certainty>)> {
        match self.map.state() {
            MapState::Complete { .. } => Some((self.map.geometry()?, self.map.cells().collect())),
            MapState::Unknown | MapState::TooLarge | MapState::Incomplete => None,
        }
    }

    /// Returns a digest of the map's cells; `None` unless the map's own digest agrees.
    #[must_use]
    pub fn grid_hash(&self) -> Option<u32> {
        let (_, cells) = self.map()?;
        let mut digest = Digest::NEW;
        cells
            .iter()
            .for_each(|cell| digest.bytes(&[cell.to_bits()]));
        Some(digest.value())
    }
}

/// The memory that an image needs before its first instruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Sizes {
    /// Code, constants and the initial values of variables.
    pub flash_bytes: u32,
    /// Variables, without the stack.
    pub static_ram_bytes: u32,
}

/// What a backend measured besides the car's reports.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RunDetails {
    /// The memory that the image needs, where there is one.
    pub sizes: Option<Sizes>,
    /// The deepest stack, in bytes, where the backend can measure it.
    pub stack_bytes: Option<u32>,
    /// The true pose of the car in each round.
    pub ground_truth: Vec<GroundTruth>,
}

/// Why the application could not be run to its end; displays as one line.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum BackendError {
    /// There is no image to run.
    #[error(
        "{}: no firmware image: {why}; build it with `cargo firmware`, or name one with --image",
        path.display()
    )]
    NoImage {
        /// The path that was tried.
        path: PathBuf,
        /// The error of the operating system.
        why: String,
    },
    /// A file that is no image.
    #[error("{}: no image for this board: {why}; build one with `cargo firmware`", path.display())]
    BadImage {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        why: String,
    },
    /// QEMU is not installed.
    #[error("there is no qemu-system-arm: install it with `sudo apt-get install qemu-system-arm`")]
    NoQemu,
    /// QEMU could not be started.
    #[error("qemu-system-arm cannot be started: {0}")]
    Qemu(String),
    /// The emulator ended before the last round.
    #[error(
        "the emulator ended before the last round; build its image again with `cargo firmware`"
    )]
    Ended,
    /// The emulator sent nothing for too long.
    #[error(
        "the emulator stopped sending before the last round; build its image again with `cargo firmware`"
    )]
    Timeout,
    /// The image uses another protocol.
    #[error("the image uses an unknown protocol: build it again with `cargo firmware`")]
    UnknownProtocol,
    /// The application refused its configuration, which would be a defect of this program.
    #[error("the application refused its configuration")]
    Refused,
    /// The emulated board was left out of this program.
    #[error(
        "this program was built without the emulated board: build it with its default features"
    )]
    NoBoard,
    /// The emulated board failed.
    #[error("the emulated board: {0}")]
    Board(String),
}
