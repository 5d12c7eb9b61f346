//! The robust certainty grid: `AddToGrid`, [001] §5 and Fig. 3.

use super::add_to_grid::{RobustRules, Verdict, agreement, weighted_mean};
use super::grid::{CertaintyGrid, Measurement, WrongStorage, zeroed};
use super::owners::{Owners, owner_bytes};
use super::{Cell, Geometry, Shape};
use crate::certainty::Certainty;
use crate::health::Health;
use crate::sensor::SensorId;

/// A grid that lets sensors check each other, cell by cell, and believes each as far as it agrees.
///
/// Each cell remembers who owns its value. When another sensor speaks about the cell, the two
/// confirm or contradict each other, which moves both confidences, and the cell takes the mean weighted
/// by them. So a sensor that is often contradicted loses its say, wherever it looks. Prefer it over
/// the median grid where memory is short or views overlap only partly.
///
/// Order: what is added later counts more. The same order gives the same grid, bit for bit.
///
/// Memory: [001] §7, one byte a cell and ⌈log₂(n + 1)⌉ bits for its owner; 17 × 11 cells and three
/// sensors take 187 + 47 bytes.
#[derive(Debug, Clone)]
pub struct RobustGrid<Sh, S, O> {
    shape: Sh,
    rules: RobustRules,
    /// Deviations from *uncertain*, so that zeroed memory is an empty grid.
    cells: S,
    owners: Owners<O>,
    sensors: u8,
}

impl<Sh, S, O> RobustGrid<Sh, S, O>
where
    Sh: Shape,
    S: AsRef<[u8]> + AsMut<[u8]>,
    O: AsRef<[u8]> + AsMut<[u8]>,
{
    /// Creates a grid for sensors 1 to `sensors` in which every cell is uncertain and unowned.
    ///
    /// # Errors
    ///
    /// [`WrongStorage`] unless `storage` has a byte for each cell and `owners` has [`owner_bytes`];
    /// both are handed back.
    ///
    /// # Examples
    ///
    /// One liar of three is outvoted:
    ///
    /// ```
    /// use certainty_core::certainty::Certainty;
    /// use certainty_core::fusion::{CertaintyGrid, Geometry, Measurement, RobustGrid, RobustRules};
    /// use certainty_core::health::Health;
    /// use certainty_core::sensor::SensorId;
    /// use certainty_core::units::{Millimeters, Point};
    ///
    /// let shape = Geometry::try_new(17, 11, Millimeters::new(100), Point::ORIGIN)?;
    /// let mut grid = RobustGrid::try_new(shape, RobustRules::DEFAULT, 3, [0; 187], [0; 47])?;
    /// assert_eq!(grid.memory_bytes(), 234);
    ///
    /// let cell = shape.cell(3, 4).ok_or("outside")?;
    /// let mut sensors = [Health::default(); 3];
    /// for _round in 0..9 {
    ///     for (number, certainty) in [(1, Certainty::OCCUPIED), (2, Certainty::FREE), (3, Certainty::OCCUPIED)] {
    ///         let sensor = SensorId::new(number).ok_or("zero")?;
    ///         grid.add(cell, Measurement { sensor, certainty }, &mut sensors);
    ///     }
    /// }
    /// assert!(grid.certainty(cell) > Certainty::UNCERTAIN);
    /// assert!(sensors[1].confidence() < sensors[0].confidence());
    /// # Ok::<(), Box<dyn core::error::Error>>(())
    /// ```
    pub fn try_new(
        shape: Sh,
        rules: RobustRules,
        sensors: u8,
        storage: S,
        owners: O,
    ) -> Result<Self, WrongStorage<(S, O)>> {
        let cells = shape.geometry().cells() as usize;
        let cells = match zeroed(storage, cells) {
            Ok(cells) => cells,
            Err(WrongStorage { needed, storage }) => {
                return Err(WrongStorage {
                    needed,
                    storage: (storage, owners),
                });
            }
        };
        match zeroed(owners, owner_bytes(cells.as_ref().len(), sensors)) {
            Ok(owners) => Ok(Self {
                shape,
                rules,
                cells,
                owners: Owners::new(sensors, owners),
                sensors,
            }),
            Err(WrongStorage { needed, storage }) => Err(WrongStorage {
                needed,
                storage: (cells, storage),
            }),
        }
    }

    /// Returns who owns the cell's value; `None` is *unknown* ([001] §5.1).
    pub fn owner(&self, cell: Cell) -> Option<SensorId> {
        self.owners.get(cell)
    }
}

impl<Sh, S, O> CertaintyGrid for RobustGrid<Sh, S, O>
where
    Sh: Shape,
    S: AsRef<[u8]> + AsMut<[u8]>,
    O: AsRef<[u8]> + AsMut<[u8]>,
{
    fn geometry(&self) -> Geometry {
        self.shape.geometry()
    }

    /// Adds a measurement: `AddToGrid` of [001] Fig. 3, in the figure's order.
    #[inline]
    fn add(&mut self, cell: Cell, measurement: Measurement, sensors: &mut [Health]) {
        let Measurement { sensor, certainty } = measurement;
        if sensor.number() > self.sensors {
            return;
        }
        let Some(stored) = self.cells.as_mut().get_mut(cell.index()) else {
            return;
        };

        // if (cell.owner = unknown) or (cell.owner = sensor)
        let owner = match self.owners.get(cell) {
            Some(owner) if owner != sensor => owner,
            _ => {
                *stored = certainty.deviation().cast_unsigned();
                self.owners.set(cell, Some(sensor));
                return;
            }
        };
        // An owner is a sensor that was added before, so both are listed.
        let (Some(owner_conf), Some(sensor_conf)) = (
            sensors.get(owner.slot()).map(Health::confidence),
            sensors.get(sensor.slot()).map(Health::confidence),
        ) else {
            return;
        };

        // comparison, weights and the new cell.occ; the confidences are still the old ones here.
        let occ = Certainty::from_deviation(stored.cast_signed());
        let comparison = agreement(occ, certainty);
        let fused = weighted_mean(occ, owner_conf, certainty, sensor_conf);
        *stored = fused.deviation().cast_unsigned();

        let config = self.rules.config();
        for id in [owner, sensor] {
            if let Some(health) = sensors.get_mut(id.slot()) {
                match self.rules.verdict(comparison) {
                    Verdict::Confirmation => health.confirm(config.raise, config.ceiling),
                    Verdict::Contradiction => health.contradict(config.lower, config.floor),
                    Verdict::Insignificant => {}
                }
            }
        }

        // contribution, with the new cell.occ
        let contributes = self.rules.contributes(agreement(fused, certainty));
        self.owners.set(cell, contributes.then_some(sensor));
    }

    fn certainty(&self, cell: Cell) -> Certainty {
        let stored = self.cells.as_ref().get(cell.index()).copied();
        Certainty::from_deviation(stored.unwrap_or(0).cast_signed())
    }

    fn memory_bytes(&self) -> usize {
        self.cells
            .as_ref()
            .len()
            .saturating_add(self.owners.memory_bytes())
    }
}
