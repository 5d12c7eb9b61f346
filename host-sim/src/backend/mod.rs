//! Where the firmware's application runs: in this process, under QEMU, or on an emulated board.
//!
//! The same application meets the same [`Bench`] of simulated devices on each of them:
//!
//! | backend | is | its pins are |
//! |---|---|---|
//! | [`Backend::Native`] | the application as a part of this process | plain calls |
//! | [`Backend::Qemu`] | `bin/qemu` as Thumb code under QEMU | at the far end of its serial line |
//! | [`Backend::Board`] | `bin/smart_car`, the image that is flashed | registers of an emulated chip |
//!
//! What is known of a run is what the car reports on its serial line ([`Received`]), on every backend.

#[cfg(feature = "emulated-board")]
pub mod board;
mod bridge;
mod error;
mod image;
mod native;
mod qemu;
mod received;

pub use error::BackendError;
pub use image::{Image, Sizes};
pub use received::{Heard, MissingCounts, Received};

use crate::bench::{Bench, Stage};
use core::fmt;
use core::str::FromStr;
use std::path::Path;
use thiserror::Error;

/// Where the application runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Backend {
    /// As a part of this process.
    Native,
    /// As Thumb code under QEMU, its pins at the far end of a serial line.
    Qemu,
    /// As the unmodified image for the real board, on an emulated chip, pin by pin.
    Board,
}

/// The text names no backend.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("no such backend: write native, qemu or board")]
pub struct NoSuchBackend;

impl Backend {
    /// Returns the name it has on a command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Native => "native",
            Self::Qemu => "qemu",
            Self::Board => "board",
        }
    }
}

impl fmt::Display for Backend {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Backend {
    type Err = NoSuchBackend;

    fn from_str(text: &str) -> Result<Self, NoSuchBackend> {
        [Self::Native, Self::Qemu, Self::Board]
            .into_iter()
            .find(|backend| backend.name() == text)
            .ok_or(NoSuchBackend)
    }
}

/// What a backend knows of a run besides what the car reports.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Ran {
    /// What the image takes, where there is one.
    pub sizes: Option<Sizes>,
    /// The deepest the stack ever was, in bytes, where it can be told.
    pub stack_bytes: Option<u32>,
    /// Where the car truly was in each round, which it cannot know itself.
    pub stages: Vec<Stage>,
}

/// Runs the application for `rounds` rounds of its schedule against `bench`.
///
/// `image` replaces the image that this build made.
///
/// # Errors
///
/// [`BackendError`] says what the backend lacks, or where it failed.
pub fn run(
    backend: Backend,
    image: Option<&Path>,
    bench: Bench,
    rounds: u32,
) -> Result<(Received, Ran), BackendError> {
    let mut received = Received::default();
    let mut enough = |bytes: &[u8]| {
        received.take(bytes);
        received.statistics().round >= rounds
    };
    let ran = match backend {
        Backend::Native => native::run(bench, &mut enough)?,
        Backend::Qemu => qemu::run(&Image::load(image, "qemu")?, bench, &mut enough)?,
        #[cfg(feature = "emulated-board")]
        Backend::Board => board::run(&Image::load(image, "smart_car")?, bench, &mut enough)?,
        #[cfg(not(feature = "emulated-board"))]
        Backend::Board => return Err(BackendError::NoBoard),
    };
    Ok((received, ran))
}
