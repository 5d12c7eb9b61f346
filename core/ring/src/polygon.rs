//! The surroundings as a polygon of walls (\[003\] §3).

use super::line::Line;
use super::place::{FinePoint, sixteenths};
use super::scan::Scan;
use super::split::{Full, Piece, Pieces, Points};
use certainty_core::units::{BinaryAngle, Direction, Millimeters, Point};
use core::fmt;

/// What decides how points become a polygon, before it is checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PolygonConfig {
    /// Points are one line while their standard deviation from it is below this.
    pub spread: Millimeters,
    /// A line that passes the origin this close, or closer, is no wall but the edge of a view.
    pub pseudo_within: Millimeters,
    /// Two lines meet in a vertex if that is so near to the point between them; else that point is
    /// the vertex, as nearly parallel lines meet anywhere.
    pub vertex_within: Millimeters,
    /// Walls that turn by less than this are one wall to a sonar: no corner, no edge.
    pub turn: BinaryAngle,
}

impl PolygonConfig {
    /// 22 mm and 0.2 m are the paper's. What it leaves open: vertices within 0.2 m of the scan's point,
    /// so that lines with 22 mm of noise may meet at some 10°; and a turn of 20°, twice as much, makes
    /// a corner.
    pub const DEFAULT: Self = Self {
        spread: Millimeters::new(22),
        pseudo_within: Millimeters::new(200),
        vertex_within: Millimeters::new(200),
        turn: BinaryAngle::from_millidegrees(20_000),
    };
}

impl Default for PolygonConfig {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The checked [`PolygonConfig`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PolygonRules(PolygonConfig);

/// Why a configuration was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PolygonConfigError {
    /// The deviation is zero, which no points are below, or above a metre.
    Spread,
    /// The turn is more than a right angle.
    Turn,
}

impl fmt::Display for PolygonConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Spread => "the deviation from a line must be from 1mm to 1m",
            Self::Turn => "the turn that makes a corner must be at most 90deg",
        })
    }
}

impl core::error::Error for PolygonConfigError {}

impl PolygonRules {
    /// The rules of [`PolygonConfig::DEFAULT`].
    pub const DEFAULT: Self = Self(PolygonConfig::DEFAULT);

    /// Checks the configuration.
    ///
    /// # Errors
    ///
    /// [`PolygonConfigError`] names what cannot be.
    pub const fn try_new(config: PolygonConfig) -> Result<Self, PolygonConfigError> {
        let spread = config.spread.get();
        if spread == 0 || spread > 1000 {
            Err(PolygonConfigError::Spread)
        } else if config.turn.to_bits() > BinaryAngle::QUARTER.to_bits() {
            Err(PolygonConfigError::Turn)
        } else {
            Ok(Self(config))
        }
    }

    /// Returns the configuration.
    #[must_use]
    pub const fn config(&self) -> &PolygonConfig {
        &self.0
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
    /// Something that is there.
    Wall,
    /// A pseudo line segment (\[003\] §3): it joins two walls of which one hides the other's end.
    Pseudo,
}

/// What is where an element starts: how it and the one before it join.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Joint {
    /// A concave dihedral of two walls, which sends sound back to where it came from.
    Corner,
    /// A convex dihedral of two walls, which scatters sound.
    Edge,
    /// Two walls in one line, or nearly.
    Flat,
    /// One of the two is no wall.
    Open,
}

/// A straight piece of the surroundings.
///
/// Memory: 32 bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Element {
    line: Line,
    start: FinePoint,
    end: FinePoint,
    points: u16,
    kind: ElementKind,
    joint: Joint,
}

impl Element {
    /// Returns the line that it is a piece of.
    #[must_use]
    pub const fn line(&self) -> Line {
        self.line
    }

    /// Returns where it starts, going counter-clockwise around the robot.
    #[must_use]
    pub const fn start(&self) -> FinePoint {
        self.start
    }

    /// Returns where it ends: where the next element starts.
    #[must_use]
    pub const fn end(&self) -> FinePoint {
        self.end
    }

    /// Returns of how many points of the scan it is made; those at its ends belong to two elements.
    #[must_use]
    pub const fn points(&self) -> u16 {
        self.points
    }

    /// Returns what it is.
    #[must_use]
    pub const fn kind(&self) -> ElementKind {
        self.kind
    }

    /// Returns what is where it starts.
    #[must_use]
    pub const fn joint(&self) -> Joint {
        self.joint
    }
}

/// The surroundings as a closed polygon, counter-clockwise around the robot.
///
/// `ELEMENTS` is how many there is room for; a furnished office takes 20 to 40.
///
/// Memory: 32 bytes an element and 8. While it is made, 8 bytes an element more on the stack.
#[derive(Debug, Clone)]
pub struct Polygon<const ELEMENTS: usize> {
    elements: heapless::Vec<Element, ELEMENTS>,
}

/// A scan has more straight pieces than there is room for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TooManyElements {
    /// How many there is room for.
    pub room: usize,
}

impl fmt::Display for TooManyElements {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let room = self.room;
        write!(
            f,
            "the polygon has room for {room} elements, and the scan has more"
        )
    }
}

impl core::error::Error for TooManyElements {}

impl<const ELEMENTS: usize> Polygon<ELEMENTS> {
    /// Creates the polygon of an empty scan: nothing is known of the surroundings.
    #[must_use]
    pub const fn empty() -> Self {
        const { assert!(ELEMENTS >= 1 && ELEMENTS <= 1 << 12) };
        Self {
            elements: heapless::Vec::new(),
        }
    }

    /// Makes the polygon of a scan (\[003\] §3).
    ///
    /// The scan is divided where points are farthest from the line through a list's ends; each piece
    /// gets the line that fits its points best; the last piece and the first, which meet where the scan
    /// began, are made one or divided anew; and neighbouring lines meet in vertices.
    ///
    /// Lines are of total least squares, as \[003\] keeps them in Hesse's form: a wall is as straight
    /// whichever way it runs, which a regression of y over x cannot say. The deviation that decides is
    /// that from the same line.
    ///
    /// An empty scan makes an empty polygon; a single point, a wall of no length.
    ///
    /// Cost: some ten looks at each point; at the worst `ELEMENTS` · n² / 2 looks for n points.
    ///
    /// # Errors
    ///
    /// [`TooManyElements`] if the surroundings have more straight pieces than there is room for.
    pub fn of<const BEAMS: usize>(
        scan: &Scan<BEAMS>,
        rules: &PolygonRules,
    ) -> Result<Self, TooManyElements> {
        let mut polygon = Self::empty();
        polygon.remake(scan, rules)?;
        Ok(polygon)
    }

    /// Makes this polygon that of a scan, as [`Polygon::of`] does, without a second one on the stack.
    ///
    /// # Errors
    ///
    /// [`TooManyElements`] as for [`Polygon::of`]; the polygon is empty then.
    pub fn remake<const BEAMS: usize>(
        &mut self,
        scan: &Scan<BEAMS>,
        rules: &PolygonRules,
    ) -> Result<(), TooManyElements> {
        self.elements.clear();
        let points = Points(scan.raw());
        let pieces = closed::<ELEMENTS>(points, rules.0.spread);
        let pieces = pieces.map_err(|Full| TooManyElements { room: ELEMENTS })?;
        let elements = pieces.iter().map(|&piece| {
            let line = points.moments(piece).line();
            let pseudo = line.distance() <= rules.0.pseudo_within;
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
                return Err(TooManyElements { room: ELEMENTS });
            };
        }
        // A single line is open: it has the ends of its points.
        if pieces.len() > 1 {
            self.join(points, &pieces, &rules.0);
        }
        Ok(())
    }

    /// Puts a vertex between each element and the one before it, and says what it is.
    fn join(&mut self, points: Points<'_>, pieces: &[Piece], config: &PolygonConfig) {
        let reach = i64::from(sixteenths(config.vertex_within));
        let reach = reach.wrapping_mul(reach).unsigned_abs();
        let Some(last) = self.elements.last().map(|last| last.line) else {
            return;
        };
        let mut before = last;
        for (element, piece) in self.elements.iter_mut().zip(pieces) {
            let between = fine(points.at(piece.first));
            let meeting = before.meet(&element.line);
            let near = meeting.filter(|place| place.minus(between).square() <= reach);
            element.start = near.unwrap_or(between);
            before = element.line;
        }
        // Each ends where the next starts, so the last is done first.
        let mut next = self.elements.first().map(|first| first.start);
        for element in self.elements.iter_mut().rev() {
            element.end = next.unwrap_or(element.end);
            next = Some(element.start);
        }
        let sine = config.turn.direction().sin();
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

/// What is between an element and the one before it; `sine` is that of the least turn.
///
/// The polygon goes counter-clockwise around the robot: a turn to the left is concave.
fn joint(before: &Element, after: &Element, sine: i32) -> Joint {
    if before.kind == ElementKind::Pseudo || after.kind == ElementKind::Pseudo {
        return Joint::Open;
    }
    let (come, go) = (before.end.minus(before.start), after.end.minus(after.start));
    let left = come.cross(go);
    // Each length is below 2^21 sixteenths where the points are a scan's.
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

/// The straight pieces of the whole scan, once around.
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
        // All points are one line, which nothing closes.
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

#[cfg(test)]
mod tests;
