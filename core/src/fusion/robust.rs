//! The robust certainty grid: `AddToGrid`, \[001\] §5 and Fig. 3.

use super::add_to_grid::{RobustRules, Update};
use super::grid::{CertaintyGrid, GridError, GridErrorKind, Measurement, zeroed};
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
/// Memory: \[001\] §7, one byte a cell and ⌈log₂(n + 1)⌉ bits for its owner; 17 × 11 cells and three
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
    /// [`GridError`] unless there is a sensor, `storage` has a byte for each cell and `owners` has [`owner_bytes`];
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
    ///         let sensor = SensorId::try_new(number).ok_or("zero")?;
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
    ) -> Result<Self, GridError<(S, O)>> {
        if sensors == 0 {
            let why = GridErrorKind::Sensors {
                most: u8::MAX as usize,
            };
            let storage = (storage, owners);
            return Err(GridError { why, storage });
        }
        let cells = shape.geometry().cells() as usize;
        let cells = match zeroed(storage, cells) {
            Ok(cells) => cells,
            Err(GridError { why, storage }) => {
                return Err(GridError {
                    why,
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
            Err(GridError { why, storage }) => Err(GridError {
                why,
                storage: (cells, storage),
            }),
        }
    }

    /// Returns who owns the cell's value; `None` is *unknown* (\[001\] §5.1).
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

    #[inline]
    fn add_all(
        &mut self,
        cells: impl Iterator<Item = Cell>,
        measurement: Measurement,
        sensors: &mut [Health],
    ) {
        // `AddToGrid` of \[001\] Fig. 3.
        let Measurement { sensor, certainty } = measurement;
        let Some(own) = sensors.get(sensor.slot()) else {
            return;
        };
        if sensor.number() > self.sensors {
            return;
        }
        let mut voice = Update::new(&self.rules, measurement, own);
        let (stored, mut owners) = (self.cells.as_mut(), self.owners.open());
        cells.for_each(|cell| {
            let Some((stored, slot)) = stored.get_mut(cell.index()).zip(owners.slot(cell)) else {
                return;
            };
            // if (cell.owner = unknown) or (cell.owner = sensor)
            match slot.owner {
                Some(owner) if owner != sensor => {
                    // The list may have been longer when the owner spoke: nobody to compare with then.
                    if let Some(owner) = sensors.get_mut(owner.slot()) {
                        slot.set(voice.meet(stored, owner));
                    }
                }
                known => {
                    *stored = certainty.deviation().cast_unsigned();
                    if known.is_none() {
                        slot.set(Some(sensor));
                    }
                }
            }
        });
        // No cell that it owns was compared, so that nothing else was written there.
        if let Some(health) = sensors.get_mut(sensor.slot()) {
            *health = voice.into_own();
        }
    }

    #[inline]
    fn add(&mut self, cell: Cell, measurement: Measurement, sensors: &mut [Health]) {
        self.add_all(core::iter::once(cell), measurement, sensors);
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

#[cfg(test)]
mod tests {
    use super::super::add_to_grid::RobustConfig;
    use super::super::picture::draw;
    use super::*;
    use crate::health::{Claim, Confidence, FaultAttribution, StepRule};
    use crate::units::{Millimeters, Point};
    use proptest::prelude::*;

    type Small = RobustGrid<Geometry, Vec<u8>, Vec<u8>>;

    fn grid(columns: u16, rows: u16, sensors: u8) -> Small {
        with_rules(columns, rows, sensors, RobustRules::DEFAULT)
    }

    fn with_rules(columns: u16, rows: u16, sensors: u8, rules: RobustRules) -> Small {
        let shape = Geometry::try_new(columns, rows, Millimeters::new(100), Point::ORIGIN).unwrap();
        let cells = shape.cells() as usize;
        let owners = vec![0xFF; owner_bytes(cells, sensors)];
        RobustGrid::try_new(shape, rules, sensors, vec![0xFF; cells], owners).unwrap()
    }

    fn says(number: u8, bits: u8) -> Measurement {
        Measurement {
            sensor: SensorId::try_new(number).unwrap(),
            certainty: Certainty::from_bits(bits),
        }
    }

    /// \[001\] Fig. 3 in real numbers, with the integers' rounding of cell.occ and nothing else.
    ///
    /// `conf` is what sensors 1 to 3 are believed of, [what they call occupied, what they call free].
    #[derive(Debug)]
    struct Naive {
        occ: f64,
        owner: usize,
        conf: [[f64; 2]; 4],
        rules: RobustRules,
    }

    impl Naive {
        /// As [`RobustGrid`] stands: so each step is compared for itself.
        fn like(grid: &Small, cell: Cell, sensors: &[Health; 3]) -> Self {
            let mut conf = [[0.0; 2]; 4];
            for (own, health) in conf[1..].iter_mut().zip(sensors) {
                *own = [Claim::Occupied, Claim::Free].map(|word| real(health.confidence_in(word)));
            }
            Self {
                occ: f64::from(grid.certainty(cell).to_bits()) / 256.0,
                owner: grid.owner(cell).map_or(0, |owner| owner.number().into()),
                conf,
                rules: grid.rules,
            }
        }

        fn add(&mut self, sensor: usize, measurement: f64) {
            if self.owner == 0 || self.owner == sensor {
                self.occ = measurement;
                self.owner = sensor;
                return;
            }
            let config = *self.rules.config();
            let comparison = 4.0 * (self.occ - 0.5) * (measurement - 0.5);
            let least = |id: usize| self.conf[id][0].min(self.conf[id][1]);
            let weight1 = (self.occ - 0.5).abs() * least(self.owner);
            let weight2 = (measurement - 0.5).abs() * least(sensor);
            let exact = if weight1 == weight2 {
                f64::midpoint(self.occ, measurement)
            } else {
                (self.occ * weight1 + measurement * weight2) / (weight1 + weight2)
            };
            let said = [
                (self.owner, usize::from(self.occ <= 0.5)),
                (sensor, usize::from(measurement <= 0.5)),
            ];
            self.occ = (exact * 256.0 + 0.5).floor() / 256.0;
            if comparison > config.confirmation.to_num::<f64>() {
                for (id, word) in said {
                    self.agree(id, word);
                }
            }
            if comparison < config.contradiction.to_num::<f64>() {
                let [a, b] = said.map(|(id, word)| self.conf[id][word]);
                for ((id, word), (own, other)) in said.into_iter().zip([(a, b), (b, a)]) {
                    self.disagree(id, word, own, other);
                }
            }
            let contribution = 4.0 * (self.occ - 0.5) * (measurement - 0.5);
            self.owner = if contribution > config.contribution.to_num::<f64>() {
                sensor
            } else {
                0
            };
        }

        fn agree(&mut self, id: usize, word: usize) {
            let learning = self.rules.config().learning;
            let step: f64 = [learning.raise, learning.raise_free][word].to_num();
            let ceiling = real(learning.ceiling);
            for (of, own) in self.conf[id].iter_mut().enumerate() {
                if learning.attribution == FaultAttribution::Alike || word == 0 || of == word {
                    let whole = match learning.step_rule {
                        StepRule::Fixed => 1.0,
                        StepRule::Proportional => ceiling - *own,
                    };
                    *own = (*own + step * whole).min(ceiling);
                }
            }
        }

        fn disagree(&mut self, id: usize, word: usize, own: f64, other: f64) {
            let learning = self.rules.config().learning;
            let floor = real(learning.floor);
            // Bayes' rule for who of two is wrong if one is, twice over.
            let doubt = |confidence: f64| real(Confidence::FULL) - confidence + floor;
            let wrong = [doubt(own) * other, doubt(other) * own];
            let share = match learning.attribution {
                FaultAttribution::Alike => 1.0,
                FaultAttribution::Shared => 2.0 * wrong[0] / (wrong[0] + wrong[1]),
            };
            let step = learning.lower.to_num::<f64>() * share;
            for (of, own) in self.conf[id].iter_mut().enumerate() {
                if learning.attribution == FaultAttribution::Alike || of == word {
                    let whole = match learning.step_rule {
                        StepRule::Fixed => 1.0,
                        StepRule::Proportional => *own,
                    };
                    *own = (*own - step * whole).max(floor);
                }
            }
        }
    }

    fn real(confidence: Confidence) -> f64 {
        confidence.value().to_num()
    }

    #[test]
    fn the_papers_grid_takes_187_and_47_bytes() {
        assert_eq!(grid(17, 11, 3).memory_bytes(), 187 + 47);
    }

    #[test]
    fn an_unowned_cell_takes_the_measurement_as_is_and_so_does_the_owners_own() {
        let mut grid = grid(1, 1, 3);
        let cell = grid.geometry().cell(0, 0).unwrap();
        let mut sensors = [Health::default(); 3];
        for bits in [200, 10, 128, 255] {
            grid.add(cell, says(2, bits), &mut sensors);
            assert_eq!(grid.certainty(cell).to_bits(), bits);
            assert_eq!(grid.owner(cell), SensorId::try_new(2));
        }
        assert_eq!(sensors, [Health::default(); 3], "nobody was compared");
    }

    #[test]
    fn a_contradiction_lowers_both_and_leaves_the_cell_to_the_stronger() {
        let mut grid = grid(1, 1, 2);
        let cell = grid.geometry().cell(0, 0).unwrap();
        let mut sensors = [Health::default(); 2];
        grid.add(cell, says(1, 255), &mut sensors);
        grid.add(cell, says(2, 0), &mut sensors);
        // (255 · 127 + 0 · 128) / 255 = 127: a little nearer to free, so sensor 2 contributes.
        assert_eq!(grid.certainty(cell).to_bits(), 127);
        assert_eq!(grid.owner(cell), SensorId::try_new(2));
        // Each by a 48th, for what it said and for nothing else.
        for (health, said) in sensors.iter().zip([Claim::Occupied, Claim::Free]) {
            let lowered = health.confidence_in(said).to_bits();
            assert!(lowered.abs_diff(65_535 - 1365) <= 2, "{lowered}");
            assert_eq!(health.confidence().to_bits(), lowered);
        }
        assert_eq!(sensors[0].confidence_in(Claim::Free), Confidence::FULL);
        assert_eq!(sensors[1].confidence_in(Claim::Occupied), Confidence::FULL);
        assert!(sensors.iter().all(|health| health.contradictions() == 1));
    }

    #[test]
    fn a_voice_that_says_uncertain_leaves_the_value_and_frees_the_cell_of_its_owner() {
        let mut grid = grid(1, 1, 2);
        let cell = grid.geometry().cell(0, 0).unwrap();
        let mut sensors = [Health::default(); 2];
        grid.add(cell, says(1, 0), &mut sensors);
        grid.add(cell, says(2, 128), &mut sensors);
        assert_eq!(grid.certainty(cell), Certainty::FREE);
        assert_eq!(grid.owner(cell), None);
        // So the next word is taken as is: what a blind sensor freed is taken back.
        grid.add(cell, says(2, 128), &mut sensors);
        assert_eq!(grid.certainty(cell), Certainty::UNCERTAIN);
    }

    #[test]
    fn owners_are_drawn_where_they_spoke_last() {
        let mut grid = grid(4, 2, 3);
        let mut sensors = [Health::default(); 3];
        for (column, row, number) in [(0, 0, 1), (1, 0, 2), (2, 0, 3), (1, 1, 1), (1, 0, 3)] {
            let cell = grid.geometry().cell(column, row).unwrap();
            grid.add(cell, says(number, 255), &mut sensors);
        }
        let drawn = draw(&grid.geometry(), |cell| match grid.owner(cell) {
            Some(owner) => (b'0' + owner.number()) as char,
            None => '-',
        });
        assert_eq!(drawn, ["-1--", "133-"]);
    }

    #[test]
    fn a_sensor_that_is_not_listed_is_not_added() {
        let mut grid = grid(1, 1, 3);
        let cell = grid.geometry().cell(0, 0).unwrap();
        grid.add(cell, says(2, 255), &mut [Health::default(); 1]);
        assert_eq!(grid.certainty(cell), Certainty::UNCERTAIN);
        assert_eq!(grid.owner(cell), None);
    }

    #[test]
    fn a_sensor_the_grid_was_not_made_for_is_not_added() {
        let mut grid = grid(1, 1, 2);
        let cell = grid.geometry().cell(0, 0).unwrap();
        grid.add(cell, says(3, 255), &mut [Health::default(); 3]);
        assert_eq!(grid.certainty(cell), Certainty::UNCERTAIN);
    }

    #[test]
    fn storage_of_another_size_is_handed_back() {
        let shape = Geometry::try_new(2, 2, Millimeters::new(100), Point::ORIGIN).unwrap();
        let make = |cells: usize, owners: usize| {
            RobustGrid::try_new(
                shape,
                RobustRules::DEFAULT,
                3,
                vec![1; cells],
                vec![2; owners],
            )
        };
        let cells = make(3, 1).unwrap_err();
        assert_eq!(
            (cells.why, cells.storage),
            (
                GridErrorKind::Storage { needed: 4 },
                (vec![1; 3], vec![2; 1])
            )
        );
        let owners = make(4, 2).unwrap_err();
        assert_eq!(
            (owners.why, owners.storage.1),
            (GridErrorKind::Storage { needed: 1 }, vec![2; 2])
        );
    }

    proptest! {
        #[test]
        fn any_run_of_measurements_follows_the_figure(
            letters in any::<bool>(),
            run in prop::collection::vec((1..=3_u8, 0..=255_u8), 0..300),
        ) {
            let letter = RobustRules::try_new(RobustConfig::TO_THE_LETTER).unwrap();
            let rules = if letters { letter } else { RobustRules::DEFAULT };
            // Fixed steps are exact; parts of a part are rounded down, and a share to 2^-12 of it.
            let error = if letters { 0.0 } else { 3.0 / 65536.0 };
            let mut grid = with_rules(1, 1, 3, rules);
            let cell = grid.geometry().cell(0, 0).unwrap();
            let mut sensors = [Health::default(); 3];
            for (number, bits) in run {
                let mut naive = Naive::like(&grid, cell, &sensors);
                grid.add(cell, says(number, bits), &mut sensors);
                naive.add(number.into(), f64::from(bits) / 256.0);
                let after = Naive::like(&grid, cell, &sensors);
                prop_assert_eq!(after.occ, naive.occ);
                prop_assert_eq!(after.owner, naive.owner);
                for (own, expected) in after.conf.as_flattened().iter().zip(naive.conf.as_flattened()) {
                    prop_assert!((own - expected).abs() <= error, "{} {}", own, expected);
                }
            }
        }
    }
}
