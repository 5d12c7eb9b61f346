use super::*;
use crate::RingConfig;
use core::f64::consts::TAU;
use proptest::prelude::*;

const RADIUS: f64 = 300.0;

fn ring() -> Ring<24> {
    Ring::try_new(RingConfig::DEFAULT).unwrap()
}

/// The arcs in floating point, by their definition: no axes, no closed form.
#[derive(Clone, Copy)]
struct Naive {
    foci: [(f64, f64); 2],
    axes: [f64; 2],
    length: f64,
    middle: f64,
}

impl Naive {
    fn of(from: u8, order: u8, distance: f64) -> Self {
        let axes = [f64::from(from), f64::from(from + order)].map(|slot| slot * TAU / 24.0);
        let foci = axes.map(|axis| (RADIUS * axis.cos(), RADIUS * axis.sin()));
        let half_apart = (foci[0].0 - foci[1].0).hypot(foci[0].1 - foci[1].1) / 2.0;
        Self {
            foci,
            axes,
            length: 2.0 * distance.hypot(half_apart),
            middle: f64::midpoint(axes[0], axes[1]),
        }
    }

    fn radius(&self, direction: f64) -> f64 {
        let over = |radius: f64| {
            let (x, y) = (radius * direction.cos(), radius * direction.sin());
            let ways = self.foci.map(|(fx, fy)| (x - fx).hypot(y - fy));
            ways[0] + ways[1] > self.length
        };
        let (mut low, mut high) = (RADIUS * 0.5, 20_000.0);
        for _ in 0..60 {
            let middle = f64::midpoint(low, high);
            if over(middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
        low
    }

    /// Whether the arc's place in this direction is within cones of half this angle.
    fn within(&self, direction: f64, half: f64) -> bool {
        let radius = self.radius(direction);
        let (x, y) = (radius * direction.cos(), radius * direction.sin());
        self.foci.iter().zip(self.axes).all(|(&(fx, fy), axis)| {
            let off = (y - fy).atan2(x - fx) - axis;
            let off = (off + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0;
            off.abs() <= half
        })
    }
}

/// Whether two arcs meet in cones of half this angle: the least difference, and whether it changes
/// its sign.
fn naive_meeting(one: &Naive, other: &Naive, half: f64) -> Option<(f64, bool)> {
    let mut least: Option<(f64, bool)> = None;
    let mut sign = None;
    for step in -600..=600 {
        let direction = one.middle + f64::from(step) / 600.0 * half;
        if !one.within(direction, half) || !other.within(direction, half) {
            continue;
        }
        let gap = one.radius(direction) - other.radius(direction);
        let changed = sign.is_some_and(|positive| positive != (gap > 0.0));
        sign = Some(gap > 0.0);
        let before = least.unwrap_or((f64::INFINITY, false));
        least = Some((before.0.min(gap.abs()), before.1 || changed));
    }
    least
}

fn meets(one: (u8, u8, u16), other: (u8, u8, u16)) -> bool {
    let ring = ring();
    let arc = |(from, order, distance)| Arc::of(&ring, Path::new(from, order), distance);
    let touch = Millimeters::new(1);
    arc(one)
        .zip(arc(other))
        .is_some_and(|(one, other)| one.meets(&other, &ring, touch))
}

#[test]
fn the_radius_is_that_of_the_definition() {
    let ring = ring();
    let mut worst = 0.0_f64;
    for order in 0..=3 {
        for distance in [150, 300, 700, 1999, 2000] {
            let Some(arc) = Arc::of(&ring, Path::new(2, order), distance) else {
                // The cones of distant neighbours share nothing so near.
                let naive = Naive::of(2, order, distance.into());
                assert!(!naive.within(naive.middle, TAU / 12.0 - 1e-3));
                continue;
            };
            let naive = Naive::of(2, order, distance.into());
            for turned in (-i32::from(arc.half)..=i32::from(arc.half)).step_by(97) {
                let direction = naive.middle + f64::from(turned) / 65536.0 * TAU;
                let found = arc.radius(turned).unwrap() as f64 / 16.0;
                worst = worst.max((found - naive.radius(direction)).abs());
            }
        }
    }
    assert!(worst < 0.25, "{worst} mm");
    assert!(
        worst > 0.001,
        "integers this good would be suspicious: {worst}"
    );
}

#[test]
fn an_arc_reaches_as_far_as_both_cones() {
    let ring = ring();
    for order in 0..=3 {
        for distance in [150, 400, 1000, 2000] {
            let naive = Naive::of(0, order, distance.into());
            let half = Arc::of(&ring, Path::new(0, order), distance).map(|arc| arc.half);
            let Some(half) = half else {
                assert!(
                    !naive.within(naive.middle, TAU / 12.0 - 1e-3),
                    "{order} at {distance}"
                );
                continue;
            };
            let reach = f64::from(half) / 65536.0 * TAU;
            assert!(naive.within(naive.middle + reach - 0.002, TAU / 12.0));
            assert!(!naive.within(naive.middle + reach + 0.002, TAU / 12.0));
        }
    }
}

#[test]
fn arcs_of_one_wall_and_of_one_corner_meet() {
    // A wall 1 m from the middle, square to sonar 1: neighbours' feet are at 1 m − 0.3·cos 15°.
    let direct = |slot: f64| (1000.0 - 300.0 * (slot * TAU / 24.0).cos()).round() as u16;
    assert!(meets((0, 0, direct(0.0)), (1, 0, direct(1.0))));
    assert!(meets((23, 0, direct(1.0)), (1, 0, direct(1.0))));
    // The arcs around (0.9 m, 0.2 m), from sonars 1, 2 and across between them.
    let (x, y) = (900.0_f64, 200.0_f64);
    let away = |slot: f64| {
        let axis = slot * TAU / 24.0;
        (x - 300.0 * axis.cos()).hypot(y - 300.0 * axis.sin())
    };
    let chord = 300.0 * (TAU / 48.0).sin();
    let across = ((away(0.0) + away(1.0)) / 2.0).powi(2) - chord * chord;
    let across = across.sqrt().round() as u16;
    let (first, second) = (away(0.0).round() as u16, away(1.0).round() as u16);
    assert!(meets((0, 0, first), (1, 0, second)));
    assert!(meets((0, 0, first), (0, 1, across)));
    assert!(!meets((0, 0, first), (0, 1, across + 40)));
}

#[test]
fn arcs_that_touch_meet_and_arcs_a_little_apart_do_not() {
    // The circle about sonar 2 and the ellipse about 1 and 3 are alike about sonar 2's axis: they touch
    // there where the wall is square to it.
    let wall = 1000.0_f64;
    let direct = (wall - 300.0).round() as u16;
    let across = (wall - 300.0 * (TAU / 24.0).cos()).round() as u16;
    assert!(meets((1, 0, direct), (0, 2, across)));
    assert!(!meets((1, 0, direct), (0, 2, across + 8)));
}

#[test]
fn equal_arcs_coincide_and_meet() {
    for order in 0..=3 {
        for distance in [120, 500, 2000] {
            let arc = (4, order, distance);
            let there = Arc::of(&ring(), Path::new(4, order), distance).is_some();
            assert_eq!(meets(arc, arc), there, "{arc:?}");
        }
    }
}

#[test]
fn a_distance_of_nothing_makes_no_trouble() {
    for order in 0..=3 {
        for other in 0..=3 {
            let _defined = meets((0, order, 0), (1, other, 0));
            let _defined = meets((0, order, 0), (1, other, 2000));
            let _defined = meets((0, order, 8000), (1, other, 1));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]
    #[test]
    fn arcs_meet_where_a_fine_search_says_so(
        one in (0_u8..=3, 60_u16..2000),
        apart in 0_u8..6,
        order in 0_u8..=3,
        nearly in -150_i32..150,
    ) {
        let other = (apart, order, (i32::from(one.1) + nearly).max(20) as u16);
        let naive = Naive::of(0, one.0, one.1.into());
        let against = Naive::of(other.0, other.1, other.2.into());
        let found = meets((0, one.0, one.1), other);
        // What hangs on the last tenth of a degree of a cone, or of a millimetre, is left out.
        let half = TAU / 12.0;
        let narrow = naive_meeting(&naive, &against, half - 0.004);
        let wide = naive_meeting(&naive, &against, half + 0.004);
        if narrow.is_some_and(|(least, changes)| changes || least < 0.5) {
            prop_assert!(found, "{one:?} {other:?}: {narrow:?}");
        }
        if wide.is_none_or(|(least, changes)| !changes && least > 2.5) {
            prop_assert!(!found, "{one:?} {other:?}: {wide:?}");
        }
    }

    #[test]
    fn meeting_is_mutual(
        one in (0_u8..24, 0_u8..=3, 1_u16..8000),
        other in (0_u8..24, 0_u8..=3, 1_u16..8000),
    ) {
        prop_assert_eq!(meets(one, other), meets(other, one));
    }
}
