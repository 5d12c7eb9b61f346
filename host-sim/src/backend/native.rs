//! The application as a part of this process, its pins plain calls.

use super::bridge::Bridge;
use super::{BackendError, Ran};
use crate::bench::Bench;
use certainty_firmware::executive::{Dispatcher, DueQueue, Executive};
use certainty_firmware::remote::{Link, Refused, RemoteClock, RemoteWatchdog, Request};
use certainty_firmware::smart_car::{SCHEDULE, SmartCar, remote_wiring};
use core::cell::RefCell;

/// A far end that is near: requests are calls.
struct Direct(RefCell<Bridge>);

impl Link for Direct {
    fn ask(&self, request: Request) -> Result<u32, Refused> {
        self.0.borrow_mut().serve(request)
    }

    fn pass(&self, nanoseconds: u32) {
        // Time always passes.
        let _passed = self.ask(Request::Pass(nanoseconds));
    }

    fn micros(&self) -> u32 {
        self.0.borrow().micros()
    }

    fn report(&self, frame: &[u8]) {
        self.0.borrow_mut().report(frame);
    }
}

/// Runs the application against `bench` until `enough` of its telemetry has come.
///
/// # Errors
///
/// [`BackendError::Refused`] where the application does not fit its parts, which would be a defect.
pub(super) fn run(
    bench: Bench,
    enough: &mut dyn FnMut(&[u8]) -> bool,
) -> Result<Ran, BackendError> {
    let link = Direct(RefCell::new(Bridge::new(bench)));
    let mut car = SmartCar::try_new(remote_wiring(&link)).map_err(|_| BackendError::Refused)?;
    let queue = DueQueue::new();
    let clock = RemoteClock::new(&link, Dispatcher::new(&SCHEDULE), &queue);
    let mut executive = Executive::new(&SCHEDULE, clock, RemoteWatchdog::new(&link));
    loop {
        executive.step(&queue, &mut car);
        let telemetry = link.0.borrow_mut().take_telemetry();
        if !telemetry.is_empty() && enough(&telemetry) {
            return Ok(Ran {
                stages: link.0.borrow().bench().stages().to_vec(),
                ..Ran::default()
            });
        }
    }
}
