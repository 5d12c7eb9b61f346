//! Spatial interpretation: what a reading says about the cells in its beam.

use super::{Cell, Geometry, Ray, cone};
use crate::certainty::Certainty;
use crate::narrow::saturating_i8;
use crate::transducer::Reading;
use crate::units::{BinaryAngle, Direction, Millimeters, Point};
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
    pub(super) config: BeamConfig,
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
    pub(super) fn spread(&self, distance: Millimeters) -> Millimeters {
        // A product of 32 and 16 bits, rounded down: a spread below a millimetre is none.
        let wide = u64::from(distance.get()).wrapping_mul(self.config.accuracy.to_bits().into());
        Millimeters::new(u32::try_from(wide >> U0F16::FRAC_NBITS).unwrap_or(u32::MAX))
    }
}

/// A reading with its place: one beam in the map's frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Beam {
    /// Where the beam starts.
    pub origin: Point,
    /// Which way it goes.
    pub bearing: BinaryAngle,
    /// What came back.
    pub reading: Reading,
}

impl Beam {
    /// Tells `listener` what the reading says, and about which cells.
    ///
    /// Every cell is told once. A narrow beam visits its cells in order of distance, a cone row
    /// after row from the lowest; a fixed order is what makes a run reproducible (\[001\] §7).
    /// *Too near* and *missing* say nothing about any cell.
    ///
    /// Cost: a narrow beam visits the cells on its line inside the grid; a cone those in the box
    /// around it.
    #[inline]
    pub fn interpret(&self, geometry: &Geometry, model: &BeamModel, listener: &mut impl Listener) {
        let echo = match self.reading {
            Reading::Echo(distance) => Some(distance),
            Reading::NoObject => None,
            Reading::TooNear | Reading::Missing(_) => return,
        };
        if model.config.half_width != BinaryAngle::ZERO {
            cone::interpret(self, echo, geometry, model, listener);
        } else if let Some(distance) = echo {
            self.narrow_echo(distance, geometry, model, listener);
        } else {
            let mut ray = Ray::new(geometry, self.origin, self.ahead(model.config.farthest));
            listener.hear(model.config.free, ray.run(u32::MAX));
            listener.hear(model.config.free, ray);
        }
    }

    fn ahead(&self, distance: Millimeters) -> Point {
        self.origin.ahead(self.bearing.direction(), distance)
    }

    /// Free before the spread, occupied at the echo, and behind it what the model says.
    fn narrow_echo(
        &self,
        distance: Millimeters,
        geometry: &Geometry,
        model: &BeamModel,
        listener: &mut impl Listener,
    ) {
        let BeamModel { config } = model;
        let spread = model.spread(distance);
        let hit = self.ahead(distance);
        let hit_cell = geometry.cell_at(hit);
        let fade = Fade {
            beam: self,
            distance: distance.get().into(),
            spread: spread.get().into(),
            peak: config.occupied.deviation().into(),
        };

        // Two rays that share the cell of the echo. The first comes up to it: a cell is free if the
        // beam leaves it before the spread begins.
        let clear = distance.saturating_sub(spread);
        let (mut ray, crossings) = Ray::with_part(geometry, self.origin, hit, clear, distance);
        let free = config.free;
        let outside = crossings > ray.crossings_left();
        listener.hear(free, ray.run(crossings));
        let mut tell = |cell, certainty| listener.hear(certainty, core::iter::once(cell));
        for cell in ray {
            if Some(cell) == hit_cell {
                tell(cell, config.occupied);
            } else if outside {
                tell(cell, free); // the last one inside: the spread begins beyond the grid
            } else if let Some(certainty) = fade.at(geometry.center(cell)) {
                tell(cell, certainty);
            }
        }

        // The second goes on from it, through the rest of the spread and what lies behind.
        let end = match config.behind {
            Behind::Untouched => distance.saturating_add(spread),
            Behind::Uncertain => config.farthest,
        };
        if end <= distance {
            return;
        }
        for cell in Ray::new(geometry, hit, self.ahead(end)) {
            if Some(cell) == hit_cell {
                continue;
            }
            match fade.at(geometry.center(cell)) {
                Some(certainty) => tell(cell, certainty),
                None if config.behind == Behind::Uncertain => tell(cell, Certainty::UNCERTAIN),
                None => {}
            }
        }
    }
}

/// Who wants to know what a reading says.
///
/// Any `FnMut(Cell, Certainty)` is one.
pub trait Listener {
    /// Hears that each of `cells`, in this order, has this `certainty`.
    fn hear(&mut self, certainty: Certainty, cells: impl Iterator<Item = Cell>);
}

impl<F: FnMut(Cell, Certainty)> Listener for F {
    fn hear(&mut self, certainty: Certainty, cells: impl Iterator<Item = Cell>) {
        cells.for_each(|cell| self(cell, certainty));
    }
}

/// The occupied spread along a narrow beam: from *occupied* at the echo linearly to *uncertain*.
struct Fade<'a> {
    beam: &'a Beam,
    distance: i64,
    spread: i64,
    peak: i64,
}

impl Fade<'_> {
    /// What the spread says about the cell with this centre; `None` outside it.
    ///
    /// Rounds towards *uncertain*.
    fn at(&self, center: Point) -> Option<Certainty> {
        let direction = self.beam.bearing.direction();
        let part = |mm: i32, origin: i32, unit: i32| {
            // At most 2^29 mm times 2^30.
            i64::from(mm)
                .wrapping_sub(i64::from(origin))
                .wrapping_mul(unit.into())
        };
        let origin = self.beam.origin;
        let along = part(center.x_mm(), origin.x_mm(), direction.cos()).wrapping_add(part(
            center.y_mm(),
            origin.y_mm(),
            direction.sin(),
        ));
        let along = along >> Direction::FRACTION_BITS;
        let left = self
            .spread
            .wrapping_sub(along.wrapping_sub(self.distance).saturating_abs());
        let deviation = self.peak.wrapping_mul(left).checked_div(self.spread)?;
        (deviation > 0).then(|| Certainty::from_deviation(saturating_i8(deviation)))
    }
}

#[cfg(test)]
mod tests {
    use super::super::picture::draw_beam;
    use super::*;
    use crate::transducer::Missing;
    use proptest::prelude::*;

    const fn mm(mm: u32) -> Millimeters {
        Millimeters::new(mm)
    }

    fn strip() -> Geometry {
        Geometry::try_new(12, 1, mm(100), Point::ORIGIN).unwrap()
    }

    fn beam(reading: Reading) -> Beam {
        Beam {
            origin: Point::from_mm(50, 50),
            bearing: BinaryAngle::ZERO,
            reading,
        }
    }

    fn drawn(reading: Reading, config: BeamConfig) -> String {
        draw_beam(
            &strip(),
            &beam(reading),
            &BeamModel::try_new(config).unwrap(),
        )
        .concat()
    }

    #[test]
    fn free_before_occupied_at_and_uncertain_behind_the_echo() {
        let exact = BeamConfig::narrow(mm(800));
        assert_eq!(drawn(Reading::Echo(mm(400)), exact), "....#????   ");
        let silent = BeamConfig {
            behind: Behind::Untouched,
            ..exact
        };
        assert_eq!(drawn(Reading::Echo(mm(400)), silent), "....#       ");
    }

    #[test]
    fn the_occupied_spread_follows_the_accuracy_and_fades_both_ways() {
        // A quarter of 800 mm is two cells to each side: the nearer ones half a spread away, the
        // outer ones at its end, where it says nothing and what lies behind is uncertain.
        let vague = BeamConfig {
            accuracy: U0F16::lit("0.25"),
            ..BeamConfig::narrow(mm(1100))
        };
        assert_eq!(drawn(Reading::Echo(mm(800)), vague), "...... +#+??");
        // At 300 mm it begins inside the cell before the echo's, which so is not left free.
        assert_eq!(drawn(Reading::Echo(mm(300)), vague), ".. #????????");
    }

    /// PEERS: nav2 dropped a range above the maximum, so that *no echo* never cleared, and made an
    /// obstacle of a range at the maximum.
    #[test]
    fn no_object_frees_up_to_the_range_and_marks_nothing() {
        let exact = BeamConfig::narrow(mm(800));
        assert_eq!(drawn(Reading::NoObject, exact), ".........   ");
    }

    #[test]
    fn an_echo_at_the_very_range_is_an_obstacle_there() {
        let exact = BeamConfig::narrow(mm(800));
        assert_eq!(drawn(Reading::Echo(mm(800)), exact), "........#   ");
    }

    #[test]
    fn what_says_nothing_tells_no_cell() {
        for reading in [Reading::TooNear, Reading::Missing(Missing::Timeout)] {
            let exact = BeamConfig::narrow(mm(800));
            assert_eq!(drawn(reading, exact), " ".repeat(12), "{reading:?}");
        }
    }

    #[test]
    fn an_echo_outside_the_grid_frees_what_is_inside() {
        let exact = BeamConfig::narrow(mm(90_000));
        assert_eq!(drawn(Reading::Echo(mm(70_000)), exact), "............");
    }

    #[test]
    fn an_echo_before_the_grid_makes_the_grid_uncertain() {
        let beam = Beam {
            origin: Point::from_mm(-2000, 50),
            ..beam(Reading::Echo(mm(1000)))
        };
        let model = BeamModel::try_new(BeamConfig::narrow(mm(2650))).unwrap();
        assert_eq!(draw_beam(&strip(), &beam, &model).concat(), "???????     ");
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let base = BeamConfig::narrow(mm(800));
        let refused = |config| BeamModel::try_new(config).unwrap_err();
        let endless = BeamConfig {
            farthest: mm(u32::MAX),
            ..base
        };
        assert_eq!(refused(endless), BeamError::Range);
        assert_eq!(refused(BeamConfig::narrow(mm(0))), BeamError::Range);
        let flat = BeamConfig {
            half_width: BinaryAngle::QUARTER,
            ..base
        };
        assert_eq!(refused(flat), BeamError::Width);
        let clear = BeamConfig {
            half_clear: BinaryAngle::from_bits(1),
            ..base
        };
        assert_eq!(refused(clear), BeamError::Width);
        let upside_down = BeamConfig {
            free: Certainty::OCCUPIED,
            ..base
        };
        assert_eq!(refused(upside_down), BeamError::Certainties);
    }

    proptest! {
        #[test]
        fn every_echo_inside_the_grid_is_drawn_at_its_place_and_nothing_twice(
            x in -2000..2000_i32, y in -2000..2000_i32, bearing: u16, distance in 0..3000_u32,
            accuracy: u16, width in 0..0x3000_u16,
        ) {
            let geometry = Geometry::try_new(20, 20, mm(97), Point::from_mm(-900, -900)).unwrap();
            let beam = Beam {
                origin: Point::from_mm(x, y),
                bearing: BinaryAngle::from_bits(bearing),
                reading: Reading::Echo(mm(distance)),
            };
            let narrow = BeamConfig {
                accuracy: U0F16::from_bits(accuracy / 4),
                ..BeamConfig::narrow(mm(2500))
            };
            let model = BeamModel::try_new(narrow).unwrap();
            let mut told = vec![None; geometry.cells() as usize];
            beam.interpret(&geometry, &model, &mut |cell: Cell, certainty: Certainty| {
                assert_eq!(told[cell.index()].replace(certainty), None);
            });
            if let Some(hit) = geometry.cell_at(beam.ahead(mm(distance))) {
                prop_assert_eq!(told[hit.index()], Some(Certainty::OCCUPIED));
            }
            let cone = BeamConfig {
                accuracy: narrow.accuracy,
                ..BeamConfig::cone(mm(2500), BinaryAngle::from_bits(width))
            };
            let model = BeamModel::try_new(cone).unwrap();
            let _drawn = draw_beam(&geometry, &beam, &model);
        }
    }
}
