//! Tables of measured characteristics: the readings of units at measured distances.
//!
//! Text with commas, semicolons, tabs or blanks between the columns; with other separators than commas,
//! numbers may have a decimal comma. `#` starts a comment line, blank lines are skipped. The first other
//! line names the columns: the distance with its unit (`dist_cm`, `distance_mm`, `mm`, …), and one name a
//! unit. Each further line is a distance and every unit's reading there, which need not be whole: it may
//! be a mean; a field that is empty, `-` or `nan` is left out of its unit and counted. Distances may come
//! in any order and repeatedly, so `distance_mm,raw` with a line a reading is a raw recording of one unit
//! called `raw`.
//!
//! Readings are counts of an ADC of 8 bits, unless [`Adc`] says that they are of more bits, or volts.

use super::characteristic::CurvePoint;
use crate::input::{Column, Fields, Separator, Unit};
use crate::quantity::Excerpt;
use thiserror::Error;

/// The converter whose counts a table has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Adc {
    /// The number of bits: 8, 10 or 12.
    bits: u8,
    /// The reference voltage, if the table has volts.
    reference: Option<f64>,
}

impl Adc {
    /// The byte of a GP2D02.
    pub const BYTE: Self = Self {
        bits: 8,
        reference: None,
    };

    /// The largest number of bits.
    pub const MOST_BITS: u8 = 16;

    /// Creates a converter of 8 to [`Self::MOST_BITS`] bits.
    #[must_use]
    pub const fn try_new(bits: u8) -> Option<Self> {
        if bits < 8 || bits > Self::MOST_BITS {
            return None;
        }
        Some(Self {
            bits,
            reference: None,
        })
    }

    /// Returns it for a table of volts, of which `reference` is the largest count.
    ///
    /// `None` unless the reference is a number of volts above 0.
    #[must_use]
    pub fn volts(self, reference: f64) -> Option<Self> {
        (reference.is_finite() && reference > 0.0).then_some(Self {
            reference: Some(reference),
            ..self
        })
    }

    /// Returns the number of bits.
    #[must_use]
    pub const fn bits(self) -> u8 {
        self.bits
    }

    /// Returns the reference voltage, if the table has volts.
    #[must_use]
    pub const fn reference(self) -> Option<f64> {
        self.reference
    }

    /// Returns the largest count.
    #[must_use]
    pub const fn most(self) -> f64 {
        ((1_u32 << self.bits) - 1) as f64
    }

    /// The counts of a value of the table, or why there are none.
    fn counts(self, value: f64) -> Option<f64> {
        let counts = match self.reference {
            Some(reference) => value / reference * self.most(),
            None => value,
        };
        (0.0..=self.most()).contains(&counts).then_some(counts)
    }
}

/// Values up to this, with fractions, look like volts.
const MOST_VOLTS: f64 = 5.5;

/// One unit's measured points.
///
/// Possession proves that every distance is finite and above 0 mm and every reading within the counts of
/// its [`Adc`].
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredUnit {
    name: String,
    adc: Adc,
    points: Vec<CurvePoint>,
    blanks: usize,
}

/// Why a table was refused; displays as one line that starts with the line number.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("line {line}: {problem}")]
pub struct TableError {
    /// The line, from 1.
    pub line: usize,
    /// The problem.
    pub problem: TableProblem,
}

/// The problem of a line of a table; displays as one line that says what to do.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TableProblem {
    /// The line that names the columns is missing, or names no unit.
    #[error(
        "name the columns: dist_cm or distance_mm, and one name a unit, separated by commas, semicolons or tabs"
    )]
    NoHeader,
    /// The line names more units than [`MeasuredUnit::MOST_UNITS`].
    #[error("more than {} units; split the table", MeasuredUnit::MOST_UNITS)]
    TooManyUnits,
    /// Two units have one name.
    #[error("two columns {name}: name each unit once")]
    SameName {
        /// The name.
        name: Excerpt,
    },
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
    #[error("column {column}: '{text}' is no distance; write one above 0")]
    NoDistance {
        /// The column, from 1.
        column: usize,
        /// The text.
        text: Excerpt,
    },
    /// A reading is outside the counts or the volts of the ADC.
    #[error("column {column}: '{text}' is not within 0 to {}", most(*.adc))]
    OutOfScale {
        /// The column, from 1.
        column: usize,
        /// The text.
        text: Excerpt,
        /// The ADC.
        adc: Adc,
    },
    /// All readings are small and have fractions: volts.
    #[error(
        "the readings look like volts: give --volts, and --vref if the ADC's reference is not 5 V"
    )]
    Volts,
    /// The table holds more numbers than [`MeasuredUnit::MOST_POINTS`].
    #[error("more than {} points; split the table", MeasuredUnit::MOST_POINTS)]
    TooManyPoints,
}

/// The end of the scale, and the option that has a longer one.
fn most(adc: Adc) -> String {
    match adc.reference {
        Some(reference) => format!("the reference of {reference} V: give --vref the ADC's own"),
        None if adc.bits < 12 => format!(
            "{}, the counts of {} bits: give --adc-bits 10 or 12 if the ADC has more",
            adc.most(),
            adc.bits
        ),
        None => format!("{}, the counts of {} bits", adc.most(), adc.bits),
    }
}

impl MeasuredUnit {
    /// The largest number of units in one table.
    pub const MOST_UNITS: usize = 256;

    /// The largest number of points in one table, of all units together: those of one GP2D02 in
    /// four hours.
    pub const MOST_POINTS: usize = 200_000;

    /// Reads a table of bytes.
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
        Self::parse_as(table, Adc::BYTE)
    }

    /// Reads a table of what `adc` says; the points are in its counts.
    ///
    /// # Errors
    ///
    /// [`TableError`] names the line.
    pub fn parse_as(table: &str, adc: Adc) -> Result<Vec<Self>, TableError> {
        let mut lines = (1..)
            .zip(table.strip_prefix('\u{FEFF}').unwrap_or(table).lines())
            .filter(|(_, line)| !line.trim().is_empty());
        let at = |line: usize| move |problem: TableProblem| TableError { line, problem };
        let (line, header) = lines
            .find_map(|(line, text)| match text.trim().strip_prefix('#') {
                None => Some((line, Header::of(text))),
                // A header may be a comment; a sentence is none.
                Some(_) if Separator::of(text) == Separator::Blanks => None,
                Some(_) => Header::of(text).ok().map(|header| (line, Ok(header))),
            })
            .ok_or(at(1)(TableProblem::NoHeader))?;
        let header = header.map_err(at(line))?;
        let unit = |name: &String| Self {
            name: name.clone(),
            adc,
            points: Vec::new(),
            blanks: 0,
        };
        let mut units: Vec<Self> = header.names.iter().map(unit).collect();
        let mut fields = Fields::new(header.separator);
        let mut points = 0;
        for (line, row) in lines.filter(|(_, line)| !line.trim_start().starts_with('#')) {
            points += units.len();
            if points > Self::MOST_POINTS {
                return Err(at(line)(TableProblem::TooManyPoints));
            }
            fields.split(row);
            add(&mut units, &fields, &header, adc).map_err(at(line))?;
        }
        let raw = || {
            units
                .iter()
                .flat_map(|unit| &unit.points)
                .map(|point| point.raw)
        };
        if adc.reference.is_none()
            && raw().all(|raw| raw <= MOST_VOLTS)
            && raw().any(|raw| raw.fract() != 0.0)
        {
            return Err(at(line)(TableProblem::Volts));
        }
        Ok(units)
    }

    /// Returns the converter whose counts the points have.
    #[must_use]
    pub const fn adc(&self) -> Adc {
        self.adc
    }

    /// Returns how many fields of the unit had no reading.
    #[must_use]
    pub const fn blanks(&self) -> usize {
        self.blanks
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

/// The columns of a table.
struct Header {
    separator: Separator,
    columns: usize,
    /// The column of the distances, and their unit in millimetres.
    distance: usize,
    mm: f64,
    /// The units, in the order of the other columns.
    names: Vec<String>,
}

/// The unit of the distances in millimetres, if this is their column.
fn distance_mm(column: &Column) -> Option<f64> {
    let named = ["dist", "distance", "d", "range"].contains(&column.stem.as_str());
    match (column.stem.as_str(), column.unit) {
        ("mm", None) => Some(1.0),
        ("cm", None) => Some(10.0),
        (_, Some(Unit::Millimeters)) if named => Some(1.0),
        (_, Some(Unit::Centimeters)) if named => Some(10.0),
        (_, Some(Unit::Meters)) if named => Some(1000.0),
        _ => None,
    }
}

impl Header {
    fn of(line: &str) -> Result<Self, TableProblem> {
        let (separator, mut columns) = Column::all(line);
        // Spreadsheets add separators at the end.
        while columns
            .last()
            .is_some_and(|column| column.written.is_empty())
        {
            columns.pop();
        }
        let mut distances = (0..).zip(columns.iter().map(distance_mm));
        let found = distances.find_map(|(place, mm)| Some((place, mm?)));
        let (distance, mm) = found.ok_or(TableProblem::NoHeader)?;
        let count = columns.len();
        columns.remove(distance);
        let most = MeasuredUnit::MOST_UNITS;
        if columns.is_empty() || columns.iter().any(|column| column.written.is_empty()) {
            return Err(TableProblem::NoHeader);
        }
        if columns.len() > most {
            return Err(TableProblem::TooManyUnits);
        }
        for (place, column) in columns.iter().enumerate() {
            let same = |other: &Column| other.written.eq_ignore_ascii_case(&column.written);
            if columns[..place].iter().any(same) {
                let name = Excerpt::new(&column.written);
                return Err(TableProblem::SameName { name });
            }
        }
        Ok(Self {
            separator,
            columns: count,
            distance,
            mm,
            names: columns.into_iter().map(|column| column.written).collect(),
        })
    }
}

/// Whether a field says that there is no reading.
fn is_blank(text: &str) -> bool {
    let blank = ["", "-", "nan", "na", "n/a", "null", "missing"];
    blank.iter().any(|word| text.eq_ignore_ascii_case(word))
}

/// Adds a line's points.
fn add(
    units: &mut [MeasuredUnit],
    fields: &Fields,
    header: &Header,
    adc: Adc,
) -> Result<(), TableProblem> {
    let (found, expected) = (fields.len(), header.columns);
    let empty = |index: usize| fields.get(index).is_none_or(str::is_empty);
    if found < expected || !(expected..found).all(empty) {
        return Err(TableProblem::Columns { found, expected });
    }
    let number = |place: usize| {
        let text = Excerpt::new(fields.get(place).unwrap_or_default());
        let column = place + 1;
        match fields.number(place) {
            Some(number) => Ok((column, number, text)),
            None => Err(TableProblem::NotANumber { column, text }),
        }
    };
    let (column, distance, text) = number(header.distance)?;
    let distance_mm = distance * header.mm;
    if !(distance_mm.is_finite() && distance_mm > 0.0) {
        return Err(TableProblem::NoDistance { column, text });
    }
    let places = (0..header.columns).filter(|&place| place != header.distance);
    for (unit, place) in units.iter_mut().zip(places) {
        if is_blank(fields.get(place).unwrap_or_default()) {
            unit.blanks += 1;
            continue;
        }
        let (column, value, text) = number(place)?;
        let Some(raw) = adc.counts(value) else {
            return Err(TableProblem::OutOfScale { column, text, adc });
        };
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
            (
                "dist_cm,left,right,Left\n10,1,2,3",
                "line 1: two columns Left: name each unit once",
            ),
            ("dist_cm,A\n10,x", "line 2: column 2: 'x' is not a number"),
            ("dist_cm,A\n,1", "line 2: column 1: '' is not a number"),
            ("dist_cm,A\nNaN,1", "line 2: column 1: 'NaN' is no distance"),
            ("dist_cm,A\n0,1", "line 2: column 1: '0' is no distance"),
            ("dist_cm,A\n1e308,1", "line 2: column 1: '1e308' is no dist"),
            (
                "dist_cm,A,B\n10,190,256\n",
                "line 2: column 3: '256' is not within 0 to 255, the counts of 8 bits: give --adc-bits 10 or 12",
            ),
            (
                "dist_cm,A\n10,-1",
                "line 2: column 2: '-1' is not within 0 to 255",
            ),
            (
                "dist_cm,A\n10,inf",
                "line 2: column 2: 'inf' is not within 0 to 255",
            ),
            (
                "dist_cm,A\n10,2.7\n20,1.5",
                "line 1: the readings look like volts: give --volts",
            ),
        ] {
            let line = error_of(table);
            assert!(line.starts_with(start), "{table:?}: {line}");
        }
    }

    /// A unit's name, its distances and readings, and its blank fields.
    type UnitPoints = (String, Vec<(f64, f64)>, usize);

    fn points(table: &str, adc: Adc) -> Vec<UnitPoints> {
        let units = MeasuredUnit::parse_as(table, adc).unwrap();
        let unit = |unit: &MeasuredUnit| {
            let points = unit.points().iter().map(|p| (p.distance_mm, p.raw));
            (unit.name().to_owned(), points.collect(), unit.blanks())
        };
        units.iter().map(unit).collect()
    }

    #[test]
    fn tables_of_spreadsheets_mean_the_same() {
        let expected = points("dist_cm,left,right\n10,229.5,226\n12,204,\n", Adc::BYTE);
        assert_eq!(expected[1].2, 1);
        for table in [
            "dist_cm;left;right\n10,0;229,5;226\n12;204;-;\n",
            "# by hand, twice\nDistance_MM, \"left\", right\n100, 229.5, 226\n120, 204, nan\n",
            "left\tright\tDistance [cm]\n229,5\t226\t10\n204\t\t12\n",
            "cm left right\n10 229.5 226\n12 204 NA\n",
            "# dist_m,left,right\n0.1,229.5,226\n0.12,204,missing\n",
        ] {
            assert_eq!(points(table, Adc::BYTE), expected, "{table}");
        }
    }

    #[test]
    fn other_converters_are_named() {
        let table = "dist_cm,A\n15,553\n20,505\n";
        assert!(error_of(table).contains("--adc-bits 10 or 12"));
        let ten = Adc::try_new(10).unwrap();
        assert_eq!(points(table, ten)[0].1, [(150.0, 553.0), (200.0, 505.0)]);
        let volts = "dist_cm,A\n15,2.5\n20,1.25\n";
        assert!(error_of(volts).contains("--volts"));
        let five = ten.volts(5.0).unwrap();
        assert_eq!(points(volts, five)[0].1, [(150.0, 511.5), (200.0, 255.75)]);
        let error = MeasuredUnit::parse_as("dist_cm,A\n15,6\n", five).unwrap_err();
        assert!(error.to_string().contains("--vref"), "{error}");
        assert_eq!(
            (Adc::try_new(7), ten.volts(0.0), ten.volts(f64::NAN)),
            (None, None, None)
        );
    }

    #[test]
    fn a_table_that_is_too_large_is_refused() {
        let names = (0..MeasuredUnit::MOST_UNITS).map(|unit| format!(",a{unit}"));
        let wide = "distance_mm".to_owned() + &names.collect::<String>();
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
