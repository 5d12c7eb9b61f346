//! What the car reported: its map, its sensors and how its schedule fared.

use certainty_core::certainty::Certainty;
use certainty_core::fusion::Geometry;
use certainty_core::transducer::{Missing, Reading};
use certainty_firmware::digest::Digest;
use certainty_firmware::smart_car::{CELLS, HEADS, STATIONS};
use certainty_firmware::telemetry::{
    Decoder, Drive, MapState, MapView, Report, SensorHealth, Statistics, Tally,
};

/// Everything that came out of a board's serial line, put together.
///
/// It is what any receiver of the real car's telemetry could know, and nothing else.
#[derive(Debug, Clone)]
pub struct Received {
    decoder: Decoder,
    map: MapView<[u8; CELLS]>,
    sensors: [Heard; STATIONS],
    drives: Vec<Drive>,
    statistics: Statistics,
}

/// What came of one sensor.
#[derive(Debug, Clone, Copy, Default)]
pub struct Heard {
    /// Its record, as last reported.
    pub health: Option<SensorHealth>,
    /// Its last reading.
    pub reading: Option<Reading>,
    /// Readings that were missing, by their reasons.
    pub missing: MissingCounts,
}

/// How many readings were missing for which reason.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct MissingCounts {
    /// The sensor did not answer in time.
    pub timeout: u32,
    /// Its line, or its servo's, failed.
    pub bus: u32,
    /// Its answer could not be.
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

impl Heard {
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
            sensors: [Heard::default(); STATIONS],
            drives: Vec::new(),
            statistics: Statistics::default(),
        }
    }
}

impl Received {
    /// Takes bytes of the serial line, in any portions.
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
                if let Some(heard) = self.sensors.get_mut(health.sensor.slot()) {
                    heard.health = Some(*health);
                }
            }
            Report::Statistics(statistics) => self.statistics = *statistics,
            Report::Drive(drive) => self.drives.push(*drive),
            Report::Hello(_) | Report::Map(_) | Report::Pose(_) => {}
        }
    }

    fn reading(&mut self, slot: usize, reading: Reading) {
        if let Some(heard) = self.sensors.get_mut(slot) {
            heard.take(reading);
        }
    }

    /// Returns how the schedule fared, as last reported.
    #[must_use]
    pub const fn statistics(&self) -> Statistics {
        self.statistics
    }

    /// Returns what came of each sensor, in the order of their numbers.
    #[must_use]
    pub const fn sensors(&self) -> &[Heard; STATIONS] {
        &self.sensors
    }

    /// Returns how the car drove, a round after the other.
    #[must_use]
    pub fn drives(&self) -> &[Drive] {
        &self.drives
    }

    /// Returns what was lost on the line.
    #[must_use]
    pub const fn tally(&self) -> &Tally {
        self.decoder.tally()
    }

    /// Returns the map, if its digest agrees: its geometry and its cells, row after row from the
    /// lowest.
    #[must_use]
    pub fn map(&self) -> Option<(Geometry, Vec<Certainty>)> {
        match self.map.state() {
            MapState::Complete { .. } => Some((self.map.geometry()?, self.map.cells().collect())),
            MapState::Unknown | MapState::TooLarge | MapState::Incomplete => None,
        }
    }

    /// Returns a digest of the map's cells; `None` while no right map is there.
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
