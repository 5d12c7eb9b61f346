//! What the control level sees: a map and the health of what made it.

use super::{Cell, CertaintyGrid, Geometry};
use crate::certainty::Certainty;
use crate::health::{Health, Status};
use crate::sensor::SensorId;
use crate::units::Point;

/// A read-only image of the robot's surroundings.
///
/// The interface between the fusion level and the control level (\[000\] §2). It shows no sensor's
/// readings, mounting or kind, so a sensor can be added without control noticing.
#[derive(Debug)]
pub struct Environment<'a, G> {
    grid: &'a G,
    health: &'a [Health],
}

impl<'a, G: CertaintyGrid> Environment<'a, G> {
    /// Creates the image of `grid` and its sensors' `health`, in the order of their numbers.
    pub const fn new(grid: &'a G, health: &'a [Health]) -> Self {
        Self { grid, health }
    }

    /// Returns where the map lies and how it is divided.
    #[must_use]
    pub fn geometry(&self) -> Geometry {
        self.grid.geometry()
    }

    /// Returns the belief that `cell` is occupied.
    #[must_use]
    pub fn certainty(&self, cell: Cell) -> Certainty {
        self.grid.certainty(cell)
    }

    /// Returns the belief that `place` is occupied; outside the map it is uncertain.
    #[must_use]
    pub fn certainty_at(&self, place: Point) -> Certainty {
        let cell = self.geometry().cell_at(place);
        cell.map_or(Certainty::UNCERTAIN, |cell| self.certainty(cell))
    }

    /// Returns every sensor with its health.
    pub fn sensors(&self) -> impl Iterator<Item = (SensorId, &'a Health)> + use<'a, G> {
        let numbered = self.health.iter().zip(1..=u8::MAX);
        numbered.filter_map(|(health, number)| SensorId::try_new(number).map(|id| (id, health)))
    }

    /// Returns how many sensors have this status.
    #[must_use]
    pub fn count(&self, status: Status) -> u8 {
        let alike = self
            .sensors()
            .filter(|(_, health)| health.status() == status);
        // Not `Iterator::count`, which would panic past the last number of a caller's type.
        alike.fold(0, |count: u8, _| count.saturating_add(1))
    }
}

// Not derived: that would ask the grid to be `Copy` too.
impl<G> Clone for Environment<'_, G> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<G> Copy for Environment<'_, G> {}
