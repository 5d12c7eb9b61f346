//! The reports and their wire form.
//!
//! Enumerations without numbers have the core's own serde form. The wire form of types with numbers is defined
//! here: all integers share one encoder, which takes less flash than the core's form. Values that no core type
//! can hold are refused when they are decoded.

use certainty_control::{Effort, SpeedLimit, Wheels};
use certainty_core::fusion::Geometry;
use certainty_core::health::{Confidence, Health, Status};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::{Finding, Missing, Reading};
use certainty_core::units::{BinaryAngle, Millimeters, Point, Pose, Ticks};
use core::fmt;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Most cells in a part of a map: four parts hold the Smart Car's 187.
pub const PART_CELLS: usize = WINDOW as usize;

/// [`PART_CELLS`] as a cell's index.
pub(super) const WINDOW: u16 = 48;

/// One report: what a frame carries.
///
/// The order of the variants and of their fields is the wire format; a change needs a new
/// [`VERSION`](super::VERSION).
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Report {
    /// The sender's grid and sensors; sent before every keyframe of the map.
    Hello(Hello),
    /// A part of the map.
    Map(MapPart),
    /// The robot's pose in the map's frame.
    Pose(#[serde(with = "WirePose")] Pose),
    /// Direction and reading of a pivoted sensor.
    Head(Head),
    /// The health of a sensor.
    Health(SensorHealth),
    /// The reading of a fixed ranger.
    Ranger(Ranger),
    /// Counts of the schedule and the outbox.
    Statistics(Statistics),
    /// Pose, speed and state of the drive.
    Drive(Drive),
}

/// The sender: the grid of the map parts and its sensors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hello {
    /// The grid's size and place.
    #[serde(with = "geometry")]
    pub geometry: Geometry,
    /// The number of pivoted sensors.
    #[serde(with = "number")]
    pub sensors: u8,
    /// The number of fixed rangers.
    #[serde(with = "number")]
    pub rangers: u8,
    /// The duration of a round of the schedule, in milliseconds.
    #[serde(with = "number")]
    pub round_ms: u32,
}

/// A run of neighbouring cells, row after row from the lowest.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct MapPart {
    /// The generation of this part; counts up and wraps.
    #[serde(with = "number")]
    pub generation: u16,
    /// The first cell's index.
    #[serde(with = "number")]
    pub start: u16,
    /// The cells' certainties, each as [`Certainty::to_bits`](certainty_core::certainty::Certainty::to_bits).
    pub cells: Vec<u8, PART_CELLS, u8>,
    /// The size and digest of the whole map, in the last part of a generation.
    pub end: Option<MapEnd>,
}

/// Size and digest of the whole map after a generation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct MapEnd {
    /// The number of cells of the map.
    #[serde(with = "number")]
    pub cells: u16,
    /// A digest of the grid's geometry and all its cells.
    #[serde(with = "postcard::fixint::le")]
    pub digest: u32,
}

/// Direction and reading of a pivoted sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Head {
    /// The sensor.
    #[serde(with = "sensor")]
    pub sensor: SensorId,
    /// The direction as seen from the robot: 0 ahead, counter-clockwise.
    #[serde(with = "angle")]
    pub direction: BinaryAngle,
    /// The reading.
    #[serde(with = "WireReading")]
    pub reading: Reading,
    /// What the validation of the reading found.
    pub finding: Finding,
}

/// The health of a sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct SensorHealth {
    /// The sensor.
    #[serde(with = "sensor")]
    pub sensor: SensorId,
    /// The status.
    pub status: Status,
    /// The confidence.
    #[serde(with = "confidence")]
    pub confidence: Confidence,
    /// Readings that arrived.
    #[serde(with = "number")]
    pub readings: u32,
    /// Missing readings.
    #[serde(with = "number")]
    pub missing: u32,
    /// Cells on which another sensor agreed.
    #[serde(with = "number")]
    pub confirmations: u32,
    /// Cells on which another sensor disagreed.
    #[serde(with = "number")]
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

/// The reading of a fixed ranger.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Ranger {
    /// The ranger's number, from 1.
    #[serde(with = "number")]
    pub number: u8,
    /// The reading.
    #[serde(with = "WireReading")]
    pub reading: Reading,
}

/// Counts of the schedule and the outbox.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Statistics {
    /// Completed rounds since the start; saturates.
    #[serde(with = "number")]
    pub round: u32,
    /// The schedule's clock.
    #[serde(with = "ticks")]
    pub tick: Ticks,
    /// Skipped slots since the start; saturates.
    #[serde(with = "number")]
    pub overruns: u32,
    /// Frames that the outbox refused since the start; saturates.
    #[serde(with = "number")]
    pub unsent: u32,
}

/// Pose, speed and state of the drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Drive {
    /// The reckoned pose at the time of the sensors' measurement, in the map's frame.
    #[serde(with = "WirePose")]
    pub pose: Pose,
    /// The wheels' speeds from now on, in parts of full speed.
    #[serde(with = "WireWheels")]
    pub wheels: Wheels,
    /// The reason for these speeds.
    pub state: DriveState,
    /// The distance from the pose to the goal.
    #[serde(with = "millimeters")]
    pub to_goal: Millimeters,
}

/// The state of the drive: why the robot moves or stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum DriveState {
    /// Stands during the first sweep of its sensors.
    #[default]
    Looking,
    /// Drives at the speed that its behaviours request: [`SpeedLimit::None`].
    Going,
    /// Stands at the goal: [`SpeedLimit::Arrived`].
    Arrived,
    /// Drives slower than requested: [`SpeedLimit::Slowed`].
    Slowed,
    /// Stands because its sensors cover too little: [`SpeedLimit::Blind`].
    Blind,
    /// Turns on the spot because no direction is free: [`SpeedLimit::NoWay`].
    NoWay,
    /// Stands for this round because a slot was skipped or no decision was made.
    Late,
    /// Stands because a motor's channel failed.
    Refused,
    /// Stands until a manual reset because it moved an unknown distance.
    Lost,
    /// Stands until a manual reset because it was reset automatically and its pose is unknown.
    Restarted,
}

impl From<SpeedLimit> for DriveState {
    fn from(limit: SpeedLimit) -> Self {
        match limit {
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

/// Integers of up to 32 bits, all by the same code: postcard encodes `u16` and `u32` alike, as varints.
mod number {
    use serde::de::Error as _;
    use serde::{Deserialize, Deserializer, Serializer};

    pub(super) fn serialize<T: Copy + Into<u32>, S: Serializer>(
        value: &T,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        word((*value).into(), serializer)
    }

    // One copy in flash instead of one a field.
    #[inline(never)]
    fn word<S: Serializer>(value: u32, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_u32(value)
    }

    pub(super) fn deserialize<'de, T: TryFrom<u32>, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<T, D::Error> {
        let word = u32::deserialize(deserializer)?;
        T::try_from(word).map_err(|_| D::Error::custom("out of range"))
    }
}

/// A module for `#[serde(with = "…")]`: `$type` on the wire as the [`number`] `$wire`.
macro_rules! as_number {
    ($name:ident: $type:ty as $wire:ty, $out:expr, $into:expr) => {
        mod $name {
            use super::*;
            use serde::de::Error as _;
            use serde::{Deserializer, Serializer};

            pub(super) fn serialize<S: Serializer>(
                value: &$type,
                serializer: S,
            ) -> Result<S::Ok, S::Error> {
                let out: fn($type) -> $wire = $out;
                number::serialize(&out(*value), serializer)
            }

            pub(super) fn deserialize<'de, D: Deserializer<'de>>(
                deserializer: D,
            ) -> Result<$type, D::Error> {
                let into: fn($wire) -> Option<$type> = $into;
                into(number::deserialize(deserializer)?)
                    .ok_or_else(|| D::Error::custom("out of range"))
            }
        }
    };
}

as_number!(sensor: SensorId as u8, SensorId::number, SensorId::try_new);
as_number!(angle: BinaryAngle as u16, BinaryAngle::to_bits, |bits| {
    Some(BinaryAngle::from_bits(bits))
});
as_number!(confidence: Confidence as u16, Confidence::to_bits, |bits| {
    Some(Confidence::from_bits(bits))
});
as_number!(ticks: Ticks as u32, Ticks::get, |ticks| Some(Ticks::new(ticks)));
as_number!(millimeters: Millimeters as u32, Millimeters::get, |mm| {
    Some(Millimeters::new(mm))
});

as_number!(effort: Effort as u32, |effort| effort.to_bits().cast_unsigned(), |bits| {
    Some(Effort::from_bits(bits.cast_signed()))
});

/// The speeds of [`Wheels`].
#[derive(Serialize, Deserialize)]
#[serde(remote = "Wheels")]
struct WireWheels {
    #[serde(with = "effort")]
    right: Effort,
    #[serde(with = "effort")]
    left: Effort,
}

/// A [`Point`]; one beyond the limits of the type is refused.
mod point {
    use super::Point;
    use serde::de::Error as _;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(super) fn serialize<S: Serializer>(at: &Point, serializer: S) -> Result<S::Ok, S::Error> {
        (at.x_mm(), at.y_mm()).serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Point, D::Error> {
        let (x, y) = <(i32, i32)>::deserialize(deserializer)?;
        let at = Point::from_mm(x, y);
        if (at.x_mm(), at.y_mm()) == (x, y) {
            Ok(at)
        } else {
            Err(D::Error::custom("point out of range"))
        }
    }
}

/// A [`Geometry`]; invalid parts are refused.
mod geometry {
    use super::{Geometry, WireGeometry};
    use serde::de::Error as _;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(super) fn serialize<S: Serializer>(
        geometry: &Geometry,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        let wire = WireGeometry {
            columns: geometry.columns(),
            rows: geometry.rows(),
            cell: geometry.cell_size(),
            corner: geometry.corner(),
        };
        wire.serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Geometry, D::Error> {
        let wire = WireGeometry::deserialize(deserializer)?;
        Geometry::try_new(wire.columns, wire.rows, wire.cell, wire.corner).map_err(D::Error::custom)
    }
}

/// The parts of a [`Geometry`].
#[derive(Serialize, Deserialize)]
struct WireGeometry {
    #[serde(with = "number")]
    columns: u16,
    #[serde(with = "number")]
    rows: u16,
    #[serde(with = "millimeters")]
    cell: Millimeters,
    #[serde(with = "point")]
    corner: Point,
}

/// A [`Pose`].
#[derive(Serialize, Deserialize)]
#[serde(remote = "Pose")]
struct WirePose {
    #[serde(with = "point")]
    at: Point,
    #[serde(with = "angle")]
    heading: BinaryAngle,
}

/// A [`Reading`].
#[derive(Serialize, Deserialize)]
#[serde(remote = "Reading")]
enum WireReading {
    Echo(#[serde(with = "millimeters")] Millimeters),
    NoObject,
    TooNear,
    Missing(Missing),
}
