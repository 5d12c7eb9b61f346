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

#[cfg(test)]
mod tests;
