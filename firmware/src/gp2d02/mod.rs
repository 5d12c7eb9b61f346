//! A Sharp GP2D02 infrared sensor on two pins.
//!
//! | Vin | Vout |
//! |---|---|
//! | high | idles high |
//! | goes low | goes low, and high again within 70 ms: the conversion is over |
//! | eight times high, then low, 50 to 100 µs each | one bit after each fall, the highest first |
//! | high for 2 ms | goes back to idle |
//!
//! The sensor stands 3 V on Vin at most and pulls it up itself, so Vin must be an open-drain
//! output: *high* is let go. Vout needs a pull-down, so that a sensor that is gone reads low.
//!
//! [`Gp2d02::start`] and [`Gp2d02::read`] are for a schedule, which does other things for 70 ms;
//! [`Gp2d02::measure`] is for who has nothing else to do. All three check the line before they
//! believe it: several samples must agree, low where the sensor converts and high where it idles.
//!
//! The durations stated here hold while each operation is within
//! [`OPERATION_US`](crate::stopwatch::OPERATION_US) and no interrupt takes long.

mod fault;

pub use fault::Fault;

use crate::stopwatch::longest;
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{InputPin, OutputPin};

/// The longest conversion, in µs: the least between [`Gp2d02::start`] and [`Gp2d02::read`].
pub const CONVERSION_US: u32 = 70_000;

/// The longest that [`Gp2d02::start`] takes, in µs.
pub const START_US: u32 = longest(
    2 * CHECK_OPERATIONS + START_OPERATIONS,
    2 * CHECK_US + RESPONSE_US,
);

/// The longest that [`Gp2d02::read`] takes, in µs.
pub const READ_US: u32 = longest(
    2 * CHECK_OPERATIONS + READ_OPERATIONS,
    2 * CHECK_US + 8 * (HIGH_US + EARLY_US + LATE_US) + RECOVERY_US,
);

/// The longest that [`Gp2d02::measure`] waits for a conversion to end before it gives up, in µs,
/// the time for asking not counted.
pub const PATIENCE_US: u32 = 100_000;

/// The longest that [`Gp2d02::measure`] takes, in µs.
pub const MEASURE_US: u32 = START_US + (PATIENCE_US / POLL_US) * longest(2, POLL_US) + READ_US;

/// Samples that must agree before a level of Vout is believed.
///
/// Of five samples of mere noise all agree in one case of 16, and there are three such checks and
/// eight bits of two samples in a reading.
const SAMPLES: u32 = 5;

/// Between two samples, in µs.
const SAMPLE_GAP_US: u32 = 20;

/// What a check of Vout waits, in µs.
const CHECK_US: u32 = SAMPLE_GAP_US * (SAMPLES - 1);

/// What a check of Vout does: its samples, and the waits between them.
const CHECK_OPERATIONS: u32 = 2 * SAMPLES - 1;

/// Vin low, a wait, and Vin high for a fault.
const START_OPERATIONS: u32 = 3;

/// Two levels of Vin, three waits and two samples a bit, then Vin high, a wait, and Vin high for a
/// fault.
const READ_OPERATIONS: u32 = 8 * 7 + 3;

/// How soon Vout is low after Vin is, in µs.
const RESPONSE_US: u32 = 200;

// With its operations each half of a clock's period is within 50 to 100 µs, as it must be.

/// Vin high before a bit, in µs.
const HIGH_US: u32 = 60;

/// From Vin's fall to the first sample of a bit, in µs.
const EARLY_US: u32 = 30;

/// From the first sample of a bit to the second, in µs.
const LATE_US: u32 = 30;

/// Vin high after the bits until Vout must idle, in µs: 2 ms and a tenth for a clock that is fast.
const RECOVERY_US: u32 = 2_200;

/// Between two polls of [`Gp2d02::measure`], in µs.
const POLL_US: u32 = 1_000;

/// The driver: `Vin` is an open-drain output, `Vout` an input with a pull-down.
///
/// After a fault Vin is high. A sound sensor idles again 2 ms later, and the next
/// [`start`](Self::start) works.
#[derive(Debug)]
pub struct Gp2d02<Vin, Vout> {
    vin: Vin,
    vout: Vout,
    state: State,
}

/// Where the driver is in the protocol.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// Vin is high.
    Idle,
    /// Vin is low, and a conversion under way or over.
    Converting,
}

impl<Vin: OutputPin, Vout: InputPin> Gp2d02<Vin, Vout> {
    /// Creates the driver of a sensor whose Vin has been high for 2 ms.
    #[must_use]
    pub const fn new(vin: Vin, vout: Vout) -> Self {
        Self {
            vin,
            vout,
            state: State::Idle,
        }
    }

    /// Returns the pins.
    #[must_use]
    pub fn release(self) -> (Vin, Vout) {
        (self.vin, self.vout)
    }

    /// Starts a conversion; it is over [`CONVERSION_US`] later.
    ///
    /// Cost: at most [`START_US`].
    ///
    /// # Errors
    ///
    /// - [`Fault::StuckLow`] where Vout does not idle high, and nothing is started,
    /// - [`Fault::StuckHigh`] where it does not go low then,
    /// - [`Fault::Floating`] where it is neither,
    /// - [`Fault::Pin`], and [`Fault::OutOfTurn`] during a conversion, which it ends.
    pub fn start(&mut self, delay: &mut impl DelayNs) -> Result<(), Fault> {
        let started = match self.state {
            State::Idle => self.ask(delay),
            State::Converting => Err(Fault::OutOfTurn),
        };
        self.conclude(started, State::Converting)
    }

    /// Says whether the conversion is over: one look at Vout, without a wait.
    ///
    /// # Errors
    ///
    /// [`Fault::Pin`], and [`Fault::OutOfTurn`] where no conversion was started.
    pub fn ready(&mut self) -> Result<bool, Fault> {
        let ready = match self.state {
            State::Idle => Err(Fault::OutOfTurn),
            State::Converting => self.vout_is_high(),
        };
        self.conclude(ready, State::Converting)
    }

    /// Reads the byte of a conversion that is over; it falls with distance.
    ///
    /// Cost: at most [`READ_US`].
    ///
    /// # Errors
    ///
    /// - [`Fault::Timeout`] where the conversion is not over, which is given up,
    /// - [`Fault::Floating`] where Vout changes within a bit or a check,
    /// - [`Fault::CutShort`] where it does not idle high afterwards,
    /// - [`Fault::Pin`], and [`Fault::OutOfTurn`] where no conversion was started.
    pub fn read(&mut self, delay: &mut impl DelayNs) -> Result<u8, Fault> {
        let byte = match self.state {
            State::Idle => Err(Fault::OutOfTurn),
            State::Converting => self.clock_out(delay),
        };
        self.conclude(byte, State::Idle)
    }

    /// Measures once, waiting for the conversion to end.
    ///
    /// Cost: at most [`MEASURE_US`].
    ///
    /// # Errors
    ///
    /// Those of [`start`](Self::start) and [`read`](Self::read).
    pub fn measure(&mut self, delay: &mut impl DelayNs) -> Result<u8, Fault> {
        self.start(delay)?;
        for _ in 0..PATIENCE_US / POLL_US {
            if self.ready()? {
                break;
            }
            delay.delay_us(POLL_US);
        }
        self.read(delay)
    }

    /// Enters `next`, or gives up: Vin high, whatever else failed.
    fn conclude<T>(&mut self, result: Result<T, Fault>, next: State) -> Result<T, Fault> {
        self.state = if result.is_ok() { next } else { State::Idle };
        if result.is_err() {
            // The fault is known already; a pin that refuses too adds nothing to it.
            let _ = self.vin.set_high();
        }
        result
    }

    fn ask(&mut self, delay: &mut impl DelayNs) -> Result<(), Fault> {
        self.expect(true, Fault::StuckLow, delay)?;
        self.vin.set_low().map_err(|_| Fault::Pin)?;
        delay.delay_us(RESPONSE_US);
        self.expect(false, Fault::StuckHigh, delay)
    }

    fn clock_out(&mut self, delay: &mut impl DelayNs) -> Result<u8, Fault> {
        self.expect(true, Fault::Timeout, delay)?;
        let mut byte = 0_u8;
        for _ in 0..u8::BITS {
            self.vin.set_high().map_err(|_| Fault::Pin)?;
            delay.delay_us(HIGH_US);
            self.vin.set_low().map_err(|_| Fault::Pin)?;
            delay.delay_us(EARLY_US);
            let bit = self.vout_is_high()?;
            delay.delay_us(LATE_US);
            if self.vout_is_high()? != bit {
                return Err(Fault::Floating);
            }
            byte = byte << 1 | u8::from(bit);
        }
        self.vin.set_high().map_err(|_| Fault::Pin)?;
        delay.delay_us(RECOVERY_US);
        self.expect(true, Fault::CutShort, delay)?;
        Ok(byte)
    }

    /// Checks that Vout is steadily `high`; `otherwise` says what it is if it is steadily not.
    fn expect(
        &mut self,
        high: bool,
        otherwise: Fault,
        delay: &mut impl DelayNs,
    ) -> Result<(), Fault> {
        let level = self.vout_is_high()?;
        for _ in 1..SAMPLES {
            delay.delay_us(SAMPLE_GAP_US);
            if self.vout_is_high()? != level {
                return Err(Fault::Floating);
            }
        }
        if level == high {
            Ok(())
        } else {
            Err(otherwise)
        }
    }

    fn vout_is_high(&mut self) -> Result<bool, Fault> {
        self.vout.is_high().map_err(|_| Fault::Pin)
    }
}

#[cfg(test)]
mod tests;
