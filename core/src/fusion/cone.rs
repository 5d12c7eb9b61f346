//! Spatial interpretation of a beam with a width, as an ultrasonic ranger has.

use super::{Beam, BeamModel, Behind, Geometry, Listener};
use crate::certainty::Certainty;
use crate::narrow::saturating_i8;
use crate::units::{BinaryAngle, Direction, Millimeters, Point};
use core::num::Wrapping;

/// Tells `listener` what the reading says about each cell of the cone.
///
/// What it is told fades with the square of its angle from the axis, from all at the axis to *uncertain*
/// at the edge: the shape that Elfes gave sonar. The arc of an echo reaches every cell that is at most
/// half outside; freed are only cells whose centre is inside, and those that the axis itself crosses,
/// for near the apex the cone is narrower than a cell. *Free* has a narrower edge than *occupied*
/// besides, so that neighbouring cones do not erase each other's obstacles.
pub(super) fn interpret(
    beam: &Beam,
    echo: Option<Millimeters>,
    geometry: &Geometry,
    model: &BeamModel,
    listener: &mut impl Listener,
) {
    let mut tell = |cell, certainty| listener.hear(certainty, core::iter::once(cell));
    let config = &model.config;
    let cone = Cone::new(beam, geometry, config.half_width, Belongs::ByItsHalf);
    let clear = Cone::new(beam, geometry, config.half_clear, Belongs::ByItsCenter);
    let half_cell = i64::from(geometry.cell_size().get()) / 2;

    // The arc of the echo: between `near` and `far`.
    let (near, far, reach) = match echo {
        None => (i64::from(config.farthest.get()), i64::MAX, config.farthest),
        Some(distance) => {
            let half_arc = half_cell.max(model.spread(distance).get().into());
            let at = i64::from(distance.get());
            let far = at.saturating_add(half_arc);
            let arc_end = Millimeters::new(u32::try_from(far).unwrap_or(u32::MAX));
            let reach = match config.behind {
                Behind::Untouched => arc_end,
                Behind::Uncertain => arc_end.max(config.farthest),
            };
            (at.saturating_sub(half_arc), far, reach)
        }
    };

    let Some((columns, rows)) = cone.bounds(beam, geometry, reach) else {
        return;
    };
    let reach = i64::from(reach.get());
    let hit = echo.and_then(|distance| {
        geometry.cell_at((beam.origin).ahead(beam.bearing.direction(), distance))
    });
    for row in rows {
        for column in columns.clone() {
            let cell = geometry.cell_inside(column, row);
            if Some(cell) == hit {
                // However narrow the cone, and however far the cell's centre is from its axis.
                tell(cell, config.occupied);
                continue;
            }
            let center = geometry.center(cell);
            let Some(place) = cone.place(center) else {
                continue;
            };
            if place.distance > reach {
                continue;
            }
            if place.distance > far {
                tell(cell, Certainty::UNCERTAIN);
                continue;
            }
            let told = if place.distance < near {
                clear
                    .place(center)
                    .map(|inner| faded(config.free, inner.off_axis))
            } else {
                echo.map(|_| faded(config.occupied, place.off_axis))
            };
            // At the edge the cone says nothing.
            if let Some(certainty) = told.filter(|&told| told != Certainty::UNCERTAIN) {
                tell(cell, certainty);
            }
        }
    }
}

/// `certainty`, weakened by the square of how far off the axis the cell is; rounds towards
/// *uncertain*.
fn faded(certainty: Certainty, off_axis: i64) -> Certainty {
    let off = off_axis.clamp(0, 256);
    let kept = 65_536_i64.saturating_sub(off.saturating_mul(off));
    let deviation = i64::from(certainty.deviation())
        .saturating_mul(kept)
        .checked_div(65_536);
    Certainty::from_deviation(saturating_i8(deviation.unwrap_or(0)))
}

/// A sector with its axis, in the map's frame.
struct Cone {
    origin: Point,
    axis: Direction,
    edge: Direction,
    half_width: BinaryAngle,
    half_cell: i64,
    belongs: Belongs,
}

/// When a cell belongs to a cone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Belongs {
    /// When half of it does.
    ByItsHalf,
    /// When its centre does, or the axis crosses it.
    ByItsCenter,
}

/// Where a cell's centre lies in a cone.
struct Place {
    /// From the apex, in millimetres.
    distance: i64,
    /// 0 on the axis, 256 at the edge or beyond.
    off_axis: i64,
}

impl Cone {
    fn new(beam: &Beam, geometry: &Geometry, half_width: BinaryAngle, belongs: Belongs) -> Self {
        Self {
            origin: beam.origin,
            axis: beam.bearing.direction(),
            edge: half_width.direction(),
            half_width,
            half_cell: i64::from(geometry.cell_size().get()) / 2,
            belongs,
        }
    }

    /// Where the cell with this `center` lies in the cone, or `None` if outside.
    fn place(&self, center: Point) -> Option<Place> {
        let part = |mm: i32, origin: i32| Wrapping(i64::from(mm).wrapping_sub(i64::from(origin)));
        let x = part(center.x_mm(), self.origin.x_mm());
        let y = part(center.y_mm(), self.origin.y_mm());
        let (cos, sin) = (
            Wrapping(i64::from(self.axis.cos())),
            Wrapping(i64::from(self.axis.sin())),
        );
        // At most 2^30 mm times 2^30, twice: 61 bits.
        const FRACTION: usize = Direction::FRACTION_BITS as usize;
        let along = (x * cos + y * sin) >> FRACTION;
        // The magnitude first: a mirrored cell is as far from the axis.
        let across = Wrapping((y * cos - x * sin).0.saturating_abs()) >> FRACTION;
        if along.0 < 0 {
            return None;
        }
        let off = match self.belongs {
            _ if across.0 <= self.half_cell => 0, // the axis crosses it
            Belongs::ByItsHalf => across.0.saturating_sub(self.half_cell),
            Belongs::ByItsCenter => across.0,
        };
        // tan(off axis) ≤ tan(half width), both sides times both cosines.
        let (edge_cos, edge_sin) = (
            Wrapping(i64::from(self.edge.cos())),
            Wrapping(i64::from(self.edge.sin())),
        );
        let (reached, limit) = (Wrapping(off) * edge_cos, along * edge_sin);
        if reached > limit {
            return None;
        }
        let unit = (limit.0 >> 8).max(1);
        let square = (along * along + across * across).0;
        Some(Place {
            distance: square.checked_isqrt().unwrap_or(0),
            off_axis: reached.0.checked_div(unit).unwrap_or(256).min(256),
        })
    }

    /// The columns and rows of the box around the cone, clipped to the grid; `None` if outside.
    fn bounds(
        &self,
        beam: &Beam,
        geometry: &Geometry,
        reach: Millimeters,
    ) -> Option<(core::ops::Range<u32>, core::ops::Range<u32>)> {
        // A sector's box is spanned by its apex, the ends of its edges, and where its arc meets the
        // axes of the map.
        let corners = [
            Some(beam.bearing.wrapping_add(self.half_width)),
            Some(beam.bearing.wrapping_sub(self.half_width)),
        ];
        let poles = [0_u16, 0x4000, 0x8000, 0xC000].map(|bits| {
            let pole = BinaryAngle::from_bits(bits);
            (pole.separation(beam.bearing) <= self.half_width).then_some(pole)
        });
        let (mut low, mut high) = (self.origin, self.origin);
        for direction in corners.into_iter().chain(poles).flatten() {
            let tip = self.origin.ahead(direction.direction(), reach);
            low = Point::from_mm(low.x_mm().min(tip.x_mm()), low.y_mm().min(tip.y_mm()));
            high = Point::from_mm(high.x_mm().max(tip.x_mm()), high.y_mm().max(tip.y_mm()));
        }
        let (first, last) = (geometry.address(low), geometry.address(high));
        // One cell more on each side for the half cell that a cone is widened by.
        let clipped = |first: i64, last: i64, cells: u16| {
            let first = first.saturating_sub(1).max(0);
            let end = last.saturating_add(2).min(cells.into());
            let (first, end) = (u32::try_from(first).ok()?, u32::try_from(end).ok()?);
            (first < end).then_some(first..end)
        };
        Some((
            clipped(first.0, last.0, geometry.columns())?,
            clipped(first.1, last.1, geometry.rows())?,
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::super::picture::draw_beam;
    use super::super::{
        BayesGrid, BeamConfig, Cell, CertaintyGrid, Latest, Mapper, MedianGrid, Middle, RobustGrid,
        RobustRules, Strength,
    };
    use super::*;
    use crate::health::{Health, HealthRules};
    use crate::sensor::SensorId;
    use crate::transducer::Reading;
    use crate::units::Ticks;

    const fn mm(mm: u32) -> Millimeters {
        Millimeters::new(mm)
    }

    fn yard() -> Geometry {
        Geometry::try_new(21, 12, mm(100), Point::from_mm(-1050, 0)).unwrap()
    }

    fn sonar() -> BeamModel {
        let half_width = BinaryAngle::from_millidegrees(15_000);
        BeamModel::try_new(BeamConfig::cone(mm(1100), half_width)).unwrap()
    }

    fn up(degrees: i32, reading: Reading) -> Beam {
        Beam {
            origin: Point::ORIGIN,
            bearing: BinaryAngle::from_millidegrees(90_000 - degrees * 1000),
            reading,
        }
    }

    #[test]
    fn a_cone_frees_its_middle_and_marks_an_arc() {
        // The arc holds what lies 950 to 1050 mm away: (0, 1050), and of the row at 950 what is at most
        // 300 to the side, whose near half is 0.98 of the way to the edge. The clear part, 7.5° wide,
        // reaches the centres beside the axis, 100 to the side, from 760 mm on.
        let drawn = draw_beam(&yard(), &up(0, Reading::Echo(mm(1000))), &sonar());
        let mut expected = vec!["          .          "; 12];
        expected[..4].copy_from_slice(&[
            "                     ",
            "          #          ",
            "       ++###++       ",
            "         ,.,         ",
        ]);
        assert_eq!(drawn, expected);
    }

    #[test]
    fn a_cone_and_its_mirror_image_tell_mirrored_cells() {
        // Cells of an odd size have a middle millimetre; x mirrors to −1 − x.
        let corner = Point::from_mm(-51 * 8, -51 * 8);
        let geometry = Geometry::try_new(16, 16, mm(51), corner).unwrap();
        for bearing in (0..=u16::MAX).step_by(97) {
            let beam = Beam {
                origin: Point::from_mm(20, -33),
                bearing: BinaryAngle::from_bits(bearing),
                reading: Reading::Echo(mm(300)),
            };
            let mirrored = Beam {
                origin: Point::from_mm(-1 - 20, -33),
                bearing: BinaryAngle::HALF.wrapping_sub(beam.bearing),
                ..beam
            };
            let drawn = draw_beam(&geometry, &mirrored, &sonar());
            let flipped: Vec<String> = drawn
                .iter()
                .map(|row| row.chars().rev().collect())
                .collect();
            assert_eq!(
                draw_beam(&geometry, &beam, &sonar()),
                flipped,
                "bearing {bearing}"
            );
        }
    }

    /// PEERS: neighbouring cones erased each other's obstacles (navigation layers).
    #[test]
    fn neighbouring_cones_do_not_erase_each_others_obstacles() {
        // Two sonars 15° apart on one ring; the first sees a post at 700 mm on its axis, which is at
        // the edge of the second's cone, and the second, a hundred times, nothing. Wherever the
        // borders of the cells lie.
        for shift in (0..100).step_by(7) {
            let corner = Point::from_mm(-1050 + shift, shift - 100);
            let yard = Geometry::try_new(21, 12, mm(100), corner).unwrap();
            let seen = up(-7, Reading::Echo(mm(700)));
            let unseen = up(8, Reading::NoObject);
            let post = yard.cell_at(seen.origin.ahead(seen.bearing.direction(), mm(700)));
            let post = post.unwrap();
            let bayes = BayesGrid::try_new(yard, Strength::MEASUREMENT, [0; 252]).unwrap();
            let robust = RobustGrid::try_new(yard, RobustRules::DEFAULT, 2, [0; 252], [0; 63]);
            let median =
                MedianGrid::<_, _, 2>::try_new(yard, 2, Middle::Higher, Latest, [0; 504]).unwrap();
            let outcomes = [
                erased(bayes, &seen, &unseen, post),
                erased(robust.unwrap(), &seen, &unseen, post),
                erased(median, &seen, &unseen, post),
            ];
            for (grid, certainty) in ["bayes", "robust", "median"].iter().zip(outcomes) {
                assert!(
                    certainty.to_bits() > 200,
                    "{grid}, shift {shift}: {certainty}"
                );
            }
        }
    }

    fn erased(grid: impl CertaintyGrid, seen: &Beam, unseen: &Beam, post: Cell) -> Certainty {
        let mut mapper = Mapper::new(grid, [Health::default(); 2], HealthRules::DEFAULT);
        let [first, second] = [1, 2].map(|number| SensorId::try_new(number).unwrap());
        let now = Ticks::new(0);
        mapper.integrate(first, seen, &sonar(), now).unwrap();
        for _ in 0..100 {
            mapper.integrate(second, unseen, &sonar(), now).unwrap();
        }
        mapper.environment().certainty(post)
    }

    /// PEERS: a cone that left the grid on the negative side wrapped into a huge loop (nav2).
    #[test]
    fn a_cone_leaving_on_the_negative_side_ends_there() {
        let outside = Beam {
            origin: Point::from_mm(-5000, -5000),
            ..up(180, Reading::Echo(mm(1000)))
        };
        let drawn = draw_beam(&yard(), &outside, &sonar());
        assert!(drawn.iter().all(|row| row.trim().is_empty()));
        let edge = draw_beam(&yard(), &up(-90, Reading::NoObject), &sonar());
        assert!(edge.concat().contains('.'));
    }
}
