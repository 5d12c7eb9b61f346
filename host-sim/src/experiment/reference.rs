//! The certainty grid of perfect virtual sensors, which \[001\] §6.2 measures against.

use crate::transducer::{Look, PerfectSensor, Sensor};
use certainty_core::certainty::Certainty;
use certainty_core::fusion::{Beam, BeamModel, Cell, Geometry};

/// What perfect sensors say about a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Truth {
    /// Never seen, or only behind an obstacle.
    Unseen,
    /// Looked through and never hit.
    Free,
    /// Hit at least once.
    Occupied,
}

impl Truth {
    /// Returns the landmark that a perfect grid shows for it.
    #[must_use]
    pub const fn certainty(self) -> Certainty {
        match self {
            Self::Unseen => Certainty::UNCERTAIN,
            Self::Free => Certainty::FREE,
            Self::Occupied => Certainty::OCCUPIED,
        }
    }
}

/// The grid that perfect sensors draw when they look where the real ones looked.
///
/// A cell hit once is occupied, whoever looks through it later: perfect sensors do not err, and a
/// cell that an obstacle only grazes is both hit and passed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Reference {
    geometry: Geometry,
    cells: Vec<Truth>,
}

impl Reference {
    /// Creates the grid from a perfect sensor and the looks of all real ones.
    pub fn new(
        geometry: Geometry,
        model: &BeamModel,
        mut perfect: PerfectSensor,
        looks: impl IntoIterator<Item = Look>,
    ) -> Self {
        let mut cells = vec![Truth::Unseen; geometry.cells() as usize];
        for look in looks {
            let beam = Beam {
                origin: look.origin,
                bearing: look.bearing,
                reading: perfect.sense(&look),
            };
            beam.interpret(&geometry, model, &mut |cell: Cell, certainty: Certainty| {
                let truth = &mut cells[cell.index()];
                *truth = match (*truth, certainty) {
                    (_, Certainty::OCCUPIED) => Truth::Occupied,
                    (Truth::Unseen, Certainty::FREE) => Truth::Free,
                    (unchanged, _) => unchanged,
                };
            });
        }
        Self { geometry, cells }
    }

    /// Returns where the grid lies.
    #[must_use]
    pub const fn geometry(&self) -> Geometry {
        self.geometry
    }

    /// Returns the truth of every cell, row after row from the lowest.
    #[must_use]
    pub fn cells(&self) -> &[Truth] {
        &self.cells
    }
}
