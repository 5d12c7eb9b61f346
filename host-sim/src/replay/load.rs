//! Loads a file of any format.

use super::carmen::{self, CarmenLog, ScanOptions};
use super::layout::{self, CsvOptions};
use super::line_index::LineIndex;
use super::readings::{self, CsvError, CsvLog, HEADER};
use super::recording::{AngleUnit, LengthUnit, RangeUnit, TimeUnit};
use super::recording::{Format, RecordedBeam, Recording, ZeroMeans};
use super::recording::{LineKind, SkipReason, Skipped, SkippedLine, TooManySkipped};
use crate::export::display_path;
use crate::input::{InputError, Text};
use crate::quantity::FieldOfView;
use certainty_core::transducer::Reading;
use certainty_core::units::{BinaryAngle, Millimeters};
use core::cell::Cell;
use core::num::NonZeroU8;
use std::io::Read;
use std::path::{Path, PathBuf};

/// How to read a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LoadOptions {
    /// The format; detected from the content if `None`.
    pub format: Option<Format>,
    /// Echoes at this distance or farther are no object: lasers report *no echo* as a distance.
    pub max_range: Option<Millimeters>,
    /// The number of virtual sensors of a laser: beam i belongs to sensor i mod `sensors`.
    pub sensors: NonZeroU8,
    /// The meaning of a reading of 0.
    pub zero: ZeroMeans,
    /// The field of view of a scan, whatever the file has (CARMEN), or of the ranges of a line (wide CSV):
    /// around straight ahead.
    pub fov: Option<FieldOfView>,
    /// The direction of the first beam of a scan or a line, counter-clockwise from straight ahead,
    /// whatever the file has.
    pub start_angle: Option<BinaryAngle>,
    /// The unit of readings in columns whose names have none (CSV).
    pub unit: Option<RangeUnit>,
    /// The unit of positions in columns whose names have none (CSV).
    pub pose_unit: Option<LengthUnit>,
    /// The unit of directions in a column whose name has none (CSV).
    pub heading_unit: Option<AngleUnit>,
    /// The unit of times in a column whose name has none (CSV).
    pub time_unit: Option<TimeUnit>,
    /// Beams behind a longer step of the pose are left out.
    pub max_step: Option<Millimeters>,
    /// Whether a file is read of which more than a twentieth of the lines are unreadable.
    pub lenient: bool,
    /// The most beams in memory, 24 bytes each; a file with more is refused.
    pub max_beams: usize,
}

impl Default for LoadOptions {
    /// The format is detected, every distance is an echo, a laser is one sensor, and a file may have
    /// 20 million beams (half a gigabyte).
    fn default() -> Self {
        Self {
            format: None,
            max_range: None,
            sensors: NonZeroU8::MIN,
            zero: ZeroMeans::NoObject,
            fov: None,
            start_angle: None,
            unit: None,
            pose_unit: None,
            heading_unit: None,
            time_unit: None,
            max_step: None,
            lenient: false,
            max_beams: 20_000_000,
        }
    }
}

impl Format {
    /// Detects the format from the first bytes of the (unpacked) file.
    ///
    /// The first line that is a CARMEN message or the header of a CSV decides; other lines before it
    /// are ignored. A start of comments alone (`#`) is a CARMEN log.
    ///
    /// ```
    /// use certainty_sim::replay::Format;
    ///
    /// let start = b"# note\nt_ms,sensor,x_mm,y_mm,bearing_mdeg,reading\n0,1,0,0,0,none\n";
    /// assert_eq!(Format::detect(start), Some(Format::Readings));
    /// assert_eq!(Format::detect(b"ODOM 0 0 0 0 0 0 0.1 host 0.1\n"), Some(Format::Carmen));
    /// assert_eq!(Format::detect(b"Dear all,\n"), None);
    /// ```
    #[must_use]
    pub fn detect(start: &[u8]) -> Option<Self> {
        let start = start.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(start);
        let mut comments = false;
        let mut others = false;
        for line in start.split(|&byte| byte == b'\n') {
            let line = line.trim_ascii();
            let word = line.split(u8::is_ascii_whitespace).next().unwrap_or(line);
            // A name in another encoding, in a column that is not used, leaves the others readable.
            let header = layout::header_of(&String::from_utf8_lossy(line));
            if header.is_some() {
                return header;
            }
            match line.first() {
                None => {}
                Some(b'#') => comments = true,
                Some(_) if str::from_utf8(word).is_ok_and(carmen::is_message) => {
                    return Some(Self::Carmen);
                }
                Some(_) => others = true,
            }
        }
        (comments && !others).then_some(Self::Carmen)
    }
}

/// Why a recording cannot be loaded; displays as one line that says what to do.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The file cannot be read as text.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The file is binary.
    #[error("{}: is not text; give a CARMEN log or a readings file (.csv)", display_path(.path))]
    NotText {
        /// The file.
        path: PathBuf,
    },
    /// The file is text of an unknown format.
    #[error(
        "{}: no line of its start is a CARMEN message or the header of a CSV: add the header, \
         \"{HEADER}\" or \"t_s,x_m,y_m,heading_rad,range0_m,range1_m…\"",
        display_path(.path)
    )]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// A line is almost the header of a CSV.
    #[error(
        "{}:{line}: looks like a header, but has no column of {lacks}; the header \"{HEADER}\" has all",
        display_path(.path)
    )]
    Columns {
        /// The file.
        path: PathBuf,
        /// The line.
        line: u64,
        /// What it lacks.
        lacks: String,
    },
    /// The file's content needs an option, or cannot be read.
    #[error("{}:{line}: {problem}", display_path(.path))]
    Table {
        /// The file.
        path: PathBuf,
        /// The line.
        line: u64,
        /// What is wrong, and what to do.
        problem: String,
    },
    /// Too many lines are unreadable.
    #[error("{}:{}: {too_many}", display_path(.path), .too_many.first.line)]
    TooManySkipped {
        /// The file.
        path: PathBuf,
        /// How many.
        too_many: TooManySkipped,
    },
    /// No line has a usable beam.
    #[error("{}{}", display_path(.path), no_beams(*.skipped, .first.as_ref()))]
    NoBeams {
        /// The file.
        path: PathBuf,
        /// How many lines were skipped.
        skipped: u64,
        /// The first of them.
        first: Option<SkippedLine>,
    },
    /// The file has more beams than are allowed.
    #[error(
        "{}:{line}: more than {limit} beams: give --max-beams a larger number, 24 bytes of memory a beam, or \
         split the recording",
        display_path(.path)
    )]
    TooManyBeams {
        /// The file.
        path: PathBuf,
        /// The line that exceeds the limit.
        line: u64,
        /// The limit.
        limit: usize,
    },
}

/// The message behind the file's name if it has no beams.
fn no_beams(skipped: u64, first: Option<&SkippedLine>) -> String {
    match first {
        Some(first) => format!(
            ":{}: no usable beam: {} ({skipped} lines skipped in all): expected a CARMEN log, or a CSV with the \
             header {HEADER}",
            first.line, first.reason
        ),
        None => ": no beam in it (no line skipped); record range readings with poses".to_owned(),
    }
}

/// Loads the recording at `path`, or from stdin if it is `-`; plain, or packed by gzip, xz, bzip2 or zip.
///
/// `progress` receives how many bytes of the file were read, and its length; 0 for a pipe, whose length
/// is unknown.
///
/// A packed file that is cut short has the beams before the cut, and the cut is counted as
/// [`SkipReason::Truncated`]. Damage within it is an error, because lines before it can be wrong too.
///
/// # Errors
/// If the file cannot be read, has an unknown format, too many unreadable lines, or no usable beam: see
/// [`LoadError`].
///
/// # Examples
/// ```
/// use certainty_sim::replay::{Format, LoadOptions, load};
///
/// let path = concat!(env!("CARGO_MANIFEST_DIR"), "/data/eight-sonar.csv");
/// let recording = load(path.as_ref(), &LoadOptions::default(), &mut |_done, _total| {})?;
/// assert_eq!(recording.format, Format::Readings);
/// assert_eq!((recording.sensors, recording.beams.len()), (8, 413 * 8));
/// # Ok::<(), certainty_sim::replay::LoadError>(())
/// ```
pub fn load(
    path: &Path,
    options: &LoadOptions,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<Recording, LoadError> {
    let done = Cell::new(0);
    let (text, length) = Text::open(path, "a recording", &done)?;
    let mut report = || progress(done.get(), length);
    let recording = read_text(text, options, &mut report)?;
    report();
    Ok(recording)
}

/// Reads a recording from a source of bytes as [`load`] does from a file; `path` is for messages.
///
/// # Errors
/// As for [`load`].
pub fn read(path: &Path, source: impl Read, options: &LoadOptions) -> Result<Recording, LoadError> {
    read_text(Text::new(path, "a recording", source)?, options, &mut || ())
}

/// Reads a recording from text.
fn read_text(
    mut text: Text<'_>,
    options: &LoadOptions,
    report: &mut dyn FnMut(),
) -> Result<Recording, LoadError> {
    let detected = Format::detect(text.start());
    let format = match options.format.or(detected) {
        Some(format) => format,
        None => return Err(unknown(&text)),
    };
    let path = text.path().to_owned();
    let mut recording = Recording {
        beams: Vec::new(),
        sensors: 0,
        format,
        beam_width: None,
        skipped: Skipped::default(),
        other_messages: 0,
        backward_steps: 0,
        notes: Vec::new(),
        names: Vec::new(),
        lines: LineIndex::default(),
    };
    let mut parser = match format {
        Format::Carmen => Parser::Carmen(Box::new(CarmenLog::new(ScanOptions {
            sensors: options.sensors,
            max_range: options.max_range,
            zero: options.zero,
            fov: options.fov,
            start_angle: options.start_angle,
        }))),
        Format::Readings | Format::Wide => {
            let has_header = detected.is_some_and(|format| format != Format::Carmen);
            if format == Format::Wide && !has_header {
                return Err(unknown(&text));
            }
            Parser::Csv(Box::new(CsvLog::new(csv_options(options), has_header)))
        }
    };
    let mut read = 0;
    loop {
        let mut before = recording.beams.len();
        let replaced = parser.replaced();
        let taken = match text.next() {
            Ok(None) => break,
            Ok(Some(line)) => line
                .map_err(|bad| CsvError::Skip(bad.into()))
                .and_then(|line| {
                    if format != Format::Carmen
                        && let Some(width) = readings::beam_width(line)
                    {
                        recording.beam_width = Some(width?);
                    }
                    parser.line(line, &mut recording.beams)
                }),
            Err(error) if error.is_cut() && !recording.beams.is_empty() => {
                recording.skipped.add(text.number(), SkipReason::Truncated);
                break;
            }
            Err(error) => return Err(error.into()),
        };
        match taken {
            Ok(LineKind::Beams { backward }) => {
                recording.backward_steps += u64::from(backward);
                read += 1;
                text.mark_used();
            }
            Ok(LineKind::Other) => recording.other_messages += 1,
            Ok(LineKind::Nothing) => {}
            Err(CsvError::Skip(reason)) => recording.skipped.add(text.number(), reason),
            Err(CsvError::File(problem)) => {
                let line = text.number();
                return Err(LoadError::Table {
                    path,
                    line,
                    problem,
                });
            }
        }
        if parser.replaced() > replaced {
            // The beams of this line are from a better source than all before.
            recording.lines = LineIndex::default();
            before = 0;
        }
        recording
            .lines
            .push(text.number(), before, recording.beams.len());
        if recording.beams.len() > options.max_beams {
            return Err(LoadError::TooManyBeams {
                path,
                line: text.number(),
                limit: options.max_beams,
            });
        }
        if text.number().is_multiple_of(1024) {
            report();
        }
    }
    if text.trailing() {
        recording
            .skipped
            .add(text.number(), SkipReason::TrailingBytes);
    }
    if recording.beams.is_empty() {
        return Err(LoadError::NoBeams {
            path,
            skipped: recording.skipped.total(),
            first: recording.skipped.first().first().copied(),
        });
    }
    match parser {
        Parser::Carmen(log) => {
            let summary = log.finish();
            recording.sensors = summary.sensors;
            recording.names = (1..=u16::from(summary.sensors)).collect();
            recording.backward_steps = summary.backward;
            recording.other_messages += summary.replaced;
            recording.notes = summary.notes;
            if !summary.at_odometry {
                // They are of a source that is not used.
                recording.other_messages += recording.skipped.forget(SkipReason::NoPose);
            }
        }
        Parser::Csv(log) => {
            let summary = log.finish(&mut recording.beams);
            // At most 255 of them.
            recording.sensors = u8::try_from(summary.names.len()).unwrap_or(u8::MAX);
            recording.names = summary.names;
            recording.notes = summary.notes;
        }
    }
    if let Some(too_many) = recording.skipped.too_many(read)
        && !options.lenient
    {
        return Err(LoadError::TooManySkipped { path, too_many });
    }
    if let Some(most) = options.max_step {
        recording.leave_out_far_steps(most);
    }
    let is_echo = |beam: &RecordedBeam| matches!(beam.reading, Reading::Echo(_));
    if !recording.beams.iter().any(is_echo) {
        recording.notes.push(match options.max_range {
            Some(limit) => {
                format!("no echo within --max-range {limit}: check --max-range and the units")
            }
            None => "no beam has an echo: check the units".to_owned(),
        });
    }
    if let Some(stray) = recording.stray_pose() {
        recording.notes.push(stray.to_string());
    }
    Ok(recording)
}

/// The options of a CSV.
const fn csv_options(options: &LoadOptions) -> CsvOptions {
    CsvOptions {
        max_range: options.max_range,
        zero: options.zero,
        unit: options.unit,
        pose_unit: options.pose_unit,
        heading_unit: options.heading_unit,
        time_unit: options.time_unit,
        fov: options.fov,
        start_angle: options.start_angle,
    }
}

/// A parser of each format.
enum Parser {
    Carmen(Box<CarmenLog>),
    Csv(Box<CsvLog>),
}

impl Parser {
    /// Returns how many lines had beams that those of a better source have replaced.
    fn replaced(&self) -> u64 {
        match self {
            Self::Carmen(log) => log.replaced(),
            Self::Csv(_) => 0,
        }
    }

    /// Appends the beams of `line`, if it has any.
    fn line(&mut self, line: &str, beams: &mut Vec<RecordedBeam>) -> Result<LineKind, CsvError> {
        match self {
            Self::Carmen(log) => Ok(log.line(line, beams)?),
            Self::Csv(log) => log.line(line, beams),
        }
    }
}

/// The error for a file of an unknown format.
fn unknown(text: &Text<'_>) -> LoadError {
    let path = text.path().to_owned();
    let start = text.start();
    let lines = (1..).zip(start.split(|&byte| byte == b'\n'));
    for (line, bytes) in lines.take(20) {
        let lacks = layout::lacking(&String::from_utf8_lossy(bytes));
        if let Some(lacks) = lacks {
            return LoadError::Columns { path, line, lacks };
        }
    }
    if let Some(foreign) = text.foreign() {
        return foreign.into();
    }
    // Text has no byte 0 and hardly any other control characters.
    let odd = |byte: &&u8| matches!(byte, 1..=8 | 14..=26 | 28..=31 | 127);
    if start.contains(&0) || start.iter().filter(odd).count() * 20 > start.len() {
        LoadError::NotText { path }
    } else {
        LoadError::UnknownFormat { path }
    }
}

#[cfg(test)]
mod tests {
    use super::super::readings::written;
    use super::super::recording::Tally;
    use super::*;
    use crate::input::gzip;
    use certainty_core::sensor::SensorId;
    use certainty_core::transducer::Missing;
    use certainty_core::units::Ticks;
    use certainty_core::units::{BinaryAngle, Point};
    use flate2::{Compression, write::GzEncoder};
    use proptest::prelude::*;
    use std::io;

    fn read_with(bytes: &[u8], options: &LoadOptions) -> Result<Recording, LoadError> {
        read(Path::new("f.log"), bytes, options)
    }

    fn read_bytes(bytes: &[u8]) -> Result<Recording, LoadError> {
        read_with(bytes, &LoadOptions::default())
    }

    /// The error's message.
    fn message(bytes: &[u8]) -> String {
        let message = read_bytes(bytes).unwrap_err().to_string();
        assert_eq!(message.lines().count(), 1, "{message}");
        message
    }

    /// A readings file of `count` beams.
    fn many_readings(count: u32) -> Vec<u8> {
        let beam = |at| RecordedBeam {
            at: Ticks::new(at),
            sensor: SensorId::new(1 + (at % 7) as u8),
            origin: Point::from_mm(at as i32 * 13 % 9001, -(at as i32)),
            bearing: BinaryAngle::from_bits((at * 977 % 65536) as u16),
            reading: Reading::Echo(Millimeters::new(at * 31 % 5000)),
        };
        written(&(0..count).map(beam).collect::<Vec<_>>()).into_bytes()
    }

    #[test]
    fn a_recording_without_an_echo_is_noted() {
        let text = format!("{HEADER}\n0,1,0,0,0,9000\n0,1,0,0,0,none\n");
        let notes = |max_range| {
            let options = LoadOptions {
                max_range,
                ..LoadOptions::default()
            };
            read_with(text.as_bytes(), &options).unwrap().notes
        };
        assert_eq!(
            notes(Some(Millimeters::new(9000))),
            ["no echo within --max-range 9000mm: check --max-range and the units"]
        );
        assert!(notes(None).is_empty());
        let silent = read_bytes(format!("{HEADER}\n0,1,0,0,0,none\n").as_bytes()).unwrap();
        assert_eq!(silent.notes, ["no beam has an echo: check the units"]);
    }

    #[test]
    fn a_latin_1_name_does_not_hide_the_header() {
        let plain = "t_ms,x_m,y_m,heading_deg,temp_xC,range0_m\n0,0,0,45,20,1\n";
        let mut latin = plain.as_bytes().to_vec();
        latin[plain.find("xC").unwrap()] = 0xB0; // °
        let options = LoadOptions {
            start_angle: Some(BinaryAngle::ZERO),
            ..LoadOptions::default()
        };
        let (one, other) = (
            read_with(plain.as_bytes(), &options).unwrap(),
            read_with(&latin, &options).unwrap(),
        );
        assert_eq!((one.beams, one.skipped), (other.beams, other.skipped));
    }

    #[test]
    fn old_macintosh_lines_are_read() {
        let unix = many_readings(20_000);
        let old: Vec<u8> = unix
            .iter()
            .map(|&byte| if byte == b'\n' { b'\r' } else { byte })
            .collect();
        assert_eq!(read_bytes(&old).unwrap(), read_bytes(&unix).unwrap());
        let mut doubled = many_readings(3);
        doubled.extend(b"9,1,0,0,0,5\r\r\n");
        assert_eq!(read_bytes(&doubled).unwrap().beams.len(), 4);
    }

    #[test]
    fn packed_file_reads_as_the_plain_one() {
        let plain = many_readings(20_000);
        let recording = read_bytes(&plain).unwrap();
        assert_eq!(recording.beams.len(), 20_000);
        assert_eq!((recording.sensors, recording.format), (7, Format::Readings));
        assert_eq!(recording.skipped.total(), 0);
        assert_eq!(read_bytes(&gzip(&plain)).unwrap(), recording);
    }

    #[test]
    fn cut_packed_file_keeps_the_beams_before() {
        let plain = many_readings(20_000);
        let whole = read_bytes(&plain).unwrap();
        let packed = gzip(&plain);
        for end in [packed.len() - 1, packed.len() / 2, packed.len() / 4] {
            let cut = read_bytes(&packed[..end]).unwrap();
            assert_eq!(cut.skipped.total(), 1);
            assert_eq!(cut.skipped.count(SkipReason::Truncated), 1);
            assert!(!cut.beams.is_empty() && cut.beams.len() <= whole.beams.len());
            // Half a line is not read as a whole one.
            assert_eq!(cut.beams, whole.beams[..cut.beams.len()]);
        }
        assert!(message(&packed[..12]).starts_with("f.log:1: the gzip data are damaged"));
    }

    #[test]
    fn damaged_packed_data_are_an_error() {
        let packed = gzip(&many_readings(100));
        let mut damaged = packed.clone();
        let checksum = damaged.len() - 8;
        damaged[checksum] ^= 1;
        assert!(message(&damaged).contains("the gzip data are damaged"));
        let padded = read_bytes(&[packed, vec![0; 512]].concat()).unwrap();
        assert_eq!(padded.beams.len(), 100);
        assert_eq!(padded.skipped.count(SkipReason::TrailingBytes), 1);
    }

    #[test]
    fn gzip_bomb_is_read_in_bounded_memory() {
        // 256 MiB without a line end behind one good beam: all of it is one line to be skipped.
        let mut bomb = GzEncoder::new(Vec::new(), Compression::fast());
        io::copy(&mut &many_readings(1)[..], &mut bomb).unwrap();
        io::copy(&mut io::repeat(b'7').take(256 << 20), &mut bomb).unwrap();
        let bomb = bomb.finish().unwrap();
        assert!(bomb.len() < 4 << 20);
        let options = LoadOptions {
            lenient: true,
            ..LoadOptions::default()
        };
        let recording = read_with(&bomb, &options).unwrap();
        assert_eq!(recording.beams.len(), 1);
        assert_eq!(recording.skipped.count(SkipReason::TooLong), 1);
    }

    #[test]
    fn too_many_beams_are_refused_by_line() {
        let options = LoadOptions {
            max_beams: 10,
            ..LoadOptions::default()
        };
        assert_eq!(
            read_with(&many_readings(10), &options).unwrap().beams.len(),
            10
        );
        let error = read_with(&many_readings(11), &options).unwrap_err();
        assert_eq!(
            error.to_string(),
            "f.log:12: more than 10 beams: give --max-beams a larger number, 24 bytes of memory a beam, or \
             split the recording"
        );
    }

    #[test]
    fn every_error_names_the_file_and_what_to_do() {
        assert_eq!(message(b""), "f.log: is empty: expected a recording");
        assert_eq!(message(&gzip(b"")), "f.log: is empty: expected a recording");
        let png = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR";
        assert!(message(png).starts_with("f.log: it is a PNG picture: "));
        assert!(message(&gzip(png)).starts_with("f.log: it is a PNG picture: "));
        assert!(message(b"\x01\0\x02").starts_with("f.log: is not text; give"));
        assert!(message(b"Dear all,\n").starts_with("f.log: no line of its start is"));
        let damaged = format!("{HEADER}\n# note\n0,-1,0,0,0,5\n0,1,0\n");
        assert_eq!(
            message(damaged.as_bytes()),
            "f.log:3: no usable beam: sensor not within 0 to 65535 (2 lines skipped in all): expected a \
             CARMEN log, or a CSV with the header t_ms,sensor,x_mm,y_mm,bearing_mdeg,reading"
        );
        assert_eq!(
            message(b"ODOM 0 0 0 0 0 0 0.1 h 0.1\n"),
            "f.log: no beam in it (no line skipped); record range readings with poses"
        );
        let load = |path: &Path| load(path, &LoadOptions::default(), &mut |_, _| ()).unwrap_err();
        let missing = load(Path::new("no/such\nfile"));
        assert!(matches!(missing, LoadError::Input(InputError::Open { .. })));
        assert_eq!(missing.to_string().lines().count(), 1);
        let directory = load(Path::new(env!("CARGO_MANIFEST_DIR")));
        assert!(matches!(
            directory,
            LoadError::Input(InputError::Directory { .. })
        ));
    }

    #[test]
    fn damaged_lines_are_skipped_alone() {
        let mut file = many_readings(3);
        file.extend_from_slice(b"\xff\xfe\0\n5,1,0,0,0,5,5\r\n\r\n# end\r\n6,1,0,0,0,17\r\n");
        let error = read_bytes(&file).unwrap_err().to_string();
        assert_eq!(
            error,
            "f.log:5: 2 of 6 lines with readings are unreadable, first: not text; correct them, or give \
             --lenient to leave them out"
        );
        let options = LoadOptions {
            lenient: true,
            ..LoadOptions::default()
        };
        let recording = read_with(&file, &options).unwrap();
        assert_eq!(recording.beams.len(), 4);
        let skipped: Vec<String> = recording
            .skipped
            .first()
            .iter()
            .map(ToString::to_string)
            .collect();
        assert_eq!(
            skipped,
            ["line 5: not text", "line 6: wrong number of fields"]
        );
    }

    #[test]
    fn steps_back_in_time_are_counted() {
        let file =
            format!("{HEADER}\n5,1,0,0,0,1\n9,1,0,0,0,2\n3,1,0,0,0,3\n3,1,0,0,0,4\n7,1,0,0,0,5\n");
        let recording = read_bytes(file.as_bytes()).unwrap();
        assert_eq!(recording.backward_steps, 1);
        let order: Vec<u32> = recording.beams.iter().map(|beam| beam.at.get()).collect();
        assert_eq!(order, [5, 9, 3, 3, 7]);
    }

    #[test]
    fn extent_holds_origins_and_echoes() {
        let file =
            format!("{HEADER}\n0,1,10,20,0,1000\n0,1,-5,0,270000,300\n0,1,0,0,180000,none\n");
        let recording = read_bytes(file.as_bytes()).unwrap();
        let (low, high) = recording.extent();
        assert_eq!(
            (low, high),
            (Point::from_mm(-5, -300), Point::from_mm(1010, 20))
        );
    }

    /// Seven poses along x, the fourth far away.
    fn one_wild_pose() -> String {
        let lines = [0, 100, 200, 9_000_000, 400, 500, 600].map(|x| format!("0,1,{x},0,0,50\n"));
        format!("# note\n{HEADER}\n{}", lines.concat())
    }

    #[test]
    fn a_pose_far_from_all_others_is_named() {
        let recording = read_bytes(one_wild_pose().as_bytes()).unwrap();
        let stray = recording.stray_pose().unwrap();
        assert_eq!((stray.line, stray.at), (6, Point::from_mm(9_000_000, 0)));
        let [note] = &recording.notes[..] else {
            panic!("{:?}", recording.notes);
        };
        assert!(
            note.starts_with("line 6 has a pose at 9000000mm,0mm, a step of "),
            "{note}"
        );
        let first = one_wild_pose().replace("0,1,0,0,0,50", "0,1,-9000000,0,0,50");
        let first = first.replace(",9000000,", ",300,");
        assert_eq!(
            read_bytes(first.as_bytes())
                .unwrap()
                .stray_pose()
                .unwrap()
                .line,
            3
        );
    }

    #[test]
    fn beams_behind_a_far_step_are_left_out_and_counted() {
        let options = LoadOptions {
            max_step: Some(Millimeters::new(1000)),
            ..LoadOptions::default()
        };
        let recording = read_with(one_wild_pose().as_bytes(), &options).unwrap();
        assert_eq!(recording.beams.len(), 6);
        assert_eq!(recording.notes, [""; 0]);
        let skipped: Vec<_> = recording.skipped.counts().collect();
        assert_eq!(
            (skipped[0].reason, skipped[0].lines, skipped[0].first_line),
            (SkipReason::FarStep, 1, 6)
        );
        assert_eq!(skipped.len(), 1);
    }

    #[test]
    fn progress_ends_at_the_file_length() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/eight-sonar.csv");
        let mut last = (0, 0);
        load(&path, &LoadOptions::default(), &mut |done, total| {
            assert!(done >= last.0);
            last = (done, total);
        })
        .unwrap();
        let length = std::fs::metadata(&path).unwrap().len();
        assert_eq!(last, (length, length));
    }

    #[test]
    fn eight_sonar_run_is_read_whole() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/eight-sonar.csv");
        let recording = load(&path, &LoadOptions::default(), &mut |_, _| ()).unwrap();
        let expected = Tally {
            echo: 2236,
            no_object: 1068,
            ..Tally::default()
        };
        assert_eq!(recording.tally(), expected);
        assert_eq!((recording.sensors, recording.backward_steps), (8, 0));
        assert_eq!(recording.skipped.total(), 0);
        assert_eq!(recording.beams.last().unwrap().at, Ticks::new(92_837));
    }

    /// The folder of logs that the project may not distribute, if it exists.
    fn borrowed_data() -> Option<PathBuf> {
        let folder = std::env::var_os("CERTAINTY_DATA").map_or_else(
            || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"),
            PathBuf::from,
        );
        folder.is_dir().then_some(folder)
    }

    #[test]
    fn real_carmen_logs_have_no_skipped_line() {
        let Some(folder) = borrowed_data() else {
            eprintln!("skipped: set CERTAINTY_DATA to the folder with carmen/*.log.gz");
            return;
        };
        // Name, scans, beams a scan, the laser's no echo in millimetres and how often it occurs (counted
        // by another program), steps back in time.
        let logs = [
            ("intel", 910, 180, 80_000, 4172, 4),
            ("fhw", 488, 180, 50_000, 647, 0),
            ("acapulco", 861, 181, 50_000, 13_213, 0),
            ("orebro", 237, 181, 32_700, 968, 0),
        ];
        for (name, scans, per_scan, no_echo, no_object, backward) in logs {
            let path = folder.join(format!("carmen/{name}-corrected.log.gz"));
            let options = LoadOptions {
                max_range: Some(Millimeters::new(no_echo)),
                ..LoadOptions::default()
            };
            let recording = load(&path, &options, &mut |_, _| ()).unwrap();
            let expected = Tally {
                echo: (scans * per_scan) as u64 - no_object,
                no_object,
                ..Tally::default()
            };
            assert_eq!(recording.tally(), expected, "{name}");
            assert_eq!(recording.skipped.total(), 0, "{name}");
            assert_eq!(recording.backward_steps, backward, "{name}");
            if name == "acapulco" {
                // Its last beam reads 50 m in every scan, which must not become an obstacle.
                let mut stuck = recording.beams.iter().skip(180).step_by(181);
                assert!(stuck.all(|beam| beam.reading == Reading::NoObject));
            }
        }
    }

    fn any_reading() -> impl Strategy<Value = Reading> {
        prop_oneof![
            (1..=u32::MAX).prop_map(|mm| Reading::Echo(Millimeters::new(mm))),
            Just(Reading::NoObject),
            Just(Reading::TooNear),
            Just(Reading::Missing(Missing::Timeout)),
        ]
    }

    prop_compose! {
        fn any_beam()(
            at: u32,
            sensor in 1_u8..,
            x in -Point::LIMIT..=Point::LIMIT,
            y in -Point::LIMIT..=Point::LIMIT,
            bearing: u16,
            reading in any_reading(),
        ) -> RecordedBeam {
            RecordedBeam {
                at: Ticks::new(at),
                sensor: SensorId::try_new(sensor).unwrap(),
                origin: Point::from_mm(x, y),
                bearing: BinaryAngle::from_bits(bearing),
                reading,
            }
        }
    }

    /// Words that reach the parsers' special cases.
    fn any_word() -> impl Strategy<Value = String> {
        prop_oneof![
            Just("FLASER".to_owned()),
            Just("ROBOTLASER1".to_owned()),
            Just(format!("\n{HEADER}\n")),
            Just("\nt_ms;x;y_mm;heading;range0;range1_m;temp\n".to_owned()),
            Just(";".to_owned()),
            Just("\"".to_owned()),
            Just("\n".to_owned()),
            Just("nan".to_owned()),
            Just("-inf".to_owned()),
            Just(",".to_owned()),
            Just("1e999".to_owned()),
            Just("18446744073709551615".to_owned()),
            (0_u32..12).prop_map(|n| n.to_string()),
            any::<i64>().prop_map(|n| n.to_string()),
            any::<f64>().prop_map(|n| n.to_string()),
        ]
    }

    proptest! {
        #[test]
        fn written_readings_read_back(beams in prop::collection::vec(any_beam(), 1..50)) {
            let mut recording = read_bytes(written(&beams).as_bytes()).unwrap();
            for beam in &mut recording.beams {
                let number = recording.names[beam.sensor.slot()];
                beam.sensor = SensorId::try_new(u8::try_from(number).unwrap()).unwrap();
            }
            prop_assert_eq!(recording.beams, beams);
        }

        #[test]
        fn no_bytes_panic(bytes: Vec<u8>, format in 0_usize..4, packed: bool) {
            let options = LoadOptions {
                format: [None, Some(Format::Carmen), Some(Format::Readings), Some(Format::Wide)][format],
                ..LoadOptions::default()
            };
            let _ = read_with(&bytes, &options);
            let bytes = if packed { gzip(&bytes) } else { [&[0x1F, 0x8B, 8][..], &bytes].concat() };
            let _ = read_with(&bytes, &options);
        }

        #[test]
        fn no_words_panic(words in prop::collection::vec(any_word(), 0..60), format in 0_usize..4) {
            let options = LoadOptions {
                format: [None, Some(Format::Carmen), Some(Format::Readings), Some(Format::Wide)][format],
                unit: Some(RangeUnit::Meters),
                lenient: true,
                sensors: NonZeroU8::MAX,
                ..LoadOptions::default()
            };
            let _ = read_with(words.join(" ").as_bytes(), &options);
            let _ = read_with(words.concat().as_bytes(), &options);
        }

        #[test]
        fn damaged_scan_is_whole_or_skipped(
            place in 0_usize..200,
            byte: u8,
            readings in prop::collection::vec(0.0..9.0_f64, 1..30),
        ) {
            let numbers: Vec<String> = readings.iter().map(ToString::to_string).collect();
            let line = format!("FLASER {} {} 1 2 3 1 2 3 4.5 h 4.5", numbers.len(), numbers.join(" "));
            let mut bytes = line.into_bytes();
            let place = place % bytes.len();
            bytes[place] = byte;
            let options = LoadOptions { format: Some(Format::Carmen), ..LoadOptions::default() };
            if let Ok(recording) = read_with(&bytes, &options) {
                // A changed digit is a changed number; the count is right or the line is gone.
                let text = String::from_utf8_lossy(&bytes);
                let announced: usize = text.split_ascii_whitespace().nth(1).unwrap().parse().unwrap();
                prop_assert_eq!(recording.beams.len(), announced);
            }
        }
    }

    #[test]
    fn first_known_line_decides_the_format() {
        let carmen = Some(Format::Carmen);
        let readings = Some(Format::Readings);
        assert_eq!(
            Format::detect(b"# message formats defined: PARAM\n"),
            carmen
        );
        assert_eq!(Format::detect(b"\n\nFLASER 2 1.0"), carmen);
        assert_eq!(Format::detect(b"RAWLASER3 0 1\n"), carmen);
        assert_eq!(Format::detect(b"\xff\x00\nODOM 1 2\n"), carmen);
        let with_mark = format!("\u{FEFF}{HEADER}\r\n");
        assert_eq!(Format::detect(with_mark.as_bytes()), readings);
        let noted = format!("# FLASER is mentioned here\n\n{HEADER}\n");
        assert_eq!(Format::detect(noted.as_bytes()), readings);
    }

    #[test]
    fn similar_text_is_of_unknown_format() {
        for text in [
            "",
            "\n\n",
            "FLASERS 1 2\n",
            "t_ms,sensor,x_mm\n",
            "t_ms,sensor,x_mm,y_mm,reading\n",
            "# note\n1 2 3\n",
            "\u{89}PNG\r\n",
        ] {
            assert_eq!(Format::detect(text.as_bytes()), None, "{text:?}");
        }
    }
}
