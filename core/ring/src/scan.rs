//! What laser scanners saw around the robot, as one list of points (\[003\] §3).

use certainty_core::narrow::saturating_i16;
use certainty_core::transducer::Reading;
use certainty_core::units::{BinaryAngle, Millimeters, Point, Pose};
use core::fmt;

/// Where a laser scanner sits on the robot, and how far it sees.
///
/// Possession proves that no point it reports is 32 768 mm or more from the robot's middle along x or
/// y, so that a point takes four bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Scanner {
    mount: Pose,
    farthest: Millimeters,
}

/// Why a scanner was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ScannerError {
    /// It sits farther than two metres from the robot's middle, along x or y.
    Mount,
    /// It sees nothing, or farther than 30 m.
    Farthest,
}

impl fmt::Display for ScannerError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Mount => "a scanner must sit within 2m of the robot's middle",
            Self::Farthest => "a scanner's range must be from 1mm to 30m",
        })
    }
}

impl core::error::Error for ScannerError {}

impl Scanner {
    const MOST_OFFSET: u32 = 2000;
    const MOST_RANGE: u32 = 30_000;

    /// Creates a scanner at `mount` in the robot's frame that sees up to `farthest`.
    ///
    /// # Errors
    ///
    /// [`ScannerError`] names what is too large.
    pub const fn try_new(mount: Pose, farthest: Millimeters) -> Result<Self, ScannerError> {
        let (x, y) = (
            mount.at.x_mm().unsigned_abs(),
            mount.at.y_mm().unsigned_abs(),
        );
        if x > Self::MOST_OFFSET || y > Self::MOST_OFFSET {
            Err(ScannerError::Mount)
        } else if farthest.get() == 0 || farthest.get() > Self::MOST_RANGE {
            Err(ScannerError::Farthest)
        } else {
            Ok(Self { mount, farthest })
        }
    }

    /// Returns where it sits in the robot's frame.
    #[must_use]
    pub const fn mount(&self) -> Pose {
        self.mount
    }

    /// Returns how far it sees.
    #[must_use]
    pub const fn farthest(&self) -> Millimeters {
        self.farthest
    }

    /// Where the beam in direction `bearing`, relative to the scanner's heading, ended.
    const fn end(&self, bearing: BinaryAngle, reading: Reading) -> Option<Point> {
        let farthest = self.farthest;
        let range = match reading {
            Reading::Echo(range) if range.get() < farthest.get() => range,
            // Nothing nearer than the scanner sees: that much of it is free, and what lies beyond a
            // sonar's range is all one to the sonar.
            Reading::Echo(_) | Reading::NoObject => farthest,
            Reading::TooNear | Reading::Missing(_) => return None,
        };
        let direction = self.mount.heading.wrapping_add(bearing).direction();
        Some(self.mount.at.ahead(direction, range))
    }
}

/// The points where the beams of a scan around the robot ended, in the order of their directions.
///
/// Two scanners of 361 beams each fill `Scan<722>` (\[003\] §3). The scan is one list, counter-clockwise:
/// first the beams of the one scanner, then those of the other.
///
/// Memory: 4 bytes a beam and 12.
#[derive(Debug, Clone)]
pub struct Scan<const BEAMS: usize> {
    points: heapless::Vec<[i16; 2], BEAMS>,
    unseen: u32,
}

/// A scan has more beams than there is room for; the beam was not taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TooManyBeams {
    /// How many there is room for.
    pub room: usize,
}

impl fmt::Display for TooManyBeams {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the scan has room for {} beams and got more", self.room)
    }
}

impl core::error::Error for TooManyBeams {}

impl<const BEAMS: usize> Scan<BEAMS> {
    /// Creates a scan without beams.
    #[must_use]
    pub const fn new() -> Self {
        // A list position, and twice the list around the seam, must fit 16 bits.
        const { assert!(BEAMS >= 1 && BEAMS <= 1 << 14) };
        Self {
            points: heapless::Vec::new(),
            unseen: 0,
        }
    }

    /// Adds the beam in direction `bearing`, relative to the scanner's heading.
    ///
    /// No object counts as a point at the end of the scanner's range: what lies beyond is no concern
    /// of a sonar. A beam that is too near or missing says nothing and leaves no point; it is counted.
    ///
    /// # Errors
    ///
    /// [`TooManyBeams`] if the scan is full; it is as it was.
    pub fn add(
        &mut self,
        scanner: &Scanner,
        bearing: BinaryAngle,
        reading: Reading,
    ) -> Result<(), TooManyBeams> {
        match scanner.end(bearing, reading) {
            Some(end) => {
                let point = [saturating_i16(end.x_mm()), saturating_i16(end.y_mm())];
                let added = self.points.push(point);
                added.map_err(|_| TooManyBeams { room: BEAMS })
            }
            None => {
                self.unseen = self.unseen.saturating_add(1);
                Ok(())
            }
        }
    }

    /// Forgets all beams.
    pub fn clear(&mut self) {
        self.points.clear();
        self.unseen = 0;
    }

    /// Returns the points in the robot's frame, in the order in which they came.
    #[must_use]
    pub fn points(&self) -> impl ExactSizeIterator<Item = Point> + '_ {
        let points = self.points.iter();
        points.map(|&[x, y]| Point::from_mm(x.into(), y.into()))
    }

    /// Returns how many beams left no point.
    #[must_use]
    pub const fn unseen(&self) -> u32 {
        self.unseen
    }

    /// Adds a point as it is.
    #[cfg(test)]
    pub(super) fn place(&mut self, point: [i16; 2]) {
        self.points.push(point).unwrap();
    }

    pub(super) fn raw(&self) -> &[[i16; 2]] {
        &self.points
    }
}

impl<const BEAMS: usize> Default for Scan<BEAMS> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use certainty_core::transducer::Missing;

    const fn mm(mm: u32) -> Millimeters {
        Millimeters::new(mm)
    }

    #[test]
    fn each_kind_of_reading_leaves_its_own_trace() {
        let mount = Pose::new(Point::from_mm(100, 0), BinaryAngle::QUARTER);
        let scanner = Scanner::try_new(mount, mm(8000)).unwrap();
        let mut scan = Scan::<4>::new();
        let ahead = BinaryAngle::ZERO;
        for reading in [
            Reading::Echo(mm(500)),
            Reading::NoObject,
            Reading::Echo(mm(9000)),
            Reading::TooNear,
            Reading::Missing(Missing::Timeout),
        ] {
            scan.add(&scanner, ahead, reading).unwrap();
        }
        let points: Vec<_> = scan.points().collect();
        let at = |y| Point::from_mm(100, y);
        assert_eq!(points, [at(500), at(8000), at(8000)]);
        assert_eq!(scan.unseen(), 2);
        // The bearing counts from the scanner's heading, and +90° of that is −x.
        scan.add(&scanner, BinaryAngle::QUARTER, Reading::Echo(mm(500)))
            .unwrap();
        assert_eq!(scan.points().last(), Some(Point::from_mm(-400, 0)));
    }

    #[test]
    fn a_beam_too_many_is_refused_and_changes_nothing() {
        let scanner = Scanner::try_new(Pose::default(), mm(8000)).unwrap();
        let mut scan = Scan::<1>::new();
        let beam = |scan: &mut Scan<1>| scan.add(&scanner, BinaryAngle::ZERO, Reading::NoObject);
        assert_eq!(beam(&mut scan), Ok(()));
        assert_eq!(beam(&mut scan), Err(TooManyBeams { room: 1 }));
        assert_eq!(scan.points().len(), 1);
        scan.clear();
        assert_eq!(beam(&mut scan), Ok(()));
    }

    #[test]
    fn a_scanner_whose_points_do_not_fit_is_refused() {
        let at = |x, y| Pose::new(Point::from_mm(x, y), BinaryAngle::ZERO);
        assert!(Scanner::try_new(at(2000, -2000), mm(30_000)).is_ok());
        for mount in [at(2001, 0), at(0, -2001), at(i32::MIN, 0)] {
            assert_eq!(Scanner::try_new(mount, mm(1)), Err(ScannerError::Mount));
        }
        for farthest in [0, 30_001, u32::MAX] {
            let refused = Scanner::try_new(at(0, 0), mm(farthest));
            assert_eq!(refused, Err(ScannerError::Farthest));
        }
    }
}
