//! TIM3 and TIM4: a counter and the pulses of its channels CH1 to CH3 (PWM mode 1, counting up).

/// The emulated channels.
const CHANNELS: usize = 3;

const COUNTS: u32 = 1; // CR1.CEN
const BUFFERED_RELOAD: u32 = 1 << 7; // CR1.ARPE
const UPDATE: u32 = 1; // EGR.UG

/// A register with a buffer: the counter uses `active`, the program writes `buffer`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Buffered {
    buffer: u32,
    active: u32,
}

impl Buffered {
    const fn write(&mut self, value: u32, at_once: bool) {
        self.buffer = value & 0xffff;
        if at_once {
            self.load();
        }
    }

    const fn load(&mut self) {
        self.active = self.buffer;
    }
}

/// The timer's registers and its counter.
#[derive(Debug)]
pub(crate) struct PwmTimer {
    cr1: u32,
    /// CCMR1 and CCMR2: eight bits a channel.
    modes: u32,
    ccer: u32,
    prescaler: Buffered,
    reload: Buffered,
    compare: [Buffered; CHANNELS],
    compare_4: u32,
    /// The cycle of the last update event; not used while the counter is off.
    period_began: u64,
    /// What CNT reads while the counter is off.
    halted_at: u32,
}

impl Default for PwmTimer {
    fn default() -> Self {
        let full = Buffered {
            buffer: 0xffff,
            active: 0xffff,
        };
        Self {
            cr1: 0,
            modes: 0,
            ccer: 0,
            prescaler: Buffered::default(),
            reload: full,
            compare: [Buffered::default(); CHANNELS],
            compare_4: 0,
            period_began: 0,
            halted_at: 0,
        }
    }
}

impl PwmTimer {
    pub(crate) fn read(&self, offset: u32, now: u64) -> Option<u32> {
        Some(match offset {
            0x00 => self.cr1,
            0x14 => 0, // EGR is write-only
            0x18 => self.modes & 0xffff,
            0x1c => self.modes >> 16,
            0x20 => self.ccer,
            0x24 => self.count(now),
            0x28 => self.prescaler.buffer,
            0x2c => self.reload.buffer,
            0x34 | 0x38 | 0x3c => self.compare[channel(offset)].buffer,
            0x40 => self.compare_4,
            _ => return None,
        })
    }

    /// Returns whether there is such a register.
    pub(crate) fn write(&mut self, offset: u32, value: u32, now: u64) -> bool {
        self.advance(now);
        match offset {
            0x00 => self.set_cr1(value, now),
            0x14 => {
                if value & UPDATE != 0 {
                    self.update(now);
                    self.halted_at = 0;
                }
            }
            0x18 => self.modes = self.modes >> 16 << 16 | value & 0xffff,
            0x1c => self.modes = self.modes & 0xffff | value << 16,
            0x20 => self.ccer = value,
            0x24 => {
                self.halted_at = value & 0xffff;
                self.period_began = now.saturating_sub(self.cycles(self.halted_at));
            }
            0x28 => self.prescaler.write(value, false),
            0x2c => self.reload.write(value, self.cr1 & BUFFERED_RELOAD == 0),
            0x34 | 0x38 | 0x3c => {
                let channel = channel(offset);
                let at_once = self.mode(channel) & 0x08 == 0; // OCxPE
                self.compare[channel].write(value, at_once);
            }
            0x40 => self.compare_4 = value & 0xffff,
            _ => return false,
        }
        true
    }

    fn set_cr1(&mut self, value: u32, now: u64) {
        let halted_at = self.count(now);
        let was_counting = self.counting();
        self.cr1 = value;
        match (was_counting, self.counting()) {
            (false, true) => self.period_began = now.saturating_sub(self.cycles(halted_at)),
            (true, false) => self.halted_at = halted_at,
            _ => {}
        }
    }

    const fn counting(&self) -> bool {
        self.cr1 & COUNTS != 0
    }

    /// The eight mode bits of a channel.
    const fn mode(&self, channel: usize) -> u32 {
        self.modes >> (8 * channel) & 0xff
    }

    /// The cycles that `counts` take.
    fn cycles(&self, counts: u32) -> u64 {
        u64::from(counts) * (u64::from(self.prescaler.active) + 1)
    }

    fn period(&self) -> u64 {
        self.cycles(self.reload.active + 1)
    }

    fn count(&self, now: u64) -> u32 {
        if !self.counting() {
            return self.halted_at;
        }
        let since = now.saturating_sub(self.period_began) % self.period();
        // Less than a period of at most 0x10000 counts.
        (since / (u64::from(self.prescaler.active) + 1)) as u32
    }

    /// When buffers that differ from the active values will be loaded.
    pub(crate) fn next_event(&self) -> Option<u64> {
        let differs = |register: &Buffered| register.buffer != register.active;
        let waiting =
            differs(&self.prescaler) || differs(&self.reload) || self.compare.iter().any(differs);
        (waiting && self.counting()).then(|| self.period_began + self.period())
    }

    /// Loads the buffers at the end of each period up to `now`.
    ///
    /// Returns the last cycle in which a load changed something, if any.
    pub(crate) fn advance(&mut self, now: u64) -> Option<u64> {
        if !self.counting() {
            return None;
        }
        let mut last = None;
        if let Some(loads) = self.next_event().filter(|&loads| loads <= now) {
            self.update(loads);
            last = Some(loads);
        }
        // Nothing changes in the periods after that.
        let over = now.saturating_sub(self.period_began) / self.period();
        self.period_began += over * self.period();
        last
    }

    fn update(&mut self, at: u64) {
        self.prescaler.load();
        self.reload.load();
        self.compare.iter_mut().for_each(Buffered::load);
        self.period_began = at;
    }

    /// The cycles of each period in which channel `channel`, from 0, is high; 0 where it gives no pulses.
    pub(crate) fn pulse_cycles(&self, channel: usize) -> u64 {
        let enabled = self.ccer >> (4 * channel) & 0b11 == 0b01; // on, active high
        let pwm_mode_1 = self.mode(channel) & 0x73 == 0x60; // OCxM, and CCxS an output
        if self.counting() && enabled && pwm_mode_1 {
            self.cycles(self.compare[channel].active.min(self.reload.active + 1))
        } else {
            0
        }
    }
}

/// The channel of a compare register at `offset`.
const fn channel(offset: u32) -> usize {
    ((offset - 0x34) / 4) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 50 Hz in microseconds out of 8 MHz, all buffered, all three channels on.
    fn servo_timer() -> PwmTimer {
        let mut timer = PwmTimer::default();
        timer.write(0x18, 0x6868, 0);
        timer.write(0x1c, 0x0068, 0);
        timer.write(0x20, 0x0111, 0);
        timer.write(0x28, 7, 0);
        timer.write(0x2c, 19_999, 0);
        timer.write(0x34, 1_500, 0);
        timer.write(0x14, 1, 0);
        timer.write(0x00, 0x81, 0);
        timer
    }

    const PERIOD: u64 = 160_000; // 20 ms

    #[test]
    fn a_pulse_lasts_the_counts_of_its_compare_register() {
        let timer = servo_timer();
        assert_eq!(timer.pulse_cycles(0), 12_000); // 1500 µs
        assert_eq!(timer.pulse_cycles(1), 0);
    }

    #[test]
    fn a_new_pulse_begins_with_the_next_period() {
        let mut timer = servo_timer();
        timer.write(0x34, 1_000, 5 * PERIOD + 1);
        assert_eq!(timer.next_event(), Some(6 * PERIOD));
        assert_eq!(timer.advance(6 * PERIOD - 1), None);
        assert_eq!(timer.pulse_cycles(0), 12_000);
        assert_eq!(timer.advance(6 * PERIOD + 10), Some(6 * PERIOD));
        assert_eq!(timer.pulse_cycles(0), 8_000);
        assert_eq!(timer.next_event(), None);
    }

    #[test]
    fn without_a_buffer_a_pulse_changes_at_once() {
        let mut timer = servo_timer();
        timer.write(0x18, 0x6060, 10);
        timer.write(0x38, 2_000, 10);
        assert_eq!(timer.pulse_cycles(1), 16_000);
        // Longer than the period: always high.
        timer.write(0x38, 30_000, 10);
        assert_eq!(timer.pulse_cycles(1), PERIOD);
    }

    #[test]
    fn no_pulses_while_channel_or_counter_is_off() {
        let mut timer = servo_timer();
        timer.write(0x20, 0x0110, 10);
        assert_eq!(timer.pulse_cycles(0), 0);
        timer.write(0x20, 0x0111, 10);
        timer.write(0x18, 0x6878, 10); // PWM mode 2 is the inverse
        assert_eq!(timer.pulse_cycles(0), 0);
        timer.write(0x18, 0x6868, 10);
        timer.write(0x00, 0x80, 10);
        assert_eq!(timer.pulse_cycles(0), 0);
    }

    #[test]
    fn a_stopped_counter_keeps_its_count() {
        let mut timer = servo_timer();
        assert_eq!(timer.read(0x24, 8 * 123 + 7), Some(123));
        assert_eq!(timer.read(0x24, PERIOD - 1), Some(19_999));
        assert_eq!(timer.read(0x24, 3 * PERIOD), Some(0));
        timer.write(0x00, 0x80, 3 * PERIOD + 80);
        assert_eq!(timer.read(0x24, 3 * PERIOD + 8_000), Some(10));
        timer.write(0x00, 0x81, 4 * PERIOD);
        assert_eq!(timer.read(0x24, 4 * PERIOD + 8), Some(11));
    }
}
