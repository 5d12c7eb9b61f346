//! Spatial interpretation: what a reading says about the cells in its beam.

mod fade;
mod model;

pub use model::{BeamConfig, BeamError, BeamModel, Behind};

use super::{Cell, Geometry, Ray, cone};
use crate::certainty::Certainty;
use crate::transducer::Reading;
use crate::units::{BinaryAngle, Millimeters, Point};
use fade::Fade;

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
    /// *Too near* and *missing* say nothing about any cell; an echo from beyond the model's range says
    /// that there is no object within it.
    ///
    /// Cost: a narrow beam visits the cells on its line inside the grid; a cone those in the box
    /// around it.
    #[inline]
    pub fn interpret(&self, geometry: &Geometry, model: &BeamModel, listener: &mut impl Listener) {
        let echo = match self.reading {
            Reading::Echo(distance) if distance <= model.config.farthest => Some(distance),
            // Nothing within the range, which is as far as the model knows the sensor.
            Reading::Echo(_) | Reading::NoObject => None,
            Reading::TooNear | Reading::Missing(_) => return,
        };
        if model.config.half_width != BinaryAngle::ZERO {
            cone::interpret(self, echo, geometry, model, listener);
        } else if let Some(distance) = echo {
            self.narrow_echo(distance, geometry, model, listener);
        } else {
            let end = (self.origin).ahead(self.bearing.direction(), model.config.farthest);
            listener.hear(model.config.free, Ray::new(geometry, self.origin, end));
        }
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
            Behind::Uncertain => distance.saturating_add(spread).max(config.farthest),
        };
        if end <= distance {
            return;
        }
        for cell in Ray::new(geometry, hit, self.origin.ahead(direction, end)) {
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
    ///
    /// It hears all of them: what it left over would be told otherwise next.
    fn hear(&mut self, certainty: Certainty, cells: impl Iterator<Item = Cell>);
}

impl<F: FnMut(Cell, Certainty)> Listener for F {
    fn hear(&mut self, certainty: Certainty, cells: impl Iterator<Item = Cell>) {
        cells.for_each(|cell| self(cell, certainty));
    }
}

#[cfg(test)]
mod tests;
