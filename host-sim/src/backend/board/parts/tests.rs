//! The peripherals together: clocks, pins and what hangs on them.

use super::*;
use certainty_firmware::remote::Channel;

/// Writes down what it is told; Vout 1 and Echo 0 are high.
#[derive(Debug, Default)]
struct Diary(Vec<String>);

impl Wires for Diary {
    fn set_level(&mut self, line: Line, high: bool, now_ns: u64) {
        self.0.push(format!("{line:?} {high} at {now_ns}"));
    }

    fn level(&mut self, line: Line, _: u64) -> bool {
        matches!(line, Line::Vout(1) | Line::Echo(0))
    }

    fn set_pulse(&mut self, channel: Channel, width_us: u32, now_ns: u64) {
        self.0.push(format!("{channel:?} {width_us} at {now_ns}"));
    }
}

const RCC: u32 = 0x4002_1000;
const GPIO_A: u32 = 0x4001_0800;
const GPIO_B: u32 = 0x4001_0c00;
const GPIO_C: u32 = 0x4001_1000;
const TIM3: u32 = 0x4000_0400;
const TIM4: u32 = 0x4000_0800;
const USART1: u32 = 0x4001_3800;
const IWDG: u32 = 0x4000_3000;

/// Everything clocked that the car uses.
fn clocked() -> Parts<Diary> {
    let mut parts = Parts::new(Diary::default());
    parts.write(RCC + 0x18, 0x401d, 0);
    parts.write(RCC + 0x1c, 0x6, 0);
    parts
}

#[test]
fn a_peripheral_without_its_clock_reads_zero_and_takes_nothing() {
    let mut parts = Parts::new(Diary::default());
    parts.write(GPIO_C + 0x0c, 0xffff, 0);
    assert_eq!(parts.read(GPIO_C, 0), 0);
    parts.write(RCC + 0x18, 0x10, 0);
    assert_eq!(parts.read(GPIO_C, 0), 0x4444_4444);
    assert_eq!(parts.read(GPIO_C + 0x0c, 0), 0);
    let listed: Vec<String> = parts.unmodelled().into_iter().map(|one| one.name).collect();
    assert_eq!(listed, ["GPIOC+0x00", "GPIOC+0x0c"]);
}

#[test]
fn a_reset_bit_puts_its_peripheral_back() {
    let mut parts = clocked();
    parts.write(GPIO_B, 0x3333_3333, 0);
    parts.write(RCC + 0x0c, 0x8, 0);
    parts.write(RCC + 0x0c, 0, 0);
    assert_eq!(parts.read(GPIO_B, 0), 0x4444_4444);
}

#[test]
fn an_open_drain_tells_its_edges_and_reads_its_level() {
    let mut parts = clocked();
    let vin_0 = 1 << 12;
    parts.write(GPIO_B + 0x10, vin_0, 0);
    parts.write(GPIO_B + 0x04, 0x4447_4444, 8); // PB12 open drain
    assert_eq!(parts.wires.0, [""; 0]);
    parts.write(GPIO_B + 0x14, vin_0, 16);
    assert_eq!(parts.read(GPIO_B + 0x08, 16) & vin_0, 0);
    parts.write(GPIO_B + 0x10, vin_0, 24);
    assert_eq!(parts.read(GPIO_B + 0x08, 24) & vin_0, vin_0);
    assert_eq!(
        parts.wires.0,
        ["Vin(0) false at 2000", "Vin(0) true at 3000"]
    );
    assert_eq!(parts.failure(), None);
}

#[test]
fn a_vin_that_is_driven_high_ends_the_run() {
    let mut parts = clocked();
    parts.write(GPIO_B + 0x10, 1 << 13, 0);
    parts.write(GPIO_B + 0x04, 0x4434_4444, 8_000); // PB13 push-pull
    let told = BoardError::VinDrivenHigh {
        slot: 1,
        at_ns: 1_000_000,
    };
    assert_eq!(parts.failure(), Some(&told));
    assert_eq!(parts.next_event(), 0);
    assert_eq!(
        told.to_string(),
        "Vin of sensor 2 was driven high, at 1 ms: it takes 3 V at most"
    );
}

#[test]
fn a_port_reads_the_devices_on_its_inputs_and_the_pulls_of_the_rest() {
    let mut parts = clocked();
    // PC8 pulled with nothing on it, PC10 to PC12 pulled down with Vout on them, PC13 analog.
    parts.write(GPIO_C + 0x04, 0x4408_8848, 0);
    assert_eq!(parts.read(GPIO_C + 0x08, 0) & 0x7f00, 1 << 11);
    parts.write(GPIO_C + 0x0c, 1 << 8, 0);
    assert_eq!(parts.read(GPIO_C + 0x08, 0) & 0x7f00, 1 << 11 | 1 << 8);
    assert_eq!(parts.read(GPIO_B + 0x08, 0), 1 << 10 | 0b111 << 12);
}

#[test]
fn a_trigger_is_told_when_it_goes_up_and_comes_down() {
    let mut parts = clocked();
    parts.write(GPIO_C, 0x4444_4432, 0); // PC1 push-pull
    parts.write(GPIO_C + 0x10, 2, 8);
    parts.write(GPIO_C + 0x10, 2 << 16, 88);
    assert_eq!(
        parts.wires.0,
        ["Trigger(1) true at 1000", "Trigger(1) false at 11000"]
    );
}

#[test]
fn a_servo_gets_pulses_once_its_pin_is_the_timers() {
    let mut parts = clocked();
    for (register, value) in [(0x18, 0x6868), (0x20, 0x11), (0x28, 7), (0x2c, 19_999)] {
        parts.write(TIM3 + register, value, 0);
    }
    parts.write(TIM3 + 0x38, 1_234, 0);
    parts.write(TIM3 + 0x14, 1, 0);
    parts.write(TIM3, 0x81, 0);
    assert_eq!(parts.wires.0, [""; 0]);
    parts.write(GPIO_A, 0xb444_4444, 80); // PA7
    parts.write(TIM3 + 0x38, 2_000, 160);
    assert_eq!(parts.next_event(), 160_000);
    parts.advance(160_000);
    assert_eq!(
        parts.wires.0,
        ["Servo(1) 1234 at 10000", "Servo(1) 2000 at 20000000"]
    );
}

#[test]
fn the_motors_have_a_timer_and_a_clock_of_their_own() {
    let mut parts = clocked();
    parts.write(GPIO_B, 0xb444_4444, 0); // PB7
    for (register, value) in [(0x18, 0x6868), (0x20, 0x11), (0x28, 7), (0x2c, 19_999)] {
        parts.write(TIM4 + register, value, 0);
    }
    parts.write(TIM4 + 0x38, 1_600, 0);
    parts.write(TIM4 + 0x14, 1, 0);
    parts.write(TIM4, 0x81, 8);
    assert_eq!(parts.wires.0, ["Motor(1) 1600 at 1000"]);
    parts.write(RCC + 0x1c, 0x2, 16); // TIM3's clock only
    parts.write(TIM4 + 0x38, 1_700, 24);
    assert_eq!(parts.next_event(), u64::MAX);
}

#[test]
fn a_pulse_is_told_to_the_nearest_microsecond() {
    let mut parts = clocked();
    parts.write(GPIO_A, 0x4b44_4444, 0); // PA6
    for (register, value) in [(0x18, 0x60), (0x20, 1), (0x28, 2), (0x2c, 53_332)] {
        parts.write(TIM3 + register, value, 0);
    }
    parts.write(TIM3 + 0x14, 1, 0);
    parts.write(TIM3, 1, 0);
    parts.write(TIM3 + 0x34, 4_001, 0); // 1500.375 µs
    parts.write(TIM3 + 0x34, 4_002, 8); // 1500.75 µs
    assert_eq!(
        parts.wires.0,
        ["Servo(0) 1500 at 0", "Servo(0) 1501 at 1000"]
    );
}

#[test]
fn serial_bytes_leave_on_the_pin_that_is_the_ports() {
    let mut parts = clocked();
    parts.write(USART1 + 0x08, 69, 0);
    parts.write(USART1 + 0x0c, 0x2008, 0);
    parts.write(USART1 + 0x04, 1, 0);
    parts.advance(1_000);
    parts.write(GPIO_A + 0x04, 0x4444_44b4, 1_000); // PA9
    parts.write(USART1 + 0x04, 2, 1_000);
    assert_eq!(parts.next_event(), 1_690);
    parts.advance(1_690);
    assert_eq!(parts.take_serial(), [2]);
    assert_eq!(parts.take_serial(), [0; 0]);
}

#[test]
fn the_watchdogs_bite_is_told_with_its_time() {
    let mut parts = clocked();
    parts.write(IWDG, 0xcccc, 0);
    assert_eq!(parts.next_event(), 3_276_800);
    parts.advance(3_276_799);
    assert_eq!(parts.failure(), None);
    parts.advance(3_280_000);
    let bite = BoardError::WatchdogBite { at_ns: 409_600_000 };
    assert_eq!(parts.failure(), Some(&bite));
    assert_eq!(
        bite.to_string(),
        "the watchdog bit at 409 ms: it was not fed"
    );
}
