//! How one kind of sensor's readings are spread over cells.

use crate::certainty::Certainty;
use crate::units::{BinaryAngle, Millimeters, Point};
use core::fmt;
use fixed::types::U0F16;

/// What the cells behind an echo are told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Behind {
    /// Nothing: they are left alone.
    Untouched,
    /// That they are uncertain, up to the sensor's range, as \[001\] Fig. 1(b) draws them.
    ///
    /// To eq. 1 that is neutral; to the robust and the median grid it is a voice: it takes back what
    /// a sensor freed that saw no object.
    Uncertain,
}

/// The parameters of a [`BeamModel`], before they are checked.
///
/// No paper gives them; the defaults are those of a sensor that is exact and narrow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BeamConfig {
    /// How far the sensor sees. *No object* frees up to here.
    pub farthest: Millimeters,
    /// Half of the occupied spread around an echo, as a fraction of its distance: the accuracy of
    /// \[001\] Table 1.
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub accuracy: U0F16,
    /// Half of the beam's opening angle; zero for a narrow beam. Below a quarter turn.
    pub half_width: BinaryAngle,
    /// Half of the angle in which a wide beam frees cells.
    ///
    /// Narrower than [`Self::half_width`], because at a cone's edge a sensor hears little: *no echo*
    /// from there says little, and a neighbour's obstacle must survive it.
    pub half_clear: BinaryAngle,
    /// What cells before the echo are told; below *uncertain*.
    pub free: Certainty,
    /// What the cell at the echo is told; above *uncertain*.
    pub occupied: Certainty,
    /// What cells behind the echo are told.
    pub behind: Behind,
}

impl BeamConfig {
    /// An exact, narrow beam that sees `farthest`, with the certainties of \[001\] Fig. 1(b).
    #[must_use]
    pub const fn narrow(farthest: Millimeters) -> Self {
        Self {
            farthest,
            accuracy: U0F16::ZERO,
            half_width: BinaryAngle::ZERO,
            half_clear: BinaryAngle::ZERO,
            free: Certainty::FREE,
            occupied: Certainty::OCCUPIED,
            behind: Behind::Uncertain,
        }
    }

    /// A wide beam that sees `farthest` and opens by `half_width` to each side; it frees the inner
    /// half.
    ///
    /// An arc of echoes is far wider than the object, so it is told less than *occupied*.
    #[must_use]
    pub const fn cone(farthest: Millimeters, half_width: BinaryAngle) -> Self {
        Self {
            half_width,
            half_clear: BinaryAngle::from_bits(half_width.to_bits() / 2),
            behind: Behind::Untouched,
            ..Self::narrow(farthest)
        }
    }
}

/// How one kind of sensor's readings are spread over cells; the checked [`BeamConfig`].
///
/// Possession proves that the beam is shorter than the plane and narrower than half a turn, and that
/// *free*, *uncertain* and *occupied* are in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BeamModel {
    pub(in crate::fusion) config: BeamConfig,
}

/// Why a beam model was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BeamError {
    /// The range is zero or above [`Point::LIMIT`].
    Range,
    /// The half width reaches a quarter turn, or the clear part is wider than the beam.
    Width,
    /// *Free* is not below *uncertain*, or *occupied* not above it.
    Certainties,
}

impl fmt::Display for BeamError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Range => "a beam's range must be above zero and at most 268 km",
            Self::Width => "a beam's half width must be below 90 degrees and its clear part inside",
            Self::Certainties => "free must be below 128 and occupied above it",
        })
    }
}

impl core::error::Error for BeamError {}

impl BeamModel {
    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// [`BeamError`] names what cannot be.
    pub const fn try_new(config: BeamConfig) -> Result<Self, BeamError> {
        let farthest = config.farthest.get();
        let width = config.half_width.to_bits();
        if farthest == 0 || farthest > Point::LIMIT.unsigned_abs() {
            Err(BeamError::Range)
        } else if width >= BinaryAngle::QUARTER.to_bits() || config.half_clear.to_bits() > width {
            Err(BeamError::Width)
        } else if config.free.deviation() >= 0 || config.occupied.deviation() <= 0 {
            Err(BeamError::Certainties)
        } else {
            Ok(Self { config })
        }
    }

    /// Returns the parameters.
    #[must_use]
    pub const fn config(&self) -> &BeamConfig {
        &self.config
    }

    /// Half of the occupied spread around an echo at `distance`.
    pub(in crate::fusion) fn spread(&self, distance: Millimeters) -> Millimeters {
        // A product of 32 and 16 bits, rounded down: a spread below a millimetre is none.
        let wide = u64::from(distance.get()).wrapping_mul(self.config.accuracy.to_bits().into());
        Millimeters::new(u32::try_from(wide >> U0F16::FRAC_NBITS).unwrap_or(u32::MAX))
    }
}
