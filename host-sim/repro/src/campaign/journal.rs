//! The campaign's CSV file, appended row by row so that an interrupted campaign can be continued.
//!
//! Rows come in a fixed order, whole scenarios at a time. An unfinished file is continued: its complete
//! scenarios are kept, and the rest behind them (part of a scenario, half a line) is written again. Every
//! row is a function of its key, so the finished file is the same after any number of interruptions.

use super::row::Row;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Largest file that is continued, in bytes: ten times the largest campaign.
const MOST_BYTES: u64 = 256 << 20;

/// An open file with the first scenarios of a campaign.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    finished: usize,
    dropped: usize,
}

/// Why a file cannot be used for the campaign; each displays as one line.
#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    /// It cannot be opened, read or written.
    #[error("{}: {source}: expected a file that can be read and written", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// It is a directory.
    #[error("{}: is a directory: expected a file for --csv", path.display())]
    Directory {
        /// The directory.
        path: PathBuf,
    },
    /// It is a pipe or a device.
    #[error("{}: not a regular file: expected a file for --csv", path.display())]
    NoFile {
        /// The path.
        path: PathBuf,
    },
    /// Another process is writing it.
    #[error("{}: in use by another campaign: expected another file, or wait", path.display())]
    Busy {
        /// The file.
        path: PathBuf,
    },
    /// It is not a file of this campaign.
    #[error("{}:{line}: {problem}: expected a new file or one of this campaign", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The error in the line.
        problem: String,
    },
}

impl Journal {
    /// Opens or creates the file at `path` for the scenarios whose rows begin with `keys`.
    ///
    /// # Errors
    ///
    /// [`JournalError`]; a file that is not the beginning of this campaign is not changed.
    pub(super) fn open(path: &Path, keys: &[Vec<String>]) -> Result<Self, JournalError> {
        let io = |source| JournalError::Io {
            path: path.to_owned(),
            source,
        };
        // A pipe would never end, and a device does not store rows.
        match std::fs::metadata(path) {
            Ok(there) if there.is_dir() => {
                let path = path.to_owned();
                return Err(JournalError::Directory { path });
            }
            Ok(there) if !there.is_file() => {
                let path = path.to_owned();
                return Err(JournalError::NoFile { path });
            }
            _ => {}
        }
        let mut options = OpenOptions::new();
        let mut file = options
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(path)
            .map_err(io)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let path = path.to_owned();
                return Err(JournalError::Busy { path });
            }
            Err(TryLockError::Error(source)) => return Err(io(source)),
        }
        let mut bytes = Vec::new();
        (&file)
            .take(MOST_BYTES + 1)
            .read_to_end(&mut bytes)
            .map_err(io)?;
        let kept = Kept::of(&bytes, keys).map_err(|(line, problem)| JournalError::Foreign {
            path: path.to_owned(),
            line,
            problem,
        })?;
        if kept.bytes == 0 {
            file.set_len(0).map_err(io)?;
            file.seek(SeekFrom::Start(0)).map_err(io)?;
            writeln!(file, "{}", Row::HEADER).map_err(io)?;
        } else {
            file.set_len(kept.bytes as u64).map_err(io)?;
            file.seek(SeekFrom::End(0)).map_err(io)?;
        }
        Ok(Self {
            path: path.to_owned(),
            file,
            finished: kept.scenarios,
            dropped: kept.dropped,
        })
    }

    /// Returns the number of complete scenarios in the file.
    #[must_use]
    pub const fn finished(&self) -> usize {
        self.finished
    }

    /// Returns the number of lines of an unfinished scenario that were dropped.
    #[must_use]
    pub const fn dropped(&self) -> usize {
        self.dropped
    }

    /// Writes a scenario's rows.
    pub(super) fn append(&mut self, rows: &[Row]) -> Result<(), JournalError> {
        let lines: String = rows.iter().map(|row| row.line() + "\n").collect();
        let written = self.file.write_all(lines.as_bytes());
        written.map_err(|source| JournalError::Io {
            path: self.path.clone(),
            source,
        })
    }
}

/// The part of a file that is kept.
#[derive(Debug, PartialEq, Eq)]
struct Kept {
    /// The bytes from its start; 0 if the header is incomplete.
    bytes: usize,
    scenarios: usize,
    dropped: usize,
}

impl Kept {
    /// Compares a file's bytes with the expected rows; an error is a line and its problem.
    fn of(bytes: &[u8], keys: &[Vec<String>]) -> Result<Self, (usize, String)> {
        let mut expected = keys.iter().flatten();
        let mut lines = (1..).zip(bytes.split_inclusive(|&byte| byte == b'\n'));
        let Some((_, header)) = lines.next() else {
            return Ok(Self {
                bytes: 0,
                scenarios: 0,
                dropped: 0,
            });
        };
        let Some(header) = header.strip_suffix(b"\n") else {
            return if Row::HEADER.as_bytes().starts_with(header) {
                Ok(Self {
                    bytes: 0,
                    scenarios: 0,
                    dropped: 1,
                })
            } else {
                Err((1, "not the header of a campaign".to_owned()))
            };
        };
        if header != Row::HEADER.as_bytes() {
            return Err((1, "not the header of a campaign".to_owned()));
        }
        let mut kept = Self {
            bytes: header.len() + 1,
            scenarios: 0,
            dropped: 0,
        };
        let (mut whole, mut length) = (0, 0);
        for (number, line) in lines {
            let Some(key) = expected.next() else {
                return Err((number, "more rows than this campaign has".to_owned()));
            };
            match line.strip_suffix(b"\n") {
                Some(line) => check(line, key).map_err(|problem| (number, problem))?,
                None => check_half(line, key).map_err(|problem| (number, problem))?,
            }
            (whole, length) = (whole + 1, length + line.len());
            let finished =
                line.ends_with(b"\n") && keys.get(kept.scenarios).map(Vec::len) == Some(whole);
            if finished {
                kept.bytes += length;
                kept.scenarios += 1;
                (whole, length) = (0, 0);
            }
        }
        kept.dropped = whole;
        Ok(kept)
    }
}

/// Returns an error unless a whole line can be the row that begins with `key`.
fn check(line: &[u8], key: &str) -> Result<(), String> {
    if !line.starts_with(key.as_bytes()) {
        let key = key.trim_end_matches(',');
        return Err(format!("not the row {key} of this campaign"));
    }
    let fields: Vec<&[u8]> = line.split(|&byte| byte == b',').collect();
    let figures = &fields[key.matches(',').count().min(fields.len())..];
    let number = |field: &&[u8]| {
        field.is_empty()
            || core::str::from_utf8(field).is_ok_and(|text| text.parse::<f64>().is_ok())
    };
    if fields.len() == Row::FIELDS && figures.iter().all(number) {
        Ok(())
    } else {
        Err("the row is damaged".to_owned())
    }
}

/// Returns an error unless half a line can be the beginning of the row that begins with `key`.
fn check_half(line: &[u8], key: &str) -> Result<(), String> {
    let shorter = line.len().min(key.len());
    if line[..shorter] == key.as_bytes()[..shorter] {
        Ok(())
    } else {
        Err("not a row of this campaign".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys() -> Vec<Vec<String>> {
        let scenario = |name: &str| ["bayes", "oracle"].map(|m| format!("{name},{m},")).to_vec();
        vec![scenario("a"), scenario("b")]
    }

    /// A complete file: every row is its key and figures in all other fields.
    fn whole() -> String {
        let mut text = format!("{}\n", Row::HEADER);
        for key in keys().into_iter().flatten() {
            let figures = vec!["0.5"; Row::FIELDS - key.matches(',').count()];
            text += &format!("{key}{}\n", figures.join(","));
        }
        text
    }

    #[test]
    fn the_header_names_every_field() {
        assert_eq!(Row::HEADER.split(',').count(), Row::FIELDS);
    }

    #[test]
    fn a_cut_file_keeps_its_complete_scenarios() {
        let text = whole();
        let ends: Vec<usize> = text.match_indices('\n').map(|(at, _)| at + 1).collect();
        for cut in 0..=text.len() {
            let kept = Kept::of(&text.as_bytes()[..cut], &keys()).unwrap();
            // Header, then two rows a scenario.
            let expected = [(ends[4], 2), (ends[2], 1), (ends[0], 0)];
            let expected = expected.into_iter().find(|&(end, _)| cut >= end);
            let expected = expected.unwrap_or((0, 0));
            assert_eq!((kept.bytes, kept.scenarios), expected, "cut at {cut}");
            assert_eq!(kept.dropped > 0, cut > kept.bytes, "cut at {cut}");
        }
    }

    #[test]
    fn a_foreign_file_is_refused_with_its_line() {
        let line = |text: &str| Kept::of(text.as_bytes(), &keys()).unwrap_err().0;
        assert_eq!(line("my notes"), 1);
        assert_eq!(line("my notes\n"), 1);
        assert_eq!(line(&whole().replace("a,oracle", "a,median")), 3);
        assert_eq!(line(&whole().replacen("0.5", "0.x", 1)), 2);
        assert_eq!(line(&whole().replacen(",0.5", "", 1)), 2);
        assert_eq!(line(&(whole() + "b,oracle")), 6);
        assert_eq!(line(&format!("{}\nnotes", Row::HEADER)), 2);
    }

    #[test]
    fn a_second_writer_is_refused_and_files_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("campaign.csv");
        let first = Journal::open(&path, &keys()).unwrap();
        let second = Journal::open(&path, &keys()).unwrap_err();
        assert!(matches!(second, JournalError::Busy { .. }), "{second}");
        drop(first);
        std::fs::write(&path, "my notes\n").unwrap();
        assert!(Journal::open(&path, &keys()).is_err());
        assert_eq!(std::fs::read(&path).unwrap(), b"my notes\n");
    }
}
