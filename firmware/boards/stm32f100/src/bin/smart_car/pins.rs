//! Pins and pulse channels; the table of pins is in `docs/hardware.md`.

use crate::clock::{Light, Time};
use crate::serial::SerialOutbox;
use certainty_firmware::board::{Board, HeadWires, MotorWires, RangerWires, ResetCause, Wiring};
use certainty_firmware::smart_car::{HEADS, RANGERS};
use core::convert::Infallible;
use core::marker::PhantomData;
use core::ops::Deref;
use embedded_hal::pwm::{ErrorType, SetDutyCycle};
use stm32f1xx_hal::gpio::{
    GpioExt, Input, OpenDrain, Output, PB10, PB11, PB12, PB13, PB14, PC0, PC1, PC10, PC11, PC12,
    PinState, PullDown, PushPull,
};
use stm32f1xx_hal::pac::tim2::RegisterBlock;
use stm32f1xx_hal::pac::{GPIOA, GPIOB, GPIOC, RCC, TIM3, TIM4};
use stm32f1xx_hal::rcc::RccExt;

/// Defines an enum of pins in the same mode that implements that mode's trait, so that pins fit an array.
///
/// The HAL has such a type with a pin number at run time; it panics for a number above 15, and this image
/// must not contain a panic.
macro_rules! any_of {
    ($(#[$doc:meta])* $name:ident: Output<$mode:ty> = $($pin:ident)|+) => {
        $(#[$doc])*
        pub(crate) enum $name { $($pin($pin<Output<$mode>>)),+ }

        impl embedded_hal::digital::ErrorType for $name {
            type Error = core::convert::Infallible;
        }

        impl embedded_hal::digital::OutputPin for $name {
            fn set_low(&mut self) -> Result<(), Self::Error> {
                match self { $(Self::$pin(pin) => pin.set_low()),+ }
                Ok(())
            }

            fn set_high(&mut self) -> Result<(), Self::Error> {
                match self { $(Self::$pin(pin) => pin.set_high()),+ }
                Ok(())
            }
        }
    };
    ($(#[$doc:meta])* $name:ident: Input<$mode:ty> = $($pin:ident)|+) => {
        $(#[$doc])*
        pub(crate) enum $name { $($pin($pin<Input<$mode>>)),+ }

        impl embedded_hal::digital::ErrorType for $name {
            type Error = core::convert::Infallible;
        }

        impl embedded_hal::digital::InputPin for $name {
            fn is_high(&mut self) -> Result<bool, Self::Error> {
                match self { $(Self::$pin(pin) => pin.is_high()),+ }
            }

            fn is_low(&mut self) -> Result<bool, Self::Error> {
                match self { $(Self::$pin(pin) => pin.is_low()),+ }
            }
        }
    };
}

any_of! {
    /// Open drain: a GP2D02 takes 3 V at most on its Vin and has the pull-up.
    Vin: Output<OpenDrain> = PB12 | PB13 | PB14
}

any_of! {
    /// 5 V tolerant; pulled down, so that an unplugged sensor reads low.
    Vout: Input<PullDown> = PC10 | PC11 | PC12
}

any_of! {
    /// Input of a ranger, for which 3 V are high.
    Trigger: Output<PushPull> = PC0 | PC1
}

any_of! {
    /// 5 V tolerant; pulled down, so that an unplugged ranger reads low.
    Echo: Input<PullDown> = PB10 | PB11
}

/// The board: an STM32F100RB with the car's devices on its pins.
pub(crate) struct Stm32f100<'a>(PhantomData<&'a ()>);

impl<'a> Board for Stm32f100<'a> {
    type Vin = Vin;
    type Vout = Vout;
    type Pwm = Pulses<'a>;
    type Motor = Pulses<'a>;
    type Trigger = Trigger;
    type Echo = Echo;
    type Delay = Time;
    type Stopwatch = Time;
    type Outbox = SerialOutbox;
}

/// The configured pins.
pub(crate) struct Pins {
    pub(crate) lines: Lines,
    pub(crate) heartbeat: Light,
    /// What started the microcontroller.
    pub(crate) reset_cause: ResetCause,
}

/// The pins of the sensors.
pub(crate) struct Lines {
    vin: [Vin; HEADS as usize],
    vout: [Vout; HEADS as usize],
    trigger: [Trigger; RANGERS as usize],
    echo: [Echo; RANGERS as usize],
}

/// Sets every pin's mode and enables the clocks of all peripherals that the car uses.
///
/// The microcontroller stays on its internal 8 MHz oscillator, and every peripheral on its default pins.
pub(crate) fn set_up(rcc: RCC, ports: (GPIOA, GPIOB, GPIOC)) -> Pins {
    let reset_cause = take_reset_cause(&rcc);
    let mut rcc = rcc.constrain();
    rcc.apb2enr().modify(|_, w| w.usart1en().enabled());
    rcc.apb1enr()
        .modify(|_, w| w.tim3en().enabled().tim4en().enabled());
    let mut a = ports.0.split(&mut rcc);
    let mut b = ports.1.split(&mut rcc);
    let mut c = ports.2.split(&mut rcc);
    // The pins of servos, motors and the serial output belong to their peripherals.
    a.pa6.into_alternate_push_pull(&mut a.crl);
    a.pa7.into_alternate_push_pull(&mut a.crl);
    b.pb0.into_alternate_push_pull(&mut b.crl);
    b.pb6.into_alternate_push_pull(&mut b.crl);
    b.pb7.into_alternate_push_pull(&mut b.crl);
    a.pa9.into_alternate_push_pull(&mut a.crh);
    let high = PinState::High;
    let vin = [
        Vin::PB12(b.pb12.into_open_drain_output_with_state(&mut b.crh, high)),
        Vin::PB13(b.pb13.into_open_drain_output_with_state(&mut b.crh, high)),
        Vin::PB14(b.pb14.into_open_drain_output_with_state(&mut b.crh, high)),
    ];
    let vout = [
        Vout::PC10(c.pc10.into_pull_down_input(&mut c.crh)),
        Vout::PC11(c.pc11.into_pull_down_input(&mut c.crh)),
        Vout::PC12(c.pc12.into_pull_down_input(&mut c.crh)),
    ];
    let trigger = [
        Trigger::PC0(c.pc0.into_push_pull_output(&mut c.crl)),
        Trigger::PC1(c.pc1.into_push_pull_output(&mut c.crl)),
    ];
    let echo = [
        Echo::PB10(b.pb10.into_pull_down_input(&mut b.crh)),
        Echo::PB11(b.pb11.into_pull_down_input(&mut b.crh)),
    ];
    Pins {
        lines: Lines {
            vin,
            vout,
            trigger,
            echo,
        },
        heartbeat: c.pc9.into_push_pull_output(&mut c.crh),
        reset_cause,
    }
}

/// Reads the cause of the reset and clears its flags.
///
/// The flags stay set until they are cleared or the power is switched off; without clearing them the next
/// press of the reset button would look like the reset before it. Every reset sets the flag of the reset pin,
/// so that flag is not used.
fn take_reset_cause(rcc: &RCC) -> ResetCause {
    let flags = rcc.csr().read();
    rcc.csr().modify(|_, w| w.rmvf().set_bit());
    let automatic = flags.iwdgrstf().bit_is_set()
        || flags.wwdgrstf().bit_is_set()
        || flags.sftrstf().bit_is_set()
        || flags.lpwrrstf().bit_is_set();
    if automatic {
        ResetCause::Automatic
    } else {
        ResetCause::Manual
    }
}

impl Lines {
    /// Returns the application's wiring.
    pub(crate) fn wire<'a>(
        self,
        servos: [Pulses<'a>; HEADS as usize],
        [right, left]: [Pulses<'a>; 2],
        outbox: SerialOutbox,
        reset_cause: ResetCause,
    ) -> Wiring<Stm32f100<'a>, { HEADS as usize }, { RANGERS as usize }> {
        let [vin_1, vin_2, vin_3] = self.vin;
        let [vout_1, vout_2, vout_3] = self.vout;
        let [pwm_1, pwm_2, pwm_3] = servos;
        let [trigger_1, trigger_2] = self.trigger;
        let [echo_1, echo_2] = self.echo;
        let head = |vin, vout, pwm| HeadWires { vin, vout, pwm };
        let ranger = |trigger, echo| RangerWires { trigger, echo };
        Wiring {
            heads: [
                head(vin_1, vout_1, pwm_1),
                head(vin_2, vout_2, pwm_2),
                head(vin_3, vout_3, pwm_3),
            ],
            rangers: [ranger(trigger_1, echo_1), ranger(trigger_2, echo_2)],
            motors: MotorWires { right, left },
            delay: Time,
            stopwatch: Time,
            outbox,
            reset_cause,
        }
    }
}

/// The time from one pulse to the next, in µs: 50 Hz.
const PERIOD_US: u16 = 20_000;

/// Both timers, shared by their channels: the servos' TIM3 (channels 1 to 3) and the motors' TIM4 (1 and 2).
pub(crate) struct Timers {
    servos: TIM3,
    motors: TIM4,
}

impl Timers {
    /// Configures the timers; their clocks must be enabled and their pins configured.
    ///
    /// The timers start together when the first pulse width is set, so the periods of both are in step with the
    /// schedule. A channel's width is zero until it is set, so no servo or motor gets a pulse before that.
    pub(crate) fn new(servos: TIM3, motors: TIM4) -> Self {
        configure(&servos);
        configure(&motors);
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

    /// Starts both timers; later calls do nothing.
    fn start(&self) {
        let timers: [&RegisterBlock; 2] = [&self.servos, &self.motors];
        if self.servos.cr1().read().cen().is_disabled() {
            for timer in timers {
                // The update event loads the configuration.
                timer.egr().write(|w| w.ug().update());
                timer.cr1().write(|w| w.arpe().enabled().cen().enabled());
            }
        }
    }
}

/// Configures channels 1 to 3 for pulses in steps of a microsecond.
fn configure(timer: &impl Deref<Target = RegisterBlock>) {
    timer.psc().write(|w| w.psc().set(8 - 1)); // 8 MHz to 1 MHz
    timer.arr().write(|w| w.arr().set(PERIOD_US - 1));
    // A new width takes effect in the next period, so no pulse is cut short.
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

/// A channel; its duty is the pulse width in microseconds.
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
