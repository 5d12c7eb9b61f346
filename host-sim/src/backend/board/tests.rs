//! The board with programs of a few instructions, assembled by hand.

use super::elf_of::elf_of;
use super::*;
use certainty_firmware::remote::{Channel, Line};

/// Nothing on the pins.
#[derive(Debug)]
struct Bare;

impl Wires for Bare {
    fn set_level(&mut self, _: Line, _: bool, _: u64) {}

    fn level(&mut self, _: Line, _: u64) -> bool {
        false
    }

    fn set_pulse(&mut self, _: Channel, _: u32, _: u64) {}
}

/// The vectors up to `SysTick`'s; handlers in the order of their numbers, where there are any.
fn program(handlers: [u32; 15], code: &[u16]) -> Vec<u8> {
    let mut data = 0x2000_2000_u32.to_le_bytes().to_vec();
    for handler in handlers {
        data.extend(handler.to_le_bytes());
    }
    for half in code {
        data.extend(half.to_le_bytes());
    }
    elf_of(FLASH_AT, &data)
}

/// The code's first instruction is here, as a Thumb address.
const START: u32 = FLASH_AT + 0x41;

fn board(image: &[u8]) -> EmulatedBoard<Bare> {
    EmulatedBoard::new(image, Bare).unwrap()
}

/// Starts a 1 kHz `SysTick`, turns USART1 on, sleeps for ever; `SysTick`'s handler sends a byte.
fn ticking() -> Vec<u8> {
    let mut handlers = [START; 15];
    handlers[14] = START + 2 * 16; // SysTick
    let code = [
        // 0: literals are behind the code, at half-word 22
        0x4c0a, // ldr r4, [pc, #40] ; SysTick
        0x4d0b, // ldr r5, [pc, #44] ; RCC
        0x4e0b, // ldr r6, [pc, #44] ; USART1
        0x4f0c, // ldr r7, [pc, #48] ; GPIOA
        0x480c, // ldr r0, [pc, #48] ; reload
        0x6060, // str r0, [r4, #4]
        0x2007, // movs r0, #7
        0x6020, // str r0, [r4, #0]
        // 8
        0x480b, // ldr r0, [pc, #44] ; clocks
        0x61a8, // str r0, [r5, #24]
        0x2045, // movs r0, #69
        0x60b0, // str r0, [r6, #8]
        0x480a, // ldr r0, [pc, #40] ; UE and TE
        0x60f0, // str r0, [r6, #12]
        0xbf30, // wfi
        0xe7fd, // b to the wfi
        // 16: the handler
        0x20b0, // movs r0, #0xb0
        0x6078, // str r0, [r7, #4] ; PA9 is the port's
        0x202a, // movs r0, #42
        0x6070, // str r0, [r6, #4]
        0x4770, // bx lr
        0xbf00, // nop
        // 22
        0xe010, 0xe000, // SysTick
        0x1000, 0x4002, // RCC
        0x3800, 0x4001, // USART1
        0x0800, 0x4001, // GPIOA
        0x1f3f, 0x0000, // 7999
        0x4004, 0x0000, // port A and USART1
        0x2008, 0x0000, // UE and TE
    ];
    program(handlers, &code)
}

#[test]
fn a_tick_a_millisecond_wakes_the_sleeper() {
    let mut board = board(&ticking());
    for _ in 0..100 {
        board.step_ms().unwrap();
    }
    assert_eq!(board.now_ns() / 1_000_000, 100);
    // The first tick is a millisecond after the start, and a byte takes a part of one.
    assert_eq!(board.take_serial(), [42; 99]);
    assert!(board.cycles_awake() < board.cycles() / 10, "{board:?}");
    assert_eq!(board.stack_bytes(), 32); // one exception's frame
    assert_eq!(board.lowest_stack_pointer(), 0x2000_2000 - 32);
    assert_eq!(board.unmodelled(), []);
}

#[test]
fn skipping_sleep_changes_nothing_but_the_time_that_it_takes() {
    let mut skipping = board(&ticking());
    let mut stepping = board(&ticking());
    stepping.skip_sleep = false;
    for _ in 0..20 {
        skipping.step_ms().unwrap();
        stepping.step_ms().unwrap();
        assert_eq!(skipping.cycles(), stepping.cycles());
        assert_eq!(skipping.take_serial(), stepping.take_serial());
        let clock = |board: &EmulatedBoard<Bare>| board.core.with_sys(|system| system.syst_cvr);
        assert_eq!(clock(&skipping), clock(&stepping));
    }
    assert_eq!(stepping.skipped, 0);
    assert!(skipping.skipped > 19 * CYCLES_PER_MS);
}

#[test]
fn it_runs_until_what_is_waited_for_or_the_limit() {
    let mut board = board(&ticking());
    let mut sent = Vec::new();
    let done = board.run_until(50, |board| {
        sent.extend(board.take_serial());
        sent.len() == 10
    });
    assert_eq!((done, board.now_ns() / 1_000_000), (Ok(true), 11));
    assert_eq!(board.run_until(5, |_| false), Ok(false));
}

#[test]
fn an_undefined_instruction_is_a_hard_fault() {
    let mut handlers = [START; 15];
    handlers[2] = START + 2;
    let mut board = board(&program(handlers, &[0xde00, 0xe7fe])); // udf; b .
    let told = board.step_ms().unwrap_err();
    assert!(matches!(told, BoardError::HardFault { .. }), "{told}");
    assert_eq!(
        board.step_ms().unwrap_err().to_string().split(" ms").next(),
        Some("hard fault at 2")
    );
}

#[test]
fn a_fault_within_the_fault_handler_locks_up() {
    let mut handlers = [START; 15];
    handlers[2] = START;
    let mut board = board(&program(handlers, &[0xde00]));
    let told = board.step_ms().unwrap_err();
    assert!(matches!(told, BoardError::LockedUp { .. }), "{told}");
    assert!(board.is_locked_up());
}

#[test]
fn a_sleeper_that_nobody_wakes_sleeps_until_the_watchdog_bites() {
    let code = [
        0x4802, // ldr r0, [pc, #8] ; IWDG
        0x4903, // ldr r1, [pc, #12] ; the key that starts it
        0x6001, // str r1, [r0, #0]
        0xbf30, // wfi
        0xe7fd, // b to the wfi
        0xbf00, 0x3000, 0x4000, 0xcccc, 0x0000,
    ];
    let mut board = board(&program([START; 15], &code));
    let told = board.run_until(1_000, |_| false).unwrap_err();
    let BoardError::WatchdogBite { at_ns } = told else {
        panic!("{told}")
    };
    // 4096 counts of 100 µs after the first few instructions.
    assert!((409_600_000..409_610_000).contains(&at_ns), "{at_ns}");
    assert_eq!(board.step_ms(), Err(told));
}

#[test]
fn a_reset_that_the_program_asks_for_ends_the_run() {
    let code = [
        0x4801, // ldr r0, [pc, #4] ; AIRCR
        0x4902, // ldr r1, [pc, #8] ; key and SYSRESETREQ
        0x6001, // str r1, [r0, #0]
        0xe7fe, // b .
        0xed0c, 0xe000, 0x0004, 0x05fa,
    ];
    let mut board = board(&program([START; 15], &code));
    let told = board.step_ms().unwrap_err();
    assert!(matches!(told, BoardError::Reset { .. }), "{told}");
}

/// Goes round an IT block whose condition never holds while `SysTick` interrupts it ever so often.
///
/// Returns what was added up within the block; `handler` is `SysTick`'s.
fn added_in_an_it_block(handler: [u16; 3]) -> u32 {
    let mut handlers = [START; 15];
    handlers[14] = START + 2 * 13;
    let mut code = vec![
        0x4c07, // ldr r4, [pc, #28] ; SysTick
        0x2061, // movs r0, #97 ; cycles between interrupts, less one
        0x6060, // str r0, [r4, #4]
        0x2007, // movs r0, #7
        0x6020, // str r0, [r4, #0]
        0x2100, // movs r1, #0
        0x2801, // cmp r0, #1 ; it is 7
        0xbf01, // itttt eq
        0x3101, 0x3101, 0x3101, 0x3101, // four times adds r1, #1
        0xe7f8, // b to the comparison
    ];
    code.extend(handler);
    code.extend([0xe010, 0xe000]);
    let mut board = board(&program(handlers, &code));
    board.step_ms().unwrap();
    assert_eq!(board.stack_bytes(), 32, "it was not interrupted");
    board.core.reg(1)
}

#[test]
fn an_interrupt_within_an_it_block_does_not_make_its_condition_hold() {
    // bx lr
    assert_eq!(added_in_an_it_block([0x4770, 0xbf00, 0xbf00]), 0);
}

#[test]
fn nor_does_a_handler_that_returns_from_an_it_block_of_its_own() {
    // it ne; bx lr; bx lr
    assert_eq!(added_in_an_it_block([0xbf18, 0x4770, 0x4770]), 0);
}
