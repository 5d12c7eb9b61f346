//! Spatial interpretation: the cells in a beam and the certainty that a reading gives each.
//!
//! A narrow beam is a line of cells, a wide one a sector ([`BeamConfig::cone`]), as an ultrasonic ranger has.

use super::cone::{Belongs, Cone};
use super::geometry::{Cell, Geometry};
use super::ray::Ray;
use crate::certainty::Certainty;
use crate::narrow::saturating_i8;
use crate::transducer::Reading;
use crate::units::{BinaryAngle, Direction, Millimeters, Point};
use core::fmt;
use fixed::types::U0F16;

/// The certainty of the cells behind an echo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Behind {
    /// None: they are not written.
    Untouched,
    /// *Uncertain*, up to the sensor's range, as \[001\] Fig. 1(b) draws them.
    ///
    /// Neutral in eq. 1; in the robust and the median grid it is a measurement, which weakens the *free* of
    /// a sensor that saw no object.
    Uncertain,
}

/// The parameters of a [`BeamModel`], before they are checked.
///
/// No paper gives them; the defaults are those of a sensor that is exact and narrow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BeamConfig {
    /// The shortest distance that the sensor measures. *Too near* makes the cells up to here occupied; zero:
    /// *too near* changes no cell.
    pub nearest: Millimeters,
    /// The sensor's range. *No object* makes the cells up to here as free as [`Self::no_object`].
    pub farthest: Millimeters,
    /// Half of the occupied spread around an echo, as a fraction of its distance: the accuracy of
    /// \[001\] Table 1.
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub accuracy: U0F16,
    /// The part of half the spread that is the same at every distance; added to that of [`Self::accuracy`].
    pub error: Millimeters,
    /// Half of the beam's opening angle; zero for a narrow beam. Below a quarter turn.
    pub half_width: BinaryAngle,
    /// Half of the angle in which a wide beam makes cells free.
    ///
    /// Narrower than [`Self::half_width`], because a sensor receives little from a cone's edge: *no echo*
    /// from there is weak evidence, which must not erase a neighbour's obstacle.
    pub half_clear: BinaryAngle,
    /// The certainty of cells before the echo; below *uncertain*.
    pub free: Certainty,
    /// The certainty of cells in a beam without an object; at most *uncertain*.
    ///
    /// Weaker than [`Self::free`] for a sensor that reports *no object* wrongly, as the infrared sensors of
    /// \[001\] Table 1 do in 16 to 18 % of all readings.
    pub no_object: Certainty,
    /// The certainty of the cell at the echo; above *uncertain*.
    pub occupied: Certainty,
    /// The certainty of cells behind the echo.
    pub behind: Behind,
}

impl BeamConfig {
    /// An exact, narrow beam of range `farthest`, with the certainties of \[001\] Fig. 1(b).
    #[must_use]
    pub const fn narrow(farthest: Millimeters) -> Self {
        Self {
            nearest: Millimeters::ZERO,
            farthest,
            accuracy: U0F16::ZERO,
            error: Millimeters::ZERO,
            half_width: BinaryAngle::ZERO,
            half_clear: BinaryAngle::ZERO,
            free: Certainty::FREE,
            no_object: Certainty::FREE,
            occupied: Certainty::OCCUPIED,
            behind: Behind::Uncertain,
        }
    }

    /// A wide beam of range `farthest` that opens by `half_width` to each side and makes its inner half
    /// free.
    ///
    /// An arc of echoes is far wider than the object, so only its middle is *occupied*.
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

/// How a sensor's readings are spread over cells; the checked [`BeamConfig`].
///
/// Possession proves that the beam is shorter than the plane and narrower than half a turn, and that
/// *free*, *uncertain* and *occupied* are in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BeamModel {
    config: BeamConfig,
}

/// Why a beam model is invalid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BeamError {
    /// The range is zero, not beyond the shortest distance, or above [`Point::LIMIT`].
    Range,
    /// The half width reaches a quarter turn, or the clear part is wider than the beam.
    Width,
    /// *Free* is not below *uncertain*, *no object* above it, or *occupied* not above it.
    Certainties,
}

impl BeamError {
    const fn message(self) -> &'static str {
        match self {
            Self::Range => {
                "a beam's range must be above its shortest distance and at most 2^28 mm (268 km)"
            }
            Self::Width => "a beam's half width must be below 90 degrees, its clear part not wider",
            Self::Certainties => {
                "the certainty of free must be below 128, of no object not above, of occupied above"
            }
        }
    }
}

impl fmt::Display for BeamError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.message())
    }
}

impl core::error::Error for BeamError {}

impl BeamModel {
    /// Checks the parameters of a constant: [`Self::try_new`] that refuses at compile time.
    ///
    /// # Panics
    ///
    /// With the message of the [`BeamError`]; in a constant that is a compile error.
    ///
    /// # Examples
    ///
    /// ```
    /// use certainty_core::fusion::{BeamConfig, BeamModel};
    /// use certainty_core::units::Millimeters;
    ///
    /// const GP2D02: BeamModel = BeamModel::new(BeamConfig::narrow(Millimeters::new(800)));
    /// assert_eq!(GP2D02.config().farthest, Millimeters::new(800));
    /// ```
    #[must_use]
    #[expect(clippy::panic, reason = "for constants, where it is a compile error")]
    pub const fn new(config: BeamConfig) -> Self {
        match Self::try_new(config) {
            Ok(model) => model,
            Err(error) => panic!("{}", error.message()),
        }
    }

    /// Checks the parameters.
    ///
    /// # Errors
    ///
    /// [`BeamError`] names the first rule that is broken.
    pub const fn try_new(config: BeamConfig) -> Result<Self, BeamError> {
        let farthest = config.farthest.get();
        let width = config.half_width.to_bits();
        if farthest <= config.nearest.get() || farthest > Point::LIMIT.unsigned_abs() {
            Err(BeamError::Range)
        } else if width >= BinaryAngle::QUARTER.to_bits() || config.half_clear.to_bits() > width {
            Err(BeamError::Width)
        } else if config.free.deviation() >= 0
            || config.no_object.deviation() > 0
            || config.occupied.deviation() <= 0
        {
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
    fn spread(&self, distance: Millimeters) -> Millimeters {
        // A product of 32 and 16 bits, rounded down: a spread below a millimetre is zero.
        let wide = u64::from(distance.get()).wrapping_mul(self.config.accuracy.to_bits().into());
        Millimeters::from_saturating(wide >> U0F16::FRAC_NBITS) + self.config.error
    }
}

/// A reading with its origin and bearing: one beam in the map's frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Beam {
    /// Where the beam starts.
    pub origin: Point,
    /// The direction of the beam.
    pub bearing: BinaryAngle,
    /// The reading.
    pub reading: Reading,
}

impl Beam {
    /// Writes the certainty that the reading gives each cell of its beam to `sink`.
    ///
    /// Every cell is written once. A narrow beam visits its cells in order of distance, a cone row
    /// by row from the lowest; with a fixed order a run is reproducible (\[001\] §7). *Missing*
    /// writes no cell, *too near* those within the shortest distance; an echo from beyond the model's range is
    /// taken as *no object*.
    ///
    /// Cost: a narrow beam visits the cells on its line inside the grid; a cone those in the box
    /// around it.
    ///
    /// # Examples
    ///
    /// Any `FnMut(Cell, Certainty)` is a sink:
    ///
    /// ```
    /// use certainty_core::certainty::Certainty;
    /// use certainty_core::fusion::{Beam, BeamConfig, BeamModel, Cell, Geometry};
    /// use certainty_core::transducer::Reading;
    /// use certainty_core::units::{BinaryAngle, Millimeters, Point};
    ///
    /// let strip = Geometry::new(5, 1, Millimeters::new(100), Point::ORIGIN);
    /// let model = BeamModel::new(BeamConfig::narrow(Millimeters::new(300)));
    /// let beam = Beam {
    ///     origin: Point::from_mm(50, 50),
    ///     bearing: BinaryAngle::ZERO,
    ///     reading: Reading::Echo(Millimeters::new(200)),
    /// };
    /// let mut row = [' '; 5];
    /// beam.interpret(&strip, &model, &mut |cell: Cell, certainty: Certainty| {
    ///     row[cell.index()] = match certainty {
    ///         Certainty::FREE => '.',
    ///         Certainty::OCCUPIED => '#',
    ///         _ => '?',
    ///     };
    /// });
    /// assert_eq!(row, ['.', '.', '#', '?', ' ']);
    /// ```
    #[inline]
    pub fn interpret(&self, geometry: &Geometry, model: &BeamModel, sink: &mut impl CellSink) {
        let config = &model.config;
        let seen = match self.reading {
            Reading::Echo(distance) if distance <= config.farthest => Seen::At(distance),
            // An echo from beyond the range: nothing within it.
            Reading::Echo(_) | Reading::NoObject => Seen::Nothing,
            Reading::TooNear if config.nearest > Millimeters::ZERO => Seen::Nearer,
            Reading::TooNear | Reading::Missing(_) => return,
        };
        if config.half_width != BinaryAngle::ZERO {
            self.wide(seen, geometry, model, sink);
            return;
        }
        let (certainty, reach) = match seen {
            Seen::At(distance) => return self.narrow_echo(distance, geometry, model, sink),
            Seen::Nearer => (config.occupied, config.nearest),
            Seen::Nothing => (config.no_object, config.farthest),
        };
        let end = self.origin.ahead(self.bearing.direction(), reach);
        sink.write(certainty, Ray::new(geometry, self.origin, end));
    }

    /// Free before the spread, occupied at the echo, and behind it as the model has it.
    fn narrow_echo(
        &self,
        distance: Millimeters,
        geometry: &Geometry,
        model: &BeamModel,
        sink: &mut impl CellSink,
    ) {
        let BeamModel { config } = model;
        let spread = model.spread(distance);
        let direction = self.bearing.direction();
        let hit = self.origin.ahead(direction, distance);
        let hit_cell = geometry.cell_at(hit);
        let fade = Fade {
            origin: self.origin,
            direction,
            distance: distance.get().into(),
            spread: spread.get().into(),
            peak: config.occupied.deviation().into(),
        };

        // Two rays that share the cell of the echo. The first ends in it: a cell is free if the beam
        // leaves it before the spread begins.
        let clear = distance - spread;
        let (mut ray, crossings) = Ray::with_part(geometry, self.origin, hit, clear, distance);
        let free = config.free;
        let outside = crossings > ray.crossings_left();
        sink.write(free, ray.run(crossings));
        let mut write = |cell, certainty| sink.write(certainty, core::iter::once(cell));
        for cell in ray {
            if Some(cell) == hit_cell {
                write(cell, config.occupied);
            } else if outside {
                write(cell, free); // the last cell inside: the spread begins beyond the grid
            } else if let Some(certainty) = fade.at(geometry.center(cell)) {
                write(cell, certainty);
            }
        }

        // The second starts there, through the rest of the spread and the cells behind.
        let end = match config.behind {
            Behind::Untouched => distance + spread,
            Behind::Uncertain => (distance + spread).max(config.farthest),
        };
        if end <= distance {
            return;
        }
        for cell in Ray::new(geometry, hit, self.origin.ahead(direction, end)) {
            if Some(cell) == hit_cell {
                continue;
            }
            match fade.at(geometry.center(cell)) {
                Some(certainty) => write(cell, certainty),
                None if config.behind == Behind::Uncertain => write(cell, Certainty::UNCERTAIN),
                None => {}
            }
        }
    }

    /// The certainty that a reading gives each cell of the cone.
    ///
    /// It fades with the square of the angle from the axis, to *uncertain* at the edge: the shape that Elfes
    /// gave sonar. The arc of an echo contains every cell that is at most half outside; free are only cells
    /// whose centre is inside, and those that the axis crosses, as near the apex the cone is narrower than
    /// a cell. *Free* has a narrower edge than *occupied*, so that neighbouring cones do not erase each
    /// other's obstacles.
    fn wide(&self, seen: Seen, geometry: &Geometry, model: &BeamModel, sink: &mut impl CellSink) {
        let mut write = |cell, certainty| sink.write(certainty, core::iter::once(cell));
        let config = &model.config;
        let half_cell = i64::from(geometry.cell_size().get()) / 2;
        let cone = Cone::new(
            self.origin,
            self.bearing,
            config.half_width,
            half_cell,
            Belongs::ByItsHalf,
        );
        let clear = Cone::new(
            self.origin,
            self.bearing,
            config.half_clear,
            half_cell,
            Belongs::ByItsCenter,
        );

        // The occupied arc: between `near` and `far`.
        let (near, far, reach) = match seen {
            Seen::Nothing => (i64::from(config.farthest.get()), i64::MAX, config.farthest),
            Seen::Nearer => (0, config.nearest.get().into(), config.nearest),
            Seen::At(distance) => {
                let half_arc = half_cell.max(model.spread(distance).get().into());
                let at = i64::from(distance.get());
                let far = at.saturating_add(half_arc);
                let arc_end = Millimeters::from_saturating(far.unsigned_abs());
                let reach = match config.behind {
                    Behind::Untouched => arc_end,
                    Behind::Uncertain => arc_end.max(config.farthest),
                };
                (at.saturating_sub(half_arc), far, reach)
            }
        };

        let Some((columns, rows)) = cone.bounds(geometry, reach) else {
            return;
        };
        let reach = i64::from(reach.get());
        let (free, hit) = match seen {
            Seen::Nothing => (config.no_object, None),
            Seen::Nearer => (config.free, geometry.cell_at(self.origin)),
            Seen::At(distance) => {
                let hit = self.origin.ahead(self.bearing.direction(), distance);
                (config.free, geometry.cell_at(hit))
            }
        };
        for row in rows {
            for column in columns.clone() {
                let cell = geometry.cell_inside(column, row);
                if Some(cell) == hit {
                    // At any width of the cone and any distance of the cell's centre from its axis.
                    write(cell, config.occupied);
                    continue;
                }
                let center = geometry.center(cell);
                let Some(place) = cone.place(center) else {
                    continue;
                };
                if place.distance > reach {
                    continue;
                }
                if place.distance > far {
                    write(cell, Certainty::UNCERTAIN);
                    continue;
                }
                let certainty = if place.distance < near {
                    clear.place(center).map(|inner| faded(free, inner.off_axis))
                } else {
                    (seen != Seen::Nothing).then(|| faded(config.occupied, place.off_axis))
                };
                // At the edge nothing is left of it.
                if let Some(certainty) = certainty.filter(|&given| given != Certainty::UNCERTAIN) {
                    write(cell, certainty);
                }
            }
        }
    }
}

/// What a reading shows within the model's range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Seen {
    Nothing,
    /// An object at this distance.
    At(Millimeters),
    /// An object within the shortest distance.
    Nearer,
}

/// A receiver of cells with their certainties.
///
/// Any `FnMut(Cell, Certainty)` is one.
pub trait CellSink {
    /// Takes the same `certainty` for each of `cells`, in this order.
    ///
    /// Implementations must exhaust `cells`.
    fn write(&mut self, certainty: Certainty, cells: impl Iterator<Item = Cell>);
}

impl<F: FnMut(Cell, Certainty)> CellSink for F {
    fn write(&mut self, certainty: Certainty, cells: impl Iterator<Item = Cell>) {
        cells.for_each(|cell| self(cell, certainty));
    }
}

/// The occupied spread along a narrow beam: from *occupied* at the echo linearly to *uncertain*.
struct Fade {
    origin: Point,
    direction: Direction,
    distance: i64,
    spread: i64,
    peak: i64,
}

impl Fade {
    /// The certainty that the spread gives the cell with this centre; `None` outside it.
    ///
    /// Rounds towards *uncertain*.
    fn at(&self, center: Point) -> Option<Certainty> {
        let part = |mm: i32, origin: i32, unit: i32| {
            // At most 2^29 mm times 2^30.
            i64::from(mm)
                .wrapping_sub(i64::from(origin))
                .wrapping_mul(unit.into())
        };
        let Self {
            origin, direction, ..
        } = self;
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

/// `certainty`, weakened by the square of how far off the axis the cell is; rounds towards
/// *uncertain*.
fn faded(certainty: Certainty, off_axis: i64) -> Certainty {
    let off = off_axis.clamp(0, 256);
    let kept = 65_536_i64.saturating_sub(off.saturating_mul(off));
    let deviation = i64::from(certainty.deviation())
        .saturating_mul(kept)
        .checked_div(65_536);
    Certainty::from_deviation(saturating_i8(deviation.unwrap_or(0)))
}

#[cfg(test)]
mod tests {
    use super::super::picture::{draw, mark};
    use super::*;
    use crate::transducer::Missing;
    use proptest::prelude::*;

    /// Draws the certainties of one beam, cells that it does not write as spaces.
    fn draw_beam(geometry: &Geometry, beam: &Beam, model: &BeamModel) -> Vec<String> {
        let mut written = vec![None; geometry.cells() as usize];
        beam.interpret(geometry, model, &mut |cell: Cell, certainty: Certainty| {
            assert_eq!(written[cell.index()], None, "a cell is written once");
            written[cell.index()] = Some(certainty);
        });
        draw(geometry, |cell| written[cell.index()].map_or(' ', mark))
    }

    const fn mm(mm: u32) -> Millimeters {
        Millimeters::new(mm)
    }

    fn strip() -> Geometry {
        Geometry::new(12, 1, mm(100), Point::ORIGIN)
    }

    fn beam(reading: Reading) -> Beam {
        Beam {
            origin: Point::from_mm(50, 50),
            bearing: BinaryAngle::ZERO,
            reading,
        }
    }

    fn drawn(reading: Reading, config: BeamConfig) -> String {
        draw_beam(&strip(), &beam(reading), &BeamModel::new(config)).concat()
    }

    #[test]
    fn free_before_occupied_at_and_uncertain_behind_the_echo() {
        let exact = BeamConfig::narrow(mm(800));
        assert_eq!(drawn(Reading::Echo(mm(400)), exact), "....#????   ");
        let untouched = BeamConfig {
            behind: Behind::Untouched,
            ..exact
        };
        assert_eq!(drawn(Reading::Echo(mm(400)), untouched), "....#       ");
    }

    #[test]
    fn the_spread_follows_the_accuracy_and_fades() {
        // A quarter of 800 mm is two cells to each side: the nearer ones half a spread away, the outer ones
        // at its end, where nothing is left of it and the cells behind are uncertain.
        let vague = BeamConfig {
            accuracy: U0F16::lit("0.25"),
            ..BeamConfig::narrow(mm(1100))
        };
        assert_eq!(drawn(Reading::Echo(mm(800)), vague), "...... +#+??");
        // At 300 mm it begins inside the cell before the echo's, which so is not free.
        assert_eq!(drawn(Reading::Echo(mm(300)), vague), ".. #????????");
    }

    /// A defect of nav2: it dropped a range above the maximum, so that *no echo* never cleared, and made an
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
    fn too_near_is_an_obstacle_within_the_shortest_distance() {
        let near = BeamConfig {
            nearest: mm(200),
            ..BeamConfig::narrow(mm(800))
        };
        assert_eq!(drawn(Reading::TooNear, near), "###         ");
        let cone = BeamConfig {
            nearest: mm(200),
            ..BeamConfig::cone(mm(800), BinaryAngle::from_millidegrees(20_000))
        };
        assert_eq!(drawn(Reading::TooNear, cone), "###         ");
    }

    #[test]
    fn no_object_can_be_weaker_than_a_passing_beam() {
        let unsure = BeamConfig {
            no_object: Certainty::UNCERTAIN,
            ..BeamConfig::narrow(mm(300))
        };
        assert_eq!(drawn(Reading::NoObject, unsure), "????        ");
        assert_eq!(drawn(Reading::Echo(mm(200)), unsure), "..#?        ");
        let cone = BeamConfig {
            no_object: Certainty::UNCERTAIN,
            ..BeamConfig::cone(mm(800), BinaryAngle::from_millidegrees(20_000))
        };
        assert_eq!(drawn(Reading::NoObject, cone), " ".repeat(12));
    }

    #[test]
    fn a_constant_error_is_the_same_spread_at_every_distance() {
        let constant = BeamConfig {
            error: mm(100),
            ..BeamConfig::narrow(mm(1100))
        };
        assert_eq!(drawn(Reading::Echo(mm(300)), constant), ".. #????????");
        assert_eq!(drawn(Reading::Echo(mm(800)), constant), "....... #???");
    }

    #[test]
    fn too_near_and_missing_write_no_cell() {
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
        let model = BeamModel::new(BeamConfig::narrow(mm(2650)));
        assert_eq!(draw_beam(&strip(), &beam, &model).concat(), "???????     ");
    }

    #[test]
    fn invalid_models_are_refused() {
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
        fn every_echo_is_drawn_at_its_place_and_no_cell_twice(
            x in -2000..2000_i32, y in -2000..2000_i32, bearing: u16, distance in 0..=2500_u32,
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
            let model = BeamModel::new(narrow);
            let mut written = vec![None; geometry.cells() as usize];
            beam.interpret(&geometry, &model, &mut |cell: Cell, certainty: Certainty| {
                assert_eq!(written[cell.index()].replace(certainty), None);
            });
            let hit = geometry.cell_at(beam.origin.ahead(beam.bearing.direction(), mm(distance)));
            if let Some(hit) = hit {
                prop_assert_eq!(written[hit.index()], Some(Certainty::OCCUPIED));
            }
            let cone = BeamConfig {
                accuracy: narrow.accuracy,
                ..BeamConfig::cone(mm(2500), BinaryAngle::from_bits(width))
            };
            let model = BeamModel::new(cone);
            let mut written = vec![None; geometry.cells() as usize];
            beam.interpret(&geometry, &model, &mut |cell: Cell, certainty: Certainty| {
                assert_eq!(written[cell.index()].replace(certainty), None);
            });
            if let Some(hit) = hit {
                prop_assert_eq!(written[hit.index()], Some(Certainty::OCCUPIED), "cone");
            }
        }
    }

    #[test]
    fn an_echo_near_the_range_keeps_its_spread() {
        let vague = |behind| BeamConfig {
            accuracy: U0F16::lit("0.25"),
            behind,
            ..BeamConfig::narrow(mm(800))
        };
        let untouched = drawn(Reading::Echo(mm(800)), vague(Behind::Untouched));
        assert_eq!(untouched, "...... +#+  ");
        // At the end of the spread the cell is uncertain.
        let uncertain = drawn(Reading::Echo(mm(800)), vague(Behind::Uncertain));
        assert_eq!(uncertain, "...... +#+? ");
    }

    #[test]
    fn an_echo_from_beyond_the_range_is_no_object_within_it() {
        let exact = BeamConfig::narrow(mm(800));
        let free = drawn(Reading::NoObject, exact);
        for distance in [801, 5000, u32::MAX] {
            assert_eq!(drawn(Reading::Echo(mm(distance)), exact), free);
        }
    }

    fn yard() -> Geometry {
        Geometry::new(21, 12, mm(100), Point::from_mm(-1050, 0))
    }

    fn sonar() -> BeamModel {
        let half_width = BinaryAngle::from_millidegrees(15_000);
        BeamModel::new(BeamConfig::cone(mm(1100), half_width))
    }

    fn up(degrees: i32, reading: Reading) -> Beam {
        Beam {
            origin: Point::ORIGIN,
            bearing: BinaryAngle::from_millidegrees(90_000 - degrees * 1000),
            reading,
        }
    }

    #[test]
    fn a_cone_frees_its_middle_and_marks_an_arc() {
        // The arc holds the cells 950 to 1050 mm away: (0, 1050), and of the row at 950 those at most 300 to
        // the side, whose near half is 0.98 of the way to the edge. The clear part, 7.5° wide,
        // reaches the centres beside the axis, 100 to the side, from 760 mm on.
        let drawn = draw_beam(&yard(), &up(0, Reading::Echo(mm(1000))), &sonar());
        let mut expected = vec!["          .          "; 12];
        expected[..4].copy_from_slice(&[
            "                     ",
            "          #          ",
            "       ++###++       ",
            "         ,.,         ",
        ]);
        assert_eq!(drawn, expected);
    }

    #[test]
    fn mirrored_cones_write_mirrored_cells() {
        // Cells of an odd size have a middle millimetre; x mirrors to −1 − x.
        let corner = Point::from_mm(-51 * 8, -51 * 8);
        let geometry = Geometry::new(16, 16, mm(51), corner);
        for bearing in (0..=u16::MAX).step_by(97) {
            let beam = Beam {
                origin: Point::from_mm(20, -33),
                bearing: BinaryAngle::from_bits(bearing),
                reading: Reading::Echo(mm(300)),
            };
            let mirrored = Beam {
                origin: Point::from_mm(-1 - 20, -33),
                bearing: BinaryAngle::HALF.wrapping_sub(beam.bearing),
                ..beam
            };
            let drawn = draw_beam(&geometry, &mirrored, &sonar());
            let flipped: Vec<String> = drawn
                .iter()
                .map(|row| row.chars().rev().collect())
                .collect();
            assert_eq!(
                draw_beam(&geometry, &beam, &sonar()),
                flipped,
                "bearing {bearing}"
            );
        }
    }

    /// A defect of nav2: a cone that left the grid on the negative side wrapped into a huge loop.
    #[test]
    fn a_cone_leaving_on_the_negative_side_ends_there() {
        let outside = Beam {
            origin: Point::from_mm(-5000, -5000),
            ..up(180, Reading::Echo(mm(1000)))
        };
        let drawn = draw_beam(&yard(), &outside, &sonar());
        assert!(drawn.iter().all(|row| row.trim().is_empty()));
        let edge = draw_beam(&yard(), &up(-90, Reading::NoObject), &sonar());
        assert!(edge.concat().contains('.'));
    }
}
