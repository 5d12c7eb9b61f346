//! How many things are done at once.

use super::Failure;
use clap::Args;

/// `--jobs N`: part of every command that runs in parallel.
#[derive(Debug, Clone, Copy, Args)]
pub(super) struct Jobs {
    /// How many threads; the result is the same with any number [default: one a core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
}

impl Jobs {
    /// Whether a number was given.
    pub(super) const fn are_given(self) -> bool {
        self.jobs.is_some()
    }

    /// Runs `work` where `rayon` has so many threads.
    pub(super) fn run<T: Send>(self, work: impl FnOnce() -> T + Send) -> Result<T, Failure> {
        // Zero lets rayon count the cores.
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(self.jobs.unwrap_or(0).into())
            .build()
            .map_err(|error| Failure::Internal(format!("cannot start threads: {error}")))?;
        Ok(pool.install(work))
    }
}
