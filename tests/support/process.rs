//! Builds and runs programs for tests.

use core::time::Duration;
use serde_json::Value;
use std::io::Read;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::Instant;

use crate::workspace;

/// The longest that a run may take, on a busy machine and under QEMU too.
pub const PATIENCE: Duration = Duration::from_secs(300);

/// Builds with cargo and returns the path of the executable `name`.
///
/// # Errors
/// The stderr of cargo, if it fails or builds no such executable.
///
/// # Panics
/// If cargo itself cannot be started.
pub fn executable<'a>(
    arguments: impl IntoIterator<Item = &'a str>,
    name: &str,
) -> Result<PathBuf, String> {
    let output = Command::new(env!("CARGO"))
        .args(arguments)
        .args(["--locked", "--message-format=json-render-diagnostics"])
        .current_dir(workspace())
        .output()
        .expect("cargo runs: it started this test");
    let messages = String::from_utf8_lossy(&output.stdout);
    let built = messages.lines().rev().find_map(|line| {
        let message: Value = serde_json::from_str(line).ok()?;
        let path = message.get("executable")?.as_str()?;
        (message["target"]["name"] == name).then(|| PathBuf::from(path))
    });
    let built = built.filter(|_| output.status.success());
    built.ok_or_else(|| String::from_utf8_lossy(&output.stderr).into_owned())
}

/// How a run ended.
#[derive(Debug, Clone)]
pub struct Ran {
    /// The exit code; `None` after a signal.
    pub code: Option<i32>,
    /// The text on stdout.
    pub stdout: String,
    /// The text on stderr.
    pub stderr: String,
}

impl Ran {
    /// Returns the one JSON document on stdout.
    ///
    /// # Panics
    /// If the run failed or stdout has any other content.
    #[must_use]
    pub fn json(&self) -> Value {
        assert_eq!(self.code, Some(0), "{}", self.stderr);
        serde_json::from_str(&self.stdout).expect("stdout is one JSON document")
    }

    /// Returns the line on stderr of a refused run: exit code 2, one line on stderr, nothing on stdout.
    ///
    /// # Panics
    /// If the run did anything else.
    #[must_use]
    pub fn refusal(&self) -> &str {
        assert_eq!(self.code, Some(2), "{self:?}");
        assert_eq!(self.stdout, "", "a refused run prints no result");
        let mut lines = self.stderr.lines();
        let line = lines.next().expect("a refused run gives its reason");
        assert_eq!(
            lines.next(),
            None,
            "the reason is one line: {:?}",
            self.stderr
        );
        assert!(line.starts_with("certainty: "), "{line}");
        assert!(!line.contains("panicked"), "{line}");
        line
    }
}

/// Runs `command` to its end.
///
/// # Panics
/// If it cannot be started or runs longer than `limit`; it is killed then.
#[must_use]
pub fn run(mut command: Command, limit: Duration) -> Ran {
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("the command can be started");
    let stdout = child.stdout.take().map(reader);
    let stderr = child.stderr.take().map(reader);
    let code = wait(&mut child, limit);
    let text = |reader: Option<thread::JoinHandle<String>>| {
        let text = reader.map(|reader| reader.join().expect("reading a pipe does not fail"));
        text.unwrap_or_default()
    };
    let code = code.unwrap_or_else(|| panic!("{command:?} ran longer than {limit:?}"));
    Ran {
        code,
        stdout: text(stdout),
        stderr: text(stderr),
    }
}

/// Waits for `child` and returns its exit code; kills it after `limit` and returns `None`.
///
/// # Panics
/// If the system has no such child process.
pub fn wait(child: &mut Child, limit: Duration) -> Option<Option<i32>> {
    let start = Instant::now();
    loop {
        if let Some(status) = child.try_wait().expect("the child is ours") {
            return Some(status.code());
        }
        if start.elapsed() > limit {
            child.kill().expect("the child is ours");
            child.wait().expect("the child is ours");
            return None;
        }
        thread::sleep(Duration::from_millis(2));
    }
}

/// Reads a pipe to its end in a thread, so that the writer never blocks.
fn reader(mut pipe: impl Read + Send + 'static) -> thread::JoinHandle<String> {
    thread::spawn(move || {
        let mut bytes = Vec::new();
        pipe.read_to_end(&mut bytes).expect("a pipe can be read");
        String::from_utf8_lossy(&bytes).into_owned()
    })
}
