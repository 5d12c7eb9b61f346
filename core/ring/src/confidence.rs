//! The two confidence vectors: how many confirmations each sonar has (\[003\] §5, §6).
//!
//! [`simulation_based`] compares measured distances with those that the polygon lets expect,
//! [`intersection_based`] the echoes of different sonars with each other.

use super::arc::Arc;
use super::distances::Distances;
use super::ring::{NEIGHBOURS, ORDERS, Path, Ring, RingRules};
use certainty_core::sensor::SensorId;

/// The number of paths of a sonar: the maximum of [`simulation_based`].
pub const PATHS_OF_A_SENSOR: u8 = 2 * NEIGHBOURS + 1;

/// The number of independent overlaps of a sonar in the paper's ring: the maximum of
/// [`intersection_based`] there.
pub const INDEPENDENT_OVERLAPS: u8 = 35;

/// Two echo paths whose detection ranges overlap, of which the first is one of the sonar's own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Overlap {
    /// A path that the sonar is part of.
    pub own: Path,
    /// The path that overlaps with it.
    pub other: Path,
}

/// The paths of the sonar in `slot`.
fn own_paths<const SENSORS: usize>(
    ring: &Ring<SENSORS>,
    slot: u8,
) -> impl Iterator<Item = Path> + use<SENSORS> {
    let orders = 0..=ring.most_order();
    orders.flat_map(move |order| {
        let back = Ring::<SENSORS>::slot_after(slot, i16::from(order).wrapping_neg());
        // The direct path starts and ends at the same sonar, and counts once.
        let both = [Path::new(back, order), Path::new(slot, order)];
        both.into_iter().skip(usize::from(order == 0))
    })
}

/// Returns the overlaps of a sonar's paths that \[003\] §6 lists: 51 in its ring.
///
/// The rule behind the list: two paths overlap if their cones share an angle, and each of the sonar's
/// paths is paired with the paths of its own order and of higher ones.
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

/// Returns those of the [`overlaps`] whose other path is not one of the sonar's own: 35 in the paper's
/// ring.
pub fn independent_overlaps<const SENSORS: usize>(
    ring: &Ring<SENSORS>,
    sensor: SensorId,
) -> impl Iterator<Item = Overlap> + use<SENSORS> {
    overlaps(ring, sensor).filter(move |overlap| {
        let ends = Ring::<SENSORS>::ends(overlap.other);
        ends.iter().all(|&end| usize::from(end) != sensor.slot())
    })
}

/// Whether `path` counts for `sensor`: the path's *other* sonar is not removed.
fn counts<const SENSORS: usize>(removed: &[bool; SENSORS], path: Path, sensor: SensorId) -> bool {
    Ring::<SENSORS>::ends(path).iter().all(|&end| {
        let end = usize::from(end);
        end == sensor.slot() || !removed.get(end).is_some_and(|&removed| removed)
    })
}

/// Computes the simulation-based confidence vector (\[003\] §5): for each sonar, the number of its paths,
/// 0 to 7, whose measured distance agrees with the expected one.
///
/// Paths to a sonar that is `removed` do not count. A path without an echo has the range as its distance,
/// so it agrees if no echo is expected either.
#[must_use]
pub fn simulation_based<const SENSORS: usize>(
    ring: &Ring<SENSORS>,
    expected: &Distances<SENSORS>,
    measured: &Distances<SENSORS>,
    removed: &[bool; SENSORS],
    rules: &RingRules,
) -> [u8; SENSORS] {
    let limit = rules.config().uncertainty.get();
    let agrees = |path: Path| {
        let both = expected.distance(path).zip(measured.distance(path));
        both.is_some_and(|(expected, measured)| u32::from(expected.abs_diff(measured)) < limit)
    };
    each_sonar(ring, |sensor, slot| {
        count(own_paths(ring, slot).filter(|&path| counts(removed, path, sensor) && agrees(path)))
    })
}

/// One number per sonar, from its id and its slot.
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

/// Computes the intersection-based confidence vector (\[003\] §6): for each sonar, the number of its
/// independent overlaps, 0 to 35 in the paper's ring, whose two arcs intersect.
///
/// Overlaps with a path of a sonar that is `removed` do not count, nor do paths without an echo, which
/// have no arc. The paper does not state the latter; it follows from its example, in which sonar 8 agrees
/// on six of seven paths and intersects with none of 35: arcs at the range, side by side, would all
/// intersect.
///
/// Cost: 840 pairs of arcs in the paper's ring. Memory: 450 bytes of stack.
#[must_use]
pub fn intersection_based<const SENSORS: usize>(
    ring: &Ring<SENSORS>,
    measured: &Distances<SENSORS>,
    removed: &[bool; SENSORS],
    rules: &RingRules,
) -> [u8; SENSORS] {
    let extents = Extents::of(ring, measured);
    let arc = |path: Path| {
        let distance = measured.echo(ring, path)?;
        let half = extents.get(path)?;
        Some(Arc::with_extent(ring, path, distance, half))
    };
    each_sonar(ring, |sensor, _| {
        let intersecting = independent_overlaps(ring, sensor).filter(|overlap| {
            let counted = [overlap.own, overlap.other].map(|path| counts(removed, path, sensor));
            let arcs = counted
                .iter()
                .all(|&counts| counts)
                .then(|| arc(overlap.own).zip(arc(overlap.other)));
            arcs.flatten()
                .is_some_and(|(own, other)| own.intersects(&other, ring, rules.config().touch))
        });
        count(intersecting)
    })
}

/// The extent of each path's arc; computed once, used for many pairs.
struct Extents<const SENSORS: usize>([[Option<u16>; ORDERS]; SENSORS]);

impl<const SENSORS: usize> Extents<SENSORS> {
    fn of(ring: &Ring<SENSORS>, measured: &Distances<SENSORS>) -> Self {
        let mut extents = Self([[None; ORDERS]; SENSORS]);
        for path in ring.paths() {
            let distance = measured.echo(ring, path);
            let arc = distance.and_then(|distance| Arc::of(ring, path, distance));
            if let Some(entry) = extents.entry(path) {
                *entry = arc.map(|arc| arc.half());
            }
        }
        extents
    }

    fn entry(&mut self, path: Path) -> Option<&mut Option<u16>> {
        let row = self.0.get_mut(usize::from(path.slot()));
        row.and_then(|row| row.get_mut(usize::from(path.order())))
    }

    fn get(&self, path: Path) -> Option<u16> {
        let row = self.0.get(usize::from(path.slot()))?;
        row.get(usize::from(path.order())).copied().flatten()
    }
}

/// The number of items, saturating at 255.
fn count<T>(items: impl Iterator<Item = T>) -> u8 {
    items.fold(0, |number: u8, _| number.saturating_add(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Echoes, RingConfig};
    use certainty_core::transducer::Reading;
    use certainty_core::units::Millimeters;
    use std::collections::BTreeSet;

    fn ring() -> Ring<24> {
        Ring::try_new(RingConfig::DEFAULT).unwrap()
    }

    fn id(number: u8) -> SensorId {
        SensorId::try_new(number).unwrap()
    }

    /// The list of \[003\] §6 as printed: offsets from sensor i; equal ones are a direct echo.
    const PRINTED: [(&str, &str); 5] = [
        (
            "0/0",
            "-3/-3 -2/-2 -1/-1 1/1 2/2 3/3 -3/-2 -2/-1 -1/0 0/1 1/2 2/3 -3/-1 -2/0 -1/1 0/2 1/3 \
             -3/0 -2/1 -1/2 0/3",
        ),
        (
            "-1/0",
            "-3/-2 -2/-1 0/1 1/2 -3/-1 -2/0 -1/1 0/2 -3/0 -2/1 -1/2",
        ),
        ("0/1", "-2/-1 -1/0 1/2 2/3 -2/0 -1/1 0/2 1/3 -2/1 -1/2 0/3"),
        ("-2/0", "-3/-1 -1/1 -3/0 -2/1"),
        ("0/2", "-1/1 1/3 -1/2 0/3"),
    ];

    fn offsets(text: &str) -> (i8, i8) {
        let (from, to) = text.split_once('/').unwrap();
        (from.parse().unwrap(), to.parse().unwrap())
    }

    /// A path's ends as offsets from `sensor`, −12 to 11.
    fn seen_from(sensor: SensorId, path: Path) -> (i8, i8) {
        let off = |slot: u8| {
            let off = i16::from(slot) - (i16::from(sensor.number()) - 1);
            ((off + 12).rem_euclid(24) - 12) as i8
        };
        let [from, to] = Ring::<24>::ends(path);
        (off(from), off(to))
    }

    type Pairs = BTreeSet<((i8, i8), (i8, i8))>;

    fn printed() -> Pairs {
        let lines = PRINTED.iter().flat_map(|(own, others)| {
            let others = others.split_whitespace();
            others.map(move |other| (offsets(own), offsets(other)))
        });
        lines.collect()
    }

    fn generated(
        overlaps: impl Iterator<Item = Overlap>,
        sensor: SensorId,
    ) -> Vec<((i8, i8), (i8, i8))> {
        let pairs = overlaps.map(|overlap| {
            let Overlap { own, other } = overlap;
            (seen_from(sensor, own), seen_from(sensor, other))
        });
        pairs.collect()
    }

    #[test]
    fn every_sensor_has_the_papers_51_overlaps() {
        let ring = ring();
        for sensor in ring.sensors() {
            let found = generated(overlaps(&ring, sensor), sensor);
            assert_eq!(found.len(), 51);
            assert_eq!(Pairs::from_iter(found), printed());
        }
    }

    #[test]
    fn of_these_35_are_independent() {
        let ring = ring();
        let independent: Pairs = printed()
            .into_iter()
            .filter(|&(_, (from, to))| from != 0 && to != 0)
            .collect();
        assert_eq!(independent.len(), 35);
        let of_own = |own| independent.iter().filter(|pair| pair.0 == own).count();
        let split = [(0, 0), (-1, 0), (0, 1), (-2, 0), (0, 2)].map(of_own);
        assert_eq!(split, [15, 7, 7, 3, 3]);
        for sensor in ring.sensors() {
            let found = generated(independent_overlaps(&ring, sensor), sensor);
            assert_eq!(found.len(), 35);
            assert_eq!(Pairs::from_iter(found), independent);
        }
    }

    #[test]
    fn there_are_24_direct_and_72_cross_paths() {
        let ring = ring();
        let orders: Vec<_> = ring.paths().map(Path::order).collect();
        let of = |order| orders.iter().filter(|&&o| o == order).count();
        assert_eq!([of(0), of(1), of(2), of(3)], [24; 4]);
        // 60°, 45°, 30° and 15°.
        let degrees =
            [0, 1, 2, 3].map(|order| f64::from(ring.half_width(order)) * 2.0 / 65536.0 * 360.0);
        for (found, printed) in degrees.into_iter().zip([60.0, 45.0, 30.0, 15.0]) {
            assert!((found - printed).abs() < 0.02, "{found} for {printed}");
        }
    }

    #[test]
    fn narrow_cones_have_fewer_paths_and_overlaps() {
        let narrow = RingConfig {
            opening_millidegrees: 30_000,
            ..RingConfig::DEFAULT
        };
        let ring = Ring::<24>::try_new(narrow).unwrap();
        // 30° wide and 15° apart: the next neighbour's cone overlaps by 15°, the second's only touches.
        assert_eq!(ring.paths().count(), 48);
        let found = generated(overlaps(&ring, id(7)), id(7));
        let expected: Pairs = [
            ((0, 0), (-1, -1)),
            ((0, 0), (1, 1)),
            ((0, 0), (-1, 0)),
            ((0, 0), (0, 1)),
        ]
        .into();
        // Cross paths are 15° wide and 15° apart, and direct ones at ±1.5 spacings touch as well.
        assert_eq!(Pairs::from_iter(found), expected);
    }

    /// The distances of all paths if the surroundings are a circle around the robot.
    fn round(distance: u32) -> Distances<24> {
        let ring = ring();
        let mut echoes = Echoes::silent();
        for path in ring.paths() {
            let (_, half_apart) = ring.chord(path.order());
            let half_apart = half_apart as f64 / 16.0;
            let length = 2.0 * f64::from(distance).hypot(half_apart);
            let [from, to] = Ring::<24>::ends(path).map(|slot| id(slot + 1));
            let reading = Reading::Echo(Millimeters::new(length.round() as u32));
            echoes.set(from, to, reading).unwrap();
            echoes.set(to, from, reading).unwrap();
        }
        Distances::fold(&ring, &echoes, &RingRules::DEFAULT)
    }

    #[test]
    fn echoes_as_expected_confirm_all_seven_paths() {
        let (ring, none) = (ring(), [false; 24]);
        let measured = round(1000);
        let rules = RingRules::DEFAULT;
        for (off, paths) in [(0, 7), (99, 7), (101, 0)] {
            let vector = simulation_based(&ring, &round(1000 + off), &measured, &none, &rules);
            assert_eq!(vector, [paths; 24], "{off} mm off");
        }
        // A difference equal to the threshold is not below it.
        let vector = simulation_based(&ring, &round(1100), &measured, &none, &rules);
        assert!(vector.iter().all(|&paths| paths < 7));
    }

    #[test]
    fn a_removed_sensor_counts_for_itself_only() {
        let (ring, measured) = (ring(), round(1000));
        let mut removed = [false; 24];
        removed[3] = true;
        let rules = RingRules::DEFAULT;
        let vector = simulation_based(&ring, &measured, &measured, &removed, &rules);
        let mut expected = [7; 24];
        for neighbour in [0, 1, 2, 4, 5, 6] {
            expected[neighbour] = 6;
        }
        assert_eq!(vector, expected);

        let all = intersection_based(&ring, &measured, &[false; 24], &rules);
        let fewer = intersection_based(&ring, &measured, &removed, &rules);
        assert_eq!(fewer[3], all[3], "no other sonar is removed");
        for neighbour in [0, 1, 2, 4, 5, 6] {
            assert!(fewer[neighbour] < all[neighbour]);
        }
        assert_eq!(fewer[12], all[12]);
    }

    #[test]
    fn unknown_echoes_confirm_nothing() {
        let (ring, none, rules) = (ring(), [false; 24], RingRules::DEFAULT);
        let unknown = Distances::fold(&ring, &Echoes::unknown(), &rules);
        assert_eq!(
            simulation_based(&ring, &round(1000), &unknown, &none, &rules),
            [0; 24]
        );
        assert_eq!(intersection_based(&ring, &unknown, &none, &rules), [0; 24]);
    }

    /// Arcs at the range, side by side, would all intersect; in the paper's example sonar 8 agrees with the
    /// simulation on six of seven paths and intersects with no arc.
    #[test]
    fn silence_agrees_with_the_simulation_and_no_arc() {
        let (ring, none, rules) = (ring(), [false; 24], RingRules::DEFAULT);
        let silent = Distances::fold(&ring, &Echoes::silent(), &rules);
        assert_eq!(
            simulation_based(&ring, &silent, &silent, &none, &rules),
            [7; 24]
        );
        assert_eq!(intersection_based(&ring, &silent, &none, &rules), [0; 24]);
        // One millimetre nearer there are arcs.
        let intersecting = intersection_based(&ring, &round(1999), &none, &rules);
        assert!(intersecting.iter().all(|&arcs| arcs > 0));
    }

    #[test]
    fn no_vector_is_above_its_bound() {
        let (ring, none, rules) = (ring(), [false; 24], RingRules::DEFAULT);
        for distance in [0, 50, 300, 1999, 2500] {
            let measured = round(distance);
            let simulated = simulation_based(&ring, &measured, &measured, &none, &rules);
            assert!(simulated.iter().all(|&paths| paths <= PATHS_OF_A_SENSOR));
            let intersecting = intersection_based(&ring, &measured, &none, &rules);
            assert!(
                intersecting
                    .iter()
                    .all(|&arcs| arcs <= INDEPENDENT_OVERLAPS)
            );
        }
    }
}
