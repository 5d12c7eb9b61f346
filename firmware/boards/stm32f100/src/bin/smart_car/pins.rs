//! Which pin is what; the same table is in `docs/hardware.md`.

use crate::any_of::any_of;
use crate::clock::Time;
use crate::pulses::Pulses;
use crate::serial::SerialOutbox;
use crate::watchdog::Light;
use certainty_firmware::board::{Board, HeadWires, MotorWires, RangerWires, Start, Wiring};
use certainty_firmware::smart_car::{HEADS, RANGERS};
use core::marker::PhantomData;
use stm32f1xx_hal::gpio::{
    GpioExt, Input, OpenDrain, Output, PB10, PB11, PB12, PB13, PB14, PC0, PC1, PC10, PC11, PC12,
    PinState, PullDown, PushPull,
};
use stm32f1xx_hal::pac::{GPIOA, GPIOB, GPIOC, RCC};
use stm32f1xx_hal::rcc::RccExt;

any_of! {
    /// Open drain: a GP2D02 takes 3 V at most on its Vin, and pulls it up itself.
    Vin: Output<OpenDrain> = PB12 | PB13 | PB14
}

any_of! {
    /// 5 V tolerant; pulled down, so that an unplugged sensor reads low.
    Vout: Input<PullDown> = PC10 | PC11 | PC12
}

any_of! {
    /// To a ranger, which takes 3 V as high.
    Trigger: Output<PushPull> = PC0 | PC1
}

any_of! {
    /// 5 V tolerant; pulled down, so that an unplugged ranger reads low.
    Echo: Input<PullDown> = PB10 | PB11
}

/// The STM32F100RB with the car's devices on its pins.
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

/// The pins, each in its mode.
pub(crate) struct Pins {
    pub(crate) lines: Lines,
    pub(crate) heartbeat: Light,
    /// Who started the microcontroller.
    pub(crate) start: Start,
}

/// Those to the sensors.
pub(crate) struct Lines {
    vin: [Vin; HEADS as usize],
    vout: [Vout; HEADS as usize],
    trigger: [Trigger; RANGERS as usize],
    echo: [Echo; RANGERS as usize],
}

/// Sets every pin's mode, and starts the clocks of all peripherals that the car uses.
///
/// All stays on the internal 8 MHz oscillator, on which the microcontroller wakes up, and every
/// peripheral comes out where it does by itself.
pub(crate) fn set_up(rcc: RCC, ports: (GPIOA, GPIOB, GPIOC)) -> Pins {
    let start = started(&rcc);
    let mut rcc = rcc.constrain();
    rcc.apb2enr().modify(|_, w| w.usart1en().enabled());
    rcc.apb1enr()
        .modify(|_, w| w.tim3en().enabled().tim4en().enabled());
    let mut a = ports.0.split(&mut rcc);
    let mut b = ports.1.split(&mut rcc);
    let mut c = ports.2.split(&mut rcc);
    // Servos, motors and the serial line's output stay with their peripherals for good.
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
        start,
    }
}

/// Tells who started the microcontroller, and forgets it: the flags stay until they are cleared or the power goes, and
/// the next press of the button would pass for what was before it.
///
/// Every reset pulls the reset pin, so that the flag of that pin says nothing.
fn started(rcc: &RCC) -> Start {
    let flags = rcc.csr().read();
    rcc.csr().modify(|_, w| w.rmvf().set_bit());
    let by_itself = flags.iwdgrstf().bit_is_set()
        || flags.wwdgrstf().bit_is_set()
        || flags.sftrstf().bit_is_set()
        || flags.lpwrrstf().bit_is_set();
    if by_itself {
        Start::ByItself
    } else {
        Start::ByHand
    }
}

impl Lines {
    /// Puts together what the application is wired to.
    pub(crate) fn wire<'a>(
        self,
        servos: [Pulses<'a>; HEADS as usize],
        [right, left]: [Pulses<'a>; 2],
        outbox: SerialOutbox,
        start: Start,
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
            start,
        }
    }
}
