//! What can be reported.

use super::wire;
use certainty_control::{SpeedLimit, Wheels};
use certainty_core::certainty::Certainty;
use certainty_core::fusion::Geometry;
use certainty_core::health::{Confidence, Health, Status};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::{Finding, Reading};
use certainty_core::units::{BinaryAngle, Millimeters, Pose, Ticks};
use core::fmt;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Most cells in a part of a map: four parts hold the Smart Car's 187.
pub const PART_CELLS: usize = WINDOW as usize;

/// [`PART_CELLS`] as a cell's index.
pub(super) const WINDOW: u16 = 48;

/// One report: what a frame carries.
///
/// The order of the variants and of their fields is the wire format; whoever changes it raises
/// [`VERSION`](super::VERSION).
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Report {
    /// Who reports, before every keyframe of the map.
    Hello(Hello),
    /// A part of the map.
    Map(MapPart),
    /// Where the robot is in the map's frame.
    Pose(#[serde(with = "wire::WirePose")] Pose),
    /// Where a pivoted sensor looked, and what it said.
    Head(Head),
    /// The record of a sensor.
    Health(SensorHealth),
    /// What a fixed ranger said.
    Ranger(Ranger),
    /// How the schedule fares.
    Statistics(Statistics),
    /// How the robot drives.
    Drive(Drive),
}

/// Who reports: the grid that the map parts fill, and what looks into it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hello {
    /// The grid's size and place.
    #[serde(with = "wire::geometry")]
    pub geometry: Geometry,
    /// How many pivoted sensors there are.
    #[serde(with = "wire::number")]
    pub sensors: u8,
    /// How many fixed rangers there are.
    #[serde(with = "wire::number")]
    pub rangers: u8,
    /// How long a round of the schedule takes, in milliseconds.
    #[serde(with = "wire::number")]
    pub round_ms: u32,
}

/// A run of neighbouring cells, row after row from the lowest.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct MapPart {
    /// The pass through the grid that this part belongs to; counts up and wraps.
    #[serde(with = "wire::number")]
    pub generation: u16,
    /// The first cell's index.
    #[serde(with = "wire::number")]
    pub start: u16,
    /// The cells' certainties as bytes; see [`MapPart::certainties`].
    pub cells: Vec<u8, PART_CELLS, u8>,
    /// What the map is to be, in the last part of a generation.
    pub end: Option<MapEnd>,
}

impl MapPart {
    /// Returns the cells' certainties.
    #[must_use]
    pub fn certainties(&self) -> impl ExactSizeIterator<Item = Certainty> + '_ {
        self.cells.iter().map(|&bits| Certainty::from_bits(bits))
    }
}

/// What the whole map is after a generation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct MapEnd {
    /// How many cells the map has.
    #[serde(with = "wire::number")]
    pub cells: u16,
    /// A digest of the grid's geometry and all its cells.
    #[serde(with = "postcard::fixint::le")]
    pub digest: u32,
}

/// Where a pivoted sensor looked, and what it said.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Head {
    /// The sensor.
    #[serde(with = "wire::sensor")]
    pub sensor: SensorId,
    /// The direction as seen from the robot: 0 ahead, counter-clockwise.
    #[serde(with = "wire::angle")]
    pub direction: BinaryAngle,
    /// What it said.
    #[serde(with = "wire::WireReading")]
    pub reading: Reading,
    /// What the local validation found.
    #[serde(with = "wire::WireFinding")]
    pub finding: Finding,
}

/// The record of a sensor, as [`Health`] keeps it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct SensorHealth {
    /// The sensor.
    #[serde(with = "wire::sensor")]
    pub sensor: SensorId,
    /// The conclusion.
    #[serde(with = "wire::WireStatus")]
    pub status: Status,
    /// How far it is trusted.
    #[serde(with = "wire::confidence")]
    pub confidence: Confidence,
    /// Readings that came.
    #[serde(with = "wire::number")]
    pub readings: u32,
    /// Readings that did not.
    #[serde(with = "wire::number")]
    pub missing: u32,
    /// Cells on which another sensor agreed.
    #[serde(with = "wire::number")]
    pub confirmations: u32,
    /// Cells on which another sensor disagreed.
    #[serde(with = "wire::number")]
    pub contradictions: u32,
}

impl SensorHealth {
    /// Returns the report of `sensor`'s `health`.
    #[must_use]
    pub const fn new(sensor: SensorId, health: &Health) -> Self {
        Self {
            sensor,
            status: health.status(),
            confidence: health.confidence(),
            readings: health.readings(),
            missing: health.missing(),
            confirmations: health.confirmations(),
            contradictions: health.contradictions(),
        }
    }
}

/// What a fixed ranger said.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Ranger {
    /// The ranger's number, from 1.
    #[serde(with = "wire::number")]
    pub number: u8,
    /// What it said.
    #[serde(with = "wire::WireReading")]
    pub reading: Reading,
}

/// How the schedule fares.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Statistics {
    /// Rounds completed since the start; saturates.
    #[serde(with = "wire::number")]
    pub round: u32,
    /// The schedule's clock.
    #[serde(with = "wire::ticks")]
    pub tick: Ticks,
    /// Slots that did not end in time since the start; saturates.
    #[serde(with = "wire::number")]
    pub overruns: u32,
    /// Frames that found no room in the outbox since the start; saturates.
    #[serde(with = "wire::number")]
    pub unsent: u32,
}

/// How the robot drives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Drive {
    /// Where it believes to have been when its sensors looked, in the map's frame.
    #[serde(with = "wire::WirePose")]
    pub pose: Pose,
    /// What its wheels are told from now on, in parts of full speed.
    #[serde(with = "wire::WireWheels")]
    pub wheels: Wheels,
    /// Why it does so.
    pub conduct: DriveState,
    /// How far the goal is from its pose.
    #[serde(with = "wire::millimeters")]
    pub to_goal: Millimeters,
}

/// Why the robot drives as it does, or does not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum DriveState {
    /// It stands and looks around, as it does at first.
    #[default]
    Looking,
    /// It goes as fast as its behaviours want: [`SpeedLimit::None`].
    Going,
    /// [`SpeedLimit::Arrived`]: it stands.
    Arrived,
    /// [`SpeedLimit::Slowed`].
    Slowed,
    /// [`SpeedLimit::Blind`]: it stands.
    Blind,
    /// [`SpeedLimit::NoWay`]: it turns on the spot.
    NoWay,
    /// A slot of the round was skipped, or nothing was decided in it: it stands for this round.
    Late,
    /// A motor cannot be told what to do: it stands, as far as it can be told.
    Refused,
    /// It moved and cannot know how far: it stands until it is started by hand.
    Lost,
    /// Nobody started it but itself, so that it knows no place: it stands until it is started by hand.
    Restarted,
}

impl From<SpeedLimit> for DriveState {
    fn from(caution: SpeedLimit) -> Self {
        match caution {
            SpeedLimit::None => Self::Going,
            SpeedLimit::Arrived => Self::Arrived,
            SpeedLimit::Slowed => Self::Slowed,
            SpeedLimit::Blind => Self::Blind,
            SpeedLimit::NoWay => Self::NoWay,
        }
    }
}

impl fmt::Display for DriveState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Looking => "looking around",
            Self::Going => "going",
            Self::Arrived => "arrived",
            Self::Slowed => "slowed",
            Self::Blind => "blind",
            Self::NoWay => "no way",
            Self::Late => "late",
            Self::Refused => "motor refused",
            Self::Lost => "lost",
            Self::Restarted => "restarted",
        })
    }
}
