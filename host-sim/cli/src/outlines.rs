//! What stands in a world or in a map, as a track chart draws it: in metres.

use certainty_core::certainty::Certainty;
use certainty_core::fusion::Geometry;
use certainty_core::units::Point;
use certainty_sim::world::World;

/// A place.
pub(super) fn at(point: Point) -> (f64, f64) {
    metres((f64::from(point.x_mm()), f64::from(point.y_mm())))
}

fn metres((x, y): (f64, f64)) -> (f64, f64) {
    (x / 1000.0, y / 1000.0)
}

/// The obstacles' outlines.
pub(super) fn of_world(world: &World) -> Vec<Vec<(f64, f64)>> {
    let outlines = world.obstacles().iter().map(|obstacle| {
        let outline = obstacle.outline();
        outline.into_iter().map(metres).collect()
    });
    outlines.collect()
}

/// The outlines of the cells that are surer than half way from *uncertain* to *occupied*.
pub(super) fn of_map(geometry: &Geometry, cells: &[Certainty]) -> Vec<Vec<(f64, f64)>> {
    let half = f64::from(geometry.cell_size().get()) / 2000.0;
    let corners = [(-half, -half), (half, -half), (half, half), (-half, half)];
    let known = geometry.iter().zip(cells);
    let occupied = known.filter(|&(_, &certainty)| certainty > Certainty::from_bits(192));
    let outlines = occupied.map(|(cell, _)| {
        let (x, y) = at(geometry.center(cell));
        corners.map(|(dx, dy)| (x + dx, y + dy)).to_vec()
    });
    outlines.collect()
}
