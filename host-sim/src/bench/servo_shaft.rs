//! A servo as its pulses turn it.

use super::MILLISECOND;
use certainty_core::units::BinaryAngle;
use certainty_firmware::servo::ServoConfig;

/// The shaft of a simulated servo: turns at its speed to where the pulses say.
///
/// It obeys each pulse at once and stops at the ends of its range, which are those of its shortest
/// and longest pulse.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ServoShaft {
    config: ServoConfig,
    /// Where it was when it was last told something, in 2^-32 of a turn.
    from: i64,
    /// Where it turns to, in 2^-32 of a turn.
    to: i64,
    since_ns: u64,
    jammed: bool,
}

/// Fraction bits of a place below a step of [`BinaryAngle`].
const FINER: u32 = 16;

impl ServoShaft {
    /// Creates a servo that stands at the angle of `pulse_us`, with the numbers of `config`, which
    /// must be those of a [`ServoModel`](certainty_firmware::servo::ServoModel).
    #[must_use]
    pub fn new(config: ServoConfig, pulse_us: u32) -> Self {
        let at = place(&config, pulse_us);
        Self {
            config,
            from: at,
            to: at,
            since_ns: 0,
            jammed: false,
        }
    }

    /// Sets the length of the pulses; 0 is none, and the shaft stays where it is.
    pub fn set_pulse(&mut self, pulse_us: u32, now_ns: u64) {
        self.from = self.place_at(now_ns);
        self.since_ns = now_ns;
        self.to = match pulse_us {
            0 => self.from,
            pulse_us => place(&self.config, pulse_us),
        };
    }

    /// Jams the shaft, which stays where it is then, or frees it, which goes where it was sent.
    pub fn set_jammed(&mut self, jammed: bool, now_ns: u64) {
        self.from = self.place_at(now_ns);
        self.since_ns = now_ns;
        self.jammed = jammed;
    }

    /// Says whether the shaft is jammed.
    #[must_use]
    pub const fn is_jammed(&self) -> bool {
        self.jammed
    }

    /// Returns the angle of the shaft, counter-clockwise from straight ahead.
    ///
    /// Rounds to the nearest step of the angle, ties up.
    #[must_use]
    pub fn angle(&self, now_ns: u64) -> BinaryAngle {
        let steps = (self.place_at(now_ns) + (1 << (FINER - 1))) >> FINER;
        BinaryAngle::from_bits(steps as u16)
    }

    /// Says whether the shaft has arrived.
    #[must_use]
    pub fn is_settled(&self, now_ns: u64) -> bool {
        self.place_at(now_ns) == self.to
    }

    fn place_at(&self, now_ns: u64) -> i64 {
        if self.jammed {
            return self.from;
        }
        let sixth_ns = u128::from(self.config.sixth_ms) * u128::from(MILLISECOND);
        let elapsed_ns = u128::from(now_ns.saturating_sub(self.since_ns));
        let travelled = (elapsed_ns << 32) / (6 * sixth_ns);
        let way = self.to - self.from;
        if travelled >= u128::from(way.unsigned_abs()) {
            self.to
        } else {
            self.from + way.signum() * travelled as i64
        }
    }
}

/// Returns the pulse in whole µs whose duty cycle is `duty` of `full`, at a period of `period_us`.
///
/// Exact for the duty cycles of [`Servo`](certainty_firmware::servo::Servo) where `full` is at least
/// the period; 0 where `full` is.
#[must_use]
pub fn pulse_of(duty: u16, full: u16, period_us: u16) -> u32 {
    let (duty, full) = (u32::from(duty), u32::from(full));
    (duty * u32::from(period_us) + full / 2)
        .checked_div(full)
        .unwrap_or(0)
}

/// The angle of a pulse, in 2^-32 of a turn.
fn place(config: &ServoConfig, pulse_us: u32) -> i64 {
    let (shortest, longest) = (config.shortest_us.into(), config.longest_us.into());
    let aside = i64::from(pulse_us.clamp(shortest, longest)) - i64::from(config.ahead_us);
    (aside << 30) / i64::from(config.quarter_us)
}
