//! The firmware's images, built as `cargo firmware` builds them.

use crate::process::{Ran, executable, run};
use crate::{tool_is_missing, workspace};
use core::time::Duration;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{self, Command, Stdio};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::{env, io};

/// The microcontroller's target.
const TARGET: &str = "thumbv7m-none-eabi";

/// Returns the image `name`; `None` if its target is not installed.
///
/// # Panics
/// If the firmware cannot be built.
#[must_use]
pub fn image(name: &str) -> Option<PathBuf> {
    build(["firmware"], name, name)
}

/// Returns the image `name`, built with `feature`; `None` if its target is not installed.
///
/// # Panics
/// If it cannot be built.
#[must_use]
pub fn image_with(name: &str, feature: &str) -> Option<PathBuf> {
    let copy = format!("{name}-{feature}");
    build(
        ["firmware", "--features", feature, "--bin", name],
        name,
        &copy,
    )
}

/// Builds an image, once a process, and returns the path of a copy of it.
///
/// Builds with different features write to the same file, hence the copy, and the lock until it is made.
fn build<const N: usize>(arguments: [&str; N], name: &str, copy: &str) -> Option<PathBuf> {
    static BUILT: Mutex<BTreeMap<String, PathBuf>> = Mutex::new(BTreeMap::new());
    static INSTALLED: OnceLock<bool> = OnceLock::new();
    if !*INSTALLED.get_or_init(target_is_installed) {
        tool_is_missing(&format!("rustup target add {TARGET}"));
        return None;
    }
    let mut built = BUILT.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(image) = built.get(copy) {
        return Some(image.clone());
    }
    let copied = || -> io::Result<PathBuf> {
        // Beside the test: wherever cargo puts its target folder.
        let folder = env::current_exe()?.with_file_name("images");
        fs::create_dir_all(&folder)?;
        let lock = File::create(folder.join("lock"))?;
        lock.lock()?;
        let image = executable(arguments, name).expect("the firmware can be built");
        let (part, copy) = (
            folder.join(format!("{copy}.{}", process::id())),
            folder.join(copy),
        );
        fs::copy(image, &part)?;
        fs::rename(part, &copy)?;
        Ok(copy)
    };
    let image = copied().expect("the image can be copied");
    built.insert(copy.into(), image.clone());
    Some(image)
}

fn target_is_installed() -> bool {
    let libraries = Command::new("rustc")
        .args(["--print", "target-libdir", "--target", TARGET])
        .current_dir(workspace())
        .output();
    let folder = libraries
        .ok()
        .and_then(|output| String::from_utf8(output.stdout).ok());
    folder.is_some_and(|folder| Path::new(folder.trim()).is_dir())
}

/// Returns whether QEMU is installed; prints a note if not.
#[must_use]
pub fn qemu_is_installed() -> bool {
    let version = Command::new("qemu-system-arm").arg("--version").output();
    if version.is_err() {
        tool_is_missing("qemu-system-arm is not installed");
    }
    version.is_ok()
}

/// Runs an image that prints by semihosting, under QEMU and until it ends; returns what it printed.
///
/// Every instruction takes 32 ns of the emulated time, so that counts are reproducible.
///
/// # Panics
/// If the image reports a failure or does not end.
#[must_use]
pub fn output(image: &Path) -> String {
    let mut qemu = Command::new("qemu-system-arm");
    qemu.args(["-M", "stm32vldiscovery", "-nographic", "-monitor", "none"])
        .args(["-serial", "null", "-icount", "shift=5"])
        .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(image)
        .stdin(Stdio::null());
    let ran = run(qemu, Duration::from_secs(120));
    assert_eq!(ran.code, Some(0), "{ran:?}");
    let Ran { stdout, stderr, .. } = ran;
    // QEMU writes semihosting output to stderr or stdout, depending on its version.
    stdout + &stderr
}
