//! What the sonars should hear in the surroundings that the lasers saw (\[003\] §4).

use super::distances::{Distances, length_of, of_length};
use super::place::FinePoint;
use super::polygon::{Element, ElementKind, Joint, Polygon};
use super::ring::{Ring, Sonar};
use certainty_core::narrow::saturating_u16_of_u64;

impl<const SENSORS: usize> Distances<SENSORS> {
    /// Returns the distance that each path should give in the surroundings `polygon` (\[003\] §4).
    ///
    /// Walls reflect as mirrors do, corners (concave) send back what comes, edges (convex) scatter and
    /// are not heard. What comes back must lie in the cones of both the path's sonars; a way there or
    /// back that crosses another element of the polygon is barred. Each path gets its shortest echo, or
    /// the range if there is none within it.
    ///
    /// Cost: 96 paths × elements reflections, and for each that would be the shortest yet a look at all
    /// elements.
    #[must_use]
    pub fn simulated<const ELEMENTS: usize>(
        ring: &Ring<SENSORS>,
        polygon: &Polygon<ELEMENTS>,
    ) -> Self {
        let mut distances = Self::UNKNOWN;
        let range = ring.config().range;
        let none = saturating_u16_of_u64(range.get().into());
        for path in ring.paths() {
            let sonars = ring.sonars(path);
            let longest = length_of(ring, path.order(), range);
            let shortest = shortest(polygon.elements(), &sonars, longest);
            let echo = shortest.and_then(|length| of_length(ring, path.order(), length));
            distances.set(path, echo.map_or(none, |distance| distance.min(none)));
        }
        distances
    }
}

/// The shortest echo below `longest` between two sonars, in sixteenths of a millimetre.
fn shortest(elements: &[Element], sonars: &[Sonar; 2], longest: u64) -> Option<u64> {
    let mut best = longest;
    let mut before = elements.last();
    for element in elements {
        let wall = (element.kind() == ElementKind::Wall).then(|| off_wall(element, sonars));
        if let Some((length, place)) = wall.flatten()
            && length < best
            && reaches(elements, sonars, place, [element; 2])
        {
            best = length;
        }
        let corner = before.filter(|_| element.joint() == Joint::Corner);
        if let Some(before) = corner {
            let place = element.start();
            let [there, back] = sonars.map(|sonar| place.minus(sonar.at).length());
            let length = there.wrapping_add(back);
            if length < best && reaches(elements, sonars, place, [before, element]) {
                best = length;
            }
        }
        before = Some(element);
    }
    (best < longest).then_some(best)
}

/// Length and place of the reflection off a wall: as if the second sonar were behind it.
fn off_wall(element: &Element, sonars: &[Sonar; 2]) -> Option<(u64, FinePoint)> {
    let line = element.line();
    let [from, to] = sonars.map(|sonar| {
        let (before, along) = (line.before(sonar.at), line.position(sonar.at));
        (i64::from(before), i64::from(along))
    });
    if from.0 <= 0 || to.0 <= 0 {
        return None;
    }
    // Below 2^22 and 2^45: places of a scan are below 2^20 sixteenths.
    let deep = from.0.wrapping_add(to.0);
    let weighted = from.1.wrapping_mul(to.0);
    let weighted = weighted.wrapping_add(to.1.wrapping_mul(from.0));
    let along = weighted.checked_div(deep)?;
    let ends = [element.start(), element.end()].map(|end| i64::from(line.position(end)));
    let [start, end] = ends;
    if along < start.min(end) || along > start.max(end) {
        return None;
    }
    let aside = from.1.wrapping_sub(to.1);
    let square = aside.wrapping_mul(aside);
    let square = square.wrapping_add(deep.wrapping_mul(deep)).unsigned_abs();
    let along = certainty_core::narrow::saturating_i32(along);
    Some((square.isqrt(), line.at(along)))
}

/// Whether both sonars see `place`, and nothing bars the ways but what is `at` the place.
fn reaches(elements: &[Element], sonars: &[Sonar; 2], place: FinePoint, at: [&Element; 2]) -> bool {
    let others = || {
        let elements = elements.iter();
        elements.filter(|&element| !at.iter().any(|&own| core::ptr::eq(own, element)))
    };
    sonars.iter().all(|sonar| sonar.sees(place))
        && sonars
            .iter()
            .all(|sonar| !others().any(|element| bars(element, sonar.at, place)))
}

/// Whether an element crosses the way from one place to another.
///
/// A way through a vertex crosses one of the two elements there: what lies on the way counts as left.
fn bars(element: &Element, from: FinePoint, to: FinePoint) -> bool {
    let (start, end) = (element.start(), element.end());
    let way = to.minus(from);
    let along = end.minus(start);
    let left_of_way = |place: FinePoint| way.cross(place.minus(from)) >= 0;
    let left_of_element = |place: FinePoint| along.cross(place.minus(start)) >= 0;
    left_of_way(start) != left_of_way(end) && left_of_element(from) != left_of_element(to)
}

#[cfg(test)]
mod tests;
