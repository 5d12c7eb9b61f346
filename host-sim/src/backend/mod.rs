//! Where the firmware's application runs: in this process, under QEMU, or on an emulated board.
//!
//! Each backend runs the same application against the same [`Bench`] of simulated devices:
//!
//! | backend | is | its pins are |
//! |---|---|---|
//! | [`Backend::Native`] | the application as a part of this process | plain calls |
//! | [`Backend::Qemu`] | the image `qemu` as Thumb code under QEMU | at the far end of its serial line |
//! | [`Backend::Board`] | the image `smart_car`, which is flashed | registers of an emulated chip |
//!
//! On every backend the results are the reports that the car sends on its serial line ([`Received`]).

#[cfg(feature = "emulated-board")]
pub mod board;
mod image;
mod outcome;
mod remote;

pub use image::Image;
pub use outcome::{BackendError, MissingCounts, Received, ReceivedSensor, RunDetails, Sizes};

use crate::bench::Bench;
use core::fmt;
use std::path::Path;

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

impl Backend {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Native, Self::Qemu, Self::Board];

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

/// Runs the application for `rounds` rounds of its schedule against `bench`.
///
/// `image` is the path of an image to run in place of this build's own.
///
/// # Errors
///
/// [`BackendError`] for a backend that is not there, or that failed.
pub fn run(
    backend: Backend,
    image: Option<&Path>,
    bench: Bench,
    rounds: u32,
) -> Result<(Received, RunDetails), BackendError> {
    let mut received = Received::default();
    let mut done = |bytes: &[u8]| {
        received.take(bytes);
        received.statistics().round >= rounds
    };
    let ran = match backend {
        Backend::Native => remote::run_native(bench, &mut done)?,
        Backend::Qemu => remote::run_qemu(&Image::load(image, "qemu")?, bench, &mut done)?,
        #[cfg(feature = "emulated-board")]
        Backend::Board => board::run(&Image::load(image, "smart_car")?, bench, &mut done)?,
        #[cfg(not(feature = "emulated-board"))]
        Backend::Board => return Err(BackendError::NoBoard),
    };
    Ok((received, ran))
}
