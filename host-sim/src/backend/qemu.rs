//! The application as Thumb code under QEMU, its pins at the far end of a serial line.

use super::bridge::Bridge;
use super::image::Image;
use super::{BackendError, Ran};
use crate::bench::Bench;
use certainty_firmware::remote::{Request, wire};
use core::time::Duration;
use std::io::{self, Read, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;

/// The emulator's program.
const PROGRAM: &str = "qemu-system-arm";

/// How long the emulator may say nothing, in real time, before it is given up.
const PATIENCE: Duration = Duration::from_secs(30);

/// Runs `image` under QEMU against `bench` until `enough` of its telemetry has come.
///
/// # Errors
///
/// [`BackendError`] where QEMU is missing, ends, falls silent, or speaks another language.
pub(super) fn run(
    image: &Image,
    bench: Bench,
    enough: &mut dyn FnMut(&[u8]) -> bool,
) -> Result<Ran, BackendError> {
    let mut emulator = Emulator::start(image)?;
    let mut bridge = Bridge::new(bench);
    let mut told_enough = false;
    loop {
        let [kind] = emulator.read()?;
        if kind == wire::REPORT {
            let [length] = emulator.read()?;
            let mut frame = vec![0; length.into()];
            for byte in &mut frame {
                [*byte] = emulator.read()?;
            }
            bridge.report(&frame);
        } else {
            let mut request = [kind, 0, 0, 0, 0, 0];
            request[1..].copy_from_slice(&emulator.read::<{ wire::REQUEST - 1 }>()?);
            let request = wire::decode(request).ok_or(BackendError::Language)?;
            let answer = bridge.serve(request);
            if !matches!(request, Request::Pass(_)) {
                emulator.write(&wire::answer(answer, bridge.micros()))?;
            }
        }
        let telemetry = bridge.take_telemetry();
        told_enough |= !telemetry.is_empty() && enough(&telemetry);
        // The board tells of its stack where a round ends, after the round's last report.
        if told_enough && kind == wire::FEED {
            return Ok(Ran {
                stages: bridge.bench().stages().to_vec(),
                sizes: Some(image.sizes()),
                stack_bytes: bridge
                    .unused_stack()
                    .map(|unused| image.stack_room().saturating_sub(unused)),
            });
        }
    }
}

/// The running emulator; it ends with this value.
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
        // A thread of its own, so that waiting for the emulator can have an end.
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
                .recv_timeout(PATIENCE)
                .map_err(|error| match error {
                    RecvTimeoutError::Timeout => BackendError::Silent,
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
        // It has ended by itself, or has nothing left to do.
        let _ended = self.process.kill();
        let _reaped = self.process.wait();
    }
}
