//! A Sharp GP2D02 infrared sensor on two pins.
//!
//! | Vin | Vout |
//! |---|---|
//! | high | idles high |
//! | goes low | goes low, and high again within 70 ms: the conversion is over |
//! | eight times high, then low, 50 to 100 µs each | one bit after each fall, the highest first |
//! | high for 2 ms | goes back to idle |
//!
//! Vin takes 3 V at most and has a pull-up in the sensor, so it must be an open-drain output: *high*
//! means released. Vout needs a pull-down, so that an unplugged sensor reads low.
//!
//! [`Gp2d02::start`] and [`Gp2d02::read`] are for a schedule that does other work during the conversion
//! of 70 ms; [`Gp2d02::measure`] blocks until it is over. All three check Vout: several samples must
//! agree, low while the sensor converts and high while it idles.
//!
//! The stated durations hold if each operation takes at most
//! [`OPERATION_US`](crate::timing::OPERATION_US) and no interrupt takes long.

use crate::timing::longest;
use certainty_core::transducer::Missing;
use core::fmt;
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{InputPin, OutputPin};

/// Why a GP2D02 gave no byte.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Fault {
    /// Vout is low while the sensor should idle: a short circuit, no supply, or no sensor.
    StuckLow,
    /// Vout stays high after a conversion was started.
    StuckHigh,
    /// Vout changes while it must be steady.
    Floating,
    /// The conversion did not end within its 70 ms.
    Timeout,
    /// After the eight bits Vout did not return to high: the sensor was lost meanwhile.
    CutShort,
    /// A pin returned an error.
    Pin,
    /// A read without a started conversion, or a start during one.
    OutOfTurn,
}

impl Fault {
    /// Returns the reason of the missing reading: a timeout for [`Fault::Timeout`] and
    /// [`Fault::OutOfTurn`], a bus error for all others.
    #[must_use]
    pub const fn reason(self) -> Missing {
        match self {
            Self::Timeout | Self::OutOfTurn => Missing::Timeout,
            Self::StuckLow | Self::StuckHigh | Self::Floating | Self::CutShort | Self::Pin => {
                Missing::Bus
            }
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::StuckLow => "Vout is low while the sensor idles: expected high",
            Self::StuckHigh => "Vout is high after the start of a conversion: expected low",
            Self::Floating => "Vout changes between samples: expected a steady level",
            Self::Timeout => "the conversion did not end within 70 ms",
            Self::CutShort => "Vout is low after the bits: expected high",
            Self::Pin => "the pin failed",
            Self::OutOfTurn => "call out of turn: expected start, then read",
        })
    }
}

impl core::error::Error for Fault {}

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

/// The longest that [`Gp2d02::measure`] waits for the end of a conversion, in µs, the time of its
/// operations not counted.
pub const WAIT_LIMIT_US: u32 = 100_000;

/// The longest that [`Gp2d02::measure`] takes, in µs.
pub const MEASURE_US: u32 = START_US + (WAIT_LIMIT_US / POLL_US) * longest(2, POLL_US) + READ_US;

/// Samples of Vout that must agree in a check.
///
/// Five samples of pure noise agree in one case of 16. A reading has three such checks and eight bits of
/// two samples each.
const SAMPLES: u32 = 5;

/// The time between two samples, in µs.
const SAMPLE_GAP_US: u32 = 20;

/// The waits in a check of Vout, in µs.
const CHECK_US: u32 = SAMPLE_GAP_US * (SAMPLES - 1);

/// Operations in a check of Vout: its samples and the waits between them.
const CHECK_OPERATIONS: u32 = 2 * SAMPLES - 1;

/// Operations of a start: Vin low, a wait, and Vin high after a fault.
const START_OPERATIONS: u32 = 3;

/// Operations of a read: two levels of Vin, three waits and two samples a bit; then Vin high, a wait, and
/// Vin high after a fault.
const READ_OPERATIONS: u32 = 8 * 7 + 3;

/// The time from Vin low until Vout must be low, in µs.
const RESPONSE_US: u32 = 200;

// With its operations each half of the clock's period takes 50 to 100 µs, as the data sheet requires.

/// The time that Vin is high before a bit, in µs.
const HIGH_US: u32 = 60;

/// The time from Vin's fall to the first sample of a bit, in µs.
const EARLY_US: u32 = 30;

/// The time from the first sample of a bit to the second, in µs.
const LATE_US: u32 = 30;

/// The time that Vin is high after the bits until Vout must idle, in µs: 2 ms plus 10 % for a fast clock.
const RECOVERY_US: u32 = 2_200;

/// The time between two polls of [`Gp2d02::measure`], in µs.
const POLL_US: u32 = 1_000;

/// The driver: `Vin` is an open-drain output, `Vout` an input with a pull-down.
///
/// After a fault Vin is high. A working sensor idles again 2 ms later; then the next
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
    /// Vin is low; a conversion runs or has ended.
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
    /// - [`Fault::StuckLow`] if Vout does not idle high; nothing is started.
    /// - [`Fault::StuckHigh`] if Vout does not go low after the start.
    /// - [`Fault::Floating`] if Vout is not steady.
    /// - [`Fault::OutOfTurn`] during a conversion, which is ended.
    /// - [`Fault::Pin`] if a pin fails.
    pub fn start(&mut self, delay: &mut impl DelayNs) -> Result<(), Fault> {
        let started = match self.state {
            State::Idle => self.request(delay),
            State::Converting => Err(Fault::OutOfTurn),
        };
        self.conclude(started, State::Converting)
    }

    /// Returns whether the conversion is over: one sample of Vout, without a wait.
    ///
    /// # Errors
    ///
    /// - [`Fault::OutOfTurn`] if no conversion was started.
    /// - [`Fault::Pin`] if the pin fails.
    pub fn ready(&mut self) -> Result<bool, Fault> {
        let ready = match self.state {
            State::Idle => Err(Fault::OutOfTurn),
            State::Converting => self.vout_is_high(),
        };
        self.conclude(ready, State::Converting)
    }

    /// Reads the byte of a finished conversion; it decreases with distance.
    ///
    /// Cost: at most [`READ_US`].
    ///
    /// # Errors
    ///
    /// - [`Fault::Timeout`] if the conversion is not over; it is abandoned.
    /// - [`Fault::Floating`] if Vout changes within a bit or a check.
    /// - [`Fault::CutShort`] if Vout does not idle high afterwards.
    /// - [`Fault::OutOfTurn`] if no conversion was started.
    /// - [`Fault::Pin`] if a pin fails.
    pub fn read(&mut self, delay: &mut impl DelayNs) -> Result<u8, Fault> {
        let byte = match self.state {
            State::Idle => Err(Fault::OutOfTurn),
            State::Converting => self.clock_out(delay),
        };
        self.conclude(byte, State::Idle)
    }

    /// Measures once and blocks until the conversion has ended.
    ///
    /// Cost: at most [`MEASURE_US`].
    ///
    /// # Errors
    ///
    /// Those of [`start`](Self::start) and [`read`](Self::read).
    pub fn measure(&mut self, delay: &mut impl DelayNs) -> Result<u8, Fault> {
        self.start(delay)?;
        for _ in 0..WAIT_LIMIT_US / POLL_US {
            if self.ready()? {
                break;
            }
            delay.delay_us(POLL_US);
        }
        self.read(delay)
    }

    /// Enters `next`; after a fault sets Vin high and enters [`State::Idle`].
    fn conclude<T>(&mut self, result: Result<T, Fault>, next: State) -> Result<T, Fault> {
        self.state = if result.is_ok() { next } else { State::Idle };
        if result.is_err() {
            // The first fault is the one to return; an error of this pin adds nothing.
            let _ = self.vin.set_high();
        }
        result
    }

    fn request(&mut self, delay: &mut impl DelayNs) -> Result<(), Fault> {
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

    /// Checks that Vout is steady at `high`; returns `otherwise` if it is steady at the other level.
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
mod tests {
    // Each transcript lists every level, every sample and every wait in the order of the protocol.

    use super::*;
    use embedded_hal_mock::eh1::MockError;
    use embedded_hal_mock::eh1::delay::{CheckedDelay, Transaction as Wait};
    use embedded_hal_mock::eh1::digital::{Mock as Pin, State as Level, Transaction as PinStep};
    use std::io::ErrorKind;

    /// What the three mocks expect.
    #[derive(Default)]
    struct Transcript {
        vin: Vec<PinStep>,
        vout: Vec<PinStep>,
        waits: Vec<Wait>,
    }

    impl Transcript {
        fn vin(mut self, level: Level) -> Self {
            self.vin.push(PinStep::set(level));
            self
        }

        fn vout(mut self, level: Level) -> Self {
            self.vout.push(PinStep::get(level));
            self
        }

        fn wait(mut self, us: u32) -> Self {
            self.waits.push(Wait::delay_us(us));
            self
        }

        /// Five samples, 20 µs apart.
        fn check(self, level: Level) -> Self {
            (1..5).fold(self.vout(level), |script, _| script.wait(20).vout(level))
        }

        fn start(self) -> Self {
            let script = self.check(Level::High).vin(Level::Low).wait(200);
            script.check(Level::Low)
        }

        fn bits(self, bits: &[Level]) -> Self {
            bits.iter().fold(self, |script, &bit| {
                let script = script.vin(Level::High).wait(60).vin(Level::Low);
                script.wait(30).vout(bit).wait(30).vout(bit)
            })
        }

        fn byte(self, byte: u8) -> Self {
            let bits = format!("{byte:08b}");
            let bits: Vec<Level> = bits
                .chars()
                .map(|bit| if bit == '1' { Level::High } else { Level::Low })
                .collect();
            self.check(Level::High)
                .bits(&bits)
                .vin(Level::High)
                .wait(2_200)
        }

        /// Runs `act` on a new driver; everything expected must have happened.
        fn run<T>(self, act: impl FnOnce(&mut Gp2d02<Pin, Pin>, &mut CheckedDelay) -> T) -> T {
            let mut delay = CheckedDelay::new(&self.waits);
            let mut sensor = Gp2d02::new(Pin::new(&self.vin), Pin::new(&self.vout));
            let result = act(&mut sensor, &mut delay);
            delay.done();
            let (mut vin, mut vout) = sensor.release();
            vin.done();
            vout.done();
            result
        }
    }

    fn script() -> Transcript {
        Transcript::default()
    }

    fn pin_error() -> MockError {
        MockError::Io(ErrorKind::NotConnected)
    }

    #[test]
    fn a_reading_follows_the_protocol_highest_bit_first() {
        for byte in [0x00, 0x80, 0x01, 0xA5, 190, 75, 0xFF] {
            let read = script()
                .start()
                .vout(Level::Low) // not ready yet
                .vout(Level::High)
                .byte(byte)
                .check(Level::High)
                .run(|sensor, delay| {
                    sensor.start(delay).unwrap();
                    assert_eq!(sensor.ready(), Ok(false));
                    assert_eq!(sensor.ready(), Ok(true));
                    sensor.read(delay)
                });
            assert_eq!(read, Ok(byte));
        }
    }

    #[test]
    fn measure_polls_every_millisecond() {
        let read = script()
            .start()
            .vout(Level::Low)
            .wait(1_000)
            .vout(Level::Low)
            .wait(1_000)
            .vout(Level::High)
            .byte(108)
            .check(Level::High)
            .run(|sensor, delay| sensor.measure(delay));
        assert_eq!(read, Ok(108));
    }

    #[test]
    fn measure_gives_up_after_100_ms_and_releases_vin() {
        let waiting = (0..100).fold(script().start(), |script, _| {
            script.vout(Level::Low).wait(1_000)
        });
        let read = waiting
            .check(Level::Low)
            .vin(Level::High)
            .run(|sensor, delay| sensor.measure(delay));
        assert_eq!(read, Err(Fault::Timeout));
    }

    #[test]
    fn vout_low_before_the_start_is_stuck_low() {
        let started = script()
            .check(Level::Low)
            .vin(Level::High)
            .run(|sensor, delay| sensor.start(delay));
        assert_eq!(started, Err(Fault::StuckLow));
    }

    #[test]
    fn vout_high_after_the_start_is_stuck_high() {
        let started = script()
            .check(Level::High)
            .vin(Level::Low)
            .wait(200)
            .check(Level::High)
            .vin(Level::High)
            .run(|sensor, delay| sensor.start(delay));
        assert_eq!(started, Err(Fault::StuckHigh));
    }

    #[test]
    fn one_different_sample_is_a_floating_line() {
        let started = script()
            .vout(Level::High)
            .wait(20)
            .vout(Level::High)
            .wait(20)
            .vout(Level::Low)
            .vin(Level::High)
            .run(|sensor, delay| sensor.start(delay));
        assert_eq!(started, Err(Fault::Floating));
    }

    #[test]
    fn a_bit_that_changes_is_a_floating_line() {
        let read = script()
            .start()
            .check(Level::High)
            .bits(&[Level::High, Level::Low])
            .vin(Level::High)
            .wait(60)
            .vin(Level::Low)
            .wait(30)
            .vout(Level::High)
            .wait(30)
            .vout(Level::Low)
            .vin(Level::High)
            .run(|sensor, delay| {
                sensor.start(delay).unwrap();
                sensor.read(delay)
            });
        assert_eq!(read, Err(Fault::Floating));
    }

    #[test]
    fn vout_low_after_the_bits_voids_them() {
        let read = script()
            .start()
            .byte(0b1010_0000)
            .check(Level::Low)
            .vin(Level::High)
            .run(|sensor, delay| {
                sensor.start(delay).unwrap();
                sensor.read(delay)
            });
        assert_eq!(read, Err(Fault::CutShort));
    }

    #[test]
    fn after_a_late_conversion_the_next_one_works() {
        let read = script()
            .start()
            .check(Level::Low)
            .vin(Level::High)
            .start()
            .byte(75)
            .check(Level::High)
            .run(|sensor, delay| {
                sensor.start(delay).unwrap();
                assert_eq!(sensor.read(delay), Err(Fault::Timeout));
                sensor.start(delay).unwrap();
                sensor.read(delay)
            });
        assert_eq!(read, Ok(75));
    }

    #[test]
    fn calls_in_the_wrong_order_are_out_of_turn() {
        script()
            .vin(Level::High)
            .vin(Level::High)
            .start()
            .vin(Level::High)
            .start()
            .run(|sensor, delay| {
                assert_eq!(sensor.read(delay), Err(Fault::OutOfTurn));
                assert_eq!(sensor.ready(), Err(Fault::OutOfTurn));
                assert_eq!(sensor.start(delay), Ok(()));
                assert_eq!(sensor.start(delay), Err(Fault::OutOfTurn));
                assert_eq!(sensor.start(delay), Ok(()));
            });
    }

    #[test]
    fn a_pin_error_is_a_fault_and_releases_vin() {
        let mut failing = script();
        failing
            .vout
            .push(PinStep::get(Level::High).with_error(pin_error()));
        let started = failing
            .vin(Level::High)
            .run(|sensor, delay| sensor.start(delay));
        assert_eq!(started, Err(Fault::Pin));

        let mut failing = script().check(Level::High);
        failing
            .vin
            .push(PinStep::set(Level::Low).with_error(pin_error()));
        failing
            .vin
            .push(PinStep::set(Level::High).with_error(pin_error()));
        let started = failing.run(|sensor, delay| sensor.start(delay));
        assert_eq!(started, Err(Fault::Pin));
    }

    #[test]
    fn each_fault_has_the_reason_of_its_kind() {
        use certainty_core::transducer::Missing;
        for fault in [
            Fault::StuckLow,
            Fault::StuckHigh,
            Fault::Floating,
            Fault::CutShort,
            Fault::Pin,
        ] {
            assert_eq!(fault.reason(), Missing::Bus, "{fault}");
        }
        for fault in [Fault::Timeout, Fault::OutOfTurn] {
            assert_eq!(fault.reason(), Missing::Timeout, "{fault}");
        }
    }

    #[test]
    fn the_stated_durations_match_the_transcripts() {
        // Each mock's step is an operation, and so is each call of a wait.
        let longest = |script: &Transcript| {
            let operations = script.vin.len() + script.vout.len() + script.waits.len();
            let mut us = 5 * operations as u32;
            for wait in [20, 30, 60, 200, 1_000, 2_200] {
                let same = Wait::delay_us(wait);
                us += wait * script.waits.iter().filter(|step| **step == same).count() as u32;
            }
            us
        };
        // The longest call is one that fails at its last check.
        let start = script()
            .check(Level::High)
            .vin(Level::Low)
            .wait(200)
            .check(Level::High)
            .vin(Level::High);
        assert_eq!(START_US, longest(&start));
        let read = script().byte(0).check(Level::Low).vin(Level::High);
        assert_eq!(READ_US, longest(&read));
        let waiting = (0..100).fold(script(), |script, _| script.vout(Level::Low).wait(1_000));
        assert_eq!(MEASURE_US, START_US + longest(&waiting) + READ_US);
    }
}
