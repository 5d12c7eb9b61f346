//! The servos' pulses: TIM3's channels 1 to 3, 50 Hz in steps of a microsecond.

use core::convert::Infallible;
use embedded_hal::pwm::{ErrorType, SetDutyCycle};
use stm32f1xx_hal::pac::TIM3;

/// Microseconds from one pulse to the next.
const PERIOD_US: u16 = 20_000;

/// The timer, which is shared by its channels.
pub(crate) struct Timer(TIM3);

impl Timer {
    /// Sets the timer up; its clock must run already, and its pins be its own.
    ///
    /// It stands still until the first pulse is asked for. So the periods keep step with the schedule,
    /// and no pulse comes before a servo was told where to turn.
    pub(crate) fn new(timer: TIM3) -> Self {
        timer.psc().write(|w| w.psc().set(8 - 1)); // 8 MHz to 1 MHz
        timer.arr().write(|w| w.arr().set(PERIOD_US - 1));
        // A new width begins with the next pulse: none is ever cut short.
        timer.ccmr1_output().write(|w| {
            w.oc1m().pwm_mode1().oc1pe().enabled();
            w.oc2m().pwm_mode1().oc2pe().enabled()
        });
        timer
            .ccmr2_output()
            .write(|w| w.oc3m().pwm_mode1().oc3pe().enabled());
        timer
            .ccer()
            .write(|w| w.cc1e().set_bit().cc2e().set_bit().cc3e().set_bit());
        Self(timer)
    }

    /// Returns the channels, in their order.
    pub(crate) const fn channels(&self) -> [Pulses<'_>; 3] {
        let timer = &self.0;
        [
            Pulses {
                timer,
                channel: Channel::One,
            },
            Pulses {
                timer,
                channel: Channel::Two,
            },
            Pulses {
                timer,
                channel: Channel::Three,
            },
        ]
    }
}

enum Channel {
    One,
    Two,
    Three,
}

/// A servo's channel; its duty is the pulse in microseconds.
pub(crate) struct Pulses<'a> {
    timer: &'a TIM3,
    channel: Channel,
}

impl ErrorType for Pulses<'_> {
    type Error = Infallible;
}

impl SetDutyCycle for Pulses<'_> {
    fn max_duty_cycle(&self) -> u16 {
        PERIOD_US
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        let compare = match self.channel {
            Channel::One => self.timer.ccr1(),
            Channel::Two => self.timer.ccr2(),
            Channel::Three => self.timer.ccr3(),
        };
        compare.write(|w| w.ccr().set(duty));
        if self.timer.cr1().read().cen().is_disabled() {
            // The update takes over what was set up.
            self.timer.egr().write(|w| w.ug().update());
            self.timer
                .cr1()
                .write(|w| w.arpe().enabled().cen().enabled());
        }
        Ok(())
    }
}
