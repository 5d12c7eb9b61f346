//! From a scan's points to a polygon of walls (\[003\] §3).
//!
//! The points are divided into straight pieces, each piece gets the line that fits it best, and
//! neighbouring lines are joined in vertices.

use super::geometry::{FinePoint, FittedLine, Moments, sixteenths};
use super::scan::Scan;
use certainty_core::units::{BinaryAngle, Direction, Millimeters, Point};
use core::fmt;

/// Lines that pass this close to the origin, or closer, are pseudo line segments (\[003\] §3).
const PSEUDO_WITHIN: Millimeters = Millimeters::new(200);

/// Two neighbouring lines meet in a vertex if it is this close to the scan point between them;
/// otherwise that point is the vertex, as the intersection of nearly parallel lines is ill-defined.
///
/// \[003\] gives no number. Lines with 22 mm of noise may then meet at some 10°.
const VERTEX_WITHIN: Millimeters = Millimeters::new(200);

/// Walls that turn by less than this are one wall to a sonar: neither a corner nor an edge.
///
/// \[003\] gives no number. This is twice the angle that noise alone may produce.
const LEAST_TURN: BinaryAngle = BinaryAngle::from_millidegrees(20_000);

/// How noisy the scanners are: the one number of the extraction that depends on them.
///
/// Possession proves that the limit is from 1 mm to 1 m.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PolygonRules {
    spread: Millimeters,
}

/// Returned by [`PolygonRules::try_new`] if the limit is outside 1 mm to 1 m.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PolygonRulesError {
    /// The limit that was given.
    pub spread: Millimeters,
}

impl fmt::Display for PolygonRulesError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let spread = self.spread;
        write!(
            f,
            "points cannot deviate from their line by up to {spread}: expected 1mm to 1m"
        )
    }
}

impl core::error::Error for PolygonRulesError {}

impl PolygonRules {
    /// Points are one line while their standard deviation from it is below 22 mm (\[003\] §3).
    pub const DEFAULT: Self = Self::new(Millimeters::new(22));

    /// Creates rules by which points are one line while their standard deviation from it is below
    /// `spread`, for constants.
    ///
    /// # Panics
    ///
    /// For a limit that [`Self::try_new`] refuses: a constant then does not build. Use that at run
    /// time.
    #[expect(clippy::panic, reason = "refuses a constant at compile time")]
    #[must_use]
    pub const fn new(spread: Millimeters) -> Self {
        match Self::try_new(spread) {
            Ok(rules) => rules,
            Err(_) => panic!("points may deviate from their line by 1mm to 1m"),
        }
    }

    /// Creates rules by which points are one line while their standard deviation from it is below
    /// `spread`.
    ///
    /// # Errors
    ///
    /// [`PolygonRulesError`] if `spread` is zero or above a metre.
    pub const fn try_new(spread: Millimeters) -> Result<Self, PolygonRulesError> {
        if spread.get() == 0 || spread.get() > 1000 {
            Err(PolygonRulesError { spread })
        } else {
            Ok(Self { spread })
        }
    }

    /// Returns the limit of the standard deviation.
    #[must_use]
    pub const fn spread(&self) -> Millimeters {
        self.spread
    }
}

impl Default for PolygonRules {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// What an element of the polygon is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ElementKind {
    /// A wall of the surroundings.
    Wall,
    /// A pseudo line segment (\[003\] §3): it connects two walls, the nearer of which occludes the end of
    /// the other.
    Pseudo,
}

/// How an element and its predecessor are joined where it starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Joint {
    /// A concave dihedral of two walls, which reflects sound back to its source.
    Corner,
    /// A convex dihedral of two walls, which scatters sound.
    Edge,
    /// Two walls in one line, or nearly so.
    Flat,
    /// At least one of the two is not a wall.
    Open,
}

/// A straight piece of the polygon.
///
/// Memory: 32 bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Element {
    line: FittedLine,
    start: FinePoint,
    end: FinePoint,
    points: u16,
    kind: ElementKind,
    joint: Joint,
}

impl Element {
    /// Returns the line of which it is a piece.
    #[must_use]
    pub const fn line(&self) -> FittedLine {
        self.line
    }

    /// Returns its start, counter-clockwise around the robot.
    #[must_use]
    pub const fn start(&self) -> FinePoint {
        self.start
    }

    /// Returns its end, which is the start of the next element.
    #[must_use]
    pub const fn end(&self) -> FinePoint {
        self.end
    }

    /// Returns the number of scan points it is made of; the points at its ends belong to two elements.
    #[must_use]
    pub const fn points(&self) -> u16 {
        self.points
    }

    /// Returns whether it is a wall or a pseudo line segment.
    #[must_use]
    pub const fn kind(&self) -> ElementKind {
        self.kind
    }

    /// Returns how it and its predecessor are joined.
    #[must_use]
    pub const fn joint(&self) -> Joint {
        self.joint
    }
}

/// The surroundings as a closed polygon, counter-clockwise around the robot.
///
/// `ELEMENTS` is its capacity, from 1 to 4096; a furnished office takes 20 to 40 elements.
///
/// Memory: 32 bytes per element and 8. While it is built, 8 bytes per element more on the stack.
#[derive(Debug, Clone)]
pub struct Polygon<const ELEMENTS: usize> {
    elements: heapless::Vec<Element, ELEMENTS>,
}

/// A scan has more straight pieces than the polygon has room for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TooManyElements {
    /// The polygon's capacity.
    pub capacity: usize,
}

impl fmt::Display for TooManyElements {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let capacity = self.capacity;
        write!(
            f,
            "the scan has more straight pieces than the polygon's capacity of {capacity}"
        )
    }
}

impl core::error::Error for TooManyElements {}

impl<const ELEMENTS: usize> Polygon<ELEMENTS> {
    /// Creates a polygon without elements, as an empty scan gives.
    #[must_use]
    pub const fn empty() -> Self {
        const { assert!(ELEMENTS >= 1 && ELEMENTS <= 1 << 12) };
        Self {
            elements: heapless::Vec::new(),
        }
    }

    /// Extracts the polygon from a scan (\[003\] §3).
    ///
    /// 1. Divides the list at the point farthest from the line through the list's ends, until each piece
    ///    is straight.
    /// 2. Fits a line to each piece.
    /// 3. Merges the last piece and the first, which meet at the seam where the scan began, and divides
    ///    the result again.
    /// 4. Joins neighbouring lines in vertices.
    ///
    /// Lines are fitted by total least squares, as \[003\] gives them in Hesse's form: a regression of y
    /// over x would fail for walls along y. The standard deviation is that from the same line.
    ///
    /// An empty scan gives an empty polygon; a single point gives a wall of zero length.
    ///
    /// Cost: each point is visited some ten times; in the worst case n points are visited
    /// `ELEMENTS` · n² / 2 times.
    ///
    /// # Errors
    ///
    /// [`TooManyElements`] if the scan has more straight pieces than the polygon has room for.
    pub fn of<const BEAMS: usize>(
        scan: &Scan<BEAMS>,
        rules: &PolygonRules,
    ) -> Result<Self, TooManyElements> {
        let mut polygon = Self::empty();
        polygon.rebuild(scan, rules)?;
        Ok(polygon)
    }

    /// Replaces this polygon by that of a scan, as [`Polygon::of`] does, without a second one on the
    /// stack.
    ///
    /// # Errors
    ///
    /// [`TooManyElements`] as for [`Polygon::of`]; the polygon is then empty.
    pub fn rebuild<const BEAMS: usize>(
        &mut self,
        scan: &Scan<BEAMS>,
        rules: &PolygonRules,
    ) -> Result<(), TooManyElements> {
        self.elements.clear();
        let points = Points(scan.raw());
        let pieces = closed::<ELEMENTS>(points, rules.spread);
        let pieces = pieces.map_err(|Full| TooManyElements { capacity: ELEMENTS })?;
        let elements = pieces.iter().map(|&piece| {
            let line = points.moments(piece).line();
            let pseudo = line.distance() <= PSEUDO_WITHIN;
            Element {
                line,
                start: line.at(line.position(fine(points.at(piece.first)))),
                end: line.at(line.position(fine(points.at(piece.last)))),
                points: piece.last.wrapping_sub(piece.first).wrapping_add(1),
                kind: if pseudo {
                    ElementKind::Pseudo
                } else {
                    ElementKind::Wall
                },
                joint: Joint::Open,
            }
        });
        for element in elements {
            // There is room for as many elements as there is for pieces.
            let Ok(()) = self.elements.push(element) else {
                self.elements.clear();
                return Err(TooManyElements { capacity: ELEMENTS });
            };
        }
        // A single line is open: it ends at its outer points.
        if pieces.len() > 1 {
            self.join(points, &pieces);
        }
        Ok(())
    }

    /// Puts a vertex between each element and its predecessor, and classifies it.
    fn join(&mut self, points: Points<'_>, pieces: &[Piece]) {
        let reach = i64::from(sixteenths(VERTEX_WITHIN));
        let reach = reach.wrapping_mul(reach).unsigned_abs();
        let Some(last) = self.elements.last().map(|last| last.line) else {
            return;
        };
        let mut before = last;
        for (element, piece) in self.elements.iter_mut().zip(pieces) {
            let between = fine(points.at(piece.first));
            let meeting = before.intersection(&element.line);
            let near = meeting.filter(|vertex| vertex.minus(between).square() <= reach);
            element.start = near.unwrap_or(between);
            before = element.line;
        }
        // Each element ends where the next starts, so they are visited from the last to the first.
        let mut next = self.elements.first().map(|first| first.start);
        for element in self.elements.iter_mut().rev() {
            element.end = next.unwrap_or(element.end);
            next = Some(element.start);
        }
        let sine = LEAST_TURN.direction().sin();
        let mut before = self.elements.last().copied();
        for element in &mut self.elements {
            element.joint = before.map_or(Joint::Open, |before| joint(&before, element, sine));
            before = Some(*element);
        }
    }

    /// Returns the elements, counter-clockwise around the robot.
    #[must_use]
    pub fn elements(&self) -> &[Element] {
        &self.elements
    }
}

/// Classifies the vertex between an element and its predecessor; `sine` is that of the least turn.
///
/// The polygon runs counter-clockwise around the robot, so a turn to the left is concave.
fn joint(before: &Element, after: &Element, sine: i32) -> Joint {
    if before.kind == ElementKind::Pseudo || after.kind == ElementKind::Pseudo {
        return Joint::Open;
    }
    let (come, go) = (before.end.minus(before.start), after.end.minus(after.start));
    let left = come.cross(go);
    // Each length is below 2^21 sixteenths, as the points are those of a scan.
    let lengths = come.length().wrapping_mul(go.length());
    let least = u128::from(lengths).wrapping_mul(sine.unsigned_abs().into());
    let least = least >> Direction::FRACTION_BITS;
    let turns = u128::from(left.unsigned_abs()) >= least || come.dot(go) < 0;
    match left {
        0 => Joint::Flat,
        _ if !turns => Joint::Flat,
        1.. => Joint::Corner,
        _ => Joint::Edge,
    }
}

/// The straight pieces of the whole scan, once around, with the seam closed.
fn closed<const ELEMENTS: usize>(
    points: Points<'_>,
    spread: Millimeters,
) -> Result<Pieces<ELEMENTS>, Full> {
    let mut pieces = Pieces::new();
    let Some(last) = points.len().checked_sub(1) else {
        return Ok(pieces);
    };
    points.split(Piece { first: 0, last }, spread, &mut pieces)?;
    let seam = match *pieces {
        [first, .., last] => Piece {
            first: last.first,
            last: first.last.wrapping_add(points.len()),
        },
        // All points are on one line: there is no seam to close.
        _ => return Ok(pieces),
    };
    let inner = pieces.get(1..pieces.len().wrapping_sub(1));
    let inner = Pieces::from_slice(inner.unwrap_or(&[]));
    let mut around = inner.map_err(|_| Full)?;
    points.split(seam, spread, &mut around)?;
    Ok(around)
}

fn fine([x, y]: [i16; 2]) -> FinePoint {
    FinePoint::from_point(Point::from_mm(x.into(), y.into()))
}

/// The points of a scan as a cyclic list: position n is position 0 again.
#[derive(Debug, Clone, Copy)]
struct Points<'a>(&'a [[i16; 2]]);

/// A straight piece: the points from one position to another, both included.
///
/// `first` is within the list; `last` may be beyond its end, once around.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Piece {
    first: u16,
    last: u16,
}

/// The list of pieces has no room for another one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Full;

type Pieces<const ELEMENTS: usize> = heapless::Vec<Piece, ELEMENTS>;

impl<'a> Points<'a> {
    /// The number of points; a scan has at most 2^14.
    fn len(self) -> u16 {
        u16::try_from(self.0.len()).unwrap_or(u16::MAX)
    }

    /// The points of a piece.
    fn of(self, piece: Piece) -> impl Iterator<Item = &'a [i16; 2]> {
        let first = piece.first.checked_rem(self.len()).unwrap_or(0);
        let from = self.0.get(first.into()..).unwrap_or(&[]);
        let length = piece.last.wrapping_sub(piece.first).wrapping_add(1);
        from.iter().chain(self.0).take(length.into())
    }

    fn at(self, position: u16) -> [i16; 2] {
        let position = position.checked_rem(self.len()).unwrap_or(0);
        let point = self.0.get(usize::from(position));
        point.copied().unwrap_or([0, 0])
    }

    fn moments(self, piece: Piece) -> Moments {
        Moments::of(self.of(piece))
    }

    /// The position of the point farthest from the line through the piece's ends; the first of equals.
    ///
    /// If both ends are the same point, there is no line, and the distance to that point counts. For a
    /// piece of three points or more the result is never one of its ends.
    fn farthest(self, piece: Piece) -> u16 {
        let [from_x, from_y] = self.at(piece.first).map(i64::from);
        let [to_x, to_y] = self.at(piece.last).map(i64::from);
        let (along_x, along_y) = (to_x.wrapping_sub(from_x), to_y.wrapping_sub(from_y));
        let closed = along_x == 0 && along_y == 0;
        let mut best = (piece.first.wrapping_add(1), -1);
        let between = self.of(piece).skip(1);
        let inner = piece.first.wrapping_add(1)..piece.last;
        for (&[x, y], position) in between.zip(inner) {
            let (x, y) = (
                i64::from(x).wrapping_sub(from_x),
                i64::from(y).wrapping_sub(from_y),
            );
            let away = if closed {
                x.wrapping_mul(x).wrapping_add(y.wrapping_mul(y))
            } else {
                let aside = along_x
                    .wrapping_mul(y)
                    .wrapping_sub(along_y.wrapping_mul(x));
                aside.wrapping_abs()
            };
            if away > best.1 {
                best = (position, away);
            }
        }
        best.0
    }

    /// Divides `whole` into pieces whose points deviate by less than `spread` from their line.
    ///
    /// The figure of \[003\] §3 without its recursion: a list is cut at the point farthest from the line
    /// through its ends until the remaining piece is straight; the next list starts at that cut.
    /// Differs from \[003\] §3: a list is tested before it is cut; otherwise a last piece that is straight
    /// would be cut at its noisiest point.
    ///
    /// Cost: each cut visits n points twice; a piece takes n² / 2 such visits in the worst case, and
    /// log₂ n cuts in practice.
    fn split<const ELEMENTS: usize>(
        self,
        whole: Piece,
        spread: Millimeters,
        pieces: &mut Pieces<ELEMENTS>,
    ) -> Result<(), Full> {
        let around = self.len();
        let Piece { mut first, last } = whole;
        loop {
            let mut piece = Piece { first, last };
            // Two points are always straight.
            while piece.last > piece.first.wrapping_add(1)
                && !self.moments(piece).spread_below(spread)
            {
                piece.last = self.farthest(piece);
            }
            let next = piece.last;
            if piece.first >= around {
                piece.first = piece.first.wrapping_sub(around);
                piece.last = piece.last.wrapping_sub(around);
            }
            pieces.push(piece).map_err(|_| Full)?;
            if next >= last {
                return Ok(());
            }
            first = next;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scanner;
    use certainty_core::transducer::Reading;
    use certainty_core::units::Pose;
    use proptest::prelude::*;

    const fn mm(mm: u32) -> Millimeters {
        Millimeters::new(mm)
    }

    /// A scan of points in whole millimetres, given as they are.
    fn scan(points: &[[i32; 2]]) -> Scan<1024> {
        let mut scan = Scan::new();
        for &[x, y] in points {
            scan.place([x as i16, y as i16]);
        }
        scan
    }

    /// Points every 20 mm along the closed outline through `corners`.
    fn outline(corners: &[[i32; 2]]) -> Vec<[i32; 2]> {
        let mut points = Vec::new();
        for (place, &[x, y]) in corners.iter().enumerate() {
            let [to_x, to_y] = corners[(place + 1) % corners.len()];
            let (run, rise) = (to_x - x, to_y - y);
            let steps = run.abs().max(rise.abs()) / 20;
            points.extend((0..steps).map(|step| [x + run * step / steps, y + rise * step / steps]));
        }
        points
    }

    fn polygon(points: &[[i32; 2]]) -> Polygon<64> {
        Polygon::of(&scan(points), &PolygonRules::DEFAULT).unwrap()
    }

    fn starts(polygon: &Polygon<64>) -> Vec<[i32; 2]> {
        let starts = polygon.elements().iter().map(|element| element.start());
        starts
            .map(|start| [(start.x() + 8) >> 4, (start.y() + 8) >> 4])
            .collect()
    }

    const ROOM: [[i32; 2]; 4] = [[1500, -1000], [1500, 2000], [-2000, 2000], [-2000, -1000]];

    #[test]
    fn a_box_is_four_walls_wherever_the_scan_begins() {
        let mut points = outline(&ROOM);
        for _ in 0..points.len() / 7 {
            points.rotate_left(7);
            let polygon = polygon(&points);
            let mut found = starts(&polygon);
            // The first element may be any of the four; the order is fixed.
            let first = found.iter().position(|&start| start == ROOM[0]).unwrap();
            found.rotate_left(first);
            assert_eq!(found, ROOM);
            for element in polygon.elements() {
                assert_eq!(element.kind(), ElementKind::Wall);
                assert_eq!(element.joint(), Joint::Corner);
            }
        }
    }

    #[test]
    fn a_pillar_is_between_two_pseudo_segments() {
        // Seen from the origin, the pillar occludes a part of the wall ahead.
        let around = [
            [1500, -1000],
            [1500, -375], // the pillar's shadow ends
            [800, -200],
            [800, 200],
            [1500, 375],
            [1500, 2000],
            [-2000, 2000],
            [-2000, -1000],
        ];
        let polygon = polygon(&outline(&around));
        let kinds: Vec<_> = polygon
            .elements()
            .iter()
            .map(|element| (element.kind(), element.joint()))
            .collect();
        let wall = |joint| (ElementKind::Wall, joint);
        let pseudo = (ElementKind::Pseudo, Joint::Open);
        let mut expected = [
            wall(Joint::Corner), // the piece of wall to the right of the pillar
            pseudo,
            wall(Joint::Open), // the pillar
            pseudo,
            wall(Joint::Open),
            wall(Joint::Corner),
            wall(Joint::Corner),
            wall(Joint::Corner),
        ];
        let begins = kinds.iter().position(|&kind| kind == pseudo).unwrap();
        expected.rotate_left(1);
        let mut kinds = kinds;
        kinds.rotate_left(begins);
        assert_eq!(kinds, expected);
    }

    #[test]
    fn a_convex_vertex_is_an_edge() {
        // An L-shaped room; the inner corner at (500, 500) points at the robot.
        let around = [
            [2000, -1000],
            [2000, 500],
            [500, 500],
            [500, 2000],
            [-1000, 2000],
            [-1000, -1000],
        ];
        let polygon = polygon(&outline(&around));
        let edges: Vec<_> = polygon
            .elements()
            .iter()
            .filter(|element| element.joint() == Joint::Edge)
            .map(|element| [element.start().x(), element.start().y()])
            .collect();
        assert_eq!(edges, [[500 * 16, 500 * 16]]);
        let corners = polygon
            .elements()
            .iter()
            .filter(|e| e.joint() == Joint::Corner);
        assert_eq!(corners.count(), 5);
    }

    #[test]
    fn noise_above_the_threshold_divides_a_wall() {
        // ±δ alternating is a deviation of δ; the paper accepts less than 22 mm.
        let with_noise = |delta: i32| {
            let mut points = outline(&ROOM);
            for (number, point) in points.iter_mut().enumerate() {
                let off = if number % 2 == 0 { delta } else { -delta };
                let [x, y] = *point;
                *point = if x.abs() >= 1500 {
                    [x + off, y]
                } else {
                    [x, y + off]
                };
            }
            Polygon::<1024>::of(&scan(&points), &PolygonRules::DEFAULT).unwrap()
        };
        assert_eq!(with_noise(15).elements().len(), 4);
        assert!(with_noise(40).elements().len() > 40);
    }

    #[test]
    fn degenerate_scans_have_defined_polygons() {
        assert_eq!(polygon(&[]).elements().len(), 0);

        let one = polygon(&[[300, 400]]);
        let [element] = one.elements() else { panic!() };
        assert_eq!(element.start(), element.end());
        assert_eq!(element.line().distance(), mm(500));

        let twice = polygon(&[[300, 400]; 50]);
        assert_eq!(twice.elements().len(), 1);
        assert_eq!(twice.elements()[0].points(), 50);

        let collinear: Vec<_> = (-20..=20).map(|step| [1000, step * 50]).collect();
        let wall = polygon(&collinear);
        let [element] = wall.elements() else { panic!() };
        assert_eq!((element.start().y(), element.end().y()), (-16_000, 16_000));
        assert_eq!(element.joint(), Joint::Open);

        // Two points alternating are one line, however often they repeat.
        let two: Vec<_> = (0..100).map(|n| [500, n % 2 * 900]).collect();
        assert_eq!(polygon(&two).elements().len(), 1);
    }

    #[test]
    fn a_scan_without_echoes_is_round_at_the_range() {
        let scanner = Scanner::try_new(Pose::default(), mm(8000)).unwrap();
        let mut scan = Scan::<722>::new();
        for beam in 0..720 {
            let bearing = BinaryAngle::from_millidegrees(beam * 500);
            scan.add(&scanner, bearing, Reading::NoObject).unwrap();
        }
        let polygon = Polygon::<64>::of(&scan, &PolygonRules::DEFAULT).unwrap();
        // A chord whose points deviate by 22 mm bulges by some 74 mm: 15.6° at 8 m, so at least 23 chords.
        assert!((23..=64).contains(&polygon.elements().len()));
        for element in polygon.elements() {
            assert_eq!(element.kind(), ElementKind::Wall);
            assert!(element.line().distance() > mm(7800));
        }
    }

    #[test]
    fn a_scan_with_too_many_pieces_is_refused() {
        let zigzag: Vec<_> = (0..200)
            .map(|n| [1000 + n % 2 * 500, n * 20 - 2000])
            .collect();
        let refused = Polygon::<16>::of(&scan(&zigzag), &PolygonRules::DEFAULT);
        assert_eq!(refused.unwrap_err(), TooManyElements { capacity: 16 });
    }

    #[test]
    fn a_spread_of_nothing_or_over_a_metre_is_refused() {
        for spread in [0, 1001].map(mm) {
            let refused = PolygonRules::try_new(spread);
            assert_eq!(refused, Err(PolygonRulesError { spread }));
        }
        assert_eq!(PolygonRules::try_new(mm(22)), Ok(PolygonRules::DEFAULT));
        assert_eq!(PolygonRules::try_new(mm(1000)).unwrap().spread(), mm(1000));
    }

    proptest! {
        #[test]
        fn every_point_is_near_the_element_it_belongs_to(
            // A room with one random corner in each quadrant.
            corners in prop::array::uniform4((600_i32..5000, 600_i32..5000)),
            begin in 0_usize..1000,
        ) {
            let [a, b, c, d] = corners;
            let around = [[a.0, -a.1], [b.0, b.1], [-c.0, c.1], [-d.0, -d.1]];
            let mut points = outline(&around);
            points.truncate(1024);
            let begin = begin % points.len();
            points.rotate_left(begin);
            let polygon = polygon(&points);
            let mut members = 0;
            for element in polygon.elements() {
                members += usize::from(element.points());
            }
            // Each point belongs to one element, and each dividing point to two.
            prop_assert_eq!(members, points.len() + polygon.elements().len());
            // The polygon is closed.
            for (place, element) in polygon.elements().iter().enumerate() {
                let next = &polygon.elements()[(place + 1) % polygon.elements().len()];
                prop_assert_eq!(element.end(), next.start());
            }
        }

        #[test]
        fn any_points_make_a_polygon_or_are_refused(
            points in prop::collection::vec(prop::array::uniform2(-32_768_i32..32_768), 0..300),
            repeat in 1_usize..4,
        ) {
            let points: Vec<_> = points.into_iter().flat_map(|p| core::iter::repeat_n(p, repeat)).collect();
            match Polygon::<64>::of(&scan(&points), &PolygonRules::DEFAULT) {
                Ok(polygon) => prop_assert_eq!(polygon.elements().is_empty(), points.is_empty()),
                Err(refused) => prop_assert_eq!(refused.capacity, 64),
            }
        }
    }
}
