//! Why an application could not be run.

use std::path::PathBuf;
use thiserror::Error;

/// What a backend lacks, or where it failed; displays as one line.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum BackendError {
    /// There is no image to run.
    #[error(
        "{}: no firmware image: {why}; build it with `cargo firmware`, or name one with --image",
        path.display()
    )]
    NoImage {
        /// Where it was looked for.
        path: PathBuf,
        /// What the system said.
        why: String,
    },
    /// A file that is no image.
    #[error("{}: no image for this board: {why}; build one with `cargo firmware`", path.display())]
    BadImage {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        why: String,
    },
    /// QEMU is not installed.
    #[error("there is no qemu-system-arm: install it with `sudo apt-get install qemu-system-arm`")]
    NoQemu,
    /// QEMU could not be started.
    #[error("qemu-system-arm cannot be started: {0}")]
    Qemu(String),
    /// The emulator ended before its time.
    #[error("the emulator ended before the last round; build its image anew with `cargo firmware`")]
    Ended,
    /// Nothing came from the emulator any more.
    #[error(
        "the emulator fell silent before the last round; build its image anew with `cargo firmware`"
    )]
    Silent,
    /// The image asks for what there is not.
    #[error("the image speaks another language: build it anew with `cargo firmware`")]
    Language,
    /// The application refused its parts; a defect of ours.
    #[error("the application does not fit its parts")]
    Refused,
    /// The emulated board was left out of this program.
    #[error(
        "this program was built without the emulated board: build it with its default features"
    )]
    NoBoard,
    /// The emulated board failed.
    #[error("the emulated board: {0}")]
    Board(String),
}
