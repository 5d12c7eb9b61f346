//! How the core's types look on the wire.
//!
//! The core knows nothing of serialisation, and the wire nothing of how the core lays its types out:
//! a change there either leaves these alone or does not compile. What no type of the core can hold is
//! refused on the way in.

use certainty_control::{Effort, Wheels};
use certainty_core::fusion::Geometry;
use certainty_core::health::{Confidence, Status};
use certainty_core::sensor::SensorId;
use certainty_core::transducer::{Finding, Missing, Reading};
use certainty_core::units::{BinaryAngle, Millimeters, Point, Pose, Ticks};
use serde::{Deserialize, Serialize};

/// Integers of up to 32 bits, all by the same code: postcard's varints of 16 and of 32 bits are alike.
pub(super) mod number {
    use serde::de::Error as _;
    use serde::{Deserialize, Deserializer, Serializer};

    pub(in super::super) fn serialize<T: Copy + Into<u32>, S: Serializer>(
        value: &T,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        word((*value).into(), serializer)
    }

    // Once in flash, not once a field.
    #[inline(never)]
    fn word<S: Serializer>(value: u32, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_u32(value)
    }

    pub(in super::super) fn deserialize<'de, T: TryFrom<u32>, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<T, D::Error> {
        let word = u32::deserialize(deserializer)?;
        T::try_from(word).map_err(|_| D::Error::custom("out of range"))
    }
}

/// A module for `#[serde(with = "…")]`: `$type` on the wire as the [`number`] `$wire`.
macro_rules! as_number {
    ($name:ident: $type:ty as $wire:ty, $out:expr, $into:expr) => {
        pub(super) mod $name {
            use super::*;
            use serde::de::Error as _;
            use serde::{Deserializer, Serializer};

            pub(in super::super) fn serialize<S: Serializer>(
                value: &$type,
                serializer: S,
            ) -> Result<S::Ok, S::Error> {
                let out: fn($type) -> $wire = $out;
                number::serialize(&out(*value), serializer)
            }

            pub(in super::super) fn deserialize<'de, D: Deserializer<'de>>(
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

as_number!(signal: Effort as u32, |signal| signal.to_bits().cast_unsigned(), |bits| {
    Some(Effort::from_bits(bits.cast_signed()))
});

/// The speeds of [`Wheels`].
#[derive(Serialize, Deserialize)]
#[serde(remote = "Wheels")]
pub(super) struct WireWheels {
    #[serde(with = "signal")]
    right: Effort,
    #[serde(with = "signal")]
    left: Effort,
}

/// A [`Point`]; one beyond its limit, which would be moved, is refused.
pub(super) mod point {
    use super::Point;
    use serde::de::Error as _;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(in super::super) fn serialize<S: Serializer>(
        at: &Point,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        (at.x_mm(), at.y_mm()).serialize(serializer)
    }

    pub(in super::super) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Point, D::Error> {
        let (x, y) = <(i32, i32)>::deserialize(deserializer)?;
        let at = Point::from_mm(x, y);
        if (at.x_mm(), at.y_mm()) == (x, y) {
            Ok(at)
        } else {
            Err(D::Error::custom("beyond all maps"))
        }
    }
}

/// A [`Geometry`]; one that is none is refused.
pub(super) mod geometry {
    use super::{Geometry, WireGeometry};
    use serde::de::Error as _;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(in super::super) fn serialize<S: Serializer>(
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

    pub(in super::super) fn deserialize<'de, D: Deserializer<'de>>(
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
pub(super) struct WirePose {
    #[serde(with = "point")]
    at: Point,
    #[serde(with = "angle")]
    heading: BinaryAngle,
}

/// A [`Reading`].
#[derive(Serialize, Deserialize)]
#[serde(remote = "Reading")]
pub(super) enum WireReading {
    Echo(#[serde(with = "millimeters")] Millimeters),
    NoObject,
    TooNear,
    Missing(#[serde(with = "WireMissing")] Missing),
}

/// Why a reading is [`Missing`].
#[derive(Serialize, Deserialize)]
#[serde(remote = "Missing")]
pub(super) enum WireMissing {
    Timeout,
    Bus,
    Implausible,
    Late,
}

/// A [`Finding`].
#[derive(Serialize, Deserialize)]
#[serde(remote = "Finding")]
pub(super) enum WireFinding {
    Plausible,
    Jump,
    OutOfRange,
    StuckAt,
    Missing,
}

/// A [`Status`].
#[derive(Serialize, Deserialize)]
#[serde(remote = "Status")]
pub(super) enum WireStatus {
    Healthy,
    Suspect,
    Failed,
    Recovering,
}
