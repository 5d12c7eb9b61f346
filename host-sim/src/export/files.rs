//! Output files, which appear whole or not at all, and file names in messages.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use tempfile::{NamedTempFile, TempPath};

/// A directory for results.
///
/// Possession proves that it exists, was writable when it was created, and is locked: no other run
/// writes there until this value is dropped or the process ends, however it ends. Every file is written
/// under a temporary name in the same directory and renamed when it is complete: a reader sees the old
/// file or the new one, and a failure leaves the old one.
#[derive(Debug)]
pub struct OutDir {
    path: PathBuf,
    /// The directories that were made for it, the outermost first.
    made: Vec<PathBuf>,
    /// `None` once it is dropped.
    lock: Option<Lock>,
    /// The files of a set that is not yet in place; `None` if each is put in place at once.
    staged: Option<Mutex<Vec<Staged>>>,
}

/// A complete file under its temporary name, and where it belongs.
#[derive(Debug)]
struct Staged {
    file: TempPath,
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
    /// Another run holds the directory.
    #[error(
        "{}: another run writes its files there; wait until it ends or name another with --out",
        display_path(.path)
    )]
    InUse {
        /// The directory.
        path: PathBuf,
    },
    /// A directory has the name of a file.
    #[error(
        "{}: is a directory where a file is to be written; remove it or name another --out",
        display_path(.path)
    )]
    Taken {
        /// The directory.
        path: PathBuf,
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
    /// Creates the directory at `path`, with its parents, unless it exists, and locks it; each file is put
    /// in place when it is written.
    ///
    /// Directories that were created are removed again when this value is dropped and they are empty.
    ///
    /// # Errors
    /// If it cannot be created, cannot be written to, or another run holds it.
    pub fn create(path: impl Into<PathBuf>) -> Result<Self, ExportError> {
        let mut out = Self {
            path: path.into(),
            made: Vec::new(),
            lock: None,
            staged: None,
        };
        out.make().map_err(|source| ExportError::Create {
            path: out.path.clone(),
            source,
        })?;
        match NamedTempFile::new_in(&out.path) {
            Ok(_probe) => {}
            Err(source) => {
                let path = out.path.clone();
                return Err(ExportError::NotWritable { path, source });
            }
        }
        out.lock = Lock::take(&out.path)?;
        Ok(out)
    }

    /// As [`Self::create`], but the files are a set: none is put in place before [`Self::finish`], and
    /// none at all without it.
    ///
    /// # Errors
    /// As [`Self::create`].
    ///
    /// # Examples
    /// ```
    /// use certainty_sim::export::OutDir;
    ///
    /// let folder = tempfile::tempdir().unwrap();
    /// let out = OutDir::begin(folder.path())?;
    /// let map = out.write_bytes("map.pgm", b"P2 1 1 255 0")?;
    /// let yaml = out.write_bytes("map.yaml", b"image: map.pgm")?;
    /// assert!(!map.exists() && !yaml.exists());
    /// out.finish()?;
    /// assert!(map.exists() && yaml.exists());
    /// # Ok::<(), certainty_sim::export::ExportError>(())
    /// ```
    pub fn begin(path: impl Into<PathBuf>) -> Result<Self, ExportError> {
        let mut out = Self::create(path)?;
        out.staged = Some(Mutex::default());
        Ok(out)
    }

    /// Creates what is missing of the path.
    fn make(&mut self) -> io::Result<()> {
        let missing: Vec<&Path> = self
            .path
            .ancestors()
            .take_while(|part| !part.as_os_str().is_empty() && !part.exists())
            .collect();
        self.made = missing.into_iter().rev().map(Path::to_owned).collect();
        fs::create_dir_all(&self.path)
    }

    /// Puts the files that were written since [`Self::begin`] in place, all or none, and unlocks the
    /// directory.
    ///
    /// # Errors
    /// If one cannot be put in place; then the directory is as it was before.
    pub fn finish(self) -> Result<(), ExportError> {
        let Some(staged) = &self.staged else {
            return Ok(());
        };
        // A panic while the list is held leaves it whole.
        let mut staged = staged.lock().unwrap_or_else(PoisonError::into_inner);
        let mut placed = Vec::new();
        for Staged { file, path } in staged.drain(..) {
            let result = check_free(&path).and_then(|()| {
                let write = |source| ExportError::Write {
                    path: path.clone(),
                    source,
                };
                let old = keep_old(&self.path, &path).map_err(write)?;
                let persisted = file.persist(&path);
                persisted.map_err(|error| write(error.error))?;
                Ok(old)
            });
            match result {
                Ok(old) => placed.push((path, old)),
                Err(error) => {
                    restore(placed);
                    return Err(error);
                }
            }
        }
        Ok(())
    }

    /// Returns the directory's path.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes the file `name` with the bytes that `content` writes, and returns its path, where it is at
    /// once, or after [`Self::finish`] if the files are a set.
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
        check_free(&path)?;
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
        let Some(staged) = &self.staged else {
            file.persist(path).map_err(|error| error.error)?;
            return Ok(());
        };
        let file = file.into_temp_path();
        let path = path.to_owned();
        // A panic while the list is held leaves it whole.
        let mut staged = staged.lock().unwrap_or_else(PoisonError::into_inner);
        staged.retain(|earlier| earlier.path != path);
        staged.push(Staged { file, path });
        Ok(())
    }
}

impl Drop for OutDir {
    fn drop(&mut self) {
        self.staged = None;
        self.lock = None;
        for made in self.made.iter().rev() {
            let _ = fs::remove_dir(made); // not if it has files
        }
    }
}

/// Refuses a path at which a directory is.
fn check_free(path: &Path) -> Result<(), ExportError> {
    if path.is_dir() {
        return Err(ExportError::Taken { path: path.into() });
    }
    Ok(())
}

/// Returns another name in `folder` for the file at `path`, if there is one.
fn keep_old(folder: &Path, path: &Path) -> io::Result<Option<TempPath>> {
    if path.symlink_metadata().is_err() {
        return Ok(None);
    }
    let mut name = tempfile::Builder::new();
    name.prefix(".certainty-").suffix(".old");
    let kept = name.make_in(folder, |kept| match fs::hard_link(path, kept) {
        Err(error) if error.kind() != io::ErrorKind::AlreadyExists => {
            fs::copy(path, kept).map(|_bytes| ())
        }
        linked => linked,
    })?;
    Ok(Some(kept.into_temp_path()))
}

/// Takes back the files that were put in place, the last first.
fn restore(placed: Vec<(PathBuf, Option<TempPath>)>) {
    for (path, old) in placed.into_iter().rev() {
        // The error that led here is the one to report.
        let _ = match old {
            Some(old) => old.persist(&path).map_err(|error| error.error),
            None => fs::remove_file(&path),
        };
    }
}

/// The lock of a directory: a locked file in it, which the system unlocks when the process ends.
#[derive(Debug)]
struct Lock {
    path: PathBuf,
    /// It is locked as long as it is open.
    _file: File,
}

impl Lock {
    /// The name of the file.
    const NAME: &str = ".certainty.lock";

    /// Locks `folder`; `None` if its file system has no locks.
    fn take(folder: &Path) -> Result<Option<Self>, ExportError> {
        let path = folder.join(Self::NAME);
        loop {
            match Self::try_take(folder, &path) {
                Ok(Some(file)) => return Ok(Some(Self { path, _file: file })),
                // The run that had it ended and removed it, and with it perhaps the directory.
                Ok(None) => {}
                Err(TryLockError::WouldBlock) => {
                    let path = folder.into();
                    return Err(ExportError::InUse { path });
                }
                Err(TryLockError::Error(error)) if error.kind() == io::ErrorKind::Unsupported => {
                    return Ok(None);
                }
                Err(TryLockError::Error(source)) => {
                    return Err(ExportError::NotWritable { path, source });
                }
            }
        }
    }

    /// Returns the locked file; `None` if it is no longer the one at `path`.
    fn try_take(folder: &Path, path: &Path) -> Result<Option<File>, TryLockError> {
        fs::create_dir_all(folder).map_err(TryLockError::Error)?;
        let mut options = OpenOptions::new();
        let opened = options.create(true).truncate(false).write(true).open(path);
        let file = match opened {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            opened => opened.map_err(TryLockError::Error)?,
        };
        file.try_lock()?;
        let same = is_at(&file, path).map_err(TryLockError::Error)?;
        Ok(same.then_some(file))
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // While it is locked: a run that opened it in between finds that it is gone. Where an open file
        // cannot be removed, it stays, and is as good for the next run.
        if cfg!(unix) {
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Returns whether `file` is the one at `path`.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> io::Result<bool> {
    use std::os::unix::fs::MetadataExt;
    let opened = file.metadata()?;
    match fs::metadata(path) {
        Ok(found) => Ok((found.dev(), found.ino()) == (opened.dev(), opened.ino())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
    }
}

/// Returns whether `file` is the one at `path`: it is not removed here.
#[cfg(not(unix))]
#[expect(clippy::unnecessary_wraps, reason = "as on Unix")]
fn is_at(_file: &File, _path: &Path) -> io::Result<bool> {
    Ok(true)
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
            .filter(|name| name != Lock::NAME)
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

    #[test]
    fn second_run_is_refused_until_the_first_ends() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out");
        let out = OutDir::create(&path).unwrap();
        let error = OutDir::begin(&path).unwrap_err();
        assert!(matches!(error, ExportError::InUse { .. }));
        assert_eq!(
            error.to_string(),
            format!(
                "{}: another run writes its files there; wait until it ends or name another with --out",
                path.display()
            )
        );
        drop(out);
        // A file that a killed run left is no lock.
        fs::create_dir_all(&path).unwrap();
        fs::write(path.join(Lock::NAME), b"").unwrap();
        drop(OutDir::create(&path).unwrap());
        assert!(path.exists(), "it was there before");
        assert!(!path.join(Lock::NAME).exists());
    }

    #[test]
    fn unused_directories_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a/b");
        let out = OutDir::begin(&path).unwrap();
        out.write_bytes("x", b"").unwrap();
        drop(out);
        assert!(names(folder.path()).is_empty());
        OutDir::create(&path)
            .unwrap()
            .write_bytes("x", b"")
            .unwrap();
        assert_eq!(names(&path), ["x"]);
    }

    #[test]
    fn set_appears_whole_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        fs::write(path.join("a"), b"old").unwrap();
        let written = |out: OutDir, files: &[&str]| -> Result<(), ExportError> {
            for file in files {
                out.write_bytes(file, b"new")?;
            }
            out.finish()
        };
        fs::create_dir(path.join("c")).unwrap();
        let out = OutDir::begin(path).unwrap();
        let error = written(out, &["a", "b", "c"]).unwrap_err();
        let expected = format!(
            "{}: is a directory where a file is to be written; remove it or name another --out",
            path.join("c").display()
        );
        assert_eq!(error.to_string(), expected);
        assert_eq!(names(path), ["a", "c"]);
        // It became a directory in between.
        fs::remove_dir(path.join("c")).unwrap();
        let out = OutDir::begin(path).unwrap();
        for file in ["a", "b", "c"] {
            out.write_bytes(file, b"new").unwrap();
        }
        fs::create_dir(path.join("c")).unwrap();
        assert!(matches!(out.finish(), Err(ExportError::Taken { .. })));
        assert_eq!(fs::read(path.join("a")).unwrap(), b"old");
        assert_eq!(names(path), ["a", "c"]);
        let out = OutDir::begin(path).unwrap();
        written(out, &["a", "b", "b"]).unwrap();
        assert_eq!(fs::read(path.join("a")).unwrap(), b"new");
        assert_eq!(names(path), ["a", "b", "c"]);
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
