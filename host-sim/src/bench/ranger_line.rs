//! A pulse-echo ultrasonic ranger as its two pins show it.

use super::{LineFault, MICROSECOND, MILLISECOND};

/// What a ranger heard.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RangerAnswer {
    /// The nearest object is this many centimetres away.
    Object {
        /// Whole centimetres.
        cm: u16,
    },
    /// No echo came back.
    NoObject,
}

/// A simulated pulse-echo ranger, pin by pin.
///
/// A pulse on Trigger answers with one on Echo, of 58 µs a centimetre or, where nothing came back,
/// of [`NO_OBJECT_NS`](Self::NO_OBJECT_NS). Triggers meanwhile go unheard.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RangerLine {
    trigger: bool,
    /// When Trigger last rose.
    rose_ns: u64,
    /// From when to when Echo is high.
    pulse: Option<(u64, u64)>,
    fault: Option<LineFault>,
}

impl RangerLine {
    /// The shortest trigger that is heard.
    pub const SHORTEST_TRIGGER_NS: u64 = 10 * MICROSECOND;

    /// From Trigger's fall to Echo's rise.
    pub const DELAY_NS: u64 = 700 * MICROSECOND;

    /// What an echo takes for a centimetre.
    pub const CENTIMETER_NS: u64 = 58 * MICROSECOND;

    /// How long Echo is high where nothing came back.
    pub const NO_OBJECT_NS: u64 = 38 * MILLISECOND;

    /// Creates a ranger that idles, its Trigger low.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets Trigger.
    ///
    /// If it was a trigger, `hear` is asked what comes back; `None` is a ranger that does not
    /// answer. It is asked whatever is wrong with the line.
    pub fn set_trigger(
        &mut self,
        high: bool,
        now_ns: u64,
        hear: impl FnOnce() -> Option<RangerAnswer>,
    ) {
        let was = core::mem::replace(&mut self.trigger, high);
        if high {
            if !was {
                self.rose_ns = now_ns;
            }
            return;
        }
        let busy = self.pulse.is_some_and(|(_, fall_ns)| now_ns < fall_ns);
        let long = now_ns.saturating_sub(self.rose_ns) >= Self::SHORTEST_TRIGGER_NS;
        if was && long && !busy {
            let rise_ns = now_ns + Self::DELAY_NS;
            self.pulse = hear().map(|answer| {
                let width_ns = match answer {
                    RangerAnswer::Object { cm } => u64::from(cm) * Self::CENTIMETER_NS,
                    RangerAnswer::NoObject => Self::NO_OBJECT_NS,
                };
                (rise_ns, rise_ns + width_ns)
            });
        }
    }

    /// Returns the level of Echo.
    #[must_use]
    pub fn echo(&self, now_ns: u64) -> bool {
        match self.fault {
            // Without the sensor's own level there is none: the pull-down's.
            Some(fault) => fault.level(now_ns).unwrap_or(false),
            None => self
                .pulse
                .is_some_and(|(rise_ns, fall_ns)| (rise_ns..fall_ns).contains(&now_ns)),
        }
    }

    /// Puts a fault on the line, or heals it, at once.
    ///
    /// A ranger has neither a conversion nor bits: [`LineFault::UnpluggedMidConversion`] and
    /// [`LineFault::CutShort`] silence it as [`LineFault::Mute`] does.
    pub const fn set_fault(&mut self, fault: Option<LineFault>) {
        self.fault = fault;
    }

    /// Returns the fault that is on the line.
    #[must_use]
    pub const fn fault(&self) -> Option<LineFault> {
        self.fault
    }
}
