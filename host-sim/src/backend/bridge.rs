//! Answers the board's requests out of the bench's virtual time.

use crate::bench::Bench;
use certainty_firmware::remote::{Refused, Request};

/// Nanoseconds of a millisecond.
const MILLISECOND: u64 = 1_000_000;

/// The far end of a remote board: a bench and the virtual time that passes only when it is asked to.
#[derive(Debug)]
pub(super) struct Bridge {
    bench: Bench,
    now_ns: u64,
    telemetry: Vec<u8>,
    unused_stack: Option<u32>,
}

impl Bridge {
    /// Creates the far end at time zero.
    #[must_use]
    pub(super) const fn new(bench: Bench) -> Self {
        Self {
            bench,
            now_ns: 0,
            telemetry: Vec::new(),
            unused_stack: None,
        }
    }

    /// Carries out a request.
    ///
    /// # Errors
    ///
    /// [`Refused`] where the bench has no such line or channel, or where it is broken.
    pub(super) fn serve(&mut self, request: Request) -> Result<u32, Refused> {
        match request {
            Request::Drive(line, high) => {
                let driven = self.bench.set_level(line, high, self.now_ns);
                driven.map(|()| 0).map_err(|_| Refused)
            }
            Request::Level(line) => {
                let level = self.bench.level(line, self.now_ns);
                level.map(u32::from).map_err(|_| Refused)
            }
            Request::Pulse(channel, micros) => {
                let set = self.bench.set_pulse(channel, micros.into(), self.now_ns);
                set.map(|()| 0).map_err(|_| Refused)
            }
            Request::Pass(nanoseconds) => {
                self.now_ns += u64::from(nanoseconds);
                Ok(0)
            }
            Request::Until(tick) => {
                // Ticks wrap; one in the past has begun.
                let ahead = tick.wrapping_sub(self.tick());
                if (1..1 << 31).contains(&ahead) {
                    self.now_ns = (self.now_ns / MILLISECOND + u64::from(ahead)) * MILLISECOND;
                }
                Ok(self.tick())
            }
            Request::Tick => Ok(self.tick()),
            Request::Micros => Ok(self.micros()),
            Request::Feed => Ok(0),
            Request::Unused(bytes) => {
                self.unused_stack = Some(bytes);
                Ok(0)
            }
        }
    }

    /// Returns the time in microseconds, modulo 2^32.
    pub(super) const fn micros(&self) -> u32 {
        (self.now_ns / 1000) as u32
    }

    const fn tick(&self) -> u32 {
        (self.now_ns / MILLISECOND) as u32
    }

    /// Takes a frame of telemetry.
    pub(super) fn report(&mut self, frame: &[u8]) {
        self.telemetry.extend_from_slice(frame);
    }

    /// Hands out the telemetry that came since the last time.
    pub(super) fn take_telemetry(&mut self) -> Vec<u8> {
        core::mem::take(&mut self.telemetry)
    }

    /// Returns the bench.
    pub(super) const fn bench(&self) -> &Bench {
        &self.bench
    }

    /// Returns how many bytes of the stack were never used, as the board last said.
    #[must_use]
    pub(super) const fn unused_stack(&self) -> Option<u32> {
        self.unused_stack
    }
}
