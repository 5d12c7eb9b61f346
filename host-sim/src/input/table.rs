//! Lines of a table as fields, and the names of its columns.
//!
//! A header decides what separates fields: comma, semicolon or tab, or blanks if it has none of them.
//! Where the separator is no comma, a number may have a decimal comma.

use csv_core::{ReadRecordResult, ReaderBuilder};

/// What separates fields.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Separator {
    Comma,
    Semicolon,
    Tab,
    Blanks,
}

impl Separator {
    /// The separator that a header has most often; blanks if it has none.
    pub(crate) fn of(header: &str) -> Self {
        let count = |separator: char| header.matches(separator).count();
        let all = [
            (count('\t'), Self::Tab),
            (count(';'), Self::Semicolon),
            (count(','), Self::Comma),
        ];
        // Of equal counts the last one.
        let (most, separator) = all
            .into_iter()
            .max_by_key(|&(count, _)| count)
            .unwrap_or((0, Self::Comma));
        if most == 0 { Self::Blanks } else { separator }
    }

    /// Whether a comma within a field is a decimal comma.
    pub(crate) fn decimal_comma(self) -> bool {
        self != Self::Comma
    }

    const fn byte(self) -> u8 {
        match self {
            Self::Comma => b',',
            Self::Semicolon => b';',
            Self::Tab | Self::Blanks => b'\t',
        }
    }
}

/// Splits lines into fields, without quotes and blanks around them.
#[derive(Debug)]
pub(crate) struct Fields {
    separator: Separator,
    reader: csv_core::Reader,
    text: String,
    bytes: Vec<u8>,
    ends: Vec<usize>,
    count: usize,
}

impl Fields {
    pub(crate) fn new(separator: Separator) -> Self {
        Self {
            separator,
            reader: ReaderBuilder::new().delimiter(separator.byte()).build(),
            text: String::new(),
            bytes: vec![0; 256],
            ends: vec![0; 16],
            count: 0,
        }
    }

    /// Returns what separates fields.
    pub(crate) const fn separator(&self) -> Separator {
        self.separator
    }

    /// Splits `line`; a quote that is not closed ends with the line.
    pub(crate) fn split(&mut self, line: &str) {
        self.count = 0;
        self.text.clear();
        if self.separator == Separator::Blanks {
            for word in line.split_whitespace() {
                self.text.push_str(word);
                self.end(self.text.len());
            }
            return;
        }
        self.reader.reset();
        let (mut input, mut written, mut ended) = (line.as_bytes(), 0, 0);
        loop {
            let (result, read, wrote, ends) =
                self.reader
                    .read_record(input, &mut self.bytes[written..], &mut self.ends[ended..]);
            // The end of the input is read as an empty input.
            let at_end = input.is_empty();
            input = input.get(read..).unwrap_or_default();
            written += wrote;
            ended += ends;
            match result {
                ReadRecordResult::OutputFull => self.bytes.resize(2 * self.bytes.len(), 0),
                ReadRecordResult::OutputEndsFull => self.ends.resize(2 * self.ends.len(), 0),
                ReadRecordResult::InputEmpty if !at_end => {}
                _ => break,
            }
        }
        self.count = ended;
        // Text that is split at ASCII characters stays UTF-8.
        self.text
            .push_str(str::from_utf8(&self.bytes[..written]).unwrap_or_default());
    }

    fn end(&mut self, at: usize) {
        if self.count == self.ends.len() {
            self.ends.resize(2 * self.ends.len(), 0);
        }
        self.ends[self.count] = at;
        self.count += 1;
    }

    /// Returns the number of fields.
    pub(crate) const fn len(&self) -> usize {
        self.count
    }

    /// Returns a field; `None` if the line has fewer.
    pub(crate) fn get(&self, index: usize) -> Option<&str> {
        let end = *self.ends[..self.count].get(index)?;
        let start = index.checked_sub(1).map_or(0, |before| self.ends[before]);
        let field = self.text.get(start..end)?.trim();
        // Quotes with a blank before them are not the reader's.
        let inner = field
            .strip_prefix('"')
            .and_then(|rest| rest.strip_suffix('"'));
        Some(inner.map_or(field, str::trim))
    }

    /// Returns all fields.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &str> + '_ {
        (0..self.count).filter_map(|index| self.get(index))
    }

    /// Returns a field as a number.
    pub(crate) fn number(&self, index: usize) -> Option<f64> {
        number(self.get(index)?, self.separator)
    }
}

/// Parses a number, with a decimal comma where the separator is no comma; `inf` and `nan` too.
pub(crate) fn number(text: &str, separator: Separator) -> Option<f64> {
    if let Ok(number) = text.parse() {
        return Some(number);
    }
    let comma = separator.decimal_comma() && text.matches(',').count() == 1 && !text.contains('.');
    comma.then(|| text.replace(',', ".").parse().ok())?
}

/// The unit at the end of a column's name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Unit {
    Nanoseconds,
    Microseconds,
    Milliseconds,
    Seconds,
    Millimeters,
    Centimeters,
    Meters,
    Degrees,
    Millidegrees,
    Radians,
}

/// The unit that `word` is the name of.
fn unit(word: &str) -> Option<Unit> {
    Some(match word {
        "ns" | "nsec" | "nanoseconds" => Unit::Nanoseconds,
        "us" | "µs" | "μs" | "\u{FFFD}s" | "usec" | "microseconds" => Unit::Microseconds,
        "ms" | "msec" | "millis" | "milliseconds" => Unit::Milliseconds,
        "s" | "sec" | "secs" | "seconds" => Unit::Seconds,
        "mm" | "millimeters" | "millimetres" => Unit::Millimeters,
        "cm" | "centimeters" | "centimetres" => Unit::Centimeters,
        "m" | "meters" | "metres" => Unit::Meters,
        // The last is the sign's byte in Latin-1, which is no UTF-8.
        "deg" | "degrees" | "°" | "\u{FFFD}" => Unit::Degrees,
        "mdeg" | "millidegrees" => Unit::Millidegrees,
        "rad" | "radians" => Unit::Radians,
        _ => return None,
    })
}

/// A column's name: lower case, its unit and number apart.
///
/// `Range_3 [mm]` is the stem `range`, the number 3 and millimetres; `x_m` the stem `x` and metres.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Column {
    /// The name as written.
    pub(crate) written: String,
    /// The name without number and unit, lower case, words joined by `_`.
    pub(crate) stem: String,
    /// The number at the stem's end.
    pub(crate) number: Option<u32>,
    /// The unit behind the last `_` or in brackets.
    pub(crate) unit: Option<Unit>,
}

impl Column {
    /// Reads a name.
    pub(crate) fn of(written: &str) -> Self {
        // The degree sign, and the signs that are taken for it, are a word of their own.
        let lower = written.to_lowercase().replace(['°', 'º', '˚'], " ° ");
        let of_word =
            |c: char| c.is_alphanumeric() || matches!(c, '°' | char::REPLACEMENT_CHARACTER);
        let mut words: Vec<&str> = lower
            .split(|c: char| !of_word(c))
            .filter(|word| !word.is_empty())
            .collect();
        // At any other place it is part of a name, such as that of a temperature in °C.
        if let Some(last) = words.pop() {
            words.retain(|&word| word != "°");
            words.push(last);
        }
        let (words, unit) = match words.split_last() {
            Some((last, before)) if !before.is_empty() && unit(last).is_some() => {
                (before, unit(last))
            }
            _ => (&words[..], None),
        };
        let name = words.join("_");
        let stem = name.trim_end_matches(|c: char| c.is_ascii_digit());
        let number = name
            .get(stem.len()..)
            .and_then(|digits| digits.parse().ok());
        Self {
            written: written.to_owned(),
            stem: stem.trim_end_matches('_').to_owned(),
            number,
            unit,
        }
    }

    /// Reads a header line, if its first character that is not blank may begin one: `#` before it is
    /// left out.
    pub(crate) fn all(line: &str) -> (Separator, Vec<Self>) {
        let line = line.trim();
        let line = line.strip_prefix(['#', '%']).unwrap_or(line).trim();
        let separator = Separator::of(line);
        let mut fields = Fields::new(separator);
        fields.split(line);
        (separator, fields.iter().map(Self::of).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn split(line: &str) -> Vec<String> {
        let mut fields = Fields::new(Separator::of(line));
        fields.split(line);
        fields.iter().map(str::to_owned).collect()
    }

    #[test]
    fn each_separator_splits_its_line() {
        for line in [
            "a,b,c",
            "a;b;c",
            "a\tb\tc",
            "a  b c",
            " a , \"b\" ,c ",
            "\"a\",b,c",
            "a;\"b\";c",
        ] {
            assert_eq!(split(line), ["a", "b", "c"], "{line:?}");
        }
        assert_eq!(split("a,,"), ["a", "", ""]);
        assert_eq!(split("\"a,b\",c"), ["a,b", "c"]);
        assert_eq!(split("a"), ["a"]);
    }

    #[test]
    fn lines_follow_each_other() {
        let mut fields = Fields::new(Separator::Comma);
        for (line, count) in [("a,b,c", 3), ("\"a,b", 1), ("d", 1), ("", 0), ("e,f", 2)] {
            fields.split(line);
            assert_eq!(fields.len(), count, "{line}");
        }
        assert_eq!(
            (fields.get(0), fields.get(1), fields.get(2)),
            (Some("e"), Some("f"), None)
        );
    }

    #[test]
    fn a_decimal_comma_needs_another_separator() {
        assert_eq!(number("229,5", Separator::Semicolon), Some(229.5));
        assert_eq!(number("-1,5", Separator::Tab), Some(-1.5));
        assert_eq!(number("229,5", Separator::Comma), None);
        assert_eq!(number("1,229,5", Separator::Semicolon), None);
        assert_eq!(number("1,229.5", Separator::Semicolon), None);
        assert_eq!(number("1e3", Separator::Comma), Some(1000.0));
        assert_eq!(number("", Separator::Comma), None);
    }

    #[test]
    fn a_name_has_a_stem_a_number_and_a_unit() {
        let of = |name: &str| {
            let column = Column::of(name);
            (column.stem, column.number, column.unit)
        };
        assert_eq!(of("T_MS"), ("t".into(), None, Some(Unit::Milliseconds)));
        assert_eq!(of("ultrasound0"), ("ultrasound".into(), Some(0), None));
        assert_eq!(
            of("Range 3 [mm]"),
            ("range".into(), Some(3), Some(Unit::Millimeters))
        );
        assert_eq!(
            of("range3_m"),
            ("range".into(), Some(3), Some(Unit::Meters))
        );
        assert_eq!(
            of("us0_us"),
            ("us".into(), Some(0), Some(Unit::Microseconds))
        );
        assert_eq!(of("pos_x"), ("pos_x".into(), None, None));
        for degrees in [
            "heading (°)",
            "heading_°",
            "heading°",
            "heading [º]",
            "heading ˚",
            "heading (\u{FFFD})",
        ] {
            let expected = ("heading".into(), None, Some(Unit::Degrees));
            assert_eq!(of(degrees), expected, "{degrees}");
        }
        assert_eq!(of("temp_°C"), ("temp_c".into(), None, None));
        assert_eq!(of("°"), ("°".into(), None, None));
        assert_eq!(of("m"), ("m".into(), None, None));
        assert_eq!(of(""), (String::new(), None, None));
    }

    proptest! {
        #[test]
        fn any_line_splits(lines in prop::collection::vec(".{0,80}", 0..5)) {
            for separator in [Separator::Comma, Separator::Semicolon, Separator::Tab, Separator::Blanks] {
                let mut fields = Fields::new(separator);
                for line in &lines {
                    fields.split(line);
                    prop_assert!(fields.iter().count() == fields.len());
                    let _ = Column::all(line);
                }
            }
        }
    }
}
