//! The application whose pins are remote: in this process they are calls, under QEMU a serial line.
//!
//! The application makes requests ([`Request`]); a [`Bridge`] carries them out on the bench, in virtual time
//! that passes only on request.

use super::image::Image;
use super::outcome::{BackendError, RunDetails};
use crate::bench::{Bench, MILLISECOND};
use certainty_firmware::executive::{Dispatcher, DueQueue, Executive};
use certainty_firmware::remote::{
    Link, RemoteClock, RemoteWatchdog, Request, RequestRefused, wire,
};
use certainty_firmware::smart_car::{SCHEDULE, SmartCar, remote_wiring};
use core::cell::RefCell;
use core::time::Duration;
use std::io::{self, Read, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;

/// The bench of a remote board, and its virtual time, which passes only on request.
#[derive(Debug)]
struct Bridge {
    bench: Bench,
    now_ns: u64,
    telemetry: Vec<u8>,
    unused_stack: Option<u32>,
}

impl Bridge {
    /// Creates the bridge at time zero.
    const fn new(bench: Bench) -> Self {
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
    /// [`RequestRefused`] where the bench has no such line or channel, or where it has failed.
    fn serve(&mut self, request: Request) -> Result<u32, RequestRefused> {
        match request {
            Request::Drive(line, high) => {
                let driven = self.bench.set_level(line, high, self.now_ns);
                driven.map(|()| 0).map_err(|_| RequestRefused)
            }
            Request::Level(line) => {
                let level = self.bench.level(line, self.now_ns);
                level.map(u32::from).map_err(|_| RequestRefused)
            }
            Request::Pulse(channel, micros) => {
                let set = self.bench.set_pulse(channel, micros.into(), self.now_ns);
                set.map(|()| 0).map_err(|_| RequestRefused)
            }
            Request::Pass(nanoseconds) => {
                self.now_ns += u64::from(nanoseconds);
                Ok(0)
            }
            Request::Until(tick) => {
                // Ticks wrap; half of them are in the past.
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
    const fn micros(&self) -> u32 {
        (self.now_ns / 1000) as u32
    }

    const fn tick(&self) -> u32 {
        (self.now_ns / MILLISECOND) as u32
    }
}

/// A link within this process: requests are calls.
struct InProcess(RefCell<Bridge>);

impl Link for InProcess {
    fn request(&self, request: Request) -> Result<u32, RequestRefused> {
        self.0.borrow_mut().serve(request)
    }

    fn pass(&self, nanoseconds: u32) {
        let _ = self.request(Request::Pass(nanoseconds)); // never refused
    }

    fn micros(&self) -> u32 {
        self.0.borrow().micros()
    }

    fn report(&self, frame: &[u8]) {
        self.0.borrow_mut().telemetry.extend_from_slice(frame);
    }
}

/// Runs the application against `bench` until `done` returns true for its telemetry.
///
/// # Errors
///
/// [`BackendError::Refused`] where the application refuses its configuration, which would be a defect.
pub(super) fn run_native(
    bench: Bench,
    done: &mut dyn FnMut(&[u8]) -> bool,
) -> Result<RunDetails, BackendError> {
    let link = InProcess(RefCell::new(Bridge::new(bench)));
    let mut car = SmartCar::try_new(remote_wiring(&link)).map_err(|_| BackendError::Refused)?;
    let queue = DueQueue::new();
    let clock = RemoteClock::new(&link, Dispatcher::new(&SCHEDULE), &queue);
    let mut executive = Executive::new(&SCHEDULE, clock, RemoteWatchdog::new(&link));
    loop {
        executive.step(&queue, &mut car);
        let telemetry = core::mem::take(&mut link.0.borrow_mut().telemetry);
        if !telemetry.is_empty() && done(&telemetry) {
            return Ok(RunDetails {
                ground_truth: link.0.borrow().bench.ground_truth().to_vec(),
                ..RunDetails::default()
            });
        }
    }
}

/// The emulator's program.
const PROGRAM: &str = "qemu-system-arm";

/// The longest time, in real time, that the emulator may send nothing.
const SILENCE_LIMIT: Duration = Duration::from_secs(30);

/// Runs `image` under QEMU against `bench` until `done` returns true for its telemetry.
///
/// # Errors
///
/// [`BackendError`] where QEMU is missing, ends, sends nothing, or where the image uses another protocol.
pub(super) fn run_qemu(
    image: &Image,
    bench: Bench,
    done: &mut dyn FnMut(&[u8]) -> bool,
) -> Result<RunDetails, BackendError> {
    let mut emulator = Emulator::start(image)?;
    let mut bridge = Bridge::new(bench);
    let mut is_done = false;
    loop {
        let [kind] = emulator.read()?;
        if kind == wire::REPORT {
            let [length] = emulator.read()?;
            let mut frame = vec![0; length.into()];
            for byte in &mut frame {
                [*byte] = emulator.read()?;
            }
            bridge.telemetry.extend_from_slice(&frame);
        } else {
            let mut request = [kind, 0, 0, 0, 0, 0];
            request[1..].copy_from_slice(&emulator.read::<{ wire::REQUEST - 1 }>()?);
            let request = wire::decode(request).ok_or(BackendError::UnknownProtocol)?;
            let answer = bridge.serve(request);
            if !matches!(request, Request::Pass(_)) {
                emulator.write(&wire::encode_answer(answer, bridge.micros()))?;
            }
        }
        let telemetry = core::mem::take(&mut bridge.telemetry);
        is_done |= !telemetry.is_empty() && done(&telemetry);
        // The board reports its stack at the end of a round, after all other reports.
        if is_done && kind == wire::FEED {
            return Ok(RunDetails {
                ground_truth: bridge.bench.ground_truth().to_vec(),
                sizes: Some(image.sizes()),
                stack_bytes: bridge
                    .unused_stack
                    .map(|unused| image.stack_room().saturating_sub(unused)),
            });
        }
    }
}

/// The running emulator; dropping it ends the process.
struct Emulator {
    process: Child,
    input: ChildStdin,
    output: Receiver<u8>,
}

impl Emulator {
    fn start(image: &Image) -> Result<Self, BackendError> {
        let mut process = Command::new(PROGRAM)
            .args(["-M", "stm32vldiscovery", "-display", "none"])
            .args(["-monitor", "none", "-serial", "stdio", "-kernel"])
            .arg(image.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|error| match error.kind() {
                io::ErrorKind::NotFound => BackendError::NoQemu,
                _ => BackendError::Qemu(error.to_string()),
            })?;
        let (input, output) = (process.stdin.take(), process.stdout.take());
        let (Some(input), Some(mut output)) = (input, output) else {
            return Err(BackendError::Qemu("it has no pipes".to_owned()));
        };
        // A thread of its own, so that waiting for the emulator can time out.
        let (sender, receiver) = channel();
        thread::spawn(move || {
            let mut bytes = [0; 4096];
            while let Ok(count @ 1..) = output.read(&mut bytes) {
                if bytes[..count]
                    .iter()
                    .any(|&byte| sender.send(byte).is_err())
                {
                    return;
                }
            }
        });
        Ok(Self {
            process,
            input,
            output: receiver,
        })
    }

    fn read<const N: usize>(&mut self) -> Result<[u8; N], BackendError> {
        let mut bytes = [0; N];
        for byte in &mut bytes {
            *byte = self
                .output
                .recv_timeout(SILENCE_LIMIT)
                .map_err(|error| match error {
                    RecvTimeoutError::Timeout => BackendError::Timeout,
                    RecvTimeoutError::Disconnected => BackendError::Ended,
                })?;
        }
        Ok(bytes)
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), BackendError> {
        let written = self.input.write_all(bytes);
        written
            .and_then(|()| self.input.flush())
            .map_err(|_| BackendError::Ended)
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        let _ = self.process.kill(); // fails where it has already ended
        let _ = self.process.wait(); // only frees the process's entry
    }
}
