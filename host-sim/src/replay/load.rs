//! Opening a file and reading it to its end.

use super::carmen::{CarmenLog, Taken};
use super::error::LoadError;
use super::format::Format;
use super::gunzip::{Gunzip, MAGIC};
use super::lines::Lines;
use super::readings;
use super::skipped::{SkipReason, Skipped};
use super::{RecordedBeam, Recording};
use certainty_core::units::{Millimeters, Ticks};
use core::cell::Cell;
use core::num::NonZeroU8;
use std::fs::File;
use std::io::{self, BufReader, Cursor, Read};
use std::path::Path;

/// How much of the start tells the format, in bytes.
const START: u64 = 64 * 1024;

/// How to read a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LoadOptions {
    /// The format, where its content shall not tell it.
    pub format: Option<Format>,
    /// An echo this far away or farther is no object: lasers report their *no echo* as a distance.
    pub max_range: Option<Millimeters>,
    /// To how many virtual sensors the beams of a laser are dealt: beam i to i mod `sensors`.
    pub sensors: NonZeroU8,
    /// How many beams are taken into memory; a file with more is refused.
    pub max_beams: usize,
}

impl Default for LoadOptions {
    /// The content tells the format, every distance is an echo, a laser is one sensor, and a file
    /// may have 20 million beams (half a gigabyte).
    fn default() -> Self {
        Self {
            format: None,
            max_range: None,
            sensors: NonZeroU8::MIN,
            max_beams: 20_000_000,
        }
    }
}

/// Loads the recording at `path`, plain or packed with gzip.
///
/// `progress` is told how many bytes of the file were read, and of how many; 0 of a pipe, whose
/// length nobody knows.
///
/// A packed file that was cut short gives the beams before the cut, and counts as
/// [`SkipReason::Truncated`]. Damage within it is an error: nothing says how far back it reaches.
///
/// # Errors
/// If the file cannot be read, is of no known format, or has no usable beam: see [`LoadError`].
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
    let open = |source| LoadError::Open {
        path: path.into(),
        source,
    };
    let file = File::open(path).map_err(open)?;
    let metadata = file.metadata().map_err(open)?;
    if metadata.is_dir() {
        return Err(LoadError::Directory { path: path.into() });
    }
    let done = Cell::new(0);
    let counted = Counted {
        inner: file,
        count: &done,
    };
    let mut report = || progress(done.get(), metadata.len());
    let recording = read(path, counted, options, &mut report)?;
    report();
    Ok(recording)
}

/// Counts the bytes that were read.
struct Counted<'a, R> {
    inner: R,
    count: &'a Cell<u64>,
}

impl<R: Read> Read for Counted<'_, R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(out)?;
        self.count.set(self.count.get() + count as u64);
        Ok(count)
    }
}

/// Reads a recording from anything that gives bytes; `path` is for messages.
pub(super) fn read(
    path: &Path,
    mut source: impl Read,
    options: &LoadOptions,
    report: &mut dyn FnMut(),
) -> Result<Recording, LoadError> {
    let mut magic = Vec::new();
    source
        .by_ref()
        .take(MAGIC.len() as u64)
        .read_to_end(&mut magic)
        .map_err(|error| failed(path, 1, error))?;
    let packed = magic == MAGIC;
    let whole = BufReader::with_capacity(1 << 16, Cursor::new(magic).chain(source));
    if packed {
        let (mut recording, line, gunzip) = read_text(path, Gunzip::new(whole), options, report)?;
        if gunzip.trailing() {
            recording.skipped.add(line, SkipReason::TrailingBytes);
        }
        Ok(recording)
    } else {
        read_text(path, whole, options, report).map(|(recording, ..)| recording)
    }
}

/// Reads unpacked text; gives the number of the last line and the reader back.
fn read_text<R: Read>(
    path: &Path,
    source: R,
    options: &LoadOptions,
    report: &mut dyn FnMut(),
) -> Result<(Recording, u64, R), LoadError> {
    let source = Started::new(source);
    let format = match options.format {
        _ if source.start().is_empty() => match source.pending {
            Some(error) => return Err(failed(path, 1, error)),
            None => return Err(LoadError::Empty { path: path.into() }),
        },
        Some(format) => format,
        None => Format::detect(source.start()).ok_or_else(|| unknown(path, source.start()))?,
    };
    let mut recording = Recording {
        beams: Vec::new(),
        sensors: 0,
        format,
        beam_width: None,
        skipped: Skipped::default(),
        other_messages: 0,
        backward_steps: 0,
    };
    let mut parser = match format {
        Format::Carmen => Parser::Carmen(CarmenLog::new(*options)),
        Format::Readings => Parser::Readings {
            max_range: options.max_range,
            last: None,
        },
    };
    let mut lines = Lines::new(BufReader::with_capacity(1 << 16, source));
    loop {
        let taken = match lines.next() {
            Ok(None) => break,
            Ok(Some(line)) => line.and_then(|line| {
                if format == Format::Readings
                    && let Some(width) = readings::beam_width(line)
                {
                    recording.beam_width = Some(width?);
                }
                parser.line(line, &mut recording.beams)
            }),
            Err(error) if is_cut(&error) && !recording.beams.is_empty() => {
                recording.skipped.add(lines.number(), SkipReason::Truncated);
                break;
            }
            Err(error) => return Err(failed(path, lines.number(), error)),
        };
        match taken {
            Ok(Taken::Beams { backward }) => {
                recording.backward_steps += u64::from(backward);
                lines.was_of_use();
            }
            Ok(Taken::Other) => recording.other_messages += 1,
            Ok(Taken::Nothing) => {}
            Err(reason) => recording.skipped.add(lines.number(), reason),
        }
        if recording.beams.len() > options.max_beams {
            return Err(LoadError::TooManyBeams {
                path: path.into(),
                line: lines.number(),
                limit: options.max_beams,
            });
        }
        if lines.number().is_multiple_of(1024) {
            report();
        }
    }
    let highest = recording
        .beams
        .iter()
        .map(|beam| beam.sensor.number())
        .max();
    recording.sensors = match (highest, format) {
        (None, _) => {
            return Err(LoadError::NoBeams {
                path: path.into(),
                skipped: recording.skipped.total(),
                first: recording.skipped.first().first().copied(),
            });
        }
        (Some(_), Format::Carmen) => options.sensors.get(),
        (Some(highest), Format::Readings) => highest,
    };
    let number = lines.number();
    Ok((recording, number, lines.into_inner().into_inner().rest))
}

/// A parser of each format.
enum Parser {
    Carmen(CarmenLog),
    Readings {
        max_range: Option<Millimeters>,
        last: Option<Ticks>,
    },
}

impl Parser {
    /// Appends the beams of `line`, if it has any.
    fn line(&mut self, line: &str, beams: &mut Vec<RecordedBeam>) -> Result<Taken, SkipReason> {
        match self {
            Self::Carmen(log) => log.line(line, beams),
            Self::Readings { max_range, last } => {
                let Some(beam) = readings::parse(line, *max_range)? else {
                    return Ok(Taken::Nothing);
                };
                beams.push(beam);
                let before = last.replace(beam.at);
                let backward = before.is_some_and(|before| before.since(beam.at) > 0);
                Ok(Taken::Beams { backward })
            }
        }
    }
}

/// A reader whose start was read to look at; a failure met there comes again in its place.
struct Started<R> {
    start: Cursor<Vec<u8>>,
    pending: Option<io::Error>,
    rest: R,
}

impl<R: Read> Started<R> {
    fn new(mut rest: R) -> Self {
        let mut start = Vec::new();
        // What was read before a failure is kept.
        let pending = rest.by_ref().take(START).read_to_end(&mut start).err();
        Self {
            start: Cursor::new(start),
            pending,
            rest,
        }
    }

    fn start(&self) -> &[u8] {
        self.start.get_ref()
    }
}

impl<R: Read> Read for Started<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let count = self.start.read(out)?;
        if count > 0 || out.is_empty() {
            return Ok(count);
        }
        match self.pending.take() {
            Some(error) => Err(error),
            None => self.rest.read(out),
        }
    }
}

/// Whether packed data ended before their end.
fn is_cut(error: &io::Error) -> bool {
    error.kind() == io::ErrorKind::UnexpectedEof
}

/// The error for a reader that failed in `line`: the decoder's own kinds are damage to the file.
fn failed(path: &Path, line: u64, source: io::Error) -> LoadError {
    let path = path.into();
    match source.kind() {
        io::ErrorKind::UnexpectedEof | io::ErrorKind::InvalidData | io::ErrorKind::InvalidInput => {
            LoadError::Gzip { path, line, source }
        }
        _ => LoadError::Read { path, line, source },
    }
}

/// The error for a file whose `start` shows no format.
fn unknown(path: &Path, start: &[u8]) -> LoadError {
    let path = path.into();
    // The start may end within a character.
    let cut = start.len() as u64 == START;
    let text = match str::from_utf8(start) {
        Ok(_) => true,
        Err(error) => cut && error.error_len().is_none(),
    };
    if text && !start.contains(&0) {
        LoadError::UnknownFormat { path }
    } else {
        LoadError::NotText { path }
    }
}
