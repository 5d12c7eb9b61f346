//! Output files, which appear whole or not at all, and file names in messages.

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// A directory for results.
///
/// Possession proves that it exists and was writable when it was created. Every file is written under
/// a temporary name in the same directory and renamed when it is complete: a reader sees the old file
/// or the new one, and a failure leaves the old one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OutDir {
    path: PathBuf,
}

/// Why a result cannot be written; each reads as one line that says what to do.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The directory cannot be created.
    #[error(
        "{}: cannot be created as a directory ({source}); name another with --out",
        display_path(.path)
    )]
    Create {
        /// The directory.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// The directory cannot be written to.
    #[error(
        "{}: cannot be written to ({source}); change its permissions or name another with --out",
        display_path(.path)
    )]
    NotWritable {
        /// The directory.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// The file's name is not a plain name.
    #[error("{}: is not a plain file name; leave out directories", display_path(.name))]
    Name {
        /// The name.
        name: PathBuf,
    },
    /// Writing failed; no partial file is left.
    #[error("{}: cannot be written ({source}); free space or name another --out", display_path(.path))]
    Write {
        /// The file.
        path: PathBuf,
        /// The error of the system, or of the writer of the content.
        source: io::Error,
    },
}

impl OutDir {
    /// Creates the directory at `path`, with its parents, unless it exists.
    ///
    /// # Errors
    /// If it cannot be created or cannot be written to.
    pub fn create(path: impl Into<PathBuf>) -> Result<Self, ExportError> {
        let path = path.into();
        if let Err(source) = fs::create_dir_all(&path) {
            return Err(ExportError::Create { path, source });
        }
        match NamedTempFile::new_in(&path) {
            Ok(_probe) => Ok(Self { path }),
            Err(source) => Err(ExportError::NotWritable { path, source }),
        }
    }

    /// Returns the directory's path.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes the file `name` with the bytes that `content` writes, and returns its path.
    ///
    /// # Errors
    /// If `name` is not a plain file name, `content` fails, or the file cannot be put in place.
    ///
    /// # Examples
    /// ```
    /// use certainty_sim::export::OutDir;
    ///
    /// let folder = tempfile::tempdir().unwrap();
    /// let out = OutDir::create(folder.path().join("out"))?;
    /// let path = out.write("scores.txt", |file| writeln!(file, "robust 0.93"))?;
    /// assert_eq!(std::fs::read_to_string(path).unwrap(), "robust 0.93\n");
    /// # Ok::<(), certainty_sim::export::ExportError>(())
    /// ```
    pub fn write(
        &self,
        name: &str,
        content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<PathBuf, ExportError> {
        if Path::new(name).file_name() != Some(name.as_ref()) {
            return Err(ExportError::Name { name: name.into() });
        }
        let path = self.path.join(name);
        match self.write_whole(&path, content) {
            Ok(()) => Ok(path),
            Err(source) => Err(ExportError::Write { path, source }),
        }
    }

    /// Writes the file `name` with `bytes`, and returns its path.
    ///
    /// # Errors
    /// As [`Self::write`].
    pub fn write_bytes(&self, name: &str, bytes: &[u8]) -> Result<PathBuf, ExportError> {
        self.write(name, |file| file.write_all(bytes))
    }

    fn write_whole(
        &self,
        path: &Path,
        content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> io::Result<()> {
        let mut temporary = tempfile::Builder::new();
        temporary.prefix(".certainty-").suffix(".tmp");
        // A temporary file is private by default; a result has the permissions of any new file.
        #[cfg(unix)]
        temporary.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let mut file = BufWriter::new(temporary.tempfile_in(&self.path)?);
        content(&mut file)?;
        let file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
        file.as_file().sync_all()?;
        file.persist(path).map_err(|error| error.error)?;
        Ok(())
    }
}

/// Returns `path` as text of one line; control characters are escaped.
#[must_use]
pub fn display_path(path: &Path) -> String {
    one_line(path.display().to_string())
}

/// `text` as one line: escaped if it has control characters.
pub(super) fn one_line(text: String) -> String {
    if text.contains(char::is_control) {
        text.escape_debug().to_string()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(path: &Path) -> Vec<String> {
        let entries = fs::read_dir(path).unwrap();
        let name = |entry: io::Result<fs::DirEntry>| entry.unwrap().file_name();
        let mut names: Vec<String> = entries
            .map(name)
            .map(|n| n.into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn failed_write_leaves_only_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let out = OutDir::create(folder.path()).unwrap();
        assert!(names(out.path()).is_empty());
        let path = out.write_bytes("map.pgm", b"old").unwrap();
        let error = out
            .write("map.pgm", |file| {
                file.write_all(b"half of the new")?;
                Err(io::Error::other("writer failed"))
            })
            .unwrap_err();
        let expected = format!(
            "{}: cannot be written (writer failed); free space or name another --out",
            path.display()
        );
        assert_eq!(error.to_string(), expected);
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(out.path()), ["map.pgm"]);
        out.write_bytes("map.pgm", b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
    }

    #[cfg(unix)]
    #[test]
    fn result_has_permissions_of_any_new_file() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let out = OutDir::create(folder.path()).unwrap();
        let ours = out.write_bytes("ours", b"").unwrap();
        let plain = folder.path().join("plain");
        fs::write(&plain, b"").unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&plain));
    }

    #[test]
    fn file_in_place_of_directory_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("taken");
        fs::write(&file, b"").unwrap();
        let error = OutDir::create(&file).unwrap_err();
        assert!(matches!(error, ExportError::Create { .. }));
        assert!(error.to_string().starts_with(&file.display().to_string()));
        let below = OutDir::create(file.join("below")).unwrap_err();
        assert!(matches!(below, ExportError::Create { .. }));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn unwritable_directory_is_refused_at_once() {
        // Not even its owner can make files there.
        let error = OutDir::create("/proc/self").unwrap_err();
        assert!(matches!(error, ExportError::NotWritable { .. }), "{error}");
        assert!(
            error
                .to_string()
                .starts_with("/proc/self: cannot be written to (")
        );
    }

    #[test]
    fn name_cannot_leave_the_directory() {
        let folder = tempfile::tempdir().unwrap();
        let out = OutDir::create(folder.path().join("out")).unwrap();
        for name in ["", ".", "..", "../x", "a/b", "/tmp/x", "a/"] {
            let error = out.write_bytes(name, b"").unwrap_err();
            assert!(matches!(error, ExportError::Name { .. }), "{name:?}");
        }
        assert_eq!(names(folder.path()), ["out"]);
    }

    #[test]
    fn path_with_line_break_stays_on_one_line() {
        assert_eq!(display_path(Path::new("a\nb\u{1b}[1m")), "a\\nb\\u{1b}[1m");
        assert_eq!(display_path(Path::new("logs/früh.csv")), "logs/früh.csv");
    }
}
