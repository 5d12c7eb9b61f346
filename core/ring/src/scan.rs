//! The beams of laser scanners around the robot, as one list of points (\[003\] §3).

use certainty_core::transducer::Reading;
use certainty_core::units::{BinaryAngle, Millimeters, Point, Pose};
use core::fmt;

/// A laser scanner: where it is mounted on the robot, and its range.
///
/// Possession proves that every point it reports is less than 32 768 mm from the robot's centre along x
/// and y, so that a point takes four bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Scanner {
    mount: Pose,
    range: Millimeters,
}

/// The part of a scanner that is out of range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ScannerError {
    /// It is mounted farther than two metres from the robot's centre, along x or y.
    Mount,
    /// Its range is zero, or above 30 m.
    Range,
}

impl ScannerError {
    const fn message(self) -> &'static str {
        match self {
            Self::Mount => "a scanner must be mounted within 2m of the robot's centre",
            Self::Range => "a scanner's range must be from 1mm to 30m",
        }
    }
}

impl fmt::Display for ScannerError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.message())
    }
}

impl core::error::Error for ScannerError {}

impl Scanner {
    const MOST_OFFSET: u32 = 2000;
    const MOST_RANGE: u32 = 30_000;

    /// Creates a scanner at `mount` in the robot's frame, for constants.
    ///
    /// # Panics
    ///
    /// For a mount or a range that [`Self::try_new`] refuses: a constant then does not build. Use that at run
    /// time.
    #[expect(clippy::panic, reason = "refuses a constant at compile time")]
    #[must_use]
    pub const fn new(mount: Pose, range: Millimeters) -> Self {
        match Self::try_new(mount, range) {
            Ok(scanner) => scanner,
            Err(error) => panic!("{}", error.message()),
        }
    }

    /// Creates a scanner at `mount` in the robot's frame.
    ///
    /// # Errors
    ///
    /// [`ScannerError`] names the part that is out of range.
    pub const fn try_new(mount: Pose, range: Millimeters) -> Result<Self, ScannerError> {
        let (x, y) = (
            mount.at.x_mm().unsigned_abs(),
            mount.at.y_mm().unsigned_abs(),
        );
        if x > Self::MOST_OFFSET || y > Self::MOST_OFFSET {
            Err(ScannerError::Mount)
        } else if range.get() == 0 || range.get() > Self::MOST_RANGE {
            Err(ScannerError::Range)
        } else {
            Ok(Self { mount, range })
        }
    }

    /// Returns where it is mounted, in the robot's frame.
    #[must_use]
    pub const fn mount(&self) -> Pose {
        self.mount
    }

    /// Returns its range.
    #[must_use]
    pub const fn range(&self) -> Millimeters {
        self.range
    }

    /// The end of the beam in direction `bearing`, relative to the scanner's heading.
    const fn end(&self, bearing: BinaryAngle, reading: Reading) -> Option<Point> {
        let range = match reading {
            Reading::Echo(range) if range.get() < self.range.get() => range,
            // Free up to the scanner's range, which is beyond the range of the sonars.
            Reading::Echo(_) | Reading::NoObject => self.range,
            Reading::TooNear | Reading::Missing(_) => return None,
        };
        let direction = self.mount.heading.wrapping_add(bearing).direction();
        Some(self.mount.at.ahead(direction, range))
    }
}

/// The end points of the beams of a scan around the robot, in the order of their directions.
///
/// `BEAMS` is its capacity, from 1 to 16384; two scanners of 361 beams each fill `Scan<722>` (\[003\] §3).
/// The scan is one list, counter-clockwise:
/// first the beams of the one scanner, then those of the other.
///
/// Memory: 4 bytes per beam and 12.
#[derive(Debug, Clone)]
pub struct Scan<const BEAMS: usize> {
    points: heapless::Vec<[i16; 2], BEAMS>,
    unseen: u32,
}

/// A scan is full; the beam was not added.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TooManyBeams {
    /// The scan's capacity.
    pub capacity: usize,
}

impl fmt::Display for TooManyBeams {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "the scan has more beams than its capacity of {}",
            self.capacity
        )
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
    /// *No object* adds a point at the scanner's range, which is beyond that of a sonar. A beam that is
    /// *too near* or *missing* adds no point and is counted as [`unseen`](Scan::unseen).
    ///
    /// # Errors
    ///
    /// [`TooManyBeams`] if the scan is full; it is then unchanged.
    pub fn add(
        &mut self,
        scanner: &Scanner,
        bearing: BinaryAngle,
        reading: Reading,
    ) -> Result<(), TooManyBeams> {
        match scanner.end(bearing, reading) {
            Some(end) => {
                // Both fit: that is what a `Scanner` proves.
                let point = [end.x_mm(), end.y_mm()].map(|mm| i16::try_from(mm).unwrap_or(0));
                let added = self.points.push(point);
                added.map_err(|_| TooManyBeams { capacity: BEAMS })
            }
            None => {
                self.unseen = self.unseen.saturating_add(1);
                Ok(())
            }
        }
    }

    /// Removes all beams.
    pub fn clear(&mut self) {
        self.points.clear();
        self.unseen = 0;
    }

    /// Returns the points in the robot's frame, in the order in which they were added.
    #[must_use]
    pub fn points(&self) -> impl ExactSizeIterator<Item = Point> + '_ {
        let points = self.points.iter();
        points.map(|&[x, y]| Point::from_mm(x.into(), y.into()))
    }

    /// Returns the number of beams that added no point.
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
    fn each_kind_of_reading_adds_its_point_or_none() {
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
    fn a_full_scan_refuses_a_beam_and_is_unchanged() {
        let scanner = Scanner::try_new(Pose::default(), mm(8000)).unwrap();
        let mut scan = Scan::<1>::new();
        let beam = |scan: &mut Scan<1>| scan.add(&scanner, BinaryAngle::ZERO, Reading::NoObject);
        assert_eq!(beam(&mut scan), Ok(()));
        assert_eq!(beam(&mut scan), Err(TooManyBeams { capacity: 1 }));
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
        for range in [0, 30_001, u32::MAX] {
            let refused = Scanner::try_new(at(0, 0), mm(range));
            assert_eq!(refused, Err(ScannerError::Range));
        }
    }
}
