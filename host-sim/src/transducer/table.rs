//! Tables of measured characteristics: the bytes of units at measured distances.
//!
//! Comma-separated text. `#` starts a comment line, blank lines are skipped. The first other
//! line names the columns: `dist_cm` or `distance_mm`, then one name a unit. Each further line is a
//! distance in that unit of length and every unit's byte there, which need not be whole: it may be
//! a mean. Distances may come in any order and repeatedly, so `distance_mm,raw`
//! with a line a reading is a raw recording of one unit called `raw`.

use super::characteristic::CurvePoint;
use crate::quantity::Excerpt;
use thiserror::Error;

/// One unit's measured points.
///
/// Possession proves that every distance is finite and above 0 mm and every byte within 0..=255.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredUnit {
    name: String,
    points: Vec<CurvePoint>,
}

/// Why a table was refused; displays as one line that starts with the line number.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("line {line}: {problem}")]
pub struct TableError {
    /// The line, from 1.
    pub line: usize,
    /// The problem.
    pub problem: TableProblem,
}

/// The problem of a line of a table; displays as one line that says what to do.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum TableProblem {
    /// The line that names the columns is missing, or names no unit.
    #[error("name the columns: dist_cm or distance_mm, and one name a unit, separated by commas")]
    NoHeader,
    /// The line names more units than [`MeasuredUnit::MOST_UNITS`].
    #[error("more than {} units; split the table", MeasuredUnit::MOST_UNITS)]
    TooManyUnits,
    /// The line has more or fewer columns than the first.
    #[error("{found} columns where the first line names {expected}; complete the line")]
    Columns {
        /// The number of columns.
        found: usize,
        /// The expected number.
        expected: usize,
    },
    /// A field is no number.
    #[error("column {column}: '{text}' is not a number; write distances and bytes as numbers")]
    NotANumber {
        /// The column, from 1.
        column: usize,
        /// The text.
        text: Excerpt,
    },
    /// A distance is not above zero, or not finite.
    #[error("column 1: '{text}' is no distance; write one above 0")]
    NoDistance {
        /// The text.
        text: Excerpt,
    },
    /// A byte is outside 0..=255.
    #[error("column {column}: '{text}' is no byte; write a number within 0..=255")]
    NoByte {
        /// The column, from 1.
        column: usize,
        /// The text.
        text: Excerpt,
    },
    /// The table holds more numbers than [`MeasuredUnit::MOST_POINTS`].
    #[error("more than {} points; split the table", MeasuredUnit::MOST_POINTS)]
    TooManyPoints,
}

impl MeasuredUnit {
    /// The largest number of units in one table.
    pub const MOST_UNITS: usize = 256;

    /// The largest number of points in one table, of all units together: those of one GP2D02 in
    /// four hours.
    pub const MOST_POINTS: usize = 200_000;

    /// Reads a table.
    ///
    /// ```
    /// use certainty_sim::transducer::MeasuredUnit;
    ///
    /// let units = MeasuredUnit::parse("dist_cm,left,right\n10,190,201\n80,75,82.5\n")?;
    /// assert_eq!(units[1].name(), "right");
    /// let last = units[1].points()[1];
    /// assert_eq!((last.distance_mm, last.raw), (800.0, 82.5));
    /// # Ok::<(), certainty_sim::transducer::TableError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`TableError`] names the line.
    pub fn parse(table: &str) -> Result<Vec<Self>, TableError> {
        let mut lines = (1..)
            .zip(table.strip_prefix('\u{FEFF}').unwrap_or(table).lines())
            .filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
        let at = |line: usize| move |problem: TableProblem| TableError { line, problem };
        let (line, header) = lines.next().ok_or(at(1)(TableProblem::NoHeader))?;
        let (mm, names) = columns(header).map_err(at(line))?;
        let unit = |name: String| Self {
            name,
            points: Vec::new(),
        };
        let mut units: Vec<Self> = names.into_iter().map(unit).collect();
        let mut points = 0;
        for (line, row) in lines {
            points += units.len();
            if points > Self::MOST_POINTS {
                return Err(at(line)(TableProblem::TooManyPoints));
            }
            add(&mut units, row, mm).map_err(at(line))?;
        }
        Ok(units)
    }

    /// Returns the unit's name, as the table has it.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the points, in the table's order.
    #[must_use]
    pub fn points(&self) -> &[CurvePoint] {
        &self.points
    }
}

/// The unit of the distances in millimetres, and the units' names.
fn columns(header: &str) -> Result<(f64, Vec<String>), TableProblem> {
    let mut fields = header.split(',').map(str::trim);
    let mm = match fields.next() {
        Some("dist_cm") => 10.0,
        Some("distance_mm") => 1.0,
        _ => return Err(TableProblem::NoHeader),
    };
    let most = MeasuredUnit::MOST_UNITS;
    let names: Vec<String> = fields.take(most + 1).map(str::to_owned).collect();
    if names.is_empty() || names.iter().any(String::is_empty) {
        return Err(TableProblem::NoHeader);
    }
    if names.len() > most {
        return Err(TableProblem::TooManyUnits);
    }
    Ok((mm, names))
}

/// Adds a line's points.
fn add(units: &mut [MeasuredUnit], row: &str, mm: f64) -> Result<(), TableProblem> {
    let (found, expected) = (row.split(',').count(), units.len() + 1);
    if found != expected {
        return Err(TableProblem::Columns { found, expected });
    }
    let mut fields = (1..).zip(row.split(',')).map(|(column, field)| {
        let text = Excerpt::new(field.trim());
        match field.trim().parse::<f64>() {
            Ok(number) => Ok((column, number, text)),
            Err(_) => Err(TableProblem::NotANumber { column, text }),
        }
    });
    let Some(first) = fields.next() else {
        return Err(TableProblem::Columns { found, expected });
    };
    let (_, distance, text) = first?;
    let distance_mm = distance * mm;
    if !(distance_mm.is_finite() && distance_mm > 0.0) {
        return Err(TableProblem::NoDistance { text });
    }
    for (unit, field) in units.iter_mut().zip(fields) {
        let (column, raw, text) = field?;
        if !(0.0..=255.0).contains(&raw) {
            return Err(TableProblem::NoByte { column, text });
        }
        unit.points.push(CurvePoint { distance_mm, raw });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn error_of(table: &str) -> String {
        MeasuredUnit::parse(table).unwrap_err().to_string()
    }

    #[test]
    fn a_raw_recording_is_a_table_of_one_unit() {
        let table =
            "\u{FEFF}# by hand\r\ndistance_mm,raw\r\n\r\n100,190\r\n100, 191\r\n80.5,200\r\n";
        let units = MeasuredUnit::parse(table).unwrap();
        assert_eq!((units.len(), units[0].name()), (1, "raw"));
        let points = units[0].points().iter().map(|p| (p.distance_mm, p.raw));
        let expected = [(100.0, 190.0), (100.0, 191.0), (80.5, 200.0)];
        assert_eq!(points.collect::<Vec<_>>(), expected);
    }

    #[test]
    fn each_error_names_its_place() {
        for (table, start) in [
            ("", "line 1: name the columns: dist_cm or distance_mm"),
            ("# only\n# notes\n", "line 1: name the columns"),
            ("\n# note\ndist_cm", "line 3: name the columns"),
            ("distance,raw\n1,2", "line 1: name the columns"),
            ("dist_cm,A,,B\n", "line 1: name the columns"),
            (
                "dist_cm,A,B\n10,190,191\n# note\n20,135\n",
                "line 4: 2 columns where the first line names 3; complete",
            ),
            ("dist_cm,A\n10,x", "line 2: column 2: 'x' is not a number"),
            ("dist_cm,A\n,1", "line 2: column 1: '' is not a number"),
            ("dist_cm,A\nNaN,1", "line 2: column 1: 'NaN' is no distance"),
            ("dist_cm,A\n0,1", "line 2: column 1: '0' is no distance"),
            ("dist_cm,A\n1e308,1", "line 2: column 1: '1e308' is no dist"),
            (
                "dist_cm,A,B\n10,190,256\n",
                "line 2: column 3: '256' is no byte; write a number within 0..=255",
            ),
            ("dist_cm,A\n10,-1", "line 2: column 2: '-1' is no byte"),
            ("dist_cm,A\n10,nan", "line 2: column 2: 'nan' is no byte"),
        ] {
            let line = error_of(table);
            assert!(line.starts_with(start), "{table:?}: {line}");
        }
    }

    #[test]
    fn a_table_that_is_too_large_is_refused() {
        let wide = "distance_mm".to_owned() + &",a".repeat(MeasuredUnit::MOST_UNITS);
        assert_eq!(
            MeasuredUnit::parse(&wide).unwrap().len(),
            MeasuredUnit::MOST_UNITS
        );
        assert_eq!(
            error_of(&(wide + ",a")),
            "line 1: more than 256 units; split the table"
        );
        let long = "distance_mm,raw\n".to_owned() + &"1,1\n".repeat(MeasuredUnit::MOST_POINTS);
        assert!(MeasuredUnit::parse(&long).is_ok());
        let line = error_of(&(long + "1,1\n"));
        assert_eq!(
            line,
            "line 200002: more than 200000 points; split the table"
        );
    }

    proptest! {
        #[test]
        fn no_table_panics(table in "((dist_cm|distance_mm),A(,B)?\n)?([0-9.,aN-]{0,12}\n){0,6}") {
            if let Ok(units) = MeasuredUnit::parse(&table) {
                let points = units.iter().flat_map(MeasuredUnit::points);
                for point in points {
                    prop_assert!(point.distance_mm > 0.0 && (0.0..=255.0).contains(&point.raw));
                }
            }
        }
    }
}
