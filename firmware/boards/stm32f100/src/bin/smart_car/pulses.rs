//! The servos' pulses, TIM3's channels 1 to 3, and the motors', TIM4's 1 and 2: 50 Hz in steps of a
//! microsecond.

use core::convert::Infallible;
use core::ops::Deref;
use embedded_hal::pwm::{ErrorType, SetDutyCycle};
use stm32f1xx_hal::pac::tim2::RegisterBlock;
use stm32f1xx_hal::pac::{TIM3, TIM4};

/// Microseconds from one pulse to the next.
const PERIOD_US: u16 = 20_000;

/// Both timers, which are shared by their channels.
pub(crate) struct Timers {
    servos: TIM3,
    motors: TIM4,
}

impl Timers {
    /// Sets the timers up; their clocks must run already, and their pins be their own.
    ///
    /// They stand still until the first pulse of all is asked for, and then begin together. So the periods of
    /// both keep step with the schedule, and no pulse comes before a servo was told where to turn, or a motor
    /// how fast: its length is zero until then.
    pub(crate) fn new(servos: TIM3, motors: TIM4) -> Self {
        set_up(&servos);
        set_up(&motors);
        Self { servos, motors }
    }

    /// Returns the servos' channels, in their order.
    pub(crate) fn servos(&self) -> [Pulses<'_>; 3] {
        [Channel::One, Channel::Two, Channel::Three].map(|channel| Pulses {
            timers: self,
            timer: &self.servos,
            channel,
        })
    }

    /// Returns the motors' channels: right, left.
    pub(crate) fn motors(&self) -> [Pulses<'_>; 2] {
        [Channel::One, Channel::Two].map(|channel| Pulses {
            timers: self,
            timer: &self.motors,
            channel,
        })
    }

    /// Starts both, once.
    fn start(&self) {
        let timers: [&RegisterBlock; 2] = [&self.servos, &self.motors];
        if self.servos.cr1().read().cen().is_disabled() {
            for timer in timers {
                // The update takes over what was set up.
                timer.egr().write(|w| w.ug().update());
                timer.cr1().write(|w| w.arpe().enabled().cen().enabled());
            }
        }
    }
}

/// Pulses on channels 1 to 3, at a microsecond a step.
fn set_up(timer: &impl Deref<Target = RegisterBlock>) {
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
}

enum Channel {
    One,
    Two,
    Three,
}

/// A channel; its duty is the pulse in microseconds.
pub(crate) struct Pulses<'a> {
    timers: &'a Timers,
    timer: &'a RegisterBlock,
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
        self.timers.start();
        Ok(())
    }
}
