//! The firmware's images, built as `cargo firmware` builds them.

use crate::process::{Ran, executable, run};
use crate::{skipped, workspace};
use core::time::Duration;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

/// The microcontroller's target.
const TARGET: &str = "thumbv7m-none-eabi";

/// Returns the image called `name`; `None` where its target is not installed.
///
/// # Panics
/// If the firmware cannot be built.
#[must_use]
pub fn image(name: &str) -> Option<PathBuf> {
    build(["firmware"], name)
}

/// Returns the image called `name`, which the crate has with `feature` only.
///
/// # Panics
/// If it cannot be built.
#[must_use]
pub fn image_with(name: &str, feature: &str) -> Option<PathBuf> {
    build(["firmware", "--features", feature, "--bin", name], name)
}

fn build<const N: usize>(arguments: [&str; N], name: &str) -> Option<PathBuf> {
    static INSTALLED: OnceLock<bool> = OnceLock::new();
    if *INSTALLED.get_or_init(target_is_installed) {
        Some(executable(arguments, name).expect("the firmware can be built"))
    } else {
        skipped(&format!("rustup target add {TARGET}"));
        None
    }
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

/// Whether QEMU can be run here; notes it if not.
#[must_use]
pub fn qemu_is_there() -> bool {
    let there = Command::new("qemu-system-arm").arg("--version").output();
    if there.is_err() {
        skipped("there is no qemu-system-arm");
    }
    there.is_ok()
}

/// Runs an image that speaks by semihosting, under QEMU and until it ends.
///
/// Every instruction takes 32 ns of the emulator's time, so that counts repeat.
#[must_use]
pub fn counted(image: &Path) -> Ran {
    let mut qemu = Command::new("qemu-system-arm");
    qemu.args(["-M", "stm32vldiscovery", "-nographic", "-monitor", "none"])
        .args(["-serial", "null", "-icount", "shift=5"])
        .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(image)
        .stdin(Stdio::null());
    run(qemu, Duration::from_secs(120))
}
