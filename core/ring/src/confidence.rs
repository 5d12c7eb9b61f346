//! How far each sonar's echoes are confirmed (\[003\] §5, §6).

use super::arc::Arc;
use super::distances::Distances;
use super::ring::{NEIGHBOURS, ORDERS, Path, Ring};
use certainty_core::health::{Confidence, FaultAttribution, Learning, StepRule};
use certainty_core::sensor::SensorId;
use certainty_core::units::Millimeters;
use core::fmt;
use fixed::types::U0F16;

/// How many paths a sonar is part of: the most that [`simulation_based`] gives it.
pub const PATHS_OF_A_SENSOR: u8 = 2 * NEIGHBOURS + 1;

/// How many independent overlaps a sonar of the paper's ring has: the most that [`intersection_based`]
/// gives it.
pub const INDEPENDENT_OVERLAPS: u8 = 35;

/// What decides whether echoes agree, before it is checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RingRulesConfig {
    /// The two directions of a path contradict each other if their distances differ by this much.
    pub consistent: Millimeters,
    /// A simulated and a heard distance agree if they differ by less than this.
    pub uncertainty: Millimeters,
    /// Arcs meet that come as close as this.
    pub touch: Millimeters,
    /// A sonar with fewer confirmations than this is declared faulty.
    pub least: u8,
    /// How much one assessment that speaks for a sonar raises its confidence.
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub raise: U0F16,
    /// How much one that does not lowers it.
    #[cfg_attr(feature = "defmt", defmt(Display2Format))]
    pub lower: U0F16,
}

impl RingRulesConfig {
    /// The uncertainty of 0.1 m is the paper's, and so is that one confirmation is enough. What it leaves
    /// open: the two directions of a path may differ by as much; arcs that touch to a millimetre, the
    /// resolution of an echo, meet. One assessment against a sonar makes it suspect and a second failed,
    /// and six for it make it healthy: confidence falls faster than it rises (\[002\] §4).
    pub const DEFAULT: Self = Self {
        consistent: Millimeters::new(100),
        uncertainty: Millimeters::new(100),
        touch: Millimeters::new(1),
        least: 1,
        raise: U0F16::lit("0.084"),
        lower: U0F16::lit("0.8"),
    };

    /// Differs from \[003\] §7: a sonar needs three confirmations, so that an accident or two do not make a
    /// wrong one sound. For rooms in which every sound sonar has as many: in the paper's example two have
    /// one and two, and would be declared faulty.
    pub const WARY: Self = Self {
        least: 3,
        ..Self::DEFAULT
    };
}

impl Default for RingRulesConfig {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The checked [`RingRulesConfig`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RingRules(RingRulesConfig);

/// Why a configuration was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RingRulesError {
    /// The consistency or the uncertainty is zero, which no two distances are below.
    Never,
    /// Arcs a metre or more apart are no arcs that touch.
    Touch,
    /// A step of the confidence is zero.
    Step,
    /// No confirmation is needed, so nobody would ever be faulty.
    Least,
}

impl fmt::Display for RingRulesError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Never => "distances agree only below a limit that is at least 1mm",
            Self::Touch => "arcs touch only below 1m",
            Self::Least => "a sonar must need at least one confirmation",
            Self::Step => "the steps of a confidence must be above zero",
        })
    }
}

impl core::error::Error for RingRulesError {}

impl RingRules {
    /// How a verdict moves a sonar's confidence: by fixed steps, whatever the sonar said.
    pub(super) const fn learning(&self) -> Learning {
        Learning {
            raise: self.0.raise,
            raise_free: self.0.raise,
            lower: self.0.lower,
            step_rule: StepRule::Fixed,
            attribution: FaultAttribution::Alike,
            floor: Confidence::NONE,
            ceiling: Confidence::FULL,
        }
    }

    /// The rules of [`RingRulesConfig::DEFAULT`].
    pub const DEFAULT: Self = Self(RingRulesConfig::DEFAULT);

    /// The rules of [`RingRulesConfig::WARY`].
    pub const WARY: Self = Self(RingRulesConfig::WARY);

    /// Checks the configuration.
    ///
    /// # Errors
    ///
    /// [`RingRulesError`] names what cannot be.
    pub const fn try_new(config: RingRulesConfig) -> Result<Self, RingRulesError> {
        if config.consistent.get() == 0 || config.uncertainty.get() == 0 {
            Err(RingRulesError::Never)
        } else if config.touch.get() >= 1000 {
            Err(RingRulesError::Touch)
        } else if config.raise.to_bits() == 0 || config.lower.to_bits() == 0 {
            Err(RingRulesError::Step)
        } else if config.least == 0 {
            Err(RingRulesError::Least)
        } else {
            Ok(Self(config))
        }
    }

    /// Returns the configuration.
    #[must_use]
    pub const fn config(&self) -> &RingRulesConfig {
        &self.0
    }
}

impl Default for RingRules {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Two echo paths whose detection ranges overlap, the first being one of the sonar's own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Overlap {
    /// A path that the sonar is part of.
    pub own: Path,
    /// The path it overlaps with.
    pub other: Path,
}

/// The paths that the sonar in place `slot` is part of.
fn own_paths<const SENSORS: usize>(
    ring: &Ring<SENSORS>,
    slot: u8,
) -> impl Iterator<Item = Path> + use<SENSORS> {
    let orders = 0..=ring.most_order();
    orders.flat_map(move |order| {
        let back = Ring::<SENSORS>::on(slot, i16::from(order).wrapping_neg());
        // The direct path starts and ends at the same sonar and counts once.
        let both = [Path::new(back, order), Path::new(slot, order)];
        both.into_iter().skip(usize::from(order == 0))
    })
}

/// Returns the overlaps of the sonar's paths that \[003\] §6 lists, 51 in its ring.
///
/// The rule behind the list: each of the sonar's paths overlaps with every other path whose cone shares
/// an angle with its own, and is held against those of its own order and of higher ones.
pub fn overlaps<const SENSORS: usize>(
    ring: &Ring<SENSORS>,
    sensor: SensorId,
) -> impl Iterator<Item = Overlap> + use<SENSORS> {
    let ring = *ring;
    let slot = sensor.slot();
    let slot = u8::try_from(slot).ok().filter(|_| slot < SENSORS);
    let own = slot
        .into_iter()
        .flat_map(move |slot| own_paths(&ring, slot));
    own.flat_map(move |own| {
        let others = ring.paths().filter(move |&other| {
            other.order() >= own.order() && other != own && ring.overlap(own, other)
        });
        others.map(move |other| Overlap { own, other })
    })
}

/// Returns those of the [`overlaps`] whose other path the sonar has no part in, 35 in the paper's ring.
pub fn independent_overlaps<const SENSORS: usize>(
    ring: &Ring<SENSORS>,
    sensor: SensorId,
) -> impl Iterator<Item = Overlap> + use<SENSORS> {
    overlaps(ring, sensor).filter(move |overlap| {
        let ends = Ring::<SENSORS>::ends(overlap.other);
        ends.iter().all(|&end| usize::from(end) != sensor.slot())
    })
}

/// Whether `path` counts for the sonar: no *other* sonar of it is removed.
fn counts<const SENSORS: usize>(removed: &[bool; SENSORS], path: Path, sensor: SensorId) -> bool {
    Ring::<SENSORS>::ends(path).iter().all(|&end| {
        let end = usize::from(end);
        end == sensor.slot() || !removed.get(end).is_some_and(|&removed| removed)
    })
}

/// Returns, for each sonar, how many of its paths give the distance that the simulation expects
/// (\[003\] §5): 0 to 7.
///
/// Paths to a sonar that is `removed` do not count. A silent path is one at the range: where nothing is
/// expected, silence confirms.
#[must_use]
pub fn simulation_based<const SENSORS: usize>(
    ring: &Ring<SENSORS>,
    expected: &Distances<SENSORS>,
    heard: &Distances<SENSORS>,
    removed: &[bool; SENSORS],
    rules: &RingRules,
) -> [u8; SENSORS] {
    let limit = rules.config().uncertainty.get();
    let agrees = |path: Path| {
        let both = expected.distance(path).zip(heard.distance(path));
        both.is_some_and(|(expected, heard)| u32::from(expected.abs_diff(heard)) < limit)
    };
    each_sonar(ring, |sensor, slot| {
        number_of(
            own_paths(ring, slot).filter(|&path| counts(removed, path, sensor) && agrees(path)),
        )
    })
}

/// One number a sonar, from its own number and its place in the ring.
fn each_sonar<const SENSORS: usize>(
    ring: &Ring<SENSORS>,
    number: impl Fn(SensorId, u8) -> u8,
) -> [u8; SENSORS] {
    let mut vector = [0; SENSORS];
    for (place, sensor) in vector.iter_mut().zip(ring.sensors()) {
        let slot = u8::try_from(sensor.slot()).unwrap_or(0);
        *place = number(sensor, slot);
    }
    vector
}

/// Returns, for each sonar, how many of its independent overlaps hold an intersection of the two arcs
/// (\[003\] §6): 0 to 35 in the paper's ring.
///
/// Overlaps with a path of a sonar that is `removed` do not count, nor do paths without an echo: no arc
/// is where nothing was heard. The text does not say so, but its example does: sonar 8 has six of seven
/// paths right and meets none of 35 arcs, which silent arcs at the range, side by side, could not but meet.
///
/// Cost: 840 pairs of arcs in the paper's ring. Memory: 450 bytes of stack.
#[must_use]
pub fn intersection_based<const SENSORS: usize>(
    ring: &Ring<SENSORS>,
    heard: &Distances<SENSORS>,
    removed: &[bool; SENSORS],
    rules: &RingRules,
) -> [u8; SENSORS] {
    let reaches = Reaches::of(ring, heard);
    let arc = |path: Path| {
        let distance = heard.echo(ring, path)?;
        let half = reaches.get(path)?;
        Some(Arc::with_reach(ring, path, distance, half))
    };
    each_sonar(ring, |sensor, _| {
        let meeting = independent_overlaps(ring, sensor).filter(|overlap| {
            let counted = [overlap.own, overlap.other].map(|path| counts(removed, path, sensor));
            let arcs = counted
                .iter()
                .all(|&counts| counts)
                .then(|| arc(overlap.own).zip(arc(overlap.other)));
            arcs.flatten()
                .is_some_and(|(own, other)| own.meets(&other, ring, rules.config().touch))
        });
        number_of(meeting)
    })
}

/// How far each path's arc goes to the sides; found once, used many times.
struct Reaches<const SENSORS: usize>([[Option<u16>; ORDERS]; SENSORS]);

impl<const SENSORS: usize> Reaches<SENSORS> {
    fn of(ring: &Ring<SENSORS>, heard: &Distances<SENSORS>) -> Self {
        let mut reaches = Self([[None; ORDERS]; SENSORS]);
        for path in ring.paths() {
            let distance = heard.echo(ring, path);
            let arc = distance.and_then(|distance| Arc::of(ring, path, distance));
            if let Some(place) = reaches.place(path) {
                *place = arc.map(|arc| arc.half());
            }
        }
        reaches
    }

    fn place(&mut self, path: Path) -> Option<&mut Option<u16>> {
        let row = self.0.get_mut(usize::from(path.slot()));
        row.and_then(|row| row.get_mut(usize::from(path.order())))
    }

    fn get(&self, path: Path) -> Option<u16> {
        let row = self.0.get(usize::from(path.slot()))?;
        row.get(usize::from(path.order())).copied().flatten()
    }
}

/// How many there are; more than 255 count as 255.
fn number_of<T>(items: impl Iterator<Item = T>) -> u8 {
    items.fold(0, |number: u8, _| number.saturating_add(1))
}

#[cfg(test)]
mod tests;
