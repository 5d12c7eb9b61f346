//! The scene in front of the Smart Car, and an office.

use super::World;

/// The world file of the built-in scene: also a sample of how one is written.
///
/// In the manner of \[001\] Fig. 5(a), whose layout the paper does not give in numbers.
pub const SMART_CAR: &str = include_str!("../../data/smart-car.toml");

/// The world file of the office in which `certainty ring` checks a sonar ring.
///
/// In the manner of the room in the figures of \[003\], which gives no plan of it.
pub const OFFICE: &str = include_str!("../../data/office.toml");

impl World {
    /// Returns a furnished office of 6 m by 5 m with its lower left corner at the origin: [`OFFICE`].
    ///
    /// # Panics
    ///
    /// Never: a test proves that the file, which is part of the program, is a world.
    #[must_use]
    pub fn office() -> Self {
        Self::parse(OFFICE.as_bytes(), "office.toml").expect("the built-in office is valid")
    }

    /// Returns the scene in front of the Smart Car: [`SMART_CAR`].
    ///
    /// Units and range: obstacles in x −850..=850 mm and y 0..=1100 mm, the certainty grid of
    /// \[001\] §6.1; none within 150 mm of the sensors at the origin. Of the directions from
    /// −90° to 90° about half meet no obstacle within a GP2D02's 800 mm.
    ///
    /// # Panics
    ///
    /// Never: a test proves that the file, which is part of the program, is a world.
    #[must_use]
    pub fn built_in() -> Self {
        Self::parse(SMART_CAR.as_bytes(), "smart-car.toml").expect("the built-in world is valid")
    }
}
