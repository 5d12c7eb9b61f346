//! Real GP2D02 units, each with its own curve and calibration.

use super::characteristic::{Characteristic, CurveError, FitError};
use super::table::{MeasuredUnit, TableError};
use certainty_core::transducer::{Calibration, Reading};
use certainty_firmware::smart_car::{FARTHEST, NEAREST};
use std::sync::LazyLock;
use thiserror::Error;

/// The table of the sixteen real units in this package.
///
/// Source: numbers tabulated in the public project humbertomb/ThinkingCapSim (robot Quaky II).
pub const GP2D02_UNITS: &str = include_str!("../../data/gp2d02-units.csv");

/// One GP2D02 and its calibration.
///
/// Possession proves that the calibration distinguishes *no object* from an echo: the unit's byte where
/// nothing reflects reads as no object.
#[derive(Debug, Clone, PartialEq)]
pub struct Gp2d02Unit {
    name: String,
    characteristic: Characteristic,
    calibration: Calibration,
    faintest_echo: u8,
}

/// Why a table of units was refused; displays as one line.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum UnitsError {
    /// The table itself is wrong.
    #[error("{0}")]
    Table(TableError),
    /// A unit's column is no characteristic.
    #[error("column {column}: {source}")]
    Curve {
        /// The column, from 1.
        column: usize,
        /// The error.
        source: CurveError,
    },
}

impl Gp2d02Unit {
    /// Creates a unit from its curve; its calibration is the curve's fit over 100 mm to 800 mm.
    ///
    /// # Errors
    ///
    /// [`FitError`] where the core cannot hold the calibration, [`FitError::Floor`] also where it
    /// could not distinguish an echo from none.
    pub fn new(name: impl Into<String>, characteristic: Characteristic) -> Result<Self, FitError> {
        let calibration = characteristic.fit().calibration(NEAREST, FARTHEST)?;
        let no_object = characteristic.no_object_raw().round() as u8;
        let faintest_echo = (no_object..=u8::MAX)
            .find(|&raw| matches!(calibration.reading(raw), Reading::Echo(_)))
            .filter(|&faintest| faintest > no_object)
            .ok_or(FitError::Floor)?;
        Ok(Self {
            name: name.into(),
            characteristic,
            calibration,
            faintest_echo,
        })
    }

    /// Returns the sixteen real units, `A0_0` to `A3_3`.
    ///
    /// # Panics
    ///
    /// If the built-in table is invalid, which a test excludes.
    #[must_use]
    pub fn shipped() -> &'static [Self] {
        static UNITS: LazyLock<Vec<Gp2d02Unit>> =
            LazyLock::new(|| Gp2d02Unit::parse(GP2D02_UNITS).expect("the built-in table is valid"));
        &UNITS
    }

    /// Parses a table of units, as [`MeasuredUnit::parse`] does, and fits each; the distances must ascend.
    ///
    /// # Errors
    ///
    /// [`UnitsError`] names the line or the column.
    pub fn parse(table: &str) -> Result<Vec<Self>, UnitsError> {
        (2..)
            .zip(MeasuredUnit::parse(table).map_err(UnitsError::Table)?)
            .map(|(column, measured)| {
                let refused = |source| UnitsError::Curve { column, source };
                let points = measured.points().to_vec();
                let curve = Characteristic::through(points).map_err(refused)?;
                Self::new(measured.name(), curve).map_err(|e| refused(CurveError::Fit(e)))
            })
            .collect()
    }

    /// Returns the unit's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the unit's byte as a function of distance.
    #[must_use]
    pub const fn characteristic(&self) -> &Characteristic {
        &self.characteristic
    }

    /// Returns the calibration, which converts the unit's bytes to millimetres.
    #[must_use]
    pub const fn calibration(&self) -> &Calibration {
        &self.calibration
    }

    /// Returns the smallest byte that the calibration reads as an echo; it is above the byte for no object.
    #[must_use]
    pub const fn faintest_echo(&self) -> u8 {
        self.faintest_echo
    }

    /// Returns the byte the unit gives at `distance_mm`, rounded to the nearest.
    #[must_use]
    pub fn byte_at(&self, distance_mm: f64) -> u8 {
        // Within 0..=255 already; the cast saturates.
        self.characteristic.raw(distance_mm).round() as u8
    }

    /// Returns the byte that the unit's calibration reads as `reading`, or as near to it as any byte
    /// is; `None` for a missing one.
    ///
    /// The inverse of the calibration: the result for the reading of a byte reads the same as that byte.
    #[must_use]
    pub fn byte_for(&self, reading: Reading) -> Option<u8> {
        match reading {
            Reading::Echo(distance) => (self.faintest_echo..=u8::MAX)
                .filter_map(|raw| match self.calibration.reading(raw) {
                    Reading::Echo(read) => Some((read.get().abs_diff(distance.get()), raw)),
                    _ => None,
                })
                .min()
                .map(|(_, raw)| raw),
            Reading::NoObject => Some(self.no_object_byte()),
            Reading::TooNear => Some(u8::MAX),
            Reading::Missing(_) => None,
        }
    }

    /// Returns the byte the unit gives where nothing reflects.
    #[must_use]
    pub fn no_object_byte(&self) -> u8 {
        self.characteristic.no_object_raw().round() as u8
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_byte_of_a_reading_reads_the_same() {
        for unit in Gp2d02Unit::shipped() {
            for raw in 0..=u8::MAX {
                let reading = unit.calibration().reading(raw);
                let back = unit.byte_for(reading).unwrap();
                assert_eq!(unit.calibration().reading(back), reading, "{}", unit.name());
            }
        }
    }

    #[test]
    fn the_table_has_16_units_at_22_distances() {
        let units = Gp2d02Unit::shipped();
        assert_eq!(units.len(), 16);
        for unit in units {
            assert_eq!(unit.characteristic().points().len(), 22, "{}", unit.name());
        }
        assert_eq!(units[5].name(), "A1_1");
        assert_eq!(units[5].byte_at(80.0), 244);
        assert_eq!(units[5].byte_at(900.0), 111);
    }

    #[test]
    fn every_unit_fits_within_about_a_count() {
        // Two-sided: an improvement is unexpected as well.
        let (mut worst_rms, mut worst) = (0.0_f64, 0.0_f64);
        for unit in Gp2d02Unit::shipped() {
            let fit = unit.characteristic().fit();
            println!(
                "{}: a {:.0} b {} c {:.2} rms {:.2} worst {:.2}",
                unit.name(),
                fit.slope(),
                fit.offset(),
                fit.floor(),
                fit.rms(),
                fit.worst()
            );
            worst_rms = worst_rms.max(fit.rms());
            worst = worst.max(fit.worst());
        }
        assert!((0.9..1.1).contains(&worst_rms), "{worst_rms}");
        assert!((2.5..3.0).contains(&worst), "{worst}");
    }

    #[test]
    fn units_differ_by_48_counts_at_80_cm() {
        let bytes = Gp2d02Unit::shipped().iter().map(|unit| unit.byte_at(800.0));
        let (least, most) = (bytes.clone().min().unwrap(), bytes.max().unwrap());
        assert_eq!(most - least, 48);
    }

    #[test]
    fn every_unit_reads_its_curve_within_13_percent() {
        for unit in Gp2d02Unit::shipped() {
            for mm in (120..=700).step_by(10) {
                let truth = f64::from(mm);
                let Reading::Echo(read) = unit.calibration().reading(unit.byte_at(truth)) else {
                    panic!("{} does not echo at {mm} mm", unit.name());
                };
                let error = (f64::from(read.get()) - truth).abs() / truth;
                assert!(error < 0.13, "{} at {mm} mm: {error}", unit.name());
            }
            let no_object = unit.no_object_byte();
            assert_eq!(unit.calibration().reading(no_object), Reading::NoObject);
        }
    }

    #[test]
    fn each_error_names_its_place() {
        let line = |table| Gp2d02Unit::parse(table).unwrap_err().to_string();
        assert!(line("").starts_with("line 1: name the columns"));
        assert_eq!(
            line("dist_cm,A\n20,135\n10,190\n40,95\n"),
            "column 2: the distances of a characteristic must ascend"
        );
        assert_eq!(
            line("dist_cm,A,B\n10,190,75\n20,135,95\n40,95,190\n"),
            "column 3: the byte must fall with distance"
        );
        assert_eq!(
            line("dist_cm,A\n10,190\n"),
            "column 2: a characteristic needs points at three distances or more"
        );
    }

    proptest! {
        #[test]
        fn no_table_panics(table in "(dist_cm,A(,B)?\n)?([0-9.,aN-]{0,12}\n){0,6}") {
            let _: Result<_, UnitsError> = Gp2d02Unit::parse(&table); // either is right
        }
    }
}
